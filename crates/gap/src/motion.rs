//! The smoothed measured motion of a record, on which laws are evaluated. It serves to rank laws, never to
//! estimate parameters.

use crate::decisions::{REST_NOISE, REST_PART};
use crate::repeat::repeatability;
use crate::whiteness::{lines, mean_step};
use phisindy_learn::Calibration;
use phisindy_phys::{Record, SensorPart, System};
use phisindy_signal::{Interpolation, noise_level};

/// The motion of one record.
pub(crate) struct Motion {
    /// Times (s).
    pub(crate) time: Vec<f64>,
    /// Smoothed states, samples x n, with the sensors' offsets and gains removed.
    pub(crate) states: Vec<f64>,
    /// Inputs at the samples, samples x inputs, and their slopes; of held ones the mean slope around a sample.
    pub(crate) inputs: Vec<f64>,
    pub(crate) slopes: Vec<f64>,
    /// The system's parameters, then the record's constants.
    pub(crate) numbers: Vec<f64>,
    /// Gain and offset of each column's sensor.
    pub(crate) sensors: Vec<(f64, f64)>,
    /// Since when the clocks of the sensors drift (s).
    pub(crate) since: f64,
    /// Period of the motion (s).
    pub(crate) period: f64,
    /// Whether it repeats from period to period.
    pub(crate) periodic: bool,
}

impl Motion {
    /// The motion of a record in a fitted system.
    pub(crate) fn new(
        system: &System,
        record: &Record,
        smooth: &Record,
        index: usize,
        fitted: &Calibration,
    ) -> Motion {
        let n = system.states.len();
        let mut numbers: Vec<f64> = system.parameters.iter().map(|p| p.start).collect();
        let mut sensors: Vec<(f64, f64)> =
            record.sensors[..system.columns()].iter().map(|s| (s.gain.start, s.offset.start)).collect();
        for p in &fitted.parameters {
            if !p.id.holds_in(index) {
                continue;
            }
            if let Some(k) = p.id.constant() {
                numbers[k] = p.estimate.value;
                for (sensor, own) in sensors.iter_mut().zip(&record.sensors) {
                    if own.gain.shared == Some(k) {
                        sensor.0 = p.estimate.value;
                    }
                    if own.offset.shared == Some(k) {
                        sensor.1 = p.estimate.value;
                    }
                }
            } else if let Some((column, part)) = p.id.sensor()
                && let Some(sensor) = sensors.get_mut(column)
            {
                match part {
                    SensorPart::Gain => sensor.0 = p.estimate.value,
                    SensorPart::Offset => sensor.1 = p.estimate.value,
                    SensorPart::Delay | SensorPart::Clock | SensorPart::Lag => {}
                }
            }
        }
        numbers.extend(&record.constants);
        let samples = record.len();
        let mut states = vec![0.0; samples * n];
        let run = fitted.records.get(index).and_then(|r| r.run.as_ref());
        // Outputs tell the states of the rig; a simulation tells those of the model.
        let told = |k: usize| record.sizes.get(k).is_some_and(|size| *size > 0.0);
        for k in 0..n {
            let (gain, offset) = sensors[k];
            // The smoothed columns are states as far as their sensors were known.
            let (zero, scale) = smooth.sensors[k].known_before();
            for i in 0..samples {
                states[i * n + k] = match (&smooth.columns[k], run) {
                    // An unmeasured state comes from the simulation.
                    (Some(_), Some(run)) if unmeasured(system, record, k) && !told(k) => {
                        run.states[i * run.n + k]
                    }
                    (Some(c), _) if unmeasured(system, record, k) => c[i],
                    (Some(c), _) if record.columns[k].is_some() => (zero + scale * c[i] - offset) / gain,
                    (Some(c), _) => c[i],
                    (None, Some(run)) => run.states[i * run.n + k],
                    (None, None) => 0.0,
                };
            }
        }
        let m = record.inputs.len();
        let (mut inputs, mut slopes) = (vec![0.0; samples * m], vec![0.0; samples * m]);
        let step = (record.time[samples - 1] - record.time[0]) / (samples - 1).max(1) as f64;
        for (k, signal) in record.inputs.iter().enumerate() {
            let mut hint = 0;
            for (i, &t) in record.time.iter().enumerate() {
                (inputs[i * m + k], slopes[i * m + k]) = signal.value_and_slope(t, &mut hint);
                if signal.kind() == Interpolation::Hold {
                    // Its steps count in the interval around a sample.
                    slopes[i * m + k] = (signal.value(t + 0.5 * step) - signal.value(t - 0.5 * step)) / step;
                }
            }
        }
        let measured = (0..record.columns.len()).find_map(|k| record.own_column(k));
        let strongest = measured.as_ref().and_then(|(t, x)| lines(x, mean_step(t), 1, 0).first().copied());
        let period = strongest.map_or(step * samples as f64, |w| 2.0 * std::f64::consts::PI / w);
        let repeat = measured.and_then(|(time, column)| repeatability(&time, &column));
        let (period, periodic) = repeat.map_or((period, false), |r| (r.period, true));
        let (time, since) = (record.time.to_vec(), record.sensors.first().map_or(0.0, |s| s.since));
        Motion { time, states, inputs, slopes, numbers, sensors, since, period, periodic }
    }

    pub(crate) fn samples(&self) -> usize {
        self.time.len()
    }
}

/// Whether a state has no column and is not the velocity of one that has.
fn unmeasured(system: &System, record: &Record, k: usize) -> bool {
    let source = |x: &usize| system.states[*x].velocity == Some(k) && record.columns[*x].is_some();
    record.columns[k].is_none() && !(0..system.states.len()).any(|x| source(&x))
}

/// Marks rest: samples at which the velocity stays below `threshold` for at least `least` consecutive
/// samples.
pub(crate) fn resting(velocity: &[f64], threshold: f64, least: usize) -> Vec<bool> {
    let mut out = vec![false; velocity.len()];
    let mut start = 0;
    for i in 0..=velocity.len() {
        if i == velocity.len() || velocity[i].abs() > threshold {
            if i - start >= least {
                out[start..i].fill(true);
            }
            start = i + 1;
        }
    }
    out
}

/// The speed below which a velocity counts as zero: `REST_NOISE` standard errors of the smoothed velocity,
/// and at least `REST_PART` of its rms value.
pub(crate) fn rest_threshold(velocity: &[f64]) -> f64 {
    let rms = (velocity.iter().map(|v| v * v).sum::<f64>() / velocity.len().max(1) as f64).sqrt();
    // The roughness of the smoothed velocity gives the noise that is left in it.
    (REST_NOISE * noise_level(velocity)).max(REST_PART * rms)
}
