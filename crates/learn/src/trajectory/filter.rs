//! A Kalman filter along the located events of a run: what follows a plant on which unknown forces act.
//!
//! The model is `dx/dt = f(t, x) + sum_b e_b w_b(t)` with white forces of intensity `q_b` on the rate of each
//! state that is not driven by another one alone. Between two samples the filter advances by the derivatives of
//! the run, which know the jumps at events: `P <- Phi P Phi' + Q`. A contact that sticks holds its speed, and a
//! force below the holding force moves nothing. Readings are taken one by one, so every innovation is a number
//! with a variance of its own. Their likelihood is that of the records (F. C. Schweppe, IEEE Trans. Inf. Theory
//! 11 (1965) 61-70), and with the gains held fixed the innovations are residuals like those of a free run
//! (L. Ljung, System Identification, 2nd ed. 1999, ch. 7). Without forces the gains are zero: the free run.

use crate::trajectory::delayed_samples::Reading;
use crate::trajectory::problem::Problem;
use phisindy_phys::System;
use phisindy_sim::{Observer, Shown};

/// Gains by which a run follows a record, and the variances of its innovations.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gains {
    /// For each column, row-major samples x states; empty without a column.
    of: Vec<Vec<f64>>,
    /// For each column and sample.
    pub(crate) variance: Vec<Vec<f64>>,
}

impl Gains {
    /// How far a reading of a column moves each state, for each unit that it is missed by.
    pub(crate) fn at(&self, column: usize, sample: usize, n: usize) -> &[f64] {
        &self.of[column][sample * n..][..n]
    }
}

/// The states on whose rates forces act: all but those whose rate is another state.
pub(crate) fn driven(system: &System) -> Vec<usize> {
    (0..system.states.len()).filter(|&k| system.states[k].velocity.is_none()).collect()
}

/// States whose forces share an intensity, each with its part of it.
pub(crate) type Group = Vec<(usize, f64)>;

/// What the filter has seen between two readings, for other intensities and noises.
struct Interval {
    /// Derivatives of the states by those before, row-major.
    phi: Vec<f64>,
    /// For each group of forces, the covariance of what a unit of its intensity does, row-major.
    forces: Vec<Vec<f64>>,
    readings: Vec<Innovation>,
    /// The time, the states as predicted, and their rates.
    time: f64,
    states: Vec<f64>,
    rates: Vec<f64>,
}

/// A reading as the filter has seen it.
struct Innovation {
    column: usize,
    /// Derivatives of the reading by the states.
    slopes: Vec<f64>,
    /// What was read less what was predicted.
    miss: f64,
    /// Variance of the sensor's noise.
    noise: f64,
    gain: Vec<f64>,
    variance: f64,
}

/// The filter of one record.
pub(crate) struct Filter<'p> {
    problem: &'p Problem<'p>,
    record: usize,
    x: &'p [f64],
    /// Of each sample time, the readings that are due.
    due: Vec<Vec<Reading>>,
    times: Vec<f64>,
    /// Groups of forces: states and what of the intensity each takes.
    groups: &'p [Group],
    intensities: &'p [f64],
    noise: &'p dyn Fn(usize, f64) -> f64,
    covariance: Vec<f64>,
    before: f64,
    pub(crate) pass: Pass,
}

/// A pass of the filter along a record.
#[derive(Default)]
pub(crate) struct Pass {
    n: usize,
    columns: usize,
    intervals: Vec<Interval>,
    /// Twice the negative logarithm of the likelihood, but for a constant.
    pub(crate) unlikelihood: f64,
    pub(crate) readings: usize,
}

impl<'p> Filter<'p> {
    /// For a record of a problem at `x`; `noise` is the variance of a column's sensor at what it reads.
    pub(crate) fn new(
        problem: &'p Problem<'p>,
        record: usize,
        x: &'p [f64],
        (times, due): (Vec<f64>, Vec<Vec<Reading>>),
        (groups, intensities): (&'p [Group], &'p [f64]),
        noise: &'p dyn Fn(usize, f64) -> f64,
    ) -> Filter<'p> {
        let n = problem.system.states.len();
        let before = problem.records[record].time[0];
        let pass = Pass { n, columns: problem.system.columns(), ..Pass::default() };
        let covariance = vec![0.0; n * n];
        Filter { problem, record, x, due, times, groups, intensities, noise, covariance, before, pass }
    }

    /// What a unit of the intensity of each group does within `h` seconds: Simpson's rule over where the
    /// derivatives take a force at the begin, the middle and the end.
    fn forces(&self, phi: &[f64], h: f64, held: &[f64]) -> Vec<Vec<f64>> {
        let n = self.pass.n;
        let of_group = |group: &Group| {
            let mut q = vec![0.0; n * n];
            for &(b, part) in group {
                let begin: Vec<f64> = (0..n).map(|i| phi[i * n + b]).collect();
                let end: Vec<f64> = (0..n).map(|i| f64::from(u8::from(i == b))).collect();
                // Half of the way is the root of the derivatives: `sqrt(1 + D) = 1 + D/2 - D^2/8 + ...`
                let once: Vec<f64> = begin.iter().zip(&end).map(|(a, b)| a - b).collect();
                let twice: Vec<f64> = times(phi, &once, n).iter().zip(&once).map(|(a, b)| a - b).collect();
                let middle: Vec<f64> = (0..n).map(|i| end[i] + 0.5 * once[i] - 0.125 * twice[i]).collect();
                for (mut g, weight) in [(begin, 1.0), (middle, 4.0), (end, 1.0)] {
                    release(&mut g, held);
                    add_outer(&mut q, &g, &g, part * weight * h / 6.0);
                }
            }
            q
        };
        self.groups.iter().map(of_group).collect()
    }
}

