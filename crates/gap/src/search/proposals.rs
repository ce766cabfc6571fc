//! The trials of a round: models with one or two more effects, from starts that a fit can use.

use super::task::Search;
use crate::decisions::{FITTED_IN_FULL, LEADERS, NEUTRAL, RESTS_BELOW, SEEDED_STRIDE, STARTS_WITH_MEMORY};
use crate::model::{Fitted, TrialModel, current, values};
use crate::place::{Effect, Place, Site, is_force};
use crate::screen::{Candidate, Screening, excludes, sibling_starts};
use phisindy_expr::{Scratch, Tape};
use phisindy_phys::spec::Role;
use phisindy_phys::{LawEntry, LawParameter};
use phisindy_signal::standard_deviation;
use rayon::prelude::*;

impl Search<'_> {
    /// The best laws for a model that comes to rest, ranked by the cost of free runs after a few fit steps:
    /// the linear response does not describe stops.
    pub(crate) fn ranked_by_free_run(&self, model: &TrialModel, screening: &Screening) -> Vec<Vec<Effect>> {
        let mut all: Vec<(f64, Effect)> = screening
            .candidates
            .par_iter()
            .filter_map(|c| {
                let starts = [&c.effect].into_iter().chain(&c.others).map(neutral);
                let costed = starts.filter_map(|e| {
                    let d = model.with(&e).ok()?;
                    Some((d.free_run_cost(self.noise)?, e))
                });
                costed.min_by(|a, b| a.0.total_cmp(&b.0))
            })
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.into_iter().take(FITTED_IN_FULL).map(|(_, e)| vec![e]).collect()
    }

    /// The laws with static friction at each body that rests in a record: it is at least the largest known force there. A
    /// regression along the motion shows only kinetic friction, which is less.
    pub(crate) fn static_friction(&self, model: &TrialModel) -> Vec<TrialModel> {
        let mut all = Vec::new();
        for place in model.places() {
            let Some(load) = load_at_rest(model, place) else { continue };
            for entry in self.catalogue.iter().filter(|e| model.takes(&e.law, place)) {
                let levels = entry.law.static_levels();
                let start = |(k, (_, p)): (usize, &(String, LawParameter))| match is_force(&p.unit) {
                    true if levels.contains(&k) => load,
                    true => 0.5 * load,
                    false => 0.0_f64.clamp(p.within.0, p.within.1),
                };
                let start = entry.law.parameters.iter().enumerate().map(start).collect();
                let effect = Effect::new(entry.clone(), place.clone(), start);
                if !levels.is_empty() && !model.effects.iter().any(|own| excludes(&own.effect, &effect)) {
                    all.extend(model.with(&effect));
                }
            }
        }
        all
    }

    /// Every law of the family of the leading friction law, started from the leader's fitted force.
    pub(crate) fn siblings(&self, model: &TrialModel, leader: &Fitted) -> Vec<TrialModel> {
        let Some(last) = leader.model.effects.last() else { return vec![] };
        let effect = &last.effect;
        if effect.entry.law.has_memory() || leader.model.effects.len() != model.effects.len() + 1 {
            return vec![];
        }
        let sibling = Effect {
            start: values(leader, &last.names, &effect.start),
            beside: leader.estimates(|p| !p.each),
            ..effect.clone()
        };
        family(self.catalogue, &effect.entry)
            .filter(|e| e.id != effect.entry.id)
            .filter_map(|e| sibling_starts(&leader.model, &leader.cal, &sibling, e))
            .flatten()
            .filter_map(|e| model.with(&e).ok())
            .collect()
    }

    /// The family of the leading friction law at every other place, from the leader's fitted levels, where
    /// the segment cost is no higher. If two places move little against each other, the linear response sees
    /// the stops of both.
    pub(crate) fn at_other_places(&self, model: &TrialModel, singles: &[Fitted]) -> Vec<TrialModel> {
        let Some(leader) = singles.iter().find(|f| f.model.effects.len() == model.effects.len() + 1) else {
            return vec![];
        };
        let effects = current(leader);
        let [.., last] = &effects[..] else { return vec![] };
        let law = &last.entry.law;
        if law.family != "friction" || law.has_memory() {
            return vec![];
        }
        let cost = |d: &TrialModel| d.segment_cost(self.noise, 1).unwrap_or(f64::INFINITY);
        let here = cost(&leader.model);
        let free = |p: &&Place| model.takes(law, p) && p.at != last.place.at;
        let family: Vec<Effect> =
            family(self.catalogue, &last.entry).map(|entry| relative(last, entry)).collect();
        model
            .places()
            .iter()
            .filter(free)
            .flat_map(|place| family.iter().map(|e| Effect { place: place.clone(), ..e.clone() }))
            .filter(|e| !model.effects.iter().any(|own| excludes(&own.effect, e)))
            .filter(|e| !singles.iter().any(|f| f.model.effects.last().is_some_and(|own| own.effect.same(e))))
            .filter_map(|e| model.with(&e).ok())
            .collect::<Vec<TrialModel>>()
            .into_par_iter()
            .filter(|d| cost(d) <= here)
            .collect()
    }

    /// The model with each of its effects replaced by a law that contains it, or by the same law or a simpler
    /// relative with a level of its own in each record: one curve for all records may stand for levels that
    /// differ.
    pub(crate) fn richer(&self, model: &TrialModel, now: &Fitted) -> Vec<TrialModel> {
        let effects = current(now);
        let base = model.without_effects();
        let mut all = Vec::new();
        for k in 0..effects.len() {
            for entry in self
                .catalogue
                .iter()
                .filter(|e| e.law.simpler.contains(&effects[k].entry.id) && !e.law.has_memory())
            {
                let mut list = effects.clone();
                list[k] = relative(&effects[k], entry);
                all.extend(base.with_all(&list).ok());
            }
            if model.fit_records() < 2 {
                continue;
            }
            let simpler = &effects[k].entry.law.simpler;
            let relatives = self.catalogue.iter().filter(|e| simpler.contains(&e.id));
            let same = [effects[k].clone()].into_iter().chain(relatives.map(|e| relative(&effects[k], e)));
            for own in same.filter_map(|e| e.with_own_levels()) {
                let mut list = effects.clone();
                list[k] = own;
                all.extend(base.with_all(&list).ok());
            }
        }
        all
    }

    /// Pairs that a leading law of many parameters may stand for: each of its simpler relatives beside every
    /// law of one parameter that acts on the same body or on a sensor.
    pub(crate) fn decompositions(
        &self,
        model: &TrialModel,
        leader: &Fitted,
        screening: &Screening,
    ) -> Vec<Vec<Effect>> {
        let effects = current(leader);
        let [.., last] = &effects[..] else { return vec![] };
        if !is_composed(last) || effects.len() != model.effects.len() + 1 {
            return vec![];
        }
        let plain = self.catalogue.iter().filter(|e| last.entry.law.simpler.contains(&e.id));
        plain
            .map(|entry| relative(last, entry))
            .flat_map(|one| {
                let beside = |c: &&Candidate| {
                    (touches(&c.effect, &one) || c.effect.entry.law.property().is_some())
                        && c.effect.entry.law.parameters.len() == 1
                        && !excludes(&c.effect, &one)
                };
                let others: Vec<Effect> =
                    screening.candidates.iter().filter(beside).map(|c| neutral(&c.effect)).collect();
                others.into_iter().map(move |other| vec![one.clone(), other])
            })
            .collect()
    }

    /// The laws with memory where the leader of some fits, which has memory and does not explain the records,
    /// acts: each from the starts with the lowest segment costs. Segments whose memory starts anew fit nearly
    /// any of these laws, so their costs do not decide.
    pub(crate) fn with_memory(
        &self,
        model: &TrialModel,
        screening: &Screening,
        singles: &[Fitted],
    ) -> Vec<TrialModel> {
        let Some(leader) = singles.first().filter(|f| !f.score.explains()) else { return vec![] };
        let Some(last) = leader.model.effects.last().filter(|a| a.effect.entry.law.has_memory()) else {
            return vec![];
        };
        let wanted =
            |c: &&Candidate| c.effect.entry.law.has_memory() && c.effect.place.is(&last.effect.place);
        let starts: Vec<Vec<Effect>> = screening
            .candidates
            .par_iter()
            .filter(|c| wanted(c))
            .map(|c| {
                let all = [&c.effect].into_iter().chain(&c.others);
                let cost = |e: &Effect| model.with(e).ok()?.segment_cost(self.noise, SEEDED_STRIDE);
                let mut costed: Vec<(f64, Effect)> =
                    all.filter_map(|e| Some((cost(e)?, e.clone()))).collect();
                costed.sort_by(|a, b| a.0.total_cmp(&b.0));
                costed.into_iter().take(STARTS_WITH_MEMORY).map(|(_, e)| e).collect()
            })
            .collect();
        // From where a law was fitted already it would end at the same numbers.
        let fitted = |e: &&Effect| {
            let own = singles.iter().filter(|f| !f.cal.hopeless).filter_map(|f| f.model.effects.last());
            own.map(|a| &a.effect).any(|own| own.same(e) && own.start == e.start)
        };
        starts.iter().flatten().filter(|e| !fitted(e)).filter_map(|e| model.with(e).ok()).collect()
    }

    /// Each law from the start with the lowest segment cost.
    pub(crate) fn best_starts(&self, model: &TrialModel, laws: Vec<&Candidate>) -> Vec<Vec<Effect>> {
        laws.into_par_iter()
            .map(|c| {
                let cost = |e: &Effect| {
                    let d = model.with(e).ok()?;
                    d.segment_cost(self.noise, SEEDED_STRIDE)
                };
                let starts: Vec<&Effect> = [&c.effect].into_iter().chain(&c.others).collect();
                if starts.len() == 1 {
                    return vec![c.effect.clone()];
                }
                let costs: Vec<f64> = starts.par_iter().map(|e| cost(e).unwrap_or(f64::INFINITY)).collect();
                let best = (0..starts.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0);
                vec![starts[best].clone()]
            })
            .collect()
    }
}

