//! Whether numbers of the spec changed: a joint that wore, a mass that was exchanged, a screw that came loose. The model
//! that is believed complete then needs no law, but another number.

use crate::decisions::{CONSTANT_OFF, MOST_CHANGED, SIMPLER, SUBSTANTIAL, WORTH};
use crate::model::{Fitted, Measure, TrialModel};
use crate::place::{Effect, Place, Site};
use phisindy_learn::Effort;
use phisindy_phys::LawEntry;
use phisindy_phys::spec::{ConstantSpec, Spec, Text};
use phisindy_phys::unit::Unit;
use rayon::prelude::*;

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
    Some(Effect {
        entry: LawEntry::read(CHANGED, &text).ok()?,
        place: Place { at: name.to_owned(), site: Site::Constant { stated } },
        mirror: false,
        load: None,
        pressed_by: None,
        start: vec![factor * stated],
        beside: vec![],
    })
}

/// The model in which a few constants of the spec have other values and nothing is added, and those with other
/// constants that explain the data too. `None` unless it explains the data and says more than `last`. Constants are
/// freed one after the other, each the one that leaves least.
pub(crate) fn changed_constants(
    last: &Fitted,
    noise: &[Vec<f64>],
    candidates: usize,
) -> Option<(Fitted, Vec<Fitted>)> {
    let base = last.model.without_effects();
    let all = changeable(&base.given.spec);
    let mut found: Option<Fitted> = None;
    for _ in 0..MOST_CHANGED {
        let from = found.as_ref().map_or_else(|| base.clone(), Fitted::settled);
        let new = |e: &&Effect| !from.effects.iter().any(|a| a.effect.same(e));
        let models: Vec<TrialModel> = all.iter().filter(new).filter_map(|e| from.with(e).ok()).collect();
        let fits = models.into_par_iter().filter_map(|m| Fitted::new(m, noise, Effort::Plain).ok());
        let mut fits: Vec<Fitted> = fits.collect();
        fits.sort_by(|a, b| a.score.fit.total_cmp(&b.score.fit));
        if fits.is_empty() {
            return None;
        }
        let best = fits.remove(0);
        if best.score.explains() {
            fits.retain(|f| f.score.explains());
            return is_finding(&best, last, candidates).then_some((best, fits));
        }
        if found.is_some_and(|before| best.score.fit * SUBSTANTIAL > before.score.fit) {
            return None;
        }
        found = Some(best);
    }
    None
}

/// Whether a model with changed constants that explains the data says more than `last`. In place of as many numbers of
/// a force that is linear it does not: a missing spring and a stiffness that is too small are the same force. But a curve
/// that the model holds already is that curve with another number.
fn is_finding(changed: &Fitted, last: &Fitted, candidates: usize) -> bool {
    let by = Measure::of([&changed.score, &last.score], candidates);
    let worse = by.criterion(&changed.score) - by.criterion(&last.score);
    let curve = last.model.effects.iter().any(|a| a.effect.entry.law.is_curve());
    let simpler = changed.model.size() < last.model.size() || curve;
    !last.score.explains() || worse < if simpler { SIMPLER } else { -WORTH }
}
