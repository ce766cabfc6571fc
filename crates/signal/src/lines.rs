//! Spectral lines of a column.
//!
//! There are two finders, because they answer two questions:
//!
//! - [`strongest_line`] asks how a column mainly moves. It takes any time grid, removes the straight line,
//!   limits the number of samples, interpolates between bins by the ratio of two amplitudes, and says which
//!   share of the variance the line holds.
//! - [`strongest_lines`] asks which tones stand out of a residual or an input. It takes a uniform grid,
//!   removes the mean alone, compares powers with a noise that may rise with the frequency, and interpolates
//!   by a parabola through logarithms.
//!
//! Their frequencies agree to a fraction of a bin, not to the last bit.

use crate::fft::{hann, periodogram, power};
use crate::grid::linear_resampled;
use crate::statistics::largest;
use crate::trend::without_line;

/// Longer columns are read on a coarser grid: no motion of interest has so many periods.
const MAX_SAMPLES: usize = 1 << 16;

/// A frequency and its share of the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Periods per unit of time.
    pub frequency: f64,
    /// The part of the variance that lies in this line, from 0 to 1.
    pub share: f64,
}

/// The strongest line of a column after its straight line is removed. Uneven grids are resampled.
///
/// Returns `None` for a column that does not vary or has fewer than 16 samples.
///
/// ```
/// let time: Vec<f64> = (0..1000).map(|i| 0.01 * f64::from(i)).collect();
/// let swing: Vec<f64> = time.iter().map(|t| (2.0 * std::f64::consts::PI * 1.23 * t).sin()).collect();
/// let line = phisindy_signal::strongest_line(&time, &swing).unwrap();
/// assert!((line.frequency - 1.23).abs() < 0.005 && line.share > 0.9);
/// ```
pub fn strongest_line(time: &[f64], values: &[f64]) -> Option<Line> {
    let samples = time.len().min(values.len());
    let (time, values) = (&time[..samples], &values[..samples]);
    let n = samples.min(MAX_SAMPLES);
    let (first, last) = (*time.first()?, *time.last()?);
    // A comparison that is false for NaN.
    let forward = last - first > 0.0;
    if n < 16 || !forward {
        return None;
    }
    let step = (last - first) / (n - 1) as f64;
    let even = linear_resampled(time, values, step, n);
    let mut windowed: Vec<f64> =
        without_line(&even).iter().enumerate().map(|(i, x)| hann(i, n) * x).collect();
    let power = power(&mut windowed);
    let total: f64 = power.iter().skip(1).sum();
    let top = (1..power.len().saturating_sub(1)).max_by(|&a, &b| power[a].total_cmp(&power[b]))?;
    // Rounding leaves this much of a column that does not vary.
    if !(total.is_finite() && total > (1e-12 * largest(&even) * n as f64).powi(2)) {
        return None;
    }
    // Between bins: the Hann window fixes the ratio of the two largest amplitudes.
    let amplitude = |k: usize| power[k].sqrt();
    let up = amplitude(top + 1) >= amplitude(top - 1) || top == 1;
    let ratio = amplitude(if up { top + 1 } else { top - 1 }) / amplitude(top);
    let shift = ((2.0 * ratio - 1.0) / (ratio + 1.0)).clamp(0.0, 0.5);
    let bin = top as f64 + if up { shift } else { -shift };
    let around = power[top.saturating_sub(2).max(1)..(top + 3).min(power.len())].iter().sum::<f64>();
    Some(Line { frequency: bin / (n as f64 * step), share: around / total })
}

/// At most `count` angular frequencies (radians per unit of `step`) of a uniformly sampled column, strongest
/// first.
///
/// The power of the noise is taken to rise with the frequency to the power `rise`: 0 for white noise, 4 for
/// its second derivative. Lines are at least 2.5 bins apart. Fewer than 16 samples give none.
pub fn strongest_lines(values: &[f64], step: f64, count: usize, rise: i32) -> Vec<f64> {
    let n = values.len();
    if n < 16 {
        return vec![];
    }
    let power: Vec<f64> =
        periodogram(values).iter().enumerate().map(|(k, p)| p / (k.max(1) as f64).powi(rise)).collect();
    let mut peaks: Vec<usize> =
        (1..power.len() - 1).filter(|&k| power[k] > power[k - 1] && power[k] >= power[k + 1]).collect();
    peaks.sort_unstable_by(|&a, &b| power[b].total_cmp(&power[a]));
    let mut chosen: Vec<f64> = Vec::new();
    for k in peaks {
        // A parabola through the logarithms.
        let [a, b, c] = [power[k - 1], power[k], power[k + 1]].map(|p| p.max(f64::MIN_POSITIVE).ln());
        let bend = a - 2.0 * b + c;
        let at = k as f64 + if bend < 0.0 { 0.5 * (a - c) / bend } else { 0.0 };
        let omega = 2.0 * std::f64::consts::PI * at / (n as f64 * step);
        if chosen.iter().all(|w| (w - omega).abs() * n as f64 * step > 2.0 * std::f64::consts::PI * 2.5) {
            chosen.push(omega);
        }
        if chosen.len() == count {
            break;
        }
    }
    chosen
}

/// The part of the variance of a column that one frequency holds, given in radians per sample; 0 for a column
/// that does not vary.
pub fn tone_share(values: &[f64], radians: f64) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let (mut re, mut im, mut power) = (0.0, 0.0, 0.0);
    for (i, value) in values.iter().enumerate() {
        let (sin, cos) = (radians * i as f64).sin_cos();
        re += (value - mean) * cos;
        im += (value - mean) * sin;
        power += (value - mean).powi(2);
    }
    if power > 0.0 { 2.0 * (re * re + im * im) / (n * power) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_uneven_grid_changes_little() {
        let time: Vec<f64> =
            (0..2000).map(|i| 0.01 * f64::from(i) + 0.003 * f64::from(i * 7919 % 11) / 11.0).collect();
        let values: Vec<f64> = time.iter().map(|t| 4.0 + 0.1 * t + (12.0 * t).cos()).collect();
        let line = strongest_line(&time, &values).expect("a line");
        assert!((line.frequency - 12.0 / std::f64::consts::TAU).abs() < 0.005, "{line:?}");
    }

    #[test]
    fn what_does_not_vary_has_no_line() {
        let time: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(strongest_line(&time, &vec![3.0; 100]), None);
        assert_eq!(strongest_line(&time, &time), None);
        assert_eq!(strongest_line(&time[..3], &time[..3]), None);
    }

    #[test]
    fn a_line_is_found_between_bins() {
        let x: Vec<f64> = (0..2000).map(|i| (0.1234 * f64::from(i)).cos()).collect();
        let found = strongest_lines(&x, 0.1, 1, 0);
        assert!((found[0] - 1.234).abs() < 2e-3, "{found:?}");
        assert!(strongest_lines(&x[..15], 0.1, 1, 0).is_empty());
    }

    #[test]
    fn a_tone_holds_its_part_of_the_power() {
        let tones: Vec<f64> = (0..5000)
            .map(|i| 3.0 + (0.07 * f64::from(i)).sin() + 0.5 * (0.31 * f64::from(i) + 1.0).cos())
            .collect();
        for (turn, due) in [(0.07, 0.8), (0.31, 0.2), (0.2, 0.0)] {
            let found = tone_share(&tones, turn);
            assert!((found - due).abs() < 0.01, "{turn}: {found}");
        }
    }
}
