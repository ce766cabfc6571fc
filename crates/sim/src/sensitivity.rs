//! Derivatives of the trajectory by its start state and parameters: the variational equation over the
//! accepted steps, and the jump of its solution at each switch.
//!
//! Between events `dS/dt = (df/dx) S + df/dp` is advanced with the stages of the state's step, so that `S`
//! is the derivative of the computed trajectory, also where the step is implicit; where the state rests in a stiff mode
//! `S` alone takes an implicit step. At an event on `w = 0` the event time moves by `dt =
//! -(dw/dx S + dw/dp) / (dw/dt)` and `S` jumps by `(f- - f+) dt` (saltation; Leine and Nijmeijer, Dynamics
//! and Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7). When a contact is released the rates
//! are continuous and `S` does not jump.

use crate::decisions::UNRESOLVED;
use crate::dense::Dense;
use crate::dopri::{self, A, C, STAGES};
use crate::factors::Factors;
use crate::field::Field;
use crate::linearisation::Linearisation;
use crate::radau;
use crate::step::{Method, Step};
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
    /// How the last step of `S` was made.
    method: Method,
    /// The largest size of each element of `S` so far.
    sizes: Vec<f64>,
    linear: Linearisation,
    /// Memory of an implicit step: `df/dx` at its stages, their equations, and the right-hand sides.
    slopes: [Vec<f64>; radau::STAGES],
    equations: Option<Factors>,
    right: Vec<f64>,
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
            sizes: s.clone(),
            s,
            fresh: false,
            method: Method::Explicit,
            linear: Linearisation::default(),
            slopes: Default::default(),
            equations: None,
            right: vec![],
        }
    }

    /// Advances over an accepted step of the state. A mode in which the state rests to the last digit does not limit
    /// its steps, however stiff it is; `S` does not rest there, and explicit stages beyond their domain of stability
    /// would let it grow without bound. Such a step of `S` is implicit, along the interpolant of the state.
    pub(crate) fn advance(&mut self, field: &mut Field<'_>, step: &mut Step) {
        self.method = step.method();
        match self.method {
            Method::Explicit => {
                self.advance_explicit(field, step);
                if !self.is_resolved(step.h) {
                    self.s.copy_from_slice(&self.start);
                    self.method = Method::Implicit;
                    let dense = step.dense().clone();
                    let (t, h) = (step.t, step.h);
                    let mut x = step.x[0].clone();
                    self.advance_implicit(field, h, |linear, field, free, at| {
                        dense.value(radau::C[at], &mut x);
                        linear.evaluate(field, free, t + radau::C[at] * h, &x);
                    });
                }
            }
            Method::Implicit => self.advance_implicit(field, step.h, |linear, field, free, at| {
                linear.evaluate(field, free, step.t + radau::C[at] * step.h, &step.x[at]);
            }),
        }
        self.sizes.iter_mut().zip(&self.s).for_each(|(size, s)| *size = size.max(s.abs()));
    }

    /// Whether the error of an explicit step is small beside each element of `S`.
    fn is_resolved(&self, h: f64) -> bool {
        let small = |(i, (end, size)): (usize, (&f64, &f64))| {
            let error = dopri::error(h, &self.k, i);
            error.abs() <= UNRESOLVED * end.abs().max(*size)
        };
        self.s.iter().zip(&self.sizes).enumerate().all(small)
    }

    fn advance_explicit(&mut self, field: &mut Field<'_>, step: &Step) {
        let (n, m) = (self.n, self.m);
        self.start.copy_from_slice(&self.s);
        for stage in 0..STAGES {
            if stage == 0 && self.fresh {
                self.k.swap(0, STAGES - 1);
                continue;
            }
            self.linear.evaluate(field, &self.free, step.t + C[stage] * step.h, &step.x[stage]);
            self.stage.copy_from_slice(&self.start);
            let (before, after) = self.k.split_at_mut(stage);
            wide(
                #[inline(always)]
                || {
                    for (a, k) in A[stage.max(1) - 1].iter().zip(&*before).filter(|(a, _)| **a != 0.0) {
                        self.stage.iter_mut().zip(k).for_each(|(s, k)| *s += step.h * a * k);
                    }
                    multiply_add(&self.linear, &self.stage, n, m, &mut after[0]);
                },
            );
        }
        // The last stage is at the end of the step: its argument is the solution.
        self.s.copy_from_slice(&self.stage);
        self.fresh = true;
    }

    /// `dS/dt` at the present point.
    pub(crate) fn slope(&mut self, field: &mut Field<'_>, t: f64, x: &[f64]) -> Vec<f64> {
        self.linear.evaluate(field, &self.free, t, x);
        let mut out = vec![0.0; self.s.len()];
        multiply_add(&self.linear, &self.s, self.n, self.m, &mut out);
        out
    }

    /// The stages of an implicit step are what solves its equations, so their derivatives `S + D` follow from
    /// those of the equations at the solution: `sum_j W_ij D_j / h - J_i D_i = J_i S + (df/dp)_i`.
    /// `at` evaluates the linearisation at a stage.
    fn advance_implicit(
        &mut self,
        field: &mut Field<'_>,
        h: f64,
        mut at: impl FnMut(&mut Linearisation, &mut Field<'_>, &[usize], usize),
    ) {
        const STAGES: usize = radau::STAGES;
        let (n, m) = (self.n, self.m);
        self.start.copy_from_slice(&self.s);
        self.right.resize(STAGES * n * m, 0.0);
        for stage in 0..STAGES {
            at(&mut self.linear, field, &self.free, stage + 1);
            self.slopes[stage].clone_from(&self.linear.by_state);
            multiply_add(&self.linear, &self.start, n, m, &mut self.stage);
            for (i, row) in self.stage.chunks_exact(m).enumerate() {
                self.right[(i * STAGES + stage) * m..][..m].copy_from_slice(row);
            }
        }
        let equations = self.equations.get_or_insert_with(|| Factors::new(STAGES * n));
        radau::matrix(h, n, |stage| &self.slopes[stage], &mut equations.a);
        // Newton's method has solved nearly the same equations: they have a solution.
        equations.factor();
        equations.solve(&mut self.right, m);
        for (i, rows) in self.right.chunks_exact(STAGES * m).enumerate() {
            for (stage, row) in rows.chunks_exact(m).enumerate() {
                let start = &self.start[i * m..(i + 1) * m];
                let out = &mut self.k[stage + 1][i * m..(i + 1) * m];
                out.iter_mut().zip(start).zip(row).for_each(|((out, s), d)| *out = s + d);
            }
        }
        self.s.copy_from_slice(&self.k[STAGES]);
        self.fresh = false;
    }

    /// Prepares the interpolation within the last step.
    pub(crate) fn interpolate(&mut self, step: &Step) {
        match self.method {
            Method::Explicit => dopri::interpolate(&mut self.dense, step.h, &self.start, &self.s, &self.k),
            Method::Implicit => {
                // The first place holds a rate in explicit steps, and is the start here.
                self.k[0].copy_from_slice(&self.start);
                radau::interpolate(&mut self.dense, step.h, &self.k);
            }
        }
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
}

/// `dS/dt = (df/dx) S + df/dp`, where `df/dp` has no columns for the start states.
#[inline(always)]
fn multiply_add(linear: &Linearisation, s: &[f64], n: usize, m: usize, out: &mut [f64]) {
    let Linearisation { by_state: a, by_parameter: b } = linear;
    for i in 0..n {
        let row = &mut out[i * m..(i + 1) * m];
        row[..n].fill(0.0);
        row[n..].copy_from_slice(&b[i * (m - n)..(i + 1) * (m - n)]);
        for (j, &a) in a[i * n..(i + 1) * n].iter().enumerate().filter(|(_, a)| **a != 0.0) {
            row.iter_mut().zip(&s[j * m..(j + 1) * m]).for_each(|(r, s)| *r += a * s);
        }
    }
}
