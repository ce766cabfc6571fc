//! Outputs that jump, compared by their means over a window of samples.
//!
//! Where friction reverses, an accelerometer jumps. A model whose event is late by a few samples misses these
//! by the whole jump, and moving the event does not lower the sum of squares until the event passes a sample:
//! the cost of single samples has a side minimum for nearly every event time. The mean over a window has none
//! as long as the event stays within it, for its derivative holds that of the event time: `d/dp int y dt =
//! int dy/dp dt - [y] dt_e/dp`. So a fit whose outputs miss more than their noise starts with means over long
//! windows, which then get shorter.

use crate::decisions::{LARGEST_WINDOW, WHITE_EXCESS, WINDOW_FALL};
use crate::trajectory::delayed_samples::SampledRun;
use crate::trajectory::kalman_smoother::reads_outputs;
use crate::trajectory::layout::Segment;
use crate::trajectory::problem::Problem;
use phisindy_sim::Jump;

/// A window of samples of a column in a segment.
pub(crate) struct Window<'r> {
    pub(crate) column: usize,
    /// Its samples, counted in the segment.
    samples: Vec<usize>,
    /// The weighted difference of the means.
    pub(crate) miss: f64,
    /// By this a sum over the samples is weighted.
    pub(crate) factor: f64,
    /// Events within it, each with what the sum loses, in the unit of the column, for every sampling interval
    /// that it is later.
    events: Vec<(&'r Jump, f64)>,
    step: f64,
}

impl Window<'_> {
    /// The samples, counted in the segment.
    pub(crate) fn samples(&self) -> &[usize] {
        &self.samples
    }

    /// Adds what the events contribute to the derivatives of the sum by the unknowns of the run.
    pub(crate) fn add_events(&self, row: &mut [f64]) {
        for (jump, loss) in &self.events {
            let by = self.factor * loss / self.step;
            row.iter_mut().zip(&jump.moves).for_each(|(j, s)| *j -= by * s);
        }
    }

    /// What the sum loses for every second that all events are later.
    pub(crate) fn loss(&self) -> f64 {
        self.events.iter().map(|(_, loss)| self.factor * loss / self.step).sum()
    }
}

