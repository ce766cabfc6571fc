//! Hum: a tone in a sensor. A force of the same frequency moves the rig, and all columns follow it; hum has an amplitude and
//! a phase of its own in each column.

use crate::drive::Drive;
use crate::evidence::frequency;
use crate::model::{Fitted, measured};
use crate::other_causes::tone_of;
use crate::screen::dot;
use crate::whiteness::mean_step;
use phisindy_learn::{Effort, RecordFit};
use phisindy_phys::Record;
use phisindy_phys::spec::Role;
use std::sync::Arc;

/// Evidence (BIC) that the forces of time which `with` has and `without` lacks are hum; `None` where none of them is a tone.
pub(crate) fn evidence_of_hum(without: &Fitted, with: &Fitted, noise: &[Vec<f64>]) -> Option<f64> {
    let of_time = with.model.effects.iter().filter(|a| a.effect.entry.law.is_of_time());
    let tones: Vec<f64> = of_time.filter_map(|a| frequency(with, &a.effect)).collect();
    if tones.is_empty() {
        return None;
    }
    let (hum, force) =
        (left(&free_of_tones(without, &tones, noise)?, &tones, noise)?, left(with, &[], noise)?);
    // Each tone has an amplitude and a phase in each column; a force has one amplitude, and a phase in each record.
    let records = with.model.fit_records();
    let more = tones.len() as f64 * (2.0 * hum.columns as f64 - 1.0 - records as f64);
    let samples = hum.samples as f64;
    Some(samples * (force.power / hum.power).ln() - more * samples.ln())
}

/// The model fitted again to columns without these tones. Hum bends the numbers of a fit.
fn free_of_tones(of: &Fitted, tones: &[f64], noise: &[Vec<f64>]) -> Option<Fitted> {
    let mut model = of.settled();
    for (record, fit) in Arc::make_mut(&mut model.records).iter_mut().zip(&of.cal.records) {
        let columns: Vec<usize> =
            (0..record.columns.len()).filter(|&k| record.columns[k].is_some()).collect();
        for (k, residual) in columns.into_iter().zip(measured(fit)) {
            let time = record.own_times.of(k, &record.time);
            let mut rest = residual.to_vec();
            set_aside_tones(&mut rest, &time, tones);
            let column = record.columns[k].as_mut().filter(|c| c.len() == rest.len())?;
            column.iter_mut().zip(residual.iter().zip(&rest)).for_each(|(y, (e, rest))| *y -= e - rest);
        }
    }
    Fitted::new(model, noise, Effort::Plain).ok()
}

/// For each column of a Fit record that leaves mostly one tone, the cosine and the sine of this tone, by record and column.
pub(crate) fn waves_of_tones(of: &Fitted) -> Vec<Vec<Vec<Vec<f64>>>> {
    let records = of.model.records.iter().zip(&of.cal.records).filter(|(r, _)| r.role == Role::Fit);
    let fits: Vec<(&Record, &RecordFit)> = records.collect();
    let nothing = |r: &Record| -> Vec<Vec<f64>> {
        r.columns.iter().map(|c| c.as_ref().map_or(vec![], |_| vec![0.0; r.len()])).collect()
    };
    let mut all = vec![];
    for (r, (record, fit)) in fits.iter().enumerate() {
        let mut drive = Drive::new(&of.model.system, record);
        for k in (0..fit.residuals.len()).filter(|&k| !fit.residuals[k].is_empty()) {
            let Some((time, _)) = record.own_column(k) else { continue };
            let tone = tone_of(mean_step(&time), &fit.own_residual(k), drive.as_mut());
            let Some((frequency, _)) = tone else { continue };
            for part in [f64::cos, f64::sin] {
                let mut wave: Vec<Vec<Vec<f64>>> = fits.iter().map(|(record, _)| nothing(record)).collect();
                wave[r][k] = record.time.iter().map(|t| part(frequency * t)).collect();
                all.push(wave);
            }
        }
    }
    all
}

/// What is left of the columns of the Fit records.
struct Left {
    /// Sum of (residual / noise)^2.
    power: f64,
    samples: usize,
    columns: usize,
}

/// What is left once each column has tones of these frequencies of its own; `None` where a run fails.
fn left(of: &Fitted, tones: &[f64], noise: &[Vec<f64>]) -> Option<Left> {
    let mut all = Left { power: 0.0, samples: 0, columns: 0 };
    for (r, record) in of.model.records.iter().enumerate().filter(|(_, record)| record.role == Role::Fit) {
        of.cal.records[r].run.as_ref()?;
        let columns = (0..record.columns.len()).filter(|&k| record.columns[k].is_some());
        for ((k, residual), noise) in columns.zip(measured(&of.cal.records[r])).zip(&noise[r]) {
            let time = record.own_times.of(k, &record.time);
            let mut rest: Vec<f64> = residual.iter().map(|e| e / noise).collect();
            set_aside_tones(&mut rest, &time, tones);
            all.power += dot(&rest, &rest);
            all.samples += rest.len();
            all.columns += 1;
        }
    }
    (all.power > 0.0).then_some(all)
}

/// Takes tones of these frequencies out of a column, each with the amplitude and phase that leave least.
fn set_aside_tones(column: &mut [f64], time: &[f64], tones: &[f64]) {
    let mut basis: Vec<Vec<f64>> = vec![];
    for tone in tones {
        for part in [f64::cos, f64::sin] {
            let mut wave: Vec<f64> = time.iter().map(|t| part(tone * t)).collect();
            basis.iter().for_each(|own| set_aside(&mut wave, own));
            set_aside(column, &wave);
            basis.push(wave);
        }
    }
}

/// Takes out of `values` what they have in common with `wave`.
fn set_aside(values: &mut [f64], wave: &[f64]) {
    let square = dot(wave, wave);
    if square > 0.0 {
        let part = dot(values, wave) / square;
        values.iter_mut().zip(wave).for_each(|(v, w)| *v -= part * w);
    }
}
