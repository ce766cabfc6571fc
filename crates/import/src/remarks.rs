//! What should be known about a file before a spec for it is run.

use std::fmt;

/// One of these things. Lines and rows are counted from 1, headings are those of the file.
#[derive(Clone, Debug, PartialEq)]
pub enum Remark {
    /// The heading of the time gives no unit, and its steps are too long for seconds.
    TimeUnit {
        /// Of the column of time.
        heading: String,
        /// The median step, as the file has it.
        step: f64,
        /// The unit that it is taken to have.
        unit: String,
    },
    /// Two columns share this heading, and the model needs one of them.
    SharedHeading(String),
    /// Time goes back, and no column tells the runs apart.
    TimeGoesBack {
        /// Where it first does.
        line: usize,
        /// How many runs there are.
        runs: usize,
    },
    /// Not all trials are written out.
    MoreTrials {
        /// Trials of the file.
        all: usize,
        /// Trials that are records.
        written: usize,
    },
    /// Values are missing or times stand twice.
    BadRows {
        /// The first line where a value is missing.
        missing: Option<usize>,
        /// The first line whose time is that of the line before.
        repeated: Option<usize>,
        /// First and last row of the stretch without, and the number of all rows; none if it is too short.
        kept: Option<(usize, usize, usize)>,
    },
}

impl Remark {
    /// Whether the user has to look at it: a run may stop there, or read the data wrongly.
    pub fn needs_edit(&self) -> bool {
        !matches!(self, Remark::MoreTrials { .. })
    }
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Remark::TimeUnit { heading, step, unit } => write!(
                f,
                "the heading `{heading}` gives no unit: its steps of {step} are taken for {unit} (for seconds write \"s\" in the place of \"{unit}\" in the records)"
            ),
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
            Remark::BadRows { missing, repeated, kept } => {
                let missing = missing.map(|line| format!("values are missing (first in line {line})"));
                let repeated = repeated.map(|line| format!("a time stands twice (first in line {line})"));
                let what: Vec<String> = missing.into_iter().chain(repeated).collect();
                f.write_str(&what.join(" and "))?;
                match kept {
                    Some((first, last, all)) => write!(
                        f,
                        ": the windows take the longest stretch without, rows {first} to {last} of {all}. To use all, delete the bad lines in the file"
                    ),
                    None => f.write_str(
                        ", so often that no long stretch is left: delete those lines in the file before you run this",
                    ),
                }
            }
        }
    }
}
