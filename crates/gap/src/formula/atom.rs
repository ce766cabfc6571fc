//! The table of atoms: functions of the displacement or of the velocity of a place, of which formulas are
//! products and sums.

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
    /// The text of the atom that it becomes where its inner number has no say: a size that is large, a rate
    /// that is small. Empty where it becomes constant, or has no such limit.
    limit: &'static str,
    /// The same for a size that is small: a step.
    step: &'static str,
}

/// What an atom becomes where its inner number has no say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limit {
    /// `None` for a constant.
    pub(super) atom: Option<&'static Atom>,
    /// The power of the inner number that becomes a factor.
    pub(super) power: i32,
}

const fn atom(text: &'static str, inner: Inner, unit: f64, factor: bool, limit: &'static str) -> Atom {
    Atom { text, inner, unit, factor, limit, step: "" }
}

/// An atom that becomes a step where its size is small.
const fn stepping(text: &'static str, unit: f64, factor: bool) -> Atom {
    Atom { text, inner: Inner::Size, unit, factor, limit: "y", step: "sgn(y)" }
}

/// Atoms in the displacement.
#[rustfmt::skip]
pub(super) const DISPLACEMENT: &[Atom] = &[
    atom("y", Inner::No, 1.0, true, ""),
    atom("y^2", Inner::No, 2.0, true, ""),
    atom("y^3", Inner::No, 3.0, true, ""),
    atom("y^4", Inner::No, 4.0, true, ""),
    atom("y^5", Inner::No, 5.0, false, ""),
    atom("y^7", Inner::No, 7.0, false, ""),
    atom("abs(y)", Inner::No, 1.0, true, ""),
    atom("y*abs(y)", Inner::No, 2.0, false, ""),
    atom("sgn(y)", Inner::No, 0.0, false, ""),
    atom("abs(y)^0.5*sgn(y)", Inner::No, 0.5, false, ""),
    atom("y*abs(y)^0.5", Inner::No, 1.5, false, ""),
    atom("y*abs(y)^1.5", Inner::No, 2.5, false, ""),
    atom("y*(abs(y)/Y)^n", Inner::Power, 1.0, false, ""),
    atom("sin(n*y)", Inner::Wave, 0.0, true, "y"),
    atom("cos(n*y)", Inner::Wave, 0.0, true, "1"),
    atom("y*cos(n*y)", Inner::Wave, 1.0, false, "y"),
    atom("y*sin(n*y)", Inner::Wave, 1.0, false, "y^2"),
    stepping("tanh(y/n)", 0.0, false),
    stepping("atan(y/n)", 0.0, false),
    atom("exp(n*y)", Inner::Rate, 0.0, true, "1"),
    atom("y*exp(n*y)", Inner::Rate, 1.0, false, "y"),
    atom("exp(-(y/n)^2)", Inner::Size, 0.0, true, "1"),
    atom("y*exp(-(y/n)^2)", Inner::Size, 1.0, false, "y"),
    atom("1/(1 + (y/n)^2)", Inner::Size, 0.0, true, "1"),
    atom("y/(1 + (y/n)^2)", Inner::Size, 1.0, false, "y"),
    stepping("y/(1 + abs(y)/n)", 1.0, false),
    atom("pos(y - n)", Inner::Corner, 1.0, false, ""),
    atom("pos(n - y)", Inner::Corner, 1.0, false, ""),
    atom("dead(y, n)", Inner::Size, 1.0, false, ""),
    atom("abs(y)^0.5", Inner::No, 0.5, true, ""),
    atom("(exp(n*y) - 1)", Inner::Rate, 0.0, false, "y"),
    atom("ln(1 + abs(y)/n)*sgn(y)", Inner::Size, 0.0, false, "y"),
];

