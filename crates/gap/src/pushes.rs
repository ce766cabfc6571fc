//! Pushes that nobody measured. A model that is right between them leaves nothing where the records are cut there, and a
//! force of the motion is not gone with a few cuts.

use crate::decisions::{FEWEST_SAMPLES, MOST_OF_RESIDUAL, MOST_PUSHES, PUSHED_PART};
use crate::model::{Fitted, Measure, TrialModel, is_sure, power_of};
use crate::result::Push;
use phisindy_learn::{Identified, LearnOptions, RecordFit, identify};
use phisindy_phys::spec::{Method, Role};
use phisindy_phys::{Case, Record};
use std::ops::{ControlFlow, Range};

/// A stretch of a record between pushes.
#[derive(Clone)]
struct Piece {
    record: usize,
    samples: Range<usize>,
}

/// A push, cut out of its record.
struct Cut {
    record: usize,
    state: usize,
    samples: Range<usize>,
    /// The integral of the rate of the state.
    changes: f64,
}

impl Cut {
    /// Adds this cut to the others; those that it meets, or leaves too few samples before, are parts of it.
    fn join(mut self, cuts: &mut Vec<Cut>) {
        let meets = |a: &Range<usize>, b: &Range<usize>| {
            a.start < b.end + FEWEST_SAMPLES && b.start < a.end + FEWEST_SAMPLES
        };
        while let Some(k) = cuts.iter().position(|c| {
            (c.record, c.state) == (self.record, self.state) && meets(&c.samples, &self.samples)
        }) {
            let part = cuts.swap_remove(k);
            self.samples = self.samples.start.min(part.samples.start)..self.samples.end.max(part.samples.end);
            self.changes += part.changes;
        }
        cuts.push(self);
    }
}

/// Pushes that explain what a model leaves.
pub(crate) struct Pushed {
    pub(crate) pushes: Vec<Push>,
    /// The fit of what is between them.
    pub(crate) between: Identified,
    /// The samples between them, in all records.
    pub(crate) samples: usize,
    /// The mean square, in units of the noise, that these leave without the pushes and with them. A push shows in the motion
    /// after it; an outlier does not.
    pub(crate) left: [f64; 2],
    /// How many numbers they have.
    pub(crate) numbers: usize,
}

impl Pushed {
    /// Whether they are sure beside `base`, the model that they act on, and beside laws that lower its criterion by so much.
    pub(crate) fn is_sure(&self, base: &Fitted, candidates: usize, laws: impl Iterator<Item = f64>) -> bool {
        let of = |left: f64, numbers: usize| base.score.of_samples(left, self.samples, numbers);
        let (without, with) = (of(self.left[0], 0), of(self.left[1], self.numbers));
        let by = Measure::of([&with, &without], candidates);
        is_sure(by.criterion(&without) - by.criterion(&with), laws.chain([0.0]))
    }
}

/// Whether a model takes most of the residual of `base`. A law acts in all records: one that takes most of the gap of the
/// Validate records alone does not explain a push in a Fit record.
pub(crate) fn takes_most(of: &Fitted, base: &Fitted) -> bool {
    let beyond = |f: &Fitted| [f.score.fit, f.score.gap()].map(|gap| gap.powi(2) - 1.0);
    beyond(of).iter().zip(beyond(base)).all(|(left, before)| *left < (1.0 - MOST_OF_RESIDUAL) * before)
}

impl TrialModel {
    /// The fit of this model, as it is, that leaves a random force on each body.
    pub(crate) fn with_random_force(&self, stopped: &(dyn Fn() -> bool + Sync)) -> Option<Identified> {
        self.of_pieces(&self.whole(), None, false, stopped)
    }

    /// The same of a model that was fitted before.
    pub(crate) fn refitted_with_random_force(
        &self,
        stopped: &(dyn Fn() -> bool + Sync),
    ) -> Option<Identified> {
        self.of_pieces(&self.whole(), None, true, stopped)
    }

    /// The same, of all records together.
    pub(crate) fn of_all_with_random_force(&self, stopped: &(dyn Fn() -> bool + Sync)) -> Option<Identified> {
        self.of_pieces(&self.whole(), Some(Role::Fit), false, stopped)
    }

