//! The search: screen the catalogue, add the best effect, fit again, until the residual is white or no law of
//! the catalogue helps.

mod compare;
mod proposals;
mod refine;
mod task;

pub(crate) use compare::{label, placed, preferred, rank, rival};
pub(crate) use proposals::neutral;
pub(crate) use refine::refitted;
pub(crate) use task::{Observe, Observer, ROUND, SEARCHED, Search};

use crate::changed_constants::{ChangedConstants, changed_constants};
use crate::decisions::{
    FAMILY_ROUNDS, FAR_OFF, MORE_STARTS, MOST_EFFECTS, ON_THE_WAY, PAIRS_RACED, RACE, REPEATS, RICHER,
    RIVALS, SEARCHES_AGAIN, SEEDED_STRIDE, SEGMENTS_END, SHRINKS, SIMPLER, WEAK_ROUND, WORTH, WORTH_STARTS,
};
use crate::evidence::{against, stands};
use crate::impacts::with_impact;
use crate::input_interpolation::Drawing;
use crate::model::{Fitted, Measure, Score, TrialModel, current};
use crate::other_causes::input_noise;
use crate::place::Effect;
use crate::plausibility::{may_be_undetermined, vetoed};
use crate::pushes::takes_most;
use crate::result::tried::weighed;
use crate::result::{
    Activity, Leader, MissingForce, ModelError, NotTried, PlacedLaw, Rival, RoundStart, StopReason, Tried,
    Veto, Vetoed,
};
use crate::screen::{Candidate, Screening, Target, screen};
use compare::{makes_progress, predicts_no_better};
use phisindy_learn::{Effort, SegmentFit};
use phisindy_phys::LawEntry;
use proposals::{friction_pairs, is_composed, singles};
use rayon::prelude::*;
use std::collections::HashSet;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Race limit that fits all models. Used for few models, whose segment costs may be wrong about sticking.
const ALL: f64 = f64::INFINITY;

/// A round of the search.
#[derive(Clone, Debug)]
pub(crate) struct Round {
    /// Number of effects of the model before the round.
    pub(crate) before: usize,
    pub(crate) rivals: Vec<Rival>,
    /// Laws that evidence outside the fit rules out.
    pub(crate) vetoed: Vec<Vetoed>,
    /// Laws that were fitted with one effect more than before: the gap that is left and the gain of the
    /// criterion.
    pub(crate) fitted: Vec<(PlacedLaw, f64, f64)>,
}

/// Result of a second screening of a model whose residual looks white.
enum SecondPass {
    /// A better model with one effect more, or with other effects.
    More(Box<Fitted>, Round),
    /// Models with one effect more, none of which is worth its price.
    Near(Round),
}

/// How a search ended.
pub(crate) struct Searched {
    pub(crate) base: Fitted,
    pub(crate) last: Fitted,
    pub(crate) rounds: Vec<Round>,
    /// Largest number of effects that were available in a round.
    pub(crate) candidates: usize,
    pub(crate) stop: StopReason,
    /// The effects without which a repeated search found nothing as good.
    pub(crate) needed: Vec<PlacedLaw>,
    /// What was tried beside the model as it is, and what was not.
    pub(crate) tried: (Vec<Tried>, Vec<NotTried>),
    /// The missing force without a formula, where neither a law nor a formula explains the data.
    pub(crate) force: Option<MissingForce>,
    /// The models whose constants have other values, where they were asked for within the search.
    pub(crate) changed: Option<ChangedConstants>,
}

/// State at the start of a round.
struct Start<'a> {
    /// The fitted model.
    now: &'a Fitted,
    /// The same model with its estimates as start values.
    model: TrialModel,
    screening: Screening,
    /// Largest number of effects that were available in any round so far.
    candidates: usize,
    drawing: &'a Drawing<'a>,
}

impl Start<'_> {
    /// Number of effects of the model.
    fn before(&self) -> usize {
        self.model.effects.len()
    }
}

/// Whether a model leaves no more than the scatter of the rig, a gap of `floor`; 0 where that is not known.
pub(crate) fn at_floor(of: &Fitted, floor: f64) -> bool {
    floor > 0.0 && of.score.gap() <= REPEATS * floor
}

