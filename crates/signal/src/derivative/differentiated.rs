//! A column with its derivative.

use super::smoothing::Smoothing;

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
    /// tests on noisy motion the true error is 0.8 to 1.8 times this, mostly at corners and at the ends of
    /// the record. Without noise it is only a lower bound.
    pub std_error: f64,
    /// What was done: method, window or cutoff, noise.
    pub smoothing: Smoothing,
}
