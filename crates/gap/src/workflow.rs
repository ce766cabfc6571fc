//! The whole workflow: noise, where, what, add, how it ends.

use crate::causes::{causes, inputs};
use crate::clock::clock;
use crate::draft::Draft;
use crate::drive::Drive;
use crate::effect::{Effect, Entry};
use crate::evidence::against;
use crate::fitted::{Fitted, current, noise};
use crate::found::{Gap, GapError, Rival, Simulated, Status, Step, StepParameter};
use crate::held::held;
use crate::mistaken::mistaken;
use crate::refine::refitted;
use crate::region::regions;
use crate::repeat::{Repeat, prediction, repeatability};
use crate::search::{self, Measure, Search, Searched, label};
use crate::verdict::{helpful, refused, status};
use phisindy_learn::{Effort, at_bounds, dead_column, sensitive_starts};
use phisindy_phys::spec::Role;
use phisindy_phys::{Case, Record, System, splice};
use phisindy_signal::standard_deviation;
use std::ops::ControlFlow;

/// A motion that is followed to this many times what it repeats to is explained.
const REPEATS: f64 = 1.25;
/// A motion whose cycles differ by more than this many times the noise has a scatter of its own.
const SCATTERS: f64 = 5.0;
/// Samples of the Fit records that a search looks at.
const LOOK: usize = 6_000;
/// What is left when an effect is kept although something else is missing too: each must have brought the gap down by this factor.
const SUBSTANTIAL: f64 = 3.0;

/// A gap above this on Fit records is not the work of one constant.
const MUCH: f64 = 5.0;

/// Runs the gap workflow on a checked spec and its records. `observe` hears a fraction and what is being done, and may stop the search.
///
/// # Errors
/// Records from which nothing can be learned; a model that cannot be simulated from any start.
///
/// ```
/// use phisindy_gap::{Entry, Status, gap};
/// use phisindy_phys::{Law, Origin, SourceId, check, spec};
/// use phisindy_sim::synthesize;
/// use std::{ops::ControlFlow, sync::Arc};
/// // A pendulum that is believed to swing without friction.
/// let text = r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") }, known: { "x": "v", "v": "-k*x" }, unknown: {},
///     data: [ Synthetic(truth: { "v": "-0.05*sgn(v)" }, start: { "x": 2.0, "v": 0.0 }, duration: 40.0, step: 0.05, noise: Additive(0.02), seed: 1) ])"#;
/// let (spec, _) = spec::read(text, SourceId(0)).unwrap();
/// let (case, _) = check(&spec, SourceId(0)).unwrap();
/// let Origin::Synthetic(truth) = &case.records[0].origin else { panic!("a measured record") };
/// let (record, _) = synthesize(&case.records[0], truth, &case.system, None, &|_| Err("no files here".into())).unwrap();
/// let law = Law::read(r#"(name: "Coulomb friction", roles: { "v": "m/s" }, parameters: { "Fc": (unit: "N", within: (0.0, 10.0)) }, force: "Fc*sgn(v)", family: "friction")"#);
/// let catalogue = [Entry { id: "coulomb".into(), law: Arc::new(law.unwrap()) }];
/// let found = gap(text, case, vec![record], &catalogue, &mut |_, _| ControlFlow::Continue(())).unwrap();
/// assert_eq!((found.status, found.steps[0].effect.place.at.as_str()), (Status::Explained, "v"));
/// assert!((found.steps[0].parameters[0].value - 0.05).abs() < 1e-3);
/// ```
pub fn gap(
    text: &str,
    case: Case,
    records: Vec<Record>,
    catalogue: &[Entry],
    observe: &mut dyn FnMut(f64, &str) -> ControlFlow<()>,
) -> Result<Gap, GapError> {
    if !records.iter().any(|r| r.role == Role::Fit) {
        return Err(GapError::Data(
            "no record has the role Fit, so there is nothing to compare with: take `role: Validate` off one of them".into(),
        ));
    }
    for record in &records {
        if record.len() < 64 {
            return Err(GapError::Data(format!(
                "{}: {} samples are too few to tell noise from motion (64 at least): take a longer window, or decimate less",
                record.name,
                record.len()
            )));
        }
    }
    if let Some(why) = records.iter().find_map(|r| dead_column(&case.system, r)) {
        return Err(GapError::Data(why.to_string()));
    }
    let mut warnings = Vec::new();
    if case.is_open() {
        let what = if case.system.terms.is_empty() { "names laws" } else { "has candidates" };
        warnings.push(format!("`unknown` {what}: `gap` leaves them out and searches the catalogue instead"));
    }
    let noise = noise(&records);
    mostly_noise(&case.system, &records, &noise)?;
    let (repeat, floor) = floor(&case, &records, &noise);
    let mut hear = |part: f64, what: &str| observe(part, what).is_break();
    let mut search = Search { catalogue, noise: &noise, floor, hear: &mut hear, veto: &against };
    let cannot = |e: String| GapError::Numerics(format!("the model as it is cannot be simulated: {e}"));
    let whole = without_candidates(text, case, records).map_err(cannot)?;
    // A look needs no more samples than this; the numbers come from all of them.
    let short = shortened(&whole.records);
    let searched = match &short {
        Some(short) => {
            let mut found =
                search.run(Draft::base(&whole.text, whole.case.clone(), short.clone())).map_err(cannot)?;
            found.base = Fitted::new(whole.clone(), &noise, Effort::Plain).map_err(cannot)?;
            let full =
                whole.with_all(&current(&found.last)).and_then(|d| Fitted::new(d, &noise, Effort::Plain));
            found.last = full.unwrap_or_else(|_| found.base.clone());
            found
        }
        None => search.run(whole).map_err(cannot)?,
    };
    finished(searched, &mut search, repeat, warnings)
}

