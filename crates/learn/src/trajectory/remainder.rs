//! The force that a fit leaves: how large, where, and whether it follows the motion.

use crate::decisions::REMAINDER_STRETCHES;
use crate::linear::{solve_damped, symmetric};
use crate::result::remainder::Remainder;
use crate::trajectory::filter::Pass;
use crate::trajectory::fit::Fit;
use phisindy_signal::{effective_samples, standard_deviation};
use rayon::prelude::*;

/// The forces that are left on the states of each fitted record; none where free runs leave noise alone.
pub(crate) fn remainders(fit: &Fit<'_>) -> Vec<Remainder> {
    let Some(force) = &fit.force else { return vec![] };
    let of_record = |r: usize| -> Vec<Remainder> {
        let intensities = &force.intensities[r];
        let pass = fit.problem.filtered(r, &fit.x, &fit.noise, (&force.groups, intensities));
        let Some((pass, _)) = pass else { return vec![] };
        let smoothed = pass.smoothed_forces(&force.groups, intensities);
        let driven = force.groups.iter().flatten().map(|(state, _)| *state);
        driven.map(|state| of_state(fit, r, &pass, state, &smoothed[state])).collect()
    };
    (0..fit.problem.records.len()).into_par_iter().flat_map_iter(of_record).collect()
}

fn of_state(fit: &Fit<'_>, record: usize, pass: &Pass, state: usize, force: &[f64]) -> Remainder {
    let times: Vec<f64> = pass.along(state).map(|(t, ..)| t).collect();
    let rates: Vec<f64> = pass.along(state).map(|(_, _, rate)| rate).collect();
    let (rms, whole) = (root_mean_square(force), root_mean_square(&rates).max(f64::MIN_POSITIVE));
    let length = (force.len() / REMAINDER_STRETCHES).max(1);
    let stretches = force.chunks(length).enumerate();
    let strongest = stretches.max_by(|a, b| root_mean_square(a.1).total_cmp(&root_mean_square(b.1)));
    let span = strongest.map_or((0.0, 0.0), |(k, of)| (times[k * length], times[k * length + of.len() - 1]));
    Remainder {
        record: fit.problem.records[record].name.clone(),
        state,
        rms,
        share: rms / whole,
        of_motion: of_motion(fit, pass, force) * rms / whole,
        strongest: span,
        course: times.into_iter().zip(force.iter().copied()).collect(),
    }
}

/// The part of a force that is a function of the motion: the root of the explained variance of a regression on
/// the states, their signs and their products, less what chance explains of as many independent samples.
fn of_motion(fit: &Fit<'_>, pass: &Pass, force: &[f64]) -> f64 {
    let states = &fit.problem.system.states;
    let columns: Vec<Vec<f64>> = (0..states.len())
        .map(|k| standardised(&pass.along(k).map(|(_, x, _)| x).collect::<Vec<f64>>()))
        .collect();
    let mut features: Vec<Vec<f64>> = vec![vec![1.0; force.len()]];
    features.extend(columns.iter().cloned());
    let moves = |k: usize| states.iter().any(|s| s.velocity == Some(k));
    let signs = (0..states.len()).filter(|&k| moves(k));
    features.extend(signs.map(|k| pass.along(k).map(|(_, v, _)| v.signum()).collect()));
    for (k, a) in columns.iter().enumerate() {
        features.extend(columns[k..].iter().map(|b| a.iter().zip(b).map(|(a, b)| a * b).collect()));
    }
    let p = features.len();
    let independent = effective_samples(force);
    if independent <= p as f64 + 2.0 {
        return 0.0;
    }
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let triangle: Vec<f64> = (0..p)
        .flat_map(|i| (i..p).map(move |j| (i, j)))
        .map(|(i, j)| dot(&features[i], &features[j]))
        .collect();
    let right: Vec<f64> = features.iter().map(|f| dot(f, force)).collect();
    let Some(found) = solve_damped(&symmetric(&triangle, p), &right, f64::EPSILON.sqrt()) else { return 0.0 };
    let left: Vec<f64> = (0..force.len())
        .map(|i| force[i] - found.iter().zip(&features).map(|(c, f)| c * f[i]).sum::<f64>())
        .collect();
    let mean = force.iter().sum::<f64>() / force.len() as f64;
    let whole: f64 = force.iter().map(|f| (f - mean).powi(2)).sum();
    let unexplained = dot(&left, &left) / whole.max(f64::MIN_POSITIVE);
    (1.0 - unexplained * (independent - 1.0) / (independent - p as f64)).max(0.0).sqrt()
}

fn standardised(column: &[f64]) -> Vec<f64> {
    let mean = column.iter().sum::<f64>() / column.len().max(1) as f64;
    let deviation = standard_deviation(column).max(f64::MIN_POSITIVE);
    column.iter().map(|x| (x - mean) / deviation).collect()
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
