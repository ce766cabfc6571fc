//! Find, name, add, refit, until nothing but noise is left or nothing in the catalogue helps.

use crate::draft::Draft;
use crate::effect::{Effect, Entry, fits};
use crate::fitted::{FAR_OFF, Fitted};
use crate::place::{Place, Site, places};
use crate::screen::{Candidate, Screening, excludes, imitated, screen};
use phisindy_learn::{Effort, approach, glance};
use rayon::prelude::*;

/// Effects in one model at most.
const EFFECTS: usize = 4;
/// Singles, and pairs, that are fitted in full.
const BEST: usize = 6;
/// What a new effect must bring.
const WORTH: f64 = 10.0;
/// A simpler description within this is preferred.
const SIMPLER: f64 = 3.0;
/// An effect that leaves more than this part of the gap on Validate records explains nothing of note.
const SHRINK: f64 = 0.98;
/// A richer law must lower the gap on Validate records to this part, where something is left that is not noise.
const RICHER: f64 = 0.95;
/// A round that leaves more than this part of a gap that is far above the noise is a weak one; after two of them nothing in the catalogue helps.
const FAR: f64 = 0.8;
/// ... where a gap is that is above this.
const LITTLE: f64 = 5.0;
/// Of the segments that a glance looks at, the part that tells the starts of one law apart: every third.
const SEEDED: usize = 3;
/// A model far from the noise that brings the gap on Fit records to this part is on the way, whatever Validate records say.
const HALF: f64 = 0.5;
/// How often a family of friction laws is tried again from a new leader.
const FAMILY: usize = 2;
/// Gaps on Validate records within this factor are the same.
const ALIKE: f64 = 1.02;
/// In the race a model that is this many times worse than the best is out.
const RACE: f64 = 3.0;
/// Where there are few, and a first look at short segments may be wrong about what holds at rest, all are fitted.
const ALL: f64 = f64::INFINITY;

/// A description that was fitted and not chosen.
#[derive(Clone, Debug)]
pub(crate) struct Rival {
    pub(crate) law: String,
    pub(crate) at: String,
    /// By how much its criterion is worse than that of the chosen one.
    pub(crate) worse: f64,
}

/// A round of the search.
#[derive(Clone, Debug)]
pub(crate) struct Round {
    /// How many effects the model had before.
    pub(crate) before: usize,
    pub(crate) rivals: Vec<Rival>,
    /// Laws that evidence outside the fit speaks against, and why.
    pub(crate) vetoed: Vec<(String, String)>,
}

/// How a search ended.
pub(crate) struct Searched {
    pub(crate) base: Fitted,
    pub(crate) last: Fitted,
    pub(crate) rounds: Vec<Round>,
    /// How many effects there were to choose from.
    pub(crate) candidates: usize,
    /// Whether it was stopped.
    pub(crate) stopped: bool,
}

/// What a comparison of models goes by: how many effects there were to choose from, and which part of the samples counts as independent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Measure {
    pub(crate) candidates: usize,
    pub(crate) independent: f64,
}

impl Measure {
    /// The measure for some models: the residual of the best of them says how many samples count.
    pub(crate) fn of<'f>(all: impl IntoIterator<Item = &'f Fitted>, candidates: usize) -> Measure {
        let best = all.into_iter().min_by(|a, b| a.fit.total_cmp(&b.fit));
        Measure { candidates, independent: best.map_or(1.0, Fitted::independent) }
    }

    pub(crate) fn score(self, of: &Fitted) -> f64 {
        of.score(self.candidates, self.independent)
    }
}

/// What the search works with.
pub(crate) struct Search<'a> {
    pub(crate) catalogue: &'a [Entry],
    pub(crate) noise: &'a [Vec<f64>],
    /// Gap on Validate records below which nothing is added: what the rig repeats to.
    pub(crate) floor: f64,
    /// Hears of the progress, a fraction and what is being done; true to stop.
    pub(crate) hear: &'a mut dyn FnMut(f64, &str) -> bool,
    /// What evidence outside the fit says against an effect in a fitted model.
    pub(crate) veto: &'a (dyn Fn(&Fitted, &Effect) -> Option<String> + Sync),
}

