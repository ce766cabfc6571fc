//! How much each term contributes along the fitted trajectory.

use crate::trajectory::fit::Fit;
use phisindy_expr::{Scratch, Tape};

/// Root mean square of `coefficient * value` of each term along the fitted trajectories; `None` if they
/// cannot be simulated.
pub(crate) fn term_sizes(fit: &Fit<'_>) -> Option<Vec<f64>> {
    let problem = &fit.problem;
    let system = problem.system;
    let outputs: Vec<_> = problem.terms.iter().map(|&t| system.terms[t].value).collect();
    let tape = Tape::compile(&system.graph, &system.arguments(), &outputs).ok()?;
    let mut scratch = Scratch::<1>::new(&tape);
    let (mut sums, mut count) = (vec![0.0; outputs.len()], 0usize);
    // Behind the coefficients; the constants of the record are the record's to add.
    let held = problem.terms.len()..problem.terms.len() + system.parameters.len();
    for segment in &problem.segments {
        let run = problem.trajectory(segment, &fit.x).ok()?.run;
        let record = problem.records[segment.record];
        let parameters = problem.model_parameters(segment.record, &fit.x);
        for (i, sample) in (segment.samples.0..segment.samples.1).enumerate() {
            let states = run.state_at(i).iter().copied();
            scratch.at(record.arguments_at(sample, states, &parameters[held.clone()]));
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum += (fit.x[k] * scratch.output(k)[0]).powi(2);
            }
            count += 1;
        }
    }
    Some(sums.into_iter().map(|s| (s / count.max(1) as f64).sqrt()).collect())
}
