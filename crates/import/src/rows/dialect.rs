//! Separator and decimal mark of a text file.

use crate::clock::is_stamp;
use crate::headings::{is_beside_units, is_name_over_unit, is_unit};
use crate::rows::line::Line;
use crate::rows::thousands::is_grouped;
use std::borrow::Cow;
use std::ops::Range;

/// Separator and decimal mark.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Dialect {
    /// The character between fields; `None` for any number of blanks.
    pub(crate) separator: Option<char>,
    /// The decimal mark, if the spec states it.
    pub(crate) decimal: Option<char>,
}

impl Dialect {
    /// Takes the given separator, or guesses it from the first two lines: one that splits both into the same
    /// number of fields, and of these the one that yields the largest share of numbers.
    pub(crate) fn guess(
        separator: Option<char>,
        decimal: Option<char>,
        first: &str,
        second: Option<&str>,
    ) -> Dialect {
        let with = |separator| Dialect { separator, decimal };
        if let Some(given) = separator {
            return with(Some(given).filter(|c| *c != ' '));
        }
        let candidates = [Some(';'), Some('\t'), Some(','), None].map(with);
        let count = |d: &Dialect, line: &str| d.fields(line).len();
        // Behind a trailing separator the last value may be missing.
        let trailing =
            |d: &Dialect, line: &str| d.separator.is_some_and(|c| line.trim_end_matches(' ').ends_with(c));
        let table = |d: &&Dialect| {
            let n = count(d, first);
            let as_many = |line: &str| count(d, line) == n || (count(d, line) + 1 == n && trailing(d, line));
            n > 1 && second.is_none_or(as_many)
        };
        // Numbers in the second line, in per mille of its fields: "0,01 1,5" holds two numbers, not three
        // fields.
        let numbers = |d: &&Dialect| {
            let line = second.unwrap_or(first);
            let fields = d.fields(line);
            let good = fields.iter().filter(|f| looks_like_number(&d.unquoted(line, f))).count();
            1000 * good / fields.len().max(1)
        };
        // Ties go to the first candidate; `max_by_key` takes the last, so the order is reversed.
        let best = candidates.iter().rev().filter(table).max_by_key(numbers);
        // One number below a heading of several words, as in `ACC [g]`: one column.
        let alone = |d: &&Dialect| {
            second.is_some_and(|line| looks_like_number(line.trim()) && count(d, line) == 1)
                && count(d, first) == 1
        };
        let best = best.or_else(|| candidates.iter().find(alone));
        let best = best.or_else(|| candidates.iter().rev().max_by_key(|d| count(d, first)));
        best.cloned().unwrap_or_else(|| with(Some(',')))
    }

    /// The fields of a line without surrounding blanks. A trailing separator adds no field.
    pub(crate) fn fields(&self, line: &str) -> Vec<Range<usize>> {
        let mut fields = Vec::new();
        match self.separator {
            Some(separator) => {
                let (mut start, mut quoted) = (0, false);
                for (at, c) in line.char_indices() {
                    if c == '"' {
                        quoted = !quoted;
                    } else if c == separator && !quoted {
                        fields.push(trimmed(line, start..at));
                        start = at + c.len_utf8();
                    }
                }
                let rest = trimmed(line, start..line.len());
                if !rest.is_empty() || fields.is_empty() {
                    fields.push(rest);
                }
            }
            None => {
                let mut start = None;
                let mut quoted = false;
                for (at, c) in line.char_indices() {
                    quoted ^= c == '"';
                    match (c.is_whitespace() && !quoted, start) {
                        (true, Some(from)) => {
                            fields.push(from..at);
                            start = None;
                        }
                        (false, None) => start = Some(at),
                        _ => {}
                    }
                }
                fields.extend(start.map(|from| from..line.len()));
            }
        }
        fields
    }

