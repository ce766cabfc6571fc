//! Grids of values for parameters that a law does not depend on linearly, scaled to the motion.

use super::regression_data::RegressionData;
use super::regressors::{Axis, Regressors, Scale};
use crate::constraint::fulfilled;
use crate::decisions::{
    BESIDE_LINE, GRID_AXIS, GRID_DEFLECTIONS, GRID_FORCES, GRID_GAPS, GRID_LENGTHS, GRID_QUARTERS,
    GRID_SPEEDS, GRID_TIMES, GRID_VALUES, MOST_NUMBER, TOP_QUANTILE,
};
use crate::evaluate::evaluated;
use crate::place::{Effect, Site};
use crate::whiteness::{lines, mean_step};
use phisindy_expr::Tape;
use phisindy_phys::System;

/// The values of a motion that scale the grid, each sorted.
struct Ranges {
    speeds: Vec<f64>,
    displacements: Vec<f64>,
    sizes: Vec<f64>,
    /// Angular frequencies at which the model lacks something (rad/s).
    frequencies: Vec<f64>,
}

/// All combinations of grid values for a law. The last two outputs of `tape` are velocity and displacement of
/// the place.
pub(super) fn grids(
    regressors: &Regressors,
    effect: &Effect,
    system: &System,
    data: &[RegressionData],
    tape: &Tape,
) -> Vec<Vec<f64>> {
    if regressors.grid.is_empty() {
        return vec![vec![]];
    }
    let outputs = tape.outputs();
    let (mut speeds, mut places) = (Vec::new(), Vec::new());
    let mut frequencies: Vec<f64> = Vec::new();
    let oscillates = regressors.grid.iter().any(|axis| axis.scale == Scale::Frequency);
    let memory = !regressors.internal.is_empty();
    for data in data {
        let zero = vec![0.0; data.motion.samples()];
        let series: Vec<&[f64]> = vec![&zero; regressors.internal.len()];
        let values = evaluated(tape, &data.motion, &vec![0.0; regressors.grid.len()], &series);
        speeds.extend(values[outputs - 2].iter().map(|v| v.abs()));
        places.extend(values[outputs - 1].iter().copied());
        if let (true, Site::Force { state: Some(state), .. }) = (oscillates, &effect.place.site) {
            frequencies.extend(missing_tones(data, *state, system.states.len(), &values[0]));
        }
    }
    let sizes = sorted(places.iter().map(|x| x.abs()).collect());
    let ranges = Ranges { speeds: sorted(speeds), displacements: sorted(places), sizes, frequencies };
    let mut all: Vec<Vec<f64>> = vec![vec![]];
    // As many values as the number of combinations allows.
    let free = regressors.grid.iter().filter(|axis| axis.within.0 < axis.within.1).count();
    let each = (GRID_VALUES as f64).powf(1.0 / free.max(1) as f64) as usize;
    for axis in &regressors.grid {
        let values = ranges.axis(axis, each.clamp(2, GRID_AXIS), memory);
        all =
            all.iter().flat_map(|g| values.iter().map(|v| g.iter().copied().chain([*v]).collect())).collect();
        all.truncate(GRID_VALUES);
    }
    // Where the law's own condition does not hold, a start would be moved, and the regression would say
    // nothing of it.
    if memory {
        let law = &effect.entry.law;
        let holds = |grid: &Vec<f64>| {
            let parameters = regressors.parameters(&vec![1.0; regressors.columns.len()], grid);
            parameters.is_none_or(|all| fulfilled(law, &all).is_none_or(|value| value >= 0.0))
        };
        all.retain(holds);
    }
    all
}

/// Frequencies at which the residual of a rate is strong (rad/s). `factor` multiplies the law's oscillation.
fn missing_tones(data: &RegressionData, state: usize, n: usize, factor: &[f64]) -> Vec<f64> {
    let step = mean_step(&data.motion.time);
    let missing: Vec<f64> = (0..data.motion.samples())
        .map(|i| (data.acceleration(i, state, n) - data.rates[i * n + state]) * factor[i])
        .collect();
    let fine = data.resolution();
    // In a periodic motion any missing effect equals a sum of forces at multiples of its frequency, so these
    // are excluded.
    let own = 2.0 * std::f64::consts::PI / data.motion.period;
    let force = factor.iter().all(|v| *v == factor[0]);
    let ambiguous = |w: f64| {
        // At a frequency of the drive a force compensates for anything that is missing; a factor of the
        // motion does not.
        force && data.drive.iter().any(|line| (w - line).abs() < fine)
            || data.motion.periodic && (w / own - (w / own).round()).abs() * own < 2.0 * fine
    };
    // Lines that are strong, or far above the noise of a second derivative.
    let missing = smoothed(&missing, data.motion.period / step);
    let strong = lines(&missing, step, 6, 0);
    let clear = lines(&missing, step, 4, 4);
    let all = strong.into_iter().chain(clear).chain(data.left.iter().copied());
    let near = all.filter(|w| !ambiguous(*w)).flat_map(|line| BESIDE_LINE.map(|d| line + d * fine));
    near.filter(|w| *w > 0.0).collect()
}

