//! What is wrong with an input, as data: a message, the places it is about, and what to do. Drawing is the
//! program's job.

use phisindy_expr::Span;
use std::fmt;

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

impl Source {
    /// Line and column of a byte, counted from 1; columns are characters.
    pub fn line_and_column(&self, byte: usize) -> (usize, usize) {
        let mut at = byte.min(self.text.len());
        while !self.text.is_char_boundary(at) {
            at -= 1;
        }
        let before = &self.text[..at];
        let line = before.rfind('\n').map_or(0, |end| end + 1);
        (self.first_line + before.matches('\n').count(), before[line..].chars().count() + 1)
    }
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

    /// The diagnostic in plain text with the place of the mistake: name, line and column, counted from 1 in
    /// characters.
    ///
    /// ```
    /// use phisindy_phys::{Sources, spec};
    /// let mut sources = Sources::default();
    /// let text = "(\n    staates: {},\n)";
    /// let source = sources.add("case", text);
    /// let mistakes = spec::read(text, source).unwrap_err();
    /// let shown = mistakes[0].located(&sources).to_string();
    /// assert!(shown.starts_with("error: unknown field of the spec `staates`\n  at case:2:5"), "{shown}");
    /// assert!(shown.contains("\n  help: did you mean `states`?"), "{shown}");
    /// ```
    pub fn located<'a>(&'a self, sources: &'a Sources) -> Located<'a> {
        Located { diagnostic: self, sources }
    }
}

/// Message and help without places, which need the texts: [`Diagnostic::located`].
impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.severity, self.message)?;
        self.help.iter().try_for_each(|line| write!(f, "\n  help: {line}"))
    }
}

impl std::error::Error for Diagnostic {}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Severity::Warning => "warning",
            Severity::Error => "error",
        })
    }
}

/// A diagnostic with the texts that it points into; its `Display` is plain text.
#[derive(Clone, Copy, Debug)]
pub struct Located<'a> {
    diagnostic: &'a Diagnostic,
    sources: &'a Sources,
}

impl fmt::Display for Located<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Diagnostic { severity, message, labels, help } = self.diagnostic;
        write!(f, "{severity}: {message}")?;
        for label in labels {
            // A label of other texts has no place here.
            let Some(source) = self.sources.files.get(label.source.0) else { continue };
            let (line, column) = source.line_and_column(label.span.start);
            write!(f, "\n  at {}:{line}:{column}", source.name)?;
            if !label.message.is_empty() {
                write!(f, " ({})", label.message)?;
            }
        }
        help.iter().try_for_each(|line| write!(f, "\n  help: {line}"))
    }
}
