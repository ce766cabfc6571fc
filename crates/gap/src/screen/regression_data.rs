//! A record prepared for the regression: the measured motion, the linear system and its response, rest at
//! each place.

use super::readings::{OutputTape, Readings};
use super::response::{Linear, drifts, shift};
use crate::decisions::{FORGETS_PER_PERIOD, RESTS, SHORT_REST};
use crate::drive::Drive;
use crate::evaluate::{evaluated, speed};
use crate::model::TrialModel;
use crate::motion::{Motion, rest_threshold, resting};
use crate::place::{Entered, Rates, Site, entered};
use crate::whiteness::lines;
use phisindy_expr::{Id, Tape};
use phisindy_learn::Calibration;
use phisindy_phys::{Record, SensorPart, System};
use phisindy_sim::Trajectory;

/// One record, prepared for the regression.
pub(super) struct RegressionData {
    pub(super) motion: Motion,
    /// The linear system that gives responses.
    pub(super) linear: Linear,
    /// Rates minus A x, samples x n: the input of the linear system.
    pub(super) bracket: Vec<f64>,
    /// The measured columns.
    pub(super) rows: Vec<Row>,
    /// How the outputs read states and rates; `None` where the system has none.
    readings: Option<Readings>,
    /// Rate of every state at every sample. At rest, friction of the model balances the other forces.
    pub(super) rates: Vec<f64>,
    stride: usize,
    /// Rest at each place of a force.
    pub(super) still: Vec<PlaceAtRest>,
    /// The strongest spectral lines of the fitted model's residuals. In the smoothed motion noise of a few
    /// per cent hides them.
    pub(super) left: Vec<f64>,
    /// Frequencies of the drive of the base model (rad/s).
    pub(super) drive: Vec<f64>,
}

/// A measured column of a record.
pub(super) struct Row {
    /// Its index among the columns of the system.
    pub(super) column: usize,
    values: Vec<f64>,
    weight: f64,
    /// The sample of each stretch that counts; none where the column has none of its own.
    at: Vec<Option<usize>>,
    /// What the known rates make of it, without its sensor.
    known: Vec<f64>,
}

impl Row {
    /// A value at every sample that counts.
    fn every(&self, of: impl Fn(usize) -> f64) -> Vec<f64> {
        self.at.iter().map(|at| at.map_or(0.0, &of)).collect()
    }
}

/// The first sample that a column has in each stretch of so many samples of a record.
fn counting(record: &Record, column: usize, stride: usize) -> Vec<Option<usize>> {
    let first =
        |from: usize| (from..(from + stride).min(record.len())).find(|&i| record.own_times.has(column, i));
    (0..record.len()).step_by(stride).map(first).collect()
}

/// The samples at which the velocity of a place is at rest.
pub(super) struct PlaceAtRest {
    pub(super) at: String,
    pub(super) rests: Vec<bool>,
    /// The state that friction of the model holds there.
    pub(super) stuck_state: Option<usize>,
}

/// A tape of the known rates, their Jacobian and their derivatives by the parameters.
pub(super) struct Base {
    pub(super) tape: Tape,
    pub(super) n: usize,
    pub(super) parameters: usize,
    outputs: Option<OutputTape>,
}

impl Base {
    pub(super) fn new(system: &System) -> Option<Base> {
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
        outputs.extend(system.coupling.iter().map(|&(.., ratio)| ratio));
        let tape = Tape::compile(&graph, &system.arguments(), &outputs).ok()?;
        let outputs = if system.outputs.is_empty() { None } else { Some(OutputTape::new(system)?) };
        Some(Base { tape, n, parameters: parameters.len(), outputs })
    }

    pub(super) fn data(
        &self,
        model: &TrialModel,
        record: usize,
        fitted: &Calibration,
        noise: &[Vec<f64>],
        stride: usize,
    ) -> Option<RegressionData> {
        self.data_along(model, record, fitted, noise, stride, None)
    }

