//! Where a force is known: the displacements and velocities that the records show.

use crate::evaluate::along_run;
use crate::model::{Applied, Fitted};
use crate::place::{Effect, Quantity, Site};
use phisindy_expr::Tape;
use phisindy_phys::unit::Unit;

/// The values of a quantity along the records.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedRange {
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

/// The ranges of the quantities that the force of an effect without memory depends on, along the runs of a
/// model.
pub(crate) fn observed_ranges(fitted: &Fitted, applied: &Applied) -> Vec<ObservedRange> {
    let effect = &applied.effect;
    let Site::Force { displacement, velocity, .. } = &effect.place.site else { return vec![] };
    let Some(force) = applied.force.filter(|_| !effect.entry.law.has_memory()) else { return vec![] };
    let graph = &fitted.model.system.graph;
    let mut all: Vec<(&Quantity, &str)> = displacement.iter().map(|x| (x, "m")).collect();
    all.push((velocity, "m/s"));
    all.retain(|(q, _)| graph.uses(&[force], &[q.node]));
    all.into_iter().filter_map(|(q, unit)| range(fitted, effect, q, unit)).collect()
}

fn range(fitted: &Fitted, effect: &Effect, of: &Quantity, unit: &str) -> Option<ObservedRange> {
    let system = &fitted.model.system;
    let tape = Tape::compile(&system.graph, &system.arguments(), &[of.node]).ok()?;
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (r, record) in fitted.model.records.iter().enumerate() {
        let Some(run) = fitted.cal.records.get(r).and_then(|fit| fit.run.as_ref()) else { continue };
        let model = (system, fitted.cal.parameters.as_slice());
        for [value] in along_run(&tape, model, (r, record), run, 1) {
            (low, high) = (low.min(value), high.max(value));
        }
    }
    let unit = Effect { load: None, ..effect.clone() }.unit(unit, system);
    let factor = Unit::parse(&unit).map_or(1.0, |u| u.factor);
    let quantity = of.bare().to_owned();
    (low <= high).then_some(ObservedRange { quantity, low, high, unit, factor })
}
