//! Whether the first record tells the parameters of hidden effects at all: the Cramer-Rao bound.
//!
//! The motion is simulated again with each parameter, and each start state, a little off. The changes of the
//! readings in units of the noise are the rows of the Fisher information (S. M. Kay 1993, Fundamentals of
//! Statistical Signal Processing: Estimation Theory, section 3.9).

use super::effect::Effect;
use super::experiment::first_part;
use super::motion::{Experiment, motion};
use super::rig::Rig;
use faer::Mat;
use faer::linalg::solvers::Solve;

/// A parameter is moved by this part of itself, a start state by this part of the largest reading.
const STEP: f64 = 1e-4;
/// No standard deviation of a parameter may be a larger part of it.
const MOST: f64 = 0.1;

/// Whether no parameter of a law with memory is more uncertain than `MOST` of itself. `columns`: indices of
/// what is measured, and the noise of each.
pub(super) fn determined(
    rig: &Rig,
    effects: &[Effect],
    experiment: &Experiment,
    split: usize,
    columns: &[(usize, f64)],
) -> bool {
    let experiment = first_part(experiment, split);
    let readings = |effects: &[Effect], experiment: &Experiment| -> Option<Vec<f64>> {
        let motion = motion(rig, effects, experiment, 0.0).ok()?;
        let of = |&(k, noise): &(usize, f64)| motion.reading(k, rig.count()).iter().map(move |y| y / noise);
        Some(columns.iter().flat_map(of).collect())
    };
    let Some(now) = readings(effects, &experiment) else { return false };
    // What the readings change with each, per part of it.
    let change = |effects: &[Effect], experiment: &Experiment| -> Option<Vec<f64>> {
        Some(readings(effects, experiment)?.iter().zip(&now).map(|(a, b)| (a - b) / STEP).collect())
    };
    let mut rows: Vec<Option<Vec<f64>>> = Vec::new();
    for (e, effect) in effects.iter().enumerate() {
        for k in 0..effect.parameters.len() {
            let mut off = effects.to_vec();
            off[e].parameters[k].1 *= 1.0 + STEP;
            rows.push(change(&off, &experiment));
        }
    }
    let wanted = rows.len();
    for k in 0..experiment.start.len() {
        let mut off = experiment.clone();
        off.start[k] += STEP * if k < rig.count() { rig.size } else { rig.size * rig.natural };
        rows.push(change(effects, &off));
    }
    let Some(rows) = rows.into_iter().collect::<Option<Vec<_>>>() else { return false };
    let n = rows.len();
    let information =
        Mat::from_fn(n, n, |i, j| rows[i].iter().zip(&rows[j]).map(|(a, b)| a * b).sum::<f64>());
    // Unit scale: a parameter that does nothing has no scale.
    let scale: Vec<f64> = (0..n).map(|i| information[(i, i)].sqrt()).collect();
    if scale.iter().any(|s| *s <= 0.0 || !s.is_finite()) {
        return false;
    }
    let scaled = Mat::from_fn(n, n, |i, j| information[(i, j)] / (scale[i] * scale[j]));
    let Ok(llt) = scaled.llt(faer::Side::Lower) else { return false };
    let inverse = llt.solve(&Mat::<f64>::identity(n, n));
    (0..wanted).all(|i| inverse[(i, i)].sqrt() / scale[i] < MOST)
}
