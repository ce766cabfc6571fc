//! Why a readable file makes no spec.

use phisindy_expr::Span;
use phisindy_phys::{Diagnostic, SourceId};

/// Why a readable file makes no spec.
#[derive(Debug)]
pub struct Trouble {
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: String,
    /// The mistake in a column that is needed.
    pub mistake: Option<Box<Diagnostic>>,
}

impl Trouble {
    /// As a mistake in the file `name`, which the user named at a place.
    pub fn diagnostic(self, name: &str, (source, at): (SourceId, Span)) -> Box<Diagnostic> {
        let plain = || {
            Diagnostic::error(format!("`{name}`: {}", self.message))
                .at(source, at, "this file")
                .help(&self.help)
        };
        self.mistake.unwrap_or_else(|| Box::new(plain()))
    }
}
