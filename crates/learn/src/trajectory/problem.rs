//! The trajectory fit as a least-squares problem: simulations, predictions of the sensors, residuals,
//! weights. [`super::layout`] says what the unknowns are, [`super::cost`] differentiates.

use crate::decisions::{
    BASE_STEPS, DIVERGED_SIZE, FIRST_NOISE, NOISE_FLOOR, SAME_TIME, STEPS_PER_SAMPLE, TOLERANCE,
};
use crate::result::error::ModelError;
use crate::trajectory::delayed_samples::{DelayedSamples, Lateness, SampledRun};
use crate::trajectory::filter::Gains;
use crate::trajectory::follower::Follower;
use crate::trajectory::input_sensors::{InputSensors, OF_INPUT};
use crate::trajectory::layout::{CLOCK, DELAY, LAG, Layout, Segment, SensorSources, Source};
use crate::trajectory::noise::{ColumnNoise, least_noise_of};
use phisindy_phys::{Record, Sensor, System};
use phisindy_signal::{Signal, mean_step};
use phisindy_sim::{
    Automaton, Drive, Observer, Options, SimError, Stop, Trajectory, at_rest, observe, simulate,
};
use rayon::prelude::*;
use std::sync::Arc;

/// A least-squares problem for a choice of terms and records.
pub(crate) struct Problem<'a> {
    pub(crate) system: &'a System,
    pub(crate) terms: Vec<usize>,
    pub(crate) records: Vec<&'a Record>,
    pub(crate) automaton: Automaton,
    pub(crate) segments: Vec<Segment>,
    /// Number of unknowns.
    pub(crate) unknowns: usize,
    pub(crate) bounds: Vec<(f64, f64)>,
    /// Priors: unknown, mean, standard deviation.
    pub(crate) priors: Vec<(usize, f64, f64)>,
    /// Weight of the priors beside the data: 1, or the inflation factor where samples are correlated.
    pub(crate) belief: f64,
    /// For each record, the parameters of the model.
    pub(crate) model: Vec<Vec<Source>>,
    /// For each record, the sensor parameters of each state, each output, then each input.
    pub(crate) sensors: Vec<Vec<SensorSources>>,
    input_sensors: InputSensors,
    /// By record and column, the first sample that tells of the model, see [`Problem::tells`].
    told_from: Vec<Vec<usize>>,
    /// The size of each state, for the accuracy of the simulation.
    pub(crate) scale: Vec<f64>,
    /// How far each state may go before it has diverged, without the factor.
    pub(crate) reach: Vec<f64>,
    /// Standard deviation of each measured column, by record and column.
    pub(crate) deviations: Vec<Vec<f64>>,
    /// Noise of each column that may jump, from its spectrum, by record and column: how far a sample may be from
    /// either side of a jump.
    pub(crate) jump_noise: Vec<Vec<f64>>,
    /// By record and column, the mean time between samples.
    pub(crate) steps: Vec<Vec<f64>>,
    /// Soft continuity: by how much each state may jump from one segment to the next; `None` leaves the start
    /// states free.
    pub(crate) continuity: Option<Vec<f64>>,
    /// Whether the segments are a chain that stands for one run, or the run is what such a chain became:
    /// steps are damped by what the data say, not by the joints.
    pub(crate) chained: bool,
    /// Gains by which the run of each record follows its readings; `None` for free runs.
    pub(crate) following: Option<Vec<Gains>>,
    /// Steps that a simulation may take; `None` for a generous guess.
    pub(crate) budget: Option<usize>,
    /// Local error of the simulations, relative to the size of each state.
    pub(crate) tolerance: f64,
    /// Ends a minimisation where it is.
    pub(crate) stop: Stop,
}

/// What an unknown is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Meaning {
    Coefficient(usize),
    /// Index into the system's parameters; the record for those that each has.
    Parameter(usize, Option<usize>),
    /// Record, column (or, beyond them, input), which of its parameters.
    Sensor(usize, usize, usize),
    Start,
}

/// Noise of each record and column.
pub(crate) type Noise = Vec<Vec<ColumnNoise>>;

/// Residuals and predictions of one column of one record, at its own samples.
#[derive(Clone, Debug, Default)]
pub(crate) struct ColumnResidual {
    pub(crate) residual: Vec<f64>,
    pub(crate) prediction: Vec<f64>,
}

