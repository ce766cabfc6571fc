//! Linear systems of a few unknowns.

use crate::decisions::LEAST_PIVOT;

/// Gauss-Jordan elimination with row pivoting on `m` rows of `m + k` numbers; the right-hand sides become
/// the solutions. An unknown that the others determine (two contacts between the same bodies) becomes zero
/// and uses no row.
pub(crate) fn solve_in_place(a: &mut [f64], m: usize, k: usize) {
    let width = m + k;
    let largest = (0..m * m).map(|i| a[i / m * width + i % m].abs()).fold(0.0, f64::max);
    // Rows in use, each for the first unknown that it determines.
    let mut used = 0;
    for col in 0..m {
        let size = |row: usize| a[row * width + col].abs();
        let pivot = (used..m).max_by(|&i, &j| size(i).total_cmp(&size(j)));
        // A NaN stays in the system and appears in the rates.
        let Some(pivot) = pivot.filter(|&row| size(row).is_nan() || size(row) > LEAST_PIVOT * largest) else {
            (used..m).for_each(|row| a[row * width + col] = 0.0);
            continue;
        };
        if pivot != used {
            (0..width).for_each(|j| a.swap(pivot * width + j, used * width + j));
        }
        let inverse = 1.0 / a[used * width + col];
        (0..width).for_each(|j| a[used * width + j] *= inverse);
        for row in (0..m).filter(|&r| r != used) {
            let factor = a[row * width + col];
            if factor != 0.0 {
                (0..width).for_each(|j| a[row * width + j] -= factor * a[used * width + j]);
                a[row * width + col] = 0.0;
            }
        }
        used += 1;
    }
    // From the last row up, each row moves to its unknown, which never precedes it.
    for col in (0..m).rev() {
        let about = |row: usize| a[row * width..][..col].iter().all(|v| *v == 0.0);
        if used > 0 && about(used - 1) {
            used -= 1;
            a.copy_within(used * width + m..(used + 1) * width, col * width + m);
        } else {
            a[col * width + m..(col + 1) * width].fill(0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// The solutions satisfy the equations, wherever the largest number of a column is.
    #[test]
    fn the_solutions_solve_the_system() {
        let a = [[0.0, 2.0, -1.0], [1e-3, 1.0, 4.0], [5.0, -3.0, 2.0]];
        let b = [[3.0, -1.0], [0.5, 2.0], [7.0, 0.0]];
        let mut system: Vec<f64> = (0..3).flat_map(|i| [&a[i][..], &b[i]].concat()).collect();
        solve_in_place(&mut system, 3, 2);
        for (row, due) in a.iter().zip(&b) {
            for (k, due) in due.iter().enumerate() {
                let found: f64 = (0..3).map(|j| row[j] * system[5 * j + 3 + k]).sum();
                assert_relative_eq!(found, *due, epsilon = 1e-12);
            }
        }
    }

    /// The second and the third unknown have the same equation: one gets the whole solution, the other
    /// zero, and a fourth one is not affected.
    #[test]
    fn what_the_others_decide_is_zero() {
        let rows = [
            [1.0, 0.0, 0.0, 0.0, 2.0],
            [0.0, 2.0, 2.0, 0.0, 6.0],
            [0.0, 1.0, 1.0, 0.0, 3.0],
            [0.0, 0.0, 0.0, 5.0, 20.0],
        ];
        for order in [[0, 1, 2, 3], [2, 0, 3, 1], [3, 2, 1, 0]] {
            let mut system: Vec<f64> = order.iter().flat_map(|&i| rows[i]).collect();
            solve_in_place(&mut system, 4, 1);
            assert_eq!([system[4], system[9], system[14], system[19]], [2.0, 3.0, 0.0, 4.0], "{order:?}");
        }
        // An unknown without any coefficient, before one that has some.
        let mut system = [0.0, 0.0, 5.0, 0.0, 4.0, 8.0];
        solve_in_place(&mut system, 2, 1);
        assert_eq!((system[2], system[5]), (0.0, 2.0));
        // A NaN is not hidden.
        let mut system = [f64::NAN, 0.0, 5.0, 0.0, 4.0, 8.0];
        solve_in_place(&mut system, 2, 1);
        assert!(system[2].is_nan());
    }
}
