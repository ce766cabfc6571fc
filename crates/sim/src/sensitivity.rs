//! Derivatives of the trajectory by its start state and parameters: the variational equation over the
//! accepted steps, and the jump of its solution at each switch.
//!
//! Between events `dS/dt = (df/dx) S + df/dp` is advanced with the stages of the state's step, so that `S`
//! is the derivative of the computed trajectory, also where the step is implicit; where the state rests in a
//! stiff mode `S` alone takes an implicit step. At an event on `w = 0` the event time moves by `dt =
//! -(dw/dx S + dw/dp) / (dw/dt)` and `S` jumps by `(f- - f+) dt` (saltation; Leine and Nijmeijer, Dynamics
//! and Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7). When a contact is released the rates
//! are continuous and `S` does not jump.

use crate::columns::Columns;
use crate::dopri::{C, STAGES};
use crate::factors::Factors;
use crate::field::Field;
use crate::linearisation::{Free, LANES, Linearisation};
use crate::radau;
use crate::resets::Row;
use crate::step::{Method, Step};
use rayon::prelude::*;

/// The derivatives of all states. Columns are the start states, then the free parameters.
pub(crate) struct Sensitivity {
    n: usize,
    /// How many states have a start that is a number of its own: those that hold something follow them.
    starts: usize,
    /// The parameters to differentiate by.
    pub(crate) free: Vec<usize>,
    places: Free,
    /// Number of columns.
    pub(crate) m: usize,
    /// `S`, a few columns at a time.
    columns: Vec<Columns>,
    /// The error that a step of the states may make, as a part of their sizes.
    tolerance: f64,
    scale: Vec<f64>,
    /// Whether the last stage is the first stage of the next step.
    fresh: bool,
    /// How the last step of `S` was made.
    method: Method,
    /// The rates to first order at the stages.
    lines: Vec<Linearisation>,
    /// Memory of an implicit step: `df/dx` at its stages, and their equations.
    slopes: [Vec<f64>; radau::STAGES],
    equations: Option<Factors>,
}

impl Sensitivity {
    /// By the start of the first `starts` states, of all whose sizes that matter are `scale`, by the parameters `free` of all
    /// `parameters`, and by `spare` numbers that only an observer knows.
    pub(crate) fn new(
        (scale, starts): (&[f64], usize),
        tolerance: f64,
        parameters: usize,
        free: &[usize],
        spare: usize,
    ) -> Self {
        let (n, m) = (scale.len(), starts + free.len() + spare);
        Sensitivity {
            n,
            starts,
            free: free.to_vec(),
            places: Free::new(parameters, free, n - starts),
            m,
            columns: Columns::all((n, starts), m),
            tolerance,
            scale: scale.to_vec(),
            fresh: false,
            method: Method::Explicit,
            lines: vec![Linearisation::default(); LANES],
            slopes: Default::default(),
            equations: None,
        }
    }

    /// Does `work` for all columns, on several threads where there is much of it.
    fn for_all(columns: &mut [Columns], work: impl Fn(&mut Columns) + Sync + Send) {
        match columns {
            [few] => work(few),
            many => many.par_iter_mut().for_each(work),
        }
    }

    /// Advances over an accepted step of the state. A mode in which the state rests to the last digit does
    /// not limit its steps, however stiff it is; `S` does not rest there, and explicit stages beyond their
    /// domain of stability would let it grow without bound. Such a step of `S` is implicit, along the
    /// interpolant of the state.
    pub(crate) fn advance(&mut self, field: &mut Field<'_>, step: &mut Step) {
        self.method = step.method();
        match self.method {
            Method::Explicit => {
                if !self.advance_explicit(field, step) {
                    self.columns.iter_mut().for_each(Columns::back);
                    self.method = Method::Implicit;
                    let dense = step.dense();
                    let n = self.n;
                    let mut x = vec![0.0; radau::STAGES * n];
                    for (stage, x) in x.chunks_exact_mut(n).enumerate() {
                        dense.value(radau::C[stage + 1], x);
                    }
                    self.advance_implicit(field, (step.t, step.h), |stage| &x[stage * n..][..n]);
                }
            }
            Method::Implicit => {
                self.advance_implicit(field, (step.t, step.h), |stage| &step.x[stage + 1]);
            }
        }
        let scale = &self.scale;
        Self::for_all(&mut self.columns, |columns| columns.measure(scale));
    }

    /// Returns whether the error is small beside each element of `S`.
    fn advance_explicit(&mut self, field: &mut Field<'_>, step: &Step) -> bool {
        let fresh = std::mem::replace(&mut self.fresh, true);
        let known = usize::from(fresh);
        let mut points: [(f64, &[f64]); STAGES] = [(0.0, &[]); STAGES];
        for (stage, point) in points.iter_mut().enumerate() {
            *point = (step.t + C[stage] * step.h, &step.x[stage]);
        }
        let lines = &mut self.lines[..STAGES];
        field.linearise(&mut lines[known..], &self.places, &points[known..]);
        let (lines, h, accuracy) = (&*lines, step.h, (self.tolerance, &self.scale[..]));
        match &mut self.columns[..] {
            [few] => few.advance_explicit(h, lines, fresh, accuracy),
            many => {
                let all =
                    many.par_iter_mut().map(|columns| columns.advance_explicit(h, lines, fresh, accuracy));
                all.reduce(|| true, |a, b| a & b)
            }
        }
    }

