//! How a file separates its fields and writes its decimals.

use phisindy_phys::spec::CsvSpec;
use std::ops::Range;

/// How a file is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Dialect {
    /// The character between fields; None: any run of blanks.
    pub(super) separator: Option<char>,
    /// The decimal mark, where the spec says it.
    pub(super) decimal: Option<char>,
}

impl Dialect {
    /// What the spec says, or what makes the first two lines a table.
    pub(super) fn guess(csv: &CsvSpec, first: &str, second: Option<&str>) -> Dialect {
        let decimal = csv.decimal.as_ref().map(|d| d.value);
        let with = |separator| Dialect { separator, decimal };
        if let Some(given) = &csv.separator {
            return with(Some(given.value).filter(|c| *c != ' '));
        }
        let candidates = [Some(';'), Some('\t'), Some(','), None].map(with);
        let count = |d: &Dialect, line: &str| d.fields(line).len();
        let table = |d: &&Dialect| {
            let n = count(d, first);
            n > 1 && second.is_none_or(|line| count(d, line) == n)
        };
        let best =
            candidates.iter().find(table).or_else(|| candidates.iter().rev().max_by_key(|d| count(d, first)));
        best.cloned().unwrap_or_else(|| with(Some(',')))
    }

    /// The fields of a line, blanks around them taken off. One empty field at the end (a separator too many) is no field.
    pub(super) fn fields(&self, line: &str) -> Vec<Range<usize>> {
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

    /// The content of a field; quoting rules are those of the csv crate.
    pub(super) fn unquoted(&self, line: &str, field: &Range<usize>) -> String {
        let text = &line[field.clone()];
        if !text.starts_with('"') {
            return text.to_owned();
        }
        let mut reader =
            csv::ReaderBuilder::new().has_headers(false).delimiter(0).from_reader(text.as_bytes());
        let record = reader.records().next().and_then(Result::ok);
        record.and_then(|r| r.get(0).map(|f| f.trim().to_owned())).unwrap_or_else(|| text.to_owned())
    }
}

fn trimmed(line: &str, range: Range<usize>) -> Range<usize> {
    let text = &line[range.clone()];
    let start = range.start + (text.len() - text.trim_start().len());
    start..(start + text.trim().len())
}
