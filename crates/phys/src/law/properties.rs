//! What a law is, asked of its graph: whether it sticks, has a clearance, is a spring, a resistance, a
//! hysteresis, and which of its parameters are linear.

use super::graph::{LawGraph, jointly_linear};
use super::{Law, Role};
use phisindy_expr::{Binary, Id, Node, Scratch, Unary};
use std::collections::HashMap;

/// A speed (m/s) below all that move.
const NEARLY_AT_REST: f64 = 1e-30;
/// A force that changes by a smaller part of itself does not jump.
const NO_JUMP: f64 = 1e-6;

impl Law {
    /// Whether it is a hysteresis: it has memory, and its states rest while the place rests, however slowly
    /// or fast the place came there. Examples: an elastic contact, Bouc-Wen; not a dashpot behind a spring,
    /// which relaxes.
    pub fn is_hysteretic(&self) -> bool {
        let of = &self.compiled;
        let (Some(v), false) = (of.velocity, of.rates.is_empty()) else { return false };
        let mut graph = of.graph.clone();
        let zero = graph.constant(0.0);
        let resting = graph.replace(&of.rates, &HashMap::from([(v, zero)]));
        // Numbers of no meaning: what vanishes for them vanishes for all.
        let (symbols, tape) = LawGraph::program(&mut graph, &resting);
        let mut scratch = Scratch::<1>::new(&tape);
        scratch.at((0..symbols.len()).map(|k| 0.7 + 0.1 * (k as f64).sin()));
        (0..resting.len()).all(|k| scratch.output(k)[0] == 0.0)
    }

    /// Whether it is a friction that can stick: its force jumps with the sign of the velocity.
    pub fn sticks(&self) -> bool {
        let of = &self.compiled;
        let (Some(force), Some(v)) = (of.force.filter(|_| self.force.is_some()), of.velocity) else {
            return false;
        };
        crate::system::equations::contains_sign(&mut of.graph.clone(), &[force], v) && self.jumps(force, v)
    }

    /// The parameters that act at rest only: levels of static friction.
    pub fn static_levels(&self) -> Vec<usize> {
        let of = &self.compiled;
        let Some(force) = of.force else { return vec![] };
        let mut graph = of.graph.clone();
        let sliding = [graph.with_rest(force, 0.0)];
        let only_at_rest = |k: &usize| {
            graph.uses(&[force], &[of.parameters[*k]]) && !graph.uses(&sliding, &[of.parameters[*k]])
        };
        (0..of.parameters.len()).filter(only_at_rest).collect()
    }

    /// Whether a force differs at velocities a little above and below zero, with every other number inside
    /// its bounds. A power of the speed has a sign and does not jump.
    fn jumps(&self, force: Id, v: Id) -> bool {
        let of = &self.compiled;
        let (symbols, tape) = LawGraph::program(&mut of.graph.clone(), &[force]);
        let mut scratch = Scratch::<1>::new(&tape);
        let mut at = |speed: f64| {
            let value = |id: &Id| {
                let (low, high) = self.bounds_of(*id).unwrap_or((0.0, 1.0));
                if *id == v { speed } else { 0.7_f64.clamp(low, high) }
            };
            scratch.at(symbols.iter().map(value));
            scratch.output(0)[0]
        };
        let (above, below, far) = (at(NEARLY_AT_REST), at(-NEARLY_AT_REST), at(1.0));
        (above - below).abs() > NO_JUMP * far.abs()
    }

    /// Bounds of a parameter; none for another symbol.
    pub(super) fn bounds_of(&self, symbol: Id) -> Option<(f64, f64)> {
        let own = self.compiled.parameters.iter().position(|p| *p == symbol)?;
        Some(self.parameters[own].1.within)
    }

