//! Noise that is larger than the columns tell, or has a colour: where it is all that is left, nothing else is missing.

use super::Ending;
use crate::changed_constants::{ChangedConstants, is_finding};
use crate::decisions::SURE;
use crate::hum::is_hum;
use crate::model::{Fitted, Measure, TrialModel, current};
use crate::other_causes::causes;
use crate::result::{GapError, Status, Tried, Warning};
use phisindy_learn::{Effort, Identified, Verdict, reads_outputs};
use phisindy_phys::spec::Role;

impl Ending<'_, '_> {
    /// The fit with a random force, where no force is left, neither in the Fit records nor in all records together: noise has
    /// one size.
    fn without_force(&self, of: &Fitted) -> Option<Identified> {
        let needs_none = |found: &Identified| found.verdict == Verdict::Identified;
        let found = self.with_random_force(of).filter(needs_none)?;
        let (model, observer) = (&of.model, &self.search.observer);
        if !model.records.iter().any(|r| r.role == Role::Validate) {
            return Some(found);
        }
        // With outputs or jumps no fit looks for a force.
        let looks = !model.system.jumps() && !model.records.iter().any(|r| reads_outputs(&model.system, r));
        let all = || model.of_all_with_random_force(&|| observer.stopped());
        let alike = if looks { all().is_some_and(|all| needs_none(&all)) } else { of.score.is_of_one_size() };
        alike.then_some(found)
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
        if let Some(changed) = self.changed_constants_instead(&searched[n])? {
            return Ok(Some((Status::Explained, changed)));
        }
        let Some((n, found)) = self.without_force_or_hum(&searched, n) else { return Ok(None) };
        let before = (self.last.clone(), std::mem::replace(&mut self.path, searched));
        self.keep(n)?;
        found.iter().for_each(|found| self.take_numbers(found));
        if self.is_doubted() {
            (self.last, self.path) = before;
            return Ok(None);
        }
        let status = match n {
            0 => Status::NothingMissing,
            _ if (0..n).all(|k| self.step(k).is_sure()) => Status::Explained,
            _ => Status::Undetermined,
        };
        Ok(Some((status, n)))
    }

    /// How many of the first `n` effects it takes until no force is left, and the fit that shows it. Forces of time at the end
    /// are not needed where they are hum; then no fit shows it.
    fn without_force_or_hum(&self, searched: &[Fitted], n: usize) -> Option<(usize, Option<Identified>)> {
        // Nothing is missing where no law does better.
        let better = |t: &&Tried| t.gap.is_some() && t.vetoed.is_none();
        let for_laws: f64 = self.tried.0.iter().filter(better).map(|t| (0.5 * t.score).exp()).sum();
        if n == 0 && (1.0 + for_laws).recip() < SURE {
            return None;
        }
        let less = before_forces_of_time(&searched[n].model);
        let judged = |n: usize| Some((n, Some(self.without_force(&searched[n])?)));
        let found = if less < n { judged(less) } else { None };
        let found = found.or_else(|| judged(n))?;
        let hum = less < found.0 && is_hum(&searched[less], &searched[n], &self.noise);
        Some(if hum { (less, None) } else { found })
    }

    /// Takes the nearest model with changed constants, where it says more than the best of the search and needs no force;
    /// returns how many there are.
    fn changed_constants_instead(&mut self, best: &Fitted) -> Result<Option<usize>, GapError> {
        let nearest = self.changed.as_ref().and_then(ChangedConstants::nearest);
        let Some((effects, all)) = nearest.map(|(fitted, all)| (current(fitted), all)) else {
            return Ok(None);
        };
        let changed = self.base.model.with_all(&effects).ok();
        let changed = changed.and_then(|model| Fitted::new(model, &self.noise, Effort::Plain).ok());
        let says_more = |f: &Fitted| is_finding(f, all, best, self.candidates);
        match changed.filter(|f| says_more(f) && self.without_force(f).is_some()) {
            Some(changed) => self.instead(changed, &[]),
            None => Ok(None),
        }
    }

    /// Drops forces of time at the end of the model where they are hum: no force is left without them, or tones in the sensors
    /// describe the records better. Returns the status of what remains.
    pub(super) fn without_hum(&mut self) -> Result<Status, GapError> {
        let n = before_forces_of_time(&self.last.model);
        if n == self.last.model.effects.len() || self.interrupted() {
            return Ok(Status::Explained);
        }
        let found = self.without_force(&self.path[n]);
        if found.is_none() && !is_hum(&self.path[n], &self.last, &self.noise) {
            return Ok(Status::Explained);
        }
        self.keep(n)?;
        found.iter().for_each(|found| self.take_numbers(found));
        self.warnings.extend(causes(&self.base, &self.last).into_iter().map(Warning::Cause));
        Ok(if n == 0 { Status::NothingMissing } else { Status::Explained })
    }
}

/// The number of effects before the last ones that are forces of time alone.
fn before_forces_of_time(model: &TrialModel) -> usize {
    model.effects.iter().rposition(|a| !a.effect.entry.law.is_of_time()).map_or(0, |k| k + 1)
}
