//! What a reader of any format delivers: the columns of a file as numbers, with their headings and units.

use crate::headings::Heading;
use phisindy_phys::Diagnostic;

/// A column of a file.
#[derive(Clone, Debug)]
pub struct Column {
    /// Its name and unit.
    pub heading: Heading,
    /// One number for each row, in the unit of the heading; NaN where there is none.
    pub values: Vec<f64>,
    /// Number of cells that hold text.
    pub text_cells: usize,
    /// The first of these cells, as a mistake.
    pub first_text: Option<Diagnostic>,
}

impl Column {
    /// A column without rows.
    pub fn new(heading: Heading) -> Column {
        Column { heading, values: vec![], text_cells: 0, first_text: None }
    }
}

/// What a file holds. Which column is time is decided later, from the headings and the numbers ([`crate::TimeColumn`]).
#[derive(Clone, Debug)]
pub struct Table {
    /// In the order of the file, all of the same length.
    pub columns: Vec<Column>,
    /// Where each row stands in the file: a line or row number, counted from 1.
    pub row_numbers: Vec<usize>,
    /// How a spec says that the file is to be read, as fields of a record: `separator: ';'`, `skip: 3`.
    pub reading: Vec<String>,
    /// The part of the file that was read, 1 for all.
    pub part: f64,
}

impl Table {
    /// Number of rows that were read.
    pub fn rows(&self) -> usize {
        self.row_numbers.len()
    }

    /// One more column, for a file without time: what the time would be at `rate` rows per second. Returns its index.
    pub(crate) fn count_rows(&mut self, rate: f64) -> usize {
        let values = (0..self.rows()).map(|k| k as f64 / rate).collect();
        let heading = Heading { unit: Some("s".to_owned()), ..Heading::parse("row") };
        self.columns.push(Column { values, ..Column::new(heading) });
        self.columns.len() - 1
    }
}
