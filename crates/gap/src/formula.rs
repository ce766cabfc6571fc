//! A law that is in no catalogue, found as a formula: where the search ended without an explanation.
//!
//! ```text
//! what is left --front, at each place--> shortest sums of products of atoms --shape--> laws --fit in full--> best
//!      ^                                                                                          |
//!      +------------------------- the motion is its run, which has no noise ----------------------+
//! ```
//!
//! A formula is a law like any other from there on: the same fit, the same contacts, the same Validate
//! records, the same evidence against it. It counts only if it passes what a law of the catalogue must pass.

mod atom;
mod expansion;
mod force;
mod front;
mod known_laws;
mod scale;
mod scope;
mod shape;

use crate::decisions::{
    FORMULA_PASSES, FORMULAS_FITTED, RACE, RESPONSE_ERROR, RIVALS, SEARCHES_AGAIN, WORTH,
};
use crate::evidence::stands;
use crate::model::{Fitted, Measure, TrialModel, current};
use crate::place::{Effect, Place, Site, fits};
use crate::plausibility::{cancelling, vetoed};
use crate::result::{Activity, MissingForce, PlacedLaw, Rival, StopReason, Veto, Vetoed};
use crate::screen::{PartialRegression, Target};
use crate::search::{Round, Search, Searched, label, placed, refitted, rival};
pub(crate) use expansion::expansion;
use expansion::short;
use force::Free;
use front::{Entry, Grammar, Selection, shortest, structure};
use known_laws::known_laws;
use phisindy_learn::{Calibration, Effort};
use phisindy_phys::{LawEntry, LawError, LawRole, Record};
use scale::Scale;
pub(crate) use scope::Scope;
use shape::{Shape, Term, formula, shapes};
use std::collections::BTreeSet;

/// The part of a search after which formulas are sought, where no law explains the data.
const FORMULAS: f64 = 0.7;
/// The id of a law that was found.
pub const DISCOVERED: &str = "discovered";

/// A formula at a place, ready for a fit.
struct Candidate {
    effect: Effect,
    shapes: Vec<Shape>,
    symbols: usize,
    length: f64,
    /// What it leaves beyond the noise, in the same units.
    excess: f64,
    scales: [Scale; 2],
}

/// A formula that was fitted in full.
struct Tried {
    fitted: Fitted,
    shapes: Vec<Shape>,
    symbols: usize,
    scales: [Scale; 2],
}

impl Tried {
    /// The fitted model, with the formula as a law that is told as such.
    fn discovered(self) -> Fitted {
        let mut last = self.fitted.chosen();
        if let Some(applied) = last.model.effects.last_mut()
            && let Ok(named) = named(&self.shapes, &self.scales, &applied.effect)
        {
            applied.effect.entry = named;
        }
        last
    }
}

/// The best formula beside a model.
struct Found {
    best: Tried,
    rivals: Vec<Rival>,
}

