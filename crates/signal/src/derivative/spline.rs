//! The cubic smoothing spline; generalised cross-validation chooses its smoothness.
//!
//! C. H. Reinsch 1967 (banded solve); M. F. Hutchinson and F. R. de Hoog 1985 (trace of the influence matrix
//! in O(n)).

use std::f64::consts::PI;

use super::differentiated::Differentiated;
use super::noise::noise_of;
use super::smoothing::Smoothing;
use crate::grid::mean_step;

/// Smoothing length, in samples, of a spline that practically interpolates.
const MIN_LENGTH: f64 = 0.02;
/// Longest smoothing length, in samples. Beyond it the normal matrix is ill-conditioned.
const MAX_LENGTH: f64 = 2000.0;

/// Symmetric matrix of three upper bands.
type Bands = Vec<[f64; 3]>;

/// The problem in units of the mean step: `(R + alpha Q'Q) gamma = Q' y`, spline values `y - alpha Q gamma`.
struct Smoother<'a> {
    steps: Vec<f64>,
    values: &'a [f64],
    second_differences: Vec<f64>,
    r: Bands,
    qq: Bands,
}

/// One spline: second derivatives at the inner knots, residual and score.
struct Fit {
    gamma: Vec<f64>,
    residual: Vec<f64>,
    /// Residual degrees of freedom.
    free: f64,
    score: f64,
}

pub(super) fn differentiate(time: &[f64], values: &[f64]) -> Differentiated {
    let n = time.len();
    let mean_step = mean_step(time);
    let smoother = Smoother::new(time, values, mean_step);
    let longest = MAX_LENGTH.min(n as f64 / 4.0);
    let length = least(MIN_LENGTH.ln(), longest.ln(), |l| smoother.fit(alpha(l.exp())).score).exp();
    let fit = smoother.fit(alpha(length));
    let left = fit.residual.iter().map(|r| r * r).sum::<f64>();
    // The residual of a spline that hardly smooths does not determine the noise.
    let noise = if fit.free > 0.02 * n as f64 { (left / fit.free).sqrt() } else { noise_of(time, values) };
    let smooth: Vec<f64> = values.iter().zip(&fit.residual).map(|(v, r)| v - r).collect();
    let curvature = |i: usize| if i == 0 || i == n - 1 { 0.0 } else { fit.gamma[i - 1] };
    let derivative = (0..n).map(|i| {
        // The spline's slope at the left or right end of an interval, in units of the mean step.
        let (left, at_left) = if i == n - 1 { (i - 1, false) } else { (i, true) };
        let h = smoother.steps[left];
        let (g0, g1) = (curvature(left), curvature(left + 1));
        let bend = if at_left { -(2.0 * g0 + g1) } else { g0 + 2.0 * g1 };
        ((smooth[left + 1] - smooth[left]) / h + bend * h / 6.0) / mean_step
    });
    let derivative = derivative.collect();
    Differentiated {
        values: smooth,
        derivative,
        std_error: noise * gain(alpha(length)) / mean_step,
        smoothing: Smoothing::Spline { length, noise },
    }
}

/// The smoothing parameter whose equivalent kernel has this length: its fourth power, since the penalty is on
/// curvature.
fn alpha(length: f64) -> f64 {
    length.powi(4)
}

/// The minimum of a function by a coarse scan and golden section search. The score can have several minima,
/// hence the scan.
fn least(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    const SCAN: usize = 16;
    let at = |i: usize| low + (high - low) * i as f64 / SCAN as f64;
    let scores: Vec<f64> = (0..=SCAN).map(|i| f(at(i))).collect();
    let best = (0..=SCAN).min_by(|&i, &j| scores[i].total_cmp(&scores[j])).unwrap_or(0);
    let (mut a, mut b) = (at(best.saturating_sub(1)), at((best + 1).min(SCAN)));
    let golden = (5f64.sqrt() - 1.0) / 2.0;
    let (mut x, mut y) = (b - golden * (b - a), a + golden * (b - a));
    let (mut fx, mut fy) = (f(x), f(y));
    for _ in 0..14 {
        if fx <= fy {
            (b, y, fy) = (y, x, fx);
            x = b - golden * (b - a);
            fx = f(x);
        } else {
            (a, x, fx) = (x, y, fy);
            y = a + golden * (b - a);
            fy = f(y);
        }
    }
    if fx <= fy { x } else { y }
}

