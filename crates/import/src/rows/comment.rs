//! Comment lines of a text file: their signs, and the heading that programs such as NumPy write behind one.

use super::dialect::{Dialect, is_units_row, looks_like_number};
use super::line::Line;
use crate::headings::{Heading, Quantity};
use crate::roles::is_word_of_a_role;
use crate::time_column::is_named_time;
use std::ops::Range;

/// What comments begin with. A semicolon separates cells too, so it is a sign where the line has no other.
const SIGNS: [&str; 5] = ["#", "%", "//", "!", ";"];
/// Words before a colon that announce the names of columns: `# Fields: t x`.
const ANNOUNCEMENTS: [&str; 7] = ["columns", "column", "fields", "header", "heading", "spalten", "channels"];
/// Comments above the first row that are looked at for a heading.
const NEAR: usize = 30;

/// Whether a line is a comment.
pub(super) fn is_comment(line: &[u8]) -> bool {
    let text = line.trim_ascii_start();
    match text.first() {
        Some(b'#' | b'%' | b'!') => true,
        Some(b'/') => text.starts_with(b"//"),
        Some(b'"' | b',') => is_property(text),
        Some(b';') => {
            // `;1,5` is a row whose first cell is empty.
            let rest = text[1..].trim_ascii();
            !rest.is_empty() && !rest.contains(&b';') && !is_number(rest)
        }
        _ => false,
    }
}

/// Whether a line holds properties of channels below their names, as Simulink writes them: `"","Type: double"`. Units are
/// read.
fn is_property(text: &[u8]) -> bool {
    let rest = text.strip_prefix(b"\"\"").unwrap_or(text);
    let Some(cell) = rest.strip_prefix(b",") else { return false };
    let cell = cell.strip_prefix(b"\"").unwrap_or(cell);
    PROPERTIES.iter().any(|name| cell.starts_with(name.as_bytes()))
}

/// What Simulink tells of a channel beside its unit.
const PROPERTIES: [&str; 4] = ["Type:", "Interp:", "BlockPath:", "PortIndex:"];

fn is_number(bytes: &[u8]) -> bool {
    std::str::from_utf8(bytes).is_ok_and(looks_like_number)
}

/// The line with blanks in the place of its comment sign, so that its fields stay where they are.
fn without_sign(line: &Line) -> String {
    let mut text = line.text.as_str();
    loop {
        let rest = text.trim_start();
        let sign = SIGNS.iter().find(|sign| rest.starts_with(**sign));
        text = match sign {
            Some(sign) => &rest[sign.len()..],
            None => rest,
        };
        if sign.is_none() {
            break;
        }
    }
    if let Some((word, names)) = text.split_once(':')
        && ANNOUNCEMENTS.contains(&word.trim().to_lowercase().as_str())
    {
        text = names;
    }
    format!("{}{text}", " ".repeat(line.text.len() - text.len()))
}

/// A heading behind a comment sign.
pub(super) struct Commented {
    /// The line, with blanks in the place of its sign.
    pub(super) line: Line,
    /// Places of the names.
    pub(super) fields: Vec<Range<usize>>,
    /// The names.
    pub(super) names: Vec<String>,
    /// The units of a line below, behind a comment sign too.
    pub(super) units: Option<Vec<String>>,
}

/// Looks in the comments above rows of numbers of `width` columns for their heading: the lowest line with as
/// many names. It may have another separator than the rows.
pub(super) fn heading(dialect: &Dialect, width: usize, comments: &[Line]) -> Option<Commented> {
    let mut units = None;
    // The line that stands on the rows needs less proof.
    let mut touches = true;
    for comment in comments.iter().rev().take(NEAR) {
        let line = Line { text: without_sign(comment), ..comment.clone() };
        let own = split(dialect, width, &line);
        if let (Some((_, cells)), true, true) = (&own, touches, width > 1)
            && units.is_none()
            && cells.iter().all(|c| c.len() < 12)
            && is_units_row(dialect, &line.text)
        {
            units = Some((line, own.unwrap_or_default().1));
            continue;
        }
        let others =
            [Some(';'), Some('\t'), Some(','), None].map(|separator| Dialect { separator, decimal: None });
        let all = own.map(|cells| (dialect.separator, cells)).into_iter();
        let all = all.chain(others.iter().filter_map(|d| Some((d.separator, split(d, width, &line)?))));
        for (separator, (fields, names)) in all {
            if names_columns(&line.text, separator, &names, touches) {
                let units = units.map(|(_, cells)| cells);
                return Some(Commented { line, fields, names, units });
            }
        }
        touches = false;
    }
    // Letters such as `t, m, F` are units as well as names.
    let (line, names) = units?;
    let (fields, _) = split(dialect, width, &line)?;
    Some(Commented { line, fields, names, units: None })
}

/// The units in a comment below a heading of `width` names, if it holds units and nothing else.
pub(super) fn units(dialect: &Dialect, width: usize, comment: &Line) -> Option<Vec<String>> {
    let line = Line { text: without_sign(comment), ..comment.clone() };
    let (_, cells) = split(dialect, width, &line)?;
    is_units_row(dialect, &line.text).then_some(cells)
}

