//! The table of atoms: functions of the displacement or of the velocity of a place, of which formulas are products
//! and sums.

/// What an inner number of an atom is, which gives its unit and the values that are tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Inner {
    /// None.
    No,
    /// A size of the quantity, positive, over which a curve bends.
    Size,
    /// The inverse of one, of either sign: the rate of an exponential.
    Rate,
    /// An angle per unit of the quantity.
    Wave,
    /// A value of the quantity, of either sign: where a corner is.
    Corner,
    /// A power.
    Power,
}

/// A row of the table. In the text `y` is the quantity, `n` the inner number, `Y` one unit of the quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Atom {
    /// In the language of the specs.
    pub(super) text: &'static str,
    /// Its inner number.
    pub(super) inner: Inner,
    /// The power of the quantity in its unit.
    pub(super) unit: f64,
    /// Whether it is a factor of products of displacement and velocity too.
    pub(super) factor: bool,
}

const fn atom(text: &'static str, inner: Inner, unit: f64, factor: bool) -> Atom {
    Atom { text, inner, unit, factor }
}

/// Atoms in the displacement.
#[rustfmt::skip]
pub(super) const DISPLACEMENT: &[Atom] = &[
    atom("y", Inner::No, 1.0, true),
    atom("y^2", Inner::No, 2.0, true),
    atom("y^3", Inner::No, 3.0, true),
    atom("y^4", Inner::No, 4.0, true),
    atom("y^5", Inner::No, 5.0, false),
    atom("y^7", Inner::No, 7.0, false),
    atom("abs(y)", Inner::No, 1.0, true),
    atom("y*abs(y)", Inner::No, 2.0, false),
    atom("sgn(y)", Inner::No, 0.0, false),
    atom("abs(y)^0.5*sgn(y)", Inner::No, 0.5, false),
    atom("abs(y)^1.5*sgn(y)", Inner::No, 1.5, false),
    atom("abs(y)^2.5*sgn(y)", Inner::No, 2.5, false),
    atom("(abs(y)/Y)^n*sgn(y)", Inner::Power, 0.0, false),
    atom("sin(n*y)", Inner::Wave, 0.0, true),
    atom("cos(n*y)", Inner::Wave, 0.0, true),
    atom("y*cos(n*y)", Inner::Wave, 1.0, false),
    atom("y*sin(n*y)", Inner::Wave, 1.0, false),
    atom("tanh(y/n)", Inner::Size, 0.0, false),
    atom("atan(y/n)", Inner::Size, 0.0, false),
    atom("exp(n*y)", Inner::Rate, 0.0, true),
    atom("y*exp(n*y)", Inner::Rate, 1.0, false),
    atom("exp(-(y/n)^2)", Inner::Size, 0.0, true),
    atom("y*exp(-(y/n)^2)", Inner::Size, 1.0, false),
    atom("1/(1 + (y/n)^2)", Inner::Size, 0.0, true),
    atom("y/(1 + (y/n)^2)", Inner::Size, 1.0, false),
    atom("y/(1 + abs(y)/n)", Inner::Size, 1.0, false),
    atom("pos(y - n)", Inner::Corner, 1.0, false),
    atom("pos(n - y)", Inner::Corner, 1.0, false),
    atom("dead(y, n)", Inner::Size, 1.0, false),
];

/// Atoms in the velocity.
#[rustfmt::skip]
pub(super) const VELOCITY: &[Atom] = &[
    atom("y", Inner::No, 1.0, true),
    atom("y^2", Inner::No, 2.0, true),
    atom("y^3", Inner::No, 3.0, true),
    atom("y^5", Inner::No, 5.0, false),
    atom("abs(y)", Inner::No, 1.0, true),
    atom("y*abs(y)", Inner::No, 2.0, true),
    atom("sgn(y)", Inner::No, 0.0, true),
    atom("abs(y)^0.5*sgn(y)", Inner::No, 0.5, true),
    atom("abs(y)^1.5*sgn(y)", Inner::No, 1.5, true),
    atom("abs(y)^2.5*sgn(y)", Inner::No, 2.5, false),
    atom("(abs(y)/Y)^n*sgn(y)", Inner::Power, 0.0, false),
    atom("tanh(y/n)", Inner::Size, 0.0, true),
    atom("atan(y/n)", Inner::Size, 0.0, false),
    atom("sgn(y)*exp(-(y/n)^2)", Inner::Size, 0.0, false),
    atom("sgn(y)*exp(-abs(y)/n)", Inner::Size, 0.0, false),
    atom("sgn(y)/(1 + abs(y)/n)", Inner::Size, 0.0, false),
    atom("sgn(y)/(1 + (y/n)^2)", Inner::Size, 0.0, false),
    atom("y*exp(-(y/n)^2)", Inner::Size, 1.0, false),
    atom("y/(1 + (y/n)^2)", Inner::Size, 1.0, false),
    atom("y/(1 + abs(y)/n)", Inner::Size, 1.0, false),
    atom("exp(n*y)", Inner::Rate, 0.0, false),
];

impl Atom {
    /// The text with the name of the quantity and of the inner number.
    pub(super) fn written(&self, quantity: &str, inner: &str, unit: &str) -> String {
        let mut out = String::new();
        let mut word = String::new();
        for c in self.text.chars().chain([' ']) {
            if c.is_ascii_alphabetic() {
                word.push(c);
                continue;
            }
            out.push_str(match word.as_str() {
                "y" => quantity,
                "n" => inner,
                "Y" => unit,
                other => other,
            });
            word.clear();
            out.push(c);
        }
        out.trim_end().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_put_in() {
        let tanh = DISPLACEMENT.iter().find(|a| a.text.starts_with("tanh")).expect("a row");
        assert_eq!(tanh.written("x", "l1", "X"), "tanh(x/l1)");
        assert_eq!(VELOCITY[10].written("v", "q", "V"), "(abs(v)/V)^q*sgn(v)");
    }
}
