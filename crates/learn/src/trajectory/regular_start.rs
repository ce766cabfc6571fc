//! Start states from which a fit can move. At some the rates have no finite slopes: `sqrt(|h|)` has none at zero, where a
//! state without a column would start. From others a body breaks away that rests.

use crate::decisions::HOP_GAIN;
use crate::trajectory::jacobian::{Jacobian, Singular};
use crate::trajectory::layout::Segment;
use crate::trajectory::problem::Problem;
use phisindy_phys::Record;
use rayon::prelude::*;

impl Problem<'_> {
    /// Moves start states to where the rates have finite slopes: a measured state to its next sample where
    /// they have, any other one to the size of the measured states that have its unit.
    pub(crate) fn leave_singularities(&self, x: &mut [f64], filled: &[Record]) {
        let n = self.system.states.len();
        // Elementary functions that a model is made of are singular at zero.
        let zero = |x: &[f64]| self.segments.iter().any(|s| x[s.start..s.start + n].contains(&0.0));
        let Some(slopes) = zero(x).then(|| Jacobian::new(self)).flatten() else { return };
        for segment in &self.segments {
            let record = &filled[segment.record];
            let numbers = self.model_parameters(segment.record, x);
            let first = segment.samples.0;
            let own = segment.start..segment.start + n;
            for k in slopes.singular_states(record, first, &x[own.clone()], &numbers) {
                let samples = record.columns[k].iter().flat_map(|c| &c[first..segment.samples.1]).copied();
                for value in samples.chain([self.size_of(k)]) {
                    x[segment.start + k] = value;
                    let left = slopes.singular_states(record, first, &x[own.clone()], &numbers);
                    if !left.contains(&k) {
                        break;
                    }
                }
            }
        }
    }

    /// Starts segments with a contact at rest where they then miss clearly less. The speed of a body at rest is known with an
    /// error, and from a wrong speed it would break away.
    pub(crate) fn start_at_rest(&self, x: &mut [f64]) {
        for contact in self.breaking_away() {
            self.start_better(x, |segment, x| {
                let (speed, rest) = self.at_rest(segment, x, contact);
                (speed != 0.0).then_some(rest)
            });
        }
    }

    /// Starts segments from the smoothed motion, moving or at rest, where they then miss clearly less. Returns whether any do.
    pub(crate) fn start_anew(&self, x: &mut [f64], filled: &[Record]) -> bool {
        if self.breaking_away().next().is_none() {
            return false;
        }
        let mut fresh = x.to_vec();
        self.start_from(&mut fresh, filled);
        let n = self.system.states.len();
        self.start_better(x, |segment, _| Some(fresh[segment.start..segment.start + n].to_vec()))
    }

    /// Starts segments from another state where they then miss clearly less. Returns whether any do.
    fn start_better(
        &self,
        x: &mut [f64],
        other: impl Fn(&Segment, &[f64]) -> Option<Vec<f64>> + Sync,
    ) -> bool {
        let (n, weights) = (self.system.states.len(), self.weights(&self.first_noise(), None));
        let better = |segment: &Segment| {
            let start = other(segment, x)?;
            let mut trial = x.to_vec();
            trial[segment.start..segment.start + n].copy_from_slice(&start);
            let [now, then] = [&*x, &trial].map(|x| self.cost_along(segment, x, &weights, 1));
            (then.ok()? < HOP_GAIN * now.unwrap_or(f64::INFINITY)).then_some((segment.start, start))
        };
        let better: Vec<(usize, Vec<f64>)> = self.segments.par_iter().filter_map(better).collect();
        better.iter().for_each(|(at, start)| x[*at..at + n].copy_from_slice(start));
        !better.is_empty()
    }

    /// Ends a step of a fit where the speed of a contact would change its sign. A contact at rest stays at rest: when it lets
    /// go, the cost jumps.
    pub(crate) fn stop_at_rest(&self, from: &[f64], to: &mut [f64]) {
        let n = self.system.states.len();
        for contact in self.breaking_away() {
            for segment in &self.segments {
                let (before, _) = self.at_rest(segment, from, contact);
                let (after, rest) = self.at_rest(segment, to, contact);
                if before == 0.0 || before * after < 0.0 {
                    to[segment.start..segment.start + n].copy_from_slice(&rest);
                }
            }
        }
    }

    /// The contacts that can stick, of a model with static friction above kinetic friction.
    fn breaking_away(&self) -> impl Iterator<Item = usize> + use<'_> {
        let all = self.automaton.switches.iter().enumerate().filter(|_| self.automaton.breaks_away);
        all.filter(|(_, switch)| switch.can_stick).map(|(contact, _)| contact)
    }

    /// The size of a state: of measured ones with its unit the mean magnitude.
    fn size_of(&self, state: usize) -> f64 {
        let unit = &self.system.states[state].unit;
        let alike = (0..self.system.states.len()).filter(|&k| self.system.states[k].unit == *unit);
        let columns = alike.flat_map(|k| self.records.iter().filter_map(move |r| r.columns[k].as_ref()));
        let sizes = columns.map(|c| c.iter().map(|v| v.abs()).sum::<f64>() / c.len().max(1) as f64);
        let largest = sizes.fold(0.0, f64::max);
        if largest > 0.0 { largest } else { self.scale[state] }
    }

    /// Where the rates have no finite slope at the start of a segment.
    pub(crate) fn singularity(&self, x: &[f64]) -> Option<Singular> {
        let n = self.system.states.len();
        let at = |segment: &Segment| {
            let (record, first) = (self.records[segment.record], segment.samples.0);
            let (states, numbers) =
                (&x[segment.start..segment.start + n], self.model_parameters(segment.record, x));
            let slopes = Jacobian::new(self)?;
            let singular = !slopes.singular_states(record, first, states, &numbers).is_empty();
            singular.then(|| slopes.singular(record, first, states, &numbers)).flatten()
        };
        self.segments.iter().find_map(at)
    }
}
