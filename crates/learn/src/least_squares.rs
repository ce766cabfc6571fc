//! Levenberg-Marquardt within bounds, for any function that gives a cost and its normal equations.

use crate::decisions::{
    CHANCES, DAMPING_AFTER_FAILURE, DAMPING_FALL, DAMPING_RISE, FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING,
    ROUNDING, TRIES_PER_STEP,
};
use crate::linear::solve_damped;
use faer::Mat;
use rayon::prelude::*;

/// Cost `sum r^2` at a point, `J^T J` and `J^T r`.
#[derive(Clone, Debug)]
pub(crate) struct Normal {
    pub(crate) cost: f64,
    pub(crate) matrix: Mat<f64>,
    pub(crate) gradient: Vec<f64>,
}

impl Normal {
    /// The normal equations in the first `count` unknowns, the others at their minimum for each value of
    /// these: Schur's complement.
    pub(crate) fn reduced(&self, count: usize) -> Normal {
        let n = self.gradient.len();
        let inner = Mat::from_fn(n - count, n - count, |i, j| self.matrix[(count + i, count + j)]);
        let solved = |right: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let right: Vec<f64> = (count..n).map(right).collect();
            solve_damped(&inner, &right, 0.0).unwrap_or_else(|| vec![0.0; n - count])
        };
        let columns: Vec<Vec<f64>> =
            (0..count).into_par_iter().map(|j| solved(&|i| self.matrix[(i, j)])).collect();
        let shift = solved(&|i| self.gradient[i]);
        let along = |row: usize, column: &[f64]| -> f64 {
            (count..n).zip(column).map(|(i, c)| self.matrix[(row, i)] * c).sum()
        };
        let matrix = Mat::from_fn(count, count, |i, j| self.matrix[(i, j)] - along(i, &columns[j]));
        let gradient: Vec<f64> = (0..count).map(|i| self.gradient[i] - along(i, &shift)).collect();
        let fall: f64 = (count..n).zip(&shift).map(|(i, s)| self.gradient[i] * s).sum();
        Normal { cost: self.cost - fall, matrix, gradient }
    }
}

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Accepted steps at most.
    pub(crate) iterations: usize,
    /// Stops when a step lowers the cost by less than this part of it.
    pub(crate) gain: f64,
    /// ... or, as long as the cost is above the first of these, by less than the second: digits of a
    /// wrong model do not matter.
    pub(crate) far: (f64, f64),
    /// Gives up if [`CHANCES`] steps, or twice as many failures, leave the cost above this.
    pub(crate) hopeless: f64,
}

impl Limits {
    /// At most `iterations` steps, as long as each lowers the cost by the part `gain`.
    pub(crate) fn new(iterations: usize, gain: f64) -> Limits {
        Limits { iterations, gain, far: (f64::INFINITY, gain), hopeless: f64::INFINITY }
    }

    /// The same from a row of [`crate::decisions`].
    pub(crate) fn of([iterations, gain]: [f64; 2]) -> Limits {
        Limits::new(iterations as usize, gain)
    }
}

/// Minimises from `values`, which end at the best point found. Returns the normal equations there, or `None`
/// if the start itself cannot be evaluated. `evaluate` returns `None` where the model fails, and may return
/// it where the cost is above a ceiling, its second argument: after a failure the next step is likely to fail
/// too.
pub(crate) fn minimise(
    values: &mut [f64],
    bounds: &[(f64, f64)],
    limits: Limits,
    evaluate: impl FnMut(&[f64], f64) -> Option<Normal>,
) -> Option<Normal> {
    minimise_by(None, |_, _| (), values, bounds, limits, evaluate)
}