impl Search<'_> {
    /// Runs the search, and repeats it without the laws that the records do not determine in the end, or that
    /// evidence rules out: another law may do as well. A repeated search counts if it explains the data, and
    /// beside a law whose numbers are open as well as that one; the laws that it leaves out are reported with
    /// its first round. Otherwise the data need the law.
    pub(crate) fn run_until_determined(&mut self, base: TrialModel) -> Result<Searched, ModelError> {
        let mut catalogue = self.catalogue.to_vec();
        let mut found = self.run(base.clone())?;
        let mut out: Vec<Vetoed> = Vec::new();
        for _ in 0..SEARCHES_AGAIN {
            let done = self.explained(&found.last);
            let any = |f: &Fitted| f.model.effects.iter().any(may_be_undetermined);
            if !done || found.stop == StopReason::Interrupted || !any(&found.last) {
                break;
            }
            let Ok(last) = Fitted::new(found.last.settled(), self.noise, Effort::Errors) else { break };
            let doubted: Vec<Vetoed> = vetoed(&last).into_iter().map(|(_, vetoed)| vetoed).collect();
            if doubted.is_empty() {
                break;
            }
            catalogue.retain(|entry| !doubted.iter().any(|v| v.law.law == entry.id));
            let mut again = Search { catalogue: &catalogue, ..*self };
            let other = again.run(base.clone())?;
            let candidates = found.candidates.max(other.candidates);
            // Numbers that the records leave open may depend on each other. A law that ends at a bound, or that
            // evidence rules out, explains nothing, however well it fits.
            let open = doubted.iter().all(|v| matches!(v.why, Veto::Undetermined(_)));
            let done = self.explained(&other.last);
            if !done || open && !self.as_good(&other.last, &found.last, candidates) {
                found.needed = placed(&found.last.model);
                break;
            }
            out.extend(doubted);
            // What the first search tried is what was tried.
            found = Searched { tried: std::mem::take(&mut found.tried), ..other };
            if let Some(round) = found.rounds.first_mut() {
                round.vetoed.extend(out.iter().cloned());
            }
        }
        Ok(found)
    }

    /// Whether a model leaves no more than noise or the scatter of the rig.
    pub(crate) fn explained(&self, by: &Fitted) -> bool {
        by.score.explains() || self.at_floor(by)
    }

    /// Whether a model leaves no more than what is not known of the inputs: how they are drawn, or their noise.
    fn inputs_leave(&self, of: &Fitted, drawing: &Drawing<'_>) -> bool {
        drawing.hides_the_rest(of) || self.left_by_input_noise(of)
    }

    /// Whether a model leaves no more than the noise of the measured inputs does alone, which no force describes.
    pub(crate) fn left_by_input_noise(&self, of: &Fitted) -> bool {
        input_noise(of, self.noise).is_some_and(|noise| noise.left <= noise.most)
    }

    /// Whether a model leaves no more than the scatter of the rig.
    pub(crate) fn at_floor(&self, of: &Fitted) -> bool {
        at_floor(of, self.floor)
    }

    /// Runs the search from a model.
    pub(crate) fn run(&mut self, base: TrialModel) -> Result<Searched, ModelError> {
        self.observer.tell(0.02, Activity::Calibrating);
        let base = Fitted::new(base, self.noise, Effort::Plain)?;
        let mut now = base.clone().on_trial();
        let mut rounds = Vec::new();
        let (mut candidates, mut weak) = (1, 0);
        // The round that found nothing worth its price.
        let mut fruitless: Option<Round> = None;
        let mut first: Option<(Vec<Tried>, Vec<NotTried>)> = None;
        let mut changed = None;
        let drawing = Drawing::of(&base, self.noise);
        if let Some(hit) = with_impact(&base, self.noise) {
            rounds.push(round_from(0, &base, &hit, &[], vec![], candidates));
            now = hit.on_trial();
        }
        let mut stop = loop {
            if let Some(stop) = self.ends(&now, rounds.len(), weak) {
                break stop;
            }
            if !rounds.is_empty() && self.inputs_leave(&now, &drawing) {
                break StopReason::Inputs;
            }
            // Laws one after the other imitate numbers that are wrong. Where other numbers explain the data alone, no
            // second round can say more.
            if rounds.len() == 1 && changed.is_none() {
                let found = changed_constants(&base, self.noise);
                let explain = found.explain();
                changed = Some(found);
                if explain {
                    break StopReason::NothingHelps;
                }
            }
            let part = 0.1 + ROUND * rounds.len() as f64;
            let round = RoundStart { number: rounds.len() + 1, gap: now.score.gap() };
            if self.observer.tell(part, Activity::Screening(round)) {
                break StopReason::Interrupted;
            }
            let model = now.settled();
            let Some(screening) = screen(&model, &now.cal, self.catalogue, self.noise, Target::AlongData)
            else {
                break StopReason::NothingHelps;
            };
            candidates = candidates.max(screening.candidates.len());
            first.get_or_insert_with(|| screened(&screening));
            let start = Start { now: &now, model, screening, candidates, drawing: &drawing };
            let (next, round) = self.round(&start);
            let next = match next {
                Ok(next) => next,
                Err(why) => {
                    fruitless = Some(round);
                    break if self.observer.stopped() { StopReason::Interrupted } else { why };
                }
            };
            // Near the repeatability of the rig an effect may describe the rig's scatter. It counts if its
            // residual is white, or if it predicts what was not used clearly better.
            if self.at_floor(&now) && !next.score.is_white() {
                let lowers = next.score.gap() < RICHER * now.score.gap();
                if !lowers {
                    break StopReason::Repeatability;
                }
                // A floor that a model passes is no floor.
                if next.score.gap() < RICHER * self.floor {
                    self.floor = 0.0;
                }
            }
            rounds.push(round);
            weak += usize::from(next.score.fit > FAR_OFF.max(WEAK_ROUND * now.score.fit));
            now = next;
        };
        if stop != StopReason::Interrupted && !self.observer.stopped() {
            match self.second_pass(&now, candidates, &mut first) {
                Some(SecondPass::More(more, round)) => {
                    rounds.push(round);
                    now = *more;
                    stop = self.ends(&now, rounds.len(), weak).unwrap_or(stop);
                }
                Some(SecondPass::Near(round)) => {
                    if let Some(last) = rounds.last_mut() {
                        last.rivals.extend(round.rivals.iter().filter(|r| r.delta_bic < WORTH).cloned());
                    }
                    fruitless = Some(round);
                }
                None => {}
            }
        }
        // A model that leaves nothing but noise was screened by the second pass alone, if at all.
        let first = first.or_else(|| {
            Some(screened(&screen(
                &base.settled(),
                &base.cal,
                self.catalogue,
                self.noise,
                Target::AlongData,
            )?))
        });
        let all: Vec<&Round> = rounds.iter().chain(&fruitless).collect();
        let tried = after_fits(first.unwrap_or_default(), &all, &now);
        Ok(Searched {
            base,
            last: now,
            rounds,
            candidates,
            stop,
            needed: vec![],
            tried,
            force: None,
            changed,
        })
    }

    /// The reason why the search ends after this number of rounds, `weak` of which were weak; `None` if it
    /// goes on.
    fn ends(&self, now: &Fitted, rounds: usize, weak: usize) -> Option<StopReason> {
        let effects = now.model.effects.len();
        // The last effect is allowed only where the gap is small. A model with that many effects explains
        // nothing, but the last one may make others needless.
        let too_far = effects + 1 == MOST_EFFECTS && now.score.fit > FAR_OFF * self.floor.max(1.0);
        if now.score.is_white() {
            Some(StopReason::White)
        } else if effects >= MOST_EFFECTS || too_far {
            Some(StopReason::EffectLimit)
        } else if self.at_floor(now) && rounds > 0 {
            Some(StopReason::Repeatability)
        } else if weak > 1 || (weak > 0 && rounds > 2) {
            Some(StopReason::WeakSteps)
        } else {
            None
        }
    }

    /// One round: adds the best single law or the best pair, or ends the search.
    fn round(&mut self, start: &Start<'_>) -> (Result<Fitted, StopReason>, Round) {
        let Start { now, candidates, .. } = *start;
        let before = start.before();
        let mut vetoed: Vec<Vetoed> = Vec::new();
        let singles = self.best_singles(start, &mut vetoed);
        let best = self.worthy(now, &singles, candidates);
        // A law of many parameters may stand for two simple laws, so pairs are fitted too.
        let plain = |f: &Fitted| f.model.effects[before..].iter().all(|a| !is_composed(&a.effect));
        let enough = |b: &&Fitted| b.score.is_white() && plain(b) || self.inputs_leave(b, start.drawing);
        if let Some(best) = best.as_ref().filter(enough) {
            let best = self.simplified(best.clone(), candidates);
            let best = self.exchanged(self.relocated(best, candidates), candidates);
            let round = round(now, &best, &singles, vetoed, candidates);
            return (Ok(best), round);
        }
        if before == 0 && self.is_pushed(now, &singles, candidates) {
            return (Err(StopReason::Pushes), round(now, now, &singles, vetoed, candidates));
        }
        let (pairs, pair) = self.best_pairs(start, &singles, best.as_ref(), &mut vetoed);
        let settled = pair.as_ref().filter(|pair| !pair.score.is_white()).map(|pair| placed(&pair.model));
        let all: Vec<Fitted> = singles.into_iter().chain(pairs).collect();
        let Some(chosen) = one_or_two(best, pair, before, candidates) else {
            return (Err(StopReason::NothingHelps), round(now, now, &all, vetoed, candidates));
        };
        let chosen = self.simplified(chosen, candidates);
        let chosen =
            if settled == Some(placed(&chosen.model)) { chosen } else { self.relocated(chosen, candidates) };
        let chosen = self.exchanged(chosen, candidates);
        let by = Measure::of([&chosen.score, &now.score], candidates);
        let gain = by.criterion(&now.score) - by.criterion(&chosen.score);
        if chosen.model.effects.len() <= before && gain <= WORTH {
            return (Err(StopReason::NothingHelps), round(now, now, &all, vetoed, candidates));
        }
        let round = round(now, &chosen, &all, vetoed, candidates);
        (Ok(chosen), round)
    }

    /// Whether the model as it is leaves nothing between a few pushes, and no law comes near that: then no second law and no
    /// formula says more.
    fn is_pushed(&self, now: &Fitted, singles: &[Fitted], candidates: usize) -> bool {
        if singles.iter().any(|f| takes_most(f, now)) {
            return false;
        }
        let pushed = now.settled().pushes(&now.cal.records, self.noise, &|| self.observer.stopped());
        let laws = fitted_alone(now, singles.iter(), &[], candidates);
        pushed.is_some_and(|p| p.is_sure(now, candidates, laws.iter().map(|(_, _, gain)| *gain)))
    }

    /// Models with one effect more, best first: the leading laws of the screening, then relatives of the
    /// leader.
    fn best_singles(&self, start: &Start<'_>, vetoed: &mut Vec<Vetoed>) -> Vec<Fitted> {
        let Start { now, model, screening, candidates, .. } = start;
        let mut models = self.extended(model, now, screening);
        models.extend(self.richer(model, now));
        if !now.rests() {
            models.extend(self.static_friction(model));
        }
        let mut singles = self.fit_race(models, RACE, *candidates, vetoed);
        // What a leading law contains is fitted whatever its segments cost: on a coarse grid the richer law
        // starts nearer.
        let contained = self.contained(model, screening, &singles);
        if !contained.is_empty() {
            singles.extend(self.fit_race(contained, ALL, *candidates, vetoed));
            rank(&mut singles, *candidates);
        }
        if singles.first().is_some_and(|leader| !leader.score.is_white()) {
            singles.extend(self.fit_race(self.at_other_places(model, &singles), ALL, *candidates, vetoed));
            rank(&mut singles, *candidates);
        }
        let with_memory = self.with_memory(model, screening, &singles);
        if !with_memory.is_empty() {
            singles.extend(self.fit_race(with_memory, ALL, *candidates, vetoed));
            rank(&mut singles, *candidates);
        }
        // The whole family of the law that leaves least is fitted; where a sibling leaves less, once more from that one.
        // Parameters of a narrow curve are hard to find by a regression, and easy from a fitted sibling.
        for _ in 0..FAMILY_ROUNDS {
            let Some(leader) = nearest(&singles) else { break };
            let (own, siblings) = (placed(&leader.model), self.siblings(model, leader));
            singles.extend(self.fit_race(siblings, ALL, *candidates, vetoed));
            if nearest(&singles).is_some_and(|leader| placed(&leader.model) == own) {
                break;
            }
        }
        rank(&mut singles, *candidates);
        singles
    }

    /// The model with each law that the leader of these fits contains, at its place, unless it was fitted.
    fn contained(&self, model: &TrialModel, screening: &Screening, singles: &[Fitted]) -> Vec<TrialModel> {
        let last = |f: &Fitted| f.model.effects.last().map(|a| a.effect.clone());
        let Some(leader) = singles.first().and_then(last) else { return vec![] };
        let fitted = |c: &Candidate| singles.iter().filter_map(last).any(|e| e.same(&c.effect));
        let wanted = |c: &&Candidate| {
            leader.entry.law.has_memory() && c.effect.is_simpler_form_of(&leader) && !fitted(c)
        };
        let laws = screening.candidates.iter().filter(wanted).collect();
        let lists = self.best_starts(model, laws);
        lists.iter().filter_map(|list| model.with_all(list).ok()).collect()
    }

    /// Models with two effects more, best first, and the one that is worth its price. `single` is the best
    /// model with one.
    fn best_pairs(
        &self,
        start: &Start<'_>,
        singles: &[Fitted],
        single: Option<&Fitted>,
        vetoed: &mut Vec<Vetoed>,
    ) -> (Vec<Fitted>, Option<Fitted>) {
        let Start { now, model, screening, candidates, .. } = start;
        let price = (now.cal.samples as f64).ln();
        // Pairs matter in the first round, where a greedy choice may be wrong. Later rounds have their
        // friction already.
        let wanted = if start.before() == 0 { PAIRS_RACED } else { 0 };
        let mut pairs: Vec<Vec<Effect>> =
            screening.pairs(price, wanted).into_iter().map(|(a, b)| vec![a.effect, b.effect]).collect();
        pairs.extend(singles.first().map_or(vec![], |leader| self.decompositions(model, leader, screening)));
        if wanted > 0 {
            pairs.extend(friction_pairs(screening));
        }
        // Where one law explains the data, only pairs with no more parameters are of interest.
        if let Some(enough) = single.filter(|b| b.score.is_white()).map(|b| b.score.parameters) {
            let parameters =
                |pair: &[Effect]| pair.iter().map(|e| e.size(model.fit_records())).sum::<usize>();
            pairs.retain(|pair| model.size() + parameters(pair) <= enough);
        }
        let models: Vec<TrialModel> = pairs.iter().filter_map(|list| model.with_all(list).ok()).collect();
        // Segments tell little of a motion that sticks.
        let smooth = |b: &&Fitted| b.score.is_white() && !b.rests() && !b.has_clearance();
        let leader = single.filter(smooth);
        let settled = leader.map(Fitted::settled);
        let cost = |model: &TrialModel, stride: usize| model.segment_cost(self.noise, stride);
        let models = self.near(models, settled.as_ref().and_then(|b| cost(b, SEEDED_STRIDE)));
        let rival = leader.zip(settled.and_then(|b| cost(&b, 1)));
        let mut pairs = self.fit_race_against(rival, models, RACE, *candidates, vetoed);
        if let Some(pair) = self.worthy(now, &pairs, *candidates).filter(|pair| pair.score.is_white()) {
            pairs = self.with_competitors(pairs, singles, &pair, *candidates, vetoed);
        }
        let pair = self.worthy(now, &pairs, *candidates);
        // A pair that leaves little may have its effects at wrong places.
        let pair =
            pair.map(|pair| if pair.score.is_white() { pair } else { self.relocated(pair, *candidates) });
        (pairs, pair)
    }

    /// The models that a part of the segments does not show to be far behind, as most are: behind the best
    /// one, or behind `rival`, what a fitted model leaves there.
    fn near(&self, models: Vec<TrialModel>, rival: Option<f64>) -> Vec<TrialModel> {
        let cost = |model: TrialModel| {
            let own = model.segment_cost(self.noise, SEEDED_STRIDE)?;
            Some((model.is_flattered(), own, model))
        };
        let costed: Vec<(bool, f64, TrialModel)> = models.into_par_iter().filter_map(cost).collect();
        let limits =
            limits(RACE * RACE, rival, costed.iter().map(|(flattered, cost, _)| (*flattered, *cost)));
        costed
            .into_iter()
            .filter(|(flattered, cost, _)| *cost <= limits[usize::from(*flattered)])
            .map(|(.., model)| model)
            .collect()
    }

    /// The preferred one of these models, if it is worth its price.
    fn worthy(&self, now: &Fitted, all: &[Fitted], candidates: usize) -> Option<Fitted> {
        preferred(all, candidates).filter(|best| worth(now, best, candidates)).cloned()
    }

    /// Looks for one more effect beside a model whose residual is white: a weak second effect hardly changes
    /// the whiteness. Applies to smooth motions only, because the linear response does not describe stops.
    /// `first` is what the first screening of the search tried, if there was one. `None` where nothing was fitted.
    fn second_pass(
        &self,
        now: &Fitted,
        candidates: usize,
        first: &mut Option<(Vec<Tried>, Vec<NotTried>)>,
    ) -> Option<SecondPass> {
        let before = now.model.effects.len();
        if before + 1 >= MOST_EFFECTS || !now.score.is_white() || now.rests() {
            return None;
        }
        let model = now.settled();
        let mut screening = screen(&model, &now.cal, self.catalogue, self.noise, Target::AlongData)?;
        first.get_or_insert_with(|| screened(&screening));
        let candidates = candidates.max(screening.candidates.len());
        let price = (now.cal.samples as f64).ln();
        let pays = |c: &Candidate| c.gain > price * c.size as f64;
        screening.candidates.retain(pays);
        if screening.candidates.is_empty() {
            return None;
        }
        // What the residuals of the fit do not hold is an error of the smoothed motion, or of the inputs
        // between samples.
        let named = |entry: &&LawEntry| screening.candidates.iter().any(|c| c.effect.entry.id == entry.id);
        let asked: Vec<LawEntry> = self.catalogue.iter().filter(named).cloned().collect();
        let of_fit = screen(&model, &now.cal, &asked, self.noise, Target::OfFit(&now.cal))?;
        let held =
            |c: &Candidate| of_fit.candidates.iter().any(|own| own.effect.same(&c.effect) && pays(own));
        screening.candidates.retain(held);
        let mut vetoed = Vec::new();
        let all = self.fit_race(self.extended(&model, now, &screening), RACE, candidates, &mut vetoed);
        // A base model may be complete, so a first effect must gain twice the usual amount.
        let extra = if before == 0 { WORTH } else { 0.0 };
        let more = |f: &&Fitted| {
            let by = Measure::of([&now.score, &f.score], candidates);
            let gain = by.criterion(&now.score) - by.criterion(&f.score);
            f.score.is_white() && worth(now, f, candidates) && gain > WORTH + extra
        };
        let Some(best) = preferred(&all, candidates).filter(more).cloned() else {
            return Some(SecondPass::Near(round_from(0, now, now, &all, vetoed, candidates)));
        };
        // The effects found first may have compensated for part of the new one.
        let effects = current(&best);
        let without = |k: usize| {
            let rest: Vec<Effect> =
                effects.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, e)| e.clone()).collect();
            refitted(model.without_effects().with_all(&rest).ok()?, &best, self.noise)
        };
        let mut rest: Vec<Fitted> = (0..before).filter_map(without).collect();
        rank(&mut rest, candidates);
        let mut all = self.with_competitors(all, &rest, &best, candidates, &mut vetoed);
        let best = preferred(&all, candidates).cloned().unwrap_or(best);
        let best = self.exchanged(self.simplified(best, candidates), candidates);
        let first = placed(&now.model);
        let extends = |f: &Fitted| placed(&f.model).starts_with(&first);
        let from = if extends(&best) { before } else { 0 };
        all.retain(|f| from == 0 || extends(f));
        let round = round_from(from, now, &best, &all, vetoed, candidates);
        Some(SecondPass::More(Box::new(best), round))
    }

    /// Adds competitors to `pairs`, where `pair` explains the data. Takes the best of `singles` that is a
    /// part of `pair`, screens beside it, and fits every law that ranks above the other part. The first
    /// screening may have confused similar laws, because the linear response is inexact far from the data.
    fn with_competitors(
        &self,
        mut pairs: Vec<Fitted>,
        singles: &[Fitted],
        pair: &Fitted,
        candidates: usize,
        vetoed: &mut Vec<Vetoed>,
    ) -> Vec<Fitted> {
        let parts = placed(&pair.model);
        let Some(single) = singles.iter().find(|f| placed(&f.model).iter().all(|own| parts.contains(own)))
        else {
            return pairs;
        };
        let model = single.settled();
        let Some(mut screening) = screen(&model, &single.cal, self.catalogue, self.noise, Target::AlongData)
        else {
            return pairs;
        };
        let own = |c: &Candidate| pair.model.effects.iter().any(|a| a.effect.same(&c.effect));
        let better = screening.candidates.iter().position(own).unwrap_or(screening.candidates.len());
        screening.candidates.truncate(better);
        pairs.extend(self.fit_race(self.extended(&model, single, &screening), RACE, candidates, vetoed));
        rank(&mut pairs, candidates);
        pairs
    }

    /// The model with each of the leading laws of a screening, from the best of their starts.
    fn extended(&self, model: &TrialModel, now: &Fitted, screening: &Screening) -> Vec<TrialModel> {
        let lists = if now.rests() || now.has_clearance() || model.system.jumps() {
            self.ranked_by_free_run(model, screening)
        } else {
            self.best_starts(model, singles(screening))
        };
        lists.iter().filter_map(|list| model.with_all(list).ok()).collect()
    }

    /// Fits the models whose segment cost is within `race` of the best, sorted by the criterion, without
    /// those that evidence rules out. If the leader is ruled out, the race is repeated among the others,
    /// which it may have eliminated wrongly. Laws that short segments flatter do not race against the others.
    pub(crate) fn fit_race(
        &self,
        models: Vec<TrialModel>,
        race: f64,
        candidates: usize,
        vetoed: &mut Vec<Vetoed>,
    ) -> Vec<Fitted> {
        self.fit_race_against(None, models, race, candidates, vetoed)
    }

    /// The same race, where a fitted model that explains the records runs too, with its segment cost.
    fn fit_race_against(
        &self,
        rival: Option<(&Fitted, f64)>,
        models: Vec<TrialModel>,
        race: f64,
        candidates: usize,
        vetoed: &mut Vec<Vetoed>,
    ) -> Vec<Fitted> {
        let mut waiting: Vec<Waiting> = self.compared(models);
        // Fitted models with their segment costs.
        let mut done: Vec<(f64, Fitted)> = Vec::new();
        loop {
            let raced = waiting.iter().map(|w| (w.model.is_flattered(), w.cost()));
            let raced = raced.chain(done.iter().map(|(cost, f)| (f.model.is_flattered(), *cost)));
            let limits = limits(race, rival.map(|(_, cost)| cost), raced);
            let (now, later): (Vec<_>, Vec<_>) =
                waiting.into_iter().partition(|w| w.cost() <= limits[usize::from(w.model.is_flattered())]);
            done.extend(self.fitted(now, rival.map(|(fitted, _)| fitted), candidates));
            let by = Measure::of(done.iter().map(|(_, f)| &f.score), candidates);
            done.sort_by(|(_, a), (_, b)| by.criterion(&a.score).total_cmp(&by.criterion(&b.score)));
            let names = |of: &[(f64, Fitted)]| of.iter().map(|(_, f)| placed(&f.model)).collect::<Vec<_>>();
            let all = names(&done);
            done.retain(|(_, f)| !ruled_out(f, vetoed));
            let left = names(&done);
            if later.is_empty() || rival.is_some() || all.first() == left.first() {
                return done.into_iter().map(|(_, f)| f).collect();
            }
            waiting = later;
            waiting.retain(|w| !all.contains(&placed(&w.model)) || left.contains(&placed(&w.model)));
        }
    }

    /// The first iterations of the fit of each model over segments.
    fn compared(&self, models: Vec<TrialModel>) -> Vec<Waiting> {
        let (all, done) = (models.len(), AtomicUsize::new(0));
        let compare = |model: TrialModel| {
            let segments = if self.observer.stopped() { None } else { model.segment_fit(self.noise) };
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            self.observer.tell(part(&model), Activity::Comparing { round: self.observer.round(), done, all });
            Waiting { model, segments }
        };
        models.into_par_iter().map(compare).collect()
    }

    /// Fits models, each given with its segment cost; failed fits are dropped. `leader` explains the
    /// records.
    fn fitted(&self, models: Vec<Waiting>, leader: Option<&Fitted>, candidates: usize) -> Vec<(f64, Fitted)> {
        let tally = Tally::of(self.observer.round(), models.len());
        let fit = |models: Vec<Waiting>, beside_leader: Option<&Fitted>| -> Vec<(f64, Fitted)> {
            let fit = |w: Waiting| {
                if self.observer.stopped() {
                    return None;
                }
                let (cost, part) = (w.cost(), part(&w.model));
                // A law that loses is shown with what it leaves, a pair is not.
                let effort = beside_leader.map_or(Effort::Plain, |b| beside(b, leader.is_none()));
                let fitted = Fitted::from(w.model, w.segments.as_ref(), self.noise, effort).ok();
                self.observer.tell(part, tally.one_more(fitted.as_ref()));
                Some((cost, fitted?))
            };
            models.into_par_iter().filter_map(fit).collect()
        };
        // The best over segments goes first, then the best that these flatter: a law that leaves more
        // even on segments than one of them does in its runs need not be fitted to the end, unless evidence
        // rules that one out.
        let mut models = models;
        models.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
        let mut all: Vec<(f64, Fitted)> = Vec::new();
        for flattered in [false, true] {
            let first = models.iter().position(|w| w.model.is_flattered() == flattered);
            if let Some(first) = first.filter(|_| leader.is_none()) {
                let first = models.remove(first);
                all.extend(fit(vec![first], strongest(&all)));
            }
        }
        all.extend(fit(models, leader.or(strongest(&all))));
        all.retain(|(_, f)| f.score.fit.is_finite());
        let by = Measure::of(all.iter().map(|(_, f)| &f.score), candidates);
        all.sort_by(|(_, a), (_, b)| by.criterion(&a.score).total_cmp(&by.criterion(&b.score)));
        // Models near the best are fitted again from more starts: runs through stops have local minima.
        let least = all.iter().map(|(_, f)| f.score.fit).fold(f64::INFINITY, f64::min);
        let near = |f: &Fitted| {
            (f.score.fit < WORTH_STARTS * least || f.score.fit < WORTH_STARTS)
                && f.may_gain()
                && !f.cal.hopeless
        };
        all.par_iter_mut().take(MORE_STARTS).filter(|(_, f)| near(f)).for_each(|(_, f)| {
            let thorough = Fitted::new(f.settled(), self.noise, Effort::Thorough);
            if let Ok(better) = thorough
                && better.score.fit < f.score.fit
            {
                *f = better;
            }
        });
        all
    }

    /// Whether a simpler model is as good. Where neither residual is white, the richer law must predict
    /// Validate records better.
    pub(crate) fn as_good(&self, simple: &Fitted, rich: &Fitted, candidates: usize) -> bool {
        let by = Measure::of([&simple.score, &rich.score], candidates);
        by.criterion(&simple.score) - by.criterion(&rich.score) < SIMPLER
            || predicts_no_better(&simple.score, &rich.score)
    }
}

