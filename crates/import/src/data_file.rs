//! A data file as the caller opened it.

use std::io::{Cursor, Read, Seek};

/// Bytes that can be read more than once, such as a file or a slice in memory.
pub trait ReadSeek: Read + Seek {}

impl<T: Read + Seek> ReadSeek for T {}

/// The bytes of a data file, and what the user calls it.
pub struct DataFile<'a> {
    /// Shown in messages.
    pub(crate) name: &'a str,
    pub(crate) bytes: Box<dyn ReadSeek + 'a>,
    /// How many bytes there were when it was opened.
    pub(crate) size: u64,
}

impl<'a> DataFile<'a> {
    /// A file that holds `size` bytes, at its start; `name` is shown in messages.
    pub fn new(name: &'a str, bytes: impl ReadSeek + 'a, size: u64) -> DataFile<'a> {
        DataFile { name, bytes: Box::new(bytes), size }
    }

    /// A file in memory.
    pub fn of_bytes(name: &'a str, bytes: &'a [u8]) -> DataFile<'a> {
        DataFile::new(name, Cursor::new(bytes), bytes.len() as u64)
    }
}