/// Atoms in the velocity.
#[rustfmt::skip]
pub(super) const VELOCITY: &[Atom] = &[
    atom("y", Inner::No, 1.0, true, ""),
    atom("y^2", Inner::No, 2.0, true, ""),
    atom("y^3", Inner::No, 3.0, true, ""),
    atom("y^5", Inner::No, 5.0, false, ""),
    atom("abs(y)", Inner::No, 1.0, true, ""),
    atom("y*abs(y)", Inner::No, 2.0, true, ""),
    atom("sgn(y)", Inner::No, 0.0, true, ""),
    atom("abs(y)^0.5*sgn(y)", Inner::No, 0.5, true, ""),
    atom("abs(y)^1.5*sgn(y)", Inner::No, 1.5, true, ""),
    atom("abs(y)^2.5*sgn(y)", Inner::No, 2.5, false, ""),
    atom("(abs(y)/Y)^n*sgn(y)", Inner::Power, 0.0, false, ""),
    stepping("tanh(y/n)", 0.0, true),
    stepping("atan(y/n)", 0.0, false),
    atom("sgn(y)*exp(-(y/n)^2)", Inner::Size, 0.0, false, "sgn(y)"),
    atom("sgn(y)*exp(-abs(y)/n)", Inner::Size, 0.0, false, "sgn(y)"),
    atom("sgn(y)/(1 + abs(y)/n)", Inner::Size, 0.0, false, "sgn(y)"),
    atom("sgn(y)/(1 + (y/n)^2)", Inner::Size, 0.0, false, "sgn(y)"),
    atom("y*exp(-(y/n)^2)", Inner::Size, 1.0, false, "y"),
    atom("y/(1 + (y/n)^2)", Inner::Size, 1.0, false, "y"),
    stepping("y/(1 + abs(y)/n)", 1.0, false),
    atom("exp(n*y)", Inner::Rate, 0.0, false, "1"),
    atom("(exp(n*y) - 1)", Inner::Rate, 0.0, false, "y"),
    atom("ln(1 + abs(y)/n)*sgn(y)", Inner::Size, 0.0, false, "y"),
    atom("y^3/(1 + (y/n)^2)", Inner::Size, 3.0, false, "y^3"),
    atom("y*exp(-abs(y)/n)", Inner::Size, 1.0, false, "y"),
];

impl Atom {
    /// What it becomes where its inner number has no say; `step`: where that is a small size.
    pub(super) fn limit(&self, table: &'static [Atom], step: bool) -> Option<Limit> {
        let limit = if step { self.step } else { self.limit };
        let atom = table.iter().find(|a| a.text == limit);
        // A shape over `n` that is not divided by its unit loses a length, an angle gives one.
        let gained = atom.map_or(0.0, |a| a.unit) - self.unit;
        let power = match self.inner {
            Inner::Size => -gained as i32,
            Inner::Wave | Inner::Rate => gained as i32,
            _ => 0,
        };
        (!limit.is_empty()).then_some(Limit { atom, power })
    }

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

    /// `tanh(y/n)` is `y/n` for a large `n`, `sin(n*y)` is `n*y` for a small one.
    #[test]
    fn limits_keep_the_unit() {
        let of = |text: &str| {
            let atom = DISPLACEMENT.iter().find(|a| a.text == text).expect("a row");
            atom.limit(DISPLACEMENT, false).map(|l| (l.atom.map(|a| a.text), l.power))
        };
        let step = |text: &str| {
            let atom = VELOCITY.iter().find(|a| a.text == text).expect("a row");
            atom.limit(VELOCITY, true).map(|l| (l.atom.map(|a| a.text), l.power))
        };
        assert_eq!(step("tanh(y/n)"), Some((Some("sgn(y)"), 0)));
        assert_eq!(step("y/(1 + abs(y)/n)"), Some((Some("sgn(y)"), 1)));
        assert_eq!(step("y*exp(-(y/n)^2)"), None);
        assert_eq!(of("tanh(y/n)"), Some((Some("y"), -1)));
        assert_eq!(of("sin(n*y)"), Some((Some("y"), 1)));
        assert_eq!(of("y*sin(n*y)"), Some((Some("y^2"), 1)));
        assert_eq!(of("y/(1 + abs(y)/n)"), Some((Some("y"), 0)));
        assert_eq!(of("exp(-(y/n)^2)"), Some((None, 0)));
        assert_eq!(of("dead(y, n)"), None);
    }
}
