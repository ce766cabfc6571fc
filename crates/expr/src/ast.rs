//! The syntax tree: nodes and their places in the text.

use crate::{Binary, Span, Unary};

/// One node; operands are indices of earlier nodes of the same [`Ast`].
#[derive(Clone, Debug, PartialEq)]
pub enum AstKind {
    /// A literal.
    Number(f64),
    /// A name, not yet looked up.
    Name(String),
    /// A function of one argument, a sign, or bars.
    Unary(Unary, usize),
    /// An infix operation or a function of two arguments.
    Binary(Binary, usize, usize),
    /// A function of one argument that a file holds: `table('spring.csv', x)`.
    Table {
        /// The file, and its place in the text.
        path: (String, Span),
        /// Whether it goes smoothly through its points, and not straight from one to the next.
        cubic: bool,
        /// The argument.
        of: usize,
    },
}

/// A node and its place in the text.
#[derive(Clone, Debug, PartialEq)]
pub struct AstNode {
    /// The node.
    pub kind: AstKind,
    /// Its place.
    pub span: Span,
}

/// A parsed expression. Operands precede operations and the last node is the root, so every pass is one
/// loop and a long text cannot overflow the stack.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Ast {
    /// Operands first.
    pub nodes: Vec<AstNode>,
}

impl Ast {
    /// Every name with its place, in the order of the text, with repetitions.
    pub fn names(&self) -> impl Iterator<Item = (&str, Span)> {
        self.nodes.iter().filter_map(|node| match &node.kind {
            AstKind::Name(name) => Some((name.as_str(), node.span)),
            _ => None,
        })
    }

    /// Every file of a table with its place, in the order of the text, with repetitions.
    pub fn files(&self) -> impl Iterator<Item = (&str, Span)> {
        self.nodes.iter().filter_map(|node| match &node.kind {
            AstKind::Table { path: (path, span), .. } => Some((path.as_str(), *span)),
            _ => None,
        })
    }
}
