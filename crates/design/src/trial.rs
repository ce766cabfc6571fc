//! A run that a rig could make.

use crate::limits::{Limits, step};
use phisindy_phys::Record;
use std::f64::consts::{PI, TAU};

/// The form of a drive; each begins at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A sine.
    Tone,
    /// Straight lines up and down.
    Triangle,
    /// Levels by chance, two in a cycle, with smooth ways between them: what jumps between two samples is not in a record.
    Steps,
    /// Two cycles of a sine, then rest, each time longer: for what depends on how long a contact rested.
    Bursts,
    /// A sine whose frequency grows up to the end of the band, or tenfold.
    Sweep,
    /// Ten sines up to the end of the band, or ten times the frequency, with the phases of M. Schroeder (1970,
    /// doi 10.1109/TIT.1970.1054411).
    Multisine,
}

impl Shape {
    /// All of them.
    pub const ALL: [Shape; 6] =
        [Shape::Tone, Shape::Triangle, Shape::Steps, Shape::Bursts, Shape::Sweep, Shape::Multisine];

    /// As a sentence calls it.
    pub fn name(self) -> &'static str {
        match self {
            Shape::Tone => "tone",
            Shape::Triangle => "triangle",
            Shape::Steps => "steps",
            Shape::Bursts => "bursts",
            Shape::Sweep => "sweep",
            Shape::Multisine => "multisine",
        }
    }
}

/// What drives one input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waveform {
    /// The input.
    pub input: usize,
    /// The form.
    pub shape: Shape,
    /// Of a tone; where a sweep or a multisine begins (Hz).
    pub frequency: f64,
    /// The end of a sweep or a multisine (Hz).
    pub end: f64,
    /// Its largest distance from the middle (SI).
    pub amplitude: f64,
    /// The middle (SI).
    pub middle: f64,
}

/// The part of a level in which it is reached.
const TRANSITION: f64 = 0.4;
/// How many sines a multisine has.
const SINES: usize = 10;

impl Waveform {
    /// Its values at the samples of a run.
    pub fn values(&self, step: f64, samples: usize) -> Vec<f64> {
        let duration = step * samples as f64;
        let all: Vec<f64> = (0..samples).map(|i| self.plain(step * i as f64, duration)).collect();
        let largest = all.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let unit = if self.shape == Shape::Multisine && largest > 0.0 { largest } else { 1.0 };
        all.into_iter().map(|x| self.middle + self.amplitude * x / unit).collect()
    }

    /// Between -1 and 1, but for a multisine.
    fn plain(&self, t: f64, duration: f64) -> f64 {
        let cycles = self.frequency * t;
        match self.shape {
            Shape::Tone => (TAU * cycles).sin(),
            Shape::Triangle => (TAU * cycles).sin().asin() * 2.0 / PI,
            Shape::Steps => {
                let (now, since) = ((2.0 * cycles) as u64, (2.0 * cycles).fract());
                let from = now.checked_sub(1).map_or(0.0, level);
                let part = (since / TRANSITION).min(1.0);
                from + (level(now) - from) * part * part * (3.0 - 2.0 * part)
            }
            Shape::Bursts => {
                let (mut from, mut rest) = (0.0, 2.0);
                while cycles >= from + 2.0 + rest {
                    (from, rest) = (from + 2.0 + rest, 2.0 * rest);
                }
                if cycles < from + 2.0 { (TAU * (cycles - from)).sin() } else { 0.0 }
            }
            Shape::Sweep => {
                let ratio = (self.end / self.frequency).max(1.0 + 1e-9).ln();
                (TAU * self.frequency * duration / ratio * ((ratio * t / duration).exp() - 1.0)).sin()
            }
            Shape::Multisine => {
                let spacing = (self.end - self.frequency) / (SINES - 1) as f64;
                let sine = |k: usize| {
                    let phase = -PI * (k * (k + 1)) as f64 / SINES as f64;
                    (TAU * (self.frequency + spacing * k as f64) * t + phase).sin()
                };
                (0..SINES).map(sine).sum::<f64>() * cycles.min(1.0)
            }
        }
    }
}

/// A level by chance between -1 and 1, the same for each number.
fn level(k: u64) -> f64 {
    // SplitMix64 (G. L. Steele, D. Lea, C. H. Flood 2014, doi 10.1145/2660193.2660195).
    let mut z = k.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// A run that a rig could make.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// What drives it; `None` for a run that is let go, or that repeats a record.
    pub waveform: Option<Waveform>,
    /// States (SI) at which it is let go; the others are at rest.
    pub start: Vec<(String, f64)>,
    /// Which setting of the constants.
    pub setting: usize,
    /// The time between samples (s).
    pub step: f64,
    /// How many samples.
    pub samples: usize,
    /// The values of each input (SI).
    pub inputs: Vec<Vec<f64>>,
}

impl Trial {
    /// How long it is (s).
    pub fn duration(&self) -> f64 {
        self.step * self.samples.saturating_sub(1) as f64
    }

