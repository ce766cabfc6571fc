//! Expressions along a measured motion, and along the run of a fitted model.

use crate::motion::Motion;
use crate::place::{Place, Site};
use phisindy_expr::{Scratch, Tape};
use phisindy_learn::{FoundParameter, parameter_values};
use phisindy_phys::{Record, System};
use phisindy_sim::Trajectory;

/// All outputs of a tape along a motion. `grid` holds further constant inputs, `series` further inputs by
/// sample.
pub(crate) fn evaluated(tape: &Tape, motion: &Motion, grid: &[f64], series: &[&[f64]]) -> Vec<Vec<f64>> {
    const LANES: usize = 64;
    let samples = motion.samples();
    let (n, m) = (motion.states.len() / samples, motion.inputs.len() / samples);
    let mut scratch = Scratch::<LANES>::new(tape);
    let after = 1 + n + m;
    for (k, v) in motion.numbers.iter().chain(grid).enumerate() {
        *scratch.input(after + k) = [*v; LANES];
    }
    let last = after + motion.numbers.len() + grid.len();
    let mut out = vec![Vec::with_capacity(samples); tape.outputs()];
    for first in (0..samples).step_by(LANES) {
        let count = LANES.min(samples - first);
        for lane in 0..LANES {
            let i = first + lane.min(count - 1);
            scratch.input(0)[lane] = motion.time[i];
            (0..n).for_each(|k| scratch.input(1 + k)[lane] = motion.states[i * n + k]);
            (0..m).for_each(|k| scratch.input(1 + n + k)[lane] = motion.inputs[i * m + k]);
            series.iter().enumerate().for_each(|(k, s)| scratch.input(last + k)[lane] = s[i]);
        }
        scratch.run();
        out.iter_mut().enumerate().for_each(|(k, o)| o.extend(&scratch.output(k)[..count]));
    }
    out
}

/// The velocity of a place along a motion.
pub(crate) fn speed(system: &System, motion: &Motion, place: &Place) -> Option<Vec<f64>> {
    let Site::Force { velocity, .. } = &place.site else { return None };
    let tape = Tape::compile(&system.graph, &system.arguments(), &[velocity.node]).ok()?;
    evaluated(&tape, motion, &[], &[]).pop()
}

/// The acceleration of what the body of a place is carried by while it rests there: an input, or a belt whose speed
/// the spec gives. Zero where that is the ground or another body.
pub(crate) fn carried(system: &System, motion: &Motion, place: &Place) -> Option<Vec<f64>> {
    let Site::Force { velocity, .. } = &place.site else { return None };
    let prescribed: Vec<_> = [system.time].into_iter().chain(system.inputs.iter().map(|u| u.node)).collect();
    let mut graph = system.graph.clone();
    let slopes = graph.gradient(velocity.node, &prescribed);
    if slopes.iter().all(|&slope| graph.value(slope) == Some(0.0)) {
        return None;
    }
    let tape = Tape::compile(&graph, &system.arguments(), &slopes).ok()?;
    let by = evaluated(&tape, motion, &[], &[]);
    let m = system.inputs.len();
    let of = |i: usize| {
        let inputs = (0..m).map(|j| by[1 + j][i] * motion.slopes[i * m + j]);
        -by[0][i] - inputs.sum::<f64>()
    };
    Some((0..motion.samples()).map(of).collect())
}

/// The first `N` outputs of a tape at every few samples of the run of a record, with the numbers that were
/// found.
pub(crate) fn along_run<'a, const N: usize>(
    tape: &'a Tape,
    (system, parameters): (&System, &[FoundParameter]),
    (index, record): (usize, &'a Record),
    run: &'a Trajectory,
    every: usize,
) -> impl Iterator<Item = [f64; N]> + 'a {
    let owner = record.continues.unwrap_or(index);
    let mut numbers = parameter_values(parameters, system, owner);
    numbers.extend(&record.constants);
    let mut scratch = Scratch::<1>::new(tape);
    (0..record.len()).step_by(every).map(move |i| {
        let t = record.time[i];
        let inputs = record.inputs.iter().map(|u| u.value(t));
        let states = run.state_at(i).iter().copied();
        scratch.at([t].into_iter().chain(states).chain(inputs).chain(numbers.iter().copied()));
        std::array::from_fn(|k| scratch.output(k)[0])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::{fitted, model};

    /// A body that rests on a belt whose speed is `0.3 sin(2 t)` has the acceleration `0.6 cos(2 t)`; the ground and an
    /// input of other bodies carry nothing.
    #[test]
    fn a_belt_of_given_speed_carries_what_rests_on_it() {
        let (base, noise) = model(
            r#"(states: { "x": "m", "v": "m/s" }, known: { "x": "v", "v": "-x - 0.1*v" }, unknown: {},
                contacts: ["v - 0.3*sin(2*t)"],
                data: [ Synthetic(truth: {}, start: { "x": 1.0, "v": 0.0 }, duration: 10.0, step: 0.05,
                    noise: Additive(0.01), seed: 1) ])"#,
        );
        let fitted = fitted(base, &noise);
        let model = &fitted.model;
        let motion = Motion::new(&model.system, &model.records[0], &model.smooth[0], 0, &fitted.cal);
        let carried = |belt: bool| {
            let place = model.places().iter().find(|p| p.is_on_base() == belt && p.at.starts_with('v'));
            super::carried(&model.system, &motion, place.expect("a place"))
        };
        let due = motion.time.iter().map(|t| 0.6 * (2.0 * t).cos());
        assert!(carried(true).expect("a belt").iter().zip(due).all(|(a, due)| (a - due).abs() < 1e-12));
        assert_eq!(carried(false), None);
    }
}
