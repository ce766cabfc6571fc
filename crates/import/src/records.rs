//! Which rows of a file become which records of the spec.

use crate::remarks::Remark;
use crate::roles::{Input, Roles};
use crate::statistics::stops;
use crate::table::Table;
use crate::time_column::TimeColumn;
use std::ops::Range;

/// More trials than this are not written out.
const MOST_TRIALS: usize = 6;
/// Fewer rows than this are no record.
const FEWEST: usize = 20;

/// A record of the spec.
#[derive(Clone, Debug)]
pub struct RecordDraft {
    /// What it is called.
    pub name: String,
    /// Headings and values that select its rows.
    pub rows: Vec<(String, f64)>,
    /// Which run of the file, where no column counts them.
    pub run: Option<usize>,
    /// Times as the file has them.
    pub window: Option<(f64, f64)>,
    /// Whether it is fitted.
    pub fit: bool,
}

/// The records of a file.
pub(crate) struct Records {
    /// At least one.
    pub(crate) records: Vec<RecordDraft>,
    /// The rows of the first run, and of these the ones in motion; none if no run has enough good rows.
    pub(crate) first: Option<(Range<usize>, Range<usize>)>,
    /// Rows of the longest record.
    pub(crate) longest: usize,
    /// What should be known about them.
    pub(crate) remarks: Vec<Remark>,
}

impl Records {
    /// Out of the runs of the file.
    pub(crate) fn of(table: &Table, time: &TimeColumn, roles: &Roles, runs: &[Range<usize>]) -> Records {
        Rows { table, time, roles, remarks: vec![] }.records(runs)
    }
}

/// A run of the file of which a stretch of rows is good.
struct Run {
    /// All of its rows.
    rows: Range<usize>,
    /// The good ones.
    good: Range<usize>,
    /// Headings and values that select it.
    selected_by: Vec<(String, f64)>,
    /// Its number, where no column tells it.
    number: Option<usize>,
}

/// The rows of a file, and what they are.
struct Rows<'a> {
    table: &'a Table,
    time: &'a TimeColumn,
    roles: &'a Roles,
    remarks: Vec<Remark>,
}

