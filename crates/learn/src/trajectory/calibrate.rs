//! Calibration: parameters of a known model fitted to records whose noise is known. The gap workflow calls
//! this for every trial.

use crate::decisions::{
    ASTRAY, FAR_GAIN, LIKELIHOOD_GAIN, MEMORY_STEPS, MISFIT, QUICK_SEGMENTS, QUICK_SINGLE, RESTART_MINIMUM,
    RESTART_PROMISE, RESTART_REACH, RESTARTS, ROUGH_TOLERANCE, SEGMENTS_MINIMUM, SINGLE_ITERATIONS, STAGES,
    STEPS_TO_ONE, TOLERANCE, TRIAL_BASE_STEPS, TRIAL_STEPS, WRONG_MODEL,
};
use crate::least_squares::Limits;
use crate::result::error::ModelError;
use crate::result::estimate::Estimate;
use crate::result::parameter::FoundParameter;
use crate::result::record_fit::RecordFit;
use crate::trajectory::error_bars::{ErrorBars, of_curvature};
use crate::trajectory::fit::{Fit, transfer};
use crate::trajectory::free_run::{Solution, free_runs};
use crate::trajectory::layout::Segment;
use crate::trajectory::noise::ColumnNoise;
use crate::trajectory::problem::{Noise, Problem};
use crate::trajectory::tally::{Tally, tally};
use crate::trajectory::unknowns::Unknowns;
use phisindy_phys::spec::Role;
use phisindy_phys::{Record, System};
use phisindy_signal::standard_deviation;
use phisindy_sim::Stop;

/// A calibrated model.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// Sum over all samples of the Fit records of (residual / noise)^2.
    pub chi2: f64,
    /// How many samples that sum has.
    pub samples: usize,
    /// How many of them are independent, by the autocorrelation of the residual.
    pub effective: f64,
    /// Parameters that moved: shared, per record, of sensors; start states not counted.
    pub moved: usize,
    /// Their values, with intervals for [`Effort::Errors`].
    pub parameters: Vec<FoundParameter>,
    /// Their covariance where the noise is what was given: the inverse of the curvature of the cost, start states
    /// eliminated; infinite on the diagonal for what the records do not see.
    pub curvature: Vec<Vec<f64>>,
    /// Free runs of all records from their fitted starts.
    pub records: Vec<RecordFit>,
    /// Segments of the record that has most: 1 unless no single run can be simulated.
    pub segments: usize,
    /// Whether the fit was given up as [`Effort::Rival`] says.
    pub hopeless: bool,
}

/// Fits what may move in `system` (its parameters, sensors and start states; no dictionary) to the Fit
/// records, each column weighted by its `noise` (standard deviation in SI, by record and measured column),
/// and runs all records freely. `smooth` are the records with smoothed samples of every state, to start from.
///
/// With [`Effort::Errors`] the parameters come with 95 % intervals (sandwich covariance, stretched where
/// residuals are correlated, profile likelihood).
///
/// # Errors
/// The model cannot be simulated from any start.
pub fn calibrate(
    system: &System,
    records: &[Record],
    smooth: &[Record],
    noise: &[Vec<f64>],
    effort: Effort,
) -> Result<Calibration, ModelError> {
    calibrate_from(None, system, records, smooth, noise, effort, &Stop::default())
}

