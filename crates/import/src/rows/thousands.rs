//! Marks of thousands, as in `1.234,5` and `1,234.5`: no number of a data file may have them, for a single one
//! is a decimal mark to another reader.

/// Whether a text is a number with marks of thousands, whichever mark is its decimal one.
pub(super) fn is_grouped(text: &str) -> bool {
    let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
    // Nearly all fields are told apart by their first characters.
    let Some(at) = digits.find(|c: char| !c.is_ascii_digit()).filter(|at| (1..=3).contains(at)) else {
        return false;
    };
    let mark = digits[at..].chars().next().unwrap_or_default();
    if digits.starts_with('0') || !matches!(mark, '.' | ',' | '\'' | '’' | ' ' | '\u{a0}' | '\u{202f}') {
        return false;
    }
    let mut groups = digits[at..].split(mark).skip(1).peekable();
    let (mut whole, mut decimals) = (0, None);
    while let Some(group) = groups.next() {
        let last = groups.peek().is_none();
        let (front, behind) = match group.find(['.', ',']).filter(|_| last) {
            Some(at) => (&group[..at], Some(&group[at + 1..])),
            None => (group, None),
        };
        if front.len() != 3 || !front.bytes().all(|b| b.is_ascii_digit()) {
            return false;
        }
        (whole, decimals) = (whole + 1, behind);
    }
    let decimal = decimals.is_some_and(|d| d.bytes().all(|b| b.is_ascii_digit()));
    match mark {
        // Of two columns that a blank parts, one ends with a decimal comma as often.
        ' ' => decimal,
        '.' | ',' => decimal || (decimals.is_none() && whole > 1),
        _ => decimal || decimals.is_none(),
    }
}

/// What the numbers of a column look like, as far as it tells whether `1,234` is more than a thousand.
#[derive(Clone, Debug, Default)]
pub(super) struct Marks {
    /// The first number with three digits behind its mark, and none that is zero before it.
    three: Option<String>,
    /// The first whole number of three digits.
    hundreds: Option<String>,
    /// Whether any number has another count of digits behind its mark, or an exponent.
    decimals: bool,
}

impl Marks {
    /// Sees a number as it is written.
    pub(super) fn see(&mut self, text: &str) {
        if self.decimals {
            return;
        }
        let digits = text.trim_start_matches(['-', '+']);
        let all = |part: &str| part.bytes().all(|b| b.is_ascii_digit());
        match digits.split_once([',', '.']) {
            None if !all(digits) => self.decimals = true,
            None if digits.len() == 3 => drop(self.hundreds.get_or_insert_with(|| text.to_owned())),
            None => {}
            Some((front, behind)) if behind.len() == 3 && all(behind) && !front.starts_with('0') => {
                self.three.get_or_insert_with(|| text.to_owned());
            }
            Some(_) => self.decimals = true,
        }
    }

    /// Two numbers that say so, if the mark may be one of thousands: programs that write three decimals write
    /// them all, and those that drop zeros at the end do not always leave three.
    pub(super) fn doubt(&self) -> Option<(&str, &str)> {
        if self.decimals { None } else { self.three.as_deref().zip(self.hundreds.as_deref()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_of_thousands_are_told_from_decimal_marks() {
        for (text, grouped) in [
            ("1.234,5", true),
            ("-1,234.5", true),
            ("1,234,567", true),
            ("1.234.567", true),
            ("1'000", true),
            ("12’345,6", true),
            ("99\u{202f}147", true),
            ("99 147,02", true),
            ("99 147", false),
            ("1,234", false),
            ("1.234", false),
            ("0.123,4", false),
            ("1234,567.8", false),
            ("1.23,4", false),
            ("12.05.2024", false),
            ("1,234.5.6", false),
            ("192.168.1.1", false),
            ("1.234,5e3", false),
            ("", false),
            ("-", false),
            ("a", false),
        ] {
            assert_eq!(is_grouped(text), grouped, "{text}");
        }
    }

    #[test]
    fn a_single_mark_is_in_doubt_beside_hundreds_alone() {
        let doubt = |all: &[&str]| {
            let mut marks = Marks::default();
            all.iter().for_each(|text| marks.see(text));
            marks.doubt().is_some()
        };
        for (all, expected) in [
            (&["998", "-999", "1,000", "1,001"][..], true),
            (&["998.001", "999.123", "1.000"], false),
            (&["999", "1.25", "1.125"], false),
            (&["99", "1.125"], false),
            (&["999", "0.125"], false),
            (&["999", "1.125", "1e3"], false),
        ] {
            assert_eq!(doubt(all), expected, "{all:?}");
        }
    }
}
