//! How the trajectory changes with its start state and parameters: the variational equation along the accepted steps, and the jump of its
//! solution at each switch.
//!
//! Between events `dS/dt = (df/dx) S + df/dp` is advanced by the very stages of the state's step, so that `S` is the derivative of the computed
//! trajectory. At an event on `w = 0` the event time moves by `dt = -(dw/dx S + dw/dp) / (dw/dt)` and `S` jumps by `(f- - f+) dt` (saltation; Leine and
//! Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7). When a contact lets go the rates are continuous and nothing jumps.

use crate::dopri::{A, STAGES, Step, dense};
use crate::field::{Field, solve_in_place};

/// The derivatives of all states: columns are the start states, then the free parameters.
pub(crate) struct Sensitivity {
    n: usize,
    free: Vec<usize>,
    /// Number of columns.
    pub(crate) m: usize,
    /// `S` at the present time, row-major n x m.
    pub(crate) s: Vec<f64>,
    start: Vec<f64>,
    stage: Vec<f64>,
    k: [Vec<f64>; STAGES],
    /// Whether `k[0]` is already that of the next step.
    fresh: bool,
    a: Vec<f64>,
    b: Vec<f64>,
}

impl Sensitivity {
    pub(crate) fn new(n: usize, free: &[usize]) -> Self {
        let m = n + free.len();
        let mut s = vec![0.0; n * m];
        (0..n).for_each(|i| s[i * m + i] = 1.0);
        Sensitivity {
            n,
            free: free.to_vec(),
            m,
            start: s.clone(),
            stage: s.clone(),
            k: std::array::from_fn(|_| vec![0.0; n * m]),
            s,
            fresh: false,
            a: vec![0.0; n * n],
            b: vec![0.0; n * free.len()],
        }
    }

    /// Follows an accepted step of the state.
    pub(crate) fn advance(&mut self, field: &mut Field<'_>, step: &Step) {
        let (n, m) = (self.n, self.m);
        self.start.copy_from_slice(&self.s);
        for stage in 0..STAGES {
            if stage == 0 && self.fresh {
                self.k.swap(0, STAGES - 1);
                continue;
            }
            self.stage.copy_from_slice(&self.start);
            for j in 0..stage {
                let weight = step.h * A[stage - 1][j];
                if weight != 0.0 {
                    self.stage.iter_mut().zip(&self.k[j]).for_each(|(s, k)| *s += weight * k);
                }
            }
            self.linearise(field, step.t + crate::dopri::C[stage] * step.h, &step.x[stage]);
            for i in 0..n {
                let row = &mut self.k[stage][i * m..(i + 1) * m];
                row.fill(0.0);
                row[n..].copy_from_slice(&self.b[i * (m - n)..(i + 1) * (m - n)]);
                for j in 0..n {
                    let a = self.a[i * n + j];
                    if a != 0.0 {
                        row.iter_mut().zip(&self.stage[j * m..(j + 1) * m]).for_each(|(r, s)| *r += a * s);
                    }
                }
            }
        }
        // The last stage stands at the end of the step: its argument is the solution.
        self.s.copy_from_slice(&self.stage);
        self.fresh = true;
    }

    /// `S` at a fraction of the step just followed.
    pub(crate) fn dense(&self, theta: f64, h: f64, out: &mut [f64]) {
        let k: [&[f64]; STAGES] = std::array::from_fn(|j| self.k[j].as_slice());
        dense(theta, h, &self.start, &self.s, &k, out);
    }

    /// The jump at a switch on its surface: rates before and after, and the rate of `w` before.
    pub(crate) fn jump(&mut self, normal: &[f64], by_parameter: &[f64], w_rate: f64, before: &[f64], after: &[f64]) {
        self.fresh = false;
        if w_rate == 0.0 || before.iter().zip(after).all(|(b, a)| b == a) {
            return;
        }
        for j in 0..self.m {
            let mut dw: f64 = (0..self.n).map(|i| normal[i] * self.s[i * self.m + j]).sum();
            if j >= self.n {
                dw += by_parameter[j - self.n];
            }
            let dt = -dw / w_rate;
            (0..self.n).for_each(|i| self.s[i * self.m + j] += (before[i] - after[i]) * dt);
        }
    }

    /// The modes changed without a jump of the rates.
    pub(crate) fn restart(&mut self) {
        self.fresh = false;
    }

    /// `dw_c/dp` for the free parameters.
    pub(crate) fn by_parameter(&self, field: &mut Field<'_>, c: usize, t: f64, x: &[f64]) -> Vec<f64> {
        let d = field.derivatives(t, x);
        self.free.iter().map(|&p| d.w_p(c, p)).collect()
    }

    /// `df/dx` and `df/dp` in the present modes; where contacts stick, with the held modes following:
    /// `ds = -M^-1 (d(dw/dt)/dx dx + d(dw/dt)/dp dp)`.
    fn linearise(&mut self, field: &mut Field<'_>, t: f64, x: &[f64]) {
        let (n, f) = (self.n, self.free.len());
        let set: Vec<usize> = (0..field.switches()).filter(|&c| field.stuck[c]).collect();
        let mut held = Vec::new();
        if !set.is_empty() {
            field.hold(t, x);
            held = set.iter().map(|&c| set.iter().map(|&k| field.influence(c, k)).collect::<Vec<f64>>()).collect();
        }
        let d = field.derivatives(t, x);
        for i in 0..n {
            (0..n).for_each(|j| self.a[i * n + j] = d.rate_x(i, j));
            (0..f).for_each(|j| self.b[i * f + j] = d.rate_p(i, self.free[j]));
        }
        if set.is_empty() {
            return;
        }
        let (m, width) = (set.len(), set.len() + n + f);
        let mut y = Vec::with_capacity(m * width);
        for (row, &c) in held.iter().zip(&set) {
            y.extend(row);
            y.extend((0..n).map(|j| d.w_rate_x(c, j)));
            y.extend(self.free.iter().map(|&p| d.w_rate_p(c, p)));
        }
        solve_in_place(&mut y, m, n + f);
        for (r, &c) in set.iter().enumerate() {
            let y = &y[r * width + m..(r + 1) * width];
            for i in 0..n {
                let by_mode = d.rate_s(i, c);
                if by_mode != 0.0 {
                    (0..n).for_each(|j| self.a[i * n + j] -= by_mode * y[j]);
                    (0..f).for_each(|j| self.b[i * f + j] -= by_mode * y[n + j]);
                }
            }
        }
    }
}
