//! The header of a text file: its dialect, and the names and units of its columns.

use super::comment;
use super::dialect::{Dialect, is_missing, is_units_row, looks_like_number};
use super::line::{Line, LineError};
use super::lines::Lines;
use crate::cell::SEPARATOR;
use std::ops::Range;

/// The content of the first two lines, and the heading behind a comment sign above them.
pub(super) struct Header {
    /// Separator and decimal mark.
    pub(super) dialect: Dialect,
    /// Names of the columns; the number of a column, counted from 1, where the heading gives none.
    pub(super) names: Vec<String>,
    /// The heading line and its fields, if there is one.
    pub(super) heading: Option<(Line, Vec<Range<usize>>)>,
    /// Whether the heading stands behind a comment sign.
    pub(super) commented: bool,
    /// Columns without a name in the heading line, counted from 0.
    pub(super) unnamed: Vec<usize>,
    /// Cells of a second heading line that holds only units.
    pub(super) units: Option<Vec<String>>,
    /// Those of the two lines that are rows of numbers.
    pub(super) rows: Vec<Line>,
}

impl Header {
    /// Reads the first two lines and guesses what is not given. Returns `None` for an empty file.
    ///
    /// # Errors
    /// One of the lines cannot be read.
    pub(super) fn read(
        lines: &mut Lines<'_>,
        separator: Option<char>,
        decimal: Option<char>,
        header: Option<bool>,
    ) -> Result<Option<Header>, LineError> {
        // Other formats than text say what is a cell and, most of them, what is a heading.
        let (separator, header) = match lines.sheet() {
            Some(sheet) => (Some(SEPARATOR), sheet.heading().or(header)),
            None => (separator, header),
        };
        let Some(first) = lines.next()? else { return Ok(None) };
        let second = lines.next()?;
        let dialect =
            Dialect::guess(separator, decimal, &first.text, second.as_ref().map(|l| l.text.as_str()));
        let fields = dialect.fields(&first.text);
        let mut cells = dialect.cells(&first.text);
        // A value may be missing in the first row.
        let no_number = |f: &String| !looks_like_number(f) && !is_missing(f);
        let all_missing = cells.iter().all(|f| is_missing(f));
        // `header: false` numbers the columns, whatever stands above them.
        let wanted = header.is_none() && first.number > 0;
        let found = || {
            let known: Vec<Line> =
                lines.comments().iter().filter(|c| c.number < first.number).cloned().collect();
            wanted.then(|| comment::heading(&dialect, fields.len(), &known)).flatten()
        };
        let words = cells.iter().any(no_number);
        let mut has_header = header.unwrap_or(words || all_missing);
        // A row may hold words beside its numbers, below a heading behind a comment sign.
        let mixed = words && cells.iter().any(|cell| looks_like_number(cell));
        let mut found = if !has_header || mixed { found() } else { None };
        has_header &= !(mixed && found.is_some());
        if !has_header {
            let found = found.take();
            let numbers = (1..=fields.len()).map(|k| k.to_string()).collect();
            let rows = [Some(first), second].into_iter().flatten().collect();
            return Ok(Some(match found {
                Some(found) => {
                    let (names, unnamed) = named(found.names);
                    let heading = Some((found.line, found.fields));
                    Header { dialect, names, heading, commented: true, unnamed, units: found.units, rows }
                }
                None => Header {
                    dialect,
                    names: numbers,
                    heading: None,
                    commented: false,
                    unnamed: vec![],
                    units: None,
                    rows,
                },
            }));
        }
        // Commas between the names and blanks between the numbers.
        let mut fields = fields;
        if dialect.separator.is_none() && comment::has_marks(&cells) {
            let marks = [',', ';'].map(|mark| Dialect { separator: Some(mark), decimal: None });
            if let Some((places, names)) = marks.iter().find_map(|d| comment::split(d, cells.len(), &first)) {
                (fields, cells) = (places, names);
            }
        }
        let units_behind_a_sign = || {
            let below = lines.comments().iter().find(|c| c.number > first.number)?;
            comment::units(&dialect, cells.len(), below)
        };
        let (units, rows) = match second {
            Some(line) if is_units_row(&dialect, &line.text) => (Some(dialect.cells(&line.text)), vec![]),
            other => (units_behind_a_sign(), other.into_iter().collect()),
        };
        // R and pandas write names or numbers of rows, and no name above them.
        let of_rows = |row: &Line| has_row_name(&dialect, row, cells.len());
        if rows.first().is_some_and(of_rows) {
            cells.insert(0, String::new());
            fields.insert(0, 0..0);
        }
        let (names, unnamed) = named(std::mem::take(&mut cells));
        let heading = Some((first, fields));
        Ok(Some(Header { dialect, names, heading, commented: false, unnamed, units, rows }))
    }
}

/// Whether a row has its own name, in quotes or as its number, and so one cell more than so many names above it.
pub(super) fn has_row_name(dialect: &Dialect, row: &Line, names: usize) -> bool {
    let fields = dialect.fields(&row.text);
    let named = |own: &Range<usize>| {
        let text = &row.text[own.clone()];
        text.starts_with('"') || (names > 1 && text.bytes().all(|b| b.is_ascii_digit()))
    };
    fields.len() == names + 1 && named(&fields[0])
}

/// The number of a column, counted from 1, in the place of a name that is missing; and which columns these
/// are, counted from 0.
fn named(mut names: Vec<String>) -> (Vec<String>, Vec<usize>) {
    let unnamed: Vec<usize> = (0..names.len()).filter(|&k| names[k].is_empty()).collect();
    unnamed.iter().for_each(|&k| names[k] = (k + 1).to_string());
    (names, unnamed)
}
