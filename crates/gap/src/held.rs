//! Is it a missing effect, or a constant of the known part that is not what the spec says? A mass that is wrong by a few per cent bends a motion in a way that two or
//! three laws imitate; what was found is told together with the constant that would do instead.

use crate::draft::Draft;
use crate::effect::{Effect, Entry};
use crate::evidence::against;
use crate::fitted::{Fitted, current};
use crate::screen::screen;
use crate::search::{BEST, Measure, RACE, SIMPLER, WORTH, label, size};
use phisindy_learn::Effort;
use phisindy_phys::spec::{self, ConstantSpec};
use phisindy_phys::unit::Unit;
use phisindy_phys::{SourceId, splice};
use rayon::prelude::*;

/// A constant that is held may be off by this part.
const OFF: f64 = 0.3;
/// Models that are fitted in full.
const FITTED: usize = 6;

/// Constants beside which the catalogue is looked at anew.
const ANEW: usize = 2;

/// A constant as the spec has it.
struct Constant {
    name: String,
    unit: String,
    value: f64,
}

/// A constant that would do instead of what was found.
pub(crate) struct Instead {
    /// In words.
    pub(crate) text: String,
    /// Whether the data speak for it: it needs fewer numbers, and says more.
    pub(crate) much_better: bool,
}

/// The best model in which one constant that the spec holds is free, and at least one effect less is needed, if it explains the data as well as `last` does, or explains them where
/// `last` does not: in words. One number for one number says nothing new: a spring that is missing and a stiffness that is too small are one force.
pub(crate) fn held(
    last: &Fitted,
    catalogue: &[Entry],
    noise: &[Vec<f64>],
    candidates: usize,
) -> Option<Instead> {
    let effects = current(last);
    let base = last.draft.without_effects();
    let fewer = subsets(&effects, last.is_white());
    let constants: Vec<(Constant, Draft)> =
        constants(&base.text).into_iter().filter_map(|c| freed(&base, &c).map(|free| (c, free))).collect();
    let trials: Vec<(&Constant, &Draft, &Vec<Effect>)> =
        constants.iter().flat_map(|(c, free)| fewer.iter().map(move |effects| (c, free, effects))).collect();
    let looked = trials.into_par_iter().filter_map(|(constant, free, effects)| {
        let draft = free.with_all(effects).ok()?;
        Some((draft.glance(noise, 1)?, constant, draft))
    });
    let mut looked: Vec<(f64, &Constant, Draft)> = looked.collect();
    let least = looked.iter().map(|(look, ..)| *look).fold(f64::INFINITY, f64::min);
    looked.retain(|(look, ..)| *look <= RACE * least);
    // A free constant is a number like any other.
    let price = (last.cal.samples as f64).ln();
    let promise = |(look, _, d): &(f64, &Constant, Draft)| {
        last.cal.samples as f64 * (1.0 + look.ln()) + price * size(d) as f64
    };
    looked.sort_by(|a, b| promise(a).total_cmp(&promise(b)));
    looked.truncate(FITTED);
    let fitted = looked
        .into_par_iter()
        .filter_map(|(_, constant, draft)| Some((constant, Fitted::new(draft, noise, Effort::Plain).ok()?)));
    let mut fitted: Vec<(&Constant, Fitted)> = fitted.collect();
    let stands = |f: &Fitted| f.draft.effects.iter().all(|(e, ..)| against(f, e).is_none());
    let chosen = |fitted: &[(&Constant, Fitted)], strict: bool| -> Option<(f64, usize)> {
        let by = Measure::of(fitted.iter().map(|(_, f)| f).chain([last]), candidates);
        let simpler = |f: &Fitted| size(&f.draft) + 1 < size(&last.draft);
        let limit = |f: &Fitted| if last.explains() && simpler(f) { SIMPLER } else { -WORTH };
        let worse = fitted.iter().map(|(_, f)| by.score(f) + price - by.score(last));
        let found = worse.enumerate().map(|(k, worse)| (worse, k));
        found
            .filter(|(worse, k)| fitted[*k].1.explains() && *worse < limit(&fitted[*k].1))
            .filter(|(_, k)| !strict || stands(&fitted[*k].1))
            .min_by(|a, b| a.0.total_cmp(&b.0))
    };
    // Beside a constant that is wrong the search may have gone astray from the start.
    let blamed = chosen(&fitted, false).map(|(_, k)| fitted[k].0);
    if blamed.is_some() || !last.explains() {
        let looked = |c: &Constant| blamed.is_none_or(|blamed| blamed.name == c.name);
        fitted.extend(anew(constants.iter().filter(|(c, _)| looked(c)), catalogue, noise));
    }
    let (worse, k) = chosen(&fitted, true)?;
    let (constant, best) = fitted.swap_remove(k);
    let (_, found) = best.found(|p| p.name == constant.name).pop()?;
    let factor = Unit::parse(&constant.unit).map_or(1.0, |u| u.factor);
    let kept: Vec<(&str, &str)> = label(&best.draft, 0);
    let needless: Vec<String> = label(&last.draft, 0)
        .iter()
        .filter(|l| !kept.contains(l))
        .map(|(law, at)| format!("{law} at {at}"))
        .collect();
    let less =
        if needless.is_empty() { String::new() } else { format!(" without {}", needless.join(" and ")) };
    let own = label(&last.draft, 0);
    let other: Vec<String> =
        kept.iter().filter(|l| !own.contains(l)).map(|(law, at)| format!(" and {law} at {at}")).collect();
    let numbers = numbers(&best);
    let text = format!(
        "the known part may be wrong instead: with {} = {} (the spec says {}){} the model explains the data{less} (BIC {:.1} {}){numbers}: is that constant known so well?",
        constant.name,
        in_unit(found / factor, &constant.unit),
        in_unit(constant.value, &constant.unit),
        other.concat(),
        worse.abs(),
        if worse < 0.0 { "lower" } else { "higher" }
    );
    // One number for another is the same thing under another name.
    let simpler = size(&best.draft) + 1 < size(&last.draft);
    Some(Instead { text, much_better: simpler && worse < -WORTH })
}

