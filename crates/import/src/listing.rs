//! Names of a file in a message, which stays readable however many and long they are.

use phisindy_expr::clipped;

/// Most names of a list.
const MOST_NAMES: usize = 20;
/// Most characters of a name, and bytes of a list after which no name begins.
const MOST_CHARACTERS: usize = 60;
const MOST_BYTES: usize = 600;

/// A name, cut where it is too long.
pub(crate) fn name(name: &str) -> String {
    clipped(name, MOST_CHARACTERS).into_owned()
}

/// The first names, with commas between them, and the number of those that are left out.
pub(crate) fn listing(names: &[String]) -> String {
    joined(names, name)
}

/// The same, each name in the marks that stand around names.
pub(crate) fn marked(names: &[String]) -> String {
    joined(names, |own| format!("`{}`", name(own)))
}

fn joined(names: &[String], form: impl Fn(&str) -> String) -> String {
    let mut text = String::new();
    for (k, own) in names.iter().enumerate() {
        if k == MOST_NAMES || text.len() > MOST_BYTES {
            return format!("{text} and {} more", names.len() - k);
        }
        if k > 0 {
            text.push_str(", ");
        }
        text.push_str(&form(own));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_and_many_names_make_no_long_message() {
        let names: Vec<String> = (0..5000).map(|k| format!("{k}{}", "µ".repeat(9000))).collect();
        let text = listing(&names);
        assert!(text.len() < 1000 && text.ends_with("more") && text.starts_with("0µµ"), "{text}");
        assert_eq!(listing(&names[..0]), "");
        let two = ["t".to_owned(), "x".to_owned()];
        assert_eq!((listing(&two), marked(&two)), ("t, x".to_owned(), "`t`, `x`".to_owned()));
    }
}
