//! What is odd about a record: each kind with its numbers, and in words with what to do.

use phisindy_signal::Interpolation;
use std::fmt;

/// Something odd about a record before any model is fitted. It stops nothing. `Display` says it in words,
/// without the name of the record.
///
/// Columns are named as the spec names the state or input that they measure. Times are in seconds, values in
/// SI.
#[derive(Clone, Debug, PartialEq)]
pub enum Suspicion {
    /// No samples for a while.
    MissingSamples {
        /// The last sample before it.
        from: f64,
        /// The first sample after it.
        to: f64,
        /// Its length in usual steps.
        steps: f64,
        /// How many such gaps there are; this is the first one.
        count: usize,
    },
    /// A column with one value in all samples.
    Constant {
        /// The column.
        column: String,
        /// Its value.
        value: f64,
        /// How many samples.
        samples: usize,
    },
    /// A column with few levels: too few digits, or a coarse sensor.
    Quantised {
        /// The column.
        column: String,
        /// How many levels lie between its least and greatest value.
        levels: f64,
        /// Between two of them.
        step: f64,
        /// The standard deviation of the column.
        size: f64,
    },
    /// A column that repeats each value for several samples.
    Repeated {
        /// The column.
        column: String,
        /// How many samples each value usually stands.
        length: usize,
        /// Whether it is an input, which the actuator may have held as well.
        input: bool,
    },
    /// A column that is cut off at the end of its range.
    Clipped {
        /// The column.
        column: String,
        /// Its least and greatest value.
        range: (f64, f64),
        /// How many samples are cut off.
        samples: usize,
        /// Whether it is an input, which may be limited itself.
        input: bool,
    },
    /// An input that moves between its samples more than they tell.
    Undersampled {
        /// The input.
        input: String,
        /// Standard error between the samples, as a part of the standard deviation of the input.
        error: f64,
        /// How it is interpolated.
        interpolation: Interpolation,
    },
    /// An input that holds levels and is interpolated as if it moved between them.
    Switched {
        /// The input.
        input: String,
        /// How many jumps it has.
        jumps: usize,
        /// Standard error of the interpolation, as a part of the standard deviation of the input.
        error: f64,
    },
    /// A counter that overflows, or an angle that begins again after a turn.
    Wrapped {
        /// The column.
        column: String,
        /// By how much it jumps (SI).
        period: f64,
        /// The last time before the first jump.
        time: f64,
        /// How many jumps there are.
        count: usize,
    },
    /// A stretch of equal values in a column that has noise or moves before and after it.
    Frozen {
        /// The column.
        column: String,
        /// The value that stands there.
        value: f64,
        /// How many samples.
        samples: usize,
        /// Its first and last sample.
        from_to: (f64, f64),
        /// How many such stretches there are; this is the first one.
        count: usize,
    },
    /// A sample far from its neighbours.
    Spike {
        /// The column.
        column: String,
        /// What it says there.
        value: f64,
        /// When.
        time: f64,
        /// How many spikes there are; this is the first one.
        count: usize,
    },
    /// A displacement whose level is another one from one sample to the next.
    Jump {
        /// The column.
        column: String,
        /// Time and value before it.
        before: (f64, f64),
        /// Time and value after it.
        after: (f64, f64),
        /// How many jumps there are; this is the first one.
        count: usize,
    },
    /// A displacement that moves at another scale than its velocity.
    RateScaled {
        /// The displacement.
        displacement: String,
        /// Its velocity.
        velocity: String,
        /// Rate of the displacement over the velocity.
        factor: f64,
    },
    /// A velocity that has the sign of minus the rate of its displacement.
    RateReversed {
        /// The displacement.
        displacement: String,
        /// Its velocity.
        velocity: String,
    },
    /// A displacement that is the rate of its velocity.
    PairSwapped {
        /// The column of the displacement.
        displacement: String,
        /// The column of the velocity.
        velocity: String,
    },
    /// Columns that must be exchanged for each velocity to be the rate of its displacement.
    SwappedByRates {
        /// The pairs of columns of which one should be exchanged; the likeliest first.
        candidates: Vec<(String, String)>,
    },
    /// Columns that must be exchanged for the known part to give the measured acceleration.
    SwappedByModel {
        /// One column.
        first: String,
        /// The other one.
        second: String,
    },
    /// A column that must be multiplied for the known part to give the measured acceleration.
    ColumnScaled {
        /// The column.
        column: String,
        /// A power of 1000, or -1.
        factor: f64,
    },
    /// A part of the known rate that must be multiplied for it to be the measured acceleration.
    PartScaled {
        /// The velocity whose rate it is.
        velocity: String,
        /// The parts, as expressions.
        parts: Vec<String>,
        /// A power of 1000, or -1.
        factor: f64,
        /// Whether a time column in milliseconds would explain it as well.
        clock: bool,
    },
}

