//! One step of Dormand and Prince's Runge-Kutta pair 5(4) with its dense output (J. Comput. Appl. Math. 6
//! (1980) 19-26; Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.5 and II.6).

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

/// The memory of one step.
pub(crate) struct Step {
    /// Start of the step.
    pub(crate) t: f64,
    /// Length of the step.
    pub(crate) h: f64,
    /// State at the stages; the first is the start, the last the end.
    pub(crate) x: [Vec<f64>; STAGES],
    /// Rates at the stages, followed by the loads of the sticking contacts, which are not integrated but
    /// must be resolved too.
    pub(crate) k: [Vec<f64>; STAGES],
    dense: Dense,
    interpolated: bool,
}

impl Step {
    pub(crate) fn new(n: usize, loads: usize) -> Self {
        let columns = |size: usize| std::array::from_fn(|_| vec![0.0; size]);
        let (x, k) = (columns(n), columns(n + loads));
        Step { t: 0.0, h: 0.0, x, k, dense: Dense::default(), interpolated: false }
    }

    /// Starts at a point whose rates are known.
    pub(crate) fn start(&mut self, t: f64, x: &[f64], rates: &[f64]) {
        self.t = t;
        self.x[0].copy_from_slice(x);
        self.k[0].copy_from_slice(rates);
    }

    /// Makes a step of length `h` from the start.
    pub(crate) fn advance(&mut self, h: f64, mut rates: impl FnMut(f64, &[f64], &mut [f64])) {
        self.h = h;
        self.interpolated = false;
        let n = self.x[0].len();
        for stage in 1..STAGES {
            for i in 0..n {
                let sum: f64 = (0..stage).map(|j| A[stage - 1][j] * self.k[j][i]).sum();
                self.x[stage][i] = self.x[0][i] + h * sum;
            }
            rates(self.t + C[stage] * h, &self.x[stage], &mut self.k[stage]);
        }
    }

    /// The state at the end.
    pub(crate) fn end(&self) -> &[f64] {
        &self.x[STAGES - 1]
    }

    /// The estimated errors of the states, followed by those of the mean loads.
    pub(crate) fn errors(&self, out: &mut [f64]) {
        let n = self.x[0].len();
        for (i, e) in out[..self.k[0].len()].iter_mut().enumerate() {
            *e = (0..STAGES).map(|j| E[j] * self.k[j][i]).sum();
            if i < n {
                *e *= self.h;
            }
        }
    }

    /// The interpolant of the step.
    pub(crate) fn dense(&mut self) -> &Dense {
        if !self.interpolated {
            self.interpolated = true;
            self.dense.set(self.h, &self.x[0], &self.x[STAGES - 1], &self.k);
        }
        &self.dense
    }
}

/// Hairer's fourth-order interpolant of a step, from the values at both ends and the rates at the stages.
/// It serves states and sensitivities alike.
#[derive(Default)]
pub(crate) struct Dense {
    h: f64,
    /// Five coefficients for each component.
    c: Vec<[f64; 5]>,
}

impl Dense {
    pub(crate) fn set(&mut self, h: f64, start: &[f64], end: &[f64], k: &[Vec<f64>; STAGES]) {
        self.h = h;
        self.c.clear();
        self.c.extend(start.iter().zip(end).enumerate().map(|(i, (&start, &end))| {
            let difference = end - start;
            let bend = h * k[0][i] - difference;
            let fourth = difference - h * k[STAGES - 1][i] - bend;
            let fifth = h * k.iter().zip(&D).map(|(k, d)| d * k[i]).sum::<f64>();
            [start, difference, bend, fourth, fifth]
        }));
    }

    /// The values at the fraction `theta` of the step.
    pub(crate) fn values(&self, theta: f64) -> impl Iterator<Item = f64> {
        let back = 1.0 - theta;
        self.c.iter().map(move |[start, difference, bend, fourth, fifth]| {
            start + theta * (difference + back * (bend + theta * (fourth + back * fifth)))
        })
    }

    /// Writes the values at the fraction `theta` to `out`.
    pub(crate) fn value(&self, theta: f64, out: &mut [f64]) {
        out.iter_mut().zip(self.values(theta)).for_each(|(out, value)| *out = value);
    }

    /// Writes the rates of change at the fraction `theta` to `out`.
    pub(crate) fn slope(&self, theta: f64, out: &mut [f64]) {
        let back = 1.0 - theta;
        for (out, [_, difference, bend, fourth, fifth]) in out.iter_mut().zip(&self.c) {
            let third = fourth + back * fifth;
            let second = bend + theta * third;
            let first = difference + back * second;
            *out = (first + theta * (back * (third - theta * fifth) - second)) / self.h;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    /// One step of one state; the load equals its rate.
    fn step(t: f64, h: f64, x: f64, rate: impl Fn(f64, f64) -> f64) -> Step {
        let mut step = Step::new(1, 1);
        step.start(t, &[x], &[rate(t, x); 2]);
        step.advance(h, |t, x, out| out.fill(rate(t, x[0])));
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
