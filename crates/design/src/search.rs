//! The search among runs: a grid of drives, then the best of each form made better.

use crate::DECIDED;
use crate::information::{Narrowed, Separation, narrowed, separation};
use crate::limits::{Limits, Range, step};
use crate::rival::{Noise, Response, Rival, Unfit};
use crate::trial::{Shape, Trial, Waveform};
use phisindy_phys::{Record, System};
use rayon::prelude::*;
use std::fmt;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Frequencies of the grid, evenly spaced in their logarithm over the band.
const FREQUENCIES: usize = 5;
/// Amplitudes of the grid, as parts of what the limits allow.
const AMPLITUDES: [f64; 2] = [1.0, 0.3];
/// By how much the best drives are changed in search of better ones, one after the other.
const REFINEMENTS: [f64; 3] = [1.3, 1.15, 1.07];
/// So many forms are made better.
const REFINED: usize = 3;
/// A shorter run is taken where it leaves the wrong models no more than this: a hundredth of what leaves a question open, for
/// what linear responses do not know.
const ROOM: f64 = (1.0 - DECIDED) / 100.0;
/// A run is shortened by halves, and never to fewer samples than this: they tell the noise to 7 %.
const FEWEST_SAMPLES: usize = 200;
/// Samples of a run: `gap` takes no fewer, a record has no more.
const FEWEST: f64 = 64.0;
const MOST: f64 = 2e6;
/// How often the last run is repeated for comparison.
const LONGER: usize = 3;

/// What a run is to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Aim {
    /// Tell the models apart.
    Separate,
    /// Narrow one number of the first model.
    Narrow(String),
    /// Narrow all numbers of the first model.
    NarrowAll,
}

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Activity {
    /// Runs that were looked at.
    pub tried: usize,
}

impl fmt::Display for Activity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "looking at runs: {} so far", self.tried)
    }
}

/// A run and what it promises.
#[derive(Clone, Debug)]
pub struct Run {
    /// The run.
    pub trial: Trial,
    /// What it is ranked by (nats): by how much less probable the wrong models become, or by how much narrower the numbers;
    /// less for motions that a small error changes.
    pub value: f64,
    /// How well it tells the models apart.
    pub separation: Separation,
    /// What it makes of the numbers of the first model.
    pub narrowed: Narrowed,
    /// The share of points in which contacts stop as often as foreseen, over all models.
    pub steady: f64,
}

/// The runs that are best, and what a run as before would do.
#[derive(Clone, Debug)]
pub struct Design {
    /// The best of each form, the best one first.
    pub runs: Vec<Run>,
    /// The last run once more.
    pub again: Option<Run>,
    /// The last run three times as long.
    pub longer: Option<Run>,
    /// How many runs were looked at.
    pub tried: usize,
    /// How many of them would leave the limits of a quantity, or cannot be simulated.
    pub refused: Vec<(String, usize)>,
    /// Models that cannot be simulated, and why not: no run is designed for them.
    pub left_out: Vec<(String, String)>,
    /// Whether the work was stopped before its end.
    pub stopped: bool,
}

/// Why there is no run.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// There is nothing that may be driven, and no displacement from which it may be let go.
    NothingDrives,
    /// A run of the stated duration has fewer or more samples than a record may have: the least and the longest (s).
    Duration(f64, f64),
    /// No run can be made: why, and how often.
    Forbidden(Vec<(String, usize)>),
    /// No run of this model can be simulated.
    CannotBeSimulated(String, String),
    /// No model has this number; these are there.
    NoNumber(String, Vec<String>),
    /// One model is left, and none of its numbers was to be found.
    NothingOpen,
    /// It was stopped before anything was found.
    Stopped,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Failure::NothingDrives => f.write_str(
                "nothing of the rig may be driven or let go: name an input or a displacement in `limits`, as in `limits: { \"F\": (-5.0, 5.0), duration: 20.0 }`",
            ),
            Failure::Duration(least, most) => write!(
                f,
                "at the rate of the records a run takes {least:.3} to {most:.3e} s: change `duration` in `limits`"
            ),
            Failure::Forbidden(by) => {
                let by: Vec<String> = by.iter().map(|(why, n)| format!("{why} (in {n})")).collect();
                write!(f, "no run that was looked at can be made: {}", by.join(", "))
            }
            Failure::CannotBeSimulated(rival, why) => {
                write!(f, "no run of `{rival}` can be simulated: {why}")
            }
            Failure::NoNumber(name, known) => {
                write!(f, "there is no number `{name}` to narrow; there is: {}", known.join(", "))
            }
            Failure::NothingOpen => f.write_str(
                "one model is left, and all its numbers are held: nothing is open that a run could decide",
            ),
            Failure::Stopped => f.write_str("stopped before a run was found"),
        }
    }
}

