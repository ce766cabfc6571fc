//! Local cubics with a window chosen at every sample.
//!
//! At each sample the derivative is estimated from windows of growing width. Narrow windows are noisy, wide
//! ones biased. The departure of a wide window from all narrower ones, beyond what noise explains, bounds its
//! bias. The window with the smallest sum of squared bias and variance is selected (A. Goldenshluger, O.
//! Lepski 2011). This is done for windows centred on the sample and for windows shifted to either side. Their
//! results are averaged with weights of inverse risk, so that near a stop the windows that do not reach
//! across it dominate. One cubic per window serves every sample that uses the window.
//!
//! Two alternatives were worse on stick-slip: the widest window whose confidence interval intersects those of
//! all narrower ones (one false alarm selects a far too narrow window), and the best shift alone (the average
//! has less noise).

use std::ops::Range;

use super::differentiated::Differentiated;
use super::noise::noise_of;
use super::smoothing::Smoothing;
use crate::grid::uniform_step;

/// Squared departure that noise explains, in variances of the narrower window. Below 6 false alarms dominate.
const EXPLAINED: f64 = 8.0;
/// Shifts of windows relative to their sample, in half widths.
const SHIFTS: [f64; 7] = [0.0, -1.0 / 3.0, 1.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0, -1.0, 1.0];
/// Widest half window, in samples. Beyond it the work grows and the error hardly falls.
const MAX_HALF_WIDTH: usize = 512;
/// Samples treated together. This bounds the memory; windows across the edges cost a quarter more.
const CHUNK: usize = 4096;

type Matrix = [[f64; 4]; 4];

/// Least-squares cubic on one window, in u = (t - centre)/scale.
#[derive(Clone, Copy)]
struct Cubic {
    coefficients: [f64; 4],
    centre: f64,
    scale: f64,
}

/// The estimate of one quantity at one sample from one window, with its standard error for unit noise.
#[derive(Clone, Copy)]
struct Estimate {
    value: f64,
    error: f64,
}

/// The result for one quantity at one sample: its value, its estimated squared error, and the width of the
/// shift with the largest weight.
struct Selected {
    value: f64,
    risk: f64,
    level: usize,
}

const UNKNOWN: Estimate = Estimate { value: 0.0, error: f64::INFINITY };

pub(super) fn differentiate(time: &[f64], values: &[f64]) -> Differentiated {
    let n = time.len();
    // Not zero: weights are inverse variances.
    let noise = noise_of(time, values).max(1e-100);
    let step = uniform_step(time, 1e-6);
    let halves: Vec<usize> = half_widths(n).collect();
    // The value needs narrower windows than the derivative: each has its own.
    let (mut smooth, mut slopes) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for first in (0..n).step_by(CHUNK) {
        let samples = first..n.min(first + CHUNK);
        let mut estimates = vec![[UNKNOWN; 2]; samples.len() * SHIFTS.len() * halves.len()];
        for (level, &half) in halves.iter().enumerate() {
            let centres = samples.start.saturating_sub(half).max(half)..(samples.end + half).min(n - half);
            // Near the ends of the record all shifts use the first or the last window.
            let centres = centres.start.min(n - 1 - half)..centres.end.max(half + 1);
            let windows = Windows::new(time, values, half, step, centres);
            let levels = estimates.iter_mut().skip(level).step_by(halves.len());
            let places = samples.clone().flat_map(|i| SHIFTS.iter().map(move |shift| (i, shift)));
            for ((i, shift), estimate) in places.zip(levels) {
                let centre =
                    (i as f64 + shift * half as f64).round().clamp(half as f64, (n - 1 - half) as f64);
                *estimate = windows.estimate(centre as usize, time[i]);
            }
        }
        for sample in estimates.chunks_exact(SHIFTS.len() * halves.len()) {
            smooth.push(combine(sample, 0, halves.len(), noise));
            slopes.push(combine(sample, 1, halves.len(), noise));
        }
    }
    let mut levels: Vec<usize> = slopes.iter().map(|a| a.level).collect();
    levels.sort_unstable();
    let width = |at: usize| 2 * halves[levels[at]] + 1;
    let (least, median, most) = (width(0), width(n / 2), width(n - 1));
    Differentiated {
        values: smooth.iter().map(|a| a.value).collect(),
        derivative: slopes.iter().map(|a| a.value).collect(),
        std_error: (slopes.iter().map(|a| a.risk).sum::<f64>() / n as f64).sqrt(),
        smoothing: Smoothing::LocalCubics { least, median, most, noise },
    }
}

/// The average over the shifts, each at its best width, weighted by inverse risk.
fn combine(estimates: &[[Estimate; 2]], quantity: usize, levels: usize, noise: f64) -> Selected {
    let mut best = [(UNKNOWN, f64::INFINITY, 0); SHIFTS.len()];
    for (shift, best) in estimates.chunks_exact(levels).zip(&mut best) {
        let shift = || shift.iter().map(|both| both[quantity]);
        for (level, wide) in shift().enumerate().filter(|(_, wide)| wide.error.is_finite()) {
            let variance = |e: Estimate| (noise * e.error).powi(2);
            let bias = shift().take(level).filter(|e| e.error.is_finite()).fold(0.0_f64, |bias, narrow| {
                bias.max((wide.value - narrow.value).powi(2) - EXPLAINED * variance(narrow))
            });
            let risk = bias + variance(wide);
            if risk < best.1 {
                *best = (wide, risk, level);
            }
        }
    }
    let least =
        best.iter().copied().fold(best[0], |least, shift| if shift.1 < least.1 { shift } else { least });
    let mut selected = Selected { value: 0.0, risk: least.1, level: least.2 };
    let (mut weights, mut roots, mut inverse_roots) = (0.0, 0.0, 0.0);
    for (estimate, risk, _) in best.iter().filter(|shift| shift.1.is_finite()) {
        let weight = least.1 / risk;
        weights += weight;
        selected.value += weight * estimate.value;
        roots += risk.sqrt();
        inverse_roots += 1.0 / risk.sqrt();
    }
    selected.value /= weights;
    // The squared geometric mean of the arithmetic and the harmonic mean of the standard errors. The least
    // risk would be too small, since it was selected for being small; tests confirm this choice.
    selected.risk = roots / inverse_roots;
    selected
}

