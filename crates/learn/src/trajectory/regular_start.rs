//! Start states at which the rates have finite slopes. `sqrt(|h|)` has none at zero, where a state without a column
//! would start: no sensitivity is finite then, and a fit cannot move.

use crate::trajectory::layout::Segment;
use crate::trajectory::problem::Problem;
use phisindy_expr::{Graph, Id, Node, Scratch, Tape};
use phisindy_phys::{Model, Record};

/// Where a rate has no finite slope.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Singular {
    /// The innermost expression without a finite slope.
    pub(crate) expression: String,
    /// Index of a state that it depends on.
    pub(crate) state: usize,
}

/// The slopes of the rates of a problem's model by its states.
pub(crate) struct Slopes {
    model: Model,
    tape: Tape,
}

impl Slopes {
    /// Of the model of a problem; `None` if it cannot be compiled.
    pub(crate) fn new(problem: &Problem<'_>) -> Option<Slopes> {
        let mut model = problem.system.model(&problem.terms);
        let states = model.states.clone();
        let rates = model.rates.clone();
        let slopes: Vec<Id> = rates.iter().flat_map(|&rate| model.graph.gradient(rate, &states)).collect();
        let tape = Tape::compile(&model.graph, &arguments(&model), &slopes).ok()?;
        Some(Slopes { model, tape })
    }

    /// The states by which some rate has no finite slope at a sample of a record.
    fn singular_states(&self, record: &Record, sample: usize, states: &[f64], numbers: &[f64]) -> Vec<usize> {
        let n = states.len();
        let mut scratch = Scratch::<1>::new(&self.tape);
        scratch.at(row(record, sample, states, numbers));
        (0..n).filter(|k| (0..n).any(|i| !scratch.output(i * n + k)[0].is_finite())).collect()
    }

    /// The first expression that has no finite slope there, although what it is made of is finite.
    fn singular(
        mut self,
        record: &Record,
        sample: usize,
        states: &[f64],
        numbers: &[f64],
    ) -> Option<Singular> {
        let inputs = arguments(&self.model);
        for id in self.model.graph.reachable(&self.model.rates) {
            let graph = &mut self.model.graph;
            let of: Vec<Id> = operands(graph, id);
            let mut outputs = graph.gradient(id, &of);
            outputs.extend(&of);
            let tape = Tape::compile(graph, &inputs, &outputs).ok()?;
            let mut scratch = Scratch::<1>::new(&tape);
            scratch.at(row(record, sample, states, numbers));
            let finite = |k: usize| scratch.output(k)[0].is_finite();
            if (of.len()..outputs.len()).all(finite) && !(0..of.len()).all(finite) {
                let state = (0..states.len()).find(|&k| graph.uses(&[id], &[self.model.states[k]]))?;
                return Some(Singular { expression: self.model.text(id), state });
            }
        }
        None
    }
}

impl Problem<'_> {
    /// Moves start states to where the rates have finite slopes: a measured state to its next sample where they
    /// have, any other one to the size of the measured states that have its unit.
    pub(crate) fn leave_singularities(&self, x: &mut [f64], filled: &[Record]) {
        let n = self.system.states.len();
        // Elementary functions that a model is made of are singular at zero.
        let zero = |x: &[f64]| self.segments.iter().any(|s| x[s.start..s.start + n].contains(&0.0));
        let Some(slopes) = zero(x).then(|| Slopes::new(self)).flatten() else { return };
        for segment in &self.segments {
            let record = &filled[segment.record];
            let numbers = self.model_parameters(segment.record, x);
            let first = segment.samples.0;
            let own = segment.start..segment.start + n;
            for k in slopes.singular_states(record, first, &x[own.clone()], &numbers) {
                let samples = record.columns[k].iter().flat_map(|c| &c[first..segment.samples.1]).copied();
                for value in samples.chain([self.size_of(k)]) {
                    x[segment.start + k] = value;
                    let left = slopes.singular_states(record, first, &x[own.clone()], &numbers);
                    if !left.contains(&k) {
                        break;
                    }
                }
            }
        }
    }

    /// The size of a state: of measured ones with its unit the mean magnitude.
    fn size_of(&self, state: usize) -> f64 {
        let unit = &self.system.states[state].unit;
        let alike = (0..self.system.states.len()).filter(|&k| self.system.states[k].unit == *unit);
        let columns = alike.flat_map(|k| self.records.iter().filter_map(move |r| r.columns[k].as_ref()));
        let sizes = columns.map(|c| c.iter().map(|v| v.abs()).sum::<f64>() / c.len().max(1) as f64);
        let largest = sizes.fold(0.0, f64::max);
        if largest > 0.0 { largest } else { self.scale[state] }
    }

    /// Where the rates have no finite slope at the start of a segment.
    pub(crate) fn singularity(&self, x: &[f64]) -> Option<Singular> {
        let n = self.system.states.len();
        let at = |segment: &Segment| {
            let (record, first) = (self.records[segment.record], segment.samples.0);
            let (states, numbers) =
                (&x[segment.start..segment.start + n], self.model_parameters(segment.record, x));
            let slopes = Slopes::new(self)?;
            let singular = !slopes.singular_states(record, first, states, &numbers).is_empty();
            singular.then(|| slopes.singular(record, first, states, &numbers)).flatten()
        };
        self.segments.iter().find_map(at)
    }
}

fn arguments(model: &Model) -> Vec<Id> {
    let moving =
        [model.time].into_iter().chain(model.states.iter().copied()).chain(model.inputs.iter().copied());
    moving.chain(model.parameters.iter().copied()).collect()
}

fn row<'r>(
    record: &'r Record,
    sample: usize,
    states: &'r [f64],
    numbers: &'r [f64],
) -> impl Iterator<Item = f64> + 'r {
    let t = record.time[sample];
    let inputs = record.inputs.iter().map(move |u| u.value(t));
    [t].into_iter().chain(states.iter().copied()).chain(inputs).chain(numbers.iter().copied())
}

fn operands(graph: &Graph, id: Id) -> Vec<Id> {
    match graph.node(id) {
        Node::Unary(..) | Node::Binary(..) => graph.operands(id).collect(),
        _ => vec![],
    }
}
