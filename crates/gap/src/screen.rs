//! Every law at every place, at a glance: the linear response to the measured motion, one Gram matrix for all.

use crate::course::node;
use crate::draft::Draft;
use crate::drive::Drive;
use crate::effect::{Effect, Entry, fits};
use crate::motion::{Motion, rest_threshold, resting};
use crate::need;
use crate::place::{Place, Site, places};
use crate::recipe::{Recipe, Scale};
use crate::response::{Linear, shift};
use crate::whiteness::lines;
use faer::Mat;
use faer::linalg::solvers::Solve;
use phisindy_expr::{Id, Scratch, Tape};
use phisindy_learn::Calibration;
use phisindy_phys::System;
use phisindy_phys::spec::Role;
use rayon::prelude::*;

/// Rows of the regression at most: more say nothing new.
const ROWS: usize = 20_000;
/// Other starts that are kept for a law with numbers on a grid.
const SEEDS: usize = 3;
/// The same for laws that oscillate.
const TONES: usize = 8;
/// Values of a grid beyond these are not tried.
const GRID: usize = 200;
/// Decay of the linear stand-in of a body that comes to rest, per period.
const FORGET: f64 = 4.0;
/// A column of which less than this is left after projecting out what may move is no candidate.
const DEGENERATE: f64 = 1e-7;

/// A law at a place with its best numbers of the grid.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    /// With parameters from the regression.
    pub(crate) effect: Effect,
    /// By how much it lowers chi^2 in the regression, alone.
    pub(crate) gain: f64,
    /// Parameters that it adds.
    pub(crate) size: usize,
    /// The same from other numbers of the grid, next best.
    pub(crate) others: Vec<Effect>,
    columns: Vec<usize>,
    grid: Vec<f64>,
    recipe: usize,
}

/// What a screening found.
pub(crate) struct Screening {
    /// Best first, by gain less the price of the parameters.
    pub(crate) candidates: Vec<Candidate>,
    gram: Mat<f64>,
    /// How much of each column that was projected out is in each of the others.
    follow: Mat<f64>,
    movable: Vec<Movable>,
    recipes: Vec<Option<Recipe>>,
}

/// A movable constant of the model, whose column is projected out.
struct Movable {
    name: String,
    /// Where the model has it (SI).
    now: f64,
    /// Its row in [`Screening::follow`].
    row: usize,
}

/// What one evaluation of an effect gives: the columns of a trial, by record.
struct Trial {
    recipe: usize,
    effect: Effect,
    grid: Vec<f64>,
    /// Responses as rows, for each column.
    columns: Vec<Vec<f64>>,
}

/// One record, ready.
struct Ground {
    motion: Motion,
    /// Responses of the linear system.
    linear: Linear,
    /// Rate less A x, samples x n: what drives the linear system.
    bracket: Vec<f64>,
    /// Measured columns: state, value, weight.
    rows: Vec<(usize, Vec<f64>, f64)>,
    /// Rate of every state at every sample, contacts at rest taken into account.
    rates: Vec<f64>,
    stride: usize,
    /// The response of the model as it is, samples x n.
    known: Vec<f64>,
    /// For each place of a force, where it rests.
    still: Vec<Still>,
    /// The strongest lines of what the fitted model leaves of each column: noise of a few per cent hides them from the smoothed motion.
    left: Vec<f64>,
    /// Frequencies of the drive, without the effects that the model has been given.
    drive: Vec<f64>,
}

/// Where the velocity of a place rests.
struct Still {
    at: String,
    rests: Vec<bool>,
    /// The state that is held there by friction which the model has already.
    held: Option<usize>,
}

