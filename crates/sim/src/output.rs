//! What a run shows beside its states: the outputs of the model at a sample, their rates, and their
//! derivatives by the start and the free parameters.
//!
//! An output `y(t, x, u, p, s)` may hold rates of states, so it jumps where friction does. The modes `s` of
//! sticking contacts follow from `dw/dt = 0`: a change of anything else by `d` changes them by `ds = -M^-1
//! d(dw/dt)`, which is how the holding force enters.

use crate::elimination::solve_in_place;
use crate::field::Field;
use crate::state::Run;

impl Run<'_> {
    /// Writes the outputs behind the states of the sample just written, `back` seconds away from the point
    /// `(t, x)` along the present rates.
    pub(crate) fn sample_outputs(&mut self, t: f64, x: &[f64], rates: &[f64], back: f64) {
        if self.field.automaton.outputs == 0 {
            return;
        }
        let m = self.out.m;
        let set = self.field.evaluate_outputs(t, x);
        let slopes = self.field.output_rates(&set, rates);
        let count = self.field.automaton.outputs;
        for (k, slope) in slopes.iter().enumerate() {
            self.out.states.push(self.field.output_at(k) + back * slope);
        }
        self.out.rates.extend(&slopes);
        let Some(sensitivity) = &self.sensitivity else { return };
        let s = &self.sampled;
        let (own, free) = (self.own, sensitivity.free.len());
        let by = self.field.output_derivatives(&set, x.len(), &sensitivity.free);
        let width = x.len() + sensitivity.free.len();
        self.by_state.clear();
        for k in 0..count {
            // Of a model without states and free parameters it is empty.
            let row = &by[k * width..(k + 1) * width];
            self.by_state.extend(&row[..own]);
            let at = self.out.sensitivities.len();
            self.out.sensitivities.resize(at + m, 0.0);
            let out = &mut self.out.sensitivities[at..];
            out[own..own + free].copy_from_slice(&row[x.len()..]);
            for (a, s) in row[..x.len()].iter().zip(s.chunks(m.max(1))).filter(|(a, _)| **a != 0.0) {
                out.iter_mut().zip(s).for_each(|(o, s)| *o += a * s);
            }
        }
    }
}

impl Field<'_> {
    /// The rates of change of the outputs along `rates`, after [`Field::evaluate_outputs`] with these
    /// contacts at rest.
    fn output_rates(&self, set: &[usize], rates: &[f64]) -> Vec<f64> {
        let along =
            |row: &dyn Fn(usize) -> f64| -> f64 { rates.iter().enumerate().map(|(j, f)| row(j) * f).sum() };
        let right = |f: &Field<'_>, c: usize| vec![f.rate_by_time(c) + along(&|j| f.rate_by_state(c, j))];
        let moved = self.mode_changes(set, 1, right);
        let slope = |k: usize| {
            let modes: f64 = set.iter().zip(&moved).map(|(&c, d)| self.output_by_mode(k, c) * d[0]).sum();
            self.output_by_time(k) + along(&|j| self.output_by_state(k, j)) + modes
        };
        (0..self.automaton.outputs).map(slope).collect()
    }

    /// Derivatives of the outputs by the `n` states, then by the parameters `free`, row-major, after
    /// [`Field::evaluate_outputs`].
    fn output_derivatives(&self, set: &[usize], n: usize, free: &[usize]) -> Vec<f64> {
        let right = |f: &Field<'_>, c: usize| -> Vec<f64> {
            let states = (0..n).map(|j| f.rate_by_state(c, j));
            states.chain(free.iter().map(|&p| f.rate_by_parameter(c, p))).collect()
        };
        let moved = self.mode_changes(set, n + free.len(), right);
        let mut out = Vec::with_capacity(self.automaton.outputs * (n + free.len()));
        for k in 0..self.automaton.outputs {
            let first = out.len();
            out.extend((0..n).map(|j| self.output_by_state(k, j)));
            out.extend(free.iter().map(|&p| self.output_by_parameter(k, p)));
            for (&c, d) in set.iter().zip(&moved) {
                let by_mode = self.output_by_mode(k, c);
                if by_mode != 0.0 {
                    out[first..].iter_mut().zip(d).for_each(|(o, d)| *o += by_mode * d);
                }
            }
        }
        out
    }

    /// Of a contact that sticks, how its mode changes with time along `rates`, with each state and with each of the parameters
    /// `free`.
    pub(crate) fn mode_derivatives(
        &mut self,
        c: usize,
        (t, x): (f64, &[f64]),
        rates: &[f64],
        free: &[usize],
    ) -> Vec<f64> {
        let set = self.evaluate_outputs(t, x);
        let right = |f: &Field<'_>, c: usize| -> Vec<f64> {
            let states: Vec<f64> = (0..x.len()).map(|j| f.rate_by_state(c, j)).collect();
            let along: f64 = states.iter().zip(rates).map(|(a, rate)| a * rate).sum();
            let parameters = free.iter().map(|&p| f.rate_by_parameter(c, p));
            [f.rate_by_time(c) + along].into_iter().chain(states).chain(parameters).collect()
        };
        let changes = self.mode_changes(&set, 1 + x.len() + free.len(), right);
        set.into_iter().zip(changes).find(|(k, _)| *k == c).map_or(vec![], |(_, changes)| changes)
    }

    /// How the modes of the sticking contacts `set` change when their `dw/dt` change by `right`.
    fn mode_changes(
        &self,
        set: &[usize],
        width: usize,
        right: impl Fn(&Field<'_>, usize) -> Vec<f64>,
    ) -> Vec<Vec<f64>> {
        let m = set.len();
        if m == 0 {
            return vec![];
        }
        let mut system = Vec::with_capacity(m * (m + width));
        for &c in set {
            system.extend(set.iter().map(|&k| self.influence(c, k)));
            system.extend(right(self, c));
        }
        solve_in_place(&mut system, m, width);
        system.chunks(m + width).map(|row| row[m..].iter().map(|d| -d).collect()).collect()
    }
}