    /// The same run with another time between samples, its inputs in straight lines between those that it has.
    pub fn sampled(&self, step: f64) -> Trial {
        let samples = (self.duration() / step).round() as usize + 1;
        let value = |values: &[f64], i: usize| {
            let at = (i as f64 * step / self.step).min((self.samples - 1) as f64);
            let (k, part) = (at as usize, at.fract());
            values[k] + part * (values[(k + 1).min(self.samples - 1)] - values[k])
        };
        let inputs = self.inputs.iter().map(|values| (0..samples).map(|i| value(values, i)).collect());
        Trial { step, samples, inputs: inputs.collect(), ..self.clone() }
    }

    /// A run with this drive from these states, as long as the limits allow.
    pub(crate) fn driven(
        limits: &Limits,
        like: &Record,
        step: f64,
        waveform: Option<Waveform>,
        start: Vec<(String, f64)>,
        setting: usize,
    ) -> Trial {
        let samples = (limits.duration.0 / step).round() as usize + 1;
        let mut inputs: Vec<Vec<f64>> =
            (0..like.inputs.len()).map(|k| vec![limits.rest(k, like); samples]).collect();
        if let Some(waveform) = waveform {
            inputs[waveform.input] = waveform.values(step, samples);
        }
        for derived in &like.derivations {
            inputs[derived.input] = slopes(&inputs[derived.of], step);
        }
        Trial { waveform, start, setting, step, samples, inputs }
    }

    /// The drive of a record once more, or so many times.
    pub(crate) fn repeated(like: &Record, step: f64, times: usize) -> Trial {
        let (from, length) = (like.time[0], like.time[like.len() - 1] - like.time[0]);
        let samples = (times as f64 * length / step).round() as usize + 1;
        let at = |i: usize| from + (i as f64 * step) % length.max(step);
        let inputs = like.inputs.iter().map(|u| (0..samples).map(|i| u.value(at(i))).collect()).collect();
        Trial { waveform: None, start: vec![], setting: 0, step, samples, inputs }
    }

    /// The first part of it.
    pub(crate) fn first(&self, samples: usize) -> Trial {
        let inputs = self.inputs.iter().map(|values| values[..samples].to_vec()).collect();
        Trial { samples, inputs, ..self.clone() }
    }
}

fn slopes(values: &[f64], step: f64) -> Vec<f64> {
    let last = values.len() - 1;
    let slope = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
        (values[b] - values[a]) / (step * (b - a).max(1) as f64)
    };
    (0..values.len()).map(slope).collect()
}

impl Limits {
    /// The value of an input at rest: zero, or what is nearest to it; of one that nothing drives, its mean.
    pub(crate) fn rest(&self, input: usize, like: &Record) -> f64 {
        match self.inputs.iter().find(|(k, _)| *k == input) {
            Some((_, range)) => 0.0_f64.clamp(range.within.0, range.within.1),
            None if like.derivations.iter().any(|d| d.input == input) => 0.0,
            None => like.input_samples(input).iter().sum::<f64>() / like.len() as f64,
        }
    }

    /// The first column that leaves its limits.
    pub(crate) fn left_by(&self, columns: &[Vec<f64>], system: &phisindy_phys::System) -> Option<String> {
        let out =
            |(low, high): (f64, f64), column: &Vec<f64>| column.iter().any(|x| !(low..=high).contains(x));
        let ranges = self.columns.iter().filter_map(|(_, range)| Some((range, system.column(&range.name)?)));
        let mut left =
            ranges.filter(|(range, k)| columns.get(*k).is_some_and(|column| out(range.within, column)));
        left.next().map(|(range, _)| range.name.clone())
    }

    /// The time between samples at which a run is looked at: that of the record, or as coarse as a long run allows.
    pub(crate) fn step(&self, like: &Record) -> f64 {
        let fine = step(like);
        let coarse = (self.duration.0 / MOST_SAMPLES).min((SAMPLES_IN_A_CYCLE * self.band.1).recip());
        fine.max(coarse)
    }
}

/// Runs are looked at in about so many samples.
const MOST_SAMPLES: f64 = 2000.0;
/// A cycle of the fastest drive has so many.
const SAMPLES_IN_A_CYCLE: f64 = 20.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drives_stay_within_their_amplitude_and_begin_at_rest() {
        for shape in Shape::ALL {
            let waveform =
                Waveform { input: 0, shape, frequency: 0.7, end: 7.0, amplitude: 2.0, middle: 1.0 };
            let values = waveform.values(0.01, 2000);
            let largest = values.iter().fold(0.0_f64, |m, x| m.max((x - 1.0).abs()));
            assert!(largest <= 2.0 + 1e-12 && largest > 1.6, "{shape:?} {largest}");
            assert!((values[0] - 1.0).abs() < 1e-12, "{shape:?}");
            // The same run in half the time is its first part, but for a sweep.
            let half = waveform.values(0.01, 1000);
            let same = half.iter().zip(&values).all(|(a, b)| (a - b).abs() < 1e-12);
            assert_eq!(same, shape != Shape::Sweep, "{shape:?}");
        }
    }
}
