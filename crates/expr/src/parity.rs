//! Whether an expression is even or odd, told by its structure.

use crate::ops::{Binary, Parity, Unary};
use crate::{Graph, Id, Node};

impl Graph {
    /// The parity of a node in some symbols together; `None` where the rules do not tell. What uses none of
    /// them is even.
    ///
    /// ```
    /// # use phisindy_expr::*;
    /// # let (mut g, mut n) = (Graph::default(), Names::default());
    /// # let mut e = |g: &mut Graph, t: &str| g.lower(&parse(t).unwrap(), |s| Some(n.intern(s))).unwrap();
    /// let (drag, sum, v) = (e(&mut g, "d*v*abs(v)"), e(&mut g, "v + v^2"), e(&mut g, "v"));
    /// assert_eq!(g.parity(drag, &[v]), Some(Parity::Odd));
    /// assert_eq!(g.parity(sum, &[v]), None);
    /// ```
    pub fn parity(&self, root: Id, of: &[Id]) -> Option<Parity> {
        let order = self.reachable(&[root]);
        let mut parities = vec![None; root.index() + 1];
        for id in order {
            parities[id.index()] = match self.node(id) {
                Node::Symbol(_) if of.contains(&id) => Some(Parity::Odd),
                Node::Symbol(_) | Node::Constant(_) => Some(Parity::Even),
                Node::Unary(op, a) => parities[a.index()].and_then(|a| of_function(op, a)),
                Node::Binary(op, a, b) => parities[a.index()]
                    .zip(parities[b.index()])
                    .and_then(|(pa, pb)| of_operation(op, (pa, pb), self.value(b))),
            };
        }
        parities[root.index()]
    }
}

/// Any function of what stays, stays; of what turns, as its row says.
fn of_function(op: Unary, argument: Parity) -> Option<Parity> {
    if argument == Parity::Even { Some(argument) } else { op.row().parity }
}

/// `right` is the second operand, if it is a number.
fn of_operation(op: Binary, (a, b): (Parity, Parity), right: Option<f64>) -> Option<Parity> {
    match op {
        Binary::Add | Binary::Sub => (a == b).then_some(a),
        Binary::Mul | Binary::Div | Binary::Masked => Some(if a == b { Parity::Even } else { Parity::Odd }),
        Binary::Pow if a == Parity::Odd => {
            let power = right.filter(|n| n.fract() == 0.0)?;
            Some(if power % 2.0 == 0.0 { Parity::Even } else { Parity::Odd })
        }
        Binary::Atan2 if b == Parity::Even => Some(a),
        Binary::Hold => Some(a),
        // `dead(x, g)` is odd in `x`; a gate lets pass or not.
        Binary::Dead | Binary::Gate => (b == Parity::Even).then_some(a),
        _ => (a == Parity::Even && b == Parity::Even).then_some(Parity::Even),
    }
}
