//! The end of the workflow: the verdict on the model of a search, doubts, other explanations, the result.

mod noise;
mod probability;

use crate::alternative_constant::alternative_constant;
use crate::changed_constants::ChangedConstants;
use crate::data_mistakes::data_mistakes;
use crate::decisions::{REPEATS, SAME_FREQUENCY, SAME_MOTION, SUBSTANTIAL, WORTH};
use crate::drive::Drive;
use crate::drive_frequency::drive_frequency;
use crate::formula::{DISCOVERED, expansion};
use crate::input_interpolation::{Redrawn, beyond_noise, coarse_inputs, redrawn};
use crate::model::{
    Applied, ColumnError, Fitted, Measure, Score, TrialModel, current, expression, most_apart_beforehand,
    probability_beside, text_with, values,
};
use crate::none_of_these::probability as probability_of_none;
use crate::other_causes::{causes, input_noise};
use crate::place::Site;
use crate::plausibility::{cancelling, pressed, vetoed};
use crate::pushes::{Pushed, takes_most};
use crate::result::verdict::{bent, helpful, refused, status};
use crate::result::{
    Activity, Alternative, Cancelling, ColumnGap, ColumnRepeat, Gap, GapError, InputError, MissingForce,
    Named, NotTried, PlacedLaw, Push, RecordValue, Region, Rival, Simulated, Status, Step, StepParameter,
    StopReason, Tried, Veto, Vetoed, Warning, observed_ranges, regions,
};
use crate::search::{Round, SEARCHED, Search, Searched, placed, refitted, rival, round_from};
use crate::sensor_linearity::sensor_nonlinearity;
use crate::spec_mistakes::spec_mistake;
use phisindy_learn::{Effort, FoundParameter, Identified, at_bounds, free_run_horizons, sensitive_starts};
use phisindy_phys::spec::Role;
use phisindy_signal::Interpolation;
use probability::rivals_of_the_answer;
use rayon::prelude::*;

/// The state after the search: the verdict, other explanations and the result follow from it.
pub(crate) struct Ending<'s, 'a> {
    search: &'s mut Search<'a>,
    base: Fitted,
    last: Fitted,
    /// The models with no effect, the first effect, the first two, and so on.
    path: Vec<Fitted>,
    rounds: Vec<Round>,
    candidates: usize,
    stop: StopReason,
    /// The effects without which nothing as good was found.
    needed: Vec<PlacedLaw>,
    tried: (Vec<Tried>, Vec<NotTried>),
    force: Option<MissingForce>,
    changed: Option<ChangedConstants>,
    noise: Vec<Vec<f64>>,
    warnings: Vec<Warning>,
    /// Whether near rivals were fitted as hard as the final model.
    compared: bool,
    /// The gap that the drawing of the inputs between their samples leaves open; 0 where it is no excuse.
    open: f64,
}

impl<'s, 'a> Ending<'s, 'a> {
    /// Rescales all gaps to the noise that the best model leaves, drops needless effects and computes error
    /// bars.
    pub(crate) fn new(
        searched: Searched,
        search: &'s mut Search<'a>,
        mut warnings: Vec<Warning>,
    ) -> Result<Self, GapError> {
        let Searched { base, last, rounds, candidates, stop, needed, tried, force, changed } = searched;
        let (base, last) = (base.chosen(), last.chosen());
        let noise = last.noise_left(search.noise);
        let (base, last) = (base.measured_by(&noise), last.measured_by(&noise));
        warnings.extend(data_mistakes(&base).into_iter().map(Warning::Data));
        search.observer.tell(SEARCHED, Activity::ErrorBars);
        let mut path = path(&base, &last, &noise);
        let mut last = last;
        // Drops the last effect while the model is as good without it.
        while let [.., before] = &path[..]
            && path.len() > 1
            && needless(before, &last, candidates)
        {
            last = before.clone();
            path.pop();
        }
        let last = with_errors(last, &noise)?;
        if !last.model.effects.is_empty() {
            path.push(last.clone());
        }
        Ok(Ending {
            search,
            base,
            last,
            path,
            rounds,
            candidates,
            stop,
            needed,
            tried,
            force,
            changed,
            noise,
            warnings,
            compared: false,
            open: 0.0,
        })
    }

