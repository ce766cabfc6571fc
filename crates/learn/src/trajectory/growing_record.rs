//! A horizon that grows, for records of which no state is measured.
//!
//! Short segments need start states, and an accelerometer tells none: over a segment without an event a
//! constant force and a spring's force by the displacement at its start are the same. The whole record has
//! side minima, with a stop too many or too few. So the first part of the record is fitted, then a longer one
//! from where that ended: its few events find their times before later ones depend on them.

use crate::decisions::{FIRST_PARTS, GROWTH, ROUGH_MINIMUM, START_GAIN};
use crate::least_squares::Limits;
use crate::trajectory::fit::{Context, Fit};
use crate::trajectory::kalman_smoother::reads_outputs;
use crate::trajectory::problem::Problem;
use phisindy_phys::Record;
use phisindy_phys::spec::SegmentsSpec;

impl<'a> Context<'a> {
    /// Whether no state is measured, and outputs are.
    pub(crate) fn is_blind(&self) -> bool {
        let measured = |r: &&Record| r.columns[..self.system.states.len()].iter().any(Option::is_some);
        let outputs = self.records.iter().any(|r| reads_outputs(self.system, r));
        outputs && !self.records.iter().any(measured) && self.segments == SegmentsSpec::Auto
    }

    /// A better fit of the same terms, if one is found from the first parts of the records; `None` where
    /// states are measured, or nothing but noise is left.
    pub(crate) fn grown(&self, fit: &Fit<'a>, coefficients: &[f64]) -> Option<Fit<'a>> {
        if !self.is_blind() || fit.is_white() {
            return None;
        }
        let (_, problem, x) = self.along_parts(&fit.problem.terms, coefficients, &GROWTH)?;
        let noise = problem.first_noise();
        let found = self.settle(problem, x, noise, 3)?;
        (self.misfit(&found)? < (1.0 - START_GAIN) * self.misfit(fit)?).then_some(found)
    }

    /// What terms leave of the first part of the records after a fit, where no state is measured: the root of
    /// the cost.
    pub(crate) fn misfit_of_first_part(&self, terms: &[usize], coefficients: &[f64]) -> Option<f64> {
        if !self.is_blind() {
            return None;
        }
        self.along_parts(terms, coefficients, &GROWTH[..FIRST_PARTS]).map(|(cost, ..)| cost.sqrt())
    }

    /// Cost, problem and unknowns of a fit that goes along these parts of the records, from start states as
    /// they were estimated or at rest, whichever ends better.
    fn along_parts(
        &self,
        terms: &[usize],
        coefficients: &[f64],
        parts: &[usize],
    ) -> Option<(f64, Problem<'a>, Vec<f64>)> {
        let single = vec![1; self.records.len()];
        let mut problem = self.cut(terms, &single)?;
        let weights = problem.weights(&problem.first_noise(), None);
        let whole: Vec<(usize, usize)> = problem.segments.iter().map(|s| s.samples).collect();
        let estimated = problem.guess(coefficients, None, &self.smooth);
        let mut at_rest = estimated.clone();
        for segment in &problem.segments {
            for (k, stated) in self.records[segment.record].start.iter().enumerate() {
                at_rest[segment.start + k] = stated.unwrap_or(0.0);
            }
        }
        let mut best: Option<(f64, Vec<f64>)> = None;
        let starts = if at_rest == estimated { vec![estimated] } else { vec![estimated, at_rest] };
        for mut x in starts {
            let mut cost = f64::INFINITY;
            for part in parts {
                for (segment, (first, last)) in problem.segments.iter_mut().zip(&whole) {
                    segment.samples.1 = first + (last - first) / part;
                }
                let end = problem.minimise_from_means(&mut x, &weights, Limits::of(ROUGH_MINIMUM));
                cost = end.map_or(f64::INFINITY, |end| end.cost);
            }
            if best.as_ref().map_or(f64::INFINITY, |(least, _)| *least) > cost {
                best = Some((cost, x));
            }
        }
        problem.segments.iter_mut().zip(whole).for_each(|(segment, samples)| segment.samples = samples);
        let (cost, x) = best?;
        Some((cost, problem, x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::onestep::tests::common;

    /// A rubbing oscillator that an accelerometer sees: from a start far away a fit of the whole record ends
    /// with other stops than the record has.
    #[test]
    fn parts_of_a_record_lead_out_of_a_side_minimum() {
        let text = r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2"), "A": (1.0, "m/s^2"), "W": (0.7, "rad/s") },
            known: { "x": "v", "v": "-k*x + A*cos(W*t)" }, contacts: ["v"],
            unknown: { "v": (factor: "-sgn(v)", candidates: ["1", "|v|"]) }, outputs: { "a": (unit: "m/s^2", reads: "rate(v)") },
            data: [ Synthetic(truth: { "v": "-0.3*sgn(v)" }, start: { "x": 2.5, "v": 0.0 }, duration: 40.0, step: 0.02, measure: ["a"], noise: Additive(0.01), seed: 1) ])"#;
        let (case, records) = common::load_text(text, &[]);
        let context = Context {
            system: &case.system,
            records: records.iter().collect(),
            smooth: records.clone(),
            segments: SegmentsSpec::Auto,
            stop: Default::default(),
        };
        let problem = Problem::new(&case.system, &[0], &context.records, &[1]).expect("a problem");
        let noise = problem.first_noise();
        let stuck = context.settle(problem, vec![0.9, 0.0, -1.0], noise, 3).expect("a fit");
        assert!(!stuck.is_white() && (stuck.x[0] - 0.3).abs() > 0.1, "{:?}", stuck.x);
        let found = context.grown(&stuck, &[0.5]).expect("a better fit");
        assert!(found.is_white() && (found.x[0] - 0.3).abs() < 2e-3, "{:?}", found.x);
        // Nothing is better than noise, and where a state is measured, it starts the fit.
        assert!(context.grown(&found, &[0.5]).is_none());
        let [record] = &records[..] else { panic!("one record") };
        let seen = Record {
            columns: record.columns.iter().map(|_| Some(vec![0.0; record.len()])).collect(),
            ..record.clone()
        };
        let with_states = Context { records: vec![&seen], smooth: vec![seen.clone()], ..context };
        assert!(with_states.grown(&stuck, &[0.5]).is_none());
    }
}
