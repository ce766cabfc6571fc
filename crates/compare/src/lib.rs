//! Results beside each other: which numbers changed between two of them, and which of many machines stands out.
//!
//! ```text
//! Estimates of two records --changes-----> Changes: the fewest numbers whose change explains the difference
//! Estimates of many        --population--> Population: spread, who stands out, intervals that know the others
//! ```

mod changes;
mod estimates;
mod force_curve;
mod json_numbers;
mod population;
mod shrinkage;
mod unit;

pub use changes::{Changes, Difference, changes};
pub use estimates::{Estimates, HALF_WIDTH_95, Number};
pub use force_curve::{ForceCurve, mean_curve};
pub use population::{Beside, Member, Population, Spread, population};
pub use unit::{Cause, Comparison, Fleet, Unit};

/// The share of comparisons of unchanged machines in which a change is told: one in a hundred, by convention.
pub const FALSE_ALARMS: f64 = 0.01;
