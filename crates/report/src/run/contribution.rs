//! The contribution of each term to the motion: its size, its share of the unknown force, the energy it
//! dissipates.

use crate::table::short;
use phisindy_learn::{FoundTerm, Identified};
use phisindy_phys::unit::{Dimension, Unit};
use phisindy_phys::{System, Term};
use serde::Serialize;

/// A number and its SI unit; the unit is empty if the spec does not determine it.
#[derive(Serialize)]
pub(crate) struct Quantity {
    value: f64,
    unit: String,
}

impl Quantity {
    fn text(&self) -> String {
        format!("{} {}", short(self.value), if self.unit == "1" { "" } else { &self.unit })
            .trim_end()
            .to_owned()
    }
}

/// The contribution of one term.
#[derive(Serialize)]
pub(crate) struct Contribution {
    /// Root mean square of the force, or of the rate if the spec states no inertia.
    rms: Quantity,
    /// Ratio to the root mean square of all terms of the equation together.
    share: f64,
    /// Dissipated power, per unit of inertia if none is stated; negative if the term feeds energy.
    power: Option<Quantity>,
    /// Dissipated energy per cycle, likewise.
    energy_per_cycle: Option<Quantity>,
}

/// The contribution of a term, if it is known.
pub(crate) fn contribution(system: &System, found: &FoundTerm) -> Option<Contribution> {
    let term = &system.terms[found.term];
    let c = found.contribution?;
    let force = force(system, term).map_or(String::new(), |dimension| dimension.to_string());
    let unit = |dimension: Option<Dimension>| dimension.map_or(String::new(), name);
    let per_second = |d: Dimension| d.div(Dimension::SECOND);
    Some(Contribution {
        rms: Quantity { value: c.rms, unit: force },
        share: c.share,
        power: c.power.map(|value| Quantity { value, unit: unit(term.energy.map(per_second)) }),
        energy_per_cycle: c.per_cycle.map(|value| Quantity { value, unit: unit(term.energy) }),
    })
}

/// The rows of a table, headings first.
pub(crate) fn rows(system: &System, found: &Identified) -> Vec<Vec<String>> {
    let heading = ["equation", "candidate", "rms", "of the unknown part", "dissipates", "per cycle"];
    let mut rows = vec![heading.map(str::to_owned).to_vec()];
    for term in &found.terms {
        let Some(c) = contribution(system, term) else { continue };
        let Term { state, candidate, .. } = &system.terms[term.term];
        let text = |q: Option<Quantity>| q.map_or("-".to_owned(), |q| q.text());
        let share = format!("{:.1} %", 100.0 * c.share);
        let name = system.states[*state].name.clone();
        rows.push(vec![
            name,
            candidate.clone(),
            c.rms.text(),
            share,
            text(c.power),
            text(c.energy_per_cycle),
        ]);
    }
    rows
}

/// The unit of a term's force, or of its rate if no inertia is stated.
fn force(system: &System, term: &Term) -> Option<Dimension> {
    let state = Unit::parse(&system.states[term.state].unit).ok()?.dimension;
    Some(term.energy?.div(state).div(Dimension::SECOND))
}

/// The unit in J or W if it is an energy or a power.
fn name(dimension: Dimension) -> String {
    let joule = Dimension::NEWTON.mul(Dimension::METRE);
    let watt = joule.div(Dimension::SECOND);
    let named = [
        ("J", joule),
        ("W", watt),
        ("J/kg", joule.div(Dimension::KILOGRAM)),
        ("W/kg", watt.div(Dimension::KILOGRAM)),
    ];
    named
        .iter()
        .find(|(_, d)| *d == dimension)
        .map_or_else(|| dimension.to_string(), |(name, _)| (*name).to_owned())
}
