//! The friction of a joint as simulators of robots have it: a dry and a viscous part.

use phisindy_expr::{Scratch, Tape};
use phisindy_phys::System;

/// A part of a friction that is so small beside it is what rounding leaves.
const ROUNDING: f64 = 1e-9;

/// Motion of a record, in SI.
pub struct Moved {
    /// The samples of each state of the system.
    pub states: Vec<Vec<f64>>,
    /// The constants of the record, in the order of [`System::record_constants`].
    pub constants: Vec<f64>,
}

/// Dry and viscous friction that come nearest to those of a model, over the speeds of its records (least squares, none
/// negative).
#[derive(Clone, Debug, PartialEq)]
pub struct JointFriction {
    /// Dry friction (N or N m).
    pub dry: f64,
    /// Viscous friction (N s/m or N m s).
    pub viscous: f64,
    /// What they miss of the model's force: the ratio of the mean squares, as a root.
    pub missed: f64,
    /// The greatest speed of the records.
    pub fastest: f64,
    /// Other states on which the model's force depends.
    pub depends_on: Vec<String>,
}

impl JointFriction {
    /// The friction at a place that the spec names; `None` where no such place is a speed of `energy`, or where nothing
    /// moves it.
    pub fn of(system: &System, place: &str, records: &[Moved]) -> Option<JointFriction> {
        let named = system.places.iter().find(|own| own.name == place)?;
        let speed = system.states.iter().position(|state| state.node == named.of.node)?;
        let &(_, force) = system.undriven.iter().find(|(own, _)| *own == speed)?;
        let mut graph = system.graph.clone();
        let lost = graph.neg(force);
        let other = |k: &usize| *k != speed && graph.uses(&[lost], &[system.states[*k].node]);
        let depends_on: Vec<String> =
            (0..system.states.len()).filter(other).map(|k| system.states[k].name.clone()).collect();
        let tape = Tape::compile(&graph, &system.arguments(), &[lost]).ok()?;
        let mut scratch = Scratch::<1>::new(&tape);
        let mut all: Vec<(f64, f64)> = vec![];
        for Moved { states, constants } in records {
            for sample in 0..states.get(speed)?.len() {
                let of_states = states.iter().map(|values| values[sample]);
                // No input is in it, nor the time.
                let inputs = system.inputs.iter().map(|_| 0.0);
                let parameters = system.parameters.iter().map(|p| p.start);
                let values = [0.0]
                    .into_iter()
                    .chain(of_states)
                    .chain(inputs)
                    .chain(parameters)
                    .chain(constants.iter().copied());
                all.push((states[speed][sample], scratch.at(values).output(0)[0]));
            }
        }
        // At rest the force is what holds, not what these numbers say.
        all.retain(|(v, force)| *v != 0.0 && force.is_finite());
        let fastest = all.iter().fold(0.0_f64, |most, (v, _)| most.max(v.abs()));
        let strongest = all.iter().fold(0.0_f64, |most, (_, force)| most.max(force.abs()));
        // What rounding leaves is none.
        let sound = |x: f64, of: f64| if x * of < ROUNDING * strongest { 0.0 } else { x };
        let (dry, viscous) =
            nearest(&all).map(|(dry, viscous)| (sound(dry, 1.0), sound(viscous, fastest)))?;
        let square = |x: f64| x * x;
        let size: f64 = all.iter().map(|(_, force)| square(*force)).sum();
        let off: f64 = all.iter().map(|(v, force)| square(force - dry * v.signum() - viscous * v)).sum();
        let missed = if size > 0.0 { (off / size).sqrt() } else { 0.0 };
        Some(JointFriction { dry, viscous, missed, fastest, depends_on })
    }
}

/// The two numbers of least squares that are not negative.
fn nearest(all: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = all.len() as f64;
    let sum = |of: &dyn Fn(f64, f64) -> f64| {
        all.iter().map(|&(v, force)| of(v.abs(), force * v.signum())).sum::<f64>()
    };
    let (v, vv, f, fv) = (sum(&|v, _| v), sum(&|v, _| v * v), sum(&|_, f| f), sum(&|v, f| f * v));
    let det = n * vv - v * v;
    let both = ((f * vv - fv * v) / det, (n * fv - f * v) / det);
    // One speed alone does not tell them apart: it is dry.
    let alone = [(f / n, 0.0), (0.0, fv / vv)].map(|(a, b)| (a.max(0.0), b.max(0.0)));
    let missed = |(dry, viscous): (f64, f64)| sum(&|v, f| (f - dry - viscous * v).powi(2));
    match () {
        () if all.is_empty() => None,
        () if det > 1e-9 * n * vv && both.0 >= 0.0 && both.1 >= 0.0 => Some(both),
        () => alone.into_iter().min_by(|a, b| missed(*a).total_cmp(&missed(*b))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_phys::{SourceId, check, spec};

    fn of(dissipation: &str, speeds: &[f64]) -> JointFriction {
        let text = format!(
            r#"(constants: {{ "m": 1.0 }}, inputs: {{ "F": "" }},
                energy: (coordinates: {{ "x": ("v", "") }}, kinetic: "m*v^2/2", {dissipation}),
                places: {{ "rail": "v" }})"#
        );
        let (spec, _) = spec::read_without_data(&text, SourceId(0)).expect("a spec");
        let (case, _) = check(&spec, SourceId(0)).expect("a case");
        let moved = Moved { states: vec![vec![0.3; speeds.len()], speeds.to_vec()], constants: vec![] };
        JointFriction::of(&case.system, "rail", &[moved]).expect("a friction")
    }

    #[test]
    fn dry_and_viscous_friction_are_themselves_whatever_drives() {
        let speeds: Vec<f64> = (-20..30).map(|k| 0.05 * f64::from(k)).collect();
        let found =
            of(r#"dissipation: "3*|v| + 0.7*v^2/2", forces: { "F": "v", "-0.5*sgn(v)": "v" }"#, &speeds);
        assert!((found.dry - 3.5).abs() < 1e-12 && (found.viscous - 0.7).abs() < 1e-12, "{found:?}");
        assert!(found.missed < 1e-12 && found.depends_on.is_empty(), "{found:?}");
    }

    #[test]
    fn of_a_law_that_falls_what_two_numbers_miss_is_told() {
        let speeds: Vec<f64> = (1..100).map(|k| 0.01 * f64::from(k)).collect();
        let found = of(r#"forces: { "F": "v", "-(1 + exp(-(v/0.1)^2))*sgn(v)": "v", "-2*x": "v" }"#, &speeds);
        // Viscous friction does not fall: the mean is all that is left, and the place is told.
        assert!(found.viscous == 0.0 && found.missed > 0.1 && found.missed < 0.5, "{found:?}");
        assert_eq!(found.depends_on, ["x"]);
    }
}