impl Search<'_> {
    /// A search that ended without an explanation, or with one that evidence speaks against, with a formula
    /// if there is one that explains the data: beside the model as it is, else beside the effects that were
    /// found.
    pub(crate) fn described(&mut self, searched: Searched) -> Searched {
        let (searched, linear) = self.with_changed_constants(searched);
        let explained = self.explained(&searched.last);
        let done = explained && !doubted(&searched.last, &searched.needed, self.noise);
        let ended =
            matches!(searched.stop, StopReason::Interrupted | StopReason::Inputs | StopReason::Pushes);
        if done && !ended {
            return self.in_place_of_many_numbers(searched);
        }
        if ended || self.left_by_input_noise(&searched.last) {
            return searched;
        }
        // A number of the model that is wrong is no law: most formulas would say the same with more words. A
        // spring or a damper beside a stiffness or a damping that is held is the same force, as it is among
        // the laws.
        let mut starts = vec![searched.base.clone()];
        if !explained && !searched.last.model.effects.is_empty() {
            starts.push(searched.last.clone());
        }
        for now in starts {
            let now = now.on_trial();
            let scopes = |model: &TrialModel| Scope::everywhere(model, linear);
            let Some(found) = self.formula_beside(&now, scopes) else { continue };
            let Found { best, rivals } = found;
            let before = now.model.effects.len();
            let expressions = expressions(&best.shapes, &best.scales);
            let last = self.answer(&now, best);
            // The laws that evidence ruled out are told beside the formula.
            let (mut rounds, vetoed) = match before {
                0 => (vec![], searched.rounds.into_iter().flat_map(|r| r.vetoed).collect()),
                _ => (searched.rounds, vec![]),
            };
            rounds.push(Round { before, rivals, vetoed: without_own(&last, vetoed), fitted: vec![] });
            return Searched {
                last,
                rounds,
                candidates: searched.candidates.max(expressions),
                stop: StopReason::White,
                ..searched
            };
        }
        if explained || linear {
            return searched;
        }
        let force = self.missing_force(&searched.base);
        Searched { force, ..searched }
    }

    /// A search that laws explain, compared with a formula at their place: the one with the better criterion is the answer, the
    /// other its rival. Three numbers fit many curves, and memory is shown only where no force of the motion does as well.
    /// Two numbers are as short as the formula would be.
    fn in_place_of_many_numbers(&mut self, mut searched: Searched) -> Searched {
        let effects = current(&searched.last);
        let Some(place) = place_of_many_numbers(&effects) else { return searched };
        let rest: Vec<Effect> = effects.iter().filter(|e| !e.place.is(&place)).cloned().collect();
        let plain = searched.base.model.with_all(&rest).ok();
        let Some(now) = plain.and_then(|model| refitted(model, &searched.last, self.noise)) else {
            return searched;
        };
        let (scope, now) = (Scope::at(&place, false), now.on_trial());
        let Some(Found { best, mut rivals }) = self.formula_beside(&now, |m| scope.of(m)) else {
            return searched;
        };
        let by = Measure::of([&searched.last.score, &best.fitted.score], 1);
        let of_laws = by.among(searched.candidates).criterion(&searched.last.score);
        let behind = by.criterion(&best.fitted.score) + structure(best.symbols) - of_laws;
        if behind > 0.0 {
            if let Some(round) = searched.rounds.last_mut() {
                round.rivals.push(rival(&best.fitted, rest.len(), behind));
            }
            return searched;
        }
        rivals.push(rival(&searched.last, 0, -behind));
        rivals.sort_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic));
        let candidates = searched.candidates.max(expressions(&best.shapes, &best.scales));
        let last = self.answer(&now, best);
        let vetoed = without_own(&last, searched.rounds.into_iter().flat_map(|r| r.vetoed).collect());
        let rounds = vec![Round { before: rest.len(), rivals, vetoed, fitted: vec![] }];
        Searched { last, rounds, candidates, ..searched }
    }

    /// The model with a formula, or with the laws of the catalogue that its terms are.
    fn answer(&self, now: &Fitted, best: Tried) -> Fitted {
        let laws = || {
            let effect = current(&best.fitted).pop()?;
            let laws = known_laws(&best.shapes, &effect.start, &best.scales, &effect.place, self.catalogue)?;
            let model = now.settled().with_all(&laws).ok()?;
            let model = model.starting_at(&best.fitted.estimates(|p| !p.each));
            let fitted = refitted(model, &best.fitted, self.noise)?;
            (self.explained(&fitted) && stands(&fitted)).then(|| fitted.chosen())
        };
        laws().unwrap_or_else(|| best.discovered())
    }

    /// A fitted model with the formula that explains the data, sought at one place; `None` if there is none.
    pub(crate) fn formula_at(&mut self, now: &Fitted, scope: &Scope) -> Option<Fitted> {
        let found = self.formula_beside(&now.clone().on_trial(), |model| scope.of(model))?;
        Some(found.best.discovered())
    }

    /// The force that a model lacks, at the place where it explains most; beside a few laws that do not
    /// explain the data it would be what these leave, which is no force of its own.
    fn missing_force(&mut self, now: &Fitted) -> Option<MissingForce> {
        if self.observer.tell(FORMULAS, Activity::Formulas) {
            return None;
        }
        let model = now.settled();
        let noise = response_noise(&model, self.noise);
        let regression = PartialRegression::new(&model, &now.cal, None, &noise, Target::AlongData)?;
        let at_place = |place: &Place| {
            let at = regression.kinematics(&model.system, place)?;
            force::missing_force(&regression, &at, &model.system, place)
        };
        let all: Vec<Free> = model.places().iter().filter_map(at_place).collect();
        let best = all.into_iter().min_by(|a, b| a.length.total_cmp(&b.length))?;
        (best.length < 0.0).then_some(best.force)
    }

    /// The best formula beside a fitted model; `None` if none explains the data and is worth its length.
    fn formula_beside(&mut self, now: &Fitted, scopes: impl Fn(&TrialModel) -> Vec<Scope>) -> Option<Found> {
        let model = now.settled();
        let coarse = response_noise(&model, self.noise);
        let mut tried: Vec<Tried> = Vec::new();
        let mut runs: Option<Calibration> = None;
        let value = |t: &Tried, by: Measure| by.criterion(&t.fitted.score) + structure(t.symbols);
        for _ in 0..FORMULA_PASSES {
            if self.observer.tell(FORMULAS, Activity::Formulas) {
                break;
            }
            let along = PartialRegression::new(&model, &now.cal, runs.as_ref(), &coarse, Target::AlongData);
            let Some(regression) = along else { break };
            let mut candidates = Vec::new();
            for scope in scopes(&model) {
                if self.observer.tell(FORMULAS, Activity::Formulas) {
                    break;
                }
                candidates.extend(candidates_at(&regression, &model, &scope));
            }
            let (first, longer) = promising(candidates, &tried);
            if (first.is_empty() && longer.is_empty())
                || self.observer.tell(FORMULAS, Activity::FittingFormulas)
            {
                break;
            }
            let before = best_of(&tried, &value);
            self.fit_formulas(&model, &first, &mut tried);
            if !best_of(&tried, &value).is_some_and(|best| self.explained(&tried[best].fitted)) {
                self.fit_formulas(&model, &longer, &mut tried);
            }
            let Some(best) = best_of(&tried, &value) else { break };
            if before == Some(best) {
                break;
            }
            runs = Some(tried[best].fitted.cal.clone());
        }
        // Fewer terms and limits shorten a formula; they do not explain what it does not. One that evidence
        // rules out gives way to the next.
        let mut again = 0;
        let best = loop {
            let best = best_of(&tried, &value)?;
            if !self.explained(&tried[best].fitted) {
                return None;
            }
            self.prune(&model, &mut tried, &value);
            let best = best_of(&tried, &value)?;
            if again == SEARCHES_AGAIN || !doubted(&tried[best].fitted, &[], self.noise) {
                break best;
            }
            tried.swap_remove(best);
            again += 1;
        };
        let by = Measure::of(tried.iter().map(|t| &t.fitted.score).chain([&now.score]), 1);
        let own = value(&tried[best], by);
        let gain = by.criterion(&now.score) - own;
        if !self.explained(&tried[best].fitted) || gain < WORTH {
            return None;
        }
        let best = tried.swap_remove(best);
        let before = now.model.effects.len();
        let rival = |t: &Tried| rival(&t.fitted, before, value(t, by) - own);
        let mut rivals: Vec<Rival> = tried.iter().map(rival).collect();
        rivals.retain(|r| r.delta_bic.is_finite());
        rivals.sort_by(|a, b| a.delta_bic.total_cmp(&b.delta_bic));
        // Of each formula its best fit.
        let mut seen = BTreeSet::from([label(&best.fitted.model, before)]);
        rivals.retain(|r| seen.insert(r.laws.clone()));
        rivals.truncate(RIVALS);
        Some(Found { best, rivals })
    }

    /// Tries the best formula without each of its terms, and with each atom replaced by what it is where its
    /// inner number has no say, from the numbers of its fit, until nothing is needless.
    fn prune(&self, model: &TrialModel, tried: &mut Vec<Tried>, value: &dyn Fn(&Tried, Measure) -> f64) {
        // A shorter one may have been fitted from numbers that led elsewhere: it is fitted again from here.
        let first = tried.len();
        while let Some(best) = best_of(tried, value) {
            let from = &tried[best];
            let terms = 0..from.shapes.len();
            let kinds = [(0, false), (1, false), (0, true), (1, true)];
            let limits =
                terms.clone().flat_map(|k| kinds.map(|(quantity, step)| at_limit(from, k, quantity, step)));
            let shorter = terms.map(|k| without(from, k)).chain(limits).flatten();
            let shorter: Vec<Candidate> = shorter.filter(|c| !has(&tried[first..], c)).collect();
            let before = tried.len();
            self.fit_formulas(model, &shorter, tried);
            if tried.len() == before || best_of(tried, value) == Some(best) {
                break;
            }
        }
    }

    /// Fits formulas in full and adds them to what was tried.
    fn fit_formulas(&self, model: &TrialModel, candidates: &[Candidate], tried: &mut Vec<Tried>) {
        let models: Vec<TrialModel> = candidates.iter().filter_map(|c| model.with(&c.effect).ok()).collect();
        for fitted in self.fit_race(models, RACE, 1, &mut vec![]) {
            let own = |c: &&Candidate| fitted.model.effects.last().is_some_and(|a| a.effect.same(&c.effect));
            let Some(c) = candidates.iter().find(own) else { continue };
            let (shapes, scales) = (c.shapes.clone(), c.scales.clone());
            tried.push(Tried { shapes, scales, symbols: c.symbols, fitted });
        }
    }
}

