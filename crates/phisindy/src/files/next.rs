//! The next run: which one decides between the models that a result left, or best narrows a number.
//!
//! ```text
//! spec --gap--> the final model and its rivals --identify--> Rivals: numbers, errors --design--> ranked runs
//! spec --run--> the identified model ----------------------------------------+
//! ```

use super::compared_models::{freed, parsed};
use super::load::Purpose;
use super::request::Request;
use super::source::{Source, part, words};
use crate::error::Error;
use crate::options::Options;
use crate::{Gap, Identified, Status};
use phisindy_design::{Aim, Limits, Noise, Rival, design, possible};
use phisindy_learn::NoiseModel;
use phisindy_phys::spec::Role;
use phisindy_phys::splice;
use phisindy_report::{NextReport, Predicted, QuantityShown, model_name};
use phisindy_signal::standard_deviation;
use std::path::Path;

/// A model of this probability is left: a rarer one is seldom worth a run (`JUDGE`'s live laws, by convention).
const LIVE: f64 = 0.01;

/// Looks for the run after which most is known: between the models that a spec (or the folder of a result) leaves, or,
/// with `narrow`, of one number. The limits of the rig are those of the spec, or what its records have shown.
///
/// # Errors
/// In words: the spec cannot be read, nothing explains its records, or no run is possible.
///
/// ```no_run
/// use phisindy::{Options, files};
/// use std::path::Path;
/// let report = files::next(Path::new("found"), None, &files::Request::default(), &Options::default())?;
/// println!("{}", report.sentence());
/// # Ok::<(), String>(())
/// ```
pub fn next(
    path: &Path,
    narrow: Option<&str>,
    request: &Request,
    options: &Options<'_>,
) -> Result<NextReport, String> {
    let source = Source::given(path, &request.assignments)?;
    let laws = source.laws(request)?;
    let options = &Options { laws: options.laws.or(Some(&laws)), ..*options };
    // They stand in the text by now, and are not made in what comes of it.
    let request = &Request { assignments: vec![], ..request.clone() };
    let told = |why: Error| format!("`{}`: {}", source.name, words(&why));
    let left = left(&source, request, options)?;
    let fits = left.models.iter().enumerate().map(|(k, model)| {
        let span = |k: usize| 0.5 + 0.1 * k as f64 / left.models.len() as f64;
        part(options, (span(k), span(k + 1)), |options| source.fitted(&model.text, request, options))
    });
    let mut failed = Vec::new();
    let mut fitted: Vec<(&Model, Identified)> = Vec::new();
    for (model, fit) in left.models.iter().zip(fits) {
        match fit {
            Ok(found) => fitted.push((model, found)),
            Err(why) if fitted.is_empty() => return Err(told(why)),
            Err(why) => {
                failed.push(format!("{} is left out: it cannot be fitted ({})", model.name, words(&why)))
            }
        }
    }
    let all: f64 = fitted.iter().map(|(model, _)| model.weight).sum();
    let first = &fitted[0].1;
    let (system, records) = (&first.loaded.case.system, &first.loaded.records);
    let limits = Limits::of(&first.loaded.parsed, system, records);
    // A run that is let go or driven anew is like the first one that was fitted.
    let k = records.iter().position(|r| r.role == Role::Fit).unwrap_or(0);
    let measured: Vec<usize> = (0..system.columns()).filter(|&c| records[k].columns[c].is_some()).collect();
    let relative = first.result.noise_model == NoiseModel::Relative;
    let noise = measured.iter().zip(&first.records()[k].noise).map(|(&c, (_, sigma))| {
        let size = records[k].columns[c].as_deref().map_or(0.0, standard_deviation);
        match relative && size > 0.0 {
            // Zero is read exactly by no sensor.
            true => Noise { additive: 1e-3 * sigma, relative: sigma / size },
            false => Noise { additive: *sigma, relative: 0.0 },
        }
    });
    let noise: Vec<Noise> = noise.collect();
    let fits = records.iter().filter(|r| r.role == Role::Fit);
    let readings = fits.map(|r| r.readings() as f64).sum();
    let mut rivals = Vec::new();
    for (model, found) in &fitted {
        let mut systems = vec![found.loaded.case.system.clone()];
        for text in settings(&model.text, &limits).map_err(told)? {
            systems.push(source.opened(&text, request, Purpose::Run).map_err(told)?.case.system);
        }
        let record = found.loaded.records[k].clone();
        let numbers = (found.parameters(), found.result.covariance.as_slice());
        let rival = Rival::new((model.name.clone(), model.weight / all), systems, record, numbers, &noise);
        rivals.push(rival.settled(&limits, &found.records()[k].start));
    }
    let aim = match narrow {
        Some(name) => Aim::Narrow(name.to_owned()),
        None if rivals.len() > 1 => Aim::Separate,
        None => Aim::NarrowAll,
    };
    let found = part(options, (0.6, 1.0), |options| {
        design(&rivals, &limits, (&noise, &readings), &aim, &|fraction, activity| {
            options.progress(fraction, &activity.to_string())
        })
    });
    let found = found.map_err(|why| format!("`{}`: {why}", source.name))?;
    failed.extend(
        found
            .left_out
            .iter()
            .map(|(name, why)| format!("{name} is left out: it cannot be simulated ({why})")),
    );
    rivals.retain(|rival| found.left_out.iter().all(|(name, _)| *name != rival.name));
    let all: f64 = rivals.iter().map(|rival| rival.probability).sum();
    rivals.iter_mut().for_each(|rival| rival.probability /= all);
    let shown = |k: usize| {
        let (name, unit) = system.measured(k);
        QuantityShown { name: name.to_owned(), unit: unit.to_owned(), factor: system.factor(k) }
    };
    let units: Vec<f64> = measured.iter().map(|&k| system.factor(k)).collect();
    let best = &found.runs[0];
    let predicted = rivals
        .iter()
        .filter_map(|rival| {
            let response = rival.response(&best.trial, None).ok()?;
            Some(Predicted::of(&response.over(&units), units.len()))
        })
        .collect();
    let columns = measured.into_iter().map(shown).collect();
    let inputs = (0..system.inputs.len()).map(|k| shown(system.columns() + k)).collect();
    let numbers = first.parameters().iter().filter_map(|p| {
        let name = p.id.constant().map(|k| system.parameters[k].name.clone())?;
        Some(QuantityShown { name, unit: p.unit.clone(), factor: p.factor })
    });
    let set: Vec<String> = std::iter::once(String::new()).chain(set_words(&limits)).collect();
    Ok(NextReport {
        name: source.name.clone(),
        status: left.status,
        none: left.none,
        aim,
        limits,
        design: found,
        predicted,
        columns,
        inputs,
        numbers: numbers.collect(),
        settings: set,
        doubts: failed,
        rivals,
    })
}

