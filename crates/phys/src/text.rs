//! What a spec says: its text read field by field, edited without loss of comments, and mistakes that point
//! into it.
//!
//! ```text
//! text --raw--> nodes with spans --spec--> Spec (every field with its place)
//!                        |                       +--> Diagnostic (message, labels, help)
//!                        +--splice--> text with one value changed
//!                        +--format--> text with its white space in order
//! ```

pub(crate) mod diagnostic;
pub mod fields;
pub(crate) mod files;
pub(crate) mod format;
pub(crate) mod raw;
pub mod spec;
pub mod splice;
