//! Strings and numbers in specs.

pub(crate) use phisindy_phys::splice::quoted;

/// Four significant digits, for comments.
pub(crate) fn four_digits(x: f64) -> String {
    let size = x.abs();
    match () {
        () if x == 0.0 => "0".to_owned(),
        () if !(1e-3..1e6).contains(&size) => format!("{x:.3e}"),
        () => {
            let digits = (3 - size.log10().floor() as i32).clamp(0, 6) as usize;
            let text = format!("{x:.digits$}");
            if text.contains('.') {
                text.trim_end_matches('0').trim_end_matches('.').to_owned()
            } else {
                text
            }
        }
    }
}

/// Three significant digits: a start value is not more accurate.
pub(crate) fn three_digits(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (x, text) in [
            (0.0, "0"),
            (12345.0, "12345"),
            (0.5, "0.5"),
            (1.0 / 3.0, "0.3333"),
            (2e-5, "2.000e-5"),
            (250.0, "250"),
        ] {
            assert_eq!(four_digits(x), text);
        }
        assert_eq!(three_digits(1234.5), 1230.0);
    }

    #[test]
    fn headings_with_quotes_are_raw() {
        assert_eq!(quoted("x"), "\"x\"");
        assert_eq!(quoted("x \"a\""), "r#\"x \"a\"\"#");
        assert_eq!(quoted("x \"#a"), "r##\"x \"#a\"##");
    }
}