/// A model that is left.
struct Model {
    name: String,
    weight: f64,
    text: String,
}

/// The models that are left, the best one first.
struct Left {
    status: String,
    none: Option<f64>,
    models: Vec<Model>,
}

fn left(source: &Source, request: &Request, options: &Options<'_>) -> Result<Left, String> {
    let told = |why: Error| format!("`{}`: {}", source.name, words(&why));
    let loaded = source.opened(&source.text, request, Purpose::Run).map_err(told)?;
    let (system, records) = (&loaded.case.system, &loaded.records);
    // Before any work: limits that leave no run leave none to any model.
    if let Some(like) = records.iter().find(|r| r.role == Role::Fit) {
        let limits = Limits::of(&loaded.parsed, system, records);
        possible(system, like, &limits).map_err(|why| format!("`{}`: {why}", source.name))?;
    }
    let named =
        parsed(&source.text).map_err(told)?.unknown.iter().any(|(_, unknown)| !unknown.laws.is_empty());
    if loaded.case.is_open() || named {
        let found = part(options, (0.0, 0.5), |options| loaded.identify(options)).map_err(told)?;
        let text = found.model().and_then(|model| freed(&model, &found.loaded.parsed)).map_err(told)?;
        let models = vec![Model { name: "the identified model".to_owned(), weight: 1.0, text }];
        return Ok(Left { status: found.verdict().word().to_owned(), none: None, models });
    }
    let found = part(options, (0.0, 0.5), |options| loaded.gap(options)).map_err(told)?;
    let status = found.status();
    // Where the model as it is leaves only noise, it is left, though a law may be there too.
    let explains = status != Status::Unexplained || !found.steps().is_empty();
    if !explains {
        return Err(format!(
            "`{}` is {}: no model is left that a run could decide on; `phisindy gap {}` shows what the missing force depends on",
            source.name,
            status.name(),
            source.name
        ));
    }
    Ok(Left { status: status.name().to_owned(), none: found.result.none, models: models(source, &found) })
}

/// The final model of a search, and its rivals by their odds.
fn models(source: &Source, found: &Gap) -> Vec<Model> {
    let steps = found.steps();
    let text = if steps.is_empty() { source.text.clone() } else { found.result.completed.clone() };
    let mut all = vec![Model { name: model_name(steps), weight: 1.0, text }];
    for rival in steps.iter().flat_map(|step| &step.rivals) {
        let Some(text) = &rival.completed else { continue };
        if all.iter().all(|other| other.text != *text) {
            let laws: Vec<String> = rival.laws.iter().map(ToString::to_string).collect();
            all.push(Model {
                name: laws.join(" + "),
                weight: (-0.5 * rival.behind).exp(),
                text: text.clone(),
            });
        }
    }
    let sum: f64 = all.iter().map(|model| model.weight).sum();
    all.retain(|model| model.weight > LIVE * sum);
    all.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    all
}

/// The model with each constant that can be set at either end of its range.
fn settings(text: &str, limits: &Limits) -> Result<Vec<String>, Error> {
    let mut all = Vec::new();
    for range in &limits.constants {
        for end in [range.within.0, range.within.1] {
            let value = end / range.factor;
            let written = match range.unit.as_str() {
                "" => format!("{value:?}"),
                unit => format!("({value:?}, {unit:?})"),
            };
            all.push(splice::set_at(text, &["constants", &range.name], &written)?);
        }
    }
    Ok(all)
}

/// The same settings in words.
fn set_words(limits: &Limits) -> impl Iterator<Item = String> {
    let of = |range: &phisindy_design::Range| {
        [range.within.0, range.within.1].map(|end| {
            format!("{} = {} {}", range.name, end / range.factor, range.unit).trim_end().to_owned()
        })
    };
    limits.constants.iter().flat_map(of)
}
