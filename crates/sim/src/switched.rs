//! A model with its signs replaced by modes: the expressions of a hybrid automaton, before anything is compiled.

use phisindy_expr::{Binary, Graph, Id, Names, Node, Unary};
use phisindy_phys::Model;
use std::collections::HashMap;

/// A surface `w(t, x, u, p) = 0` at which a sign in the rates jumps.
#[derive(Clone, Debug)]
pub struct Switch {
    /// The velocity (or other quantity) whose sign it is.
    pub node: Id,
    /// The same as text.
    pub text: String,
    /// Whether the sign acts on the rate of `w` itself: only then can it stick.
    pub can_stick: bool,
    /// Whether the size of the jump depends on `|w|`: friction with a shape near zero speed.
    pub shaped: bool,
}

/// Rates that are smooth for every combination of modes, and the surfaces between.
///
/// The mode `s` stands for `sgn(w)`, and `|w|` became `pos(e w + b) - b + d`. The side `e` is the mode of what slips and 0 for what sticks; the
/// floor `d` is zero for friction that is finite at rest; by the small margin `b` friction is continued smoothly beyond the surface, so that a step that
/// ends on it sees no kink, in value or derivative.
#[derive(Clone, Debug)]
pub struct Switched {
    /// Where the expressions live.
    pub graph: Graph,
    /// Names of the symbols; those of modes, sides, floors, margins and slopes hold a space.
    pub names: Names,
    /// The surfaces.
    pub switches: Vec<Switch>,
    /// `du/dt` of each input.
    pub slopes: Vec<Id>,
    /// For each switch its mode `s`.
    pub modes: Vec<Id>,
    /// For each switch the side `e`.
    pub sides: Vec<Id>,
    /// For each switch the floor `d`.
    pub floors: Vec<Id>,
    /// For each switch the margin `b`.
    pub margins: Vec<Id>,
    /// `dx/dt`.
    pub rates: Vec<Id>,
    /// `w` of each switch.
    pub surfaces: Vec<Id>,
    /// `dw/dt`.
    pub surface_rates: Vec<Id>,
    /// `d(dw/dt)/ds`, row by row.
    pub influence: Vec<Id>,
    /// `dw/dx`, row by row.
    pub normals: Vec<Id>,
}

impl Switched {
    /// Finds the switches of a model and puts modes in the place of its signs.
    ///
    /// ```
    /// use phisindy_phys::Model;
    /// use phisindy_sim::Switched;
    /// let model = Model::build(&["x", "v"], &[], &["mu"], &["v", "-x - mu*sgn(v)"]).unwrap();
    /// let switched = Switched::new(&model);
    /// assert_eq!(switched.graph.text(switched.rates[1], &switched.names), "-x - mu*mode 0");
    /// ```
    pub fn new(model: &Model) -> Switched {
        let (mut graph, mut names) = (model.graph.clone(), model.names.clone());
        let surfaces = surfaces(&mut graph, model);
        let fresh = |graph: &mut Graph, names: &mut Names, kind: &str, count: usize| -> Vec<Id> {
            // A space keeps these names out of reach of any spec.
            (0..count)
                .map(|k| names.intern(&format!("{kind} {k}")))
                .collect::<Vec<_>>()
                .into_iter()
                .map(|s| graph.symbol(s))
                .collect()
        };
        let modes = fresh(&mut graph, &mut names, "mode", surfaces.len());
        let sides = fresh(&mut graph, &mut names, "side", surfaces.len());
        let floors = fresh(&mut graph, &mut names, "floor", surfaces.len());
        let margins = fresh(&mut graph, &mut names, "margin", surfaces.len());
        let slopes = fresh(&mut graph, &mut names, "slope", model.inputs.len());
        let sizes = sizes(&mut graph, &surfaces, &sides, &floors, &margins);
        let with = replacements(&mut graph, &surfaces, &modes, &sizes);
        let rates = graph.replace(&model.rates, &with);

        // dw/dt by the chain rule, through states, inputs and time.
        let mut flow_of = model.states.clone();
        flow_of.extend(&model.inputs);
        flow_of.push(model.time);
        let one = graph.constant(1.0);
        let velocity: Vec<Id> = rates.iter().chain(&slopes).copied().chain([one]).collect();
        let mut surface_rates = Vec::new();
        for &w in &surfaces {
            let gradient = graph.gradient(w, &flow_of);
            let mut sum = graph.constant(0.0);
            for (g, v) in gradient.into_iter().zip(&velocity) {
                let share = graph.mul(g, *v);
                sum = graph.add(sum, share);
            }
            surface_rates.push(sum);
        }
        let influence: Vec<Id> = surface_rates.iter().flat_map(|&r| graph.gradient(r, &modes)).collect();

        let switches = (0..surfaces.len()).map(|k| {
            let own = influence[k * surfaces.len() + k];
            Switch {
                node: surfaces[k],
                text: graph.text(surfaces[k], &names),
                can_stick: graph.value(own) != Some(0.0),
                shaped: graph.uses(&[own], &[floors[k]]),
            }
        });
        let switches: Vec<Switch> = switches.collect();
        let normals: Vec<Id> = surfaces.iter().flat_map(|&w| graph.gradient(w, &model.states)).collect();
        Switched {
            graph,
            names,
            switches,
            slopes,
            modes,
            sides,
            floors,
            margins,
            rates,
            surfaces,
            surface_rates,
            influence,
            normals,
        }
    }
}

