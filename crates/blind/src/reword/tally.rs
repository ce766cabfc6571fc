//! How often each rewording was tried, and how often the answers agreed.

use super::rewording::Rewording;
use crate::markdown::markdown;
use crate::table::Table;

/// One case in other words.
#[derive(Clone, Debug)]
pub(super) struct Outcome {
    pub(super) index: usize,
    pub(super) command: &'static str,
    pub(super) kind: &'static str,
    /// In what, if the answers do.
    pub(super) disagrees: Option<String>,
}

/// The table, and a line for each disagreement.
pub(super) fn tally(rows: &[&Rewording], all: &[Outcome]) -> Table {
    let row = |name: &str, agree: &str, of: &dyn Fn(&Outcome) -> bool| {
        let count = |command: &str, disagrees: bool| {
            let fits = |o: &&Outcome| of(o) && o.command == command && (!disagrees || o.disagrees.is_some());
            all.iter().filter(fits).count().to_string()
        };
        let counts = ["run", "gap"].map(|command| [count(command, false), count(command, true)]);
        [vec![name.to_owned(), agree.to_owned()], counts.concat()].concat()
    };
    let mut lines: Vec<Vec<String>> =
        rows.iter().map(|r| row(r.name, r.agree.word(), &|o| o.kind == r.name)).collect();
    lines.push(row("all", "", &|_| true));
    let line = |o: &Outcome| {
        let why = o.disagrees.as_ref()?;
        Some(format!("{} {}, {}: {why}\n", o.index, o.command, o.kind))
    };
    let head = ["in other words", "must agree", "`run`", "of these disagree", "`gap`", "of these disagree"];
    Table { name: "reword", table: markdown(&head, &lines), failures: all.iter().filter_map(line).collect() }
}
