//! How sure an answer is beside all that was fitted.

use super::Ending;
use crate::changed_constants::{is_other_than_a_number, is_same_force};
use crate::decisions::SURE;
use crate::model::{Fitted, Measure, is_sure, probability_beside};
use crate::pushes::Pushed;
use crate::result::{PlacedLaw, Rival, Step, Tried};
use crate::search::Round;

impl Ending<'_, '_> {
    /// By how much the fitted laws that count lower the criterion, each alone.
    fn gains(&self, counts: impl Fn(&Tried, f64) -> bool) -> impl Iterator<Item = f64> {
        let fitted = self.tried.0.iter().filter(move |t| t.gap.is_some_and(|gap| counts(t, gap)));
        fitted.map(|t| t.score)
    }

    /// Whether it is sure that no law is missing. A law that is ruled out counts too: something else is missing then.
    pub(super) fn nothing_is_sure(&self) -> bool {
        is_sure(0.0, self.gains(|_, _| true))
    }

    /// Whether pushes are sure beside `base`, the model that they act on, and beside every fitted law.
    pub(super) fn pushes_are_sure(&self, pushed: &Pushed, base: &Fitted) -> bool {
        pushed.is_sure(base, self.candidates, self.gains(|_, _| true))
    }

    /// Whether changed constants are sure beside the fitted laws. `constants` says how many could have changed.
    pub(super) fn is_sure_beside_laws(&self, changed: &Fitted, constants: usize) -> bool {
        let by = Measure::of([&changed.score, &self.base.score], self.candidates);
        let gain = by.criterion(&self.base.score) - by.among(constants).criterion(&changed.score);
        let other = |t: &Tried, gap: f64| {
            let entry = self.search.catalogue.iter().find(|entry| entry.id == t.at.law);
            !is_same_force(gap, changed.score.gap())
                && t.vetoed.is_none()
                && entry.is_some_and(|e| is_other_than_a_number(&e.law))
        };
        is_sure(gain, self.gains(other))
    }

    /// By how much later effects lowered the criterion of the model with which a round ended.
    pub(super) fn gained_since(&self, round: &Round) -> f64 {
        let all = self.last.model.effects.len();
        let later = self.rounds.iter().map(|r| r.before).filter(|before| *before > round.before);
        let then = &self.path[later.min().unwrap_or(all).min(all)].score;
        let by = Measure::of([then, &self.last.score], self.candidates);
        by.criterion(then) - by.criterion(&self.last.score)
    }
}

impl Step {
    /// Whether the law is sure beside its rivals. One that moves the same is the same answer. One that holds it, or of which
    /// it is a special case, speaks against it only where it does better.
    pub(super) fn is_sure(&self) -> bool {
        let own = &self.effect;
        let holds = |r: &Rival| {
            let mut effects = r.model.iter().flat_map(|m| m.effects.iter().map(|a| &a.effect));
            effects.any(|e| e.same(own) || own.is_simpler_form_of(e))
        };
        let against = self.rivals.iter().filter(|r| !r.same && (r.delta_bic < 0.0 || !holds(r)));
        probability_beside(against.map(|r| r.delta_bic)) >= SURE
    }
}

/// The rivals of a law, beside the final model. One that holds the law and more was an answer to what was left then: later
/// effects have left it behind. Of one without the law nobody knows how it would do beside these.
pub(super) fn rivals_of_the_answer(mut rivals: Vec<Rival>, law: &PlacedLaw, gained_since: f64) -> Vec<Rival> {
    rivals.iter_mut().for_each(|r| r.behind = r.delta_bic + gained_since);
    rivals.iter_mut().filter(|r| r.laws.contains(law)).for_each(|r| r.delta_bic = r.behind);
    rivals.sort_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic));
    rivals
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a richer model does better than the answer, the answer is not all; once the answer has more effects, what was
    /// an alternative to the next one is none any more.
    #[test]
    fn a_rival_that_holds_the_law_counts_against_the_final_model() {
        let law = |id: &str| PlacedLaw { law: id.into(), name: id.into(), at: "v".into() };
        let rivals = || {
            let rival = |laws, delta_bic| Rival {
                laws,
                delta_bic,
                behind: f64::INFINITY,
                same: false,
                completed: None,
                model: None,
            };
            vec![rival(vec![law("maxwell"), law("quintic")], -8.0), rival(vec![law("bouc-wen")], 3.0)]
        };
        let deltas = |gained: f64| -> Vec<f64> {
            rivals_of_the_answer(rivals(), &law("maxwell"), gained).iter().map(|r| r.delta_bic).collect()
        };
        assert_eq!(deltas(0.0), [-8.0, 3.0]);
        assert_eq!(deltas(500.0), [3.0, 492.0]);
    }
}
