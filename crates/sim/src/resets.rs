//! Jumps of the state: what it becomes at an event, with its derivatives.
//!
//! At an event whose time moves by `dt` the state becomes `x+ = G(t, x-, p)`. Along the motion before it `x-` moves by
//! `S- + f- dt`, so that `S+ = G_x (S- + f- dt) + G_p + G_t dt - f+ dt` (saltation; P. C. Muller, Calculation of Lyapunov
//! exponents for dynamic systems with discontinuities, Chaos, Solitons and Fractals 5 (1995) 1671-1681). At a given time
//! `dt` is zero.

use crate::held::Held;
use crate::jacobian::Sparse;
use crate::state::Run;
use crate::switched::{Switched, drift};
use phisindy_expr::{Id, Tape, Unbound};
use phisindy_phys::Model;
use std::iter::once;

/// A jump: which states, and where among the outputs of the tape the rest is found.
#[derive(Clone, Debug)]
pub(crate) struct Reset {
    targets: Vec<usize>,
    values: usize,
    drifts: usize,
    by_state: Sparse,
    by_parameter: Sparse,
}

impl Reset {
    /// The states that jump, and the outputs of the tape that say where to.
    pub(crate) fn targets(&self) -> impl Iterator<Item = (usize, usize)> {
        self.targets.iter().copied().zip(self.values..)
    }
}

/// All jumps of a model: those of what it holds, then those of its impacts.
///
/// The inputs of the tape are those of all tapes, and whether an impact rebounds: 1, or 0 for one that ends at rest.
#[derive(Clone, Debug)]
pub(crate) struct Resets {
    pub(crate) tape: Tape,
    pub(crate) all: Vec<Reset>,
    /// The first output that is a restitution.
    pub(crate) restitutions: usize,
}

impl Resets {
    /// Of a model with modes; its tapes have these inputs.
    pub(crate) fn new(
        model: &Model,
        held: &[Held],
        of: &mut Switched,
        inputs: &[Id],
    ) -> Result<Resets, Unbound> {
        let rebounds = of.names.intern("does rebound");
        let rebounds = of.graph.symbol(rebounds);
        let graph = &mut of.graph;
        let mut maps: Vec<Vec<(usize, Id)>> = Vec::new();
        maps.extend(held.iter().flat_map(|h| h.resets(&model.states)).map(|reset| vec![reset]));
        let first = of.switches.len() - model.impacts.len();
        for (k, impact) in model.impacts.iter().enumerate() {
            let one = graph.constant(1.0);
            let part = graph.mul(rebounds, impact.restitution);
            let part = graph.add(one, part);
            let jump = graph.mul(part, of.surfaces[first + k]);
            let map = impact.direction.iter().map(|&(state, by)| {
                let share = graph.mul(by, jump);
                (state, graph.sub(model.states[state], share))
            });
            maps.push(map.collect());
        }
        let one = graph.constant(1.0);
        let given = model.inputs.iter().chain(once(&model.time)).chain(&of.slopes);
        let given: Vec<Id> = given.copied().collect();
        // What is held jumps at times that do not move.
        let moves: Vec<Id> = of.slopes.iter().chain(once(&one)).chain(&of.bends).copied().collect();
        let (mut outputs, mut all) = (Vec::new(), Vec::new());
        for map in maps {
            let (targets, nodes): (Vec<usize>, Vec<Id>) = map.into_iter().unzip();
            let values = outputs.len();
            outputs.extend(&nodes);
            let drifts = outputs.len();
            for &node in &nodes {
                outputs.push(drift(graph, node, &given, &moves));
            }
            let by_state = Sparse::new(graph, &nodes, &model.states, &mut outputs);
            let by_parameter = Sparse::new(graph, &nodes, &model.parameters, &mut outputs);
            all.push(Reset { targets, values, drifts, by_state, by_parameter });
        }
        let restitutions = outputs.len();
        outputs.extend(model.impacts.iter().map(|impact| impact.restitution));
        let inputs: Vec<Id> = inputs.iter().chain(once(&rebounds)).copied().collect();
        Ok(Resets { tape: Tape::compile(graph, &inputs, &outputs)?, all, restitutions })
    }
}

/// A state that jumps, with its derivatives by states, by columns of the sensitivities, and by the time of the jump.
pub(crate) struct Row {
    pub(crate) target: usize,
    pub(crate) by_state: Vec<(usize, f64)>,
    pub(crate) by_column: Vec<(usize, f64)>,
    pub(crate) by_time: f64,
}

impl Run<'_> {
    /// Lets states jump together, from their values before; the time moves by `moves` (not at all if there are none).
    /// [`Run::flow_on`] follows where the time moves.
    pub(crate) fn apply(&mut self, resets: &[usize], moves: &[f64], rebounds: f64) {
        let n = self.x.len();
        self.field.evaluate_resets(self.t, &self.x, rebounds);
        let (field, all) = (&self.field, &self.field.automaton.resets.all);
        let mut values = Vec::new();
        for reset in resets.iter().map(|&k| &all[k]) {
            values.extend(reset.targets().map(|(target, value)| (target, field.reset_at(value))));
        }
        if let Some(s) = &mut self.sensitivity {
            let mut rows = Vec::new();
            for reset in resets.iter().map(|&k| &all[k]) {
                for (i, &target) in reset.targets.iter().enumerate() {
                    let by_state = reset.by_state.row(i).map(|(j, k)| (j, field.reset_at(k))).collect();
                    let by_parameter = reset.by_parameter.row(i);
                    let by_column =
                        by_parameter.filter_map(|(p, k)| Some((s.column(p)?, field.reset_at(k)))).collect();
                    rows.push(Row { target, by_state, by_column, by_time: field.reset_at(reset.drifts + i) });
                }
            }
            s.map(&rows, moves, &self.rates[..n]);
        }
        values.into_iter().for_each(|(target, value)| self.x[target] = value);
    }
}
