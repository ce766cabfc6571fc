//! What moves in a system: pairs of a displacement and its speed, and the inertia that a force moves.

use super::probe::Probe;
use super::terms::{Term, terms};
use phisindy_expr::Id;
use phisindy_phys::System;
use phisindy_phys::unit::{Dimension, Unit};

/// A body of the system.
pub(crate) struct Moving {
    /// Its displacement, where the system has one.
    pub(crate) displacement: Option<usize>,
    pub(crate) speed: usize,
    /// What turns a force into its rate, where that is known.
    pub(crate) mass: Option<Id>,
    /// The forces on it, one by one; rates where no mass is known.
    pub(crate) forces: Vec<Id>,
    pub(crate) turns: bool,
}

/// The dimension of a unit as the spec writes it.
pub(super) fn dimension(unit: &str) -> Option<Dimension> {
    Unit::parse(unit).ok().map(|u| u.dimension)
}

/// The bodies, in the order of the states.
pub(super) fn bodies(system: &mut System, probe: &Probe) -> Vec<Moving> {
    let states = &system.states;
    let speed = Dimension::METRE.div(Dimension::SECOND);
    let rubs = |k: usize| system.contacts.iter().any(|c| c.node == states[k].node);
    let of = |k: usize| {
        if states[k].velocity.is_some() || states[k].hidden {
            return None;
        }
        let displacement = states.iter().position(|s| s.velocity == Some(k));
        // A speed alone is that of a body where the spec says so.
        let alone = system.inertia[k].is_some() || rubs(k) || dimension(&states[k].unit) == Some(speed);
        (displacement.is_some() || alone).then_some((displacement, k))
    };
    let pairs: Vec<(Option<usize>, usize)> = (0..states.len()).filter_map(of).collect();
    let turning = |k: usize| states[k].unit.contains("rad") || states[k].unit.contains("deg");
    let turns: Vec<bool> = pairs.iter().map(|&(x, v)| turning(x.unwrap_or(v))).collect();
    let all = pairs.iter().zip(turns).map(|(&(displacement, speed), turns)| {
        let (mass, forces) = forces(system, probe, speed);
        Moving { displacement, speed, mass, forces, turns }
    });
    all.collect()
}

/// What expressions of the motion depend on: all but numbers.
pub(super) fn varying(system: &System) -> Vec<Id> {
    let states = system.states.iter().map(|s| s.node);
    states.chain(system.inputs.iter().map(|u| u.node)).chain([system.time]).collect()
}

/// The mass of a body and the forces on it.
fn forces(system: &mut System, probe: &Probe, speed: usize) -> (Option<Id>, Vec<Id>) {
    let varying = varying(system);
    if let Some(&(_, momentum, sum)) = system.momenta.iter().find(|(v, ..)| *v == speed) {
        let node = system.states[speed].node;
        let mass = system.graph.gradient(momentum, &[node])[0];
        let speeds: Vec<Id> = system.momenta.iter().map(|&(v, ..)| system.states[v].node).collect();
        let all = terms(&mut system.graph, sum, &varying).into_iter();
        let all = all.map(|t| t.over.map_or(t.value, |over| system.graph.div(t.value, over)));
        let all: Vec<Id> = all.collect();
        // What turning masses feel of their own speeds is no force from elsewhere.
        let of_masses = |f: &Id| {
            system.graph.uses(&[*f], &speeds)
                && probe.scales(&system.graph, *f, (&speeds, 2.0), 4.0)
                && probe.scales(&system.graph, *f, (&speeds, -1.0), 1.0)
        };
        return (Some(mass), all.into_iter().filter(|f| !of_masses(f)).collect());
    }
    let split = terms(&mut system.graph, system.known[speed], &varying);
    let rates: Vec<Id> =
        split.iter().map(|t| t.over.map_or(t.value, |over| system.graph.div(t.value, over))).collect();
    let Some(mass) = system.inertia[speed].or_else(|| found_mass(system, probe, &rates)) else {
        return (None, rates);
    };
    let force = |(t, rate): (_, Id)| match t {
        Term { value, over: Some(over) } if over == mass => value,
        _ => system.graph.mul(mass, rate),
    };
    (Some(mass), split.into_iter().zip(rates).map(force).collect())
}

/// The number in kilograms by which the rates of a body are divided.
fn found_mass(system: &System, probe: &Probe, rates: &[Id]) -> Option<Id> {
    let is_mass = |unit: &str| {
        let powers = dimension(unit).map(Dimension::powers);
        powers.is_some_and(|[kg, m, s, ..]| kg == 1.0 && (m == 0.0 || m == 2.0) && s == 0.0)
    };
    let divides = |node: &Id| rates.iter().any(|&r| probe.scales(&system.graph, r, (&[*node], 2.0), 0.5));
    let masses = system.parameters.iter().filter(|p| is_mass(&p.unit)).map(|p| p.node);
    let mut masses = masses.filter(divides);
    masses.next().filter(|_| masses.next().is_none())
}