/// The runs after which most is known of these models, the most probable one first. `noise` is that of each measured
/// column (SI), `readings` how many were fitted so far. `observe` hears of the progress, and may stop the search, which then returns the best so far.
///
/// # Errors
/// See [`Failure`].
pub fn design(
    rivals: &[Rival],
    limits: &Limits,
    (noise, readings): (&[Noise], &f64),
    aim: &Aim,
    observe: &(dyn Fn(f64, Activity) -> ControlFlow<()> + Sync),
) -> Result<Design, Failure> {
    let first = &rivals[0];
    if let Aim::Narrow(name) = aim
        && !first.numbers.iter().any(|(own, ..)| own == name)
    {
        return Err(Failure::NoNumber(name.clone(), first.numbers.iter().map(|(n, ..)| n.clone()).collect()));
    }
    if *aim != Aim::Separate && (0..first.numbers.len()).all(|k| first.std_error(k) == 0.0) {
        return Err(Failure::NothingOpen);
    }
    possible(&first.systems[0], &first.like, limits)?;
    let grid = grid(first, limits);
    let (rivals, left_out) = able(rivals, &grid)?;
    let (rivals, first) = (&rivals[..], &rivals[0]);
    let settings = first.systems.len();
    let refinements = REFINED * (REFINEMENTS.len() * 4 + settings - 1);
    let search = Search {
        rivals,
        limits,
        noise,
        readings: *readings,
        aim,
        observe,
        all: grid.len() + refinements + 2,
        tried: AtomicUsize::new(0),
        stopped: AtomicBool::new(false),
    };
    let looked: Vec<Result<Run, Refused>> =
        grid.par_iter().filter_map(|trial| search.look(trial, true)).collect();
    let mut refused: Vec<(String, usize)> = Vec::new();
    let (mut fine, mut unfit) = (Vec::new(), Vec::new());
    for result in looked {
        match result {
            Ok(run) => fine.push(run),
            Err(why) => unfit.push(why),
        }
    }
    for why in &unfit {
        let what = match &why.model {
            Some(model) => format!("{}: {model}", why.what),
            None => format!("`{}` leaves its limits", why.what),
        };
        match refused.iter_mut().find(|(other, _)| *other == what) {
            Some((_, count)) => *count += 1,
            None => refused.push((what, 1)),
        }
    }
    refused.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
    if fine.is_empty() {
        if search.stopped.load(Ordering::Relaxed) {
            return Err(Failure::Stopped);
        }
        return Err(Failure::Forbidden(refused));
    }
    let mut runs = best_of_each_form(fine);
    for run in runs.iter_mut().take(REFINED) {
        search.refine(run);
    }
    runs.sort_by(|a, b| b.value.total_cmp(&a.value));
    for run in &mut runs {
        search.shorten(run);
    }
    let step = limits.step(&first.like);
    let repeated =
        |times| search.look(&Trial::repeated(&first.like, step, times), false).and_then(Result::ok);
    let drives = !first.like.inputs.is_empty();
    let (again, longer) = (repeated(1).filter(|_| drives), repeated(LONGER).filter(|_| drives));
    let (tried, stopped) = (search.tried.load(Ordering::Relaxed), search.stopped.load(Ordering::Relaxed));
    Ok(Design { runs, again, longer, tried, refused, left_out, stopped })
}

/// Models, and those that are left out with the reason.
type Able = (Vec<Rival>, Vec<(String, String)>);

/// The models that can be simulated, with probabilities among these, and those that cannot, with the reason: in none of a
/// few runs all over the grid.
fn able(rivals: &[Rival], grid: &[Trial]) -> Result<Able, Failure> {
    const TRIED: usize = 5;
    let (mut able, mut left_out) = (Vec::new(), Vec::new());
    for rival in rivals {
        let mut trials = grid.iter().step_by(grid.len().div_ceil(TRIED));
        let numbers: Vec<f64> = rival.numbers.iter().map(|(_, value, _)| *value).collect();
        let run =
            |trial: &Trial| rival.predicted(trial, &trial.record(&rival.like), &numbers, &rival.start(trial));
        let mut why = String::new();
        if trials.any(|trial| run(trial).map_err(|e| why = e.to_string()).is_ok()) {
            able.push(rival.clone());
        } else {
            left_out.push((rival.name.clone(), why));
        }
    }
    let all: f64 = able.iter().map(|rival| rival.probability).sum();
    able.iter_mut().for_each(|rival| rival.probability /= all);
    match (able.is_empty(), left_out.first()) {
        (true, Some((name, why))) => Err(Failure::CannotBeSimulated(name.clone(), why.clone())),
        _ => Ok((able, left_out)),
    }
}

/// A run that cannot be made: for leaving the limits of a quantity, or because a model fails, with its reason.
struct Refused {
    what: String,
    model: Option<String>,
}

