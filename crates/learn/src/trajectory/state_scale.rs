//! The sizes of the states of a problem: how much they move, and how far from zero they are.

use super::problem::Problem;
use crate::decisions::{SIZE_TOLERANCE, SLOPE_STRETCHES, SMALLEST_SIZE, STEPS_PER_SAMPLE};
use phisindy_sim::Options;

/// What a state's column is larger than the state by.
fn gain(record: &phisindy_phys::Record, state: usize) -> f64 {
    record.sensors[state].gain.start.abs()
}

impl Problem<'_> {
    /// The size of each state: from its columns, from the slope of the displacement whose velocity it is, or,
    /// of a state that nothing shows, from where the law or the model takes it.
    pub(super) fn scales(&self) -> Vec<f64> {
        let shown = self.shown_scales();
        if shown.iter().all(|s| *s > 0.0) {
            return shown;
        }
        let run = self.sizes_of_a_run(&shown);
        let of = |(k, scale): (usize, &f64)| {
            if *scale > 0.0 {
                return *scale;
            }
            let size = self.system.states[k].memory.or_else(|| run.as_ref().map(|all| all[k]));
            size.filter(|s| *s > 0.0 && s.is_finite()).unwrap_or(1.0)
        };
        shown.iter().enumerate().map(of).collect()
    }

    /// How large each state becomes in a coarse run of the first record, from the model's numbers as they
    /// start. `None` where the run ends early.
    fn sizes_of_a_run(&self, shown: &[f64]) -> Option<Vec<f64>> {
        let unknown = |k: usize| shown[k] <= 0.0 && self.system.states[k].memory.is_none();
        let n = shown.len();
        let record = *self.records.first().filter(|_| (0..n).any(unknown))?;
        let scale = shown.iter().map(|s| if *s > 0.0 { *s } else { SMALLEST_SIZE }).collect();
        let options = Options {
            tolerance: SIZE_TOLERANCE,
            scale,
            diverged: f64::MAX,
            max_steps: self.longest_segment().max(record.len()) * STEPS_PER_SAMPLE,
            ..Options::default()
        };
        let x = self.guess(&[], None, &self.records.iter().map(|r| (*r).clone()).collect::<Vec<_>>());
        let start = &x[self.segments.first()?.start..][..n];
        let run = self.simulated(0, &x, (record.time[0], start), &record.time, &options).ok()?;
        Some((0..n).map(|k| run.column(k).iter().fold(0.0_f64, |m, v| m.max(v.abs()))).collect())
    }

    /// The same, with 0 for a state that nothing shows.
    fn shown_scales(&self) -> Vec<f64> {
        (0..self.system.states.len())
            .map(|k| {
                let of = |r: usize| self.deviations[r][k] / gain(self.records[r], k);
                let own = (0..self.records.len()).map(of).fold(0.0, f64::max);
                if own > 0.0 {
                    return own;
                }
                let told = self.records.iter().filter_map(|r| r.sizes.get(k).copied()).fold(0.0, f64::max);
                if told > 0.0 {
                    return told;
                }
                let mut slope = 0.0_f64;
                for (x, _) in self.system.states.iter().enumerate().filter(|(_, s)| s.velocity == Some(k)) {
                    for record in &self.records {
                        let Some(column) = &record.columns[x] else { continue };
                        // Over a stretch of a hundredth of the record, so that noise does not make it large.
                        let far = (record.len() / SLOPE_STRETCHES).max(1);
                        let pairs = (far..record.len())
                            .map(|i| (column[i] - column[i - far]) / (record.time[i] - record.time[i - far]));
                        let count = (record.len() - far).max(1) as f64;
                        let mean = pairs.map(|s| s * s).sum::<f64>() / count;
                        slope = slope.max(mean.sqrt() / gain(record, x));
                    }
                }
                slope
            })
            .collect()
    }

    /// How far each state may be expected to go: as far as its columns are from the zeros that their sensors
    /// may have, if that is more than they move. A pendulum at rest moves by its noise alone, and the model
    /// of it swings about a zero that the search has not found yet. A velocity without a column may be larger
    /// than its scale by as much as its displacement.
    pub(super) fn reaches(&self) -> Vec<f64> {
        let from_zero = |k: usize| {
            let of = |record: &&phisindy_phys::Record| {
                let Some(column) = &record.columns[k] else { return 0.0 };
                let (low, high) = phisindy_signal::bounds(column);
                let offset = &record.sensors[k].offset;
                let (least, most) = offset.within.unwrap_or((offset.start, offset.start));
                (high - least).abs().max((low - most).abs()) / gain(record, k)
            };
            self.records.iter().map(of).fold(0.0, f64::max)
        };
        let own: Vec<f64> = (0..self.scale.len()).map(|k| self.scale[k].max(from_zero(k))).collect();
        let of = |k: usize| {
            let displacements = self.system.states.iter().enumerate().filter(|(_, s)| s.velocity == Some(k));
            displacements.map(|(x, _)| self.scale[k] * own[x] / self.scale[x]).fold(own[k], f64::max)
        };
        (0..own.len()).map(of).collect()
    }
}