/// The largest segment cost with which a model stays in a race: of models that short segments do not flatter, and of those
/// that they flatter. Each cost comes with whether they flatter its model.
fn limits(race: f64, rival: Option<f64>, raced: impl Iterator<Item = (bool, f64)> + Clone) -> [f64; 2] {
    let least = |flattered: bool| {
        let others = raced.clone().filter(|(other, _)| flattered || !other);
        others.map(|(_, cost)| cost).fold(rival.unwrap_or(f64::INFINITY), f64::min)
    };
    [false, true].map(|flattered| race * least(flattered))
}

/// The model that leaves least of the Fit records.
fn nearest(all: &[Fitted]) -> Option<&Fitted> {
    all.iter().min_by(|a, b| a.score.fit.total_cmp(&b.score.fit))
}

/// The model with the least misfit that evidence does not rule out.
fn strongest(all: &[(f64, Fitted)]) -> Option<&Fitted> {
    all.iter().map(|(_, f)| f).filter(|f| stands(f)).min_by(|a, b| a.score.fit.total_cmp(&b.score.fit))
}

/// A model of a race, with the first iterations of its fit over segments.
struct Waiting {
    model: TrialModel,
    segments: Option<SegmentFit>,
}

impl Waiting {
    /// The cost over segments; infinite where the model cannot be simulated.
    fn cost(&self) -> f64 {
        self.segments.as_ref().map_or(f64::INFINITY, |fit| fit.cost)
    }
}

