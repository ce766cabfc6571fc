//! Noise that is larger than the columns tell, or has a colour: where it is all that is left, nothing else is missing.

use super::Ending;
use crate::changed_constants::{ChangedConstants, is_finding, other_kinds};
use crate::decisions::{CHANCE, WORTH};
use crate::hum::evidence_of_hum;
use crate::model::{Fitted, Measure, TrialModel, current, measured};
use crate::other_causes::causes;
use crate::place::Effect;
use crate::result::{GapError, Status, Warning};
use crate::search::refitted;
use crate::sensor_linearity::bent_columns;
use phisindy_learn::{Effort, Identified, Verdict, reads_outputs};
use phisindy_phys::spec::Role;
use phisindy_signal::effective_samples;

impl Ending<'_, '_> {
    /// The fit with a random force, where no force is left, neither in the Fit records nor in all records together, and noise
    /// has one size in all of them and does not know the motion.
    fn without_force(&self, of: &Fitted) -> Option<Identified> {
        let needs_none = |found: &Identified| found.verdict == Verdict::Identified;
        let (model, observer) = (&of.model, &self.search.observer);
        let validates = model.records.iter().any(|r| r.role == Role::Validate);
        if validates && !self.is_of_one_size(of) || bent_columns(of).next().is_some() {
            return None;
        }
        let found = self.with_random_force(of).filter(needs_none)?;
        let all = || model.of_all_with_random_force(&|| observer.stopped());
        let alike = !validates || !looks_for_force(model) || all().is_some_and(|all| needs_none(&all));
        alike.then_some(found)
    }

    /// Whether the Validate records leave as much as the Fit records, but for chance.
    fn is_of_one_size(&self, of: &Fitted) -> bool {
        let left = |role: Role| -> Vec<Vec<f64>> {
            let records = of.cal.records.iter().zip(&self.noise).filter(|(fit, _)| fit.role == role);
            let columns = records.flat_map(|(fit, noise)| measured(fit).zip(noise));
            columns.map(|(column, noise)| column.iter().map(|e| e / noise).collect()).collect()
        };
        have_one_size(&left(Role::Fit), &left(Role::Validate))
    }

    /// The status of the best model of the search, if a fit with a random force on each body needs no force: the noise may
    /// have a colour, or be larger than the columns tell. The result is that model then, with so many effects.
    pub(super) fn by_the_judge_of_run(
        &mut self,
        searched: Vec<Fitted>,
        determined: usize,
    ) -> Result<Option<(Status, usize)>, GapError> {
        let by = Measure::of(searched.iter().map(|f| &f.score), self.candidates);
        let criterion = |n: &usize| by.criterion(&searched[*n].score);
        let best = (0..searched.len().min(determined + 1))
            .filter(|n| *n == 0 || searched[*n].follows())
            .min_by(|a, b| criterion(a).total_cmp(&criterion(b)));
        let Some(n) = best.filter(|_| !self.interrupted()) else { return Ok(None) };
        if self.changed_constants_instead(&searched[n])? {
            return Ok(Some(self.beside_near_rivals()));
        }
        let way = searched[..=n].to_vec();
        let Some((less, found)) = self.without_force_or_hum(&way) else { return Ok(None) };
        let whole = way[n].model.clone();
        let dropped = less.is_some();
        let before = (self.last.clone(), std::mem::replace(&mut self.path, less.unwrap_or(way)));
        self.keep(self.path.len() - 1)?;
        found.iter().for_each(|found| self.take_numbers(found));
        if self.is_doubted() {
            (self.last, self.path) = before;
            return Ok(None);
        }
        if dropped {
            self.forget_forces_of_time(&whole);
        }
        Ok(Some(self.beside_near_rivals()))
    }

    /// The status of the final model beside its near rivals, and the number of its effects.
    fn beside_near_rivals(&mut self) -> (Status, usize) {
        self.compare_near_rivals();
        let n = self.last.model.effects.len();
        let status = match n {
            0 => Status::NothingMissing,
            _ if (0..n).all(|k| self.step(k).is_sure()) => Status::Explained,
            _ => Status::Undetermined,
        };
        (status, n)
    }