/// The part of a column's standard deviation that may be noise.
const NOISY: f64 = 0.8;

/// Where every column of a record that is to be fitted is noise above all, any model would leave noise.
fn mostly_noise(system: &System, records: &[Record], noise: &[Vec<f64>]) -> Result<(), GapError> {
    for (record, noise) in records.iter().zip(noise).filter(|(r, _)| r.role == Role::Fit) {
        let share = |k: usize| record.columns[k].as_ref().map(|c| noise[k] / standard_deviation(c));
        let shares: Vec<f64> = (0..system.states.len()).filter_map(share).collect();
        if shares.iter().all(|s| *s > NOISY) {
            return Err(GapError::Data(format!(
                "{}: what was measured is mostly noise ({:.0} % of it): no motion to explain",
                record.name,
                100.0 * shares.iter().copied().fold(1.0, f64::min)
            )));
        }
    }
    Ok(())
}

/// The model that is believed complete: what the spec only asks about is no part of it.
fn without_candidates(text: &str, case: Case, records: Vec<Record>) -> Result<Draft, String> {
    let asks = case.is_open();
    let whole = Draft::base(text, case, records);
    if !asks {
        return Ok(whole);
    }
    let text = splice::set(text, "unknown", "{}").map_err(|e| e.to_string())?;
    whole.rebuilt(text, vec![], vec![])
}

/// The beginnings of long records, for the search; `None` if none is long.
pub(crate) fn shortened(records: &[Record]) -> Option<Vec<Record>> {
    let fits = records.iter().filter(|r| r.role == Role::Fit).count().max(1);
    let most = LOOK / fits;
    let long = records.iter().any(|r| r.len() > most + most / 2);
    long.then(|| {
        records
            .iter()
            .map(|r| {
                let n = r.len().min(most);
                let mut out = r.clone();
                out.time = r.time[..n].into();
                out.columns = r.columns.iter().map(|c| c.as_ref().map(|c| c[..n].to_vec())).collect();
                // Cut off from the run that it continued.
                out.continues = None;
                out
            })
            .collect()
    })
}

/// Repeatability of every column, and the gap that it stands for on the Validate records (on all if there are none); 0 where the motion is not periodic.
fn floor(case: &Case, records: &[Record], noise: &[Vec<f64>]) -> (Vec<(String, String, Repeat)>, f64) {
    let validates = records.iter().any(|r| r.role == Role::Validate);
    let mut all = Vec::new();
    let (mut sum, mut count) = (0.0, 0usize);
    let mut periodic = true;
    for (r, record) in records.iter().enumerate() {
        for (k, column) in record.columns.iter().enumerate() {
            let Some(column) = column else { continue };
            let counts = !validates || record.role == Role::Validate;
            // The larger of the scatter within a record and of the step from one half to the next.
            let own = repeatability(record, column).filter(|r| {
                Drive::new(&case.system, record).is_some_and(|mut drive| drive.repeats(r.period))
            });
            let carried = record.continues.and_then(|before| {
                let earlier = records[before].columns[k].as_ref()?;
                prediction(&records[before], earlier, record, column)
            });
            let larger = match (own, carried) {
                (Some(a), Some(b)) => Some(if a.rms > b.rms { a } else { b }),
                (own, _) => own,
            };
            match larger {
                Some(found) => {
                    if counts {
                        sum += (found.rms / noise[r][k]).powi(2) * column.len() as f64;
                        count += column.len();
                    }
                    all.push((record.name.clone(), case.system.states[k].name.clone(), found));
                }
                None => periodic &= !counts,
            }
        }
    }
    let gap = if periodic && count > 0 { (sum / count as f64).sqrt() } else { 0.0 };
    // Near the noise it is the noise that does not repeat, not the rig.
    (all, if gap > SCATTERS { gap } else { 0.0 })
}

