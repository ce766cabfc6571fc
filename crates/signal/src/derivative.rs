//! The time derivative of a noisy sampled column. The noise level decides how much is smoothed.

mod differentiated;
mod local;
mod noise;
mod smoothing;
mod spectral;
mod spline;
#[cfg(test)]
mod tests;

pub use differentiated::Differentiated;
pub use smoothing::Smoothing;

use crate::interpolate::{SignalError, check_samples};

/// Least number of samples for a derivative: a cubic and one degree of freedom.
const LEAST_SAMPLES: usize = 5;

/// How a column is differentiated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Differentiator {
    /// Fourier series of the record, continued by odd reflection about the line through its ends, and
    /// truncated where the motion falls below the noise. Best for smooth motion on a uniform grid; other
    /// grids are resampled first. It assumes zero curvature at both ends, so a few samples there are less
    /// accurate.
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
