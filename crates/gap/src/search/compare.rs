//! Comparison of models by their scores.

use crate::decisions::{FAR_OFF, ON_THE_WAY, RICHER, SIMPLER};
use crate::model::{Fitted, Measure, Score, TrialModel};
use crate::result::{PlacedLaw, Rival};

/// Sorts models by the criterion, best first.
pub(crate) fn rank(all: &mut [Fitted], candidates: usize) {
    let by = Measure::of(all.iter().map(|f| &f.score), candidates);
    all.sort_by(|a, b| by.criterion(&a.score).total_cmp(&by.criterion(&b.score)));
}

/// The best model by the criterion, or a simpler one that is as good.
pub(crate) fn preferred(all: &[Fitted], candidates: usize) -> Option<&Fitted> {
    let scores: Vec<&Score> = all.iter().map(|f| &f.score).collect();
    preferred_score(&scores, candidates).map(|k| &all[k])
}

fn preferred_score(all: &[&Score], candidates: usize) -> Option<usize> {
    let by = Measure::of(all.iter().copied(), candidates);
    let best = all.iter().min_by(|a, b| by.criterion(a).total_cmp(&by.criterion(b)))?;
    let near = |s: &Score| by.criterion(s) - by.criterion(best) < SIMPLER || predicts_no_better(s, best);
    let near: Vec<usize> = (0..all.len()).filter(|&k| near(all[k])).collect();
    let least = near.iter().map(|&k| all[k].parameters).min()?;
    let gap = |k: usize| all[k].predictive.unwrap_or(0.0);
    near.into_iter().filter(|&k| all[k].parameters == least).min_by(|&a, &b| gap(a).total_cmp(&gap(b)))
}

/// Whether two models both leave more than noise, and the second predicts Validate records no better than the
/// first.
pub(crate) fn predicts_no_better(simple: &Score, rich: &Score) -> bool {
    let better = simple.predictive.zip(rich.predictive).is_none_or(|(a, b)| b < RICHER * a);
    !rich.is_white() && !simple.is_white() && !better && !makes_progress(simple, rich)
}

/// Whether `to` is far from the noise but reduces the gap on Fit records to `ON_THE_WAY` of that of `from`.
/// While much is missing, Validate records are missed whatever is added, so they do not count; the end of the
/// search judges them.
pub(crate) fn makes_progress(from: &Score, to: &Score) -> bool {
    to.fit > FAR_OFF && to.fit < ON_THE_WAY * from.fit
}

/// Laws and places of all effects of a model.
pub(crate) fn placed(model: &TrialModel) -> Vec<PlacedLaw> {
    label(model, 0)
}

/// Laws and places of its effects from index `from` on.
pub(crate) fn label(model: &TrialModel, from: usize) -> Vec<PlacedLaw> {
    model.effects[from.min(model.effects.len())..].iter().map(|a| PlacedLaw::of(&a.effect)).collect()
}

/// A fitted model as a rival that is behind by this much, told by its effects from index `from` on.
pub(crate) fn rival(of: &Fitted, from: usize, delta_bic: f64) -> Rival {
    let mut model = of.model.starting_at(&of.estimates(|p| !p.each));
    of.starts(&mut model);
    let (laws, model) = (label(&of.model, from), Some(Box::new(model)));
    Rival { laws, delta_bic, behind: f64::INFINITY, same: false, completed: None, model }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::tests::score;

    #[test]
    fn a_simpler_model_that_does_as_well_is_preferred() {
        let with = |fit: f64, parameters: usize| Score { parameters, ..score(fit, Some(fit), 1) };
        let table: [(&[Score], usize); 5] = [
            // Both white: the criterion decides, which prices parameters.
            (&[with(1.0, 3), with(1.0, 1)], 1),
            (&[with(1.03, 1), with(1.0, 2)], 1),
            (&[with(1.001, 1), with(1.0, 2)], 0),
            // More than noise is left: the richer one must lower the gap on Validate records by a twentieth.
            (&[with(1.50, 1), with(1.46, 3)], 0),
            (&[with(1.60, 1), with(1.30, 3)], 1),
        ];
        for (scores, due) in table {
            let all: Vec<&Score> = scores.iter().collect();
            assert_eq!(preferred_score(&all, 30), Some(due), "{scores:?}");
        }
        assert_eq!(preferred_score(&[], 30), None);
    }

    #[test]
    fn far_from_the_noise_half_the_gap_is_progress() {
        assert!(makes_progress(&score(30.0, None, 0), &score(14.0, None, 1)));
        assert!(!makes_progress(&score(30.0, None, 0), &score(16.0, None, 1)));
        assert!(!makes_progress(&score(3.0, None, 0), &score(1.4, None, 1)));
    }
}
