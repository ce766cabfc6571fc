//! Syntax tree to graph: names become symbols.

use crate::{Ast, AstKind, Graph, Id, Span, Symbol};

/// A name without a meaning here.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnknownName {
    /// The name as written.
    pub name: String,
    /// Where it stands in the expression.
    pub span: Span,
}

impl Graph {
    /// Builds the graph of a syntax tree. `resolve` returns the symbol of a name; `pi` is known.
    ///
    /// # Errors
    /// All names unknown to `resolve`, in the order of the text.
    pub fn lower(
        &mut self,
        ast: &Ast,
        resolve: impl FnMut(&str) -> Option<Symbol>,
    ) -> Result<Id, Vec<UnknownName>> {
        self.lower_with(ast, resolve, |_, _, _, _| None)
    }

    /// As [`Graph::lower`]; `table` makes the value of a table of its file, whether it is cubic, and its argument.
    ///
    /// # Errors
    /// As [`Graph::lower`], and the files of which `table` makes nothing.
    pub fn lower_with(
        &mut self,
        ast: &Ast,
        mut resolve: impl FnMut(&str) -> Option<Symbol>,
        mut table: impl FnMut(&mut Graph, &str, bool, Id) -> Option<Id>,
    ) -> Result<Id, Vec<UnknownName>> {
        let mut ids: Vec<Id> = Vec::with_capacity(ast.nodes.len());
        let mut unknown = Vec::new();
        for node in &ast.nodes {
            let id = match &node.kind {
                AstKind::Number(value) => self.constant(*value),
                AstKind::Name(name) => match resolve(name) {
                    Some(symbol) => self.symbol(symbol),
                    None if name == "pi" => self.constant(std::f64::consts::PI),
                    None => {
                        unknown.push(UnknownName { name: name.clone(), span: node.span });
                        // Any finite number: the result is discarded.
                        self.constant(1.0)
                    }
                },
                AstKind::Unary(op, a) => self.unary(*op, ids[*a]),
                AstKind::Binary(op, a, b) => self.binary(*op, ids[*a], ids[*b]),
                AstKind::Table { path: (path, span), cubic, of } => {
                    let made = table(self, path, *cubic, ids[*of]);
                    made.unwrap_or_else(|| {
                        unknown.push(UnknownName { name: path.clone(), span: *span });
                        self.constant(1.0)
                    })
                }
            };
            ids.push(id);
        }
        match ids.last() {
            Some(&root) if unknown.is_empty() => Ok(root),
            _ => Err(unknown),
        }
    }
}
