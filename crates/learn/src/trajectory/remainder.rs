//! The force that a fit leaves: how large, where, and whether it follows the motion.

use crate::decisions::REMAINDER_STRETCHES;
use crate::result::remainder::Remainder;
use crate::trajectory::analogues::{Remains, of_motion};
use crate::trajectory::filter::Pass;
use crate::trajectory::fit::Fit;
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
    let motion = || {
        let states = fit.problem.system.states.len();
        (0..states).map(|k| pass.along(k).map(|(_, x, _)| x).collect()).collect()
    };
    Remainder {
        record: fit.problem.records[record].name.clone(),
        state,
        rms,
        share: rms / whole,
        of_motion: of_motion(&[Remains { motion: motion(), left: force.to_vec() }]).sqrt() * rms / whole,
        strongest: span,
    }
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}
