//! The linear response to the measured motion.
//!
//! The measured motion obeys `x' = f(x, t) + sum theta phi(x, v, t)`. For any matrix A this equals
//! `x' = A x + [f(x, t) - A x] + sum theta phi`, which is linear in theta. The measured column is therefore
//! the response of the linear system `A` to known forces, plus theta times its response to each `phi`. This
//! is a linear regression without local minima, exact however large the gap is. With the mean Jacobian of f
//! as A, the bracket is nearly free of the noise in x.

use crate::decisions::DRIFTS;
use faer::Mat;

/// One step of `x' = A x + g(t)` with g linear between samples.
#[derive(Clone, Debug)]
struct Step {
    h: f64,
    /// `exp(A h)`, and the weights of g at the start and at the end of the step; row-major n x n.
    phi: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
}

/// A linear system on a time grid.
#[derive(Clone, Debug)]
pub(crate) struct Linear {
    n: usize,
    steps: Vec<Step>,
    /// Index of the step that leads to each sample but the first.
    which: Vec<usize>,
}

impl Linear {
    /// The system `x' = A x + g` (A row-major) on a time grid. Steps of equal length share their matrices.
    pub(crate) fn new(a: &[f64], n: usize, time: &[f64]) -> Linear {
        let mut steps: Vec<Step> = Vec::new();
        let mut which = Vec::with_capacity(time.len().saturating_sub(1));
        for pair in time.windows(2) {
            let h = pair[1] - pair[0];
            let known = steps.iter().rposition(|s| (s.h - h).abs() <= 1e-6 * h);
            which.push(known.unwrap_or_else(|| {
                steps.push(step(a, n, h));
                steps.len() - 1
            }));
        }
        Linear { n, steps, which }
    }

    /// The response of every state (samples x n, row-major) to a force `g` (samples x n, row-major) from the
    /// state `start`.
    pub(crate) fn response(&self, g: &[f64], start: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; (self.which.len() + 1) * self.n];
        x[..self.n].copy_from_slice(start);
        // Of a known size the loops over states have no bounds to check.
        match self.n {
            2 => self.follow::<2>(g, &mut x),
            4 => self.follow::<4>(g, &mut x),
            n => {
                for (i, &w) in self.which.iter().enumerate() {
                    let (done, rest) = x.split_at_mut((i + 1) * n);
                    let (g0, g1) = (&g[i * n..(i + 1) * n], &g[(i + 1) * n..(i + 2) * n]);
                    self.steps[w].advance(&done[i * n..], (g0, g1), &mut rest[..n]);
                }
            }
        }
        x
    }

    /// The response of `N` states, from the first row on.
    fn follow<const N: usize>(&self, g: &[f64], x: &mut [f64]) {
        let (g, x) = (g.as_chunks::<N>().0, x.as_chunks_mut::<N>().0);
        for (i, &w) in self.which.iter().enumerate() {
            let mut next = [0.0; N];
            self.steps[w].advance(&x[i], (&g[i], &g[i + 1]), &mut next);
            x[i + 1] = next;
        }
    }
}

impl Step {
    /// The state after the step from `before`, under a force that goes from `g.0` to `g.1`.
    #[inline(always)]
    fn advance(&self, before: &[f64], g: (&[f64], &[f64]), next: &mut [f64]) {
        let n = before.len();
        let dot = |m: &[f64], v: &[f64]| m.iter().zip(v).map(|(a, b)| a * b).sum::<f64>();
        for (row, out) in next.iter_mut().enumerate() {
            let at = row * n..(row + 1) * n;
            *out = dot(&self.phi[at.clone()], before)
                + dot(&self.first[at.clone()], g.0)
                + dot(&self.second[at], g.1);
        }
    }
}