/// What the effects of a model are then.
pub(crate) fn numbers(best: &Fitted) -> String {
    let parameters = &best.draft.case.system.parameters;
    let of = |name: &String| {
        let unit = parameters.iter().find(|p| p.name == *name).map_or("", |p| p.unit.as_str());
        let (_, value) = best.found(|p| p.name == *name).pop()?;
        Some(format!("{name} = {}", in_unit(value / Unit::parse(unit).map_or(1.0, |u| u.factor), unit)))
    };
    let all: Vec<String> = best.draft.effects.iter().flat_map(|(_, names, _)| names).filter_map(of).collect();
    if all.is_empty() { String::new() } else { format!(", then {}", all.join(", ")) }
}

/// Models with one constant free and one effect: for the constants that alone leave least, the laws that promise most beside them.
fn anew<'c>(
    constants: impl Iterator<Item = &'c (Constant, Draft)>,
    catalogue: &[Entry],
    noise: &[Vec<f64>],
) -> Vec<(&'c Constant, Fitted)> {
    let constants: Vec<_> = constants.collect();
    let alone = constants
        .into_par_iter()
        .filter_map(|(c, free)| Some((c, Fitted::new(free.clone(), noise, Effort::Plain).ok()?)));
    let mut alone: Vec<(&Constant, Fitted)> = alone.collect();
    alone.sort_by(|(_, a), (_, b)| a.fit.total_cmp(&b.fit));
    alone.truncate(ANEW);
    let beside = |(constant, free): &(&'c Constant, Fitted)| -> Option<Vec<(&'c Constant, Draft)>> {
        let draft = free.settled().ok()?;
        let found = screen(&draft, &free.cal, catalogue, noise)?;
        let best = found.candidates.iter().take(BEST);
        Some(best.filter_map(|c| Some((*constant, draft.with(&c.effect).ok()?))).collect())
    };
    let drafts: Vec<(&Constant, Draft)> = alone.iter().filter_map(beside).flatten().collect();
    drafts
        .into_par_iter()
        .filter_map(|(c, draft)| Some((c, Fitted::new(draft, noise, Effort::Plain).ok()?)))
        .collect()
}

/// A number to five digits with its unit.
fn in_unit(value: f64, unit: &str) -> String {
    let digits = format!("{value:.4e}").parse::<f64>().unwrap_or(value);
    if unit.is_empty() { format!("{digits}") } else { format!("{digits} {unit}") }
}

/// The constants that a spec holds, but for those that are zero.
fn constants(text: &str) -> Vec<Constant> {
    let Ok((spec, _)) = spec::read(text, SourceId(0)) else { return vec![] };
    let of = |(name, constant): &(spec::Text, ConstantSpec)| match constant {
        ConstantSpec::Number { value, unit } if value.value != 0.0 => Some(Constant {
            name: name.value.clone(),
            unit: unit.as_ref().map_or(String::new(), |u| u.value.clone()),
            value: value.value,
        }),
        _ => None,
    };
    spec.constants.iter().filter_map(of).collect()
}

/// The model with one of its constants free.
fn freed(base: &Draft, constant: &Constant) -> Option<Draft> {
    let (a, b) = ((1.0 - OFF) * constant.value, (1.0 + OFF) * constant.value);
    let unit = if constant.unit.is_empty() { String::new() } else { format!("unit: {:?}, ", constant.unit) };
    let free = format!("(value: {:?}, {unit}within: ({:?}, {:?}))", constant.value, a.min(b), a.max(b));
    let text = splice::set(&base.text, &format!("constants.{}", constant.name), &free).ok()?;
    base.rebuilt(text, vec![], vec![]).ok()
}

/// Where some effects explain the data all choices of fewer of them; else the first of them, however many.
fn subsets(effects: &[Effect], explain: bool) -> Vec<Vec<Effect>> {
    let n = effects.len();
    let of = |bits: usize| (0..n).filter(|k| bits >> k & 1 == 1).map(|k| effects[k].clone()).collect();
    if explain {
        (0..(1usize << n) - 1).map(of).collect()
    } else {
        (0..=n).map(|k| effects[..k].to_vec()).collect()
    }
}