    /// Whether it has a clearance: its force has a corner or a jump at a displacement other than zero.
    pub fn has_clearance(&self) -> bool {
        let of = &self.compiled;
        let (Some(force), Some(x)) = (of.force, of.displacement) else { return false };
        let depends = |id: Id| of.graph.uses(&[id], &[x]);
        of.graph.reachable(&[force]).into_iter().any(|id| match of.graph.node(id) {
            Node::Binary(Binary::Max | Binary::Min | Binary::Dead | Binary::Mod, a, b) => {
                depends(a) || depends(b)
            }
            Node::Unary(
                Unary::Pos | Unary::Step | Unary::Abs | Unary::Sgn | Unary::Rest | Unary::Floor,
                a,
            ) => a != x && depends(a),
            _ => false,
        })
    }

    /// Whether it is a resistance: a force of the velocity alone, without memory, that does not stick.
    /// Examples: a dashpot, drag.
    pub fn is_resistance(&self) -> bool {
        let of = &self.compiled;
        let (Some(force), Some(v), false) = (of.force, of.velocity, self.has_memory()) else { return false };
        let others: Vec<Id> = of
            .displacement
            .into_iter()
            .chain([of.time])
            .chain(of.outside.iter().map(|(_, id)| *id))
            .chain(of.load)
            .collect();
        !self.sticks() && of.graph.uses(&[force], &[v]) && !of.graph.uses(&[force], &others)
    }

    /// Whether it is a force of time alone.
    pub fn is_of_time(&self) -> bool {
        let of = &self.compiled;
        let Some(force) = of.force else { return false };
        let others: Vec<Id> = (of.displacement.into_iter().chain(of.velocity).chain(of.load))
            .chain(of.outside.iter().map(|(_, id)| *id))
            .collect();
        let timed = of.graph.uses(&[force], &[of.time]) && !of.graph.uses(&[force], &others);
        timed && !self.has_memory()
    }

    /// Whether it is a spring: a force of the displacement alone, without memory.
    pub fn is_spring(&self) -> bool {
        let of_displacement = self.role(Role::Displacement).is_some() && self.role(Role::Velocity).is_none();
        of_displacement && self.property().is_none() && !self.has_memory()
    }

    /// Whether it is a spring in proportion to the displacement, at all times.
    pub fn is_linear_spring(&self) -> bool {
        let of = &self.compiled;
        let (true, Some(force), Some(x)) = (self.is_spring(), of.force, of.displacement) else {
            return false;
        };
        let mut graph = of.graph.clone();
        let slope = graph.gradient(force, &[x])[0];
        !graph.uses(&[slope], &[x, of.time])
    }

    /// The value of its one parameter at which what acts is the recorded input itself, if that parameter stands
    /// linearly there: the 1 of a gain, the 0 of an offset. `None` for any other law.
    pub fn neutral_input(&self) -> Option<f64> {
        let of = &self.compiled;
        let ((u, acts), [parameter], false) = (of.acting?, &of.parameters[..], self.has_memory()) else {
            return None;
        };
        let mut graph = of.graph.clone();
        let slope = graph.gradient(acts, &[*parameter])[0];
        if graph.uses(&[slope], &[*parameter]) {
            return None;
        }
        // u = p*slope + rest, at an input of 1.
        let (one, zero) = (graph.constant(1.0), graph.constant(0.0));
        let at = HashMap::from([(u, one), (*parameter, zero)]);
        let values = graph.replace(&[slope, acts], &at);
        Some((1.0 - graph.value(values[1])?) / graph.value(values[0])?)
    }

    /// Whether it is a factor of an input.
    pub fn is_input_gain(&self) -> bool {
        self.neutral_input() == Some(1.0)
    }

    /// Whether it is a force of the motion that is not in proportion to it, without memory: a curve.
    pub fn is_curve(&self) -> bool {
        let of = &self.compiled;
        let motion: Vec<Id> = of.displacement.into_iter().chain(of.velocity).collect();
        let (Some(force), false) = (of.force, self.has_memory()) else { return false };
        let mut graph = of.graph.clone();
        let slopes = graph.gradient(force, &motion);
        self.sticks() || graph.uses(&slopes, &motion)
    }

    /// The parameters in which the force is linear, jointly: no slope by one of them depends on another of
    /// them.
    pub fn linear_parameters(&self) -> Vec<usize> {
        let of = &self.compiled;
        of.force.map_or(vec![], |force| jointly_linear(&mut of.graph.clone(), force, &of.parameters))
    }
}