/// The noise of each column, and at least the error of the response: of clean data no formula would leave as
/// little.
pub(crate) fn response_noise(model: &TrialModel, noise: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let of = |(record, noise): (&Record, &Vec<f64>)| {
        let columns = (0..record.columns.len()).filter(|&k| record.columns[k].is_some()).zip(noise);
        columns.map(|(k, noise)| noise.max(RESPONSE_ERROR * record.deviation(k))).collect()
    };
    model.records.iter().zip(noise).map(of).collect()
}

/// The laws that are ruled out, without those of the answer.
fn without_own(last: &Fitted, mut vetoed: Vec<Vetoed>) -> Vec<Vetoed> {
    let own = placed(&last.model);
    vetoed.retain(|v| !own.contains(&v.law));
    vetoed
}

/// The place at which laws act that have more than two numbers together, and are no curve of the catalogue: several of
/// them, or one with memory.
fn place_of_many_numbers(effects: &[Effect]) -> Option<Place> {
    let forces = || effects.iter().filter(|e| matches!(e.place.site, Site::Force { .. }));
    let many = |place: &&Place| {
        let here: Vec<&Effect> = forces().filter(|e| e.place.is(place)).collect();
        let numbers: usize = here.iter().map(|e| e.entry.law.parameters.len()).sum();
        numbers > 2 && (here.len() > 1 || here.iter().any(|e| e.entry.law.has_memory()))
    };
    forces().map(|e| &e.place).find(many).cloned()
}

