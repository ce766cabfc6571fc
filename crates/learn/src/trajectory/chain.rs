//! A record as a chain of short runs whose joints are tightened: the fit of motion that forgets its start.
//!
//! Where neighbouring motions diverge, the cost of one long run has a minimum in every ripple. Over a segment
//! so short that a disturbance hardly grows the motion is nearly linear in its start and in all coefficients,
//! and a penalty on the jumps between segments, tightened in steps, leads to the one run without leaving the
//! basin (multiple shooting: Bock, 1983; soft continuity: Ribeiro et al., Automatica 121 (2020) 109158).
//! Start states couple to their neighbours alone, so the work grows with their number.

use crate::decisions::{
    CHAIN_MINIMUM, CHAIN_SAMPLES, FIRST_NOISE, FORGOTTEN, LONGEST_STRETCH, LOOSE_JOINTS, LOST, NOISE_FLOOR,
    START_GAIN, STRETCHES_PER_TERM, TIGHT_JOINTS,
};
use crate::least_squares::Limits;
use crate::trajectory::chain_selection::{Criterion, addition, select_on_chain};
use crate::trajectory::fit::{Context, Fit, transfer};
use crate::trajectory::initial::Regression;
use crate::trajectory::layout::Segment;
use crate::trajectory::noise::{ColumnNoise, least_noise_of};
use crate::trajectory::problem::{Noise, Problem};
use crate::trajectory::select::Selection;
use phisindy_phys::Record;
use phisindy_phys::spec::SegmentsSpec;
use std::iter::successors;

impl<'a> Context<'a> {
    /// The fit of a chain with its terms selected from the whole dictionary, if the motion forgets its start
    /// or no single run has come near it, and if that is the better description.
    pub(crate) fn chained(&self, found: &Fit<'a>, regression: &Regression) -> Option<Selection<'a>> {
        if !self.forgets_its_start(found) {
            return None;
        }
        // Where a rich start blows up or ends in a side minimum, one of half as many terms may not.
        let starts = successors(Some(self.richest()), |n| (*n > 1).then_some(n / 2));
        let selected = starts.filter_map(|most| {
            let Selection { fit, path } = self.selected(&regression.best(self.system, most), regression)?;
            let fit = self.unchained(&fit).unwrap_or(fit);
            fit.is_white().then_some(Selection { fit, path })
        });
        selected.take(1).find(|s| s.fit.problem.terms != found.problem.terms)
    }

    /// The better of two selections on a chain that starts with these terms. A rich model bends in the joints
    /// where a poor one cannot, and a tight chain may end in a side minimum: terms are selected after the
    /// tightening, and along it. Joints that are loose stand for small terms, and along those that are tight
    /// a term can hardly be added, for all other numbers must follow it through a bent valley: in between
    /// neither holds.
    fn selected(&self, start: &[usize], regression: &Regression) -> Option<Selection<'a>> {
        let loose = self.loose_chain(start, &regression.solve(start))?;
        let after = self.tightened(&loose, &TIGHT_JOINTS).map(|full| select_on_chain(self, full));
        let (half, whole) = TIGHT_JOINTS.split_at(1);
        let first = self.refit(&loose, start).map(|fit| select_on_chain(self, fit));
        let along = [half, whole].iter().fold(first, |selected, joints| {
            self.tightened(&selected?.fit, joints).map(|fit| select_on_chain(self, fit))
        });
        let criterion = Criterion::new(self.system, &loose);
        let of = |s: &Selection<'_>| criterion.of_fit(&s.fit);
        after.into_iter().chain(along).min_by(|a, b| of(a).total_cmp(&of(b)))
    }

    /// Whether a disturbance of the start grows so much along the record that a fit of single runs is in
    /// doubt, or no such fit was found; asked of motion without contacts of which every state is measured.
    fn forgets_its_start(&self, found: &Fit<'a>) -> bool {
        let n = self.system.states.len();
        let measured = |r: &&Record| r.columns[..n].iter().all(Option::is_some);
        if !self.system.contacts.is_empty()
            || self.segments != SegmentsSpec::Auto
            || !self.records.iter().all(measured)
        {
            return false;
        }
        !found.is_white() || found.most_pieces() > 1 || growth(&found.problem, &found.x) > FORGOTTEN
    }

    /// The term beside those of a fit that the data ask for most, if they nearly ask for it, and by how much
    /// the criterion is worse with it; asked of motion that forgets its start, which shows its numbers
    /// through noise that hides terms.
    pub(crate) fn nearly_there(&self, fit: &Fit<'a>) -> Option<(usize, f64)> {
        let forgets = fit.problem.chained || growth(&fit.problem, &fit.x) > FORGOTTEN;
        (forgets && self.forgets_its_start(fit)).then(|| addition(self, fit))?
    }

