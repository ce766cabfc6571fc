//! What was done to the data of a record before anything sees them, as numbers and in words.

use phisindy_signal::{Smoothing, Trend};
use std::fmt;

/// Something that was done to the data of a record.
#[derive(Clone, Debug, PartialEq)]
pub enum Note {
    /// An input was differentiated from another one, which is smoothed with it.
    DerivedInput {
        /// The derivative.
        input: String,
        /// The input it is the derivative of.
        of: String,
        /// How.
        smoothing: Smoothing,
    },
    /// A velocity without a column was differentiated from its displacement.
    DerivedVelocity {
        /// The velocity.
        velocity: String,
        /// Its displacement.
        displacement: String,
        /// How.
        smoothing: Smoothing,
    },
    /// Rows in which a value is missing were left out.
    Omitted {
        /// The file.
        path: String,
        /// Their number.
        omitted: usize,
        /// Samples of the record.
        kept: usize,
        /// The longest step that is left, in seconds.
        gap: f64,
    },
    /// Rows of a file were replaced by their means.
    Decimated {
        /// The file.
        path: String,
        /// Rows in each mean.
        rows: u32,
        /// The part of the amplitude of the motion that this takes away, where it matters.
        loss: Option<f64>,
    },
    /// The trend of a column was taken off.
    Detrended {
        /// The state or input.
        column: String,
        /// The unit of the column in its file, if the spec states one.
        unit: Option<String>,
        /// In that unit.
        trend: Trend,
        /// Whether it is that of the first record of the file.
        shared: bool,
    },
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Note::DerivedInput { input, of, smoothing } => {
                write!(f, "{input} is the derivative of {of}, and {of} is smoothed with it: {smoothing}")
            }
            Note::DerivedVelocity { velocity, displacement, smoothing } => {
                write!(f, "{velocity} is the derivative of {displacement} ({smoothing})")
            }
            Note::Omitted { path, omitted, kept, gap } => {
                let (rows, are, have) =
                    if *omitted == 1 { ("row", "is", "it has") } else { ("rows", "are", "they have") };
                write!(
                    f,
                    "{omitted} {rows} of `{path}` {are} left out, for {have} no value in some column; {kept} samples are left, \
                     the longest step between them is {gap:.3e} s (missing)"
                )
            }
            Note::Decimated { path, rows, loss } => {
                write!(f, "each sample is the mean of {rows} rows of `{path}` (decimate)")?;
                let Some(loss) = loss else { return Ok(()) };
                write!(
                    f,
                    "; that takes {:.1} % off the amplitude of the motion, and rounds its stops and turns more than that: \
                     what the result says of friction is off by as much; decimate less",
                    100.0 * loss
                )
            }
            Note::Detrended { column, unit, trend, shared } => {
                let unit = unit.as_ref().map_or(String::new(), |unit| format!(" {unit}"));
                write!(f, "`{column}` without its trend: ")?;
                if trend.slope == 0.0 {
                    write!(f, "{:.6e}{unit}", trend.offset)?;
                } else {
                    write!(
                        f,
                        "the line {:.6e}{unit} at time {:.6} s, slope {:.3e}{unit} per s",
                        trend.offset, trend.at, trend.slope
                    )?;
                }
                write!(
                    f,
                    " is taken off (detrend{})",
                    if *shared { ", as in the first record of this file" } else { "" }
                )
            }
        }
    }
}
