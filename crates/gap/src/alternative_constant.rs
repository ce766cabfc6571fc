//! Tests whether a wrong constant of the known part explains the data instead of missing effects. A mass that
//! is wrong by a few per cent changes a motion in a way that two or three laws can imitate. The result names
//! the constant that would explain the data as well.

use crate::changed_constants::changeable;
use crate::decisions::{
    CONSTANTS_FITTED, CONSTANTS_SCREENED, FITTED_IN_FULL, NEAR_NOISE, RACE, SIMPLER, WORTH,
};
use crate::evidence::stands;
use crate::model::{Fitted, Measure, TrialModel, current};
use crate::place::{Effect, Site};
use crate::result::{AlternativeConstant, NamedValue, PlacedLaw};
use crate::screen::{Candidate, Target, screen};
use crate::search::placed;
use phisindy_learn::Effort;
use phisindy_phys::LawEntry;
use phisindy_phys::unit::Unit;
use rayon::prelude::*;

/// A constant that explains the data in place of effects.
pub(crate) struct Instead {
    pub(crate) constant: AlternativeConstant,
    /// Whether the data prefer it clearly.
    pub(crate) much_better: bool,
    /// The model with its effects and the constant as the spec says, where that explains what `last` does not.
    pub(crate) without: Option<Fitted>,
}

/// The best model in which one fixed constant of the spec is free and at least one effect fewer is needed. It
/// must explain the data as well as `last` does, or explain them where `last` does not. A free constant in
/// place of a single parameter is no finding: a missing spring and a stiffness that is too small are the same
/// force.
pub(crate) fn alternative_constant(
    last: &Fitted,
    catalogue: &[LawEntry],
    noise: &[Vec<f64>],
    candidates: usize,
) -> Option<Instead> {
    let effects = current(last);
    let base = last.model.without_effects();
    let fewer = subsets(&effects, last.score.is_white());
    let constants: Vec<(Effect, TrialModel)> = changeable(&base.given.spec)
        .into_iter()
        .filter_map(|c| base.with(&c).ok().map(|free| (c, free.into_base())))
        .collect();
    let price = last.score.occam.of_coefficient(last.score.part(last.score.independent()));
    let mut fitted = lowest_cost(last, &constants, &fewer, price, noise);
    let chosen = |fitted: &[(&Effect, Fitted)], strict: bool| -> Option<(f64, usize)> {
        let by = Measure::of(fitted.iter().map(|(_, f)| &f.score).chain([&last.score]), candidates);
        let limit = |f: &Fitted| if last.score.explains() && simpler(f, last) { SIMPLER } else { -WORTH };
        // A free constant costs as much as any other parameter.
        let worse = fitted.iter().map(|(_, f)| by.criterion(&f.score) + price - by.criterion(&last.score));
        worse
            .enumerate()
            .map(|(k, worse)| (worse, k))
            .filter(|(worse, k)| fitted[*k].1.score.explains() && *worse < limit(&fitted[*k].1))
            .filter(|(_, k)| !strict || stands(&fitted[*k].1))
            .min_by(|a, b| a.0.total_cmp(&b.0))
    };
    // A wrong constant may have misled the search from the first round, so the catalogue is screened again.
    let blamed = chosen(&fitted, false).map(|(_, k)| fitted[k].0);
    if blamed.is_some() || !last.score.explains() {
        let eligible = |c: &Effect| blamed.is_none_or(|blamed| blamed.place.at == c.place.at);
        fitted.extend(screened_with(constants.iter().filter(|(c, _)| eligible(c)), catalogue, noise));
    }
    let (worse, k) = chosen(&fitted, true)?;
    let (constant, best) = fitted.swap_remove(k);
    let name = constant.place.at.clone();
    let Site::Constant { stated } = constant.place.site else { return None };
    let (_, value) = best.estimates(|p| p.name == name).pop()?;
    let unit = constant.entry.law.parameters.first()?.1.unit.clone();
    let factor = Unit::parse(&unit).map_or(1.0, |u| u.factor);
    let (kept, own) = (placed(&best.model), placed(&last.model));
    let apart = |a: &[PlacedLaw], b: &[PlacedLaw]| -> Vec<PlacedLaw> {
        a.iter().filter(|law| !b.contains(law)).cloned().collect()
    };
    // Another name for the same force is no better than it.
    let much_better = worse < -WORTH;
    let as_stated = || Fitted::new(base.with_all(&current(&best)).ok()?, noise, Effort::Plain).ok();
    let needed = !last.score.explains() && !best.model.effects.is_empty();
    let without = if needed { as_stated() } else { None };
    let without = without.filter(|f| f.score.explains() && stands(f));
    let constant = AlternativeConstant {
        constant: NamedValue { name, value: value / factor, unit },
        stated,
        other: apart(&kept, &own),
        needless: apart(&own, &kept),
        numbers: numbers(&best),
        delta_bic: worse,
    };
    Some(Instead { constant, much_better, without })
}