impl Search<'_> {
    /// Runs the search from a model.
    pub(crate) fn run(&mut self, base: Draft) -> Result<Searched, String> {
        (self.hear)(0.02, "fitting what may move");
        let base = Fitted::new(base, self.noise, Effort::Plain)?;
        let mut now = base.clone();
        let mut rounds = Vec::new();
        let mut candidates = 1;
        let (mut stopped, mut weak) = (false, 0);
        while now.draft.effects.len() < EFFECTS && !now.is_white() {
            // Below what the rig repeats to only an effect that leaves nothing but noise shows that it was none of the rig's scatter.
            let below = now.validate.is_some_and(|v| v <= self.floor);
            if below && !rounds.is_empty() {
                break;
            }
            let part = 0.1 + 0.8 * (rounds.len() as f64 / EFFECTS as f64);
            stopped = (self.hear)(part, "looking at every law at every place");
            if stopped {
                break;
            }
            let draft = now.settled()?;
            let Some(found) = screen(&draft, &now.cal, self.catalogue, self.noise) else { break };
            candidates = candidates.max(found.candidates.len());
            (self.hear)(part + 0.03, "fitting the best of them");
            let Some((next, round)) = self.round(&draft, &now, &found, candidates) else { break };
            if below && !next.is_white() {
                break;
            }
            rounds.push(round);
            weak += usize::from(next.fit > LITTLE.max(FAR * now.fit));
            now = next;
            if weak > 1 {
                break;
            }
        }
        Ok(Searched { base, last: now, rounds, candidates, stopped })
    }

    /// One round: the best single, or the best pair, or nothing.
    fn round(
        &mut self,
        draft: &Draft,
        now: &Fitted,
        found: &Screening,
        candidates: usize,
    ) -> Option<(Fitted, Round)> {
        let before = draft.effects.len();
        let mut vetoed: Vec<(String, String)> = Vec::new();
        let added = |lists: Vec<Vec<Effect>>| -> Vec<Draft> {
            lists.iter().filter_map(|list| draft.with_all(list).ok()).collect()
        };
        let mut drafts = if now.rests() || now.strikes() {
            added(self.approached(draft, found))
        } else {
            added(self.seeded(draft, singles(found)))
        };
        drafts.extend(self.richer(draft, now));
        let mut singles = self.tried(drafts, RACE, candidates, &mut vetoed);
        if singles.first().is_some_and(|leader| !leader.is_white()) {
            let elsewhere = self.elsewhere(draft, &singles);
            singles.extend(self.tried(elsewhere, ALL, candidates, &mut vetoed));
            let by = Measure::of(&singles, candidates);
            singles.sort_by(|a, b| by.score(a).total_cmp(&by.score(b)));
        }
        // From each new leader its whole family once more: one slow curve is hard to reach from a regression, easy from its neighbour.
        for _ in 0..FAMILY {
            let Some(leader) = singles.first().map(|f| named(&f.draft)) else { break };
            let more = self.tried(self.siblings(draft, &singles), ALL, candidates, &mut vetoed);
            let by = Measure::of(singles.iter().chain(&more), candidates);
            singles.extend(more);
            singles.sort_by(|a, b| by.score(a).total_cmp(&by.score(b)));
            if named(&singles[0].draft) == leader {
                break;
            }
        }
        let best = preferred(&singles, candidates).filter(|best| self.worth(now, best, candidates)).cloned();
        // A law of many parameters may stand for two simple ones.
        let plain = |f: &Fitted| f.draft.effects[before..].iter().all(|(e, ..)| !is_composed(e));
        if let Some(best) = best.as_ref().filter(|b| b.is_white() && plain(b)) {
            let best = self.simplified(best.clone(), candidates);
            let best = self.exchanged(self.moved(best, candidates), candidates);
            return Some((best.clone(), round(before, &best, &singles, vetoed, candidates)));
        }
        let price = (now.cal.samples as f64).ln();
        // Two at once where greed could go wrong from the start; later rounds have their friction already.
        let wanted = if before == 0 { BEST } else { 0 };
        let mut pairs: Vec<Vec<Effect>> =
            found.pairs(price, wanted).into_iter().map(|(a, b)| vec![a.effect, b.effect]).collect();
        pairs.extend(singles.first().map_or(vec![], |leader| self.parted(draft, leader, found)));
        if wanted > 0 {
            pairs.extend(rubbing(found));
        }
        // Where one law explains everything, two can only be simpler.
        if let Some(enough) = best.as_ref().filter(|b| b.is_white()).map(|b| size(&b.draft)) {
            let parameters =
                |pair: &[Effect]| pair.iter().map(|e| e.entry.law.parameters.len()).sum::<usize>();
            pairs.retain(|pair| size(draft) + parameters(pair) <= enough);
        }
        (self.hear)(0.1 + 0.8 * (before as f64 + 0.5) / EFFECTS as f64, "fitting the best pairs");
        let pairs = self.tried(added(pairs), RACE, candidates, &mut vetoed);
        let pair = preferred(&pairs, candidates).filter(|p| self.worth(now, p, candidates)).cloned();
        // Two that nearly do may stand in wrong places.
        let pair = pair.map(|pair| if pair.is_white() { pair } else { self.moved(pair, candidates) });
        let settled = pair.as_ref().filter(|pair| !pair.is_white()).map(|pair| named(&pair.draft));
        let all: Vec<Fitted> = singles.into_iter().chain(pairs).collect();
        let chosen = match (best, pair) {
            (Some(single), Some(pair)) => {
                let by = Measure::of([&single, &pair], candidates);
                let better = by.score(&pair) + WORTH < by.score(&single);
                // A pair that does not explain everything is taken only where it says much more than one of its parts: greed goes on otherwise.
                let (own, both) = (label(&single.draft, before), label(&pair.draft, before));
                let much = pair.validate.zip(single.validate).is_none_or(|(p, s)| p < HALF * s)
                    || on_the_way(&single, &pair)
                    || !own.iter().all(|e| both.contains(e));
                if better && (pair.is_white() || much) { pair } else { single }
            }
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => return None,
        };
        let chosen = self.simplified(chosen, candidates);
        let chosen =
            if settled == Some(named(&chosen.draft)) { chosen } else { self.moved(chosen, candidates) };
        let chosen = self.exchanged(chosen, candidates);
        let by = Measure::of([&chosen, now], candidates);
        if chosen.draft.effects.len() <= before && by.score(&chosen) >= by.score(now) - WORTH {
            return None;
        }
        Some((chosen.clone(), round(before, &chosen, &all, vetoed, candidates)))
    }

    /// Whether a model is worth its price against another one.
    fn worth(&self, now: &Fitted, next: &Fitted, candidates: usize) -> bool {
        let by = Measure::of([now, next], candidates);
        let gain = by.score(now) - by.score(next);
        let carries = match (now.validate, next.validate) {
            (Some(before), Some(after)) => after < SHRINK * before || (next.is_white() && after < before),
            _ => true,
        };
        gain > WORTH && (carries || on_the_way(now, next))
    }

    /// The best laws for a model that comes to rest, each tried by a few steps of the fit itself: a linear response knows nothing of stops.
    fn approached(&self, draft: &Draft, found: &Screening) -> Vec<Vec<Effect>> {
        let mut all: Vec<(f64, Effect)> = found
            .candidates
            .par_iter()
            .filter_map(|c| {
                let starts = [&c.effect].into_iter().chain(&c.others).map(neutral);
                let looked = starts.filter_map(|e| {
                    let d = draft.with(&e).ok()?;
                    Some((approach(&d.case.system, &d.records, &d.smooth, self.noise)?, e))
                });
                looked.min_by(|a, b| a.0.total_cmp(&b.0))
            })
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.into_iter().take(BEST).map(|(_, e)| vec![e]).collect()
    }

    /// Every law of the family of the leading friction, started from what the leader found.
    fn siblings(&self, draft: &Draft, singles: &[Fitted]) -> Vec<Draft> {
        let Some(leader) = singles.first() else { return vec![] };
        let Some((effect, names, _)) = leader.draft.effects.last() else { return vec![] };
        let law = &effect.entry.law;
        if law.family.is_empty()
            || !law.internal.is_empty()
            || leader.draft.effects.len() != draft.effects.len() + 1
        {
            return vec![];
        }
        let found = Effect {
            start: values(leader, names, &effect.start),
            beside: leader.found(|p| !p.each),
            ..effect.clone()
        };
        self.catalogue
            .iter()
            .filter(|e| e.law.family == law.family && e.law.internal.is_empty() && e.id != effect.entry.id)
            .filter_map(|e| imitated(&leader.draft, &leader.cal, &found, e))
            .flatten()
            .filter_map(|e| draft.with(&e).ok())
            .collect()
    }

    /// The family of the leading friction at every other place, from the levels that the leader found, where it looks no worse: of two places of which one moves little against the other a
    /// linear response sees the stops of both.
    fn elsewhere(&self, draft: &Draft, singles: &[Fitted]) -> Vec<Draft> {
        let Some(leader) = singles.iter().find(|f| f.draft.effects.len() == draft.effects.len() + 1) else {
            return vec![];
        };
        let effects = current(leader);
        let [.., last] = &effects[..] else { return vec![] };
        let law = &last.entry.law;
        if law.family != "friction" || !law.internal.is_empty() {
            return vec![];
        }
        let look =
            |d: &Draft| glance(&d.case.system, &d.records, &d.smooth, self.noise, 1).unwrap_or(f64::INFINITY);
        let here = look(&leader.draft);
        let free = |p: &&Place| fits(law, p) && p.at != last.place.at;
        let everywhere = places(&draft.case.system, &draft.case.records, &draft.internal);
        let family =
            self.catalogue.iter().filter(|e| e.law.family == law.family && e.law.internal.is_empty());
        let family: Vec<Effect> = family.map(|entry| relative(last, entry)).collect();
        everywhere
            .iter()
            .filter(free)
            .flat_map(|place| family.iter().map(|e| Effect { place: place.clone(), ..e.clone() }))
            .filter(|e| !draft.effects.iter().any(|(held, ..)| excludes(held, e)))
            .filter(|e| !singles.iter().any(|f| f.draft.effects.last().is_some_and(|(own, ..)| own.same(e))))
            .filter_map(|e| draft.with(&e).ok())
            .collect::<Vec<Draft>>()
            .into_par_iter()
            .filter(|d| look(d) <= here)
            .collect()
    }

    /// The model with each of its effects replaced by a law that contains it.
    fn richer(&self, draft: &Draft, now: &Fitted) -> Vec<Draft> {
        let effects = current(now);
        let base = draft.without_effects();
        let mut all = Vec::new();
        for k in 0..effects.len() {
            for entry in self
                .catalogue
                .iter()
                .filter(|e| e.law.simpler.contains(&effects[k].entry.id) && e.law.internal.is_empty())
            {
                let mut list = effects.clone();
                list[k] = relative(&effects[k], entry);
                all.extend(base.with_all(&list).ok());
            }
        }
        all
    }

    /// What a leading law of many parameters may stand for: its simpler relatives, each beside every law of one parameter that acts in the same place or on a sensor.
    fn parted(&self, draft: &Draft, leader: &Fitted, found: &Screening) -> Vec<Vec<Effect>> {
        let effects = current(leader);
        let [.., last] = &effects[..] else { return vec![] };
        if !is_composed(last) || effects.len() != draft.effects.len() + 1 {
            return vec![];
        }
        let plain = self.catalogue.iter().filter(|e| last.entry.law.simpler.contains(&e.id));
        plain
            .map(|entry| relative(last, entry))
            .flat_map(|one| {
                let beside = |c: &&Candidate| {
                    (c.effect.place.at == one.place.at || c.effect.entry.law.sensor.is_some())
                        && c.effect.entry.law.parameters.len() == 1
                        && !excludes(&c.effect, &one)
                };
                let others: Vec<Effect> =
                    found.candidates.iter().filter(beside).map(|c| neutral(&c.effect)).collect();
                others.into_iter().map(move |other| vec![one.clone(), other])
            })
            .collect()
    }

    /// Each law from the best of its starts, by a glance.
    fn seeded(&self, draft: &Draft, laws: Vec<&Candidate>) -> Vec<Vec<Effect>> {
        laws.into_par_iter()
            .map(|c| {
                let look = |e: &Effect| {
                    let d = draft.with(e).ok()?;
                    glance(&d.case.system, &d.records, &d.smooth, self.noise, SEEDED)
                };
                let starts: Vec<&Effect> = [&c.effect].into_iter().chain(&c.others).collect();
                if starts.len() == 1 {
                    return vec![c.effect.clone()];
                }
                let looks: Vec<f64> = starts.par_iter().map(|e| look(e).unwrap_or(f64::INFINITY)).collect();
                let best = (0..starts.len()).min_by(|&a, &b| looks[a].total_cmp(&looks[b])).unwrap_or(0);
                vec![starts[best].clone()]
            })
            .collect()
    }

    /// Fits those of some models that stay in a race, and leaves out what evidence speaks against. A race that such a model led is run again without its law: it has outrun what
    /// might be true.
    fn tried(
        &self,
        mut drafts: Vec<Draft>,
        race: f64,
        candidates: usize,
        vetoed: &mut Vec<(String, String)>,
    ) -> Vec<Fitted> {
        loop {
            let all = self.fitted(drafts.clone(), race, candidates);
            let (count, names) = (all.len(), all.iter().map(|f| named(&f.draft)).collect::<Vec<_>>());
            let all = self.allowed(all, vetoed);
            let left: Vec<_> = all.iter().map(|f| named(&f.draft)).collect();
            if names.first() == left.first() || count == drafts.len() {
                return all;
            }
            drafts.retain(|d| !names.contains(&named(d)) || left.contains(&named(d)));
        }
    }

    /// Fits what is left of a race; failures drop out.
    fn fitted(&self, drafts: Vec<Draft>, race: f64, candidates: usize) -> Vec<Fitted> {
        let looks: Vec<f64> = drafts
            .par_iter()
            .map(|d| glance(&d.case.system, &d.records, &d.smooth, self.noise, 1).unwrap_or(f64::INFINITY))
            .collect();
        let least = looks.iter().copied().fold(f64::INFINITY, f64::min);
        let kept: Vec<Draft> =
            drafts.into_iter().zip(looks).filter(|(_, look)| *look <= race * least).map(|(d, _)| d).collect();
        let mut all: Vec<Fitted> =
            kept.into_par_iter().filter_map(|d| Fitted::new(d, self.noise, Effort::Plain).ok()).collect();
        let by = Measure::of(&all, candidates);
        all.sort_by(|a, b| by.score(a).total_cmp(&by.score(b)));
        // Those that are near but not there are worth more starts: a run through stops has side minima.
        let least = all.iter().map(|f| f.fit).fold(f64::INFINITY, f64::min);
        let near = |f: &&mut Fitted| (f.fit < 2.0 * least || f.fit < 2.0) && f.may_gain();
        all.par_iter_mut().take(4).filter(near).for_each(|f| {
            let thorough = f.settled().and_then(|d| Fitted::new(d, self.noise, Effort::Thorough));
            if let Ok(better) = thorough
                && better.fit < f.fit
            {
                *f = better;
            }
        });
        let by = Measure::of(&all, candidates);
        all.sort_by(|a, b| by.score(a).total_cmp(&by.score(b)));
        all
    }

    /// Without the models that evidence speaks against.
    fn allowed(&self, all: Vec<Fitted>, vetoed: &mut Vec<(String, String)>) -> Vec<Fitted> {
        all.into_iter()
            .filter(|f| {
                let against = f.draft.effects.iter().find_map(|(e, ..)| Some((e, (self.veto)(f, e)?)));
                match against {
                    Some((effect, why)) => {
                        if !vetoed.iter().any(|(law, _)| *law == effect.entry.id) {
                            vetoed.push((effect.entry.id.clone(), why));
                        }
                        false
                    }
                    None => true,
                }
            })
            .collect()
    }

    /// Whether a simpler model does as well. Where neither leaves noise alone, a richer law must carry over: lower the gap on Validate records by more than a twentieth.
    fn as_good(&self, simple: &Fitted, rich: &Fitted, candidates: usize) -> bool {
        let by = Measure::of([simple, rich], candidates);
        by.score(simple) - by.score(rich) < SIMPLER || carries_no_further(simple, rich)
    }

    /// Each effect at every other place: what was added first was looked for without the others, and may stand where it made good a part of them.
    fn moved(&self, mut now: Fitted, candidates: usize) -> Fitted {
        for _ in 0..EFFECTS {
            let effects = current(&now);
            if effects.len() < 2 {
                break;
            }
            let base = now.draft.without_effects();
            let everywhere = places(&base.case.system, &base.case.records, &base.internal);
            let elsewhere = |k: usize| {
                let own = &effects[k];
                let free = everywhere.iter().filter(|p| fits(&own.entry.law, p) && p.at != own.place.at);
                free.map(|p| Effect { place: p.clone(), ..own.clone() }).collect::<Vec<_>>()
            };
            let trials: Vec<Vec<Effect>> = (0..effects.len())
                .flat_map(|k| elsewhere(k).into_iter().map(move |e| (k, e)))
                .filter(|(k, e)| effects.iter().enumerate().all(|(j, other)| j == *k || !excludes(other, e)))
                .map(|(k, e)| {
                    let mut list = effects.clone();
                    list[k] = e;
                    list
                })
                .collect();
            let (noise, veto) = (self.noise, self.veto);
            let others: Vec<Fitted> =
                trials.par_iter().filter_map(|list| instead(&base, &now, list, noise, veto)).collect();
            let by = Measure::of(others.iter().chain([&now]), candidates);
            let best = others.iter().min_by(|a, b| by.score(a).total_cmp(&by.score(b)));
            match best.filter(|b| by.score(b) + SIMPLER < by.score(&now)) {
                Some(better) => now = better.clone(),
                None => break,
            }
        }
        now
    }

    /// Each law of a family in the place of its sibling, started from that one's force, where two or more effects leave nothing but noise: which of the family it is could not be told while
    /// the others were missing.
    fn exchanged(&self, now: Fitted, candidates: usize) -> Fitted {
        let effects = current(&now);
        if effects.len() < 2 || !now.is_white() {
            return now;
        }
        let base = now.draft.without_effects();
        let kin = |k: usize| {
            let own = &effects[k];
            let law = &own.entry.law;
            let related = move |e: &&Entry| {
                !law.family.is_empty()
                    && law.internal.is_empty()
                    && e.law.family == law.family
                    && e.law.internal.is_empty()
                    && e.id != own.entry.id
                    && !law.simpler.contains(&e.id)
            };
            self.catalogue
                .iter()
                .filter(related)
                .filter_map(|e| imitated(&now.draft, &now.cal, own, e))
                .flatten()
                .collect::<Vec<Effect>>()
        };
        let trials: Vec<Vec<Effect>> = (0..effects.len())
            .flat_map(|k| kin(k).into_iter().map(move |e| (k, e)))
            .map(|(k, e)| {
                let mut list = effects.clone();
                list[k] = e;
                list
            })
            .collect();
        let (noise, veto) = (self.noise, self.veto);
        let fitted = |list: &Vec<Effect>| {
            let other = refitted(base.with_all(list).ok()?, &now, noise)?;
            list.iter().all(|e| veto(&other, e).is_none()).then_some(other)
        };
        let others: Vec<Fitted> = trials.par_iter().filter_map(fitted).collect();
        let by = Measure::of(others.iter().chain([&now]), candidates);
        let best = others.into_iter().min_by(|a, b| by.score(a).total_cmp(&by.score(b)));
        best.filter(|b| by.score(b) + SIMPLER < by.score(&now)).unwrap_or(now)
    }

    /// Drops each effect, or puts a simpler relative in its place, as long as nothing of note is lost.
    fn simplified(&self, mut now: Fitted, candidates: usize) -> Fitted {
        'again: loop {
            let effects = current(&now);
            let base = now.draft.without_effects();
            let everywhere = places(&base.case.system, &base.case.records, &base.internal);
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
                    let mut list = effects.clone();
                    list[k] = relative;
                    trials.push(list);
                }
                // Two effects that are one law by another name.
                for entry in self.catalogue.iter().filter(|e| e.law.same_as.len() == 2) {
                    let j =
                        (0..effects.len()).find(|&j| j != k && effects[j].entry.id == entry.law.same_as[1]);
                    let Some(j) = j.filter(|_| effects[k].entry.id == entry.law.same_as[0]) else { continue };
                    let bodies = |e: &Effect| match &e.place.site {
                        Site::Force { acts, .. } => acts.iter().map(|a| a.0).collect(),
                        Site::Sensor(_) => vec![usize::MAX],
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
                // One law on each of two bodies may be one between them.
                for j in (0..effects.len()).filter(|&j| j != k && effects[j].entry.id == effects[k].entry.id)
                {
                    let between = format!("{}-{}", effects[k].place.at, effects[j].place.at);
                    let Some(place) = everywhere.iter().find(|p| p.at == between) else { continue };
                    let one = Effect { place: place.clone(), ..effects[k].clone() };
                    let others = effects.iter().enumerate().filter(|(i, _)| *i != k && *i != j);
                    trials.push(others.map(|(_, e)| e.clone()).chain([one]).collect());
                }
                for list in trials {
                    let Some(simple) = instead(&base, &now, &list, self.noise, self.veto) else { continue };
                    let same = self.as_good(&simple, &now, candidates);
                    let by = Measure::of([&simple, &now], candidates);
                    let carries = simple.validate.zip(now.validate).is_none_or(|(a, b)| a < ALIKE * b)
                        || !now.is_white()
                        || by.score(&simple) + SIMPLER < by.score(&now);
                    if same && carries && (simple.is_white() || !now.is_white()) {
                        now = simple;
                        continue 'again;
                    }
                }
            }
            return now;
        }
    }
}

