//! The forces of a model that depend on one speed or one displacement alone, as functions of it.

use crate::html::friction::{force_unit, rate};
use crate::input::Input;
use crate::sketch::{Model, Moving};
use phisindy_compare::{Estimates, ForceCurve, Number};
use phisindy_expr::{Binary, Id, Node, Scratch, Tape};
use phisindy_learn::Identified;
use phisindy_phys::System;
use phisindy_phys::unit::{Dimension, Unit};

/// Points of a curve: odd, so that zero is one of them.
const POINTS: usize = 61;
/// Most samples of a record that are looked at for how far it went.
const SAMPLES: usize = 2000;

/// The forces of a model with these numbers, over what the records of a fit visited. A number that `numbers` does not
/// have stands as the fit or the spec has it, without an error. Forces that hang on more than one speed or displacement,
/// or on a number of one record, are left out.
pub fn force_curves(input: Input<'_>, found: &Identified, numbers: &Estimates) -> Vec<ForceCurve> {
    let model = Model::new(input.spec, input.case, &found.parameters);
    let Model { mut system, mut values, bodies } = model;
    let named = numbers.numbers.iter().zip(&numbers.values);
    values.extend(named.map(|(number, value)| (number.name.clone(), *value)));
    let mut all = Vec::new();
    for body in bodies {
        let mut parts: Vec<Part> = body.forces.iter().map(|&node| Part { node, of: None }).collect();
        for term in
            found.terms.iter().filter(|t| system.terms.get(t.term).is_some_and(|t| t.state == body.speed))
        {
            let own = &system.terms[term.term];
            let of = Number::of_coefficient(&own.candidate, &system.states[own.state].name);
            let value = own.value;
            let share = body.mass.map_or(value, |mass| system.graph.mul(mass, value));
            let size = numbers.position(&of).map_or(term.coefficient.value, |k| numbers.values[k]);
            let size = system.graph.constant(size);
            parts.push(Part { node: system.graph.mul(size, share), of: Some((of, share)) });
        }
        let mut groups: Vec<(Id, Vec<Part>)> = Vec::new();
        for part in parts {
            let Some(over) = depends_on(&system, &body, part.node) else { continue };
            match groups.iter_mut().find(|(other, _)| *other == over) {
                Some((_, group)) => group.push(part),
                None => groups.push((over, vec![part])),
            }
        }
        for (over, group) in groups {
            let visited = visited(&system, &values, input, found, over);
            all.extend(
                visited.and_then(|ends| curve(&mut system, &values, numbers, &body, (over, ends), &group)),
            );
        }
    }
    all
}

/// A force, and of a found term the name of its coefficient and what that is multiplied by.
struct Part {
    node: Id,
    of: Option<(String, Id)>,
}

type Values = std::collections::HashMap<String, f64>;

/// All that moves: states, inputs, time.
fn moving(system: &System) -> Vec<Id> {
    let states = system.states.iter().map(|s| s.node);
    states.chain(system.inputs.iter().map(|u| u.node)).chain([system.time]).collect()
}

/// Whether a state is the speed of something.
fn is_speed(system: &System, body: &Moving, k: usize) -> bool {
    k == body.speed || system.states.iter().any(|s| s.velocity == Some(k))
}

/// The one speed or displacement that a force depends on: of a body, or of one body from another.
fn depends_on(system: &System, body: &Moving, force: Id) -> Option<Id> {
    let moving = moving(system);
    let graph = &system.graph;
    let below = graph.reachable(&[force]);
    let own = (0..system.states.len()).filter(|&k| {
        let state = &system.states[k];
        !state.hidden && (state.velocity.is_some() || is_speed(system, body, k))
    });
    let own = own.map(|k| system.states[k].node);
    let contacts = system.contacts.iter().map(|c| c.node);
    let differences = below.iter().copied().filter(|&id| match graph.node(id) {
        Node::Binary(Binary::Sub, a, b) => moving.contains(&a) && moving.contains(&b),
        _ => false,
    });
    let alone = |over: &Id| {
        let above = graph.reachable_above(&[force], &[*over]);
        above.contains(over) && moving.iter().all(|id| id == over || !above.contains(id))
    };
    own.chain(contacts).chain(differences).find(alone)
}

/// The least and the largest value of a node along the records.
fn visited(
    system: &System,
    values: &Values,
    input: Input<'_>,
    found: &Identified,
    over: Id,
) -> Option<(f64, f64)> {
    let tape = Tape::compile(&system.graph, &system.arguments(), &[over]).ok()?;
    let mut scratch = Scratch::<1>::new(&tape);
    let numbers = numbers_of(system, values);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (record, fit) in input.records.iter().zip(&found.records) {
        let Some(run) = &fit.run else { continue };
        for i in (0..record.len()).step_by(record.len().div_ceil(SAMPLES).max(1)) {
            let t = record.time[i];
            let states = run.state_at(i).iter().copied();
            let inputs = record.inputs.iter().map(|u| u.value(t));
            let rest = [t].into_iter().chain(states).chain(inputs).chain(numbers.iter().copied());
            scratch.at(rest);
            let at = scratch.output(0)[0];
            if at.is_finite() {
                (low, high) = (low.min(at), high.max(at));
            }
        }
    }
    (low < high).then_some((low, high))
}