impl<'a> Problem<'a> {
    /// Sets up the problem; each record is cut into `pieces[r]` segments of equal length.
    pub(crate) fn new(
        system: &'a System,
        terms: &[usize],
        records: &[&'a Record],
        pieces: &[usize],
    ) -> Result<Problem<'a>, ModelError> {
        let input_sensors = InputSensors::new(system.columns(), records);
        let with_sensors = input_sensors.model(system.model(terms));
        let automaton =
            Automaton::new(&with_sensors).map_err(|e| ModelError::Unbound(e.message(&with_sensors.names)))?;
        let Layout { bounds, priors, model, sensors, segments } = Layout::new(system, terms, records, pieces);
        let deviations: Vec<Vec<f64>> =
            records.iter().map(|r| (0..r.columns.len()).map(|k| r.deviation(k)).collect()).collect();
        let states = system.states.len();
        let level = |r: &Record, k: usize| match &r.columns[k] {
            Some(_) if k >= states || !system.impacts.is_empty() => {
                r.noise_level(k).max(least_noise_of(r, k, NOISE_FLOOR))
            }
            _ => 1.0,
        };
        let jump_noise =
            records.iter().map(|r| (0..r.columns.len()).map(|k| level(r, k)).collect()).collect();
        let steps = records.iter().map(|r| (0..r.columns.len()).map(|k| r.step(k)).collect()).collect();
        let mut problem = Problem {
            system,
            terms: terms.to_vec(),
            records: records.to_vec(),
            automaton,
            segments,
            unknowns: bounds.len(),
            bounds,
            priors,
            belief: 1.0,
            model,
            sensors,
            input_sensors,
            told_from: vec![],
            scale: vec![],
            reach: vec![],
            deviations,
            jump_noise,
            steps,
            continuity: None,
            chained: false,
            following: None,
            budget: None,
            tolerance: TOLERANCE,
            stop: Stop::default(),
        };
        let starts = problem.numbers(&[], None);
        problem.look_from(&starts);
        problem.scale = vec![1.0; states];
        problem.scale = problem.scales();
        problem.reach = problem.reaches();
        Ok(problem)
    }

    /// What each unknown is.
    pub(crate) fn meanings(&self) -> Vec<Meaning> {
        let mut all = vec![Meaning::Start; self.unknowns];
        (0..self.terms.len()).for_each(|k| all[k] = Meaning::Coefficient(k));
        for r in 0..self.records.len() {
            for (p, source) in
                self.model[r][self.terms.len()..].iter().take(self.system.parameters.len()).enumerate()
            {
                if let Source::Unknown(k) = *source {
                    all[k] = Meaning::Parameter(p, self.system.parameters[p].each.then_some(r));
                }
            }
            for (state, sensor) in self.sensors[r].iter().enumerate() {
                for (which, source) in sensor.iter().enumerate() {
                    // A shared one is a parameter already.
                    if let Source::Unknown(k) = *source
                        && all[k] == Meaning::Start
                    {
                        let n = self.system.columns();
                        let own = self.records[r].sensors[state].follows.map_or(state, |of| n + of);
                        all[k] = Meaning::Sensor(r, own, which);
                    }
                }
            }
        }
        all
    }

    /// A first guess: coefficients and parameters as given (or where the spec starts them), start states from
    /// the columns.
    pub(crate) fn guess(
        &self,
        coefficients: &[f64],
        parameters: Option<&[f64]>,
        filled: &[Record],
    ) -> Vec<f64> {
        let mut x = self.numbers(coefficients, parameters);
        self.start_from(&mut x, filled);
        x
    }

    /// Starts the segments where the columns say.
    pub(crate) fn start_from(&self, x: &mut [f64], filled: &[Record]) {
        for segment in &self.segments {
            let record = &filled[segment.record];
            for state in 0..self.system.states.len() {
                let value = record.columns[state].as_ref().map(|c| c[segment.samples.0]);
                let stated = self.records[segment.record].start[state].filter(|_| segment.samples.0 == 0);
                x[segment.start + state] = stated.or(value).unwrap_or(0.0);
            }
        }
        self.leave_singularities(x, filled);
        self.start_at_rest(x);
    }

    /// The noise before the first fit: a fixed part of each column's standard deviation.
    pub(crate) fn first_noise(&self) -> Noise {
        let one = |d: &f64| ColumnNoise { additive: FIRST_NOISE * d.max(f64::MIN_POSITIVE), relative: 0.0 };
        self.deviations.iter().map(|columns| columns.iter().map(one).collect()).collect()
    }

