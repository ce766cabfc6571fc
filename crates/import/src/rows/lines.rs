//! Numbered lines of a data file, without comments, empty lines and the byte order mark. The comments of its
//! beginning are kept aside: they may hold the heading and the rate.

use super::comment::is_comment;
use super::encoding::{Decoded, is_utf16, is_utf32, text};
use super::line::{Line, LineError};
use crate::clock::is_stamp;
use crate::data_file::DataFile;
use crate::format::recognized;
use crate::refusal::{Refusal, Wanted};
use crate::sheet::Sheet;
use std::borrow::Cow;
use std::io::{self, BufRead, BufReader, Read};

/// Most bytes of a line; longer ones belong to no table.
const LONGEST: usize = 1 << 20;

/// Comments are kept as long as fewer lines with content were read, and so many of them at most.
const BEGINNING: usize = 100;
const MOST_COMMENTS: usize = 400;
/// Most bytes of a comment that is kept.
const LONGEST_COMMENT: usize = 1 << 16;

/// Reads the lines of a file in order.
pub(crate) struct Lines<'a> {
    input: Input<'a>,
    buffer: Vec<u8>,
    number: usize,
    /// The last byte of a line.
    end: u8,
    /// Number of lines at the start to skip.
    skip: usize,
    /// Bytes of the text so far, and of the whole file.
    read: u64,
    size: u64,
    /// Number of lines with content so far, and the comments between the first of them.
    contents: usize,
    comments: Vec<Line>,
}

enum Input<'a> {
    Text(BufReader<Decoded<'a>>),
    /// The rows of another format, and how many of them were read.
    Sheet(Box<Sheet>, usize),
}