/// The largest known force on a body while it rests in the Fit records; `None` where it hardly rests.
fn load_at_rest(model: &TrialModel, place: &Place) -> Option<f64> {
    let system = &model.system;
    let Site::Force { velocity, state: Some(state), .. } = &place.site else { return None };
    if system.states[*state].node != velocity.node {
        return None;
    }
    let mut graph = system.graph.clone();
    let force = system.inertia[*state].map_or(system.known[*state], |m| graph.mul(m, system.known[*state]));
    let tape = Tape::compile(&graph, &system.arguments(), &[force]).ok()?;
    let mut scratch = Scratch::<1>::new(&tape);
    let numbers: Vec<f64> = system.parameters.iter().map(|p| p.start).collect();
    let (mut load, mut slow, mut samples) = (0.0_f64, 0, 0);
    for record in model.smooth.iter().filter(|r| r.role == Role::Fit) {
        let speeds = record.columns[*state].as_deref()?;
        let size = standard_deviation(speeds);
        samples += speeds.len();
        for i in (0..speeds.len()).filter(|&i| speeds[i].abs() < RESTS_BELOW * size) {
            let states = record.columns[..system.states.len()].iter();
            let states = states.map(|c| c.as_ref().map_or(0.0, |c| c[i]));
            scratch.at(record.arguments_at(i, states, &numbers));
            slow += 1;
            load = load.max(scratch.output(0)[0].abs());
        }
    }
    // A sine is as slow as that for a twentieth of its time; this asks for two fifths.
    (slow as f64 >= 4.0 * RESTS_BELOW * samples as f64 && load > 0.0 && load.is_finite()).then_some(load)
}

