//! A number with its uncertainty.

use crate::decisions::HALF_WIDTH_95;

/// A number with its uncertainty.
///
/// ```
/// let mass = phisindy_learn::Estimate::normal(2.0, 0.1);
/// assert!((mass.ci95.1 - 2.196).abs() < 1e-4);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Best value (SI).
    pub value: f64,
    /// Standard error; infinite where the data say nothing.
    pub std_error: f64,
    /// 95 % interval.
    pub ci95: (f64, f64),
}

impl Estimate {
    /// With the interval of a normal distribution.
    pub fn normal(value: f64, std_error: f64) -> Estimate {
        let reach = HALF_WIDTH_95 * std_error;
        Estimate { value, std_error, ci95: (value - reach, value + reach) }
    }

    /// Widens both by another variance: that between records, or that of a noisy input.
    pub(crate) fn widen(&mut self, variance: f64) {
        if variance > 0.0 {
            self.std_error = (self.std_error.powi(2) + variance).sqrt();
            // Each side of the interval keeps its shape.
            let more = HALF_WIDTH_95 * variance.sqrt();
            let (below, above) = (self.value - self.ci95.0, self.ci95.1 - self.value);
            self.ci95 = (self.value - below.hypot(more), self.value + above.hypot(more));
        }
    }
}
