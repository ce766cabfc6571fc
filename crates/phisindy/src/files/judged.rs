//! A machine by its own spec or result: its model completed, and the numbers and forces of that.

use super::compared_models::{freed, label, parsed};
use super::load::Purpose;
use super::request::Request;
use super::source::{Source, part, words};
use crate::error::Error;
use crate::options::Options;
use crate::{Gap, Identified};
use phisindy_compare::{Cause, Estimates, ForceCurve, Number, Unit};
use phisindy_gap::{Site, Step};
use phisindy_learn::{FoundParameter, ParameterOf};
use phisindy_phys::SensorPart;
use phisindy_phys::spec::Spec;
use phisindy_report::force_curves;

/// The forces of a model with these numbers.
pub(super) fn curves(found: &Identified, numbers: &Estimates) -> Vec<ForceCurve> {
    force_curves(found.loaded.input(), &found.result, numbers)
}

/// A machine by its own spec.
pub(super) struct Judged {
    pub(super) unit: Unit,
    /// Whether its spec has terms or laws to choose from.
    pub(super) open: bool,
    /// Its completed model, as a text in which all numbers that were found may move.
    pub(super) model: String,
}

pub(super) fn judged(source: &Source, request: &Request, options: &Options<'_>) -> Result<Judged, String> {
    let told = |why: Error| format!("`{}`: {}", source.name, words(&why));
    let loaded = source.opened(&source.text, request, Purpose::Run).map_err(told)?;
    let named = |spec: &Spec| spec.unknown.iter().any(|(_, unknown)| !unknown.laws.is_empty());
    if loaded.case.is_open() || named(&parsed(&source.text).map_err(told)?) {
        let found = loaded.identify(options).map_err(told)?;
        let model = found.model().and_then(|model| freed(&model, &found.loaded.parsed)).map_err(told)?;
        let (name, status) = (source.name.clone(), found.verdict().word().to_owned());
        let holds = found.verdict().holds();
        let estimates = estimates(&found);
        let curves = curves(&found, &estimates);
        return Ok(Judged {
            unit: Unit { name, status, holds, causes: vec![], estimates, curves },
            open: true,
            model,
        });
    }
    let found = part(options, (0.0, 0.8), |options| loaded.gap(options)).map_err(told)?;
    let model = if found.steps().is_empty() { source.text.clone() } else { found.result.completed.clone() };
    let fitted =
        part(options, (0.8, 1.0), |options| source.fitted(&model, request, options)).map_err(told)?;
    Ok(Judged { unit: of_gap(source, &found, &fitted), open: false, model })
}

/// What `gap` says of a machine.
pub(super) fn of_gap(source: &Source, found: &Gap, fitted: &Identified) -> Unit {
    let (status, estimates) = (found.status(), estimates(fitted));
    Unit {
        name: source.name.clone(),
        status: status.name().to_owned(),
        holds: status.holds(),
        causes: found.steps().iter().map(cause).collect(),
        curves: curves(fitted, &estimates),
        estimates,
    }
}

fn cause(step: &Step) -> Cause {
    let stated = match step.effect.place.site {
        Site::Constant { stated } => Some(stated),
        _ => None,
    };
    let numbers = step.parameters.iter().map(|p| (p.name.clone(), p.value, p.ci95, p.unit.clone())).collect();
    Cause { law: step.effect.entry.law.name.clone(), at: step.effect.place.at.clone(), stated, numbers }
}

/// The numbers that tell one machine from another: constants and coefficients, gains and delays of sensors. Where a
/// record starts, and what belongs to one record of several, is none; the zero of a sensor is set before each run.
pub(super) fn estimates(found: &Identified) -> Estimates {
    let terms = found.terms();
    let of_machine = |p: &FoundParameter| {
        let offset = matches!(p.id.of, ParameterOf::Sensor { part: SensorPart::Offset, .. });
        p.id.shown_record().is_none() && !offset
    };
    let named = |name: String, unit: &str, factor| Number { name, unit: unit.to_owned(), factor };
    let of_terms = terms
        .iter()
        .map(|t| (named(Number::of_coefficient(&t.candidate, &t.state), &t.unit, 1.0), t.coefficient.value));
    let of_parameters = found
        .parameters()
        .iter()
        .map(|p| (named(label(&p.id.to_string()), &p.unit, p.factor), p.estimate.value));
    let all: Vec<(Number, f64)> = of_terms.chain(of_parameters).collect();
    let covariance = &found.result.covariance;
    let kept: Vec<usize> = (0..all.len())
        .filter(|&k| {
            k < covariance.len() && (k < terms.len() || of_machine(&found.parameters()[k - terms.len()]))
        })
        .collect();
    Estimates {
        numbers: kept.iter().map(|&k| all[k].0.clone()).collect(),
        values: kept.iter().map(|&k| all[k].1).collect(),
        covariance: kept.iter().map(|&i| kept.iter().map(|&j| covariance[i][j]).collect()).collect(),
    }
}
