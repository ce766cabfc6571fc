//! Inputs whose sensors are off by numbers that are to be found: a zero error, a scale error, a delay.
//!
//! The model gets `(u + d w - o)/g` in the place of such an input `u`: offset `o` and gain `g` are parameters
//! of a run. A run reads the input earlier by its delay, so that the number `d` is zero; the derivative by it
//! is the input's slope `w`, which is one more input.

use phisindy_phys::{Model, Record};
use phisindy_signal::{Interpolation, Signal};
use std::borrow::Cow;

/// The inputs with such sensors, with their columns and slopes in each record.
pub(crate) struct InputSensors {
    /// Which inputs, in order.
    pub(crate) inputs: Vec<usize>,
    /// By record: what the column says, but for the delay that the record has undone.
    columns: Vec<Vec<Signal>>,
    slopes: Vec<Vec<Signal>>,
}

impl InputSensors {
    /// For the inputs that have a sensor with something to find in one of the records; `columns` of states
    /// and outputs precede them in a record's sensors.
    pub(crate) fn new(columns: usize, records: &[&Record]) -> InputSensors {
        let count = records.first().map_or(0, |r| r.inputs.len());
        let finds = |&j: &usize| {
            let of = |r: &&Record| {
                let sensor = &r.sensors[columns + j];
                [&sensor.offset, &sensor.gain, &sensor.delay].iter().any(|s| s.within.is_some())
            };
            records.iter().any(of)
        };
        let inputs: Vec<usize> = (0..count).filter(finds).collect();
        let through = |of: &Signal, values: Vec<f64>, kind: Interpolation| {
            Signal::new(of.time().clone(), values, kind).unwrap_or_else(|_| of.clone())
        };
        let column = |record: &Record, j: usize| {
            let (own, sensor) = (&record.inputs[j], &record.sensors[columns + j]);
            let (offset, gain) = (sensor.offset.start, sensor.gain.start);
            through(own, own.values().iter().map(|u| offset + gain * u).collect(), own.kind())
        };
        let slope = |column: &Signal| {
            // What is held between samples has no slope there, but moves all the same.
            let smooth = through(column, column.values().to_vec(), Interpolation::Cubic);
            let slopes = column.time().iter().map(|&t| smooth.slope(t)).collect();
            through(column, slopes, Interpolation::Cubic)
        };
        let of_record = |r: &&Record| inputs.iter().map(|&j| column(r, j)).collect();
        let read: Vec<Vec<Signal>> = records.iter().map(of_record).collect();
        let slopes = read.iter().map(|of| of.iter().map(slope).collect()).collect();
        InputSensors { inputs, columns: read, slopes }
    }

    /// The model with offset, gain and delay of each of these inputs among its parameters, in this order,
    /// behind those that it has.
    pub(crate) fn model(&self, mut model: Model) -> Model {
        let mut with = std::collections::HashMap::new();
        for &j in &self.inputs {
            // A space keeps the names out of reach of any spec.
            let mut fresh = |kind: &str| {
                let symbol = model.names.intern(&format!("{kind} of input {j}"));
                model.graph.symbol(symbol)
            };
            let (offset, gain, delay) = (fresh("offset"), fresh("gain"), fresh("delay"));
            let slope = fresh("slope");
            let graph = &mut model.graph;
            let step = graph.mul(delay, slope);
            let shifted = graph.add(model.inputs[j], step);
            let centred = graph.sub(shifted, offset);
            with.insert(model.inputs[j], graph.div(centred, gain));
            model.inputs.push(slope);
            model.parameters.extend([offset, gain, delay]);
        }
        model.rates = model.graph.replace(&model.rates, &with);
        model.outputs = model.graph.replace(&model.outputs, &with);
        model
    }

    /// What drives a record whose inputs of these are read earlier by `delays`.
    pub(crate) fn signals<'a>(&self, record: &'a Record, index: usize, delays: &[f64]) -> Cow<'a, [Signal]> {
        if self.inputs.is_empty() {
            return Cow::Borrowed(&record.inputs);
        }
        let mut signals = record.inputs.clone();
        for ((&j, column), &delay) in self.inputs.iter().zip(&self.columns[index]).zip(delays) {
            signals[j] = column.earlier(delay);
        }
        let slopes = self.slopes[index].iter().zip(delays);
        signals.extend(slopes.map(|(slope, &delay)| slope.earlier(delay)));
        Cow::Owned(signals)
    }
}