impl Observer for Filter<'_> {
    fn correct(&mut self, sample: usize, shown: &Shown<'_>, x: &mut [f64], s: &mut [f64]) -> bool {
        let n = self.pass.n;
        let phi = s.to_vec();
        let h = (self.times[sample] - self.before).max(0.0);
        self.before = self.times[sample].max(self.before);
        let forces = self.forces(&phi, h, shown.held);
        self.covariance = advanced(&phi, &self.covariance, n);
        for (q, intensity) in forces.iter().zip(self.intensities) {
            self.covariance.iter_mut().zip(q).for_each(|(p, q)| *p += intensity * q);
        }
        s.fill(0.0);
        (0..n).for_each(|k| s[k * n + k] = 1.0);
        let shown_x = x.to_vec();
        let mut readings = Vec::with_capacity(self.due[sample].len());
        for Reading { column, sample: own } in self.due[sample].clone() {
            let (value, by_state) = shown_value(shown, column, x, &shown_x);
            let (predicted, gain) = self.problem.reading(self.record, column, self.x, value);
            let Some(read) = self.problem.records[self.record].columns[column].as_ref() else { continue };
            let slopes: Vec<f64> = by_state.iter().map(|c| gain * c).collect();
            let noise = (self.noise)(column, predicted);
            let (miss, innovation) = (read[own] - predicted, times(&self.covariance, &slopes, n));
            let variance = noise + dot(&slopes, &innovation);
            let gain: Vec<f64> = innovation.iter().map(|p| p / variance).collect();
            self.pass.unlikelihood += variance.ln() + miss * miss / variance;
            self.pass.readings += 1;
            x.iter_mut().zip(&gain).for_each(|(x, k)| *x += k * miss);
            add_outer(&mut self.covariance, &gain, &innovation, -1.0);
            readings.push(Innovation { column, slopes, miss, noise, gain, variance });
        }
        let (time, rates) = (self.times[sample], shown.rates[..n].to_vec());
        self.pass.intervals.push(Interval { phi, forces, readings, time, states: shown_x, rates });
        true
    }
}

/// What a column shows at states that readings before it have corrected, and its derivatives by the states.
pub(crate) fn shown_value(shown: &Shown<'_>, column: usize, x: &[f64], before: &[f64]) -> (f64, Vec<f64>) {
    let n = x.len();
    if column < n {
        return (x[column], (0..n).map(|k| f64::from(u8::from(k == column))).collect());
    }
    let by_state = shown.by_state[(column - n) * n..][..n].to_vec();
    let moved: f64 = by_state.iter().zip(x.iter().zip(before)).map(|(c, (x, b))| c * (x - b)).sum();
    (shown.values[column] + moved, by_state)
}

impl Pass {
    /// The gains of this pass, for a record with so many samples.
    pub(crate) fn gains(&self, due: &[Vec<Reading>], samples: usize) -> Gains {
        let mut gains = Gains { of: vec![vec![]; self.columns], variance: vec![vec![]; self.columns] };
        for (interval, due) in self.intervals.iter().zip(due) {
            for (reading, place) in interval.readings.iter().zip(due) {
                let (of, variance) = (&mut gains.of[reading.column], &mut gains.variance[reading.column]);
                of.resize(samples * self.n, 0.0);
                variance.resize(samples, f64::INFINITY);
                of[place.sample * self.n..][..self.n].copy_from_slice(&reading.gain);
                variance[place.sample] = reading.variance;
            }
        }
        gains
    }

