//! How often each command was run, and how it ended.

use crate::markdown::markdown;
use crate::table::Table;

/// Exit codes that the reference names.
const CODES: [i32; 5] = [0, 1, 2, 3, 130];

/// How one execution ended.
#[derive(Clone, Debug)]
pub(super) struct Outcome {
    pub(super) index: usize,
    pub(super) command: &'static str,
    pub(super) damaged: bool,
    /// None if it was killed.
    pub(super) code: Option<i32>,
    pub(super) hung: bool,
    pub(super) panicked: bool,
    /// What is wrong about the answer.
    pub(super) wrong: Option<String>,
    pub(super) seconds: f64,
}

impl Outcome {
    /// Whether it ended as no program may.
    pub(super) fn failed(&self) -> bool {
        self.panicked || self.hung || !self.code.is_some_and(|code| CODES.contains(&code))
    }
}

/// The table, and a line for each execution that failed or was wrong.
pub(super) fn tally(all: &[Outcome]) -> Table {
    let head = [
        "command",
        "executions",
        "of these damaged",
        "exit 0",
        "1",
        "2",
        "3",
        "130",
        "another",
        "panics",
        "hangs",
        "wrong verdicts",
        "slowest",
    ];
    let mut commands: Vec<&str> = all.iter().map(|o| o.command).collect();
    commands.sort_unstable();
    commands.dedup();
    let row = |name: &str, of: &dyn Fn(&Outcome) -> bool| {
        let of: Vec<&Outcome> = all.iter().filter(|o| of(o)).collect();
        let count = |keep: &dyn Fn(&Outcome) -> bool| of.iter().filter(|o| keep(o)).count().to_string();
        let mut cells = vec![name.to_owned(), of.len().to_string(), count(&|o| o.damaged)];
        cells.extend(CODES.iter().map(|code| count(&|o| o.code == Some(*code))));
        let another = |o: &Outcome| !o.hung && !o.code.is_some_and(|code| CODES.contains(&code));
        cells.extend([
            count(&another),
            count(&|o| o.panicked),
            count(&|o| o.hung),
            count(&|o| o.wrong.is_some()),
        ]);
        cells.push(format!("{:.1} s", of.iter().map(|o| o.seconds).fold(0.0, f64::max)));
        cells
    };
    let mut rows: Vec<Vec<String>> = commands.iter().map(|name| row(name, &|o| o.command == *name)).collect();
    rows.push(row("all", &|_| true));
    let line = |o: &Outcome| {
        let why = match &o.wrong {
            _ if o.panicked => "panicked".to_owned(),
            _ if o.hung => "hung".to_owned(),
            _ if o.failed() => format!("ended with {:?}", o.code),
            Some(wrong) => wrong.clone(),
            None => return None,
        };
        Some(format!("{} {}: {why}\n", o.index, o.command))
    };
    Table { name: "odd", table: markdown(&head, &rows), failures: all.iter().filter_map(line).collect() }
}
