//! Some columns of the derivatives over a step. The columns do not depend on each other, so a few at a time
//! stay in the caches with all their stages, and several threads may take different ones.

use crate::decisions::UNRESOLVED;
use crate::dense::Dense;
use crate::dopri::{self, A, STAGES};
use crate::linearisation::Linearisation;
use crate::radau;
use crate::resets::Row;
use crate::step::Method;
use phisindy_expr::wide;

/// Rows are stored in whole vectors.
const VECTOR: usize = 8;
/// Columns that are advanced together at most: a hundred rows of them, with all stages, fit the second cache.
const MOST: usize = 32;

/// Columns `first`, `first + 1`, ... of `S`.
pub(crate) struct Columns {
    pub(crate) first: usize,
    count: usize,
    /// `count`, rounded up to whole vectors: what is beyond stays zero.
    width: usize,
    rows: usize,
    /// At the present time, row by row.
    s: Vec<f64>,
    start: Vec<f64>,
    stage: Vec<f64>,
    k: [Vec<f64>; STAGES],
    /// The largest size of each element so far.
    sizes: Vec<f64>,
    /// The largest size of an element of each column, in units of its state.
    reach: Vec<f64>,
    /// Rows that may differ from zero: nothing else has reached the others yet.
    live: Vec<bool>,
    /// Within the last step, after [`Columns::interpolate`].
    dense: Dense,
}

impl Columns {
    /// All `m` columns of `n` states, the first of which have a start, at the start: the unit matrix, then zeros.
    pub(crate) fn all((n, starts): (usize, usize), m: usize) -> Vec<Columns> {
        let vectors = m.div_ceil(VECTOR);
        let blocks = m.div_ceil(MOST);
        let edge = |b: usize| (b * vectors / blocks.max(1) * VECTOR).min(m);
        (0..blocks).map(|b| Columns::new((n, starts), edge(b), edge(b + 1))).collect()
    }

    fn new((n, starts): (usize, usize), first: usize, end: usize) -> Columns {
        let (count, width) = (end - first, (end - first).next_multiple_of(VECTOR));
        let mut s = vec![0.0; n * width];
        (first..end.min(starts)).for_each(|i| s[i * width + i - first] = 1.0);
        Columns {
            first,
            count,
            width,
            rows: n,
            start: s.clone(),
            stage: vec![0.0; n * width],
            k: std::array::from_fn(|_| vec![0.0; n * width]),
            sizes: s.clone(),
            reach: vec![0.0; width],
            s,
            live: (0..n).map(|i| i < starts && (first..end).contains(&i)).collect(),
            dense: Dense::default(),
        }
    }

    /// Row `i`.
    fn row(&self, i: usize) -> &[f64] {
        &self.s[i * self.width..][..self.count]
    }

    /// Advances with the stages of an explicit step, `lines` at each of them; `fresh` if the last stage of
    /// the step before is the first of this one. Returns whether the error is small; the accuracy is that of
    /// the states, and their sizes that matter.
    pub(crate) fn advance_explicit(
        &mut self,
        h: f64,
        lines: &[Linearisation],
        fresh: bool,
        accuracy: (f64, &[f64]),
    ) -> bool {
        wide(
            #[inline(always)]
            || {
                self.explicit(h, lines, fresh);
                self.is_resolved(h, accuracy)
            },
        )
    }

    #[inline(always)]
    fn explicit(&mut self, h: f64, lines: &[Linearisation], fresh: bool) {
        self.start.copy_from_slice(&self.s);
        if fresh {
            self.k.swap(0, STAGES - 1);
        } else {
            self.stage.copy_from_slice(&self.s);
            self.rates(&lines[0], 0);
        }
        for (at, line) in lines.iter().enumerate().skip(1) {
            match at {
                1 => self.combine(h, [0]),
                2 => self.combine(h, [0, 1]),
                3 => self.combine(h, [0, 1, 2]),
                4 => self.combine(h, [0, 1, 2, 3]),
                5 => self.combine(h, [0, 1, 2, 3, 4]),
                // The last stage is at the end of the step: its argument is the solution.
                _ => self.combine(h, [0, 2, 3, 4, 5]),
            }
            self.rates(line, at);
        }
        self.s.copy_from_slice(&self.stage);
    }

    /// The argument of a stage: the start and these rates before it.
    #[inline(always)]
    fn combine<const K: usize>(&mut self, h: f64, of: [usize; K]) {
        let (row, width) = (&A[of[K - 1]], self.width);
        for (i, _) in self.live.iter().enumerate().filter(|(_, live)| **live) {
            let at = i * width..(i + 1) * width;
            let mut rates: [(f64, &[[f64; VECTOR]]); K] = [(0.0, &[]); K];
            for (rates, &j) in rates.iter_mut().zip(&of) {
                *rates = (h * row[j], self.k[j][at.clone()].as_chunks::<VECTOR>().0);
            }
            let start = self.start[at.clone()].as_chunks::<VECTOR>().0;
            let out = self.stage[at].as_chunks_mut::<VECTOR>().0;
            for (v, (out, start)) in out.iter_mut().zip(start).enumerate() {
                let mut sum = *start;
                for (a, k) in &rates {
                    (0..VECTOR).for_each(|l| sum[l] += a * k[v][l]);
                }
                *out = sum;
            }
        }
    }