/// How hard to fit a rival of a fitted model. Segments leave no more than a single run, so one that
/// leaves more there than the leader in its runs, by more than the parameters of that one cost, loses.
fn beside(leader: &Fitted, runs: bool) -> Effort {
    let samples = leader.cal.samples as f64;
    let cheaper = leader.score.occam.price(1.0);
    let left = leader.score.fit.powi(2);
    Effort::Rival { most: left * (SEGMENTS_END + (WORTH + cheaper) / samples), runs }
}

/// The part of a search that is done where models of so many effects are fitted.
fn part(model: &TrialModel) -> f64 {
    0.1 + ROUND * model.effects.len() as f64
}

/// Counts the fits of a race.
struct Tally {
    round: RoundStart,
    all: usize,
    /// Fits that ended, and the best of them.
    so_far: Mutex<(usize, Option<Leader>)>,
}

impl Tally {
    fn of(round: RoundStart, all: usize) -> Tally {
        Tally { round, all, so_far: Mutex::new((0, None)) }
    }

    /// One more fit has ended.
    fn one_more(&self, fitted: Option<&Fitted>) -> Activity {
        let mut so_far = self.so_far.lock().unwrap_or_else(PoisonError::into_inner);
        so_far.0 += 1;
        if let Some(fitted) = fitted
            && so_far.1.as_ref().is_none_or(|best| fitted.score.gap() < best.gap)
        {
            so_far.1 = Some(Leader { laws: placed(&fitted.model), gap: fitted.score.gap() });
        }
        Activity::Fitting { round: self.round, done: so_far.0, all: self.all, best: so_far.1.clone() }
    }
}