    /// Coefficients and parameters as given, or where the spec starts them; start states are 0.
    fn numbers(&self, coefficients: &[f64], parameters: Option<&[f64]>) -> Vec<f64> {
        let mut x = vec![0.0; self.unknowns];
        for (k, c) in coefficients.iter().enumerate() {
            x[k] = c.clamp(self.bounds[k].0, self.bounds[k].1);
        }
        for (k, meaning) in self.meanings().into_iter().enumerate() {
            match meaning {
                Meaning::Parameter(p, _) => {
                    x[k] = parameters.map_or(self.system.parameters[p].start, |v| v[p])
                }
                Meaning::Sensor(r, state, which) => {
                    x[k] = self.records[r].sensors[state].parameters()[which].start;
                }
                _ => {}
            }
        }
        x
    }

    fn value(source: Source, x: &[f64]) -> f64 {
        match source {
            Source::Unknown(k) => x[k],
            Source::Number(v) => v,
        }
    }

    /// Holds an unknown other than a start state at a value: it moves no more, and runs have no derivatives by it.
    /// [`Problem::meanings`] no longer says what it is.
    pub(crate) fn hold(&mut self, k: usize, value: f64) {
        self.bounds[k] = (value, value);
        let sensors = self.sensors.iter_mut().flatten().flatten();
        let own = |source: &&mut Source| **source == Source::Unknown(k);
        self.model.iter_mut().flatten().chain(sensors).filter(own).for_each(|s| *s = Source::Number(value));
    }

    /// How many parameters of a record's run are unknown.
    pub(crate) fn free_parameters(&self, record: usize) -> usize {
        self.sources(record).filter(|s| matches!(s, Source::Unknown(_))).count()
    }

    /// The numbers of the model's parameters in a record.
    pub(crate) fn model_parameters(&self, record: usize, x: &[f64]) -> Vec<f64> {
        self.model[record].iter().map(|&s| Self::value(s, x)).collect()
    }

    /// When each sensor of an input that is not perfect shows what is.
    fn input_clocks(&self, record: usize, x: &[f64]) -> Vec<Lateness> {
        let n = self.system.columns();
        self.input_sensors.inputs.iter().map(|j| self.lateness(record, n + j, x)).collect()
    }

    /// Whether a sample tells of the model: the column has it, and it shows what was after the start of the record, driven
    /// by what is known.
    /// What a late input did before its first sample nobody knows, and where the record starts a late sensor shows what
    /// was before. Where numbers of sensors are to be found it goes by where a minimisation starts: samples that come and
    /// go with a delay would be a reason to change it.
    pub(crate) fn tells(&self, record: usize, column: usize, sample: usize) -> bool {
        sample >= self.told_from[record][column] && self.records[record].own_times.has(column, sample)
    }

    /// Lets these samples tell of the model that do so with the numbers `x`.
    pub(crate) fn look_from(&mut self, x: &[f64]) {
        let of = |r: usize, record: &Record| -> Vec<usize> {
            let inputs = self.input_sensors.signals(record, r, &self.input_clocks(r, x));
            let measured = inputs.iter().take(record.inputs.len());
            let begins = measured.filter_map(|signal| signal.knots().next()).fold(record.time[0], f64::max);
            let own = |k: usize| {
                let (late, step) = (self.lateness(r, k, x), mean_step(&record.time));
                if late.oldest(record.time[0]) >= begins - SAME_TIME * step {
                    return 0;
                }
                // Devices are late by whole samples: half of one between them does not hang on a digit of the delay.
                let tells = |t: &f64| late.oldest(*t) >= begins + 0.5 * step;
                let first = record.time.iter().position(tells).unwrap_or(record.len());
                if record.columns.get(k).is_some_and(Option::is_some) {
                    first.min(record.len() / 2)
                } else {
                    0
                }
            };
            (0..self.system.columns()).map(own).collect()
        };
        self.told_from = self.records.iter().enumerate().map(|(r, record)| of(r, record)).collect();
    }

    /// How late a sensor is.
    pub(crate) fn lateness(&self, record: usize, column: usize, x: &[f64]) -> Lateness {
        let own = &self.sensors[record][column];
        let Sensor { since, average, .. } = self.records[record].sensors[column];
        let [delay, clock, lag] = [DELAY, CLOCK, LAG].map(|which| Self::value(own[which], x));
        Lateness { delay, clock, lag, since, average }
    }