    /// The rates of stage `at`, `dS/dt = (df/dx) S + df/dp`. Rows that they reach are live from now on.
    #[inline(always)]
    fn rates(&mut self, line: &Linearisation, at: usize) {
        let Columns { first, count, width, live, stage, k, .. } = self;
        let width = *width;
        let mut reached = false;
        for i in 0..self.rows {
            let by_parameter =
                line.by_parameter(i).iter().filter(|(p, _)| (*first..*first + *count).contains(p));
            let entries = line.by_state(i);
            if !live[i] && by_parameter.clone().next().is_none() && !entries.iter().any(|(j, _)| live[*j]) {
                continue;
            }
            reached |= !live[i];
            let out = &mut k[at][i * width..(i + 1) * width];
            out.fill(0.0);
            by_parameter.for_each(|(p, value)| out[p - *first] = *value);
            for (v, out) in out.as_chunks_mut::<VECTOR>().0.iter_mut().enumerate() {
                let mut sum = *out;
                for &(j, a) in entries {
                    let s = &stage[j * width + v * VECTOR..][..VECTOR];
                    (0..VECTOR).for_each(|l| sum[l] += a * s[l]);
                }
                *out = sum;
            }
        }
        if reached {
            self.spread(line);
        }
    }

    /// Notes which rows the rates have reached. All were decided by those that were live before.
    fn spread(&mut self, line: &Linearisation) {
        let columns = self.first..self.first + self.count;
        let reached = |i: usize| {
            self.live[i]
                || line.by_parameter(i).iter().any(|(p, _)| columns.contains(p))
                || line.by_state(i).iter().any(|(j, _)| self.live[*j])
        };
        self.live = (0..self.rows).map(reached).collect();
    }

    /// Whether the error of the step is small beside each element, or no larger than what a step of the
    /// states may make: an element that the step has only just reached is nothing but error.
    #[inline(always)]
    fn is_resolved(&self, h: f64, (tolerance, scale): (f64, &[f64])) -> bool {
        let mut unresolved = [false; VECTOR];
        for v in 0..self.width / VECTOR {
            let vector = |of: &[f64], i: usize| -> [f64; VECTOR] {
                *of[i * self.width + v * VECTOR..].first_chunk().expect("a whole vector")
            };
            let live = || self.live.iter().enumerate().filter(|(_, live)| **live).map(|(i, _)| i);
            // The size of the column, in units of the states.
            let mut reach = vector(&self.reach, 0);
            for i in live() {
                let (end, part) = (vector(&self.s, i), 1.0 / scale[i]);
                (0..VECTOR).for_each(|l| reach[l] = reach[l].max(part * end[l].abs()));
            }
            for i in live() {
                let mut k = [[0.0; VECTOR]; STAGES];
                for (k, of) in k.iter_mut().zip(&self.k) {
                    *k = vector(of, i);
                }
                let error = dopri::error(h, &k);
                let (end, size) = (vector(&self.s, i), vector(&self.sizes, i));
                let allowed = tolerance * scale[i];
                for l in 0..VECTOR {
                    let least = (UNRESOLVED * end[l].abs().max(size[l])).max(allowed * reach[l]);
                    // What is not a number is not resolved.
                    unresolved[l] |= error[l].is_nan() | (error[l].abs() > least);
                }
            }
        }
        !unresolved.contains(&true)
    }

    /// Back to the start of the step just made.
    pub(crate) fn back(&mut self) {
        self.s.copy_from_slice(&self.start);
    }

    /// Notes the sizes at the end of a step; `scale` is the size of each state that matters.
    pub(crate) fn measure(&mut self, scale: &[f64]) {
        let Columns { s, sizes, reach, width, .. } = self;
        wide(
            #[inline(always)]
            || {
                let rows = sizes.chunks_exact_mut(*width).zip(s.chunks_exact(*width));
                for ((sizes, s), scale) in rows.zip(scale) {
                    let part = 1.0 / scale;
                    for ((size, s), reach) in sizes.iter_mut().zip(s).zip(&mut *reach) {
                        *size = size.max(s.abs());
                        *reach = reach.max(part * *size);
                    }
                }
            },
        );
    }

    /// The right-hand sides of the equations of an implicit step, `J_i S + (df/dp)_i`, row by row, stage by
    /// stage; then `solve` puts the solutions there. See [`crate::sensitivity`].
    pub(crate) fn advance_implicit(&mut self, lines: &[Linearisation], solve: impl Fn(&mut [f64], usize)) {
        const STAGES: usize = radau::STAGES;
        let width = self.width;
        self.start.copy_from_slice(&self.s);
        self.stage.copy_from_slice(&self.s);
        self.live.fill(true);
        let mut right = vec![0.0; STAGES * self.rows * width];
        for (stage, line) in lines.iter().enumerate() {
            self.rates(line, 0);
            for (i, row) in self.k[0].chunks_exact(width).enumerate() {
                right[(i * STAGES + stage) * width..][..width].copy_from_slice(row);
            }
        }
        solve(&mut right, width);
        for (i, rows) in right.chunks_exact(STAGES * width).enumerate() {
            let at = i * width..(i + 1) * width;
            for (stage, row) in rows.chunks_exact(width).enumerate() {
                let out = self.k[stage + 1][at.clone()].iter_mut();
                out.zip(&self.start[at.clone()]).zip(row).for_each(|((out, s), d)| *out = s + d);
            }
        }
        self.s.copy_from_slice(&self.k[STAGES]);
    }

