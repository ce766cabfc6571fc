//! Pushes that nobody measured. A model that is right between them leaves nothing where the records are cut there, and a
//! force of the motion is not gone with a few cuts.

use crate::decisions::{FEWEST_SAMPLES, MOST_PUSHES, PUSH_PAUSE, PUSH_STANDS_OUT, PUSHED_PART};
use crate::model::TrialModel;
use crate::result::Push;
use phisindy_learn::{Identified, LearnOptions, identify};
use phisindy_phys::spec::{Method, Role};
use phisindy_phys::{Case, Record};
use std::ops::{ControlFlow, Range};

/// A stretch of a record between pushes.
#[derive(Clone)]
struct Piece {
    record: usize,
    samples: Range<usize>,
}

impl TrialModel {
    /// The fit of this model, as it is, that leaves a random force on each body.
    pub(crate) fn with_random_force(&self, stopped: &(dyn Fn() -> bool + Sync)) -> Option<Identified> {
        self.of_pieces(&self.whole(), None, stopped)
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
        identify(&case, &records, &LearnOptions { method: Some(Method::Trajectory) }, &mut observe).ok()
    }

    /// The pushes without which this model leaves nothing, with the fit of what is between them; none where there are no
    /// such pushes.
    pub(crate) fn pushes(&self, stopped: &(dyn Fn() -> bool + Sync)) -> Option<(Vec<Push>, Identified)> {
        let records = &self.records;
        let mut pieces = self.whole();
        let mut pushes: Vec<Push> = vec![];
        loop {
            let found = self.of_pieces(&pieces, Some(Role::Fit), stopped).filter(|f| !f.interrupted())?;
            let strongest = found.remainder.iter().max_by(|a, b| a.share.total_cmp(&b.share));
            let Some(left) = strongest else { break };
            // What mostly follows the motion is a law that is missing.
            if pushes.len() == MOST_PUSHES * records.len() || left.of_motion > 0.5 * left.share {
                return None;
            }
            let place: usize = left.record.parse().ok()?;
            let Piece { record, samples } = pieces[place].clone();
            let time = &records[record].time;
            let burst = burst(&left.course)?;
            let [first, last] = [burst.start, burst.end - 1].map(|k| left.course[k].0);
            let from = time.partition_point(|t| *t < first).max(samples.start);
            let to = (time.partition_point(|t| *t <= last) + 1).min(samples.end);
            let changes: f64 =
                left.course[burst].windows(2).map(|w| 0.5 * (w[0].1 + w[1].1) * (w[1].0 - w[0].0)).sum();
            pushes.push(Push {
                record: records[record].name.clone(),
                at: self.system.states[left.state].name.clone(),
                from: time[from.min(time.len() - 1)],
                to: time[to.min(time.len()) - 1],
                changes: changes / self.system.states[left.state].factor,
                unit: self.system.states[left.state].unit.clone(),
            });
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
        if pushes.is_empty() {
            return None;
        }
        pushes.sort_by(|a, b| {
            (&a.record, a.from).partial_cmp(&(&b.record, b.from)).unwrap_or(std::cmp::Ordering::Equal)
        });
        let found = self.of_pieces(&pieces, None, stopped)?;
        found.verdict.holds().then_some((pushes, found))
    }
}

/// The stretch about the largest force in which it comes back above the scatter of the rest.
fn burst(course: &[(f64, f64)]) -> Option<Range<usize>> {
    let size = |k: usize| course[k].1.abs();
    let peak = (0..course.len()).max_by(|&a, &b| size(a).total_cmp(&size(b)))?;
    let mut sizes: Vec<f64> = (0..course.len()).map(size).collect();
    let middle = sizes.len() / 2;
    let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    // Half of what is normal lies within 0.6745 standard deviations.
    let level = PUSH_STANDS_OUT * *median / 0.6745;
    let pause = (PUSH_PAUSE * course.len() as f64) as usize + 1;
    let strong = |k: &usize| size(*k) >= level;
    let (mut start, mut end) = (peak, peak + 1);
    while let Some(k) = (start.saturating_sub(pause)..start).find(strong) {
        start = k;
    }
    while let Some(k) = (end..(end + pause).min(course.len())).rev().find(strong) {
        end = k + 1;
    }
    (end > start + 1).then_some(start..end)
}
