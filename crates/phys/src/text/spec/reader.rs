//! Reads the outline of a RON text into values and collects what is wrong on the way.

use crate::text::diagnostic::{Diagnostic, SourceId};
use crate::text::files::Files;
use crate::text::raw::{Node, Shape, comma_advice};
use phisindy_expr::{Span, nearest};

/// More mistakes than these help nobody.
const MOST: usize = 100;

/// Reads nodes of one text. Each method gives None after it has noted why.
pub(crate) struct Reader<'t> {
    pub(crate) text: &'t str,
    pub(crate) source: SourceId,
    pub(crate) found: Vec<Diagnostic>,
    /// The files that the text names; none: what stands in them is not read.
    pub(crate) files: Option<Files>,
}

impl<'t> Reader<'t> {
    pub(crate) fn new(text: &'t str, source: SourceId, files: Option<&Files>) -> Self {
        Reader { text, source, found: Vec::new(), files: files.cloned() }
    }

    pub(crate) fn slice(&self, span: Span) -> &'t str {
        &self.text[span.range()]
    }

    /// Notes a mistake.
    pub(crate) fn note(&mut self, diagnostic: Diagnostic) {
        if self.found.len() < MOST {
            self.found.push(diagnostic);
        }
    }

    /// Notes a mistake at one place, with what to do about it.
    pub(crate) fn wrong<T>(
        &mut self,
        span: Span,
        message: impl Into<String>,
        label: &str,
        help: &str,
    ) -> Option<T> {
        let mut diagnostic = Diagnostic::error(message).at(self.source, span, label);
        if !help.is_empty() {
            diagnostic = diagnostic.help(help);
        }
        self.note(diagnostic);
        None
    }

    /// Notes that something else should stand there.
    pub(crate) fn expected<T>(&mut self, node: &Node, what: &str, help: &str) -> Option<T> {
        let found = match (node.shape, node.name) {
            (Shape::Number, _) => "a number".into(),
            (Shape::Text, _) => "a text".into(),
            (Shape::Char, _) => "a character".into(),
            (Shape::Name, _) => format!("the name `{}`", self.slice(node.span)),
            (Shape::List, _) => "a list `[...]`".into(),
            (Shape::Map, _) => "a map `{...}`".into(),
            (Shape::Group, Some(name)) => format!("`{}(...)`", self.slice(name)),
            (Shape::Group, None) => "a group `(...)`".into(),
        };
        let comma = (node.shape == Shape::Group).then(|| comma_advice(self.slice(node.span))).flatten();
        let help = comma.as_deref().unwrap_or(help);
        self.wrong(node.span, format!("expected {what}, found {found}"), &format!("should be {what}"), help)
    }

    /// Notes that a name is none of those that may stand there.
    pub(crate) fn unknown_name<T>(&mut self, what: &str, span: Span, allowed: &[&str]) -> Option<T> {
        let name = self.slice(span);
        let hint = match nearest(name, allowed.iter().copied()) {
            Some(near) => format!("did you mean `{near}`? allowed: {}", allowed.join(", ")),
            None => format!("allowed: {}", allowed.join(", ")),
        };
        self.wrong(span, format!("unknown {what} `{name}`"), &format!("not a {what}"), &hint)
    }

    /// What a variant like `Relative(0.1)` holds.
    pub(crate) fn argument<'n>(&mut self, node: &'n Node, what: &str) -> Option<&'n Node> {
        match node.entries.as_slice() {
            [entry] if entry.key.is_none() => Some(&entry.value),
            _ => {
                let message = format!("`{}` takes {what}", self.variant(node).unwrap_or(""));
                self.wrong(node.span, message, &format!("should hold {what}"), "")
            }
        }
    }

    /// The name of a variant, with or without content.
    pub(crate) fn variant(&self, node: &Node) -> Option<&'t str> {
        match node.shape {
            Shape::Name => Some(self.slice(node.span)),
            Shape::Group => node.name.map(|name| self.slice(name)),
            _ => None,
        }
    }

    /// One of a few names.
    pub(crate) fn choice<T: Copy>(&mut self, node: &Node, what: &str, table: &[(&str, T)]) -> Option<T> {
        let names: Vec<&str> = table.iter().map(|(name, _)| *name).collect();
        if node.shape != Shape::Name {
            return self.expected(node, &format!("one of {}", names.join(", ")), "without quotes");
        }
        let name = self.slice(node.span);
        match table.iter().find(|(n, _)| *n == name) {
            Some((_, value)) => Some(*value),
            None => self.unknown_name(what, node.span, &names),
        }
    }
}
