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