/// As [`calibrate`], from where a fit over segments of the same model and records has ended. After `stop` is
/// requested it ends with the best point found so far, or without a result.
///
/// # Errors
/// As [`calibrate`].
pub fn calibrate_from(
    segments: Option<&SegmentFit>,
    system: &System,
    records: &[Record],
    smooth: &[Record],
    noise: &[Vec<f64>],
    effort: Effort,
    stop: &Stop,
) -> Result<Calibration, ModelError> {
    let samples: usize = records.iter().filter(|r| r.role == Role::Fit).map(Record::readings).sum();
    let mut setup = Setup { begun: segments, stop: stop.clone(), ..Setup::new(records, smooth, noise) };
    let effort = match effort {
        Effort::Rival { most, runs } => {
            (setup.most, setup.runs) = (most * samples as f64, runs);
            Effort::Plain
        }
        other => other,
    };
    let (Stage { problem, mut x, cost, hopeless }, segmented) = match stages(system, &setup, effort, samples)
    {
        Ok(ends) => ends,
        // No single run can be simulated: fit segments instead.
        Err(_) if effort != Effort::Plain => {
            return calibrate_from(None, system, records, smooth, noise, Effort::Plain, stop);
        }
        Err(e) => return Err(e),
    };
    let weights = problem.weights(&setup.noise, None);
    if problem.segments.len() == setup.fitted.len() && !hopeless {
        let mut best = Best { problem: &problem, weights: &weights, samples, most: setup.most, x, cost };
        match effort {
            Effort::Plain | Effort::Rival { .. } => best.try_other_starts(&setup, segmented),
            Effort::Thorough | Effort::Errors => best.try_nearby(),
        }
        x = best.x;
    }
    let (fit, chi2) = finished(problem, x, weights, &setup)?;
    let unknowns = Unknowns::new(system, records, &fit);
    if stop.aborts() {
        return Err(ModelError::Stopped);
    }
    let moved = if effort == Effort::Errors {
        let bars = ErrorBars::new(&fit);
        unknowns.parameters(|k| bars.estimate(k))
    } else {
        let bounds = &fit.problem.bounds;
        unknowns.parameters(|k| Estimate { value: fit.x[k], std_error: f64::NAN, ci95: bounds[k] })
    };
    let (places, parameters): (Vec<usize>, Vec<FoundParameter>) = moved.into_iter().unzip();
    let curvature = of_curvature(&fit, &places);
    let mut solution = Solution { given_up: hopeless, ..unknowns.solution() };
    let replays = free_runs(system, records, smooth, &mut solution);
    Ok(Calibration {
        chi2,
        samples: fit.samples,
        effective: fit.effective,
        moved: parameters.len(),
        parameters,
        curvature,
        records: replays,
        segments: fit.most_pieces(),
        hopeless,
    })
}

/// Fits over fewer and fewer segments, each stage from where the one before ended. Returns the last two
/// stages.
///
/// # Errors
/// No stage can be simulated; the error is that of the last one. Or it is beaten.
fn stages<'a>(
    system: &'a System,
    setup: &'a Setup<'a>,
    effort: Effort,
    samples: usize,
) -> Result<(Stage<'a>, Option<Stage<'a>>), ModelError> {
    let (mut best, mut before): (Option<Stage<'_>>, Option<Stage<'_>>) = (None, None);
    let mut trouble = None;
    let stages: &[usize] = if effort == Effort::Plain { &STAGES } else { &STAGES[STAGES.len() - 1..] };
    for &pieces in stages {
        match Stage::new(system, setup, pieces, effort, samples, best.as_ref()) {
            _ if setup.stop.aborts() => return Err(ModelError::Stopped),
            Ok(stage) if !setup.runs && pieces > 1 && stage.cost > setup.most => {
                return Err(ModelError::Beaten);
            }
            Ok(stage) => before = best.replace(stage),
            Err(e) => trouble = Some(e),
        }
    }
    best.map(|best| (best, before)).ok_or_else(|| trouble.expect("a fit without a stage has failed in one"))
}

/// The best end of the fits of single runs so far.
struct Best<'p, 'a> {
    problem: &'p Problem<'a>,
    weights: &'p [Vec<Vec<f64>>],
    samples: usize,
    /// The cost below which a start is asked for more than a few steps; infinite where nothing is ahead.
    most: f64,
    x: Vec<f64>,
    cost: f64,
}

impl Best<'_, '_> {
    /// Whether it leaves no more than noise.
    fn is_at_noise(&self) -> bool {
        self.cost < MISFIT * self.samples as f64
    }

