//! Units of measurement: texts like `N*s/m` as a factor to SI and a dimension.

mod dimension;
mod scale;
mod table;

pub use dimension::Dimension;
pub use scale::Scale;
pub use table::names;

use phisindy_expr::{Span, nearest};
use std::fmt;

/// A unit: `value * factor` is the value in SI.
///
/// ```
/// use phisindy_phys::unit::Unit;
/// let unit = Unit::parse("kN*s/m").unwrap();
/// assert_eq!(unit.factor, 1000.0);
/// assert_eq!(unit.dimension.to_string(), "N*s/m");
/// assert_eq!(Unit::parse("N*sec").unwrap_err().span, phisindy_expr::Span::new(2, 5));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// How many SI units one of it is.
    pub factor: f64,
    /// What it measures. Angles and per cents are plain numbers.
    pub dimension: Dimension,
}

/// Why a text is no unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnitError {
    /// What is wrong, in one sentence.
    pub message: String,
    /// Where, in bytes of the unit's text.
    pub span: Span,
    /// What to do, if there is something to say.
    pub help: Option<String>,
}

impl UnitError {
    /// What to do, as the expression parser's errors have it.
    pub fn hint(&self) -> Option<String> {
        self.help.clone()
    }
}

impl fmt::Display for UnitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for UnitError {}

impl Unit {
    /// The plain number.
    pub const ONE: Unit = Unit { factor: 1.0, dimension: Dimension::NONE };

    /// Reads units joined by `*` and `/`, each with an optional power (`^2`, `^-1`, `^0.5`, `^(1/3)`, `²`);
    /// brackets group, a number scales (`rev/4096`), `1` and the empty text are the plain number.
    ///
    /// # Errors
    /// The first mistake with its place.
    pub fn parse(text: &str) -> Result<Unit, UnitError> {
        let mut parser = Parser { text, at: 0, depth: 0 };
        parser.space();
        if parser.rest().is_empty() {
            return Ok(Unit::ONE);
        }
        let unit = parser.product()?;
        if let Some(c) = parser.rest().chars().next() {
            let help =
                if c == ')' { "no bracket is open here" } else { "join units with `*` or `/`, as in N*s/m" };
            return Err(parser.error(parser.at, parser.at + c.len_utf8(), format!("unexpected `{c}`"), help));
        }
        if !unit.factor.is_normal() {
            return Err(parser.error(0, text.len(), "the numbers of this unit are out of range", ""));
        }
        Ok(unit)
    }

    fn times(self, other: Unit) -> Unit {
        Unit { factor: self.factor * other.factor, dimension: self.dimension.mul(other.dimension) }
    }

    fn over(self, other: Unit) -> Unit {
        Unit { factor: self.factor / other.factor, dimension: self.dimension.div(other.dimension) }
    }
}

/// Raised digits and the raised minus, in the order of `0123456789-`.
const RAISED: [char; 11] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹', '⁻'];

/// A number that scales a unit.
fn scale(name: &str) -> Option<f64> {
    let digits = name.starts_with(|c: char| c.is_ascii_digit());
    name.parse::<f64>().ok().filter(|x| digits && *x > 0.0 && x.is_finite())
}

struct Parser<'t> {
    text: &'t str,
    at: usize,
    depth: usize,
}

