//! The experiments of a set: one long run that is split, or two runs.

use super::motion::{Experiment, Motion};
use super::rig::{Drive, Rig};
use crate::dice::{Dice, rounded};
use std::f64::consts::TAU;

/// How long and how dense records are.
pub(super) struct Length {
    pub(super) periods: (f64, f64),
    pub(super) samples: (usize, usize),
    /// The least number of samples in a period of the rig.
    pub(super) a_period: f64,
}

/// Draws one long run, to be split at the returned sample, or two runs.
pub(super) fn experiments(rig: &Rig, length: &Length, dice: &mut Dice) -> (Vec<Experiment>, usize) {
    let period = TAU / rig.natural;
    let periods = dice.between(length.periods.0, length.periods.1);
    let samples = dice.whole(length.samples.0, length.samples.1);
    let a_period = (samples as f64 / periods).max(length.a_period);
    let digits = 10f64.powf(2.0 - (period / a_period).log10().floor());
    let step = (period / a_period * digits).round() / digits;
    let split = (0.6 * samples as f64) as usize;
    let grid = |n: usize| (0..n).map(|k| (k as f64 * step * 1e9).round() / 1e9).collect::<Vec<f64>>();
    let first =
        Experiment { start: start(rig, dice), lines: rig.lines.clone(), times: grid(samples), second: false };
    // The end of a released motion is only noise: a second release shows more.
    if rig.drive != Drive::Free && dice.chance(0.5) {
        return (vec![first], split);
    }
    let mut lines = rig.lines.clone();
    match rig.drive {
        // The drive in `known` is the same in both records, except for an amplitude that is a constant of
        // each.
        Drive::Explicit(_) if lines.len() == 1 && dice.chance(0.5) => {
            lines[0].amplitude = rounded(lines[0].amplitude * dice.between(0.7, 1.15));
        }
        Drive::Force(_) | Drive::Base { .. } => {
            let factor = dice.between(0.75, 1.15);
            for line in &mut lines {
                line.amplitude = rounded(line.amplitude * factor);
                line.phase = rounded(dice.between(0.0, TAU));
            }
        }
        _ => {}
    }
    let second = Experiment { start: start(rig, dice), lines, times: grid(samples - split), second: true };
    (vec![Experiment { times: grid(split), ..first }, second], split)
}

fn start(rig: &Rig, dice: &mut Dice) -> Vec<f64> {
    let count = rig.count();
    let rest = rig.drive != Drive::Free && dice.chance(0.4);
    let mut start = vec![0.0; 2 * count];
    if rest {
        return start;
    }
    let size = if rig.drive == Drive::Free { 3.0 } else { 0.6 } * rig.size;
    for k in 0..count {
        start[k] = rounded(dice.sign() * dice.between(0.5, 1.0) * size);
        start[count + k] = rounded(dice.between(-0.5, 0.5) * size * rig.natural);
    }
    start
}

/// The part of an experiment before a sample.
pub(super) fn first_part(experiment: &Experiment, split: usize) -> Experiment {
    Experiment { times: experiment.times[..split].to_vec(), ..experiment.clone() }
}

/// The part of a motion before a sample.
pub(super) fn first_part_of_motion(motion: &Motion, split: usize) -> Motion {
    let cut = |columns: &[Vec<f64>]| columns.iter().map(|c| c[..split].to_vec()).collect();
    Motion {
        n: motion.n,
        states: cut(&motion.states),
        rates: cut(&motion.rates),
        stuck: motion.stuck[..split].to_vec(),
        readings: cut(&motion.readings),
    }
}