/// Whether evidence speaks against an effect of a model, other than that the records leave the numbers of a
/// law open that they need.
fn doubted(last: &Fitted, needed: &[PlacedLaw], noise: &[Vec<f64>]) -> bool {
    if last.model.effects.is_empty() {
        return false;
    }
    let Ok(last) = Fitted::new(last.settled(), noise, Effort::Errors) else { return false };
    let counts = |v: &Vetoed| !(matches!(v.why, Veto::Undetermined(_)) && needed.contains(&v.law));
    vetoed(&last).iter().any(|(_, v)| counts(v)) || cancelling(&last).is_some()
}

/// The formulas of a pass that are fitted in full: of those that are worth their length, the ones that may be
/// the right one. The response is not exact, and the right formula may leave as much as the shortest one
/// does; what is longer than it by more than that, and the evidence that counts, is another. Second, sums
/// that have all terms of a shorter formula and some more: they are fitted where no shorter one explains the
/// data.
fn promising(mut all: Vec<Candidate>, tried: &[Tried]) -> (Vec<Candidate>, Vec<Candidate>) {
    let best = all.iter().min_by(|a, b| a.length.total_cmp(&b.length));
    let Some(most) = best.map(|b| b.length + b.excess + 2.0 * WORTH) else { return (vec![], vec![]) };
    all.retain(|c| c.length < most.min(0.0));
    let within = |a: &Candidate, b: &Candidate| {
        a.shapes.len() < b.shapes.len()
            && a.length < b.length
            && a.effect.place.is(&b.effect.place)
            && a.shapes.iter().all(|s| b.shapes.contains(s))
    };
    let longer: Vec<bool> = all.iter().map(|b| all.iter().any(|a| within(a, b))).collect();
    let (mut first, mut more) = (vec![], vec![]);
    for (c, longer) in all.into_iter().zip(longer).filter(|(c, _)| !has(tried, c)) {
        if longer { more.push(c) } else { first.push(c) }
    }
    let some = |all| shortest(all, FORMULAS_FITTED, |c: &Candidate| c.shapes.len(), |c| c.length);
    (some(first), some(more))
}

