//! One step of Radau IIA with five stages, of order 9 and stable however stiff the rates are (E. Hairer, G.
//! Wanner, Solving Ordinary Differential Equations II, IV.5 and IV.8; J. Comput. Appl. Math. 111 (1999)
//! 93-111, doi:10.1016/S0377-0427(99)00134-X).
//!
//! The stages `X_i = x + Z_i` solve `sum_j W_ij Z_j / h = f(t + c_i h, X_i)` with the inverse `W` of the
//! method's matrix, by Newton's method with the matrix `W/h (x) I - diag(df/dx)`. At first `df/dx` is that at
//! the start of the step in all places; where that converges slowly, it is evaluated at the stages. The very
//! same matrix at the solution gives the derivatives of the stages, by the theorem on implicit functions: see
//! [`crate::sensitivity`].

use crate::decisions::{
    EXTRAPOLATION, NEWTON_ERROR, NEWTON_ITERATIONS, NEWTON_ROUNDING, NEWTON_SLOW, POWERS,
};
use crate::dense::Dense;
use crate::factors::Factors;
use crate::flow::Flow;

/// Number of stages beyond the start of the step.
pub(crate) const STAGES: usize = 5;

/// The start of the step and the stages: the roots of the fourth derivative of `c^4 (c - 1)^5`.
pub(crate) const C: [f64; STAGES + 1] = [
    0.0,
    0.057_104_196_114_517_68,
    0.276_843_013_638_123_8,
    0.583_590_432_368_916_8,
    0.860_240_135_656_219_5,
    1.0,
];

/// The inverse of the method's matrix: the slopes at the stages of the polynomial that is 1 at one stage, 0
/// at the others and at the start.
#[rustfmt::skip]
const W: [[f64; STAGES]; STAGES] = [
    [8.755_923_977_938_362, 2.891_942_615_380_117_3, -0.875_186_396_200_265_1, 0.399_705_207_939_965_5, -0.133_706_163_849_215_83],
    [-7.161_380_720_145_387, 1.806_077_724_083_644_3, 2.363_797_176_068_608_5, -0.865_900_780_283_134_6, 0.274_338_077_775_194_2],
    [4.122_165_246_243_374, -4.496_017_125_813_394_5, 0.856_765_245_397_177_6, 2.518_320_949_211_064_5, -0.657_062_757_134_360_1],
    [-3.878_663_219_724_010_5, 3.393_151_918_064_954_3, -5.188_340_906_407_187, 0.581_233_052_580_816_4, 2.809_983_655_279_712],
    [8.412_424_223_594_29, -6.970_256_116_656_661, 8.777_114_204_150_473, -18.219_282_311_088_1, 13.0],
];

/// The real eigenvalue of `W`.
const GAMMA: f64 = 6.286_704_751_729_276_5;

/// The weights of the `Z` in the error estimate, that of `h f(x)` being 1: it vanishes for polynomials of the
/// fifth degree.
const E: [f64; STAGES] =
    [-27.780_933_944_064_63, 3.641_478_498_049_213, -1.252_547_721_169_118_7, 0.592_003_167_184_542_8, -0.2];

/// The weights of the loads at start and stages in the error estimate of their mean: `E` times the method's
/// matrix.
const LOADS: [f64; STAGES + 1] = [
    1.0,
    -1.586_407_900_186_328_3,
    1.008_117_881_498_373,
    -0.730_974_866_159_787_5,
    0.509_264_884_847_742_7,
    -0.2,
];

/// The coefficients of the interpolant from what bends it at the inner stages.
const BENT: [[f64; STAGES - 1]; STAGES - 1] = [
    [1.495_817_352_336_468, -0.729_027_489_081_882_4, 0.304_384_927_966_786, -0.071_174_791_221_371_55],
    [-1.948_770_091_585_769_3, 2.124_479_451_164_335, -2.437_334_618_931_793_3, 2.261_625_259_353_227_3],
    [-7.756_320_320_611_152, 12.738_819_670_250_003, -4.346_330_797_261_739, -0.636_168_552_377_110_5],
    [10.762_598_377_354_353, -25.430_097_054_910_306, 22.382_152_596_558_5, -7.714_653_919_002_545],
];

