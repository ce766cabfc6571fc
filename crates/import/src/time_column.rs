//! The column of time: which one it is, and how regular it is.

use crate::headings::Quantity;
use crate::table::{Column, Table};
use std::fmt;
use std::ops::Range;

/// Names that a column of time has.
const NAMES: &[&str] = &[
    "t",
    "time",
    "times",
    "timestamp",
    "zeit",
    "temps",
    "tiempo",
    "tempo",
    "tijd",
    "sec",
    "seconds",
    "secs",
    "elapsed",
    "clock",
];
/// Names of a counter.
const COUNTERS: &[&str] =
    &["index", "sample", "samples", "row", "count", "counter", "no", "nr", "id", "unnamed"];

/// What is to be said about time.
#[derive(Clone, Debug)]
pub struct TimeColumn {
    /// Which column.
    pub(crate) column: usize,
    /// The median step.
    pub(crate) step: f64,
    /// The largest deviation from the median step, gaps left out, as a part of it.
    pub(crate) jitter: f64,
    /// Rows after which time goes on more than five steps later.
    pub(crate) gaps: Vec<usize>,
    /// Rows whose time is that of the row before.
    pub(crate) repeats: Vec<usize>,
    /// Rows whose time is before that of the row before.
    pub(crate) reversals: Vec<usize>,
    /// Why it may be another one: no name and no unit says that this is time.
    pub(crate) guessed: bool,
    /// No column is time: it is counted, at a rate that is to be said.
    pub(crate) counted: bool,
    /// The unit is taken from the numbers: rows that are a second or more apart are no record of a motion.
    pub(crate) unit_guessed: bool,
}

/// Why no column is time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoTime {
    /// The column with this heading should be time; whether it holds text.
    NotGrowing {
        /// As the file has it.
        heading: String,
        /// Whether some of its cells hold text.
        text: bool,
    },
    /// No column grows from row to row.
    NoneGrows,
}

impl fmt::Display for NoTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoTime::NotGrowing { heading, text } => {
                let advice = if *text { ": write it as a number of seconds" } else { "" };
                write!(
                    f,
                    "the column `{heading}` should be time, and it does not grow from row to row{advice}"
                )
            }
            NoTime::NoneGrows => f.write_str("no column grows from row to row, so none of them is time"),
        }
    }
}

/// What is taken for the rows per second of a file that does not say.
pub(crate) const RATE: f64 = 100.0;

impl TimeColumn {
    /// The column that is time, which a table without one gets; why there is none.
    pub(crate) fn find(table: &mut Table) -> Result<TimeColumn, NoTime> {
        if !table
            .columns
            .iter()
            .any(|c| grows(c) || c.heading.quantity == Quantity::Time || c.heading.says(NAMES))
        {
            let column = table.count_rows(RATE);
            return Ok(TimeColumn {
                counted: true,
                ..TimeColumn::of(column, &table.columns[column].values, false)
            });
        }

        let growing: Vec<bool> = table.columns.iter().map(grows).collect();
        let named = |c: &Column| c.heading.quantity == Quantity::Time || c.heading.says(NAMES);
        let counter = |c: &Column| c.heading.says(COUNTERS) && c.heading.quantity != Quantity::Time;
        let pick = |test: &dyn Fn(&Column) -> bool| {
            table.columns.iter().zip(&growing).position(|(c, grows)| *grows && test(c))
        };
        if let Some(column) = pick(&|c| named(c) && !counter(c)) {
            return Ok(TimeColumn::of(column, &table.columns[column].values, false));
        }
        if let Some(c) = table.columns.iter().find(|c| named(c)) {
            return Err(NoTime::NotGrowing { heading: c.heading.raw.clone(), text: c.text_cells > 0 });
        }
        match pick(&|c| !counter(c) && !whole(c))
            .or_else(|| pick(&|c| !counter(c)))
            .or_else(|| pick(&|_| true))
        {
            Some(column) => Ok(TimeColumn::of(column, &table.columns[column].values, true)),
            None => Err(NoTime::NoneGrows),
        }
    }

    fn of(column: usize, time: &[f64], guessed: bool) -> TimeColumn {
        let steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
        let mut forward: Vec<f64> = steps.iter().copied().filter(|d| *d > 0.0).collect();
        forward.sort_by(f64::total_cmp);
        let step = forward.get(forward.len() / 2).copied().unwrap_or(1.0);
        let rows = |test: &dyn Fn(f64) -> bool| {
            steps.iter().enumerate().filter(|(_, d)| test(**d)).map(|(k, _)| k).collect::<Vec<_>>()
        };
        let (gaps, repeats, reversals) = (rows(&|d| d > 5.0 * step), rows(&|d| d == 0.0), rows(&|d| d < 0.0));
        let jitter =
            forward.iter().filter(|d| **d <= 5.0 * step).fold(0.0_f64, |m, d| m.max((d - step).abs()));
        let after = |k: Vec<usize>| k.into_iter().map(|k| k + 1).collect();
        TimeColumn {
            column,
            step,
            jitter: jitter / step,
            gaps,
            repeats: after(repeats),
            reversals: after(reversals),
            guessed,
            counted: false,
            unit_guessed: false,
        }
    }

    /// Gives a column of time without a unit, in which rows are one or more apart, the unit in which they are not: milliseconds, or microseconds.
    pub(crate) fn refined(self, table: &mut Table) -> TimeColumn {
        let heading = &mut table.columns[self.column].heading;
        let unit_guessed = !self.guessed && !self.counted && heading.unit.is_none() && self.step >= 1.0;
        if unit_guessed {
            *heading = heading.clone().with_unit(if self.step < 1000.0 { "ms" } else { "us" });
        }
        TimeColumn { unit_guessed, ..self }
    }

    /// The stretches of rows in which time does not go back.
    pub(crate) fn runs(&self, rows: usize) -> Vec<Range<usize>> {
        let ends = self.reversals.iter().copied().chain([rows]);
        let starts = [0].into_iter().chain(self.reversals.iter().copied());
        starts.zip(ends).map(|(a, b)| a..b).collect()
    }
}

/// Whether a column only counts or tells the time: no motion, whatever else it is.
pub(crate) fn is_counter(column: &Column) -> bool {
    let even = || column.values.windows(3).all(|w| w[2] - w[1] == w[1] - w[0]);
    let named = column.heading.quantity == Quantity::Time
        || column.heading.says(NAMES)
        || column.heading.says(COUNTERS);
    grows(column) && (named || (whole(column) && even()))
}

/// Whether a column grows as time does: nearly everywhere.
fn grows(column: &Column) -> bool {
    let steps = column.values.windows(2);
    let count = steps.len();
    let (mut up, mut down) = (0, 0);
    for w in steps {
        if w[1] > w[0] {
            up += 1;
        } else if w[1] != w[0] {
            down += 1;
        }
    }
    // Trials that each start at zero go back a few times, and a logger repeats a row now and then.
    column.text_cells == 0 && up as f64 > 0.6 * count as f64 && (down as f64) < 0.02 * count as f64
}

fn whole(column: &Column) -> bool {
    column.values.iter().all(|x| x.fract() == 0.0)
}
