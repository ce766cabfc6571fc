//! The records of a draft: which rows of the file they take.

use crate::remarks::Remark;
use crate::roles::{Evidence, Input, Roles};
use crate::statistics::stops;
use crate::table::Table;
use crate::time_column::TimeColumn;
use std::ops::Range;

/// Most trials that become records.
const MOST_TRIALS: usize = 6;
/// Rows may be left out over this part of a period of the fastest strong line. Cubic interpolation of the
/// inputs, whose error is `3/128 (2 pi part)^4` of the amplitude, is then right to 0.02 %.
const SHORT_HOLE: f64 = 0.05;
/// Fewest rows of a record.
const FEWEST: usize = 20;

/// A record of the draft.
#[derive(Clone, Debug)]
pub struct RecordDraft {
    /// Its name.
    pub name: String,
    /// Headings and values that select its rows (`rows`).
    pub rows: Vec<(String, f64)>,
    /// Number of the run, if no column counts the runs (`run`).
    pub run: Option<usize>,
    /// First and last time, in the unit of the file.
    pub window: Option<(f64, f64)>,
    /// Whether rows without a value are left out (`missing`).
    pub omits_missing: bool,
    /// Whether the role is Fit; otherwise Validate.
    pub fit: bool,
}

/// The records of a file and what they leave out.
pub(crate) struct Records {
    /// At least one.
    pub(crate) records: Vec<RecordDraft>,
    /// Good rows of the first record, and those in motion; `None` if no run has enough good rows.
    pub(crate) first: Option<(Range<usize>, Range<usize>)>,
    /// Rows of the longest record.
    pub(crate) longest: usize,
    /// Remarks for the user.
    pub(crate) remarks: Vec<Remark>,
}

impl Records {
    /// Chooses the records; `runs` are the ranges in which time does not go back.
    pub(crate) fn of(evidence: &Evidence<'_>, roles: &Roles, runs: &[Range<usize>]) -> Records {
        let Evidence { table, time, statistics, .. } = evidence;
        let lines = roles.used().filter_map(|c| statistics[c].line);
        let fastest = lines.map(|line| line.frequency).fold(0.0, f64::max);
        let hole = if fastest > 0.0 { (SHORT_HOLE / (fastest * time.step)) as usize } else { 0 };
        Rows { table, time, roles, hole: hole.max(1), remarks: vec![] }.records(runs)
    }
}

/// A run of the file with enough good rows.
struct Run {
    /// All rows.
    rows: Range<usize>,
    /// The longest stretch of good rows.
    good: Range<usize>,
    /// Whether rows without a value are among them.
    has_holes: bool,
    /// Headings and values that select the run.
    selected_by: Vec<(String, f64)>,
    /// Its number, if no column counts the runs.
    number: Option<usize>,
}

/// The rows of a table.
struct Rows<'a> {
    table: &'a Table,
    time: &'a TimeColumn,
    roles: &'a Roles,
    /// Most rows without a value that follow each other in a good stretch.
    hole: usize,
    remarks: Vec<Remark>,
}

