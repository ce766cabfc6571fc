//! Identification from start to end, whatever the method.

use crate::differentiators::{Number, dependence};
use crate::result::contribution::contributions;
use crate::result::error::{DataError, LearnError, NumericsError};
use crate::result::estimate::Estimate;
use crate::result::identified::{Identified, NoiseModel, PathPoint};
use crate::result::parameter::FoundParameter;
use crate::result::quantity::{ParameterId, ParameterOf, Quantity, TermId};
use crate::result::record_fit::RecordFit;
use crate::result::term::FoundTerm;
use crate::result::verdict::verdict;
use crate::result::warning::{Warning, at_bounds, sensitive_starts};
use crate::step::train::{StepFit, StepOptions, normal_of_steps, train};
use crate::trajectory::assess::{Solution, assess};
use crate::trajectory::method::by_trajectory;
use phisindy_phys::spec::{Method, Optimiser, Role};
use phisindy_phys::{Case, Record, System};
use std::ops::ControlFlow;

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
        return Err(DataError::NothingToFit.into());
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
    let worst = |role: Role, of: fn(&RecordFit) -> f64| {
        found.records.iter().filter(|r| r.role == role).map(of).fold(0.0, f64::max)
    };
    let (fit, validate) =
        (worst(Role::Fit, RecordFit::worst), worst(Role::Validate, RecordFit::worst_of_motion));
    if validate > FINE && validate > WORSE * fit {
        found.warnings.push(Warning::ValidationWorse { fit, validate });
    }
}

/// A record with fewer samples cannot be learned from.
const FEWEST: usize = 20;

/// A record from which nothing can be learned is refused with the reason.
fn suitable(system: &System, record: &Record) -> Result<(), LearnError> {
    if record.len() < FEWEST {
        let (record, samples) = (record.name.clone(), record.len());
        return Err(DataError::TooFewSamples { record, samples }.into());
    }
    dead_column(system, record).map_or(Ok(()), |dead| Err(dead.into()))
}

/// What is wrong with a record in which a measured column does not move.
pub fn dead_column(system: &System, record: &Record) -> Option<DataError> {
    let still = |c: &Option<Vec<f64>>| c.as_ref().is_some_and(|c| c.iter().all(|v| *v == c[0]));
    let k = record.columns.iter().position(still)?;
    let column = system.states[k].name.clone();
    Some(DataError::ConstantColumn { record: record.name.clone(), column })
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
            Ok(notes) => {
                let of = |note| Warning::DataNote { record: record.name.clone(), note };
                warnings.extend(notes.into_iter().map(of));
            }
            Err(states) => {
                return Err(DataError::MissingStates { record: record.name.clone(), states }.into());
            }
        }
    }
    let options = step_options(case);
    if options.optimiser != Optimiser::GaussNewton && !system.parameters.is_empty() {
        let names = system.parameters.iter().map(|p| p.name.clone()).collect();
        warnings.push(Warning::HeldConstants { optimiser: options.optimiser, names });
    }
    if records
        .iter()
        .any(|r| r.sensors.iter().any(|s| [&s.offset, &s.gain, &s.delay].iter().any(|p| p.within.is_some())))
    {
        warnings.push(Warning::HeldSensors);
    }
    let fitted: Vec<&Record> = filled.iter().filter(|r| r.role == Role::Fit).collect();
    let fit = train(system, &fitted, &options, observe);
    if !fit.loss.is_finite() || fit.coefficients.iter().any(|c| !c.is_finite()) {
        return Err(NumericsError::LossNotFinite.into());
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
        noise_model: NoiseModel::Unweighted,
        selection,
        covariance,
        warnings,
        verdict,
        stop_reason: fit.stop_reason,
    })
}

/// What method step found, in the order of its unknowns.
fn numbers_of_steps(system: &System, fit: &StepFit, moved: bool) -> Vec<Number> {
    let terms = fit.terms.iter().map(|&t| Quantity::Coefficient(TermId::new(system, t)));
    let parameters =
        (0..system.parameters.len()).filter(|_| moved).map(|k| Quantity::Parameter(id(system, k)));
    let names = terms.chain(parameters);
    names.zip(fit.std_errors()).enumerate().map(|(k, (name, error))| (k, name, error)).collect()
}

/// A constant that all records share.
fn id(system: &System, index: usize) -> ParameterId {
    let of = ParameterOf::Constant { index, name: system.parameters[index].name.clone() };
    ParameterId { of, owner: None }
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
        id: id(system, k),
        unit: p.unit.clone(),
        factor: phisindy_phys::unit::Unit::parse(&p.unit).map_or(1.0, |u| u.factor),
        estimate: Estimate::normal(values[k], std_errors[k]),
        bounds: p.within,
        at_bound: values[k] <= p.within.0 || values[k] >= p.within.1,
    };
    system.parameters.iter().enumerate().map(found).collect()
}

#[cfg(test)]
mod tests;
