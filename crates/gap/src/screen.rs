//! The screening: every law at every place as a linear regression on responses to the measured motion, from
//! one Gram matrix.

mod free_columns;
mod gram;
mod grid;
mod partial_regression;
mod readings;
mod regression_data;
mod regressors;
mod response;
mod sibling_starts;
mod target;
mod trial;

use crate::decisions::{
    FOLLOWED, FOLLOWED_FROM, FOLLOWED_GAIN, FOLLOWS, GRID_KEPT, GRID_STARTS, PLAIN_GAIN, REGRESSION_ROWS,
    TONE_STARTS,
};
use crate::model::TrialModel;

use crate::constraint;
use crate::place::{Effect, Site, known_forces, needs};
use crate::result::{NotTried, WhyNot};
use faer::Mat;
use free_columns::{FreeColumns, Movable};
use gram::{Projected, products, projected, solve};
use phisindy_learn::Calibration;
use phisindy_phys::spec::Role;
use phisindy_phys::{Law, LawEntry, LawRole, System};
use rayon::prelude::*;
use regression_data::{Base, RegressionData};
use regressors::{Regressors, Scale};
use trial::{ForceTrials, Trial, input_trials, sensor_trials};

pub(crate) use partial_regression::{Kinematics, PartialRegression, Response, dot, norm, subtract};
pub(crate) use sibling_starts::sibling_starts;
pub(crate) use target::Target;

/// A law at a place with its best grid values.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    /// The effect, with parameters from the regression.
    pub(crate) effect: Effect,
    /// Reduction of chi^2 in the regression with this effect alone.
    pub(crate) gain: f64,
    /// Number of parameters that it adds.
    pub(crate) size: usize,
    /// The same effect from other grid values, next best first.
    pub(crate) others: Vec<Effect>,
    columns: Vec<usize>,
    /// Which of the law's columns the free quantities do not explain; those that they do explain count as
    /// zero.
    seen: Vec<bool>,
    grid: Vec<f64>,
    regressors: usize,
}

/// Result of a screening.
pub(crate) struct Screening {
    /// Sorted by gain minus the price of the parameters, best first.
    pub(crate) candidates: Vec<Candidate>,
    /// The target, the columns that are projected out (`fixed` with the target), and those of the candidates.
    columns: Mat<f64>,
    fixed: usize,
    /// Samples that a row stands for.
    stride: f64,
    movable: Vec<Movable>,
    regressors: Vec<Option<Regressors>>,
    /// Laws of the catalogue without a candidate.
    pub(crate) left_out: Vec<NotTried>,
    /// Rows of the regression, each for as many samples as it stands for.
    pub(crate) samples: f64,
}

