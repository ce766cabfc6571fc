//! Places in a text.

use std::ops::Range;

/// A half-open byte range `start..end` in a text.
///
/// ```
/// use phisindy_expr::Span;
/// let span = Span::new(4, 7);
/// assert_eq!(&"ln(  y )"[span.range()], " y ");
/// assert_eq!(span.shifted(10), Span::new(14, 17));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Span {
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Span {
    /// The range `start..end`.
    pub fn new(start: usize, end: usize) -> Self {
        Span { start, end }
    }

    /// The same range as a type of `std`, for slices.
    pub fn range(self) -> Range<usize> {
        self.start..self.end
    }

    /// The smallest range that contains both.
    pub fn to(self, other: Span) -> Span {
        Span::new(self.start.min(other.start), self.end.max(other.end))
    }

    /// The range moved right by `offset` bytes: from a part of a text to the whole text.
    pub fn shifted(self, offset: usize) -> Span {
        Span::new(self.start + offset, self.end + offset)
    }
}
