//! Records of one machine over time, and of many machines: what changed, who stands out.
//!
//! ```text
//! older --unit--> its model, completed --+--all numbers free--> Estimates ---------------------------+
//! newer --its records in that model-------+--all numbers free--> Estimates if it explains them, or gap --+--> Comparison
//! ```

use super::compared_models::{all_free, believed, columns, freed, gain_of, label, parsed, with_records_of};
use super::load::Purpose;
use super::request::Request;
use super::source::{Source, part, words};
use crate::error::Error;
use crate::options::Options;
use crate::{Gap, Identified};
use phisindy_compare::{Cause, Comparison, Estimates, Fleet, Number, Unit, changes, population};
use phisindy_gap::{Site, Status, Step};
use phisindy_learn::{FoundParameter, ParameterOf, SensorPart};
use phisindy_phys::spec::{ConstantSpec, Spec};
use phisindy_phys::unit::Unit as Measure;
use phisindy_report::CompareReport;
use std::path::{Path, PathBuf};

/// Sets specs or folders of results beside each other: of two, what changed from the first to the second; of more,
/// which of the machines stands out. `options` hears of the progress.
///
/// # Errors
/// In words: there are fewer than two, one of them cannot be read or has no result, or the records of one do not fit
/// into the model of the other.
///
/// ```no_run
/// use phisindy::{Options, files};
/// use std::path::PathBuf;
/// let paths = ["march-found", "june.ron"].map(PathBuf::from);
/// let report = files::compare(&paths, &files::Request::default(), &Options::default())?;
/// println!("{}", report.sentence());
/// # Ok::<(), String>(())
/// ```
pub fn compare(paths: &[PathBuf], request: &Request, options: &Options<'_>) -> Result<CompareReport, String> {
    let laws = paths.first().map(|path| Source::completed(path)?.laws(request)).transpose()?;
    let options = &Options { laws: options.laws.or(laws.as_ref()), ..*options };
    match paths {
        [old, new] => pair(old, new, request, options).map(|pair| CompareReport::Pair(Box::new(pair))),
        [] | [_] => Err("two specs or results are needed: the older one first".to_owned()),
        many => fleet(many, request, options).map(CompareReport::Fleet),
    }
}

/// What changed from one record of a machine to another.
fn pair(old: &Path, new: &Path, request: &Request, options: &Options<'_>) -> Result<Comparison, String> {
    let (older, newer) = (Source::completed(old)?, Source::completed(new)?);
    let Judged { unit: older_unit, open: open_model, model } =
        part(options, (0.0, 0.4), |options| judged(&older, request, options))?;
    let told = |why: Error| {
        format!("the model of `{}` with the records of `{}`: {}", old.display(), new.display(), words(&why))
    };
    let fit = |source: &Source, model: &str, span| {
        let free = all_free(model)?;
        part(options, span, |options| fitted(source, &free, request, options))
    };
    let before = fit(&older, &model, (0.4, 0.5)).map_err(told)?;
    // What `run` found is called by its terms, and in the model by its constants.
    let own = if open_model {
        part(options, (0.4, 0.5), |options| fitted(&older, &model, request, options)).map_err(told)?
    } else {
        older_unit.estimates.clone()
    };
    let known = known(&model, &own);
    let moved = with_records_of(&model, &newer.text).map_err(told)?;
    let open = |text: &str| newer.opened(text, request, Purpose::Gap).map_err(told);
    let free = open(&all_free(&moved).map_err(told)?)?.standing().map_err(told)?;
    let by_numbers = |holds: bool| {
        let status = if holds { Status::NothingMissing } else { Status::Unexplained };
        let (name, estimates) = (newer.name.clone(), fit(&newer, &moved, (0.5, 1.0)).map_err(told)?);
        Ok::<Unit, String>(Unit { name, status: status.name().into(), holds, causes: vec![], estimates })
    };
    let unit = if free.explains {
        by_numbers(true)?
    } else {
        let gap = |held: bool, span| {
            let loaded = open(&believed(&moved, &known, held).map_err(told)?)?;
            part(options, span, |options| loaded.gap(options)).map_err(told)
        };
        // A law is seen best beside numbers that stand still; where that does not explain the record, they move within
        // their errors.
        let mut found = gap(true, (0.5, 0.7))?;
        if !(found.stopped() || found.status().holds() && found.steps().len() == 1) {
            let other = gap(false, (0.7, 0.9))?;
            let rank = |found: &Gap| (!found.status().holds(), found.steps().len());
            found = if rank(&other) < rank(&found) { other } else { found };
        }
        let (fitted, validated) = found.after();
        let samples = free.samples as f64;
        let gain = 2.0 * samples * (free.gap / validated.unwrap_or(fitted)).ln();
        // A law that is not worth the price of one number (G. Schwarz 1978) beside numbers that move is not what is new.
        if gain < samples.ln() {
            by_numbers(found.status().holds())?
        } else {
            let text = if found.steps().is_empty() { &moved } else { &found.result.completed };
            of_gap(&newer, &found, fit(&newer, text, (0.9, 1.0)).map_err(told)?)
        }
    };
    let changes = changes(&before, &unit.estimates);
    // Where no number can be compared, the model as it was must explain the newer record.
    let alone = changes.differences.is_empty() && unit.holds && unit.causes.is_empty();
    let unit = if alone
        && !open(&believed(&moved, &known, true).map_err(told)?)?.standing().map_err(told)?.explains
    {
        Unit { holds: false, status: Status::Unexplained.name().into(), ..unit }
    } else {
        unit
    };
    Ok(Comparison { old: Unit { estimates: known, ..older_unit }, new: unit, changes })
}

