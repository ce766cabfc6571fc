//! The one-step prediction of PhI-SINDy as expressions: a Runge-Kutta step of the rates with the event
//! condition in every stage (eqs. (17)-(19), (33); Algorithm 2 of the paper).

use phisindy_expr::{Binary, Graph, Id, Names, Tape, Unary};
use phisindy_phys::{Model, System};
use std::collections::HashMap;

/// Where the states stand in [`OneStep::data`].
pub(crate) const FIRST_STATE: usize = 5;

/// A step of the classical Runge-Kutta method as nodes of a graph.
#[derive(Clone, Debug)]
pub(crate) struct OneStep {
    pub(crate) graph: Graph,
    pub(crate) names: Names,
    /// What a step starts from, in this order: time; step length, its half, third and sixth; states; inputs
    /// at the start, in the middle, at the end.
    pub(crate) data: Vec<Id>,
    /// Coefficients and movable constants.
    pub(crate) parameters: Vec<Id>,
    /// The states at the start.
    pub(crate) states: Vec<Id>,
    /// The states at the end.
    pub(crate) next: Vec<Id>,
    /// The velocities of the contacts at the start.
    pub(crate) contacts: Vec<Id>,
}

impl OneStep {
    /// Builds the step for a model. While a contact's velocity is within `tolerance` its degree of freedom
    /// stands still.
    pub(crate) fn new(system: &System, model: &Model, tolerance: f64) -> OneStep {
        let mut graph = model.graph.clone();
        let mut names = model.names.clone();
        let rates = masked(&mut graph, system, model, tolerance);
        let mut fresh = |graph: &mut Graph, name: String| {
            let symbol = names.intern(&name);
            graph.symbol(symbol)
        };
        let [h, half, third, sixth] = ["step length", "half of it", "a third of it", "a sixth of it"]
            .map(|name| fresh(&mut graph, name.into()));
        let middle: Vec<Id> =
            (0..model.inputs.len()).map(|k| fresh(&mut graph, format!("middle {k}"))).collect();
        let end: Vec<Id> = (0..model.inputs.len()).map(|k| fresh(&mut graph, format!("end {k}"))).collect();

        let states = &model.states;
        let stage = |graph: &mut Graph, ahead: Option<Id>, inputs: &[Id], slopes: &[Id]| -> Vec<Id> {
            let Some(ahead) = ahead else { return rates.clone() };
            let mut with = HashMap::new();
            for (&x, &k) in states.iter().zip(slopes) {
                let change = graph.mul(ahead, k);
                with.insert(x, graph.add(x, change));
            }
            with.insert(model.time, graph.add(model.time, ahead));
            with.extend(model.inputs.iter().copied().zip(inputs.iter().copied()));
            graph.replace(&rates, &with)
        };
        let k1 = stage(&mut graph, None, &[], &[]);
        let k2 = stage(&mut graph, Some(half), &middle, &k1);
        // Stage 3 starts from stage 2; the published two-mass notebook takes stage 1 again.
        let k3 = stage(&mut graph, Some(half), &middle, &k2);
        let k4 = stage(&mut graph, Some(h), &end, &k3);
        let next = (0..states.len())
            .map(|i| {
                let inner = graph.add(k2[i], k3[i]);
                let inner = graph.mul(third, inner);
                let outer = graph.add(k1[i], k4[i]);
                let outer = graph.mul(sixth, outer);
                let change = graph.add(inner, outer);
                graph.add(states[i], change)
            })
            .collect();
        let contacts = system.contacts.iter().map(|c| c.node).collect();
        let mut data = vec![model.time, h, half, third, sixth];
        data.extend(states.iter().chain(&model.inputs).chain(&middle).chain(&end));
        OneStep {
            graph,
            names,
            data,
            parameters: model.parameters.clone(),
            states: states.clone(),
            next,
            contacts,
        }
    }

    /// `(next_i - target_i) * weight_i`, with fresh symbols for the targets: returns residuals and targets.
    pub(crate) fn residuals(&mut self, weights: &[f64]) -> (Vec<Id>, Vec<Id>) {
        let mut targets = Vec::new();
        let mut residuals = Vec::new();
        for (i, &weight) in weights.iter().enumerate() {
            let target = self.names.intern(&format!("target {i}"));
            let target = self.graph.symbol(target);
            let miss = self.graph.sub(self.next[i], target);
            let weight = self.graph.constant(weight);
            residuals.push(self.graph.mul(weight, miss));
            targets.push(target);
        }
        (residuals, targets)
    }

    /// Compiles outputs that were built from `inputs` alone.
    ///
    /// # Panics
    /// An output depends on something else: a mistake of this crate.
    pub(crate) fn compile(&self, inputs: &[Id], outputs: &[Id]) -> Tape {
        Tape::compile(&self.graph, inputs, outputs).unwrap_or_else(|e| {
            unreachable!("every symbol of a step is an input: {}", e.message(&self.names))
        })
    }
}

/// The rates with the event condition: where `|w| <= tolerance` a contact's degree of freedom does not move
/// (eq. (33)).
///
/// A contact on one velocity stops that velocity and its displacement, as in the paper. A contact between two
/// moving things keeps `dw/dt = 0`: the rates lose their part along the contact force, whose direction is the
/// surface's normal scaled by the inertias.
fn masked(graph: &mut Graph, system: &System, model: &Model, tolerance: f64) -> Vec<Id> {
    let mut rates = model.rates.clone();
    let tolerance = graph.constant(tolerance);
    for contact in &system.contacts {
        let speed = graph.unary(Unary::Abs, contact.node);
        let slipping = graph.sub(speed, tolerance);
        if let Some(v) = model.states.iter().position(|&x| x == contact.node) {
            for (k, rate) in rates.iter_mut().enumerate() {
                if k == v || system.states[k].velocity == Some(v) {
                    *rate = graph.binary(Binary::Gate, *rate, slipping);
                }
            }
            continue;
        }
        let normal = graph.gradient(contact.node, &model.states);
        let one = graph.constant(1.0);
        let (mut along, mut grip) = (graph.gradient(contact.node, &[model.time])[0], graph.constant(0.0));
        let force: Vec<Id> =
            (0..rates.len()).map(|k| graph.div(normal[k], system.inertia[k].unwrap_or(one))).collect();
        for k in 0..rates.len() {
            let share = graph.mul(normal[k], rates[k]);
            along = graph.add(along, share);
            let share = graph.mul(normal[k], force[k]);
            grip = graph.add(grip, share);
        }
        let multiplier = graph.div(along, grip);
        let zero = graph.constant(0.0);
        let sticking = graph.sub(zero, slipping);
        for (rate, f) in rates.iter_mut().zip(&force) {
            let hold = graph.mul(*f, multiplier);
            let hold = graph.binary(Binary::Gate, hold, sticking);
            *rate = graph.sub(*rate, hold);
        }
    }
    rates
}

#[cfg(test)]
pub(crate) mod tests;
