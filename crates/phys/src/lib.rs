//! TODO
mod diagnostic;
pub use diagnostic::{Diagnostic, Label, Severity, Source, SourceId, Sources};
