//! The table that the reader of each format delivers: columns of numbers with headings and units.

use crate::headings::Heading;
use crate::stated_rate::StatedRate;
use phisindy_phys::Diagnostic;

/// A column of a file.
#[derive(Clone, Debug)]
pub struct Column {
    /// Name and unit.
    pub heading: Heading,
    /// One number for each row, in the unit of the heading; NaN for a cell without number.
    pub values: Vec<f64>,
    /// Number of cells that hold a time of day; they are seconds from the first one.
    pub stamps: usize,
    /// Number of cells that hold text.
    pub text_cells: usize,
    /// A diagnostic for the first of these cells.
    pub first_text: Option<Diagnostic>,
    /// How they follow each other.
    pub(crate) words: Words,
}

/// Different words of a column that are kept: more are no names of channels.
const MOST_WORDS: usize = 32;

/// The words of a column: how many there are, and how often another one follows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Words {
    last: String,
    seen: Vec<String>,
    changes: usize,
}

impl Words {
    /// The next one.
    pub(crate) fn see(&mut self, word: &str) {
        if word == self.last {
            return;
        }
        word.clone_into(&mut self.last);
        self.changes += 1;
        if self.seen.len() <= MOST_WORDS && !self.seen.iter().any(|seen| seen == word) {
            self.seen.push(word.to_owned());
        }
    }

    /// The words, if there are few that take turns over so many rows: of a log they say whose value a row holds.
    pub(crate) fn taking_turns(&self, rows: usize) -> Option<&[String]> {
        ((2..=MOST_WORDS).contains(&self.seen.len()) && 2 * self.changes > rows).then_some(&self.seen)
    }
}

impl Column {
    /// A column without rows.
    pub fn new(heading: Heading) -> Column {
        Column {
            heading,
            values: vec![],
            stamps: 0,
            text_cells: 0,
            first_text: None,
            words: Words::default(),
        }
    }
}

/// All columns of a data file. [`crate::TimeColumn`] decides later which of them is the time.
#[derive(Clone, Debug)]
pub struct Table {
    /// The columns in the order of the file, all of the same length.
    pub columns: Vec<Column>,
    /// Number of each row in the file (for text files the line), counted from 1.
    pub row_numbers: Vec<usize>,
    /// Fields of a record that tell how to read the file: `separator: ';'`, `skip: 3`.
    pub record_fields: Vec<String>,
    /// The fraction of the file that was read, 1 for all of it.
    pub fraction_read: f64,
    /// Whether the file is text.
    pub is_text: bool,
    /// Sheets of the file that were not read and hold numbers.
    pub other_sheets: Vec<String>,
    /// What was done to read the file: columns without a name, channels with a rate of their own.
    pub notes: Vec<String>,
    /// The rates that the header of the file states.
    pub stated_rates: Vec<StatedRate>,
}

impl Default for Table {
    fn default() -> Self {
        Table {
            columns: vec![],
            row_numbers: vec![],
            record_fields: vec![],
            fraction_read: 1.0,
            is_text: true,
            other_sheets: vec![],
            notes: vec![],
            stated_rates: vec![],
        }
    }
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.row_numbers.len()
    }

    /// Adds a time column, in seconds, at `rate` rows per second. Returns its index.
    pub(crate) fn count_rows(&mut self, rate: f64) -> usize {
        let values = (0..self.rows()).map(|k| k as f64 / rate).collect();
        let heading = Heading { unit: Some("s".to_owned()), ..Heading::parse("row") };
        self.columns.push(Column { values, ..Column::new(heading) });
        self.columns.len() - 1
    }
}