/// As [`minimise`], with steps damped by these curvatures in the place of the diagonal of `J^T J`. `correct` may change the
/// end of a step, its second argument.
pub(crate) fn minimise_by(
    metric: Option<&[f64]>,
    correct: impl Fn(&[f64], &mut [f64]),
    values: &mut [f64],
    bounds: &[(f64, f64)],
    limits: Limits,
    mut evaluate: impl FnMut(&[f64], f64) -> Option<Normal>,
) -> Option<Normal> {
    let n = values.len();
    let mut damping = FIRST_DAMPING;
    let mut tries = 0;
    // A start beyond a bound would stay there where nothing within is lower.
    values.iter_mut().zip(bounds).for_each(|(v, &(low, high))| *v = v.clamp(low, high));
    let mut now = evaluate(values, f64::INFINITY)?;
    for done in 0..limits.iterations {
        let hopeless = now.cost > limits.hopeless;
        if hopeless && done >= CHANCES {
            break;
        }
        // A step that keeps failing costs more than it can gain.
        let most = if hopeless { done + 2 * CHANCES } else { TRIES_PER_STEP * limits.iterations };
        let mut better = None;
        let mut ceiling = f64::INFINITY;
        while damping < MOST_DAMPING && tries < most {
            let step = bounded_step(&now, values, bounds, damping, metric);
            let Some(step) = step else {
                damping *= DAMPING_RISE;
                continue;
            };
            let mut trial: Vec<f64> =
                (0..n).map(|k| (values[k] + step[k]).clamp(bounds[k].0, bounds[k].1)).collect();
            correct(values, &mut trial);
            if trial.iter().zip(values.iter()).all(|(a, b)| a == b) {
                break;
            }
            tries += 1;
            match evaluate(&trial, ceiling) {
                Some(next) if next.cost < now.cost => {
                    better = Some((trial, next));
                    damping = (damping * DAMPING_FALL).max(LEAST_DAMPING);
                    break;
                }
                // At the rounding of the cost there is nothing left to gain.
                Some(next) if next.cost <= now.cost * ROUNDING => break,
                _ => {
                    damping = (damping * DAMPING_RISE).max(DAMPING_AFTER_FAILURE);
                    ceiling = now.cost * ROUNDING;
                }
            }
        }
        let Some((trial, next)) = better else { break };
        let gain = (now.cost - next.cost) / now.cost.max(f64::MIN_POSITIVE);
        values.copy_from_slice(&trial);
        now = next;
        let least = if now.cost > limits.far.0 { limits.far.1 } else { limits.gain };
        if gain < least {
            break;
        }
    }
    Some(now)
}

