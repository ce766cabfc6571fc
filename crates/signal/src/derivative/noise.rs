//! The noise of a column that is to be differentiated, on any grid.

use crate::grid::uniform_step;
use crate::noise_level::noise_level;
use crate::noise_level::quantum::rounding_error;
use crate::statistics::{largest, median};

/// Standard deviation of the noise: from the spectrum on a nearly uniform grid, else from third divided
/// differences. Never less than the rounding error of the numbers.
pub(super) fn noise_of(time: &[f64], values: &[f64]) -> f64 {
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
