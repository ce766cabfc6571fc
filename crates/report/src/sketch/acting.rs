//! What a force is and where it acts, by what it depends on.

use super::moving::{Moving, varying};
use super::probe::Probe;
use super::scheme::{End, Kind};
use phisindy_expr::{Id, Node, Unary};
use phisindy_phys::System;

/// Where a force belongs in a sketch.
#[derive(PartialEq)]
pub(super) enum Acting {
    Between(Kind, (End, End)),
    /// It comes from outside.
    Push,
}

/// The system beside its bodies.
pub(super) struct View<'a> {
    pub(super) system: &'a mut System,
    pub(super) probe: &'a Probe,
    pub(super) bodies: &'a [Moving],
    /// The inputs that move a support: displacement and speed.
    pub(super) bases: &'a [(Option<usize>, Option<usize>)],
}

impl View<'_> {
    /// The constants that an expression is made of.
    pub(super) fn constants(&mut self, node: Id) -> Vec<String> {
        let system = &mut *self.system;
        let all = system.parameters.iter().map(|p| (p.node, p.name.clone()));
        let all = all.chain(system.record_constants.iter().map(|(name, node)| (*node, name.clone())));
        let (nodes, names): (Vec<Id>, Vec<String>) = all.unzip();
        let slopes = system.graph.gradient(node, &nodes);
        let one = system.graph.constant(1.0);
        // `k + h - h` is of `k` alone.
        let told = names.into_iter().zip(slopes);
        let told = told.filter(|(_, slope)| !self.probe.nothing(&self.system.graph, *slope, one));
        told.map(|(name, _)| name).collect()
    }

    pub(super) fn displacement(&self, body: usize) -> Option<Id> {
        self.bodies[body].displacement.map(|x| self.system.states[x].node)
    }

    pub(super) fn speed(&self, body: usize) -> Id {
        self.system.states[self.bodies[body].speed].node
    }

    /// Displacement and speed of a base.
    pub(super) fn base(&self, k: usize) -> [Option<Id>; 2] {
        let (x, v) = self.bases[k];
        [x, v].map(|u| u.map(|u| self.system.inputs[u].node))
    }

    /// Whether it is in proportion to what it depends on.
    pub(super) fn is_linear(&mut self, force: Id) -> bool {
        let varying = varying(self.system);
        let slopes = self.system.graph.gradient(force, &varying);
        let signs = self.system.graph.reachable(&[force]);
        let jumps = |id: &Id| matches!(self.system.graph.node(*id), Node::Unary(Unary::Sgn | Unary::Step, _));
        !self.system.graph.uses(&slopes, &varying) && !signs.iter().any(jumps)
    }

    /// What a force on a body is.
    pub(super) fn acting(&mut self, body: usize, force: Id) -> Acting {
        let graph = &self.system.graph;
        let uses = |id: Option<Id>| id.is_some_and(|id| graph.uses(&[force], &[id]));
        let others: Vec<Id> = {
            let moving = |k: &usize| self.bodies.iter().any(|b| b.displacement == Some(*k) || b.speed == *k);
            let all = (0..self.system.states.len()).filter(|k| !moving(k));
            all.map(|k| self.system.states[k].node).collect()
        };
        let of_place: Vec<usize> = (0..self.bodies.len()).filter(|&k| uses(self.displacement(k))).collect();
        let of_speed: Vec<usize> = (0..self.bodies.len()).filter(|&k| uses(Some(self.speed(k)))).collect();
        let mut bodies: Vec<usize> = of_place.iter().chain(&of_speed).copied().collect();
        bodies.sort_unstable();
        bodies.dedup();
        if bodies.is_empty() && !graph.uses(&[force], &others) {
            return Acting::Push;
        }
        let base = (0..self.bases.len()).find(|&k| self.base(k).into_iter().any(uses));
        let sign = graph.reachable(&[force]).into_iter().find_map(|id| match graph.node(id) {
            Node::Unary(Unary::Sgn | Unary::Step, a) => {
                let speeds: Vec<Id> = (0..self.bodies.len()).map(|k| self.speed(k)).collect();
                graph.uses(&[a], &speeds).then_some(a)
            }
            _ => None,
        });
        if let Some(ends) = sign.and_then(|w| self.along(w)) {
            return Acting::Between(Kind::Friction, ends);
        }
        let bases: Vec<usize> = self.bases.iter().flat_map(|&(x, v)| [x, v]).flatten().collect();
        let inputs =
            self.system.inputs.iter().enumerate().filter(|(k, _)| !bases.contains(k)).map(|(_, u)| u.node);
        let others: Vec<Id> = others.into_iter().chain(inputs).collect();
        let many = bodies.len() > 2 || self.system.graph.uses(&[force], &others);
        let ends = match (&bodies[..], base) {
            ([own], Some(k)) if *own == body && !many => (End::Base(k), End::Body(body)),
            ([own, other] | [other, own], _) if *own == body => (End::Body(body), End::Body(*other)),
            ([other], _) if *other != body => (End::Body(body), End::Body(*other)),
            _ => (End::Ground, End::Body(body)),
        };
        // Of a spring between two the slopes are opposite.
        let between = |of: [Option<Id>; 2], view: &mut Self| -> bool {
            let [Some(a), Some(b)] = of else { return false };
            let slopes = view.system.graph.gradient(force, &[a, b]);
            let minus = view.system.graph.neg(slopes[1]);
            view.probe.same(&view.system.graph, slopes[0], minus)
        };
        let linear = self.is_linear(force);
        let whole = match ends {
            (End::Base(k), _) => {
                let [x, v] = self.base(k);
                let own = [self.displacement(body), Some(self.speed(body))];
                let pairs = [([own[0], x], !of_place.is_empty()), ([own[1], v], !of_speed.is_empty())];
                pairs.into_iter().all(|(pair, used)| !used || between(pair, self))
            }
            (End::Body(a), End::Body(b)) if !linear => {
                let pairs = [
                    ([self.displacement(a), self.displacement(b)], !of_place.is_empty()),
                    ([Some(self.speed(a)), Some(self.speed(b))], !of_speed.is_empty()),
                ];
                pairs.into_iter().all(|(pair, used)| !used || between(pair, self))
            }
            _ => true,
        };
        let bends = self.bodies[body].turns && bodies == [body] && !linear;
        let kind = match (of_place.is_empty(), of_speed.is_empty()) {
            _ if many || !whole => Kind::Force,
            (false, true) if bends && base.is_none() && self.is_weight(body, force) => Kind::Weight,
            (false, true) => {
                if linear {
                    Kind::Spring
                } else {
                    Kind::BentSpring
                }
            }
            (true, false) => {
                if linear {
                    Kind::Damper
                } else {
                    Kind::BentDamper
                }
            }
            _ => Kind::Force,
        };
        Acting::Between(kind, ends)
    }

    fn is_weight(&self, body: usize, force: Id) -> bool {
        let angle = self.displacement(body);
        angle.is_some_and(|angle| self.probe.turns(&self.system.graph, force, angle))
    }

    /// The ends of what acts along a speed: the bodies whose speeds are in it, or one and what carries it.
    pub(super) fn along(&mut self, speed: Id) -> Option<(End, End)> {
        let bodies: Vec<usize> =
            (0..self.bodies.len()).filter(|&k| self.system.graph.uses(&[speed], &[self.speed(k)])).collect();
        let base = (0..self.bases.len())
            .find(|&k| self.base(k)[1].is_some_and(|v| self.system.graph.uses(&[speed], &[v])));
        match (&bodies[..], base) {
            ([], _) => None,
            ([one], Some(k)) => Some((End::Base(k), End::Body(*one))),
            ([one], None) => Some((End::Ground, End::Body(*one))),
            ([a, b, ..], _) => Some((End::Body(*a), End::Body(*b))),
        }
    }
}