    /// Where each parameter of a run comes from: those of the model, then those of the inputs' sensors.
    pub(crate) fn sources(&self, record: usize) -> impl Iterator<Item = Source> {
        let n = self.system.columns();
        let sensors = self
            .input_sensors
            .inputs
            .iter()
            .flat_map(move |j| self.sensors[record][n + j].into_iter().take(OF_INPUT));
        self.model[record].iter().copied().chain(sensors)
    }

    /// A run of a record from any state, with its inputs as they are at `x`.
    pub(crate) fn simulated(
        &self,
        record: usize,
        x: &[f64],
        start: (f64, &[f64]),
        times: &[f64],
        options: &Options,
    ) -> Result<Trajectory, SimError> {
        self.observed(record, x, start, times, options, None)
    }

    /// The speed of a contact at the start of a segment, and the start state with the contact at rest.
    pub(crate) fn at_rest(&self, segment: &Segment, x: &[f64], contact: usize) -> (f64, Vec<f64>) {
        let record = segment.record;
        let parameters: Vec<f64> = self.sources(record).map(|s| Self::value(s, x)).collect();
        let inputs = self.input_sensors.signals(self.records[record], record, &self.input_clocks(record, x));
        let drive = Drive { inputs: &inputs, parameters: &parameters };
        let start = &x[segment.start..segment.start + self.system.states.len()];
        let time = self.records[record].time[segment.samples.0];
        at_rest(&self.automaton, &drive, (time, start), contact, &self.scale)
    }

    /// As [`Problem::simulated`], with an observer that may correct the run at its samples.
    pub(crate) fn observed(
        &self,
        record: usize,
        x: &[f64],
        start: (f64, &[f64]),
        times: &[f64],
        options: &Options,
        observer: Option<&mut dyn Observer>,
    ) -> Result<Trajectory, SimError> {
        let mut parameters: Vec<f64> = self.sources(record).map(|s| Self::value(s, x)).collect();
        // The signals contain the delays and the drift of the clocks already.
        let own = parameters.len() - OF_INPUT * self.input_sensors.inputs.len();
        parameters[own..].chunks_exact_mut(OF_INPUT).for_each(|of| (of[DELAY], of[CLOCK]) = (0.0, 0.0));
        let clocks = self.input_clocks(record, x);
        let inputs = self.input_sensors.signals(self.records[record], record, &clocks);
        let drive = Drive { inputs: &inputs, parameters: &parameters };
        let moving = self.input_sensors.moving(&inputs, &clocks, own);
        let options = &Options { moving, ..options.clone() };
        let run = match observer {
            Some(observer) => observe(&self.automaton, &drive, start, times, options, observer)?,
            None => simulate(&self.automaton, &drive, start.0, start.1, times, options)?,
        };
        self.readable(record, &run, times).map(|()| run)
    }

    /// Checks that what the record measures is a number all along a run: states are, outputs need not be.
    fn readable(&self, record: usize, run: &Trajectory, times: &[f64]) -> Result<(), SimError> {
        for k in (self.system.states.len()..run.n).filter(|&k| self.records[record].columns[k].is_some()) {
            let lost = |&i: &usize| !run.states[i * run.n + k].is_finite();
            if let Some(i) = (0..run.samples()).find(lost) {
                let output = self.system.measured(k).0.to_owned();
                return Err(SimError::NoReading { time: times[i], output });
            }
        }
        Ok(())
    }

    /// Simulates one segment; with the derivatives by everything that is unknown in it.
    pub(crate) fn run(
        &self,
        segment: &Segment,
        x: &[f64],
        derivatives: bool,
    ) -> Result<SampledRun, SimError> {
        let record = self.records[segment.record];
        let (first, last) = segment.samples;
        let start = &x[segment.start..segment.start + self.system.states.len()];
        let unknown = |(k, source): (usize, Source)| matches!(source, Source::Unknown(_)).then_some(k);
        let free = self.sources(segment.record).enumerate().filter_map(unknown).collect();
        let options = self.options(segment, derivatives.then_some(free));
        let mut samples = self.delayed_samples(segment, x);
        if let Some(gains) = &self.following {
            let own = &gains[segment.record];
            let mut follower = Follower::new(self, segment, x, own, &samples, derivatives);
            let options = Options { spare: if derivatives { follower.spare } else { 0 }, ..options };
            let begin = (record.time[first], start);
            let run =
                self.observed(segment.record, x, begin, &samples.times, &options, Some(&mut follower))?;
            return Ok(samples.followed(run, follower.read));
        }
        // One more sample, where the next segment takes over. (An early sensor can ask for later times than
        // that.)
        if self.next(segment).is_some() {
            samples.push(record.time[last]);
        }
        self.simulated(segment.record, x, (record.time[first], start), &samples.times, &options)
            .map(|run| samples.split(run))
    }

