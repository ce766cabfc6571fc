//! Columns of one length, which are read like lines of text.

use crate::cell::{SEPARATOR, push_number, push_word};
use crate::channel::Values;
use crate::rows::Line;

/// Columns of one length.
#[derive(Debug)]
pub(crate) struct Columns {
    pub(crate) columns: Vec<Column>,
    pub(crate) rows: usize,
    /// Rows before the first one that every column covers.
    pub(crate) first: usize,
}

#[derive(Debug)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) unit: Option<String>,
    pub(crate) values: Values,
}

impl Columns {
    /// Whether the columns have names of their own; otherwise they are counted from 1.
    pub(crate) fn has_names(&self) -> bool {
        self.columns.iter().enumerate().any(|(k, c)| c.name != (k + 1).to_string())
    }

    fn has_units(&self) -> bool {
        self.has_names() && self.columns.iter().any(|c| c.unit.is_some())
    }

    pub(crate) fn lines(&self) -> usize {
        self.rows + usize::from(self.has_names()) + usize::from(self.has_units())
    }

    /// A line: the names, the units, or a row.
    pub(crate) fn line(&self, k: usize) -> Option<Line> {
        let mut text = String::with_capacity(12 * self.columns.len());
        let heading = usize::from(self.has_names());
        let units = heading + usize::from(self.has_units());
        let number = if k < units { 0 } else { k - units + self.first + 1 };
        if k >= units && k - units >= self.rows {
            return None;
        }
        for column in &self.columns {
            if !text.is_empty() {
                text.push(SEPARATOR);
            }
            match &column.values {
                _ if k < heading => push_word(&mut text, &column.name),
                _ if k < units => push_word(&mut text, column.unit.as_deref().unwrap_or("-")),
                Values::Numbers(x) => push_number(&mut text, x[k - units]),
                Values::Words(x) => push_word(&mut text, &x[k - units]),
            }
        }
        Some(Line { text, number, ended: true })
    }
}
