//! The header of a text file: its dialect, and the names and units of its columns.

use super::dialect::{Dialect, is_units_row, looks_like_number};
use super::line::{Line, LineError};
use super::lines::Lines;
use crate::cell::SEPARATOR;
use std::ops::Range;

/// The content of the first two lines.
pub(super) struct Header {
    /// Separator and decimal mark.
    pub(super) dialect: Dialect,
    /// Names of the columns; the number of a column, counted from 1, where the heading gives none.
    pub(super) names: Vec<String>,
    /// The heading line and its fields, if there is one.
    pub(super) heading: Option<(Line, Vec<Range<usize>>)>,
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
        let has_header = header.unwrap_or_else(|| cells.iter().any(|f| !looks_like_number(f)));
        if !has_header {
            let names = (1..=fields.len()).map(|k| k.to_string()).collect();
            let rows = [Some(first), second].into_iter().flatten().collect();
            return Ok(Some(Header { dialect, names, heading: None, unnamed: vec![], units: None, rows }));
        }
        let unnamed: Vec<usize> = (0..cells.len()).filter(|&k| cells[k].is_empty()).collect();
        unnamed.iter().for_each(|&k| cells[k] = (k + 1).to_string());
        let (units, rows) = match second {
            Some(line) if is_units_row(&dialect, &line.text) => (Some(dialect.cells(&line.text)), vec![]),
            other => (None, other.into_iter().collect()),
        };
        Ok(Some(Header { dialect, names: cells, heading: Some((first, fields)), unnamed, units, rows }))
    }
}