/// The fraction of the step at which the interpolant is furthest from the polynomial of a degree more.
const BETWEEN: f64 = 0.734;

/// The error estimate grows with this power of the step length.
pub(crate) const ORDER: f64 = 6.0;

/// The memory of the method.
pub(crate) struct Radau {
    n: usize,
    /// `df/dx` at the start of the step, once it is known.
    slope: Vec<f64>,
    known: bool,
    /// `df/dx` at each stage.
    slopes: [Vec<f64>; STAGES],
    newton: Factors,
    filter: Factors,
    /// `Z`: state by state, stage by stage.
    z: Vec<f64>,
    residual: Vec<f64>,
    errors: Vec<f64>,
    /// The errors of the interpolant.
    between: Vec<f64>,
    point: Vec<f64>,
    rates: Vec<f64>,
    dense: Dense,
    /// End and interpolant of the accepted step before this one.
    before: Option<(f64, Dense)>,
    /// Matrices decomposed so far.
    pub(crate) factorisations: usize,
}

/// Writes the matrix `W/h (x) I - diag(df/dx)` for the derivatives at the stages. Its rows and columns go
/// state by state, stage by stage, so that a chain of bodies stays a chain.
pub(crate) fn matrix<'a>(h: f64, n: usize, slope: impl Fn(usize) -> &'a [f64], out: &mut [f64]) {
    let width = STAGES * n;
    out.fill(0.0);
    for stage in 0..STAGES {
        for (i, slopes) in slope(stage).chunks_exact(n).enumerate() {
            let row = &mut out[(i * STAGES + stage) * width..][..width];
            slopes.iter().enumerate().for_each(|(j, a)| row[j * STAGES + stage] = -a);
            W[stage].iter().enumerate().for_each(|(k, w)| row[i * STAGES + k] += w / h);
        }
    }
}

/// The polynomial through the start and the stages.
pub(crate) fn interpolate(dense: &mut Dense, h: f64, x: &[Vec<f64>]) {
    let c = dense.set(h, x[0].len());
    for i in 0..x[0].len() {
        let (start, difference) = (x[0][i], x[STAGES][i] - x[0][i]);
        let bend: [f64; STAGES - 1] = std::array::from_fn(|k| {
            let c = C[k + 1];
            (x[k + 1][i] - start - c * difference) / (c * (1.0 - c))
        });
        let [second, third, fourth, fifth] =
            BENT.map(|row| row.iter().zip(&bend).map(|(a, b)| a * b).sum::<f64>());
        let of = [start, difference, second, third, fourth, fifth];
        c.iter_mut().zip(of).for_each(|(c, value)| c[i] = value);
    }
}

impl Radau {
    pub(crate) fn new(n: usize, loads: usize) -> Self {
        Radau {
            n,
            slope: vec![0.0; n * n],
            known: false,
            slopes: std::array::from_fn(|_| vec![0.0; n * n]),
            newton: Factors::new(STAGES * n),
            filter: Factors::new(n),
            z: vec![0.0; STAGES * n],
            residual: vec![0.0; STAGES * n],
            errors: vec![0.0; n + loads],
            between: vec![0.0; n],
            point: vec![0.0; n],
            rates: vec![0.0; n + loads],
            dense: Dense::default(),
            before: None,
            factorisations: 0,
        }
    }

    /// A new point is the start.
    pub(crate) fn start(&mut self) {
        self.known = false;
    }

    /// Other steps than those of this method came before the next one.
    pub(crate) fn forget(&mut self) {
        self.before = None;
        self.known = false;
    }