/// Screens the catalogue beside a fitted model. `None` if the known rates cannot be evaluated along the data.
pub(crate) fn screen(
    model: &TrialModel,
    fitted: &Calibration,
    catalogue: &[LawEntry],
    noise: &[Vec<f64>],
    target: Target<'_>,
) -> Option<Screening> {
    let system = &model.system;
    let of: Vec<usize> = (0..model.records.len()).filter(|&r| model.records[r].role == Role::Fit).collect();
    let total: usize = of.iter().map(|&r| model.records[r].readings()).sum();
    let stride = total.div_ceil(REGRESSION_ROWS).max(1);
    let base = Base::new(system)?;
    let data: Vec<RegressionData> =
        of.iter().map(|&r| base.data(model, r, fitted, noise, stride)).collect::<Option<_>>()?;
    // The columns that are projected out, and the target.
    let FreeColumns { all: fixed, movable, .. } = FreeColumns::new(&base, model, &of, &data, target);
    let free = Free::new(&fixed, &movable, stride as f64);
    let effects = effects(model, catalogue);
    let seeds = |effect: &Effect| match &effect.place.site {
        Site::Sensor(names) => {
            let columns: Vec<usize> = names.iter().filter_map(|name| system.column(name)).collect();
            free.seeds(sensor_trials(effect, &columns, &data), None)
        }
        Site::Input(inputs) => free.seeds(input_trials(effect, inputs, system, &data), None),
        Site::Constant { .. } | Site::Impact { .. } => free.seeds(vec![], None),
        Site::Force { .. } if model.stop.requested() => free.seeds(vec![], None),
        Site::Force { .. } => match ForceTrials::new(effect, system, &data) {
            Some(force) => free.seeds(force.on_grid(), Some(force.regressors)),
            None => free.seeds(vec![], None),
        },
    };
    let mut seeds: Vec<Seeds> = effects.par_iter().map(seeds).collect();
    let most = seeds.iter().filter_map(|of| of.all.first()).map(|c| c.gain).fold(0.0, f64::max);
    let near = |of: &Seeds| of.is_coarse() && of.all.first().is_some_and(|c| c.gain >= FOLLOWED_FROM * most);
    let follow = |(of, effect): (&mut Seeds, &Effect)| {
        if near(of) && !model.stop.requested() {
            free.follow(of, effect, system, &data);
        }
    };
    seeds.par_iter_mut().zip(&effects).for_each(follow);
    let screened: Vec<Screened> = seeds.into_iter().map(|of| of.best(&data)).collect();
    let rows = fixed[0].len();
    let samples = (rows * stride) as f64;
    let left_out = left_out(model, catalogue, &effects, &screened);
    let (mut columns, mut candidates, mut regressors) = (fixed.clone(), vec![], vec![]);
    for (k, of) in screened.into_iter().enumerate() {
        regressors.push(of.regressors);
        let Some((candidate, own)) = of.best else { continue };
        // Column indices after projection: column 0 is the target, projected columns are gone.
        let first = columns.len() - fixed.len() + 1;
        let at = (0..own.len()).filter(|&k| candidate.seen[k]).map(|k| first + k).collect();
        columns.extend(own);
        candidates.push(Candidate { columns: at, regressors: k, ..candidate });
    }
    let price = |size: usize| size as f64 * samples.ln();
    candidates.sort_by(|a: &Candidate, b| (b.gain - price(b.size)).total_cmp(&(a.gain - price(a.size))));
    let (fixed, stride) = (fixed.len(), stride as f64);
    let columns = Mat::from_fn(rows, columns.len(), |i, j| columns[j][i]);
    Some(Screening { candidates, columns, fixed, stride, movable, regressors, left_out, samples })
}

/// The laws of the catalogue without a candidate at any place.
fn left_out(
    model: &TrialModel,
    catalogue: &[LawEntry],
    effects: &[Effect],
    screened: &[Screened],
) -> Vec<NotTried> {
    let unknown = |entry: &LawEntry| {
        let mut system = model.system.clone();
        entry
            .law
            .nodes()
            .outside
            .iter()
            .find(|(name, _)| system.quantity(name).is_none())
            .map(|(n, _)| n.clone())
    };
    let mut all = Vec::new();
    for entry in catalogue {
        let own: Vec<usize> = (0..effects.len()).filter(|&k| effects[k].entry.id == entry.id).collect();
        if own.iter().any(|&k| screened[k].best.is_some()) {
            continue;
        }
        let reason = match (unknown(entry), own.iter().rev().find_map(|&k| screened[k].why.clone())) {
            (Some(name), _) => WhyNot::UnknownName(name),
            _ if entry.law.parameters.is_empty() => WhyNot::NothingToFind,
            (None, Some(why)) => why,
            (None, None) => WhyNot::NoPlace(needs(&entry.law)),
        };
        all.push(NotTried { law: entry.id.clone(), why: reason });
    }
    all
}

/// An effect in regressions of its own.
struct Screened {
    regressors: Option<Regressors>,
    /// The best of its trials with its columns, and the next ones.
    best: Option<(Candidate, Vec<Vec<f64>>)>,
    /// Why there is none.
    why: Option<WhyNot>,
}

/// The trials of an effect that may start a fit.
struct Seeds {
    regressors: Option<Regressors>,
    /// Best first.
    all: Vec<Candidate>,
    /// The columns of the first one.
    columns: Vec<Vec<f64>>,
    /// Why there is none.
    why: Option<WhyNot>,
    /// Whether only the best are kept.
    few: bool,
}

