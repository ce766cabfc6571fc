//! A cell of a table, and its text: a number is the shortest text that reads back as it.

use std::fmt::Write;

/// Between the cells of a row.
pub(crate) const SEPARATOR: char = '\t';

/// A cell.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cell {
    /// Nothing stands there.
    Empty,
    /// A number.
    Number(f64),
    /// Anything else: words, a time of day.
    Word(Box<str>),
}

/// Adds a cell to the text of a row.
pub(crate) fn push(text: &mut String, cell: &Cell) {
    if !text.is_empty() {
        text.push(SEPARATOR);
    }
    match cell {
        // Something stands even at the end of a line, where a separator alone adds no field.
        Cell::Empty => text.push_str("\"\""),
        Cell::Number(x) => push_number(text, *x),
        Cell::Word(word) => push_word(text, word),
    }
}

/// Adds a number as the shortest text that reads back as it.
pub(crate) fn push_number(text: &mut String, x: f64) {
    // Writing to a string does not fail.
    let _ = write!(text, "{x:?}");
}

/// Adds words, without what would end their cell.
pub(crate) fn push_word(text: &mut String, word: &str) {
    let word = word.trim();
    if word.is_empty() {
        text.push_str("\"\"");
    }
    text.extend(word.chars().map(|c| match c {
        '"' => '\'',
        c if c.is_control() => ' ',
        c => c,
    }));
}
