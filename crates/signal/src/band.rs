//! The band of a motion: below its lowest frequency a column holds noise alone, and an integral of it only
//! drifts.

use crate::fft::periodogram;
use crate::grid::mean_step;
use crate::noise_level::noise_level;

/// The lowest frequency (rad/s) at which a column holds more than its noise: below it the sum of the spectrum
/// is at most twice that of white noise of its level, or a millionth of the whole, which the window lets
/// through. At least that of two periods in the record.
///
/// ```
/// use phisindy_signal::lowest_frequency;
/// let time: Vec<f64> = (0..2000).map(|i| 0.01 * f64::from(i)).collect();
/// let column: Vec<f64> = time.iter().map(|t| (9.0 * t).sin() + (23.0 * t).sin()).collect();
/// let lowest = lowest_frequency(&time, &column);
/// assert!((5.0..9.1).contains(&lowest), "{lowest}");
/// ```
pub fn lowest_frequency(time: &[f64], values: &[f64]) -> f64 {
    let n = values.len();
    let bin = 2.0 * std::f64::consts::PI / (n as f64 * mean_step(time));
    // The window of the periodogram leaves this part of white noise.
    let noise = 0.375 * n as f64 * noise_level(values).powi(2);
    let spectrum = periodogram(values);
    let through = 1e-6 * spectrum.iter().skip(2).sum::<f64>();
    let (mut sum, mut last) = (0.0, 2);
    for (k, power) in spectrum.iter().enumerate().skip(2) {
        sum += power;
        if sum > (2.0 * noise * (k - 1) as f64).max(through) {
            break;
        }
        last = k;
    }
    bin * last as f64
}

/// The second integral over time of a column, without what drifts: the displacement of an accelerometer,
/// about its mean. For start values: near the ends it is less accurate.
///
/// A trapezoidal sum, less its mean over two periods of the lowest frequency about each sample, twice.
///
/// ```
/// use phisindy_signal::twice_integrated;
/// let time: Vec<f64> = (0..2000).map(|i| 0.01 * f64::from(i)).collect();
/// let acceleration: Vec<f64> = time.iter().map(|t| 0.3 - 25.0 * (5.0 * t).sin()).collect();
/// let x = twice_integrated(&time, &acceleration);
/// let worst = (500..1500).map(|i| (x[i] - (5.0 * time[i]).sin()).abs()).fold(0.0, f64::max);
/// assert!(worst < 0.15, "{worst}");
/// ```
pub fn twice_integrated(time: &[f64], values: &[f64]) -> Vec<f64> {
    if values.len() < 2 {
        return vec![0.0; values.len()];
    }
    let window = 4.0 * std::f64::consts::PI / lowest_frequency(time, values);
    let half = ((0.5 * window / mean_step(time)) as usize).max(1);
    let acceleration = without_drift(values, half);
    let velocity = without_drift(&integral(time, &acceleration), half);
    without_drift(&integral(time, &velocity), half)
}

/// The integral from the first sample, by the trapezoidal rule.
pub fn integral(time: &[f64], rate: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let step = |i: usize| {
        if i > 0 {
            sum += 0.5 * (rate[i] + rate[i - 1]) * (time[i] - time[i - 1]);
        }
        sum
    };
    (0..rate.len()).map(step).collect()
}

/// Less the mean over so many samples on either side; near the ends, less the line through what is there.
fn without_drift(values: &[f64], half: usize) -> Vec<f64> {
    let n = values.len();
    let line = |i: usize| {
        let (a, b) = (i.saturating_sub(half), (i + half + 1).min(n));
        let count = (b - a) as f64;
        let middle = 0.5 * (a + b - 1) as f64;
        let mean = values[a..b].iter().sum::<f64>() / count;
        let (mut cross, mut square) = (0.0, 0.0);
        for (j, v) in values[a..b].iter().enumerate() {
            let d = (a + j) as f64 - middle;
            cross += d * v;
            square += d * d;
        }
        mean + if square > 0.0 { cross / square * (i as f64 - middle) } else { 0.0 }
    };
    (0..n).map(|i| values[i] - line(i)).collect()
}
