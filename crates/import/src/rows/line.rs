//! A line of a data file, and why one cannot be read.

use crate::refusal::Refusal;
use std::io;

/// A line with content.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    /// The text without line end.
    pub(crate) text: String,
    /// Its number, counted from 1; 0 for headings that are no row of the file.
    pub(crate) number: usize,
    /// Whether a line end follows; it may be missing at the end of a file.
    pub(crate) ended: bool,
}

/// Why a line cannot be read.
#[derive(Debug)]
pub(crate) enum LineError {
    /// Reading failed.
    Io(io::Error),
    /// The format is not read, or the file breaks its rules.
    Format(Refusal),
    /// No text: what stands before, and the number of the line.
    NotText(String, usize),
    /// The line with this number is too long.
    TooLong(usize),
    /// The file has more or fewer bytes than when it was opened.
    Changed,
}

impl LineError {
    /// Whether the name of a sheet is to blame.
    pub(crate) fn is_of_sheet(&self) -> bool {
        matches!(self, LineError::Format(refusal) if refusal.of_sheet)
    }
}