/// Whether the model with a free constant needs fewer parameters than `last`.
fn simpler(free: &Fitted, last: &Fitted) -> bool {
    free.model.size() + 1 < last.model.size()
}

/// Fits each free constant together with each choice of effects. Only the trials with the lowest segment cost
/// are fitted in full.
fn lowest_cost<'c>(
    last: &Fitted,
    constants: &'c [(Effect, TrialModel)],
    choices: &[Vec<Effect>],
    price: f64,
    noise: &[Vec<f64>],
) -> Vec<(&'c Effect, Fitted)> {
    let trials: Vec<(&Effect, &TrialModel, &Vec<Effect>)> = constants
        .iter()
        .flat_map(|(c, free)| choices.iter().map(move |effects| (c, free, effects)))
        .collect();
    let costed = trials.into_par_iter().filter_map(|(constant, free, effects)| {
        let model = free.with_all(effects).ok()?;
        Some((model.segment_cost(noise, 1)?, constant, model))
    });
    let mut costed: Vec<(f64, &Effect, TrialModel)> = costed.collect();
    let least = costed.iter().map(|(cost, ..)| *cost).fold(f64::INFINITY, f64::min);
    costed.retain(|(cost, ..)| *cost <= RACE * least);
    let promise = |(cost, _, m): &(f64, &Effect, TrialModel)| {
        last.cal.samples as f64 * (1.0 + cost.ln()) + price * m.size() as f64
    };
    costed.sort_by(|a, b| promise(a).total_cmp(&promise(b)));
    costed.truncate(CONSTANTS_FITTED);
    costed
        .into_par_iter()
        .filter_map(|(_, constant, model)| Some((constant, Fitted::new(model, noise, near_noise()).ok()?)))
        .collect()
}

/// Only what leaves little more than noise is of interest.
fn near_noise() -> Effort {
    Effort::Rival { most: NEAR_NOISE.powi(2), runs: false }
}

/// The fitted parameters of the effects of a model.
pub(crate) fn numbers(best: &Fitted) -> Vec<NamedValue> {
    let parameters = &best.model.system.parameters;
    let of = |name: &String| {
        let unit = parameters.iter().find(|p| p.name == *name).map_or("", |p| p.unit.as_str());
        let (_, value) = best.estimates(|p| p.name == *name).pop()?;
        let factor = Unit::parse(unit).map_or(1.0, |u| u.factor);
        Some(NamedValue { name: name.clone(), value: value / factor, unit: unit.to_owned() })
    };
    best.model.effects.iter().flat_map(|a| &a.names).filter_map(of).collect()
}

/// Fits models with one free constant and one effect. Takes the constants that leave the smallest gap alone,
/// and the leading laws of a screening for each.
fn screened_with<'c>(
    constants: impl Iterator<Item = &'c (Effect, TrialModel)>,
    catalogue: &[LawEntry],
    noise: &[Vec<f64>],
) -> Vec<(&'c Effect, Fitted)> {
    let constants: Vec<_> = constants.collect();
    let alone = constants
        .into_par_iter()
        .filter_map(|(c, free)| Some((c, Fitted::new(free.clone(), noise, Effort::Plain).ok()?)));
    let mut alone: Vec<(&Effect, Fitted)> = alone.collect();
    alone.sort_by(|(_, a), (_, b)| a.score.fit.total_cmp(&b.score.fit));
    alone.truncate(CONSTANTS_SCREENED);
    let beside = |(constant, free): &(&'c Effect, Fitted)| -> Option<Vec<(&'c Effect, TrialModel)>> {
        let model = free.settled();
        let screening = screen(&model, &free.cal, catalogue, noise, Target::AlongData)?;
        let (best, rest) = screening.candidates.split_at(FITTED_IN_FULL.min(screening.candidates.len()));
        // A richer law brings its simpler relatives along: beside it, one of them may be all that is missing.
        let simpler = |c: &&Candidate| best.iter().any(|b| c.effect.is_simpler_form_of(&b.effect));
        let best = best.iter().chain(rest.iter().filter(simpler));
        Some(best.filter_map(|c| Some((*constant, model.with(&c.effect).ok()?))).collect())
    };
    let models: Vec<(&Effect, TrialModel)> = alone.iter().filter_map(beside).flatten().collect();
    models
        .into_par_iter()
        .filter_map(|(c, model)| Some((c, Fitted::new(model, noise, near_noise()).ok()?)))
        .collect()
}

/// All proper subsets of the effects where these explain the data; otherwise the first 0, 1, ... n of them.
fn subsets(effects: &[Effect], explain: bool) -> Vec<Vec<Effect>> {
    let n = effects.len();
    let of = |bits: usize| (0..n).filter(|k| bits >> k & 1 == 1).map(|k| effects[k].clone()).collect();
    if explain {
        (0..(1usize << n) - 1).map(of).collect()
    } else {
        (0..=n).map(|k| effects[..k].to_vec()).collect()
    }
}