impl Rows<'_> {
    fn values(&self, column: usize) -> &[f64] {
        &self.table.columns[column].values
    }

    /// As the file has it.
    fn times(&self) -> &[f64] {
        self.values(self.time.column)
    }

    fn raw(&self, column: usize) -> &str {
        &self.table.columns[column].heading.raw
    }

    fn records(mut self, runs: &[Range<usize>]) -> Records {
        let runs = self.good_runs(runs);
        let Some(first) = runs.first() else {
            let all =
                RecordDraft { name: "all".to_owned(), rows: vec![], run: None, window: None, fit: true };
            return Records { records: vec![all], first: None, longest: 0, remarks: self.remarks };
        };
        let first = Some((first.good.clone(), self.trimmed(first.good.clone())));
        let longest = runs.iter().map(|run| run.good.len()).max().unwrap_or(0);
        let (records, longest) = match runs.as_slice() {
            [run] => (self.halves(run), longest / 2),
            several => {
                let last = several.len() - 1;
                let all = several.iter().enumerate().map(|(k, run)| self.whole(k, run, k < last));
                (all.collect(), longest)
            }
        };
        Records { records, first, longest, remarks: self.remarks }
    }

    /// The first runs, as far as they have enough good rows.
    fn good_runs(&mut self, runs: &[Range<usize>]) -> Vec<Run> {
        let trials = if runs.len() > 1 { self.trial_column(runs) } else { None };
        let counted = runs.len() > 1 && trials.is_none();
        if counted {
            let line = self.table.row_numbers[runs[1].start];
            self.remarks.push(Remark::TimeGoesBack { line, runs: runs.len() });
        }
        let mut all = Vec::new();
        for (k, run) in runs.iter().enumerate().take(MOST_TRIALS) {
            let good = self.chosen(run.clone());
            if good.len() < FEWEST {
                continue;
            }
            let trial = trials.map(|c| (self.raw(c).to_owned(), self.values(c)[good.start]));
            let flag = self.roles.flag.as_ref().map(|flag| (self.raw(flag.column).to_owned(), flag.value));
            let selected_by = trial.into_iter().chain(flag).collect();
            all.push(Run { rows: run.clone(), good, selected_by, number: counted.then_some(k) });
        }
        if runs.len() > MOST_TRIALS {
            self.remarks.push(Remark::MoreTrials { all: runs.len(), written: MOST_TRIALS });
        }
        all
    }

    /// The time of the first and of the last row.
    fn span(&self, rows: &Range<usize>) -> (f64, f64) {
        let last = self.table.rows() - 1;
        (self.times()[rows.start.min(last)], self.times()[(rows.end - 1).min(last)])
    }

    /// A record of the `k`-th of several runs.
    fn whole(&self, k: usize, run: &Run, fit: bool) -> RecordDraft {
        let moving = self.trimmed(run.good.clone());
        let whole = self.selected(run.rows.clone()).len() == moving.len();
        let name = match (run.selected_by.first(), run.number) {
            (_, Some(run)) => format!("run {run}"),
            (Some((name, value)), None) => format!("{name} {value}"),
            (None, None) => format!("trial {k}"),
        };
        let window = (!whole).then(|| self.span(&moving));
        RecordDraft { name, rows: run.selected_by.clone(), run: run.number, window, fit }
    }

    /// Two records of a single run: one is fitted, the other validates.
    fn halves(&self, run: &Run) -> Vec<RecordDraft> {
        let moving = self.trimmed(run.good.clone());
        let (start, end) = self.span(&moving);
        let middle = self.times()[(moving.start + moving.len() / 2).min(self.table.rows() - 1)];
        let record = |name: &str, window, fit| RecordDraft {
            name: name.to_owned(),
            rows: run.selected_by.clone(),
            run: run.number,
            window: Some(window),
            fit,
        };
        vec![record("first half", (start, middle), true), record("second half", (middle, end), false)]
    }

    /// The column that tells the runs of a file apart: whole numbers, one for each.
    fn trial_column(&self, runs: &[Range<usize>]) -> Option<usize> {
        (0..self.table.columns.len()).find(|&c| {
            let values = self.values(c);
            let own: Vec<f64> = runs.iter().map(|r| values[r.start]).collect();
            let constant = runs.iter().zip(&own).all(|(r, x)| values[r.clone()].iter().all(|y| y == x));
            let distinct = own.iter().enumerate().all(|(k, x)| x.fract() == 0.0 && !own[..k].contains(x));
            c != self.time.column && constant && distinct
        })
    }

    /// Rows of a run that the flag takes.
    fn selected(&self, run: Range<usize>) -> Vec<usize> {
        let flag = self.roles.flag.as_ref();
        run.filter(|&r| flag.is_none_or(|f| self.values(f.column)[r] == f.value)).collect()
    }

    /// The longest stretch of rows of a run that the flag takes and in which nothing is missing or repeated.
    fn chosen(&mut self, run: Range<usize>) -> Range<usize> {
        let used: Vec<usize> = self.roles.used().chain([self.time.column]).collect();
        let rows = self.selected(run.clone());
        let good = |r: usize, before: Option<usize>| {
            let there = used.iter().all(|&c| self.values(c)[r].is_finite());
            let later = before.is_none_or(|b| b + 1 == r && self.times()[r] > self.times()[b]);
            (there, later)
        };
        let (mut best, mut start, mut before) = (0..0, None, None);
        let (mut lost, mut repeated) = (None, None);
        for &r in &rows {
            let (there, later) = good(r, before);
            if !there {
                (start, before) = (None, None);
                lost = lost.or(Some(r));
                continue;
            }
            if !later {
                start = None;
                repeated = repeated.or(Some(r).filter(|_| before.is_some_and(|b| b + 1 == r)));
            }
            let from = *start.get_or_insert(r);
            before = Some(r);
            if r + 1 - from > best.len() {
                best = from..r + 1;
            }
        }
        // A window is two times, so that no row outside may have the time of the first or last one inside.
        let time = self.times();
        while best.len() > 1 && best.start > run.start && time[best.start - 1] == time[best.start] {
            best.start += 1;
        }
        while best.len() > 1 && best.end < run.end && time[best.end] == time[best.end - 1] {
            best.end -= 1;
        }
        let enough = best.len() * 5 >= rows.len();
        let number = |r: usize| self.table.row_numbers[r];
        // Runs go back in time, so that a time may well stand there twice.
        let repeated = repeated.filter(|_| self.time.reversals.is_empty()).map(number);
        let missing = lost.map(number);
        if missing.is_some() || repeated.is_some() {
            let kept = enough.then(|| (best.start + 1, best.end, self.table.rows()));
            self.remarks.push(Remark::BadRows { missing, repeated, kept });
        }
        if enough { best } else { rows.first().map_or(0..0, |a| *a..rows[rows.len() - 1] + 1) }
    }

    /// A free motion without the rest before it starts and most of that after it ended.
    fn trimmed(&self, rows: Range<usize>) -> Range<usize> {
        if self.roles.input != Input::None || rows.len() < 100 {
            return rows;
        }
        let (time, x) = (
            &self.times()[rows.clone()],
            &self.values(self.roles.moving().unwrap_or(self.time.column))[rows.clone()],
        );
        let stops = stops(time, x, None);
        let near = rows.len() / 100 + 1;
        let mut kept = 0..rows.len();
        if let Some(first) =
            stops.stretches.first().filter(|s| s.start < near && s.len() > near && s.end + near < rows.len())
        {
            kept.start = first.end;
        }
        if let Some(last) =
            stops.stretches.last().filter(|s| s.end + near > rows.len() && s.start > kept.start)
        {
            kept.end = (last.start + (last.start - kept.start) / 20).min(rows.len());
        }
        if kept.len() < 20 { rows } else { rows.start + kept.start..rows.start + kept.end }
    }
}