/// Many machines of one kind, each by its own spec or result.
fn fleet(paths: &[PathBuf], request: &Request, options: &Options<'_>) -> Result<Fleet, String> {
    let mut units = Vec::new();
    for (k, path) in paths.iter().enumerate() {
        let share = |k: usize| k as f64 / paths.len() as f64;
        let source = Source::completed(path)?;
        units
            .push(part(options, (share(k), share(k + 1)), |options| judged(&source, request, options))?.unit);
    }
    let all: Vec<Estimates> = units.iter().map(|unit| unit.estimates.clone()).collect();
    Ok(Fleet { population: population(&all), units })
}

/// The numbers of a model by the records of a spec.
fn fitted(
    source: &Source,
    model: &str,
    request: &Request,
    options: &Options<'_>,
) -> Result<Estimates, Error> {
    Ok(estimates(&source.fitted(model, request, options)?))
}

/// A machine by its own spec.
struct Judged {
    unit: Unit,
    /// Whether its spec has terms or laws to choose from.
    open: bool,
    /// Its completed model, as a text in which all numbers that were found may move.
    model: String,
}

fn judged(source: &Source, request: &Request, options: &Options<'_>) -> Result<Judged, String> {
    let told = |why: Error| format!("`{}`: {}", source.name, words(&why));
    let loaded = source.opened(&source.text, request, Purpose::Run).map_err(told)?;
    let named = |spec: &Spec| spec.unknown.iter().any(|(_, unknown)| !unknown.laws.is_empty());
    if loaded.case.is_open() || named(&parsed(&source.text).map_err(told)?) {
        let found = loaded.identify(options).map_err(told)?;
        let model = found.model().and_then(|model| freed(&model, &found.loaded.parsed)).map_err(told)?;
        let (name, status) = (source.name.clone(), found.verdict().word().to_owned());
        let holds = found.verdict().holds();
        return Ok(Judged {
            unit: Unit { name, status, holds, causes: vec![], estimates: estimates(&found) },
            open: true,
            model,
        });
    }
    let found = part(options, (0.0, 0.8), |options| loaded.gap(options)).map_err(told)?;
    let model = if found.steps().is_empty() { source.text.clone() } else { found.result.completed.clone() };
    let fitted =
        part(options, (0.8, 1.0), |options| fitted(source, &model, request, options)).map_err(told)?;
    Ok(Judged { unit: of_gap(source, &found, fitted), open: false, model })
}

/// What `gap` says of a machine.
fn of_gap(source: &Source, found: &Gap, estimates: Estimates) -> Unit {
    let status = found.status();
    Unit {
        name: source.name.clone(),
        status: status.name().to_owned(),
        holds: status.holds(),
        causes: found.steps().iter().map(cause).collect(),
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
fn estimates(found: &Identified) -> Estimates {
    let terms = found.terms();
    let of_machine = |p: &FoundParameter| {
        let offset = matches!(p.id.of, ParameterOf::Sensor { part: SensorPart::Offset, .. });
        p.id.shown_record().is_none() && !offset
    };
    let named = |name: String, unit: &str, factor| Number { name, unit: unit.to_owned(), factor };
    let of_terms = terms
        .iter()
        .map(|t| (named(format!("{} in {}'", t.candidate, t.state), &t.unit, 1.0), t.coefficient.value));
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

/// The numbers of a model: those that were found with their errors, those that it holds, and gains of 1.
fn known(model: &str, found: &Estimates) -> Estimates {
    let Ok(spec) = parsed(model) else { return found.clone() };
    let constants = spec.constants.iter().filter_map(|(name, constant)| match constant {
        ConstantSpec::Number { value, unit } => {
            Some((name.value.clone(), unit.as_ref().map_or("", |unit| &unit.value), value.value))
        }
        _ => None,
    });
    let gains = columns(&spec).into_iter().map(|column| (gain_of(&column), "", 1.0));
    let mut all = found.clone();
    for (name, unit, value) in constants.chain(gains) {
        let factor = Measure::parse(unit).map_or(1.0, |unit| unit.factor);
        all.hold(Number { name, unit: unit.to_owned(), factor }, value * factor);
    }
    all
}