impl Ranges {
    /// The grid values of one parameter, `count` of them where its scale does not say how many. `memory`: its
    /// law has internal states.
    fn axis(&self, axis: &Axis, count: usize, memory: bool) -> Vec<f64> {
        let of = |parts: &[f64], top: f64| parts.iter().map(|q| q * top).collect();
        let negative = axis.within.0 < 0.0;
        let (length, speed) = (quantile(&self.sizes, TOP_QUANTILE), quantile(&self.speeds, TOP_QUANTILE));
        match axis.scale {
            Scale::Speed => of(&GRID_SPEEDS, speed),
            Scale::Displacement if memory => of(&GRID_DEFLECTIONS, length),
            Scale::Displacement if negative => (1..20)
                .map(|k| quantile(&self.displacements, f64::from(k) / 20.0))
                .chain([0.98, TOP_QUANTILE].map(|q| quantile(&self.displacements, q)))
                .collect(),
            Scale::Displacement => of(&GRID_GAPS, length),
            Scale::Frequency => self.frequencies.clone(),
            Scale::WaveNumber => {
                let swing = quantile(&self.displacements, TOP_QUANTILE)
                    - quantile(&self.displacements, 1.0 - TOP_QUANTILE);
                let quarter = 0.5 * std::f64::consts::PI / swing;
                (GRID_QUARTERS[0]..GRID_QUARTERS[1])
                    .map(|k| k as f64 * quarter)
                    .filter(|n| n.is_finite())
                    .collect()
            }
            Scale::Number => between(axis.within, count),
            Scale::Power { length: l, time: t } => {
                let [first, last] = match (l == 0.0, t == 0.0) {
                    (true, true) => GRID_FORCES,
                    (true, false) => GRID_TIMES,
                    (false, _) => GRID_LENGTHS,
                };
                let half = if negative { count.div_ceil(2) } else { count };
                let part = match (l == 0.0, t == 0.0) {
                    (true, true) => 1.0,
                    (true, false) => t.abs(),
                    (false, _) => l.abs(),
                };
                let sign = if l < 0.0 { -1.0 } else { 1.0 };
                let unit = length.powf(l) * (length / speed).powf(t);
                let all = geometric(first, last, half).into_iter().map(|q| unit * q.powf(sign * part));
                let all: Vec<f64> = all.filter(|x| x.is_finite()).collect();
                let mirrored = all.iter().filter(|_| negative).map(|x| -x);
                all.iter().copied().chain(mirrored).collect()
            }
            Scale::Any => (-3..=3).map(|k| 10f64.powi(k)).collect(),
        }
    }
}

/// Numbers in a constant ratio from the first to the last.
pub(super) fn geometric(first: f64, last: f64, count: usize) -> Vec<f64> {
    let steps = count.max(2) - 1;
    (0..=steps).map(|k| first * (last / first).powf(k as f64 / steps as f64)).collect()
}

/// Numbers between bounds: in a constant ratio where both are positive, else in equal steps. Far bounds say
/// nothing.
pub(super) fn between((low, high): (f64, f64), count: usize) -> Vec<f64> {
    if low == high {
        return vec![low];
    }
    let (low, high) = (low.max(-MOST_NUMBER), high.min(MOST_NUMBER));
    if low > 0.0 {
        return geometric(low.max(1.0 / MOST_NUMBER), high, count);
    }
    (0..count).map(|k| low + (high - low) * (k as f64 + 0.5) / count as f64).collect()
}

fn quantile(values: &[f64], q: f64) -> f64 {
    values.get(((values.len().max(1) - 1) as f64 * q) as usize).copied().unwrap_or(0.0)
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.retain(|x| x.is_finite());
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// A moving mean over a twentieth of a period. A second derivative above that frequency is noise.
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
