//! Numerics on sampled columns. They know slices of numbers and nothing of specs, systems or records.
//!
//! ```text
//! file rows --Blocks, Trend--> column --noise_level--> noise --differentiate--> smoothed column and its derivative
//!                                |                                                |
//!                                +--strongest_line, strongest_lines--> lines      +--Signal--> value and slope at any time
//!
//! residual --chance_of_white, whiteness_score--> is anything left but noise?   --effective_samples--> independent samples
//! ```

mod blocks;
mod derivative;
mod interpolate;
mod noise_level;
mod spectrum;
mod spread;
#[cfg(any(test, feature = "test-signals"))]
#[allow(missing_docs)]
#[doc(hidden)]
pub mod test_signals;
mod trend;
mod whiteness;

pub use blocks::Blocks;
pub use derivative::{Differentiated, Differentiator, Smoothing, automatic, differentiate};
pub use interpolate::{Interpolation, Signal, SignalError};
pub use noise_level::quantum::{quantum, rounding_error};
pub use noise_level::{autocorrelation, effective_samples, median, noise_level};
pub use spectrum::{Line, mean_step, strongest_line, strongest_lines, tone_share};
pub use spread::{bounds, standard_deviation};
pub use trend::{Detrend, Trend};
pub use whiteness::{chance_of_white, whiteness_score};
