//! Inputs whose sensors are late by a time that is to be found.
//!
//! A run reads such an input earlier by the delay. Its derivative by the delay is the input's slope: the model gets `u + d w` in the place of `u`,
//! with the slope `w` as one more input and the number `d` as one more parameter, which is zero.

use phisindy_phys::{Interpolation, Model, Record, Signal};
use std::borrow::Cow;

/// The inputs that are read at a time of their own, and their slopes in each record.
pub(crate) struct LateInputs {
    /// Which inputs, in order.
    pub(crate) inputs: Vec<usize>,
    slopes: Vec<Vec<Signal>>,
}

impl LateInputs {
    /// For these inputs of the records.
    pub(crate) fn new(inputs: Vec<usize>, records: &[&Record]) -> LateInputs {
        let slope = |record: &Record, j: usize| {
            let own = &record.inputs[j];
            // What is held between samples has no slope there, but moves all the same.
            let smooth = |values: Vec<f64>| {
                Signal::new(own.time().clone(), values, Interpolation::Cubic).unwrap_or_else(|_| own.clone())
            };
            let through = smooth(own.values().to_vec());
            smooth(own.time().iter().map(|&t| through.slope(t)).collect())
        };
        let of_record = |record: &&Record| inputs.iter().map(|&j| slope(record, j)).collect();
        let slopes = records.iter().map(of_record).collect();
        LateInputs { inputs, slopes }
    }

    /// The model with the delays among its parameters, behind those that it has.
    pub(crate) fn model(&self, mut model: Model) -> Model {
        let mut with = std::collections::HashMap::new();
        for &j in &self.inputs {
            // A space keeps the names out of reach of any spec.
            let mut fresh = |kind: &str| {
                let symbol = model.names.intern(&format!("{kind} {j}"));
                model.graph.symbol(symbol)
            };
            let (delay, slope) = (fresh("delay of input"), fresh("slope of input"));
            let step = model.graph.mul(delay, slope);
            let shifted = model.graph.add(model.inputs[j], step);
            with.insert(model.inputs[j], shifted);
            model.inputs.push(slope);
            model.parameters.push(delay);
        }
        model.rates = model.graph.replace(&model.rates, &with);
        model
    }

    /// What drives a record whose late inputs are read earlier by `delays`.
    pub(crate) fn signals<'a>(&self, record: &'a Record, index: usize, delays: &[f64]) -> Cow<'a, [Signal]> {
        if self.inputs.is_empty() {
            return Cow::Borrowed(&record.inputs);
        }
        let mut signals = record.inputs.clone();
        for (&j, &delay) in self.inputs.iter().zip(delays) {
            signals[j] = signals[j].earlier(delay);
        }
        let slopes = self.slopes[index].iter().zip(delays);
        signals.extend(slopes.map(|(slope, &delay)| slope.earlier(delay)));
        Cow::Owned(signals)
    }
}
