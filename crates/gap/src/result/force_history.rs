//! The force of an effect along the motion of the final model, for a plot.

use super::{Gap, Step};
use crate::decisions::PICTURE_SAMPLES;
use crate::evaluate::along_run;
use crate::place::{Effect, Site};
use phisindy_expr::Tape;
use phisindy_phys::unit::Unit;
use phisindy_phys::{LawRole, Record};

/// The force of an effect against displacement, velocity or time, as the sketch of its law is drawn.
#[derive(Clone, Debug)]
pub struct ForceHistory {
    /// The abscissa, in the language of the specs.
    pub over: String,
    /// Unit of the abscissa.
    pub over_unit: String,
    /// The unit of the force.
    pub unit: String,
    /// Whether the force is added to the motion (a push) rather than subtracted.
    pub push: bool,
    /// Whether it is a force; otherwise a rate, because the spec states no inertia.
    pub force: bool,
    /// Whether it depends on the abscissa alone, so that the points of each record lie on one curve.
    pub function: bool,
    /// Name and points (abscissa, force) of each record with a run. Points are sorted by the abscissa where
    /// `function` is true, otherwise by time. Samples in which friction sticks are left out, because its
    /// force there is set by the other forces.
    pub records: Vec<(String, Vec<(f64, f64)>)>,
}

/// The force of a step in the final model of `found` along its runs. `records` are those that were searched.
/// `None` for an effect on sensors, or where no record has a run.
pub fn force_history(found: &Gap, step: &Step, records: &[Record]) -> Option<ForceHistory> {
    let effect = &step.effect;
    let Site::Force { displacement, velocity, state, .. } = &effect.place.site else { return None };
    let law = &effect.entry.law;
    let drawn = law.sketch.as_ref().and_then(|s| s.over.chars().next());
    let letter = drawn.unwrap_or(if law.role(LawRole::Velocity).is_some() { 'v' } else { 'x' });
    let system = &found.simulated.system;
    let (over, place, over_unit) = match (letter, displacement) {
        ('x', Some(x)) => (x.bare(), x.node, "m"),
        ('t', _) => ("t", system.time, "s"),
        _ => (velocity.bare(), velocity.node, "m/s"),
    };
    let graph = &system.graph;
    let sign = if law.push.is_some() { -1.0 } else { 1.0 };
    let (force, speed) = (step.force?, velocity.node);
    // The unit of the force without its load, which the expression contains already.
    let bare = Effect { load: None, ..effect.clone() };
    let unit = bare.unit("N", system);
    let over_unit = if letter == 't' { "s".to_owned() } else { bare.unit(over_unit, system) };
    let factor = |unit: &str| Unit::parse(unit).map_or(1.0, |u| u.factor);
    let (size, length) = (sign / factor(&unit), 1.0 / factor(&over_unit));
    let rest = graph.reachable_above(&[force], &[place]);
    let moving = system.states.iter().map(|s| s.node).chain(system.inputs.iter().map(|u| u.node));
    let function = moving.chain([system.time]).all(|id| id == place || !rest.contains(&id));
    let tape = Tape::compile(graph, &system.arguments(), &[place, force, speed]).ok()?;
    let mut out = Vec::new();
    for (r, record) in records.iter().enumerate() {
        let Some(run) = found.simulated.records.get(r).and_then(|fit| fit.run.as_ref()) else { continue };
        let every = record.len().div_ceil(PICTURE_SAMPLES).max(1);
        let told = |[place, force, speed]: [f64; 3]| {
            let sticking = law.sticks() && speed == 0.0;
            let drawn = !sticking && place.is_finite() && force.is_finite();
            drawn.then_some((length * place, size * force))
        };
        let model = (system, found.parameters.as_slice());
        let mut points: Vec<(f64, f64)> =
            along_run(&tape, model, (r, record), run, every).filter_map(told).collect();
        if function {
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            points.dedup();
        }
        if points.len() > 1 {
            out.push((record.name.clone(), points));
        }
    }
    let over = over.to_owned();
    (!out.is_empty()).then_some(ForceHistory {
        over,
        over_unit,
        unit,
        push: law.push.is_some(),
        force: state.is_none_or(|state| system.inertia[state].is_some()),
        function,
        records: out,
    })
}
