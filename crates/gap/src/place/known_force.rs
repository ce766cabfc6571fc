//! The forces of the known part that may press what rubs: the terms of the rates of a place's bodies.

use super::{Place, Site};
use phisindy_expr::{Binary, Graph, Id, Node, Unary};
use phisindy_phys::System;

/// The terms of the known rates of a place's bodies, as forces, in the language of the spec: springs and
/// inputs, not constants (they are a part of the level) nor what depends on velocities alone (it is a damper
/// already).
pub(crate) fn known_forces(system: &System, place: &Place) -> Vec<String> {
    let Site::Force { acts, .. } = &place.site else { return vec![] };
    if place.enters() {
        return vec![];
    }
    let mut system = system.clone();
    let displacements: Vec<Id> =
        system.states.iter().filter(|s| s.velocity.is_some()).map(|s| s.node).collect();
    let inputs: Vec<Id> = system.inputs.iter().map(|u| u.node).collect();
    let varies: Vec<Id> = displacements.into_iter().chain(inputs).chain([system.time]).collect();
    let mut all: Vec<String> = Vec::new();
    for &(state, _) in acts {
        // The matrices of a structure are no forces that press at one of its points.
        let point = system.points.iter().any(|point| point.speed == state);
        let own = system.momenta.iter().find(|(speed, ..)| point && *speed == state);
        if let Some(&(.., sum)) = own {
            for term in
                terms(&system.graph, sum).into_iter().filter(|&term| system.graph.uses(&[term], &varies))
            {
                all.push(system.graph.text(term, &system.names));
            }
            continue;
        }
        let (rate, inertia) = (system.known[state], system.inertia[state]);
        // `(a + b)/m` is a sum of forces over the inertia.
        let (sum, factor) = match (system.graph.node(rate), inertia) {
            (Node::Binary(Binary::Div, sum, over), Some(m)) if over == m => (sum, None),
            (_, inertia) => (rate, inertia),
        };
        for term in terms(&system.graph, sum) {
            if !system.graph.uses(&[term], &varies) {
                continue;
            }
            let force = factor.map_or(term, |m| system.graph.mul(m, term));
            let text = system.graph.text(force, &system.names);
            if !all.contains(&text) {
                all.push(text);
            }
        }
    }
    all
}

/// The terms of a sum, without their signs.
fn terms(graph: &Graph, sum: Id) -> Vec<Id> {
    let (mut waiting, mut all) = (vec![sum], Vec::new());
    while let Some(id) = waiting.pop() {
        match graph.node(id) {
            Node::Binary(Binary::Add | Binary::Sub, a, b) => waiting.extend([a, b]),
            Node::Unary(Unary::Neg, a) => waiting.push(a),
            _ => all.push(id),
        }
    }
    all.reverse();
    all
}

#[cfg(test)]
mod tests {
    use crate::test_models::model;

    #[test]
    fn springs_and_inputs_press_dampers_and_constants_do_not() {
        let (base, _) = model(
            r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (3.0, "N/m"), "m": (2.0, "kg"), "c": (0.1, "N*s/m"), "g": (9.81, "m/s^2"), "F0": (1.0, "N"), "W": (0.7, "rad/s") },
            known: { "x": "v", "v": "(-k*x - c*v + F0*cos(W*t) - m*g)/m" },
            inertia: { "v": "m" }, unknown: {}, data: [ Synthetic(truth: {}, start: { "x": 1.0, "v": 0.0 }, duration: 40.0, step: 0.05, noise: Additive(0.02), seed: 1) ])"#,
        );
        let place = base.places().iter().find(|p| p.at == "v").expect("a place").clone();
        let all = super::known_forces(&base.system, &place);
        assert_eq!(all.len(), 2, "{all:?}");
        assert!(all[0].contains('x') && all[1].contains("cos"), "{all:?}");
    }
}
