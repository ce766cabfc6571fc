//! The time column: which one it is, and how regularly it is sampled.

use crate::headings::{Heading, Quantity, factor, normalized};
use crate::question::Question;
use crate::roles::is_word_of_a_role;
use crate::stated_rate::StatedRate;
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
    "stamp",
    "micros",
    "millis",
];
/// Fewer stamps do not tell the rate of the rows.
const MIN_STAMPS: usize = 3;
/// Words that name a counter.
const COUNTERS: &[&str] = &[
    "index", "idx", "sample", "samples", "row", "count", "counter", "no", "nr", "id", "unnamed", "frame",
    "frames",
];

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
    /// The rows per second if they are counted: by the user, the header, or stamps that are coarser.
    pub rate: f64,
    /// The user says the rate.
    pub told: bool,
    /// The time column that is coarser than the rows.
    pub coarse: Option<Coarse>,
    /// The unit is derived from the numbers: a motion is not sampled in steps of a second or more, and dates
    /// are days.
    pub unit_guessed: bool,
    /// The unit of the heading, where its numbers make no record: steps of a quarter of an hour.
    pub implausible_unit: Option<String>,
    /// What the header of the file states on the rate of the rows.
    pub stated: Option<StatedRate>,
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
        let named = names_time(column);
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

/// Units of time of loggers.
const UNITS: [&str; 4] = ["s", "ms", "us", "ns"];
/// Words of a heading that say seconds.
const SECONDS: &[&str] = &["sec", "secs", "seconds", "second", "sek", "sekunden"];
/// Seconds between two rows, beyond which there is no record of a motion.
const SLOWEST: f64 = 10.0;
/// Steps from which a unit is too short for what a logger does: milliseconds of a second, and so on.
const STEPS: [(f64, &str); 3] = [(1e3, "ms"), (1e5, "us"), (f64::INFINITY, "ns")];
/// The seconds since 1970 of about 2001 to 2039.
const EPOCH: Range<f64> = 1.0e9..2.2e9;

/// The unit in which steps of this size are of that rate.
fn unit_at(step: f64, rate: f64) -> Option<&'static str> {
    UNITS.into_iter().find(|unit| (step * factor(Some(unit)) * rate - 1.0).abs() < SAME_RATE)
}

/// The unit of times whose numbers are no seconds: days where they are dates, a fraction of a second where
/// they count from 1970 or their steps are one or more.
fn plausible_unit(step: f64, values: &[f64]) -> Option<&'static str> {
    if step < SHORT_OF_DAYS && are_dates(values) {
        return Some("d");
    }
    if step < 1.0 {
        return None;
    }
    let first = values.iter().copied().find(|x| x.is_finite()).unwrap_or(0.0);
    let since_1970 = UNITS.into_iter().find(|unit| {
        let second = factor(Some(unit));
        EPOCH.contains(&(first * second)) && step * second <= 1.0
    });
    since_1970.or_else(|| STEPS.iter().find(|(below, _)| step < *below).map(|(_, unit)| *unit))
}

/// The rate of the header, if all that it states is one.
fn agreed(stated: &[StatedRate]) -> Option<StatedRate> {
    let first = stated.first()?;
    let same = |other: &StatedRate| (other.rate / first.rate - 1.0).abs() < SAME_RATE;
    stated.iter().all(same).then(|| first.clone())
}

/// Why no column is time.
#[derive(Clone, Debug, PartialEq)]
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
    /// Of times as long or as short no rate can be computed.
    Beyond {
        /// The heading.
        heading: String,
        /// Seconds between two rows.
        step: f64,
    },
    /// No column is time, and nothing states the rate of the rows.
    NoRate {
        /// A column that counts the rows.
        counter: Option<String>,
        /// What the header states, if that contradicts itself.
        stated: Vec<StatedRate>,
    },
}

impl fmt::Display for NoTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NoTime::NotGrowing { heading, falls } => {
                let does = if *falls { "falls" } else { "does not grow" };
                write!(f, "the column `{heading}` should be time, and it {does} from row to row")
            }
            NoTime::Beyond { heading, step } => {
                write!(f, "the rows are {step:?} s apart by `{heading}`: such times cannot be used")
            }
            NoTime::Text { mistake, .. } => f.write_str(&mistake.message),
            NoTime::NoRate { stated, .. } if !stated.is_empty() => {
                let all = stated.iter().map(|s| format!("line {} says `{}`", s.line, s.text));
                let all = all.collect::<Vec<_>>().join(", ");
                write!(f, "no column is time, and the header contradicts itself on the rate: {all}")
            }
            NoTime::NoRate { counter: Some(counter), .. } => {
                write!(f, "no column is time: `{counter}` counts the rows. How many are there in a second?")
            }
            NoTime::NoRate { counter: None, .. } => {
                f.write_str("no column is time. How many rows are there in a second?")
            }
        }
    }
}

