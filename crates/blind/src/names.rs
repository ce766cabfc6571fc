//! Replaces names in the text of expressions.

use phisindy_expr::parse_with;

/// The text with every name replaced for which `with` returns something, all in one pass; `rate(v)` is the name
/// `rate v`. The rest of the text does not change.
///
/// A text that is no expression is returned unchanged; its compilation reports the error.
pub(crate) fn substitute<'a>(text: &str, with: impl Fn(&str) -> Option<&'a str>) -> String {
    let Ok(ast) = parse_with(text, &["rate"]) else { return text.to_owned() };
    let mut out = String::with_capacity(text.len());
    let mut end = 0;
    for (name, span) in ast.names() {
        if let Some(new) = with(name) {
            out += &text[end..span.start];
            out += new;
            end = span.end;
        }
    }
    out + &text[end..]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_names_are_replaced() {
        let c = |name: &str| (name == "c").then_some("(2)");
        assert_eq!(substitute("Fc*exp(c)+c1-c", c), "Fc*exp((2))+c1-(2)");
    }

    #[test]
    fn what_is_put_in_is_not_replaced_again() {
        let swapped = |name: &str| match name {
            "x" => Some("y"),
            "y" => Some("x"),
            _ => None,
        };
        assert_eq!(substitute("x - 2*abs(y)", swapped), "y - 2*abs(x)");
    }
}
