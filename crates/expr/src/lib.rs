//! TODO
mod span;
pub use span::Span;
