//! Expressions of the language of the specs in Unicode: `-0.3*sgn(y1)^2` as `−0.3·sgn(y₁)²`.

use crate::table::{by_error, four};

const GREEK: [(&str, &str); 20] = [
    ("alpha", "α"),
    ("beta", "β"),
    ("gamma", "γ"),
    ("delta", "δ"),
    ("eps", "ε"),
    ("epsilon", "ε"),
    ("zeta", "ζ"),
    ("eta", "η"),
    ("theta", "θ"),
    ("kappa", "κ"),
    ("lambda", "λ"),
    ("mu", "μ"),
    ("nu", "ν"),
    ("xi", "ξ"),
    ("pi", "π"),
    ("rho", "ρ"),
    ("sigma", "σ"),
    ("tau", "τ"),
    ("phi", "φ"),
    ("omega", "ω"),
];

/// The expression. Numbers that are one of `found` (value and half of its 95 % interval) have the digits that
/// it allows, others four.
pub(crate) fn expression(text: &str, found: &[(f64, f64)]) -> String {
    let letters: Vec<char> = text.chars().collect();
    let (mut out, mut k) = (String::new(), 0);
    while k < letters.len() {
        let c = letters[k];
        let end = |inside: &dyn Fn(usize, char) -> bool| {
            (k..letters.len()).find(|&j| !inside(j, letters[j])).unwrap_or(letters.len())
        };
        if c.is_ascii_digit() || (c == '.' && letters.get(k + 1).is_some_and(char::is_ascii_digit)) {
            let part = |j: usize, c: char| {
                let power = |c: char| c == 'e' || c == 'E';
                let sign = matches!(c, '+' | '-') && power(letters[j - 1]);
                let digit = |k: usize| letters.get(k).is_some_and(char::is_ascii_digit);
                let signed = matches!(letters.get(j + 1), Some('+' | '-')) && digit(j + 2);
                c.is_ascii_digit()
                    || c == '.'
                    || (j > k && sign)
                    || (j > k && power(c) && (digit(j + 1) || signed))
            };
            let stop = end(&part);
            let word: String = letters[k..stop].iter().collect();
            out += &word.parse().map_or(word.clone(), |x| number(x, found));
            k = stop;
        } else if c.is_alphabetic() || c == '_' {
            let stop = end(&|_, c| c.is_alphanumeric() || c == '_');
            let word: String = letters[k..stop].iter().collect();
            match closing(&letters, stop).filter(|_| word == "abs") {
                Some(close) => {
                    let inside: String = letters[stop + 1..close].iter().collect();
                    out += &format!("|{}|", expression(&inside, found));
                    k = close + 1;
                }
                None => {
                    out += &name(&word);
                    k = stop;
                }
            }
        } else if c == '^' {
            let stop =
                (k + 1..letters.len()).find(|&j| !letters[j].is_ascii_digit()).unwrap_or(letters.len());
            let whole = stop > k + 1 && letters.get(stop) != Some(&'.');
            let digits: String = letters[k + 1..stop].iter().collect();
            out += &if whole { raised(&digits) } else { "^".to_owned() };
            k = if whole { stop } else { k + 1 };
        } else {
            out.push(match c {
                '*' => '·',
                '-' => '−',
                c => c,
            });
            k += 1;
        }
    }
    out
}

/// The bracket that closes the one at `open`, if one opens there.
fn closing(letters: &[char], open: usize) -> Option<usize> {
    let mut depth = 0_i32;
    for (k, c) in letters.iter().enumerate().skip(open) {
        depth += match c {
            '(' => 1,
            ')' => -1,
            _ => 0,
        };
        if depth == 0 {
            return (k > open).then_some(k);
        }
    }
    None
}

/// A name with Greek letters and lowered digits.
pub(crate) fn name(word: &str) -> String {
    let stem = word.trim_end_matches(|c: char| c.is_ascii_digit());
    let (stem, digits) = if stem.is_empty() { (word, "") } else { (stem, &word[stem.len()..]) };
    let stem = GREEK.iter().find(|(plain, _)| *plain == stem).map_or(stem, |(_, letter)| letter);
    let low = |c: char| c.to_digit(10).and_then(|d| char::from_u32(0x2080 + d)).unwrap_or(c);
    stem.chars().chain(digits.chars().map(low)).collect()
}

/// The name of a rate: a dot above a letter, `d…/dt` of a word.
pub(crate) fn rate(state: &str) -> String {
    let shown = name(state);
    let mut letters = shown.chars();
    let first = letters.next().unwrap_or('x');
    let rest: String = letters.collect();
    let short = first.is_alphabetic() && rest.chars().all(|c| ('\u{2080}'..='\u{2089}').contains(&c));
    if short { format!("{first}\u{307}{rest}") } else { format!("d{shown}/dt") }
}

fn raised(digits: &str) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    digits.chars().filter_map(|c| c.to_digit(10)).map(|d| DIGITS[d as usize]).collect()
}

fn number(x: f64, found: &[(f64, f64)]) -> String {
    let same = |y: f64| (x - y.abs()).abs() <= 1e-9 * x.abs();
    found.iter().find(|(value, _)| same(*value)).map_or_else(|| four(x), |(_, error)| by_error(x, *error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_expression_reads_as_in_a_book() {
        for (text, shown) in [
            ("-0.3*sgn(y1) + x1^2", "−0.3·sgn(y₁) + x₁²"),
            ("2.5e-07*v^1.5", "2.5e-7·v^1.5"),
            ("mu0*N*du", "μ₀·N·du"),
            ("c_y*abs(v - abs(u))", "c_y·|v − |u||"),
            ("12.3456789e3", "12346"),
        ] {
            assert_eq!(expression(text, &[]), shown);
        }
        assert_eq!(expression("0.298341*x", &[(-0.298341, 0.0083)]), "0.298·x");
        assert_eq!(expression("3.214e-5*x", &[(3.214e-5, 4.1e-7)]), "3.21·10⁻⁵·x");
        assert_eq!((rate("y1").as_str(), rate("speed").as_str()), ("y\u{307}₁", "dspeed/dt"));
    }
}
