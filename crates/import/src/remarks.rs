//! Remarks on a draft: what the user should know before a run.

use crate::rig::Rig;
use crate::stated_rate::StatedRate;
use crate::time_column::Coarse;
use std::fmt;

/// A remark. Lines and rows count from 1, headings are those of the file.
#[derive(Clone, Debug, PartialEq)]
pub enum Remark {
    /// The time has no unit, and its numbers are no seconds.
    TimeUnit {
        /// Heading of the time column.
        heading: String,
        /// Median step, as a number in the file.
        step: f64,
        /// The assumed unit.
        unit: String,
    },
    /// The motion has no unit.
    MotionUnit {
        /// Heading of its column.
        heading: String,
        /// The assumed unit.
        unit: &'static str,
    },
    /// The stamps are coarser than the rows.
    CoarseTime(Coarse),
    /// No column is time, and the header states the rate.
    StatedRate(StatedRate),
    /// The user says the rate, and the file has times.
    TimesNotRead {
        /// Heading of their column.
        heading: String,
    },
    /// What drives is measured, and of the rig that the user says nothing drives.
    DriveNotRead {
        /// Heading of its column.
        heading: String,
        /// The rig.
        rig: Rig,
    },
    /// The times and the header of the file differ in their rate.
    RateDiffers {
        /// What the header states.
        stated: StatedRate,
        /// Rows per second by the times.
        seen: f64,
    },
    /// A column wraps.
    Wraps {
        /// Its heading.
        heading: String,
        /// By how much it jumps, in the unit of the file.
        period: f64,
        /// Number of jumps.
        count: usize,
        /// The first line after a jump.
        line: usize,
    },
    /// Sheets of the file that hold numbers too.
    OtherSheets(Vec<String>),
    /// What was done to read the file.
    Note(String),
    /// Two columns share a heading that the model needs.
    SharedHeading(String),
    /// Time goes back, and no column counts the runs.
    TimeGoesBack {
        /// The first line with an earlier time.
        line: usize,
        /// Number of runs.
        runs: usize,
    },
    /// Only the first trials become records.
    MoreTrials {
        /// Number of trials in the file.
        all: usize,
        /// Number of trials that become records.
        written: usize,
    },
    /// Rows here and there lack a value, and the records leave them out (`missing: Omit`).
    OmittedRows {
        /// Their number.
        count: usize,
        /// All rows of the run.
        all: usize,
        /// The first of their lines.
        line: usize,
    },
    /// Values are missing in many rows that follow each other, or times are repeated.
    BadRows {
        /// The first line with a missing value.
        missing: Option<usize>,
        /// The first line with a repeated time.
        repeated: Option<usize>,
        /// First and last row of the stretch that is kept, and the number of all rows; `None` if it is too
        /// short.
        kept: Option<(usize, usize, usize)>,
    },
}

impl Remark {
    /// Whether the user has to check or correct something before a run.
    pub fn needs_edit(&self) -> bool {
        use Remark::{DriveNotRead, MoreTrials, Note, OmittedRows, OtherSheets, StatedRate, TimesNotRead};
        !matches!(
            self,
            DriveNotRead { .. }
                | MoreTrials { .. }
                | Note(_)
                | OmittedRows { .. }
                | OtherSheets(_)
                | StatedRate(_)
                | TimesNotRead { .. }
        )
    }
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Remark::TimeUnit { heading, unit, .. } if unit == "d" => write!(
                f,
                "the heading `{heading}` gives no unit: its values are taken for dates in days, as workbooks and MATLAB count them (for seconds write \"s\" \
                 in the place of \"d\" in the records)"
            ),
            Remark::TimeUnit { heading, step, unit } => write!(
                f,
                "the heading `{heading}` gives no unit: its steps of {} are taken for {unit} (for seconds write \"s\" in the place of \"{unit}\" in the records)",
                short(*step)
            ),
            Remark::MotionUnit { heading, unit } => write!(
                f,
                "the heading `{heading}` gives no unit: its numbers are taken for {unit} (for others name the unit in the heading or in the records, as in \
                 `(\"{heading}\", \"m{unit}\")`)"
            ),
            Remark::CoarseTime(Coarse { heading, step, rows: (least, most), rate }) => write!(
                f,
                "`{heading}` is coarser than the rows, with a new stamp every {} for {least}{} rows each: the rows are counted, {rate} of them per second",
                short(*step),
                if most > least { format!(" to {most}") } else { String::new() }
            ),
            Remark::StatedRate(StatedRate { rate, line, text }) => {
                write!(f, "no column is time: {rate} rows per second, as line {line} says: `{text}`")
            }
            Remark::TimesNotRead { heading } => {
                write!(f, "`{heading}` is not read: `--rate` counts the rows")
            }
            Remark::DriveNotRead { heading, rig } => {
                write!(f, "`{heading}` is not read: nothing drives a rig that is `{rig}`")
            }
            Remark::RateDiffers { stated: StatedRate { rate, line, text }, seen } => write!(
                f,
                "the times make {seen:.4} rows per second, and line {line} says {rate}: `{text}`. \
                 Is the unit of the time right?"
            ),
            Remark::Wraps { heading, period, count, line } => write!(
                f,
                "`{heading}` wraps: it jumps by {period} from one end of its range to the other, {count} time{} (first in line {line}). Say so in \
                 the records, by `unwrap` of its sensor (the turn, in SI), or write it unwrapped into the file, in Python with \
                 `numpy.unwrap(values, period={period})`",
                if *count == 1 { "" } else { "s" }
            ),
            Remark::OtherSheets(names) => {
                let list = names.join("`, `");
                write!(f, "the file has other sheets with numbers: `{list}` (name one with `--sheet`)")
            }
            Remark::Note(what) => f.write_str(what),
            Remark::SharedHeading(name) => write!(
                f,
                "two columns are called `{name}`: rename one of them in the file before you run this"
            ),
            Remark::TimeGoesBack { line, runs } => write!(
                f,
                "time goes back at line {line}{}: the file holds {runs} runs, and no column tells them apart. They are counted from 0: `run: 0`, \
                 `run: 1`, ...; if it is one run, correct the times in the file",
                if *runs > 2 { " and later" } else { "" }
            ),
            Remark::MoreTrials { all, written } => {
                write!(f, "the file holds {all} trials, of which the first {written} are written out")
            }
            Remark::OmittedRows { count, all, line } => write!(
                f,
                "{count} of {all} rows lack a value (first in line {line}) and are left out: `missing: Omit`"
            ),
            Remark::BadRows { missing, repeated, kept } => {
                let missing = missing.map(|line| format!("values are missing (first in line {line})"));
                let repeated = repeated.map(|line| format!("a time stands twice (first in line {line})"));
                let what: Vec<String> = missing.into_iter().chain(repeated.clone()).collect();
                f.write_str(&what.join(" and "))?;
                let way = match repeated {
                    None => "widen the windows and say `missing: Omit`, which leaves these rows out",
                    Some(_) => "delete the bad lines in the file",
                };
                match kept {
                    Some((first, last, all)) => write!(
                        f,
                        ": the windows take the longest stretch without, rows {first} to {last} of {all}. To use all, {way}"
                    ),
                    None => write!(f, ", so often that no long stretch is left. To use the file, {way}"),
                }
            }
        }
    }
}

/// A number as a sentence has it: without what a difference leaves in its last digits.
fn short(x: f64) -> f64 {
    format!("{x:.9e}").parse().unwrap_or(x)
}
