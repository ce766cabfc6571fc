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

    /// The least cost with these coefficients alone; infinite where they are not determined, or leave their
    /// bounds.
    pub(crate) fn least(&self, of: &[usize]) -> f64 {
        let matrix = Mat::from_fn(of.len(), of.len(), |i, j| self.matrix[(of[i], of[j])]);
        let right: Vec<f64> = of.iter().map(|&i| self.right[i]).collect();
        let Some(c) = solve_damped(&matrix, &right, 0.0) else { return f64::INFINITY };
        let within = of.iter().zip(&c).all(|(&i, c)| (self.bounds[i].0..=self.bounds[i].1).contains(c));
        let fall: f64 = c.iter().zip(&right).map(|(c, b)| c * b).sum();
        if within { self.rest - fall } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::symmetric;
    use approx::assert_relative_eq;

    /// `(a + b - 3)^2 + (b - 1)^2 + 4` at `a = b = 0`: 4 with both, 4 + 1 with the first alone, 4 + 2 with
    /// the second.
    #[test]
    fn the_least_cost_of_each_choice_of_coefficients() {
        let normal =
            Normal { cost: 14.0, matrix: symmetric(&[1.0, 1.0, 2.0], 2), gradient: vec![-3.0, -4.0] };
        let free = [(f64::NEG_INFINITY, f64::INFINITY); 2];
        let model = Quadratic::new(&normal, &[0.0, 0.0], &free);
        for (of, due) in [(&[0, 1][..], 4.0), (&[0], 5.0), (&[1], 6.0), (&[], 14.0)] {
            assert_relative_eq!(model.least(of), due, max_relative = 1e-12);
        }
        // From anywhere else it is the same function: at a = 1, b = 2 the cost is 5.
        let normal = Normal { cost: 5.0, gradient: vec![0.0, 1.0], ..normal };
        let elsewhere = Quadratic::new(&normal, &[1.0, 2.0], &free);
        assert_relative_eq!(elsewhere.least(&[1]), 6.0, max_relative = 1e-12);
        // What would leave its bounds is no choice: a alone wants 3.
        let held = Quadratic::new(&normal, &[1.0, 2.0], &[(-1.0, 2.5), free[1]]);
        assert_eq!(held.least(&[0]), f64::INFINITY);
    }
}
