//! Whether laws that a spec names fulfil what their files ask for, with the constants that were found.

use super::identified::Identified;
use super::verdict::{Rejection, Unfulfilled, Verdict};
use super::warning::Warning;
use crate::decisions::HALF_WIDTH_95;
use phisindy_expr::{Id, Scratch, Tape};
use phisindy_phys::{Case, Requirement};

/// Adds a warning for each law that does not fulfil its condition, and rejects the model if that is certain.
pub(crate) fn requirements(case: &Case, found: &mut Identified) {
    let broken: Vec<Unfulfilled> =
        case.requirements.iter().filter_map(|required| unfulfilled(case, required, found)).collect();
    if found.verdict == Verdict::Identified
        && let Some(first) = broken.iter().find(|b| b.certain)
    {
        found.verdict = Verdict::Rejected(Rejection::Unfulfilled(first.clone()));
    }
    found.warnings.extend(broken.into_iter().map(Warning::Unfulfilled));
}

fn unfulfilled(case: &Case, required: &Requirement, found: &Identified) -> Option<Unfulfilled> {
    let system = &case.system;
    let mut graph = system.graph.clone();
    let parameters: Vec<Id> = system.parameters.iter().map(|p| p.node).collect();
    let slopes = graph.gradient(required.node, &parameters);
    let outputs: Vec<Id> = [required.node].into_iter().chain(slopes).collect();
    let tape = Tape::compile(&graph, &parameters, &outputs).ok()?;
    let mut scratch = Scratch::<1>::new(&tape);
    scratch.at(found.parameters_of(system, 0));
    let value = scratch.output(0)[0];
    let t = found.terms.len();
    let slope = |k: usize| {
        let index = found.parameters[k].id.constant().filter(|_| found.parameters[k].id.holds_in(0));
        index.map_or(0.0, |index| scratch.output(1 + index)[0])
    };
    let used: Vec<usize> = (0..found.parameters.len()).filter(|&k| slope(k) != 0.0).collect();
    let covariance = |i: usize, j: usize| found.covariance.get(t + i).map_or(f64::NAN, |row| row[t + j]);
    let row = |&i: &usize| used.iter().map(|&j| slope(i) * covariance(i, j) * slope(j)).sum::<f64>();
    let error = used.iter().map(row).sum::<f64>().max(0.0).sqrt();
    (value < 0.0).then(|| Unfulfilled {
        law: required.law.clone(),
        because: required.because.clone(),
        simpler: required.simpler.clone(),
        certain: value + HALF_WIDTH_95 * error < 0.0,
    })
}
