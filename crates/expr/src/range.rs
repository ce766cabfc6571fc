//! Bounds of an expression from bounds of its symbols, by interval arithmetic (Moore 1966).

use crate::{Binary, Graph, Id, Node, Unary};
use std::collections::HashMap;
use std::f64::consts::PI;

/// The least and the largest value.
type Range = (f64, f64);

const ALL: Range = (f64::NEG_INFINITY, f64::INFINITY);

impl Graph {
    /// Bounds of a node where its symbols keep theirs; a symbol without bounds may have any value. The bounds
    /// hold, but need not be reached: `x - x` is taken for a difference of two numbers. Rounding is not
    /// counted.
    ///
    /// ```
    /// # use phisindy_expr::*;
    /// # let (mut g, mut n) = (Graph::default(), Names::default());
    /// # let mut e = |g: &mut Graph, t: &str| g.lower(&parse(t).unwrap(), |s| Some(n.intern(s))).unwrap();
    /// let (bell, v) = (e(&mut g, "1 - exp(-v^2)"), e(&mut g, "v"));
    /// assert_eq!(g.range(bell, &[(v, (-3.0, f64::INFINITY))]), (0.0, 1.0));
    /// ```
    pub fn range(&self, root: Id, within: &[(Id, Range)]) -> Range {
        let known: HashMap<Id, Range> = within.iter().copied().collect();
        let mut ranges = vec![ALL; root.index() + 1];
        for id in self.reachable(&[root]) {
            let range = match self.node(id) {
                Node::Symbol(_) => known.get(&id).copied().unwrap_or(ALL),
                Node::Constant(bits) => (f64::from_bits(bits), f64::from_bits(bits)),
                Node::Unary(op, a) => of_function(op, ranges[a.index()]),
                Node::Binary(Binary::Mul, a, b) if a == b => power(ranges[a.index()], 2.0),
                Node::Binary(op, a, b) => {
                    of_operation(op, ranges[a.index()], ranges[b.index()], self.value(b))
                }
            };
            ranges[id.index()] = if range.0.is_nan() || range.1.is_nan() { ALL } else { range };
        }
        ranges[root.index()]
    }
}

fn of_function(op: Unary, (low, high): Range) -> Range {
    let value = op.row().value;
    match op {
        Unary::Neg => (-high, -low),
        Unary::Abs if low >= 0.0 => (low, high),
        Unary::Abs if high <= 0.0 => (-high, -low),
        Unary::Abs => (0.0, high.max(-low)),
        Unary::Sin | Unary::Cos => (-1.0, 1.0),
        Unary::Rest => (0.0, 1.0),
        Unary::Sgn | Unary::Step | Unary::Pos | Unary::Tanh | Unary::Atan | Unary::Floor => {
            (value(low), value(high))
        }
        Unary::Exp => (low.exp(), high.exp()),
        Unary::Ln if low >= 0.0 => (low.ln(), high.ln()),
        Unary::Sqrt if low >= 0.0 => (low.sqrt(), high.sqrt()),
        _ => ALL,
    }
}

/// `right` is the second operand, if it is a number.
fn of_operation(op: Binary, a: Range, b: Range, right: Option<f64>) -> Range {
    match op {
        Binary::Add => (a.0 + b.0, a.1 + b.1),
        Binary::Sub => (a.0 - b.1, a.1 - b.0),
        Binary::Mul | Binary::Masked => product(a, b),
        // The ends of `1/b`; where it is `1/0` the sign of zero is that of the rest of `b`.
        Binary::Div if b.0 >= 0.0 && b.1 > 0.0 => product(a, (1.0 / b.1, 1.0 / b.0.abs())),
        Binary::Div if b.1 <= 0.0 && b.0 < 0.0 => product(a, (-1.0 / b.1.abs(), 1.0 / b.0)),
        Binary::Pow => match right {
            Some(n) => power(a, n),
            // A power of what is not negative is none either.
            None if a.0 >= 0.0 => (0.0, f64::INFINITY),
            None => ALL,
        },
        Binary::Min => (a.0.min(b.0), a.1.min(b.1)),
        Binary::Max => (a.0.max(b.0), a.1.max(b.1)),
        Binary::Hold => a,
        Binary::Gate => (a.0.min(0.0), a.1.max(0.0)),
        Binary::Mod if b.0 >= 0.0 => (0.0, b.1),
        Binary::Atan2 => (-PI, PI),
        // Towards zero by a clearance; a negative one leads away from it.
        Binary::Dead if b.0 >= 0.0 => (a.0.min(0.0), a.1.max(0.0)),
        _ => ALL,
    }
}

/// Zero times infinity is zero: an end at infinity is never reached.
fn product(a: Range, b: Range) -> Range {
    let times = |x: f64, y: f64| if x == 0.0 || y == 0.0 { 0.0 } else { x * y };
    let all = [times(a.0, b.0), times(a.0, b.1), times(a.1, b.0), times(a.1, b.1)];
    (all.iter().copied().fold(f64::INFINITY, f64::min), all.iter().copied().fold(f64::NEG_INFINITY, f64::max))
}

fn power((low, high): Range, n: f64) -> Range {
    let (a, b) = (low.powf(n), high.powf(n));
    if n.fract() == 0.0 && n % 2.0 == 0.0 && n > 0.0 {
        if low >= 0.0 {
            (a, b)
        } else if high <= 0.0 {
            (b, a)
        } else {
            (0.0, a.max(b))
        }
    } else if n > 0.0 && (low >= 0.0 || n.fract() == 0.0) {
        (a, b)
    } else if low >= 0.0 {
        (b, a)
    } else {
        ALL
    }
}