/// Whether `next` is worth its price against `now`.
fn worth(now: &Fitted, next: &Fitted, candidates: usize) -> bool {
    let by = Measure::of([&now.score, &next.score], candidates);
    let gain = by.criterion(&now.score) - by.criterion(&next.score);
    let carries = match (now.score.predictive, next.score.predictive) {
        (Some(before), Some(after)) => after < SHRINKS * before || (next.score.is_white() && after < before),
        _ => true,
    };
    // A motion that is sensitive to every parameter is missed on Validate records while any effect is
    // missing, so these do not count as long as the gap on Fit records is large and falls fast.
    makes_progress(&now.score, &next.score) || (gain > WORTH && carries)
}

/// The better one of the best single law and the best pair. A pair of more parameters is worth its price or
/// does not count, and one that does not explain the data needs a clear gain over its single part; otherwise
/// the greedy search goes on.
fn one_or_two(
    single: Option<Fitted>,
    pair: Option<Fitted>,
    before: usize,
    candidates: usize,
) -> Option<Fitted> {
    let (single, pair) = match (single, pair) {
        (Some(single), Some(pair)) => (single, pair),
        (single, pair) => return single.or(pair),
    };
    let by = Measure::of([&single.score, &pair.score], candidates);
    let price = if pair.score.parameters > single.score.parameters { WORTH } else { 0.0 };
    let better = by.criterion(&pair.score) + price < by.criterion(&single.score);
    let (own, both) = (label(&single.model, before), label(&pair.model, before));
    let lower = pair.score.predictive.zip(single.score.predictive).is_none_or(|(p, s)| p < ON_THE_WAY * s);
    let much = lower || makes_progress(&single.score, &pair.score) || !own.iter().all(|e| both.contains(e));
    Some(if better && (pair.score.is_white() || much) { pair } else { single })
}