    /// Tries other starts: where the spec starts, where the smoothed motion starts, and, if the fit still misses, from
    /// segments in smaller steps.
    fn try_other_starts(&mut self, setup: &Setup<'_>, segmented: Option<Stage<'_>>) {
        // The start of the spec may be better than the end of the segments: after an earlier fit it is.
        self.try_start(self.problem.guess(&[], None, &setup.smooth));
        if let Some(start) = on_the_data(self.problem, &self.x, &setup.noise, &setup.smooth) {
            self.try_start(start);
        }
        let misses = !self.is_at_noise();
        let joined = segmented.filter(|_| misses);
        if let Some(start) = joined.and_then(|s| step_by_step(self.problem.system, setup, self.samples, s)) {
            self.try_start(start);
        }
    }

    /// Tries starts near the end of a fit, as long as the fit leaves more than noise.
    fn try_nearby(&mut self) {
        for attempt in 0..RESTARTS {
            match nearby(self.problem, &self.x, self.weights, self.samples, attempt) {
                Some(start) => self.try_start(start),
                None => break,
            }
        }
    }

    /// Fits from another start and keeps the better end; skips starts that cost more than [`RESTART_PROMISE`] times the
    /// current fit. A run through stops has local minima: with one stop more or less the cost jumps.
    fn try_start(&mut self, start: Vec<f64>) {
        let problem = self.problem;
        if problem.stop.requested() || self.is_at_noise() {
            return;
        }
        let promising = |there: f64| there < RESTART_PROMISE * self.cost;
        if !problem.cost(&start, self.weights).is_ok_and(promising) {
            return;
        }
        let mut other = start;
        let limits = Limits { far: far(self.samples), hopeless: self.most, ..Limits::of(RESTART_MINIMUM) };
        if let Ok(end) = problem.minimise(&mut other, self.weights, limits)
            && end.cost < self.cost
        {
            (self.x, self.cost) = (other, end.cost);
        }
    }
}

/// The fit at its end, with the noise that was given, and its chi square.
///
/// # Errors
/// The model cannot be simulated there.
fn finished<'a>(
    problem: Problem<'a>,
    x: Vec<f64>,
    weights: Vec<Vec<Vec<f64>>>,
    setup: &Setup<'_>,
) -> Result<(Fit<'a>, f64), ModelError> {
    let normal = problem.normal(&x, &weights)?;
    let Tally { samples, effective, power } = tally(&setup.noise, &problem.residuals(&x)?);
    let of_record = |r: usize| problem.segments.iter().filter(|s| s.record == r).count();
    let pieces = (0..setup.fitted.len()).map(of_record).collect();
    let noise = setup.noise.clone();
    Ok((
        Fit { problem, x, noise, weights, normal, samples, effective, excess: 1.0, pieces, force: None },
        power,
    ))
}

/// A fit over segments.
struct Stage<'a> {
    problem: Problem<'a>,
    x: Vec<f64>,
    cost: f64,
    /// Whether longer segments cannot miss as little as is asked for.
    hopeless: bool,
}

