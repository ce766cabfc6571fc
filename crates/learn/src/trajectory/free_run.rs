//! Free runs: every record is simulated from its fitted start state and compared with what was measured.

use crate::decisions::{DIVERGED_SIZE, OWN_PART, START_BLUR, START_MINIMUM, START_PART, START_SAMPLES};
use crate::least_squares::{Limits, Normal};
use crate::linear::covariance;
use crate::result::error::ModelError;
use crate::result::quantity::{ParameterId, ParameterOf, RecordId};
use crate::result::record_fit::{Adapted, OwnValue, RecordFit};
use crate::trajectory::delayed_samples::SampledRun;
use crate::trajectory::problem::{Meaning, Problem};
use faer::Mat;
use phisindy_phys::spec::Role;
use phisindy_phys::unit::Unit;
use phisindy_phys::{Record, SensorPart, System};
use phisindy_signal::standard_deviation;
use phisindy_sim::{Options, SimError, Trajectory};

/// A model with all its numbers.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub(crate) terms: Vec<usize>,
    pub(crate) coefficients: Vec<f64>,
    /// Values of the system's parameters, for each record.
    pub(crate) parameters: Vec<Vec<f64>>,
    /// The parameters of each sensor, for each record.
    pub(crate) sensors: Vec<Vec<[f64; SensorPart::ALL.len()]>>,
    /// Start states, for each record, if fitted already.
    pub(crate) starts: Vec<Option<Vec<f64>>>,
    /// Whether its fit was given up: start states need no digits then.
    pub(crate) given_up: bool,
}

impl Solution {
    /// Coefficients and shared parameters alone; sensors as the spec starts them.
    pub(crate) fn new(
        terms: Vec<usize>,
        coefficients: Vec<f64>,
        parameters: &[f64],
        records: &[Record],
    ) -> Solution {
        let sensors = |r: &Record| r.sensors.iter().map(|s| s.parameters().map(|p| p.start)).collect();
        Solution {
            terms,
            coefficients,
            parameters: vec![parameters.to_vec(); records.len()],
            sensors: records.iter().map(sensors).collect(),
            starts: vec![None; records.len()],
            given_up: false,
        }
    }

    /// The unknowns of a problem of one record alone, with the numbers of a record; start states from the
    /// columns.
    pub(crate) fn guess(&self, problem: &Problem<'_>, of: usize, filled: &[Record]) -> Vec<f64> {
        let mut x = problem.guess(&self.coefficients, Some(&self.parameters[of]), filled);
        for (k, meaning) in problem.meanings().into_iter().enumerate() {
            if let Meaning::Sensor(_, state, which) = meaning {
                x[k] = self.sensors[of][state][which];
            }
        }
        x
    }
}

/// Simulates every record from its start state, which is fitted where `solution` has none. What a Validate
/// record has of its own is fitted with it, and stands in `solution` afterwards. `filled` are the records
/// with samples (or derived samples) of every state, to start from.
pub(crate) fn free_runs(
    system: &System,
    records: &[Record],
    filled: &[Record],
    solution: &mut Solution,
) -> Vec<RecordFit> {
    let mut fits: Vec<RecordFit> = Vec::new();
    for r in 0..records.len() {
        let fit = one(system, records, filled, solution, r, &fits);
        fits.push(fit);
    }
    fits
}

fn one(
    system: &System,
    records: &[Record],
    filled: &[Record],
    solution: &mut Solution,
    r: usize,
    done: &[RecordFit],
) -> RecordFit {
    let record = &records[r];
    let mut fit = RecordFit {
        name: record.name.clone(),
        role: record.role,
        samples: record.len(),
        adapted: None,
        nrmse: vec![],
        noise: vec![],
        residuals: vec![vec![]; record.columns.len()],
        own_times: record.own_times.clone(),
        start: vec![],
        run: None,
        failure: None,
        segments: None,
    };
    let mut problem = match Problem::new(system, &solution.terms, &[record], &[1]) {
        Ok(problem) => problem,
        Err(e) => {
            fit.failure = Some(e);
            return fit;
        }
    };
    let source = record.continues.filter(|&j| done[j].run.is_some()).unwrap_or(r);
    let mut x = solution.guess(&problem, source, &filled[r..=r]);
    problem.look_from(&x);
    let whole = problem.segments[0];
    let run = if source != r {
        continued(&problem, &records[source], &done[source], record, &x)
    } else {
        expect_starts(&mut problem, record, done);
        started(problem, &mut x, solution, r, record).and_then(|(problem, took)| {
            solution.starts[r] = Some(x[whole.start..].to_vec());
            fit.adapted = took.map(|took| {
                keep(&problem, &x, &mut solution.parameters[r], &mut solution.sensors[r]);
                adapted(&problem, &x, record, r, took)
            });
            let sampled = problem.trajectory(&whole, &x);
            sampled.map(|sampled| (Read::new(&problem, &x, &sampled), x[whole.start..].to_vec(), sampled.run))
        })
    };
    let (read, start, run) = match run {
        Ok(run) => run,
        Err(e) => {
            fit.failure = Some(e.into());
            return fit;
        }
    };
    fit.start = start;
    let scored = fit.scored();
    for (k, column) in record.columns.iter().enumerate() {
        let Some(column) = column else { continue };
        let name = system.measured(k).0.to_owned();
        let own: Vec<usize> = scored.clone().filter(|&i| record.own_times.has(k, i)).collect();
        let deviation = size_of_motion(own.iter().map(|&i| column[i]).collect(), k, records);
        let missed: f64 = own.iter().map(|&i| (column[i] - read.readings[k][i]).powi(2)).sum();
        let rms = (missed / own.len() as f64).sqrt();
        fit.nrmse.push((name.clone(), if deviation > 0.0 { rms / deviation } else { f64::INFINITY }));
        fit.noise.push((name, record.noise_level(k)));
        fit.residuals[k].clone_from(&read.residuals[k]);
    }
    fit.run = Some(run);
    fit
}

