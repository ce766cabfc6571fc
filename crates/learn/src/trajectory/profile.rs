//! Intervals by profile likelihood, for parameters on which the cost does not depend quadratically (Venzon and Moolgavkar, Applied Statistics 37
//! (1988) 87-94): the parameter is held off its best value, everything else follows, and the interval ends where the cost has risen by chi^2.

use crate::least_squares::Limits;
use crate::trajectory::fit::Fit;

/// 95 % quantile of chi^2 with one degree of freedom, and its root.
const RISE: f64 = 3.841_458_820_694_124;
const REACH: f64 = 1.959_963_984_540_054;
/// The quadratic interval stands if the cost at its end is within this part of what it should be.
const QUADRATIC: f64 = 0.2;
/// Steps of the search for an end.
const STEPS: usize = 5;

/// The 95 % interval of unknown `k`, whose quadratic one has the standard error `error`; never beyond the bounds. `curvature` is the standard error by the
/// curvature of the cost alone: where the noise is not as modelled the two differ, and the rise to look for is stretched by the square of
/// their ratio (Kent, Biometrika 69 (1982) 19-27).
pub(crate) fn interval(fit: &Fit<'_>, k: usize, error: f64, curvature: f64) -> (f64, f64) {
    let (low, high) = fit.problem.bounds[k];
    let quadratic = (fit.x[k] - REACH * error, fit.x[k] + REACH * error);
    if !error.is_finite() {
        return (low, high);
    }
    if error == 0.0 {
        return quadratic;
    }
    let target = RISE * (error / curvature).powi(2);
    let of = |quadratic: f64| end(fit, k, quadratic, target).clamp(low, high);
    rayon::join(|| of(quadratic.0), || of(quadratic.1))
}

/// One end, where the cost has risen by `target`, from where the quadratic model puts it.
fn end(fit: &Fit<'_>, k: usize, quadratic: f64, target: f64) -> f64 {
    let (low, high) = fit.problem.bounds[k];
    let mut z = quadratic;
    for step in 0..STEPS {
        z = z.clamp(low, high);
        let Some(rise) = rise(fit, k, z) else { return z };
        let miss = rise / target;
        // Beyond a bound there is nothing to look for; near enough is good.
        let at_bound = (z == low || z == high) && miss < 1.0;
        if at_bound || (miss - 1.0).abs() < if step == 0 { QUADRATIC } else { 0.02 } {
            return z;
        }
        // The root of the rise is nearly straight.
        let stretch = (1.0 / miss.max(1e-3)).sqrt().clamp(0.3, 3.0);
        z = fit.x[k] + (z - fit.x[k]) * stretch;
    }
    z.clamp(low, high)
}

/// By how much the cost rises if unknown `k` is held at `z` and all others follow; `None` where the model fails.
fn rise(fit: &Fit<'_>, k: usize, z: f64) -> Option<f64> {
    let mut bounds = fit.problem.bounds.clone();
    bounds[k] = (z, z);
    let mut x = followed(fit, k, z);
    let limits = Limits::new(5, 1e-6);
    let there = fit.problem.minimise_within(&bounds, &mut x, &fit.weights, limits).ok()?;
    Some((there.cost - fit.normal.cost).max(0.0))
}

/// Unknown `k` at `z`, and all others where the quadratic model puts them then.
fn followed(fit: &Fit<'_>, k: usize, z: f64) -> Vec<f64> {
    let mut x = fit.x.clone();
    let n = x.len();
    let held = |i: usize| i == k;
    let matrix =
        faer::Mat::from_fn(n, n, |i, j| if held(i) || held(j) { 0.0 } else { fit.normal.matrix[(i, j)] });
    let right: Vec<f64> =
        (0..n).map(|i| if held(i) { 0.0 } else { -fit.normal.matrix[(i, k)] * (z - fit.x[k]) }).collect();
    if let Some(step) = crate::linear::solve_damped(&matrix, &right, 1e-9) {
        for i in (0..n).filter(|&i| !held(i)) {
            x[i] = (x[i] + step[i]).clamp(fit.problem.bounds[i].0, fit.problem.bounds[i].1);
        }
    }
    x[k] = z;
    x
}

#[cfg(test)]
mod tests;