impl Seeds {
    /// Whether they lie on a grid of several axes.
    fn is_coarse(&self) -> bool {
        self.regressors.iter().flat_map(|r| &r.grid).filter(|axis| axis.is_free()).count() > 1
    }

    /// The best one, and the starts that come after it.
    fn best(mut self, data: &[RegressionData]) -> Screened {
        if self.few {
            self.all.truncate(GRID_KEPT);
        }
        let others = others(&self.all, self.regressors.as_ref(), data);
        let best = self.all.into_iter().next().map(|seed| (Candidate { others, ..seed }, self.columns));
        Screened { regressors: self.regressors, best, why: self.why }
    }
}

/// The target, the columns that are projected out, their Gram matrix, and the movable constants among them.
struct Free<'a> {
    columns: Vec<&'a [f64]>,
    gram: Mat<f64>,
    movable: &'a [Movable],
    /// Samples that a row stands for.
    stride: f64,
}

impl<'a> Free<'a> {
    fn new(columns: &'a [Vec<f64>], movable: &'a [Movable], stride: f64) -> Free<'a> {
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let gram = products(&columns, &columns);
        Free { columns, gram, movable, stride }
    }

    /// The regression of each trial of an effect beside the free columns. An effect that oscillates keeps all
    /// trials, of any other one few may start a fit.
    fn seeds(&self, trials: Vec<Trial>, regressors: Option<Regressors>) -> Seeds {
        let tone = regressors.iter().flat_map(|r| &r.grid).any(|axis| axis.scale == Scale::Frequency);
        let few = !tone && trials.len() > GRID_KEPT;
        let none = Err(match (trials.is_empty(), tone) {
            (true, true) => WhyNot::NoTone,
            (true, false) => WhyNot::NotFinite,
            (false, _) => WhyNot::NotSeen,
        });
        let seeds: Vec<(Result<Candidate, WhyNot>, Trial)> =
            trials.into_iter().map(|t| (self.candidate(&t, regressors.as_ref()), t)).collect();
        // Of many where none is of use the first one tells why, of few the last one.
        let teller = if few { seeds.first() } else { seeds.last() };
        let why = teller.map_or(none, |(seed, _)| seed.clone()).err();
        let mut all: Vec<(Candidate, Trial)> =
            seeds.into_iter().filter_map(|(seed, t)| Some((seed.ok()?, t))).collect();
        all.sort_by(|(a, _), (b, _)| b.gain.total_cmp(&a.gain));
        let (all, mut trials): (Vec<Candidate>, Vec<Trial>) = all.into_iter().unzip();
        let columns = trials.first_mut().map_or(vec![], |first| std::mem::take(&mut first.columns));
        Seeds { regressors, all, columns, why, few }
    }

    /// Follows the best points of a coarse grid to where the law explains most (variable projection: Golub,
    /// Pereyra 1973, doi 10.1137/0710036).
    fn follow(&self, seeds: &mut Seeds, effect: &Effect, system: &System, data: &[RegressionData]) {
        let Some(force) = ForceTrials::new(effect, system, data) else { return };
        let axes = &force.regressors.grid;
        // Points beside a better one lie on the same slope.
        let adjoin =
            |a: &[f64], b: &[f64]| axes.iter().zip(a.iter().zip(b)).all(|(axis, (a, b))| axis.adjoin(*a, *b));
        let on_top = |k: &usize| (0..*k).all(|j| !adjoin(&seeds.all[j].grid, &seeds.all[*k].grid));
        let tops: Vec<usize> = (0..seeds.all.len()).filter(on_top).take(FOLLOWED).collect();
        let mut top = seeds.all.first().map_or(0.0, |c| c.gain);
        let better = |now: &Candidate, part: f64| {
            let tried = force.around(&now.grid, part).into_iter();
            let found =
                tried.filter_map(|t| Some((self.candidate(&t, Some(&force.regressors)).ok()?, t.columns)));
            let best = found.max_by(|(a, _), (b, _)| a.gain.total_cmp(&b.gain));
            best.filter(|(c, _)| c.gain > now.gain * (1.0 + FOLLOWED_GAIN))
        };
        for k in tops {
            for part in FOLLOWS {
                while let Some((next, columns)) = better(&seeds.all[k], part) {
                    if next.gain > top {
                        (top, seeds.columns) = (next.gain, columns);
                    }
                    seeds.all[k] = next;
                }
            }
        }
        seeds.all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    }

    /// A trial as a candidate on its own.
    ///
    /// # Errors
    /// The free columns explain what it does, or a parameter is outside the law's bounds.
    fn candidate(&self, trial: &Trial, regressors: Option<&Regressors>) -> Result<Candidate, WhyNot> {
        let own: Vec<&[f64]> = trial.columns.iter().map(Vec::as_slice).collect();
        let all: Vec<&[f64]> = self.columns.iter().chain(&own).copied().collect();
        let cross = products(&all, &own);
        let fixed = self.columns.len();
        let gram = Mat::from_fn(all.len(), all.len(), |i, j| match (i < fixed, j < fixed) {
            (true, true) => self.gram[(i, j)],
            (_, false) => cross[(i, j - fixed)],
            (false, true) => cross[(j, i - fixed)],
        });
        let Projected { gram, kept, follow } = projected(&gram, fixed);
        // What a free constant of the model does as well is left to it: the viscous part of a friction law
        // beside a free damper.
        let mut seen = kept[1..].to_vec();
        let mut at: Vec<usize> = (1..=own.len()).filter(|&k| kept[k]).collect();
        if at.is_empty() {
            return Err(WhyNot::NotSeen);
        }
        let mut of = || {
            let (mut gain, mut coefficients) = solve(&gram, &at)?;
            // A part that would take the wrong sign starts at zero: noise may turn the sign of one of several
            // parts that are nearly collinear, and the law as a whole may be the right one.
            while let Some((regressors, wrong)) =
                regressors.and_then(|r| Some((r, r.wrong_sign(&at, &coefficients)?)))
            {
                seen[at.remove(wrong) - 1] = false;
                if regressors.is_simpler(&at) {
                    return None;
                }
                (gain, coefficients) = solve(&gram, &at)?;
            }
            let all = with_zeros(&seen, &coefficients);
            let effect = seeded(&trial.effect, regressors, &all, &trial.grid)?;
            let beside = moved(self.movable, &follow, &at, &coefficients);
            Some((self.stride * gain, Effect { beside, ..effect }))
        };
        let (gain, effect) = of().ok_or(WhyNot::OutOfBounds)?;
        let (size, grid) = (trial.effect.entry.law.parameters.len(), trial.grid.clone());
        Ok(Candidate { effect, gain, size, others: vec![], columns: vec![], seen, grid, regressors: 0 })
    }
}

