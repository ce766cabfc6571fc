//! Records of one machine over time, and of many machines: what changed, who stands out.
//!
//! ```text
//! older --unit--> its model, completed --+--all numbers free--> Estimates ---------------------------+
//! newer --its records in that model-------+--all numbers free--> Estimates if it explains them, or gap --+--> Comparison
//! ```

use super::compared_models::{all_free, believed, columns, gain_of, parsed, with_records_of};
use super::fleet::fleet;
use super::judged::{Judged, curves, estimates, judged, of_gap};
use super::load::Purpose;
use super::request::Request;
use super::source::{Source, part, words};
use crate::error::Error;
use crate::options::Options;
use crate::{Gap, Identified};
use phisindy_compare::{Comparison, Estimates, Number, Unit, changes};
use phisindy_gap::Status;
use phisindy_phys::spec::ConstantSpec;
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
        part(options, span, |options| source.fitted(&free, request, options))
    };
    let before = fit(&older, &model, (0.4, 0.5)).map_err(told)?;
    // What `run` found is called by its terms, and in the model by its constants.
    let own = if open_model {
        estimates(&part(options, (0.4, 0.5), |options| older.fitted(&model, request, options)).map_err(told)?)
    } else {
        older_unit.estimates.clone()
    };
    let known = known(&model, &own);
    let moved = with_records_of(&model, &newer.text).map_err(told)?;
    let open = |text: &str| newer.opened(text, request, Purpose::Gap).map_err(told);
    let free = open(&all_free(&moved).map_err(told)?)?.standing().map_err(told)?;
    let by_numbers = |holds: bool| {
        let status = if holds { Status::NothingMissing } else { Status::Unexplained };
        let found = fit(&newer, &moved, (0.5, 1.0)).map_err(told)?;
        let (name, status) = (newer.name.clone(), status.name().into());
        let unit = Unit { name, status, holds, estimates: estimates(&found), ..Unit::default() };
        Ok::<(Unit, Identified), String>((unit, found))
    };
    let (unit, after) = if free.explains {
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
            let after = fit(&newer, text, (0.9, 1.0)).map_err(told)?;
            (of_gap(&newer, &found, &after), after)
        }
    };
    let changes = changes(&estimates(&before), &unit.estimates);
    // A constant that changed is one finding, whether the search for laws saw it too or not.
    let of_numbers: Vec<&str> = changes.changed().map(|change| change.name.as_str()).collect();
    let unit = Unit {
        causes: unit
            .causes
            .into_iter()
            .filter(|cause| cause.stated.is_none() || !of_numbers.contains(&cause.at.as_str()))
            .collect(),
        ..unit
    };
    // Where no number can be compared, the model as it was must explain the newer record.
    let alone = changes.differences.is_empty() && unit.holds && unit.causes.is_empty();
    let unit = if alone
        && !open(&believed(&moved, &known, true).map_err(told)?)?.standing().map_err(told)?.explains
    {
        Unit { holds: false, status: Status::Unexplained.name().into(), ..unit }
    } else {
        unit
    };
    let old = Unit { curves: curves(&before, &known), estimates: known, ..older_unit };
    let new = Unit { curves: curves(&after, &changes.applied(&old.estimates)), ..unit };
    Ok(Comparison { old, new, changes })
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
