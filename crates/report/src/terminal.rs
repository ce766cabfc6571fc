//! Results for people at a terminal: equations in Unicode, numbers with the digits that their errors allow,
//! colours, a small plot. Pipes get LaTeX or text as other forms of the result.

pub(crate) mod braille;
mod look;
pub(crate) mod unicode;

pub(crate) use look::Ink;
pub use look::Look;
