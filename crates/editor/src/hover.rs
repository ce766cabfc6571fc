//! What stands at a place, in words: what a field is, the unit of a name, what a function does, what a unit is
//! in SI.

use crate::descriptions::{self, Known};
use crate::document::{Document, Place};
use phisindy_expr::Span;
use phisindy_phys::fields::Form;

/// Words about what stands at a byte, in Markdown, and what they are about.
///
/// ```
/// use phisindy_editor::{Document, Known, hover};
/// let text = "(states: { \"v\": \"km/h\" }, known: { \"v\": \"-sgn(v)\" })";
/// let document = Document::new(text, std::path::Path::new("rig.ron"));
/// let said = |word: &str| hover(&document, &Known::default(), text.find(word).unwrap()).expect("words").0;
/// assert_eq!(said("v)"), "**v**: state, km/h");
/// assert_eq!(said("sgn"), "**sgn(x)**: -1, 0 or 1 with the sign of x");
/// assert!(said("km/h").starts_with("**km/h**: 0.2777"));
/// assert!(said("known").starts_with("**known** of the spec: the rate of each state"));
/// ```
pub fn hover(document: &Document<'_>, known: &Known, at: usize) -> Option<(String, Span)> {
    if document.in_comment(at) {
        return None;
    }
    let Place { wants, word, quoted, .. } = document.place(at);
    let text = &document.text[word.range()];
    let field = wants.groups.iter().find_map(|group| Some((*group, group.field(text)?)));
    if let Some((group, field)) = field {
        return Some((descriptions::field(group, field), word));
    }
    let said = |form: &Form| match form {
        Form::Unit if quoted => descriptions::unit(text).map(|said| (said, word)),
        Form::Expression if quoted => {
            let name = identifier(document.text, word, at);
            descriptions::name(document, known, &document.text[name.range()]).map(|said| (said, name))
        }
        Form::Declares(_) | Form::Name(_) => {
            descriptions::name(document, known, text).map(|said| (said, word))
        }
        Form::LawId => {
            let law = known.laws.iter().find(|(id, _)| id == text);
            law.map(|(id, about)| (format!("**{id}**: {about}"), word))
        }
        Form::Group(group) if group.variant == Some(text) => {
            Some((format!("**{text}(...)** has the fields {}", group.names().join(", ")), word))
        }
        _ => None,
    };
    wants.forms.iter().find_map(|form| said(form))
}

/// The name around a place of a text.
pub(crate) fn identifier(text: &str, within: Span, at: usize) -> Span {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let (before, after) = (&text[within.start..at], &text[at..within.end]);
    let start = before
        .rfind(|c| !part(c))
        .map_or(within.start, |k| within.start + k + before[k..].chars().next().map_or(0, char::len_utf8));
    Span::new(start, at + after.find(|c| !part(c)).unwrap_or(after.len()))
}
