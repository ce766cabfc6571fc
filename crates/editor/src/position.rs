//! Bytes of a text as an editor counts them: lines, and in a line units of UTF-16.

use lsp_types::{Position, Range};
use phisindy_expr::Span;

/// Where the lines of a text begin: many positions are found in one.
pub(crate) struct Lines<'t> {
    text: &'t str,
    starts: Vec<usize>,
}

impl<'t> Lines<'t> {
    pub(crate) fn new(text: &'t str) -> Lines<'t> {
        let ends = text.match_indices('\n').map(|(at, _)| at + 1);
        Lines { text, starts: std::iter::once(0).chain(ends).collect() }
    }

    /// The position of a byte, moved to the beginning of its character.
    fn position(&self, byte: usize) -> Position {
        let at =
            (0..=byte.min(self.text.len())).rev().find(|at| self.text.is_char_boundary(*at)).unwrap_or(0);
        let line = self.starts.partition_point(|start| *start <= at) - 1;
        let column = self.text[self.starts[line]..at].encode_utf16().count();
        Position::new(line as u32, column as u32)
    }

    /// The same of both ends.
    pub(crate) fn range(&self, span: Span) -> Range {
        Range::new(self.position(span.start), self.position(span.end))
    }
}

/// The positions of both ends of a span.
pub(crate) fn range(text: &str, span: Span) -> Range {
    Lines::new(text).range(span)
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
            assert_eq!(Lines::new(text).position(at), Position::new(line, character), "{at}");
            assert_eq!(byte(text, Position::new(line, character)), at, "{at}");
        }
        assert_eq!(
            (Lines::new(text).position(5), byte(text, Position::new(0, 99))),
            (Position::new(0, 2), 8)
        );
        assert_eq!(byte(text, Position::new(7, 0)), text.len());
    }
}
