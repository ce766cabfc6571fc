//! Intervals by profile likelihood, for parameters on which the cost does not depend quadratically (Venzon
//! and Moolgavkar, Applied Statistics 37 (1988) 87-94): the parameter is fixed off its best value, all others
//! are refitted, and the interval ends where the cost has risen by the quantile of chi^2.

use crate::decisions::{
    HALF_WIDTH_95, PROFILE_DAMPING, PROFILE_END, PROFILE_FITS, PROFILE_MINIMUM, PROFILE_QUADRATIC,
    PROFILE_STEPS, PROFILE_STRETCH, RISE_95,
};
use crate::least_squares::{Limits, Normal};
use crate::trajectory::fit::Fit;

/// The 95 % interval of unknown `k`, whose quadratic one has the standard error `error`; never beyond the
/// bounds. `curvature` is the standard error by the curvature of the cost alone: where the noise is not as
/// modelled the two differ, and the rise to look for is stretched by the square of their ratio (Kent,
/// Biometrika 69 (1982) 19-27).
pub(crate) fn interval(fit: &Fit<'_>, k: usize, error: f64, curvature: f64) -> (f64, f64) {
    let (low, high) = fit.problem.bounds[k];
    let quadratic = (fit.x[k] - HALF_WIDTH_95 * error, fit.x[k] + HALF_WIDTH_95 * error);
    if !error.is_finite() {
        return (low, high);
    }
    if error == 0.0 {
        return quadratic;
    }
    let target = RISE_95 * (error / curvature).powi(2);
    let of = |quadratic: f64| end(fit, k, quadratic, target).clamp(low, high);
    rayon::join(|| of(quadratic.0), || of(quadratic.1))
}

/// One end, where the cost has risen by `target`, from where the quadratic model puts it.
fn end(fit: &Fit<'_>, k: usize, quadratic: f64, target: f64) -> f64 {
    let (low, high) = fit.problem.bounds[k];
    let mut z = quadratic;
    for step in 0..PROFILE_STEPS {
        z = z.clamp(low, high);
        if fit.problem.stop.requested() {
            return z;
        }
        let Some(rise) = rise(fit, k, z, target) else { return z };
        let miss = rise / target;
        // The interval ends at a bound, or near enough to the target.
        let at_bound = (z == low || z == high) && miss < 1.0;
        if at_bound || (miss - 1.0).abs() < if step == 0 { PROFILE_QUADRATIC } else { PROFILE_END } {
            return z;
        }
        // The square root of the rise is nearly linear.
        let stretch = (1.0 / miss.max(1e-3)).sqrt().clamp(PROFILE_STRETCH[0], PROFILE_STRETCH[1]);
        z = fit.x[k] + (z - fit.x[k]) * stretch;
    }
    z.clamp(low, high)
}

/// The rise of the cost if unknown `k` is fixed at `z` and all others are refitted, to a part of `target`;
/// `None` where the model cannot be simulated, or the others creep along a valley and do not arrive: what
/// they still have to gain would count as a rise, and the interval would end too early.
fn rise(fit: &Fit<'_>, k: usize, z: f64, target: f64) -> Option<f64> {
    let mut bounds = fit.problem.bounds.clone();
    bounds[k] = (z, z);
    let mut x = followed(fit, k, z);
    let limits = Limits::of(PROFILE_MINIMUM);
    for _ in 0..PROFILE_FITS {
        let there = fit.problem.minimise_within(&bounds, &mut x, &fit.weights, limits).ok()?;
        let rise = (there.cost - fit.normal.cost).max(0.0);
        // A rise below the target only falls, and the end lies farther out in any case.
        if rise <= target || still_to_gain(&there, &x, &bounds) < PROFILE_QUADRATIC * rise {
            return Some(rise);
        }
    }
    None
}

/// By how much the quadratic model promises to lower the cost yet, with what is held at a bound left there.
fn still_to_gain(there: &Normal, x: &[f64], bounds: &[(f64, f64)]) -> f64 {
    let n = x.len();
    let out = |i: usize| {
        let (low, high) = bounds[i];
        low >= high || (x[i] <= low && there.gradient[i] > 0.0) || (x[i] >= high && there.gradient[i] < 0.0)
    };
    let free: Vec<bool> = (0..n).map(|i| !out(i)).collect();
    let matrix = faer::Mat::from_fn(n, n, |i, j| if free[i] && free[j] { there.matrix[(i, j)] } else { 0.0 });
    let right: Vec<f64> = (0..n).map(|i| if free[i] { -there.gradient[i] } else { 0.0 }).collect();
    let step = crate::linear::solve_damped(&matrix, &right, PROFILE_DAMPING);
    step.map_or(f64::INFINITY, |step| step.iter().zip(&right).map(|(s, r)| s * r).sum())
}

/// Unknown `k` at `z`, and all others where the quadratic model puts them then.
pub(crate) fn followed(fit: &Fit<'_>, k: usize, z: f64) -> Vec<f64> {
    let mut x = fit.x.clone();
    let n = x.len();
    let held = |i: usize| i == k;
    let matrix =
        faer::Mat::from_fn(n, n, |i, j| if held(i) || held(j) { 0.0 } else { fit.normal.matrix[(i, j)] });
    let right: Vec<f64> =
        (0..n).map(|i| if held(i) { 0.0 } else { -fit.normal.matrix[(i, k)] * (z - fit.x[k]) }).collect();
    if let Some(step) = crate::linear::solve_damped(&matrix, &right, PROFILE_DAMPING) {
        for i in (0..n).filter(|&i| !held(i)) {
            x[i] = (x[i] + step[i]).clamp(fit.problem.bounds[i].0, fit.problem.bounds[i].1);
        }
    }
    x[k] = z;
    x
}

#[cfg(test)]
mod tests;
