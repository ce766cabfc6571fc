//! The band of a motion: below its lowest frequency a column holds noise alone.

use crate::fft::periodogram;
use crate::grid::mean_step;
use crate::noise_level::noise_level;

/// The lowest frequency (rad/s) at which a column holds more than its noise: below it the sum of the spectrum is at
/// most twice that of white noise of its level. At least that of two periods in the record.
///
/// ```
/// use phisindy_signal::lowest_frequency;
/// let time: Vec<f64> = (0..2000).map(|i| 0.01 * f64::from(i)).collect();
/// let column: Vec<f64> = time.iter().map(|t| (9.0 * t).sin() + (23.0 * t).sin()).collect();
/// let lowest = lowest_frequency(&time, &column);
/// assert!((7.5..9.1).contains(&lowest), "{lowest}");
/// ```
pub fn lowest_frequency(time: &[f64], values: &[f64]) -> f64 {
    let n = values.len();
    let bin = 2.0 * std::f64::consts::PI / (n as f64 * mean_step(time));
    // The window of the periodogram leaves this part of white noise.
    let noise = 0.375 * n as f64 * noise_level(values).powi(2);
    let spectrum = periodogram(values);
    let (mut sum, mut last) = (0.0, 2);
    for (k, power) in spectrum.iter().enumerate().skip(2) {
        sum += power;
        if sum > 2.0 * noise * (k - 1) as f64 {
            break;
        }
        last = k;
    }
    bin * last as f64
}
