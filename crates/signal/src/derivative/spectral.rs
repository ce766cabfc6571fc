//! Derivative of the Fourier series of a reflected record, truncated where the motion falls below the noise.

use std::f64::consts::PI;
use std::sync::Arc;

use realfft::num_complex::Complex;

use super::differentiated::Differentiated;
use super::noise::noise_of;
use super::smoothing::Smoothing;
use crate::fft::{Forward, Inverse};
use crate::grid::uniform_step;
use crate::interpolate::{Interpolation, Signal, SignalError};

pub(super) fn differentiate(time: &[f64], values: &[f64]) -> Result<Differentiated, SignalError> {
    let noise = noise_of(time, values);
    if let Some(step) = uniform_step(time, 1e-6) {
        return Ok(uniform(step, values, noise, false));
    }
    // Resampling by a spline is far more accurate on smooth motion than by straight lines, and does not
    // change the noise.
    let n = time.len();
    let (first, span) = (time[0], time[n - 1] - time[0]);
    let grid: Arc<[f64]> = (0..n).map(|i| first + span * i as f64 / (n - 1) as f64).collect();
    let read = |from: Arc<[f64]>, column: &[f64], at: &[f64]| -> Result<Vec<f64>, SignalError> {
        let signal = Signal::new(from, column.to_vec(), Interpolation::Cubic)?;
        let mut hint = 0;
        Ok(at.iter().map(|&t| signal.value_and_slope(t, &mut hint).0).collect())
    };
    let even = uniform(span / (n - 1) as f64, &read(Arc::from(time), values, &grid)?, noise, true);
    Ok(Differentiated {
        values: read(grid.clone(), &even.values, time)?,
        derivative: read(grid, &even.derivative, time)?,
        std_error: even.std_error,
        smoothing: even.smoothing,
    })
}

fn uniform(step: f64, values: &[f64], noise: f64, resampled: bool) -> Differentiated {
    let n = values.len();
    // The odd reflection about the line through both ends makes the record periodic with a continuous slope.
    let period = 2 * (n - 1);
    let (first, rise) = (values[0], (values[n - 1] - values[0]) / (n - 1) as f64);
    let line = |i: usize| first + rise * i as f64;
    let mut reflected = vec![0.0; period];
    for i in 1..n - 1 {
        let v = values[i] - line(i);
        reflected[i] = v;
        reflected[period - i] = -v;
    }
    let mut spectrum = Forward::new(period).of(&mut reflected);
    let cut = cut_off(&spectrum, noise, period);
    let omega = |k: usize| 2.0 * PI * k as f64 / (period as f64 * step);
    let scale = 1.0 / period as f64;
    let mut derivative_spectrum = spectrum.clone();
    let (mut passed, last) = (0.0, spectrum.len() - 1);
    for (k, (z, dz)) in spectrum.iter_mut().zip(&mut derivative_spectrum).enumerate() {
        let gain = roll_off(k, cut) * scale;
        // The spectrum of an odd record is imaginary, and zero at both ends, where the inverse transform
        // requires real numbers.
        let amplitude = if k == 0 || k == last { 0.0 } else { z.im * gain };
        *z = Complex::new(0.0, amplitude);
        *dz = Complex::new(-omega(k) * amplitude, 0.0);
        passed += 2.0 * (omega(k) * roll_off(k, cut)).powi(2);
    }
    let inverse = Inverse::new(period);
    let (smooth, slope) = (inverse.of(&mut spectrum), inverse.of(&mut derivative_spectrum));
    let hertz = omega(cut.min(last)) / (2.0 * PI);
    Differentiated {
        values: (0..n).map(|i| smooth[i] + line(i)).collect(),
        derivative: (0..n).map(|i| slope[i] + rise / step).collect(),
        std_error: noise * (passed * scale).sqrt(),
        smoothing: Smoothing::FourierSeries { cutoff: hertz, noise, resampled },
    }
}

/// The index of the last line that is kept: it minimises the estimated mean squared error of the derivative
/// (Mallows' Cp).
///
/// On average, keeping line k costs k^2 noise, and dropping it costs k^2 (power - noise).
fn cut_off(spectrum: &[Complex<f64>], noise: f64, period: usize) -> usize {
    let floor = noise * noise * period as f64;
    let (mut sum, mut least, mut best) = (0.0, 0.0, 1);
    for (k, z) in spectrum.iter().enumerate().skip(1) {
        sum += (k as f64).powi(2) * (2.0 * floor - z.norm_sqr());
        if sum < least {
            (least, best) = (sum, k);
        }
    }
    best
}

/// 1 up to the cutoff, then half a cosine down to 0 at 1.25 times the cutoff. A sharp edge would ring.
fn roll_off(k: usize, cut: usize) -> f64 {
    let above = (k as f64 / cut as f64 - 1.0) / 0.25;
    if above <= 0.0 {
        1.0
    } else if above >= 1.0 {
        0.0
    } else {
        0.5 * (1.0 + (PI * above).cos())
    }
}