    /// How a segment is simulated, with these derivatives.
    pub(crate) fn options(&self, segment: &Segment, sensitivities: Option<Vec<usize>>) -> Options {
        let samples = self.samples(segment);
        Options {
            tolerance: self.tolerance,
            scale: self.scale.clone(),
            reach: self.reach.clone(),
            sensitivities,
            spare: 0,
            moving: vec![],
            // A model that needs many more steps is wrong: fail early.
            max_steps: self.budget.unwrap_or(BASE_STEPS + STEPS_PER_SAMPLE * samples),
            diverged: DIVERGED_SIZE,
            stop: self.stop.clone(),
        }
    }

    /// Whether any unknown has a prior.
    pub(crate) fn has_priors(&self) -> bool {
        !self.priors.is_empty()
    }

    /// The segment that follows this one, if segments are softly joined.
    pub(crate) fn next(&self, segment: &Segment) -> Option<Segment> {
        self.continuity.as_ref()?;
        self.segments.iter().copied().find(|s| s.record == segment.record && s.samples.0 == segment.samples.1)
    }

    /// Root mean square of the jumps of each state between segments whose start states are free.
    pub(crate) fn jumps(&mut self, x: &[f64]) -> Result<Vec<f64>, SimError> {
        let n = self.system.states.len();
        self.continuity = Some(vec![1.0; n]);
        let (mut sums, mut count) = (vec![0.0; n], 0usize);
        for segment in &self.segments {
            let Some(next) = self.next(segment) else { continue };
            let run = self.run(segment, x, false)?.run;
            let end = run.state_at(run.samples() - 1);
            (0..n).for_each(|k| sums[k] += (end[k] - x[next.start + k]).powi(2));
            count += 1;
        }
        self.continuity = None;
        Ok(sums.into_iter().map(|s| (s / count.max(1) as f64).sqrt()).collect())
    }

    /// The sample times of a segment's columns, each late by its own delay.
    pub(crate) fn delayed_samples(&self, segment: &Segment, x: &[f64]) -> DelayedSamples {
        let record = self.records[segment.record];
        let first = record.columns.iter().position(Option::is_some).unwrap_or(0);
        // What has no column is as late as the first one that has.
        let of = |k: usize| if record.columns[k].is_some() { k } else { first };
        let late: Vec<Lateness> =
            (0..self.system.columns()).map(|k| self.lateness(segment.record, of(k), x)).collect();
        DelayedSamples::new(&record.time[segment.samples.0..segment.samples.1], &late, first)
    }

    /// The prediction of a column from the value of what it measures at the sample time, and its gain.
    pub(crate) fn reading(&self, record: usize, column: usize, x: &[f64], value: f64) -> (f64, f64) {
        let [offset, gain, ..] = self.sensors[record][column].map(|s| Self::value(s, x));
        (offset + gain * value, gain)
    }

    /// Samples of the longest segment.
    pub(crate) fn longest_segment(&self) -> usize {
        self.segments.iter().map(|s| self.samples(s)).max().unwrap_or(0)
    }

    /// Samples of a segment, or those of an input along it, which may have more of them: no step skips these.
    fn samples(&self, segment: &Segment) -> usize {
        let record = self.records[segment.record];
        let own = segment.samples.1 - segment.samples.0;
        let times = record.inputs.iter().map(Signal::time);
        let times = times.filter(|time| time.len() > 1 && !Arc::ptr_eq(time, &record.time));
        let finest = times.map(|time| mean_step(time)).fold(f64::INFINITY, f64::min);
        let span = record.time[segment.samples.1 - 1] - record.time[segment.samples.0];
        own.max((span / finest) as usize)
    }