    /// The same along the motion of a run, if there is one, of a model of the same states.
    pub(super) fn data_along(
        &self,
        model: &TrialModel,
        record: usize,
        fitted: &Calibration,
        noise: &[Vec<f64>],
        stride: usize,
        run: Option<&Trajectory>,
    ) -> Option<RegressionData> {
        let (n, system) = (self.n, &model.system);
        let data = &model.records[record];
        let mut motion = Motion::new(system, data, &model.smooth[record], record, fitted);
        if let Some(run) = run {
            let own = |i: usize| run.states[i * run.n..i * run.n + n].iter().copied();
            motion.states = (0..motion.samples()).flat_map(own).collect();
        }
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
        // Rest of all places: friction is, or may be missing, there.
        let mut still: Vec<PlaceAtRest> = Vec::new();
        for place in model.places() {
            let Site::Force { acts, velocity, .. } = &place.site else { continue };
            let speed = speed(system, &motion, place)?;
            let least = ((SHORT_REST * motion.period / (span / samples as f64)) as usize).clamp(5, samples);
            let rests = resting(&speed, rest_threshold(&speed), least);
            let own = system.contacts.iter().any(|c| c.node == velocity.node && system.rubs(c));
            if own && !place.enters() {
                let numbers = &values[n + n * n + n * self.parameters..];
                let at = |sample: usize| entered(system, acts, &mut AtSample { numbers, n, sample });
                balance(&mut rates, n, &rests, &at);
            }
            let stuck_state = system.state(&place.at).filter(|_| own);
            still.push(PlaceAtRest { at: place.at.clone(), rests, stuck_state });
        }
        // A body at rest loses the memory of its motion. The linear system must decay as well, or it carries
        // errors from before a stop past it. So must one that nothing holds, or it sums up small errors of
        // forces.
        let has_stops = still.iter().any(|s| s.rests.iter().filter(|r| **r).count() * RESTS > samples);
        let forgets = has_stops || drifts(&a, n, motion.period);
        let decay = shift(&a, n, span).max(if forgets { FORGETS_PER_PERIOD / motion.period } else { 0.0 });
        (0..n).for_each(|k| a[k * n + k] -= decay);
        let bracket = bracket(&rates, &a, &motion.states, n);
        let linear = Linear::new(&a, n, &motion.time);
        let known = linear.response(&bracket, &motion.states[..n]);
        let readings = self.outputs.as_ref().map(|tape| tape.readings(&motion, &rates, &a));
        if readings.as_ref().is_some_and(|r| r.values.iter().flatten().any(|v| !v.is_finite())) {
            return None;
        }
        let measured = (0..data.columns.len()).filter_map(|k| Some((k, data.columns[k].clone()?)));
        let row = |((column, values), noise): ((usize, Vec<f64>), &f64)| {
            let known = match column.checked_sub(n) {
                None => (0..samples).map(|i| known[i * n + column]).collect(),
                Some(output) => {
                    let of = readings.as_ref().expect("the system has outputs");
                    let apart = |i: usize, k: usize| known[i * n + k] - motion.states[i * n + k];
                    (0..samples)
                        .map(|i| of.values[output][i] + of.through(output, i, &|k| apart(i, k)))
                        .collect()
                }
            };
            let at = counting(data, column, stride);
            // As if every stretch had as many samples.
            let share = (data.own_times.count(column, 0..data.len()) as f64
                / (at.iter().flatten().count() * stride) as f64)
                .min(1.0);
            Row { column, values, weight: share.sqrt() / noise, at, known }
        };
        let rows = measured.zip(&noise[record]).map(row).collect();
        let own = &fitted.records[record];
        let of = |k: usize| lines(&own.own_residual(k), data.step(k), 4, 0);
        let left = (0..own.residuals.len()).flat_map(of).collect();
        let bare = model.without_effects();
        let drive = Drive::new(&bare.system, &bare.records[record]).map_or(vec![], |mut d| d.lines());
        Some(RegressionData { motion, linear, bracket, rows, readings, rates, stride, still, left, drive })
    }
}

/// Rates at a sample of a motion: the inertia of each of `n` states, then the ratio of each coupling.
struct AtSample<'a> {
    numbers: &'a [Vec<f64>],
    n: usize,
    sample: usize,
}

impl Rates for AtSample<'_> {
    type Rate = f64;

    fn unit(&mut self, (state, sign): (usize, f64)) -> f64 {
        sign / self.numbers[state][self.sample]
    }

    fn following(&mut self, coupling: usize, rate: f64) -> f64 {
        self.numbers[self.n + coupling][self.sample] * rate
    }

    fn sum(&mut self, a: f64, b: f64) -> f64 {
        a + b
    }
}

/// The known rates less `A x`, sample by sample.
fn bracket(rates: &[f64], a: &[f64], states: &[f64], n: usize) -> Vec<f64> {
    let row = |(i, rate): (usize, &f64)| {
        let x = &states[i / n * n..][..n];
        rate - a[i % n * n..][..n].iter().zip(x).map(|(a, x)| a * x).sum::<f64>()
    };
    rates.iter().enumerate().map(row).collect()
}

/// Friction of the model balances the other forces on two bodies, or on one, while they rest against each
/// other: takes what would part them out of their rates. `entered` says what friction does at a sample.
fn balance(rates: &mut [f64], n: usize, rests: &[bool], entered: &dyn Fn(usize) -> Vec<Entered<f64>>) {
    for i in (0..rests.len()).filter(|&i| rests[i]) {
        let all = entered(i);
        let (mut toward, mut give) = (0.0, 0.0);
        for e in &all {
            toward += e.part * rates[i * n + e.state];
            give += e.part * e.rate;
        }
        for e in &all {
            rates[i * n + e.state] -= toward / give * e.rate;
        }
    }
}

impl RegressionData {
    /// The frequency resolution of the record (rad/s).
    pub(super) fn resolution(&self) -> f64 {
        let (time, samples) = (&self.motion.time, self.motion.samples());
        2.0 * std::f64::consts::PI * (samples - 1) as f64 / (samples as f64 * (time[samples - 1] - time[0]))
    }

