//! The terms of a sum, each with what it is divided by.

use phisindy_expr::{Binary, Graph, Id, Node, Unary};

/// A term with its sign, over a number.
pub(super) struct Term {
    pub(super) value: Id,
    pub(super) over: Option<Id>,
}

/// The terms of an expression. What does not depend on `moving` is a number: a product of it and a sum is a sum.
pub(super) fn terms(graph: &mut Graph, sum: Id, moving: &[Id]) -> Vec<Term> {
    struct Piece {
        of: Id,
        minus: bool,
        factors: Vec<Id>,
        over: Option<Id>,
    }
    let mut all = vec![];
    let mut waiting = vec![Piece { of: sum, minus: false, factors: vec![], over: None }];
    while let Some(mut piece) = waiting.pop() {
        let next = |of: Id, minus: bool, piece: &Piece| Piece {
            of,
            minus,
            factors: piece.factors.clone(),
            over: piece.over,
        };
        let is_number = |id: Id, graph: &Graph| !graph.uses(&[id], moving);
        match graph.node(piece.of) {
            Node::Binary(Binary::Add, a, b) => {
                waiting.extend([next(b, piece.minus, &piece), next(a, piece.minus, &piece)]);
            }
            Node::Binary(Binary::Sub, a, b) => {
                waiting.extend([next(b, !piece.minus, &piece), next(a, piece.minus, &piece)]);
            }
            Node::Unary(Unary::Neg, a) => waiting.push(next(a, !piece.minus, &piece)),
            Node::Binary(Binary::Div, a, b) if is_number(b, graph) => {
                piece.over = Some(piece.over.map_or(b, |over| graph.mul(over, b)));
                waiting.push(Piece { of: a, ..piece });
            }
            Node::Binary(Binary::Mul, a, b) if is_number(a, graph) && !is_number(b, graph) => {
                piece.factors.push(a);
                waiting.push(Piece { of: b, ..piece });
            }
            Node::Binary(Binary::Mul, a, b) if is_number(b, graph) && !is_number(a, graph) => {
                piece.factors.push(b);
                waiting.push(Piece { of: a, ..piece });
            }
            _ => {
                // `c/m*v*|v|` is `c*v*|v|` over `m`.
                let (mut factors, mut waiting_factors) = (vec![], piece.factors);
                waiting_factors.push(piece.of);
                while let Some(factor) = waiting_factors.pop() {
                    match graph.node(factor) {
                        Node::Binary(Binary::Mul, a, b) => waiting_factors.extend([a, b]),
                        Node::Unary(Unary::Neg, a) => {
                            piece.minus = !piece.minus;
                            waiting_factors.push(a);
                        }
                        Node::Binary(Binary::Div, a, b) if is_number(b, graph) => {
                            piece.over = Some(piece.over.map_or(b, |over| graph.mul(over, b)));
                            waiting_factors.push(a);
                        }
                        _ => factors.push(factor),
                    }
                }
                // Numbers stand in front, in the order of the spec.
                factors.reverse();
                factors.sort_by_key(|f| graph.uses(&[*f], moving));
                let product =
                    factors.into_iter().reduce(|product, f| graph.mul(product, f)).unwrap_or(piece.of);
                let value = if piece.minus { graph.neg(product) } else { product };
                if graph.value(value) != Some(0.0) {
                    all.push(Term { value, over: piece.over });
                }
            }
        }
    }
    all
}