    /// The most steps that a segment takes at `x`, tries included.
    pub(crate) fn steps(&self, x: &[f64]) -> usize {
        let runs = self
            .segments
            .par_iter()
            .map(|s| self.run(s, x, false).map_or(0, |s| s.run.steps + s.run.rejected));
        runs.max().unwrap_or(0)
    }

    /// Residuals of every column of every record in the unit of the column, from a simulation of all
    /// segments.
    pub(crate) fn residuals(&self, x: &[f64]) -> Result<Vec<Vec<ColumnResidual>>, SimError> {
        Ok(self.residuals_of(&self.runs(x)?, x))
    }

    /// Simulations of all segments.
    pub(crate) fn runs(&self, x: &[f64]) -> Result<Vec<SampledRun>, SimError> {
        self.segments.par_iter().map(|s| self.run(s, x, false)).collect()
    }

    /// The residuals of such simulations.
    pub(crate) fn residuals_of(&self, runs: &[SampledRun], x: &[f64]) -> Vec<Vec<ColumnResidual>> {
        let columns = vec![ColumnResidual::default(); self.system.columns()];
        let mut out = vec![columns; self.records.len()];
        for (segment, run) in self.segments.iter().zip(runs) {
            for (i, sample) in (segment.samples.0..segment.samples.1).enumerate() {
                for (k, column) in self.records[segment.record].columns.iter().enumerate() {
                    let Some(column) = column else { continue };
                    if !self.records[segment.record].own_times.has(k, sample) {
                        continue;
                    }
                    let (prediction, _) = self.reading(segment.record, k, x, run.value(i, k).0);
                    let miss = prediction - column[sample];
                    let noise = self.jump_noise[segment.record][k];
                    let beside = self.beside_jumps(segment, x, run, (sample, k), noise);
                    let left = beside.map_or(miss, |at| at.residual(miss));
                    let left = if self.tells(segment.record, k, sample) { left } else { 0.0 };
                    out[segment.record][k].residual.push(-left);
                    out[segment.record][k].prediction.push(prediction);
                }
            }
        }
        out
    }

    /// The free run of the first segment of a record.
    pub(crate) fn trajectory(&self, segment: &Segment, x: &[f64]) -> Result<SampledRun, SimError> {
        self.run(segment, x, false)
    }

    /// Readings of the sensors along a run of a record, by column.
    pub(crate) fn readings(&self, record: usize, x: &[f64], sampled: &SampledRun) -> Vec<Vec<f64>> {
        let samples = sampled.run.samples();
        (0..self.system.columns())
            .map(|k| (0..samples).map(|i| self.reading(record, k, x, sampled.value(i, k).0).0).collect())
            .collect()
    }

    /// Weights `1 / variance` of every sample; zero where a column has none of its own.
    pub(crate) fn weights(
        &self,
        noise: &Noise,
        residuals: Option<&[Vec<ColumnResidual>]>,
    ) -> Vec<Vec<Vec<f64>>> {
        (0..self.records.len())
            .map(|r| {
                (0..self.system.columns())
                    .map(|k| {
                        let Some(column) = &self.records[r].columns[k] else { return vec![] };
                        let mut predictions = residuals.map(|all| all[r][k].prediction.iter());
                        let weight = |(i, read): (usize, &f64)| {
                            if !self.records[r].own_times.has(k, i) {
                                return 0.0;
                            }
                            let predicted = predictions.as_mut().and_then(|all| all.next());
                            1.0 / noise[r][k].variance(*predicted.unwrap_or(read))
                        };
                        column.iter().enumerate().map(weight).collect()
                    })
                    .collect()
            })
            .collect()
    }

    /// The noise of every column, from residuals.
    pub(crate) fn noise(&self, residuals: &[Vec<ColumnResidual>]) -> Noise {
        let of = |r: usize, k: usize| {
            let c = &residuals[r][k];
            let record = self.records[r];
            let floor = least_noise_of(record, k, NOISE_FLOOR);
            // What is not compared leaves nothing, and tells no noise.
            let from = self.told_from[r][k];
            let from = (0..from).filter(|&i| record.own_times.has(k, i)).count().min(c.residual.len());
            ColumnNoise::estimate(&c.residual[from..], &c.prediction[from..], floor)
        };
        (0..self.records.len()).map(|r| (0..self.system.columns()).map(|k| of(r, k)).collect()).collect()
    }
}

#[cfg(test)]
mod tests;
