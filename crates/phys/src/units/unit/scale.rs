//! From numbers as they are written, in some unit, to SI.

use super::Unit;

/// How the numbers of a column become SI: by a power of ten where the unit is one, else by a factor.
///
/// ```
/// use phisindy_phys::unit::Unit;
/// let scale = Unit::parse("mm").unwrap().scale();
/// // Shifting the decimal point rounds as often as reading does: once.
/// assert_eq!(scale.si("123.4567"), "0.1234567".parse().ok());
/// assert_eq!(scale.si("some text"), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Added to the exponent of a decimal number.
    power: i32,
    /// What is left to multiply by.
    factor: f64,
}

impl Unit {
    /// How numbers in this unit become SI.
    pub fn scale(self) -> Scale {
        Scale::of(self.factor)
    }
}

impl Scale {
    /// For units of which one is so many SI units.
    pub fn of(factor: f64) -> Scale {
        let power = factor.log10().round();
        // A factor made of several prefixes may be off by its last bits.
        let decimal = power.abs() < 300.0 && (factor / 10f64.powi(power as i32) - 1.0).abs() < 1e-14;
        if decimal { Scale { power: power as i32, factor: 1.0 } } else { Scale { power: 0, factor } }
    }

    /// The SI value of a number that was read already: of the shortest text that reads back as it, which is
    /// the text that stood there unless that had more digits than a double holds. Infinite where it is too
    /// large.
    ///
    /// ```
    /// use phisindy_phys::unit::Scale;
    /// assert_eq!(Scale::of(1e-3).converted(4.1), 0.0041);
    /// assert_ne!(4.1 * 1e-3, 0.0041);
    /// ```
    pub fn converted(self, x: f64) -> f64 {
        if self.power == 0 { x * self.factor } else { self.si(&format!("{x:e}")).unwrap_or(f64::NAN) }
    }

    /// The SI value of a decimal number with a point; `None` if the text is none.
    pub fn si(self, text: &str) -> Option<f64> {
        if self.power == 0 {
            return text.parse::<f64>().ok().map(|x| x * self.factor);
        }
        let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
        let exponent = exponent.parse::<i32>().ok()?.saturating_add(self.power);
        format!("{mantissa}e{exponent}").parse().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_same_length_in_mm_and_in_m_is_the_same_number(digits in 0_u64..1_000_000_000_000_000_000, places in 0_usize..12) {
            let with_point = |places: usize| {
                let text = format!("{digits:0>width$}", width = places + 1);
                let (whole, part) = text.split_at(text.len() - places);
                format!("{whole}.{part}")
            };
            let (in_mm, in_m) = (with_point(places), with_point(places + 3));
            prop_assert_eq!(Unit::parse("mm").unwrap().scale().si(&in_mm), in_m.parse().ok());
            prop_assert_eq!(Unit::parse("kN/mm").unwrap().scale().si(&format!("{in_mm}e-2")), format!("{in_mm}e4").parse().ok());
        }
    }

    #[test]
    fn other_units_have_a_factor() {
        assert_eq!(Unit::parse("min").unwrap().scale().si("1.5"), Some(90.0));
        assert_eq!(Unit::ONE.scale().si("-1.5E3"), Some(-1500.0));
    }
}
