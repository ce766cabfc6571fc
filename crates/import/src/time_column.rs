//! The time column: which one it is, and how regularly it is sampled.

use crate::headings::{Heading, Quantity, factor};
use crate::table::{Column, Table};
use phisindy_phys::Diagnostic;
use std::fmt;
use std::ops::Range;

/// Words that name the time.
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
    "datetime",
    "uhrzeit",
    "zeitstempel",
];
/// Fewer stamps do not tell the rate of the rows.
const MIN_STAMPS: usize = 3;
/// Words that name a counter.
const COUNTERS: &[&str] =
    &["index", "sample", "samples", "row", "count", "counter", "no", "nr", "id", "unnamed"];

/// The time column of a table, and its sampling.
#[derive(Clone, Debug)]
pub struct TimeColumn {
    /// Index of the column.
    pub column: usize,
    /// Median step, in the unit of the file.
    pub step: f64,
    /// Largest deviation from the median step outside gaps, relative to it.
    pub jitter: f64,
    /// Rows before a gap: the next step exceeds five median steps.
    pub gaps: Vec<usize>,
    /// Rows with the same time as the previous row.
    pub repeats: Vec<usize>,
    /// Rows with an earlier time than the previous row.
    pub reversals: Vec<usize>,
    /// Neither name nor unit identifies the column as time.
    pub guessed: bool,
    /// Rows are counted: the file has no time column, or one that is coarser than the rows.
    pub counted: bool,
    /// The rows per second if they are counted. Without a time column it is 100, unless the user says it.
    pub rate: f64,
    /// The user says the rate.
    pub told: bool,
    /// The time column that is coarser than the rows.
    pub coarse: Option<Coarse>,
    /// The unit is derived from the numbers: a motion is not sampled in steps of a second or more, and dates
    /// are days.
    pub unit_guessed: bool,
}

/// A time column that repeats each stamp for several rows, such as full seconds.
#[derive(Clone, Debug, PartialEq)]
pub struct Coarse {
    /// Its heading.
    pub heading: String,
    /// Between two stamps, in the unit of the file.
    pub step: f64,
    /// Fewest and most rows of a stamp, without the first and the last one.
    pub rows: (usize, usize),
    /// Rows per second.
    pub rate: f64,
}

impl Coarse {
    /// The column as such a one; none if it is not named as time, or has a stamp for each row.
    fn of(column: &Column) -> Option<Coarse> {
        let named = column.heading.quantity == Quantity::Time || column.heading.has_word(NAMES);
        let times = &column.values;
        if !named || column.text_cells > 0 || times.windows(2).any(|w| w[1] < w[0] || !w[1].is_finite()) {
            return None;
        }
        let changes: Vec<usize> = (1..times.len()).filter(|&k| times[k] > times[k - 1]).collect();
        let mut rows: Vec<usize> = changes.windows(2).map(|w| w[1] - w[0]).collect();
        rows.sort_unstable();
        let (least, most) = (*rows.first()?, *rows.last()?);
        let (first, last) = (changes[0], *changes.last()?);
        // More than one row for most stamps, as evenly as a clock beside the sampling gives them. A stamp
        // that stands twice here and there is a mistake of the logger.
        let repeated = 2 * (last - first) > 3 * rows.len();
        if rows.len() < MIN_STAMPS || !repeated || most > least + 1 + least / 10 {
            return None;
        }
        let span = (times[last] - times[first]) * factor(column.heading.unit.as_deref());
        let rate = (last - first) as f64 / span;
        // The count is right within one row.
        let rate = if (rate - rate.round()).abs() * span <= 1.0 { rate.round() } else { rate };
        let step = (times[last] - times[first]) / rows.len() as f64;
        let heading = column.heading.raw.clone();
        (rate > 0.0 && rate.is_finite()).then_some(Coarse { heading, step, rows: (least, most), rate })
    }
}

/// Steps of a second, as days: a motion is not sampled in longer ones. Seconds in steps as short come from a
/// recorder of 100 kHz, which counts from its start.
const SHORT_OF_DAYS: f64 = 1.0 / 86_400.0;
/// The days of about 1955 to 2119, counted as workbooks do from 1900 and as MATLAB does from the year 0.
const DATES: [Range<f64>; 2] = [20e3..80e3, 714e3..774e3];

/// Whether all of these numbers are dates, in days.
fn are_dates(values: &[f64]) -> bool {
    let all_in = |days: &Range<f64>| values.iter().all(|x| x.is_nan() || days.contains(x));
    values.iter().any(|x| x.is_finite()) && DATES.iter().any(all_in)
}

/// Why no column is time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoTime {
    /// A column is named as time and does not grow.
    NotGrowing {
        /// Its heading.
        heading: String,
        /// Whether it falls instead.
        falls: bool,
    },
    /// A column is named as time and holds text.
    Text {
        /// Its heading.
        heading: String,
        /// What is said of the first text.
        mistake: Box<Diagnostic>,
    },
    /// No column grows from row to row.
    NoneGrows,
}

