//! A model with modes in place of its kinks: corners of otherwise continuous rates.
//!
//! `|w|` becomes `s w`, `pos(w)` becomes `w (1 + s)/2`, `max` and `min` go by the sign of the difference, and
//! `dead` has two surfaces. The mode `s` is +1 or -1: it never sticks, for on the surface either is right.

use phisindy_expr::{Binary, Graph, Id, Node, Unary};
use phisindy_phys::Model;
use std::collections::HashMap;

/// The kinks of a model. What they do to rates that are continuous needs no contact rule and no jump of
/// derivatives: the steps end on their surfaces, and rates are smooth between.
#[derive(Default)]
pub(crate) struct Kinks {
    /// `w(t, x, u, p)` of each kink.
    pub(crate) surfaces: Vec<Id>,
    /// Its mode `s`.
    pub(crate) modes: Vec<Id>,
}

impl Kinks {
    /// Replaces the kinks in the rates of a model. Those remain that step control must pass:
    ///
    /// * below a root, a logarithm or a power with a fraction: these have no value beyond the surface,
    /// * a branch of `min` or `max` that may be infinite where it is not in use,
    /// * a surface that jumps itself, or is that of a sign: see [`crate::Switched`].
    pub(crate) fn replace(model: &mut Model) -> Kinks {
        let (mut kinks, mut with) = (Kinks::default(), HashMap::new());
        for node in candidates(model) {
            if let Some(new) = kinks.smooth(model, node, &with) {
                with.insert(node, new);
            }
        }
        if !with.is_empty() {
            model.rates = model.graph.replace(&model.rates, &with);
        }
        kinks
    }

    /// The node with modes in place of its kinks.
    fn smooth(&mut self, model: &mut Model, node: Id, with: &HashMap<Id, Id>) -> Option<Id> {
        let operands: Vec<Id> = model.graph.operands(node).collect();
        let new = model.graph.replace(&operands, with);
        let new = (new[0], new.last().copied()?);
        match model.graph.node(node) {
            Node::Unary(Unary::Abs, w) => {
                let s = self.mode(model, w);
                Some(model.graph.mul(s, new.0))
            }
            Node::Unary(_, w) => {
                let s = self.mode(model, w);
                Some(part(&mut model.graph, s, new.0))
            }
            Node::Binary(Binary::Dead, x, gap) => {
                let (above, below) = (model.graph.sub(x, gap), model.graph.add(x, gap));
                let (up, down) = (self.mode(model, above), self.mode(model, below));
                let graph = &mut model.graph;
                let (above, below) = (graph.sub(new.0, new.1), graph.add(new.0, new.1));
                let minus = graph.neg(down);
                let (right, left) = (part(graph, up, above), part(graph, minus, below));
                let sum = graph.add(right, left);
                if graph.value(gap).is_some_and(|gap| gap >= 0.0) {
                    return Some(sum);
                }
                // Between the surfaces of a negative gap both parts count: the function itself stands there.
                let own = graph.binary(Binary::Dead, new.0, new.1);
                let both = graph.add(above, below);
                let rest = graph.sub(own, both);
                let rest = part(graph, up, rest);
                let rest = part(graph, minus, rest);
                Some(graph.add(sum, rest))
            }
            Node::Binary(op, a, b) => {
                let w = model.graph.sub(a, b);
                let s = self.mode(model, w);
                let graph = &mut model.graph;
                let minus = graph.neg(s);
                let (first, second) = if op == Binary::Max { (s, minus) } else { (minus, s) };
                let (first, second) = (part(graph, first, new.0), part(graph, second, new.1));
                Some(graph.add(first, second))
            }
            _ => None,
        }
    }

    /// The mode of the surface `w`; an argument and its negative are one surface.
    fn mode(&mut self, model: &mut Model, w: Id) -> Id {
        let minus = model.graph.neg(w);
        match self.surfaces.iter().position(|&known| known == w || known == minus) {
            Some(k) if self.surfaces[k] == w => self.modes[k],
            Some(k) => model.graph.neg(self.modes[k]),
            None => {
                let symbol = model.names.intern(&format!("kink {}", self.modes.len()));
                self.surfaces.push(w);
                self.modes.push(model.graph.symbol(symbol));
                self.modes[self.modes.len() - 1]
            }
        }
    }
}

/// `value` where the mode is +1, 0 where it is -1.
fn part(graph: &mut Graph, mode: Id, value: Id) -> Id {
    let half = graph.constant(0.5);
    let part = graph.mul(half, mode);
    let part = graph.add(half, part);
    graph.mul(part, value)
}

/// The nodes whose kinks become events, operands first.
fn candidates(model: &mut Model) -> Vec<Id> {
    let jumps = |node: Node| {
        matches!(node, Node::Unary(Unary::Sgn | Unary::Step, _) | Node::Binary(Binary::Gate, ..))
    };
    let graph = &mut model.graph;
    let roots: Vec<Id> = model.rates.iter().chain(&model.outputs).copied().collect();
    let all = graph.reachable(&roots);
    let signs: Vec<Id> = all.iter().copied().filter(|&id| jumps(graph.node(id))).collect();
    let mut switched: Vec<Id> = signs.iter().flat_map(|&id| graph.operands(id).last()).collect();
    (0..switched.len()).for_each(|k| {
        let minus = graph.neg(switched[k]);
        switched.push(minus);
    });
    // What only a sign looks at has no corner of its own.
    let seen = graph.reachable_above(&model.rates, &signs);
    let limited: Vec<Id> = seen.iter().copied().filter(|&id| limited(graph, id)).collect();
    let operands: Vec<Id> = limited.iter().flat_map(|&id| graph.operands(id)).collect();
    let limited = graph.reachable(&operands);
    let moving: Vec<Id> = model.states.iter().chain(&model.inputs).chain([&model.time]).copied().collect();
    let mut fits = |id: Id| {
        let (a, b) = match graph.node(id) {
            Node::Unary(Unary::Abs | Unary::Pos, w) => (w, None),
            Node::Binary(Binary::Dead | Binary::Min | Binary::Max, a, b) => (a, Some(b)),
            _ => return false,
        };
        let operands: Vec<Id> = [a].into_iter().chain(b).collect();
        let branches = matches!(graph.node(id), Node::Binary(Binary::Min | Binary::Max, ..));
        let w = if let (true, Some(b)) = (branches, b) { graph.sub(a, b) } else { a };
        graph.uses(&operands, &moving)
            && !graph.uses(&operands, &signs)
            && !switched.contains(&w)
            && !(branches && graph.reachable(&operands).iter().any(|&k| infinite(graph, k, &moving)))
    };
    seen.into_iter().filter(|id| limited.binary_search(id).is_err() && fits(*id)).collect()
}

/// Whether the function has no value for some operands.
fn limited(graph: &Graph, id: Id) -> bool {
    match graph.node(id) {
        Node::Unary(Unary::Sqrt | Unary::Ln, _) => true,
        Node::Binary(Binary::Pow, _, power) => graph.value(power).is_none_or(|power| power.fract() != 0.0),
        _ => false,
    }
}

/// Whether the value of the node may be infinite during a run.
fn infinite(graph: &Graph, id: Id, moving: &[Id]) -> bool {
    match graph.node(id) {
        Node::Unary(op, a) => op.row().singular && graph.uses(&[a], moving),
        Node::Binary(Binary::Div, _, by) => graph.uses(&[by], moving),
        Node::Binary(Binary::Pow, base, power) => {
            graph.value(power).is_none_or(|power| power < 0.0) && graph.uses(&[base], moving)
        }
        _ => false,
    }
}
