//! A table of a file that is no text. Its rows are written as lines of text, with numbers as the shortest
//! text that reads back as the same number: so every format takes the one way that text takes, to the same
//! bits.

use crate::cell::{Cell, push};
use crate::columns::Columns;
use crate::rows::Line;

/// A table.
#[derive(Debug)]
pub(crate) struct Sheet {
    /// Its name, if the file has several or the user must name it.
    pub(crate) name: Option<String>,
    /// The other sheets of the file.
    pub(crate) others: Vec<String>,
    /// What was done to channels of other rates, for the user.
    pub(crate) notes: Vec<String>,
    /// The channels of other rates that a record asks for, as they were sampled.
    pub(crate) own: Vec<OwnChannel>,
    /// The rows.
    pub(crate) rows: Rows,
}

/// A channel with times of its own, in the units of the file.
#[derive(Debug)]
pub(crate) struct OwnChannel {
    pub(crate) name: String,
    pub(crate) time: Vec<f64>,
    pub(crate) values: Vec<f64>,
}

/// The rows of a sheet.
#[derive(Debug)]
pub(crate) enum Rows {
    /// Of a workbook: numbers of the rows from 1, and their cells. Heading and remarks stand among them.
    Cells(Vec<(usize, Vec<Cell>)>),
    /// Columns with a name each.
    Columns(Columns),
}

impl Sheet {
    /// Whether the first line is a heading; none if that is to be found out.
    pub(crate) fn heading(&self) -> Option<bool> {
        match &self.rows {
            Rows::Cells(_) => None,
            Rows::Columns(columns) => Some(columns.has_names()),
        }
    }

    /// Number of lines.
    pub(crate) fn lines(&self) -> usize {
        match &self.rows {
            Rows::Cells(rows) => rows.len(),
            Rows::Columns(columns) => columns.lines(),
        }
    }

    /// A line.
    pub(crate) fn line(&self, k: usize) -> Option<Line> {
        match &self.rows {
            Rows::Cells(rows) => {
                let (number, cells) = rows.get(k)?;
                let mut text = String::with_capacity(12 * cells.len());
                cells.iter().for_each(|cell| push(&mut text, cell));
                Some(Line { text, number: *number, ended: true })
            }
            Rows::Columns(columns) => columns.line(k),
        }
    }
}