impl<'a> Stage<'a> {
    /// Fits over so many segments of each record, from where an earlier stage ended.
    fn new(
        system: &'a System,
        setup: &'a Setup<'a>,
        pieces: usize,
        effort: Effort,
        samples: usize,
        before: Option<&Stage<'_>>,
    ) -> Result<Stage<'a>, ModelError> {
        let Setup { fitted, noise, smooth: starts, .. } = setup;
        let mut problem = Problem::new(system, &[], fitted, &vec![pieces; fitted.len()])?;
        problem.stop = setup.stop.clone();
        // Error bars are asked of one model, which need not be quick.
        problem.budget = (effort != Effort::Errors).then(|| budget(&problem));
        // A single run is simulated as exactly as a result: along a motion that is sensitive, the errors of steps that
        // are as rough as the noise allows grow, and the cost has no smooth minimum.
        if effort == Effort::Plain && pieces > 1 {
            problem.tolerance = rough_tolerance(&problem, noise);
        }
        let mut x = problem.guess(&[], None, starts);
        // A few steps do not tell a body that breaks away when it does.
        let begun = setup.begun.filter(|_| !problem.automaton.breaks_away);
        if let Some(begun) = begun.filter(|begun| pieces == STAGES[0] && begun.x.len() == x.len()) {
            // The next stage needs a start, not the minimum of this one.
            let cost = begun.cost * samples as f64;
            return Ok(Stage { problem, x: begun.x.clone(), cost, hopeless: false });
        }
        if let Some(before) = before {
            transfer(&before.problem, &before.x, &problem, &mut x);
            // Start states too: short segments find them near the data, wherever the guess came from.
            for segment in &problem.segments {
                let same = |s: &&Segment| s.record == segment.record && s.samples.0 == segment.samples.0;
                if let Some(earlier) = before.problem.segments.iter().find(same) {
                    let n = system.states.len();
                    x[segment.start..segment.start + n]
                        .copy_from_slice(&before.x[earlier.start..earlier.start + n]);
                }
            }
        }
        problem.look_from(&x);
        let weights = problem.weights(noise, None);
        // Smaller gains of the likelihood decide nothing.
        let least = LIKELIHOOD_GAIN / samples.max(1) as f64;
        // A run along several segments is a run along each of them, so it misses no less.
        let hopeless = before.is_some_and(|b| b.hopeless || b.cost > setup.most);
        let limits = match (pieces == 1, effort) {
            (true, Effort::Plain) => Limits { far: far(samples), ..Limits::new(SINGLE_ITERATIONS, least) },
            (true, _) => Limits::new(SINGLE_ITERATIONS, least),
            (false, _) => Limits::of(SEGMENTS_MINIMUM),
        };
        let limits = Limits { hopeless: if hopeless { 0.0 } else { limits.hopeless }, ..limits };
        let mut cost = problem.minimise(&mut x, &weights, limits)?.cost;
        // With other numbers a body rests that broke away before.
        for _ in 0..RESTARTS {
            let mut other = x.clone();
            if !problem.start_anew(&mut other, starts) {
                break;
            }
            let end = problem.minimise(&mut other, &weights, limits)?.cost;
            if end >= cost {
                break;
            }
            (cost, x) = (end, other);
        }
        Ok(Stage { problem, x, cost, hopeless })
    }
}

/// Joins segments to one run in smaller steps, if the segments leave nothing but noise. Where neighbouring
/// motions diverge fast, a run five times as long as the segments ends in a local minimum.
fn step_by_step(system: &System, setup: &Setup<'_>, samples: usize, parted: Stage<'_>) -> Option<Vec<f64>> {
    let mut stage = Some(parted).filter(|p| p.cost < MISFIT * samples as f64)?;
    for pieces in STEPS_TO_ONE {
        stage = Stage::new(system, setup, pieces, Effort::Plain, samples, Some(&stage)).ok()?;
    }
    Some(stage.x)
}

/// Integration steps that a trial may take. Friction that grows with speed near rest creeps without end, and
/// is wrong. A memory that fades within a fraction of a sample cannot be told from none, and takes many
/// steps.
fn budget(problem: &Problem<'_>) -> usize {
    let longest = problem.longest_segment();
    let states = &problem.system.states;
    let measured = |k: usize| problem.records.iter().any(|r| r.columns[k].is_some());
    let memory = (0..states.len()).any(|k| {
        let moves = states[k].velocity.is_some() || states.iter().any(|s| s.velocity == Some(k));
        !moves && !measured(k)
    });
    TRIAL_BASE_STEPS + longest * if memory { MEMORY_STEPS } else { TRIAL_STEPS }
}

/// Local error where trials are compared by a factor of their costs, or led to the start of a single run: a part of
/// the state's size, and at most so much that the errors of a step for each sample add up to a part of the noise at
/// the end of a segment.
fn rough_tolerance(problem: &Problem<'_>, noise: &Noise) -> f64 {
    let [of_noise, of_size] = ROUGH_TOLERANCE;
    let parts = problem.records.iter().zip(noise).flat_map(|(record, noise)| {
        // An output is as accurate as the states that it reads.
        let size =
            |k: usize, c: &[f64]| problem.scale.get(k).copied().unwrap_or_else(|| standard_deviation(c));
        let of = move |k: usize| record.columns[k].as_ref().map(|c| noise[k].additive / size(k, c));
        (0..noise.len()).filter_map(of)
    });
    let least = parts.fold(f64::INFINITY, f64::min) / problem.longest_segment().max(1) as f64;
    (of_noise * least).clamp(TOLERANCE, of_size)
}

