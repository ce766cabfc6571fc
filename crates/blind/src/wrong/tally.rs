//! How often a mistake is reported, and how often the answer is wrong without a warning.

use crate::Table;
use crate::markdown::{markdown, short};
use std::fmt::Write;

/// Five standard deviations for somebody who knows what to look for: less cannot be seen.
pub(super) const VISIBLE: f64 = 25.0;
/// An interval whose half width would have to be twice as long to hold the truth: chance does that once in
/// ten thousand.
const FAR: f64 = 2.0;

/// What the program made of a set.
#[derive(Clone, Debug, Default)]
pub(super) struct Outcome {
    pub(super) set: String,
    pub(super) kind: String,
    /// What is wrong, and of which rig.
    pub(super) said: String,
    /// Whether the dictionary holds all that the known part lacks.
    pub(super) inside: bool,
    /// Chi square that the best friction leaves of the mistake.
    pub(super) visible: f64,
    /// A word for each doubt that is reported; empty without any.
    pub(super) reported: Vec<String>,
    /// By how many half widths of its interval the worst coefficient is off: above 1 the interval misses the
    /// truth.
    pub(super) off: f64,
    /// Intervals that hold the truth, and all of them.
    pub(super) covered: (usize, usize),
    pub(super) warnings: Vec<String>,
}

/// Counts. Mistakes that the dictionary makes good, and those that cannot be seen, are counted apart.
pub(super) fn tally(all: &[Outcome]) -> Table {
    let mut kinds: Vec<&str> = Vec::new();
    all.iter().map(|o| o.kind.as_str()).filter(|k| *k != "nothing").for_each(|k| {
        if !kinds.contains(&k) {
            kinds.push(k);
        }
    });
    let wrong = |o: &&Outcome| o.kind != "nothing" && !o.inside && o.visible >= VISIBLE;
    let mut rows: Vec<Vec<String>> = kinds
        .iter()
        .map(|kind| row(kind, &all.iter().filter(|o| o.kind == *kind).filter(wrong).collect::<Vec<_>>()))
        .collect();
    let picked = |keep: &dyn Fn(&Outcome) -> bool| all.iter().filter(|o| keep(o)).collect::<Vec<_>>();
    rows.push(row("all of these", &all.iter().filter(wrong).collect::<Vec<_>>()));
    let made_good = |o: &Outcome| o.kind != "nothing" && o.inside;
    rows.push(row("the dictionary makes it good", &picked(&made_good)));
    let unseen = |o: &Outcome| o.kind != "nothing" && !o.inside && o.visible < VISIBLE;
    rows.push(row("cannot be seen", &picked(&unseen)));
    rows.push(row("nothing is wrong", &picked(&|o| o.kind == "nothing")));
    let head = [
        "wrong",
        "sets",
        "told",
        "by the residual",
        "by validation",
        "by a bound",
        "rejected or refused",
        "silent, all intervals right",
        "silent, one misses",
        "of these by more than its half width",
        "intervals that hold the truth, if silent",
    ];
    let mut failures = String::new();
    let right = |o: &Outcome| o.kind == "nothing" || o.inside;
    for o in all {
        let silent = o.reported.is_empty();
        let why = match (right(o), silent) {
            (true, false) => format!("false alarm ({})", o.reported.join(", ")),
            (_, true) if o.off > 1.0 => "a miss in silence".to_owned(),
            (false, true) if o.visible >= VISIBLE => "silent".to_owned(),
            _ => continue,
        };
        let _ = writeln!(
            failures,
            "{} {why}: {}; chi square {}, off by {} half widths; {}",
            o.set,
            o.said,
            short(o.visible),
            short(o.off),
            o.warnings.join(" | ")
        );
    }
    Table { name: "wrong", table: markdown(&head, &rows), failures }
}

fn row(name: &str, of: &[&Outcome]) -> Vec<String> {
    let count = |keep: &dyn Fn(&Outcome) -> bool| of.iter().filter(|o| keep(o)).count();
    let by = |words: &[&str]| count(&|o| o.reported.iter().any(|t| words.contains(&t.as_str())));
    let silent = |o: &Outcome| o.reported.is_empty();
    let numbers = [
        of.len(),
        count(&|o| !silent(o)),
        by(&["residual"]),
        by(&["validation"]),
        by(&["bound"]),
        by(&["rejected", "refused"]),
        count(&|o| silent(o) && o.off <= 1.0),
        count(&|o| silent(o) && o.off > 1.0),
        count(&|o| silent(o) && o.off > FAR),
    ];
    let covered =
        of.iter().filter(|o| silent(o)).fold((0, 0), |(h, n), o| (h + o.covered.0, n + o.covered.1));
    let mut cells = vec![name.to_owned()];
    cells.extend(numbers.map(|n| n.to_string()));
    cells.push(if covered.1 > 0 { format!("{} of {}", covered.0, covered.1) } else { "-".to_owned() });
    cells
}