    /// The result.
    pub(crate) fn finished(mut self, text: &str, repeat: Vec<ColumnRepeat>) -> Result<Gap, GapError> {
        let redrawn = self.redraw_inputs()?;
        self.coarse_inputs()?;
        let floor = self.search.floor.max(self.open);
        let repeats = floor > 0.0 && self.last.score.gap() <= REPEATS * floor;
        let (status, warning) = status(&self.last.score, repeats, bent(&self.last));
        self.warnings.extend(warning);
        let status = if status == Status::Explained { self.without_hum()? } else { status };
        let (status, determined) = self.doubts(status);
        let searched = self.path.clone();
        let (status, alternative, determined) = self.other_explanations(status, repeats, determined)?;
        let determined =
            if status == Status::Unexplained { determined.min(self.late_doubts()) } else { determined };
        let (status, determined) = match alternative {
            Some(Alternative::InputNoise(_)) if !self.interrupted() => {
                self.refit_with_random_force();
                let free = self.late_doubts();
                let open = status == Status::Explained && free < self.last.model.effects.len();
                (if open { Status::Undetermined } else { status }, determined.min(free))
            }
            _ => (status, determined),
        };
        let (status, alternative, determined) = match self.pushes(status, alternative.as_ref(), &searched)? {
            Some(pushes) => (Status::Named, Some(Alternative::Pushes(pushes)), self.last.model.effects.len()),
            None => (status, alternative, determined),
        };
        let open_end = status == Status::Unexplained && alternative.is_none();
        let judged = if open_end { self.by_the_judge_of_run(searched, determined)? } else { None };
        let (status, determined) = judged.unwrap_or((status, determined));
        let found = |a: &Applied| a.effect.entry.id == DISCOVERED;
        let status = match status {
            Status::Explained if self.last.model.effects.iter().any(found) => Status::Described,
            other => other,
        };
        self.warnings.extend(alternative.clone().map(Warning::Alternative));
        self.warnings.extend(input_errors(&self.last).into_iter().map(Warning::InputError));
        self.warnings.extend(at_bounds(&self.last.cal.parameters).into_iter().map(Warning::Fit));
        self.warnings.extend(sensitive_starts(&self.last.cal.records).into_iter().map(Warning::Fit));
        if (self.last.score.explains() || self.open > 0.0) && !self.compared {
            self.compare_near_rivals();
        }
        let steps: Vec<Step> = (0..self.last.model.effects.len()).map(|k| self.step(k)).collect();
        // No result claims more than its own probability, and a formula no more than that of a force without one.
        let unlikely = |s: &Step| s.probability.is_some() && !s.is_sure();
        let unlikely_law = |s: &Step| unlikely(s) && s.effect.entry.id != DISCOVERED;
        // What is no more than the noise of the inputs leaves is no force.
        let by_inputs = matches!(&alternative, Some(Alternative::InputNoise(n)) if n.left <= n.most);
        let none =
            if self.interrupted() || by_inputs { None } else { probability_of_none(&self.last, &self.noise) };
        let status = match status {
            // With inputs drawn in another way the laws were not fitted.
            Status::NothingMissing
                if redrawn.is_none()
                    && (self.last.score.explains() || self.open > 0.0)
                    && !self.nothing_is_sure() =>
            {
                Status::Undetermined
            }
            Status::Explained if steps.iter().any(unlikely) => Status::Undetermined,
            Status::Described if none.is_some_and(|p| p > 0.5) || steps.iter().any(unlikely_law) => {
                Status::Undetermined
            }
            // Another force is there. Where the inputs may be drawn in another way, what brings the gap far down is named.
            Status::Explained if none.is_some_and(|p| p > 0.5) => {
                let named = self.open > 0.0 && substantial(&steps) == steps.len();
                if named { Status::Named } else { Status::Undetermined }
            }
            other => other,
        };
        // What is left of an answer is no force.
        let answered = matches!(status, Status::Explained | Status::Described)
            || matches!(&alternative, Some(Alternative::Pushes(_)));
        let none = none.filter(|p| *p <= 0.5 || !answered);
        // What was stopped was not compared with all that could do as well.
        let status = match status {
            Status::Explained | Status::Described | Status::Named if self.interrupted() => {
                Status::Undetermined
            }
            other => other,
        };
        let (mut steps, mut partial) =
            if status == Status::Unexplained { split_substantial(steps) } else { (steps, vec![]) };
        // An approximation is not named as what is missing.
        if steps.len() > determined {
            partial.splice(0..0, steps.drain(determined..));
        }
        for vetoed in self.rounds.iter().flat_map(|r| &r.vetoed) {
            // Later rounds see the same evidence with other digits.
            let kind = std::mem::discriminant(&vetoed.why);
            let same = |w: &Warning| {
                let Warning::Vetoed(v) = w else { return false };
                v.law == vetoed.law && std::mem::discriminant(&v.why) == kind
            };
            if !self.warnings.iter().any(same) {
                self.warnings.push(Warning::Vetoed(vetoed.clone()));
            }
        }
        if !self.last.model.effects.is_empty() {
            self.warnings.extend(one_frequency(&self.base.model, &repeat).map(Warning::OneFrequency));
        }
        let completed =
            text_with(text, &self.last.model, redrawn).map_err(|e| GapError::Numerics(e.into()))?;
        for rival in steps.iter_mut().chain(&mut partial).flat_map(|step| &mut step.rivals) {
            rival.completed = rival.model.take().and_then(|model| text_with(text, &model, redrawn).ok());
        }
        let stop = if self.interrupted() { StopReason::Interrupted } else { self.stop };
        let Ending { base, last, noise, warnings, tried: (tried, not_tried), force, .. } = self;
        Ok(Gap {
            status,
            stop,
            noise: column_noise(&base, &noise),
            none,
            located: located(&base, &noise),
            left: located(&last, &noise),
            steps,
            partial,
            tried,
            not_tried,
            force: force.filter(|_| status == Status::Unexplained),
            before: (base.score.fit, base.score.validate),
            after: (last.score.fit, last.score.validate),
            predictive: last.score.predictive,
            alternative,
            nrmse: nrmse(&base, &last),
            repeat,
            whiteness: (base.score.whiteness, last.score.whiteness),
            parameters: last.cal.parameters.clone(),
            completed,
            horizon: free_run_horizons(&last.model.system, &last.model.records, &last.cal.records),
            initial: Simulated::of(base),
            simulated: Simulated::of(last),
            warnings,
        })
    }

