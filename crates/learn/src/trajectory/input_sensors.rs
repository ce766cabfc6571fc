//! Inputs whose sensors are off by numbers that are to be found: a zero error, a scale error, a delay, a clock that drifts.
//!
//! The model gets `(u + (d - e s) w - o)/g` in the place of such an input `u`: offset `o` and gain `g` are parameters
//! of a run. A run reads the input earlier by its delay and by another clock, so that the numbers `d` and `e` are zero;
//! the derivatives by them are the input's slope `w`, which is one more input, and where a clock is to be found its
//! product with the age `s` of the sample, another one. What is held between samples has no slope: its steps move.

use crate::trajectory::delayed_samples::Lateness;
use crate::trajectory::layout::{CLOCK, DELAY};
use phisindy_phys::{Model, Record, Sensor};
use phisindy_signal::{Interpolation, Signal};
use phisindy_sim::MovingSteps;
use std::borrow::Cow;

/// How many parameters the sensor of an input has in a run: offset, gain, delay, clock. What acts is nothing that lags.
pub(crate) const OF_INPUT: usize = 4;

/// The inputs with such sensors, with their columns and slopes in each record.
pub(crate) struct InputSensors {
    /// Which inputs, in order.
    pub(crate) inputs: Vec<usize>,
    /// By record: what the column says, but for the delay that the record has undone.
    columns: Vec<Vec<Signal>>,
    slopes: Vec<Vec<Signal>>,
    /// By record, what its samples have undone already.
    undone: Vec<Vec<Lateness>>,
    /// Whether a clock is to be found, for each of the inputs.
    drifts: Vec<bool>,
}

impl InputSensors {
    /// For the inputs that have a sensor with something to find in one of the records; `columns` of states
    /// and outputs precede them in a record's sensors.
    pub(crate) fn new(columns: usize, records: &[&Record]) -> InputSensors {
        let count = records.first().map_or(0, |r| r.inputs.len());
        let finds = |&j: &usize| {
            let of = |r: &&Record| r.sensors[columns + j].parameters().iter().any(|s| s.within.is_some());
            records.iter().any(of)
        };
        let inputs: Vec<usize> = (0..count).filter(finds).collect();
        let sensor = |record: &'_ Record, j: usize| record.sensors[columns + j].clone();
        let drifts = |&j: &usize| records.iter().any(|r| sensor(r, j).clock.within.is_some());
        let drifts = inputs.iter().map(drifts).collect();
        let undone = |record: &Record, j: usize| {
            let Sensor { delay, clock, since, .. } = sensor(record, j);
            Lateness { delay: delay.start, clock: clock.start, since, ..Lateness::default() }
        };
        let undone = records.iter().map(|r| inputs.iter().map(|&j| undone(r, j)).collect()).collect();
        let column = |record: &Record, j: usize| {
            let own = &record.sensors[columns + j];
            record.inputs[j].rescaled(own.offset.start, own.gain.start)
        };
        let of_record = |r: &&Record| inputs.iter().map(|&j| column(r, j)).collect();
        let read: Vec<Vec<Signal>> = records.iter().map(of_record).collect();
        let slopes = read.iter().map(|of| of.iter().map(Signal::rate).collect()).collect();
        InputSensors { inputs, columns: read, slopes, undone, drifts }
    }