impl<'a> Lines<'a> {
    /// The lines of a file after the first `skip`.
    pub(crate) fn of(
        mut file: DataFile<'a>,
        skip: usize,
        wanted: &Wanted<'_>,
    ) -> Result<Lines<'a>, LineError> {
        let size = file.size;
        let start = file.start().map_err(LineError::Io)?;
        let input = match recognized(&start) {
            Some(format) => Input::Sheet(Box::new(format.sheet(file, wanted)?), 0),
            None => {
                if let Some(sheet) = wanted.sheet() {
                    return Err(LineError::Format(Refusal::no_sheets(file.name, sheet)));
                }
                if is_utf32(&start) {
                    let help = "save it as UTF-8, in a text editor or by `iconv -f UTF-32 -t UTF-8`";
                    return Err(LineError::Format(Refusal::file("its text is encoded as UTF-32", help)));
                }
                let decoded = Decoded::new(file.bytes, is_utf16(&start)).map_err(LineError::Io)?;
                Input::Text(BufReader::with_capacity(1 << 16, decoded))
            }
        };
        // Programs of old Macintoshes, and some instruments, end lines by a carriage return alone.
        let has = |byte: u8| start.contains(&byte);
        let end = if has(b'\r') && !has(b'\n') { b'\r' } else { b'\n' };
        Ok(Lines {
            input,
            buffer: vec![],
            number: 0,
            end,
            skip,
            read: 0,
            size,
            contents: 0,
            comments: vec![],
        })
    }

    /// Starts again, after the first `skip` lines.
    pub(crate) fn restarted(self, skip: usize) -> io::Result<Lines<'a>> {
        let input = match self.input {
            Input::Text(text) => {
                Input::Text(BufReader::with_capacity(1 << 16, text.into_inner().restarted()?))
            }
            Input::Sheet(sheet, _) => Input::Sheet(sheet, 0),
        };
        Ok(Lines { input, number: 0, skip, read: 0, contents: 0, comments: vec![], ..self })
    }

    /// The table in the file, if that is no text.
    pub(crate) fn sheet(&self) -> Option<&Sheet> {
        match &self.input {
            Input::Text(_) => None,
            Input::Sheet(sheet, _) => Some(sheet),
        }
    }

    /// The fraction of the file that was read, from 0 to 1.
    pub(crate) fn fraction_read(&self) -> f64 {
        let (read, all) = match &self.input {
            Input::Text(_) => (self.read as f64, self.size as f64),
            Input::Sheet(sheet, read) => (*read as f64, sheet.lines() as f64),
        };
        (read / all.max(1.0)).clamp(0.0, 1.0)
    }

    /// The comments between the first lines of content, in order.
    pub(crate) fn comments(&self) -> &[Line] {
        &self.comments
    }

    /// Whether a comment in the file's beginning is kept.
    fn keeps(&self, bytes: usize) -> bool {
        self.contents < BEGINNING && self.comments.len() < MOST_COMMENTS && bytes <= LONGEST_COMMENT
    }

    /// The next line that is neither empty nor a comment.
    pub(crate) fn next(&mut self) -> Result<Option<Line>, LineError> {
        loop {
            let input = match &mut self.input {
                Input::Text(input) => input,
                Input::Sheet(sheet, read) => {
                    let Some(line) = sheet.line(*read) else { return Ok(None) };
                    *read += 1;
                    if line.number > 0 && line.number <= self.skip {
                        continue;
                    }
                    if line.number > 0 && is_comment(line.text.as_bytes()) {
                        if self.keeps(line.text.len()) {
                            self.comments.push(line);
                        }
                        continue;
                    }
                    self.contents += 1;
                    return Ok(Some(line));
                }
            };
            self.buffer.clear();
            let mut limited = Read::take(&mut *input, LONGEST as u64);
            if limited.read_until(self.end, &mut self.buffer).map_err(LineError::Io)? == 0 {
                let whole = input.get_ref().taken() == self.size;
                return if whole { Ok(None) } else { Err(LineError::Changed) };
            }
            self.number += 1;
            self.read = input.get_ref().taken();
            if self.number == 1 && self.buffer.starts_with(b"\xEF\xBB\xBF") {
                self.buffer.drain(..3);
            }
            if self.number <= self.skip {
                continue;
            }
            let ended = self.buffer.last() == Some(&self.end);
            if !ended && self.buffer.len() == LONGEST {
                return Err(LineError::TooLong(self.number));
            }
            while matches!(self.buffer.last(), Some(b'\n' | b'\r')) {
                self.buffer.pop();
            }
            if self.buffer.trim_ascii_start().is_empty() {
                continue;
            }
            if is_comment(&self.buffer) {
                if self.keeps(self.buffer.len()) {
                    let text = text(&self.buffer).replace('\0', " ");
                    self.comments.push(Line { text, number: self.number, ended });
                }
                continue;
            }
            if let Some(zero) = self.buffer.iter().position(|b| *b == 0) {
                return Err(LineError::NotText(text(&self.buffer[..zero]).into_owned(), self.number));
            }
            let text = monitored(text(&self.buffer)).into_owned();
            self.contents += 1;
            return Ok(Some(Line { text, number: self.number, ended }));
        }
    }
}

/// A line of a serial monitor, `12:03:41.117 -> 712,500` or `... > 712,500`, with the separator of its numbers in the
/// place of the arrow. What a microcontroller prints has decimal points.
fn monitored(line: Cow<'_, str>) -> Cow<'_, str> {
    let parts = [" -> ", " > "].iter().find_map(|arrow| Some((line.split_once(arrow)?, arrow.len())));
    let Some(((stamp, rest), length)) = parts.filter(|((stamp, _), _)| is_stamp(stamp.trim())) else {
        return line;
    };
    let separator = [";", "\t", ","].into_iter().find(|mark| rest.contains(*mark)).unwrap_or(" ");
    Cow::Owned(format!("{stamp}{separator}{}{rest}", " ".repeat(length - separator.len())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_monitor_puts_a_stamp_before_each_line() {
        for (line, due) in [
            ("12:03:41.117 -> 712,500", "12:03:41.117,   712,500"),
            ("12:03:41.117 > 8;-6", "12:03:41.117;  8;-6"),
            ("12:03:41.117 -> 8 6", "12:03:41.117    8 6"),
            ("a -> 7,5", "a -> 7,5"),
        ] {
            assert_eq!(monitored(line.into()), due);
        }
    }
}
