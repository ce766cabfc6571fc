//! The parts of a system.

use super::acting::{Acting, View};
use super::linear::{self, Forces};
use super::moving::{Moving, bodies, varying};
use super::named::{Named, named};
use super::number::{INERTIA, Numbers, formula, signed_formula, words};
use super::probe::Probe;
use super::scheme::{Block, Body, End, Kind, Known, Scheme};
use crate::terminal::unicode;
use phisindy_expr::Id;
use phisindy_phys::spec::Spec;
use phisindy_phys::{Case, Origin, RecordPlan, System};

/// A system of more bodies is drawn as its states.
const BODIES: usize = 7;

/// What a sketch is made from: the system with the names of its constants, and its numbers.
pub(super) struct Reading {
    pub(super) system: System,
    pub(super) numbers: Numbers,
    pub(super) probe: Probe,
    pub(super) bodies: Vec<Moving>,
    pub(super) bases: Vec<(Option<usize>, Option<usize>)>,
    pub(super) scheme: Scheme,
}

impl Reading {
    /// The known part of a case.
    pub(super) fn new(spec: &Spec, case: &Case, found: Numbers) -> Reading {
        let mut all = Reading::read(spec, case, found);
        if all.bodies.len() > BODIES {
            all.bodies.clear();
        }
        let bases = bases(&all.system, &all.bodies, &case.records);
        let name = |&(x, v): &(Option<usize>, Option<usize>)| {
            x.or(v).map_or(String::new(), |k| unicode::name(&all.system.inputs[k].name))
        };
        all.scheme.bases = bases.iter().map(name).collect();
        all.bases = bases;
        all.add_bodies(&case.records);
        all.add_forces();
        all.add_links();
        all.add_contacts();
        all.add_blocks(&case.records);
        all
    }

    /// The same without a scheme.
    pub(super) fn read(spec: &Spec, case: &Case, found: Numbers) -> Reading {
        let Named { mut system, mut values } = named(spec)
            .unwrap_or_else(|| Named { system: case.system.clone(), values: own_values(&case.system) });
        values.extend(found.values);
        let numbers = Numbers { values, errors: found.errors };
        let probe = Probe::new(&system, &numbers.values);
        let bodies = bodies(&mut system, &probe);
        Reading { system, numbers, probe, bodies, bases: vec![], scheme: Scheme::default() }
    }

    pub(super) fn view(&mut self) -> (View<'_>, &mut Scheme, &Numbers) {
        let Reading { system, numbers, probe, bodies, bases, scheme } = self;
        (View { system, probe, bodies, bases }, scheme, numbers)
    }

    fn add_bodies(&mut self, plans: &[RecordPlan]) {
        for body in &self.bodies {
            let system = &self.system;
            let own: Vec<usize> = body.displacement.into_iter().chain([body.speed]).collect();
            let nodes: Vec<Id> = own.iter().map(|&k| system.states[k].node).collect();
            let rate = system.rate_symbols.iter().filter(|(k, _)| own.contains(k)).map(|(_, node)| *node);
            let nodes: Vec<Id> = nodes.into_iter().chain(rate).collect();
            let of_output = |k: usize| system.graph.uses(&[system.outputs[k].reading], &nodes);
            let columns = (0..system.columns()).filter(|&k| match k.checked_sub(system.states.len()) {
                None => own.contains(&k),
                Some(k) => of_output(k),
            });
            let sensors = columns.filter(|&k| is_measured(system, plans, k));
            let sensors = sensors.map(|k| unicode::name(system.measured(k).0)).collect();
            let varying = varying(system);
            let still = body.mass.filter(|m| !system.graph.uses(&[*m], &varying));
            let of = |mass: Id| words(system, (&self.probe, &self.numbers), (mass, INERTIA), body);
            let turning = || body.mass.map_or(String::new(), |mass| formula(system, mass));
            self.scheme.bodies.push(Body {
                name: unicode::name(&system.states[own[0]].name),
                turns: body.turns,
                inertia: still.map_or_else(turning, of),
                sensors,
                lit: vec![],
            });
        }
    }

