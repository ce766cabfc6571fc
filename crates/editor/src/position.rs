//! Bytes of a text as an editor counts them: lines, and in a line units of UTF-16.

use lsp_types::{Position, Range};
use phisindy_expr::Span;

/// The position of a byte, moved to the beginning of its character.
pub(crate) fn position(text: &str, byte: usize) -> Position {
    let at = (0..=byte.min(text.len())).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
    let before = &text[..at];
    let line = before.rfind('\n').map_or(0, |end| end + 1);
    Position::new(before.matches('\n').count() as u32, before[line..].encode_utf16().count() as u32)
}

/// The same of both ends.
pub(crate) fn range(text: &str, span: Span) -> Range {
    Range::new(position(text, span.start), position(text, span.end))
}

/// The byte at a position; beyond the end of a line its end.
pub(crate) fn byte(text: &str, position: Position) -> usize {
    let start: usize = text.split_inclusive('\n').take(position.line as usize).map(str::len).sum();
    let line = text[start..].split(['\n', '\r']).next().unwrap_or("");
    let mut units = 0;
    let passed = line.chars().take_while(|c| {
        units += c.len_utf16();
        units <= position.character as usize
    });
    start + passed.map(char::len_utf8).sum::<usize>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_count_units_of_utf_16() {
        let text = "aé😀b\r\nc";
        for (at, line, character) in
            [(0, 0, 0), (1, 0, 1), (3, 0, 2), (7, 0, 4), (8, 0, 5), (10, 1, 0), (11, 1, 1)]
        {
            assert_eq!(position(text, at), Position::new(line, character), "{at}");
            assert_eq!(byte(text, Position::new(line, character)), at, "{at}");
        }
        assert_eq!((position(text, 5), byte(text, Position::new(0, 99))), (Position::new(0, 2), 8));
        assert_eq!(byte(text, Position::new(7, 0)), text.len());
    }
}