    /// The model with offset, gain, delay and clock of each of these inputs among its parameters, in this order,
    /// behind those that it has.
    pub(crate) fn model(&self, mut model: Model) -> Model {
        let mut with = std::collections::HashMap::new();
        let mut ages = vec![];
        for (&j, drifts) in self.inputs.iter().zip(&self.drifts) {
            // A space keeps the names out of reach of any spec.
            let mut fresh = |kind: &str| {
                let symbol = model.names.intern(&format!("{kind} of input {j}"));
                model.graph.symbol(symbol)
            };
            let (offset, gain, delay, clock) =
                (fresh("offset"), fresh("gain"), fresh("delay"), fresh("clock"));
            let (slope, age) = (fresh("slope"), fresh("age"));
            let graph = &mut model.graph;
            let late = if *drifts {
                let drift = graph.mul(clock, age);
                graph.sub(delay, drift)
            } else {
                delay
            };
            let step = graph.mul(late, slope);
            let shifted = graph.add(model.inputs[j], step);
            let centred = graph.sub(shifted, offset);
            with.insert(model.inputs[j], graph.div(centred, gain));
            model.inputs.push(slope);
            ages.extend(drifts.then_some(age));
            model.parameters.extend([offset, gain, delay, clock]);
        }
        model.inputs.extend(ages);
        model.rates = model.graph.replace(&model.rates, &with);
        model.outputs = model.graph.replace(&model.outputs, &with);
        model.replace_in_impacts(&with);
        model
    }

    /// What drives a record whose inputs of these are so late.
    pub(crate) fn signals<'a>(
        &self,
        record: &'a Record,
        index: usize,
        late: &[Lateness],
    ) -> Cow<'a, [Signal]> {
        if self.inputs.is_empty() {
            return Cow::Borrowed(&record.inputs);
        }
        let mut signals = record.inputs.clone();
        let paces: Vec<(f64, f64)> =
            self.undone[index].iter().zip(late).map(|(undone, late)| moved(*undone, *late)).collect();
        for ((&j, column), &(pace, shift)) in self.inputs.iter().zip(&self.columns[index]).zip(&paces) {
            signals[j] = column.retimed(pace, shift);
        }
        let slopes = self.slopes[index].iter().zip(&paces);
        signals.extend(slopes.map(|(slope, &(pace, shift))| slope.retimed(pace, shift)));
        let drifting = self.inputs.iter().zip(&self.drifts).zip(late).filter(|((_, drifts), _)| **drifts);
        let ages: Vec<Signal> = drifting.map(|((&j, _), late)| age(&signals[j], *late)).collect();
        signals.extend(ages);
        Cow::Owned(signals)
    }

    /// How `d` and `e` move the steps of held inputs that are so late, as `signals` drive a run; the parameters of
    /// these sensors begin at `first`.
    pub(crate) fn moving(&self, signals: &[Signal], late: &[Lateness], first: usize) -> Vec<MovingSteps> {
        let held = |&q: &usize| signals[self.inputs[q]].kind() == Interpolation::Hold;
        let of = |q: usize| {
            let (input, signal) = (self.inputs[q], &signals[self.inputs[q]]);
            let later = Signal::new([0.0].into(), vec![-1.0], Interpolation::Hold).ok();
            let later = later.map(|by| MovingSteps { input, parameter: first + OF_INPUT * q + DELAY, by });
            let drift =
                || MovingSteps { input, parameter: first + OF_INPUT * q + CLOCK, by: age(signal, late[q]) };
            later.into_iter().chain(self.drifts[q].then(drift))
        };
        (0..self.inputs.len()).filter(held).flat_map(of).collect()
    }
}

/// By which pace and shift samples move whose lateness was taken for another one.
fn moved(undone: Lateness, late: Lateness) -> (f64, f64) {
    let pace = (1.0 + late.clock) / (1.0 + undone.clock);
    // The time on the sensor's clock of what was put at 0.
    let stamp = (undone.delay + undone.clock * undone.since) / (1.0 + undone.clock);
    if pace == 1.0 { (1.0, undone.delay - late.delay) } else { (pace, late.shown(stamp)) }
}

/// How long a sensor's clock has run since it was right, as a function of the time of what it shows.
fn age(signal: &Signal, late: Lateness) -> Signal {
    let time = signal.time();
    let ends = [time[0], time[time.len() - 1]];
    let of = |t: f64| (t + late.delay - late.since) / (1.0 + late.clock);
    Signal::new(ends.into(), ends.map(of).to_vec(), Interpolation::Linear).unwrap_or_else(|_| signal.clone())
}
