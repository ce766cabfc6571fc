//! Constructors of operations, and the rules that they apply. Each rule holds wherever the original is finite
//! (except for rounding, and for products near the limits of a double, whose factors may be multiplied in
//! another order). No rule divides by what may be zero or widens a domain on purpose. A number is folded only
//! if the result is finite; otherwise the operation stays and fails in its place.
//!
//! The rules also bring sums and products to a normal form (the number first, a difference in place of a
//! negative summand), so that printing and parsing again gives the same node.

use crate::graph::{Graph, Id, Node};
use crate::{Binary, Parity, Unary};

impl Graph {
    /// A function of one argument, simplified.
    pub fn unary(&mut self, op: Unary, a: Id) -> Id {
        unary(self, op, a).unwrap_or_else(|| self.intern(Node::Unary(op, a)))
    }

    /// An operation with two operands, simplified.
    pub fn binary(&mut self, op: Binary, a: Id, b: Id) -> Id {
        binary(self, op, a, b).unwrap_or_else(|| self.intern(Node::Binary(op, a, b)))
    }

    /// `a + b`
    pub fn add(&mut self, a: Id, b: Id) -> Id {
        self.binary(Binary::Add, a, b)
    }

    /// `a - b`
    pub fn sub(&mut self, a: Id, b: Id) -> Id {
        self.binary(Binary::Sub, a, b)
    }

    /// `a * b`
    pub fn mul(&mut self, a: Id, b: Id) -> Id {
        self.binary(Binary::Mul, a, b)
    }

    /// `a / b`
    pub fn div(&mut self, a: Id, b: Id) -> Id {
        self.binary(Binary::Div, a, b)
    }

    /// `-a`
    pub fn neg(&mut self, a: Id) -> Id {
        self.unary(Unary::Neg, a)
    }
}

/// The simpler node for `op(a)`, if a rule applies.
fn unary(g: &mut Graph, op: Unary, a: Id) -> Option<Id> {
    if let Some(x) = g.value(a) {
        let y = (op.row().value)(x);
        return y.is_finite().then(|| g.constant(y));
    }
    match (op, g.node(a)) {
        (Unary::Neg, Node::Unary(Unary::Neg, b)) => Some(b),
        (Unary::Neg, Node::Binary(Binary::Sub, b, c)) => Some(g.sub(c, b)),
        // Only for a finite number is the negative a number again; for any other the rule would not
        // terminate.
        (Unary::Neg, Node::Binary(Binary::Mul, c, b)) if g.value(c).is_some_and(f64::is_finite) => {
            let minus = g.neg(c);
            Some(g.mul(minus, b))
        }
        (
            Unary::Abs,
            Node::Unary(Unary::Abs | Unary::Exp | Unary::Sqrt | Unary::Pos | Unary::Step | Unary::Rest, _),
        ) => Some(a),
        (Unary::Sgn, Node::Unary(Unary::Sgn | Unary::Rest, _)) => Some(a),
        (Unary::Rest, Node::Unary(Unary::Sgn | Unary::Abs, b)) => Some(g.unary(op, b)),
        (Unary::Rest, Node::Unary(Unary::Rest, _)) => {
            let one = g.constant(1.0);
            Some(g.sub(one, a))
        }
        // A contact is the same one in any unit.
        (
            Unary::Sgn | Unary::Step | Unary::Rest,
            Node::Binary(Binary::Mul, c, b) | Node::Binary(Binary::Div, b, c),
        ) if g.value(c).is_some_and(|c| c.is_finite() && c != 0.0) => {
            let b = if g.value(c).is_some_and(below_zero) { g.neg(b) } else { b };
            Some(g.unary(op, b))
        }
        (_, Node::Unary(Unary::Neg, b)) => {
            let parity = op.row().parity?;
            let turned = g.unary(op, b);
            Some(if parity == Parity::Odd { g.neg(turned) } else { turned })
        }
        _ => None,
    }
}

