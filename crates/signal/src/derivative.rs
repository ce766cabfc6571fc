//! The time derivative of a noisy sampled column. The noise level decides how much is smoothed.

mod local;
mod smoothing;
mod spectral;
mod spline;
#[cfg(test)]
mod tests;

pub use smoothing::Smoothing;

use crate::grid::uniform_step;
use crate::interpolate::{SignalError, check_samples};
use crate::noise_level::noise_level;
use crate::noise_level::quantum::rounding_error;
use crate::statistics::{largest, median};

/// Least number of samples for a derivative: a cubic and one degree of freedom.
const LEAST_SAMPLES: usize = 5;

/// How a column is differentiated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Differentiator {
    /// Fourier series of the record, continued by odd reflection about the line through its ends, and truncated
    /// where the motion falls below the noise. Best for smooth motion on a uniform grid; other grids are
    /// resampled first. It assumes zero curvature at both ends, so a few samples there are less accurate.
    Spectral,
    /// Local cubics by least squares (Savitzky and Golay 1964). The window is chosen at every sample: wide
    /// where the motion is smooth, narrow and one-sided at corners of the velocity (stops). Any grid.
    SavitzkyGolay,
    /// Cubic smoothing spline (Reinsch 1967) with generalised cross-validation. Any grid. Zero curvature at
    /// both ends, as `Spectral`.
    Spline,
}

impl Differentiator {
    /// All of them.
    pub const ALL: [Differentiator; 3] =
        [Differentiator::Spectral, Differentiator::SavitzkyGolay, Differentiator::Spline];

    /// Its name in specs.
    pub fn name(self) -> &'static str {
        match self {
            Differentiator::Spectral => "Spectral",
            Differentiator::SavitzkyGolay => "SavitzkyGolay",
            Differentiator::Spline => "Spline",
        }
    }
}

impl Default for Differentiator {
    /// [`Differentiator::SavitzkyGolay`], which works on any grid and keeps corners.
    fn default() -> Self {
        Differentiator::SavitzkyGolay
    }
}

/// A column, smoothed and differentiated.
#[derive(Clone, Debug, PartialEq)]
pub struct Differentiated {
    /// The smoothed column, in its unit.
    pub values: Vec<f64>,
    /// Its time derivative at the samples, in the column's unit per unit of time.
    pub derivative: Vec<f64>,
    /// Estimated root mean square error of the derivative over the record, in the derivative's unit.
    ///
    /// `Spectral` and `Spline` count the noise that they pass, `SavitzkyGolay` also its estimated bias. In
    /// tests on noisy motion the true error is 0.8 to 1.8 times this, mostly at corners and at the ends of the
    /// record. Without noise it is only a lower bound.
    pub std_error: f64,
    /// What was done: method, window or cutoff, noise.
    pub smoothing: Smoothing,
}

/// Differentiates the column `values`, sampled at the strictly increasing `time`.
///
/// Deterministic. For n samples the work is O(n w) for `SavitzkyGolay` with windows up to w, O(n log n) for
/// `Spectral`, O(n) for `Spline`.
///
/// # Errors
/// Different lengths, fewer than 5 samples, a number that is not finite, or times that do not increase.
///
/// ```
/// use phisindy_signal::{Differentiator, differentiate};
/// let time: Vec<f64> = (0..200).map(|i| 0.01 * f64::from(i)).collect();
/// let values: Vec<f64> = time.iter().map(|t| (3.0 * t).sin()).collect();
/// let slope = differentiate(&time, &values, Differentiator::SavitzkyGolay)?;
/// assert!((slope.derivative[100] - 3.0 * 3f64.cos()).abs() < 1e-5);
/// # Ok::<(), phisindy_signal::SignalError>(())
/// ```
pub fn differentiate(
    time: &[f64],
    values: &[f64],
    how: Differentiator,
) -> Result<Differentiated, SignalError> {
    check_samples(time, values, LEAST_SAMPLES)?;
    match how {
        Differentiator::Spectral => spectral::differentiate(time, values),
        Differentiator::SavitzkyGolay => Ok(local::differentiate(time, values)),
        Differentiator::Spline => Ok(spline::differentiate(time, values)),
    }
}

/// Differentiates with the default [`Differentiator`].
///
/// # Errors
/// As [`differentiate`].
///
/// ```
/// let time: Vec<f64> = (0..50).map(|i| 0.1 * f64::from(i)).collect();
/// let line: Vec<f64> = time.iter().map(|t| 2.0 - 0.5 * t).collect();
/// let slope = phisindy_signal::automatic(&time, &line)?;
/// assert!(slope.derivative.iter().all(|d| (d + 0.5).abs() < 1e-12));
/// # Ok::<(), phisindy_signal::SignalError>(())
/// ```
pub fn automatic(time: &[f64], values: &[f64]) -> Result<Differentiated, SignalError> {
    differentiate(time, values, Differentiator::default())
}

/// Standard deviation of the noise: from the spectrum on a nearly uniform grid, else from third divided
/// differences. Never less than the rounding error of the numbers.
fn noise_of(time: &[f64], values: &[f64]) -> f64 {
    let rounding = largest(values) * f64::EPSILON;
    let noise =
        if uniform_step(time, 0.05).is_some() { noise_level(values) } else { uneven_noise(time, values) };
    noise.max(rounding)
}

/// Noise on a non-uniform grid: the median of third divided differences, scaled to unit variance.
fn uneven_noise(time: &[f64], values: &[f64]) -> f64 {
    let mut residuals: Vec<f64> = time
        .windows(4)
        .zip(values.windows(4))
        .map(|(t, v)| {
            let weight = |i: usize| 1.0 / (0..4).filter(|&j| j != i).map(|j| t[i] - t[j]).product::<f64>();
            let weights = [weight(0), weight(1), weight(2), weight(3)];
            let size = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
            weights.iter().zip(v).map(|(w, v)| w * v).sum::<f64>().abs() / size
        })
        .collect();
    (median(&mut residuals) / 0.674_489_750_196_081_7).max(rounding_error(values))
}
