//! Names in expressions, replaced in their text.

use phisindy_expr::parse;

/// The text with every name for which `with` has something replaced by that, all in one pass; the rest of the
/// text stays as it is written.
///
/// A text that is no expression comes back unchanged: whoever compiles it says what is wrong with it.
pub(crate) fn substitute<'a>(text: &str, with: impl Fn(&str) -> Option<&'a str>) -> String {
    let Ok(ast) = parse(text) else { return text.to_owned() };
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
