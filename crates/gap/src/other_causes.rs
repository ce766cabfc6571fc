//! Causes of a gap that no force law explains: a tone, a drift, a bent scale, noise of the measured inputs.

use crate::decisions::{
    EXPLAINED, INPUT_NOISE_BLOCK, INPUT_NOISE_DRAWS, INPUT_NOISE_PART, MOST_OF_RESIDUAL, REPEATS,
};
use crate::drive::Drive;
use crate::input_interpolation::moved;
use crate::model::{Fitted, TrialModel};
use crate::result::{Cause, InputNoise, Named};
use crate::sensor_linearity::bent_columns;
use crate::whiteness::{lines, mean_step, share};
use phisindy_learn::{Effort, noisier};
use phisindy_phys::Record;
use phisindy_phys::spec::Role;
use phisindy_signal::noise_level_at;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Causes of the residual other than a force. Drift is looked for in the residual of `base` first, because an
/// effect may distort it.
pub(crate) fn causes(base: &Fitted, last: &Fitted) -> Vec<Cause> {
    let mut told = Vec::new();
    let system = &last.model.system;
    let fitted = |(_, (r, _)): &(usize, (&Record, _))| r.role == Role::Fit;
    let was = |r: usize, name: &str| {
        let column = base.model.system.column(name)?;
        Some(base.cal.records[r].own_residual(column))
    };
    for (r, (record, fit)) in last.model.records.iter().zip(&last.cal.records).enumerate().filter(fitted) {
        let mut drive = Drive::new(system, record);
        for (k, (name, _)) in system.quantities().take(fit.residuals.len()).enumerate() {
            let residual = fit.own_residual(k);
            let own = record.own_column(k).filter(|(_, column)| column.len() == residual.len());
            let Some((time, column)) = own else { continue };
            let of = Named { record: record.name.clone(), column: name.to_owned() };
            // What no force pulls back drifts by itself: its line in time says nothing of a sensor.
            let pulled_back =
                system.state(name).is_none_or(|k| system.graph.uses(&system.known, &[system.states[k].node]));
            let drifts =
                |residual: &[f64]| pulled_back.then(|| drift(&time, residual, &column, &of)).flatten();
            told.extend(was(r, name).and_then(|before| drifts(&before)).or_else(|| drifts(&residual)));
            told.extend(tone(mean_step(&time), &residual, drive.as_mut(), &of));
        }
    }
    told.extend(bent_columns(last));
    told
}

/// Noise of the measured inputs, where it may cause much of the gap. Adding the same amount of noise once
/// more must change the simulation by a comparable amount, on the records on which the gap is measured.
pub(crate) fn input_noise(last: &Fitted, noise: &[Vec<f64>]) -> Option<InputNoise> {
    let left = last.score.gap();
    if left.max(last.score.fit) <= EXPLAINED {
        return None;
    }
    let settled = last.settled();
    // A fit to other inputs moves the runs no more than these inputs do while the numbers stay.
    let moves = |draw: usize| moved(last, &disturbed(&settled, draw)?.0, noise);
    let powers: Vec<f64> = (0..INPUT_NOISE_BLOCK).into_par_iter().filter_map(moves).collect();
    let mean = powers.iter().sum::<f64>() / powers.len() as f64;
    let little = mean <= INPUT_NOISE_PART * (last.score.fit.powi(2) - 1.0);
    if mean == 0.0 || last.judged_by() == Role::Fit && little {
        return None;
    }
    let apart = |draw: usize| {
        let (model, of) = disturbed(&settled, draw)?;
        let noisy = Fitted::new(model, noise, Effort::Thorough).ok()?;
        Some((last.difference(&noisy, last.judged_by(), noise), of))
    };
    // Mean square of the gap that input noise alone leaves, without the measurement noise.
    let mean = |all: &[(f64, Vec<usize>)]| all.iter().map(|(apart, _)| apart).sum::<f64>() / all.len() as f64;
    let excess = left.powi(2) - 1.0;
    let mut all: Vec<(f64, Vec<usize>)> = Vec::new();
    // A few draws tell whether the noise of the inputs matters; where one leaves as much, it may be all there is.
    for block in (0..INPUT_NOISE_DRAWS).collect::<Vec<_>>().chunks(INPUT_NOISE_BLOCK) {
        all.extend(block.par_iter().filter_map(|&draw| apart(draw)).collect::<Vec<_>>());
        let enough = all.iter().any(|(apart, _)| *apart >= excess);
        if all.is_empty() || enough || mean(&all) <= INPUT_NOISE_PART * excess {
            break;
        }
    }
    let inputs: Vec<String> = all.first()?.1.iter().map(|k| settled.system.inputs[*k].name.clone()).collect();
    if inputs.is_empty() {
        return None;
    }
    let made = mean(&all);
    // Stops pass a small noise on as few large differences, so its draws scatter. What one in twenty leaves
    // is no lack of the model (the Monte Carlo test of A. C. A. Hope, J. R. Stat. Soc. B 30 (1968) 582-598).
    let most = all.iter().map(|(apart, _)| *apart).fold(REPEATS.powi(2) * made, f64::max);
    let gap = |power: f64| (1.0 + power).sqrt();
    let much = made > INPUT_NOISE_PART * excess;
    much.then(|| InputNoise { inputs, alone: gap(made), most: gap(most), left })
}

