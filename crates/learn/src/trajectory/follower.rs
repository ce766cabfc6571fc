//! A run that follows the readings of a record by given gains, with its derivatives: each innovation is a
//! residual, and moves the state for those after it.

use crate::trajectory::cost::{add_to, by_sensor};
use crate::trajectory::delayed_samples::{Delayed, DelayedSamples, Reading};
use crate::trajectory::filter::{Gains, shown_value};
use crate::trajectory::layout::{Segment, SensorSlots};
use crate::trajectory::problem::Problem;
use phisindy_sim::{Observer, Shown};

pub(crate) struct Follower<'p> {
    problem: &'p Problem<'p>,
    record: usize,
    x: &'p [f64],
    gains: &'p Gains,
    first: usize,
    due: Vec<Vec<Reading>>,
    /// Where the sensor parameters of each column stand among the derivatives.
    slots: Vec<SensorSlots>,
    /// Columns of the derivatives: those of the run, then numbers of sensors that no rate knows.
    width: usize,
    pub(crate) spare: usize,
    /// What each measured column shows before it corrects.
    pub(crate) read: Vec<Option<Delayed>>,
}

impl<'p> Follower<'p> {
    pub(crate) fn new(
        problem: &'p Problem<'p>,
        segment: &Segment,
        x: &'p [f64],
        gains: &'p Gains,
        samples: &DelayedSamples,
        derivatives: bool,
    ) -> Follower<'p> {
        let record = problem.records[segment.record];
        let measured = |k: usize| record.columns[k].is_some();
        let (at, slots) = problem.unknowns_of(segment);
        let of_run = problem.system.states.len() + problem.free_parameters(segment.record);
        let read = record.columns.iter().map(|column| column.as_ref().map(|_| Delayed::default())).collect();
        Follower {
            problem,
            record: segment.record,
            x,
            gains,
            first: segment.samples.0,
            due: samples.due(measured),
            slots,
            width: if derivatives { at.len() } else { 0 },
            spare: at.len() - of_run,
            read,
        }
    }
}

impl Observer for Follower<'_> {
    fn correct(&mut self, sample: usize, shown: &Shown<'_>, x: &mut [f64], s: &mut [f64]) -> bool {
        let (n, m) = (x.len(), self.width);
        let (shown_x, shown_s) = (x.to_vec(), s.to_vec());
        let mut row = vec![0.0; m];
        for Reading { column, sample: own } in self.due[sample].clone() {
            let (value, by_state) = shown_value(shown, column, x, &shown_x);
            let rate = shown.rates[column];
            if m > 0 {
                if column < n {
                    row.copy_from_slice(&s[column * m..][..m]);
                } else {
                    row.copy_from_slice(&shown.sensitivities[column * m..][..m]);
                    for (k, c) in by_state.iter().enumerate().filter(|(_, c)| **c != 0.0) {
                        let moved = s[k * m..][..m].iter().zip(&shown_s[k * m..][..m]);
                        row.iter_mut().zip(moved).for_each(|(r, (s, b))| *r += c * (s - b));
                    }
                }
            }
            let Some(read) = &mut self.read[column] else { continue };
            read.values.push((value, rate));
            read.by_lag.push(-rate);
            read.sensitivities.extend(&row);
            let (predicted, gain) = self.problem.reading(self.record, column, self.x, value);
            let Some(readings) = &self.problem.records[self.record].columns[column] else { continue };
            let miss = readings[self.first + own] - predicted;
            let gains = self.gains.at(column, self.first + own, n);
            x.iter_mut().zip(gains).for_each(|(x, k)| *x += k * miss);
            if m == 0 {
                continue;
            }
            row.iter_mut().for_each(|r| *r *= gain);
            let record = self.problem.records[self.record];
            let age = record.time[self.first + own] - record.sensors[column].since;
            add_to(&mut row, &self.slots[column], by_sensor(1.0, gain, (value, rate, -rate), age));
            for (s, k) in s.chunks_exact_mut(m).zip(gains).filter(|(_, k)| **k != 0.0) {
                s.iter_mut().zip(&row).for_each(|(s, r)| *s -= k * r);
            }
        }
        true
    }
}