impl Problem<'_> {
    /// The windows, in samples and from long to short, by whose means a fit from `x` starts; none where no
    /// output jumps, or where outputs miss no more than their noise.
    pub(crate) fn windows(&self, x: &[f64]) -> Vec<usize> {
        let states = self.system.states.len();
        let outputs = self.records.iter().any(|r| reads_outputs(self.system, r));
        if !outputs || self.segments.len() > self.records.len() {
            return vec![];
        }
        let Ok(runs) = self.runs(x) else { return vec![] };
        if runs.iter().all(|r| r.run.jumps.is_empty()) {
            return vec![];
        }
        let (mut sum, mut count) = (0.0, 0);
        for (columns, noise) in self.residuals_of(&runs, x).iter().zip(&self.jump_noise) {
            for (column, noise) in columns.iter().zip(noise).skip(states) {
                sum = column.residual.iter().fold(sum, |sum, left| sum + (left / noise).powi(2));
                count += column.residual.len();
            }
        }
        if sum <= WHITE_EXCESS * count as f64 {
            return vec![];
        }
        let longest = self.segments.iter().map(|s| s.samples.1 - s.samples.0).max().unwrap_or(0);
        let first = longest / LARGEST_WINDOW;
        std::iter::successors(Some(first), |w| Some(w / WINDOW_FALL)).take_while(|w| *w > 1).collect()
    }

    /// Whether a column is compared by its means: outputs are.
    pub(crate) fn is_averaged(&self, column: usize, window: usize) -> bool {
        window > 1 && column >= self.system.states.len()
    }

    /// The windows of all outputs of a segment, each half as long away from the next.
    pub(crate) fn window_means<'r>(
        &self,
        segment: &Segment,
        x: &[f64],
        weights: &[Vec<Vec<f64>>],
        sampled: &'r SampledRun,
        window: usize,
    ) -> Vec<Window<'r>> {
        let record = self.records[segment.record];
        let (first, last) = segment.samples;
        let mut out = Vec::new();
        for (k, column) in record.columns.iter().enumerate() {
            let Some(column) = column.as_ref().filter(|_| self.is_averaged(k, window)) else { continue };
            let (_, gain) = self.reading(segment.record, k, x, 0.0);
            let late = self.lateness(segment.record, k, x);
            let shown: Vec<&Jump> = sampled.run.jumps.iter().filter(|j| j.by[k] != 0.0).collect();
            let step = self.steps[segment.record][k];
            let own: Vec<usize> = (0..last - first).filter(|i| record.own_times.has(k, first + i)).collect();
            let length = window.min(own.len());
            let mut from = 0;
            while from + length <= own.len() && length > 0 {
                let samples = &own[from..from + length];
                let time = |i: usize| late.middle(record.time[first + i]);
                let (begin, end) = (time(samples[0]) - 0.5 * step, time(samples[length - 1]) + 0.5 * step);
                let miss = |&i: &usize| {
                    self.reading(segment.record, k, x, sampled.value(i, k).0).0 - column[first + i]
                };
                let sum: f64 = samples.iter().map(miss).sum();
                let weight = samples.iter().map(|i| weights[segment.record][k][first + i]).sum::<f64>()
                    / length as f64;
                // The mean has a variance of 1/length, and half of its samples are those of the next window.
                let factor = (weight / (2.0 * length as f64)).sqrt();
                let events = shown.iter().filter(|j| j.time >= begin && j.time < end);
                let events: Vec<(&Jump, f64)> = events.map(|j| (*j, gain * j.by[k])).collect();
                // The sum has each sample stand for an interval around it; an event within one parts it.
                let parted = |(jump, by): &(&Jump, f64)| {
                    let before = samples.partition_point(|&i| time(i) <= jump.time);
                    let middle = begin + before as f64 * step;
                    by * (middle - jump.time) / step
                };
                let parts: f64 = events.iter().map(parted).sum();
                out.push(Window {
                    column: k,
                    samples: samples.to_vec(),
                    miss: factor * (sum + parts),
                    factor,
                    events,
                    step,
                });
                from += (length / 2).max(1);
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::onestep::tests::common;
    use phisindy_phys::{Record, System};

    /// A rubbing oscillator that an accelerometer sees.
    fn rubbing() -> (System, Record) {
        let text = r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2"), "A": (1.0, "m/s^2"), "W": (0.7, "rad/s"), "F": (value: 0.3, unit: "m/s^2", within: (0.0, 2.0)) },
            known: { "x": "v", "v": "-k*x + A*cos(W*t) - F*sgn(v)" }, contacts: ["v"], unknown: {}, outputs: { "a": (unit: "m/s^2", reads: "rate(v)") },
            data: [ Synthetic(truth: {}, start: { "x": 0.5, "v": 0.0 }, duration: 30.0, step: 0.02, measure: ["a"], noise: Additive(0.01), seed: 1) ])"#;
        let (case, mut records) = common::load_text(text, &[]);
        (case.system, records.remove(0))
    }

    /// The slope of a cost by differences over what moves events by a fifth of a sample, and the gradient
    /// that the fit uses.
    fn slopes(window: usize, at: f64) -> (f64, f64) {
        let (system, record) = rubbing();
        let problem = Problem::new(&system, &[], &[&record], &[1]).expect("a problem");
        let weights: Vec<Vec<Vec<f64>>> = vec![vec![vec![], vec![], vec![1e4; record.len()]]];
        let x = |friction: f64| vec![friction, 0.5, 0.0];
        let cost = |friction: f64| problem.cost_of_means(&x(friction), &weights, window).expect("a cost");
        let reach = 1e-3;
        let normal = problem.normal_of_means(&x(at), &weights, window).expect("normal equations");
        ((cost(at + reach) - cost(at - reach)) / (2.0 * reach), 2.0 * normal.gradient[0])
    }

    #[test]
    fn the_slope_of_means_holds_that_of_the_events() {
        for at in [0.25, 0.28, 0.33, 0.38] {
            let (by_differences, gradient) = slopes(32, at);
            assert!((gradient / by_differences - 1.0).abs() < 0.05, "{at}: {gradient} {by_differences}");
        }
    }

    #[test]
    fn means_are_for_outputs_that_miss_more_than_their_noise() {
        let (system, record) = rubbing();
        let problem = Problem::new(&system, &[], &[&record], &[1]).expect("a problem");
        assert_eq!(problem.windows(&[0.3, 0.5, 0.0]), Vec::<usize>::new());
        assert_eq!(problem.windows(&[0.4, 0.5, 0.0])[0], record.len() / LARGEST_WINDOW);
    }
}