/// The range of chi^2 per sample in which [`Effort::Thorough`] tries other starts. Below it there is nothing
/// to gain, above it the model is wrong.
pub const RESTART_RANGE: std::ops::Range<f64> = MISFIT..WRONG_MODEL;
/// Above this cost a fit ends at smaller gains: the model is wrong, and more digits do not help.
fn far(samples: usize) -> (f64, f64) {
    (WRONG_MODEL * samples as f64, FAR_GAIN)
}

/// The unknowns with start states from the smoothed motion, if the fitted ones are far from it: they may stem
/// from an earlier, wrong model.
fn on_the_data(problem: &Problem<'_>, x: &[f64], noise: &Noise, smooth: &[Record]) -> Option<Vec<f64>> {
    let (mut out, mut elsewhere) = (x.to_vec(), false);
    for segment in &problem.segments {
        for (k, column) in smooth[segment.record].columns[..problem.system.states.len()].iter().enumerate() {
            let Some([_, second, third, ..]) = column.as_deref() else { continue };
            let (at, start) = (segment.start + k, 2.0 * second - third);
            let measured = problem.records[segment.record].columns[k].is_some();
            elsewhere |= measured && (x[at] - start).abs() > ASTRAY * noise[segment.record][k].additive;
            out[at] = start.clamp(problem.bounds[at].0, problem.bounds[at].1);
        }
    }
    elsewhere.then_some(out)
}

/// A start near the end of a fit: every unknown is moved by [`RESTART_REACH`] standard errors of the misfit,
/// up or down.
fn nearby(
    problem: &Problem<'_>,
    x: &[f64],
    weights: &[Vec<Vec<f64>>],
    samples: usize,
    attempt: u32,
) -> Option<Vec<f64>> {
    let normal = problem.normal(x, weights).ok()?;
    let ratio = normal.cost / samples.max(1) as f64;
    if !RESTART_RANGE.contains(&ratio) {
        return None;
    }
    let cov = crate::linear::covariance(&normal.matrix);
    let moved = x.iter().enumerate().map(|(k, v)| {
        let error = (cov[(k, k)] * ratio).sqrt();
        let sign =
            if (k as u32).wrapping_mul(2_654_435_769).rotate_left(attempt * 7) & 1 == 0 { 1.0 } else { -1.0 };
        let sign = if attempt.is_multiple_of(2) { sign } else { -sign };
        let reach = f64::from(1 + attempt / 2) * RESTART_REACH;
        let step = if error.is_finite() { reach * sign * error } else { 0.0 };
        (v + step).clamp(problem.bounds[k].0, problem.bounds[k].1)
    });
    Some(moved.collect())
}

/// How hard to try.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Effort {
    /// One fit, through shorter segments to single runs.
    Plain,
    /// The same for a rival of a fitted model. Where its segments leave more, its single runs do too: they
    /// get a few steps, so that it is known how far behind they are, or none.
    Rival {
        /// Whether its single runs are asked for where it is hopeless; else the fit fails there.
        runs: bool,
        /// chi^2 per sample of segments from which on it is hopeless.
        most: f64,
    },
    /// From the start values and, if that leaves more than noise, from starts near its end: for a model that
    /// was fitted before.
    Thorough,
    /// The same, and 95 % intervals.
    Errors,
}

/// The end of the first iterations of a fit over many short segments.
#[derive(Clone, Debug)]
pub struct SegmentFit {
    /// chi^2 per sample.
    pub cost: f64,
    x: Vec<f64>,
}