    /// The forces that the spec states.
    fn add_forces(&mut self) {
        let all: Vec<Vec<Id>> = self.bodies.iter().map(|b| b.forces.clone()).collect();
        let (mut view, scheme, numbers) = self.view();
        let mut linear: Forces = vec![vec![]; all.len()];
        let mut later = vec![];
        for (body, forces) in all.into_iter().enumerate() {
            for force in forces {
                let outside = matches!(view.acting(body, force), Acting::Push);
                let of_inputs = view.system.inputs.iter().map(|u| u.node).collect::<Vec<_>>();
                let input = view.system.graph.uses(&[force], &of_inputs);
                if view.is_linear(force) && (!outside || input) {
                    linear[body].push(force);
                } else {
                    later.push((body, force));
                }
            }
        }
        linear::add(&mut view, &linear, numbers, scheme);
        for (body, force) in later {
            match view.acting(body, force) {
                Acting::Push => {
                    let said = signed_formula(view.system, force);
                    scheme.push(body, if said.is_empty() { "force".to_owned() } else { said }, Known::Stated);
                }
                Acting::Between(kind, ends) => {
                    let said = line(formula(view.system, force));
                    scheme.state(kind, ends, said, view.constants(force));
                }
            }
        }
        // What a body feels of a state that is no motion.
        let others = self.others();
        let (mut view, scheme, _) = self.view();
        for (body, forces) in linear.iter().enumerate() {
            for &force in forces {
                for &k in &others {
                    let node = view.system.states[k].node;
                    if view.system.graph.uses(&[force], &[node]) {
                        let said = formula(view.system, force);
                        add_memory(&mut view, scheme, (body, k), said);
                    }
                }
            }
        }
    }

    /// The states that are no motion of a body.
    fn others(&self) -> Vec<usize> {
        let moving = |k: &usize| self.bodies.iter().any(|b| b.displacement == Some(*k) || b.speed == *k);
        (0..self.system.states.len()).filter(|k| !moving(k) && !self.system.states[*k].hidden).collect()
    }

    /// Bodies of a mechanism that move each other by their masses.
    fn add_links(&mut self) {
        let momenta = self.system.momenta.clone();
        let body = |speed: usize| self.bodies.iter().position(|b| b.speed == speed);
        let mut found = vec![];
        for (i, &(v, momentum, _)) in momenta.iter().enumerate() {
            for &(w, ..) in &momenta[i + 1..] {
                let (Some(a), Some(b)) = (body(v), body(w)) else { continue };
                let node = self.system.states[w].node;
                let coupling = self.system.graph.gradient(momentum, &[node])[0];
                if self.system.graph.value(coupling) != Some(0.0) {
                    found.push(((End::Body(a), End::Body(b)), formula(&self.system, coupling)));
                }
            }
        }
        for (ends, said) in found {
            self.scheme.add(Kind::Link, ends, line(said), Known::Stated);
        }
    }

    /// The velocities that may stick.
    fn add_contacts(&mut self) {
        let contacts: Vec<Id> = self.system.contacts.iter().map(|c| c.node).collect();
        let (mut view, scheme, _) = self.view();
        for contact in contacts {
            if let Some(ends) = view.along(contact) {
                scheme.add(Kind::Friction, ends, vec![], Known::Stated);
            }
        }
    }

    /// The states that are no motion and no memory of a force.
    fn add_blocks(&mut self, plans: &[RecordPlan]) {
        for k in self.others() {
            let system = &self.system;
            let rate = system.known[k];
            let own = |node: Id| system.graph.uses(&[rate], &[node]);
            let states = system.states.iter().filter(|s| own(s.node)).map(|s| unicode::name(&s.name));
            let inputs: Vec<String> =
                system.inputs.iter().filter(|u| own(u.node)).map(|u| unicode::name(&u.name)).collect();
            let time = own(system.time).then(|| "t".to_owned());
            let reads = |o: usize| {
                system.graph.uses(&[system.outputs[o].reading], &[system.states[k].node])
                    && is_measured(system, plans, system.states.len() + o)
            };
            let measured = is_measured(system, plans, k) || (0..system.outputs.len()).any(reads);
            self.scheme.blocks.push(Block {
                name: unicode::name(&system.states[k].name),
                of: states.chain(time).collect(),
                inputs,
                measured,
                words: String::new(),
                known: Known::Stated,
            });
        }
    }
}

