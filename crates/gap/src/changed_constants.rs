//! Whether numbers of the spec changed: a joint that wore, a mass that was exchanged, a screw that came loose. The model
//! that is believed complete then needs no law, but another number.

use crate::decisions::{CHANGES_KEPT, CONSTANT_OFF, MOST_CHANGED, RACE, SIMPLER, SUBSTANTIAL, WORTH};
use crate::model::{Applied, Fitted, Measure, TrialModel};
use crate::place::{Effect, Place, Site};
use crate::result::{Activity, Rival, StopReason};
use crate::search::{Round, Search, Searched, rival, round_from};
use phisindy_learn::{Effort, SegmentFit};
use phisindy_phys::spec::{ConstantSpec, Spec, Text};
use phisindy_phys::unit::Unit;
use phisindy_phys::{Law, LawEntry};
use rayon::prelude::*;

/// Part of the work that is done when the constants are asked.
const CHANGED_ASKED: f64 = 0.85;

/// The id of the law that is no law: a constant of the spec has another value.
pub const CHANGED: &str = "changed-constant";

/// The fixed constants of a spec, except those that are zero, each as an effect: it has another value.
pub(crate) fn changeable(spec: &Spec) -> Vec<Effect> {
    let of = |(name, constant): &(Text, ConstantSpec)| match constant {
        ConstantSpec::Number { value, unit } if value.value != 0.0 => {
            changed(&name.value, value.value, unit.as_ref().map_or("", |u| &u.value))
        }
        _ => None,
    };
    spec.constants.iter().filter_map(of).collect()
}

/// The change of a constant, which starts at its stated value.
fn changed(name: &str, stated: f64, unit: &str) -> Option<Effect> {
    let factor = Unit::parse(unit).map_or(1.0, |u| u.factor);
    let (a, b) = (factor * stated / CONSTANT_OFF, CONSTANT_OFF * factor * stated);
    let within = (a.min(b), a.max(b));
    let text = format!(
        "(name: \"changed constant\", about: \"A number of the spec is not what it was.\", \
         parameters: {{ {name:?}: (unit: {unit:?}, within: {within:?}) }}, force: \"0\")"
    );
    let place = Place { at: name.to_owned(), site: Site::Constant { stated } };
    Some(Effect::new(LawEntry::read(CHANGED, &text).ok()?, place, vec![factor * stated]))
}

impl Search<'_> {
    /// The search with constants of the spec that changed in the place of what it found, if they say more; and whether
    /// one constant alone explains the data, said or not.
    pub(crate) fn with_changed_constants(&mut self, searched: Searched) -> (Searched, bool) {
        let complete = searched.last.score.explains() && searched.last.model.effects.is_empty();
        if complete
            || searched.stop == StopReason::Interrupted
            || self.observer.tell(CHANGED_ASKED, Activity::Constants)
        {
            return (searched, false);
        }
        let mut searched = searched;
        let asked = searched.changed.take();
        let asked = asked.unwrap_or_else(|| changed_constants(&searched.base, self.noise));
        let Searched { base, last, candidates, .. } = &searched;
        let alone = asked.explain() && asked.fits[0].model.effects.len() == 1;
        if !asked.explain() || !is_finding(&asked.fits[0], asked.all, last, *candidates) {
            searched.changed = Some(asked);
            return (searched, alone);
        }
        let mut fits = asked.fits;
        let changed = fits.remove(0);
        let mut round = round_from(0, base, &changed, &fits, vec![], *candidates);
        round.rivals.extend(other_kinds((last, &searched.rounds, *candidates), &changed, asked.all));
        let rounds = vec![round];
        (Searched { last: changed, rounds, stop: StopReason::White, needed: vec![], ..searched }, alone)
    }
}

/// What other values of the constants of a spec explain.
pub(crate) struct ChangedConstants {
    /// How many constants may have one.
    all: usize,
    /// The models that explain the data, best first; the nearest one, where none does.
    fits: Vec<Fitted>,
}

impl ChangedConstants {
    /// Whether other values explain the data.
    pub(crate) fn explain(&self) -> bool {
        self.fits.first().is_some_and(|f| f.score.explains())
    }

    /// The nearest model, and how many constants there are.
    pub(crate) fn nearest(&self) -> Option<(&Fitted, usize)> {
        Some((self.fits.first()?, self.all))
    }
}