/// A model with other effects than a fitted one, fitted from there; `None` if it is far behind after a few steps, or evidence speaks against it.
fn instead(
    base: &Draft,
    now: &Fitted,
    list: &[Effect],
    noise: &[Vec<f64>],
    veto: &(dyn Fn(&Fitted, &Effect) -> Option<String> + Sync),
) -> Option<Fitted> {
    let mut draft = base.with_all(list).ok()?;
    now.starts(&mut draft);
    let (system, records, smooth) = (&draft.case.system, &draft.records, &draft.smooth);
    let look = if now.rests() {
        approach(system, records, smooth, noise)
    } else {
        glance(system, records, smooth, noise, 1)
    }?;
    if look > RACE * now.fit.powi(2).max(1.0) {
        return None;
    }
    let other = refitted(draft, now, noise)?;
    list.iter().all(|e| veto(&other, e).is_none()).then_some(other)
}

/// A part of a fitted model, which starts near where it should end. Through stops the way over short segments may lead astray: then also straight from where that
/// model's runs started.
pub(crate) fn refitted(mut draft: Draft, whole: &Fitted, noise: &[Vec<f64>]) -> Option<Fitted> {
    whole.starts(&mut draft);
    let straight = if whole.rests() || whole.strikes() {
        Fitted::new(draft.clone(), noise, Effort::Thorough).ok()
    } else {
        None
    };
    let long = Fitted::new(draft, noise, Effort::Plain).ok();
    match (straight, long) {
        (Some(a), Some(b)) => Some(if a.fit < b.fit { a } else { b }),
        (a, b) => a.or(b),
    }
}