    /// Takes the numbers of the final model from the fit that leaves a random force on each body. The noise of an input
    /// is one: a free run sums it up and bends the numbers to it, by more than its intervals say.
    fn refit_with_random_force(&mut self) {
        if let Some(found) = self.with_random_force(&self.last) {
            self.take_numbers(&found);
        }
    }

    /// The criterion of a model beside a random force, and that fit. The noise of an input is a random force, and a free run
    /// bends each law to it.
    fn beside_a_random_force(&self, of: &Fitted) -> Option<(f64, Identified)> {
        let observer = &self.search.observer;
        let found = of.settled().refitted_with_random_force(&|| observer.stopped())?;
        Some((found.deviance? + of.score.price(self.candidates, of.score.independent()), found))
    }

    /// Compares the answer, whose criterion beside a random force is `own`, with the rivals of its last round. The best one is
    /// the answer if it leaves at most the gap `most`. Returns the criterion of the answer.
    fn compare_beside_a_random_force(&mut self, own: f64, most: f64) -> Result<f64, GapError> {
        let Some(k) = self.last_round() else { return Ok(own) };
        let compared = |rival: &Rival| {
            let model = rival.model.as_deref()?.clone();
            let mut fitted = Fitted::new(model, &self.noise, Effort::Thorough).ok()?;
            let (criterion, found) = self.beside_a_random_force(&fitted)?;
            take_numbers(&mut fitted, &found);
            let possible = vetoed(&fitted).is_empty();
            possible.then(|| (Rival { delta_bic: criterion - own, ..rival.clone() }, fitted))
        };
        let mut all: Vec<(Rival, Fitted)> = self.rounds[k].rivals.par_iter().filter_map(compared).collect();
        all.sort_by(|a, b| a.0.delta_bic.total_cmp(&b.0.delta_bic));
        let better = |(rival, f): &(Rival, Fitted)| rival.delta_bic < 0.0 && f.score.gap() <= most;
        let mut rivals: Vec<Rival> = vec![];
        let mut gained = 0.0;
        if all.first().is_some_and(better) {
            let (best, fitted) = all.remove(0);
            gained = best.delta_bic;
            rivals.push(rival(&self.last, self.rounds[k].before, 0.0));
            let base = self.base.clone();
            self.take(&base, fitted)?;
        }
        let same = |f: &Fitted| self.last.apart(f, &self.noise) < SAME_MOTION;
        rivals.extend(all.into_iter().map(|(rival, f)| Rival { same: same(&f), ..rival }));
        rivals.iter_mut().for_each(|rival| rival.delta_bic -= gained);
        self.rounds[k].rivals = rivals;
        self.compared = true;
        Ok(own + gained)
    }

    /// The last round that added something to the final model.
    fn last_round(&self) -> Option<usize> {
        let effects = self.last.model.effects.len();
        let kept = (0..self.rounds.len()).filter(|k| self.rounds[*k].before < effects);
        kept.max_by_key(|k| self.rounds[*k].before)
    }

    /// The fit of a model that leaves a random force on each body.
    fn with_random_force(&self, of: &Fitted) -> Option<Identified> {
        let observer = &self.search.observer;
        of.model.with_random_force(&|| observer.stopped())
    }