/// Further starts of a law from its `seeds`, which are sorted best first. A law that oscillates keeps one
/// start per spectral line: a body that sticks and slips responds at more lines than its drive has.
fn others(seeds: &[Candidate], regressors: Option<&Regressors>, data: &[RegressionData]) -> Vec<Effect> {
    let tone = regressors.and_then(|r| r.grid.iter().position(|axis| axis.scale == Scale::Frequency));
    let Some(tone) = tone else {
        return seeds.iter().skip(1).take(GRID_STARTS).map(|c| c.effect.clone()).collect();
    };
    let fine = data.iter().map(RegressionData::resolution).fold(0.0, f64::max);
    let mut kept: Vec<&Candidate> = Vec::new();
    for seed in seeds {
        if kept.iter().all(|k| (k.grid[tone] - seed.grid[tone]).abs() > fine) {
            kept.push(seed);
        }
    }
    kept.into_iter().skip(1).take(TONE_STARTS).map(|c| c.effect.clone()).collect()
}

impl Screening {
    /// The best pairs of candidates by joint gain in the regression, minus `price` per parameter.
    pub(crate) fn pairs(&self, price: f64, count: usize) -> Vec<(Candidate, Candidate)> {
        if count == 0 {
            return vec![];
        }
        let gram = self.columns.transpose() * &self.columns;
        let Projected { gram, follow, .. } = projected(&(gram * faer::Scale(self.stride)), self.fixed);
        let joint = |(i, k): (usize, usize)| -> Option<Pair> {
            let (a, b) = (&self.candidates[i], &self.candidates[k]);
            let at: Vec<usize> = a.columns.iter().chain(&b.columns).copied().collect();
            let (gain, coefficients) = solve(&gram, &at)?;
            let (left, right) = coefficients.split_at(a.columns.len());
            self.start(a, left).zip(self.start(b, right))?;
            Some(Pair { score: gain - price * (a.size + b.size) as f64, of: (i, k), at, coefficients })
        };
        let candidates = &self.candidates;
        let mut all: Vec<Pair> = (0..candidates.len())
            .into_par_iter()
            .flat_map_iter(|i| {
                let apart = move |&k: &usize| !excludes(&candidates[i].effect, &candidates[k].effect);
                (i + 1..candidates.len()).filter(apart).filter_map(move |k| joint((i, k)))
            })
            .collect();
        all.sort_by(|x, y| y.score.total_cmp(&x.score));
        // Smoothing errors favour rich laws, so each leading pair comes with the simpler relatives of its
        // parts.
        let simpler = |rich: &Candidate, plain: &Candidate| plain.effect.is_simpler_form_of(&rich.effect);
        let leads = all.len().min(count);
        let mut chosen: Vec<usize> = (0..leads).collect();
        for lead in 0..leads {
            let (a, b) = self.parts(&all[lead]);
            chosen.extend((leads..all.len()).filter(|&k| {
                let (c, d) = self.parts(&all[k]);
                let related = |x: &Candidate, y: &Candidate| x.effect.same(&y.effect) || simpler(x, y);
                (related(a, c) && related(b, d)) || (related(a, d) && related(b, c))
            }));
        }
        // Pairs with the plain law of each strong family: rich friction laws often imitate Coulomb friction
        // plus another effect.
        let plain = |c: &Candidate| {
            self.candidates.iter().any(|r| simpler(r, c) && r.gain > PLAIN_GAIN * self.candidates[0].gain)
        };
        let plain: Vec<bool> = self.candidates.iter().map(plain).collect();
        chosen.extend((leads..all.len()).filter(|&k| plain[all[k].of.0] || plain[all[k].of.1]).take(count));
        chosen.sort_unstable();
        chosen.dedup();
        chosen.into_iter().filter_map(|k| self.started(&all[k], &follow)).collect()
    }