/// Arguments of all signs and steps in the rates that can change while the model runs; an argument and its negative are one surface.
fn surfaces(graph: &mut Graph, model: &Model) -> Vec<Id> {
    let mut moving = model.states.clone();
    moving.extend(&model.inputs);
    moving.push(model.time);
    let mut found: Vec<Id> = Vec::new();
    for id in graph.reachable(&model.rates) {
        if let Node::Unary(Unary::Sgn | Unary::Step, w) = graph.node(id) {
            let minus = graph.neg(w);
            if !found.contains(&w) && !found.contains(&minus) && graph.uses(&[w], &moving) {
                found.push(w);
            }
        }
    }
    found
}

/// What stands for `|w|`: `pos(e w + b) - b + d`.
fn sizes(graph: &mut Graph, surfaces: &[Id], sides: &[Id], floors: &[Id], margins: &[Id]) -> Vec<Id> {
    let mut size = |k: usize| {
        let along = graph.mul(sides[k], surfaces[k]);
        let along = graph.add(along, margins[k]);
        let along = graph.unary(Unary::Pos, along);
        let along = graph.sub(along, margins[k]);
        graph.add(along, floors[k])
    };
    (0..surfaces.len()).map(&mut size).collect()
}

/// `sgn w -> s`, `|w| ->` its size, `step w -> (1 + s)/2`, `pos w -> w (1 + s)/2`, and the same of `-w` with `-s`.
fn replacements(graph: &mut Graph, surfaces: &[Id], modes: &[Id], sizes: &[Id]) -> HashMap<Id, Id> {
    let mut with = HashMap::new();
    let half = graph.constant(0.5);
    for ((&w, &s), &size) in surfaces.iter().zip(modes).zip(sizes) {
        let (minus_w, minus_s) = (graph.neg(w), graph.neg(s));
        for (w, s) in [(w, s), (minus_w, minus_s)] {
            let part = graph.mul(half, s);
            let step = graph.binary(Binary::Add, half, part);
            let pos = graph.mul(step, w);
            for (op, new) in [(Unary::Sgn, s), (Unary::Abs, size), (Unary::Step, step), (Unary::Pos, pos)] {
                let old = graph.unary(op, w);
                with.insert(old, new);
            }
        }
    }
    // A minus in front of a sign was pulled out when it was built: -sgn(w) is no key, or every minus would vanish.
    with.retain(|&old, _| {
        matches!(graph.node(old), Node::Unary(Unary::Sgn | Unary::Abs | Unary::Step | Unary::Pos, _))
    });
    with
}