/// Whether a formula was fitted at this place.
fn has(tried: &[Tried], c: &Candidate) -> bool {
    let at = |t: &Tried| t.fitted.model.effects.last().is_some_and(|a| a.effect.place.is(&c.effect.place));
    tried.iter().any(|t| t.shapes == c.shapes && at(t))
}

/// A fitted formula without its term `k`, from the numbers of the fit; `None` if it has no other.
fn without(from: &Tried, k: usize) -> Option<Candidate> {
    let effect = current(&from.fitted).pop()?;
    let mut shapes = from.shapes.clone();
    let first: usize = shapes[..k].iter().map(|s| 1 + s.inner().len()).sum();
    let gone = shapes.remove(k);
    if shapes.is_empty() {
        return None;
    }
    let mut start = effect.start.clone();
    start.drain(first..=first + gone.inner().len());
    written(shapes, Effect { start, ..effect }, &from.scales, (0.0, 0.0))
}

/// A fitted formula with the atom of a quantity (0 displacement, 1 velocity) of its term `k` replaced by its
/// limit, or by the step that it is for a small size.
fn at_limit(from: &Tried, k: usize, quantity: usize, step: bool) -> Option<Candidate> {
    let effect = current(&from.fitted).pop()?;
    let mut shapes = from.shapes.clone();
    let first: usize = shapes[..k].iter().map(|s| 1 + s.inner().len()).sum();
    let at = shapes[k].inner().iter().position(|(of, _)| *of == quantity)?;
    let (shape, power) = shapes[k].at_limit(quantity, step)?;
    shapes[k] = shape;
    let mut start = effect.start.clone();
    let inner = start.remove(first + 1 + at);
    start[first] *= inner.powi(power);
    // Twice the same term is one.
    let again = (0..shapes.len()).any(|j| j != k && shapes[j] == shapes[k] && shapes[k].inner().is_empty());
    if again { None } else { written(shapes, Effect { start, ..effect }, &from.scales, (0.0, 0.0)) }
}

/// The index of the best formula.
fn best_of(tried: &[Tried], value: &dyn Fn(&Tried, Measure) -> f64) -> Option<usize> {
    let by = Measure::of(tried.iter().map(|t| &t.fitted.score), 1);
    (0..tried.len()).min_by(|&a, &b| value(&tried[a], by).total_cmp(&value(&tried[b], by)))
}

/// The formulas of a place, shortest description first.
fn candidates_at(regression: &PartialRegression, model: &TrialModel, scope: &Scope) -> Vec<Candidate> {
    let place = &scope.place;
    let Some(at) = regression.kinematics(&model.system, place) else { return vec![] };
    // What no force of displacement and velocity explains here, no formula of them does.
    let free = force::missing_force(regression, &at, &model.system, place);
    if !free.is_some_and(|free| free.may_explain) {
        return vec![];
    }
    let grammar = Grammar::new(&at, scope);
    if model.stop.requested() {
        return vec![];
    }
    let ways: &[bool] = if at.rested() && scope.velocity { &[true, false] } else { &[false] };
    let mut all = Vec::new();
    for &sticks in ways {
        let Some(selection) = Selection::new(regression, &at, &grammar, model, sticks) else { continue };
        let found = selection.best();
        all.extend(found.into_iter().filter_map(|entry| candidate(entry, place, &grammar)));
    }
    all
}

