//! Tables as text with aligned columns, and numbers with few digits.

/// Half width of a 95 % interval of the normal distribution, in standard deviations.
pub(crate) const REACH: f64 = 1.96;

/// The rows as lines; every column is as wide as its widest cell.
pub fn aligned(rows: &[Vec<String>]) -> Vec<String> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |k: usize| rows.iter().filter_map(|r| r.get(k)).map(|w| w.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(word, &width)| format!("{word:<width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect()
}

/// A number with five significant digits.
pub fn short(x: f64) -> String {
    digits(x, 5)
}

/// An interval with five digits, or more if its ends would read alike.
pub fn interval(low: f64, high: f64) -> String {
    let (low, high) = ends(low, high);
    format!("[{low}, {high}]")
}

/// The ends of such an interval.
pub fn ends(low: f64, high: f64) -> (String, String) {
    let with = |n: usize| (digits(low, n), digits(high, n));
    let apart = (5..=17).map(with).find(|(low, high)| low != high);
    apart.unwrap_or_else(|| with(5))
}

/// A number with at most this many significant digits.
fn digits(x: f64, digits: usize) -> String {
    if !x.is_finite() {
        return if x.is_nan() { "unknown".to_owned() } else { "unbounded".to_owned() };
    }
    let behind = digits - 1;
    let scientific = format!("{x:.behind$e}");
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let trimmed = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    match exponent {
        -4..=5 => trimmed(&format!("{x:.*}", (behind as i32 - exponent).max(0) as usize)),
        _ => format!("{}e{exponent}", trimmed(mantissa)),
    }
}

/// A unit with raised exponents; empty for a plain number.
pub fn raised(unit: &str) -> String {
    const RAISED: [(&str, &str); 8] = [
        ("^-1", "⁻¹"),
        ("^-2", "⁻²"),
        ("^-3", "⁻³"),
        ("^2", "²"),
        ("^3", "³"),
        ("^4", "⁴"),
        ("^5", "⁵"),
        ("*", "·"),
    ];
    if unit == "1" {
        return String::new();
    }
    RAISED.iter().fold(unit.to_owned(), |text, (plain, raised)| text.replace(plain, raised))
}

/// `0.298 ± 0.008`: a value with the digits that its error allows, which is shown with one digit, or two
/// where the first is a 1. Without a finite error the value has four digits.
pub fn with_error(value: f64, error: f64) -> String {
    let Rounded { value, error, shared } = rounded(value, error);
    match (error, shared) {
        (None, _) => value,
        (Some(error), 0) => format!("{value} ± {error}"),
        (Some(error), _) => format!("({value} ± {error})·10{}", exponent(shared)),
    }
}

/// The number alone, with the digits that its error allows.
pub(crate) fn by_error(value: f64, error: f64) -> String {
    let Rounded { value, shared, .. } = rounded(value, error);
    if shared == 0 { value } else { format!("{value}·10{}", exponent(shared)) }
}

/// A number and its error in digits, and the power of ten that both are in.
struct Rounded {
    value: String,
    error: Option<String>,
    shared: i32,
}

fn rounded(value: f64, error: f64) -> Rounded {
    if !(error.is_finite() && error > 0.0 && value.is_finite()) {
        return Rounded { value: digits(value, 4).replace('-', "−"), error: None, shared: 0 };
    }
    let decade = |x: f64| x.abs().log10().floor() as i32;
    // Powers of ten that both share keep numbers of any size short.
    let largest = decade(value.abs().max(error));
    let shared = if (-3..5).contains(&largest) { 0 } else { largest };
    let scale = 10f64.powi(shared);
    let (value, error) = (value / scale, error / scale);
    let first = error / 10f64.powi(decade(error));
    let places = (if first < 1.95 { 1 } else { 0 }) - decade(error);
    let decimals = places.max(0) as usize;
    // An error above ten rounds tens and more.
    let tens = 10f64.powi((-places).max(0));
    let shown = |x: f64| {
        let x = if places < 0 { tens * (x / tens).round() } else { x };
        format!("{x:.decimals$}").replace('-', "−")
    };
    Rounded { value: shown(value), error: Some(shown(error)), shared }
}

/// A number with four significant digits.
pub(crate) fn four(x: f64) -> String {
    digits(x, 4)
}

/// A number as raised digits.
fn exponent(power: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    power.to_string().chars().map(|c| c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_five_digits() {
        for (x, text) in [
            (0.0, "0"),
            (0.501_998_3, "0.502"),
            (-1234.567, "-1234.6"),
            (1.5e-7, "1.5e-7"),
            (3e10, "3e10"),
            (f64::INFINITY, "unbounded"),
        ] {
            assert_eq!(short(x), text);
        }
    }

    #[test]
    fn the_ends_of_an_interval_are_told_apart() {
        assert_eq!(interval(1.2, 1.3), "[1.2, 1.3]");
        assert_eq!(interval(1.200_000_1, 1.200_000_4), "[1.2000001, 1.2000004]");
        assert_eq!(interval(1.2, 1.200_000_4), "[1.2, 1.2000004]");
        assert_eq!(interval(2e-9, 2.000_001e-9), "[2e-9, 2.000001e-9]");
        // Nothing tells these apart.
        assert_eq!(interval(1.2, 1.2), "[1.2, 1.2]");
        assert_eq!(interval(f64::NEG_INFINITY, 3.0), "[unbounded, 3]");
        assert_eq!(interval(f64::NAN, f64::NAN), "[unknown, unknown]");
    }

    #[test]
    fn a_value_has_the_digits_that_its_error_allows() {
        for (value, error, text) in [
            (0.298_34, 0.0083, "0.298 ± 0.008"),
            (0.298_34, 0.0131, "0.298 ± 0.013"),
            (1191.4, 23.0, "1190 ± 20"),
            (-0.5, 0.0021, "−0.500 ± 0.002"),
            (3.214e-5, 4.1e-7, "(3.21 ± 0.04)·10⁻⁵"),
            (0.298_34, 0.0, "0.2983"),
            (2.0, f64::INFINITY, "2"),
        ] {
            assert_eq!(with_error(value, error), text);
        }
    }

    #[test]
    fn columns_are_aligned() {
        let rows = [["a", "b"], ["long", "c"]].map(|r| r.map(str::to_owned).to_vec());
        assert_eq!(aligned(&rows), ["a     b", "long  c"]);
    }
}
