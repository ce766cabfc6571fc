//! The quadratic model of a cost in the coefficients of the whole dictionary: what any choice of terms costs.

use crate::least_squares::Normal;
use crate::linear::solve_damped;
use faer::Mat;

/// `cost = c^T A c - 2 b^T c + rest` in the coefficients `c`.
pub(crate) struct Quadratic {
    matrix: Mat<f64>,
    right: Vec<f64>,
    rest: f64,
    bounds: Vec<(f64, f64)>,
}

impl Quadratic {
    /// Of normal equations at the coefficients `x`.
    pub(crate) fn new(normal: &Normal, x: &[f64], bounds: &[(f64, f64)]) -> Quadratic {
        let n = x.len();
        let along = |i: usize| (0..n).map(|j| normal.matrix[(i, j)] * x[j]).sum::<f64>();
        let right: Vec<f64> = (0..n).map(|i| along(i) - normal.gradient[i]).collect();
        let rest = normal.cost + (0..n).map(|i| x[i] * (right[i] - normal.gradient[i])).sum::<f64>();
        Quadratic { matrix: normal.matrix.clone(), right, rest, bounds: bounds[..n].to_vec() }
    }

    /// How many coefficients there are.
    pub(crate) fn len(&self) -> usize {
        self.right.len()
    }

    /// The least cost with these coefficients alone; infinite where they are not determined, or leave their bounds.
    pub(crate) fn least(&self, of: &[usize]) -> f64 {
        let matrix = Mat::from_fn(of.len(), of.len(), |i, j| self.matrix[(of[i], of[j])]);
        let right: Vec<f64> = of.iter().map(|&i| self.right[i]).collect();
        let Some(c) = solve_damped(&matrix, &right, 0.0) else { return f64::INFINITY };
        let within = of.iter().zip(&c).all(|(&i, c)| (self.bounds[i].0..=self.bounds[i].1).contains(c));
        let fall: f64 = c.iter().zip(&right).map(|(c, b)| c * b).sum();
        if within { self.rest - fall } else { f64::INFINITY }
    }
}
