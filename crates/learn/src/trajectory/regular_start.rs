//! Start states at which the rates have finite slopes. `sqrt(|h|)` has none at zero, where a state without a
//! column would start: no sensitivity is finite then, and a fit cannot move.

use crate::trajectory::jacobian::{Jacobian, Singular};
use crate::trajectory::layout::Segment;
use crate::trajectory::problem::Problem;
use phisindy_phys::Record;

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
