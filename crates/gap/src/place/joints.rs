//! Joints that the model has: sums of displacements with numbers, such as `q/n - p` behind a gear, on which a force depends
//! that acts on all of their bodies as they are part of the sum.

use super::displacement;
use phisindy_expr::{Binary, Id, Node};
use phisindy_phys::{Contact, System};
use std::collections::{HashMap, HashSet};

/// Two numbers that are computed differently are one.
const ROUNDING: f64 = 1e-9;

/// The speeds of the joints that are no plain differences of two bodies.
pub(super) fn geared(system: &mut System, bodies: &[usize]) -> Vec<(String, Contact)> {
    let moving: Vec<(usize, usize)> =
        bodies.iter().filter_map(|&v| Some((v, displacement(system, v)?))).collect();
    let places: Vec<Id> = moving.iter().map(|&(_, x)| system.states[x].node).collect();
    let forces: Vec<Id> = moving.iter().map(|&(v, _)| force_on(system, v)).collect();
    let felt: Vec<HashSet<Id>> =
        forces.iter().map(|&force| system.graph.reachable(&[force]).into_iter().collect()).collect();
    let mut all = Vec::new();
    for sum in sums_of(system, &forces, &places) {
        let slopes = system.graph.gradient(sum, &places);
        let slopes: Option<Vec<f64>> = slopes.iter().map(|&slope| system.graph.value(slope)).collect();
        let Some(slopes) = slopes else { continue };
        let parts: Vec<(usize, f64)> =
            moving.iter().map(|m| m.0).zip(slopes).filter(|p| p.1 != 0.0).collect();
        // Differences of two bodies are places anyway.
        let plain = parts.len() == 2 && parts[0].1 + parts[1].1 == 0.0;
        let by_all = || {
            let of = moving.iter().zip(&felt).filter(|((v, _), _)| parts.iter().any(|(own, _)| own == v));
            of.map(|(_, nodes)| nodes).all(|nodes| nodes.contains(&sum))
        };
        if parts.len() < 2 || plain || !by_all() || !reacts(system, sum, &moving, &forces, &parts) {
            continue;
        }
        let text: Vec<String> =
            parts.iter().map(|&(v, slope)| format!("{slope:?}*{}", system.states[v].name)).collect();
        let text = text.join(" + ").replace("+ -", "- ");
        let node = parts.iter().fold(system.graph.constant(0.0), |all, &(v, slope)| {
            let slope = system.graph.constant(slope);
            let part = system.graph.mul(slope, system.states[v].node);
            system.graph.add(all, part)
        });
        all.push((text.replace(' ', "").replace("1.0*", ""), Contact { text, node, unit: None }));
    }
    all
}

/// The sums in forces that hang on places and numbers alone.
fn sums_of(system: &System, forces: &[Id], places: &[Id]) -> Vec<Id> {
    let mut of_places: HashSet<Id> = places.iter().copied().collect();
    let mut sums = Vec::new();
    for id in system.graph.reachable(forces) {
        let own = match system.graph.node(id) {
            Node::Constant(_) => true,
            Node::Symbol(_) => false,
            Node::Unary(_, a) => of_places.contains(&a),
            Node::Binary(_, a, b) => of_places.contains(&a) && of_places.contains(&b),
        };
        if own {
            of_places.insert(id);
            if let Node::Binary(Binary::Add | Binary::Sub, ..) = system.graph.node(id) {
                sums.push(id);
            }
        }
    }
    sums
}

/// The force on a body, or its rate where no inertia is known.
fn force_on(system: &mut System, body: usize) -> Id {
    if let Some(&(.., force)) = system.momenta.iter().find(|(speed, ..)| *speed == body) {
        return force;
    }
    match system.inertia[body] {
        Some(inertia) => system.graph.mul(inertia, system.known[body]),
        None => system.known[body],
    }
}

/// Whether what depends on a sum of places acts on each body as it is part of the sum: action and reaction.
fn reacts(
    system: &mut System,
    sum: Id,
    moving: &[(usize, usize)],
    forces: &[Id],
    parts: &[(usize, f64)],
) -> bool {
    let graph = &mut system.graph;
    let joint = system.names.intern("the joint");
    let joint = graph.symbol(joint);
    let with = HashMap::from([(sum, joint)]);
    let through = graph.replace(forces, &with);
    let slopes: Vec<Id> = through.iter().map(|&force| graph.gradient(force, &[joint])[0]).collect();
    // Any numbers do: what is the same everywhere is the same there.
    let mut values: HashMap<Id, Id> =
        system.parameters.iter().map(|p| (p.node, graph.constant(p.start))).collect();
    for symbol in graph.symbols(&slopes) {
        let node = graph.symbol(symbol);
        let some = graph.constant(0.37 + 0.1 * values.len() as f64);
        values.entry(node).or_insert(some);
    }
    let filled = graph.replace(&slopes, &values);
    let felt = |v: usize| {
        let k = moving.iter().position(|m| m.0 == v)?;
        graph.value(filled[k])
    };
    let ratios: Option<Vec<f64>> = parts.iter().map(|&(v, slope)| Some(felt(v)? / slope)).collect();
    ratios.is_some_and(|all| {
        all[0] != 0.0 && all.iter().all(|ratio| (ratio - all[0]).abs() <= ROUNDING * all[0].abs())
    })
}

#[cfg(test)]
mod tests {
    use crate::places;
    use phisindy_phys::{SourceId, check, spec};

    fn at(constants: &str, motor: &str, load: &str) -> Vec<String> {
        let text = format!(
            r#"(states: {{ "pm": "rad", "wm": "rad/s", "pl": "rad", "wl": "rad/s" }}, inputs: {{ "u": "N*m" }},
                constants: {{ "Jm": (2e-4, "kg*m^2"), "J2": (0.03, "kg*m^2"), "k": (value: 60.0, unit: "N*m/rad", within: (1.0, 100.0)), {constants} }},
                known: {{ "pm": "wm", "pl": "wl", "wm": "({motor})/Jm", "wl": "({load})/J2" }},
                inertia: {{ "wm": "Jm", "wl": "J2" }}, unknown: {{}},
                data: [ Csv(path: "run.csv", time: "t", columns: {{ "pm": "pm", "pl": "pl", "u": "u" }}) ])"#
        );
        let (spec, _) = spec::read(&text, SourceId(0)).expect("a spec");
        let (mut case, _) = check(&spec, SourceId(0)).expect("a case");
        places(&mut case.system, &case.records)
            .into_iter()
            .map(|p| p.at)
            .filter(|at| at.contains('*'))
            .collect()
    }

    /// Behind a gear the joint is the twist of the shaft; a sum that is part of the force on one body alone is none.
    #[test]
    fn a_joint_behind_a_gear_is_a_place() {
        let twist = "(k*(pm/n-pl) + 0.03*(wm/n-wl))";
        assert_eq!(
            at(r#""n": 8.0"#, &format!("u - {twist}/n"), &format!("{twist} - 2.0*pl")),
            ["0.125*wm-wl"]
        );
        assert_eq!(at(r#""n": 8.0"#, "u - k*(pm - pl)", "k*(pm - pl) - 7.0*pl"), [""; 0]);
        // Without reaction on the motor it is a sensor's signal, or a mistake.
        assert_eq!(at(r#""n": 8.0"#, "u - 3.0*pm", &twist.replace("wm", "0.5*wm")), [""; 0]);
    }
}