impl fmt::Display for NoTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoTime::NotGrowing { heading, falls } => {
                let does = if *falls { "falls" } else { "does not grow" };
                write!(f, "the column `{heading}` should be time, and it {does} from row to row")
            }
            NoTime::Text { mistake, .. } => f.write_str(&mistake.message),
            NoTime::NoneGrows => f.write_str("no column grows from row to row, so none of them is time"),
        }
    }
}

/// Rows per second that are assumed for a file without time.
const RATE: f64 = 100.0;

impl TimeColumn {
    /// Finds the time column; adds one to a table without any. If the user says a rate the rows are counted,
    /// whatever the columns hold.
    ///
    /// # Errors
    /// A column is named as time and does not grow, or no column grows.
    pub(crate) fn find(table: &mut Table, rate: Option<f64>) -> Result<TimeColumn, NoTime> {
        if let Some(rate) = rate {
            return Ok(TimeColumn { told: true, ..TimeColumn::counting(table, rate) });
        }
        if !table
            .columns
            .iter()
            .any(|c| grows(c) || c.heading.quantity == Quantity::Time || c.heading.has_word(NAMES))
        {
            return Ok(TimeColumn::counting(table, RATE));
        }
        if let Some(coarse) = table.columns.iter().find_map(Coarse::of) {
            let counted = TimeColumn::counting(table, coarse.rate);
            return Ok(TimeColumn { coarse: Some(coarse), ..counted });
        }
        let growing: Vec<bool> = table.columns.iter().map(grows).collect();
        let named = |c: &Column| c.heading.quantity == Quantity::Time || c.heading.has_word(NAMES);
        let counter = |c: &Column| c.heading.has_word(COUNTERS) && c.heading.quantity != Quantity::Time;
        let pick = |test: &dyn Fn(&Column) -> bool| {
            table.columns.iter().zip(&growing).position(|(c, grows)| *grows && test(c))
        };
        if let Some(column) = pick(&|c| named(c) && !counter(c)) {
            return Ok(TimeColumn::of(column, &table.columns[column].values, false));
        }
        if let Some(c) = table.columns.iter().find(|c| named(c)) {
            let heading = c.heading.raw.clone();
            return Err(match &c.first_text {
                Some(first) => NoTime::Text { heading, mistake: Box::new(first.clone()) },
                None => NoTime::NotGrowing { heading, falls: falls(c) },
            });
        }
        match pick(&|c| !counter(c) && !is_whole(c))
            .or_else(|| pick(&|c| !counter(c)))
            .or_else(|| pick(&|_| true))
        {
            Some(column) => Ok(TimeColumn::of(column, &table.columns[column].values, true)),
            None => Err(NoTime::NoneGrows),
        }
    }

    /// Rows counted at `rate` per second.
    fn counting(table: &mut Table, rate: f64) -> TimeColumn {
        let column = table.count_rows(rate);
        TimeColumn { counted: true, rate, ..TimeColumn::of(column, &table.columns[column].values, false) }
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
            rate: RATE,
            told: false,
            coarse: None,
            unit_guessed: false,
        }
    }

    /// Assigns a unit to a time column without one whose numbers are no seconds: milliseconds or microseconds
    /// where its steps are one or more, days where its values are dates.
    pub(crate) fn with_guessed_unit(self, table: &mut Table) -> TimeColumn {
        let column = &mut table.columns[self.column];
        let unit = match self.step {
            _ if column.heading.unit.is_some() || self.counted => None,
            step if step < SHORT_OF_DAYS && are_dates(&column.values) => Some("d"),
            step if step < 1.0 || self.guessed => None,
            step if step < 1000.0 => Some("ms"),
            _ => Some("us"),
        };
        if let Some(unit) = unit {
            column.heading = column.heading.clone().with_unit(unit);
        }
        TimeColumn { unit_guessed: unit.is_some(), ..self }
    }

    /// Ranges of rows in which time does not go back.
    pub(crate) fn runs(&self, rows: usize) -> Vec<Range<usize>> {
        let ends = self.reversals.iter().copied().chain([rows]);
        let starts = [0].into_iter().chain(self.reversals.iter().copied());
        starts.zip(ends).map(|(a, b)| a..b).collect()
    }
}

/// Whether a heading names the time.
pub(crate) fn is_named_time(heading: &Heading) -> bool {
    heading.quantity == Quantity::Time || heading.has_word(NAMES)
}

/// Whether a column counts rows or holds time, and thus no motion.
pub(crate) fn is_counter(column: &Column) -> bool {
    let even = || column.values.windows(3).all(|w| w[2] - w[1] == w[1] - w[0]);
    let counter = column.heading.has_word(COUNTERS) || (is_whole(column) && even());
    // Where the user says the rate, a column of times may be as wrong as it likes.
    is_named_time(&column.heading) || (grows(column) && counter)
}

/// Whether a column would grow if its rows stood the other way round.
fn falls(column: &Column) -> bool {
    let values = column.values.iter().map(|x| -x).collect();
    grows(&Column { values, ..column.clone() })
}

/// Whether a column grows from nearly every row to the next, as time does.
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
    // Several trials in one file restart the time, and a logger may repeat rows.
    column.text_cells == 0 && up as f64 > 0.6 * count as f64 && (down as f64) < 0.02 * count as f64
}

fn is_whole(column: &Column) -> bool {
    column.values.iter().all(|x| x.fract() == 0.0)
}
