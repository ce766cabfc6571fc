//! How a text file begins: its dialect, the names and units of its columns.

use super::dialect::{Dialect, is_units_row, looks_like_number};
use super::lines::{Line, LineError, Lines};
use std::ops::Range;

/// What the first two lines say.
pub(super) struct Opening {
    /// How fields are separated.
    pub(super) dialect: Dialect,
    /// Names of the columns; `1`, `2`, ... without a heading line.
    pub(super) names: Vec<String>,
    /// The heading line and its fields, if there is one.
    pub(super) heading: Option<(Line, Vec<Range<usize>>)>,
    /// The fields of a second heading line that only holds units.
    pub(super) units: Option<Vec<String>>,
    /// Rows of numbers that were read on the way.
    pub(super) rows: Vec<Line>,
}

impl Opening {
    /// Reads the first two lines; `separator`, `decimal` and `header` are taken as they are if they are given. `None` for an empty file.
    ///
    /// # Errors
    /// One of the lines cannot be read.
    pub(super) fn read(
        lines: &mut Lines<'_>,
        separator: Option<char>,
        decimal: Option<char>,
        header: Option<bool>,
    ) -> Result<Option<Opening>, LineError> {
        let Some(first) = lines.next()? else { return Ok(None) };
        let second = lines.next()?;
        let dialect =
            Dialect::guess(separator, decimal, &first.text, second.as_ref().map(|l| l.text.as_str()));
        let fields = dialect.fields(&first.text);
        let cells = dialect.cells(&first.text);
        let has_header = header.unwrap_or_else(|| cells.iter().any(|f| !looks_like_number(f)));
        if !has_header {
            let names = (1..=fields.len()).map(|k| k.to_string()).collect();
            let rows = [Some(first), second].into_iter().flatten().collect();
            return Ok(Some(Opening { dialect, names, heading: None, units: None, rows }));
        }
        let (units, rows) = match second {
            Some(line) if is_units_row(&dialect, &line.text) => (Some(dialect.cells(&line.text)), vec![]),
            other => (None, other.into_iter().collect()),
        };
        Ok(Some(Opening { dialect, names: cells, heading: Some((first, fields)), units, rows }))
    }
}
