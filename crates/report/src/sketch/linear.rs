//! Forces in proportion to displacements and speeds, together: a stiffness between two bodies is in the rates of both,
//! and what is left of a body's own is to the ground.

use super::acting::View;
use super::number::{DAMPING, Numbers, STIFFNESS, Units, formula, signed_formula, words};
use super::scheme::{End, Kind, Known, Scheme};
use phisindy_expr::Id;

/// The linear forces on each body.
pub(super) type Forces = Vec<Vec<Id>>;

/// Springs, then dampers, and what comes from outside.
pub(super) fn add(view: &mut View<'_>, forces: &Forces, numbers: &Numbers, scheme: &mut Scheme) {
    let mut sums = vec![];
    for of in forces {
        let zero = view.system.graph.constant(0.0);
        sums.push(of.iter().fold(zero, |sum, &f| view.system.graph.add(sum, f)));
    }
    for order in [0, 1] {
        add_order(view, &sums, order, numbers, scheme);
    }
    let pairs: Vec<usize> = view.bases.iter().flat_map(|&(x, v)| [x, v]).flatten().collect();
    for (body, &sum) in sums.iter().enumerate() {
        for (k, input) in view.system.inputs.clone().iter().enumerate().filter(|(k, _)| !pairs.contains(k)) {
            push(view, body, sum, (k, input.node), scheme);
        }
    }
}

/// Adds an input that acts by itself.
fn push(view: &mut View<'_>, body: usize, sum: Id, (input, node): (usize, Id), scheme: &mut Scheme) {
    let graph = &mut view.system.graph;
    let slope = graph.gradient(sum, &[node])[0];
    if graph.value(slope) == Some(0.0) {
        return;
    }
    let one = graph.constant(1.0);
    let product = if view.probe.same(graph, slope, one) { node } else { graph.mul(slope, node) };
    let words = signed_formula(view.system, product);
    let name = crate::terminal::unicode::name(&view.system.inputs[input].name);
    scheme.push(body, if words.is_empty() { name } else { words }, Known::Stated);
}

/// Of displacements (0) or of speeds (1).
fn add_order(view: &mut View<'_>, sums: &[Id], order: usize, numbers: &Numbers, scheme: &mut Scheme) {
    let (kind, units) = [(Kind::Spring, STIFFNESS), (Kind::Damper, DAMPING)][order];
    let n = sums.len();
    let node =
        |view: &View<'_>, k: usize| if order == 0 { view.displacement(k) } else { Some(view.speed(k)) };
    let zero = view.system.graph.constant(0.0);
    let mut slopes = vec![vec![zero; n]; n];
    for (i, &sum) in sums.iter().enumerate() {
        for (j, slope) in slopes[i].iter_mut().enumerate() {
            if let Some(node) = node(view, j) {
                *slope = view.system.graph.gradient(sum, &[node])[0];
            }
        }
    }
    let own: Vec<Id> = (0..n).map(|i| view.system.graph.neg(slopes[i][i])).collect();
    let mut left = own.clone();
    for i in 0..n {
        for j in i + 1..n {
            let (a, b) = (slopes[i][j], slopes[j][i]);
            if a == zero && b == zero {
                continue;
            }
            let ends = (End::Body(i), End::Body(j));
            let of_rates = view.bodies[i].mass.is_none() || view.bodies[j].mass.is_none();
            let both = a != zero && b != zero;
            if view.bodies[i].turns != view.bodies[j].turns && both && is_one(view, (own[i], own[j]), (a, b))
            {
                let body = if view.bodies[i].turns { j } else { i };
                let said = label(view, numbers, (own[body], units), body);
                scheme.state(kind, ends, said, view.constants(own[body]));
                (left[i], left[j]) = (zero, zero);
            } else if both && (of_rates || view.probe.same(&view.system.graph, a, b)) {
                let said = if of_rates { vec![] } else { label(view, numbers, (a, units), i) };
                scheme.state(kind, ends, said, view.constants(a));
                left[i] = view.system.graph.sub(left[i], a);
                left[j] = view.system.graph.sub(left[j], b);
            } else {
                let (of, by, slope) = if a == zero { (j, i, b) } else { (i, j, a) };
                let moved = node(view, by).unwrap_or(zero);
                let force = view.system.graph.mul(slope, moved);
                let said = formula(view.system, force);
                scheme.add(Kind::Force, (End::Body(of), End::Body(by)), vec![said], Known::Stated);
            }
        }
    }
    for i in 0..n {
        for base in 0..view.bases.len() {
            let (x, v) = view.bases[base];
            let Some(input) = [x, v][order] else { continue };
            let moved = view.system.inputs[input].node;
            let slope = view.system.graph.gradient(sums[i], &[moved])[0];
            if slope == zero {
                continue;
            }
            let rest = view.system.graph.sub(left[i], slope);
            let (graph, probe) = (&view.system.graph, view.probe);
            // A spring to a base counts in the body's own stiffness, whatever the numbers are.
            if probe.positive(graph, slope, slope) && probe.positive(graph, rest, left[i]) && left[i] != zero
            {
                let said = label(view, numbers, (slope, units), i);
                scheme.state(kind, (End::Base(base), End::Body(i)), said, view.constants(slope));
                left[i] = rest;
            } else {
                push(view, i, sums[i], (input, moved), scheme);
            }
        }
        if left[i] != zero && !view.probe.nothing(&view.system.graph, left[i], own[i]) {
            let said = label(view, numbers, (left[i], units), i);
            scheme.state(kind, (End::Ground, End::Body(i)), said, view.constants(left[i]));
        }
    }
}

/// Whether one spring explains the slopes of two bodies that move in different units.
fn is_one(view: &mut View<'_>, own: (Id, Id), across: (Id, Id)) -> bool {
    let graph = &mut view.system.graph;
    let (a, b) = (graph.mul(own.0, own.1), graph.mul(across.0, across.1));
    view.probe.same(graph, a, b)
}

fn label(view: &View<'_>, numbers: &Numbers, of: (Id, Units), body: usize) -> Vec<String> {
    let said = words(view.system, (view.probe, numbers), of, &view.bodies[body]);
    if said.is_empty() { vec![] } else { vec![said] }
}
