//! Start states from which a fit can move. At some the rates have no finite slopes: `sqrt(|h|)` has none at zero, where a
//! state without a column would start. From others a body breaks away that rests in truth.

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

    /// Lets a contact rest at the start of a segment where the run then misses clearly less. Friction that holds more than it
    /// rubs makes a body at rest, whose speed is known with an error, break away.
    pub(crate) fn stand_still(&self, x: &mut [f64]) {
        let n = self.system.states.len();
        for contact in self.breaking_away() {
            let better = |segment: &Segment| {
                let (speed, rest) = self.at_rest(segment, x, contact);
                if speed == 0.0 {
                    return None;
                }
                let mut still = x.to_vec();
                still[segment.start..segment.start + n].copy_from_slice(&rest);
                let most = HOP_GAIN * self.misfit_along(segment, x).unwrap_or(f64::INFINITY);
                (self.misfit_along(segment, &still)? < most).then_some((segment.start, rest))
            };
            let all: Vec<_> = self.segments.par_iter().filter_map(better).collect();
            all.into_iter().for_each(|(start, rest)| x[start..start + n].copy_from_slice(&rest));
        }
    }

    /// Starts each segment from the smoothed motion, at rest or not, where it then misses less; returns whether any does.
    pub(crate) fn start_nearer(&self, x: &mut [f64], filled: &[Record]) -> bool {
        if self.breaking_away().next().is_none() {
            return false;
        }
        let n = self.system.states.len();
        let mut fresh = x.to_vec();
        self.start_on(&mut fresh, filled);
        let better = |segment: &&Segment| {
            let [now, then] = [&*x, &fresh].map(|x| self.misfit_along(segment, x).unwrap_or(f64::INFINITY));
            then < HOP_GAIN * now
        };
        let all: Vec<&Segment> = self.segments.par_iter().filter(better).collect();
        all.iter().for_each(|s| x[s.start..s.start + n].copy_from_slice(&fresh[s.start..s.start + n]));
        !all.is_empty()
    }

    /// Lets a step from one point to another end where a contact that would turn comes to rest, and leaves at rest what is:
    /// beyond, a body breaks away that was held, and the cost jumps.
    pub(crate) fn stop_at_rest(&self, from: &[f64], to: &mut [f64]) {
        let n = self.system.states.len();
        for contact in self.breaking_away() {
            for segment in &self.segments {
                let (before, (after, rest)) =
                    (self.at_rest(segment, from, contact).0, self.at_rest(segment, to, contact));
                if before == 0.0 || before * after < 0.0 {
                    to[segment.start..segment.start + n].copy_from_slice(&rest);
                }
            }
        }
    }

    /// The contacts that can stick, of a model in which some hold more than they rub.
    fn breaking_away(&self) -> impl Iterator<Item = usize> + use<'_> {
        let all = self.automaton.switches.iter().enumerate().filter(|_| self.automaton.breaks_away);
        all.filter(|(_, switch)| switch.can_stick).map(|(contact, _)| contact)
    }

    /// The sum of squares of what a run along a segment misses, in units of the columns.
    fn misfit_along(&self, segment: &Segment, x: &[f64]) -> Option<f64> {
        let run = self.run(segment, x, false).ok()?;
        let (r, columns) = (segment.record, &self.records[segment.record].columns);
        let mut sum = 0.0;
        for (k, column) in columns.iter().enumerate() {
            let Some(column) = column else { continue };
            let size = self.deviations[r][k].max(f64::MIN_POSITIVE);
            for (i, sample) in (segment.samples.0..segment.samples.1).enumerate() {
                if self.tells(r, k, sample) {
                    sum += ((self.reading(r, k, x, run.value(i, k).0).0 - column[sample]) / size).powi(2);
                }
            }
        }
        Some(sum)
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