/// The plainest friction in every two places: of two contacts that stick by turns a linear response sees neither.
fn rubbing(found: &Screening) -> Vec<Vec<Effect>> {
    let plain =
        |c: &&Candidate| c.effect.entry.law.family == "friction" && c.effect.entry.law.parameters.len() == 1;
    let all: Vec<Effect> = found.candidates.iter().filter(plain).map(|c| neutral(&c.effect)).collect();
    let mut pairs = Vec::new();
    for (k, one) in all.iter().enumerate() {
        let others = all[k + 1..].iter().filter(|other| !excludes(one, other));
        pairs.extend(others.map(|other| vec![one.clone(), other.clone()]));
    }
    pairs
}

/// The best singles, with the simpler relatives and the family of what is among them.
fn singles(found: &Screening) -> Vec<&Candidate> {
    let mut chosen: Vec<&Candidate> = found.candidates.iter().take(BEST).collect();
    let leaders: Vec<&Candidate> = chosen.clone();
    for (rank, leader) in leaders.iter().enumerate() {
        let law = &leader.effect.entry.law;
        for other in &found.candidates {
            let here =
                other.effect.place.at == leader.effect.place.at && other.effect.load == leader.effect.load;
            let relative = law.simpler.contains(&other.effect.entry.id)
                || (rank < 3 && !law.family.is_empty() && other.effect.entry.law.family == law.family);
            if here && relative && !chosen.iter().any(|c| c.effect.same(&other.effect)) {
                chosen.push(other);
            }
        }
    }
    chosen
}

