//! Identification from start to end, whatever the method.

use crate::copies::{copies, restored, without};
use crate::decisions::{FINE_NRMSE, WORSE};
use crate::record_mistakes::{suitable, unreadable};
use crate::result::contribution::contributions;
use crate::result::error::{DataError, LearnError};
use crate::result::estimate::Estimate;
use crate::result::identified::{Identified, StopReason};
use crate::result::passivity::passivity;
use crate::result::quantity::{Quantity, TermId};
use crate::result::record_fit::RecordFit;
use crate::result::requirements::requirements;
use crate::result::verdict::Verdict;
use crate::result::warning::Warning;
use crate::step::method::by_steps;
use crate::trajectory::initial::{differentiated, sized, smoothed};
use crate::trajectory::kalman_smoother::reads_outputs;
use crate::trajectory::method::by_trajectory;
use phisindy_phys::spec::{Method, Role};
use phisindy_phys::{Case, Record, System};
use phisindy_sim::Stop;
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::Mutex;

/// What the caller decides; the rest is in the spec.
#[derive(Clone, Copy, Debug, Default)]
pub struct LearnOptions {
    /// Overrides the spec's method.
    pub method: Option<Method>,
    /// Whether the model was fitted before: one fit from its start values, without other starts or columns that may be late.
    pub fitted_before: bool,
}

/// Identifies the unknown part of a case from its records. `observe` receives the progress (a fraction of
/// the work), is asked again and again while a step takes long, and may stop it: the result is then the best so far.
///
/// # Errors
/// The records do not suit the method, or the numerics fail altogether. A model that merely does not fit is a
/// verdict, not an error.
///
/// ```
/// use phisindy_learn::{LearnOptions, Verdict, identify};
/// use phisindy_phys::{Origin, SourceId, check, spec};
/// use phisindy_sim::synthesize;
/// use std::ops::ControlFlow;
/// let text = r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") }, known: { "x": "v", "v": "-k*x" },
///     unknown: { "v": (factor: "-sgn(v)", candidates: ["1", "x"]) }, contacts: ["v"],
///     data: [ Synthetic(truth: { "v": "-0.3*sgn(v)" }, start: { "x": 2.0, "v": 0.0 }, duration: 10.0, step: 0.01, noise: Additive(0.01), seed: 1) ])"#;
/// let (spec, _) = spec::read(text, SourceId(0)).unwrap();
/// let (case, _) = check(&spec, SourceId(0)).unwrap();
/// let Origin::Synthetic(truth) = &case.records[0].origin else { panic!("a measured record") };
/// let (record, _) = synthesize(&case.records[0], truth, &case.system, None, &|_| Err("no files here".into())).unwrap();
/// let found = identify(&case, &[record], &LearnOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap();
/// // Of the two candidates one is there: 0.3 m/s^2 of friction.
/// assert_eq!((found.terms.len(), found.terms[0].term), (1, 0));
/// assert!((found.terms[0].coefficient.value - 0.3).abs() < 0.01);
/// assert_eq!(found.verdict, Verdict::Identified);
/// ```
pub fn identify(
    case: &Case,
    records: &[Record],
    options: &LearnOptions,
    observe: &mut (dyn FnMut(f64) -> ControlFlow<()> + Send),
) -> Result<Identified, LearnError> {
    let copies = copies(records);
    if copies.iter().any(Option::is_some) {
        let found = identify(case, &without(records, &copies), options, observe)?;
        return Ok(restored(found, records, &copies));
    }
    let (stop, told) = (Stop::default(), Mutex::new((0.0, observe)));
    let tell = |part: Option<f64>| {
        let Ok(mut told) = told.lock() else { return ControlFlow::Break(()) };
        told.0 = part.unwrap_or(told.0);
        let last = told.0;
        (told.1)(last)
    };
    stop.during(
        || tell(None).is_break(),
        || by_method(case, records, options, &stop, &mut |part| tell(Some(part))),
    )
}

