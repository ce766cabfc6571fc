//! A law that is in no catalogue, found as a formula: where the search ended without an explanation.
//!
//! ```text
//! what is left --front, at each place--> shortest sums of products of atoms --shape--> laws --fit in full--> best
//!      ^                                                                                          |
//!      +------------------------- the motion is its run, which has no noise ----------------------+
//! ```
//!
//! A formula is a law like any other from there on: the same fit, the same contacts, the same Validate records, the
//! same evidence against it. It counts only if it passes what a law of the catalogue must pass.

mod atom;
mod front;
mod scale;
mod shape;

use crate::decisions::{FORMULA_ALPHABET, FORMULA_PASSES, FORMULAS_FITTED, RACE, RIVALS, WORTH};
use crate::model::{Fitted, Measure, TrialModel};
use crate::place::{Effect, Place, Site, fits};
use crate::result::{Activity, PlacedLaw, Rival, StopReason, Vetoed};
use crate::screen::{Footing, Ground};
use crate::search::{Round, Search, Searched};
use front::{Entry, Grammar, Selection, structure};
use phisindy_learn::Calibration;
use scale::Scale;
use shape::{Shape, formula};

/// The id of a law that was found.
pub(crate) const DISCOVERED: &str = "discovered";

/// A formula at a place, ready for a fit.
struct Candidate {
    effect: Effect,
    shapes: Vec<Shape>,
    symbols: usize,
    length: f64,
    scales: [Scale; 2],
}

/// A formula that was fitted in full.
struct Tried {
    fitted: Fitted,
    shapes: Vec<Shape>,
    symbols: usize,
    scales: [Scale; 2],
}

/// The best formula beside a model.
struct Found {
    best: Tried,
    rivals: Vec<Rival>,
    vetoed: Vec<Vetoed>,
}

impl Search<'_> {
    /// A search that ended without an explanation, with a formula if there is one that explains the data: beside the
    /// model as it is, else beside the effects that were found.
    pub(crate) fn described(&mut self, searched: Searched) -> Searched {
        if self.explained(&searched.last) || searched.stop == StopReason::Interrupted {
            return searched;
        }
        let mut starts = vec![searched.base.clone()];
        if !searched.last.model.effects.is_empty() {
            starts.push(searched.last.clone());
        }
        for now in starts {
            let Some(found) = self.formula_beside(&now) else { continue };
            let Found { best, rivals, vetoed } = found;
            let before = now.model.effects.len();
            let mut last = best.fitted;
            if let Some(applied) = last.model.effects.last_mut()
                && let Ok(named) = named(&best.shapes, &best.scales, &applied.effect)
            {
                applied.effect.entry = named;
            }
            let mut rounds = if before == 0 { vec![] } else { searched.rounds };
            rounds.push(Round { before, rivals, vetoed, fitted: vec![] });
            let expressions = FORMULA_ALPHABET.saturating_pow(best.symbols.min(12) as u32);
            return Searched {
                last,
                rounds,
                candidates: searched.candidates.max(expressions),
                stop: StopReason::White,
                ..searched
            };
        }
        searched
    }

    /// The best formula beside a fitted model; `None` if none explains the data and is worth its length.
    fn formula_beside(&mut self, now: &Fitted) -> Option<Found> {
        let model = now.settled();
        let mut tried: Vec<Tried> = Vec::new();
        let mut vetoed = Vec::new();
        let mut runs: Option<Calibration> = None;
        let value = |t: &Tried, by: Measure| by.criterion(&t.fitted.score) + structure(t.symbols);
        for _ in 0..FORMULA_PASSES {
            if (self.observe)(0.9, Activity::Formulas) {
                break;
            }
            let Some(ground) = Ground::new(&model, &now.cal, runs.as_ref(), self.noise) else { break };
            let mut candidates = Vec::new();
            for place in model.places().iter().filter(|p| matches!(p.site, Site::Force { .. })) {
                if (self.observe)(0.9, Activity::Formulas) {
                    break;
                }
                candidates.extend(candidates_at(&ground, &model, place));
            }
            candidates.sort_by(|a, b| a.length.total_cmp(&b.length));
            candidates.retain(|c| {
                let same = |t: &Tried| {
                    let last = t.fitted.model.effects.last().map(|a| &a.effect.place);
                    t.shapes == c.shapes && last.is_some_and(|p| p.is(&c.effect.place))
                };
                c.length < 0.0 && !tried.iter().any(same)
            });
            candidates.truncate(FORMULAS_FITTED);
            if candidates.is_empty() || (self.observe)(0.91, Activity::FittingFormulas) {
                break;
            }
            let models: Vec<TrialModel> = candidates.iter().filter_map(|c| model.with(&c.effect).ok()).collect();
            let before = best_of(&tried, &value);
            for fitted in self.fit_race(models, RACE, 1, &mut vetoed) {
                let own = |c: &&Candidate| {
                    fitted.model.effects.last().is_some_and(|a| a.effect.same(&c.effect))
                };
                let Some(c) = candidates.iter().find(own) else { continue };
                let (shapes, scales) = (c.shapes.clone(), c.scales.clone());
                tried.push(Tried { shapes, scales, symbols: c.symbols, fitted });
            }
            let Some(best) = best_of(&tried, &value) else { break };
            if before == Some(best) {
                break;
            }
            runs = Some(tried[best].fitted.cal.clone());
        }
        let best = best_of(&tried, &value)?;
        let by = Measure::of(tried.iter().map(|t| &t.fitted.score).chain([&now.score]), 1);
        let own = value(&tried[best], by);
        let gain = by.criterion(&now.score) - own;
        if !self.explained(&tried[best].fitted) || gain < WORTH {
            return None;
        }
        let mut rivals: Vec<Rival> = Vec::new();
        for (k, t) in tried.iter().enumerate().filter(|(k, _)| *k != best) {
            let Some(applied) = t.fitted.model.effects.last() else { continue };
            let _ = k;
            let laws = vec![PlacedLaw::of(&applied.effect)];
            rivals.push(Rival { laws, delta_bic: value(t, by) - own });
        }
        rivals.retain(|r| r.delta_bic.is_finite());
        rivals.sort_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic));
        rivals.truncate(RIVALS);
        Some(Found { best: tried.swap_remove(best), rivals, vetoed })
    }
}

