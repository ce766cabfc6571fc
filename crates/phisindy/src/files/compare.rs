//! Records of one machine over time, and of many machines: what changed, who stands out.
//!
//! ```text
//! older --unit--> its model, completed --+--all numbers free--> Estimates ---------------------------+
//! newer --its records in that model-------+--all numbers free--> Estimates if it explains them, or gap --+--> Comparison
//! ```

use super::load::{Purpose, open_text, spec_text};
use super::request::Request;
use crate::error::{Error, SpecError};
use crate::loaded::Loaded;
use crate::options::{Options, Progress};
use crate::{Gap, Identified};
use phisindy_compare::{Cause, Comparison, Estimates, Fleet, Number, Unit, changes, population};
use phisindy_gap::{Site, Status, Step};
use phisindy_learn::{FoundParameter, ParameterOf, SensorPart};
use phisindy_phys::spec::{self, ConstantSpec, DataSpec, Spec, Text};
use phisindy_phys::{Sources, splice, unit};
use phisindy_report::spec_text::{COMPLETED, named_data};
use phisindy_report::{CompareReport, SPEC};
use std::path::{Path, PathBuf};

/// A number may move by this factor in another record.
const REACH: f64 = 10.0;
/// What is believed of the gain of a sensor before it is asked: an exchanged or miscalibrated one seldom errs by more.
const GAIN_BELIEF: f64 = 0.1;
/// The start of the name of the constant that is a gain.
const GAIN: &str = "gain_of_";

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
    match paths {
        [old, new] => pair(old, new, request, options).map(|pair| CompareReport::Pair(Box::new(pair))),
        [] | [_] => Err("two specs or results are needed: the older one first".to_owned()),
        many => fleet(many, request, options).map(CompareReport::Fleet),
    }
}

/// What changed from one record of a machine to another.
fn pair(old: &Path, new: &Path, request: &Request, options: &Options<'_>) -> Result<Comparison, String> {
    let (older, newer) = (Source::of(old)?, Source::of(new)?);
    let (older_unit, model) = part(options, (0.0, 0.4), |options| judged(&older, request, options))?;
    let told = |why: Error| {
        format!("the model of `{}` with the records of `{}`: {}", old.display(), new.display(), words(&why))
    };
    let fit = |source: &Source, model: &str, (from, to)| -> Result<Estimates, String> {
        let text = all_free(model).map_err(told)?;
        let fitted = part(options, (from, to), |options| {
            source.opened(&text, request, Purpose::Run)?.identify(options)
        });
        Ok(estimates(&fitted.map_err(told)?))
    };
    let before = fit(&older, &model, (0.4, 0.5))?;
    let own =
        part(options, (0.4, 0.5), |options| older.opened(&model, request, Purpose::Run)?.identify(options));
    let known = known(&model, &estimates(&own.map_err(told)?));
    let moved = with_records_of(&model, &newer)?;
    let free = all_free(&moved).map_err(told)?;
    let open = |text: &str| newer.opened(text, request, Purpose::Gap).map_err(told);
    let free = open(&free)?.standing().map_err(told)?;
    let by_numbers = |holds: bool| {
        let status = if holds { Status::NothingMissing } else { Status::Unexplained };
        let (name, estimates) = (newer.name.clone(), fit(&newer, &moved, (0.5, 1.0))?);
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
            of_gap(&newer, &found, fit(&newer, text, (0.9, 1.0))?)
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
        let source = Source::of(path)?;
        units.push(part(options, (share(k), share(k + 1)), |options| judged(&source, request, options))?.0);
    }
    let all: Vec<Estimates> = units.iter().map(|unit| unit.estimates.clone()).collect();
    Ok(Fleet { population: population(&all), units })
}

/// Does a part of the work, from one fraction of the whole to another.
fn part<R>(options: &Options<'_>, (from, to): (f64, f64), work: impl FnOnce(&Options<'_>) -> R) -> R {
    let observe = |now: Progress<'_>| options.progress(from + (to - from) * now.fraction, now.activity);
    work(&Options { observe: Some(&observe), ..*options })
}

