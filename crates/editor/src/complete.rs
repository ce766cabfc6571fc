//! What could stand at a place.

use crate::descriptions::{self, Known};
use crate::document::{Document, Place};
use crate::hover::identifier;
use lsp_types::CompletionItemKind as Of;
use phisindy_expr::Span;
use phisindy_expr::ops::function_names;
use phisindy_phys::fields::{Form, Kind};
use phisindy_phys::unit::names;

/// Something that could stand at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Completion {
    /// How it is shown.
    pub label: String,
    /// What stands there then.
    pub insert: String,
    /// What it is, in a word or two.
    pub detail: String,
    /// What it is, in Markdown.
    pub about: Option<String>,
    /// Its picture.
    pub of: Of,
}

/// What could stand at a byte, and what it would take the place of.
///
/// ```
/// use phisindy_editor::{Document, Known, complete};
/// let text = "(states: { \"v\": \"m/s\" }, known: { \"v\": \"-sgn(\" }, cont";
/// let document = Document::new(text, std::path::Path::new("rig.ron"));
/// let all = |at: usize| complete(&document, &Known::default(), at).0.into_iter();
/// let labels = |at: usize| all(at).map(|c| c.label).collect::<Vec<_>>();
/// assert!(labels(text.find("\" }, cont").unwrap()).starts_with(&["v".to_owned(), "t".to_owned()]));
/// let fields = labels(text.len());
/// assert!(fields.contains(&"contacts".to_owned()) && !fields.contains(&"states".to_owned()));
/// ```
pub fn complete(document: &Document<'_>, known: &Known, at: usize) -> (Vec<Completion>, Span) {
    if document.in_comment(at) {
        return (vec![], Span::new(at, at));
    }
    let Place { wants, around, mut word, quoted } = document.place(at);
    let item = |label: &str, insert: String, detail: &str, about, of| Completion {
        label: label.to_owned(),
        insert,
        detail: detail.to_owned(),
        about,
        of,
    };
    let written = |text: &str| if quoted { text.to_owned() } else { format!("\"{text}\"") };
    let mut all = Vec::new();
    if !quoted {
        let keys = around.entries.iter().filter_map(|e| e.key.as_ref()).filter(|key| key.span != word);
        let there: Vec<&str> = keys.map(|key| &document.text[key.span.range()]).collect();
        let colon = document.text[word.end..].trim_start().starts_with(':');
        for group in &wants.groups {
            for field in group.fields.iter().filter(|field| !there.contains(&field.0)) {
                let insert = if colon { field.0.to_owned() } else { format!("{}: ", field.0) };
                let about = Some(descriptions::field(group, field));
                all.push(item(field.0, insert, descriptions::shape(field.form()), about, Of::FIELD));
            }
        }
    }
    let declared = document.declared();
    let names_of = |is: &dyn Fn(Kind) -> bool| {
        let those = declared.iter().filter(|declared| is(declared.kind));
        let mut names: Vec<Completion> = Vec::new();
        for d in those {
            let about = descriptions::name(document, known, d.name);
            let unit = d.unit.map_or(String::new(), |unit| format!(", {unit}"));
            names.push(item(
                d.name,
                written(d.name),
                &format!("{}{unit}", d.kind.word()),
                about,
                Of::VARIABLE,
            ));
        }
        names.dedup_by(|a, b| a.label == b.label);
        names
    };
    for form in &wants.forms {
        match form {
            Form::Expression if quoted => {
                word = identifier(document.text, word, at);
                all.extend(names_of(&|kind| kind != Kind::Place));
                all.push(item("t", "t".to_owned(), "time, s", None, Of::CONSTANT));
                all.push(item("pi", "pi".to_owned(), "3.14159...", None, Of::CONSTANT));
                all.extend(function_names().map(|name| {
                    item(name, format!("{name}("), "function", descriptions::function(name), Of::FUNCTION)
                }));
            }
            Form::Unit if quoted => {
                word = identifier(document.text, word, at);
                all.extend(
                    names()
                        .map(|name| item(name, name.to_owned(), "unit", descriptions::unit(name), Of::UNIT)),
                );
            }
            Form::Name(kinds) => {
                let is = |kind| kinds.contains(&kind) || kind == Kind::Speed && kinds.contains(&Kind::State);
                all.extend(names_of(&is));
            }
            Form::LawId => all.extend(
                known
                    .laws
                    .iter()
                    .map(|(id, about)| item(id, written(id), "law", Some(about.clone()), Of::REFERENCE)),
            ),
            Form::Quoted(text) => all.push(item(text, written(text), "word", None, Of::ENUM_MEMBER)),
            Form::Word(text) if !quoted => {
                all.push(item(text, (*text).to_owned(), "word", None, Of::ENUM_MEMBER))
            }
            Form::Truth if !quoted => all.extend(
                ["true", "false"].map(|text| item(text, text.to_owned(), "word", None, Of::ENUM_MEMBER)),
            ),
            Form::Call(name, _) if !quoted => {
                all.push(item(name, format!("{name}("), "(...)", None, Of::CONSTRUCTOR));
            }
            Form::Group(group) if !quoted => all.extend(
                group.variant.map(|name| item(name, format!("{name}("), "(...)", None, Of::CONSTRUCTOR)),
            ),
            _ => {}
        }
    }
    (all, word)
}