    /// Each record as one piece.
    fn whole(&self) -> Vec<Piece> {
        let of = |(record, r): (usize, &Record)| Piece { record, samples: 0..r.len() };
        self.records.iter().enumerate().map(of).collect()
    }

    /// The same of pieces of its records, each named by its place in the list; all fitted where a role is given.
    fn of_pieces(
        &self,
        pieces: &[Piece],
        role: Option<Role>,
        fitted_before: bool,
        stopped: &(dyn Fn() -> bool + Sync),
    ) -> Option<Identified> {
        let whole = |p: &Piece| p.samples.len() == self.records[p.record].len();
        let records: Vec<Record> = (pieces.iter().enumerate())
            .map(|(k, p)| {
                let of = &self.records[p.record];
                let cut = if whole(p) { of.clone() } else { of.within(p.samples.clone()) };
                let name = if role.is_some() { k.to_string() } else { of.name.clone() };
                Record { role: role.unwrap_or(of.role), name, ..cut }
            })
            .collect();
        let case = Case {
            system: self.system.clone(),
            records: pieces.iter().map(|p| self.given.plans[p.record].clone()).collect(),
            learn: self.given.spec.learn.clone(),
            laws: vec![],
            searches: vec![],
            requirements: vec![],
            without_laws: None,
            with_constants: None,
        };
        let mut observe = |_: f64| if stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let options = LearnOptions { method: Some(Method::Trajectory), fitted_before };
        identify(&case, &records, &options, &mut observe).ok()
    }

    /// The pushes without which this model, which was fitted before, leaves nothing; none where there are no such pushes.
    /// `without` is its fit.
    pub(crate) fn pushes(
        &self,
        without: &[RecordFit],
        noise: &[Vec<f64>],
        stopped: &(dyn Fn() -> bool + Sync),
    ) -> Option<Pushed> {
        let records = &self.records;
        let mut pieces = self.whole();
        let mut cuts: Vec<Cut> = vec![];
        loop {
            let found =
                self.of_pieces(&pieces, Some(Role::Fit), true, stopped).filter(|f| !f.interrupted())?;
            let strongest = found.remainder.iter().max_by(|a, b| a.share.total_cmp(&b.share));
            let Some(left) = strongest else { break };
            // What mostly follows the motion is a law that is missing.
            if left.of_motion > 0.5 * left.share {
                return None;
            }
            let place: usize = left.record.parse().ok()?;
            let Piece { record, samples } = pieces[place].clone();
            let time = &records[record].time;
            let burst = burst(&left.course)?;
            let [first, last] = [burst.start, burst.end - 1].map(|k| left.course[k].0);
            let from = time.partition_point(|t| *t < first).max(samples.start);
            let to = (time.partition_point(|t| *t <= last) + 1).min(samples.end);
            let changes =
                left.course[burst].windows(2).map(|w| 0.5 * (w[0].1 + w[1].1) * (w[1].0 - w[0].0)).sum();
            Cut { record, state: left.state, samples: from..to, changes }.join(&mut cuts);
            if cuts.len() > MOST_PUSHES * records.len() {
                return None;
            }
            let rest = [samples.start..from, to..samples.end].into_iter();
            let rest = rest
                .filter(|samples| samples.len() >= FEWEST_SAMPLES)
                .map(|samples| Piece { record, samples });
            pieces.splice(place..=place, rest);
            let kept: usize = pieces.iter().filter(|p| p.record == record).map(|p| p.samples.len()).sum();
            if (records[record].len() - kept) as f64 > PUSHED_PART * records[record].len() as f64 {
                return None;
            }
        }
        if cuts.is_empty() {
            return None;
        }
        cuts.sort_by_key(|cut| (cut.record, cut.samples.start));
        let pushes = cuts.iter().map(|cut| self.push(cut)).collect();
        let found = self.of_pieces(&pieces, None, false, stopped)?;
        let noise_of = |p: &Piece| noise[p.record].as_slice();
        let (with, samples) = power_of(pieces.iter().zip(&found.records).map(|(p, fit)| (fit, noise_of(p))));
        let alone = |p: &Piece| power_within(&without[p.record], &p.samples, noise_of(p));
        let left = [pieces.iter().map(alone).sum(), with].map(|power| power / samples.max(1) as f64);
        // A push has a beginning and an end, and the state after it.
        let numbers = cuts.len() * (2 + self.system.states.len());
        found.verdict.holds().then_some(Pushed { pushes, between: found, samples, left, numbers })
    }