impl<'t> Parser<'t> {
    fn rest(&self) -> &'t str {
        &self.text[self.at..]
    }

    fn space(&mut self) {
        self.at = self.text.len() - self.rest().trim_start().len();
    }

    /// Steps over one of these characters and the white space after it.
    fn take(&mut self, characters: &[char]) -> Option<char> {
        let found = self.rest().chars().next().filter(|c| characters.contains(c))?;
        self.at += found.len_utf8();
        self.space();
        Some(found)
    }

    fn error(&self, start: usize, end: usize, message: impl Into<String>, help: &str) -> UnitError {
        let help = (!help.is_empty()).then(|| help.to_owned());
        UnitError { message: message.into(), span: Span::new(start, end), help }
    }

    fn product(&mut self) -> Result<Unit, UnitError> {
        let mut unit = self.factor()?;
        loop {
            match self.take(&['*', '·', '/']) {
                Some('/') => unit = unit.over(self.factor()?),
                Some(_) => unit = unit.times(self.factor()?),
                None => return Ok(unit),
            }
        }
    }

    fn factor(&mut self) -> Result<Unit, UnitError> {
        let start = self.at;
        let base = match self.take(&['(']) {
            Some(_) => self.group(start)?,
            None => self.name()?,
        };
        let exponent = match self.raised() {
            Some(exponent) => exponent,
            None if self.take(&['^']).is_none() => return Ok(base),
            None => self.exponent()?,
        };
        let (factor, dimension) = (base.factor.powf(exponent), base.dimension.pow(exponent));
        match dimension {
            Some(dimension) if factor.is_finite() && factor > 0.0 => Ok(Unit { factor, dimension }),
            _ => Err(self.error(
                start,
                self.at,
                format!("the power {exponent} of this unit is out of range"),
                "",
            )),
        }
    }

    fn group(&mut self, start: usize) -> Result<Unit, UnitError> {
        self.depth += 1;
        if self.depth > 16 {
            return Err(self.error(start, start + 1, "too many brackets in a unit", ""));
        }
        let unit = self.product()?;
        self.depth -= 1;
        match self.take(&[')']) {
            Some(_) => Ok(unit),
            None => Err(self.error(start, start + 1, "this bracket is never closed", "")),
        }
    }

    fn name(&mut self) -> Result<Unit, UnitError> {
        let start = self.at;
        let rest = self.rest();
        let ends =
            |c: char| !(c.is_alphanumeric() || matches!(c, '%' | '°' | '_' | '.')) || RAISED.contains(&c);
        let name = &rest[..rest.find(ends).unwrap_or(rest.len())];
        self.at += name.len();
        self.space();
        if let Some(factor) = scale(name) {
            return Ok(Unit { factor, ..Unit::ONE });
        }
        if name.is_empty() {
            let end = start + rest.chars().next().map_or(0, char::len_utf8);
            return Err(self.error(start, end, "a unit is missing here", ""));
        }
        let end = start + name.len();
        let unit = table::find(name).map(|(factor, dimension)| Unit { factor, dimension });
        unit.ok_or_else(|| {
            let help = match name {
                "degC" | "°C" | "C°" | "degF" | "°F" => "temperatures are in K".into(),
                _ if name.starts_with(|c: char| c.is_ascii_digit()) => {
                    "a number in a unit is positive and stands alone: rev/4096, 0.5*mm".into()
                }
                _ => match nearest(name, table::names()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => {
                        "units are SI names with prefixes, joined by `*` and `/`: N*s/m, mm, kN, rad/s".into()
                    }
                },
            };
            self.error(start, end, format!("unknown unit `{name}`"), &help)
        })
    }

    /// A power in raised digits, as in `m/s²` and `s⁻¹`; none if there is none, or too many digits.
    fn raised(&mut self) -> Option<f64> {
        let rest = self.rest();
        let end = rest.find(|c| !RAISED.contains(&c)).unwrap_or(rest.len());
        let digit = |c| RAISED.iter().position(|r| *r == c);
        let plain: String =
            rest[..end].chars().filter_map(digit).filter_map(|k| "0123456789-".chars().nth(k)).collect();
        let power = plain.parse::<i8>().ok()?;
        self.at += end;
        self.space();
        Some(f64::from(power))
    }

    /// What stands after `^`: a number, or two of them as `(1/3)`.
    fn exponent(&mut self) -> Result<f64, UnitError> {
        let start = self.at;
        if self.take(&['(']).is_none() {
            return self.decimal();
        }
        let top = self.decimal()?;
        let bottom = if self.take(&['/']).is_some() { self.decimal()? } else { 1.0 };
        match self.take(&[')']) {
            Some(_) if (top / bottom).is_finite() => Ok(top / bottom),
            Some(_) => Err(self.error(start, self.at, "this power is not a number", "")),
            None => Err(self.error(start, start + 1, "this bracket is never closed", "")),
        }
    }

    fn decimal(&mut self) -> Result<f64, UnitError> {
        let (start, rest) = (self.at, self.rest());
        let sign = usize::from(rest.starts_with(['-', '+']));
        let length = sign + rest[sign..].bytes().take_while(|b| b.is_ascii_digit() || *b == b'.').count();
        self.at += length;
        self.space();
        rest[..length].parse().map_err(|_| {
            let end = start + length.max(rest.chars().next().map_or(0, char::len_utf8));
            self.error(start, end, "a power must be a number", "as in s^2 or m^-1")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn units_have_their_factor_and_dimension() {
        let check = |text: &str, factor: f64, dimension: &str| {
            let unit = Unit::parse(text).unwrap_or_else(|e| panic!("{text}: {e}"));
            assert!((unit.factor / factor - 1.0).abs() < 1e-14, "{text}: {}", unit.factor);
            assert_eq!(unit.dimension.to_string(), dimension, "{text}");
        };
        check("", 1.0, "1");
        check(" 1 ", 1.0, "1");
        check("%", 0.01, "1");
        check("rad", 1.0, "1");
        check("deg", std::f64::consts::PI / 180.0, "1");
        check("mrad", 1e-3, "1");
        check("rpm", std::f64::consts::PI / 30.0, "1/s");
        check("1/s", 1.0, "1/s");
        check("rad/s", 1.0, "1/s");
        check("kHz", 1e3, "1/s");
        check("1/s^2", 1.0, "1/s^2");
        check("m/s^2", 1.0, "m/s^2");
        check("m*s^-2", 1.0, "m/s^2");
        check("mm", 1e-3, "m");
        check("um", 1e-6, "m");
        check("µm", 1e-6, "m");
        check("μm", 1e-6, "m");
        check("ms", 1e-3, "s");
        check("min", 60.0, "s");
        check("h", 3600.0, "s");
        check("kg", 1.0, "kg");
        assert_eq!(Unit::parse("kg").unwrap(), Unit { factor: 1.0, dimension: Dimension::KILOGRAM });
        check("g", 1e-3, "kg");
        check("mg", 1e-6, "kg");
        check("t", 1e3, "kg");
        check("kN", 1e3, "N");
        check("kg*m/s^2", 1.0, "N");
        check("N*s/m", 1.0, "N*s/m");
        check("kg/s", 1.0, "N*s/m");
        check("N/mm", 1e3, "N/m");
        check("N/m^3", 1.0, "N/m^3");
        check("N*m", 1.0, "N*m");
        check("kg*m^2", 1.0, "kg*m^2");
        check("kg/m^3", 1.0, "kg/m^3");
        check("N*m*s/rad", 1.0, "N*m*s");
        check("m/N", 1.0, "m/N");
        check("MPa", 1e6, "N/m^2");
        check("V", 1.0, "V");
        check("V/s", 1.0, "V/s");
        check("mV", 1e-3, "V");
        check("A", 1.0, "A");
        check("N/A", 1.0, "V*s/m");
        check("N/(m*s)", 1.0, "N/(m*s)");
        check("N/m/s", 1.0, "N/(m*s)");
        check("(m/s)^2", 1.0, "m^2/s^2");
        check("m^0.5", 1.0, "m^(1/2)");
        check("mm^(1/3)", 0.1, "m^(1/3)");
        check("m / s", 1.0, "m/s");
        check("m/s²", 1.0, "m/s^2");
        check("N m⁻¹".replace(' ', "*").as_str(), 1.0, "N/m");
        check("kg*m²/s²", 1.0, "N*m");
        check("mNm", 1e-3, "N*m");
        check("psi", 6_894.757_293_168, "N/m^2");
        check("inch", 0.0254, "m");
        check("turn", 2.0 * std::f64::consts::PI, "1");
        check("count", 1.0, "1");
        check("rev/4096", 2.0 * std::f64::consts::PI / 4096.0, "1");
        check("0.5*mm", 0.5e-3, "m");
        check("mm/200", 5e-6, "m");
    }

    #[test]
    fn mistakes_are_shown() {
        let check = |text: &str, place: std::ops::Range<usize>, message: &str, help: &str| {
            let error = Unit::parse(text).expect_err(text);
            assert_eq!(error.span.range(), place, "{text}: {error:?}");
            assert!(error.message.contains(message), "{text}: {error:?}");
            assert!(error.help.as_deref().unwrap_or("").contains(help), "{text}: {error:?}");
        };
        check("N*sec", 2..5, "unknown unit `sec`", "");
        check("rads/s", 0..4, "unknown unit `rads`", "`rad`");
        check("n", 0..1, "unknown unit `n`", "`N`");
        check("N s", 2..3, "unexpected `s`", "N*s/m");
        check("N*", 2..2, "missing", "");
        check("m//s", 2..3, "missing", "");
        check("m/s^", 4..4, "power", "");
        check("m^x", 2..3, "power", "");
        check("m^99999", 0..7, "out of range", "");
        check("(m", 0..1, "never closed", "");
        check("m)", 1..2, "unexpected `)`", "open");
        check("2m", 0..2, "unknown unit `2m`", "stands alone");
        check("rev/0", 4..5, "unknown unit `0`", "positive");
        check("1e300*1e300*m", 0..13, "out of range", "");
        check("rev/1e400", 4..9, "unknown unit `1e400`", "positive");
        check("m⁻", 1..4, "unexpected", "");
        check("°C", 0..3, "unknown unit", "K");
        check(&"(".repeat(1000), 16..17, "too many", "");
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "[a-zµNms%0-9*/^().° -]{0,24}|\\PC{0,12}") {
            if let Err(error) = Unit::parse(&text) {
                prop_assert!(text.get(error.span.range()).is_some());
            }
        }

        #[test]
        fn printed_dimensions_read_back(powers in proptest::array::uniform5(-24_i8..=24)) {
            let base = ["kg", "m", "s", "A", "K"].map(|u| Unit::parse(u).unwrap().dimension);
            let twelfth = |(u, p): (&Dimension, &i8)| u.pow(f64::from(*p) / 12.0).unwrap();
            let dimension = base.iter().zip(&powers).map(twelfth).fold(Dimension::NONE, Dimension::mul);
            let unit = Unit::parse(&dimension.to_string()).unwrap();
            prop_assert_eq!(unit.dimension, dimension);
            prop_assert!((unit.factor - 1.0).abs() < 1e-12);
        }
    }
}
