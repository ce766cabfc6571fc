//! A node as a sum of numbers times nodes, so that it prints as people write it: `-0.1 y - x + cos(0.3 t)`.

use phisindy_expr::{Binary, Graph, Id, Node, Unary};

/// `sum of coefficient * node` with like terms collected, in order of appearance.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LinearCombination {
    /// Coefficients and nodes; the node of a lone number is the number one.
    pub(crate) parts: Vec<(f64, Id)>,
}

impl LinearCombination {
    /// The nodes of its parts.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = Id> {
        self.parts.iter().map(|(_, id)| *id)
    }

    /// Decomposes a node. Sums are expanded and numbers multiplied in, except for a multiple of the sum of
    /// two names: `-386.7 (x - u)` says more than `-386.7 x + 386.7 u`.
    pub(crate) fn of(graph: &mut Graph, root: Id) -> LinearCombination {
        let mut all = LinearCombination::default();
        // The right operand goes on the stack first, which keeps the order of the sum.
        let mut stack = vec![(1.0, root)];
        while let Some((factor, id)) = stack.pop() {
            let (number, rest) = split(graph, id);
            let factor = factor * number;
            match graph.node(rest) {
                Node::Binary(op @ (Binary::Add | Binary::Sub), a, b)
                    if !(is_pair(graph, a, b) && factor.abs() != 1.0) =>
                {
                    stack.push((if op == Binary::Sub { -factor } else { factor }, b));
                    stack.push((factor, a));
                }
                _ => all.push(factor, rest),
            }
        }
        all.parts.retain(|&(c, _)| c != 0.0);
        all
    }

    /// Adds a part, to a like part if there is one.
    pub(crate) fn push(&mut self, coefficient: f64, node: Id) {
        match self.parts.iter_mut().find(|(_, n)| *n == node) {
            Some((c, _)) => *c += coefficient,
            None => self.parts.push((coefficient, node)),
        }
    }

    /// The sum as text in its order (a graph would turn `-a + b` into `b - a`); `print` writes a part.
    pub(crate) fn written(&self, graph: &mut Graph, print: &dyn Fn(&Graph, Id) -> String) -> String {
        let mut out = String::new();
        for &(c, node) in &self.parts {
            let size = graph.constant(c.abs());
            let part = graph.mul(size, node);
            out.push_str(match (out.is_empty(), c < 0.0) {
                (true, true) => "-",
                (true, false) => "",
                (false, true) => " - ",
                (false, false) => " + ",
            });
            out.push_str(&print(graph, part));
        }
        if out.is_empty() { "0".to_owned() } else { out }
    }
}

/// The numeric factor of a product or quotient, and the rest.
pub(crate) fn split(graph: &mut Graph, id: Id) -> (f64, Id) {
    let (number, rest) = match graph.node(id) {
        Node::Constant(bits) => (f64::from_bits(bits), graph.constant(1.0)),
        Node::Unary(Unary::Neg, a) => {
            let (c, a) = split(graph, a);
            (-c, a)
        }
        Node::Binary(op @ (Binary::Mul | Binary::Div), a, b) => {
            let ((c, a), (d, b)) = (split(graph, a), split(graph, b));
            let number = if op == Binary::Mul { c * d } else { c / d };
            (number, graph.binary(op, a, b))
        }
        _ => (1.0, id),
    };
    // A number that over- or underflows stays where it is written.
    if number.is_normal() || (number == 0.0 && graph.value(id) == Some(0.0)) {
        (number, rest)
    } else {
        (1.0, id)
    }
}

fn is_pair(graph: &Graph, a: Id, b: Id) -> bool {
    [a, b].iter().all(|&id| matches!(graph.node(id), Node::Symbol(_)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_expr::{Names, parse};

    /// The text of an expression after decomposition.
    fn tidy(text: &str) -> String {
        let (mut graph, mut names) = (Graph::default(), Names::default());
        let ast = parse(text).expect("a good expression");
        let root = graph.lower(&ast, |n| Some(names.intern(n))).expect("all names are known");
        let sum = LinearCombination::of(&mut graph, root);
        let written = sum.written(&mut graph, &|graph, id| graph.text(id, &names));
        let again = graph
            .lower(&parse(&written).expect("what was written parses"), |n| names.get(n))
            .expect("the same names");
        assert_eq!(LinearCombination::of(&mut graph, again).parts.len(), sum.parts.len());
        written
    }

    #[test]
    fn sums_are_opened_and_numbers_come_first() {
        assert_eq!(
            tidy("(-(0.1+0.1)*y1 + 0.1*y2 - (1+1)*x1 + cos(0.6*t))/2"),
            "-0.1*y1 + 0.05*y2 - x1 + 0.5*cos(0.6*t)"
        );
        assert_eq!(tidy("-(0.5*sgn(y))/2"), "-0.25*sgn(y)");
        assert_eq!(tidy("1 - (x - (y - 1))"), "-x + y");
    }

    #[test]
    fn like_terms_are_collected_and_what_cancels_goes() {
        assert_eq!(tidy("3*x + 2*y - x + y/4"), "2*x + 2.25*y");
        assert_eq!(tidy("x - y - x"), "-y");
        assert_eq!(tidy("x - x"), "0");
    }

    #[test]
    fn a_multiple_of_a_difference_stays_together() {
        assert_eq!(tidy("(-4*(v-w) - 6*(x-u))/2"), "-2*(v - w) - 3*(x - u)");
        assert_eq!(tidy("(4*(v-w) - 2*(x-u))/2"), "2*(v - w) - x + u");
    }

    #[test]
    fn numbers_leave_products_and_quotients() {
        assert_eq!(tidy("(sgn(v)/4)*(2*ln(x))"), "0.5*sgn(v)*ln(x)");
        assert_eq!(tidy("F/(2*m)"), "0.5*(F/m)");
    }
}
