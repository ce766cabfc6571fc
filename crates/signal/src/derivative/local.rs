//! Local cubics with a window chosen at every sample.
//!
//! At each sample the derivative is estimated from windows of growing width. Narrow ones are noisy, wide ones biased.
//! How far a wide one departs from all narrower ones, beyond what noise explains, bounds its bias; the window with the
//! least bias and variance together is kept (A. Goldenshluger, O. Lepski 2011). This is done for windows round the
//! sample and for windows leaning to either side, and the results are averaged by their merit, so that near a stop the
//! windows that do not reach across it count. One cubic per window serves every sample the window is asked about.
//!
//! Tried and worse on stick-slip: keeping the widest window whose confidence interval meets those of all narrower ones
//! (one false alarm leaves a far too narrow window), and the best lean alone (the average has less noise).

use std::ops::Range;

use super::{Differentiated, Smoothing, noise_of};
use crate::grid::uniform_step;

/// Squared departure, in variances of the narrower window, that noise explains. Below 6 false alarms dominate.
const EXPLAINED: f64 = 8.0;
/// Where windows sit relative to their sample, in half widths.
const LEANS: [f64; 7] = [0.0, -1.0 / 3.0, 1.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0, -1.0, 1.0];
/// Widest half window, in samples: beyond it the work grows and the error hardly falls.
const WIDEST: usize = 512;
/// Samples treated together: bounds the memory, while windows reaching over the edges cost a quarter more.
const CHUNK: usize = 4096;

type Matrix = [[f64; 4]; 4];

/// Least-squares cubic on one window, in u = (t - centre)/scale.
#[derive(Clone, Copy)]
struct Cubic {
    coefficients: [f64; 4],
    centre: f64,
    scale: f64,
}

/// What one window says about one quantity at one sample, with the standard error for unit noise.
#[derive(Clone, Copy)]
struct Estimate {
    value: f64,
    error: f64,
}

/// The answer for one quantity at one sample, with its estimated squared error and the width level of the lean that
/// counts most.
struct Answer {
    value: f64,
    risk: f64,
    level: usize,
}

const UNKNOWN: Estimate = Estimate { value: 0.0, error: f64::INFINITY };

pub(super) fn differentiate(time: &[f64], values: &[f64]) -> Differentiated {
    let n = time.len();
    // Not zero: merits are inverse variances.
    let noise = noise_of(time, values).max(1e-100);
    let step = uniform_step(time, 1e-6);
    let halves: Vec<usize> = half_widths(n).collect();
    // The value wants narrower windows than the derivative: each is chosen for itself.
    let (mut smooth, mut slopes) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for first in (0..n).step_by(CHUNK) {
        let samples = first..n.min(first + CHUNK);
        let mut estimates = vec![[UNKNOWN; 2]; samples.len() * LEANS.len() * halves.len()];
        for (level, &half) in halves.iter().enumerate() {
            let centres = samples.start.saturating_sub(half).max(half)..(samples.end + half).min(n - half);
            // Near the ends of the record all windows of a width are the first or the last one.
            let centres = centres.start.min(n - 1 - half)..centres.end.max(half + 1);
            let windows = Windows::new(time, values, half, step, centres);
            let levels = estimates.iter_mut().skip(level).step_by(halves.len());
            let places = samples.clone().flat_map(|i| LEANS.iter().map(move |lean| (i, lean)));
            for ((i, lean), estimate) in places.zip(levels) {
                let centre =
                    (i as f64 + lean * half as f64).round().clamp(half as f64, (n - 1 - half) as f64);
                *estimate = windows.estimate(centre as usize, time[i]);
            }
        }
        for sample in estimates.chunks_exact(LEANS.len() * halves.len()) {
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

/// The average over the leans, each at its best width, weighted by inverse risk.
fn combine(estimates: &[[Estimate; 2]], quantity: usize, levels: usize, noise: f64) -> Answer {
    let mut best = [(UNKNOWN, f64::INFINITY, 0); LEANS.len()];
    for (lean, best) in estimates.chunks_exact(levels).zip(&mut best) {
        let lean = || lean.iter().map(|both| both[quantity]);
        for (level, wide) in lean().enumerate().filter(|(_, wide)| wide.error.is_finite()) {
            let variance = |e: Estimate| (noise * e.error).powi(2);
            let bias = lean().take(level).filter(|e| e.error.is_finite()).fold(0.0_f64, |bias, narrow| {
                bias.max((wide.value - narrow.value).powi(2) - EXPLAINED * variance(narrow))
            });
            let risk = bias + variance(wide);
            if risk < best.1 {
                *best = (wide, risk, level);
            }
        }
    }
    let least = best.iter().copied().fold(best[0], |least, lean| if lean.1 < least.1 { lean } else { least });
    let mut answer = Answer { value: 0.0, risk: least.1, level: least.2 };
    let (mut weights, mut roots, mut inverse_roots) = (0.0, 0.0, 0.0);
    for (estimate, risk, _) in best.iter().filter(|lean| lean.1.is_finite()) {
        let weight = least.1 / risk;
        weights += weight;
        answer.value += weight * estimate.value;
        roots += risk.sqrt();
        inverse_roots += 1.0 / risk.sqrt();
    }
    answer.value /= weights;
    // Between the least risk, which was picked for being small, and the mean one: found to be about right.
    answer.risk = roots / inverse_roots;
    answer
}

/// 2, 3, 4, 6, 8, 11, ... samples to either side: a factor of about the square root of 2.
fn half_widths(n: usize) -> impl Iterator<Item = usize> {
    let widest = ((n - 1) / 2).min(WIDEST);
    let ladder = std::iter::successors(Some(2.0_f64), |h| Some(h * std::f64::consts::SQRT_2));
    ladder.map(|h| h.round() as usize).take_while(move |&h| h <= widest)
}

/// Windows of one width round consecutive samples.
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

    /// Value and slope at time `t` from the window round sample `centre`; unknown if it could not be solved.
    fn estimate(&self, centre: usize, t: f64) -> [Estimate; 2] {
        let index = centre - self.first_centre;
        let cubic = &self.cubics[index];
        let inverse = if self.inverses.len() == 1 { &self.inverses[0] } else { &self.inverses[index] };
        let u = (t - cubic.centre) / cubic.scale;
        let read = |weights: [f64; 4], unit: f64| {
            let variance = dot(&inverse.map(|row| dot(&row, &weights)), &weights);
            // Times that nearly coincide make the matrix singular: its variance is then not a positive number.
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

/// Sums of value times power, of the values relative to `offset`, so that a large one costs no digits.
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
