//! Identification from start to end, whatever the method.

use crate::differentiators::{Number, dependence};
use crate::result::contribution::contributions;
use crate::result::identified::{
    Estimate, FoundParameter, FoundTerm, Identified, LearnError, PathPoint, RecordFit, Verdict,
    sensitive_starts,
};
use crate::step::train::{StepFit, StepOptions, normal_of_steps, train};
use crate::trajectory::assess::{Solution, assess};
use crate::trajectory::method::by_trajectory;
use phisindy_phys::spec::{Method, Optimiser, Role};
use phisindy_phys::{Case, Record, System};
use std::ops::ControlFlow;

/// A free run worse than this is no model.
const WORST_NRMSE: f64 = 0.5;

/// What the caller decides; the rest is in the spec.
#[derive(Clone, Copy, Debug, Default)]
pub struct LearnOptions {
    /// Overrides the spec's method.
    pub method: Option<Method>,
}

/// Identifies the unknown part of a case from its records. `observe` hears of the progress (a fraction of the work) and may stop it.
///
/// # Errors
/// The records do not suit the method, or the numerics fail altogether. A model that merely does not fit is a verdict, not an error.
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
    observe: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Identified, LearnError> {
    let fitted: Vec<&Record> = records.iter().filter(|r| r.role == Role::Fit).collect();
    if fitted.is_empty() {
        return Err(LearnError::Data(
            "no record has the role Fit, so there is nothing to identify from: take `role: Validate` off one of them".into(),
        ));
    }
    for record in &fitted {
        suitable(&case.system, record)?;
    }
    let mut found = match options.method.or(case.learn.method).unwrap_or(Method::Trajectory) {
        Method::Step => by_steps(case, records, observe),
        Method::Trajectory => by_trajectory(case, records, observe),
    }?;
    contributions(&case.system, records, &mut found);
    remarks(&case.system, &mut found);
    Ok(found)
}

/// Validation this many times worse than the fit is told in words ...
const WORSE: f64 = 3.0;
/// ... unless it is still below this.
const FINE: f64 = 0.05;

/// What a careful reader should know of any result: terms that may as well be zero, validation that does not hold what the fit promises.
fn remarks(system: &System, found: &mut Identified) {
    for found_term in &mut found.terms {
        let term = &system.terms[found_term.term];
        let name = format!("{} of {}'", term.candidate, system.states[term.state].name);
        let Estimate { value, std_error, ci95: (low, high) } = &mut found_term.coefficient;
        (*low, *high) = (low.max(term.within.0), high.min(term.within.1));
        found_term.at_bound = *value <= term.within.0 || *value >= term.within.1;
        if found_term.at_bound {
            found.warnings.push(beyond_bound(&name, *value));
        } else if std_error.is_finite() && *low <= 0.0 && *high >= 0.0 {
            found.warnings.push(format!("{name} may as well be zero: its interval holds it"));
        }
    }
    let worst = |role: Role, of: fn(&RecordFit) -> f64| {
        found.records.iter().filter(|r| r.role == role).map(of).fold(0.0, f64::max)
    };
    let (fit, validate) =
        (worst(Role::Fit, RecordFit::worst), worst(Role::Validate, RecordFit::worst_of_motion));
    if validate > FINE && validate > WORSE * fit {
        found.warnings.push(format!(
            "validation is {:.0} times worse than the fit (NRMSE {validate:.3} against {fit:.3}): the model does not carry over; the known part may be wrong",
            validate / fit
        ));
    }
}

/// A record from which nothing can be learned is refused with the reason.
fn suitable(system: &System, record: &Record) -> Result<(), LearnError> {
    let name = &record.name;
    if record.len() < 20 {
        return Err(LearnError::Data(format!(
            "{name}: {} samples are too few to learn from (20 at least): take a longer window, or decimate less",
            record.len()
        )));
    }
    match dead_column(system, record) {
        Some(why) => Err(LearnError::Data(why)),
        None => Ok(()),
    }
}

