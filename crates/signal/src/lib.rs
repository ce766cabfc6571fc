//! Numerics on sampled columns. They know slices of numbers and nothing of specs, systems or records.
//!
//! ```text
//! rows of a file --Blocks, Trend--> column --noise_level--> noise level
//!                                     +--differentiate--> smoothed column and its derivative
//!                                     +--strongest_line(s)--> spectral lines
//!                                     +--Signal--> value and slope at any time
//! residual --whiteness_p_value, whiteness_score--> is it more than white noise?
//!     +--effective_samples--> effective number of independent samples
//!     +--evidence_of_colour--> is it noise with a colour?
//! ```

mod autocorrelation;
mod autoregression;
mod band;
mod blocks;
mod derivative;
mod fft;
mod grid;
mod interpolate;
mod lines;
mod noise_level;
mod piecewise_constant;
mod statistics;
#[cfg(any(test, feature = "test-signals"))]
#[allow(missing_docs)]
#[doc(hidden)]
pub mod test_signals;
mod trend;
mod whiteness;

pub use autocorrelation::{autocorrelation, effective_samples};
pub use autoregression::evidence_of_colour;
pub use band::{integral, lowest_frequency, twice_integrated};
pub use blocks::Blocks;
pub use derivative::{Differentiated, Differentiator, Smoothing, automatic, differentiate};
pub use grid::{mean_step, on_straight_lines};
pub use interpolate::{Interpolation, Signal, SignalError};
pub use lines::{Line, strongest_line, strongest_lines, tone_share};
pub use noise_level::quantum::{quantum, rounding_error};
pub use noise_level::{noise_level, noise_level_at};
pub use piecewise_constant::{holds_levels, moves_by_jumps};
pub use statistics::{bounds, lowest_point, median, standard_deviation};
pub use trend::{Detrend, Trend};
pub use whiteness::{whiteness_p_value, whiteness_score};
