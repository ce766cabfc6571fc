//! What may be behind a gap that no law of a force explains: a tone, a drift, noise of the measured inputs.

use crate::drive::Drive;
use crate::fitted::Fitted;
use crate::whiteness::{lines, share};
use phisindy_learn::Effort;
use phisindy_phys::spec::Role;
use phisindy_phys::{Interpolation, Record, Signal, noise_level, standard_deviation};
use phisindy_sim::{Noise, Streams, add_noise};
use std::f64::consts::TAU;

/// A tone, or a drift, that holds at least this part of what is left of a column is told.
const MOST: f64 = 0.5;
/// Noise of inputs that accounts for this part of a gap is told.
const PART: f64 = 0.25;
/// An input that changes from sample to sample by more than this part of its size does so because that is what it is.
const ROUGH: f64 = 0.2;

/// What else than a force may be behind what is left, in words with what to do.
pub(crate) fn causes(last: &Fitted, noise: &[Vec<f64>]) -> Vec<String> {
    let mut told = Vec::new();
    let system = &last.draft.case.system;
    let fitted = |(r, _): &(&Record, _)| r.role == Role::Fit;
    for (record, fit) in last.draft.records.iter().zip(&last.cal.records).filter(fitted) {
        let mut drive = Drive::new(system, record);
        for ((state, residual), column) in system.states.iter().zip(&fit.residuals).zip(&record.columns) {
            let Some(column) = column.as_ref().filter(|c| c.len() == residual.len()) else { continue };
            let of = format!("of what is left of {} in {}", state.name, record.name);
            told.extend(drift(&record.time, residual, column, &state.name, &of));
            told.extend(tone(record, residual, drive.as_mut(), &of));
        }
    }
    told.extend(noise_of_inputs(last, noise));
    told
}

/// A residual that is a straight line in time above all.
fn drift(time: &[f64], residual: &[f64], column: &[f64], name: &str, of: &str) -> Option<String> {
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
    (part > MOST && swing.abs() > noise_level(column)).then(|| {
        format!(
            "{:.0} % {of} grows with time, by {swing:.3e} (SI) from end to end: drift of a sensor, perhaps as it warms up; `detrend: {{ \"{name}\": Linear }}` takes it off",
            100.0 * part
        )
    })
}

/// A residual that is one tone above all, for no law of a force has to be behind it.
fn tone(record: &Record, residual: &[f64], drive: Option<&mut Drive<'_>>, of: &str) -> Option<String> {
    let step = step(record);
    let line = *lines(residual, step, 1, 0).first()?;
    let part = share(residual, line * step);
    // What is slower than the record is no tone, and what answers the drive is what the model lacks.
    let span = step * residual.len() as f64;
    if part <= MOST || line * span < TAU {
        return None;
    }
    let driven = drive.is_some_and(|d| d.lines().iter().any(|own| (own - line).abs() * span < TAU));
    (!driven).then(|| {
        format!(
            "{:.0} % {of} is one tone of {line:.4} rad/s ({:.4} Hz): hum of the sensor or the mains, a drive that the model does not know, or the rig's own frequency where it is another one than the model's",
            100.0 * part,
            line / TAU
        )
    })
}

/// What the noise of the measured inputs does to the model: the same inputs with as much noise once more leave more.
fn noise_of_inputs(last: &Fitted, noise: &[Vec<f64>]) -> Option<String> {
    let system = &last.draft.case.system;
    let mut draft = last.settled().ok()?;
    let mut names: Vec<&str> = Vec::new();
    for record in draft.records.iter_mut().filter(|r| r.role == Role::Fit) {
        for (input, of) in record.inputs.iter_mut().zip(&system.inputs) {
            let sigma = noise_level(input.values());
            let measured = input.kind() != Interpolation::Hold && sigma > 0.0;
            if !measured || sigma > ROUGH * standard_deviation(input.values()) {
                continue;
            }
            let mut values = input.values().to_vec();
            let mut stream = Streams(1).stream(&format!("noise of {} in {}", of.name, record.name));
            add_noise(&mut values, Noise::Sensor(sigma), &mut stream);
            *input = Signal::new(input.time().clone(), values, input.kind()).ok()?;
            if !names.contains(&of.name.as_str()) {
                names.push(&of.name);
            }
        }
    }
    if names.is_empty() {
        return None;
    }
    let twice = Fitted::new(draft, noise, Effort::Thorough).ok()?;
    let made = twice.fit.powi(2) - last.fit.powi(2);
    (made > PART * (last.fit.powi(2) - 1.0)).then(|| {
        format!(
            "what changes in {} from sample to sample, as noise does, moves the model and not the rig: it alone leaves a gap of about {:.3} on the fitted data, of the {:.3} that are left; measure the input with less noise, smooth it, or say in the spec what was commanded",
            names.join(" and "),
            (1.0 + made).sqrt(),
            last.fit
        )
    })
}

/// The mean step of time.
fn step(record: &Record) -> f64 {
    (record.time[record.len() - 1] - record.time[0]) / (record.len() - 1) as f64
}