/// The laws of a law's family without internal states; none if it has no family.
pub(crate) fn family<'a>(catalogue: &'a [LawEntry], of: &'a LawEntry) -> impl Iterator<Item = &'a LawEntry> {
    let name = &of.law.family;
    catalogue.iter().filter(move |e| !name.is_empty() && e.law.family == *name && !e.law.has_memory())
}

/// Whether two forces act on one body.
fn touches(a: &Effect, b: &Effect) -> bool {
    let acts = |e: &Effect| match &e.place.site {
        Site::Force { acts, .. } => acts.iter().map(|(state, _)| *state).collect(),
        _ => vec![],
    };
    acts(a).iter().any(|state| acts(b).contains(state))
}

/// One-parameter friction at every two places: the linear response does not describe two contacts that stick
/// alternately.
pub(crate) fn friction_pairs(screening: &Screening) -> Vec<Vec<Effect>> {
    let plain =
        |c: &&Candidate| c.effect.entry.law.family == "friction" && c.effect.entry.law.parameters.len() == 1;
    let all: Vec<Effect> = screening.candidates.iter().filter(plain).map(|c| neutral(&c.effect)).collect();
    let mut pairs = Vec::new();
    for (k, one) in all.iter().enumerate() {
        let others = all[k + 1..].iter().filter(|other| !excludes(one, other));
        pairs.extend(others.map(|other| vec![one.clone(), other.clone()]));
    }
    pairs
}

