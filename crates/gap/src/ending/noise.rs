//! What is left is noise, although it is more than the columns tell: noise of another size or colour, hum.

use super::Ending;
use crate::changed_constants::{ChangedConstants, is_finding};
use crate::decisions::SURE;
use crate::hum::{is_hum, leaves_hum};
use crate::model::{Fitted, Measure, TrialModel, current};
use crate::other_causes::causes;
use crate::result::{GapError, Status, Tried, Warning};
use phisindy_learn::{Effort, Identified, Verdict, reads_outputs};
use phisindy_phys::spec::Role;

impl Ending<'_, '_> {
    /// The same fit, where neither it nor that of all records together needs a force: what is noise of another size in the
    /// Fit records is it in the others.
    fn without_force(&self, of: &Fitted) -> Option<Identified> {
        let needs_none = |found: &Identified| found.verdict == Verdict::Identified;
        let found = self.with_random_force(of).filter(needs_none)?;
        let (model, observer) = (&of.model, &self.search.observer);
        if !model.records.iter().any(|r| r.role == Role::Validate) {
            return Some(found);
        }
        // Beside outputs and jumps no fit asks for a force.
        let asks = !model.system.jumps() && !model.records.iter().any(|r| reads_outputs(&model.system, r));
        let all = || model.of_all_with_random_force(&|| observer.stopped());
        let alike = if asks { all().is_some_and(|all| needs_none(&all)) } else { of.score.is_of_one_size() };
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
        let with_hum = (0..=n).find(|&n| leaves_hum(&searched[n], &self.noise));
        let Some((n, found)) =
            with_hum.map(|n| (n, None)).or_else(|| self.without_force_or_hum(&searched, n))
        else {
            return Ok(None);
        };
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

    /// The number of effects, of these or but for the last forces of time, beside which no force is left, with that fit; the
    /// numbers stay as they are where tones of the sensors say more than these forces.
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

    /// Drops the last forces of time alone, if the model without them needs no force, or tones of the sensors say more: they
    /// are hum. Returns the status of what is left.
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
