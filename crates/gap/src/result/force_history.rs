//! The force of an effect along the motion of the final model: what a picture of it shows.

use super::{Gap, Step};
use crate::decisions::PICTURE_SAMPLES;
use crate::place::{Effect, Site};
use phisindy_expr::{Scratch, Tape};
use phisindy_phys::unit::Unit;
use phisindy_phys::{LawRole, Record};

/// The force of an effect against a displacement, a velocity or the time, as the picture of its law is drawn.
#[derive(Clone, Debug)]
pub struct ForceHistory {
    /// What it is told against, in the language of the specs.
    pub over: String,
    /// The unit of that.
    pub over_unit: String,
    /// The unit of the force.
    pub unit: String,
    /// Whether it is a push, which adds to the motion, or a force that is subtracted.
    pub push: bool,
    /// Whether it is a force; a rate where the spec states no inertia.
    pub force: bool,
    /// Whether it depends on nothing else, so that its points lie on one line in each record.
    pub function: bool,
    /// For each record that the model could run along: its name, and places with forces, in rising order of the places where it is a
    /// function, else in the order of time. Of friction the samples in which it sticks are left out: there it is what the other forces ask for.
    pub records: Vec<(String, Vec<(f64, f64)>)>,
}

/// The force of a step in the final model of `found`, along its runs; `records` are those that were searched. `None` for what acts on a
/// sensor, or where no record could be run.
pub fn force_history(found: &Gap, step: &Step, records: &[Record]) -> Option<ForceHistory> {
    let effect = &step.effect;
    let Site::Force { displacement, velocity, state, .. } = &effect.place.site else { return None };
    let law = &effect.entry.law;
    let drawn = law.sketch.as_ref().and_then(|s| s.over.chars().next());
    let letter = drawn.unwrap_or(if law.role(LawRole::Velocity).is_some() { 'v' } else { 'x' });
    let system = &found.simulated.system;
    let (over, place, over_unit) = match (letter, displacement) {
        ('x', Some(x)) => (x.text.as_str(), x.node, "m"),
        ('t', _) => ("t", system.time, "s"),
        _ => (velocity.text.as_str(), velocity.node, "m/s"),
    };
    let graph = &system.graph;
    let sign = if law.push.is_some() { -1.0 } else { 1.0 };
    let (force, speed) = (step.force?, velocity.node);
    // The force alone: a load of the records is part of the expression already.
    let bare = Effect { load: None, ..effect.clone() };
    let unit = bare.unit("N", system);
    let over_unit = if letter == 't' { "s".to_owned() } else { bare.unit(over_unit, system) };
    let factor = |unit: &str| Unit::parse(unit).map_or(1.0, |u| u.factor);
    let (size, length) = (sign / factor(&unit), 1.0 / factor(&over_unit));
    let rest = graph.reachable_above(&[force], &[place]);
    let moving = system.states.iter().map(|s| s.node).chain(system.inputs.iter().map(|u| u.node));
    let function = moving.chain([system.time]).all(|id| id == place || !rest.contains(&id));
    let tape = Tape::compile(graph, &system.arguments(), &[place, force, speed]).ok()?;
    let mut scratch = Scratch::<1>::new(&tape);
    let mut out = Vec::new();
    for (r, record) in records.iter().enumerate() {
        let Some(run) = found.simulated.records.get(r).and_then(|fit| fit.run.as_ref()) else { continue };
        let numbers = numbers(found, record, r);
        let every = record.len().div_ceil(PICTURE_SAMPLES).max(1);
        let mut points = Vec::new();
        for (i, states) in run.states.chunks_exact(run.n).take(record.len()).enumerate().step_by(every) {
            let t = record.time[i];
            let inputs = record.inputs.iter().map(|u| u.value(t));
            scratch.at([t]
                .into_iter()
                .chain(states.iter().copied())
                .chain(inputs)
                .chain(numbers.iter().copied()));
            let [place, force, speed] = [0, 1, 2].map(|k| scratch.output(k)[0]);
            let held = law.sticks() && speed == 0.0;
            if !held && place.is_finite() && force.is_finite() {
                points.push((length * place, size * force));
            }
        }
        if function {
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            points.dedup();
        }
        if points.len() > 1 {
            out.push((record.name.clone(), points));
        }
    }
    let over = over.trim_start_matches('(').trim_end_matches(')').to_owned();
    (!out.is_empty()).then_some(ForceHistory {
        over,
        over_unit,
        unit,
        push: law.push.is_some(),
        force: system.inertia[*state].is_some(),
        function,
        records: out,
    })
}

/// The numbers of the final model in a record: its parameters, then the constants of the record.
fn numbers(found: &Gap, record: &Record, r: usize) -> Vec<f64> {
    let mut values: Vec<f64> = found.simulated.system.parameters.iter().map(|p| p.start).collect();
    let owner = record.continues.unwrap_or(r);
    for p in found.parameters.iter().filter(|p| p.id.holds_in(owner)) {
        if let Some(k) = p.id.constant() {
            values[k] = p.estimate.value;
        }
    }
    values.extend(&record.constants);
    values
}
