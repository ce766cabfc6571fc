//! `--set PATH=VALUE`: one value of a spec replaced in its text; comments, order and everything else stay.

mod error;
mod insert;

use crate::text::raw::{Node, Shape, content, parse};
pub use error::SetError;
pub use insert::quoted;

/// The text with the value at `path` replaced by `value`, or created there.
///
/// The path's parts are joined by dots: fields, keys of maps (in double quotes if they hold a dot), indices
/// of lists and tuples. Names of variants are passed over. A field or key that is missing is created in the
/// innermost group or map that exists.
///
/// # Errors
/// The text or the value is not RON, or the path leads nowhere.
///
/// ```
/// use phisindy_phys::splice::set;
/// let text = "(data: [Synthetic(noise: Relative(0.1) /* eq. 34 */)])";
/// assert_eq!(set(text, "data.0.noise", "Additive(0.02)").unwrap(), "(data: [Synthetic(noise: Additive(0.02) /* eq. 34 */)])");
/// assert_eq!(set("(data: [])", "learn.cutoff", "0.1").unwrap(), "(data: [], learn: (cutoff: 0.1))");
/// ```
pub fn set(text: &str, path: &str, value: &str) -> Result<String, SetError> {
    let parts = split(path)?;
    let root =
        parse(text).map_err(|m| SetError::new(path, format!("the spec cannot be read: {}", m.message)))?;
    let given = parse(value).map_err(|m| {
        SetError::new(value, format!("the value `{value}` for `{path}` is not RON: {}", m.message))
    })?;
    // What stands around the value, such as a line comment, could swallow what follows.
    if given.span.range() != (0..value.len()) && value.trim() != &value[given.span.range()] {
        return Err(SetError::new(value, format!("the value `{value}` holds more than one value")));
    }
    let value = &value[given.span.range()];
    let result = place(text, &root, &parts, value)?;
    match parse(&result) {
        Ok(_) => Ok(result),
        Err(m) => {
            Err(SetError::new(path, format!("the spec cannot be read with `{path}` set: {}", m.message)))
        }
    }
}

/// As [`set`], at a path of these parts, whatever characters they hold.
///
/// # Errors
/// As of [`set`].
///
/// ```
/// use phisindy_phys::splice::set_at;
/// let text = "(constants: {})";
/// assert_eq!(set_at(text, &["constants", "c.1"], "0.5").unwrap(), "(constants: { \"c.1\": 0.5 })");
/// ```
pub fn set_at(text: &str, path: &[&str], value: &str) -> Result<String, SetError> {
    let name = |part: &str| part.chars().all(|c| c.is_alphanumeric() || c == '_');
    let part = |part: &&str| if name(part) { (*part).to_owned() } else { format!("\"{part}\"") };
    set(text, &path.iter().map(part).collect::<Vec<_>>().join("."), value)
}

/// Walks down as far as the path exists, then replaces or creates.
fn place(text: &str, root: &Node, parts: &[String], value: &str) -> Result<String, SetError> {
    let (mut node, mut field) = (root, "");
    for (i, part) in parts.iter().enumerate() {
        let walked = parts[..i].join(".");
        node = through(text, node, part);
        match child(text, node, part) {
            Some(next) => (node, field) = (next, part),
            None if can_grow(node) => return insert::insert(text, node, field, &parts[i..], value),
            None => return Err(no_child(text, node, part, &walked)),
        }
    }
    Ok(format!("{}{value}{}", &text[..node.span.start], &text[node.span.end..]))
}

/// A variant around one bracket, like `Sensor({...})` or `Some((...))`, is passed over.
fn through<'n>(text: &str, node: &'n Node, part: &str) -> &'n Node {
    match node.entries.as_slice() {
        [only] if node.name.is_some() && only.key.is_none() && !only.value.entries.is_empty() => {
            // `Sensor({...}).0` is the map itself, unless the bracket has a 0 of its own.
            if part == "0" && child(text, &only.value, part).is_none() { node } else { &only.value }
        }
        _ => node,
    }
}

/// The value of this name or index.
fn child<'n>(text: &str, node: &'n Node, part: &str) -> Option<&'n Node> {
    let index = || if part.bytes().all(|b| b.is_ascii_digit()) { part.parse::<usize>().ok() } else { None };
    let named = node.entries.iter().find(|e| e.key.as_ref().is_some_and(|key| key_text(text, key) == part));
    named
        .or_else(|| index().and_then(|i| node.entries.get(i)).filter(|e| e.key.is_none()))
        .map(|entry| &entry.value)
}

fn key_text<'t>(text: &'t str, key: &Node) -> &'t str {
    let span = content(text, key.span).map_or(key.span, |(span, _)| span);
    &text[span.range()]
}

/// Whether it holds keys, so that another one can be added.
fn can_grow(node: &Node) -> bool {
    match node.shape {
        Shape::Map => true,
        Shape::Group => node.entries.iter().all(|e| e.key.is_some()),
        _ => false,
    }
}

fn no_child(text: &str, node: &Node, part: &str, walked: &str) -> SetError {
    let place = if walked.is_empty() { "the spec".to_owned() } else { format!("`{walked}`") };
    let count = node.entries.len();
    let message = match node.shape {
        Shape::List | Shape::Group if count == 0 => format!("{place} is empty, so it has no `{part}`"),
        Shape::List | Shape::Group if count == 1 => format!("{place} has one entry, 0, and no `{part}`"),
        Shape::List | Shape::Group => format!("{place} has the entries 0 to {}, and no `{part}`", count - 1),
        _ => format!("{place} is a single value, {}, and has no `{part}`", &text[node.span.range()]),
    };
    let available = if count <= 20 { (0..count).map(|i| i.to_string()).collect() } else { Vec::new() };
    SetError { available, ..SetError::new(part, message) }
}

/// The parts of a path.
fn split(path: &str) -> Result<Vec<String>, SetError> {
    let mut parts = Vec::new();
    let mut rest = path.trim();
    loop {
        let (part, after) = match rest.strip_prefix('"') {
            Some(quoted) => quoted.split_once('"').ok_or_else(|| {
                SetError::new(rest, format!("in the path `{path}` a quote is never closed"))
            })?,
            None => rest.split_at(rest.find('.').unwrap_or(rest.len())),
        };
        if part.trim().is_empty() {
            return Err(SetError::new(part, format!("a part of the path `{path}` is empty")));
        }
        parts.push(part.to_owned());
        match after.strip_prefix('.') {
            Some(next) => rest = next,
            None if after.is_empty() => return Ok(parts),
            None => {
                let message = format!("in the path `{path}` a dot is missing before `{after}`");
                return Err(SetError::new(after, message));
            }
        }
    }
}
