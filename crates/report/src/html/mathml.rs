//! Equations as MathML; long ones are broken into lines.

use crate::markup::{Element, element, escaped};
use pulldown_latex::{Parser, RenderConfig, Storage, config::DisplayMode, push_mathml};

/// Approximate number of symbols on a line.
const LINE: usize = 62;

/// An equation in display style from LaTeX; LaTeX that cannot be converted is shown as it is.
pub(crate) fn equation(latex: &str) -> Element {
    let block = element("div").class("equation scroll").with("tabindex", 0).with("role", "group");
    let block = block.with("aria-label", "equation");
    match mathml(&broken(latex), latex) {
        Some(math) => block.raw(math),
        None => block.add(element("code").text(latex)),
    }
}

/// `plain` is the same LaTeX on one line, for copies and screen readers.
fn mathml(latex: &str, plain: &str) -> Option<String> {
    let storage = Storage::new();
    let events: Vec<_> = Parser::new(latex, &storage).collect::<Result<_, _>>().ok()?;
    // The renderer does not escape the annotation.
    let plain = escaped(plain);
    let config =
        RenderConfig { display_mode: DisplayMode::Block, annotation: Some(&plain), ..Default::default() };
    let mut out = String::new();
    push_mathml(&mut out, events.into_iter().map(Ok::<_, std::convert::Infallible>), config).ok()?;
    Some(out)
}

/// The equation on several aligned lines if it is too long for one. Each line begins with a sign outside of
/// all brackets.
fn broken(latex: &str) -> String {
    let Some((left, right)) = latex.split_once(" = ") else { return latex.to_owned() };
    let mut lines: Vec<String> = vec![String::new()];
    for piece in pieces(right) {
        let last = lines.len() - 1;
        if !lines[last].is_empty() && size(&lines[last]) + size(piece) > LINE {
            lines.push(piece.to_owned());
        } else {
            lines[last].push_str(piece);
        }
    }
    if lines.len() == 1 {
        return latex.to_owned();
    }
    // `{}` in front of a sign keeps it a binary operator.
    format!("\\begin{{aligned}} {left} &= {} \\end{{aligned}}", lines.join(" \\\\ &\\quad {}"))
}

/// The parts of a sum, split before each sign outside of brackets.
fn pieces(sum: &str) -> Vec<&str> {
    let (mut depth, mut from, mut out) = (0i32, 0, Vec::new());
    for (at, c) in sum.char_indices() {
        match c {
            '(' | '[' | '{' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            ' ' if depth == 0 && at > from => {
                let rest = &sum[at..];
                if rest.starts_with(" + ") || rest.starts_with(" - ") {
                    out.push(&sum[from..at]);
                    from = at;
                }
            }
            _ => {}
        }
    }
    out.push(&sum[from..]);
    out
}

/// Approximate number of visible symbols: one for a command, none for braces.
fn size(latex: &str) -> usize {
    let (mut count, mut command) = (0, false);
    for c in latex.chars() {
        match c {
            '\\' => (count, command) = (count + 1, true),
            c if command && c.is_ascii_alphabetic() => {}
            '{' | '}' | ' ' | '_' | '^' | ',' => command = false,
            _ => (count, command) = (count + 1, false),
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_equation_is_set() {
        let set =
            equation(r"\dot{y}_{1} = -0.2\,y_{1} + \cos\left(0.6\,t\right) - 0.3\,\operatorname{sgn}(y_{1})")
                .to_string();
        for part in ["<math", "sgn", "0.3", "cos"] {
            assert!(set.contains(part), "{part}: {set}");
        }
        assert!(!set.contains("merror"), "{set}");
    }

    #[test]
    fn a_long_sum_is_broken_outside_of_brackets() {
        assert_eq!(pieces(r"-a + \left(b - c\right) - d"), ["-a", r" + \left(b - c\right)", " - d"]);
        let long = format!("\\dot{{x}} = {}", ["\\frac{a}{b}\\left(c + d\\right)"; 30].join(" + "));
        let broken = broken(&long);
        assert!(broken.matches("\\\\").count() >= 2 && mathml(&broken, &long).is_some(), "{broken}");
    }
}
