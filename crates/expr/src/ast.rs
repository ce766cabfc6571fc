//! The syntax tree: what was written, and where.

use crate::{Binary, ParseError, Span, Unary, parse};

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

/// The text of an expression with some of its names replaced, all at once; everything else stays as it was written.
///
/// # Errors
/// The text is no expression.
///
/// ```
/// use phisindy_expr::rename;
/// let with = [("x".to_owned(), "v".to_owned()), ("v".to_owned(), "(x-y)".to_owned())];
/// assert_eq!(rename("x*exp(v) + 1e-6*ex", &with).unwrap(), "v*exp((x-y)) + 1e-6*ex");
/// ```
pub fn rename(text: &str, with: &[(String, String)]) -> Result<String, ParseError> {
    let ast = parse(text)?;
    let mut places: Vec<(&str, Span)> = ast.names().collect();
    places.sort_by_key(|(_, span)| span.start);
    let (mut out, mut end) = (String::with_capacity(text.len()), 0);
    for (name, span) in places {
        out.push_str(&text[end..span.start]);
        let replacement = with.iter().find(|(old, _)| old == name);
        out.push_str(replacement.map_or(name, |(_, new)| new));
        end = span.end;
    }
    out.push_str(&text[end..]);
    Ok(out)
}