impl Refused {
    fn of(rival: &Rival, why: Unfit) -> Refused {
        match why {
            Unfit::Leaves(what) => Refused { what, model: None },
            Unfit::Model(why) => Refused { what: rival.name.clone(), model: Some(why.to_string()) },
        }
    }
}

struct Search<'a> {
    rivals: &'a [Rival],
    limits: &'a Limits,
    noise: &'a [Noise],
    readings: f64,
    aim: &'a Aim,
    observe: &'a (dyn Fn(f64, Activity) -> ControlFlow<()> + Sync),
    /// About how many runs will be looked at.
    all: usize,
    tried: AtomicUsize,
    stopped: AtomicBool,
}

impl Search<'_> {
    /// Looks at a run; `None` once the search is stopped.
    fn look(&self, trial: &Trial, within: bool) -> Option<Result<Run, Refused>> {
        if self.stopped.load(Ordering::Relaxed) {
            return None;
        }
        let tried = self.tried.fetch_add(1, Ordering::Relaxed);
        let fraction = (tried as f64 / self.all as f64).min(0.99);
        if (self.observe)(fraction, Activity { tried }).is_break() {
            self.stopped.store(true, Ordering::Relaxed);
            return None;
        }
        Some(self.responses(trial, within).map(|responses| self.judged(trial, &responses, trial.samples)))
    }

    /// What each model predicts, in units of the noise.
    fn responses(&self, trial: &Trial, within: bool) -> Result<Vec<Response>, Refused> {
        let of = |rival: &Rival| {
            rival.response(trial, within.then_some(self.limits)).map_err(|why| Refused::of(rival, why))
        };
        let responses: Vec<Response> = self.rivals.iter().map(of).collect::<Result<_, _>>()?;
        // A run that is looked at in fewer samples than are measured knows each of them better.
        let exact = (step(&self.rivals[0].like) / trial.step).sqrt().min(1.0);
        let readings = responses[0].mean.iter().zip(self.noise.iter().cycle());
        let sizes: Vec<f64> =
            readings.map(|(x, noise)| exact * noise.additive.hypot(noise.relative * x)).collect();
        Ok(responses.iter().map(|response| response.over(&sizes)).collect())
    }

    /// What the first samples of a run promise.
    fn judged(&self, trial: &Trial, responses: &[Response], samples: usize) -> Run {
        let whole = samples == trial.samples;
        let cut = |r: &Response| r.first(samples * self.noise.len());
        let responses: Vec<Response> =
            if whole { responses.to_vec() } else { responses.iter().map(cut).collect() };
        let probabilities: Vec<f64> = self.rivals.iter().map(|r| r.probability).collect();
        // Numbers cost half a logarithm of the readings each (G. Schwarz 1978, doi 10.1214/aos/1176344136).
        let readings = self.noise.len() as f64 * samples as f64 * trial.step / step(&self.rivals[0].like);
        let price = |rival: &Rival| 0.5 * rival.numbers.len() as f64 * (1.0 + readings / self.readings).ln();
        let models: Vec<(f64, f64)> = self.rivals.iter().map(|r| (r.probability, price(r))).collect();
        let separation = separation(&responses.iter().collect::<Vec<_>>(), &models);
        let narrowed = narrowed(&responses[0], &self.rivals[0].directions);
        let steady = responses.iter().zip(&probabilities).map(|(r, p)| p * r.steady()).sum();
        let gain = match self.aim {
            Aim::Separate => {
                let before: f64 = probabilities.iter().map(|p| p * (1.0 - p)).sum();
                (before / separation.wrong.max(f64::MIN_POSITIVE)).ln()
            }
            Aim::NarrowAll => narrowed.gain,
            Aim::Narrow(name) => {
                let first = &self.rivals[0];
                let k = first.numbers.iter().position(|(own, ..)| own == name).unwrap_or(0);
                (first.std_error(k) / narrowed.std_errors[k]).ln()
            }
        };
        let trial = if whole { trial.clone() } else { trial.first(samples) };
        Run { trial, value: gain * steady, separation, narrowed, steady }
    }

    /// Other frequencies, amplitudes and settings of constants, as long as they are better.
    fn refine(&self, run: &mut Run) {
        let first = &self.rivals[0];
        let better = |run: &mut Run, trial: Trial| {
            let other = self.look(&trial, true).and_then(Result::ok);
            if let Some(other) = other.filter(|other| other.value > run.value) {
                *run = other;
            }
        };
        for setting in 1..first.systems.len() {
            let trial = Trial { setting, ..run.trial.clone() };
            better(run, trial);
        }
        for factor in REFINEMENTS {
            for (f, a) in [(factor, 1.0), (1.0 / factor, 1.0), (1.0, factor), (1.0, 1.0 / factor)] {
                let trial = match run.trial.waveform {
                    Some(now) => {
                        let Some((_, range)) = self.limits.inputs.iter().find(|(k, _)| *k == now.input)
                        else {
                            return;
                        };
                        let (lowest, highest) = range.within;
                        let part = (a * now.amplitude / (0.5 * (highest - lowest))).min(1.0);
                        let frequency = (now.frequency * f).clamp(self.limits.band.0, self.limits.band.1);
                        let waveform =
                            waveform(self.limits, now.input, range.within, now.shape, frequency, part);
                        driven(first, self.limits, Some(waveform), vec![], run.trial.setting)
                    }
                    None if f != 1.0 => continue,
                    None => {
                        let start = run.trial.start.iter().map(|(name, x)| (name.clone(), x * a)).collect();
                        driven(first, self.limits, None, start, run.trial.setting)
                    }
                };
                better(run, trial);
            }
        }
    }

    /// The shortest run that leaves the wrong models no more than [`ROOM`], by halves.
    fn shorten(&self, run: &mut Run) {
        if *self.aim != Aim::Separate {
            return;
        }
        let Ok(responses) = self.responses(&run.trial, true) else { return };
        let trial = run.trial.clone();
        let mut samples = trial.samples / 2;
        while samples >= FEWEST_SAMPLES {
            let shorter = self.judged(&trial, &responses, samples);
            if shorter.separation.wrong > ROOM {
                break;
            }
            *run = shorter;
            samples /= 2;
        }
    }
}

