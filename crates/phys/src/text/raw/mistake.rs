//! Why a text is no RON.

use crate::text::diagnostic::{Diagnostic, SourceId};
use phisindy_expr::Span;

/// Why a text is no RON.
#[derive(Clone, Debug)]
pub(crate) struct Mistake {
    pub(crate) message: String,
    pub(crate) span: Span,
    label: String,
    /// Boxed to keep results small.
    other: Option<Box<(Span, String)>>,
    pub(super) help: Option<String>,
}

impl Mistake {
    pub(super) fn new(message: impl Into<String>, span: Span, label: impl Into<String>) -> Self {
        Mistake { message: message.into(), span, label: label.into(), other: None, help: None }
    }

    pub(super) fn also(mut self, span: Span, label: impl Into<String>) -> Self {
        self.other = Some(Box::new((span, label.into())));
        self
    }

    pub(super) fn help(mut self, line: impl Into<String>) -> Self {
        self.help = Some(line.into());
        self
    }

    /// The same, for the user.
    pub(crate) fn diagnostic(self, source: SourceId) -> Diagnostic {
        let mut diagnostic = Diagnostic::error(self.message).at(source, self.span, self.label);
        if let Some(other) = self.other {
            diagnostic = diagnostic.also(source, other.0, other.1);
        }
        diagnostic.help.extend(self.help);
        diagnostic
    }
}