/// The matrices of a step by the exponential of an augmented matrix (Van Loan, IEEE Trans. Automatic Control
/// 23 (1978) 395-404).
fn step(a: &[f64], n: usize, h: f64) -> Step {
    let size = 3 * n;
    let big = Mat::from_fn(size, size, |i, j| match (i / n, j / n) {
        (0, 0) => a[i * n + j] * h,
        (0, 1) if i == j - n => h,
        (1, 2) if i - n == j - 2 * n => 1.0,
        _ => 0.0,
    });
    let e = exponential(&big);
    let block = |j0: usize| -> Vec<f64> { (0..n * n).map(|k| e[(k / n, j0 * n + k % n)]).collect() };
    let (phi, ramp0, second) = (block(0), block(1), block(2));
    let first = ramp0.iter().zip(&second).map(|(a, b)| a - b).collect();
    Step { h, phi, first, second }
}

/// exp(M) by scaling, a Taylor polynomial and squaring.
fn exponential(m: &Mat<f64>) -> Mat<f64> {
    let n = m.nrows();
    let norm = (0..n).map(|i| (0..n).map(|j| m[(i, j)].abs()).sum::<f64>()).fold(0.0, f64::max);
    let squarings = if norm > 0.25 { (norm / 0.25).log2().ceil().min(60.0) as i32 } else { 0 };
    let scaled = m * faer::Scale(0.5_f64.powi(squarings));
    let mut sum = Mat::<f64>::identity(n, n);
    let mut term = Mat::<f64>::identity(n, n);
    for k in 1..=12 {
        term = &term * &scaled * faer::Scale(1.0 / f64::from(k));
        sum += &term;
    }
    for _ in 0..squarings {
        sum = &sum * &sum;
    }
    sum
}

/// Shift of the eigenvalues of `A` to the left so that no response grows by more than e over `span`. An
/// unstable model cannot be simulated freely, but the regression holds for any A.
pub(crate) fn shift(a: &[f64], n: usize, span: f64) -> f64 {
    let m = Mat::from_fn(n, n, |i, j| a[i * n + j]);
    let Ok(values) = m.eigenvalues() else { return 0.0 };
    let fastest = values.iter().map(|z| z.re).fold(f64::NEG_INFINITY, f64::max);
    // Slow growth is allowed; fast growth becomes a decay of the same rate.
    if fastest * span <= 1.0 { 0.0 } else { 2.0 * fastest }
}

/// Whether `x' = A x` has a mode that is far slower than a motion of this period: it sums up forces.
pub(crate) fn drifts(a: &[f64], n: usize, period: f64) -> bool {
    let m = Mat::from_fn(n, n, |i, j| a[i * n + j]);
    let slow = DRIFTS * std::f64::consts::TAU / period;
    m.eigenvalues().is_ok_and(|values| values.iter().any(|z| z.norm() < slow))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_oscillator_under_a_ramp() {
        // x'' = -4 x + t from rest: x = (t - sin(2 t)/2)/4.
        let time: Vec<f64> = (0..101).map(|i| 0.05 * f64::from(i)).collect();
        let system = Linear::new(&[0.0, 1.0, -4.0, 0.0], 2, &time);
        let g: Vec<f64> = time.iter().flat_map(|t| [0.0, *t]).collect();
        let x = system.response(&g, &[0.0, 0.0]);
        for (i, t) in time.iter().enumerate() {
            assert!((x[2 * i] - (t - (2.0 * t).sin() / 2.0) / 4.0).abs() < 1e-12, "{t}");
        }
        assert_eq!(system.steps.len(), 1);
    }

    #[test]
    fn growth_is_turned_into_decay() {
        assert_eq!(shift(&[0.0, 1.0, -4.0, -0.1], 2, 100.0), 0.0);
        assert!(shift(&[0.0, 1.0, 4.0, 0.0], 2, 100.0) > 3.9);
    }

    #[test]
    fn a_mass_without_a_spring_drifts() {
        assert!(drifts(&[0.0, 1.0, 0.0, -2.0], 2, 3.0));
        assert!(!drifts(&[0.0, 1.0, -4.0, -0.1], 2, 3.0));
    }
}