    /// Whether no force is left beside the last model of `way`, or beside it without its forces of time. Gives the way to the
    /// latter, if it is that one, and the fit that shows it; hum needs none.
    fn without_force_or_hum(&self, way: &[Fitted]) -> Option<(Option<Vec<Fitted>>, Option<Identified>)> {
        let whole = way.last()?;
        if whole.model.effects.is_empty() && !self.nothing_is_sure() {
            return None;
        }
        let less = self.without_forces_of_time(way);
        let rest = less.as_ref().and_then(|less| less.last());
        let alone =
            rest.filter(|rest| looks_for_force(&rest.model)).and_then(|rest| self.without_force(rest));
        if alone.is_some() {
            return Some((less, alone));
        }
        let found = self.without_force(whole)?;
        let hum = rest.is_some_and(|rest| self.is_hum(rest, whole) == Some(true));
        Some(if hum { (less, None) } else { (None, Some(found)) })
    }

    /// The models on the way to the last one of `way` without its forces of time; `None` if it has none, or a fit fails.
    fn without_forces_of_time(&self, way: &[Fitted]) -> Option<Vec<Fitted>> {
        let last = way.last()?;
        let is_of_time = |e: &Effect| e.entry.law.is_of_time();
        let first = last.model.effects.iter().position(|a| is_of_time(&a.effect))?;
        let rest: Vec<Effect> = current(last).into_iter().filter(|e| !is_of_time(e)).collect();
        let fitted = |k: usize| {
            let model = last.model.without_effects().with_all(&rest[..k]).ok()?;
            refitted(model, last, &self.noise)
        };
        way[..=first].iter().cloned().map(Some).chain((first + 1..=rest.len()).map(fitted)).collect()
    }

    /// Counts the effects before each round anew, after the forces of time were taken from this model. Rounds that added
    /// nothing else say nothing of what is left.
    fn forget_forces_of_time(&mut self, whole: &TrialModel) {
        let of_time = |k: &usize| whole.effects[*k].effect.entry.law.is_of_time();
        let mut ends: Vec<usize> = self.rounds.iter().map(|r| r.before).collect();
        ends.push(whole.effects.len());
        for round in &mut self.rounds {
            let end = ends.iter().copied().filter(|end| *end > round.before).min().unwrap_or(round.before);
            let gone = round.before < end && (round.before..end).all(|k| of_time(&k));
            let earlier = (0..round.before.min(whole.effects.len())).filter(of_time).count();
            round.before = if gone { usize::MAX } else { round.before - earlier };
        }
    }

    /// Whether hum describes the records better than forces of time do, or these better than hum; `None` where the records do
    /// not tell.
    fn is_hum(&self, without: &Fitted, with: &Fitted) -> Option<bool> {
        let evidence = evidence_of_hum(without, with, &self.noise).unwrap_or(f64::NEG_INFINITY);
        (evidence.abs() > WORTH).then_some(evidence > 0.0)
    }

    /// Takes the nearest model with changed constants, where it says more than the best of the search and needs no force;
    /// whether it did. The laws of the search are its rivals.
    fn changed_constants_instead(&mut self, best: &Fitted) -> Result<bool, GapError> {
        let nearest = self.changed.as_ref().and_then(ChangedConstants::nearest);
        let Some((effects, all)) = nearest.map(|(fitted, all)| (current(fitted), all)) else {
            return Ok(false);
        };
        let changed = self.base.model.with_all(&effects).ok();
        let changed = changed.and_then(|model| Fitted::new(model, &self.noise, Effort::Plain).ok());
        let says_more =
            |f: &Fitted| is_finding(f, all, best, self.candidates) && self.is_sure_beside_laws(f, all);
        let Some(changed) = changed.filter(|f| says_more(f) && self.without_force(f).is_some()) else {
            return Ok(false);
        };
        let rivals = other_kinds((best, &self.rounds, self.candidates), &changed, all);
        let taken = self.instead(changed, &[])?.is_some();
        if taken {
            self.rounds[0].rivals.extend(rivals);
        }
        Ok(taken)
    }

