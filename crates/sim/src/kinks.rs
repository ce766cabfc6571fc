//! A model with modes in place of its kinks: corners of otherwise continuous rates.
//!
//! `|w|` becomes `s w`, `pos(w)` becomes `w (1 + s)/2`, `max` and `min` go by the sign of the difference, and
//! `dead` has two surfaces. The mode `s` is +1 or -1: it never sticks, for on the surface either is right.
//! Steps end there, so that rates are smooth within each, and need neither contact rule nor jump of derivatives.

use phisindy_expr::{Binary, Graph, Id, Node, Unary};
use phisindy_phys::Model;
use std::collections::HashMap;

/// The kinks of a model.
#[derive(Default)]
pub(crate) struct Kinks {
    /// `w(t, x, u, p)` of each kink.
    pub(crate) surfaces: Vec<Id>,
    /// Its mode `s`.
    pub(crate) modes: Vec<Id>,
    /// Surfaces without a corner: see [`blunt`].
    passed: Vec<Id>,
}

impl Kinks {
    /// Replaces the kinks in the rates of a model. Those remain that step control must pass:
    ///
    /// * below a root, a logarithm or a power with a fraction: these have no value beyond the surface,
    /// * a branch of `min` or `max` that may be infinite where it is not in use,
    /// * a surface that jumps itself, or is that of a sign: see [`crate::Switched`],
    /// * a surface on which the slope does not jump, as that of `|v| v`: steps pass it as they are.
    pub(crate) fn replace(model: &mut Model) -> Kinks {
        let nodes = candidates(model);
        let (all, with) = Kinks::of(model, &nodes, vec![]);
        let rates = model.graph.replace(&model.rates, &with);
        let passed = blunt(&mut model.graph, &rates, &all, &with);
        let (kinks, with) = if passed.is_empty() { (all, with) } else { Kinks::of(model, &nodes, passed) };
        model.rates = model.graph.replace(&model.rates, &with);
        kinks
    }

    /// The kinks at these nodes, and what takes the place of the nodes.
    fn of(model: &mut Model, nodes: &[Id], passed: Vec<Id>) -> (Kinks, HashMap<Id, Id>) {
        let (mut kinks, mut with) = (Kinks { passed, ..Kinks::default() }, HashMap::new());
        for &node in nodes {
            if let Some(new) = kinks.smooth(model, node, &with) {
                with.insert(node, new);
            }
        }
        (kinks, with)
    }