/// Seconds between two rows with which a draft can be computed.
const USABLE: Range<f64> = 1e-30..1e30;
/// Steps and rates of one clock differ by less, relatively.
const SAME_RATE: f64 = 0.02;

impl TimeColumn {
    /// Finds the time column; adds one to a table without any, if the user or the header of the file says a
    /// rate. If the user says one the rows are counted, whatever the columns hold.
    ///
    /// # Errors
    /// A column is named as time and does not grow, or no column is time and nothing states a rate.
    pub(crate) fn find(table: &mut Table, rate: Option<f64>) -> Result<TimeColumn, NoTime> {
        if let Some(rate) = rate {
            return Ok(TimeColumn { told: true, ..TimeColumn::counting(table, rate) });
        }
        let stated = agreed(&table.stated_rates);
        if let Some(coarse) = table.columns.iter().find_map(Coarse::of) {
            let counted = TimeColumn::counting(table, coarse.rate);
            return Ok(TimeColumn { coarse: Some(coarse), ..counted });
        }
        let growing: Vec<bool> = table.columns.iter().map(grows).collect();
        let pick = |test: &dyn Fn(&Column) -> bool| {
            table.columns.iter().zip(&growing).position(|(c, grows)| *grows && test(c))
        };
        if let Some(column) = pick(&|c| names_time(c) && !counts_rows(c)) {
            let found = TimeColumn::of(column, &table.columns[column].values, false);
            return Ok(TimeColumn { stated, ..found });
        }
        if let Some(c) = table.columns.iter().find(|c| names_time(c)) {
            let heading = c.heading.raw.clone();
            return Err(match &c.first_text {
                Some(first) => NoTime::Text { heading, mistake: Box::new(first.clone()) },
                None => NoTime::NotGrowing { heading, falls: falls(c) },
            });
        }
        // A column without name and unit may be time; one that counts the rows tells no time.
        let free = |c: &Column| {
            let role = is_word_of_a_role(&c.heading) && c.heading.name != "s";
            c.heading.quantity == Quantity::Unknown && !role && !counts_rows(c) && !is_count(c)
        };
        let found = pick(&|c| free(c) && !is_whole(c)).or_else(|| pick(&free));
        let found = found.map(|k| TimeColumn::of(k, &table.columns[k].values, true));
        match (found, stated) {
            // The header states a rate, and these are other numbers: something that grows.
            (Some(found), Some(stated)) if unit_at(found.step, stated.rate).is_none() => {
                Ok(TimeColumn::counting_as_stated(table, stated))
            }
            (Some(found), stated) => Ok(TimeColumn { stated, ..found }),
            (None, Some(stated)) => Ok(TimeColumn::counting_as_stated(table, stated)),
            (None, None) => {
                let counter = pick(&|c| counts_rows(c) || is_count(c));
                let counter = counter.map(|k| table.columns[k].heading.raw.clone());
                Err(NoTime::NoRate { counter, stated: table.stated_rates.clone() })
            }
        }
    }

    /// Rows counted at `rate` per second.
    fn counting(table: &mut Table, rate: f64) -> TimeColumn {
        let column = table.count_rows(rate);
        TimeColumn { counted: true, rate, ..TimeColumn::of(column, &table.columns[column].values, false) }
    }