/// The standard deviation of some samples of a column; where they stand still, that of the column in the
/// record in which it moves most: what rests has no size of its own to compare a miss with.
fn size_of_motion(samples: Vec<f64>, column: usize, records: &[Record]) -> f64 {
    let own = standard_deviation(&samples);
    if samples.iter().any(|s| *s != samples[0]) {
        return own;
    }
    records.iter().map(|r| r.deviation(column)).fold(0.0, f64::max)
}

type Run = (Read, Vec<f64>, Trajectory);

/// What the sensors read along a run, and what the record leaves, by column.
struct Read {
    readings: Vec<Vec<f64>>,
    /// Readings beside a jump are compared with its nearer side, see [`super::jumps`].
    residuals: Vec<Vec<f64>>,
}

impl Read {
    /// Along a run of the only record of a problem.
    fn new(problem: &Problem<'_>, x: &[f64], sampled: &SampledRun) -> Read {
        let readings = problem.readings(0, x, sampled);
        let record = problem.records[0];
        let of = |(k, column): (usize, &Option<Vec<f64>>)| -> Vec<f64> {
            let noise = problem.jump_noise[0][k];
            let left = |(i, y): (usize, &f64)| {
                let miss = readings[k][i] - y;
                let beside = problem.beside_jumps(&problem.segments[0], x, sampled, (i, k), noise);
                if problem.tells(0, k, i) { -beside.map_or(miss, |at| at.residual(miss)) } else { 0.0 }
            };
            column.iter().flatten().enumerate().map(left).collect()
        };
        let residuals = record.columns.iter().enumerate().map(of).collect();
        Read { readings, residuals }
    }
}