/// A spec, or the one in a folder of a result.
struct Source {
    /// As the user named it.
    name: String,
    /// Its file.
    path: PathBuf,
    text: String,
}

impl Source {
    fn of(path: &Path) -> Result<Source, String> {
        let shown = path.display();
        // What `run` was given has the dictionary; what `gap` found stands in the completed model.
        let file = if path.is_dir() {
            let models = [COMPLETED, SPEC].map(|name| path.join(name));
            models.into_iter().find(|file| file.is_file()).ok_or_else(|| {
                format!(
                    "`{shown}` is no folder of a result of this version: name one that `phisindy run SPEC --out DIR` or `phisindy gap SPEC --out DIR` wrote, or a spec"
                )
            })?
        } else {
            path.to_owned()
        };
        let text = spec_text(&file).map_err(|d| [vec![d.message], d.help].concat().join(": "))?;
        Ok(Source { name: shown.to_string(), path: file, text })
    }

    /// A text with the records of this spec.
    fn opened(&self, text: &str, request: &Request, purpose: Purpose) -> Result<Loaded, Error> {
        let named = named_data(&self.text).into_iter().map(str::to_owned).collect();
        open_text(text, &self.path, &Request { named_data: Some(named), ..request.clone() }, purpose)
    }

    fn parsed(&self) -> Result<Spec, String> {
        parsed(&self.text).map_err(|why| format!("`{}`: {}", self.name, words(&why)))
    }
}

fn parsed(text: &str) -> Result<Spec, Error> {
    let mut sources = Sources::default();
    let source = sources.add("the model", text.to_owned());
    let wrong = |mistakes| Error::from(SpecError::new(mistakes, sources));
    spec::read(text, source).map(|(spec, _)| spec).map_err(wrong)
}

/// Sets a field of a model.
fn set(text: &mut String, path: &str, value: &str) -> Result<(), Error> {
    *text = splice::set(text, path, value).map_err(Error::Set)?;
    Ok(())
}