    /// The pushes between which the model as it is leaves nothing. They count where nothing else explains most of the gap, and
    /// no law has as much evidence. The result is that model then: laws beside pushes may stand for what the pushes leave.
    fn pushes(
        &mut self,
        status: Status,
        other: Option<&Alternative>,
        searched: &[Fitted],
    ) -> Result<Option<Vec<Push>>, GapError> {
        if status != Status::Unexplained
            || other.is_some()
            || searched.iter().any(|f| takes_most(f, &self.base))
            || self.interrupted()
        {
            return Ok(None);
        }
        let observer = &self.search.observer;
        let base = &self.path[0];
        let found = base.settled().pushes(&base.cal.records, &self.noise, &|| observer.stopped());
        let Some(Pushed { pushes, between, .. }) = found.filter(|p| self.pushes_are_sure(p, base)) else {
            return Ok(None);
        };
        self.keep(0)?;
        self.take_numbers(&between);
        self.run_with_numbers();
        Ok(Some(pushes))
    }

    /// Keeps the first `n` effects, with the errors of their numbers.
    fn keep(&mut self, n: usize) -> Result<(), GapError> {
        self.path.truncate(n + 1);
        self.compared = false;
        self.last = with_errors(self.path[n].clone(), &self.noise)?;
        self.path[n] = self.last.clone();
        Ok(())
    }

    /// Takes another final model, with the errors of its numbers.
    fn take(&mut self, base: &Fitted, found: Fitted) -> Result<(), GapError> {
        self.path = path(base, &found, &self.noise);
        self.compared = false;
        self.last = with_errors(found, &self.noise)?;
        if !self.last.model.effects.is_empty() {
            self.path.push(self.last.clone());
        }
        Ok(())
    }

    /// Whether evidence speaks against the final model. Laws beside a constant that the data press against its bound stand
    /// for something else.
    fn is_doubted(&self) -> bool {
        !vetoed(&self.last).is_empty() || pressed(&self.last, &self.noise)
    }

    /// Runs the final model with its numbers as they are, where these come from another fit.
    fn run_with_numbers(&mut self) {
        let mut held = self.last.model.clone();
        held.system.parameters.iter_mut().for_each(|p| p.within = (p.start, p.start));
        if let Ok(Fitted { cal, score, .. }) = Fitted::new(held, &self.noise, Effort::Plain) {
            (self.last.cal.records, self.last.score) = (cal.records, score);
        }
    }

    /// Takes the numbers that another fit of the final model found.
    fn take_numbers(&mut self, found: &Identified) {
        take_numbers(&mut self.last, found);
    }

    /// Whether the work is to end.
    fn interrupted(&self) -> bool {
        self.stop == StopReason::Interrupted || self.search.observer.stopped()
    }

    /// Draws the inputs between their samples in the way that explains the data, if there is one; returns it.
    fn redraw_inputs(&mut self) -> Result<Option<Interpolation>, GapError> {
        let complete = self.last.score.explains() && self.last.model.effects.is_empty();
        if complete || self.interrupted() {
            return Ok(None);
        }
        let Some(found) = redrawn(&self.path, &self.last, &self.noise, self.candidates) else {
            return Ok(None);
        };
        let Redrawn { fitted, base, from, to } = found;
        self.take(&base, fitted)?;
        self.warnings.push(Warning::Redrawn { from, to });
        Ok(Some(to))
    }

    /// Drops the effects that the drawing of the inputs between their samples leaves open, where the rest of
    /// the model is as good as that drawing allows. A model that explains the records needs no excuse: with fewer
    /// effects no drawing did, for [`redrawn`] has tried them.
    fn coarse_inputs(&mut self) -> Result<(), GapError> {
        if self.last.score.explains() || self.interrupted() {
            return Ok(());
        }
        let Some((left, coarse)) = coarse_inputs(&self.path, &self.noise) else { return Ok(()) };
        if beyond_noise(&self.path[left]).sqrt() > REPEATS * coarse.open {
            return Ok(());
        }
        self.keep(left)?;
        self.open = (1.0 + coarse.open.powi(2)).sqrt();
        self.warnings.push(Warning::CoarseInput(coarse));
        Ok(())
    }

