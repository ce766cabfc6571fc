//! Replaces names in the text of an expression.

use crate::{ParseError, Span, parse};

/// The text of an expression with some of its names replaced, all in one pass; the rest of the text does
/// not change.
///
/// # Errors
/// The text is no expression.
///
/// ```
/// use phisindy_expr::rename;
/// let with = [("x".to_owned(), "v".to_owned()), ("v".to_owned(), "(x-y)".to_owned())];
/// assert_eq!(rename("x*exp(v) + 1e-6*ex", &with).unwrap(), "v*exp((x-y)) + 1e-6*ex");
/// ```
pub fn rename(text: &str, with: &[(String, String)]) -> Result<String, ParseError> {
    let ast = parse(text)?;
    let mut places: Vec<(&str, Span)> = ast.names().collect();
    places.sort_by_key(|(_, span)| span.start);
    let (mut out, mut end) = (String::with_capacity(text.len()), 0);
    for (name, span) in places {
        out.push_str(&text[end..span.start]);
        let replacement = with.iter().find(|(old, _)| old == name);
        out.push_str(replacement.map_or(name, |(_, new)| new));
        end = span.end;
    }
    out.push_str(&text[end..]);
    Ok(out)
}