    /// The node with modes in place of its kinks.
    fn smooth(&mut self, model: &mut Model, node: Id, with: &HashMap<Id, Id>) -> Option<Id> {
        let operands: Vec<Id> = model.graph.operands(node).collect();
        let new = model.graph.replace(&operands, with);
        let new = (new[0], new.last().copied()?);
        match model.graph.node(node) {
            Node::Unary(Unary::Abs, w) => {
                let s = self.mode(model, w)?;
                Some(model.graph.mul(s, new.0))
            }
            Node::Unary(_, w) => {
                let s = self.mode(model, w)?;
                Some(part(&mut model.graph, s, new.0))
            }
            Node::Binary(Binary::Dead, x, gap) => {
                let (above, below) = (model.graph.sub(x, gap), model.graph.add(x, gap));
                let (up, down) = (self.mode(model, above)?, self.mode(model, below)?);
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
                let s = self.mode(model, w)?;
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
    fn mode(&mut self, model: &mut Model, w: Id) -> Option<Id> {
        let minus = model.graph.neg(w);
        if self.passed.contains(&w) || self.passed.contains(&minus) {
            return None;
        }
        Some(match self.surfaces.iter().position(|&known| known == w || known == minus) {
            Some(k) if self.surfaces[k] == w => self.modes[k],
            Some(k) => model.graph.neg(self.modes[k]),
            None => {
                let symbol = model.names.intern(&format!("kink {}", self.modes.len()));
                self.surfaces.push(w);
                self.modes.push(model.graph.symbol(symbol));
                self.modes[self.modes.len() - 1]
            }
        })
    }
}

/// `value` where the mode is +1, 0 where it is -1.
fn part(graph: &mut Graph, mode: Id, value: Id) -> Id {
    let half = graph.constant(0.5);
    let part = graph.mul(half, mode);
    let part = graph.add(half, part);
    graph.mul(part, value)
}

/// The surfaces on which the slopes of the rates do not jump: there the mode's share vanishes with `w^2`.
fn blunt(graph: &mut Graph, rates: &[Id], kinks: &Kinks, with: &HashMap<Id, Id>) -> Vec<Id> {
    let shares: Vec<Vec<Id>> = rates.iter().map(|&rate| graph.gradient(rate, &kinks.modes)).collect();
    let within = graph.replace(&kinks.surfaces, with);
    let turned = |graph: &mut Graph, w: Id| match graph.node(w) {
        Node::Binary(Binary::Sub, a, b) => graph.sub(b, a),
        _ => w,
    };
    let flat = |k: &usize| {
        let [w, as_is] = [kinks.surfaces[*k], within[*k]];
        let either_way = [w, as_is, turned(graph, w), turned(graph, as_is)];
        shares.iter().all(|of| order(graph, of[*k], &either_way) >= 2.0)
    };
    (0..kinks.modes.len()).filter(flat).map(|k| kinks.surfaces[k]).collect()
}

/// The power of `w` (given in all its forms) with which an expression vanishes on `w = 0`, as far as its products tell.
fn order(graph: &Graph, of: Id, w: &[Id]) -> f64 {
    let mut orders: HashMap<Id, f64> = HashMap::new();
    for id in graph.reachable(&[of]) {
        let order = match graph.node(id) {
            _ if w.contains(&id) => 1.0,
            Node::Constant(_) if graph.value(id) == Some(0.0) => f64::INFINITY,
            Node::Unary(Unary::Neg | Unary::Abs | Unary::Pos | Unary::Sin | Unary::Tanh, a) => orders[&a],
            Node::Binary(Binary::Mul, a, b) => orders[&a] + orders[&b],
            Node::Binary(Binary::Add | Binary::Sub, a, b) => orders[&a].min(orders[&b]),
            Node::Binary(Binary::Div, a, _) => orders[&a],
            Node::Binary(Binary::Pow, a, n) => graph.value(n).map_or(0.0, |n| n.max(0.0) * orders[&a]),
            _ => 0.0,
        };
        orders.insert(id, if order.is_nan() { 0.0 } else { order });
    }
    orders[&of]
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
        let (surfaces, branches) = match graph.node(id) {
            Node::Unary(Unary::Abs | Unary::Pos, w) => (vec![w], false),
            Node::Binary(Binary::Dead, x, gap) => (vec![graph.sub(x, gap), graph.add(x, gap)], false),
            Node::Binary(Binary::Min | Binary::Max, a, b) => (vec![graph.sub(a, b)], true),
            _ => return false,
        };
        let operands: Vec<Id> = graph.operands(id).collect();
        let blows_up = || branches && graph.reachable(&operands).iter().any(|&k| infinite(graph, k, &moving));
        let own = surfaces.iter().all(|w| !switched.contains(w));
        own && graph.uses(&operands, &moving) && !graph.uses(&operands, &signs) && !blows_up()
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The surfaces of a model with this rate of `v`, as texts.
    fn surfaces(rate: &str) -> Vec<String> {
        let mut model = Model::build(&["x", "v"], &["u"], &["g", "n"], &["v", rate]).unwrap();
        let kinks = Kinks::replace(&mut model);
        kinks.surfaces.iter().map(|&w| model.graph.text(w, &model.names)).collect()
    }

    #[test]
    fn corners_of_the_rates_are_events() {
        let of = |rate: &str, due: &[&str]| assert_eq!(surfaces(rate), due, "{rate}");
        of("|x| + pos(-x)", &["x"]);
        of("dead(x, g)", &["x - g", "x + g"]);
        of("min(u, 3*x)", &["u - 3*x"]);
        of("|dead(x, 0)|*v + max(t, 2)", &["x", "dead(x, 0)", "t - 2"]);
        // A sign beside it makes a switch of the surface.
        of("-sgn(v)*(g + |v|) - |x|", &["x"]);
        of("sgn(|x| - g)", &[]);
        // What does not move has no events.
        of("|g|*x", &[]);
    }

    /// No slope jumps, no value beyond the surface, an infinite branch: step control passes these.
    #[test]
    fn what_needs_no_event_or_bears_none_is_left() {
        for rate in [
            "|v|*v",
            "pos(x - 1)^2 + |x - g|*3*(g - x)*u",
            "sqrt(|x|)",
            "pos(x)^1.5 + |v|^n",
            "ln(1 + |x|)",
            "min(1/x, 3)",
            "max(ln(x), -5)",
        ] {
            assert_eq!(surfaces(rate), [""; 0], "{rate}");
        }
        assert_eq!(surfaces("|v|*v + |v|"), ["v"]);
    }
}
