//! A field or key that is not there yet.

use super::error::SetError;
use crate::text::raw::{Node, Shape};

/// Fields that are maps: what is created in them has a key in quotes.
const MAPS: &[&str] = &[
    "constants",
    "states",
    "inputs",
    "outputs",
    "let",
    "known",
    "inertia",
    "impacts",
    "unknown",
    "truth",
    "start",
    "columns",
    "derive",
    "sensors",
    "rows",
    "interpolate",
    "detrend",
    "streams",
    "places",
    "enters",
    "coordinates",
    "forces",
];
/// Fields that are lists: there is nothing to create in them by index.
const LISTS: &[&str] = &["contacts", "data", "candidates", "laws", "search", "measure", "epochs", "rates"];
/// Maps whose values are plain, so that no path goes deeper.
const PLAIN: &[&str] =
    &["states", "known", "inertia", "truth", "start", "rows", "interpolate", "derive", "let", "detrend"];

/// The text with the first of `parts` added to `node`, which is the value of `field`; further parts are
/// created inside it.
pub(super) fn insert(
    text: &str,
    node: &Node,
    field: &str,
    parts: &[String],
    value: &str,
) -> Result<String, SetError> {
    let entry = entry(node.shape == Shape::Map, field, parts, value)?;
    Ok(put(text, node, &entry))
}

/// The text with an entry behind those of `node`.
pub(super) fn put(text: &str, node: &Node, entry: &str) -> String {
    let Some(last) = node.entries.last() else {
        // Brackets without entries may still hold a comment, which stays behind the new entry.
        let space = if node.shape == Shape::Map { " " } else { "" };
        let (head, tail) = text.split_at(node.inside);
        return format!("{head}{space}{entry}{space}{tail}");
    };
    let (end, close) = (last.value.span.end, node.span.end - 1);
    let comma = comma_after(text, end, close);
    let first = last.key.as_ref().map_or(last.value.span.start, |key| key.span.start);
    let own_line = text[..first].rfind('\n').map(|at| &text[at + 1..first]).filter(|s| s.trim().is_empty());
    let close_line = text[..close]
        .rfind('\n')
        .map(|at| at + 1)
        .filter(|at| *at > end && text[*at..close].trim().is_empty());
    match (own_line, close_line) {
        // On a line of its own before the closing bracket, so that a comment behind the last entry stays
        // behind it.
        (Some(indent), Some(line)) => {
            let missing = if comma.is_some() { "" } else { "," };
            format!("{}{missing}{}{indent}{entry},\n{}", &text[..end], &text[end..line], &text[line..])
        }
        _ => {
            let (at, joint) = comma.map_or((end, ", "), |comma| (comma, " "));
            format!("{}{joint}{entry}{}", &text[..at], &text[at..])
        }
    }
}

/// One past the comma that follows an entry, if one does.
pub(super) fn comma_after(text: &str, end: usize, close: usize) -> Option<usize> {
    // Only white space, comments and one comma can stand here. Comments may hold commas too.
    let mut at = end;
    loop {
        let rest = &text[at..close];
        let space = rest.len() - rest.trim_start().len();
        let rest = &rest[space..];
        at += space;
        if rest.starts_with(',') {
            return Some(at + 1);
        } else if rest.starts_with("//") {
            at += rest.find('\n')?;
        } else if rest.starts_with("/*") {
            at += crate::text::raw::comment_length(rest)?;
        } else {
            return None;
        }
    }
}

/// `key: value`, with brackets for each further part.
fn entry(map: bool, field: &str, parts: &[String], value: &str) -> Result<String, SetError> {
    let [part, deeper @ ..] = parts else { return Ok(value.to_owned()) };
    let key = if map { quoted(part) } else { identifier(part)? };
    if deeper.is_empty() {
        return Ok(format!("{key}: {value}"));
    }
    if (!map && LISTS.contains(&part.as_str())) || (map && PLAIN.contains(&field)) {
        let message = format!("there is no `{part}` yet, so nothing can be set inside it: set all of it");
        return Err(SetError::new(part, message));
    }
    let child_is_map = !map && MAPS.contains(&part.as_str());
    let inner = entry(child_is_map, part, deeper, value)?;
    Ok(if child_is_map { format!("{key}: {{ {inner} }}") } else { format!("{key}: ({inner})") })
}

/// A text as a string of RON, raw only if it must be, so that names stand in the spec unchanged.
///
/// ```
/// use phisindy_phys::splice::quoted;
/// assert_eq!((quoted("x"), quoted("x \"a\"")), ("\"x\"".to_owned(), "r#\"x \"a\"\"#".to_owned()));
/// ```
pub fn quoted(text: &str) -> String {
    if !text.contains(['"', '\\']) {
        return format!("\"{text}\"");
    }
    // One hash more than the longest run of them: nothing in the text can end it.
    let longest = text.split(|c| c != '#').map(str::len).max().unwrap_or(0);
    let hashes = "#".repeat(longest + 1);
    format!("r{hashes}\"{text}\"{hashes}")
}

fn identifier(name: &str) -> Result<String, SetError> {
    let mut letters = name.chars();
    let starts = letters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_');
    if starts && letters.all(|c| c.is_ascii_alphanumeric() || c == '_') {
        return Ok(name.to_owned());
    }
    Err(SetError::new(name, format!("`{name}` is not the name of a field")))
}
