//! Cells of a sweep: one text for every combination of values.

use crate::interrupt;
use phisindy::files::Assignment;
use phisindy::files::with_assignments;
use phisindy_phys::{Diagnostic, Sources};

/// One combination.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    /// What makes it differ from the spec, as `PATH=VALUE, ...`; empty for the spec itself.
    pub(crate) label: String,
    /// The spec's text with those values.
    pub(crate) text: String,
}

/// Values of one thing that varies: for each, what is set and what it is called.
pub(crate) type Axis = Vec<(String, Vec<Assignment>)>;

/// The pieces of a list of values, separated outside of brackets and texts.
pub(crate) fn listed(list: &str, separator: char) -> Vec<String> {
    let (mut pieces, mut piece) = (Vec::new(), String::new());
    let (mut depth, mut quoted, mut escaped) = (0_usize, false, false);
    for c in list.chars() {
        match c {
            '"' if !escaped => quoted = !quoted,
            '(' | '[' | '{' if !quoted => depth += 1,
            ')' | ']' | '}' if !quoted => depth = depth.saturating_sub(1),
            _ => {}
        }
        escaped = quoted && c == '\\' && !escaped;
        if c == separator && depth == 0 && !quoted {
            pieces.push(std::mem::take(&mut piece));
        } else {
            piece.push(c);
        }
    }
    pieces.push(piece);
    let trimmed = pieces.iter().map(|p| p.trim().to_owned());
    trimmed.filter(|p| !p.is_empty()).collect()
}

/// An axis that gives each of `paths` the same value.
pub(crate) fn vary(name: &str, paths: &[String], values: &[String]) -> Axis {
    let assigned = |value: &String| {
        let all = paths.iter().map(|path| Assignment { path: path.clone(), value: value.clone() });
        (format!("{name}={value}"), all.collect())
    };
    values.iter().map(assigned).collect()
}

/// Every combination of the axes, the last one varying fastest; none where the program is asked to end.
///
/// # Errors
/// A value that cannot be spliced into the text.
pub(crate) fn product(text: &str, axes: &[Axis], sources: &mut Sources) -> Result<Vec<Cell>, Diagnostic> {
    let mut cells = vec![Cell { label: String::new(), text: text.to_owned() }];
    for axis in axes.iter().filter(|axis| !axis.is_empty()) {
        let mut wider = Vec::new();
        for cell in &cells {
            // The caller looks for it too.
            if interrupt::requested() {
                return Ok(vec![]);
            }
            for (name, sets) in axis {
                let joint = if cell.label.is_empty() || name.is_empty() { "" } else { ", " };
                wider.push(Cell {
                    label: format!("{}{joint}{name}", cell.label),
                    text: with_assignments(cell.text.clone(), sets, sources)?,
                });
            }
        }
        cells = wider;
    }
    Ok(cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_split_outside_of_brackets_and_texts() {
        assert_eq!(listed("Relative(0.1), Additive(0.02)", ','), ["Relative(0.1)", "Additive(0.02)"]);
        assert_eq!(listed("Sensor({\"x\": (1e-6, \"m\")})", ',').len(), 1);
        assert_eq!(listed("[\"1\", \"a;b\"];[\"x\"];", ';'), ["[\"1\", \"a;b\"]", "[\"x\"]"]);
        assert_eq!(listed(" ", ','), [""; 0]);
    }

    #[test]
    fn cells_are_all_combinations() {
        let a = vary("a", &["a".into()], &["1".into(), "2".into()]);
        let b = vary("b", &["b".into(), "c".into()], &["3".into(), "4".into()]);
        let cells = product("(a: 0)", &[a, vec![], b], &mut Sources::default()).expect("good values");
        let labels: Vec<&str> = cells.iter().map(|c| c.label.as_str()).collect();
        assert_eq!(labels, ["a=1, b=3", "a=1, b=4", "a=2, b=3", "a=2, b=4"]);
        assert_eq!(cells[3].text, "(a: 2, b: 4, c: 4)");
    }
}