    /// The last step was accepted, and ended at this time.
    pub(crate) fn accept(&mut self, end: f64) {
        let (at, kept) = self.before.get_or_insert_with(Default::default);
        *at = end;
        kept.clone_from(&self.dense);
    }

    /// The interpolant of the last step.
    pub(crate) fn dense(&self) -> &Dense {
        &self.dense
    }

    /// Makes a step of length `h` at time `t` from the state `x[0]` with the rates `k[0]`. Returns whether
    /// Newton's method converged.
    pub(crate) fn advance(
        &mut self,
        (t, h): (f64, f64),
        x: &mut [Vec<f64>],
        k: &mut [Vec<f64>],
        allowed: &[f64],
        flow: &mut impl Flow,
    ) -> bool {
        if !self.known {
            flow.by_state(t, &x[0], &mut self.slope);
            self.known = true;
        }
        self.guess(t, h, &x[0]);
        if !self.solve((t, h), x, k, allowed, flow) {
            return false;
        }
        flow.rates(t + h, &x[STAGES], &mut k[STAGES]);
        interpolate(&mut self.dense, h, x);
        self.estimate((t, h), k, flow)
    }

    /// Starts Newton's method where the step before leads.
    fn guess(&mut self, t: f64, h: f64, x: &[f64]) {
        self.z.fill(0.0);
        let Some((_, dense)) =
            self.before.as_ref().filter(|(end, dense)| *end == t && h <= EXTRAPOLATION * dense.h)
        else {
            return;
        };
        for stage in 0..STAGES {
            dense.value(1.0 + C[stage + 1] * h / dense.h, &mut self.point);
            let values = self.point.iter().zip(x);
            values.enumerate().for_each(|(i, (value, x))| self.z[i * STAGES + stage] = value - x);
        }
    }

    /// Newton's method.
    fn solve(
        &mut self,
        (t, h): (f64, f64),
        x: &mut [Vec<f64>],
        k: &mut [Vec<f64>],
        allowed: &[f64],
        flow: &mut impl Flow,
    ) -> bool {
        let n = self.n;
        matrix(h, n, |_| &self.slope, &mut self.newton.a);
        self.factorisations += 1;
        if !self.newton.factor() {
            return false;
        }
        let mut last = f64::INFINITY;
        for _ in 0..NEWTON_ITERATIONS {
            self.place(x);
            for stage in 1..=STAGES {
                flow.rates(t + C[stage] * h, &x[stage], &mut k[stage]);
            }
            self.residual(h, k);
            self.newton.solve(&mut self.residual, 1);
            self.z.iter_mut().zip(&self.residual).for_each(|(z, d)| *z += d);
            let (change, rounding) = self.change(&x[0], allowed);
            if !change.is_finite() {
                return false;
            }
            // The first change tells no rate of convergence.
            let ratio = change / last;
            let left =
                if last.is_finite() && ratio < 1.0 { ratio / (1.0 - ratio) * change } else { f64::INFINITY };
            if change <= rounding || left <= NEWTON_ERROR {
                self.place(x);
                return true;
            }
            last = change;
            if ratio > NEWTON_SLOW {
                for (stage, slope) in self.slopes.iter_mut().enumerate() {
                    (0..n).for_each(|i| x[stage + 1][i] = x[0][i] + self.z[i * STAGES + stage]);
                    flow.by_state(t + C[stage + 1] * h, &x[stage + 1], slope);
                }
                matrix(h, n, |stage| &self.slopes[stage], &mut self.newton.a);
                self.factorisations += 1;
                if !self.newton.factor() {
                    return false;
                }
                last = f64::INFINITY;
            }
        }
        false
    }

    /// Sets the states at the stages.
    fn place(&self, x: &mut [Vec<f64>]) {
        let (start, stages) = x.split_at_mut(1);
        for (stage, x) in stages.iter_mut().take(STAGES).enumerate() {
            x.iter_mut()
                .zip(&start[0])
                .zip(self.z[stage..].iter().step_by(STAGES))
                .for_each(|((x, s), z)| *x = s + z);
        }
    }