    /// The two candidates of a pair.
    fn parts(&self, pair: &Pair) -> (&Candidate, &Candidate) {
        (&self.candidates[pair.of.0], &self.candidates[pair.of.1])
    }

    /// The two candidates of a pair with the parameters of the joint regression.
    fn started(&self, pair: &Pair, follow: &Mat<f64>) -> Option<(Candidate, Candidate)> {
        let (a, b) = self.parts(pair);
        let (left, right) = pair.coefficients.split_at(a.columns.len());
        let beside = moved(&self.movable, follow, &pair.at, &pair.coefficients);
        let with = |c: &Candidate, start: Vec<f64>| {
            let effect = Effect { start, beside: beside.clone(), ..c.effect.clone() };
            Candidate { effect, ..c.clone() }
        };
        Some((with(a, self.start(a, left)?), with(b, self.start(b, right)?)))
    }

    /// Start values of a candidate from its coefficients; `None` outside the law's bounds.
    fn start(&self, c: &Candidate, coefficients: &[f64]) -> Option<Vec<f64>> {
        let all = with_zeros(&c.seen, coefficients);
        start(&c.effect.entry.law, self.regressors[c.regressors].as_ref(), &all, &c.grid)
    }
}

/// Two candidates in one regression.
struct Pair {
    /// The joint gain less the price of the parameters.
    score: f64,
    /// Their indices.
    of: (usize, usize),
    /// Their columns, and the coefficients of these.
    at: Vec<usize>,
    coefficients: Vec<f64>,
}