    /// Prepares the interpolation within the last step, of length `h`.
    pub(crate) fn interpolate(&mut self, h: f64, method: Method) {
        match method {
            Method::Explicit => wide(
                #[inline(always)]
                || dopri::interpolate(&mut self.dense, h, &self.start, &self.s, &self.k),
            ),
            Method::Implicit => {
                // The first place holds a rate in explicit steps, and is the start here.
                self.k[0].copy_from_slice(&self.start);
                radau::interpolate(&mut self.dense, h, &self.k);
            }
        }
    }

    /// Writes the present values to their places in `out`, which has rows of `m` numbers.
    pub(crate) fn read(&self, m: usize, out: &mut [f64]) {
        for (i, row) in out.chunks_exact_mut(m).enumerate() {
            row[self.first..][..self.count].copy_from_slice(self.row(i));
        }
    }

    /// Takes the present values from their places in `from`.
    pub(crate) fn set(&mut self, m: usize, from: &[f64]) {
        for (i, row) in from.chunks_exact(m).enumerate() {
            let own = &row[self.first..][..self.count];
            self.s[i * self.width..][..self.count].copy_from_slice(own);
            self.live[i] |= own.iter().any(|s| *s != 0.0);
        }
    }

    /// Writes the values at the fraction `theta` of the step to their places in `out`, which has rows of `m`
    /// numbers.
    pub(crate) fn write(&self, theta: f64, m: usize, out: &mut [f64]) {
        wide(
            #[inline(always)]
            || {
                for (i, row) in out.chunks_exact_mut(m).enumerate() {
                    self.dense.values(theta, i * self.width, &mut row[self.first..][..self.count]);
                }
            },
        );
    }

    /// Writes the values a time `back` away, at the present rates.
    pub(crate) fn write_along(&mut self, line: &Linearisation, back: f64, m: usize, out: &mut [f64]) {
        self.stage.copy_from_slice(&self.s);
        self.rates(line, 1);
        for (i, row) in out.chunks_exact_mut(m).enumerate() {
            let slope = &self.k[1][i * self.width..][..self.count];
            let values = self.row(i).iter().zip(slope).map(|(s, f)| s + back * f);
            row[self.first..].iter_mut().zip(values).for_each(|(out, value)| *out = value);
        }
    }

    /// Adds `normal S` to `out`, which has a number for each column of `S`.
    pub(crate) fn add_along(&self, normal: &[f64], out: &mut [f64]) {
        for (i, weight) in normal.iter().enumerate().filter(|(_, w)| **w != 0.0) {
            out[self.first..].iter_mut().zip(self.row(i)).for_each(|(out, s)| *out += weight * s);
        }
    }

    /// Lets the rows of states that jump follow from those before, at a time that moves by `moves`.
    pub(crate) fn map(&mut self, rows: &[Row], moves: &[f64]) {
        let mut new = vec![0.0; rows.len() * self.width];
        for (row, out) in rows.iter().zip(new.chunks_exact_mut(self.width)) {
            for &(j, by) in &row.by_state {
                let s = &self.s[j * self.width..][..self.width];
                out.iter_mut().zip(s).for_each(|(out, s)| *out += by * s);
            }
            let own = |(column, _): &&(usize, f64)| (self.first..self.first + self.count).contains(column);
            row.by_column.iter().filter(own).for_each(|&(column, by)| out[column - self.first] += by);
            if !moves.is_empty() {
                let moves = &moves[self.first..][..self.count];
                out.iter_mut().zip(moves).for_each(|(out, dt)| *out += row.by_time * dt);
            }
        }
        for (row, new) in rows.iter().zip(new.chunks_exact(self.width)) {
            self.live[row.target] |= new.iter().any(|s| *s != 0.0);
            self.s[row.target * self.width..][..self.width].copy_from_slice(new);
        }
    }

    /// A state that nothing moves.
    pub(crate) fn rest(&mut self, i: usize) {
        self.s[i * self.width..][..self.count].fill(0.0);
    }

    /// Adds to each row its own number of `by` times those of all columns.
    pub(crate) fn jump(&mut self, by: &[f64], times: &[f64]) {
        for (i, by) in by.iter().enumerate().filter(|(_, by)| **by != 0.0) {
            self.live[i] = true;
            let row = self.s[i * self.width..][..self.count].iter_mut();
            row.zip(&times[self.first..]).for_each(|(s, dt)| *s += by * dt);
        }
    }
}
