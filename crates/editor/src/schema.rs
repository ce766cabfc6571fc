//! The fields as a JSON schema (draft 2020-12), for programs that write specs or check them.
//!
//! It is of a spec as serde writes it in JSON: a group and a map are objects, a tuple is an array, and
//! `Name(...)` is an object with the one field `Name`.

use crate::descriptions::plain;
use phisindy_phys::fields::{Absent, Form, Group};
use serde_json::{Map, Value, json};

/// The schema of what has these fields.
///
/// ```
/// let schema = phisindy_editor::schema(&phisindy_phys::fields::SPEC, "spec");
/// let fields = &schema["$defs"]["the-spec"]["properties"];
/// assert_eq!(fields["states"]["additionalProperties"]["type"], "string");
/// assert!(fields["known"]["description"].as_str().expect("a text").starts_with("the rate of each state"));
/// ```
pub fn schema(root: &'static Group, name: &str) -> Value {
    let mut defined = Defined { groups: vec![], schemas: Map::new() };
    let whole = defined.reference(root, "");
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": format!("phisindy {name}"),
        "description": format!("A {name} as JSON: a tuple is an array, Name(...) an object with the field Name."),
        "$ref": whole["$ref"],
        "$defs": defined.schemas,
    })
}

/// What has these fields and no other.
fn object(properties: &Value, required: &Value) -> Value {
    json!({ "type": "object", "properties": properties, "required": required, "additionalProperties": false })
}

/// The schemas of groups so far, each by its name.
struct Defined {
    groups: Vec<(&'static Group, String)>,
    schemas: Map<String, Value>,
}

impl Defined {
    /// A reference to the schema of a group, which is made if it is not there yet.
    fn reference(&mut self, group: &'static Group, inside: &str) -> Value {
        let known =
            self.groups.iter().find(|(other, _)| std::ptr::eq(*other, group)).map(|(_, name)| name.clone());
        let name = known.unwrap_or_else(|| {
            let title = group.owner.replace('`', "").replace(' ', "-");
            // A stream of a text has no sheet.
            let taken = self.groups.iter().any(|(_, name)| *name == title);
            let name = if taken { format!("{title}-of-{inside}") } else { title };
            self.groups.push((group, name.clone()));
            let schema = self.group(group, &name);
            self.schemas.insert(name.clone(), schema);
            name
        });
        json!({ "$ref": format!("#/$defs/{name}") })
    }

    fn group(&mut self, group: &'static Group, name: &str) -> Value {
        let (mut properties, mut required, mut either) = (Map::new(), vec![], vec![]);
        for field in group.fields {
            let mut schema = self.form(field.form(), name);
            let absent = match field.3 {
                Absent::Is(what) if !what.is_empty() => format!(" (if absent: {what})"),
                _ => String::new(),
            };
            schema["description"] = plain(&format!("{}{absent}", field.about())).into();
            properties.insert(field.0.to_owned(), schema);
            match field.3 {
                Absent::Needed => required.push(field.0),
                Absent::Without(other) => {
                    either.push(json!({ "anyOf": [{ "required": [field.0] }, { "required": [other] }] }))
                }
                Absent::Is(_) => {}
            }
        }
        let mut schema = object(&properties.into(), &json!(required));
        if !either.is_empty() {
            schema["allOf"] = either.into();
        }
        schema
    }

    fn form(&mut self, form: &'static Form, inside: &str) -> Value {
        let variant = |name: &str, content: Value| object(&json!({ name: content }), &json!([name]));
        match form {
            Form::Number => json!({ "type": "number" }),
            Form::Whole => json!({ "type": "integer", "minimum": 0 }),
            Form::Truth => json!({ "type": "boolean" }),
            Form::Character => json!({ "type": "string", "minLength": 1, "maxLength": 1 }),
            Form::Word(word) | Form::Quoted(word) => json!({ "const": word }),
            Form::Group(group) => match group.variant {
                Some(name) => {
                    let content = self.reference(group, inside);
                    variant(name, content)
                }
                None => self.reference(group, inside),
            },
            Form::Tuple(parts) => self.tuple(parts, inside),
            Form::Call(name, [part]) => {
                let content = self.form(part, inside);
                variant(name, content)
            }
            Form::Call(name, parts) => {
                let content = self.tuple(parts, inside);
                variant(name, content)
            }
            Form::List(item) => json!({ "type": "array", "items": self.form(item, inside) }),
            Form::Map(_, value) => {
                json!({ "type": "object", "additionalProperties": self.form(value, inside) })
            }
            Form::Mixed(group, _, value) => {
                let mut schema = self.group(group, inside);
                schema["additionalProperties"] = self.form(value, inside);
                schema["required"] = json!([]);
                schema
            }
            Form::One(forms) => {
                json!({ "anyOf": forms.iter().map(|form| self.form(form, inside)).collect::<Vec<_>>() })
            }
            Form::Prose
            | Form::Expression
            | Form::Unit
            | Form::File
            | Form::Header
            | Form::LawId
            | Form::Free
            | Form::Declares(_)
            | Form::Name(_) => json!({ "type": "string" }),
        }
    }

    fn tuple(&mut self, parts: &'static [Form], inside: &str) -> Value {
        let items: Vec<Value> = parts.iter().map(|form| self.form(form, inside)).collect();
        json!({ "type": "array", "prefixItems": items, "items": false, "minItems": parts.len() })
    }
}
