//! One step of Dormand and Prince's Runge-Kutta pair 5(4) with its dense output (J. Comput. Appl. Math. 6
//! (1980) 19-26; Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.5 and II.6).

use crate::dense::Dense;
use crate::flow::Flow;

/// Number of stages; the last one is the first of the next step.
pub(crate) const STAGES: usize = 7;

pub(crate) const C: [f64; STAGES] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];

/// Row `i` gives stage `i + 1`; the last row is the fifth-order solution itself.
pub(crate) const A: [[f64; 6]; 6] = [
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];

/// Fifth minus fourth order: the error estimate.
const E: [f64; STAGES] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];

const D: [f64; STAGES] = [
    -12715105075.0 / 11282082432.0,
    0.0,
    87487479700.0 / 32700410799.0,
    -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0,
    -1453857185.0 / 822651844.0,
    69997945.0 / 29380423.0,
];

/// The error of the step grows with this power of its length.
pub(crate) const ORDER: f64 = 5.0;

/// Makes a step of length `h` at time `t` from the state `x[0]` with the rates `k[0]`.
pub(crate) fn advance(
    (t, h): (f64, f64),
    x: &mut [Vec<f64>; STAGES],
    k: &mut [Vec<f64>; STAGES],
    flow: &mut impl Flow,
) {
    for stage in 1..STAGES {
        for i in 0..x[0].len() {
            let sum: f64 = (0..stage).map(|j| A[stage - 1][j] * k[j][i]).sum();
            x[stage][i] = x[0][i] + h * sum;
        }
        flow.rates(t + C[stage] * h, &x[stage], &mut k[stage]);
    }
}

/// The estimated errors of the `n` states, followed by those of the mean loads.
pub(crate) fn errors(h: f64, k: &[Vec<f64>; STAGES], n: usize, out: &mut [f64]) {
    for (i, e) in out[..k[0].len()].iter_mut().enumerate() {
        *e = (0..STAGES).map(|j| E[j] * k[j][i]).sum();
        if i < n {
            *e *= h;
        }
    }
}

/// The estimated errors of `N` components with these rates at the stages, after a step of length `h`.
#[inline(always)]
pub(crate) fn error<const N: usize>(h: f64, k: &[[f64; N]; STAGES]) -> [f64; N] {
    let mut sum = [0.0; N];
    for (k, e) in k.iter().zip(&E) {
        (0..N).for_each(|l| sum[l] += e * k[l]);
    }
    (0..N).for_each(|l| sum[l] *= h);
    sum
}

/// Hairer's fourth-order interpolant of a step, from the values at both ends and the rates at the stages.
#[inline(always)]
pub(crate) fn interpolate(dense: &mut Dense, h: f64, start: &[f64], end: &[f64], k: &[Vec<f64>; STAGES]) {
    const VECTOR: usize = 8;
    let (n, c) = (start.len(), dense.set(h, start.len()));
    let whole = n / VECTOR * VECTOR;
    for at in (0..whole).step_by(VECTOR) {
        some::<VECTOR>(c, at, h, (start, end), k);
    }
    for at in whole..n {
        some::<1>(c, at, h, (start, end), k);
    }
}

/// The coefficients of `N` components from `at` on.
#[inline(always)]
fn some<const N: usize>(
    c: &mut [Vec<f64>; 6],
    at: usize,
    h: f64,
    (start, end): (&[f64], &[f64]),
    k: &[Vec<f64>; STAGES],
) {
    let (start, end) = (&start[at..at + N], &end[at..at + N]);
    let (first, last) = (&k[0][at..at + N], &k[STAGES - 1][at..at + N]);
    let mut fifth = [0.0; N];
    for (k, d) in k.iter().zip(&D) {
        let k = &k[at..at + N];
        (0..N).for_each(|l| fifth[l] += d * k[l]);
    }
    let (mut difference, mut bend, mut fourth) = ([0.0; N], [0.0; N], [0.0; N]);
    for l in 0..N {
        difference[l] = end[l] - start[l];
        bend[l] = h * first[l] - difference[l];
        fourth[l] = difference[l] - h * last[l] - bend[l];
        fifth[l] *= h;
    }
    c[0][at..at + N].copy_from_slice(start);
    c[1][at..at + N].copy_from_slice(&difference);
    c[2][at..at + N].copy_from_slice(&bend);
    c[3][at..at + N].copy_from_slice(&fourth);
    c[4][at..at + N].copy_from_slice(&fifth);
    c[5][at..at + N].fill(0.0);
}

