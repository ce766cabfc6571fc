//! One Gram matrix of all columns. Free columns are projected out once, so each regression is small.

use crate::decisions::DEGENERATE;
use faer::Mat;
use faer::linalg::solvers::Solve;
use phisindy_expr::wide;

/// Rows of a block: its columns stay in the first caches.
const BLOCK: usize = 512;
/// Partial sums of a product.
const LANES: usize = 8;

/// The inner products of columns of equal length: rows are those of `a`, columns those of `b`. For a few
/// columns of `b`, of which a general product of matrices makes a wide one.
pub(super) fn products(a: &[&[f64]], b: &[&[f64]]) -> Mat<f64> {
    let rows = a.iter().chain(b).map(|column| column.len()).next().unwrap_or(0);
    let mut sums = vec![[0.0; LANES]; a.len() * b.len()];
    for first in (0..rows).step_by(BLOCK) {
        let block = first..(first + BLOCK).min(rows);
        wide(
            #[inline(always)]
            || {
                for (i, a) in a.iter().enumerate() {
                    for (b, sum) in b.iter().zip(&mut sums[i * b.len()..]) {
                        add_products(&a[block.clone()], &b[block.clone()], sum);
                    }
                }
            },
        );
    }
    Mat::from_fn(a.len(), b.len(), |i, j| sums[i * b.len() + j].iter().sum())
}

#[inline(always)]
fn add_products(a: &[f64], b: &[f64], sum: &mut [f64; LANES]) {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut own = *sum;
    for (a, b) in a.iter().zip(b) {
        (0..LANES).for_each(|k| own[k] += a[k] * b[k]);
    }
    a_rest.iter().zip(b_rest).enumerate().for_each(|(k, (a, b))| own[k] += a * b);
    *sum = own;
}

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

#[cfg(test)]
mod tests {
    use super::*;

    /// More rows than a block, and some that fill no lanes.
    #[test]
    fn products_are_sums_over_all_rows() {
        let column = |k: usize| (0..2 * BLOCK + 13).map(|i| ((i * (k + 3)) as f64).sin()).collect();
        let all: Vec<Vec<f64>> = (0..5).map(column).collect();
        let all: Vec<&[f64]> = all.iter().map(Vec::as_slice).collect();
        let (a, b) = all.split_at(3);
        let found = products(a, b);
        assert_eq!((found.nrows(), found.ncols()), (3, 2));
        for (i, a) in a.iter().enumerate() {
            for (j, b) in b.iter().enumerate() {
                let due: f64 = a.iter().zip(*b).map(|(a, b)| a * b).sum();
                assert!((found[(i, j)] - due).abs() < 1e-9, "{i} {j}");
            }
        }
    }
}