/// Whether evidence rules out a model; notes the law and the reason.
fn ruled_out(model: &Fitted, vetoed: &mut Vec<Vetoed>) -> bool {
    // The numbers of a fit that was given up speak neither for it nor against it.
    if model.cal.hopeless {
        return false;
    }
    let veto = model.model.effects.iter().find_map(|a| Some((&a.effect, against(model, &a.effect)?)));
    let Some((effect, why)) = veto else { return false };
    let own = Vetoed { law: PlacedLaw::of(effect), why, score: model.score.clone() };
    match vetoed.iter_mut().find(|v| v.law.law == own.law.law) {
        Some(told) if own.score.fit < told.score.fit => *told = own,
        Some(_) => {}
        None => vetoed.push(own),
    }
    true
}

/// The report of a round: the nearest rivals of the chosen model and the vetoed laws.
fn round(now: &Fitted, chosen: &Fitted, all: &[Fitted], vetoed: Vec<Vetoed>, candidates: usize) -> Round {
    round_from(now.model.effects.len(), now, chosen, all, vetoed, candidates)
}

/// The same where rivals are told from effect `before` on.
pub(crate) fn round_from(
    before: usize,
    now: &Fitted,
    chosen: &Fitted,
    all: &[Fitted],
    mut vetoed: Vec<Vetoed>,
    candidates: usize,
) -> Round {
    // The fit that leaves least decides whether a law is ruled out.
    let better = |v: &Vetoed, f: &Fitted| {
        let alone = matches!(&label(&f.model, before)[..], [one] if one.law == v.law.law);
        alone && !f.cal.hopeless && f.score.fit <= v.score.fit
    };
    vetoed.retain(|v| !all.iter().any(|f| better(v, f)));
    let fitted = fitted_alone(now, all.iter().chain([chosen]), &vetoed, candidates);
    let own = label(&chosen.model, 0);
    let by = Measure::of(all.iter().chain([chosen]).map(|f| &f.score), candidates);
    // A law and the two whose sum it is are one force.
    let answer = forces(&chosen.model);
    let mut rivals: Vec<(Vec<(&str, &str)>, Rival)> = all
        .iter()
        .map(|f| (forces(&f.model), f))
        .filter(|(forces, f)| *forces != answer && f.model.effects.len() > before)
        .map(|(forces, f)| (forces, rival(f, before, by.criterion(&f.score) - by.criterion(&chosen.score))))
        .collect();
    rivals.sort_by(|a, b| a.1.delta_bic.total_cmp(&b.1.delta_bic));
    let mut told: Vec<Vec<(&str, &str)>> = Vec::new();
    rivals.retain(|(forces, _)| {
        let new = !told.contains(forces);
        told.push(forces.clone());
        new
    });
    let mut rivals: Vec<Rival> = rivals.into_iter().map(|(_, rival)| rival).collect();
    let out = |r: &Rival| matches!(&r.laws[..], [one] if vetoed.iter().any(|v| v.law.law == one.law));
    rivals.retain(|r| r.delta_bic.is_finite() && !out(r));
    rivals.truncate(RIVALS);
    // A law of the chosen model may be ruled out at another place; that is not reported.
    let chosen_law = |law: &str| own.iter().any(|chosen| chosen.law == law);
    let vetoed = vetoed.into_iter().filter(|v| !chosen_law(&v.law.law)).collect();
    Round { before, rivals, vetoed, fitted }
}

