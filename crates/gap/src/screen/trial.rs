//! The columns of a law at a place: what it would do to the measured motion, for each of the numbers that it does not depend on linearly.

use super::regression_data::RegressionData;
use crate::decisions::GRID_VALUES;
use crate::evaluate::evaluated;

use super::regressors::{Regressors, Scale};
use crate::motion::Motion;
use crate::place::{Effect, Place, Site};
use crate::whiteness::{lines, mean_step};
use phisindy_expr::{Scratch, Tape};
use phisindy_phys::System;

/// What one evaluation of an effect gives: the columns of a trial, by record.
pub(super) struct Trial {
    pub(super) regressors: usize,
    pub(super) effect: Effect,
    pub(super) grid: Vec<f64>,
    /// Responses as rows, for each column.
    pub(super) columns: Vec<Vec<f64>>,
}

/// Offset, gain or delay of the sensors of some states.
pub(super) fn sensor_trials(
    regressors: usize,
    effect: &Effect,
    states: &[usize],
    data: &[RegressionData],
) -> Vec<Trial> {
    let which = match effect.entry.law.sensor.as_deref() {
        Some("offset") => 0,
        Some("gain") => 1,
        _ => 2,
    };
    let column = data.iter().flat_map(|g| g.sensor(states, which)).collect();
    vec![Trial { regressors, effect: effect.clone(), grid: vec![], columns: vec![column] }]
}

/// A force law over its grid.
pub(super) fn force_trials(
    index: usize,
    effect: &Effect,
    regressors: &Regressors,
    system: &System,
    data: &[RegressionData],
) -> Vec<Trial> {
    let Site::Force { acts, .. } = &effect.place.site else { return vec![] };
    let n = system.states.len();
    let law = &effect.entry.law;
    let mut graph = regressors.graph.clone();
    let one = graph.constant(1.0);
    let mut outputs = Vec::new();
    for &column in &regressors.columns {
        for &(state, sign) in acts {
            let over = graph.div(column, system.inertia[state].unwrap_or(one));
            outputs.push(if sign < 0.0 { graph.neg(over) } else { over });
        }
    }
    // What a unit of friction does, to hold a body at rest.
    for &(state, sign) in acts {
        let over = graph.div(one, system.inertia[state].unwrap_or(one));
        outputs.push(if sign < 0.0 { graph.neg(over) } else { over });
    }
    outputs.push(regressors.velocity);
    outputs.push(regressors.displacement.unwrap_or(regressors.velocity));
    let mut all = system.arguments();
    all.extend(&regressors.symbols);
    let internal = regressors.internal.map(|(z, rate)| (z, rate, graph.gradient(rate, &[z])[0]));
    all.extend(internal.iter().map(|(z, ..)| *z));
    let Ok(tape) = Tape::compile(&graph, &all, &outputs) else { return vec![] };
    let inner = internal.and_then(|(_, rate, slope)| Tape::compile(&graph, &all, &[rate, slope]).ok());
    let count = regressors.columns.len();
    let width = acts.len();
    let sticks = law.sticks();
    let mut trials = Vec::new();
    for grid in grids(regressors, effect, system, data, &tape, inner.is_some()) {
        let mut columns: Vec<Vec<f64>> = vec![vec![]; count];
        let mut holding: Vec<f64> = vec![];
        let mut held = false;
        for data in data {
            let samples = data.motion.samples();
            let z = inner.as_ref().map(|tape| remembered(tape, &data.motion, &grid));
            let values =
                evaluated(&tape, &data.motion, &grid, &z.iter().map(Vec::as_slice).collect::<Vec<_>>());
            let still = data.still.iter().find(|s| s.at == effect.place.at);
            let rests = |i: usize| sticks && still.is_some_and(|s| s.rests[i]);
            for (c, column) in columns.iter_mut().enumerate() {
                let mut g = vec![0.0; samples * n];
                for (j, &(state, _)) in acts.iter().enumerate() {
                    let force = &values[c * width + j];
                    (0..samples)
                        .filter(|&i| !rests(i))
                        .for_each(|i| g[i * n + state] = if force[i].is_finite() { force[i] } else { 0.0 });
                }
                data.quiet(&mut g);
                column.extend(data.read(&data.linear.response(&g, &vec![0.0; n]), false));
            }
            // At rest the missing friction is what the other forces need to be held.
            if sticks {
                let mut g = vec![0.0; samples * n];
                for i in (0..samples).filter(|&i| rests(i)) {
                    held = true;
                    let (mut toward, mut give) = (0.0, 0.0);
                    for (j, &(state, _)) in acts.iter().enumerate() {
                        let c = if j == 0 { 1.0 } else { -1.0 };
                        toward += c * data.rates[i * n + state];
                        give += c * values[count * width + j][i];
                    }
                    toward -= base_slope(system, &effect.place, data, i);
                    for (j, &(state, _)) in acts.iter().enumerate() {
                        g[i * n + state] = -toward / give * values[count * width + j][i];
                    }
                }
                holding.extend(data.read(&data.linear.response(&g, &vec![0.0; n]), false));
            }
        }
        if held {
            columns.push(holding);
        }
        let trial = Trial { regressors: index, effect: effect.clone(), grid, columns };
        trials.push(trial);
    }
    trials
}

