//! Find, name, add, refit, until nothing but noise is left or nothing in the catalogue helps.

use crate::draft::Draft;
use crate::effect::{Effect, Entry};
use crate::fitted::{FAR_OFF, Fitted, current};
use crate::proposals::{is_composed, rubbing, singles};
use crate::refine::refitted;
use crate::screen::{Candidate, Screening, screen};
use phisindy_learn::Effort;
use rayon::prelude::*;

/// Effects in one model at most.
pub(crate) const EFFECTS: usize = 4;
/// Singles, and pairs, that are fitted in full.
pub(crate) const BEST: usize = 6;
/// What a new effect must bring.
pub(crate) const WORTH: f64 = 10.0;
/// A simpler description within this is preferred.
pub(crate) const SIMPLER: f64 = 3.0;
/// An effect that leaves more than this part of the gap on Validate records explains nothing of note.
const SHRINK: f64 = 0.98;
/// A richer law must lower the gap on Validate records to this part, where something is left that is not noise.
const RICHER: f64 = 0.95;
/// A round that leaves more than this part of a gap that is far above the noise is a weak one; after two of them, or after one that is not among the first two rounds, nothing in the catalogue helps.
const FAR: f64 = 0.8;
/// A model far from the noise that brings the gap on Fit records to this part is on the way, whatever Validate records say.
const HALF: f64 = 0.5;
/// How often a family of friction laws is tried again from a new leader.
const FAMILY: usize = 2;
/// In the race a model that is this many times worse than the best is out.
pub(crate) const RACE: f64 = 3.0;
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