/// The index of the best formula.
fn best_of(tried: &[Tried], value: &dyn Fn(&Tried, Measure) -> f64) -> Option<usize> {
    let by = Measure::of(tried.iter().map(|t| &t.fitted.score), 1);
    (0..tried.len()).min_by(|&a, &b| value(&tried[a], by).total_cmp(&value(&tried[b], by)))
}

/// The formulas of a place, shortest description first.
fn candidates_at(ground: &Ground, model: &TrialModel, place: &Place) -> Vec<Candidate> {
    let Some(at) = ground.footing(&model.system, place) else { return vec![] };
    let grammar = Grammar::new(&at);
    let ways: &[bool] = if at.rested() { &[true, false] } else { &[false] };
    let mut all = Vec::new();
    for &sticks in ways {
        let Some(selection) = Selection::new(ground, &at, &grammar, &model.system, sticks) else { continue };
        let found = selection.best();
        all.extend(found.into_iter().filter_map(|entry| candidate(entry, place, &at, &grammar)));
    }
    all
}

/// An entry of the front as a law at its place.
fn candidate(entry: Entry, place: &Place, _at: &Footing, grammar: &Grammar) -> Option<Candidate> {
    let shapes = entry.shapes();
    let law = formula("formula", "A formula", "", &shapes, &grammar.scales).ok()?;
    // The id says what it is, in the list of rivals.
    let id = law.entry.law.force.clone()?;
    let symbols = law.symbols;
    let entry_law = phisindy_phys::LawEntry { id, ..law.entry };
    if !fits(&entry_law.law, place) {
        return None;
    }
    let start = entry
        .terms
        .iter()
        .zip(&entry.coefficients)
        .flat_map(|(term, c)| [*c].into_iter().chain(term.inner.iter().copied()))
        .collect();
    let effect = Effect {
        entry: entry_law,
        place: place.clone(),
        mirror: false,
        load: None,
        pressed_by: None,
        start,
        beside: entry.beside,
    };
    Some(Candidate { effect, shapes, symbols, length: entry.length, scales: grammar.scales.clone() })
}

/// The law of a formula by the name under which it is reported, with the region in which it is known.
fn named(
    shapes: &[Shape],
    scales: &[Scale; 2],
    effect: &Effect,
) -> Result<phisindy_phys::LawEntry, phisindy_phys::LawError> {
    let law = &effect.entry.law;
    let range = |name: &str, scale: &Scale| {
        let (low, high) = scale.range();
        format!("{name} from {} to {}", short(low), short(high))
    };
    let mut known = Vec::new();
    known.extend(law.role(phisindy_phys::LawRole::Displacement).map(|x| range(x, &scales[0])));
    known.extend(law.role(phisindy_phys::LawRole::Velocity).map(|v| range(v, &scales[1])));
    let region = if known.is_empty() { String::new() } else { format!(" Known for {} (SI).", known.join(" and ")) };
    let about = format!("The shortest formula that explains the data in which it was found.{region}");
    Ok(formula(DISCOVERED, "Discovered law", &about, shapes, scales)?.entry)
}

/// A number with three digits.
fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.2e}").parse().unwrap_or(x);
    format!("{rounded}")
}