/// 2, 3, 4, 6, 8, 11, ... samples to either side: a factor of about the square root of 2.
fn half_widths(n: usize) -> impl Iterator<Item = usize> {
    let widest = ((n - 1) / 2).min(MAX_HALF_WIDTH);
    let ladder = std::iter::successors(Some(2.0_f64), |h| Some(h * std::f64::consts::SQRT_2));
    ladder.map(|h| h.round() as usize).take_while(move |&h| h <= widest)
}

/// Windows of one width about consecutive samples.
struct Windows {
    first_centre: usize,
    cubics: Vec<Cubic>,
    /// Inverse normal matrices: one for all windows of a uniform grid, one for each otherwise.
    inverses: Vec<Matrix>,
}

impl Windows {
    fn new(time: &[f64], values: &[f64], half: usize, step: Option<f64>, centres: Range<usize>) -> Self {
        let first_centre = centres.start;
        let Some(step) = step else {
            let (cubics, inverses) = centres.map(|c| uneven_window(time, values, c, half)).unzip();
            return Self { first_centre, cubics, inverses };
        };
        let scale = step * half as f64;
        let powers: Vec<[f64; 4]> = (0..=2 * half).map(|j| powers(j as f64 / half as f64 - 1.0)).collect();
        let inverse = inverse_of_normal(&powers);
        let window = |c: usize| {
            let moments = moments(&powers, &values[c - half..=c + half], values[c]);
            Cubic::new(&inverse, moments, values[c], time[c], scale)
        };
        Self { first_centre, cubics: centres.map(window).collect(), inverses: vec![inverse] }
    }

    /// Value and slope at time `t` from the window about sample `centre`; unknown if its system is singular.
    fn estimate(&self, centre: usize, t: f64) -> [Estimate; 2] {
        let index = centre - self.first_centre;
        let cubic = &self.cubics[index];
        let inverse = if self.inverses.len() == 1 { &self.inverses[0] } else { &self.inverses[index] };
        let u = (t - cubic.centre) / cubic.scale;
        let read = |weights: [f64; 4], unit: f64| {
            let variance = dot(&inverse.map(|row| dot(&row, &weights)), &weights);
            // Times that nearly coincide make the matrix singular; the variance is then no positive number.
            if !(variance.is_finite() && variance > 0.0) {
                return UNKNOWN;
            }
            Estimate { value: dot(&weights, &cubic.coefficients) / unit, error: variance.sqrt() / unit }
        };
        [read(powers(u), 1.0), read([0.0, 1.0, 2.0 * u, 3.0 * u * u], cubic.scale)]
    }
}

impl Cubic {
    fn new(inverse: &Matrix, moments: [f64; 4], offset: f64, centre: f64, scale: f64) -> Self {
        let mut coefficients = inverse.map(|row| dot(&row, &moments));
        coefficients[0] += offset;
        Self { coefficients, centre, scale }
    }
}

fn uneven_window(time: &[f64], values: &[f64], c: usize, half: usize) -> (Cubic, Matrix) {
    let (first, last) = (c - half, c + half);
    let centre = 0.5 * (time[first] + time[last]);
    let scale = 0.5 * (time[last] - time[first]);
    let powers: Vec<[f64; 4]> = time[first..=last].iter().map(|t| powers((t - centre) / scale)).collect();
    let inverse = inverse_of_normal(&powers);
    let moments = moments(&powers, &values[first..=last], values[c]);
    (Cubic::new(&inverse, moments, values[c], centre, scale), inverse)
}

/// Sums of values times powers. The values are relative to `offset`, so that a large mean costs no digits.
fn moments(powers: &[[f64; 4]], values: &[f64], offset: f64) -> [f64; 4] {
    let mut moments = [0.0; 4];
    for (p, v) in powers.iter().zip(values) {
        for (moment, p) in moments.iter_mut().zip(p) {
            *moment += p * (v - offset);
        }
    }
    moments
}

fn powers(u: f64) -> [f64; 4] {
    [1.0, u, u * u, u * u * u]
}

fn dot(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
}

/// Inverse of the sum of `p p'` by Gauss and Jordan (positive definite: no pivoting); not finite if singular.
fn inverse_of_normal(points: &[[f64; 4]]) -> Matrix {
    let mut sums = [0.0; 7];
    for p in points {
        for (k, sum) in sums.iter_mut().enumerate() {
            let low = k.min(3);
            *sum += p[low] * p[k - low];
        }
    }
    let mut m: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| sums[i + j]));
    for k in 0..4 {
        let mut row = m[k];
        let pivot = 1.0 / row[k];
        row[k] = 1.0;
        row = row.map(|x| x * pivot);
        for other in &mut m {
            let factor = std::mem::take(&mut other[k]);
            for (x, r) in other.iter_mut().zip(&row) {
                *x -= factor * r;
            }
        }
        m[k] = row;
    }
    m
}