/// The best by the criterion, or a simpler one that is as good.
fn preferred(all: &[Fitted], candidates: usize) -> Option<&Fitted> {
    let by = Measure::of(all, candidates);
    let best = all.iter().min_by(|a, b| by.score(a).total_cmp(&by.score(b)))?;
    let near = |f: &&Fitted| by.score(f) - by.score(best) < SIMPLER || carries_no_further(f, best);
    let least = all.iter().filter(near).map(|f| size(&f.draft)).min()?;
    let carried = |f: &&Fitted| f.validate.unwrap_or(0.0);
    all.iter()
        .filter(near)
        .filter(|f| size(&f.draft) == least)
        .min_by(|a, b| carried(a).total_cmp(&carried(b)))
}

/// Whether, of two models that both leave more than noise, the second predicts Validate records no better than the first.
fn carries_no_further(simple: &Fitted, rich: &Fitted) -> bool {
    let further = simple.validate.zip(rich.validate).is_none_or(|(a, b)| b < RICHER * a);
    !rich.is_white() && !simple.is_white() && !further && !on_the_way(simple, rich)
}

/// Whether the second model is on the way to something: while much is missing Validate records are missed whatever is added, and the end of the search looks at them.
fn on_the_way(from: &Fitted, to: &Fitted) -> bool {
    to.fit > FAR_OFF && to.fit < HALF * from.fit
}