    /// The stages of an implicit step from `t`, of length `h`, are what solves its equations, so their
    /// derivatives `S + D` follow from those of the equations at the solution:
    /// `sum_j W_ij D_j / h - J_i D_i = J_i S + (df/dp)_i`. `x` is the state at a stage.
    fn advance_implicit<'x>(
        &mut self,
        field: &mut Field<'_>,
        (t, h): (f64, f64),
        x: impl Fn(usize) -> &'x [f64],
    ) {
        const STAGES: usize = radau::STAGES;
        let n = self.n;
        let points: [(f64, &[f64]); STAGES] =
            std::array::from_fn(|stage| (t + radau::C[stage + 1] * h, x(stage)));
        let lines = &mut self.lines[..STAGES];
        field.linearise(lines, &self.places, &points);
        for (slope, line) in self.slopes.iter_mut().zip(&*lines) {
            slope.resize(n * n, 0.0);
            line.write_by_state(slope);
        }
        let equations = self.equations.get_or_insert_with(|| Factors::new(STAGES * n));
        radau::matrix(h, n, |stage| &self.slopes[stage], &mut equations.a);
        // Newton's method has solved nearly the same equations: they have a solution.
        equations.factor();
        let (lines, equations) = (&*lines, &*equations);
        let work = |columns: &mut Columns| columns.advance_implicit(lines, |b, k| equations.solve(b, k));
        Self::for_all(&mut self.columns, work);
        self.fresh = false;
    }

    /// The present values, row-major states x columns.
    pub(crate) fn read(&self, out: &mut [f64]) {
        self.columns.iter().for_each(|columns| columns.read(self.m, out));
    }

    /// Goes on from other values.
    pub(crate) fn set(&mut self, from: &[f64]) {
        self.fresh = false;
        self.columns.iter_mut().for_each(|columns| columns.set(self.m, from));
    }

    /// Prepares the interpolation within the last step.
    pub(crate) fn interpolate(&mut self, step: &Step) {
        let (h, method) = (step.h, self.method);
        Self::for_all(&mut self.columns, |columns| columns.interpolate(h, method));
    }

    /// Writes the values at the fraction `theta` of the last step, after [`Sensitivity::interpolate`].
    pub(crate) fn sample(&self, theta: f64, out: &mut Vec<f64>) {
        out.resize(self.n * self.m, 0.0);
        self.columns.iter().for_each(|columns| columns.write(theta, self.m, out));
    }

    /// Writes the values a time `back` away from the present point, at the present rates.
    pub(crate) fn sample_along(
        &mut self,
        field: &mut Field<'_>,
        t: f64,
        x: &[f64],
        back: f64,
        out: &mut Vec<f64>,
    ) {
        out.resize(self.n * self.m, 0.0);
        field.linearise(&mut self.lines[..1], &self.places, &[(t, x)]);
        for columns in &mut self.columns {
            columns.write_along(&self.lines[0], back, self.m, out);
        }
    }

    /// The derivatives of the time of an event on the surface of a switch, from the rate of `w` before it.
    pub(crate) fn time_of_event(&self, normal: &[f64], by_parameter: &[f64], w_rate: f64) -> Vec<f64> {
        let mut moves = vec![0.0; self.m];
        if w_rate != 0.0 {
            self.columns.iter().for_each(|columns| columns.add_along(normal, &mut moves));
            moves[self.starts..].iter_mut().zip(by_parameter).for_each(|(dw, by)| *dw += by);
            moves.iter_mut().for_each(|dw| *dw = -*dw / w_rate);
        }
        moves
    }

    /// Applies the jump at an event that moves by `times`, from the rates before and after.
    pub(crate) fn jump(&mut self, times: &[f64], before: &[f64], after: &[f64]) {
        self.fresh = false;
        let by: Vec<f64> = before.iter().zip(after).map(|(b, a)| b - a).collect();
        self.columns.iter_mut().for_each(|columns| columns.jump(&by, times));
    }

    /// A state that nothing moves: what rounding leaves of its derivatives is none.
    pub(crate) fn rest(&mut self, state: usize) {
        self.columns.iter_mut().for_each(|columns| columns.rest(state));
    }

    /// The column of a parameter, if it is free.
    pub(crate) fn column(&self, parameter: usize) -> Option<usize> {
        self.places.place(parameter).map(|place| self.starts + place)
    }

    /// The column of the free parameter at a place.
    pub(crate) fn column_of_free(&self, place: usize) -> usize {
        self.starts + place
    }

    /// Lets states jump at a time that moves by `moves`: see [`crate::resets`]. `before` are the rates before; where the
    /// time moves [`Sensitivity::jump`] takes off those after.
    pub(crate) fn map(&mut self, rows: &[Row], moves: &[f64], before: &[f64]) {
        self.fresh = false;
        for columns in &mut self.columns {
            if !moves.is_empty() {
                columns.jump(before, moves);
            }
            columns.map(rows, moves);
        }
    }

    /// The modes have changed without a jump of the rates.
    pub(crate) fn restart(&mut self) {
        self.fresh = false;
    }

    /// `dw_c/dp` for the free parameters.
    pub(crate) fn by_parameter(&self, field: &mut Field<'_>, c: usize, t: f64, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.free.len()];
        let of = &field.automaton.jacobian.surfaces_by_parameter;
        if of.row(c).next().is_some() {
            let slopes = field.jacobian_at(t, x);
            for (p, k) in of.row(c) {
                if let Some(place) = self.places.place(p) {
                    out[place] = slopes.output(k)[0];
                }
            }
        }
        out
    }
}