fn finished(
    searched: Searched,
    search: &mut Search<'_>,
    repeat: Vec<(String, String, Repeat)>,
    mut warnings: Vec<String>,
) -> Result<Gap, GapError> {
    let (noise, floor) = (search.noise, search.floor);
    let Searched { base, last, rounds, candidates, stopped } = searched;
    // What a model that leaves nothing but noise leaves is the noise: a better estimate than the one from the columns.
    let told = if last.is_white() { Some(last.noise(noise)) } else { None };
    let noise = told.as_deref().unwrap_or(noise);
    let (base, last) = (base.measured_by(noise), last.measured_by(noise));
    warnings.extend(mistaken(&base));
    (search.hear)(0.92, "error bars");
    // Each effect's part: the models on the way.
    let mut way = way(&base, &last, noise);
    // An effect that the model does as well without does not belong to it.
    let mut last = last;
    while let [.., before] = &way[..]
        && way.len() > 1
        && {
            let by = Measure::of([before, &last], candidates);
            by.score(before) <= by.score(&last) && (before.is_white() || !last.is_white())
        }
    {
        last = before.clone();
        way.pop();
    }
    let mut count = last.draft.effects.len();
    let mut last = with_errors(last, noise)?;
    if count > 0 {
        way.push(last.clone());
    }
    let repeats = floor > 0.0 && last.carried.unwrap_or(last.fit) <= REPEATS * floor;
    let mut status = status(&last, repeats, &mut warnings);
    let whole = last.clone();
    // Where much is missing no constant is to blame alone.
    let mut instead = None;
    if status != Status::NothingMissing && !repeats && !stopped && whole.fit < MUCH {
        (search.hear)(0.95, "constants that are held");
        if let Some(found) = held(&whole, search.catalogue, noise, candidates) {
            if found.much_better {
                status = Status::Unexplained;
            }
            instead = Some(found.text);
        }
    }
    if status == Status::Unexplained {
        (search.hear)(0.97, "other causes");
        let off = if instead.is_none() && !stopped { clock(&base, search) } else { None };
        // Beside a drive at the wrong frequency no effect means anything.
        let nothing_holds = off.as_ref().is_some_and(|off| off.explains);
        let helps = if nothing_holds { 0 } else { helpful(&way) };
        match off {
            Some(off) if nothing_holds => instead = Some(off.text),
            off => {
                warnings.extend(off.map(|off| off.text));
                let rest = way[helps..].iter().skip(1).enumerate();
                warnings.extend(rest.filter_map(|(k, with)| refused(&whole, helps + k, &way[helps], with)));
            }
        }
        if helps < count {
            way.truncate(helps + 1);
            last = with_errors(way[helps].clone(), noise)?;
            way[helps] = last.clone();
            count = helps;
        }
        if instead.is_none() && !stopped {
            instead = inputs(&last, noise);
        }
        warnings.extend(causes(&base, &last));
    }
    warnings.extend(instead.clone());
    warnings.extend(at_bounds(&last.cal.parameters).iter().map(ToString::to_string));
    warnings.extend(sensitive_starts(&last.cal.records).iter().map(ToString::to_string));
    let steps: Vec<Step> = (0..count)
        .map(|k| {
            let (effect, names, expression) = &last.draft.effects[k];
            let round = rounds.iter().rev().find(|r| r.before <= k);
            let (a, b) = (&way[k], &way[k + 1]);
            Step {
                effect: effect.clone(),
                expression: expression.clone(),
                parameters: parameters(&last, effect, names),
                fit: (a.fit, b.fit),
                validate: a.validate.zip(b.validate),
                delta_bic: {
                    let by = Measure::of([a, b], candidates);
                    by.score(a) - by.score(b)
                },
                rivals: round.map_or(vec![], |r| {
                    r.rivals
                        .iter()
                        .filter(|v| !part_of(v, &last))
                        .map(|v| Rival { law: v.law.clone(), at: v.at.clone(), delta_bic: v.worse })
                        .collect()
                }),
                vetoed: round.map_or(vec![], |r| r.vetoed.clone()),
            }
        })
        .collect();
    let (steps, partial) = if status == Status::Unexplained {
        // What brought the gap far down is a finding of its own, whatever else is missing. Of two stops the first helps little until the second is there.
        let gap = |of: (f64, f64), validate: Option<(f64, f64)>| validate.unwrap_or(of);
        let first = steps.first().map_or(1.0, |s| gap(s.fit, s.validate).0);
        let kept = (1..=steps.len())
            .rev()
            .find(|&k| {
                let s = &steps[k - 1];
                let (before, after) = gap(s.fit, s.validate);
                first > SUBSTANTIAL.powi(k as i32) * after && before > SUBSTANTIAL * after
            })
            .unwrap_or(0);
        let mut steps = steps;
        let partial = steps.split_off(kept);
        (steps, partial)
    } else {
        (steps, vec![])
    };
    for (law, why) in rounds.iter().flat_map(|r| &r.vetoed) {
        let text = format!("{law} fits, but evidence speaks against it: {why}");
        if !warnings.contains(&text) {
            warnings.push(text);
        }
    }
    let system = &last.draft.case.system;
    let columns: Vec<(String, f64)> = (0..base.draft.case.system.states.len())
        .filter_map(|k| {
            let of: Vec<f64> = base
                .draft
                .records
                .iter()
                .zip(noise)
                .filter(|(r, _)| r.columns[k].is_some())
                .map(|(_, n)| n[k])
                .collect();
            let mean = (of.iter().map(|s| s * s).sum::<f64>() / of.len().max(1) as f64).sqrt();
            (!of.is_empty()).then(|| (system.states[k].name.clone(), mean))
        })
        .collect();
    let mut nrmse = Vec::new();
    for (a, b) in last.cal.records.iter().zip(&base.cal.records) {
        for ((column, after), (_, before)) in a.nrmse.iter().zip(&b.nrmse) {
            nrmse.push((a.name.clone(), a.role, column.clone(), *before, *after));
        }
    }
    Ok(Gap {
        status,
        noise: columns,
        located: regions(&base.draft.case.system, &base.draft.records, &base.cal, noise),
        left: regions(system, &last.draft.records, &last.cal, noise),
        steps,
        partial,
        before: (base.fit, base.validate),
        after: (last.fit, last.validate),
        carried: last.carried,
        instead,
        nrmse,
        repeat,
        colour: (base.colour, last.colour),
        parameters: last.cal.parameters.clone(),
        completed: last.draft.text.clone(),
        was: Simulated::of(base),
        simulated: Simulated::of(last),
        warnings,
        stopped,
    })
}