/// The damped step; unknowns at a bound that would leave it are fixed.
fn bounded_step(
    now: &Normal,
    values: &[f64],
    bounds: &[(f64, f64)],
    damping: f64,
    metric: Option<&[f64]>,
) -> Option<Vec<f64>> {
    let n = values.len();
    let mut matrix = now.matrix.clone();
    let mut right: Vec<f64> = now.gradient.iter().map(|g| -g).collect();
    for k in 0..n {
        if (values[k] <= bounds[k].0 && right[k] < 0.0) || (values[k] >= bounds[k].1 && right[k] > 0.0) {
            right[k] = 0.0;
            (0..n).for_each(|j| {
                matrix[(k, j)] = 0.0;
                matrix[(j, k)] = 0.0;
            });
        }
    }
    let Some(metric) = metric else { return solve_damped(&matrix, &right, damping) };
    (0..n).for_each(|k| matrix[(k, k)] += damping * metric[k]);
    solve_damped(&matrix, &right, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::symmetric;
    use approx::assert_relative_eq;

    /// Rosenbrock's function as a least-squares problem.
    fn rosenbrock(x: &[f64]) -> Option<Normal> {
        let r = [10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]];
        let j = [[-20.0 * x[0], 10.0], [-1.0, 0.0]];
        let dot = |a: usize, b: usize| j[0][a] * j[0][b] + j[1][a] * j[1][b];
        Some(Normal {
            cost: r[0] * r[0] + r[1] * r[1],
            matrix: symmetric(&[dot(0, 0), dot(0, 1), dot(1, 1)], 2),
            gradient: (0..2).map(|k| j[0][k] * r[0] + j[1][k] * r[1]).collect(),
        })
    }

    #[test]
    fn finds_the_valley_and_respects_bounds() {
        let free = [(f64::NEG_INFINITY, f64::INFINITY); 2];
        let limits = Limits::new(200, 0.0);
        let mut x = [-1.2, 1.0];
        minimise(&mut x, &free, limits, |x, _| rosenbrock(x)).unwrap();
        assert_relative_eq!(x[0], 1.0, max_relative = 1e-8);
        assert_relative_eq!(x[1], 1.0, max_relative = 1e-8);
        let mut x = [-1.2, 1.0];
        minimise(&mut x, &[(-2.0, 0.5), (-2.0, 2.0)], limits, |x, _| rosenbrock(x)).unwrap();
        assert_relative_eq!(x[0], 0.5, max_relative = 1e-8);
        assert_relative_eq!(x[1], 0.25, max_relative = 1e-6);
    }

    /// `(a + b - 3)^2 + (b - 1)^2 + 4` at zero, the second unknown at its minimum for each value of the
    /// first: `(a - 2)^2 / 2 + 4`.
    #[test]
    fn the_others_follow_in_the_reduced_equations() {
        let normal =
            Normal { cost: 14.0, matrix: symmetric(&[1.0, 1.0, 2.0], 2), gradient: vec![-3.0, -4.0] };
        let reduced = normal.reduced(1);
        assert_relative_eq!(reduced.cost, 6.0, max_relative = 1e-12);
        assert_relative_eq!(reduced.matrix[(0, 0)], 0.5, max_relative = 1e-12);
        assert_relative_eq!(reduced.gradient[0], -1.0, max_relative = 1e-12);
    }

    /// How often the start alone, of all points, was evaluated and what was tried beside it.
    fn calls_on_a_cliff(iterations: usize) -> usize {
        let (mut calls, mut x) = (0, [-1.2, 1.0]);
        let free = [(f64::NEG_INFINITY, f64::INFINITY); 2];
        minimise(&mut x, &free, Limits::new(iterations, 0.0), |x, _| {
            calls += 1;
            if x == [-1.2, 1.0] { rosenbrock(x) } else { None }
        });
        assert_eq!(x, [-1.2, 1.0]);
        calls
    }

    #[test]
    fn a_cliff_costs_three_tries_for_each_step() {
        assert_eq!(calls_on_a_cliff(1), 1 + 3);
        assert_eq!(calls_on_a_cliff(3), 1 + 9);
    }

    #[test]
    fn what_stays_hopeless_is_given_up_after_the_chances() {
        let free = [(f64::NEG_INFINITY, f64::INFINITY); 2];
        let steps = |limits: Limits| {
            let (mut x, mut cost, mut steps) = ([-1.2, 1.0], f64::INFINITY, -1);
            minimise(&mut x, &free, limits, |x, _| {
                let normal = rosenbrock(x)?;
                if normal.cost < cost {
                    (cost, steps) = (normal.cost, steps + 1);
                }
                Some(normal)
            });
            steps
        };
        let limits = Limits::new(200, 0.0);
        // Two steps and six failures.
        assert_eq!(steps(Limits { hopeless: 0.0, ..limits }), 2);
        assert!(steps(Limits { hopeless: 1e3, ..limits }) > 3);
        assert_eq!(steps(Limits::new(5, 0.0)), 5);
        // The first step brings the cost from 24.2 to about 4.7: a gain of less than 0.99 of it.
        assert_eq!(steps(Limits::new(200, 0.99)), 1);
        assert_eq!(steps(Limits { far: (4.0, 0.99), ..limits }), 1);
        assert!(steps(Limits { far: (5.0, 0.99), ..limits }) > 3);
    }

    #[test]
    fn a_start_at_a_bound_leaves_it() {
        for (start, bounds) in [([-2.0, 1.0], [(-2.0, 3.0); 2]), ([3.0, 3.0], [(-3.0, 3.0); 2])] {
            let mut x = start;
            minimise(&mut x, &bounds, Limits::new(200, 0.0), |x, _| rosenbrock(x)).unwrap();
            assert_relative_eq!(x[0], 1.0, max_relative = 1e-8);
            assert_relative_eq!(x[1], 1.0, max_relative = 1e-8);
        }
    }

    #[test]
    fn a_hopeless_cliff_costs_twice_the_chances() {
        let (mut calls, mut x) = (0, [-1.2, 1.0]);
        let free = [(f64::NEG_INFINITY, f64::INFINITY); 2];
        minimise(&mut x, &free, Limits { hopeless: 1.0, ..Limits::new(20, 0.0) }, |x, _| {
            calls += 1;
            if x == [-1.2, 1.0] { rosenbrock(x) } else { None }
        });
        assert_eq!(calls, 1 + 6);
    }

    /// Of `(x - 1)^2 + (x + 1)^2`, so near its end that the cost is the same number.
    #[test]
    fn where_rounding_hides_the_gain_it_ends() {
        let (mut calls, mut x) = (0, [1e-9]);
        minimise(&mut x, &[(-9.0, 9.0)], Limits::new(50, 0.0), |x, _| {
            calls += 1;
            Some(Normal {
                cost: 2.0 + 2.0 * x[0] * x[0],
                matrix: symmetric(&[2.0], 1),
                gradient: vec![2.0 * x[0]],
            })
        });
        assert_eq!(calls, 2);
    }

    /// Rounding may leave `J^T J` with a negative eigenvalue (here -1 of unit diagonal): no step without
    /// damping beyond it, and then the same end.
    #[test]
    fn a_matrix_that_is_not_definite_is_damped_until_it_is() {
        let mut x = [3.0, -2.0];
        let free = [(f64::NEG_INFINITY, f64::INFINITY); 2];
        let end = minimise(&mut x, &free, Limits::new(100, 0.0), |x, _| {
            Some(Normal {
                cost: 1.0 + x[0] * x[0] + x[1] * x[1],
                matrix: symmetric(&[1.0, 2.0, 1.0], 2),
                gradient: x.to_vec(),
            })
        });
        // It creeps along the wrong eigenvector, by half of what is left with each step.
        assert_relative_eq!(end.unwrap().cost, 1.0, max_relative = 1e-6);
        assert!(x.iter().all(|x| x.abs() < 1e-3), "{x:?}");
    }
}
