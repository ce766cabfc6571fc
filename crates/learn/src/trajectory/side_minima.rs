//! Side minima beside a minimum, of fits to outputs that jump.
//!
//! Where an event passes a sample, the sample changes sides, and the cost has a step or a kink. A minimum may
//! lie between two of these, a few standard errors from a lower one. A profile over a coefficient, as
//! intervals need it, walks over them: so each coefficient is moved to both ends of its interval and beyond,
//! the others follow, and all are fitted from there.

use crate::decisions::{BLURRED, FINE_MINIMUM, HALF_WIDTH_95, LIKELIHOOD_GAIN, SIDE_REACH, SIDE_ROUNDS};
use crate::least_squares::Limits;
use crate::trajectory::error_bars::ErrorBars;
use crate::trajectory::fit::{Context, Fit};
use crate::trajectory::kalman_smoother::reads_outputs;
use crate::trajectory::profile::followed;
use rayon::prelude::*;

impl<'a> Context<'a> {
    /// The lowest of the minima near a fit in single runs with events: beside each coefficient of outputs that
    /// jump, of states beside those that are hardly known.
    pub(crate) fn past_side_minima(&self, mut fit: Fit<'a>) -> Fit<'a> {
        if fit.most_pieces() > 1 || fit.problem.terms.is_empty() {
            return fit;
        }
        let Ok(runs) = fit.problem.runs(&fit.x) else { return fit };
        let jumps = runs.iter().any(|r| !r.run.jumps.is_empty());
        let jumps = jumps && self.records.iter().any(|r| reads_outputs(self.system, r));
        if runs.iter().all(|r| r.run.events.is_empty() && r.run.hits.is_empty()) {
            return fit;
        }
        for _ in 0..SIDE_ROUNDS {
            let bars = ErrorBars::new(&fit);
            let blurred = |k: &usize| jumps || fit.blurs(&bars, *k);
            let within = |k: usize, z: f64| z.clamp(fit.problem.bounds[k].0, fit.problem.bounds[k].1);
            let end = |k: usize, reach: f64| within(k, fit.x[k] + reach * HALF_WIDTH_95 * bars.error(k));
            let ends: Vec<(usize, f64)> = (0..fit.problem.terms.len())
                .filter(blurred)
                .flat_map(|k| SIDE_REACH.map(|reach| (k, end(k, reach))))
                .filter(|(k, z)| z.is_finite() && *z != fit.x[*k])
                .collect();
            let lower = |&(k, z): &(usize, f64)| {
                let mut x = followed(&fit, k, z);
                let end = fit.problem.minimise(&mut x, &fit.weights, Limits::of(FINE_MINIMUM)).ok()?;
                Some((end.cost, x))
            };
            let found: Vec<Option<(f64, Vec<f64>)>> = ends.par_iter().map(lower).collect();
            let best = found.into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
            match best.filter(|(cost, _)| *cost < fit.normal.cost - LIKELIHOOD_GAIN) {
                Some((_, x)) => fit = self.resettle(Fit { x, ..fit }),
                None => break,
            }
        }
        fit
    }
}

impl Fit<'_> {
    /// Whether a coefficient is hardly known.
    fn blurs(&self, bars: &ErrorBars<'_>, k: usize) -> bool {
        bars.error(k) > BLURRED * self.x[k].abs()
    }

    /// Whether one of its coefficients is.
    pub(crate) fn is_blurred(&self) -> bool {
        let bars = ErrorBars::new(self);
        (0..self.problem.terms.len()).any(|k| self.blurs(&bars, k))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::onestep::tests::common;
    use crate::trajectory::noise::ColumnNoise;
    use crate::trajectory::problem::Problem;
    use phisindy_phys::spec::SegmentsSpec;

    /// Case 2b of the paper as an accelerometer sees it: of this seed a fit ends six standard errors from the
    /// truth, in a minimum that has a lower one beside it.
    #[test]
    fn a_lower_minimum_nearby_is_found() {
        let text = r#"(constants: { "d": (0.1, "1/s"), "k": (1.0, "1/s^2"), "A": (1.0, "m/s^2"), "W": (0.15, "rad/s"), "V": (0.003, "m/s"), "c": 0.022, "eps": (1e-6, "m/s") }, states: { "x": "m", "y": "m/s" },
            known: { "x": "y", "y": "-d*y - k*x + A*cos(W*t)" }, contacts: ["y"],
            unknown: { "y": (factor: "-sgn(y)", candidates: ["1", "ln((|y|+eps)/V)", "ln(c+V/(|y|+eps))"]) },
            outputs: { "a": (unit: "m/s^2", reads: "rate(y)") },
            data: [ Synthetic(truth: { "y": "-(0.5 + 0.07*ln((|y|+eps)/V) + 0.09*ln(c+V/(|y|+eps)))*sgn(y)" },
                start: { "x": 0.1, "y": 0.1 }, duration: 50.0, step: 0.01, measure: ["a"], noise: Relative(0.02), seed: 3020) ])"#;
        let (case, records) = common::load_text(text, &[]);
        let context = Context {
            system: &case.system,
            records: records.iter().collect(),
            smooth: records.clone(),
            segments: SegmentsSpec::Auto,
            stop: Default::default(),
        };
        let problem = Problem::new(&case.system, &[0, 1, 2], &context.records, &[1]).expect("a problem");
        let noise = vec![vec![ColumnNoise { additive: 1e-6, relative: 0.02 }; 3]];
        let mut x = vec![0.50006, 0.0698915, 0.0898836, 0.1001, 0.099997];
        let weights = problem.weights(&noise, None);
        let normal = problem.minimise(&mut x, &weights, Limits::of(FINE_MINIMUM)).expect("a minimum");
        let (side, pieces) = (normal.cost, vec![1]);
        let fit = Fit {
            problem,
            x,
            noise,
            weights: weights.clone(),
            normal,
            samples: 5000,
            effective: 5000.0,
            excess: 1.0,
            pieces,
            force: None,
        };
        let before = fit.x[0];
        let found = context.past_side_minima(fit);
        let gain = side - found.problem.cost(&found.x, &weights).expect("a cost");
        assert!(gain > 1.0, "{gain} {before} {:?}", found.x);
    }
}