/// chi^2 per sample of the Fit records over many short segments, after a few iterations of a fit. `None` if
/// the model cannot be simulated. Ranks trials: those far behind need no full fit. Only every `stride`-th
/// segment counts; 1 uses all of them.
pub fn segment_cost(
    system: &System,
    records: &[Record],
    smooth: &[Record],
    noise: &[Vec<f64>],
    stride: usize,
) -> Option<f64> {
    segment_fit(system, records, smooth, noise, stride).map(|fit| fit.cost)
}

/// As [`segment_cost`], with its end: with all segments, a full fit goes on from there.
pub fn segment_fit(
    system: &System,
    records: &[Record],
    smooth: &[Record],
    noise: &[Vec<f64>],
    stride: usize,
) -> Option<SegmentFit> {
    let Setup { fitted, noise, smooth: starts, .. } = Setup::new(records, smooth, noise);
    let mut problem = Problem::new(system, &[], &fitted, &vec![STAGES[0]; fitted.len()]).ok()?;
    let mut k = 0;
    problem.segments.retain(|_| {
        k += 1;
        (k - 1) % stride.max(1) == 0
    });
    cost_after_few_iterations(problem, &noise, &starts, QUICK_SEGMENTS)
}

/// As [`segment_cost`], but over single runs from the start of `smooth`: for a model that is nearly right and
/// comes to rest, which segments would not show.
pub fn single_run_cost(
    system: &System,
    records: &[Record],
    smooth: &[Record],
    noise: &[Vec<f64>],
) -> Option<f64> {
    let Setup { fitted, noise, smooth: starts, .. } = Setup::new(records, smooth, noise);
    let problem = Problem::new(system, &[], &fitted, &vec![1; fitted.len()]).ok()?;
    cost_after_few_iterations(problem, &noise, &starts, QUICK_SINGLE).map(|fit| fit.cost)
}

/// A few iterations.
fn cost_after_few_iterations(
    mut problem: Problem<'_>,
    noise: &Noise,
    starts: &[Record],
    minimum: [f64; 2],
) -> Option<SegmentFit> {
    problem.budget = Some(budget(&problem));
    problem.tolerance = rough_tolerance(&problem, noise);
    let mut x = problem.guess(&[], None, starts);
    let weights = problem.weights(noise, None);
    let normal = problem.minimise(&mut x, &weights, Limits::of(minimum)).ok()?;
    let readings = |s: &Segment| problem.records[s.record].readings_of(s.samples.0..s.samples.1);
    let samples: usize = problem.segments.iter().map(readings).sum();
    Some(SegmentFit { cost: normal.cost / samples.max(1) as f64, x })
}

/// The Fit records with their noise.
struct Setup<'a> {
    fitted: Vec<&'a Record>,
    /// A fit over the segments of the first stage.
    begun: Option<&'a SegmentFit>,
    noise: Noise,
    smooth: Vec<Record>,
    /// chi^2 of segments from which on a fit is hopeless.
    most: f64,
    /// Whether a hopeless fit is asked for its runs.
    runs: bool,
    stop: Stop,
}

impl<'a> Setup<'a> {
    fn new(records: &'a [Record], smooth: &[Record], noise: &[Vec<f64>]) -> Setup<'a> {
        let of: Vec<usize> = (0..records.len()).filter(|&r| records[r].role == Role::Fit).collect();
        let additive = |s: f64| ColumnNoise { additive: s.max(f64::MIN_POSITIVE), relative: 0.0 };
        let row = |r: usize| {
            let mut own = noise[r].iter();
            // What has no column has no noise that matters.
            let of = |column: &Option<Vec<f64>>| {
                additive(column.as_ref().and_then(|_| own.next()).copied().unwrap_or(1.0))
            };
            records[r].columns.iter().map(of).collect()
        };
        Setup {
            fitted: of.iter().map(|&r| &records[r]).collect(),
            noise: of.iter().map(|&r| row(r)).collect(),
            smooth: of.iter().map(|&r| smooth[r].clone()).collect(),
            most: f64::INFINITY,
            runs: true,
            begun: None,
            stop: Stop::default(),
        }
    }
}

#[cfg(test)]
mod tests;