/// The simpler node for `op(a, b)`, if a rule applies.
fn binary(g: &mut Graph, op: Binary, a: Id, b: Id) -> Option<Id> {
    let (x, y) = (g.value(a), g.value(b));
    if let (Some(x), Some(y)) = (x, y)
        && op != Binary::Timing
    {
        let z = (op.row().value)(x, y);
        return z.is_finite().then(|| g.constant(z));
    }
    let (zero, one) = (Some(0.0), Some(1.0));
    match op {
        Binary::Add if x == zero => Some(b),
        Binary::Add | Binary::Sub if y == zero => Some(a),
        Binary::Add if a == b => {
            let two = g.constant(2.0);
            Some(g.mul(two, a))
        }
        Binary::Add => negated(g, b).map(|b| g.sub(a, b)),
        Binary::Sub if x == zero => Some(g.neg(b)),
        Binary::Sub if a == b => Some(g.constant(0.0)),
        Binary::Sub => negated(g, b).map(|b| g.add(a, b)),
        Binary::Mul if x == zero || y == zero => Some(g.constant(0.0)),
        Binary::Mul if x == one => Some(b),
        Binary::Mul if y == one => Some(a),
        Binary::Mul if y.is_some() => Some(g.mul(b, a)),
        Binary::Mul if x == Some(-1.0) => Some(g.neg(b)),
        Binary::Mul => product(g, op, a, b),
        // Times a number it is the ordinary product.
        Binary::Masked if x.is_some() || y.is_some() => Some(g.mul(a, b)),
        Binary::Masked => product(g, op, a, b),
        Binary::Div if y == one => Some(a),
        Binary::Div if x == zero => Some(a),
        Binary::Div => quotient(g, a, b),
        Binary::Pow if y == zero => Some(g.constant(1.0)),
        Binary::Pow if y == one => Some(a),
        Binary::Min | Binary::Max if a == b => Some(a),
        Binary::Hold if x.is_some() => Some(a),
        Binary::Gate if x == zero => Some(a),
        Binary::Gate => y.map(|c| if c > 0.0 { a } else { g.constant(0.0) }),
        _ => None,
    }
}

/// `-e` for an `e` that is written with a minus sign.
fn negated(g: &mut Graph, e: Id) -> Option<Id> {
    match g.node(e) {
        Node::Unary(Unary::Neg, inner) => Some(inner),
        Node::Binary(Binary::Mul, c, b) if g.value(c).is_some_and(below_zero) => {
            let c = g.neg(c);
            Some(g.mul(c, b))
        }
        _ => g.value(e).filter(|&c| below_zero(c)).map(|c| g.constant(-c)),
    }
}

fn below_zero(c: f64) -> bool {
    c < 0.0 && c.is_finite()
}

/// Signs and numbers move to the front of a product (`op`: an ordinary or a masked one).
fn product(g: &mut Graph, op: Binary, a: Id, b: Id) -> Option<Id> {
    match (g.node(a), g.node(b)) {
        (Node::Unary(Unary::Neg, a), _) => {
            let p = g.binary(op, a, b);
            Some(g.neg(p))
        }
        (_, Node::Unary(Unary::Neg, b)) => {
            let p = g.binary(op, a, b);
            Some(g.neg(p))
        }
        (_, Node::Binary(Binary::Mul, c, d)) if g.value(c).is_some() => {
            let front = if g.value(a).is_some() { folded(g, Binary::Mul, c, a)? } else { c };
            let rest = if g.value(a).is_some() { d } else { g.binary(op, a, d) };
            Some(g.mul(front, rest))
        }
        (Node::Binary(Binary::Mul, c, d), _) if g.value(c).is_some() => {
            let rest = g.binary(op, d, b);
            Some(g.mul(c, rest))
        }
        _ => None,
    }
}

/// Signs and numbers move out of a quotient.
fn quotient(g: &mut Graph, a: Id, b: Id) -> Option<Id> {
    let sides = match (negated(g, a), negated(g, b)) {
        (Some(a), _) => Some((a, b)),
        (None, Some(b)) => Some((a, b)),
        (None, None) => None,
    };
    if let Some((a, b)) = sides {
        let q = g.div(a, b);
        return Some(g.neg(q));
    }
    match (g.node(a), g.node(b)) {
        (Node::Binary(Binary::Mul, c, d), Node::Constant(_)) if g.value(c).is_some() => {
            let c = folded(g, Binary::Div, c, b)?;
            Some(g.mul(c, d))
        }
        // The slope of ln(w/d) is d/w.
        (Node::Constant(_), Node::Binary(Binary::Div, w, d)) if g.value(d).is_some() => {
            let c = folded(g, Binary::Mul, a, d)?;
            Some(g.div(c, w))
        }
        _ => None,
    }
}

/// The folded number, if it is a normal one: folding must neither overflow nor underflow.
fn folded(g: &mut Graph, op: Binary, a: Id, b: Id) -> Option<Id> {
    let z = (op.row().value)(g.value(a)?, g.value(b)?);
    z.is_normal().then(|| g.constant(z))
}
