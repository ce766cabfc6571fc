//! What else moves with a body, where rates were solved by hand for a mass matrix that is not diagonal.

use phisindy_expr::{Graph, Id, Scratch, Tape};
use phisindy_phys::System;
use phisindy_phys::unit::{Dimension, Unit};

/// Points at which rates are compared: what agrees at all of them is the same.
const POINTS: usize = 8;

/// A speed, another one, and the rate of the latter for a rate of 1 of the former by a force along it, as in
/// [`System::coupling`]. An input that is a force along a speed shows where such a force goes.
///
/// Where another body is coupled by an entry of the mass matrix that turns with the motion, the inertia that a force
/// feels turns too. A constant inertia shows nothing: the input may act on both bodies, by a gear or a lever.
pub(super) fn shown_by_inputs(system: &System, graph: &mut Graph) -> Vec<(usize, usize, Id)> {
    let states: Vec<Id> = system.states.iter().map(|s| s.node).collect();
    let speeds: Vec<usize> = system.states.iter().filter_map(|x| x.velocity).collect();
    let mut all = Vec::new();
    for &v in &speeds {
        let Some(inertia) = system.inertia[v].filter(|&own| graph.uses(&[own], &states)) else { continue };
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
            for &other in speeds.iter().filter(|&&other| other != v) {
                let theirs = share(graph, other);
                if graph.value(theirs) != Some(0.0) {
                    follows.push((other, graph.div(theirs, own)));
                }
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

#[cfg(test)]
mod tests {
    use crate::places;
    use phisindy_phys::{SourceId, check, spec};

    /// How many speeds are coupled in a model of a cart and what hangs on it.
    fn coupled(inertia: &str, rates: [&str; 2]) -> usize {
        let text = format!(
            r#"(states: {{ "x": "m", "v": "m/s", "th": "rad", "w": "rad/s" }}, inputs: {{ "F": "N" }}, inertia: {{ "v": "{inertia}" }},
            constants: {{ "M": (2.0, "kg"), "m": (1.0, "kg"), "l": (0.5, "m"), "k": (20.0, "N/m") }},
            known: {{ "x": "v", "th": "w", "v": "{}", "w": "{}" }}, unknown: {{}},
            data: [ Csv(path: "a.csv", time: "t", columns: {{ "x": "x", "F": "F" }}) ])"#,
            rates[0], rates[1]
        );
        let (read, _) = spec::read(&text, SourceId(0)).expect("a spec");
        let (mut case, _) = check(&read, SourceId(0)).expect("a case");
        places(&mut case.system, &case.records);
        case.system.coupling.len()
    }

    #[test]
    fn a_mass_matrix_that_was_inverted_by_hand_is_seen_and_a_lever_is_none() {
        let felt = "M + m*sin(th)^2";
        let solved = ["(F - k*x)/(M + m*sin(th)^2)", "-cos(th)/l*(F - k*x)/(M + m*sin(th)^2)"];
        assert_eq!(coupled(felt, solved), 1);
        for lever in ["0.3*l*F/(m*l^2)", "-l*cos(th)*F/(m*l^2)"] {
            assert_eq!(coupled("M", ["(F - k*x)/M", lever]), 0, "{lever}");
        }
    }
}