/// What is wrong with a record in which a measured column does not move, in words.
pub fn dead_column(system: &System, record: &Record) -> Option<String> {
    let still = |c: &Option<Vec<f64>>| c.as_ref().is_some_and(|c| c.iter().all(|v| *v == c[0]));
    let k = record.columns.iter().position(still)?;
    Some(format!(
        "{}: the column of {} is constant: nothing moved, or the sensor is dead; leave the column out, or take a window in which it moves",
        record.name, system.states[k].name
    ))
}

/// The paper's method.
fn by_steps(
    case: &Case,
    records: &[Record],
    observe: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Identified, LearnError> {
    let system = &case.system;
    let mut warnings = Vec::new();
    let mut filled: Vec<Record> = records.to_vec();
    let how = case.learn.differentiator.unwrap_or_default();
    for record in &mut filled {
        match record.fill_velocities(system, how) {
            Ok(notes) => warnings.extend(notes),
            Err(missing) => {
                return Err(LearnError::Data(format!(
                    "{}: method step needs samples of every state, and {} cannot be derived from a column; use --method trajectory",
                    record.name,
                    missing.join(", ")
                )));
            }
        }
    }
    let options = step_options(case);
    if options.optimiser != Optimiser::GaussNewton && !system.parameters.is_empty() {
        let names: Vec<&str> = system.parameters.iter().map(|p| p.name.as_str()).collect();
        warnings.push(format!(
            "method step with {:?} holds {} at the spec's value; learn: (optimiser: GaussNewton) moves it",
            options.optimiser,
            names.join(", ")
        ));
    }
    if records
        .iter()
        .any(|r| r.sensors.iter().any(|s| [&s.offset, &s.gain, &s.delay].iter().any(|p| p.within.is_some())))
    {
        warnings.push("method step holds sensor offsets, gains and delays at their start values".into());
    }
    let fitted: Vec<&Record> = filled.iter().filter(|r| r.role == Role::Fit).collect();
    let fit = train(system, &fitted, &options, observe);
    if !fit.loss.is_finite() || fit.coefficients.iter().any(|c| !c.is_finite()) {
        return Err(LearnError::Numerics(
            "the one-step loss is not finite: a candidate is singular on the data".into(),
        ));
    }
    let errors = fit.std_errors();
    let terms: Vec<FoundTerm> = (0..fit.terms.len())
        .map(|k| FoundTerm::new(fit.terms[k], Estimate::normal(fit.coefficients[k], errors[k])))
        .collect();
    let moved = options.optimiser == Optimiser::GaussNewton;
    let parameters =
        if moved { found_parameters(system, &fit.parameters, &errors[terms.len()..]) } else { vec![] };
    warnings.extend(at_bounds(&parameters));
    let numbers = numbers_of_steps(system, &fit, moved);
    let here = normal_of_steps(system, &fitted, &options, &fit);
    warnings.extend(dependence(&numbers, &here, |how| {
        let derives = |r: &&&Record| !r.derivations.is_empty() || r.columns.iter().any(Option::is_none);
        let measured: Vec<&Record> = records.iter().filter(|r| r.role == Role::Fit).collect();
        measured.iter().find(derives)?;
        let other = |r: &&Record| {
            let mut r = r.rederived(how)?;
            r.fill_velocities(system, how).ok().map(|_| r)
        };
        let other: Vec<Record> = measured.iter().map(other).collect::<Option<_>>()?;
        Some(normal_of_steps(system, &other.iter().collect::<Vec<_>>(), &options, &fit))
    }));
    let mut solution = Solution::new(fit.terms.clone(), fit.coefficients.clone(), &fit.parameters, records);
    let fits = assess(system, records, &filled, &mut solution);
    warnings.extend(sensitive_starts(&fits));
    let mut without = Solution::new(vec![], vec![], &fit.parameters, records);
    let baseline = assess(system, records, &filled, &mut without);
    let verdict = verdict(system, &terms, &fits, &baseline);
    let selection =
        fit.stages.iter().map(|&(terms, criterion)| PathPoint { terms, criterion, nrmse: None }).collect();
    let found = terms.len() + parameters.len();
    let covariance = fit.covariance[..found].iter().map(|row| row[..found].to_vec()).collect();
    Ok(Identified {
        method: Method::Step,
        terms,
        parameters,
        records: fits,
        noise_model: "not used: every sample weighs the same".into(),
        selection,
        covariance,
        warnings,
        verdict,
        stopped: fit.stopped,
    })
}

/// What method step found, in the order of its unknowns.
fn numbers_of_steps(system: &System, fit: &StepFit, moved: bool) -> Vec<Number> {
    let term = |&t: &usize| {
        format!("{} in {}'", system.terms[t].candidate, system.states[system.terms[t].state].name)
    };
    let parameters = system.parameters.iter().filter(|_| moved).map(|p| p.name.clone());
    let names = fit.terms.iter().map(term).chain(parameters);
    names.zip(fit.std_errors()).enumerate().map(|(k, (name, error))| (k, name, error)).collect()
}

fn step_options(case: &Case) -> StepOptions {
    let (learn, default) = (&case.learn, StepOptions::default());
    let mut epochs = learn.epochs.clone().unwrap_or(default.epochs);
    let mut rates = learn.rates.clone().unwrap_or(default.rates);
    // The shorter list says how many stages there are.
    let stages = epochs.len().min(rates.len());
    epochs.truncate(stages);
    rates.truncate(stages);
    StepOptions {
        optimiser: learn.optimiser.unwrap_or(default.optimiser),
        epochs,
        rates,
        cutoff: learn.cutoff.as_ref().map_or(default.cutoff, |c| c.value),
        tolerance: learn.tolerance.as_ref().map_or(default.tolerance, |t| t.value),
        horizon: learn.horizon.unwrap_or(1).max(1) as usize,
        crossings: learn.crossings.unwrap_or(default.crossings),
    }
}

fn found_parameters(system: &System, values: &[f64], std_errors: &[f64]) -> Vec<FoundParameter> {
    let found = |(k, p): (usize, &phisindy_phys::Parameter)| FoundParameter {
        name: p.name.clone(),
        unit: p.unit.clone(),
        factor: phisindy_phys::unit::Unit::parse(&p.unit).map_or(1.0, |u| u.factor),
        estimate: Estimate::normal(values[k], std_errors[k]),
        bounds: p.within,
        at_bound: values[k] <= p.within.0 || values[k] >= p.within.1,
        parameter: Some(k),
        record: None,
    };
    system.parameters.iter().enumerate().map(found).collect()
}

/// A warning for every parameter that ran into a bound.
pub fn at_bounds(parameters: &[FoundParameter]) -> Vec<String> {
    let at = parameters.iter().filter(|p| p.at_bound);
    at.map(|p| beyond_bound(&p.name, p.estimate.value / p.factor)).collect()
}

fn beyond_bound(name: &str, value: f64) -> String {
    format!("{name} ended at its bound {value}: the data want to go beyond it")
}

/// Rejected when nothing survives, a free run fails or misses, or the unknown part is no better than nothing.
pub(crate) fn verdict(
    system: &System,
    terms: &[FoundTerm],
    fits: &[RecordFit],
    without: &[RecordFit],
) -> Verdict {
    if terms.is_empty() && !system.terms.is_empty() {
        let known =
            without.iter().map(|f| format!("{} {:.3}", f.name, f.worst())).collect::<Vec<_>>().join(", ");
        return Verdict::Rejected(format!(
            "no term of the dictionary survives: nothing is missing that it could name (NRMSE of the known part alone: {known})"
        ));
    }
    for fit in fits {
        if let Some(failure) = &fit.failure {
            return Verdict::Rejected(format!("the free run of {} fails: {failure}", fit.name));
        }
        // What is fitted must move; what is validated may have come to rest.
        let worst = if fit.role == Role::Fit { fit.worst() } else { fit.worst_of_motion() };
        if worst > WORST_NRMSE {
            return Verdict::Rejected(format!(
                "the free run of {} misses the data: NRMSE {worst:.2}",
                fit.name
            ));
        }
    }
    let mean = |fits: &[RecordFit]| fits.iter().map(RecordFit::worst).sum::<f64>() / fits.len().max(1) as f64;
    if !terms.is_empty() && mean(without) <= mean(fits) {
        return Verdict::Rejected("the model does no better with the identified part than without it".into());
    }
    Verdict::Identified
}

#[cfg(test)]
mod tests;
