//! Method step from records to a result: velocities are derived, terms trained, error bars and a verdict
//! added.

use crate::differentiator_dependence::{Number, dependence};
use crate::result::error::{DataError, LearnError, NumericsError};
use crate::result::estimate::Estimate;
use crate::result::identified::{Identified, NoiseModel, PathPoint};
use crate::result::parameter::FoundParameter;
use crate::result::quantity::{ParameterId, ParameterOf, Quantity, TermId};
use crate::result::term::FoundTerm;
use crate::result::verdict::verdict;
use crate::result::warning::{Warning, at_bounds, sensitive_starts};
use crate::step::options::StepOptions;
use crate::step::train::{StepFit, normal_of_steps, train};
use crate::trajectory::free_run::{Solution, free_runs};
use phisindy_phys::spec::{Method, Optimiser, Role};
use phisindy_phys::{Case, Record, System};
use phisindy_signal::Differentiator;
use std::ops::ControlFlow;

/// The paper's method.
pub(crate) fn by_steps(
    case: &Case,
    records: &[Record],
    observe: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Identified, LearnError> {
    let system = &case.system;
    if system.jumps() {
        return Err(DataError::Jumps.into());
    }
    let (filled, mut warnings) = filled(case, records)?;
    let options = step_options(case);
    warnings.extend(kept_fixed(system, records, options.optimiser));
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
    let here = normal_of_steps(system, &fitted, &options, &fit);
    warnings.extend(dependence(&numbers_of_steps(system, &fit, moved), &here, |how| {
        Some(normal_of_steps(
            system,
            &derived_by(system, records, how)?.iter().collect::<Vec<_>>(),
            &options,
            &fit,
        ))
    }));
    let mut solution = Solution::new(fit.terms.clone(), fit.coefficients.clone(), &fit.parameters, records);
    let fits = free_runs(system, records, &filled, &mut solution);
    warnings.extend(sensitive_starts(&fits));
    let mut without = Solution::new(vec![], vec![], &fit.parameters, records);
    let baseline = free_runs(system, records, &filled, &mut without);
    let verdict = verdict(system, &terms, &fits, &baseline, false);
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
        remainder: vec![],
        held: vec![],
        horizon: vec![],
        selection,
        covariance,
        late: None,
        deviance: None,
        warnings,
        verdict,
        stop_reason: fit.stop_reason,
    })
}

/// The records with derived velocities, and notes of what was derived.
///
/// # Errors
/// A state has no samples and cannot be derived.
fn filled(case: &Case, records: &[Record]) -> Result<(Vec<Record>, Vec<Warning>), DataError> {
    let mut filled: Vec<Record> = records.to_vec();
    let how = case.learn.differentiator.unwrap_or_default();
    let mut notes = Vec::new();
    for record in &mut filled {
        let name = record.name.clone();
        // The method predicts the next state: outputs have no part in it.
        record.columns.truncate(case.system.states.len());
        match record.fill_velocities(&case.system, how) {
            Ok(done) => {
                notes.extend(done.into_iter().map(|note| Warning::DataNote { record: name.clone(), note }));
            }
            Err(states) => return Err(DataError::MissingStates { record: name, states }),
        }
    }
    Ok((filled, notes))
}

/// Warnings for what the spec lets move and the method keeps fixed.
fn kept_fixed(system: &System, records: &[Record], optimiser: Optimiser) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if optimiser != Optimiser::GaussNewton && !system.parameters.is_empty() {
        let names = system.parameters.iter().map(|p| p.name.clone()).collect();
        warnings.push(Warning::HeldConstants { optimiser, names });
    }
    let mut sensors = records.iter().flat_map(|r| &r.sensors);
    if sensors.any(|s| s.parameters().iter().any(|p| p.within.is_some())) {
        warnings.push(Warning::HeldSensors);
    }
    warnings
}

/// The Fit records with their derived columns differentiated by another method; `None` where nothing is
/// derived, or it cannot be done.
fn derived_by(system: &System, records: &[Record], how: Differentiator) -> Option<Vec<Record>> {
    let derives = |r: &&&Record| !r.derivations.is_empty() || r.columns.iter().any(Option::is_none);
    let measured: Vec<&Record> = records.iter().filter(|r| r.role == Role::Fit).collect();
    measured.iter().find(derives)?;
    let other = |r: &&Record| {
        let mut r = r.rederived(how)?;
        r.columns.truncate(system.states.len());
        r.fill_velocities(system, how).ok().map(|_| r)
    };
    measured.iter().map(other).collect()
}

/// The numbers of the result, in the order of the unknowns.
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
    // The shorter list determines the number of stages.
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