/// Screens the catalogue in a fitted model.
pub(crate) fn screen(
    draft: &Draft,
    fitted: &Calibration,
    catalogue: &[Entry],
    noise: &[Vec<f64>],
) -> Option<Screening> {
    let system = &draft.case.system;
    let of: Vec<usize> = (0..draft.records.len()).filter(|&r| draft.records[r].role == Role::Fit).collect();
    let total: usize = of.iter().map(|&r| draft.records[r].readings()).sum();
    let stride = total.div_ceil(ROWS).max(1);
    let all_places = places(system, &draft.case.records, &draft.internal);
    let base = Base::new(system)?;
    let grounds: Vec<Ground> = of
        .iter()
        .map(|&r| base.ground(system, draft, r, fitted, noise, stride, &all_places))
        .collect::<Option<_>>()?;
    // The columns that are projected out, and the target.
    let (fixed, movable) = base.fixed(system, draft, &of, &grounds);
    let effects = effects(draft, catalogue, &all_places);
    let made: Vec<(Option<Recipe>, Vec<Trial>)> = effects
        .par_iter()
        .enumerate()
        .map(|(k, effect)| match &effect.place.site {
            Site::Sensor(states) => (None, sensor_trials(k, effect, states, &grounds)),
            Site::Force { .. } => match Recipe::new(effect, system) {
                Some(recipe) => {
                    let trials = force_trials(k, effect, &recipe, system, &grounds);
                    (Some(recipe), trials)
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
    let recipes = made.iter().map(|_| None).collect();
    let mut screening = Screening { candidates: vec![], gram, follow, movable, recipes };
    let mut best: Vec<Vec<Candidate>> = vec![vec![]; effects.len()];
    let price = |size: usize| size as f64 * samples.ln();
    for (trial, at) in candidates {
        // Column indices after projection: the target is 0, fixed columns are gone.
        let at: Vec<usize> = at.into_iter().map(|k| k - fixed.len() + 1).collect();
        if at.iter().any(|&k| !kept[k]) {
            continue;
        }
        let Some((gain, coefficients)) = solve(&screening.gram, &at) else { continue };
        let recipe = made[trial.recipe].0.as_ref();
        let Some(effect) = seeded(&trial.effect, recipe, &coefficients, &trial.grid) else { continue };
        let effect = Effect { beside: screening.beside(&at, &coefficients), ..effect };
        let size = trial.effect.entry.law.parameters.len();
        let candidate = Candidate {
            effect,
            gain,
            size,
            others: vec![],
            columns: at,
            grid: trial.grid.clone(),
            recipe: trial.recipe,
        };
        best[trial.recipe].push(candidate);
    }
    screening.recipes = made.into_iter().map(|(r, _)| r).collect();
    screening.candidates = best
        .into_iter()
        .filter_map(|mut seeds| {
            seeds.sort_by(|a, b| b.gain.total_cmp(&a.gain));
            let others = others(&seeds, screening.recipes[seeds.first()?.recipe].as_ref(), &grounds);
            let first = seeds.into_iter().next()?;
            Some(Candidate { others, ..first })
        })
        .collect();
    screening.candidates.sort_by(|a, b| (b.gain - price(b.size)).total_cmp(&(a.gain - price(a.size))));
    Some(screening)
}

/// Other starts than the best of a law's `seeds`, which come best first: of a law that oscillates one for each line, for a body that sticks by turns answers at more lines than the
/// one that it is pushed at.
fn others(seeds: &[Candidate], recipe: Option<&Recipe>, grounds: &[Ground]) -> Vec<Effect> {
    let tone = recipe.and_then(|r| r.grid.iter().position(|(scale, _)| *scale == Scale::Frequency));
    let Some(tone) = tone else {
        return seeds.iter().skip(1).take(SEEDS).map(|c| c.effect.clone()).collect();
    };
    let fine = grounds.iter().map(Ground::resolution).fold(0.0, f64::max);
    let mut kept: Vec<&Candidate> = Vec::new();
    for seed in seeds {
        if kept.iter().all(|k| (k.grid[tone] - seed.grid[tone]).abs() > fine) {
            kept.push(seed);
        }
    }
    kept.into_iter().skip(1).take(TONES).map(|c| c.effect.clone()).collect()
}

impl Screening {
    /// The best pairs of candidates by the regression: indices, joint gain.
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
        // Smoothing errors favour rich laws: each leading pair also with the simpler relatives of its parts.
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
        // And the plain law of each family with everything: Coulomb and something else is what rich friction laws imitate.
        let plain = |c: &Candidate| {
            self.candidates.iter().any(|r| simpler(r, c) && r.gain > 0.5 * self.candidates[0].gain)
        };
        chosen.extend((leads..all.len()).filter(|&k| plain(&all[k].1) || plain(&all[k].2)).take(count));
        chosen.sort_unstable();
        chosen.dedup();
        chosen.into_iter().map(|k| (all[k].1.clone(), all[k].2.clone())).collect()
    }

    /// Where the movable constants go when columns `at` enter with these coefficients: the regression moves them along.
    fn beside(&self, at: &[usize], coefficients: &[f64]) -> Vec<(String, f64)> {
        let of = |m: &Movable| {
            let taken: f64 = at.iter().zip(coefficients).map(|(&k, c)| c * self.follow[(m.row, k)]).sum();
            (m.name.clone(), m.now + self.follow[(m.row, 0)] - taken)
        };
        self.movable.iter().map(of).filter(|(_, value)| value.is_finite()).collect()
    }

    fn reseeded(&self, c: &Candidate, coefficients: &[f64]) -> Option<Candidate> {
        let effect = seeded(&c.effect, self.recipes[c.recipe].as_ref(), coefficients, &c.grid)?;
        Some(Candidate { effect, ..c.clone() })
    }
}

/// Whether two effects describe one thing. A law and its mirror image do not: a body may have a stop on either side.
pub(crate) fn excludes(a: &Effect, b: &Effect) -> bool {
    let family = |e: &Effect| {
        let family = &e.entry.law.family;
        if family.is_empty() { e.entry.id.clone() } else { family.clone() }
    };
    a.place.at == b.place.at && a.mirror == b.mirror && family(a) == family(b)
}

/// Laws at places, with their mirror images and loads, that the model does not hold yet.
fn effects(draft: &Draft, catalogue: &[Entry], places: &[Place]) -> Vec<Effect> {
    let loads = loads(draft);
    let mut all = Vec::new();
    for entry in catalogue {
        for place in places.iter().filter(|p| fits(&entry.law, p)) {
            let start =
                entry.law.parameters.iter().map(|(_, p)| 0.0_f64.clamp(p.within.0, p.within.1)).collect();
            let plain = Effect {
                entry: entry.clone(),
                place: place.clone(),
                mirror: false,
                load: None,
                start,
                beside: vec![],
            };
            if entry.law.mirror.is_some() {
                all.push(Effect { mirror: true, ..plain.clone() });
            }
            if entry.law.family == "friction" && entry.law.internal.is_empty() {
                all.extend(loads.iter().map(|l| Effect { load: Some(l.clone()), ..plain.clone() }));
            }
            all.push(plain);
        }
    }
    all.retain(|e| !draft.effects.iter().any(|(held, ..)| excludes(held, e)));
    all
}

/// Constants of the records that are forces of different size: what friction may be in proportion to.
fn loads(draft: &Draft) -> Vec<String> {
    let system = &draft.case.system;
    (0..system.record_constants.len())
        .filter(|&k| {
            let values: Vec<f64> = draft.records.iter().map(|r| r.constants[k]).collect();
            let name = &system.record_constants[k].0;
            values.iter().all(|v| *v > 0.0)
                && values.iter().any(|v| (v - values[0]).abs() > 1e-9 * values[0])
                && !system.graph.uses(&system.known, &[system.record_constants[k].1])
                && is_force(draft, name)
        })
        .map(|k| system.record_constants[k].0.clone())
        .collect()
}

fn is_force(draft: &Draft, name: &str) -> bool {
    use phisindy_phys::spec::{ConstantSpec, DataSpec, read};
    use phisindy_phys::unit::{Dimension, Unit};
    let Ok((spec, _)) = read(&draft.text, phisindy_phys::SourceId(0)) else { return false };
    spec.data.iter().any(|d| {
        let constants = match d {
            DataSpec::Csv(c) => &c.constants,
            DataSpec::Synthetic(s) => &s.constants,
        };
        constants.iter().any(|(n, c)| {
            n.value == name
                && matches!(c, ConstantSpec::Number { unit: Some(u), .. }
                    if Unit::parse(&u.value).is_ok_and(|u| u.dimension == Dimension::NEWTON))
        })
    })
}

/// The effect with parameters from coefficients and grid, if they lie within the law's bounds.
fn seeded(effect: &Effect, recipe: Option<&Recipe>, coefficients: &[f64], grid: &[f64]) -> Option<Effect> {
    let values = match recipe {
        Some(recipe) => recipe.parameters(coefficients, grid)?,
        None => match effect.entry.law.sensor.as_deref() {
            Some("gain") => vec![1.0 + coefficients[0]],
            _ => vec![coefficients[0]],
        },
    };
    let inside = values.iter().zip(&effect.entry.law.parameters).all(|(v, (_, p))| {
        let slack = 1e-9 * (p.within.1 - p.within.0).abs().min(1.0);
        *v >= p.within.0 - slack && *v <= p.within.1 + slack
    });
    inside.then(|| Effect { start: need::inside(&effect.entry.law, &values), ..effect.clone() })
}

/// Gain and coefficients of some columns of a projected Gram matrix whose target is column 0.
fn solve(gram: &Mat<f64>, at: &[usize]) -> Option<(f64, Vec<f64>)> {
    let scale: Vec<f64> = at.iter().map(|&k| gram[(k, k)].sqrt()).collect();
    if scale.iter().any(|s| *s <= 0.0 || !s.is_finite()) {
        return None;
    }
    let n = at.len();
    let m = Mat::from_fn(n, n, |i, j| {
        gram[(at[i], at[j])] / (scale[i] * scale[j]) + if i == j { 1e-10 } else { 0.0 }
    });
    let right = Mat::from_fn(n, 1, |i, _| gram[(at[i], 0)] / scale[i]);
    let llt = m.llt(faer::Side::Lower).ok()?;
    let x = llt.solve(&right);
    let gain: f64 = (0..n).map(|i| x[(i, 0)] * right[(i, 0)]).sum();
    let coefficients: Vec<f64> = (0..n).map(|i| x[(i, 0)] / scale[i]).collect();
    (gain.is_finite() && coefficients.iter().all(|c| c.is_finite())).then_some((gain, coefficients))
}

/// A Gram matrix with some columns projected out of the others.
struct Projected {
    gram: Mat<f64>,
    /// Which columns still hold something.
    kept: Vec<bool>,
    /// Coefficients of the columns that are out in a regression of each of the others on them.
    follow: Mat<f64>,
}

/// The Gram matrix with columns 1 .. `fixed` projected out of all others (column 0 is the target).
fn projected(gram: &Mat<f64>, fixed: usize) -> Projected {
    let total = gram.ncols();
    let out: Vec<usize> = (1..fixed).filter(|&k| gram[(k, k)] > 0.0).collect();
    let rest: Vec<usize> = [0].into_iter().chain(fixed..total).collect();
    let scale: Vec<f64> = out.iter().map(|&k| 1.0 / gram[(k, k)].sqrt()).collect();
    let n = out.len();
    let m = Mat::from_fn(n, n, |i, j| {
        gram[(out[i], out[j])] * scale[i] * scale[j] + if i == j { 1e-12 } else { 0.0 }
    });
    let cross = Mat::from_fn(n, rest.len(), |i, j| gram[(out[i], rest[j])] * scale[i]);
    let own = Mat::from_fn(rest.len(), rest.len(), |i, j| gram[(rest[i], rest[j])]);
    let mut follow = Mat::zeros(fixed - 1, rest.len());
    let left = match m.llt(faer::Side::Lower) {
        Ok(llt) if n > 0 => {
            let solved = llt.solve(&cross);
            for (i, &k) in out.iter().enumerate() {
                (0..rest.len()).for_each(|j| follow[(k - 1, j)] = scale[i] * solved[(i, j)]);
            }
            &own - cross.transpose() * &solved
        }
        _ => own.clone(),
    };
    let kept = (0..rest.len()).map(|k| left[(k, k)] > DEGENERATE * own[(k, k)]).collect();
    Projected { gram: left, kept, follow }
}

/// The known rates, their Jacobian and their slopes by the parameters, on a tape.
struct Base {
    tape: Tape,
    n: usize,
    parameters: usize,
}

impl Base {
    fn new(system: &System) -> Option<Base> {
        let mut graph = system.graph.clone();
        let n = system.states.len();
        let states: Vec<Id> = system.states.iter().map(|s| s.node).collect();
        let parameters: Vec<Id> = system.parameters.iter().map(|p| p.node).collect();
        let mut outputs = system.known.clone();
        for row in 0..n {
            outputs.extend(graph.gradient(system.known[row], &states));
        }
        for row in 0..n {
            outputs.extend(graph.gradient(system.known[row], &parameters));
        }
        let one = graph.constant(1.0);
        outputs.extend(system.inertia.iter().map(|m| m.unwrap_or(one)));
        let tape = Tape::compile(&graph, &system.arguments(), &outputs).ok()?;
        Some(Base { tape, n, parameters: parameters.len() })
    }

    #[allow(clippy::too_many_arguments)] // what a record is, and what is known of it
    fn ground(
        &self,
        system: &System,
        draft: &Draft,
        record: usize,
        fitted: &Calibration,
        noise: &[Vec<f64>],
        stride: usize,
        places: &[Place],
    ) -> Option<Ground> {
        let n = self.n;
        let data = &draft.records[record];
        let motion = Motion::new(system, data, &draft.smooth[record], record, fitted);
        let samples = motion.samples();
        let values = evaluated(&self.tape, &motion, &[], &[]);
        if values[..n + n * n].iter().flatten().any(|v| !v.is_finite()) {
            return None;
        }
        let mean = |column: &[f64]| column.iter().sum::<f64>() / samples as f64;
        let mut a: Vec<f64> = values[n..n + n * n].iter().map(|c| mean(c)).collect();
        let span = motion.time[samples - 1] - motion.time[0];
        let mut rates: Vec<f64> = vec![0.0; samples * n];
        (0..samples * n).for_each(|i| rates[i] = values[i % n][i / n]);
        // What rests: bodies for which friction is or may be missing.
        let mut still: Vec<Still> = Vec::new();
        for place in places {
            let Site::Force { acts, velocity, .. } = &place.site else { continue };
            let speed = speed(system, &motion, place)?;
            let least = ((0.04 * motion.period / (span / samples as f64)) as usize).clamp(5, samples);
            let rests = resting(&speed, rest_threshold(&speed), least);
            // Friction that is in the model already holds with what force it needs.
            let bare = |text: &str| text.replace([' ', '(', ')'], "");
            let own = system.contacts.iter().any(|c| bare(&c.text) == bare(velocity) && system.rubs(c));
            if own {
                let inertia = |k: usize, i: usize| values[n + n * n + n * self.parameters + k][i];
                for i in (0..samples).filter(|&i| rests[i]) {
                    let (mut toward, mut give) = (0.0, 0.0);
                    for (j, &(k, sign)) in acts.iter().enumerate() {
                        let c = if j == 0 { 1.0 } else { -1.0 };
                        toward += c * rates[i * n + k];
                        give += c * sign / inertia(k, i);
                    }
                    for &(k, sign) in acts {
                        rates[i * n + k] -= toward / give * sign / inertia(k, i);
                    }
                }
            }
            let held = system.state(&place.at).filter(|_| own);
            still.push(Still { at: place.at.clone(), rests, held });
        }
        // A body at rest forgets; so must its linear stand-in, or errors made before a stop are carried past it.
        let forgets = still.iter().any(|s| s.rests.iter().filter(|r| **r).count() * 50 > samples);
        let decay = shift(&a, n, span).max(if forgets { FORGET / motion.period } else { 0.0 });
        (0..n).for_each(|k| a[k * n + k] -= decay);
        let bracket: Vec<f64> = (0..samples)
            .flat_map(|i| {
                let x = &motion.states[i * n..(i + 1) * n];
                let rates = &rates;
                let a = &a;
                (0..n).map(move |row| rates[i * n + row] - (0..n).map(|k| a[row * n + k] * x[k]).sum::<f64>())
            })
            .collect();
        let rows = (0..n)
            .filter_map(|k| {
                let column = data.columns[k].as_ref()?;
                Some((k, column.clone(), 1.0 / noise[record][k]))
            })
            .collect();
        let linear = Linear::new(&a, n, &motion.time);
        let known = linear.response(&bracket, &motion.states[..n]);
        let step = span / (samples - 1) as f64;
        let left = fitted.records[record].residuals.iter().flat_map(|e| lines(e, step, 4, 0)).collect();
        let bare = draft.without_effects();
        let drive = Drive::new(&bare.case.system, &bare.records[record]).map_or(vec![], |mut d| d.lines());
        Some(Ground { motion, linear, known, bracket, rows, rates, stride, still, left, drive })
    }

    /// Target and columns to project out, over all records: start states, parameters, sensors.
    fn fixed(
        &self,
        system: &System,
        draft: &Draft,
        of: &[usize],
        grounds: &[Ground],
    ) -> (Vec<Vec<f64>>, Vec<Movable>) {
        let n = self.n;
        let mut movable = Vec::new();
        let mut all: Vec<Vec<f64>> = Vec::new();
        let total: usize = grounds.iter().map(Ground::height).sum();
        let mut target = Vec::with_capacity(total);
        for ground in grounds {
            let predicted = ground.read(&ground.known, true);
            target.extend(ground.measured().iter().zip(&predicted).map(|(y, p)| y - p));
        }
        all.push(target);
        let mut before = 0;
        for ground in grounds {
            let zero = vec![0.0; ground.bracket.len()];
            let mut push = |rows: Vec<f64>| {
                let mut column = vec![0.0; total];
                column[before..before + rows.len()].copy_from_slice(&rows);
                all.push(column);
            };
            for k in 0..n {
                let mut start = vec![0.0; n];
                start[k] = 1.0;
                push(ground.read(&ground.linear.response(&zero, &start), false));
            }
            before += ground.height();
        }
        // Parameters: shared ones over all records, others (and sensors) record by record.
        let responses: Vec<Vec<Vec<f64>>> = grounds
            .par_iter()
            .map(|ground| {
                let values = evaluated(&self.tape, &ground.motion, &[], &[]);
                (0..self.parameters)
                    .map(|p| {
                        let samples = ground.motion.samples();
                        let mut g = vec![0.0; samples * n];
                        for row in 0..n {
                            let column = &values[n + n * n + row * self.parameters + p];
                            (0..samples).for_each(|i| g[i * n + row] = column[i]);
                        }
                        ground.quiet(&mut g);
                        ground.read(&ground.linear.response(&g, &vec![0.0; n]), false)
                    })
                    .collect()
            })
            .collect();
        for (p, parameter) in system.parameters.iter().enumerate() {
            let mut before = 0;
            let mut joint = vec![0.0; total];
            for (r, ground) in grounds.iter().enumerate() {
                let mut rows = responses[r][p].clone();
                let sensors = &draft.records[of[r]].sensors;
                for which in 0..3 {
                    let states: Vec<usize> = (0..n)
                        .filter(|&k| {
                            let s = &sensors[k];
                            [&s.offset, &s.gain, &s.delay][which].shared == Some(p)
                        })
                        .collect();
                    if !states.is_empty() {
                        let own = ground.sensor(&states, which);
                        rows.iter_mut().zip(own).for_each(|(a, b)| *a += b);
                    }
                }
                if parameter.each {
                    let mut column = vec![0.0; total];
                    column[before..before + rows.len()].copy_from_slice(&rows);
                    all.push(column);
                } else {
                    joint[before..before + rows.len()].copy_from_slice(&rows);
                }
                before += ground.height();
            }
            if !parameter.each {
                // Column 0 is the target.
                movable.push(Movable {
                    name: parameter.name.clone(),
                    now: parameter.start,
                    row: all.len() - 1,
                });
                all.push(joint);
            }
        }
        let mut before = 0;
        for (r, ground) in grounds.iter().enumerate() {
            for k in 0..n {
                let s = &draft.records[of[r]].sensors[k];
                for (which, p) in [&s.offset, &s.gain, &s.delay].into_iter().enumerate() {
                    if p.within.is_some()
                        && p.shared.is_none()
                        && ground.rows.iter().any(|(state, ..)| *state == k)
                    {
                        let rows = ground.sensor(&[k], which);
                        let mut column = vec![0.0; total];
                        column[before..before + rows.len()].copy_from_slice(&rows);
                        all.push(column);
                    }
                }
            }
            before += ground.height();
        }
        (all, movable)
    }
}

impl Ground {
    /// The distance of two frequencies that the record tells apart.
    fn resolution(&self) -> f64 {
        let (time, samples) = (&self.motion.time, self.motion.samples());
        2.0 * std::f64::consts::PI * (samples - 1) as f64 / (samples as f64 * (time[samples - 1] - time[0]))
    }

    /// Rows of this record.
    fn height(&self) -> usize {
        self.rows.len() * self.motion.samples().div_ceil(self.stride)
    }

    /// The measured columns as rows.
    fn measured(&self) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.height());
        for (_, column, weight) in &self.rows {
            out.extend(column.iter().step_by(self.stride).map(|y| y * weight));
        }
        out
    }

    /// A response of all states (samples x n) as the sensors read it; the offset belongs to the whole, not to a part.
    fn read(&self, states: &[f64], whole: bool) -> Vec<f64> {
        let n = states.len() / self.motion.samples();
        let mut out = Vec::with_capacity(self.height());
        for (k, _, weight) in &self.rows {
            let (gain, offset) = self.motion.sensors[*k];
            let offset = if whole { offset } else { 0.0 };
            out.extend(
                (0..self.motion.samples())
                    .step_by(self.stride)
                    .map(|i| weight * (gain * states[i * n + k] + offset)),
            );
        }
        out
    }

    /// What a small change of a sensor parameter of some states adds: 0 offset, 1 gain, 2 delay.
    fn sensor(&self, states: &[usize], which: usize) -> Vec<f64> {
        let n = self.rates.len() / self.motion.samples();
        let mut out = Vec::with_capacity(self.height());
        for (k, _, weight) in &self.rows {
            let on = states.contains(k);
            let gain = self.motion.sensors[*k].0;
            out.extend((0..self.motion.samples()).step_by(self.stride).map(|i| {
                let change = match which {
                    0 => 1.0,
                    // Of what the model says, not of what is measured: that would explain everything.
                    1 => self.known[i * n + k],
                    _ => -gain * self.slope(i, *k, n),
                };
                if on { weight * change } else { 0.0 }
            }));
        }
        out
    }

    /// The slope of a state: of a displacement its smoothed velocity would do; by differences it serves every state.
    fn slope(&self, i: usize, k: usize, n: usize) -> f64 {
        let t = &self.motion.time;
        let (a, b) = (i.saturating_sub(1), (i + 1).min(t.len() - 1));
        (self.motion.states[b * n + k] - self.motion.states[a * n + k]) / (t[b] - t[a])
    }

    /// Takes away what a force would do to a body that rests in a contact of the model.
    fn quiet(&self, g: &mut [f64]) {
        let n = g.len() / self.motion.samples();
        for (k, rests) in self.still.iter().filter_map(|s| Some((s.held?, &s.rests))) {
            rests.iter().enumerate().filter(|(_, r)| **r).for_each(|(i, _)| g[i * n + k] = 0.0);
        }
    }
}

/// All outputs of a tape along a motion; `grid` are further inputs, and `series` further inputs that vary.
pub(crate) fn evaluated(tape: &Tape, motion: &Motion, grid: &[f64], series: &[&[f64]]) -> Vec<Vec<f64>> {
    const LANES: usize = 64;
    let samples = motion.samples();
    let (n, m) = (motion.states.len() / samples, motion.inputs.len() / samples);
    let mut scratch = Scratch::<LANES>::new(tape);
    let after = 1 + n + m;
    for (k, v) in motion.numbers.iter().chain(grid).enumerate() {
        *scratch.input(after + k) = [*v; LANES];
    }
    let last = after + motion.numbers.len() + grid.len();
    let mut out = vec![Vec::with_capacity(samples); tape.outputs()];
    for first in (0..samples).step_by(LANES) {
        let count = LANES.min(samples - first);
        for lane in 0..LANES {
            let i = first + lane.min(count - 1);
            scratch.input(0)[lane] = motion.time[i];
            (0..n).for_each(|k| scratch.input(1 + k)[lane] = motion.states[i * n + k]);
            (0..m).for_each(|k| scratch.input(1 + n + k)[lane] = motion.inputs[i * m + k]);
            series.iter().enumerate().for_each(|(k, s)| scratch.input(last + k)[lane] = s[i]);
        }
        scratch.run();
        out.iter_mut().enumerate().for_each(|(k, o)| o.extend(&scratch.output(k)[..count]));
    }
    out
}

/// The velocity of a place along a motion.
fn speed(system: &System, motion: &Motion, place: &Place) -> Option<Vec<f64>> {
    let Site::Force { velocity, .. } = &place.site else { return None };
    let mut graph = system.graph.clone();
    let speed = node(&mut graph, system, velocity)?;
    let tape = Tape::compile(&graph, &system.arguments(), &[speed]).ok()?;
    evaluated(&tape, motion, &[], &[]).pop()
}

/// Offset, gain or delay of the sensors of some states.
fn sensor_trials(recipe: usize, effect: &Effect, states: &[usize], grounds: &[Ground]) -> Vec<Trial> {
    let which = match effect.entry.law.sensor.as_deref() {
        Some("offset") => 0,
        Some("gain") => 1,
        _ => 2,
    };
    let column = grounds.iter().flat_map(|g| g.sensor(states, which)).collect();
    vec![Trial { recipe, effect: effect.clone(), grid: vec![], columns: vec![column] }]
}

/// A force law over its grid.
fn force_trials(
    index: usize,
    effect: &Effect,
    recipe: &Recipe,
    system: &System,
    grounds: &[Ground],
) -> Vec<Trial> {
    let Site::Force { acts, .. } = &effect.place.site else { return vec![] };
    let n = system.states.len();
    let law = &effect.entry.law;
    let mut graph = recipe.graph.clone();
    let one = graph.constant(1.0);
    let mut outputs = Vec::new();
    for &column in &recipe.columns {
        for &(state, sign) in acts {
            let over = graph.div(column, system.inertia[state].unwrap_or(one));
            outputs.push(if sign < 0.0 { graph.neg(over) } else { over });
        }
    }
    // What a unit of friction does, to hold a body at rest.
    for &(state, sign) in acts {
        let over = graph.div(one, system.inertia[state].unwrap_or(one));
        outputs.push(if sign < 0.0 { graph.neg(over) } else { over });
    }
    outputs.push(recipe.velocity);
    outputs.push(recipe.displacement.unwrap_or(recipe.velocity));
    let mut all = system.arguments();
    all.extend(&recipe.symbols);
    let internal = recipe.internal.map(|(z, rate)| (z, rate, graph.gradient(rate, &[z])[0]));
    all.extend(internal.iter().map(|(z, ..)| *z));
    let Ok(tape) = Tape::compile(&graph, &all, &outputs) else { return vec![] };
    let inner = internal.and_then(|(_, rate, slope)| Tape::compile(&graph, &all, &[rate, slope]).ok());
    let count = recipe.columns.len();
    let width = acts.len();
    let sticks = law.sticks();
    let mut trials = Vec::new();
    for grid in grids(recipe, effect, system, grounds, &tape, inner.is_some()) {
        let mut columns: Vec<Vec<f64>> = vec![vec![]; count];
        let mut holding: Vec<f64> = vec![];
        let mut held = false;
        for ground in grounds {
            let samples = ground.motion.samples();
            let z = inner.as_ref().map(|tape| remembered(tape, &ground.motion, &grid));
            let values =
                evaluated(&tape, &ground.motion, &grid, &z.iter().map(Vec::as_slice).collect::<Vec<_>>());
            let still = ground.still.iter().find(|s| s.at == effect.place.at);
            let rests = |i: usize| sticks && still.is_some_and(|s| s.rests[i]);
            for (c, column) in columns.iter_mut().enumerate() {
                let mut g = vec![0.0; samples * n];
                for (j, &(state, _)) in acts.iter().enumerate() {
                    let force = &values[c * width + j];
                    (0..samples)
                        .filter(|&i| !rests(i))
                        .for_each(|i| g[i * n + state] = if force[i].is_finite() { force[i] } else { 0.0 });
                }
                ground.quiet(&mut g);
                column.extend(ground.read(&ground.linear.response(&g, &vec![0.0; n]), false));
            }
            // At rest the missing friction is what the other forces need to be held.
            if sticks {
                let mut g = vec![0.0; samples * n];
                for i in (0..samples).filter(|&i| rests(i)) {
                    held = true;
                    let (mut toward, mut give) = (0.0, 0.0);
                    for (j, &(state, _)) in acts.iter().enumerate() {
                        let c = if j == 0 { 1.0 } else { -1.0 };
                        toward += c * ground.rates[i * n + state];
                        give += c * values[count * width + j][i];
                    }
                    toward -= base_slope(system, &effect.place, ground, i);
                    for (j, &(state, _)) in acts.iter().enumerate() {
                        g[i * n + state] = -toward / give * values[count * width + j][i];
                    }
                }
                holding.extend(ground.read(&ground.linear.response(&g, &vec![0.0; n]), false));
            }
        }
        if held {
            columns.push(holding);
        }
        let trial = Trial { recipe: index, effect: effect.clone(), grid, columns };
        trials.push(trial);
    }
    trials
}

/// The acceleration of an input against which a body rests.
fn base_slope(system: &System, place: &Place, ground: &Ground, i: usize) -> f64 {
    let Some((_, second)) = place.at.split_once('-') else { return 0.0 };
    let m = ground.motion.inputs.len() / ground.motion.samples();
    system.input(second).map_or(0.0, |u| ground.motion.slopes[i * m + u])
}

/// An internal state along a motion, by exponential steps: exact where its rate is linear in it.
fn remembered(tape: &Tape, motion: &Motion, grid: &[f64]) -> Vec<f64> {
    let samples = motion.samples();
    let (n, m) = (motion.states.len() / samples, motion.inputs.len() / samples);
    let mut scratch = Scratch::<1>::new(tape);
    let after = 1 + n + m;
    for (k, v) in motion.numbers.iter().chain(grid).enumerate() {
        scratch.input(after + k)[0] = *v;
    }
    let last = after + motion.numbers.len() + grid.len();
    let mut z = vec![0.0; samples];
    for i in 0..samples - 1 {
        scratch.input(0)[0] = motion.time[i];
        // In the middle of the step.
        let middle = |v: &[f64], w: usize, k: usize| 0.5 * (v[i * w + k] + v[(i + 1) * w + k]);
        (0..n).for_each(|k| scratch.input(1 + k)[0] = middle(&motion.states, n, k));
        (0..m).for_each(|k| scratch.input(1 + n + k)[0] = middle(&motion.inputs, m, k));
        scratch.input(last)[0] = z[i];
        scratch.run();
        let (rate, slope) = (scratch.output(0)[0], scratch.output(1)[0]);
        let h = motion.time[i + 1] - motion.time[i];
        let decay = slope * h;
        let factor = if decay.abs() < 1e-8 { h } else { decay.exp_m1() / slope };
        let next = z[i] + rate * factor;
        z[i + 1] = if next.is_finite() { next } else { 0.0 };
    }
    z
}

/// The numbers of the grid that suit the motion.
fn grids(
    recipe: &Recipe,
    effect: &Effect,
    system: &System,
    grounds: &[Ground],
    tape: &Tape,
    memory: bool,
) -> Vec<Vec<f64>> {
    if recipe.grid.is_empty() {
        return vec![vec![]];
    }
    let outputs = tape.outputs();
    let n = system.states.len();
    let (mut speeds, mut places) = (Vec::new(), Vec::new());
    let mut frequencies: Vec<f64> = Vec::new();
    for ground in grounds {
        let samples = ground.motion.samples();
        let zero = vec![0.0; samples];
        let series: Vec<&[f64]> = if memory { vec![&zero] } else { vec![] };
        let values = evaluated(tape, &ground.motion, &vec![0.0; recipe.grid.len()], &series);
        speeds.extend(values[outputs - 2].iter().map(|v| v.abs()));
        places.extend(values[outputs - 1].iter().copied());
        if recipe.grid.iter().any(|(s, _)| *s == Scale::Frequency) {
            let Site::Force { state, .. } = &effect.place.site else { continue };
            let step = (ground.motion.time[samples - 1] - ground.motion.time[0]) / (samples - 1) as f64;
            // The missing rate, times what the law multiplies its oscillation with.
            let lack: Vec<f64> = (0..samples)
                .map(|i| (ground.slope(i, *state, n) - ground.rates[i * n + state]) * values[0][i])
                .collect();
            let fine = ground.resolution();
            // In a motion of one period every periodic lack can be written as forces at its multiples: they would explain anything.
            let own = 2.0 * std::f64::consts::PI / ground.motion.period;
            let echo = |w: f64| {
                // At a frequency of the drive a force stands for anything that is missing.
                ground.drive.iter().any(|line| (w - line).abs() < fine)
                    || ground.motion.periodic && (w / own - (w / own).round()).abs() * own < 2.0 * fine
            };
            // Strong as a force, or far above the noise of a second derivative.
            let lack = smoothed(&lack, ground.motion.period / step);
            let strong = lines(&lack, step, 6, 0);
            let clear = lines(&lack, step, 4, 4);
            for line in strong.into_iter().chain(clear).chain(ground.left.iter().copied()) {
                if !echo(line) {
                    let near = [-0.5, -0.25, 0.0, 0.25, 0.5].map(|d| line + d * fine);
                    frequencies.extend(near.into_iter().filter(|w| *w > 0.0));
                }
            }
        }
    }
    let sorted = |mut v: Vec<f64>| -> Vec<f64> {
        v.retain(|x| x.is_finite());
        v.sort_unstable_by(f64::total_cmp);
        v
    };
    let speeds = sorted(speeds);
    let signed = sorted(places.clone());
    let sizes = sorted(places.iter().map(|x| x.abs()).collect());
    let quantile =
        |v: &[f64], q: f64| v.get(((v.len().max(1) - 1) as f64 * q) as usize).copied().unwrap_or(0.0);
    let axis = |(scale, negative): &(Scale, bool)| -> Vec<f64> {
        match scale {
            Scale::Speed => {
                let top = quantile(&speeds, 0.99);
                [0.01, 0.02, 0.04, 0.07, 0.12, 0.2, 0.3, 0.45, 0.7].iter().map(|q| q * top).collect()
            }
            Scale::Displacement if memory => {
                let top = quantile(&sizes, 0.99);
                [0.001, 0.003, 0.01, 0.02, 0.04, 0.08, 0.15, 0.3, 0.6].iter().map(|q| q * top).collect()
            }
            Scale::Displacement if *negative => (1..20)
                .map(|k| quantile(&signed, f64::from(k) / 20.0))
                .chain([0.98, 0.99].map(|q| quantile(&signed, q)))
                .collect(),
            Scale::Displacement => [0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95]
                .iter()
                .map(|q| quantile(&sizes, 0.99) * q)
                .collect(),
            Scale::Frequency => frequencies.clone(),
            Scale::Any => (-3..=3).map(|k| 10f64.powi(k)).collect(),
        }
    };
    let mut all: Vec<Vec<f64>> = vec![vec![]];
    for of in &recipe.grid {
        let values = axis(of);
        all =
            all.iter().flat_map(|g| values.iter().map(|v| g.iter().copied().chain([*v]).collect())).collect();
        all.truncate(GRID);
    }
    all
}

/// A moving mean over a twentieth of a period: what is left of a second derivative above the motion is noise.
fn smoothed(values: &[f64], period: f64) -> Vec<f64> {
    let half = ((period / 40.0) as usize).clamp(1, values.len() / 4 + 1);
    let mut sums = vec![0.0; values.len() + 1];
    values.iter().enumerate().for_each(|(i, v)| sums[i + 1] = sums[i] + v);
    (0..values.len())
        .map(|i| {
            let (a, b) = (i.saturating_sub(half), (i + half + 1).min(values.len()));
            (sums[b] - sums[a]) / (b - a) as f64
        })
        .collect()
}

/// The mean of an expression along a motion.
pub(crate) fn mean_along(
    system: &System,
    graph: &phisindy_expr::Graph,
    node: Id,
    motion: &Motion,
) -> Option<f64> {
    let tape = Tape::compile(graph, &system.arguments(), &[node]).ok()?;
    let values = evaluated(&tape, motion, &[], &[]);
    let mean = values[0].iter().sum::<f64>() / values[0].len().max(1) as f64;
    mean.is_finite().then_some(mean)
}

/// An imitation that explains this part of what the best one does is worth a fit of its own: the regression weighs speeds as the sibling's force has them.
const NEARLY: f64 = 0.9;
/// Of the highest speed, what counts as rest for it, and a speed at which a contact has just begun to slip.
const SLOW: f64 = 2e-3;
const JUST: f64 = 1e-5;

/// Starts of a law from the force that a fitted sibling at the same place has: its columns regressed on that force along the motion, one for each of its inner
/// parameters that does nearly as well as the best. None where that gives nothing within the law's bounds.
pub(crate) fn imitated(
    draft: &Draft,
    fitted: &Calibration,
    sibling: &Effect,
    entry: &Entry,
) -> Option<Vec<Effect>> {
    let system = &draft.case.system;
    let r = draft.records.iter().position(|r| r.role == Role::Fit)?;
    let mut motion = Motion::new(system, &draft.records[r], &draft.smooth[r], r, fitted);
    let start = entry.law.parameters.iter().map(|_| 0.0).collect();
    let wanted = Effect { entry: entry.clone(), start, mirror: false, ..sibling.clone() };
    let (own, other) = (Recipe::new(sibling, system)?, Recipe::new(&wanted, system)?);
    // What a contact holds at rest it holds just before it slips.
    let speeds: Vec<f64> = speed(system, &motion, &sibling.place)?;
    let top = speeds.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let (slow, n) = (SLOW * top, system.states.len());
    let Site::Force { acts, .. } = &sibling.place.site else { return None };
    let &(state, _) = acts.first()?;
    for (i, speed) in speeds.iter().enumerate().filter(|(_, speed)| speed.abs() <= slow) {
        motion.states[i * n + state] += JUST * top * speed.signum() - speed;
    }
    let along = |recipe: &Recipe, grid: &[f64]| -> Option<Vec<Vec<f64>>> {
        let mut all = system.arguments();
        all.extend(&recipe.symbols);
        let tape = Tape::compile(&recipe.graph, &all, &recipe.columns).ok()?;
        Some(evaluated(&tape, &motion, grid, &[]))
    };
    let (coefficients, grid) = own.direct(&sibling.start)?;
    let columns = along(&own, &grid)?;
    let samples = motion.samples();
    let force: Vec<f64> =
        (0..samples).map(|i| columns.iter().zip(&coefficients).map(|(c, k)| c[i] * k).sum()).collect();
    let tried: Vec<Vec<f64>> = match other.grid.len() {
        0 => vec![vec![]],
        1 => [0.01, 0.03, 0.1, 0.3].iter().map(|q| vec![q * top]).collect(),
        _ => return None,
    };
    let mut all: Vec<(f64, Effect)> = Vec::new();
    for grid in tried {
        let columns = along(&other, &grid)?;
        let n = columns.len() + 1;
        let value = |k: usize, i: usize| if k == 0 { force[i] } else { columns[k - 1][i] };
        let gram = Mat::from_fn(n, n, |a, b| (0..samples).map(|i| value(a, i) * value(b, i)).sum::<f64>());
        let at: Vec<usize> = (1..n).collect();
        let Some((gain, found)) = solve(&gram, &at) else { continue };
        all.extend(seeded(&wanted, Some(&other), &found, &grid).map(|effect| (gain, effect)));
    }
    let best = all.iter().map(|(gain, _)| *gain).fold(0.0, f64::max);
    Some(all.into_iter().filter(|(gain, _)| *gain > NEARLY * best).map(|(_, e)| e).collect())
}