    /// Rows counted at the rate that the header states.
    fn counting_as_stated(table: &mut Table, stated: StatedRate) -> TimeColumn {
        let counted = TimeColumn::counting(table, stated.rate);
        TimeColumn { stated: Some(stated), ..counted }
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
            rate: 1.0 / step,
            told: false,
            coarse: None,
            unit_guessed: false,
            implausible_unit: None,
            stated: None,
        }
    }

    /// The same column of a table of which some rows are left.
    pub(crate) fn thinned(self, table: &Table) -> TimeColumn {
        let TimeColumn { step, jitter, gaps, repeats, reversals, .. } =
            TimeColumn::of(self.column, &table.columns[self.column].values, self.guessed);
        TimeColumn { step, jitter, gaps, repeats, reversals, ..self }
    }

    /// Assigns a unit to a time column: the one that the user says; else, where the heading gives none or one
    /// that makes no record, the one that the rate in the header says, or that the numbers say.
    pub(crate) fn with_unit(self, table: &mut Table, said: Option<&str>) -> TimeColumn {
        let column = &mut table.columns[self.column];
        if self.counted {
            return self;
        }
        let own = column.heading.unit.clone();
        if let Some(said) = said {
            column.heading = Heading { unit: None, ..column.heading.clone() }.with_unit(said);
            return self;
        }
        let stated = self.stated.as_ref().and_then(|stated| unit_at(self.step, stated.rate));
        let implausible = own.is_some() && self.step * factor(own.as_deref()) > SLOWEST;
        if own.is_some() && !implausible {
            return self;
        }
        // `seconds_elapsed`, `time ms since start`.
        let word = column
            .heading
            .words()
            .filter_map(normalized)
            .find(|unit| UNITS.contains(&unit.as_str()) && unit != "s");
        let seconds = column.heading.has_word(SECONDS).then(|| "s".to_owned());
        if let (Some(unit), None) = (word.or(seconds), &own)
            && self.step * factor(Some(&unit)) <= SLOWEST
        {
            column.heading = column.heading.clone().with_unit(&unit);
            return self;
        }
        // Half a day between two rows is half a second.
        let seconds = || Some("s").filter(|_| implausible && self.step < 1.0);
        let unit = stated.or_else(|| plausible_unit(self.step, &column.values)).or_else(seconds);
        let guessed = stated.is_none() && unit.is_some();
        if let Some(unit) = unit {
            column.heading = Heading { unit: None, ..column.heading.clone() }.with_unit(unit);
        }
        let implausible_unit = own.filter(|own| implausible && Some(own.as_str()) != unit);
        TimeColumn { unit_guessed: guessed, implausible_unit, ..self }
    }

    /// Refuses times whose squares and inverses are no numbers.
    ///
    /// # Errors
    /// Such times.
    pub(crate) fn usable(self, table: &Table) -> Result<TimeColumn, NoTime> {
        let heading = &table.columns[self.column].heading;
        let step = self.step * factor(heading.unit.as_deref());
        if USABLE.contains(&step) {
            Ok(self)
        } else {
            Err(NoTime::Beyond { heading: heading.raw.clone(), step })
        }
    }

    /// What the user has to say if the heading's unit makes no record.
    pub(crate) fn question(&self, table: &Table) -> Option<Question> {
        let unit = self.implausible_unit.clone()?;
        let heading = &table.columns[self.column].heading;
        let taken = heading.unit.clone().unwrap_or_default();
        Some(Question::TimeUnit { heading: heading.raw.clone(), unit, step: self.step, taken })
    }

    /// Ranges of rows in which time does not go back.
    pub(crate) fn runs(&self, rows: usize) -> Vec<Range<usize>> {
        let ends = self.reversals.iter().copied().chain([rows]);
        let starts = [0].into_iter().chain(self.reversals.iter().copied());
        starts.zip(ends).map(|(a, b)| a..b).collect()
    }
}

/// Whether a heading names the time. One with the unit of something else is none: `T_Nm` is a torque.
pub(crate) fn is_named_time(heading: &Heading) -> bool {
    let free = matches!(heading.quantity, Quantity::Unknown | Quantity::Count);
    heading.quantity == Quantity::Time || (free && heading.has_word(NAMES))
}

/// Whether a column is named as time. A `T` that does not grow is a torque.
pub(crate) fn names_time(column: &Column) -> bool {
    is_named_time(&column.heading) && (!column.heading.is_capital_t() || grows(column))
}

/// Whether a column is named as one that counts rows.
fn counts_rows(column: &Column) -> bool {
    column.heading.has_word(COUNTERS) && column.heading.quantity != Quantity::Time
}

/// Whether a column holds whole numbers in equal steps of one.
fn is_count(column: &Column) -> bool {
    is_whole(column) && column.values.windows(2).all(|w| w[1] - w[0] == 1.0)
}

/// Whether a column counts rows or holds time, and thus no motion.
pub(crate) fn is_counter(column: &Column) -> bool {
    let even = || column.values.windows(3).all(|w| w[2] - w[1] == w[1] - w[0]);
    // An encoder counts too, in other steps.
    let counter = match column.heading.quantity {
        Quantity::Count => counts_rows(column) || is_count(column),
        _ => column.heading.has_word(COUNTERS) || (is_whole(column) && even()),
    };
    // Where the user says the rate, a column of times may be as wrong as it likes.
    names_time(column) || (grows(column) && counter)
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

/// Whether a column holds whole numbers alone.
pub(crate) fn is_whole(column: &Column) -> bool {
    column.values.iter().all(|x| x.is_nan() || x.fract() == 0.0)
}
