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

/// The text with a value behind those of the list at a path, which is made where there is none.
///
/// # Errors
/// As of [`set`].
///
/// ```
/// use phisindy_phys::splice::push_at;
/// assert_eq!(push_at("(contacts: [\"v\"])", &["contacts"], "\"w\"").unwrap(), "(contacts: [\"v\", \"w\"])");
/// assert_eq!(push_at("()", &["contacts"], "\"w\"").unwrap(), "(contacts: [\"w\"])");
/// ```
pub fn push_at(text: &str, path: &[&str], value: &str) -> Result<String, SetError> {
    match found(text, path)? {
        Some((_, node)) if node.shape == Shape::List => Ok(insert::put(text, &node, value)),
        _ => set_at(text, path, &format!("[{value}]")),
    }
}

/// The text without the entry of a list or a map at a path, and without its comma; comments stay.
///
/// # Errors
/// The text is not RON, or there is no such entry.
///
/// ```
/// use phisindy_phys::splice::remove_at;
/// let text = "(known: {\n  \"x\": \"v\", // speed\n  \"v\": \"-x\",\n}, contacts: [\"v\", \"w\"])";
/// let text = remove_at(&remove_at(text, &["known", "v"]).unwrap(), &["contacts", "1"]).unwrap();
/// assert_eq!(text, "(known: {\n  \"x\": \"v\", // speed\n}, contacts: [\"v\"])");
/// ```
pub fn remove_at(text: &str, path: &[&str]) -> Result<String, SetError> {
    let missing = || SetError::new(&path.join("."), format!("there is no `{}`", path.join(".")));
    let (parent, node) = found(text, path)?.ok_or_else(missing)?;
    let k = parent.entries.iter().position(|e| e.value.span == node.span).ok_or_else(missing)?;
    let start = parent.entries[k].key.as_ref().map_or(node.span.start, |key| key.span.start);
    let (end, close) = (node.span.end, parent.span.end - 1);
    let blank = |from: usize, to: usize| text[from..to].trim().is_empty();
    let comma = insert::comma_after(text, end, close).filter(|comma| blank(end, comma - 1));
    let end = comma.unwrap_or(end);
    let line = text[..start].rfind('\n').map(|at| at + 1).filter(|at| blank(*at, start));
    let next = text[end..].find('\n').map(|at| end + at + 1).filter(|at| blank(end, *at));
    // The comma before the last one goes with it.
    let before = k.checked_sub(1).map(|k| parent.entries[k].value.span.end);
    let before = before.filter(|_| comma.is_none()).and_then(|at| insert::comma_after(text, at, close));
    let (from, to) = match (line, next, before) {
        (Some(line), Some(next), _) => (line, next),
        (_, _, Some(before)) if blank(before, start) => (before - 1, end),
        _ => (start, end + text[end..].len() - text[end..].trim_start_matches(' ').len()),
    };
    Ok(format!("{}{}", &text[..from], &text[to..]))
}

/// The node at a path, below its parent.
fn found(text: &str, path: &[&str]) -> Result<Option<(Node, Node)>, SetError> {
    let whole = &path.join(".");
    let root = parse(text).map_err(|m| SetError::new(whole, m.message))?;
    let mut pair = (&root, &root);
    for part in path {
        let parent = through(text, pair.1, part);
        let Some(node) = child(text, parent, part) else { return Ok(None) };
        pair = (parent, node);
    }
    Ok(Some((pair.0.clone(), pair.1.clone())))
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