    /// The status with the doubts about the effects, and the number of effects from the first on that are
    /// free of doubt.
    fn doubts(&mut self, status: Status) -> (Status, usize) {
        let all = self.last.model.effects.len();
        let mut vetoed = vetoed(&self.last);
        // The data need a law that nothing replaces, although the intervals of its coefficients hold zero.
        vetoed.retain(|(_, v)| !(matches!(v.why, Veto::Undetermined(_)) && self.needed.contains(&v.law)));
        let cancelling = cancelling(&self.last);
        let explained = status == Status::Explained && !self.interrupted();
        let curve = if explained { sensor_nonlinearity(&self.last, &self.noise) } else { None };
        if vetoed.is_empty() && cancelling.is_none() && curve.is_none() {
            let pressed = explained && pressed(&self.last, &self.noise);
            return if pressed { (Status::Unexplained, 0) } else { (status, all) };
        }
        let ruled_out = vetoed.iter().map(|(k, _)| *k).min().unwrap_or(all);
        let own: Vec<PlacedLaw> = placed(&self.last.model);
        let approximate = |c: &Cancelling| own.iter().position(|law| *law == c.laws.0).unwrap_or(all);
        let bent = curve.as_ref().map_or(all, |(k, _)| *k);
        let determined = cancelling.as_ref().map_or(all, approximate).min(ruled_out).min(bent);
        self.warnings.extend(vetoed.into_iter().map(|(_, why)| Warning::Vetoed(why)));
        self.warnings.extend(cancelling.map(Warning::Cancelling));
        self.warnings.extend(curve.map(|(_, curve)| Warning::SensorNonlinearity(curve)));
        (Status::Unexplained, determined)
    }

    /// The number of effects that are free of doubt with the numbers that they have now; the others are told.
    fn late_doubts(&mut self) -> usize {
        let late = vetoed(&self.last);
        let first = late.iter().map(|(k, _)| *k).min().unwrap_or(self.last.model.effects.len());
        let told = |v: &Vetoed| {
            self.warnings.iter().any(|w| matches!(w, Warning::Vetoed(told) if told.law == v.law))
        };
        let new: Vec<Vetoed> = late.into_iter().map(|(_, v)| v).filter(|v| !told(v)).collect();
        self.warnings.extend(new.into_iter().map(Warning::Vetoed));
        first
    }

    /// Tests other explanations: fixed constants of the spec, a drive at another frequency, noise of inputs.
    /// Drops the effects that do not help if the data remain unexplained.
    fn other_explanations(
        &mut self,
        mut status: Status,
        repeats: bool,
        mut determined: usize,
    ) -> Result<(Status, Option<Alternative>, usize), GapError> {
        let whole = self.last.clone();
        let interrupted = self.interrupted();
        let mut alternative = None;
        let changed = |a: &Applied| matches!(a.effect.place.site, Site::Constant { .. });
        let changed = whole.model.effects.iter().any(changed);
        if status != Status::NothingMissing && !repeats && !interrupted && !changed {
            self.search.observer.tell(0.95, Activity::Constants);
            let catalogue = self.search.catalogue;
            if let Some(found) = alternative_constant(&whole, catalogue, &self.noise, self.candidates) {
                let rival = std::slice::from_ref(&whole);
                if let Some(determined) = found.without.map(|f| self.instead(f, rival)).transpose()?.flatten()
                {
                    return Ok((Status::Explained, None, determined));
                }
                if found.much_better {
                    status = Status::Unexplained;
                }
                alternative = Some(Alternative::Constant(found.constant));
            }
        }
        if status != Status::Unexplained {
            return Ok((status, alternative, determined));
        }
        self.search.observer.tell(0.97, Activity::OtherCauses);
        let mixed = if interrupted { None } else { spec_mistake(&self.base, &whole, &self.noise) };
        let drive = if alternative.is_none() && mixed.is_none() && !interrupted {
            drive_frequency(&self.base, self.search)
        } else {
            None
        };
        let helps = match drive {
            // With a drive at the wrong frequency the effects mean nothing.
            Some(drive) if drive.explains => {
                alternative = Some(Alternative::Drive(drive));
                0
            }
            // Nor do they with constants or columns that are mixed up.
            _ if mixed.is_some() => 0,
            drive => {
                let path: Vec<_> = self.path.iter().map(|f| (&f.score, f.follows())).collect();
                let helps = helpful(&path);
                self.warnings.extend(drive.map(Warning::Drive));
                let rest = self.path[helps..].iter().skip(1).enumerate();
                let kept = &self.path[helps];
                self.warnings.extend(rest.filter_map(|(k, with)| refused(&whole, helps + k, kept, with)));
                helps
            }
        };
        self.warnings.extend(mixed.clone().map(Warning::Spec));
        if helps < whole.model.effects.len() {
            self.keep(helps)?;
        }
        if alternative.is_none() && !interrupted {
            let noise = input_noise(&self.last, &self.noise);
            // What the noise of the inputs leaves is no force: the model is as good as they are.
            if let Some(n) = noise.as_ref().filter(|n| mixed.is_none() && n.left <= n.most) {
                let clear = helps == determined;
                let of = |f: &Fitted| self.beside_a_random_force(f).map(|(criterion, _)| criterion);
                let (without, own) = (of(&self.base), of(&whole));
                let pays = |own: Option<f64>| without.zip(own).is_some_and(|(a, b)| a - b > WORTH);
                if self.base.score.gap() <= n.most && (whole.model.effects.is_empty() || !pays(own)) {
                    status = Status::NothingMissing;
                    self.keep(0)?;
                } else if let (Some(own), true) = (own, helps == whole.model.effects.len()) {
                    let best = self.compare_beside_a_random_force(own, n.most)?;
                    if clear || best < own {
                        (status, determined) = match pays(Some(best)) {
                            true => (Status::Explained, self.last.model.effects.len()),
                            false => (Status::Undetermined, 0),
                        };
                    }
                }
            }
            alternative = noise.map(Alternative::InputNoise);
        }
        self.warnings.extend(causes(&self.base, &self.last).into_iter().map(Warning::Cause));
        Ok((status, alternative, determined))
    }