/// Says where the record's start may be of states that nothing shows and that belong to no displacement (the
/// memory of a law): where the runs of other records took them. A start far outside of that may hardly be
/// told from one within, as contacts forget where they began once they slide. The samples have the weight of
/// their motion, not of their noise, so the priors have less by the same factor.
fn expect_starts(problem: &mut Problem<'_>, record: &Record, done: &[RecordFit]) {
    let states = &problem.system.states;
    let moves = |k: usize| states[k].velocity.is_some() || states.iter().any(|s| s.velocity == Some(k));
    let first = problem.segments[0].start;
    for k in (0..states.len()).filter(|&k| record.columns[k].is_none() && !moves(k)) {
        let values: Vec<f64> =
            done.iter().filter_map(|fit| fit.run.as_ref()).flat_map(|run| run.column(k)).collect();
        let spread = standard_deviation(&values);
        if spread > 0.0 && spread.is_finite() {
            problem.priors.retain(|(at, ..)| *at != first + k);
            problem.priors.push((first + k, mean(&values), spread));
        }
    }
    let measured = (0..record.columns.len()).filter(|&k| record.columns[k].is_some());
    let noise = measured.map(|k| (record.noise_level(k) / problem.deviations[0][k]).powi(2));
    let parts: Vec<f64> = noise.filter(|part| part.is_finite()).collect();
    problem.belief = mean(&parts).max(f64::MIN_POSITIVE);
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Whether a number is a Validate record's own.
fn is_own(meaning: &Meaning) -> bool {
    matches!(meaning, Meaning::Sensor(..) | Meaning::Parameter(_, Some(_)))
}

/// What a Validate record was given of its own on its first samples.
fn adapted(problem: &Problem<'_>, x: &[f64], record: &Record, index: usize, took: Took) -> Adapted {
    let system = problem.system;
    let own = |(k, meaning): (usize, Meaning)| {
        let (of, unit) = match meaning {
            Meaning::Parameter(index, Some(_)) => {
                let p = &system.parameters[index];
                (ParameterOf::Constant { index, name: p.name.clone() }, p.unit.clone())
            }
            Meaning::Sensor(_, column, which) => {
                let (name, unit) = system.measured(column);
                let part = SensorPart::ALL[which];
                let of = ParameterOf::Sensor { column, name: name.to_owned(), part };
                (of, part.unit(unit).to_owned())
            }
            _ => return None,
        };
        let owner = Some(RecordId { index, name: record.name.clone(), only: false });
        let factor = Unit::parse(&unit).map_or(1.0, |u| u.factor);
        Some(OwnValue { id: ParameterId { of, owner }, unit, factor, value: x[k] })
    };
    Adapted {
        samples: took.samples,
        span: (record.time[0], record.time[took.samples.max(1) - 1]),
        values: problem.meanings().into_iter().enumerate().filter_map(own).collect(),
        took_more: took.more,
    }
}

/// Keeps what a record was given of its own.
fn keep(
    problem: &Problem<'_>,
    x: &[f64],
    parameters: &mut [f64],
    sensors: &mut [[f64; SensorPart::ALL.len()]],
) {
    for (k, meaning) in problem.meanings().into_iter().enumerate() {
        match meaning {
            Meaning::Parameter(p, Some(_)) => parameters[p] = x[k],
            Meaning::Sensor(_, column, which) => sensors[column][which] = x[k],
            _ => {}
        }
    }
}

/// The part of a Validate record that its own numbers took.
#[derive(Clone, Copy)]
struct Took {
    /// Its first samples.
    samples: usize,
    /// Whether it is more than usual.
    more: bool,
}

/// Fits the start state, and on a Validate record also its own parameters and sensors; everything else is
/// fixed. Returns what that took of a Validate record.
fn started<'a>(
    mut problem: Problem<'a>,
    x: &mut [f64],
    solution: &Solution,
    r: usize,
    record: &Record,
) -> Result<(Problem<'a>, Option<Took>), SimError> {
    let whole = problem.segments[0];
    if let Some(start) = &solution.starts[r] {
        x[whole.start..].copy_from_slice(start);
        return Ok((problem, None));
    }
    let validated = record.role == Role::Validate;
    for (k, meaning) in problem.meanings().into_iter().enumerate() {
        if meaning != Meaning::Start && !(validated && is_own(&meaning)) {
            problem.hold(k, x[k]);
        }
    }
    if validated {
        // A number of its own, such as a phase, needs more of the record than its start does.
        let own = problem.meanings().iter().any(|m| matches!(m, Meaning::Parameter(_, Some(_))));
        let part = record.len() / if own { OWN_PART } else { START_PART };
        problem.segments[0].samples.1 = part.max(START_SAMPLES).min(record.len());
    }
    let weight = |k: usize| 1.0 / problem.deviations[0][k].powi(2).max(f64::MIN_POSITIVE);
    let weights = vec![(0..record.columns.len()).map(|k| vec![weight(k); record.len()]).collect::<Vec<_>>()];
    let bounds = problem.bounds.clone();
    let hopeless = if solution.given_up { 0.0 } else { f64::INFINITY };
    let limits = Limits { hopeless, ..Limits::of(START_MINIMUM) };
    let mut more = false;
    loop {
        let part = problem.segments[0];
        let took = validated.then_some(Took { samples: part.samples.1, more });
        let end = problem.minimise(x, &weights, limits);
        problem.segments[0] = whole;
        let known = end?;
        if part.samples.1 >= record.len() || solution.given_up {
            return Ok((problem, took));
        }
        let moves: Vec<usize> = (0..x.len()).filter(|&k| bounds[k].0 < bounds[k].1).collect();
        match problem.normal(x, &weights) {
            // Where impacts or turning points pull neighbouring motions apart, the start state of a tenth
            // says nothing about the end of the record, however right the model is.
            Ok(wanted)
                if start_uncertainty(&known, &wanted, &moves) > START_BLUR * record.readings() as f64 =>
            {
                problem.segments[0].samples.1 = (2 * part.samples.1).min(record.len());
                more = true;
            }
            _ => return Ok((problem, took)),
        }
    }
}

/// The free run of a model without unknown part along a record from a start state: one column for each state
/// and output, read by its sensor where the record has a column of it. Every number is as the system and the
/// record start it. It is the run that a fit which ended at these numbers is judged by, as accurate as a
/// simulation. `scale` is the size of each state for a record that shows none.
///
/// # Errors
/// The model cannot be simulated.
pub fn predicted(
    system: &System,
    record: &Record,
    start: &[f64],
    scale: &[f64],
) -> Result<Vec<Vec<f64>>, ModelError> {
    let mut predictor = Predictor::new(system, record)?;
    let shows = record.columns.iter().any(Option::is_some);
    let scale = if shows { predictor.problem.scale.clone() } else { scale.to_vec() };
    // A fit may be coarser than what is asked for here.
    let tolerance = predictor.problem.tolerance.min(Options::default().tolerance);
    predictor.options = Options { tolerance, scale, diverged: DIVERGED_SIZE, ..Options::default() };
    Ok(predictor.run(None, start)?.columns)
}