fn by_method(
    case: &Case,
    records: &[Record],
    options: &LearnOptions,
    stop: &Stop,
    observe: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Identified, LearnError> {
    let fitted: Vec<&Record> = records.iter().filter(|r| r.role == Role::Fit).collect();
    if fitted.is_empty() {
        return Err(DataError::NothingToFit.into());
    }
    for record in &fitted {
        suitable(&case.system, record)?;
    }
    if let Some(wrong) = records.iter().find_map(|r| unreadable(&case.system, r)) {
        return Err(wrong.into());
    }
    let with_sizes;
    let (records, mut found) = match options.method.or(case.learn.method).unwrap_or(Method::Trajectory) {
        Method::Step => (records, by_steps(case, records, observe)?),
        Method::Trajectory => {
            let found;
            (with_sizes, found) = from_estimate_or_rest(case, records, options, stop, observe)?;
            (&with_sizes[..], found)
        }
    };
    contributions(&case.system, records, &mut found);
    remarks(&case.system, &mut found);
    limit_by_validation(&mut found);
    passivity(&case.system, records, &mut found);
    requirements(case, &mut found);
    Ok(found)
}

/// The trajectory method from the estimate of the states that only outputs tell. Where it leaves more than
/// noise, it starts once more with those states at rest, and the smaller residual counts: friction that holds
/// a body for long is an unknown force of the estimate, which may lead astray. Also returns the records with
/// the sizes of their states.
fn from_estimate_or_rest(
    case: &Case,
    records: &[Record],
    options: &LearnOptions,
    stop: &Stop,
    observe: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<(Vec<Record>, Identified), LearnError> {
    let system = &case.system;
    let mut from = |smooth: Vec<Record>| {
        let sized = sized(system, records, &smooth);
        let found = by_trajectory(case, (&sized, &smooth), options, stop, observe);
        (sized, found)
    };
    let (sized, first) = from(records.par_iter().map(|r| smoothed(system, r)).collect());
    let left = |found: &Result<Identified, LearnError>| match found {
        Ok(found) => {
            let fit = found.records.iter().filter(|r| r.role == Role::Fit);
            fit.map(RecordFit::worst).fold(0.0, f64::max)
        }
        Err(_) => f64::INFINITY,
    };
    let done = first.as_ref().is_ok_and(|found| {
        found.stop_reason == StopReason::Interrupted || !found.warnings.iter().any(Warning::doubts_residual)
    });
    if done || !records.iter().any(|r| reads_outputs(system, r)) {
        return Ok((sized, first?));
    }
    let (at_rest, second) = from(records.par_iter().map(|r| differentiated(system, r)).collect());
    if left(&second) < left(&first) { Ok((at_rest, second?)) } else { Ok((sized, first?)) }
}

/// Warnings that hold for either method: coefficients at a bound or compatible with zero, and validation that
/// is much worse than the fit.
fn remarks(system: &System, found: &mut Identified) {
    for found_term in &mut found.terms {
        let term = &system.terms[found_term.term];
        let Estimate { value, std_error, ci95: (low, high) } = &mut found_term.coefficient;
        (*low, *high) = (low.max(term.within.0), high.min(term.within.1));
        found_term.at_bound = *value <= term.within.0 || *value >= term.within.1;
        if found_term.at_bound {
            let number = Quantity::Coefficient(TermId::new(system, found_term.term));
            found.warnings.push(Warning::AtBound { number, value: *value });
        } else if std_error.is_finite() && *low <= 0.0 && *high >= 0.0 {
            found.warnings.push(Warning::MayBeZero { term: TermId::new(system, found_term.term) });
        }
    }
    let worst = |role: Role| {
        found.records.iter().filter(|r| r.role == role).map(RecordFit::judged).fold(0.0, f64::max)
    };
    let (fit, validate) = (worst(Role::Fit), worst(Role::Validate));
    let worse = |nrmse: f64| nrmse > FINE_NRMSE && nrmse > WORSE * fit;
    // The noise of a sensor is a larger share of a small motion. What a validation misses must be more than the fit leaves
    // in the unit of the column too.
    let fitted: Vec<_> = found.records.iter().filter(|r| r.role == Role::Fit).collect();
    let left = |k: usize| {
        let all = fitted.iter().flat_map(|r| r.left()).filter(|(own, ..)| *own == k);
        all.map(|(.., rms)| rms).fold(0.0, f64::max)
    };
    let misses = |r: &RecordFit| {
        let ran = r.run.is_some() && r.segments.is_none();
        worse(r.judged()) && (!ran || r.left().any(|(k, nrmse, rms)| worse(nrmse) && rms > WORSE * left(k)))
    };
    if found.records.iter().any(|r| r.role == Role::Validate && misses(r)) {
        found.warnings.push(Warning::ValidationWorse { fit, validate });
    }
}

/// What does not carry over to other records is more than noise.
fn limit_by_validation(found: &mut Identified) {
    if found.verdict == Verdict::Identified && found.warnings.iter().any(Warning::doubts_validation) {
        found.verdict = Verdict::Named;
    }
}

#[cfg(test)]
mod tests;