    /// Takes these effects, which explain the data, in place of those of the search, unless evidence speaks against them;
    /// returns how many there are.
    fn instead(&mut self, found: Fitted, rivals: &[Fitted]) -> Result<Option<usize>, GapError> {
        let before = (self.last.clone(), self.path.clone());
        let base = self.base.clone();
        self.take(&base, found)?;
        if self.is_doubted() {
            (self.last, self.path) = before;
            return Ok(None);
        }
        let out = std::mem::take(&mut self.rounds).into_iter().flat_map(|round| round.vetoed).collect();
        self.rounds = vec![round_from(0, &self.base, &self.last, rivals, out, self.candidates)];
        Ok(Some(self.last.model.effects.len()))
    }

    /// Fits the near rivals of the last round as hard as the final model, with the same noise. The fits of a race are rougher.
    /// Drops those that evidence rules out, and those whose numbers the records do not determine: they would be no answer.
    /// Of rivals that no record tells apart the best one stays.
    fn compare_near_rivals(&mut self) {
        self.compared = true;
        let Some(round) = self.last_round() else { return };
        let Ending { last, noise, rounds, candidates, open, .. } = self;
        // Where another drawing of the inputs moves the model more than two laws differ, nothing tells them apart.
        let score = |f: &Fitted| Score { least: f.score.least.max(*open), ..f.score.clone() };
        let round = &mut rounds[round];
        // What no record tells apart is one answer whatever is more plausible beforehand.
        let beforehand = most_apart_beforehand(*candidates);
        let compared = |mut rival: Rival| {
            let near = rival.delta_bic < WORTH + beforehand;
            let Some(model) = rival.model.as_deref().filter(|_| near) else {
                return Some((rival, None));
            };
            let Ok(fitted) = Fitted::new(model.clone(), noise, Effort::Thorough) else {
                return Some((rival, None));
            };
            let (other, own) = (score(&fitted), score(last));
            let by = Measure::of([&other, &own], *candidates);
            rival.delta_bic = by.criterion(&other) - by.criterion(&own);
            rival.same = last.apart(&fitted, noise) < SAME_MOTION;
            let with_errors = with_errors(fitted, noise).ok()?;
            vetoed(&with_errors).is_empty().then_some((rival, Some(with_errors)))
        };
        let rivals = std::mem::take(&mut round.rivals).into_par_iter();
        let mut all: Vec<(Rival, Option<Fitted>)> = rivals.filter_map(compared).collect();
        all.sort_by(|a, b| a.0.delta_bic.total_cmp(&b.0.delta_bic));
        let mut kept: Vec<Fitted> = vec![];
        for (rival, fitted) in all {
            let again = |f: &Fitted| kept.iter().any(|k| k.apart(f, noise) < SAME_MOTION);
            if rival.same || !fitted.as_ref().is_some_and(again) {
                round.rivals.push(rival);
                kept.extend(fitted);
            }
        }
    }

    /// The report of the `k`-th effect.
    fn step(&self, k: usize) -> Step {
        let applied = &self.last.model.effects[k];
        let round = self.rounds.iter().rev().find(|r| r.before <= k);
        let (a, b) = (&self.path[k].score, &self.path[k + 1].score);
        let by = Measure::of([a, b], self.candidates);
        let own = placed(&self.last.model);
        // A law that the final model contains is no rival.
        let other = |r: &&Rival| !r.laws.iter().all(|law| own.contains(law));
        let rivals: Vec<Rival> = round.map_or(vec![], |r| r.rivals.iter().filter(other).cloned().collect());
        let rivals = rivals_of_the_answer(rivals, &own[k], round.map_or(0.0, |r| self.gained_since(r)));
        let discovered = applied.effect.entry.id == DISCOVERED;
        let numbers = values(&self.last, &applied.names, &applied.effect.start);
        Step {
            observed: observed_ranges(&self.last, applied),
            expansion: if discovered { expansion(&applied.effect.entry.law, &numbers) } else { None },
            effect: applied.effect.clone(),
            expression: expression(applied),
            force: applied.force,
            formula: with_numbers(&self.last, applied),
            parameters: parameters(&self.last, applied),
            fit: (a.fit, b.fit),
            validate: a.validate.zip(b.validate),
            delta_bic: by.criterion(a) - by.criterion(b),
            probability: self
                .compared
                .then(|| probability_beside(rivals.iter().filter(|r| !r.same).map(|r| r.delta_bic))),
            rivals,
            vetoed: round.map_or(vec![], |r| r.vetoed.clone()),
        }
    }
}