    /// The fields of a row below a heading of so many: behind a trailing separator stands the last value, if
    /// it is missing. (Without an end of line the file is cut off.)
    pub(crate) fn fields_of(&self, line: &Line, width: usize) -> Vec<Range<usize>> {
        let (text, mut fields) = (&line.text, self.fields(&line.text));
        let trailing =
            self.separator.is_some_and(|separator| text.trim_end_matches(' ').ends_with(separator));
        if trailing && line.ended && fields.len() + 1 == width {
            fields.push(text.len()..text.len());
        }
        fields
    }

    /// Whether the comma that separates the fields of a row may be its decimal mark too: between commas stand
    /// whole numbers alone.
    pub(crate) fn may_split_decimals(&self, line: &str) -> bool {
        let whole = |field: &Range<usize>| line[field.clone()].parse::<i64>().is_ok();
        self.separator == Some(',') && self.fields(line).iter().all(whole)
    }

    /// The contents of all fields.
    pub(crate) fn cells(&self, line: &str) -> Vec<String> {
        self.fields(line).iter().map(|f| self.unquoted(line, f).into_owned()).collect()
    }

    /// The content of a field, unquoted by the rules of the csv crate.
    pub(crate) fn unquoted<'t>(&self, line: &'t str, field: &Range<usize>) -> Cow<'t, str> {
        let text = &line[field.clone()];
        if !text.starts_with('"') {
            return Cow::Borrowed(text);
        }
        let mut reader =
            csv::ReaderBuilder::new().has_headers(false).delimiter(0).from_reader(text.as_bytes());
        let record = reader.records().next().and_then(Result::ok);
        record.and_then(|r| r.get(0).map(|f| Cow::Owned(f.trim().to_owned()))).unwrap_or(Cow::Borrowed(text))
    }
}

fn trimmed(line: &str, range: Range<usize>) -> Range<usize> {
    let text = &line[range.clone()];
    let start = range.start + (text.len() - text.trim_start().len());
    start..(start + text.trim().len())
}

/// Whether a field is a number with decimal point or comma, marks of thousands, or a time of day.
pub(crate) fn looks_like_number(text: &str) -> bool {
    text.parse::<f64>().is_ok()
        || text.replacen(',', ".", 1).parse::<f64>().is_ok()
        || is_stamp(text)
        || is_grouped(text)
}

/// Common spellings of a missing value.
pub(crate) fn is_missing(text: &str) -> bool {
    matches!(
        text.to_lowercase().as_str(),
        "" | "nan" | "na" | "n/a" | "#n/a" | "#na" | "#nv" | "null" | "none" | "-" | "--" | "?" | "missing"
    )
}

/// Whether a field is a number beyond all others, which no sensor reads: `inf`, `-inf`, `1e999`.
pub(crate) fn is_infinite(text: &str) -> bool {
    // Digits alone are finite up to 308 of them: nearly all fields need not be read.
    let may_be = text.len() > 308 || text.contains(['e', 'E', 'i', 'I']);
    may_be && text.replacen(',', ".", 1).parse::<f64>().is_ok_and(f64::is_infinite)
}

/// What a line of units is called in its first cell.
const UNIT_LABELS: &[&str] = &["unit", "units", "einheit", "einheiten"];

/// Whether a line is a second heading that holds only units: `s;mm;N`, `[s];[mm];[N]` or `unit;s;mm;N`.
pub(crate) fn is_units_row(dialect: &Dialect, line: &str) -> bool {
    let mut cells = dialect.cells(line);
    if cells.len() > 1 && UNIT_LABELS.contains(&cells[0].trim_end_matches(':').to_lowercase().as_str()) {
        cells.remove(0);
    }
    let number = |cell: &&String| looks_like_number(cell.trim_matches(['[', ']', '(', ')', ' ']));
    let units = cells.iter().filter(|cell| is_unit(cell) && !number(cell)).count();
    let beside = |cell: &&String| !is_unit(cell) && is_beside_units(cell);
    // `t / ms;s / mm` are names and their units, though a tonne per millisecond is a unit.
    let none = cells.iter().all(|cell| matches!(cell.as_str(), "-" | "--"));
    (units > 0 || none)
        && !cells.iter().all(|cell| is_name_over_unit(cell))
        && units + cells.iter().filter(beside).count() == cells.len()
}