/// The best run of each form of drive and input, and of those that are let go; the best one first.
/// Whether there is any run within the limits, of a rig with records like this one; no model is fitted for that.
///
/// # Errors
/// [`Failure::Duration`] or [`Failure::NothingDrives`].
pub fn possible(system: &System, like: &Record, limits: &Limits) -> Result<(), Failure> {
    let (least, most) = (FEWEST * step(like), MOST * step(like));
    if limits.duration.1 && !(least..=most).contains(&limits.duration.0) {
        return Err(Failure::Duration(least, most));
    }
    match limits.inputs.is_empty() && let_go(system, limits).next().is_none() {
        true => Err(Failure::NothingDrives),
        false => Ok(()),
    }
}

/// The displacements from which a run may be let go.
fn let_go<'a>(system: &'a System, limits: &'a Limits) -> impl Iterator<Item = &'a (usize, Range)> {
    limits.columns.iter().filter(|(k, _)| system.states.get(*k).is_some_and(|state| state.velocity.is_some()))
}

fn best_of_each_form(runs: Vec<Run>) -> Vec<Run> {
    let form = |run: &Run| run.trial.waveform.map(|w| (w.shape, w.input));
    let mut best: Vec<Run> = Vec::new();
    for run in runs {
        match best.iter_mut().find(|other| form(other) == form(&run)) {
            Some(other) if other.value >= run.value => {}
            Some(other) => *other = run,
            None => best.push(run),
        }
    }
    best.sort_by(|a, b| b.value.total_cmp(&a.value));
    best
}

fn driven(
    first: &Rival,
    limits: &Limits,
    waveform: Option<Waveform>,
    start: Vec<(String, f64)>,
    setting: usize,
) -> Trial {
    Trial::driven(limits, &first.like, limits.step(&first.like), waveform, start, setting)
}

/// A drive about its value at rest that uses a part of what its input may do: the whole is all of it.
fn waveform(
    limits: &Limits,
    input: usize,
    (low, high): (f64, f64),
    shape: Shape,
    frequency: f64,
    part: f64,
) -> Waveform {
    let rest = 0.0_f64.clamp(low, high);
    let middle = rest + part * (0.5 * (low + high) - rest);
    let end = (10.0 * frequency).min(limits.band.1).max(frequency);
    Waveform { input, shape, frequency, end, amplitude: part * 0.5 * (high - low), middle }
}

/// Runs all over what the limits allow.
fn grid(first: &Rival, limits: &Limits) -> Vec<Trial> {
    let (low, high, _) = limits.band;
    let frequency = |k: usize| low * (high / low).powf(k as f64 / (FREQUENCIES - 1) as f64);
    let mut trials = Vec::new();
    for (input, range) in &limits.inputs {
        for shape in Shape::ALL {
            for k in 0..FREQUENCIES {
                for part in AMPLITUDES {
                    let waveform = waveform(limits, *input, range.within, shape, frequency(k), part);
                    trials.push(driven(first, limits, Some(waveform), vec![], 0));
                }
            }
        }
    }
    for (k, range) in let_go(&first.systems[0], limits) {
        for end in [range.within.0, range.within.1] {
            for part in AMPLITUDES {
                let rest = first.rest[*k];
                // The edge itself is left by the least error.
                let start = vec![(range.name.clone(), rest + 0.95 * part * (end - rest))];
                trials.push(driven(first, limits, None, start, 0));
            }
        }
    }
    trials
}