impl<'a> Smoother<'a> {
    fn new(time: &[f64], values: &'a [f64], mean_step: f64) -> Self {
        let steps: Vec<f64> = time.windows(2).map(|t| (t[1] - t[0]) / mean_step).collect();
        let inner = time.len() - 2;
        // Column j of Q: the second divided difference about sample j + 1.
        let q = |j: usize| [1.0 / steps[j], -1.0 / steps[j] - 1.0 / steps[j + 1], 1.0 / steps[j + 1]];
        let product = |j: usize, shift: usize| {
            if j + shift >= inner {
                return 0.0;
            }
            let (a, b) = (q(j), q(j + shift));
            (shift..3).map(|i| a[i] * b[i - shift]).sum()
        };
        let r = (0..inner).map(|j| {
            let beside = if j + 1 < inner { steps[j + 1] / 6.0 } else { 0.0 };
            [(steps[j] + steps[j + 1]) / 3.0, beside, 0.0]
        });
        let second_differences = (0..inner)
            .map(|j| (values[j + 2] - values[j + 1]) / steps[j + 1] - (values[j + 1] - values[j]) / steps[j]);
        Self {
            r: r.collect(),
            qq: (0..inner).map(|j| [product(j, 0), product(j, 1), product(j, 2)]).collect(),
            second_differences: second_differences.collect(),
            steps,
            values,
        }
    }

    fn fit(&self, alpha: f64) -> Fit {
        let inner = self.r.len();
        let n = self.values.len() as f64;
        let bands: Bands =
            self.r.iter().zip(&self.qq).map(|(r, q)| std::array::from_fn(|k| r[k] + alpha * q[k])).collect();
        let (pivot, lower) = factor(&bands);
        let gamma = solve(&pivot, &lower, &self.second_differences);
        let at = |j: usize| if j < inner { gamma[j] } else { 0.0 };
        let residual: Vec<f64> = (0..self.values.len())
            .map(|i| {
                // Row i of Q gamma.
                let before = if i >= 2 { at(i - 2) / self.steps[i - 1] } else { 0.0 };
                let here = if i >= 1 && i <= inner {
                    -at(i - 1) * (1.0 / self.steps[i - 1] + 1.0 / self.steps[i])
                } else {
                    0.0
                };
                let after = if i < inner { at(i) / self.steps[i] } else { 0.0 };
                alpha * (before + here + after)
            })
            .collect();
        let free = alpha * trace(&pivot, &lower, &self.qq);
        let score = n * residual.iter().map(|r| r * r).sum::<f64>() / (free * free);
        Fit { gamma, residual, free, score }
    }
}

/// `L D L'` of a positive definite matrix of three bands: D, and the two lower bands of L by column.
fn factor(bands: &Bands) -> (Vec<f64>, Vec<[f64; 2]>) {
    let mut pivot = vec![0.0; bands.len()];
    let mut lower = vec![[0.0; 2]; bands.len()];
    for j in 0..bands.len() {
        let (p1, l1) = if j >= 1 { (pivot[j - 1], lower[j - 1]) } else { (0.0, [0.0; 2]) };
        let (p2, l2) = if j >= 2 { (pivot[j - 2], lower[j - 2]) } else { (0.0, [0.0; 2]) };
        pivot[j] = bands[j][0] - p1 * l1[0] * l1[0] - p2 * l2[1] * l2[1];
        lower[j] = [(bands[j][1] - p1 * l1[0] * l1[1]) / pivot[j], bands[j][2] / pivot[j]];
    }
    (pivot, lower)
}

fn solve(pivot: &[f64], lower: &[[f64; 2]], right: &[f64]) -> Vec<f64> {
    let n = right.len();
    let mut x = right.to_vec();
    for j in 0..n {
        for k in 0..2 {
            if j + k + 1 < n {
                x[j + k + 1] -= lower[j][k] * x[j];
            }
        }
    }
    for j in (0..n).rev() {
        x[j] /= pivot[j];
        for k in 0..2 {
            if j + k + 1 < n {
                x[j] -= lower[j][k] * x[j + k + 1];
            }
        }
    }
    x
}

/// Trace of `(L D L')^-1 M` for a three-band `M`, from the bands of the inverse alone.
fn trace(pivot: &[f64], lower: &[[f64; 2]], m: &Bands) -> f64 {
    // Rows j + 1 and j + 2 of the inverse, upper bands.
    let (mut next, mut second) = ([0.0; 3], [0.0; 3]);
    let mut sum = 0.0;
    for j in (0..pivot.len()).rev() {
        let [a, b] = lower[j];
        let one = -a * next[0] - b * next[1];
        let two = -a * next[1] - b * second[0];
        let zero = 1.0 / pivot[j] - a * one - b * two;
        sum += m[j][0] * zero + 2.0 * (m[j][1] * one + m[j][2] * two);
        (next, second) = ([zero, one, two], next);
    }
    sum
}

/// Standard deviation of the spline's slope for unit white noise on a uniform grid of step 1.
fn gain(alpha: f64) -> f64 {
    const POINTS: usize = 4096;
    let power = |w: f64| {
        let even = (2.0 + w.cos()) / 3.0;
        let smooth = 1.0 / (1.0 + alpha * (2.0 - 2.0 * w.cos()).powi(2) / even);
        (w.sin() / even * smooth).powi(2)
    };
    // Midpoint rule with quadratic spacing: the pass band of a long spline is narrow and lies at zero.
    let sum: f64 = (0..POINTS)
        .map(|i| {
            let s = (i as f64 + 0.5) / POINTS as f64;
            power(PI * s * s) * 2.0 * s
        })
        .sum();
    (sum / POINTS as f64).sqrt()
}