/// What a second look at effects that leave noise alone finds.
enum Overlooked {
    /// A model with one effect more, or with others.
    More(Box<Fitted>, Round),
    /// Models with one effect more that are nearly worth their price.
    Near(Vec<Rival>),
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
            let below = now.carried.is_some_and(|v| v <= self.floor);
            if below && !rounds.is_empty() {
                break;
            }
            // The last effect is tried where not much is missing: so many explain nothing, but one more may make others needless.
            let last = now.draft.effects.len() + 1 == EFFECTS;
            if last && now.fit > FAR_OFF * self.floor.max(1.0) {
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
            weak += usize::from(next.fit > FAR_OFF.max(FAR * now.fit));
            now = next;
            if weak > 1 || (weak > 0 && rounds.len() > 2) {
                break;
            }
        }
        if !stopped {
            match self.overlooked(&now, candidates) {
                Overlooked::More(more, round) => {
                    rounds.push(round);
                    now = *more;
                }
                Overlooked::Near(rivals) => {
                    if let Some(last) = rounds.last_mut() {
                        last.rivals.extend(rivals);
                    }
                }
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
        let mut drafts = self.begun(draft, now, found);
        drafts.extend(self.richer(draft, now));
        let mut singles = self.tried(drafts, RACE, candidates, &mut vetoed);
        if singles.first().is_some_and(|leader| !leader.is_white()) {
            singles.extend(self.tried(self.elsewhere(draft, &singles), ALL, candidates, &mut vetoed));
            rank(&mut singles, candidates);
        }
        // From each new leader its whole family once more: one slow curve is hard to reach from a regression, easy from its neighbour.
        for _ in 0..FAMILY {
            let Some(leader) = singles.first().map(|f| named(&f.draft)) else { break };
            singles.extend(self.tried(self.siblings(draft, &singles), ALL, candidates, &mut vetoed));
            rank(&mut singles, candidates);
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
        let pairs = match &pair {
            Some(pair) if pair.is_white() => self.followed(pairs, &singles, pair, candidates, &mut vetoed),
            _ => pairs,
        };
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
                let much = pair.carried.zip(single.carried).is_none_or(|(p, s)| p < HALF * s)
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

    /// What is still worth its price beside effects that leave what looks like noise: a faint second effect does not colour what is left. Where the motion is smooth a
    /// linear response tells what to try; of stops it knows nothing.
    fn overlooked(&self, now: &Fitted, candidates: usize) -> Overlooked {
        let before = now.draft.effects.len();
        let nothing = Overlooked::Near(vec![]);
        if before + 1 >= EFFECTS || !now.is_white() || now.rests() {
            return nothing;
        }
        let Ok(draft) = now.settled() else { return nothing };
        let Some(mut found) = screen(&draft, &now.cal, self.catalogue, self.noise) else { return nothing };
        let candidates = candidates.max(found.candidates.len());
        let price = (now.cal.samples as f64).ln();
        found.candidates.retain(|c| c.gain > price * c.size as f64);
        let mut vetoed = Vec::new();
        let all = self.tried(self.begun(&draft, now, &found), RACE, candidates, &mut vetoed);
        // To a model that may lack nothing at all it must be more than worth it.
        let doubted = if before == 0 { WORTH } else { 0.0 };
        let more = |f: &&Fitted| {
            let by = Measure::of([now, *f], candidates);
            f.is_white() && self.worth(now, f, candidates) && by.score(f) + WORTH + doubted < by.score(now)
        };
        let Some(best) = preferred(&all, candidates).filter(more).cloned() else {
            let near = round(0, now, &all, vetoed, candidates).rivals.into_iter();
            return Overlooked::Near(near.filter(|r| r.worse < WORTH).collect());
        };
        // What was found first may have stood for part of it.
        let effects = current(&best);
        let without = |k: usize| {
            let rest: Vec<Effect> =
                effects.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, e)| e.clone()).collect();
            refitted(draft.without_effects().with_all(&rest).ok()?, &best, self.noise)
        };
        let mut rest: Vec<Fitted> = (0..before).filter_map(without).collect();
        rank(&mut rest, candidates);
        let mut all = self.followed(all, &rest, &best, candidates, &mut vetoed);
        let best = preferred(&all, candidates).cloned().unwrap_or(best);
        let best = self.exchanged(self.simplified(best, candidates), candidates);
        let first = named(&now.draft);
        let stands = |f: &Fitted| named(&f.draft).starts_with(&first);
        let from = if stands(&best) { before } else { 0 };
        all.retain(|f| from == 0 || stands(f));
        let round = round(from, &best, &all, vetoed, candidates);
        Overlooked::More(Box::new(best), round)
    }

    /// Two that explain everything, found at once, beside those that follow from the better of them alone and promise more there: far from the data a linear response confuses what is alike.
    fn followed(
        &self,
        mut pairs: Vec<Fitted>,
        singles: &[Fitted],
        pair: &Fitted,
        candidates: usize,
        vetoed: &mut Vec<(String, String)>,
    ) -> Vec<Fitted> {
        let parts = named(&pair.draft);
        let Some(single) = singles.iter().find(|f| named(&f.draft).iter().all(|own| parts.contains(own)))
        else {
            return pairs;
        };
        let screened = single.settled().ok().and_then(|draft| {
            let found = screen(&draft, &single.cal, self.catalogue, self.noise)?;
            Some((draft, found))
        });
        let Some((draft, mut found)) = screened else { return pairs };
        let own = |c: &Candidate| pair.draft.effects.iter().any(|(e, ..)| e.same(&c.effect));
        let better = found.candidates.iter().position(own).unwrap_or(found.candidates.len());
        found.candidates.truncate(better);
        pairs.extend(self.tried(self.begun(&draft, single, &found), RACE, candidates, vetoed));
        rank(&mut pairs, candidates);
        pairs
    }

    /// The best laws of a screening beside a model, each from the best of its starts.
    fn begun(&self, draft: &Draft, now: &Fitted, found: &Screening) -> Vec<Draft> {
        let lists = if now.rests() || now.strikes() {
            self.approached(draft, found)
        } else {
            self.seeded(draft, singles(found))
        };
        lists.iter().filter_map(|list| draft.with_all(list).ok()).collect()
    }

    /// Whether a model is worth its price against another one.
    fn worth(&self, now: &Fitted, next: &Fitted, candidates: usize) -> bool {
        let by = Measure::of([now, next], candidates);
        let gain = by.score(now) - by.score(next);
        let carries = match (now.carried, next.carried) {
            (Some(before), Some(after)) => after < SHRINK * before || (next.is_white() && after < before),
            _ => true,
        };
        // A motion that hangs on every number is missed on Validate records as long as anything is missing, and they say nothing of who is near.
        on_the_way(now, next) || (gain > WORTH && carries)
    }

    /// Fits those of some models that stay in a race, best first, without those that evidence speaks against. If such a one led, the race goes on among the others: it has outrun what might be
    /// true.
    fn tried(
        &self,
        drafts: Vec<Draft>,
        race: f64,
        candidates: usize,
        vetoed: &mut Vec<(String, String)>,
    ) -> Vec<Fitted> {
        let look = |d: Draft| (d.glance(self.noise, 1).unwrap_or(f64::INFINITY), d);
        let mut waiting: Vec<(f64, Draft)> = drafts.into_par_iter().map(look).collect();
        // What was fitted, and how it looked.
        let mut done: Vec<(f64, Fitted)> = Vec::new();
        loop {
            let looks = waiting.iter().map(|(look, _)| look).chain(done.iter().map(|(look, _)| look));
            let least = looks.copied().fold(f64::INFINITY, f64::min);
            let (now, later): (Vec<_>, Vec<_>) =
                waiting.into_iter().partition(|(look, _)| *look <= race * least);
            done.extend(self.fitted(now, candidates));
            let by = Measure::of(done.iter().map(|(_, f)| f), candidates);
            done.sort_by(|(_, a), (_, b)| by.score(a).total_cmp(&by.score(b)));
            let names = |of: &[(f64, Fitted)]| of.iter().map(|(_, f)| named(&f.draft)).collect::<Vec<_>>();
            let all = names(&done);
            done.retain(|(_, f)| !self.ruled_out(f, vetoed));
            let left = names(&done);
            if later.is_empty() || all.first() == left.first() {
                return done.into_iter().map(|(_, f)| f).collect();
            }
            waiting = later;
            waiting.retain(|(_, d)| !all.contains(&named(d)) || left.contains(&named(d)));
        }
    }

    /// Fits models, each with how it looked; failures drop out.
    fn fitted(&self, drafts: Vec<(f64, Draft)>, candidates: usize) -> Vec<(f64, Fitted)> {
        let fit = |(look, d): (f64, Draft)| Some((look, Fitted::new(d, self.noise, Effort::Plain).ok()?));
        let mut all: Vec<(f64, Fitted)> = drafts.into_par_iter().filter_map(fit).collect();
        all.retain(|(_, f)| f.fit.is_finite());
        let by = Measure::of(all.iter().map(|(_, f)| f), candidates);
        all.sort_by(|(_, a), (_, b)| by.score(a).total_cmp(&by.score(b)));
        // Those that are near but not there are worth more starts: a run through stops has side minima.
        let least = all.iter().map(|(_, f)| f.fit).fold(f64::INFINITY, f64::min);
        let near = |f: &Fitted| (f.fit < 2.0 * least || f.fit < 2.0) && f.may_gain();
        all.par_iter_mut().take(4).filter(|(_, f)| near(f)).for_each(|(_, f)| {
            let thorough = f.settled().and_then(|d| Fitted::new(d, self.noise, Effort::Thorough));
            if let Ok(better) = thorough
                && better.fit < f.fit
            {
                *f = better;
            }
        });
        all
    }

    /// Whether evidence speaks against a model: the law and the reason are noted.
    fn ruled_out(&self, model: &Fitted, vetoed: &mut Vec<(String, String)>) -> bool {
        let against = model.draft.effects.iter().find_map(|(e, ..)| Some((e, (self.veto)(model, e)?)));
        let Some((effect, why)) = against else { return false };
        if !vetoed.iter().any(|(law, _)| *law == effect.entry.id) {
            vetoed.push((effect.entry.id.clone(), why));
        }
        true
    }

    /// Whether a simpler model does as well. Where neither leaves noise alone, a richer law must carry over: lower the gap on Validate records by more than a twentieth.
    pub(crate) fn as_good(&self, simple: &Fitted, rich: &Fitted, candidates: usize) -> bool {
        let by = Measure::of([simple, rich], candidates);
        by.score(simple) - by.score(rich) < SIMPLER || carries_no_further(simple, rich)
    }
}

/// Sorts models, the best first.
fn rank(all: &mut [Fitted], candidates: usize) {
    let by = Measure::of(&*all, candidates);
    all.sort_by(|a, b| by.score(a).total_cmp(&by.score(b)));
}

/// The best by the criterion, or a simpler one that is as good.
fn preferred(all: &[Fitted], candidates: usize) -> Option<&Fitted> {
    let by = Measure::of(all, candidates);
    let best = all.iter().min_by(|a, b| by.score(a).total_cmp(&by.score(b)))?;
    let near = |f: &&Fitted| by.score(f) - by.score(best) < SIMPLER || carries_no_further(f, best);
    let least = all.iter().filter(near).map(|f| size(&f.draft)).min()?;
    let carried = |f: &&Fitted| f.carried.unwrap_or(0.0);
    all.iter()
        .filter(near)
        .filter(|f| size(&f.draft) == least)
        .min_by(|a, b| carried(a).total_cmp(&carried(b)))
}

/// Whether, of two models that both leave more than noise, the second predicts Validate records no better than the first.
fn carries_no_further(simple: &Fitted, rich: &Fitted) -> bool {
    let further = simple.carried.zip(rich.carried).is_none_or(|(a, b)| b < RICHER * a);
    !rich.is_white() && !simple.is_white() && !further && !on_the_way(simple, rich)
}

/// Whether the second model is on the way to something: while much is missing Validate records are missed whatever is added, and the end of the search looks at them.
fn on_the_way(from: &Fitted, to: &Fitted) -> bool {
    to.fit > FAR_OFF && to.fit < HALF * from.fit
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
    let in_order = |mut names: Vec<(String, String)>| {
        names.sort();
        names
    };
    let answer = in_order(named(&chosen.draft));
    let mut rivals: Vec<Rival> = all
        .iter()
        .filter(|f| in_order(named(&f.draft)) != answer && f.draft.effects.len() > before)
        .map(|f| {
            let names = label(&f.draft, before);
            Rival {
                law: names.iter().map(|(law, _)| *law).collect::<Vec<_>>().join(" + "),
                at: names.iter().map(|(_, at)| *at).collect::<Vec<_>>().join(", "),
                worse: by.score(f) - by.score(chosen),
            }
        })
        .collect();
    // From a worse start a law may fit with numbers that nothing speaks against: it stays ruled out.
    rivals.retain(|r| r.worse.is_finite() && !vetoed.iter().any(|(law, _)| *law == r.law));
    rivals.sort_by(|a, b| a.worse.total_cmp(&b.worse));
    rivals.dedup_by(|a, b| a.law == b.law && a.at == b.at);
    rivals.truncate(5);
    // A law that stands in one place may be ruled out in another.
    let stands = |law: &str| own.iter().any(|(chosen, _)| *chosen == law);
    let vetoed = vetoed.into_iter().filter(|(law, _)| !stands(law)).collect();
    Round { before, rivals, vetoed }
}

/// Parameters of all effects of a model.
pub(crate) fn size(d: &Draft) -> usize {
    d.effects.iter().map(|(e, ..)| e.entry.law.parameters.len()).sum()
}

/// Laws and places of a model.
fn named(d: &Draft) -> Vec<(String, String)> {
    label(d, 0).into_iter().map(|(law, at)| (law.to_owned(), at.to_owned())).collect()
}

pub(crate) fn label(d: &Draft, from: usize) -> Vec<(&str, &str)> {
    d.effects[from.min(d.effects.len())..]
        .iter()
        .map(|(e, ..)| (e.entry.id.as_str(), e.place.at.as_str()))
        .collect()
}
