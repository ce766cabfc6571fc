//! A small regression.

/// Coefficients and residual sum of squares, by the normal equations of the scaled columns; `None` if they
/// are dependent.
pub(super) fn least_squares(columns: &[Vec<f64>], target: &[f64]) -> Option<(Vec<f64>, f64)> {
    let m = columns.len();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let sizes: Vec<f64> = columns.iter().map(|c| dot(c, c).sqrt()).collect();
    if target.len() < 4 * m || sizes.iter().any(|s| *s == 0.0 || !s.is_finite()) {
        return None;
    }
    let mut matrix: Vec<Vec<f64>> = (0..m)
        .map(|i| {
            let row = (0..m).map(|j| dot(&columns[i], &columns[j]) / (sizes[i] * sizes[j]));
            row.chain([dot(&columns[i], target) / sizes[i]]).collect()
        })
        .collect();
    for k in 0..m {
        let pivot = (k..m).max_by(|&a, &b| matrix[a][k].abs().total_cmp(&matrix[b][k].abs()))?;
        matrix.swap(k, pivot);
        if matrix[k][k].abs() < 1e-12 {
            return None;
        }
        let above = matrix[k].clone();
        for (_, row) in matrix.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = row[k] / above[k];
            row.iter_mut().zip(&above).for_each(|(x, a)| *x -= factor * a);
        }
    }
    let coefficients: Vec<f64> = (0..m).map(|k| matrix[k][m] / matrix[k][k] / sizes[k]).collect();
    let left = (0..target.len())
        .map(|r| (target[r] - columns.iter().zip(&coefficients).map(|(c, x)| c[r] * x).sum::<f64>()).powi(2))
        .sum();
    Some((coefficients, left))
}
