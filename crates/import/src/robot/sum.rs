//! Sums of products of names, with what is zero or one left out.

use super::frame::{Matrix, Vector};
use std::fmt;

/// A coefficient that is so much smaller than the others is what rounding leaves of a zero.
const ROUNDING: f64 = 1e-13;

/// A sum of products: each a number and the names that it multiplies, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Sum(Vec<(f64, Vec<String>)>);

impl Sum {
    pub(super) fn number(x: f64) -> Sum {
        Sum(if x == 0.0 { vec![] } else { vec![(x, vec![])] })
    }

    pub(super) fn name(name: &str) -> Sum {
        Sum(vec![(1.0, vec![name.to_owned()])])
    }

    pub(super) fn is_zero(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether it is as short as a name for it would be.
    pub(super) fn is_short(&self) -> bool {
        match self.0.as_slice() {
            [] => true,
            [(_, names)] => names.len() < 2,
            _ => false,
        }
    }

    /// Without the number that stands alone.
    pub(super) fn without_number(mut self) -> Sum {
        self.0.retain(|(_, names)| !names.is_empty());
        self
    }

    pub(super) fn plus(mut self, other: &Sum) -> Sum {
        for (x, names) in &other.0 {
            match self.0.iter_mut().find(|(_, own)| own == names) {
                Some((own, _)) => {
                    let size = own.abs().max(x.abs());
                    *own += x;
                    if own.abs() < ROUNDING * size {
                        *own = 0.0;
                    }
                }
                None => self.0.push((*x, names.clone())),
            }
        }
        self.0.retain(|(x, _)| *x != 0.0);
        self
    }

    pub(super) fn times_number(&self, by: f64) -> Sum {
        if by == 0.0 {
            Sum::default()
        } else {
            Sum(self.0.iter().map(|(x, names)| (x * by, names.clone())).collect())
        }
    }

    pub(super) fn times(&self, other: &Sum) -> Sum {
        let mut product = Sum::default();
        for (x, names) in &other.0 {
            let mut part = self.times_number(*x);
            for (_, own) in &mut part.0 {
                own.extend(names.iter().cloned());
                own.sort();
            }
            product = product.plus(&part);
        }
        product
    }

    /// As a factor: in brackets where it has several terms.
    pub(super) fn factor(&self) -> String {
        if self.0.len() > 1 || self.0.first().is_some_and(|(x, _)| *x < 0.0) {
            format!("({self})")
        } else {
            self.to_string()
        }
    }

    /// Its square; a sign does not matter there.
    pub(super) fn square(&self) -> String {
        match self.0.as_slice() {
            [(x, names)] if x.abs() == 1.0 && names.len() == 1 => format!("{}^2", names[0]),
            [_] => format!("({})^2", self.times_number(self.0[0].0.signum())),
            _ => format!("({self})^2"),
        }
    }
}

impl fmt::Display for Sum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return f.write_str("0");
        }
        for (k, (x, names)) in self.0.iter().enumerate() {
            let size = x.abs();
            f.write_str(match (k, *x < 0.0) {
                (0, false) => "",
                (0, true) => "-",
                (_, false) => " + ",
                (_, true) => " - ",
            })?;
            match (decimal(size).as_str(), names.join("*").as_str()) {
                ("1", "") => f.write_str("1")?,
                ("1", names) => f.write_str(names)?,
                (size, "") => f.write_str(size)?,
                (size, names) => write!(f, "{size}*{names}")?,
            }
        }
        Ok(())
    }
}

/// Twelve digits of a number: more are rounding.
pub(super) fn rounded(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x)
}

/// The same as text.
pub(super) fn decimal(x: f64) -> String {
    let text = format!("{:?}", rounded(x));
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// Three sums along the axes of a frame.
pub(super) type Sums = [Sum; 3];

/// The vector product with a fixed vector.
pub(super) fn crossed(a: &Sums, b: Vector) -> Sums {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i].times_number(b[j]).plus(&a[j].times_number(-b[i]))
    })
}

/// The product of a matrix of numbers with sums.
pub(super) fn through(matrix: &Matrix, of: &Sums) -> Sums {
    matrix.map(|row| along(row, of))
}

/// The part of sums along a vector.
pub(super) fn along(row: Vector, of: &Sums) -> Sum {
    row.iter().zip(of).fold(Sum::default(), |sum, (x, of)| sum.plus(&of.times_number(*x)))
}

/// The sums of two.
pub(super) fn both(a: &Sums, b: &Sums) -> Sums {
    std::array::from_fn(|k| a[k].clone().plus(&b[k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_and_ones_are_gone() {
        let (a, b) = (Sum::name("a"), Sum::name("b"));
        let sum = a.times_number(0.3).plus(&b).plus(&a.times_number(-0.1 - 0.2));
        assert_eq!(sum.to_string(), "b");
        let sum = a.times_number(-1.0).plus(&Sum::number(2.5)).times(&b);
        assert_eq!((sum.to_string(), sum.factor()), ("-a*b + 2.5*b".into(), "(-a*b + 2.5*b)".into()));
        assert_eq!(a.times_number(-1.0).square(), "a^2");
        assert_eq!(a.times_number(-0.5).square(), "(0.5*a)^2");
        assert_eq!(crossed(&[Sum::default(), Sum::default(), a], [0.0, 2.0, 0.0])[0].to_string(), "-2*a");
    }
}
