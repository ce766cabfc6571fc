//! Improves a fitted model: effects at other places, siblings of its laws, fewer and simpler effects.

use super::proposals::{family, relative};
use super::task::Search;
use crate::decisions::{MOST_EFFECTS, NEAR_NOISE, RACE, SAME_GAP, SIMPLER};
use crate::evidence::stands;
use crate::model::{Fitted, Measure, TrialModel, current};
use crate::place::{Effect, Site};
use crate::screen::{excludes, sibling_starts};
use phisindy_learn::Effort;
use rayon::prelude::*;

impl Search<'_> {
    /// Tries each effect at every other place. The first effects were chosen while the others were missing,
    /// and may have compensated for part of them.
    pub(crate) fn relocated(&self, mut now: Fitted, candidates: usize) -> Fitted {
        for _ in 0..MOST_EFFECTS {
            let effects = current(&now);
            if effects.len() < 2 {
                break;
            }
            let base = now.model.without_effects();
            let relocations = |k: usize| {
                let own = &effects[k];
                let free =
                    base.places().iter().filter(|p| base.takes(&own.entry.law, p) && p.at != own.place.at);
                free.map(|p| Effect { place: p.clone(), ..own.clone() }).collect::<Vec<_>>()
            };
            let trials: Vec<Vec<Effect>> = (0..effects.len())
                .flat_map(|k| relocations(k).into_iter().map(move |e| (k, e)))
                .filter(|(k, e)| effects.iter().enumerate().all(|(j, other)| j == *k || !excludes(other, e)))
                .map(|(k, e)| replaced(&effects, k, e))
                .collect();
            let noise = self.noise;
            let others: Vec<Fitted> =
                trials.par_iter().filter_map(|list| refit_with(&base, &now, list, noise)).collect();
            match better(&now, others, candidates) {
                Some(better) => now = better,
                None => break,
            }
        }
        now
    }

    /// Tries each sibling of a law in its place, started from its force. Applies where two or more effects
    /// leave little more than noise: which law of the family is right could not be decided while the others
    /// were missing.
    pub(crate) fn exchanged(&self, now: Fitted, candidates: usize) -> Fitted {
        let effects = current(&now);
        if effects.len() < 2 || now.score.fit > NEAR_NOISE {
            return now;
        }
        let base = now.model.without_effects();
        let siblings = |k: usize| {
            let own = &effects[k];
            let law = &own.entry.law;
            family(self.catalogue, &own.entry)
                .filter(|e| !law.has_memory() && e.id != own.entry.id && !law.simpler.contains(&e.id))
                .filter_map(|e| sibling_starts(&now.model, &now.cal, own, e))
                .flatten()
                .collect::<Vec<Effect>>()
        };
        let trials: Vec<Vec<Effect>> = (0..effects.len())
            .flat_map(|k| siblings(k).into_iter().map(move |e| (k, e)))
            .map(|(k, e)| replaced(&effects, k, e))
            .collect();
        let noise = self.noise;
        let fitted = |list: &Vec<Effect>| {
            let other = refitted(base.with_all(list).ok()?, &now, noise)?;
            stands(&other).then_some(other)
        };
        let others: Vec<Fitted> = trials.par_iter().filter_map(fitted).collect();
        let carries =
            |f: &Fitted| f.score.predictive.zip(now.score.predictive).is_none_or(|(a, b)| a < SAME_GAP * b);
        better(&now, others, candidates).filter(carries).unwrap_or(now)
    }

    /// Removes each effect, or replaces it by a simpler relative, as long as the model stays as good.
    pub(crate) fn simplified(&self, mut now: Fitted, candidates: usize) -> Fitted {
        'again: loop {
            let effects = current(&now);
            let base = now.model.without_effects();
            for k in 0..effects.len() {
                let mut trials: Vec<Vec<Effect>> = Vec::new();
                if effects.len() > 1 {
                    trials.push(
                        effects.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, e)| e.clone()).collect(),
                    );
                }
                for simpler in &effects[k].entry.law.simpler {
                    let Some(entry) = self.catalogue.iter().find(|e| e.id == *simpler) else { continue };
                    let relative = relative(&effects[k], entry);
                    if effects.iter().enumerate().any(|(j, e)| j != k && excludes(e, &relative)) {
                        continue;
                    }
                    trials.push(replaced(&effects, k, relative));
                }
                // Two effects whose sum is a single law of the catalogue.
                for entry in self.catalogue.iter().filter(|e| e.law.same_as.len() == 2) {
                    let j =
                        (0..effects.len()).find(|&j| j != k && effects[j].entry.id == entry.law.same_as[1]);
                    let Some(j) = j.filter(|_| effects[k].entry.id == entry.law.same_as[0]) else { continue };
                    let bodies = |e: &Effect| match &e.place.site {
                        Site::Force { acts, .. } => acts.iter().map(|a| a.0).collect(),
                        _ => vec![usize::MAX],
                    };
                    if bodies(&effects[k]) != bodies(&effects[j]) {
                        continue;
                    }
                    let mut list: Vec<Effect> = effects
                        .iter()
                        .enumerate()
                        .filter(|(i, _)| *i != k && *i != j)
                        .map(|(_, e)| e.clone())
                        .collect();
                    list.push(relative(&effects[k], entry));
                    trials.push(list);
                }
                // The same law on each of two bodies may be one law between them.
                for j in (0..effects.len()).filter(|&j| j != k && effects[j].entry.id == effects[k].entry.id)
                {
                    let between = format!("{}-{}", effects[k].place.at, effects[j].place.at);
                    let Some(place) = base.places().iter().find(|p| p.at == between) else { continue };
                    let one = Effect { place: place.clone(), ..effects[k].clone() };
                    let others = effects.iter().enumerate().filter(|(i, _)| *i != k && *i != j);
                    trials.push(others.map(|(_, e)| e.clone()).chain([one]).collect());
                }
                let (noise, model) = (self.noise, &now);
                let fitted: Vec<Fitted> =
                    trials.par_iter().filter_map(|list| refit_with(&base, model, list, noise)).collect();
                for simple in fitted {
                    let same = self.as_good(&simple, &now, candidates);
                    let by = Measure::of([&simple.score, &now.score], candidates);
                    let carries = simple
                        .score
                        .predictive
                        .zip(now.score.predictive)
                        .is_none_or(|(a, b)| a < SAME_GAP * b)
                        || !now.score.is_white()
                        || by.criterion(&simple.score) + SIMPLER < by.criterion(&now.score);
                    if same && carries && (simple.score.is_white() || !now.score.is_white()) {
                        now = simple;
                        continue 'again;
                    }
                }
            }
            return now;
        }
    }
}