/// `h |lambda|` of the dominant eigenvalue, from the last two stages: both are at the end of the step, and
/// they differ by what is hardly damped (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II,
/// IV.2, eq. (2.26)). `size` weighs the states; `None` if nothing moves.
pub(crate) fn stiffness(h: f64, x: &[Vec<f64>; STAGES], k: &[Vec<f64>; STAGES], size: &[f64]) -> Option<f64> {
    let norm = |of: &[Vec<f64>; STAGES]| -> f64 {
        let apart = of[STAGES - 1].iter().zip(&of[STAGES - 2]).zip(size);
        apart.map(|((a, b), size)| ((a - b) / size).powi(2)).sum::<f64>().sqrt()
    };
    let apart = norm(x);
    (apart > 0.0).then(|| h * norm(k) / apart)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::Step;
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    /// The rate of one state.
    struct Alone<F>(F);

    impl<F: Fn(f64, f64) -> f64> Flow for Alone<F> {
        fn rates(&mut self, t: f64, x: &[f64], out: &mut [f64]) {
            out.fill((self.0)(t, x[0]));
        }
        fn by_state(&mut self, _: f64, _: &[f64], _: &mut [f64]) {
            panic!("an explicit step needs no derivative");
        }
    }

    /// One step of one state; the load equals its rate.
    fn step(t: f64, h: f64, x: f64, rate: impl Fn(f64, f64) -> f64) -> Step {
        let mut step = Step::new(1, 1);
        step.start(t, &[x], &[rate(t, x); 2]);
        assert!(step.advance(h, &[1.0], &mut Alone(rate)));
        step
    }

    fn errors(step: &Step) -> [f64; 2] {
        let mut out = [f64::NAN; 2];
        step.errors(&mut out);
        out
    }

    /// Value and slope within the step.
    fn within(step: &mut Step, theta: f64) -> (f64, f64) {
        let (mut value, mut slope) = ([f64::NAN], [f64::NAN]);
        step.dense().value(theta, &mut value);
        step.dense().slope(theta, &mut slope);
        (value[0], slope[0])
    }

    #[test]
    fn a_polynomial_of_the_fourth_degree_is_followed_exactly() {
        let exact = |t: f64| 2.0 - t + 3.0 * t * t - 0.7 * t.powi(3) + 0.4 * t.powi(4);
        let rate = |t: f64, _: f64| -1.0 + 6.0 * t - 2.1 * t * t + 1.6 * t.powi(3);
        let (t, h) = (0.3, 0.8);
        let mut step = step(t, h, exact(t), rate);
        assert_abs_diff_eq!(step.end()[0], exact(t + h), epsilon = 1e-13);
        for error in errors(&step) {
            assert_abs_diff_eq!(error, 0.0, epsilon = 1e-14);
        }
        for theta in [0.0, 0.1, 0.5, 0.77, 1.0] {
            let (value, slope) = within(&mut step, theta);
            assert_abs_diff_eq!(value, exact(t + theta * h), epsilon = 1e-13);
            assert_abs_diff_eq!(slope, rate(t + theta * h, 0.0), epsilon = 1e-12);
        }
    }

    /// The equation is `x' = -2 t x^2` with the solution `x = 1 / (1 + t^2)`. Halving the step divides an
    /// error of order `p` by `2^p`.
    #[test]
    fn errors_have_the_orders_of_the_method() {
        let exact = |t: f64| 1.0 / (1.0 + t * t);
        let rate = |t: f64, x: f64| -2.0 * t * x * x;
        let t = 0.4;
        let of = |h: f64| {
            let mut step = step(t, h, exact(t), rate);
            let middle = within(&mut step, 0.4).0;
            let [state, load] = errors(&step);
            // The estimate for a load is that of its mean: it lacks the step length.
            assert_relative_eq!(state, h * load, max_relative = 1e-12);
            [step.end()[0] - exact(t + h), middle - exact(t + 0.4 * h), state]
        };
        let (coarse, fine) = (of(0.05), of(0.025));
        for (k, order) in [6, 5, 5].into_iter().enumerate() {
            let ratio = coarse[k] / fine[k];
            assert_relative_eq!(ratio, 2.0_f64.powi(order), max_relative = 0.25);
        }
    }
}
