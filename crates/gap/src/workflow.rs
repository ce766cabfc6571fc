//! The whole workflow: noise estimate, search, other explanations, verdict.

use crate::decisions::{EXPLAINED, FEWEST_SAMPLES, MOSTLY_NOISE, SCATTERS};
use crate::drive::Drive;
use crate::ending::Ending;
use crate::model::{Fitted, SpecTextError, TrialModel, current, noise_of, shortened};
use crate::repeat::{prediction, repeatability};
use crate::result::{Activity, ColumnRepeat, DataError, Gap, GapError, ModelError, StopReason, Warning};
use crate::search::{Observe, Observer, Search, Searched, at_floor};
use phisindy_learn::{Effort, dead_column};
use phisindy_phys::spec::{self, Role, Spec};
use phisindy_phys::{Case, LawEntry, Record, SourceId, System, splice};
use std::ops::ControlFlow;

/// Runs the gap workflow on a checked spec and its records. `observe` receives the progress as a fraction and
/// an activity, and may stop the search.
///
/// # Errors
/// The records are unsuitable, or the model cannot be simulated from any start.
///
/// ```
/// use phisindy_gap::{Status, gap};
/// use phisindy_phys::{LawEntry, Origin, SourceId, check, spec};
/// use phisindy_sim::synthesize;
/// use std::ops::ControlFlow;
/// // An oscillator whose model has no friction.
/// let text = r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") },
///     known: { "x": "v", "v": "-k*x" }, unknown: {},
///     data: [ Synthetic(truth: { "v": "-0.05*sgn(v)" }, start: { "x": 2.0, "v": 0.0 },
///         duration: 40.0, step: 0.05, noise: Additive(0.02), seed: 1) ])"#;
/// let (spec, _) = spec::read(text, SourceId(0)).unwrap();
/// let (case, _) = check(&spec, SourceId(0)).unwrap();
/// let Origin::Synthetic(truth) = &case.records[0].origin else { panic!("a measured record") };
/// let (record, _) =
///     synthesize(&case.records[0], truth, &case.system, None, &|_| Err("no files here".into())).unwrap();
/// let law = r#"(name: "Coulomb friction", roles: { "v": "m/s" }, force: "Fc*sgn(v)", family: "friction",
///     parameters: { "Fc": (unit: "N", within: (0.0, 10.0)) })"#;
/// let catalogue = [LawEntry::read("coulomb", law).unwrap()];
/// let found = gap(text, case, vec![record], &catalogue, &mut |_, _| ControlFlow::Continue(())).unwrap();
/// assert_eq!((found.status, found.steps[0].effect.place.at.as_str()), (Status::Explained, "v"));
/// assert!((found.steps[0].parameters[0].value - 0.05).abs() < 1e-3);
/// ```
pub fn gap(
    text: &str,
    case: Case,
    records: Vec<Record>,
    catalogue: &[LawEntry],
    observe: &mut (dyn FnMut(f64, Activity) -> ControlFlow<()> + Send),
) -> Result<Gap, GapError> {
    suitable(&case.system, &records)?;
    let unreadable = || GapError::Data(DataError::Spec(text.to_owned()));
    let (spec, _) = spec::read_with_files(text, SourceId(0), &case.system.files).map_err(|_| unreadable())?;
    let mut warnings = Vec::new();
    if case.is_open() {
        warnings.push(Warning::UnknownLeftOut { candidates: !case.system.terms.is_empty() });
    }
    let text = if case.is_open() { without_unknown(text)? } else { text.to_owned() };
    let whole = without_candidates(spec, case, records).ok_or_else(unreadable)?;
    let mut observe = |part: f64, what: Activity| observe(part, what).is_break();
    Observer::during(&mut observe, |observer| {
        observer.tell(0.0, Activity::Calibrating);
        let whole = whole.stopped_by(observer.stop());
        let short = shortened(&whole.records).map(|records| whole.for_records(records));
        let noise = least_noise(short.as_ref().unwrap_or(&whole), noise_of(&whole.records));
        mostly_noise(&whole.records, &noise)?;
        let (repeat, floor) = floor(&whole.system, &whole.records, &noise);
        let mut search = Search { catalogue, noise: &noise, floor, observer };
        let searched = from_estimate_or_rest(&mut search, whole, short).map_err(GapError::Numerics)?;
        Ending::new(searched, &mut search, warnings)?.finished(&text, repeat)
    })
}