/// What a record says of a machine by its own spec, and its completed model as a text in which all numbers that were
/// found may move.
fn judged(source: &Source, request: &Request, options: &Options<'_>) -> Result<(Unit, String), String> {
    let told = |why: Error| format!("`{}`: {}", source.name, words(&why));
    let loaded = source.opened(&source.text, request, Purpose::Run).map_err(told)?;
    if loaded.case.is_open() || source.parsed()?.unknown.iter().any(|(_, unknown)| !unknown.laws.is_empty()) {
        let found = loaded.identify(options).map_err(told)?;
        let model = found.model().map_err(told)?;
        let verdict = found.verdict();
        let (status, holds) = (verdict.word().to_owned(), verdict.holds());
        let unit =
            Unit { name: source.name.clone(), status, holds, causes: vec![], estimates: estimates(&found) };
        return Ok((unit, freed(&model, &found.loaded.parsed).map_err(told)?));
    }
    let found = part(options, (0.0, 0.8), |options| loaded.gap(options)).map_err(told)?;
    let model = if found.steps().is_empty() { source.text.clone() } else { found.result.completed.clone() };
    let fitted =
        part(options, (0.8, 1.0), |options| source.opened(&model, request, Purpose::Run)?.identify(options));
    Ok((of_gap(source, &found, estimates(&fitted.map_err(told)?)), model))
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
    let of_parameters =
        found.parameters().iter().map(|p| (named(label(p), &p.unit, p.factor), p.estimate.value));
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

/// What a number is called: of a gain that is asked for here, in words.
fn label(p: &FoundParameter) -> String {
    let name = p.id.to_string();
    name.strip_prefix(GAIN).map_or(name.clone(), |column| format!("gain of {column}"))
}

/// The identified model with its numbers free again: coefficients, and what the spec let move.
fn freed(model: &str, given: &Spec) -> Result<String, Error> {
    let mut text = model.to_owned();
    for (name, constant) in parsed(model)?.constants {
        let ConstantSpec::Number { value, unit } = constant else { continue };
        let before = given.constants.iter().find(|(n, _)| n.value == name.value).map(|(_, c)| c);
        let (low, high) = match before {
            Some(ConstantSpec::Movable(m)) => (m.within.0.value, m.within.1.value),
            Some(ConstantSpec::Find(f)) => (f.within.0.value, f.within.1.value),
            Some(_) => continue,
            None => (-REACH * value.value.abs(), REACH * value.value.abs()),
        };
        if low < value.value && value.value < high {
            let unit = unit.map_or(String::new(), |unit| format!(", unit: {:?}", unit.value));
            let free = format!("(value: {:?}{unit}, within: ({low:?}, {high:?}))", value.value);
            set(&mut text, &format!("constants.{}", quoted(&name.value)), &free)?;
        }
    }
    Ok(text)
}

/// A model with the records of another spec, and with the constants that this one holds.
fn with_records_of(model: &str, newer: &Source) -> Result<String, String> {
    let told =
        |why: String| format!("the records of `{}` do not fit into the other model: {why}", newer.name);
    let spec = newer.parsed()?;
    let entries = spec.data.iter().map(|data| match data {
        DataSpec::Csv(csv) => csv.span,
        DataSpec::Synthetic(made) => made.span,
    });
    let entries: Vec<&str> = entries.map(|span| &newer.text[span.start..span.end]).collect();
    let mut text = splice::set(model, "data", &format!("[{}]", entries.join(", ")))
        .map_err(|why| told(why.to_string()))?;
    let held = parsed(model).map(|spec| spec.constants).unwrap_or_default();
    for (name, constant) in &spec.constants {
        let was = held.iter().find(|(n, _)| n.value == name.value).map(|(_, c)| c);
        if let (
            ConstantSpec::Number { value, unit },
            Some(ConstantSpec::Number { value: before, unit: unit_before }),
        ) = (constant, was)
            && (value.value, unit.as_ref().map(|u| &u.value))
                != (before.value, unit_before.as_ref().map(|u| &u.value))
        {
            let unit = unit.as_ref().map(|unit| format!("({:?}, {:?})", value.value, unit.value));
            let now = unit.unwrap_or_else(|| format!("{:?}", value.value));
            text = splice::set(&text, &format!("constants.{}", quoted(&name.value)), &now)
                .map_err(|why| told(why.to_string()))?;
        }
    }
    Ok(text)
}

/// A part of a path in a spec.
fn quoted(name: &str) -> String {
    if name.chars().all(|c| c.is_alphanumeric() || c == '_') { name.to_owned() } else { format!("{name:?}") }
}

/// A model in which each number may move, the gains of all columns too: what changed need not be what was to be found.
/// A number that the record does not determine is held by a belief as wide as itself.
fn all_free(model: &str) -> Result<String, Error> {
    let spec = parsed(model)?;
    let measured = spec.data.iter().all(|data| matches!(data, DataSpec::Csv(_)));
    let mut text = model.to_owned();
    let written = |value: f64, unit: &Option<Text>, (low, high): (f64, f64), sigma: f64| {
        let unit = unit.as_ref().map_or(String::new(), |unit| format!(", unit: {:?}", unit.value));
        format!("Find(start: {value:?}{unit}, within: ({low:?}, {high:?}), sigma: {sigma:?})")
    };
    for (name, constant) in &spec.constants {
        let free = match constant {
            // Of a synthetic record the truth has these numbers.
            ConstantSpec::Number { value, unit } if value.value != 0.0 && measured => {
                let ends = (value.value / REACH, value.value * REACH);
                let ends = (ends.0.min(ends.1), ends.0.max(ends.1));
                written(value.value, unit, ends, value.value.abs())
            }
            ConstantSpec::Movable(m) if m.sigma.is_none() && !m.each && m.value.value != 0.0 => {
                let ends = (m.within.0.value, m.within.1.value);
                written(m.value.value, &m.unit, ends, m.value.value.abs())
            }
            ConstantSpec::Find(f) if f.sigma.is_none() && !f.each && f.start.value != 0.0 => {
                let ends = (f.within.0.value, f.within.1.value);
                written(f.start.value, &f.unit, ends, f.start.value.abs())
            }
            _ => continue,
        };
        set(&mut text, &format!("constants.{}", quoted(&name.value)), &free)?;
    }
    for name in if measured { columns(&spec) } else { vec![] } {
        let number = format!("{GAIN}{name}");
        let taken = spec.constants.iter().any(|(other, _)| other.value == number);
        let own = |data: &DataSpec| match data {
            DataSpec::Csv(csv) => {
                csv.sensors.iter().any(|(n, sensor)| n.value == name && sensor.gain.is_some())
            }
            DataSpec::Synthetic(_) => true,
        };
        if taken || spec.data.iter().any(own) {
            continue;
        }
        let free = written(1.0, &None, (1.0 / REACH, REACH), GAIN_BELIEF);
        set(&mut text, &format!("constants.{}", quoted(&number)), &free)?;
        for (k, data) in spec.data.iter().enumerate() {
            if names(data).contains(&name) {
                set(&mut text, &format!("data.{k}.sensors.{}.gain", quoted(&name)), &format!("{number:?}"))?;
            }
        }
    }
    Ok(text)
}

/// The numbers of a model: those that were found with their errors, those that it holds, and gains of 1.
fn known(model: &str, found: &Estimates) -> Estimates {
    let Ok(spec) = parsed(model) else { return found.clone() };
    let mut all = found.clone();
    let mut hold = |name: String, unit: &str, value: f64| {
        if all.position(&name).is_none() {
            let factor = unit::Unit::parse(unit).map_or(1.0, |unit| unit.factor);
            all.covariance.iter_mut().for_each(|row| row.push(0.0));
            all.covariance.push(vec![0.0; all.numbers.len() + 1]);
            all.numbers.push(Number { name, unit: unit.to_owned(), factor });
            all.values.push(value * factor);
        }
    };
    for (name, constant) in &spec.constants {
        if let ConstantSpec::Number { value, unit } = constant {
            hold(name.value.clone(), unit.as_ref().map_or("", |unit| &unit.value), value.value);
        }
    }
    columns(&spec).iter().for_each(|column| hold(format!("gain of {column}"), "", 1.0));
    all
}

/// The model as it was found in the older record: each number held, or within its error.
fn believed(model: &str, before: &Estimates, held: bool) -> Result<String, Error> {
    let mut text = model.to_owned();
    for (name, constant) in parsed(model)?.constants {
        let Some(k) = before.position(&name.value) else { continue };
        let factor = before.numbers[k].factor;
        let (value, sigma) = (before.values[k] / factor, before.std_error(k) / factor);
        let (unit, within) = match constant {
            ConstantSpec::Movable(m) if !m.each => (m.unit, m.within),
            ConstantSpec::Find(f) if !f.each => (f.unit, f.within),
            _ => continue,
        };
        let ends = (within.0.value, within.1.value);
        if ends.0 < value && value < ends.1 && sigma > 0.0 && sigma.is_finite() {
            let unit = unit.map(|unit| unit.value);
            let now = match (held, unit) {
                (true, None) => format!("{value:?}"),
                (true, Some(unit)) => format!("({value:?}, {unit:?})"),
                (false, unit) => {
                    let unit = unit.map_or(String::new(), |unit| format!(", unit: {unit:?}"));
                    format!("Find(start: {value:?}{unit}, within: {ends:?}, sigma: {sigma:?})")
                }
            };
            set(&mut text, &format!("constants.{}", quoted(&name.value)), &now)?;
        }
    }
    Ok(text)
}

/// The columns of a record that its spec uses.
fn names(data: &DataSpec) -> Vec<String> {
    match data {
        DataSpec::Csv(csv) => csv.columns.iter().map(|(name, _)| name.value.clone()).collect(),
        DataSpec::Synthetic(_) => vec![],
    }
}

/// Those of all records.
fn columns(spec: &Spec) -> Vec<String> {
    let mut all: Vec<String> = spec.data.iter().flat_map(names).collect();
    all.sort();
    all.dedup();
    all
}

/// An error as a line.
fn words(why: &Error) -> String {
    match why {
        Error::Spec(mistakes) => {
            let first = mistakes.mistakes().find(|d| d.is_error());
            first.map_or_else(|| mistakes.to_string(), |d| d.message.clone())
        }
        other => other.to_string(),
    }
}
