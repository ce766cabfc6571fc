//! Derivatives of the trajectory by its start state and parameters: the variational equation over the
//! accepted steps, and the jump of its solution at each switch.
//!
//! Between events `dS/dt = (df/dx) S + df/dp` is advanced with the stages of the state's step, so that `S`
//! is the derivative of the computed trajectory. At an event on `w = 0` the event time moves by `dt =
//! -(dw/dx S + dw/dp) / (dw/dt)` and `S` jumps by `(f- - f+) dt` (saltation; Leine and Nijmeijer, Dynamics
//! and Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7). When a contact is released the rates
//! are continuous and `S` does not jump.

use crate::dopri::{A, C, Dense, STAGES, Step};
use crate::elimination::solve_in_place;
use crate::field::Field;
use phisindy_expr::wide;

/// The derivatives of all states. Columns are the start states, then the free parameters.
pub(crate) struct Sensitivity {
    n: usize,
    /// The parameters to differentiate by.
    pub(crate) free: Vec<usize>,
    /// Number of columns.
    pub(crate) m: usize,
    /// `S` at the present time, row-major n x m.
    pub(crate) s: Vec<f64>,
    start: Vec<f64>,
    stage: Vec<f64>,
    k: [Vec<f64>; STAGES],
    /// `S` within the last step, after [`Sensitivity::interpolate`].
    pub(crate) dense: Dense,
    /// Whether the last stage is the first stage of the next step.
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
            dense: Dense::default(),
            s,
            fresh: false,
            a: vec![0.0; n * n],
            b: vec![0.0; n * free.len()],
        }
    }

    /// Advances over an accepted step of the state.
    pub(crate) fn advance(&mut self, field: &mut Field<'_>, step: &Step) {
        let (n, m) = (self.n, self.m);
        self.start.copy_from_slice(&self.s);
        for stage in 0..STAGES {
            if stage == 0 && self.fresh {
                self.k.swap(0, STAGES - 1);
                continue;
            }
            self.linearise(field, step.t + C[stage] * step.h, &step.x[stage]);
            self.stage.copy_from_slice(&self.start);
            let (before, after) = self.k.split_at_mut(stage);
            wide(
                #[inline(always)]
                || {
                    for (a, k) in A[stage.max(1) - 1].iter().zip(&*before).filter(|(a, _)| **a != 0.0) {
                        self.stage.iter_mut().zip(k).for_each(|(s, k)| *s += step.h * a * k);
                    }
                    multiply_add(&self.a, &self.b, &self.stage, n, m, &mut after[0]);
                },
            );
        }
        // The last stage is at the end of the step: its argument is the solution.
        self.s.copy_from_slice(&self.stage);
        self.fresh = true;
    }

    /// `dS/dt` at the present point.
    pub(crate) fn slope(&mut self, field: &mut Field<'_>, t: f64, x: &[f64]) -> Vec<f64> {
        self.linearise(field, t, x);
        let mut out = vec![0.0; self.s.len()];
        multiply_add(&self.a, &self.b, &self.s, self.n, self.m, &mut out);
        out
    }

    /// Prepares the interpolation within the last step.
    pub(crate) fn interpolate(&mut self, h: f64) {
        self.dense.set(h, &self.start, &self.s, &self.k);
    }

    /// The derivatives of the time of an event on the surface of a switch, from the rate of `w` before it.
    pub(crate) fn time_of_event(&self, normal: &[f64], by_parameter: &[f64], w_rate: f64) -> Vec<f64> {
        let of = |j: usize| {
            let mut dw: f64 = (0..self.n).map(|i| normal[i] * self.s[i * self.m + j]).sum();
            if j >= self.n {
                dw += by_parameter[j - self.n];
            }
            -dw / w_rate
        };
        if w_rate == 0.0 { vec![0.0; self.m] } else { (0..self.m).map(of).collect() }
    }

    /// Applies the jump at an event that moves by `times`, from the rates before and after.
    pub(crate) fn jump(&mut self, times: &[f64], before: &[f64], after: &[f64]) {
        self.fresh = false;
        if before.iter().zip(after).all(|(b, a)| b == a) {
            return;
        }
        for (j, dt) in times.iter().enumerate() {
            (0..self.n).for_each(|i| self.s[i * self.m + j] += (before[i] - after[i]) * dt);
        }
    }

    /// The modes have changed without a jump of the rates.
    pub(crate) fn restart(&mut self) {
        self.fresh = false;
    }

    /// `dw_c/dp` for the free parameters.
    pub(crate) fn by_parameter(&self, field: &mut Field<'_>, c: usize, t: f64, x: &[f64]) -> Vec<f64> {
        let d = field.derivatives(t, x);
        self.free.iter().map(|&p| d.w_p(c, p)).collect()
    }

    /// `df/dx` and `df/dp` in the present modes. The modes of sticking contacts depend on the state: `ds =
    /// -M^-1 (d(dw/dt)/dx dx + d(dw/dt)/dp dp)`.
    fn linearise(&mut self, field: &mut Field<'_>, t: f64, x: &[f64]) {
        let (n, f) = (self.n, self.free.len());
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
            (0..n).for_each(|j| self.a[i * n + j] = d.rate_x(i, j));
            (0..f).for_each(|j| self.b[i * f + j] = d.rate_p(i, self.free[j]));
        }
        if set.is_empty() {
            return;
        }
        let (m, width) = (set.len(), set.len() + n + f);
        let mut y = Vec::with_capacity(m * width);
        for (row, &c) in influence.iter().zip(&set) {
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

/// `dS/dt = a S + b`, where `b` has no columns for the start states.
#[inline(always)]
fn multiply_add(a: &[f64], b: &[f64], s: &[f64], n: usize, m: usize, out: &mut [f64]) {
    for i in 0..n {
        let row = &mut out[i * m..(i + 1) * m];
        row[..n].fill(0.0);
        row[n..].copy_from_slice(&b[i * (m - n)..(i + 1) * (m - n)]);
        for (j, &a) in a[i * n..(i + 1) * n].iter().enumerate().filter(|(_, a)| **a != 0.0) {
            row.iter_mut().zip(&s[j * m..(j + 1) * m]).for_each(|(r, s)| *r += a * s);
        }
    }
}