    fn push(&self, cut: &Cut) -> Push {
        let (record, state) = (&self.records[cut.record], &self.system.states[cut.state]);
        let time = |k: usize| record.time[k.min(record.time.len() - 1)];
        Push {
            record: record.name.clone(),
            at: state.name.clone(),
            from: time(cut.samples.start),
            to: time(cut.samples.end),
            changes: cut.changes / state.factor,
            unit: state.unit.clone(),
        }
    }
}

/// Sum of (residual / noise)^2 of some samples of a run; what a column does not show has no residual.
fn power_within(fit: &RecordFit, samples: &Range<usize>, noise: &[f64]) -> f64 {
    let columns = fit.residuals.iter().filter(|column| !column.is_empty()).zip(noise);
    columns.flat_map(|(column, noise)| column[samples.clone()].iter().map(move |e| (e / noise).powi(2))).sum()
}

/// The stretch whose force is the strongest beside the rest: where the likelihood of two levels is largest, one within and
/// one without, both normal about zero. Given the levels it is the largest sum of a stretch (J. Bentley, Programming pearls:
/// algorithm design techniques, 1984). The levels follow from it until it stays: the likelihood grows with each round.
fn burst(course: &[(f64, f64)]) -> Option<Range<usize>> {
    let squares: Vec<f64> = course.iter().map(|(_, force)| force * force).collect();
    let mut sorted = squares.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    // Half of the squares of a standard normal number are below 0.455.
    let mut without = (*sorted.get(sorted.len() / 2)? / 0.455).max(f64::MIN_POSITIVE);
    let mut within = *sorted.last()?;
    let mut stretch = 0..0;
    for _ in 0..squares.len() {
        let gains = squares.iter().map(|f| f / without - f / within - (within / without).ln());
        let next = largest_sum(gains);
        if next == stretch || next.len() < 2 || next.len() == squares.len() {
            break;
        }
        stretch = next;
        let inside: f64 = squares[stretch.clone()].iter().sum();
        within = inside / stretch.len() as f64;
        without = (squares.iter().sum::<f64>() - inside) / (squares.len() - stretch.len()) as f64;
        if without.is_nan() || without <= 0.0 || without >= within {
            break;
        }
    }
    (stretch.len() > 1).then_some(stretch)
}

/// The stretch with the largest sum.
fn largest_sum(values: impl Iterator<Item = f64>) -> Range<usize> {
    let (mut start, mut sum, mut best) = (0, 0.0, (0.0, 0..0));
    for (k, value) in values.enumerate() {
        if sum <= 0.0 {
            (start, sum) = (k, 0.0);
        }
        sum += value;
        if sum > best.0 {
            best = (sum, start..k + 1);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A constant push, one of both signs, and one that takes a quarter of the record, in the scatter of an estimate.
    #[test]
    fn a_burst_is_where_the_force_is_strong() {
        let scatter = |k: usize| 0.3 * (1.7 * k as f64).sin();
        for (at, size, turns) in [(100..170, 0.8, false), (20..60, 0.9, true), (150..230, -1.0, false)] {
            let push = |k: usize| if turns && k % 8 < 4 { -size } else { size };
            let force = |k: usize| scatter(k) + if at.contains(&k) { push(k) } else { 0.0 };
            let course: Vec<(f64, f64)> = (0..300).map(|k| (0.01 * k as f64, force(k))).collect();
            let found = burst(&course).unwrap();
            assert!(found.start.abs_diff(at.start) < 4 && found.end.abs_diff(at.end) < 4, "{found:?} {at:?}");
        }
    }
}