/// An entry of the front as a law at its place.
fn candidate(entry: Entry, place: &Place, grammar: &Grammar) -> Option<Candidate> {
    let with = |(term, c): (&Term, &f64)| -> Vec<f64> {
        [*c].into_iter().chain(term.inner.iter().copied()).collect()
    };
    let shapes = entry.terms.iter().map(|t| t.shape).collect();
    let start = entry.terms.iter().zip(&entry.coefficients).flat_map(with).collect();
    let none = LawEntry::read(DISCOVERED, r#"(name: "none", force: "0")"#).ok()?;
    let effect = Effect { beside: entry.beside, ..Effect::new(none, place.clone(), start) };
    written(shapes, effect, &grammar.scales, (entry.length, entry.excess))
}

/// A sum of shapes as a law in the place of that of an effect, whose starts are its numbers.
fn written(
    shapes: Vec<Shape>,
    effect: Effect,
    scales: &[Scale; 2],
    (length, excess): (f64, f64),
) -> Option<Candidate> {
    let law = formula("formula", "a formula", "", &shapes, scales).ok()?;
    // The id says what it is, in the list of rivals.
    let entry = LawEntry { id: law.entry.law.force.clone()?, ..law.entry };
    let effect = Effect { entry, ..effect };
    let acts = fits(&effect.entry.law, &effect.place);
    acts.then(|| Candidate { effect, shapes, symbols: law.symbols, length, excess, scales: scales.clone() })
}

/// How many formulas of as many terms there are with no more symbols in each: among so many it was chosen.
fn expressions(of: &[Shape], scales: &[Scale; 2]) -> usize {
    let symbols = |shape: Shape| Some(formula("term", "a term", "", &[shape], scales).ok()?.symbols);
    let all: Vec<usize> = shapes(true).into_iter().filter_map(symbols).collect();
    let no_longer = |own: usize| all.iter().filter(|other| **other <= own).count();
    of.iter().filter_map(|shape| symbols(*shape)).fold(1, |n: usize, own| n.saturating_mul(no_longer(own)))
}

/// The law of a formula by the name under which it is reported, with the region in which it is known.
fn named(shapes: &[Shape], scales: &[Scale; 2], effect: &Effect) -> Result<LawEntry, LawError> {
    let law = &effect.entry.law;
    let range = |name: &str, scale: &Scale| {
        let (low, high) = scale.range();
        format!("{name} from {} to {}", short(low), short(high))
    };
    let mut known = Vec::new();
    known.extend(law.role(LawRole::Displacement).map(|x| range(x, &scales[0])));
    known.extend(law.role(LawRole::Velocity).map(|v| range(v, &scales[1])));
    let region =
        if known.is_empty() { String::new() } else { format!(" Known for {} (SI).", known.join(" and ")) };
    let about = format!("The shortest formula that explains the data in which it was found.{region}");
    Ok(formula(DISCOVERED, "discovered law", &about, shapes, scales)?.entry)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::result::Dependence;
    use crate::search::Observer;
    use crate::test_models::{fitted, model};
    use phisindy_phys::{Law, SourceId};

    /// A driven mass on a spring that lacks `truth`.
    fn rig(truth: &str) -> (TrialModel, Vec<Vec<f64>>) {
        let data = |seed: u32, role: &str| {
            format!(
                r#"Synthetic(truth: {{ "v": "{truth}" }}, start: {{ "x": 0.3, "v": 0.0 }}, duration: 40.0, step: 0.04, noise: Relative(0.02), seed: {seed}{role})"#
            )
        };
        model(&format!(
            r#"(states: {{ "x": "m", "v": "m/s" }}, constants: {{ "k": (1.0, "N/m"), "m": (1.0, "kg"), "c": (0.1, "N*s/m"), "F0": (1.0, "N"), "W": (0.7, "rad/s") }},
            known: {{ "x": "v", "v": "(-k*x - c*v + F0*cos(W*t) + F0*sin(1.9*W*t))/m" }}, inertia: {{ "v": "m" }}, unknown: {{}},
            data: [ {}, {} ])"#,
            data(1, ""),
            data(2, ", role: Validate")
        ))
    }

    /// The formula beside a model, as text.
    fn found(truth: &str) -> Option<String> {
        let (model, noise) = rig(truth);
        let now = fitted(model, &noise);
        let mut nobody = |_: f64, _: Activity| false;
        let found = Observer::during(&mut nobody, |observer| {
            let mut search = Search { catalogue: &[], noise: &noise, floor: 0.0, observer };
            search.formula_beside(&now, |model| Scope::everywhere(model, false))
        })?;
        found.best.fitted.model.effects.last().map(|a| a.effect.entry.id.clone())
    }

    #[test]
    fn a_law_of_no_catalogue_is_found_and_none_where_nothing_is_missing() {
        assert_eq!(found("-0.4*abs(v)^1.5*sgn(v)").as_deref(), Some("c*abs(v)^1.5*sgn(v)"));
        assert_eq!(found("-0.5*atan(x/0.2)").as_deref(), Some("c*atan(x/l)"));
        assert_eq!(found("0*x"), None);
    }

    /// Where three springs leave only noise, a spring of two numbers is the answer. A formula of known laws has their names.
    #[test]
    fn a_formula_takes_the_place_of_a_sum_of_laws() {
        let springs = [
            ("stiffness", include_str!("../../phys/laws/stiffness.ron")),
            ("cubic-stiffness", include_str!("../../phys/laws/cubic-stiffness.ron")),
            ("quintic-stiffness", include_str!("../../phys/laws/quintic-stiffness.ron")),
        ];
        let of = |truth: &str| {
            let spec = r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "N/m"), "m": (1.0, "kg"), "c": (0.1, "N*s/m"), "F0": (0.6, "N"), "W": (0.7, "rad/s") },
                known: { "x": "v", "v": "(-k*x - c*v + F0*cos(W*t) + F0*sin(1.9*W*t))/m" }, inertia: { "v": "m" }, unknown: {},
                data: [ Synthetic(truth: { "v": "TRUTH" }, start: { "x": 0.3, "v": 0.0 }, duration: 60.0, step: 0.05, noise: Relative(0.02), seed: 1) ])"#;
            let gap = crate::test_models::found(&spec.replace("TRUTH", truth), &springs);
            let mut all: Vec<_> = gap.steps.iter().filter_map(|s| s.effect.entry.law.force.clone()).collect();
            all.sort_unstable();
            all
        };
        assert_eq!(of("-0.6*atan(x/0.7)"), ["c*atan(x/l)"]);
        assert_eq!(of("-0.4*x - 0.3*x^3"), ["dk*x", "k3*x^3"]);
    }

    /// What the missing force depends on.
    fn depends(truth: &str) -> Option<Dependence> {
        let (model, noise) = rig(truth);
        let now = fitted(model, &noise);
        let mut nobody = |_: f64, _: Activity| false;
        let force = Observer::during(&mut nobody, |observer| {
            let mut search = Search { catalogue: &[], noise: &noise, floor: 0.0, observer };
            search.missing_force(&now)
        })?;
        Some(force.on)
    }

    #[test]
    fn what_a_force_depends_on_is_told() {
        assert_eq!(depends("-0.3*sgn(v)"), Some(Dependence::Velocity));
        assert_eq!(depends("-0.5*x^3"), Some(Dependence::Displacement));
        assert_eq!(depends("-0.03*t*v"), Some(Dependence::Time));
    }

    /// A damper is one of few formulas of its length, a product one of many.
    #[test]
    fn longer_formulas_are_chosen_among_more() {
        let scales = [vec![-1.0, 0.5, 2.0], vec![-0.4, 0.1, 0.3]].map(|v| Scale::new(&[v]));
        let all = shapes(true);
        let plain = all.iter().find(|s| s.displacement.is_none() && s.velocity.is_some()).expect("a damper");
        let product =
            all.iter().find(|s| s.displacement.is_some() && s.velocity.is_some()).expect("a product");
        let count = |of: &[Shape]| expressions(of, &scales);
        assert!(count(&[*plain]) < 10 && count(&[*product]) > 10);
        assert_eq!(count(&[*plain, *product]), count(&[*plain]) * count(&[*product]));
    }

    /// Every shape is a law that the check accepts, its units included.
    #[test]
    fn every_shape_is_a_law() {
        let scales = [vec![-1.0, 0.5, 2.0], vec![-0.4, 0.1, 0.3]].map(|v| Scale::new(&[v]));
        let all = shapes(true);
        for shape in &all {
            let law = formula("a", "A law", "", &[*shape, all[1]], &scales).expect("a law");
            let checked = Law::checked(&law.entry.text, SourceId(0));
            assert!(checked.is_ok(), "{}: {:?}", law.entry.text, checked.err());
        }
        assert!(all.len() > 100, "{}", all.len());
    }
}