/// Values of the movable constants when columns `at` enter with these coefficients, from the joint
/// regression. `follow` are the coefficients of all columns on those that were projected out.
fn moved(movable: &[Movable], follow: &Mat<f64>, at: &[usize], coefficients: &[f64]) -> Vec<(String, f64)> {
    let of = |m: &Movable| {
        let taken: f64 = at.iter().zip(coefficients).map(|(&k, c)| c * follow[(m.row, k)]).sum();
        (m.name.clone(), m.now + follow[(m.row, 0)] - taken)
    };
    movable.iter().map(of).filter(|(_, value)| value.is_finite()).collect()
}

/// Whether two effects describe the same thing: one place, one family. A law and its mirror image do not,
/// because a body may have a stop on either side.
pub(crate) fn excludes(a: &Effect, b: &Effect) -> bool {
    let family = |e: &Effect| {
        let family = &e.entry.law.family;
        if family.is_empty() { e.entry.id.clone() } else { family.clone() }
    };
    a.place.at == b.place.at && a.mirror == b.mirror && family(a) == family(b)
}

/// Laws at places, with mirror images and loads, that the model does not contain yet.
fn effects(model: &TrialModel, catalogue: &[LawEntry]) -> Vec<Effect> {
    let loads = model.loads();
    let mut all = Vec::new();
    for entry in catalogue {
        for place in model.places().iter().filter(|p| model.takes(&entry.law, p)) {
            let start =
                entry.law.parameters.iter().map(|(_, p)| 0.0_f64.clamp(p.within.0, p.within.1)).collect();
            let plain = Effect::new(entry.clone(), place.clone(), start);
            if entry.law.role(LawRole::Load).is_some() {
                let pressed = |force: String| Effect { pressed_by: Some(force), ..plain.clone() };
                all.extend(known_forces(&model.system, place).into_iter().map(pressed));
                continue;
            }
            if entry.law.mirror.is_some() {
                all.push(Effect { mirror: true, ..plain.clone() });
            }
            if entry.law.family == "friction" && !entry.law.has_memory() {
                all.extend(loads.iter().map(|l| Effect { load: Some(l.clone()), ..plain.clone() }));
            }
            all.push(plain);
        }
    }
    all.retain(|e| !model.effects.iter().any(|own| excludes(&own.effect, e)));
    all
}

/// The coefficients of all columns of a law from those of the columns that are seen.
fn with_zeros(seen: &[bool], coefficients: &[f64]) -> Vec<f64> {
    let mut next = coefficients.iter();
    seen.iter().map(|seen| if *seen { next.next().copied().unwrap_or(0.0) } else { 0.0 }).collect()
}

/// The effect with parameters from coefficients and grid values; `None` outside the law's bounds.
fn seeded(
    effect: &Effect,
    regressors: Option<&Regressors>,
    coefficients: &[f64],
    grid: &[f64],
) -> Option<Effect> {
    let start = start(&effect.entry.law, regressors, coefficients, grid)?;
    Some(Effect { start, ..effect.clone() })
}