/// The acceleration of an input against which a body rests.
fn base_slope(system: &System, place: &Place, data: &RegressionData, i: usize) -> f64 {
    let Some((_, second)) = place.at.split_once('-') else { return 0.0 };
    let m = data.motion.inputs.len() / data.motion.samples();
    system.input(second).map_or(0.0, |u| data.motion.slopes[i * m + u])
}

/// An internal state along a motion, by exponential steps: exact where its rate is linear in it.
fn remembered(tape: &Tape, motion: &Motion, grid: &[f64]) -> Vec<f64> {
    let samples = motion.samples();
    let (n, m) = (motion.states.len() / samples, motion.inputs.len() / samples);
    let mut scratch = Scratch::<1>::new(tape);
    let after = 1 + n + m;
    for (k, v) in motion.numbers.iter().chain(grid).enumerate() {
        scratch.input(after + k)[0] = *v;
    }
    let last = after + motion.numbers.len() + grid.len();
    let mut z = vec![0.0; samples];
    for i in 0..samples - 1 {
        scratch.input(0)[0] = motion.time[i];
        // In the middle of the step.
        let middle = |v: &[f64], w: usize, k: usize| 0.5 * (v[i * w + k] + v[(i + 1) * w + k]);
        (0..n).for_each(|k| scratch.input(1 + k)[0] = middle(&motion.states, n, k));
        (0..m).for_each(|k| scratch.input(1 + n + k)[0] = middle(&motion.inputs, m, k));
        scratch.input(last)[0] = z[i];
        scratch.run();
        let (rate, slope) = (scratch.output(0)[0], scratch.output(1)[0]);
        let h = motion.time[i + 1] - motion.time[i];
        let decay = slope * h;
        let factor = if decay.abs() < 1e-8 { h } else { decay.exp_m1() / slope };
        let next = z[i] + rate * factor;
        z[i + 1] = if next.is_finite() { next } else { 0.0 };
    }
    z
}