/// Whether all of a rival is in the model by now.
fn part_of(rival: &search::Rival, last: &Fitted) -> bool {
    let own = label(&last.draft, 0);
    rival.law.split(" + ").zip(rival.at.split(", ")).all(|named| own.contains(&named))
}

/// A fit once more, with the errors of its numbers.
fn with_errors(last: Fitted, noise: &[Vec<f64>]) -> Result<Fitted, GapError> {
    let settled = last.settled().map_err(GapError::Numerics)?;
    Ok(match Fitted::new(settled, noise, Effort::Errors) {
        Ok(fitted) if fitted.fit.is_finite() => fitted,
        _ => last,
    })
}

/// The model as it was, with the first effect, with the first two, and so on, but for the last.
fn way(base: &Fitted, last: &Fitted, noise: &[Vec<f64>]) -> Vec<Fitted> {
    let mut way = vec![base.clone()];
    let (plain, effects) = (last.draft.without_effects(), current(last));
    for k in 1..effects.len() {
        let fitted = plain.with_all(&effects[..k]).ok().and_then(|d| refitted(d, last, noise));
        let before = way[way.len() - 1].clone();
        way.push(fitted.filter(|f| f.fit.is_finite()).unwrap_or(before));
    }
    way
}

/// The numbers of an effect in the final model.
fn parameters(last: &Fitted, effect: &Effect, names: &[String]) -> Vec<StepParameter> {
    let labels = effect.labels();
    let mut out = Vec::new();
    for (name, label) in names.iter().zip(labels) {
        let found =
            last.cal.parameters.iter().find(|p| {
                p.id.constant().is_some_and(|k| last.draft.case.system.parameters[k].name == *name)
            });
        if let Some(p) = found {
            let f = p.factor;
            out.push(StepParameter {
                name: label,
                constant: name.clone(),
                value: p.estimate.value / f,
                ci95: (p.estimate.ci95.0 / f, p.estimate.ci95.1 / f),
                unit: p.unit.clone(),
            });
        }
    }
    out
}
