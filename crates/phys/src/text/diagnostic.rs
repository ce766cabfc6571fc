//! What is wrong with an input, as data: a message, the places it is about, and what to do. Drawing is the program's job.

use phisindy_expr::Span;

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The input can be used all the same.
    Warning,
    /// The input cannot be used.
    Error,
}

/// One text that diagnostics point into: a spec, a law, or the offending line of a data file.
#[derive(Clone, Debug)]
pub struct Source {
    /// The name shown to the user (a path as it was given).
    pub name: String,
    /// The text that spans point into.
    pub text: String,
    /// Line number of the text's first line, counted from 1 (an excerpt of a data file starts later).
    pub first_line: usize,
}

/// Index of a [`Source`] in [`Sources`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SourceId(pub usize);

/// All texts that were read, so that a diagnostic can show the place.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    /// In the order in which they were read.
    pub files: Vec<Source>,
}

impl Sources {
    /// Keeps a whole text.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<String>) -> SourceId {
        self.add_excerpt(name, text, 1)
    }

    /// Keeps a part of a file that starts at line `first_line`.
    pub fn add_excerpt(
        &mut self,
        name: impl Into<String>,
        text: impl Into<String>,
        first_line: usize,
    ) -> SourceId {
        self.files.push(Source { name: name.into(), text: text.into(), first_line });
        SourceId(self.files.len() - 1)
    }

    /// The source behind an id that this collection gave.
    ///
    /// # Panics
    /// If the id comes from another collection.
    pub fn get(&self, id: SourceId) -> &Source {
        &self.files[id.0]
    }
}

/// A place a diagnostic is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Label {
    /// Which text.
    pub source: SourceId,
    /// Which bytes of it.
    pub span: Span,
    /// A few words shown at the place; may be empty.
    pub message: String,
    /// Whether this is the place of the mistake (true) or a place that explains it (false).
    pub primary: bool,
}

/// One mistake or warning: what, where, what to do.
///
/// ```
/// use phisindy_expr::Span;
/// use phisindy_phys::{Diagnostic, Sources};
/// let mut sources = Sources::default();
/// let spec = sources.add("case.ron", "(known: { \"x\": \"yy\" })");
/// let d = Diagnostic::error("unknown name `yy`").at(spec, Span::new(15, 17), "not a state").help("did you mean `y`?");
/// assert_eq!(d.labels.len(), 1);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// One sentence: what is wrong.
    pub message: String,
    /// Places, the primary one first.
    pub labels: Vec<Label>,
    /// What to do.
    pub help: Vec<String>,
}

impl Diagnostic {
    /// An error without a place yet.
    pub fn error(message: impl Into<String>) -> Self {
        Diagnostic { severity: Severity::Error, message: message.into(), labels: vec![], help: vec![] }
    }

    /// A warning without a place yet.
    pub fn warning(message: impl Into<String>) -> Self {
        Diagnostic { severity: Severity::Warning, ..Diagnostic::error(message) }
    }

    /// Adds the place of the mistake.
    pub fn at(mut self, source: SourceId, span: Span, message: impl Into<String>) -> Self {
        self.labels.push(Label { source, span, message: message.into(), primary: true });
        self
    }

    /// Adds a place that explains the mistake.
    pub fn also(mut self, source: SourceId, span: Span, message: impl Into<String>) -> Self {
        self.labels.push(Label { source, span, message: message.into(), primary: false });
        self
    }

    /// Adds a line that says what to do.
    pub fn help(mut self, line: impl Into<String>) -> Self {
        self.help.push(line.into());
        self
    }

    /// Whether it is an error.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}
