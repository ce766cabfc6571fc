//! The screening: every law at every place as a linear regression on responses to the measured motion, from
//! one Gram matrix.

mod free_columns;
mod gram;
mod grid;
mod readings;
mod regression_data;
mod regressors;
mod response;
mod sibling_starts;
mod trial;

use crate::decisions::{GRID_KEPT, GRID_STARTS, PLAIN_GAIN, REGRESSION_ROWS, TONE_STARTS};
use crate::model::TrialModel;

use crate::constraint;
use crate::place::{Effect, Site, fits, known_forces, needs};
use crate::result::{NotTried, WhyNot};
use faer::Mat;
use free_columns::{FreeColumns, Movable};
use gram::{Projected, projected, solve};
use phisindy_learn::Calibration;
use phisindy_phys::spec::Role;
use phisindy_phys::{LawEntry, LawRole};
use rayon::prelude::*;
use regression_data::{Base, RegressionData};
use regressors::{Regressors, Scale};
use trial::{Trial, force_trials, input_trials, sensor_trials};

pub(crate) use sibling_starts::sibling_starts;

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
    grid: Vec<f64>,
    regressors: usize,
}

/// Result of a screening.
pub(crate) struct Screening {
    /// Sorted by gain minus the price of the parameters, best first.
    pub(crate) candidates: Vec<Candidate>,
    gram: Mat<f64>,
    /// Regression coefficients of all other columns on the columns that were projected out.
    follow: Mat<f64>,
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
) -> Option<Screening> {
    let system = &model.system;
    let of: Vec<usize> = (0..model.records.len()).filter(|&r| model.records[r].role == Role::Fit).collect();
    let total: usize = of.iter().map(|&r| model.records[r].readings()).sum();
    let stride = total.div_ceil(REGRESSION_ROWS).max(1);
    let base = Base::new(system)?;
    let data: Vec<RegressionData> =
        of.iter().map(|&r| base.data(model, r, fitted, noise, stride)).collect::<Option<_>>()?;
    // The columns that are projected out, and the target.
    let FreeColumns { all: fixed, movable, .. } = FreeColumns::new(&base, model, &of, &data);
    let free = Free::new(&fixed);
    let effects = effects(model, catalogue);
    let made: Vec<(Option<Regressors>, Vec<Trial>)> = effects
        .par_iter()
        .enumerate()
        .map(|(k, effect)| match &effect.place.site {
            Site::Sensor(names) => {
                let columns: Vec<usize> = names.iter().filter_map(|name| system.column(name)).collect();
                (None, sensor_trials(k, effect, &columns, &data))
            }
            Site::Input(inputs) => (None, input_trials(k, effect, inputs, system, &data)),
            Site::Force { .. } => match Regressors::new(effect, system) {
                Some(regressors) => {
                    let trials = force_trials(k, effect, &regressors, system, &data);
                    let tone = regressors.grid.iter().any(|axis| axis.scale == Scale::Frequency);
                    let trials = if tone { trials } else { leading(trials, &free, &regressors) };
                    (Some(regressors), trials)
                }
                None => (None, vec![]),
            },
        })
        .collect();
    let mut columns: Vec<&[f64]> = fixed.iter().map(Vec::as_slice).collect();
    let mut candidates = Vec::new();
    for (_, trials) in &made {
        for trial in trials {
            let first = columns.len();
            columns.extend(trial.columns.iter().map(Vec::as_slice));
            candidates.push((trial, (first..columns.len()).collect::<Vec<usize>>()));
        }
    }
    let rows = fixed[0].len();
    let matrix = Mat::from_fn(rows, columns.len(), |i, j| columns[j][i]);
    let gram = matrix.transpose() * &matrix;
    let gram = gram * faer::Scale(stride as f64);
    let Projected { gram, kept, follow } = projected(&gram, fixed.len());
    let samples = (rows * stride) as f64;
    let mut screening = Screening {
        candidates: vec![],
        gram,
        follow,
        movable,
        regressors: vec![],
        left_out: vec![],
        samples,
    };
    let mut best: Vec<Vec<Candidate>> = vec![vec![]; effects.len()];
    // Why the trials of an effect gave no candidate.
    let mut why: Vec<Option<WhyNot>> =
        made.iter().map(|(_, trials)| trials.is_empty().then_some(WhyNot::NotFinite)).collect();
    for (trial, at) in candidates {
        // Column indices after projection: column 0 is the target, projected columns are gone.
        let at: Vec<usize> = at.into_iter().map(|k| k - fixed.len() + 1).collect();
        why[trial.regressors] = Some(WhyNot::NotSeen);
        if at.iter().all(|&k| kept[k]) {
            let regressors = made[trial.regressors].0.as_ref();
            best[trial.regressors].extend(screening.candidate(trial, at, regressors));
            why[trial.regressors] = Some(WhyNot::OutOfBounds);
        }
    }
    screening.left_out = left_out(model, catalogue, &effects, &best, &why);
    screening.regressors = made.into_iter().map(|(r, _)| r).collect();
    screening.candidates = best
        .into_iter()
        .filter_map(|mut seeds| {
            seeds.sort_by(|a, b| b.gain.total_cmp(&a.gain));
            let others = others(&seeds, screening.regressors[seeds.first()?.regressors].as_ref(), &data);
            let first = seeds.into_iter().next()?;
            Some(Candidate { others, ..first })
        })
        .collect();
    let price = |size: usize| size as f64 * samples.ln();
    screening.candidates.sort_by(|a, b| (b.gain - price(b.size)).total_cmp(&(a.gain - price(a.size))));
    Some(screening)
}