/// The models in which a few constants of the spec have other values and nothing is added. Constants are freed one after the other beside the few choices that leave
/// least; models with more of them than needed are not tried.
pub(crate) fn changed_constants(of: &Fitted, noise: &[Vec<f64>]) -> ChangedConstants {
    let base = of.model.without_effects();
    let all = changeable(&base.given.spec);
    let (mut least, mut nearest) = (f64::INFINITY, vec![]);
    let mut from = vec![base];
    for _ in 0..MOST_CHANGED {
        let mut models: Vec<TrialModel> = Vec::new();
        for model in &from {
            for change in all.iter().filter(|e| !model.effects.iter().any(|a| a.effect.same(e))) {
                let more = model.with(change).ok();
                models.extend(more.filter(|m| !models.iter().any(|other| changes(other) == changes(m))));
            }
        }
        let begun = |m: TrialModel| m.segment_fit(noise).map(|segments| (segments, m));
        let mut begun: Vec<(SegmentFit, TrialModel)> = models.into_par_iter().filter_map(begun).collect();
        begun.sort_by(|(a, _), (b, _)| a.cost.total_cmp(&b.cost));
        // A run leaves no less than its segments: what leaves far more than noise there explains nothing.
        let may_explain = begun.partition_point(|(segments, _)| segments.cost <= RACE);
        begun.truncate(may_explain.max(CHANGES_KEPT));
        let fit = |(segments, m): (SegmentFit, TrialModel)| {
            Fitted::from(m, Some(&segments), noise, Effort::Plain).ok()
        };
        let mut fits: Vec<Fitted> = begun.into_par_iter().filter_map(fit).collect();
        fits.sort_by(|a, b| a.score.fit.total_cmp(&b.score.fit));
        if fits.iter().any(|f| f.score.explains()) {
            fits.retain(|f| f.score.explains());
            return ChangedConstants { all: all.len(), fits };
        }
        // A choice that helps little is none.
        let Some(best) = fits.first().filter(|f| f.score.fit * SUBSTANTIAL <= least) else { break };
        (least, nearest) = (best.score.fit, vec![best.clone()]);
        fits.truncate(CHANGES_KEPT);
        from = fits.iter().map(Fitted::settled).collect();
    }
    ChangedConstants { all: all.len(), fits: nearest }
}

/// The laws that a search of one round found, as rivals of changed constants. The search ended with `last`, and so many
/// constants could have changed.
pub(crate) fn other_kinds(
    (last, rounds, candidates): (&Fitted, &[Round], usize),
    changed: &Fitted,
    constants: usize,
) -> Vec<Rival> {
    let [round] = rounds else { return vec![] };
    let by = Measure::of([&changed.score, &last.score], candidates);
    let behind = by.criterion(&last.score) - by.among(constants).criterion(&changed.score);
    let other = |r: &Rival| {
        let mut laws = r.model.iter().flat_map(|m| m.effects.iter().map(|a| &a.effect.entry.law));
        laws.any(|law| is_other_than_a_number(law))
    };
    // More of a law that the model has is that law with another number; a sensor or an input is another cause.
    let force = |a: &Applied| a.effect.entry.law.sensor.is_none() && a.effect.entry.law.input.is_none();
    let same = is_same_force(last.score.fit, changed.score.fit) && last.model.effects.iter().all(force);
    let all = round.rivals.iter().cloned().chain((!same).then(|| rival(last, 0, 0.0)));
    all.filter(other).map(|r| Rival { delta_bic: r.delta_bic + behind, ..r }).collect()
}

/// Whether two models with these gaps have the same force: the gaps differ by rounding.
pub(crate) fn is_same_force(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 1e-6
}

/// Whether a law is more than another number of a spring or a damper: a linear force is the same thing.
pub(crate) fn is_other_than_a_number(law: &Law) -> bool {
    law.is_curve() || law.has_memory() || law.sensor.is_some() || law.input.is_some()
}

/// The names of the constants that changed, in order.
fn changes(model: &TrialModel) -> Vec<&str> {
    let mut all: Vec<&str> = model.effects.iter().map(|a| a.effect.place.at.as_str()).collect();
    all.sort_unstable();
    all
}

/// Whether a model with changed constants that explains the data says more than `last`. In place of as many numbers of
/// a force that is linear it does not: a missing spring and a stiffness that is too small are the same force. But a curve
/// that the model holds already is that curve with another number.
pub(crate) fn is_finding(changed: &Fitted, constants: usize, last: &Fitted, candidates: usize) -> bool {
    let by = Measure::of([&changed.score, &last.score], candidates);
    // There are as many choices as constants, and as many as laws at places.
    let worse = by.among(constants).criterion(&changed.score) - by.criterion(&last.score);
    let curve = last.model.effects.iter().any(|a| a.effect.entry.law.is_curve());
    let simpler = changed.model.size() < last.model.size() || curve;
    worse < if simpler { SIMPLER } else { -WORTH }
}
