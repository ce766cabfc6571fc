//! How outputs read the motion: their values along it, and what a small change of states and rates adds.

use crate::evaluate::evaluated;
use crate::motion::Motion;
use phisindy_expr::{Id, Tape};
use phisindy_phys::System;

/// A tape of what the outputs read, and its derivatives by states, by the rates that they read, by
/// parameters.
pub(super) struct OutputTape {
    tape: Tape,
    /// The states whose rates are read.
    rates: Vec<usize>,
    outputs: usize,
    states: usize,
    parameters: usize,
}

/// The outputs along a motion.
pub(super) struct Readings {
    /// By output: its value at every sample.
    pub(super) values: Vec<Vec<f64>>,
    /// By output and parameter: the derivative at every sample.
    pub(super) by_parameter: Vec<Vec<Vec<f64>>>,
    /// By output and state: the derivative by the state along the linear system, which its rates follow.
    by_state: Vec<Vec<Vec<f64>>>,
    /// By output and state: the derivative by the rate of the state; empty for rates that are not read.
    by_rate: Vec<Vec<Vec<f64>>>,
}

impl OutputTape {
    pub(super) fn new(system: &System) -> Option<OutputTape> {
        let mut graph = system.graph.clone();
        let states: Vec<Id> = system.states.iter().map(|s| s.node).collect();
        let symbols: Vec<Id> = system.rate_symbols.iter().map(|&(_, symbol)| symbol).collect();
        let parameters: Vec<Id> = system.parameters.iter().map(|p| p.node).collect();
        let mut roots: Vec<Id> = system.outputs.iter().map(|o| o.node).collect();
        for by in [&states, &symbols, &parameters] {
            for output in &system.outputs {
                roots.extend(graph.gradient(output.node, by));
            }
        }
        let arguments: Vec<Id> = system.arguments().into_iter().chain(symbols).collect();
        Some(OutputTape {
            tape: Tape::compile(&graph, &arguments, &roots).ok()?,
            rates: system.rate_symbols.iter().map(|&(k, _)| k).collect(),
            outputs: system.outputs.len(),
            states: states.len(),
            parameters: parameters.len(),
        })
    }

    /// The outputs along a motion with these rates (samples x states), about the linear system `a`.
    pub(super) fn readings(&self, motion: &Motion, rates: &[f64], a: &[f64]) -> Readings {
        let (n, samples) = (self.states, motion.samples());
        let series: Vec<Vec<f64>> =
            self.rates.iter().map(|&k| (0..samples).map(|i| rates[i * n + k]).collect()).collect();
        let series: Vec<&[f64]> = series.iter().map(Vec::as_slice).collect();
        let mut all = evaluated(&self.tape, motion, &[], &series).into_iter();
        let mut take = |count: usize| -> Vec<Vec<Vec<f64>>> {
            (0..self.outputs).map(|_| all.by_ref().take(count).collect()).collect()
        };
        let values = take(1).into_iter().flatten().collect();
        let (mut by_state, read, by_parameter) = (take(n), take(self.rates.len()), take(self.parameters));
        let mut by_rate = vec![vec![vec![]; n]; self.outputs];
        for (output, read) in read.into_iter().enumerate() {
            for (&state, by) in self.rates.iter().zip(read) {
                for (k, column) in by_state[output].iter_mut().enumerate() {
                    let slope = a[state * n + k];
                    column.iter_mut().zip(&by).for_each(|(c, d)| *c += d * slope);
                }
                by_rate[output][state] = by;
            }
        }
        Readings { values, by_parameter, by_state, by_rate }
    }
}

impl Readings {
    /// What states apart by `of` add to an output at a sample.
    pub(super) fn through(&self, output: usize, sample: usize, of: &dyn Fn(usize) -> f64) -> f64 {
        self.by_state[output].iter().enumerate().map(|(k, by)| by[sample] * of(k)).sum()
    }

    /// What rates higher by `of` add to an output at a sample.
    pub(super) fn directly(&self, output: usize, sample: usize, of: &dyn Fn(usize) -> f64) -> f64 {
        let read = self.by_rate[output].iter().enumerate().filter(|(_, by)| !by.is_empty());
        read.map(|(k, by)| by[sample] * of(k)).sum()
    }
}
