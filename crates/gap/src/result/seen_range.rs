//! Where a force is known: the displacements and velocities that the records show.

use crate::model::{Applied, Fitted};
use crate::place::{Effect, Quantity, Site};
use phisindy_expr::{Scratch, Tape};
use phisindy_learn::parameter_values;
use phisindy_phys::unit::Unit;

/// The values of a quantity along the records.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenRange {
    /// The quantity, in the language of the spec.
    pub quantity: String,
    /// The least value (SI).
    pub low: f64,
    /// The largest value (SI).
    pub high: f64,
    /// The unit that the spec gives it; empty for none.
    pub unit: String,
    /// One of this unit in SI.
    pub factor: f64,
}

/// The ranges of the quantities that the force of an effect without memory depends on, along the runs of a model.
pub(crate) fn seen_ranges(fitted: &Fitted, applied: &Applied) -> Vec<SeenRange> {
    let Site::Force { displacement, velocity, .. } = &applied.effect.place.site else { return vec![] };
    let Some(force) = applied.force.filter(|_| !applied.effect.entry.law.has_memory()) else { return vec![] };
    let graph = &fitted.model.system.graph;
    let of = |q: &&(&Quantity, &str)| graph.uses(&[force], &[q.0.node]);
    let all = displacement.iter().map(|x| (x, "m")).chain([(velocity, "m/s")]);
    let all: Vec<(&Quantity, &str)> = all.collect::<Vec<_>>().iter().filter(of).copied().collect();
    all.into_iter().filter_map(|(q, unit)| range(fitted, &applied.effect, q, unit)).collect()
}

fn range(fitted: &Fitted, effect: &Effect, of: &Quantity, unit: &str) -> Option<SeenRange> {
    let system = &fitted.model.system;
    let tape = Tape::compile(&system.graph, &system.arguments(), &[of.node]).ok()?;
    let mut scratch = Scratch::<1>::new(&tape);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (r, record) in fitted.model.records.iter().enumerate() {
        let Some(run) = fitted.cal.records.get(r).and_then(|fit| fit.run.as_ref()) else { continue };
        let owner = record.continues.unwrap_or(r);
        let mut numbers = parameter_values(&fitted.cal.parameters, system, owner);
        numbers.extend(&record.constants);
        for (i, &t) in record.time.iter().enumerate() {
            let inputs = record.inputs.iter().map(|u| u.value(t));
            let states = run.state_at(i).iter().copied();
            scratch.at([t].into_iter().chain(states).chain(inputs).chain(numbers.iter().copied()));
            let value = scratch.output(0)[0];
            (low, high) = (low.min(value), high.max(value));
        }
    }
    let unit = Effect { load: None, ..effect.clone() }.unit(unit, system);
    let factor = Unit::parse(&unit).map_or(1.0, |u| u.factor);
    let quantity = of.text.trim_start_matches('(').trim_end_matches(')').to_owned();
    (low <= high).then_some(SeenRange { quantity, low, high, unit, factor })
}
