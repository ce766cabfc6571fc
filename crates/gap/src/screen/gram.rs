//! One Gram matrix of all columns. Free columns are projected out once, so each regression is small.

use crate::decisions::DEGENERATE;
use faer::Mat;
use faer::linalg::solvers::Solve;

/// Gain and coefficients of a regression of column 0 on the columns `at` of a projected Gram matrix.
pub(super) fn solve(gram: &Mat<f64>, at: &[usize]) -> Option<(f64, Vec<f64>)> {
    let scale: Vec<f64> = at.iter().map(|&k| gram[(k, k)].sqrt()).collect();
    if scale.iter().any(|s| *s <= 0.0 || !s.is_finite()) {
        return None;
    }
    let n = at.len();
    let m = Mat::from_fn(n, n, |i, j| {
        gram[(at[i], at[j])] / (scale[i] * scale[j]) + if i == j { 1e-10 } else { 0.0 }
    });
    let right = Mat::from_fn(n, 1, |i, _| gram[(at[i], 0)] / scale[i]);
    let llt = m.llt(faer::Side::Lower).ok()?;
    let x = llt.solve(&right);
    let gain: f64 = (0..n).map(|i| x[(i, 0)] * right[(i, 0)]).sum();
    let coefficients: Vec<f64> = (0..n).map(|i| x[(i, 0)] / scale[i]).collect();
    (gain.is_finite() && coefficients.iter().all(|c| c.is_finite())).then_some((gain, coefficients))
}

/// A Gram matrix with some columns projected out of the others.
pub(super) struct Projected {
    pub(super) gram: Mat<f64>,
    /// Which columns are not degenerate after the projection.
    pub(super) kept: Vec<bool>,
    /// Regression coefficients of each remaining column on the projected columns.
    pub(super) follow: Mat<f64>,
}

/// The Gram matrix with columns 1 .. `fixed` projected out of all others (column 0 is the target).
pub(super) fn projected(gram: &Mat<f64>, fixed: usize) -> Projected {
    let total = gram.ncols();
    let out: Vec<usize> = (1..fixed).filter(|&k| gram[(k, k)] > 0.0).collect();
    let rest: Vec<usize> = [0].into_iter().chain(fixed..total).collect();
    let scale: Vec<f64> = out.iter().map(|&k| 1.0 / gram[(k, k)].sqrt()).collect();
    let n = out.len();
    let m = Mat::from_fn(n, n, |i, j| {
        gram[(out[i], out[j])] * scale[i] * scale[j] + if i == j { 1e-12 } else { 0.0 }
    });
    let cross = Mat::from_fn(n, rest.len(), |i, j| gram[(out[i], rest[j])] * scale[i]);
    let own = Mat::from_fn(rest.len(), rest.len(), |i, j| gram[(rest[i], rest[j])]);
    let mut follow = Mat::zeros(fixed - 1, rest.len());
    let left = match m.llt(faer::Side::Lower) {
        Ok(llt) if n > 0 => {
            let solved = llt.solve(&cross);
            for (i, &k) in out.iter().enumerate() {
                (0..rest.len()).for_each(|j| follow[(k - 1, j)] = scale[i] * solved[(i, j)]);
            }
            &own - cross.transpose() * &solved
        }
        _ => own.clone(),
    };
    let kept = (0..rest.len()).map(|k| left[(k, k)] > DEGENERATE * own[(k, k)]).collect();
    Projected { gram: left, kept, follow }
}