    /// Drops the forces of time if they are hum. They are if no force is left without them, or if tones in the sensors describe
    /// the records better. Returns the status of what remains.
    pub(super) fn without_hum(&mut self) -> Result<Status, GapError> {
        if self.interrupted() {
            return Ok(Status::Explained);
        }
        let Some(less) = self.without_forces_of_time(&self.path) else { return Ok(Status::Explained) };
        let rest = &less[less.len() - 1];
        let looks = looks_for_force(&self.last.model);
        let found = if looks { self.without_force(rest) } else { None };
        if found.is_none() {
            match self.is_hum(rest, &self.last) {
                Some(true) => {}
                None if !looks => {
                    self.warnings.extend(causes(&self.base, rest).into_iter().map(Warning::Cause));
                    return Ok(Status::Undetermined);
                }
                _ => return Ok(Status::Explained),
            }
        }
        let (whole, n) = (self.last.model.clone(), less.len() - 1);
        self.path = less;
        self.keep(n)?;
        self.forget_forces_of_time(&whole);
        found.iter().for_each(|found| self.take_numbers(found));
        self.warnings.extend(causes(&self.base, &self.last).into_iter().map(Warning::Cause));
        Ok(self.beside_near_rivals().0)
    }
}

/// Whether the mean squares of two sets of columns differ by no more than chance. The scatter of each is estimated from its
/// squares, so it holds with heavy tails and with coloured noise.
fn have_one_size(a: &[Vec<f64>], b: &[Vec<f64>]) -> bool {
    // The logarithm of the mean square, and its variance.
    let size = |columns: &[Vec<f64>]| {
        let count = columns.iter().map(Vec::len).sum::<usize>() as f64;
        let mean = columns.iter().flatten().map(|e| e * e).sum::<f64>() / count;
        let squares = columns.iter().map(|c| c.iter().map(|e| e * e / mean - 1.0).collect::<Vec<f64>>());
        let (mut scatter, mut independent) = (0.0, 0.0);
        for column in squares {
            scatter += column.iter().map(|s| s * s).sum::<f64>();
            independent += effective_samples(&column);
        }
        (mean.ln(), scatter / count / independent)
    };
    let ((one, first), (other, second)) = (size(a), size(b));
    (one - other).abs() <= CHANCE * (first + second).sqrt()
}

/// Whether a fit with a random force looks for one: not with outputs or jumps.
fn looks_for_force(model: &TrialModel) -> bool {
    !model.system.jumps() && !model.records.iter().any(|r| reads_outputs(&model.system, r))
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_signal::test_signals::gaussian;

    /// Of a thousand normal numbers each, three standard errors of the ratio are a tenth of the size; with one in fifty
    /// ten times as large, or with as many copies, it is more.
    #[test]
    fn noise_has_one_size_in_all_records() {
        let of =
            |size: f64, seed: u64| -> Vec<f64> { gaussian(1000, seed).iter().map(|e| size * e).collect() };
        let alike = |a: &[f64], b: &[f64]| have_one_size(&[a.to_vec()], &[b.to_vec()]);
        assert!(alike(&of(1.2, 1), &of(1.2 * 1.04, 2)));
        assert!(!alike(&of(1.2, 1), &of(1.2 * 1.2, 2)) && !alike(&of(1.2 * 1.2, 1), &of(1.2, 2)));
        let heavy = |size: f64, seed: u64| -> Vec<f64> {
            of(size, seed).iter().enumerate().map(|(i, e)| if i % 50 == 7 { 10.0 * e } else { *e }).collect()
        };
        assert!(alike(&heavy(1.0, 1), &heavy(1.2, 2)));
        let slow = |size: f64, seed: u64| -> Vec<f64> {
            of(size, seed)[..50].iter().flat_map(|e| std::iter::repeat_n(*e, 20)).collect()
        };
        assert!(alike(&slow(1.0, 1), &slow(1.2, 2)));
    }
}