/// Predicts one record again and again, with other numbers.
pub struct Predictor<'a> {
    problem: Problem<'a>,
    options: Options,
}

/// A run as its sensors would show it.
#[derive(Clone, Debug)]
pub struct Predicted {
    /// A column for each state and output, read by its sensor where the record has a column of it.
    pub columns: Vec<Vec<f64>>,
    /// How often each contact came to rest.
    pub stops: Vec<usize>,
}

impl<'a> Predictor<'a> {
    /// Of a model without unknown part, along a record that shows how large its states are: as accurate as a fit, and given
    /// up where a fit gives up.
    ///
    /// # Errors
    /// The model cannot be evaluated.
    pub fn new(system: &'a System, record: &'a Record) -> Result<Predictor<'a>, ModelError> {
        let problem = Problem::new(system, &[], &[record], &[1])?;
        let options = problem.options(&problem.segments[0], None);
        Ok(Predictor { problem, options })
    }

    /// The run from a start state, with these numbers (SI, in the order of [`System::parameters`]), or as the system
    /// starts them.
    ///
    /// # Errors
    /// The model cannot be simulated.
    pub fn run(&self, numbers: Option<&[f64]>, start: &[f64]) -> Result<Predicted, ModelError> {
        let Predictor { problem, options } = self;
        let record = problem.records[0];
        let x = problem.guess(&[], numbers, std::slice::from_ref(record));
        let run = |times: &[f64]| problem.simulated(0, &x, (record.time[0], start), times, options);
        let samples = problem.delayed_samples(&problem.segments[0], &x);
        let sampled = samples.split(run(&samples.times)?);
        let mut columns = problem.readings(0, &x, &sampled);
        // A state that nothing reads is not late.
        let on_time = if samples.times == record.time[..] { sampled.run } else { run(&record.time)? };
        for (k, column) in columns.iter_mut().enumerate().filter(|(k, _)| record.columns[*k].is_none()) {
            *column = on_time.column(k);
        }
        let mut stops = vec![0; on_time.modes.len() / on_time.samples().max(1)];
        on_time.events.iter().filter(|event| event.to == 0).for_each(|event| stops[event.switch] += 1);
        Ok(Predicted { columns, stops })
    }
}

/// The power, in units of the noise, that the uncertainty of the unknowns `moves` adds to the residuals of a
/// whole record (`wanted`) after a part of it (`known`) was fitted.
fn start_uncertainty(known: &Normal, wanted: &Normal, moves: &[usize]) -> f64 {
    let n = moves.len();
    let of = |normal: &Normal| Mat::from_fn(n, n, |i, j| normal.matrix[(moves[i], moves[j])]);
    let (cov, wanted) = (covariance(&of(known)), of(wanted));
    let blind = |i: usize| !cov[(i, i)].is_finite();
    // What the part does not see and the whole does is not known at all.
    if (0..n).any(|i| blind(i) && wanted[(i, i)] > 0.0) {
        return f64::INFINITY;
    }
    let seen: Vec<usize> = (0..n).filter(|&i| !blind(i)).collect();
    seen.iter().map(|&i| seen.iter().map(|&j| cov[(i, j)] * wanted[(j, i)]).sum::<f64>()).sum()
}

/// The run of a record that continues another one.
fn continued(
    problem: &Problem<'_>,
    before: &Record,
    fit: &RecordFit,
    record: &Record,
    x: &[f64],
) -> Result<Run, SimError> {
    let n = problem.system.states.len();
    let start = fit.run.as_ref().map_or(vec![0.0; n], |run| run.state_at(run.samples() - 1).to_vec());
    let options = Options {
        scale: problem.scale.clone(),
        reach: problem.reach.clone(),
        diverged: DIVERGED_SIZE,
        ..Default::default()
    };
    // The run before ended at the last sample time of its columns.
    let samples = problem.delayed_samples(&problem.segments[0], x);
    let t0 = before.time[before.len() - 1] + (samples.first() - record.time[0]);
    // Where the record begins: what is read there may be late.
    let begin =
        problem.simulated(0, x, (t0, &start), &[record.time[0].max(t0)], &options)?.state_at(0).to_vec();
    let sampled = samples.split(problem.simulated(0, x, (t0, &start), &samples.times, &options)?);
    Ok((Read::new(problem, x, &sampled), begin, sampled.run))
}

#[cfg(test)]
mod tests;
