//! Whether laws that a spec names fulfil what their files ask for, with the constants that were found.

use super::identified::Identified;
use super::parameter::FoundParameter;
use super::verdict::{Rejection, Unfulfilled, Verdict};
use super::warning::Warning;
use crate::decisions::HALF_WIDTH_95;
use phisindy_expr::{Id, Scratch, Tape};
use phisindy_phys::{Case, Requirement};

/// Adds a warning for each law that does not fulfil its condition, and rejects the model if that is certain.
pub(crate) fn requirements(case: &Case, found: &mut Identified) {
    let broken: Vec<Unfulfilled> =
        case.requirements.iter().filter_map(|required| unfulfilled(case, required, found)).collect();
    if found.verdict.holds()
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
    let slope = |p: &FoundParameter| {
        let index = p.id.constant().filter(|_| p.id.holds_in(0));
        index.map_or(0.0, |index| scratch.output(1 + index)[0])
    };
    let of_terms = found.terms.iter().map(|_| 0.0);
    let slopes: Vec<f64> = of_terms.chain(found.parameters.iter().map(slope)).collect();
    let certain = match found.standard_error(&slopes) {
        Some(error) => value + HALF_WIDTH_95 * error < 0.0,
        // Without error bars the number stands for itself; one that the data do not tell is not certain.
        None => found.covariance.is_empty(),
    };
    (value < 0.0).then(|| Unfulfilled {
        law: required.law.clone(),
        because: required.because.clone(),
        simpler: required.simpler.clone(),
        certain,
    })
}