/// A residual that is mostly a straight line in time.
fn drift(time: &[f64], residual: &[f64], column: &[f64], of: &Named) -> Option<Cause> {
    let n = residual.len() as f64;
    let mean = |v: &[f64]| v.iter().sum::<f64>() / n;
    let (middle, level) = (mean(time), mean(residual));
    let (mut tt, mut te, mut ee) = (0.0, 0.0, 0.0);
    for (t, e) in time.iter().zip(residual) {
        tt += (t - middle).powi(2);
        te += (t - middle) * (e - level);
        ee += (e - level).powi(2);
    }
    let part = te * te / (tt * ee);
    let swing = te / tt * (time.last()? - time.first()?);
    (part > MOST_OF_RESIDUAL && swing.abs() > noise_level_at(time, column)).then(|| Cause::Drift {
        of: of.clone(),
        share: part,
        swing,
    })
}

/// A residual that is mostly one tone; its cause need not be a force.
fn tone(step: f64, residual: &[f64], drive: Option<&mut Drive<'_>>, of: &Named) -> Option<Cause> {
    let (frequency, share) = tone_of(step, residual, drive)?;
    Some(Cause::Tone { of: of.clone(), share, frequency })
}

/// The frequency of a tone that is most of a residual (rad/s), and its share; none of the drive.
pub(crate) fn tone_of(step: f64, residual: &[f64], drive: Option<&mut Drive<'_>>) -> Option<(f64, f64)> {
    let line = *lines(residual, step, 1, 0).first()?;
    let part = share(residual, line * step);
    // A period longer than the record is no tone. A response at a frequency of the drive is a lack of the
    // model.
    let span = step * residual.len() as f64;
    if part <= MOST_OF_RESIDUAL || line * span < TAU {
        return None;
    }
    // A nonlinear rig answers at the multiples of its drive, too.
    let driven = drive.is_some_and(|d| {
        d.lines().iter().any(|own| (own - line).abs() * span < TAU) || d.multiple_at(line).is_some()
    });
    (!driven).then_some((line, part))
}

/// A model with the noise of the measured inputs of its records doubled in power, and the indices of those
/// inputs.
fn disturbed(model: &TrialModel, draw: usize) -> Option<(TrialModel, Vec<usize>)> {
    let (mut out, mut all) = (model.clone(), Vec::new());
    let records = Arc::make_mut(&mut out.records).iter_mut().zip(&model.given.plans);
    for (record, plan) in records {
        let (noisy, of) = noisier(record, &plan.differentiators, draw)?;
        *record = noisy;
        all.extend(of);
    }
    all.sort_unstable();
    all.dedup();
    Some((out, all))
}
