//! A dimension that may hold unknown ones.

use crate::units::unit::Dimension;
use std::fmt;

/// Powers nearer than this are the same: they come from exponents such as 1/3, written as decimals or
/// quotients.
pub(super) const SAME: f64 = 1e-6;

/// A product of powers of the base units and of unknown dimensions.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Form {
    /// Powers of kg, m, s, A, K.
    pub(super) base: [f64; 5],
    /// Unknown dimensions and their powers, by rising index.
    pub(super) unknown: Vec<(usize, f64)>,
}

impl Form {
    pub(super) fn known(dimension: Dimension) -> Form {
        Form { base: dimension.powers(), unknown: vec![] }
    }

    /// A plain number.
    pub(super) fn none() -> Form {
        Form::default()
    }

    /// `self * other^power`.
    pub(super) fn times(&self, other: &Form, power: f64) -> Form {
        let base = std::array::from_fn(|k| self.base[k] + power * other.base[k]);
        let mut unknown = Vec::with_capacity(self.unknown.len() + other.unknown.len());
        let (mut left, mut right) = (self.unknown.iter().peekable(), other.unknown.iter().peekable());
        loop {
            let next = match (left.peek(), right.peek()) {
                (Some(&&(i, a)), Some(&&(j, b))) if i == j => {
                    left.next();
                    right.next();
                    (i, a + power * b)
                }
                (Some(&&(i, _)), Some(&&(j, b))) if j < i => {
                    right.next();
                    (j, power * b)
                }
                (Some(&&first), _) => {
                    left.next();
                    first
                }
                (None, Some(&&(j, b))) => {
                    right.next();
                    (j, power * b)
                }
                (None, None) => break,
            };
            // A power that is no number must not pass for zero.
            if next.1.is_nan() || next.1.abs() > SAME {
                unknown.push(next);
            }
        }
        Form { base, unknown }
    }

    pub(super) fn over(&self, other: &Form) -> Form {
        self.times(other, -1.0)
    }

    pub(super) fn pow(&self, power: f64) -> Form {
        Form::none().times(self, power)
    }

    /// Whether it is a plain number for certain; powers that overflowed count as one, because nothing can be
    /// said of them.
    pub(super) fn is_none(&self) -> bool {
        self.unknown.is_empty() && !self.base.iter().any(|p| p.abs() > SAME)
    }

    /// The dimension, if nothing in it is unknown and its powers are such as units have.
    pub(super) fn dimension(&self) -> Option<Dimension> {
        if self.unknown.is_empty() { Dimension::from_powers(self.base) } else { None }
    }
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_none() {
            return f.write_str("a plain number");
        }
        match self.dimension() {
            Some(dimension) => dimension.fmt(f),
            // Powers that units do not have: `m^0.37`.
            None => {
                let factor = |(name, power): (&str, f64)| match power {
                    p if p.abs() <= SAME => None,
                    p if (p - 1.0).abs() <= SAME => Some(name.to_owned()),
                    p => Some(format!("{name}^{}", (p * 1000.0).round() / 1000.0)),
                };
                let factors = ["kg", "m", "s", "A", "K"].into_iter().zip(self.base).filter_map(factor);
                f.write_str(&factors.collect::<Vec<_>>().join("*"))
            }
        }
    }
}
