//! The rates to first order at a point: `df/dx` and `df/dp` in the present modes.

use crate::elimination::solve_in_place;
use crate::field::Field;

/// `df/dx` (n x n) and `df/dp` (n x free parameters), row-major.
#[derive(Default)]
pub(crate) struct Linearisation {
    pub(crate) by_state: Vec<f64>,
    pub(crate) by_parameter: Vec<f64>,
}

impl Linearisation {
    /// Evaluates both at a point. The modes of sticking contacts depend on the state: `ds = -M^-1 (d(dw/dt)/dx dx
    /// + d(dw/dt)/dp dp)`.
    pub(crate) fn evaluate(&mut self, field: &mut Field<'_>, free: &[usize], t: f64, x: &[f64]) {
        let (n, f) = (x.len(), free.len());
        let (a, b) = (&mut self.by_state, &mut self.by_parameter);
        a.resize(n * n, 0.0);
        b.resize(n * f, 0.0);
        let set: Vec<usize> = (0..field.switches()).filter(|&c| field.stuck[c]).collect();
        let mut influence = Vec::new();
        if !set.is_empty() {
            field.solve_stuck_modes(t, x);
            influence = set
                .iter()
                .map(|&c| set.iter().map(|&k| field.influence(c, k)).collect::<Vec<f64>>())
                .collect();
        }
        let d = field.derivatives(t, x);
        for i in 0..n {
            (0..n).for_each(|j| a[i * n + j] = d.rate_x(i, j));
            (0..f).for_each(|j| b[i * f + j] = d.rate_p(i, free[j]));
        }
        if set.is_empty() {
            return;
        }
        let (m, width) = (set.len(), set.len() + n + f);
        let mut y = Vec::with_capacity(m * width);
        for (row, &c) in influence.iter().zip(&set) {
            y.extend(row);
            y.extend((0..n).map(|j| d.w_rate_x(c, j)));
            y.extend(free.iter().map(|&p| d.w_rate_p(c, p)));
        }
        solve_in_place(&mut y, m, n + f);
        for (r, &c) in set.iter().enumerate() {
            let y = &y[r * width + m..(r + 1) * width];
            for i in 0..n {
                let by_mode = d.rate_s(i, c);
                if by_mode != 0.0 {
                    (0..n).for_each(|j| a[i * n + j] -= by_mode * y[j]);
                    (0..f).for_each(|j| b[i * f + j] -= by_mode * y[n + j]);
                }
            }
        }
    }
}
