//! What a quantity measures, whatever its unit.

use std::fmt;

/// Exponents are kept in twelfths: square roots, cube roots and fourth roots of units stay exact.
const PARTS: i16 = 12;

/// Powers of kilogram, metre, second, ampere and kelvin. Angles have no dimension.
///
/// ```
/// use phisindy_phys::unit::Unit;
/// let dimension = |text: &str| Unit::parse(text).unwrap().dimension;
/// let natural = dimension("N/m").div(dimension("kg")).pow(0.5).unwrap();
/// assert_eq!(natural, dimension("rad/s"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub struct Dimension([i16; 5]);

impl Dimension {
    /// A plain number.
    pub const NONE: Dimension = Dimension([0; 5]);
    /// Mass.
    pub const KILOGRAM: Dimension = Dimension::new(1, 0, 0, 0, 0);
    /// Length.
    pub const METRE: Dimension = Dimension::new(0, 1, 0, 0, 0);
    /// Time.
    pub const SECOND: Dimension = Dimension::new(0, 0, 1, 0, 0);
    /// Force.
    pub const NEWTON: Dimension = Dimension::new(1, 1, -2, 0, 0);
    /// Electric tension.
    pub const VOLT: Dimension = Dimension::new(1, 2, -3, -1, 0);

    /// From whole powers of kg, m, s, A, K.
    pub const fn new(kg: i8, m: i8, s: i8, a: i8, k: i8) -> Self {
        // `From` is not const; i8 times 12 fits i16.
        Dimension([kg as i16 * PARTS, m as i16 * PARTS, s as i16 * PARTS, a as i16 * PARTS, k as i16 * PARTS])
    }

    /// Powers of kg, m, s, A, K.
    pub fn powers(self) -> [f64; 5] {
        self.0.map(|twelfths| f64::from(twelfths) / f64::from(PARTS))
    }

    /// The inverse of `powers`; None as in [`Dimension::pow`].
    pub(crate) fn from_powers(powers: [f64; 5]) -> Option<Dimension> {
        let mut dimension = Dimension::NONE;
        for (twelfths, power) in dimension.0.iter_mut().zip(powers) {
            *twelfths = whole_twelfths(power * f64::from(PARTS))?;
        }
        Some(dimension)
    }

    /// Whether it is a plain number.
    pub fn is_none(self) -> bool {
        self == Dimension::NONE
    }

    /// The dimension of a product.
    #[expect(
        clippy::should_implement_trait,
        reason = "dimensions are not multiplied as numbers are; a name reads better in checks"
    )]
    pub fn mul(self, other: Dimension) -> Dimension {
        Dimension(std::array::from_fn(|i| self.0[i].saturating_add(other.0[i])))
    }

    /// The dimension of a quotient.
    #[expect(clippy::should_implement_trait, reason = "as mul")]
    pub fn div(self, other: Dimension) -> Dimension {
        Dimension(std::array::from_fn(|i| self.0[i].saturating_sub(other.0[i])))
    }

    /// The dimension of a power; None if the exponents it gives are no multiples of 1/12 or beyond 100.
    pub fn pow(self, exponent: f64) -> Option<Dimension> {
        let mut powers = [0; 5];
        for (power, old) in powers.iter_mut().zip(self.0) {
            *power = whole_twelfths(f64::from(old) * exponent)?;
        }
        Some(Dimension(powers))
    }

    /// The same with a whole power of the named unit that reads best, and what is left beside it.
    fn named(self) -> (Option<(&'static str, i16)>, Dimension) {
        let [kg, _, s, a, _] = self.0;
        let unit = match a {
            _ if kg == 0 || s == 0 || kg % PARTS != 0 => None,
            a if a == -kg => Some(("V", Dimension::VOLT)),
            0 => Some(("N", Dimension::NEWTON)),
            _ => None,
        };
        let Some((name, one)) = unit else { return (None, self) };
        let Some(rest) = one.pow(f64::from(kg / PARTS)).map(|power| self.div(power)) else {
            return (None, self);
        };
        // A square of it only where that is shorter.
        let length = |d: Dimension| d.0.iter().map(|power| power.abs()).sum::<i16>();
        if kg.abs() > PARTS && kg.abs() + length(rest) >= length(self) {
            return (None, self);
        }
        (Some((name, kg)), rest)
    }
}

/// The number as twelfths are kept; None if it is none, or beyond 100.
fn whole_twelfths(x: f64) -> Option<i16> {
    let rounded = x.round();
    let fits = !x.is_nan() && rounded.abs() <= f64::from(100 * PARTS) && (x - rounded).abs() <= 1e-5;
    fits.then_some(rounded as i16)
}

impl fmt::Display for Dimension {
    /// In SI, with newton and volt where they fit: `N*s/m`, `m/s^2`, `1/s`, `1`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (named, rest) = self.named();
        let base = ["kg", "m", "s", "A", "K"].into_iter().zip(rest.0);
        let factors: Vec<(&str, i16)> =
            named.into_iter().chain(base).filter(|(_, power)| *power != 0).collect();
        let join = |sign: i16| {
            let side = factors.iter().filter(|(_, power)| power.signum() == sign);
            side.map(|(name, power)| format!("{name}{}", exponent(power.abs()))).collect::<Vec<_>>().join("*")
        };
        let (top, bottom) = (join(1), join(-1));
        f.write_str(if top.is_empty() { "1" } else { &top })?;
        match bottom.contains('*') {
            _ if bottom.is_empty() => Ok(()),
            true => write!(f, "/({bottom})"),
            false => write!(f, "/{bottom}"),
        }
    }
}

/// `^2`, `^(1/2)` or nothing.
fn exponent(twelfths: i16) -> String {
    if twelfths == PARTS {
        return String::new();
    }
    if twelfths % PARTS == 0 {
        return format!("^{}", twelfths / PARTS);
    }
    let common = [12, 6, 4, 3, 2].into_iter().find(|d| twelfths % d == 0 && PARTS % d == 0).unwrap_or(1);
    format!("^({}/{})", twelfths / common, PARTS / common)
}

#[cfg(test)]
mod tests {
    use crate::units::unit::Unit;

    #[test]
    fn powers_of_volt_and_newton_are_told_as_such() {
        for (unit, told) in [
            ("V/s^2/V^3", "1/(V^2*s^2)"),
            ("V^3", "V^3"),
            ("N/m/V", "s*A/m^2"),
            ("N^2/m^2", "N^2/m^2"),
            ("N*s/m", "N*s/m"),
            ("1/N", "1/N"),
            ("kg^2*m/s", "kg^2*m/s"),
        ] {
            assert_eq!(Unit::parse(unit).expect(unit).dimension.to_string(), told, "{unit}");
        }
    }
}