/// The effects of a model by law and place, in order; a law that is the sum of two others as these.
fn forces(model: &TrialModel) -> Vec<(&str, &str)> {
    let mut all = Vec::new();
    for Effect { entry, place, .. } in model.effects.iter().map(|a| &a.effect) {
        let parts = if entry.law.same_as.len() == 2 {
            entry.law.same_as.as_slice()
        } else {
            std::slice::from_ref(&entry.id)
        };
        all.extend(parts.iter().map(|id| (id.as_str(), place.at.as_str())));
    }
    all.sort_unstable();
    all
}

/// The models with one effect more than `now`, and the fits that ruled a law out: law and place, the gap that is left, the gain
/// of the criterion.
fn fitted_alone<'f>(
    now: &Fitted,
    all: impl Iterator<Item = &'f Fitted>,
    vetoed: &[Vetoed],
    candidates: usize,
) -> Vec<(PlacedLaw, f64, f64)> {
    let alone = all.filter(|f| f.model.effects.len() == now.model.effects.len() + 1);
    let last = |f: &'f Fitted| Some((PlacedLaw::of(&f.model.effects.last()?.effect), &f.score));
    let out = vetoed.iter().map(|v| (v.law.clone(), &v.score));
    let all: Vec<(PlacedLaw, &Score)> = alone.filter_map(last).chain(out).collect();
    let by = Measure::of(all.iter().map(|(_, score)| *score).chain([&now.score]), candidates);
    let of = |(law, score): (PlacedLaw, &Score)| {
        (law, score.gap(), by.criterion(&now.score) - by.criterion(score))
    };
    all.into_iter().map(of).collect()
}

