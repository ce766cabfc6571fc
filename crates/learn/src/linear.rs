//! Small dense linear algebra on symmetric matrices, through faer.

use crate::decisions::{BLIND_EIGENVALUE, BLIND_PART, DENSE};
use faer::Mat;
use faer::Side;
use faer::linalg::solvers::Solve;
use rayon::prelude::*;

/// A symmetric matrix from its upper triangle, row by row.
pub(crate) fn symmetric(triangle: &[f64], n: usize) -> Mat<f64> {
    let at = |i: usize, j: usize| {
        let (i, j) = (i.min(j), i.max(j));
        triangle[i * n - i * (i + 1) / 2 + j]
    };
    Mat::from_fn(n, n, at)
}

/// Solves `(A + damping diag A) x = b` for a positive semidefinite `A`, scaled to unit diagonal first; rows
/// with a zero diagonal stay at zero.
pub(crate) fn solve_damped(a: &Mat<f64>, b: &[f64], damping: f64) -> Option<Vec<f64>> {
    let n = b.len();
    let scale = scales(a);
    let m = Mat::from_fn(n, n, |i, j| {
        let x = a[(i, j)] * scale[i] * scale[j];
        if i == j { if a[(i, i)] > 0.0 { x + damping } else { 1.0 } } else { x }
    });
    if n > DENSE {
        let right: Vec<f64> = (0..n).map(|i| b[i] * scale[i]).collect();
        let x = solve_in_envelope(&m, &right)?;
        return x.iter().all(|v| v.is_finite()).then(|| x.iter().zip(&scale).map(|(x, s)| x * s).collect());
    }
    let right = Mat::from_fn(n, 1, |i, _| b[i] * scale[i]);
    let x = m.llt(Side::Lower).ok()?.solve(&right);
    let x: Vec<f64> = (0..n).map(|i| x[(i, 0)] * scale[i]).collect();
    x.iter().all(|v| v.is_finite()).then_some(x)
}

/// Solves a positive definite system from its last unknown to its first by Cholesky's method within the
/// envelope (Jennings, The Computer Journal 9 (1966) 281-285): in each row everything before its first entry
/// stays zero. The start states of segments come last and are coupled to their own segment and to the numbers
/// that all share, so the work grows with their number and not with its cube. `None` if the matrix is not
/// definite.
fn solve_in_envelope(m: &Mat<f64>, b: &[f64]) -> Option<Vec<f64>> {
    let n = b.len();
    // The matrix is symmetric, and stored by columns: a row is read along one.
    let at = |i: usize, j: usize| m[(n - 1 - j, n - 1 - i)];
    let first: Vec<usize> = (0..n).map(|i| (0..i).find(|&j| at(i, j) != 0.0).unwrap_or(i)).collect();
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(n);
    for i in 0..n {
        let mut row: Vec<f64> = Vec::with_capacity(i + 1 - first[i]);
        for j in first[i]..=i {
            let from = first[i].max(first[j]);
            let other = if j < i { &rows[j] } else { &row };
            let both = row[from - first[i]..].iter().zip(&other[from - first[j]..]);
            let rest = at(i, j) - both.take(j - from).map(|(a, b)| a * b).sum::<f64>();
            let value = if j < i { rest / rows[j][j - first[j]] } else { rest.sqrt() };
            if j == i && (rest.is_nan() || rest <= 0.0) {
                return None;
            }
            row.push(value);
        }
        rows.push(row);
    }
    let mut x: Vec<f64> = b.iter().rev().copied().collect();
    for i in 0..n {
        let known: f64 = rows[i].iter().zip(&x[first[i]..i]).map(|(l, x)| l * x).sum();
        x[i] = (x[i] - known) / rows[i][i - first[i]];
    }
    for i in (0..n).rev() {
        x[i] /= rows[i][i - first[i]];
        let (before, after) = x.split_at_mut(i);
        before[first[i]..].iter_mut().zip(&rows[i]).for_each(|(x, l)| *x -= l * after[0]);
    }
    x.reverse();
    Some(x)
}

/// The inverse of a positive semidefinite matrix; unknowns in singular directions (eigenvalue below
/// [`BLIND_EIGENVALUE`] of unit diagonal) get an infinite diagonal.
pub(crate) fn covariance(a: &Mat<f64>) -> Mat<f64> {
    let n = a.nrows();
    if n == 0 {
        return Mat::zeros(0, 0);
    }
    let scale = scales(a);
    let m = Mat::from_fn(n, n, |i, j| a[(i, j)] * scale[i] * scale[j]);
    let Ok(eigen) = m.self_adjoint_eigen(Side::Lower) else { return Mat::from_fn(n, n, |_, _| f64::NAN) };
    let (u, s) = (eigen.U(), eigen.S());
    let blind = |k: usize| s[k] <= BLIND_EIGENVALUE;
    let lost = |i: usize| a[(i, i)] <= 0.0 || (0..n).any(|k| blind(k) && u[(i, k)].abs() > BLIND_PART);
    // Rows that lie in one piece: an unknown for each segment makes this the larger part of the work.
    let seen: Vec<usize> = (0..n).filter(|&k| !blind(k)).collect();
    let rows: Vec<Vec<f64>> = (0..n).map(|i| seen.iter().map(|&k| u[(i, k)]).collect()).collect();
    let sizes: Vec<f64> = seen.iter().map(|&k| s[k]).collect();
    let entry = |i: usize, j: usize| -> f64 {
        let products = rows[i].iter().zip(&rows[j]).zip(&sizes);
        products.map(|((a, b), s)| a * b / s).sum()
    };
    let lower: Vec<Vec<f64>> = (0..n)
        .into_par_iter()
        .map(|i| (0..=i).map(|j| if i == j && lost(i) { f64::INFINITY } else { entry(i, j) }).collect())
        .collect();
    Mat::from_fn(n, n, |i, j| {
        let entry = lower[i.max(j)][i.min(j)];
        if entry.is_infinite() { entry } else { entry * scale[i] * scale[j] }
    })
}

