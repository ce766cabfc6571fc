//! The resistance that the measured motion asks for, beside the identified part of a rate.

use crate::measured_force::{Acceleration, Body, Parts, SAMPLES};
use phisindy_expr::{Scratch, Tape};
use phisindy_learn::{Identified, UnknownPart};
use phisindy_phys::{Case, Record};

/// Velocity and resistance (SI) at the samples of records.
pub(crate) struct Resistance {
    /// Name of each record, and its points; none where the motion is not measured.
    pub(crate) records: Vec<(String, Vec<(f64, f64)>)>,
    /// What the points are made of.
    pub(crate) parts: Parts,
    /// The longest time (s) over which the motion was smoothed for the acceleration; 0 where it is measured.
    pub(crate) smoothed: f64,
}

/// The resistance of a part in all records; `None` if its graph cannot be evaluated.
pub(crate) fn resistance(
    case: &Case,
    records: &[Record],
    found: &Identified,
    part: &UnknownPart,
) -> Option<Resistance> {
    let system = &case.system;
    let mut graph = system.graph.clone();
    let mut sum = graph.constant(0.0);
    for f in found.terms.iter().filter(|f| system.terms[f.term].state == part.state) {
        let c = graph.constant(f.coefficient.value);
        let share = graph.mul(c, system.terms[f.term].value);
        sum = graph.add(sum, share);
    }
    let one = graph.constant(1.0);
    let inertia = system.inertia[part.state].filter(|_| part.force).unwrap_or(one);
    let share = graph.mul(inertia, sum);
    let force = graph.neg(share);
    let rate = graph.add(system.known[part.state], sum);
    let tape =
        Tape::compile(&graph, &system.arguments(), &[part.velocity, force, part.velocity, rate, inertia])
            .ok()?;
    let mut scratch = Scratch::<1>::new(&tape);
    let body = Body {
        system,
        state: Some(part.state),
        acceleration: Acceleration::of(system, part.state),
        sign: -1.0,
    };
    let parts = if part.force { body.parts() } else { Parts::Rates };
    let mut out = Resistance { records: vec![], parts, smoothed: 0.0 };
    for (r, record) in records.iter().enumerate() {
        let fit = &found.records[r];
        let Some(run) = &fit.run else { continue };
        let numbers = found.parameters_of(system, record.continues.unwrap_or(r));
        let mut evaluated = |i: usize, states: &[f64], numbers: &[f64]| -> [f64; 5] {
            crate::measured_force::outputs_at(&mut scratch, record, i, states, numbers)
        };
        let every = record.len().div_ceil(SAMPLES).max(1);
        let forces = (0..record.len()).step_by(every).map(|i| evaluated(i, run.state_at(i), &numbers)[1]);
        let typical = forces.filter(|f| f.is_finite()).map(f64::abs).fold(0.0, f64::max);
        let (points, smoothed) = body.measured(record, fit, &fit.noise, typical, &numbers, &mut evaluated);
        out.smoothed = out.smoothed.max(smoothed);
        out.records.push((record.name.clone(), points));
    }
    Some(out)
}
