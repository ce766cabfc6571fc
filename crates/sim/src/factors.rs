//! The factors of a square matrix, for several right-hand sides.

use phisindy_expr::wide;

/// LU factors with row pivoting (G. H. Golub, C. F. Van Loan, Matrix Computations, 3.4). Zeros below a pivot
/// cost nothing, so that chains of bodies stay cheap.
#[derive(Default)]
pub(crate) struct Factors {
    /// The matrix before [`Factors::factor`], row by row; its factors afterwards.
    pub(crate) a: Vec<f64>,
    /// The factors column by column: one right-hand side is solved along columns.
    columns: Vec<f64>,
    pivots: Vec<usize>,
}

impl Factors {
    /// A matrix of `n` rows.
    pub(crate) fn new(n: usize) -> Self {
        Factors { a: vec![0.0; n * n], columns: vec![0.0; n * n], pivots: vec![0; n] }
    }

    /// Replaces the matrix by its factors; `false` if it is singular or not finite.
    pub(crate) fn factor(&mut self) -> bool {
        let Factors { a, columns, pivots } = self;
        wide(
            #[inline(always)]
            || decompose(a, pivots) && transpose(a, pivots.len(), columns),
        )
    }

    /// Replaces `k` right-hand sides, stored as `n` rows of `k` numbers, by the solutions.
    pub(crate) fn solve(&self, b: &mut [f64], k: usize) {
        wide(
            #[inline(always)]
            || match k {
                1 => substitute_one(&self.columns, &self.pivots, b),
                _ => substitute(&self.a, &self.pivots, b, k),
            },
        );
    }
}

#[inline(always)]
fn decompose(a: &mut [f64], pivots: &mut [usize]) -> bool {
    let n = pivots.len();
    for col in 0..n {
        let mut pivot = col;
        for row in col + 1..n {
            if a[row * n + col].abs() > a[pivot * n + col].abs() {
                pivot = row;
            }
        }
        pivots[col] = pivot;
        if pivot != col {
            (0..n).for_each(|j| a.swap(pivot * n + j, col * n + j));
        }
        let diagonal = a[col * n + col];
        if diagonal == 0.0 || !diagonal.is_finite() {
            return false;
        }
        let (above, below) = a.split_at_mut((col + 1) * n);
        let from = &above[col * n + col + 1..];
        for row in below.chunks_exact_mut(n).filter(|row| row[col] != 0.0) {
            let factor = row[col] / diagonal;
            row[col] = factor;
            row[col + 1..].iter_mut().zip(from).for_each(|(r, f)| *r -= factor * f);
        }
    }
    true
}

#[inline(always)]
fn transpose(a: &[f64], n: usize, columns: &mut [f64]) -> bool {
    for (row, a) in a.chunks_exact(n).enumerate() {
        a.iter().enumerate().for_each(|(col, a)| columns[col * n + row] = *a);
    }
    true
}

/// One right-hand side: what is known of the solution leaves all other equations at once.
#[inline(always)]
fn substitute_one(columns: &[f64], pivots: &[usize], b: &mut [f64]) {
    let n = pivots.len();
    pivots.iter().enumerate().for_each(|(col, &pivot)| b.swap(col, pivot));
    for (col, factors) in columns.chunks_exact(n).enumerate() {
        let (known, below) = b[col..].split_at_mut(1);
        below.iter_mut().zip(&factors[col + 1..]).for_each(|(b, f)| *b -= f * known[0]);
    }
    for (col, factors) in columns.chunks_exact(n).enumerate().rev() {
        let (above, known) = b.split_at_mut(col);
        known[0] /= factors[col];
        above.iter_mut().zip(factors).for_each(|(b, f)| *b -= f * known[0]);
    }
}

#[inline(always)]
fn substitute(a: &[f64], pivots: &[usize], b: &mut [f64], k: usize) {
    let n = pivots.len();
    for (col, &pivot) in pivots.iter().enumerate().filter(|(col, pivot)| col != *pivot) {
        (0..k).for_each(|j| b.swap(col * k + j, pivot * k + j));
    }
    for row in 1..n {
        let (before, own) = b.split_at_mut(row * k);
        subtract(&a[row * n..row * n + row], before, &mut own[..k]);
    }
    for row in (0..n).rev() {
        let (own, after) = b[row * k..].split_at_mut(k);
        subtract(&a[row * n + row + 1..(row + 1) * n], after, own);
        let diagonal = a[row * n + row];
        own.iter_mut().for_each(|b| *b /= diagonal);
    }
}

/// Subtracts the sum of `rows`, each times its factor.
#[inline(always)]
fn subtract(factors: &[f64], rows: &[f64], from: &mut [f64]) {
    for (factor, row) in factors.iter().zip(rows.chunks_exact(from.len())).filter(|(f, _)| **f != 0.0) {
        from.iter_mut().zip(row).for_each(|(b, r)| *b -= factor * r);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// The first pivot is zero, the second column needs an exchange, and one row holds a zero.
    #[test]
    fn the_solutions_solve_the_system() {
        let a = [[0.0, 2.0, -1.0, 3.0], [1e-3, 1.0, 4.0, 0.0], [5.0, -3.0, 2.0, 1.0], [0.0, 7.0, 1.0, -2.0]];
        let b = [[3.0, -1.0], [0.5, 2.0], [7.0, 0.0], [1.0, 1.0]];
        let mut factors = Factors::new(4);
        factors.a = a.concat();
        assert!(factors.factor());
        let mut x = b.concat();
        factors.solve(&mut x, 2);
        for (row, due) in a.iter().zip(&b) {
            for (k, due) in due.iter().enumerate() {
                let found: f64 = (0..4).map(|j| row[j] * x[2 * j + k]).sum();
                assert_relative_eq!(found, *due, epsilon = 1e-12);
            }
        }
        // One right-hand side goes another way.
        for k in 0..2 {
            let mut one: Vec<f64> = b.iter().map(|b| b[k]).collect();
            factors.solve(&mut one, 1);
            (0..4).for_each(|j| assert_relative_eq!(one[j], x[2 * j + k], max_relative = 1e-12));
        }
    }

    #[test]
    fn a_matrix_without_factors_is_told() {
        for a in [vec![1.0, 2.0, 2.0, 4.0], vec![f64::NAN, 1.0, 1.0, 1.0], vec![f64::INFINITY, 0.0, 0.0, 1.0]]
        {
            let mut factors = Factors::new(2);
            factors.a = a;
            assert!(!factors.factor());
        }
    }
}