/// Takes the numbers that another fit of a model found.
fn take_numbers(of: &mut Fitted, found: &Identified) {
    for p in &mut of.cal.parameters {
        let same = |q: &&FoundParameter| q.id == p.id && q.estimate.value.is_finite();
        if let Some(found) = found.parameters.iter().find(same) {
            *p = found.clone();
        }
    }
    of.model = of.settled();
}

/// The frequency of the drive (rad/s), where every Fit record is a periodic motion at this one.
fn one_frequency(base: &TrialModel, repeat: &[ColumnRepeat]) -> Option<f64> {
    let mut all = Vec::new();
    for record in base.records.iter().filter(|r| r.role == Role::Fit) {
        repeat.iter().find(|of| of.record == record.name)?;
        let mut lines = Drive::new(&base.system, record)?.lines();
        all.append(&mut lines);
        all.sort_by(f64::total_cmp);
    }
    let (first, last) = (*all.first()?, *all.last()?);
    (last - first < SAME_FREQUENCY * first).then_some(0.5 * (first + last))
}

/// The columns whose residual is the error of the inputs between their samples, in words of the records.
fn input_errors(last: &Fitted) -> Vec<InputError> {
    let system = &last.model.system;
    let of = |error: &ColumnError| {
        let (column, unit) = system.measured(error.column);
        let factor = system.factor(error.column);
        InputError {
            inputs: system.inputs.iter().map(|u| u.name.clone()).collect(),
            of: Named { record: last.model.records[error.record].name.clone(), column: column.to_owned() },
            left: error.left / factor,
            open: error.open / factor,
            unit: unit.to_owned(),
        }
    };
    last.input_errors.iter().map(of).collect()
}

/// Whether a model is as good without its last effect.
fn needless(before: &Fitted, last: &Fitted, candidates: usize) -> bool {
    let by = Measure::of([&before.score, &last.score], candidates);
    by.criterion(&before.score) <= by.criterion(&last.score)
        && (before.score.is_white() || !last.score.is_white())
}

/// Splits the steps into those that are a finding whatever else is missing, and the others.
fn split_substantial(mut steps: Vec<Step>) -> (Vec<Step>, Vec<Step>) {
    let partial = steps.split_off(substantial(&steps));
    (steps, partial)
}

/// The number of steps that reduced the gap substantially. Products of factors are compared, because the first of two
/// stops helps little without the second.
fn substantial(steps: &[Step]) -> usize {
    let gap = |s: &Step| s.validate.unwrap_or(s.fit);
    let first = steps.first().map_or(1.0, |s| gap(s).0);
    let far_down = |&k: &usize| {
        let (before, after) = gap(&steps[k - 1]);
        first > SUBSTANTIAL.powi(k as i32) * after && before > SUBSTANTIAL * after
    };
    (1..=steps.len()).rev().find(far_down).unwrap_or(0)
}

/// Noise (standard deviation) of each measured column, over all records.
fn column_noise(base: &Fitted, noise: &[Vec<f64>]) -> Vec<(String, f64)> {
    let system = &base.model.system;
    let of = |k: usize| {
        let measured = base.model.records.iter().zip(noise).filter(|(r, _)| r.columns[k].is_some());
        let all: Vec<f64> = measured.map(|(r, n)| n[r.columns[..k].iter().flatten().count()]).collect();
        let mean = (all.iter().map(|s| s * s).sum::<f64>() / all.len().max(1) as f64).sqrt();
        (!all.is_empty()).then(|| (system.measured(k).0.to_owned(), mean))
    };
    (0..system.columns()).filter_map(of).collect()
}

fn located(fitted: &Fitted, noise: &[Vec<f64>]) -> Vec<Region> {
    regions(&fitted.model.system, &fitted.model.records, &fitted.cal, noise)
}

/// NRMSE of every record and column in the initial and the final model.
fn nrmse(base: &Fitted, last: &Fitted) -> Vec<ColumnGap> {
    let mut all = Vec::new();
    for (a, b) in last.cal.records.iter().zip(&base.cal.records) {
        for ((column, after), (_, before)) in a.nrmse.iter().zip(&b.nrmse) {
            let (record, column) = (a.name.clone(), column.clone());
            all.push(ColumnGap { record, role: a.role, column, before: *before, after: *after });
        }
    }
    all
}