    /// With how many terms of each equation a chain starts: all, or of a dictionary that has more of them
    /// than the regression has stretches the best ones of it.
    fn richest(&self) -> usize {
        let of_state = |k: usize| self.system.terms.iter().filter(|t| t.state == k).count();
        let most = (0..self.system.states.len()).map(of_state).max().unwrap_or(0);
        let stretches: usize = self.records.iter().map(|r| r.len() / LONGEST_STRETCH).sum();
        if most > stretches { (stretches / STRETCHES_PER_TERM).max(1) } else { most }
    }

    /// A chain with these terms whose joints hold as well as the readings do.
    fn loose_chain(&self, terms: &[usize], coefficients: &[f64]) -> Option<Fit<'a>> {
        let pieces: Vec<usize> = self.records.iter().map(|r| (r.len() / CHAIN_SAMPLES).max(1)).collect();
        let mut problem = self.cut(terms, &pieces)?;
        problem.chained = true;
        let noise = self.spectral_noise();
        let weights = problem.weights(&noise, None);
        let mut x = problem.guess(coefficients, None, &self.smooth);
        for tight in LOOSE_JOINTS {
            problem.continuity = Some(jumps(&problem, &noise, tight));
            problem.minimise(&mut x, &weights, Limits::of(CHAIN_MINIMUM)).ok()?;
        }
        self.settle(problem, x, noise, 1)
    }

    /// The same with tighter joints.
    fn tightened(&self, loose: &Fit<'a>, joints: &[f64]) -> Option<Fit<'a>> {
        let mut problem = self.problem(&loose.problem.terms, loose)?;
        let mut x = loose.x.clone();
        for &tight in joints {
            problem.continuity = Some(jumps(&problem, &loose.noise, tight));
            problem.minimise(&mut x, &loose.weights, Limits::of(CHAIN_MINIMUM)).ok()?;
        }
        self.settle(problem, x, loose.noise.clone(), 3)
    }

    /// A chain as one run from where it starts; `None` if no single run follows it.
    fn unchained(&self, chain: &Fit<'a>) -> Option<Fit<'a>> {
        let terms = &chain.problem.terms;
        let mut problem = self.evenly_cut(terms, 1)?;
        problem.chained = true;
        let mut x = problem.guess(&chain.x[..terms.len()], None, &self.smooth);
        transfer(&chain.problem, &chain.x, &problem, &mut x);
        for segment in &problem.segments {
            let first = chain.problem.segments.iter().find(|s| s.record == segment.record)?;
            let n = self.system.states.len();
            x[segment.start..segment.start + n].copy_from_slice(&chain.x[first.start..first.start + n]);
        }
        let single = self.settle(problem, x, chain.noise.clone(), 3)?;
        // Along such a run the numbers cannot be told from the start: they would have no error bars.
        if growth(&single.problem, &single.x) > LOST {
            return None;
        }
        (self.misfit(&single)? <= (1.0 + START_GAIN) * self.misfit(chain)?).then_some(single)
    }

    /// The noise of each column from its spectrum above the motion.
    pub(crate) fn spectral_noise(&self) -> Noise {
        let of = |r: usize, k: usize| {
            let record = self.records[r];
            let level = record.noise_level(k).max(least_noise_of(record, k, NOISE_FLOOR));
            ColumnNoise { additive: level.max(f64::MIN_POSITIVE), relative: 0.0 }
        };
        (0..self.records.len()).map(|r| (0..self.system.columns()).map(|k| of(r, k)).collect()).collect()
    }
}

/// How far each state may jump at a joint: this part of its noise, or of a hundredth of its size without a
/// column.
pub(crate) fn jumps(problem: &Problem<'_>, noise: &Noise, part: f64) -> Vec<f64> {
    let free = |k: usize| {
        let read = problem.records.iter().zip(noise).filter(|(r, _)| r.columns[k].is_some());
        let largest = read.map(|(_, noise)| noise[k].additive).fold(0.0, f64::max);
        if largest > 0.0 { largest } else { FIRST_NOISE * problem.scale[k] }
    };
    (0..problem.system.states.len()).map(|k| part * free(k)).collect()
}

/// By how much a disturbance of a start grows at most over a single run, each state in units of its size.
pub(crate) fn growth(problem: &Problem<'_>, x: &[f64]) -> f64 {
    let n = problem.system.states.len();
    let of_segment = |segment: &Segment| -> f64 {
        let Ok(sampled) = problem.run(segment, x, true) else { return f64::INFINITY };
        let run = &sampled.run;
        let entry = |i: usize, k: usize, j: usize| {
            (run.sensitivities[(i * run.n + k) * run.m + j] * problem.scale[j] / problem.scale[k]).abs()
        };
        let last = run.samples() - 1;
        let entries = (0..n).flat_map(|k| (0..n).map(move |j| (k, j)));
        entries.map(|(k, j)| entry(last, k, j)).fold(0.0, f64::max)
    };
    problem.segments.iter().map(of_segment).fold(0.0, f64::max)
}