/// Adds what a body feels of another state: a force with a memory of the motion, or one from elsewhere.
fn add_memory(view: &mut View<'_>, scheme: &mut Scheme, (body, state): (usize, usize), said: String) {
    let rate = view.system.known[state];
    let moves = |view: &View<'_>, k: usize| {
        let own = [view.displacement(k), Some(view.speed(k))].into_iter().flatten().collect::<Vec<_>>();
        view.system.graph.uses(&[rate], &own)
    };
    let felt: Vec<usize> = (0..view.bodies.len()).filter(|&k| moves(view, k)).collect();
    let inputs: Vec<Id> = view.system.inputs.iter().map(|u| u.node).collect();
    match felt[..] {
        [] => scheme.push(body, said, Known::Stated),
        _ if view.system.graph.uses(&[rate], &inputs) => scheme.push(body, said, Known::Stated),
        [one] if one == body => {
            scheme.add(Kind::Force, (End::Ground, End::Body(body)), vec![said], Known::Stated)
        }
        [one, ..] if one != body => {
            scheme.add(Kind::Force, (End::Body(one), End::Body(body)), vec![said], Known::Stated)
        }
        [_, other, ..] => {
            scheme.add(Kind::Force, (End::Body(body), End::Body(other)), vec![said], Known::Stated)
        }
        _ => {}
    }
}

fn line(words: String) -> Vec<String> {
    if words.is_empty() { vec![] } else { vec![words] }
}

fn own_values(system: &System) -> std::collections::HashMap<String, f64> {
    system.parameters.iter().filter(|p| p.known).map(|p| (p.name.clone(), p.start)).collect()
}

/// Whether a record holds a column.
fn is_measured(system: &System, plans: &[RecordPlan], column: usize) -> bool {
    let name = system.measured(column).0;
    plans.iter().any(|plan| match &plan.origin {
        Origin::Csv(csv) => csv.columns.iter().any(|(n, _)| n.value == name),
        Origin::Synthetic(s) => s.measured_columns.get(column) == Some(&true),
    })
}

/// The inputs that may move a support: a displacement like that of a body, and its rate.
fn bases(system: &System, bodies: &[Moving], plans: &[RecordPlan]) -> Vec<(Option<usize>, Option<usize>)> {
    use super::moving::dimension;
    let alike = |input: usize, state: usize| {
        let [a, b] = [&system.inputs[input].unit, &system.states[state].unit];
        !a.is_empty() && dimension(a).is_some() && dimension(a) == dimension(b)
    };
    let inputs = || 0..system.inputs.len();
    let speeds: Vec<usize> = inputs().filter(|&u| bodies.iter().any(|b| alike(u, b.speed))).collect();
    let places: Vec<usize> =
        inputs().filter(|&u| bodies.iter().filter_map(|b| b.displacement).any(|x| alike(u, x))).collect();
    let derived = |v: usize| plans.iter().find_map(|p| p.derived.get(v).copied().flatten());
    let rate = |u: usize| {
        let own = speeds.iter().copied().find(|&v| derived(v) == Some(u));
        // One of each belong together.
        own.or(if let ([v], [_]) = (&speeds[..], &places[..]) { Some(*v) } else { None })
    };
    let pairs: Vec<_> = places.iter().map(|&u| (Some(u), rate(u))).collect();
    let alone = speeds.iter().filter(|v| pairs.iter().all(|(_, w)| *w != Some(**v)));
    let alone: Vec<_> = alone.map(|&v| (None, Some(v))).collect();
    pairs.into_iter().chain(alone).collect()
}