/// Start values of a law from coefficients and grid values; `None` outside its bounds.
fn start(law: &Law, regressors: Option<&Regressors>, coefficients: &[f64], grid: &[f64]) -> Option<Vec<f64>> {
    let values = match regressors {
        Some(regressors) => regressors.parameters(coefficients, grid)?,
        // What acts in the place of an input: all of its change, or none.
        None if law.acting().is_some() => match law.neutral_input() {
            Some(neutral) => vec![neutral + coefficients[0]],
            None if coefficients[0] > 0.0 => grid.to_vec(),
            None => return None,
        },
        None => match law.property() {
            Some("gain") => vec![1.0 + coefficients[0]],
            _ => vec![coefficients[0]],
        },
    };
    let inside = values.iter().zip(&law.parameters).all(|(v, (_, p))| {
        let slack = 1e-9 * (p.within.1 - p.within.0).abs().min(1.0);
        *v >= p.within.0 - slack && *v <= p.within.1 + slack
    });
    inside.then(|| constraint::inside(law, &values))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::{fitted, model};

    const THREE_PARTS: &str = r#"(
        name: "Three dampers", about: "A linear, a quadratic and a cubic damper.", reference: "none", roles: { "v": "m/s" },
        parameters: { "p": (unit: "N*s/m", within: (0.0, 1e6)), "q": (unit: "N*s^3/m^3", within: (0.0, 1e6)),
            "r": (unit: "N*s^2/m^2", within: (-1e6, 1e6)) },
        force: "p*v + q*v^3 + r*v^2", sketch: (over: "v", with: { "p": 1.0, "q": 1.0, "r": 1.0 }),
    )"#;

    /// A law that is not tried is told with the reason: no parameter, no number anywhere.
    #[test]
    fn what_is_not_tried_is_told_why() {
        let (base, noise) = model(
            r#"(states: { "x": "m", "v": "m/s" }, known: { "x": "v", "v": "-x - 0.3*v" }, unknown: {},
                data: [ Synthetic(truth: {}, start: { "x": 1.0, "v": 0.0 }, duration: 20.0, step: 0.05,
                    noise: Additive(0.01), seed: 1) ])"#,
        );
        let law = |id: &str, parameters: &str, force: &str| {
            let text = format!(
                r#"(name: "{id}", about: "", reference: "none", roles: {{ "v": "m/s" }}, parameters: {{ {parameters} }}, force: "{force}")"#
            );
            LawEntry::read(id, &text).expect("a law")
        };
        let damper = r#""d": (unit: "N*s/m", within: (0.0, 1e6))"#;
        let laws = [law("fixed", "", "3*v"), law("nowhere", damper, "d*v*sqrt(-1 - abs(v))")];
        let fitted = fitted(base, &noise);
        let found =
            screen(&fitted.model, &fitted.cal, &laws, &noise, Target::AlongData).expect("a screening");
        let why: Vec<(&str, &WhyNot)> = found.left_out.iter().map(|l| (l.law.as_str(), &l.why)).collect();
        assert_eq!(why, [("fixed", &WhyNot::NothingToFind), ("nowhere", &WhyNot::NotFinite)]);
    }

    /// A part whose best value has the wrong sign starts at zero. Where one part is left the law is out.
    #[test]
    fn a_part_of_the_wrong_sign_starts_at_zero() {
        let screened = |truth: &str| {
            let (base, noise) = model(&format!(
                r#"(states: {{ "x": "m", "v": "m/s" }}, constants: {{ "m": (1.0, "kg"), "k": (1.0, "N/m"), "c": (0.3, "N*s/m"),
                    "F0": (1.0, "N"), "W": (0.7, "rad/s") }},
                known: {{ "x": "v", "v": "(F0*cos(W*t) - k*x - c*v)/m" }}, inertia: {{ "v": "m" }}, unknown: {{}},
                data: [ Synthetic(truth: {{ "v": "{truth}" }}, start: {{ "x": 1.0, "v": 0.0 }}, duration: 60.0, step: 0.05,
                    noise: Additive(0.01), seed: 1) ])"#
            ));
            let law = LawEntry::read("three", THREE_PARTS).expect("a law");
            let fitted = fitted(base, &noise);
            screen(&fitted.model, &fitted.cal, &[law], &noise, Target::AlongData).expect("a screening")
        };
        let one = screened("-0.3*v + 0.02*v^3");
        let start =
            &one.candidates.iter().find(|c| c.effect.place.at == "v").expect("a candidate").effect.start;
        assert!(start[0] > 0.1 && start[1] == 0.0, "{start:?}");
        let none = screened("0.1*v + 0.01*v^3");
        assert!(none.candidates.is_empty(), "{:?}", none.candidates.len());
        assert_eq!(none.left_out.len(), 1);
    }
}