    /// Twice the negative logarithm of the likelihood with other intensities, and with noises multiplied by
    /// `factors` (of the variance, by column): the filter for them, run along the same derivatives.
    pub(crate) fn unlikelihood_with(&self, intensities: &[f64], factors: &[f64]) -> f64 {
        let n = self.n;
        let (mut p, mut shift) = (vec![0.0; n * n], vec![0.0; n]);
        let (mut buffer, mut along) = (vec![0.0; n * n], vec![0.0; n]);
        let mut sum = 0.0;
        for Interval { phi, forces, readings, .. } in &self.intervals {
            advance(phi, &mut p, &mut buffer, n);
            for (q, intensity) in forces.iter().zip(intensities).filter(|(_, i)| **i > 0.0) {
                p.iter_mut().zip(q).for_each(|(p, q)| *p += intensity * q);
            }
            multiply(phi, &shift, &mut along, n);
            std::mem::swap(&mut shift, &mut along);
            for reading in readings {
                let factor = factors.get(reading.column).copied().unwrap_or(1.0);
                multiply(&p, &reading.slopes, &mut along, n);
                let variance = factor * reading.noise + dot(&reading.slopes, &along);
                let miss = reading.miss - dot(&reading.slopes, &shift);
                sum += variance.ln() + miss * miss / variance;
                for i in 0..n {
                    shift[i] += along[i] / variance * miss - reading.gain[i] * reading.miss;
                    (0..n).for_each(|j| p[i * n + j] -= along[i] * along[j] / variance);
                }
            }
        }
        sum
    }

    /// Times, a state as predicted, and its rate at each reading.
    pub(crate) fn along(&self, state: usize) -> impl Iterator<Item = (f64, f64, f64)> {
        self.intervals.iter().map(move |i| (i.time, i.states[state], i.rates[state]))
    }

    /// The smoothed force on each state before each reading, in the unit of its rate, with `intensities` as in the
    /// pass (A. E. Bryson and M. Frazier, Proc. Optimum System Synthesis Conference, 1963).
    pub(crate) fn smoothed_forces(&self, groups: &[Group], intensities: &[f64]) -> Vec<Vec<f64>> {
        let n = self.n;
        let mut lambda = vec![0.0; n];
        let mut out = vec![vec![0.0; self.intervals.len()]; n];
        for (i, interval) in self.intervals.iter().enumerate().rev() {
            for reading in interval.readings.iter().rev() {
                // lambda <- (I - K H)' lambda + H' e / s
                let along = dot(&reading.gain, &lambda);
                let by = reading.miss / reading.variance - along;
                lambda.iter_mut().zip(&reading.slopes).for_each(|(l, h)| *l += h * by);
            }
            for (group, intensity) in groups.iter().zip(intensities) {
                group.iter().for_each(|&(b, part)| out[b][i] = intensity * part * lambda[b]);
            }
            let before = lambda.clone();
            (0..n).for_each(|j| lambda[j] = (0..n).map(|k| interval.phi[k * n + j] * before[k]).sum());
        }
        out
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn multiply(matrix: &[f64], vector: &[f64], out: &mut [f64], n: usize) {
    out.iter_mut().zip(matrix.chunks_exact(n)).for_each(|(out, row)| *out = dot(row, vector));
}

fn times(matrix: &[f64], vector: &[f64], n: usize) -> Vec<f64> {
    let mut out = vec![0.0; n];
    multiply(matrix, vector, &mut out, n);
    out
}

fn add_outer(matrix: &mut [f64], a: &[f64], b: &[f64], factor: f64) {
    let n = a.len();
    for (row, a) in matrix.chunks_exact_mut(n).zip(a).filter(|(_, a)| **a != 0.0) {
        row.iter_mut().zip(b).for_each(|(m, b)| *m += factor * a * b);
    }
}

/// `Phi P Phi'`, in the place of `P`.
fn advance(phi: &[f64], p: &mut [f64], buffer: &mut [f64], n: usize) {
    for (out, row) in buffer.chunks_exact_mut(n).zip(phi.chunks_exact(n)) {
        out.fill(0.0);
        for (f, p) in row.iter().zip(p.chunks_exact(n)) {
            out.iter_mut().zip(p).for_each(|(o, p)| *o += f * p);
        }
    }
    for (out, row) in p.chunks_exact_mut(n).zip(buffer.chunks_exact(n)) {
        out.iter_mut().zip(phi.chunks_exact(n)).for_each(|(o, phi)| *o = dot(row, phi));
    }
}

fn advanced(phi: &[f64], p: &[f64], n: usize) -> Vec<f64> {
    let (mut out, mut buffer) = (p.to_vec(), vec![0.0; n * n]);
    advance(phi, &mut out, &mut buffer, n);
    out
}

/// Takes out of a direction what sticking contacts hold.
fn release(g: &mut [f64], held: &[f64]) {
    // Normals that are not orthogonal need a second turn.
    for normal in held.chunks_exact(g.len()).chain(held.chunks_exact(g.len())) {
        let length = dot(normal, normal);
        if length > 0.0 {
            let along = dot(normal, g) / length;
            g.iter_mut().zip(normal).for_each(|(g, n)| *g -= along * n);
        }
    }
}

#[cfg(test)]
mod tests;