/// How a model does as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// Its gap, on Validate records if there are any.
    pub gap: f64,
    /// The samples that this is the mean of.
    pub samples: usize,
    /// Whether its free runs leave no more than noise, or the scatter of the rig.
    pub explains: bool,
}

/// How a model does as it is: a fit, and no search.
///
/// # Errors
/// As [`gap`].
pub fn standing(spec: Spec, case: Case, records: Vec<Record>) -> Result<Standing, GapError> {
    suitable(&case.system, &records)?;
    let noise = noise_of(&records);
    let fitted = Fitted::new(TrialModel::base(spec, case, records), &noise, Effort::Plain);
    let fitted = fitted.map_err(GapError::Numerics)?;
    let model = &fitted.model;
    let (_, floor) = floor(&model.system, &model.records, &fitted.least_noise(&noise));
    let fitted = fitted.clone().measured_by(&fitted.noise_left(&noise));
    let explains = fitted.score.explains() || at_floor(&fitted, floor);
    Ok(Standing { gap: fitted.score.gap(), samples: fitted.score.judged, explains })
}

/// Searches from the estimate of the states that only outputs tell. Where nothing explains the data from
/// there, the search is repeated with those states at rest: the estimate takes what the model lacks for an
/// unknown force, and may lead astray.
fn from_estimate_or_rest(
    search: &mut Search<'_>,
    whole: TrialModel,
    short: Option<TrialModel>,
) -> Result<Searched, ModelError> {
    let first = on_shortened(search, whole.clone(), short.clone())?;
    let ended = matches!(first.stop, StopReason::Interrupted | StopReason::Pushes);
    if ended || search.explained(&first.last) {
        return Ok(first);
    }
    let Some(rest) = whole.at_rest() else { return Ok(first) };
    match on_shortened(search, rest, short.as_ref().and_then(TrialModel::at_rest)) {
        Ok(second) if search.explained(&second.last) || second.last.score.gap() < first.last.score.gap() => {
            Ok(second)
        }
        _ => Ok(first),
    }
}

/// Searches on shortened records, if there are any; the final parameters come from all samples. Where the
/// beginning of the Fit records is explained and the rest is not, the beginning does not stand for the whole:
/// a tester may have gone at one speed first. Then the whole is searched.
fn on_shortened(
    search: &mut Search<'_>,
    whole: TrialModel,
    short: Option<TrialModel>,
) -> Result<Searched, ModelError> {
    let Some(short) = short else { return described(search, whole) };
    let mut searched = described(search, short)?;
    let full = whole.with_all(&current(&searched.last)).ok();
    let full = full.and_then(|model| Fitted::new(model, search.noise, Effort::Plain).ok());
    let stands_for_all =
        full.as_ref().is_some_and(|full| full.score.fit <= EXPLAINED || search.at_floor(full));
    if searched.last.score.fit <= EXPLAINED && !stands_for_all && searched.stop != StopReason::Interrupted {
        return described(search, whole);
    }
    // Of a search that was stopped no fit goes on: it starts where the one on the beginning ended.
    let stopped = search.observer.stopped();
    let whole = if stopped { whole.starting_at(&searched.base.estimates(|p| !p.each)) } else { whole };
    searched.base = Fitted::new(whole, search.noise, Effort::Plain)?;
    searched.last = full.unwrap_or_else(|| searched.base.clone());
    Ok(searched)
}

/// The noise of every measured column by record: what the columns tell, but no more than the model as it is leaves.
fn least_noise(model: &TrialModel, noise: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    match Fitted::new(model.clone(), &noise, Effort::Plain) {
        Ok(fitted) => fitted.least_noise(&noise),
        Err(_) => noise,
    }
}

/// The search of the catalogue, and where it ends without an explanation that of a formula.
fn described(search: &mut Search<'_>, model: TrialModel) -> Result<Searched, ModelError> {
    let searched = search.run_until_determined(model)?;
    Ok(search.described(searched))
}

