//! What else moves with a body, where rates were solved by hand for a mass matrix that is not diagonal.

use phisindy_expr::{Graph, Id, Scratch, Tape};
use phisindy_phys::System;
use phisindy_phys::unit::{Dimension, Unit};

/// Points at which rates are compared: what agrees at all of them is the same.
const POINTS: usize = 8;

/// A speed, another one, and the rate of the latter for a rate of 1 that a force along the former makes ([`System::coupling`]): an
/// input that acts along a speed alone, as a force over its inertia, shows where a force there goes. A rate that is the
/// input over the inertia, with the opposite at another body, is a force between the two and shows nothing.
pub(super) fn shown_by_inputs(system: &System, graph: &mut Graph) -> Vec<(usize, usize, Id)> {
    let speeds: Vec<usize> = system.states.iter().filter_map(|x| x.velocity).collect();
    let mut all = Vec::new();
    for &v in &speeds {
        let Some(inertia) = system.inertia[v] else { continue };
        let mut found: Option<Vec<(usize, Id)>> = None;
        for input in &system.inputs {
            // What has the unit of the rate is an acceleration of the base, and acts on all bodies.
            let dimension = |unit: &str| Unit::parse(unit).map_or(Dimension::NONE, |u| u.dimension);
            if dimension(&input.unit) == dimension(&system.states[v].unit).div(Dimension::SECOND) {
                continue;
            }
            let share = |graph: &mut Graph, k: usize| graph.gradient(system.known[k], &[input.node])[0];
            let own = share(graph, v);
            let force = graph.mul(own, inertia);
            if !is_everywhere(graph, force, 1.0) && !is_everywhere(graph, force, -1.0) {
                continue;
            }
            let mut follows = Vec::new();
            let mut between = false;
            for &other in speeds.iter().filter(|&&other| other != v) {
                let theirs = share(graph, other);
                if graph.value(theirs) == Some(0.0) {
                    continue;
                }
                let ratio = graph.div(theirs, own);
                between |= system.inertia[other].is_some_and(|m| {
                    let (a, b) = (graph.mul(theirs, m), graph.mul(own, inertia));
                    let sum = graph.add(a, b);
                    is_everywhere(graph, sum, 0.0)
                });
                follows.push((other, ratio));
            }
            if between {
                continue;
            }
            // Inputs that contradict each other show nothing.
            match &found {
                Some(before) if !agree(graph, before, &follows) => {
                    found = None;
                    break;
                }
                Some(_) => {}
                None => found = Some(follows),
            }
        }
        all.extend(found.into_iter().flatten().map(|(other, ratio)| (v, other, ratio)));
    }
    all
}

fn agree(graph: &mut Graph, a: &[(usize, Id)], b: &[(usize, Id)]) -> bool {
    a.len() == b.len()
        && a.iter().zip(b).all(|(x, y)| {
            let difference = graph.sub(x.1, y.1);
            x.0 == y.0 && is_everywhere(graph, difference, 0.0)
        })
}

/// Whether an expression has this value at points of no symmetry, up to rounding.
fn is_everywhere(graph: &Graph, of: Id, value: f64) -> bool {
    let mut graph = graph.clone();
    let symbols: Vec<Id> = graph.symbols(&[of]).into_iter().map(|s| graph.symbol(s)).collect();
    let Ok(tape) = Tape::compile(&graph, &symbols, &[of]) else { return false };
    let mut scratch = Scratch::<1>::new(&tape);
    (0..POINTS).all(|point| {
        for k in 0..symbols.len() {
            scratch.input(k)[0] = 0.3 + 0.7 * (0.7 + (point * (k + 2)) as f64).sin().abs();
        }
        scratch.run();
        (scratch.output(0)[0] - value).abs() < 1e-9
    })
}