impl fmt::Display for Suspicion {
    // One arm for each sentence: the table is longer than 80 lines, and has no logic to divide.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Suspicion::MissingSamples { from, to, steps, count } => write!(
                f,
                "no samples from {from:.6} s to {to:.6} s, {steps:.0} times the usual step{}: inputs are interpolated across it, \
                 and noise and smoothing count samples as if there were no hole; cut the record there with `window`",
                if *count > 1 { format!(" ({count} such holes)") } else { String::new() }
            ),
            Suspicion::Constant { column, value, samples } => {
                write!(f, "`{column}` is {value} in all {samples} samples: is the sensor connected?")
            }
            Suspicion::Quantised { column, levels, step, size } => write!(
                f,
                "`{column}` has only {levels:.0} different values, {step:.1e} apart: each is off by up to {:.0} % of the size of the motion; write more digits, or use a finer sensor",
                50.0 * step / size
            ),
            Suspicion::Repeated { column, length, input } => {
                write!(
                    f,
                    "`{column}` has a new value only every {length} samples, and repeats the old one between them: what is written \
                     there is up to {} samples late; ",
                    length - 1
                )?;
                if *input {
                    write!(
                        f,
                        "if the actuator held it as well, write `interpolate: {{ \"{column}\": Hold }}`; if not, keep only the rows in \
                         which it changes"
                    )
                } else {
                    write!(f, "keep only the rows in which it changes, one in {length}")
                }
            }
            Suspicion::Clipped { column, range: (min, max), samples, input: true } => write!(
                f,
                "`{column}` stays at {} or {} in {samples} samples, and is still moving when it gets there: is that what acted, or was the sensor at the end of its range?",
                short(*min),
                short(*max)
            ),
            Suspicion::Clipped { column, range: (min, max), samples, input: false } => write!(
                f,
                "`{column}` is cut off at {} or {} in {samples} samples: the sensor was at the end of its range, and \
                 what it hides is fitted as if it were motion",
                short(*min),
                short(*max)
            ),
            Suspicion::Undersampled { input, error, interpolation } => {
                write!(
                    f,
                    "between its samples `{input}` has to be guessed, with an error of about {:.1} % of its size; ",
                    100.0 * error
                )?;
                match interpolation {
                    Interpolation::Linear => {
                        write!(
                            f,
                            "`interpolate: {{ \"{input}\": Cubic }}` if it is smooth, or sample it faster"
                        )
                    }
                    Interpolation::Cubic | Interpolation::Hold => f.write_str("sample it faster"),
                }
            }
            Suspicion::Switched { input, jumps, error } => write!(
                f,
                "`{input}` holds its value and jumps ({jumps} time{}), but is interpolated as if it moved from one value to the next, an error of {:.1} % of its size; write `interpolate: {{ \"{input}\": Hold }}`",
                if *jumps == 1 { "" } else { "s" },
                100.0 * error
            ),
            Suspicion::Wrapped { column, period, time, count } => write!(
                f,
                "`{column}` wraps: it jumps by {period} (SI) from one end of its range to the other, {count} time{}, first after \
                 {time:.6} s: a counter that overflows, or an angle that begins again after a turn; write it unwrapped into the \
                 file, as `numpy.unwrap(values, period=...)` does",
                if *count == 1 { "" } else { "s" }
            ),
            Suspicion::Frozen { column, value, samples, from_to: (from, to), count } => write!(
                f,
                "`{column}` is {} in {samples} samples from {from:.6} s to {to:.6} s{}, and moves or has noise before and \
                 after them: the sensor dropped out or the logger repeated a value; repair or cut this part",
                short(*value),
                if *count > 1 {
                    format!(" (and in {} more such stretches)", count - 1)
                } else {
                    String::new()
                }
            ),
            Suspicion::Spike { column, value, time, count } => write!(
                f,
                "`{column}` jumps to {} and back in the sample at {time:.6} s{}: a spike of the sensor weighs as much as a \
                 hundred good samples; repair or cut it",
                short(*value),
                if *count > 1 { format!(" (and in {} more)", count - 1) } else { String::new() }
            ),
            Suspicion::Jump { column, before, after, count } => write!(
                f,
                "`{column}` jumps between {:.6} s and {:.6} s and stays at the new level ({}, then {}){}: a body does not do that, so the sensor slipped or was reset; cut the record there with `window`",
                before.0,
                after.0,
                short(before.1),
                short(after.1),
                if *count > 1 { format!(" ({count} such jumps)") } else { String::new() }
            ),
            Suspicion::RateScaled { displacement, velocity, factor } => write!(
                f,
                "`{displacement}` moves at {} the rate that `{velocity}` gives: is the unit of one of them, or of time, right?",
                near_power_of_ten(*factor)
            ),
            Suspicion::RateReversed { displacement, velocity } => write!(
                f,
                "`{velocity}` has the opposite sign of the rate of `{displacement}`: one of the two sensors is mounted the other \
                 way round"
            ),
            Suspicion::PairSwapped { displacement, velocity } => write!(
                f,
                "`{displacement}` is the rate of `{velocity}`, and not the other way round: the two columns are probably swapped"
            ),
            Suspicion::SwappedByRates { candidates } => {
                let named: Vec<String> = candidates.iter().map(|(a, b)| format!("`{a}` and `{b}`")).collect();
                write!(
                    f,
                    "with {} exchanged each velocity is the rate of its displacement, and as they are it is not: the two columns \
                     are probably swapped",
                    named.join(" (or ") + if named.len() > 1 { ")" } else { "" }
                )
            }
            Suspicion::SwappedByModel { first, second } => write!(
                f,
                "with `{first}` and `{second}` exchanged the model gives the measured acceleration, and as they are it does not: the two \
                 columns are probably swapped"
            ),
            Suspicion::ColumnScaled { column, factor } if *factor < 0.0 => write!(
                f,
                "the model gives the measured acceleration only if the column `{column}` changes its sign: which way does its sensor count?"
            ),
            Suspicion::ColumnScaled { column, factor } => write!(
                f,
                "the model gives the measured acceleration only if the column `{column}` is {} as large: is it in the unit that the spec says?",
                times(*factor)
            ),
            Suspicion::PartScaled { velocity, parts, factor, .. } if *factor < 0.0 => write!(
                f,
                "the model gives the measured acceleration of `{velocity}` only if its part in {} changes its sign: check the signs of the equation, and the direction and the zero of the sensors",
                quoted(parts)
            ),
            Suspicion::PartScaled { velocity, parts, factor, clock } => {
                let (plural, are) = if parts.len() > 1 { ("s", "are") } else { ("", "is") };
                write!(
                    f,
                    "the model gives the measured acceleration of `{velocity}` only if its part{plural} in {} {are} {} as large: check the units of the constants and columns there, and of the measured motion{}",
                    quoted(parts),
                    times(*factor),
                    if *clock { ", or of the time column" } else { "" }
                )
            }
        }
    }
}

/// `` `a`, `b` ``.
fn quoted(parts: &[String]) -> String {
    parts.iter().map(|part| format!("`{part}`")).collect::<Vec<_>>().join(", ")
}

/// `1000 times`, `1/1000 times`.
fn times(factor: f64) -> String {
    if factor > 1.0 { format!("{factor} times") } else { format!("1/{} times", (1.0 / factor).round()) }
}

/// The size of a factor; near a power of ten as that.
fn near_power_of_ten(factor: f64) -> String {
    let power = factor.abs().log10().round();
    let round = (factor.abs() / 10f64.powf(power) - 1.0).abs() < 0.15;
    match (round, power > 0.0) {
        (true, true) => format!("{:.0} times", 10f64.powf(power)),
        (true, false) => format!("1/{:.0} of", 10f64.powf(-power)),
        _ => format!("{factor:.3} times"),
    }
}

/// Six decimals, or as many digits of a number that is large.
fn short(x: f64) -> String {
    if x.abs() < 1e9 { format!("{x:.6}") } else { format!("{x:.6e}") }
}

#[cfg(test)]
mod tests;