/// The laws of the catalogue without a candidate at any place.
fn left_out(
    model: &TrialModel,
    catalogue: &[LawEntry],
    effects: &[Effect],
    best: &[Vec<Candidate>],
    why: &[Option<WhyNot>],
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
        if own.iter().any(|&k| !best[k].is_empty()) {
            continue;
        }
        let reason = match (unknown(entry), own.iter().rev().find_map(|&k| why[k].clone())) {
            (Some(name), _) => WhyNot::UnknownName(name),
            (None, Some(why)) => why,
            (None, None) => WhyNot::NoPlace(needs(&entry.law)),
        };
        all.push(NotTried { law: entry.id.clone(), why: reason });
    }
    all
}

/// The columns that are projected out, after the target, and their Gram matrix.
struct Free {
    columns: Mat<f64>,
    gram: Mat<f64>,
}

impl Free {
    fn new(columns: &[Vec<f64>]) -> Free {
        let columns = Mat::from_fn(columns[0].len(), columns.len(), |i, j| columns[j][i]);
        let gram = columns.transpose() * &columns;
        Free { columns, gram }
    }
}

/// The trials of one law that explain most by themselves, if there are many.
fn leading(trials: Vec<Trial>, free: &Free, regressors: &Regressors) -> Vec<Trial> {
    if trials.len() <= GRID_KEPT {
        return trials;
    }
    let gain = |trial: &Trial| {
        let own = &trial.columns;
        let (rows, fixed) = (free.columns.nrows(), free.gram.ncols());
        let columns = Mat::from_fn(rows, own.len(), |i, j| own[j][i]);
        let (cross, block) = (free.columns.transpose() * &columns, columns.transpose() * &columns);
        let all = Mat::from_fn(fixed + own.len(), fixed + own.len(), |i, j| match (i < fixed, j < fixed) {
            (true, true) => free.gram[(i, j)],
            (true, false) => cross[(i, j - fixed)],
            (false, true) => cross[(j, i - fixed)],
            (false, false) => block[(i - fixed, j - fixed)],
        });
        let Projected { gram, kept, .. } = projected(&all, fixed);
        let at: Vec<usize> = (1..=own.len()).collect();
        let (gain, coefficients) = solve(&gram, &at).filter(|_| at.iter().all(|&k| kept[k]))?;
        seeded(&trial.effect, Some(regressors), &coefficients, &trial.grid).map(|_| gain)
    };
    let mut all: Vec<(f64, Trial)> =
        trials.into_iter().map(|t| (gain(&t).unwrap_or(f64::NEG_INFINITY), t)).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    // Where none is of use, one of them tells why.
    let useful = all.iter().filter(|(gain, _)| *gain > f64::NEG_INFINITY).count();
    all.into_iter().take(useful.clamp(1, GRID_KEPT)).map(|(_, trial)| trial).collect()
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
    /// A trial as a candidate on its own. `at` are its columns in the projected Gram matrix. `None` where a
    /// parameter is outside the law's bounds.
    fn candidate(&self, trial: &Trial, at: Vec<usize>, regressors: Option<&Regressors>) -> Option<Candidate> {
        let (gain, coefficients) = solve(&self.gram, &at)?;
        let effect = seeded(&trial.effect, regressors, &coefficients, &trial.grid)?;
        Some(Candidate {
            effect: Effect { beside: self.beside(&at, &coefficients), ..effect },
            gain,
            size: trial.effect.entry.law.parameters.len(),
            others: vec![],
            columns: at,
            grid: trial.grid.clone(),
            regressors: trial.regressors,
        })
    }

    /// The best pairs of candidates by joint gain in the regression, minus `price` per parameter.
    pub(crate) fn pairs(&self, price: f64, count: usize) -> Vec<(Candidate, Candidate)> {
        let mut all: Vec<(f64, Candidate, Candidate)> = Vec::new();
        for (i, a) in self.candidates.iter().enumerate() {
            for b in &self.candidates[i + 1..] {
                if excludes(&a.effect, &b.effect) {
                    continue;
                }
                let at: Vec<usize> = a.columns.iter().chain(&b.columns).copied().collect();
                let mut distinct = at.clone();
                distinct.sort_unstable();
                distinct.dedup();
                let Some((gain, coefficients)) = solve(&self.gram, &at) else { continue };
                let (left, right) = coefficients.split_at(a.columns.len());
                let (Some(mut one), Some(mut two)) = (self.reseeded(a, left), self.reseeded(b, right)) else {
                    continue;
                };
                one.effect.beside = self.beside(&at, &coefficients);
                two.effect.beside = one.effect.beside.clone();
                all.push((gain - price * (a.size + b.size) as f64, one, two));
            }
        }
        all.sort_by(|x, y| y.0.total_cmp(&x.0));
        // Smoothing errors favour rich laws, so each leading pair comes with the simpler relatives of its
        // parts.
        let simpler = |rich: &Candidate, plain: &Candidate| {
            rich.effect.place.at == plain.effect.place.at
                && rich.effect.load == plain.effect.load
                && rich.effect.entry.law.simpler.contains(&plain.effect.entry.id)
        };
        let leads = all.len().min(count);
        let mut chosen: Vec<usize> = (0..leads).collect();
        for lead in 0..leads {
            let (a, b) = (&all[lead].1, &all[lead].2);
            chosen.extend((leads..all.len()).filter(|&k| {
                let (c, d) = (&all[k].1, &all[k].2);
                let related = |x: &Candidate, y: &Candidate| x.effect.same(&y.effect) || simpler(x, y);
                (related(a, c) && related(b, d)) || (related(a, d) && related(b, c))
            }));
        }
        // Pairs with the plain law of each strong family: rich friction laws often imitate Coulomb friction
        // plus another effect.
        let plain = |c: &Candidate| {
            self.candidates.iter().any(|r| simpler(r, c) && r.gain > PLAIN_GAIN * self.candidates[0].gain)
        };
        chosen.extend((leads..all.len()).filter(|&k| plain(&all[k].1) || plain(&all[k].2)).take(count));
        chosen.sort_unstable();
        chosen.dedup();
        chosen.into_iter().map(|k| (all[k].1.clone(), all[k].2.clone())).collect()
    }

    /// Values of the movable constants when columns `at` enter with these coefficients, from the joint
    /// regression.
    fn beside(&self, at: &[usize], coefficients: &[f64]) -> Vec<(String, f64)> {
        let of = |m: &Movable| {
            let taken: f64 = at.iter().zip(coefficients).map(|(&k, c)| c * self.follow[(m.row, k)]).sum();
            (m.name.clone(), m.now + self.follow[(m.row, 0)] - taken)
        };
        self.movable.iter().map(of).filter(|(_, value)| value.is_finite()).collect()
    }

    fn reseeded(&self, c: &Candidate, coefficients: &[f64]) -> Option<Candidate> {
        let effect = seeded(&c.effect, self.regressors[c.regressors].as_ref(), coefficients, &c.grid)?;
        Some(Candidate { effect, ..c.clone() })
    }
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
        for place in model.places().iter().filter(|p| fits(&entry.law, p)) {
            let start =
                entry.law.parameters.iter().map(|(_, p)| 0.0_f64.clamp(p.within.0, p.within.1)).collect();
            let plain = Effect {
                entry: entry.clone(),
                place: place.clone(),
                mirror: false,
                load: None,
                pressed_by: None,
                start,
                beside: vec![],
            };
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

/// The effect with parameters from coefficients and grid values; `None` outside the law's bounds.
fn seeded(
    effect: &Effect,
    regressors: Option<&Regressors>,
    coefficients: &[f64],
    grid: &[f64],
) -> Option<Effect> {
    let values = match regressors {
        Some(regressors) => regressors.parameters(coefficients, grid)?,
        None => match effect.entry.law.property() {
            Some("gain") => vec![1.0 + coefficients[0]],
            _ => vec![coefficients[0]],
        },
    };
    let inside = values.iter().zip(&effect.entry.law.parameters).all(|(v, (_, p))| {
        let slack = 1e-9 * (p.within.1 - p.within.0).abs().min(1.0);
        *v >= p.within.0 - slack && *v <= p.within.1 + slack
    });
    inside.then(|| Effect { start: constraint::inside(&effect.entry.law, &values), ..effect.clone() })
}