/// The first rows and columns of the inverse of a positive definite matrix; `None` if it is not definite.
pub(crate) fn inverse_block(a: &Mat<f64>, count: usize) -> Option<Mat<f64>> {
    let unit = |k: usize| (0..a.nrows()).map(|i| if i == k { 1.0 } else { 0.0 }).collect::<Vec<f64>>();
    let columns: Vec<Vec<f64>> = (0..count).map(|k| solve_damped(a, &unit(k), 0.0)).collect::<Option<_>>()?;
    Some(Mat::from_fn(count, count, |i, j| columns[j][i]))
}

fn scales(a: &Mat<f64>) -> Vec<f64> {
    (0..a.nrows()).map(|i| if a[(i, i)] > 0.0 { 1.0 / a[(i, i)].sqrt() } else { 0.0 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn solves_a_badly_scaled_system() {
        // [[4e12, 2e3], [2e3, 3]] x = b with x = [1e-6, 2].
        let a = symmetric(&[4e12, 2e3, 3.0], 2);
        let b = [4e12 * 1e-6 + 2e3 * 2.0, 2e3 * 1e-6 + 3.0 * 2.0];
        let x = solve_damped(&a, &b, 0.0).unwrap();
        assert_relative_eq!(x[0], 1e-6, max_relative = 1e-9);
        assert_relative_eq!(x[1], 2.0, max_relative = 1e-9);
    }

    /// An arrow of pairs beside three shared unknowns, against the dense solution; one that is not definite
    /// has none.
    #[test]
    fn the_envelope_gives_the_dense_solution() {
        let (shared, n) = (3, 203);
        let pair = |i: usize| (i - shared) / 2;
        let mut m = Mat::from_fn(n, n, |i, j| {
            let value = 1.0 / (1.0 + (i + j) as f64) * if (i + j) % 3 == 0 { -1.0 } else { 1.0 };
            if i == j {
                40.0 + i as f64
            } else if i.min(j) < shared || pair(i) == pair(j) {
                value
            } else {
                0.0
            }
        });
        let b: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let x = solve_in_envelope(&m, &b).unwrap();
        for i in 0..n {
            let left: f64 = (0..n).map(|j| m[(i, j)] * x[j]).sum();
            assert_relative_eq!(left, b[i], epsilon = 1e-11);
        }
        m[(100, 100)] = -1.0;
        assert_eq!(solve_in_envelope(&m, &b), None);
    }

    #[test]
    fn covariance_inverts_and_knows_what_it_does_not_see() {
        let a = symmetric(&[2.0, 1.0, 2.0], 2);
        let c = covariance(&a);
        assert_relative_eq!(c[(0, 0)], 2.0 / 3.0, max_relative = 1e-12);
        assert_relative_eq!(c[(0, 1)], -1.0 / 3.0, max_relative = 1e-12);
        let singular = symmetric(&[1.0, 1.0, 0.0, 1.0, 0.0, 5.0], 3);
        let c = covariance(&singular);
        assert!(c[(0, 0)].is_infinite() && c[(1, 1)].is_infinite());
        assert_relative_eq!(c[(2, 2)], 0.2, max_relative = 1e-12);
    }

    #[test]
    fn damping_is_a_part_of_the_diagonal_and_what_is_not_seen_stays() {
        // [[2, 1], [1, 4]] with half of its diagonal more: [[3, 1], [1, 6]] x = b with x = [1, 2].
        let x = solve_damped(&symmetric(&[2.0, 1.0, 4.0], 2), &[5.0, 13.0], 0.5).unwrap();
        assert_relative_eq!(x[0], 1.0, max_relative = 1e-12);
        assert_relative_eq!(x[1], 2.0, max_relative = 1e-12);
        let x = solve_damped(&symmetric(&[4.0, 0.0, 0.0], 2), &[8.0, 3.0], 0.0).unwrap();
        assert_relative_eq!(x[0], 2.0, max_relative = 1e-12);
        assert_eq!(x[1], 0.0);
        assert_eq!(solve_damped(&symmetric(&[1.0, 2.0, 1.0], 2), &[1.0, 1.0], 0.0), None, "not definite");
    }

    #[test]
    fn a_covariance_has_the_units_of_its_unknowns() {
        // The inverse of [[2, 1], [1, 2]], the second unknown counted in thousandths.
        let c = covariance(&symmetric(&[2.0, 1e-3, 2e-6], 2));
        assert_relative_eq!(c[(0, 0)], 2.0 / 3.0, max_relative = 1e-12);
        assert_relative_eq!(c[(0, 1)], -1e3 / 3.0, max_relative = 1e-12);
        assert_relative_eq!(c[(1, 0)], -1e3 / 3.0, max_relative = 1e-12);
        assert_relative_eq!(c[(1, 1)], 2e6 / 3.0, max_relative = 1e-12);
    }
}