impl Rows<'_> {
    fn values(&self, column: usize) -> &[f64] {
        &self.table.columns[column].values
    }

    /// Times in the unit of the file.
    fn times(&self) -> &[f64] {
        self.values(self.time.column)
    }

    fn raw(&self, column: usize) -> &str {
        &self.table.columns[column].heading.raw
    }

    fn records(mut self, runs: &[Range<usize>]) -> Records {
        let runs = self.good_runs(runs);
        let Some(first) = runs.first() else {
            let name = "all".to_owned();
            let all =
                RecordDraft { name, rows: vec![], run: None, window: None, omits_missing: false, fit: true };
            return Records { records: vec![all], first: None, longest: 0, remarks: self.remarks };
        };
        let first = Some((first.good.clone(), self.in_motion(first.good.clone())));
        let longest = runs.iter().map(|run| run.good.len()).max().unwrap_or(0);
        let (records, longest) = match runs.as_slice() {
            [run] => (self.halves(run), longest / 2),
            several => {
                let last = several.len() - 1;
                let all = several.iter().enumerate().map(|(k, run)| self.whole_run(k, run, k < last));
                (all.collect(), longest)
            }
        };
        Records { records, first, longest, remarks: self.remarks }
    }

    /// Those of the first runs that have enough good rows.
    fn good_runs(&mut self, runs: &[Range<usize>]) -> Vec<Run> {
        let trials = if runs.len() > 1 { self.trial_column(runs) } else { None };
        let counted = runs.len() > 1 && trials.is_none();
        if counted {
            let line = self.table.row_numbers[runs[1].start];
            self.remarks.push(Remark::TimeGoesBack { line, runs: runs.len() });
        }
        let mut all = Vec::new();
        for (k, run) in runs.iter().enumerate().take(MOST_TRIALS) {
            let good = self.longest_good_stretch(run.clone());
            if good.len() < FEWEST {
                continue;
            }
            let trial = trials.map(|c| (self.raw(c).to_owned(), self.values(c)[good.start]));
            let selector = self
                .roles
                .selector
                .as_ref()
                .map(|selector| (self.raw(selector.column).to_owned(), selector.value));
            let selected_by = trial.into_iter().chain(selector).collect();
            let has_holes = good.clone().any(|r| !self.is_there(r));
            all.push(Run { rows: run.clone(), good, has_holes, selected_by, number: counted.then_some(k) });
        }
        if runs.len() > MOST_TRIALS {
            self.remarks.push(Remark::MoreTrials { all: runs.len(), written: MOST_TRIALS });
        }
        all
    }

    /// The first and the last time of some rows.
    fn span(&self, rows: &Range<usize>) -> (f64, f64) {
        let mut times = self.times()[rows.clone()].iter().copied().filter(|t| t.is_finite());
        (times.clone().next().unwrap_or(0.0), times.next_back().unwrap_or(0.0))
    }

    /// Whether a row has all values that the records need.
    fn is_there(&self, row: usize) -> bool {
        self.roles.used().chain([self.time.column]).all(|c| self.values(c)[row].is_finite())
    }

    /// The record of the `k`-th of several runs.
    fn whole_run(&self, k: usize, run: &Run, fit: bool) -> RecordDraft {
        let moving = self.in_motion(run.good.clone());
        let whole = self.selected_rows(run.rows.clone()).len() == moving.len();
        let name = match (run.selected_by.first(), run.number) {
            (_, Some(run)) => format!("run {run}"),
            (Some((name, value)), None) => format!("{name} {value}"),
            (None, None) => format!("trial {k}"),
        };
        let window = (!whole).then(|| self.span(&moving));
        let omits_missing = run.has_holes;
        RecordDraft { name, rows: run.selected_by.clone(), run: run.number, window, omits_missing, fit }
    }

    /// Two records of a single run: the first half is fitted, the second validates. A short run is one
    /// record.
    fn halves(&self, run: &Run) -> Vec<RecordDraft> {
        let moving = self.in_motion(run.good.clone());
        let (start, end) = self.span(&moving);
        let (middle, _) = self.span(&(moving.start + moving.len() / 2..moving.end));
        let record = |name: &str, window, fit| RecordDraft {
            name: name.to_owned(),
            rows: run.selected_by.clone(),
            run: run.number,
            window: Some(window),
            omits_missing: run.has_holes,
            fit,
        };
        if moving.len() < 2 * FEWEST {
            return vec![record("whole run", (start, end), true)];
        }
        vec![record("first half", (start, middle), true), record("second half", (middle, end), false)]
    }

    /// The column that counts the runs: a different whole number in each.
    fn trial_column(&self, runs: &[Range<usize>]) -> Option<usize> {
        (0..self.table.columns.len()).find(|&c| {
            let values = self.values(c);
            let own: Vec<f64> = runs.iter().map(|r| values[r.start]).collect();
            let constant = runs.iter().zip(&own).all(|(r, x)| values[r.clone()].iter().all(|y| y == x));
            let distinct = own.iter().enumerate().all(|(k, x)| x.fract() == 0.0 && !own[..k].contains(x));
            c != self.time.column && constant && distinct
        })
    }

    /// Rows of a run that the selector takes.
    fn selected_rows(&self, run: Range<usize>) -> Vec<usize> {
        let selector = self.roles.selector.as_ref();
        run.filter(|&r| selector.is_none_or(|f| self.values(f.column)[r] == f.value)).collect()
    }

    /// The longest stretch of selected rows of a run without long holes or repeated times.
    fn longest_good_stretch(&mut self, run: Range<usize>) -> Range<usize> {
        let rows = self.selected_rows(run.clone());
        let (mut best, mut start, mut before, mut hole) = (0..0, None, None, 0);
        let (mut lost, mut repeated) = (vec![], None);
        for &r in &rows {
            if !self.is_there(r) {
                hole += 1;
                lost.push(r);
                continue;
            }
            if hole > self.hole {
                (start, before) = (None, None);
            }
            let follows = before.is_none_or(|b: usize| b + 1 + hole == r);
            if before.is_some_and(|b| !follows || self.times()[r] <= self.times()[b]) {
                start = None;
                repeated = repeated.or(Some(r).filter(|_| follows));
            }
            let from = *start.get_or_insert(r);
            (before, hole) = (Some(r), 0);
            if r + 1 - from > best.len() {
                best = from..r + 1;
            }
        }
        // A window is a pair of times: no row outside may share the first or the last time.
        let time = self.times();
        while best.len() > 1 && best.start > run.start && time[best.start - 1] == time[best.start] {
            best.start += 1;
        }
        while best.len() > 1 && best.end < run.end && time[best.end] == time[best.end - 1] {
            best.end -= 1;
        }
        let enough = best.len() * 5 >= rows.len();
        self.tell_bad_rows(&lost, repeated, (&best, rows.len()), enough);
        if enough { best } else { rows.first().map_or(0..0, |a| *a..rows[rows.len() - 1] + 1) }
    }

    /// Remarks on rows that lack a value (`lost`), and on a time that stands twice, beside the `best` stretch
    /// of rows.
    fn tell_bad_rows(
        &mut self,
        lost: &[usize],
        repeated: Option<usize>,
        (best, rows): (&Range<usize>, usize),
        enough: bool,
    ) {
        let number = |r: usize| self.table.row_numbers[r];
        // Where time goes back, repeated times are expected.
        let repeated = repeated.filter(|_| self.time.reversals.is_empty()).map(number);
        let inside: Vec<usize> = lost.iter().copied().filter(|r| best.contains(r)).collect();
        // What lies outside of the stretch is not in the records.
        let outside = if enough { lost.iter().find(|r| !best.contains(r)) } else { lost.first() };
        if let (Some(first), true) = (inside.first(), enough) {
            self.remarks.push(Remark::OmittedRows { count: inside.len(), all: rows, line: number(*first) });
        }
        let missing = outside.copied().map(number);
        if missing.is_some() || repeated.is_some() {
            let kept = enough.then(|| (best.start + 1, best.end, self.table.rows()));
            self.remarks.push(Remark::BadRows { missing, repeated, kept });
        }
    }

    /// Cuts the rest before a free motion and most of the rest after it.
    fn in_motion(&self, rows: Range<usize>) -> Range<usize> {
        if self.roles.input != Input::None || rows.len() < 100 {
            return rows;
        }
        let there: Vec<usize> = rows.clone().filter(|&r| self.is_there(r)).collect();
        let of = |c: usize| there.iter().map(|&r| self.values(c)[r]).collect::<Vec<f64>>();
        let (time, x) = (of(self.time.column), of(self.roles.moving().unwrap_or(self.time.column)));
        let mut stops = stops(&time, &x, None);
        // Rows of the run in the place of those that are there.
        for s in &mut stops.stretches {
            *s = there[s.start] - rows.start..there[s.end - 1] + 1 - rows.start;
        }
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