    /// What the equations of the stages lack.
    fn residual(&mut self, h: f64, k: &[Vec<f64>]) {
        for (i, (z, out)) in
            self.z.chunks_exact(STAGES).zip(self.residual.chunks_exact_mut(STAGES)).enumerate()
        {
            for (stage, out) in out.iter_mut().enumerate() {
                let slope: f64 = W[stage].iter().zip(z).map(|(w, z)| w * z).sum();
                *out = k[stage + 1][i] - slope / h;
            }
        }
    }

    /// The largest change of the last iteration, and what rounding may leave of it, in permitted errors.
    fn change(&self, x: &[f64], allowed: &[f64]) -> (f64, f64) {
        let (mut most, mut rounding) = (0.0_f64, 0.0_f64);
        for ((d, x), allowed) in self.residual.chunks_exact(STAGES).zip(x).zip(allowed) {
            for d in d {
                // A comparison would lose a NaN.
                most = if d.is_finite() { most.max(d.abs() / allowed) } else { f64::INFINITY };
            }
            rounding = rounding.max(NEWTON_ROUNDING * x.abs() / allowed);
        }
        (most, rounding)
    }

    /// Estimates the errors of the step: at its end by the difference to a formula of order 5, damped as the
    /// exact solution is (IV.8, eq. (8.19)); within it by what the rates at the interpolant lack. A fast mode
    /// follows the slow ones exactly at the stages, and an interpolant that is too coarse shows between them
    /// alone.
    fn estimate(&mut self, (t, h): (f64, f64), k: &[Vec<f64>], flow: &mut impl Flow) -> bool {
        let n = self.n;
        self.filter.a.iter_mut().zip(&self.slope).for_each(|(a, slope)| *a = -slope);
        (0..n).for_each(|i| self.filter.a[i * (n + 1)] += GAMMA / h);
        if !self.filter.factor() {
            return false;
        }
        for (i, error) in self.errors.iter_mut().enumerate() {
            *error = if i < n {
                k[0][i] + defect(&self.z[i * STAGES..], h)
            } else {
                k.iter().zip(&LOADS).map(|(k, weight)| weight * k[i]).sum::<f64>() / GAMMA
            };
        }
        self.filter.solve(&mut self.errors[..n], 1);
        self.dense.value(BETWEEN, &mut self.point);
        self.dense.slope(BETWEEN, &mut self.between);
        flow.rates(t + BETWEEN * h, &self.point, &mut self.rates);
        self.between.iter_mut().zip(&self.rates).for_each(|(b, rate)| *b -= rate);
        self.filter.solve(&mut self.between, 1);
        true
    }

    /// The estimated errors of the states, followed by those of the mean loads.
    pub(crate) fn errors(&self, out: &mut [f64]) {
        out.copy_from_slice(&self.errors);
        for (out, between) in out.iter_mut().zip(&self.between) {
            // A NaN stays.
            if between.abs() > out.abs() || between.is_nan() {
                *out = *between;
            }
        }
    }

    /// The size of the dominant eigenvalue of `df/dx` at the start of the step, by powers of this matrix.
    /// `size` is the size of each state.
    pub(crate) fn eigenvalue(&mut self, size: &[f64]) -> Option<f64> {
        let n = self.n;
        let mut v: Vec<f64> = size.to_vec();
        let mut product = vec![0.0; n];
        let (mut power, mut count) = (0.0, 0.0);
        for turn in 0..POWERS {
            product.iter_mut().zip(self.slope.chunks_exact(n)).for_each(|(p, row)| {
                *p = row.iter().zip(&v).map(|(a, v)| a * v).sum();
            });
            let length = product.iter().zip(size).map(|(p, size)| (p / size).powi(2)).sum::<f64>().sqrt();
            if !(length > 0.0 && length.is_finite()) {
                return None;
            }
            product.iter_mut().for_each(|p| *p /= length);
            std::mem::swap(&mut v, &mut product);
            // The first products still hold other directions.
            if turn >= POWERS / 2 {
                power += length.ln();
                count += 1.0;
            }
        }
        Some((power / count).exp())
    }
}