/// Fields and contents of a line, if it has as many as a row.
pub(super) fn split(
    dialect: &Dialect,
    width: usize,
    line: &Line,
) -> Option<(Vec<Range<usize>>, Vec<String>)> {
    let fields = dialect.fields_of(line, width);
    let cells: Vec<String> = fields.iter().map(|f| dialect.unquoted(&line.text, f).into_owned()).collect();
    (fields.len() == width).then_some((fields, cells))
}

/// Whether a mark that separates stands behind one of these words.
pub(super) fn has_marks(cells: &[String]) -> bool {
    cells.iter().any(|c| c.len() > 1 && c.ends_with([',', ';']))
}

/// Whether these cells of a comment are names of columns. Prose may have as many words.
fn names_columns(text: &str, separator: Option<char>, cells: &[String], touches: bool) -> bool {
    if cells.iter().any(|c| looks_like_number(c)) || text.contains('=') || cells.iter().all(String::is_empty)
    {
        return false;
    }
    // `t, x, F` has commas, though blanks split it as well.
    if separator.is_none() && has_marks(cells) {
        return false;
    }
    let known = |cell: &&String| {
        let heading = Heading::parse(cell);
        let measures = !matches!(heading.quantity, Quantity::Unknown | Quantity::Other);
        measures || is_named_time(&heading) || is_word_of_a_role(&heading)
    };
    let count = cells.iter().filter(known).count();
    match cells {
        // A single name has a unit of a motion, and is no sentence.
        [one] => {
            let quantity = Heading::parse(one).quantity;
            let motion = !matches!(quantity, Quantity::Unknown | Quantity::Other | Quantity::Time);
            motion && !one.contains(':') && one.split_whitespace().count() <= 3
        }
        _ if separator.is_none() => 2 * count > cells.len() && !text.contains(':'),
        _ => count > 0 || (touches && !text.contains(':')),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn comments(lines: &[&str]) -> Vec<Line> {
        let line = |(k, text): (usize, &&str)| Line { text: (*text).to_owned(), number: k + 1, ended: true };
        lines.iter().enumerate().map(line).collect()
    }

    /// The names and units of a heading above rows of `width` columns.
    fn found(separator: Option<char>, width: usize, lines: &[&str]) -> Option<(Vec<String>, Vec<String>)> {
        let dialect = Dialect { separator, decimal: None };
        heading(&dialect, width, &comments(lines)).map(|h| (h.names, h.units.unwrap_or_default()))
    }

    #[test]
    fn a_row_that_begins_with_a_semicolon_is_no_comment() {
        for (line, comment) in [
            ("# a", true),
            ("  % a", true),
            ("// a", true),
            ("! a", true),
            ("; t_s, x_mm", true),
            (";1,5", false),
            (";t;x", false),
            (";", false),
            ("/ a", false),
            ("-1.5", false),
            ("", false),
        ] {
            assert_eq!(is_comment(line.as_bytes()), comment, "{line}");
        }
    }

    #[test]
    fn places_of_names_are_those_in_the_line() {
        let dialect = Dialect { separator: Some(','), decimal: None };
        let line = "#µ# Columns: t, x";
        let found = heading(&dialect, 2, &comments(&[line])).expect("a heading");
        assert_eq!(found.fields.iter().map(|f| &line[f.clone()]).collect::<Vec<_>>(), ["µ# Columns: t", "x"]);
        let line = "# Columns: t, x";
        let found = heading(&dialect, 2, &comments(&[line])).expect("a heading");
        assert_eq!(found.fields.iter().map(|f| &line[f.clone()]).collect::<Vec<_>>(), ["t", "x"]);
    }

    #[test]
    fn names_are_told_from_prose_data_and_settings() {
        let names = |all: &[&str]| all.iter().map(|n| (*n).to_owned()).collect::<Vec<_>>();
        let none: Vec<String> = vec![];
        assert_eq!(
            found(Some(','), 2, &["# t,x", "# s,mm"]),
            Some((names(&["t", "x"]), names(&["s", "mm"])))
        );
        assert_eq!(found(Some(','), 2, &["# a, b"]), Some((names(&["a", "b"]), none.clone())));
        assert_eq!(
            found(Some(','), 2, &["# t_s, x", "# gain = 3"]),
            Some((names(&["t_s", "x"]), none.clone()))
        );
        assert_eq!(found(Some(','), 2, &["# s, m"]), Some((names(&["s", "m"]), none)));
        for lines in [
            ["# a, b = 3", ""],
            ["# 0.1, 0.2", ""],
            ["# rig: 7, Monday", ""],
            ["# rig 7, Monday", "# nothing else here"],
            ["# t, x, F", ""],
        ] {
            assert_eq!(
                found(Some(','), 2, &lines[..1 + usize::from(!lines[1].is_empty())]),
                None,
                "{lines:?}"
            );
        }
        assert_eq!(found(None, 3, &["# slider seven here"]), None);
        assert_eq!(found(None, 1, &["# fs = 1000 Hz"]), None);
        assert!(found(None, 1, &["# acc [m/s^2]"]).is_some());
    }
}