    /// Number of rows of this record.
    pub(super) fn height(&self) -> usize {
        self.rows.len() * self.motion.samples().div_ceil(self.stride)
    }

    /// What the known rates along the measured motion miss of the measured columns, as the sensors read it.
    pub(super) fn missed(&self) -> Vec<f64> {
        let of = |row: &Row| -> Vec<f64> {
            let (gain, offset) = self.motion.sensors[row.column];
            row.every(|i| row.weight * (row.values[i] - gain * row.known[i] - offset))
        };
        self.rows.iter().flat_map(of).collect()
    }

    /// Residuals of a run, by column.
    pub(super) fn weighted(&self, residuals: &[Vec<f64>]) -> Vec<f64> {
        let of = |row: &Row| -> Vec<f64> { row.every(|i| row.weight * residuals[row.column][i]) };
        self.rows.iter().flat_map(of).collect()
    }

    /// The response to rates `g` (samples x n) from a start state, as the sensors read it.
    pub(super) fn response(&self, g: &[f64], start: &[f64]) -> Vec<f64> {
        let n = start.len();
        let states = self.linear.response(g, start);
        let of = |row: &Row| -> Vec<f64> {
            let factor = row.weight * self.motion.sensors[row.column].0;
            match (row.column.checked_sub(n), &self.readings) {
                (Some(output), Some(readings)) => row.every(|i| {
                    let through = readings.through(output, i, &|k| states[i * n + k]);
                    factor * (through + readings.directly(output, i, &|k| g[i * n + k]))
                }),
                _ => row.every(|i| factor * states[i * n + row.column]),
            }
        };
        self.rows.iter().flat_map(of).collect()
    }

    /// Adds what enters the outputs themselves: `of` gives it for each output.
    pub(super) fn add_to_outputs<'v>(&self, rows: &mut [f64], of: &dyn Fn(usize) -> Option<&'v [f64]>) {
        let n = self.bracket.len() / self.motion.samples();
        let each = self.motion.samples().div_ceil(self.stride);
        for (row, out) in self.rows.iter().zip(rows.chunks_mut(each)) {
            let Some(values) = row.column.checked_sub(n).and_then(of) else { continue };
            let factor = row.weight * self.motion.sensors[row.column].0;
            let values = row.every(|i| values[i]);
            out.iter_mut().zip(values).for_each(|(o, v)| *o += if v.is_finite() { factor * v } else { 0.0 });
        }
    }

    /// The derivative of what an output reads by a parameter, states and rates apart.
    pub(super) fn by_parameter(&self, output: usize, parameter: usize) -> Option<&[f64]> {
        Some(&self.readings.as_ref()?.by_parameter[output][parameter])
    }

    /// The derivative of the readings by a sensor parameter of some columns.
    pub(super) fn sensor(&self, columns: &[usize], part: SensorPart) -> Vec<f64> {
        let of = |row: &Row| -> Vec<f64> {
            let on = columns.contains(&row.column);
            let gain = self.motion.sensors[row.column].0;
            row.every(|i| {
                let change = match part {
                    SensorPart::Offset => 1.0,
                    // Proportional to the model's response; a column of the measured values themselves would
                    // explain everything.
                    SensorPart::Gain => row.known[i],
                    // A lag is a delay, to first order.
                    SensorPart::Delay | SensorPart::Lag => -gain * self.slope(i, row),
                    SensorPart::Clock => {
                        gain * self.slope(i, row) * (self.motion.time[i] - self.motion.since)
                    }
                };
                if on { row.weight * change } else { 0.0 }
            })
        };
        self.rows.iter().flat_map(of).collect()
    }

    /// Time derivative of a state by central differences.
    pub(super) fn acceleration(&self, i: usize, k: usize, n: usize) -> f64 {
        let t = &self.motion.time;
        let (a, b) = (i.saturating_sub(1), (i + 1).min(t.len() - 1));
        (self.motion.states[b * n + k] - self.motion.states[a * n + k]) / (t[b] - t[a])
    }

    /// Time derivative of what a column measures by central differences, which serve every state; a smoothed
    /// velocity exists for displacements only.
    fn slope(&self, i: usize, row: &Row) -> f64 {
        let t = &self.motion.time;
        let n = self.bracket.len() / t.len();
        let (a, b) = (i.saturating_sub(1), (i + 1).min(t.len() - 1));
        let of =
            |i: usize| if row.column < n { self.motion.states[i * n + row.column] } else { row.known[i] };
        (of(b) - of(a)) / (t[b] - t[a])
    }

    /// Zeroes a force on bodies that rest in a contact of the model.
    pub(super) fn zero_at_rest(&self, g: &mut [f64]) {
        let n = g.len() / self.motion.samples();
        for (k, rests) in self.still.iter().filter_map(|s| Some((s.stuck_state?, &s.rests))) {
            rests.iter().enumerate().filter(|(_, r)| **r).for_each(|(i, _)| g[i * n + k] = 0.0);
        }
    }
}