/// The weighted sum of the `Z` of a state in the error estimate, over the step length.
fn defect(z: &[f64], h: f64) -> f64 {
    z.iter().zip(&E).map(|(z, e)| z * e).sum::<f64>() / h
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::{Method, Step};
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    /// The rate of one state and its derivative; the load equals the rate.
    struct Alone<F, D>(F, D);

    impl<F: Fn(f64, f64) -> f64, D: Fn(f64, f64) -> f64> Flow for Alone<F, D> {
        fn rates(&mut self, t: f64, x: &[f64], out: &mut [f64]) {
            out.fill((self.0)(t, x[0]));
        }
        fn by_state(&mut self, t: f64, x: &[f64], out: &mut [f64]) {
            out.fill((self.1)(t, x[0]));
        }
    }

    fn step(
        (t, h): (f64, f64),
        x: f64,
        rate: impl Fn(f64, f64) -> f64,
        slope: impl Fn(f64, f64) -> f64,
    ) -> Step {
        let mut step = Step::new(1, 1);
        step.set_method(Method::Implicit);
        step.start(t, &[x], &[rate(t, x); 2]);
        assert!(step.advance(h, &[1e-12], &mut Alone(rate, slope)));
        step
    }

    fn within(step: &mut Step, theta: f64) -> (f64, f64) {
        let (mut value, mut slope) = ([f64::NAN], [f64::NAN]);
        step.dense().value(theta, &mut value);
        step.dense().slope(theta, &mut slope);
        (value[0], slope[0])
    }

    fn power(x: f64, q: usize) -> f64 {
        x.powi(q as i32)
    }

    /// What defines the coefficients: `W` differentiates powers of the time up to the fifth, the error
    /// estimate does not see them, and `GAMMA` is an eigenvalue.
    #[test]
    fn the_coefficients_fulfil_their_conditions() {
        let stages = &C[1..];
        for q in 1..=STAGES {
            let sum = |row: &[f64]| -> f64 { row.iter().zip(stages).map(|(w, c)| w * power(*c, q)).sum() };
            for (row, c) in W.iter().zip(stages) {
                assert_abs_diff_eq!(sum(row), q as f64 * power(*c, q - 1), epsilon = 1e-13);
            }
            assert_abs_diff_eq!(sum(&E), if q == 1 { -1.0 } else { 0.0 }, epsilon = 1e-13);
            let loads: f64 = LOADS.iter().zip(C).map(|(w, c)| w * power(c, q - 1)).sum();
            assert_abs_diff_eq!(loads, 0.0, epsilon = 1e-13);
        }
        let mut shifted = Factors::new(STAGES);
        shifted.a = W.concat();
        (0..STAGES).for_each(|i| shifted.a[i * (STAGES + 1)] -= GAMMA);
        assert!(shifted.factor());
        let last = shifted.a[STAGES * STAGES - 1];
        assert_abs_diff_eq!(last, 0.0, epsilon = 1e-13);
    }

    /// The nodes are those of Radau's quadrature, which is exact to the eighth degree; the interpolant is to
    /// the fifth.
    #[test]
    fn polynomials_are_followed_exactly() {
        let (t, h) = (0.3, 0.8);
        for q in 0..=8 {
            let exact = |t: f64| 2.0 + power(t, q + 1) / (q + 1) as f64;
            let mut step = step((t, h), exact(t), |t, _| power(t, q), |_, _| 0.0);
            assert_abs_diff_eq!(step.end()[0], exact(t + h), epsilon = 1e-13);
            if q >= STAGES {
                continue;
            }
            let mut errors = [f64::NAN; 2];
            step.errors(&mut errors);
            errors.iter().for_each(|e| assert_abs_diff_eq!(*e, 0.0, epsilon = 1e-13));
            for theta in [0.0, 0.02, 0.1, 0.5, 0.77, 0.93, 1.0] {
                let (value, slope) = within(&mut step, theta);
                assert_abs_diff_eq!(value, exact(t + theta * h), epsilon = 1e-13);
                assert_abs_diff_eq!(slope, power(t + theta * h, q), epsilon = 1e-12);
            }
        }
    }

    /// The equation is `x' = -2 t x^2` with the solution `x = 1 / (1 + t^2)`. Halving the step divides an
    /// error of order `p` by `2^p`.
    #[test]
    fn errors_have_the_orders_of_the_method() {
        let exact = |t: f64| 1.0 / (1.0 + t * t);
        let t = 0.4;
        let of = |h: f64| {
            let mut step = step((t, h), exact(t), |t, x| -2.0 * t * x * x, |t, x| -4.0 * t * x);
            let middle = within(&mut step, 0.4).0;
            let mut errors = [f64::NAN; 2];
            step.errors(&mut errors);
            [middle - exact(t + 0.4 * h), errors[0], step.end()[0] - exact(t + h)]
        };
        let (coarse, fine) = (of(0.1), of(0.05));
        for k in 0..2 {
            assert_relative_eq!((coarse[k] / fine[k]).log2(), 6.0, max_relative = 0.05);
        }
        // The error at the end, of order 10, is below rounding for such steps.
        let (coarse, fine) = (of(1.0), of(0.5));
        assert_relative_eq!((coarse[2] / fine[2]).log2(), 10.0, max_relative = 0.2);
    }

    /// A mode that is a million times faster than the step is gone at its end, and its error is not
    /// overrated.
    #[test]
    fn a_fast_mode_is_damped() {
        let mut step = step((0.0, 1.0), 1.0, |_, x| -1e6 * x, |_, _| -1e6);
        assert!(step.end()[0].abs() < 1e-5, "{}", step.end()[0]);
        let mut errors = [f64::NAN; 2];
        step.errors(&mut errors);
        assert!(errors[0].abs() < 2.0, "{errors:?}");
        let size = step.stiffness(&[1.0]).unwrap();
        assert_relative_eq!(size, 1e6, max_relative = 1e-12);
    }

    /// The slope at the start is of no use at the stages: it has the wrong sign there.
    #[test]
    fn a_slope_that_changes_is_followed() {
        let rate = |_: f64, x: f64| -20.0 * x.abs() * x + 1.0;
        let mut step = Step::new(1, 0);
        step.set_method(Method::Implicit);
        step.start(0.0, &[-0.2], &[rate(0.0, -0.2)]);
        assert!(step.advance(0.7, &[1e-8], &mut Alone(rate, |_, x: f64| -40.0 * x.abs())));
        // x' = 1 + 20 x^2 below zero, 1 - 20 x^2 above: an arc tangent up to zero, then a hyperbolic tangent.
        let root = 20.0_f64.sqrt();
        let zero = (0.2 * root).atan() / root;
        let exact = (root * (0.7 - zero)).tanh() / root;
        assert_abs_diff_eq!(step.end()[0], exact, epsilon = 5e-3);
    }

    #[test]
    fn rates_that_are_no_numbers_are_told() {
        let mut step = Step::new(1, 0);
        step.set_method(Method::Implicit);
        step.start(0.0, &[1.0], &[1.0]);
        assert!(!step.advance(
            1.0,
            &[1e-8],
            &mut Alone(|t, _| if t > 0.0 { f64::NAN } else { 1.0 }, |_, _| 0.0)
        ));
        // Only the point between two stages is no number.
        let hole = |t: f64, _: f64| if (t - BETWEEN).abs() < 0.01 { f64::NAN } else { 1.0 };
        let mut errors = [0.0; 2];
        self::step((0.0, 1.0), 0.0, hole, |_, _| 0.0).errors(&mut errors);
        assert!(errors[0].is_nan());
    }
}
