//! Impacts: what happens where a gap closes.
//!
//! The gap `h` depends on displacements, inputs and time, so its rate `w` is linear in the speeds, with `J = dw/dv`. A
//! force of 1 along `J` changes the speeds by `M^-1 J'`. An impulse in that direction reverses the closing speed,
//! `J v+ = -e J v-`, and keeps the momentum of bodies that hit each other (Newton's law of impact; F. Pfeiffer, C.
//! Glocker, Multibody Dynamics with Unilateral Contacts, 1996, ch. 8). A body at rest on the other one is held by a force
//! in the same direction.

use crate::system::equations::System;
use crate::system::model::Model;
use phisindy_expr::{Binary, Graph, Id, Names, Node};
use std::collections::HashMap;

/// An impact that the spec names.
#[derive(Clone, Debug)]
pub struct Impact {
    /// What it is called.
    pub name: String,
    /// The gap as the spec writes it.
    pub text: String,
    /// The gap: closed at zero.
    pub gap: Id,
    /// The part of the closing speed with which the gap opens again.
    pub restitution: Id,
}

/// An impact as a model knows it.
#[derive(Clone, Debug)]
pub struct Rebound {
    /// The gap: closed at zero.
    pub gap: Id,
    /// The part of the closing speed with which the gap opens again.
    pub restitution: Id,
    /// The states that jump, each by this much for a unit that the rate of the gap jumps by.
    pub direction: Vec<(usize, Id)>,
    /// The symbol of what holds the gap closed, as the acceleration of the gap that it makes. Outputs contain it; the
    /// rates do not.
    pub reaction: Id,
}

impl System {
    /// Whether something is held between the samples of a controller.
    pub fn holds(&self) -> bool {
        let outputs = self.outputs.iter().map(|output| output.node);
        let roots: Vec<Id> = self.known.iter().copied().chain(outputs).collect();
        let terms: Vec<Id> = self.terms.iter().map(|term| term.value).collect();
        let is_held = |id: &Id| matches!(self.graph.node(*id), Node::Binary(Binary::Hold, ..));
        [roots, terms].iter().any(|of| self.graph.reachable(of).iter().any(is_held))
    }

    /// Whether states jump: see [`Impact`] and [`System::holds`].
    pub fn jumps(&self) -> bool {
        !self.impacts.is_empty() || self.holds()
    }

    /// The rates of the gaps of impacts, apart from what moves beside the states.
    pub fn gap_rates(&self, graph: &mut Graph) -> Vec<Id> {
        let rate = |impact: &Impact| {
            let zero = graph.constant(0.0);
            self.closing(graph, impact.gap).into_iter().fold(zero, |sum, (speed, slope)| {
                let part = graph.mul(slope, self.states[speed].node);
                graph.add(sum, part)
            })
        };
        self.impacts.iter().map(rate).collect()
    }

    /// The speeds by which the rate of a gap is made, and its derivative by each.
    pub(crate) fn closing(&self, graph: &mut Graph, gap: Id) -> Vec<(usize, Id)> {
        let displacements = || self.states.iter().filter(|s| s.velocity.is_some());
        let slopes = graph.gradient(gap, &displacements().map(|s| s.node).collect::<Vec<_>>());
        let mut all: Vec<(usize, Id)> = Vec::new();
        for (speed, slope) in displacements().filter_map(|s| s.velocity).zip(slopes) {
            match all.iter_mut().find(|(known, _)| *known == speed) {
                Some((_, sum)) => *sum = graph.add(*sum, slope),
                None => all.push((speed, slope)),
            }
        }
        all.retain(|&(_, slope)| graph.value(slope) != Some(0.0));
        all
    }

    /// The impacts, for a model with these names.
    pub(crate) fn rebounds(&self, graph: &mut Graph, names: &mut Names) -> Vec<Rebound> {
        let mut all = Vec::new();
        for (k, impact) in self.impacts.iter().enumerate() {
            let closing = self.closing(graph, impact.gap);
            let zero = graph.constant(0.0);
            let mut moves = vec![zero; self.states.len()];
            for &(speed, slope) in &closing {
                let share = self.inertia[speed].map_or(slope, |own| graph.div(slope, own));
                self.add_rate(graph, &mut moves, speed, share);
            }
            // The rate of the gap for a unit of that force.
            let along = closing.iter().fold(zero, |sum, &(speed, slope)| {
                let part = graph.mul(slope, moves[speed]);
                graph.add(sum, part)
            });
            let moved = (0..moves.len()).filter(|&k| graph.value(moves[k]) != Some(0.0));
            let direction = moved.collect::<Vec<_>>().into_iter();
            let direction = direction.map(|k| (k, graph.div(moves[k], along))).collect();
            // A space keeps the name out of reach of any spec.
            let reaction = names.intern(&format!("reaction {k}"));
            let reaction = graph.symbol(reaction);
            all.push(Rebound { gap: impact.gap, restitution: impact.restitution, direction, reaction });
        }
        all
    }
}

impl Model {
    /// The model with an impact more, for tests and examples: the gap, the restitution, and the states that jump, each by
    /// this much for a unit that the rate of the gap jumps by.
    ///
    /// # Errors
    /// As [`Model::build`].
    pub fn rebounding(
        mut self,
        gap: &str,
        restitution: &str,
        direction: &[(usize, &str)],
    ) -> Result<Model, String> {
        let [gap, restitution] = [self.lowered(gap)?, self.lowered(restitution)?];
        let direction = direction.iter().map(|&(k, by)| Ok((k, self.lowered(by)?)));
        let direction =
            direction.collect::<Vec<Result<_, String>>>().into_iter().collect::<Result<_, _>>()?;
        let reaction = self.names.intern(&format!("reaction {}", self.impacts.len()));
        let reaction = self.graph.symbol(reaction);
        self.impacts.push(Rebound { gap, restitution, direction, reaction });
        Ok(self)
    }

    /// Replaces nodes in the impacts.
    pub fn replace_in_impacts(&mut self, with: &HashMap<Id, Id>) {
        for of in &mut self.impacts {
            let direction = of.direction.iter_mut().map(|(_, by)| by);
            for id in [&mut of.gap, &mut of.restitution].into_iter().chain(direction) {
                *id = self.graph.replace(&[*id], with)[0];
            }
        }
    }
}
