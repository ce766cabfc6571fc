//! The syntax tree: what was written, and where.

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
}

/// A node and the text it came from.
#[derive(Clone, Debug, PartialEq)]
pub struct AstNode {
    /// What it is.
    pub kind: AstKind,
    /// Where it stands.
    pub span: Span,
}

/// A parsed expression: operands precede operations and the last node is the root, so that every pass is one loop
/// and no text, however long, can overflow the stack.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Ast {
    /// Operands first.
    pub nodes: Vec<AstNode>,
}

impl Ast {
    /// Every name with its place, in the order of the text; repeated names are repeated.
    pub fn names(&self) -> impl Iterator<Item = (&str, Span)> {
        self.nodes.iter().filter_map(|node| match &node.kind {
            AstKind::Name(name) => Some((name.as_str(), node.span)),
            _ => None,
        })
    }
}