/// The numbers of the grid that suit the motion.
fn grids(
    regressors: &Regressors,
    effect: &Effect,
    system: &System,
    data: &[RegressionData],
    tape: &Tape,
    memory: bool,
) -> Vec<Vec<f64>> {
    if regressors.grid.is_empty() {
        return vec![vec![]];
    }
    let outputs = tape.outputs();
    let n = system.states.len();
    let (mut speeds, mut places) = (Vec::new(), Vec::new());
    let mut frequencies: Vec<f64> = Vec::new();
    for data in data {
        let samples = data.motion.samples();
        let zero = vec![0.0; samples];
        let series: Vec<&[f64]> = if memory { vec![&zero] } else { vec![] };
        let values = evaluated(tape, &data.motion, &vec![0.0; regressors.grid.len()], &series);
        speeds.extend(values[outputs - 2].iter().map(|v| v.abs()));
        places.extend(values[outputs - 1].iter().copied());
        if regressors.grid.iter().any(|(s, _)| *s == Scale::Frequency) {
            let Site::Force { state, .. } = &effect.place.site else { continue };
            let step = mean_step(&data.motion.time);
            // The missing rate, times what the law multiplies its oscillation with.
            let lack: Vec<f64> = (0..samples)
                .map(|i| (data.slope(i, *state, n) - data.rates[i * n + state]) * values[0][i])
                .collect();
            let fine = data.resolution();
            // In a motion of one period every periodic lack can be written as forces at its multiples: they would explain anything.
            let own = 2.0 * std::f64::consts::PI / data.motion.period;
            let force = values[0].iter().all(|v| *v == values[0][0]);
            let echo = |w: f64| {
                // At a frequency of the drive a force stands for anything that is missing; what multiplies the motion does not.
                force && data.drive.iter().any(|line| (w - line).abs() < fine)
                    || data.motion.periodic && (w / own - (w / own).round()).abs() * own < 2.0 * fine
            };
            // Strong as a force, or far above the noise of a second derivative.
            let lack = smoothed(&lack, data.motion.period / step);
            let strong = lines(&lack, step, 6, 0);
            let clear = lines(&lack, step, 4, 4);
            for line in strong.into_iter().chain(clear).chain(data.left.iter().copied()) {
                if !echo(line) {
                    let near = [-0.5, -0.25, 0.0, 0.25, 0.5].map(|d| line + d * fine);
                    frequencies.extend(near.into_iter().filter(|w| *w > 0.0));
                }
            }
        }
    }
    let sorted = |mut v: Vec<f64>| -> Vec<f64> {
        v.retain(|x| x.is_finite());
        v.sort_unstable_by(f64::total_cmp);
        v
    };
    let speeds = sorted(speeds);
    let signed = sorted(places.clone());
    let sizes = sorted(places.iter().map(|x| x.abs()).collect());
    let quantile =
        |v: &[f64], q: f64| v.get(((v.len().max(1) - 1) as f64 * q) as usize).copied().unwrap_or(0.0);
    let axis = |(scale, negative): &(Scale, bool)| -> Vec<f64> {
        match scale {
            Scale::Speed => {
                let top = quantile(&speeds, 0.99);
                [0.01, 0.02, 0.04, 0.07, 0.12, 0.2, 0.3, 0.45, 0.7].iter().map(|q| q * top).collect()
            }
            Scale::Displacement if memory => {
                let top = quantile(&sizes, 0.99);
                [0.001, 0.003, 0.01, 0.02, 0.04, 0.08, 0.15, 0.3, 0.6].iter().map(|q| q * top).collect()
            }
            Scale::Displacement if *negative => (1..20)
                .map(|k| quantile(&signed, f64::from(k) / 20.0))
                .chain([0.98, 0.99].map(|q| quantile(&signed, q)))
                .collect(),
            Scale::Displacement => [0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95]
                .iter()
                .map(|q| quantile(&sizes, 0.99) * q)
                .collect(),
            Scale::Frequency => frequencies.clone(),
            Scale::Any => (-3..=3).map(|k| 10f64.powi(k)).collect(),
        }
    };
    let mut all: Vec<Vec<f64>> = vec![vec![]];
    for of in &regressors.grid {
        let values = axis(of);
        all =
            all.iter().flat_map(|g| values.iter().map(|v| g.iter().copied().chain([*v]).collect())).collect();
        all.truncate(GRID_VALUES);
    }
    all
}

/// A moving mean over a twentieth of a period: what is left of a second derivative above the motion is noise.
fn smoothed(values: &[f64], period: f64) -> Vec<f64> {
    let half = ((period / 40.0) as usize).clamp(1, values.len() / 4 + 1);
    let mut sums = vec![0.0; values.len() + 1];
    values.iter().enumerate().for_each(|(i, v)| sums[i + 1] = sums[i] + v);
    (0..values.len())
        .map(|i| {
            let (a, b) = (i.saturating_sub(half), (i + half + 1).min(values.len()));
            (sums[b] - sums[a]) / (b - a) as f64
        })
        .collect()
}
