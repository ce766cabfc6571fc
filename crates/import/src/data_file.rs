//! The bytes of a data file, which the caller opened.

use phisindy_expr::Span;
use phisindy_phys::{Diagnostic, SourceId};
use std::io::{self, Cursor, Read, Seek, SeekFrom};

/// Bytes at the start of a file that tell its format: HDF5 may begin after 512 bytes of another program.
const START: u64 = 1024;
/// Most bytes of a file that is read as a whole: it is held in memory beside its numbers.
const MOST_BYTES: u64 = 2 << 30;

/// Seekable bytes, such as a file or a slice in memory.
pub trait ReadSeek: Read + Seek {}

impl<T: Read + Seek> ReadSeek for T {}

/// The bytes of a data file, and the name that messages use.
pub struct DataFile<'a> {
    /// Shown in messages.
    pub(crate) name: &'a str,
    pub(crate) bytes: Box<dyn ReadSeek + 'a>,
    /// Number of bytes when it was opened.
    pub(crate) size: u64,
}

impl<'a> DataFile<'a> {
    /// A file of `size` bytes, positioned at its start; messages call it `name`.
    pub fn new(name: &'a str, bytes: impl ReadSeek + 'a, size: u64) -> DataFile<'a> {
        DataFile { name, bytes: Box::new(bytes), size }
    }

    /// A file in memory.
    pub fn of_bytes(name: &'a str, bytes: &'a [u8]) -> DataFile<'a> {
        DataFile::new(name, Cursor::new(bytes), bytes.len() as u64)
    }

    /// The first bytes.
    pub(crate) fn start(&mut self) -> io::Result<Vec<u8>> {
        self.part(START)
    }

    /// All bytes; none of a file that is too large.
    pub(crate) fn whole(&mut self) -> io::Result<Option<Vec<u8>>> {
        let bytes = self.part(MOST_BYTES + 1)?;
        Ok((bytes.len() as u64 <= MOST_BYTES).then_some(bytes))
    }

    fn part(&mut self, most: u64) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.bytes.seek(SeekFrom::Start(0))?;
        (&mut self.bytes).take(most).read_to_end(&mut bytes)?;
        Ok(bytes)
    }
}

/// The diagnostic for a file that cannot be opened or read; `at` is where the user named it.
pub fn unreadable(name: &str, (source, at): (SourceId, Span), error: &io::Error) -> Diagnostic {
    let help = match error.kind() {
        io::ErrorKind::IsADirectory => "name a file in it",
        io::ErrorKind::InvalidInput => "save the data in a file first",
        io::ErrorKind::PermissionDenied => "give yourself the right to read it (chmod u+r), or copy it",
        io::ErrorKind::NotFound => "check its name and its folder",
        _ => "copy the file to a disk that can be read",
    };
    Diagnostic::error(format!("cannot read `{name}`: {error}")).at(source, at, "asked for here").help(help)
}