/// Repeats a fit with the errors of its parameters.
fn with_errors(last: Fitted, noise: &[Vec<f64>]) -> Result<Fitted, GapError> {
    Ok(match Fitted::new(last.settled(), noise, Effort::Errors) {
        Ok(fitted) if fitted.score.fit.is_finite() => fitted,
        _ => last,
    })
}

/// The models with no effect, the first effect, the first two, and so on, without the last model.
fn path(base: &Fitted, last: &Fitted, noise: &[Vec<f64>]) -> Vec<Fitted> {
    let mut path = vec![base.clone()];
    let (plain, effects) = (last.model.without_effects(), current(last));
    for k in 1..effects.len() {
        let fitted = plain.with_all(&effects[..k]).ok().and_then(|m| refitted(m, last, noise));
        let before = path[path.len() - 1].clone();
        path.push(fitted.filter(|f| f.score.fit.is_finite()).unwrap_or(before));
    }
    path
}

/// The force of an effect without memory with its numbers (SI), in the language of the spec.
fn with_numbers(last: &Fitted, applied: &Applied) -> Option<String> {
    if applied.effect.entry.law.has_memory() {
        return None;
    }
    let system = &last.model.system;
    let mut graph = system.graph.clone();
    let numbers = values(last, &applied.names, &applied.effect.start);
    let with = applied.parameters.iter().zip(numbers).map(|(&k, value)| {
        // More digits than any record tells.
        let rounded = format!("{value:.6e}").parse().unwrap_or(value);
        (system.parameters[k].node, graph.constant(rounded))
    });
    let with = with.collect();
    let force = graph.replace(&[applied.force?], &with)[0];
    Some(graph.text(force, &system.names))
}

/// The parameters of an effect in the final model.
fn parameters(last: &Fitted, applied: &Applied) -> Vec<StepParameter> {
    let own = applied.names.iter().zip(&applied.parameters).zip(applied.effect.labels());
    let turned = applied.effect.is_input_delay();
    let of = |((constant, k), name): ((&String, &usize), String)| {
        let mut all = last.cal.parameters.iter().filter(|p| p.id.constant() == Some(*k));
        let value = |p: &FoundParameter| {
            let (f, e) = (p.factor, &p.estimate);
            if turned {
                return (-e.value / f, (-e.ci95.1 / f, -e.ci95.0 / f));
            }
            (e.value / f, (e.ci95.0 / f, e.ci95.1 / f))
        };
        let each = all.clone().filter_map(|p| {
            let (value, ci95) = value(p);
            Some(RecordValue { record: p.id.shown_record()?.to_owned(), value, ci95 })
        });
        let each = each.collect();
        let found = all.next()?;
        let (value, ci95) = value(found);
        Some(StepParameter { name, constant: constant.clone(), value, ci95, unit: found.unit.clone(), each })
    };
    own.filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::found;

    const COULOMB: &str = include_str!("../../phys/laws/coulomb.ron");

    /// An oscillator, its drive, and what the model lacks.
    fn rig(damping: &str, lacks: &str, size: &str) -> String {
        r#"(states: { "x": "m", "v": "m/s" }, inputs: { "u": "m/s^2" },
            constants: { "k": (4.0, "1/s^2"), "c": DAMPING },
            known: { "x": "v", "v": "u - c*v - k*x" }, unknown: {},
            data: [ Synthetic(truth: { "v": "LACKS" }, start: { "x": 0.0, "v": 0.0 }, duration: 150.0, step: 0.2,
                inputs: { "u": Multisine(amplitude: 1.0, band: (0.05, 0.8), count: 40) }, interpolate: { "u": Linear },
                measure: ["x"], noise: Sensor({ "x": (SIZE, "m") }), seed: 1) ])"#
            .replace("DAMPING", damping)
            .replace("LACKS", lacks)
            .replace("SIZE", size)
    }

    /// A law that leaves noise only while a constant is pressed against its bound is not what is there; at a
    /// bound that is the truth it is.
    #[test]
    fn a_constant_that_is_pressed_against_its_bound_is_a_doubt() {
        let of = |lacks: &str| {
            let damping = r#"(value: 0.4, unit: "1/s", within: (0.4, 2.0))"#;
            found(&rig(damping, lacks, "0.05"), &[("coulomb", COULOMB)]).status
        };
        assert_eq!(of("-0.1*sgn(v)"), Status::Explained);
        assert_eq!(of("0.02*v - 0.1*sgn(v)"), Status::Unexplained);
    }
}