/// The numbers of the model in the order of its arguments; not finite where one is not known.
fn numbers_of(system: &System, values: &Values) -> Vec<f64> {
    let names = system.parameters.iter().map(|p| &p.name);
    let names = names.chain(system.record_constants.iter().map(|(name, _)| name));
    names.map(|name| values.get(name).copied().unwrap_or(f64::NAN)).collect()
}

/// Values between two ends, close to each other near zero, where friction has its shape.
fn grid((low, high): (f64, f64)) -> Vec<f64> {
    let largest = low.abs().max(high.abs());
    let place = |k: usize| largest * (2.0 * k as f64 / (POINTS - 1) as f64 - 1.0).powi(3);
    let inside = (0..POINTS).map(place).filter(|v| *v > low && *v < high);
    [low].into_iter().chain(inside).chain([high]).collect()
}

/// The sum of forces over what they depend on.
fn curve(
    system: &mut System,
    values: &Values,
    numbers: &Estimates,
    body: &Moving,
    (over, ends): (Id, (f64, f64)),
    parts: &[Part],
) -> Option<ForceCurve> {
    let zero = system.graph.constant(0.0);
    let sum = parts.iter().fold(zero, |sum, part| system.graph.add(sum, part.node));
    // A force is positive where it opposes.
    let force = system.graph.neg(sum);
    let nodes: Vec<Id> = system.parameters.iter().map(|p| p.node).collect();
    let gradient = system.graph.gradient(force, &nodes);
    let mut slopes = vec![zero; numbers.numbers.len()];
    for (k, number) in numbers.numbers.iter().enumerate() {
        if let Some(p) = system.parameters.iter().position(|p| p.name == number.name) {
            slopes[k] = gradient[p];
        }
        for (_, share) in parts.iter().filter_map(|p| p.of.as_ref()).filter(|(of, _)| *of == number.name) {
            let share = system.graph.neg(*share);
            slopes[k] = system.graph.add(slopes[k], share);
        }
    }
    let roots: Vec<Id> = [force].into_iter().chain(slopes).collect();
    let constants = system.record_constants.iter().map(|&(_, node)| node);
    let arguments: Vec<Id> = [over].into_iter().chain(nodes).chain(constants).collect();
    let tape = Tape::compile(&system.graph, &arguments, &roots).ok()?;
    let mut scratch = Scratch::<1>::new(&tape);
    let rest = numbers_of(system, values);
    let factor = |unit: &str| Unit::parse(unit).map_or(1.0, |u| u.factor);
    let shown = shown(system, body, over);
    let (across, size) = (factor(&shown.over.1), factor(&shown.force.1));
    let at = |x: f64| {
        scratch.at([x].into_iter().chain(rest.iter().copied()));
        let slope: Vec<f64> = (1..roots.len()).map(|k| scratch.output(k)[0]).collect();
        let used: Vec<usize> = (0..slope.len()).filter(|&k| slope[k] != 0.0).collect();
        let row =
            |i: usize| used.iter().map(|&j| slope[i] * numbers.covariance[i][j] * slope[j]).sum::<f64>();
        let variance: f64 = used.iter().map(|&i| row(i)).sum();
        (x / across, scratch.output(0)[0] / size, variance.max(0.0).sqrt() / size)
    };
    let points: Vec<(f64, f64, f64)> = grid(ends).into_iter().map(at).collect();
    let known = points.iter().all(|(_, force, error)| force.is_finite() && error.is_finite());
    known.then_some(ForceCurve { points, ..shown })
}

/// What a curve is called, and its units.
fn shown(system: &System, body: &Moving, over: Id) -> ForceCurve {
    let state = |node: Id| system.states.iter().find(|s| s.node == node);
    let inside = system.graph.reachable(&[over]);
    let first = system.states.iter().find(|s| inside.contains(&s.node));
    let unit = state(over).or(first).map_or("", |s| s.unit.as_str());
    let at = &system.states[body.speed];
    let speeds = system.states.iter().enumerate().filter(|(k, _)| is_speed(system, body, *k));
    let of_speed = speeds.map(|(_, s)| s.node).any(|node| inside.contains(&node));
    let kind = if of_speed { "resisting force" } else { "restoring force" };
    let of_rate = || rate(&at.unit).map_or(String::new(), |d: Dimension| d.to_string());
    let force = match body.mass.and(force_unit(&at.unit)) {
        Some(unit) => (kind.to_owned(), unit.to_owned()),
        None => (kind.replace(" force", " acceleration"), of_rate()),
    };
    ForceCurve {
        at: at.name.clone(),
        over: (system.graph.text(over, &system.names), unit.to_owned()),
        force,
        points: vec![],
    }
}