/// The best single laws, with their simpler relatives and, for the leaders, their families.
pub(crate) fn singles(screening: &Screening) -> Vec<&Candidate> {
    let mut chosen: Vec<&Candidate> = screening.candidates.iter().take(FITTED_IN_FULL).collect();
    let leaders: Vec<&Candidate> = chosen.clone();
    for (rank, leader) in leaders.iter().enumerate() {
        let law = &leader.effect.entry.law;
        for other in &screening.candidates {
            let here =
                other.effect.place.at == leader.effect.place.at && other.effect.load == leader.effect.load;
            let relative = law.simpler.contains(&other.effect.entry.id)
                || (rank < LEADERS && !law.family.is_empty() && other.effect.entry.law.family == law.family);
            if here && relative && !chosen.iter().any(|c| c.effect.same(&other.effect)) {
                chosen.push(other);
            }
        }
    }
    chosen
}

/// Whether a law may stand for two simple ones: it has as many parameters as two laws of one, or is the sum
/// of two laws.
pub(crate) fn is_composed(effect: &Effect) -> bool {
    effect.entry.law.parameters.len() >= 2 || !effect.entry.law.same_as.is_empty()
}

/// The effect with starts at which it has almost no influence, so that a fit continues from the model without
/// it.
pub(crate) fn neutral(effect: &Effect) -> Effect {
    let law = &effect.entry.law;
    let small = |(v, (_, p)): (&f64, &(String, LawParameter))| {
        if is_force(&p.unit) { (NEUTRAL * v).clamp(p.within.0, p.within.1) } else { *v }
    };
    let start = match law.property() {
        Some(_) if law.acting().is_some() => {
            law.neutral_input().map_or_else(|| effect.start.clone(), |v| vec![v])
        }
        Some("gain") => vec![1.0],
        Some(_) => vec![0.0],
        None => effect.start.iter().zip(&law.parameters).map(small).collect(),
    };
    Effect { start, beside: vec![], ..effect.clone() }
}

/// Another law at the same place, started from the level of the first one.
pub(crate) fn relative(effect: &Effect, entry: &LawEntry) -> Effect {
    let level = effect.start.first().copied().unwrap_or(0.0);
    let first = entry.law.parameters.first().map_or("", |(_, p)| p.unit.as_str());
    // Force levels start at the level of the other law, parameters of either sign at zero, speeds at a small
    // value.
    let start = entry
        .law
        .parameters
        .iter()
        .map(|(_, p)| match (p.unit == first && p.within.0 >= 0.0, p.within.0 < 0.0) {
            (true, _) => level.clamp(p.within.0, p.within.1),
            (_, true) => 0.0,
            _ => (p.within.0.max(1e-9) * p.within.1.min(1.0)).sqrt(),
        })
        .collect();
    Effect {
        entry: entry.clone(),
        place: effect.place.clone(),
        mirror: false,
        load: effect.load.clone(),
        pressed_by: effect.pressed_by.clone(),
        start,
        beside: effect.beside.clone(),
    }
}
