//! Samples beside a jump. Where friction reverses, a force cell or an accelerometer jumps, where a
//! body hits another one a speed does, and a
//! model whose event is late by two samples misses two samples by the whole jump, however small the error.
//! Such a residual says nothing about a force. It says when the event was: within a sampling interval `h`, so
//! with the standard deviation `h/sqrt(12)`.
//!
//! A reading that lies nearer to the other side of the nearest jump is therefore compared with that side, and
//! the time of the event with the time of the sample, if that costs less. A reading between both sides, less
//! than half a sample from the event, is a sensor's mean over its sampling interval, and leaves nothing.

use crate::trajectory::delayed_samples::SampledRun;
use crate::trajectory::layout::Segment;
use crate::trajectory::problem::Problem;
use phisindy_sim::Jump;

/// What a sample of a column leaves, in the unit of the column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Miss {
    /// Prediction minus reading, on the side of the jump that was chosen.
    pub(crate) amplitude: f64,
    /// Where the other side was chosen: the index of the jump, and how late it is in standard deviations.
    pub(crate) timing: Option<(usize, f64)>,
}

/// How a sample lies to the jumps of its column.
pub(crate) struct Sample<'a> {
    pub(crate) jumps: &'a [Jump],
    pub(crate) column: usize,
    /// Gain of the sensor.
    pub(crate) gain: f64,
    /// The time that the sample shows.
    pub(crate) time: f64,
    /// Time between samples.
    pub(crate) step: f64,
    /// Noise of the column.
    pub(crate) noise: f64,
}

impl Sample<'_> {
    /// What a reading leaves that misses the prediction by `miss` (prediction minus reading).
    pub(crate) fn miss(&self, miss: f64) -> Miss {
        let plain = Miss { amplitude: miss, timing: None };
        let after = self.jumps.partition_point(|j| j.time <= self.time);
        // Of the events of all contacts those that this column shows.
        let shown = |k: &usize| self.jumps[*k].by[self.column] != 0.0;
        let before = (0..after).rev().find(shown).map(|k| (k, -1.0));
        let behind = (after..self.jumps.len()).find(shown).map(|k| (k, 1.0));
        let mut best = (miss * miss / (self.noise * self.noise), plain);
        for (k, sign) in before.into_iter().chain(behind) {
            let jump = &self.jumps[k];
            let other = sign * self.gain * jump.by[self.column];
            let late = jump.time - self.time;
            let between = (-miss / other).clamp(0.0, 1.0);
            let (amplitude, timing) = if late.abs() <= 0.5 * self.step {
                (miss + between * other, None)
            } else if between > 0.5 {
                (miss + other, Some((k, late * 12f64.sqrt() / self.step)))
            } else {
                continue;
            };
            let cost = (amplitude / self.noise).powi(2) + timing.map_or(0.0, |(_, e)| e * e);
            if cost < best.0 {
                best = (cost, Miss { amplitude, timing });
            }
        }
        best.1
    }

    /// The same as one number in the unit of the column.
    pub(crate) fn residual(&self, miss: f64) -> f64 {
        let Miss { amplitude, timing } = self.miss(miss);
        match timing {
            Some((_, late)) => miss.signum() * amplitude.hypot(late * self.noise),
            None => amplitude,
        }
    }
}

impl Problem<'_> {
    /// How a sample of a column lies to the jumps of a run; `None` where nothing jumps.
    pub(crate) fn beside_jumps<'r>(
        &self,
        segment: &Segment,
        x: &[f64],
        sampled: &'r SampledRun,
        (sample, column): (usize, usize),
        noise: f64,
    ) -> Option<Sample<'r>> {
        let jumps = &sampled.run.jumps[..];
        if jumps.is_empty() {
            return None;
        }
        let record = self.records[segment.record];
        let step = self.steps[segment.record][column];
        let time = self.lateness(segment.record, column, x).middle(record.time[sample]);
        let (_, gain) = self.reading(segment.record, column, x, 0.0);
        Some(Sample { jumps, column, gain, time, step, noise })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(jumps: &[Jump], time: f64) -> Sample<'_> {
        Sample { jumps, column: 0, gain: 1.0, time, step: 0.01, noise: 0.1 }
    }

    #[test]
    fn a_reading_on_the_other_side_tells_the_time_of_the_event() {
        let jumps = [Jump { time: 1.0, by: vec![-4.0], moves: vec![] }];
        // The model has jumped from 2 to -2, the reading is still 2.
        let late = sample(&jumps, 1.02).miss(-2.0 - 2.05);
        assert!((late.amplitude + 0.05).abs() < 1e-12, "{late:?}");
        assert!((late.timing.expect("a time").1 + 2.0 * 12f64.sqrt()).abs() < 1e-9, "{late:?}");
        // Far from the event a miss is a miss.
        assert_eq!(sample(&jumps, 1.5).miss(-4.05).amplitude, -4.05);
        // A small miss is noise, wherever it is.
        assert_eq!(sample(&jumps, 1.02).miss(0.1).amplitude, 0.1);
    }

    #[test]
    fn an_event_of_another_contact_in_between_does_not_matter() {
        let event = |time: f64, by: [f64; 2]| Jump { time, by: by.to_vec(), moves: vec![] };
        let jumps = [event(1.001, [0.0, 7.0]), event(1.002, [-4.0, 0.0]), event(1.02, [0.0, 7.0])];
        // The model jumps from 2 to -2 right after the sample, the reading is -2 already.
        assert!((sample(&jumps, 1.0).miss(2.0 + 2.05).amplitude - 0.05).abs() < 1e-12);
        assert!((sample(&jumps, 1.003).miss(-2.0 - 2.05).amplitude + 0.05).abs() < 1e-12);
    }

    #[test]
    fn a_mean_over_the_jump_leaves_nothing() {
        let jumps = [Jump { time: 1.0, by: vec![-4.0], moves: vec![] }];
        let miss = sample(&jumps, 1.003).miss(-2.0 - 0.5);
        assert!(miss.amplitude.abs() < 1e-12 && miss.timing.is_none(), "{miss:?}");
    }
}