/// What a screening tried, and what it could not try.
fn screened(screening: &Screening) -> (Vec<Tried>, Vec<NotTried>) {
    let price = screening.samples.ln();
    let of = |c: &Candidate| Tried {
        at: PlacedLaw::of(&c.effect),
        score: c.gain - price * c.size as f64,
        gap: None,
        probability: None,
        vetoed: None,
    };
    let mut all: Vec<Tried> = screening.candidates.iter().map(of).collect();
    // A law and its mirror image, or with several loads, count once.
    let mut kept: Vec<Tried> = Vec::new();
    for tried in all.drain(..) {
        if !kept.iter().any(|k| k.at == tried.at) {
            kept.push(tried);
        }
    }
    (kept, screening.left_out.clone())
}

/// What was tried in the first screening, with what its fits say, best first.
fn after_fits(
    (mut tried, mut left_out): (Vec<Tried>, Vec<NotTried>),
    rounds: &[&Round],
    last: &Fitted,
) -> (Vec<Tried>, Vec<NotTried>) {
    for t in &mut tried {
        let Some(round) = rounds.first() else { break };
        let own = round.fitted.iter().filter(|(at, ..)| *at == t.at);
        if let Some((_, gap, score)) = own.max_by(|a, b| a.2.total_cmp(&b.2)) {
            (t.gap, t.score) = (Some(*gap), *score);
        }
        t.vetoed = round.vetoed.iter().find(|v| v.law == t.at).map(|v| v.why.clone());
    }
    weighed(&mut tried);
    let order = |t: &Tried| (t.gap.is_none(), t.vetoed.is_some());
    tried.sort_by(|a, b| order(a).cmp(&order(b)).then(b.score.total_cmp(&a.score)));
    // Beside other effects a law may have been fitted after all.
    let alone = rounds.iter().flat_map(|r| r.fitted.iter().map(|(at, ..)| &at.law));
    let fitted: HashSet<&String> =
        alone.chain(last.model.effects.iter().map(|a| &a.effect.entry.id)).collect();
    left_out.retain(|law| !fitted.contains(&law.law));
    (tried, left_out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::{effect, fitted, slowly_driven};

    /// Evidence against a worse fit of a law does not rule the law out. A rival starts where its fit ended.
    #[test]
    fn a_law_is_ruled_out_by_the_fit_that_leaves_least() {
        let (base, noise) = slowly_driven("-0.3*sgn(v)");
        let with = |id: &str, law: &str| {
            fitted(base.with(&effect(&base, id, law, "v", &[0.1])).expect("a model"), &noise)
        };
        let coulomb = with("coulomb", include_str!("../../phys/laws/coulomb.ron"));
        let viscous = with("viscous", include_str!("../../phys/laws/viscous.ron"));
        let round = |left: f64| {
            let law = PlacedLaw::of(&viscous.model.effects[0].effect);
            let score = Score { fit: left, ..viscous.score.clone() };
            let vetoed = vec![Vetoed { law, why: Veto::FeedsMotion, score }];
            let now = fitted(base.clone(), &noise);
            round_from(0, &now, &coulomb, std::slice::from_ref(&viscous), vetoed, 2)
        };
        let told = |round: &Round| (round.rivals.len(), round.vetoed.len());
        let (better, worse) = (round(1.1 * viscous.score.fit), round(0.9 * viscous.score.fit));
        assert_eq!((told(&better), told(&worse)), ((1, 0), (0, 1)));
        let rival = better.rivals[0].model.as_deref().expect("a model").clone();
        let again = Fitted::new(rival, &noise, Effort::Thorough).expect("a fit");
        assert!(again.score.fit <= 1.000_01 * viscous.score.fit, "{}", again.score.fit);
    }
}
