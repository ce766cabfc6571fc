//! What an expression is, asked by its values at points without meaning: two that agree at all of them are one.

use phisindy_expr::{Graph, Id, Scratch, Tape};
use phisindy_phys::System;
use std::collections::HashMap;

/// Points at which expressions are compared.
const POINTS: usize = 5;
/// Relative difference of equal expressions: rounding of a few operations.
const EQUAL: f64 = 1e-9;

/// Values of all that the expressions of a system depend on.
pub(super) struct Probe {
    arguments: Vec<Id>,
    points: Vec<Vec<f64>>,
    /// One more point: the numbers of the model as they are.
    own: Vec<f64>,
}

impl Probe {
    /// `values` are the numbers of the model (SI) by their names.
    pub(super) fn new(system: &System, values: &HashMap<String, f64>) -> Probe {
        let arguments = system.arguments();
        let moving = 1 + system.states.len() + system.inputs.len();
        // Fractional parts of multiples of an irrational number lie everywhere and meet no line.
        let spread = |k: usize| (0.618_033_988_749_894_9 * (k as f64 + 1.0)).fract();
        let point = |p: usize| {
            let one = |k: usize| {
                let part = spread(p * arguments.len() + k);
                // Numbers of a model are positive; what moves goes both ways.
                if k < moving && k > 0 { 2.4 * part - 1.1 } else { 0.4 + 1.3 * part }
            };
            (0..arguments.len()).map(one).collect::<Vec<f64>>()
        };
        let points: Vec<Vec<f64>> = (0..POINTS).map(point).collect();
        let mut own = points[0].clone();
        let names = system.parameters.iter().map(|p| (p.node, &p.name));
        let names = names.chain(system.record_constants.iter().map(|(name, node)| (*node, name)));
        for (node, name) in names {
            let known = values.get(name).copied().unwrap_or(f64::NAN);
            if let Some(k) = arguments.iter().position(|&a| a == node) {
                own[k] = known;
            }
        }
        Probe { arguments, points, own }
    }

    /// The value with the numbers of the model; not finite where one of them is not known.
    pub(super) fn value(&self, graph: &Graph, node: Id) -> f64 {
        self.at(graph, node, &self.own)
    }

    /// Whether both are the same.
    pub(super) fn same(&self, graph: &Graph, a: Id, b: Id) -> bool {
        let equal = |p: &Vec<f64>| {
            let (a, b) = (self.at(graph, a, p), self.at(graph, b, p));
            (a - b).abs() <= EQUAL * (a.abs() + b.abs())
        };
        self.points.iter().all(equal)
    }

    /// Whether it vanishes beside another one.
    pub(super) fn nothing(&self, graph: &Graph, a: Id, beside: Id) -> bool {
        let small = |p: &Vec<f64>| self.at(graph, a, p).abs() <= EQUAL * self.at(graph, beside, p).abs();
        self.points.iter().all(small)
    }

    /// Whether it is never negative beside another one.
    pub(super) fn positive(&self, graph: &Graph, a: Id, beside: Id) -> bool {
        self.points.iter().all(|p| self.at(graph, a, p) >= -EQUAL * self.at(graph, beside, p).abs())
    }

    /// Whether it is multiplied by `factor` where each of `of` is multiplied by `by`.
    pub(super) fn scales(&self, graph: &Graph, node: Id, (of, by): (&[Id], f64), factor: f64) -> bool {
        let holds = |p: &Vec<f64>| {
            let scaled = self.arguments.iter().zip(p);
            let scaled: Vec<f64> = scaled.map(|(a, x)| if of.contains(a) { by * x } else { *x }).collect();
            let (before, after) = (self.at(graph, node, p), self.at(graph, node, &scaled));
            before != 0.0 && (after - factor * before).abs() <= 1e-7 * before.abs()
        };
        self.points.iter().all(holds)
    }

    /// Whether it is the same one turn later.
    pub(super) fn turns(&self, graph: &Graph, node: Id, angle: Id) -> bool {
        let holds = |p: &Vec<f64>| {
            let on = self.arguments.iter().zip(p);
            let on: Vec<f64> =
                on.map(|(a, x)| if *a == angle { x + std::f64::consts::TAU } else { *x }).collect();
            let (before, after) = (self.at(graph, node, p), self.at(graph, node, &on));
            (before - after).abs() <= 1e-7 * before.abs().max(1e-3)
        };
        self.points.iter().all(holds)
    }

    fn at(&self, graph: &Graph, node: Id, point: &[f64]) -> f64 {
        let Ok(tape) = Tape::compile(graph, &self.arguments, &[node]) else { return f64::NAN };
        let mut scratch = Scratch::<1>::new(&tape);
        scratch.at(point.iter().copied()).output(0)[0]
    }
}
