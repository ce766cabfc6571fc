//! Sentences with numbers in them: a number stays in one line with its error, its unit, its per cent.

use phisindy_phys::unit::Unit;

/// The text with spaces that break no line inside of values: `0.298 ± 0.008`, `95 %`, `1.2 N·s/m`.
pub(crate) fn tied(text: &str) -> String {
    let words: Vec<&str> = text.split(' ').collect();
    let mut out = words[0].to_owned();
    for pair in words.windows(2) {
        let of_one_value = pair.contains(&"±")
            || (ends_with_a_digit(pair[0]) && (pair[1].starts_with('%') || is_unit(pair[1])));
        out.push(if of_one_value { '\u{a0}' } else { ' ' });
        out += pair[1];
    }
    out
}

/// Also in a bracket: `(0.298 ± 0.008)`, and as a power: `10⁻³`.
fn ends_with_a_digit(word: &str) -> bool {
    word.trim_end_matches(')').ends_with(|c: char| c.is_numeric())
}

/// Whether the first factor of it is a unit: `N·s/m`, `1/s²,`.
fn is_unit(word: &str) -> bool {
    let word = word.strip_prefix("1/").unwrap_or(word);
    let first: String = word.chars().take_while(|c| c.is_alphabetic() || *c == '°').collect();
    !first.is_empty() && Unit::parse(&first).is_ok()
}

#[cfg(test)]
mod tests {
    use super::tied;

    #[test]
    fn a_value_stays_in_one_line() {
        for (text, shown) in [
            ("k = 0.298 ± 0.008 N", "k = 0.298~±~0.008~N"),
            ("(3.2 ± 0.1)·10⁻⁵ m/s², so far", "(3.2~±~0.1)·10⁻⁵~m/s², so far"),
            ("(95 %) and 5 % of it", "(95~%) and 5~% of it"),
            ("(0.30 ± 0.01) N·s/m·|v|", "(0.30~±~0.01)~N·s/m·|v|"),
            ("from 3 to 20 s; 4 times its noise", "from 3 to 20~s; 4 times its noise"),
            ("smoothed over 12 ms. A body of 2 kg", "smoothed over 12~ms. A body of 2~kg"),
            ("c = 12 s⁻¹ or 12 1/s, 12 s", "c = 12~s⁻¹ or 12~1/s, 12~s"),
            ("It takes 12 steps, 3 more", "It takes 12 steps, 3 more"),
            ("", ""),
            ("two  spaces ", "two  spaces "),
        ] {
            assert_eq!(tied(text), shown.replace('~', "\u{a0}"), "{text}");
        }
    }
}
