//! What an editor says of fields, names, functions and units.

use crate::document::Document;
use phisindy_expr::ops::{BINARY, UNARY, function_names};
use phisindy_phys::fields::{Absent, Field, Form, Group};
use phisindy_phys::unit::{Dimension, Unit};
use std::collections::HashMap;

/// What is known of a text beside itself.
#[derive(Clone, Debug, Default)]
pub struct Known {
    /// What its names measured when it was last without a mistake.
    pub measures: HashMap<String, Dimension>,
    /// The laws that it may name: id, and what each is.
    pub laws: Vec<(String, String)>,
}

/// Markdown without links: those of the reference lead nowhere from an editor.
pub(crate) fn plain(about: &str) -> String {
    let mut parts = about.split("](");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        // `[what](where)`: the last bracket that is open begins what is shown.
        match (text.rfind('['), part.split_once(')')) {
            (Some(open), Some((_, rest))) => {
                text.remove(open);
                text += rest;
            }
            _ => text = format!("{text}]({part}"),
        }
    }
    text
}

/// What a field is.
pub(crate) fn field(group: &Group, field: &Field) -> String {
    let absent = match field.3 {
        Absent::Needed => "\n\nNeeded.".to_owned(),
        Absent::Without(other) => format!("\n\nNeeded, unless there is `{other}`."),
        Absent::Is("") => String::new(),
        Absent::Is(what) => format!("\n\nIf absent: {what}."),
    };
    format!("**{}** of {}: {}{absent}", field.0, group.owner, plain(field.about()))
}

/// What a form looks like, in a word or two.
pub(crate) fn shape(form: &Form) -> &'static str {
    match form {
        Form::Number => "number",
        Form::Whole => "whole number",
        Form::Truth => "true or false",
        Form::Character => "character",
        Form::Expression => "expression",
        Form::Unit => "unit",
        Form::Word(_) | Form::Quoted(_) => "word",
        Form::Group(_) => "group (...)",
        Form::Tuple(_) => "tuple (...)",
        Form::Call(name, _) => name,
        Form::List(_) => "list [...]",
        Form::Map(..) | Form::Mixed(..) => "map {...}",
        Form::One(forms) => forms.first().map_or("", shape),
        Form::LawId => "law",
        Form::Declares(_) | Form::Name(_) => "name",
        Form::Prose | Form::File | Form::Header | Form::Free => "text",
    }
}

/// What a name of an expression is, and its unit.
pub(crate) fn name(document: &Document<'_>, known: &Known, name: &str) -> Option<String> {
    match name {
        "t" => return Some("**t**: time, s".to_owned()),
        "pi" => return Some("**pi**: 3.14159..., a plain number".to_owned()),
        _ => {}
    }
    let declared = document.declared().into_iter().find(|declared| declared.name == name);
    let Some(declared) = declared else { return function(name) };
    let measured = known.measures.get(name).map(ToString::to_string);
    let unit = match (declared.unit.filter(|unit| !unit.trim().is_empty()), measured) {
        (Some(written), Some(si)) if written != si => format!(", {written} ({si} in SI)"),
        (Some(unit), _) => format!(", {unit}"),
        (None, Some(si)) => format!(", {si} (that follows from the equations)"),
        (None, None) => String::new(),
    };
    Some(format!("**{name}**: {}{unit}", declared.kind.word()))
}

/// What a function does.
pub(crate) fn function(name: &str) -> Option<String> {
    function_names().find(|known| *known == name)?;
    let one = UNARY.iter().find(|row| row.name == name).map(|row| ("x", row.about));
    let two = BINARY.iter().find(|row| row.name == name).map(|row| ("a, b", row.about));
    one.or(two).map(|(arguments, about)| format!("**{name}({arguments})**: {about}"))
}

/// A unit in SI.
pub(crate) fn unit(text: &str) -> Option<String> {
    let unit = Unit::parse(text).ok()?;
    let written = if text.trim().is_empty() { "no unit" } else { text.trim() };
    Some(format!(
        "**{written}**: {} {}",
        unit.factor,
        if unit.dimension.is_none() { "(a plain number)".to_owned() } else { unit.dimension.to_string() }
    ))
}

#[cfg(test)]
mod tests {
    #[test]
    fn links_are_their_words() {
        let about = "[a hint](#screen); a list `[1, 2]`, [`Csv(...)`](#csv) or [x](y)";
        assert_eq!(super::plain(about), "a hint; a list `[1, 2]`, `Csv(...)` or x");
    }
}