/// Whether a law may stand for two simple ones: of many parameters, or two laws by one name.
fn is_composed(effect: &Effect) -> bool {
    effect.entry.law.parameters.len() > 2 || !effect.entry.law.same_as.is_empty()
}

/// The effects of a fitted model, from where its fit ended.
pub(crate) fn current(now: &Fitted) -> Vec<Effect> {
    let own = |name: &str| now.draft.effects.iter().any(|(_, names, _)| names.iter().any(|n| n == name));
    let beside = now.found(|p| !p.each && !own(&p.name));
    let of = |(e, names, _): &(Effect, Vec<String>, String)| Effect {
        start: values(now, names, &e.start),
        beside: beside.clone(),
        ..e.clone()
    };
    now.draft.effects.iter().map(of).collect()
}

/// The values that a fit found for an effect's parameters.
pub(crate) fn values(fitted: &Fitted, names: &[String], otherwise: &[f64]) -> Vec<f64> {
    names
        .iter()
        .zip(otherwise)
        .map(|(name, other)| {
            let found =
                fitted.cal.parameters.iter().find(|p| {
                    p.parameter.is_some_and(|k| fitted.draft.case.system.parameters[k].name == *name)
                });
            found.map_or(*other, |p| p.estimate.value)
        })
        .collect()
}

