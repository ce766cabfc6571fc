//! Numbered lines of a text file, without comments, empty lines and the byte order mark.

use crate::data_file::{DataFile, ReadSeek};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};

/// Most bytes of a line; longer ones belong to no table.
const LONGEST: usize = 1 << 20;

/// A line with content.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    /// The text without line end.
    pub(crate) text: String,
    /// Its number, counted from 1.
    pub(crate) number: usize,
    /// Whether a line end follows; it may be missing at the end of a file.
    pub(crate) ended: bool,
}

/// Why a line cannot be read.
#[derive(Debug)]
pub(crate) enum LineError {
    /// Reading failed.
    Io(io::Error),
    /// Not UTF-8: the valid text before, and the number of the line.
    NotText(String, usize),
    /// UTF-16, which some spreadsheets write.
    Utf16,
    /// The line with this number is too long.
    TooLong(usize),
    /// The file has more or fewer bytes than when it was opened.
    Changed,
}

/// Reads the lines of a file in order.
pub(crate) struct Lines<'a> {
    input: BufReader<Box<dyn ReadSeek + 'a>>,
    buffer: Vec<u8>,
    number: usize,
    /// Number of lines at the start to skip.
    skip: usize,
    /// Bytes read so far, and of the whole file.
    read: u64,
    size: u64,
}

impl<'a> Lines<'a> {
    /// The lines of a file after the first `skip`.
    pub(crate) fn of(file: DataFile<'a>, skip: usize) -> Lines<'a> {
        let input = BufReader::with_capacity(1 << 16, file.bytes);
        Lines { input, buffer: vec![], number: 0, skip, read: 0, size: file.size }
    }

    /// Starts again, after the first `skip` lines.
    pub(crate) fn restarted(mut self, skip: usize) -> io::Result<Lines<'a>> {
        self.input.seek(SeekFrom::Start(0))?;
        Ok(Lines { number: 0, skip, read: 0, ..self })
    }

    /// The fraction of the file that was read, from 0 to 1.
    pub(crate) fn fraction_read(&self) -> f64 {
        (self.read as f64 / self.size.max(1) as f64).clamp(0.0, 1.0)
    }

    /// The next line that is neither empty nor a comment.
    pub(crate) fn next(&mut self) -> Result<Option<Line>, LineError> {
        loop {
            self.buffer.clear();
            let mut limited = Read::take(&mut self.input, LONGEST as u64);
            if limited.read_until(b'\n', &mut self.buffer).map_err(LineError::Io)? == 0 {
                return if self.read == self.size { Ok(None) } else { Err(LineError::Changed) };
            }
            self.number += 1;
            self.read += self.buffer.len() as u64;
            if self.number == 1 {
                if self.buffer.starts_with(&[0xFF, 0xFE]) || self.buffer.starts_with(&[0xFE, 0xFF]) {
                    return Err(LineError::Utf16);
                }
                if self.buffer.starts_with(b"\xEF\xBB\xBF") {
                    self.buffer.drain(..3);
                }
            }
            if self.number <= self.skip {
                continue;
            }
            let ended = self.buffer.last() == Some(&b'\n');
            if !ended && self.buffer.len() == LONGEST {
                return Err(LineError::TooLong(self.number));
            }
            while matches!(self.buffer.last(), Some(b'\n' | b'\r')) {
                self.buffer.pop();
            }
            let first = self.buffer.iter().find(|b| !b.is_ascii_whitespace());
            if matches!(first, None | Some(b'#' | b'%')) {
                continue;
            }
            return match std::str::from_utf8(&self.buffer) {
                Ok(text) if !text.contains('\0') => {
                    Ok(Some(Line { text: text.to_owned(), number: self.number, ended }))
                }
                Ok(text) => {
                    Err(LineError::NotText(text.split('\0').next().unwrap_or("").to_owned(), self.number))
                }
                Err(e) => {
                    let good = String::from_utf8_lossy(&self.buffer[..e.valid_up_to()]).into_owned();
                    Err(LineError::NotText(good, self.number))
                }
            };
        }
    }
}
