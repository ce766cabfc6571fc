//! Text as UTF-8: UTF-16 is decoded as it is read, Windows-1252 line by line.

use crate::data_file::ReadSeek;
use encoding_rs::{CoderResult, Decoder, Encoding, UTF_16BE, UTF_16LE, WINDOWS_1252};
use std::borrow::Cow;
use std::io::{self, Read, SeekFrom};

/// Which kind of UTF-16 a text is that begins with these bytes: by its byte order mark, or because every
/// second byte of its first two characters is zero.
pub(crate) fn is_utf16(start: &[u8]) -> Option<&'static Encoding> {
    match start {
        [0xFF, 0xFE, ..] => Some(UTF_16LE),
        [0xFE, 0xFF, ..] => Some(UTF_16BE),
        [1..=255, 0, 1..=255, 0, ..] => Some(UTF_16LE),
        [0, 1..=255, 0, 1..=255, ..] => Some(UTF_16BE),
        _ => None,
    }
}

/// Whether a text is UTF-32: by its byte order mark, or because three of the first four bytes are zero.
pub(crate) fn is_utf32(start: &[u8]) -> bool {
    matches!(
        start,
        [0xFF, 0xFE, 0, 0, ..] | [0, 0, 0xFE, 0xFF, ..] | [1..=255, 0, 0, 0, ..] | [0, 0, 0, 1..=255, ..]
    )
}

/// The text of a line: UTF-8, or Windows-1252 where it is not.
pub(crate) fn text(bytes: &[u8]) -> Cow<'_, str> {
    std::str::from_utf8(bytes)
        .map_or_else(|_| WINDOWS_1252.decode_without_bom_handling(bytes).0, Cow::Borrowed)
}

/// The bytes of a file, decoded if they are UTF-16.
pub(crate) struct Decoded<'a> {
    bytes: Box<dyn ReadSeek + 'a>,
    /// Bytes that were taken from the file.
    taken: u64,
    utf16: Option<Utf16>,
}

/// A decoder and the bytes that it has not seen.
struct Utf16 {
    encoding: &'static Encoding,
    decoder: Decoder,
    pending: Vec<u8>,
    at: usize,
    done: bool,
    /// What was decoded and not yet handed on.
    ready: String,
    handed: usize,
}

impl Utf16 {
    fn new(encoding: &'static Encoding) -> Utf16 {
        let decoder = encoding.new_decoder_with_bom_removal();
        let ready = String::with_capacity(1 << 16);
        Utf16 { encoding, decoder, pending: vec![], at: 0, done: false, ready, handed: 0 }
    }
}

impl<'a> Decoded<'a> {
    /// The file from its start.
    pub(crate) fn new(
        mut bytes: Box<dyn ReadSeek + 'a>,
        utf16: Option<&'static Encoding>,
    ) -> io::Result<Decoded<'a>> {
        bytes.seek(SeekFrom::Start(0))?;
        Ok(Decoded { bytes, taken: 0, utf16: utf16.map(Utf16::new) })
    }

    /// The same from its start again.
    pub(crate) fn restarted(self) -> io::Result<Decoded<'a>> {
        Decoded::new(self.bytes, self.utf16.map(|utf16| utf16.encoding))
    }

    /// Bytes that were taken from the file so far.
    pub(crate) fn taken(&self) -> u64 {
        self.taken
    }
}

impl Read for Decoded<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let Some(utf16) = &mut self.utf16 else {
            let count = self.bytes.read(out)?;
            self.taken += count as u64;
            return Ok(count);
        };
        while utf16.handed == utf16.ready.len() && !utf16.done {
            if utf16.at == utf16.pending.len() {
                utf16.pending.resize(1 << 16, 0);
                let count = self.bytes.read(&mut utf16.pending)?;
                utf16.pending.truncate(count);
                utf16.at = 0;
                self.taken += count as u64;
            }
            let last = utf16.pending.is_empty();
            utf16.ready.clear();
            utf16.handed = 0;
            let (result, read, _) =
                utf16.decoder.decode_to_string(&utf16.pending[utf16.at..], &mut utf16.ready, last);
            utf16.at += read;
            utf16.done = last && result == CoderResult::InputEmpty;
        }
        let ready = &utf16.ready.as_bytes()[utf16.handed..];
        let count = ready.len().min(out.len());
        out[..count].copy_from_slice(&ready[..count]);
        utf16.handed += count;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn utf_16_is_decoded_across_the_ends_of_buffers() {
        let plain: String = (0..50_000).map(|k| format!("{k};µ€😀\n")).collect();
        for (encoding, little, mark) in
            [(UTF_16LE, true, true), (UTF_16BE, false, true), (UTF_16LE, true, false)]
        {
            let marked = if mark { format!("\u{feff}{plain}") } else { plain.clone() };
            let bytes: Vec<u8> = marked
                .encode_utf16()
                .flat_map(|u| if little { u.to_le_bytes() } else { u.to_be_bytes() })
                .collect();
            assert_eq!(is_utf16(&bytes), Some(encoding));
            let mut decoded = Decoded::new(Box::new(Cursor::new(&bytes)), Some(encoding)).expect("in memory");
            let mut read = String::new();
            decoded.read_to_string(&mut read).expect("text");
            assert_eq!((read == plain, decoded.taken()), (true, bytes.len() as u64));
        }
    }

    #[test]
    fn other_bytes_are_windows_1252() {
        assert_eq!(text(b"Kraft \xb5N \x80"), "Kraft µN €");
        assert_eq!(text("Kraft µN".as_bytes()), "Kraft µN");
    }
}