/// The effects with another one in the place of the `k`-th.
fn replaced(effects: &[Effect], k: usize, other: Effect) -> Vec<Effect> {
    let mut list = effects.to_vec();
    list[k] = other;
    list
}

/// The best of some models of the same size, if it is better than `now` by more than chance.
fn better(now: &Fitted, others: Vec<Fitted>, candidates: usize) -> Option<Fitted> {
    let by = Measure::of(others.iter().chain([now]).map(|f| &f.score), candidates);
    let best = others.into_iter().min_by(|a, b| by.criterion(&a.score).total_cmp(&by.criterion(&b.score)));
    best.filter(|b| by.criterion(&b.score) + SIMPLER < by.criterion(&now.score))
}

/// Refits `now` with other effects. `None` if the cost is far higher after a few steps, or evidence rules an
/// effect out.
fn refit_with(base: &TrialModel, now: &Fitted, list: &[Effect], noise: &[Vec<f64>]) -> Option<Fitted> {
    let mut model = base.with_all(list).ok()?;
    now.starts(&mut model);
    let cost = if now.rests() { model.free_run_cost(noise) } else { model.segment_cost(noise, 1) }?;
    if cost > RACE * now.score.fit.powi(2).max(1.0) {
        return None;
    }
    let other = refitted(model, now, noise)?;
    stands(&other).then_some(other)
}

/// Fits part of the model `whole`, from the start states of its runs. With stops a fit over short segments
/// may end in a local minimum, so the free run is fitted from the same start too.
pub(crate) fn refitted(mut model: TrialModel, whole: &Fitted, noise: &[Vec<f64>]) -> Option<Fitted> {
    whole.starts(&mut model);
    let straight = if whole.rests() || whole.has_clearance() {
        Fitted::new(model.clone(), noise, Effort::Thorough).ok()
    } else {
        None
    };
    let long = Fitted::new(model, noise, Effort::Plain).ok();
    match (straight, long) {
        (Some(a), Some(b)) => Some(if a.score.fit < b.score.fit { a } else { b }),
        (a, b) => a.or(b),
    }
}
