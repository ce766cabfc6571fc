//! How often the program reports a mistake, and how often it is wrong without a warning.

use crate::markdown::{markdown, short};
use crate::table::Table;
use std::fmt::Write;

/// Chi square of five standard deviations for an observer who knows the mistake: less is invisible.
pub(super) const VISIBLE: f64 = 25.0;
/// An error of twice the half width of an interval, which happens by chance once in ten thousand.
const FAR: f64 = 2.0;

/// The result of the program for a set.
#[derive(Clone, Debug, Default)]
pub(super) struct Outcome {
    pub(super) set: String,
    pub(super) kind: String,
    /// The mistake and the rig.
    pub(super) said: String,
    /// Whether the dictionary contains all that the known part lacks.
    pub(super) inside: bool,
    /// Chi square of the mistake that the best friction cannot absorb.
    pub(super) visible: f64,
    /// One word for each doubt that the program reports.
    pub(super) told: Vec<String>,
    /// The error of the worst coefficient in half widths of its interval: above 1 the interval misses the
    /// truth.
    pub(super) off: f64,
    /// The number of intervals that contain the truth, and of all intervals.
    pub(super) covered: (usize, usize),
    pub(super) warnings: Vec<String>,
}

/// Counts the outcomes. Mistakes that the dictionary compensates, and invisible ones, are counted apart.
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
        let silent = o.told.is_empty();
        let why = match (right(o), silent) {
            (true, false) => format!("false alarm ({})", o.told.join(", ")),
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
    let by = |words: &[&str]| count(&|o| o.told.iter().any(|t| words.contains(&t.as_str())));
    let silent = |o: &Outcome| o.told.is_empty();
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
