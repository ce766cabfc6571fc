//! How the records of a set are made: one long run that is split, or two runs.

use super::motion::{Experiment, Motion};
use super::rig::{Drive, Rig};
use crate::dice::{Dice, rounded};
use std::f64::consts::TAU;

/// One long run that is split at a sample, or two runs.
pub(super) fn experiments(rig: &Rig, dice: &mut Dice) -> (Vec<Experiment>, usize) {
    let period = TAU / rig.natural;
    let (periods, samples) = (dice.between(10.0, 40.0), dice.whole(2000, 6000));
    let a_period = (samples as f64 / periods).max(60.0);
    let digits = 10f64.powf(2.0 - (period / a_period).log10().floor());
    let step = (period / a_period * digits).round() / digits;
    let split = (0.6 * samples as f64) as usize;
    let grid = |n: usize| (0..n).map(|k| (k as f64 * step * 1e9).round() / 1e9).collect::<Vec<f64>>();
    let first =
        Experiment { start: start(rig, dice), lines: rig.lines.clone(), times: grid(samples), second: false };
    // The end of a release is nothing but noise: another release shows more.
    if rig.drive != Drive::Free && dice.chance(0.5) {
        return (vec![first], split);
    }
    let mut lines = rig.lines.clone();
    match rig.drive {
        // What stands in `known` is the same in both records, but for an amplitude that is a constant of
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

/// The beginning of a experiment.
pub(super) fn cut_experiment(experiment: &Experiment, split: usize) -> Experiment {
    Experiment { times: experiment.times[..split].to_vec(), ..experiment.clone() }
}

/// The beginning of a motion.
pub(super) fn cut_motion(motion: &Motion, split: usize) -> Motion {
    let cut = |columns: &[Vec<f64>]| columns.iter().map(|c| c[..split].to_vec()).collect();
    Motion {
        n: motion.n,
        states: cut(&motion.states),
        rates: cut(&motion.rates),
        stuck: motion.stuck[..split].to_vec(),
        readings: cut(&motion.readings),
    }
}