/// Checks that the records can be searched.
fn suitable(system: &System, records: &[Record]) -> Result<(), GapError> {
    if !records.iter().any(|r| r.role == Role::Fit) {
        return Err(GapError::Data(DataError::NoFit));
    }
    if let Some(short) = records.iter().find(|r| r.len() < FEWEST_SAMPLES) {
        let (record, samples) = (short.name.clone(), short.len());
        return Err(GapError::Data(DataError::FewSamples { record, samples, least: FEWEST_SAMPLES }));
    }
    match records.iter().find_map(|r| dead_column(system, r)) {
        Some(why) => Err(GapError::Data(DataError::DeadColumn(why))),
        None => Ok(()),
    }
}

/// Rejects a Fit record whose columns are all mostly noise: any model would leave noise.
fn mostly_noise(records: &[Record], noise: &[Vec<f64>]) -> Result<(), GapError> {
    for (record, noise) in records.iter().zip(noise).filter(|(r, _)| r.role == Role::Fit) {
        let columns = (0..record.columns.len()).filter(|&k| record.columns[k].is_some());
        let shares: Vec<f64> = columns.zip(noise).map(|(k, noise)| noise / record.deviation(k)).collect();
        if shares.iter().all(|s| *s > MOSTLY_NOISE) {
            let share = shares.iter().copied().fold(1.0, f64::min);
            return Err(GapError::Data(DataError::MostlyNoise { record: record.name.clone(), share }));
        }
    }
    Ok(())
}

/// The text of a spec without its candidates and laws.
fn without_unknown(text: &str) -> Result<String, GapError> {
    let wrong = |why: splice::SetError| SpecTextError { path: "unknown".into(), why: why.to_string() };
    splice::set(text, "unknown", "{}").map_err(|why| GapError::Numerics(wrong(why).into()))
}

/// The model without the candidates and laws of `unknown`.
fn without_candidates(spec: Spec, case: Case, records: Vec<Record>) -> Option<TrialModel> {
    let open = case.is_open();
    let whole = TrialModel::base(spec.clone(), case, records);
    if open { whole.variant(Spec { unknown: vec![], ..spec }) } else { Some(whole) }
}

/// Repeatability of every column, and the gap that corresponds to it on the Validate records (on all records
/// if there are none). The gap is 0 where the motion is not periodic.
fn floor(system: &System, records: &[Record], noise: &[Vec<f64>]) -> (Vec<ColumnRepeat>, f64) {
    let validates = records.iter().any(|r| r.role == Role::Validate);
    let mut all = Vec::new();
    let (mut sum, mut count) = (0.0, 0usize);
    let mut periodic = true;
    for (r, record) in records.iter().enumerate() {
        let measured = (0..record.columns.len()).filter_map(|k| Some((k, record.own_column(k)?)));
        for ((k, (time, column)), noise) in measured.zip(&noise[r]) {
            let counts = !validates || record.role == Role::Validate;
            // The larger of the scatter within a record and the change from one half to the next.
            let own = repeatability(&time, &column)
                .filter(|r| Drive::new(system, record).is_some_and(|mut drive| drive.repeats(r.period)));
            let carried = record.continues.and_then(|before| {
                let (earlier, before) = records[before].own_column(k)?;
                prediction((&earlier, &before), (&time, &column))
            });
            let larger = match (own, carried) {
                (Some(a), Some(b)) => Some(if a.rms > b.rms { a } else { b }),
                (own, _) => own,
            };
            match larger {
                Some(found) => {
                    if counts {
                        sum += (found.rms / noise).powi(2) * column.len() as f64;
                        count += column.len();
                    }
                    all.push(ColumnRepeat {
                        record: record.name.clone(),
                        column: system.measured(k).0.to_owned(),
                        repeat: found,
                    });
                }
                None => periodic &= !counts,
            }
        }
    }
    let gap = if periodic && count > 0 { (sum / count as f64).sqrt() } else { 0.0 };
    // Near the noise level the scatter is measurement noise, not the rig.
    (all, if gap > SCATTERS { gap } else { 0.0 })
}