/// The effect from where it does next to nothing: a fit goes on from the model without it.
pub(crate) fn neutral(effect: &Effect) -> Effect {
    let law = &effect.entry.law;
    let small = |(v, (_, p)): (&f64, &(String, phisindy_phys::LawParameter))| {
        let force = phisindy_phys::unit::Unit::parse(&p.unit).is_ok_and(|u| u.dimension.powers()[0] != 0.0);
        if force { (0.05 * v).clamp(p.within.0, p.within.1) } else { *v }
    };
    let start = match law.sensor.as_deref() {
        Some("gain") => vec![1.0],
        Some(_) => vec![0.0],
        None => effect.start.iter().zip(&law.parameters).map(small).collect(),
    };
    Effect { start, beside: vec![], ..effect.clone() }
}

/// A simpler law in the place of another, started from its first level.
fn relative(effect: &Effect, entry: &Entry) -> Effect {
    let level = effect.start.first().copied().unwrap_or(0.0);
    let first = entry.law.parameters.first().map_or("", |(_, p)| p.unit.as_str());
    // Levels start at the level; what may have either sign, at nothing; a speed at a small one.
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
        start,
        beside: effect.beside.clone(),
    }
}

fn round(
    before: usize,
    chosen: &Fitted,
    all: &[Fitted],
    vetoed: Vec<(String, String)>,
    candidates: usize,
) -> Round {
    let own: Vec<(&str, &str)> = label(&chosen.draft, 0);
    let by = Measure::of(all.iter().chain([chosen]), candidates);
    let mut rivals: Vec<Rival> = all
        .iter()
        .filter(|f| label(&f.draft, before) != own[before.min(own.len())..] && f.draft.effects.len() > before)
        .map(|f| {
            let names = label(&f.draft, before);
            Rival {
                law: names.iter().map(|(law, _)| *law).collect::<Vec<_>>().join(" + "),
                at: names.iter().map(|(_, at)| *at).collect::<Vec<_>>().join(", "),
                worse: by.score(f) - by.score(chosen),
            }
        })
        .collect();
    rivals.sort_by(|a, b| a.worse.total_cmp(&b.worse));
    rivals.dedup_by(|a, b| a.law == b.law && a.at == b.at);
    rivals.truncate(5);
    // A law that stands in one place may be ruled out in another.
    let stands = |law: &str| own.iter().any(|(chosen, _)| *chosen == law);
    let vetoed = vetoed.into_iter().filter(|(law, _)| !stands(law)).collect();
    Round { before, rivals, vetoed }
}

/// Parameters of all effects of a model.
fn size(d: &Draft) -> usize {
    d.effects.iter().map(|(e, ..)| e.entry.law.parameters.len()).sum()
}

/// Laws and places of a model.
fn named(d: &Draft) -> Vec<(String, String)> {
    label(d, 0).into_iter().map(|(law, at)| (law.to_owned(), at.to_owned())).collect()
}

fn label(d: &Draft, from: usize) -> Vec<(&str, &str)> {
    d.effects[from.min(d.effects.len())..]
        .iter()
        .map(|(e, ..)| (e.entry.id.as_str(), e.place.at.as_str()))
        .collect()
}
