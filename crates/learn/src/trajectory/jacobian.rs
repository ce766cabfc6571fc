//! The slopes of the rates of a model by its states.

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
pub(crate) struct Jacobian {
    model: Model,
    tape: Tape,
}

impl Jacobian {
    /// Of the model of a problem; `None` if it cannot be compiled.
    pub(crate) fn new(problem: &Problem<'_>) -> Option<Jacobian> {
        let mut model = problem.system.model(&problem.terms);
        let states = model.states.clone();
        let rates = model.rates.clone();
        let slopes: Vec<Id> = rates.iter().flat_map(|&rate| model.graph.gradient(rate, &states)).collect();
        let tape = Tape::compile(&model.graph, &model.arguments(), &slopes).ok()?;
        Some(Jacobian { model, tape })
    }

    /// The states by which some rate has no finite slope at a sample of a record.
    pub(crate) fn singular_states(
        &self,
        record: &Record,
        sample: usize,
        states: &[f64],
        numbers: &[f64],
    ) -> Vec<usize> {
        let n = states.len();
        let mut scratch = Scratch::<1>::new(&self.tape);
        scratch.at(arguments_at(record, sample, states, numbers));
        (0..n).filter(|k| (0..n).any(|i| !scratch.output(i * n + k)[0].is_finite())).collect()
    }

    /// The first expression that has no finite slope there, although what it is made of is finite.
    pub(crate) fn singular(
        mut self,
        record: &Record,
        sample: usize,
        states: &[f64],
        numbers: &[f64],
    ) -> Option<Singular> {
        let inputs = self.model.arguments();
        for id in self.model.graph.reachable(&self.model.rates) {
            let graph = &mut self.model.graph;
            let of: Vec<Id> = operands(graph, id);
            let mut outputs = graph.gradient(id, &of);
            outputs.extend(&of);
            let tape = Tape::compile(graph, &inputs, &outputs).ok()?;
            let mut scratch = Scratch::<1>::new(&tape);
            scratch.at(arguments_at(record, sample, states, numbers));
            let finite = |k: usize| scratch.output(k)[0].is_finite();
            if (of.len()..outputs.len()).all(finite) && !(0..of.len()).all(finite) {
                let state = (0..states.len()).find(|&k| graph.uses(&[id], &[self.model.states[k]]))?;
                return Some(Singular { expression: self.model.text(id), state });
            }
        }
        None
    }
}

/// The arguments of a model at a sample, in the order of [`Model::arguments`]. `numbers` are all its
/// parameters.
pub(crate) fn arguments_at<'r>(
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
