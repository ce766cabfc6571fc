//! A model with modes in place of its signs: the expressions of a hybrid automaton before compilation.

use phisindy_expr::{Binary, Graph, Id, Names, Node, Unary};
use phisindy_phys::{Model, with_reactions};
use std::collections::HashMap;

/// A surface `w(t, x, u, p) = 0` at which a sign in the rates jumps.
#[derive(Clone, Debug)]
pub struct Switch {
    /// The velocity (or other quantity) whose sign switches.
    pub node: Id,
    /// The same as text.
    pub text: String,
    /// Whether the sign acts on the rate of `w` itself; otherwise the switch cannot stick.
    pub can_stick: bool,
    /// Whether the size of the jump depends on `|w|`: friction with a shape near zero speed.
    pub shaped: bool,
}

/// Rates that are smooth for every combination of modes, and the surfaces between them.
///
/// The mode `s` replaces `sgn(w)`, and `pos(e w + b) - b + d` replaces `|w|`. The side `e` is the mode of a
/// slipping contact and 0 for a sticking one. The floor `d` is zero for friction that is finite at rest.
/// The small margin `b` continues friction smoothly beyond the surface, so that a step that ends on it sees
/// no kink in value or derivative.
#[derive(Clone, Debug)]
pub struct Switched {
    /// The graph of all expressions.
    pub graph: Graph,
    /// Names of the symbols. Those of modes, sides, floors, margins and slopes contain a space.
    pub names: Names,
    /// The surfaces.
    pub switches: Vec<Switch>,
    /// `du/dt` of each input.
    pub slopes: Vec<Id>,
    /// `d2u/dt2` of each input, beside impacts: what rests on something that moves feels it.
    pub bends: Vec<Id>,
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
    /// How many of the last switches are the rates of gaps, which never slip: the mode is the reaction that keeps one
    /// closed.
    pub reactions: usize,
    /// What is read beside the states.
    pub outputs: Vec<Id>,
    /// The change of each output with time, states and modes at rest.
    pub output_drifts: Vec<Id>,
    /// The same of `dw/dt`, apart from what changes the slope of an input.
    pub surface_drifts: Vec<Id>,
    /// Whether rates may jump as a contact lets go: some `rest(w)` stands in them.
    pub breaks_away: bool,
}

/// Symbols of one kind. No name of a spec contains a space.
fn fresh(graph: &mut Graph, names: &mut Names, kind: &str, count: usize) -> Vec<Id> {
    let symbols: Vec<_> = (0..count).map(|k| names.intern(&format!("{kind} {k}"))).collect();
    symbols.into_iter().map(|s| graph.symbol(s)).collect()
}

/// The rate of a value by what it is given and how that moves.
pub(crate) fn drift(graph: &mut Graph, of: Id, given: &[Id], moves: &[Id]) -> Id {
    let gradient = graph.gradient(of, given);
    let zero = graph.constant(0.0);
    gradient.into_iter().zip(moves).fold(zero, |sum, (g, &v)| {
        let share = graph.mul(g, v);
        graph.add(sum, share)
    })
}

impl Switched {
    /// Finds the switches of a model and replaces its signs by modes.
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
        let mut surfaces = surfaces(&mut graph, model);
        let frictions = surfaces.len();
        let mut modes = fresh(&mut graph, &mut names, "mode", frictions);
        modes.extend(model.impacts.iter().map(|impact| impact.reaction));
        let slopes = fresh(&mut graph, &mut names, "slope", model.inputs.len());
        let moved = if model.impacts.is_empty() { 0 } else { slopes.len() };
        let bends = fresh(&mut graph, &mut names, "bend", moved);
        let one = graph.constant(1.0);
        let mut flow_of = model.states.clone();
        flow_of.extend(&model.inputs);
        flow_of.push(model.time);
        for impact in &model.impacts {
            let moves: Vec<Id> = model.rates.iter().chain(&slopes).copied().chain([one]).collect();
            surfaces.push(drift(&mut graph, impact.gap, &flow_of, &moves));
        }
        let sides = fresh(&mut graph, &mut names, "side", surfaces.len());
        let floors = fresh(&mut graph, &mut names, "floor", surfaces.len());
        let margins = fresh(&mut graph, &mut names, "margin", surfaces.len());
        let sizes = sizes(&mut graph, &surfaces[..frictions], &sides, &floors, &margins);
        let with = replacements(&mut graph, (&surfaces[..frictions], &sizes), &modes, &sides);
        let rates = with_reactions(&mut graph, &model.rates, &model.impacts);
        let rates = graph.replace(&rates, &with);
        let outputs = graph.replace(&model.outputs, &with);

        // dw/dt by the chain rule, through states, inputs and time.
        let mut velocity: Vec<Id> = rates.iter().chain(&slopes).copied().chain([one]).collect();
        flow_of.extend(slopes.iter().take(moved));
        velocity.extend(&bends);
        let surface_rates: Vec<Id> =
            surfaces.iter().map(|&w| drift(&mut graph, w, &flow_of, &velocity)).collect();
        let given =
            model.inputs.iter().copied().chain([model.time]).chain(slopes.iter().take(moved).copied());
        let given: Vec<Id> = given.collect();
        let moves: Vec<Id> = slopes.iter().copied().chain([one]).chain(bends.iter().copied()).collect();
        let mut drifts =
            |of: &[Id]| -> Vec<Id> { of.iter().map(|&f| drift(&mut graph, f, &given, &moves)).collect() };
        let output_drifts = drifts(&outputs);
        let breaks_away = breaks_away(model);
        let surface_drifts = if outputs.is_empty() && !breaks_away { vec![] } else { drifts(&surface_rates) };
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
            bends,
            modes,
            sides,
            floors,
            margins,
            rates,
            surfaces,
            surface_rates,
            influence,
            normals,
            reactions: model.impacts.len(),
            outputs,
            output_drifts,
            surface_drifts,
            breaks_away,
        }
    }
}

/// Whether friction differs at rest from what it is in motion: the rates jump as a contact lets go.
fn breaks_away(model: &Model) -> bool {
    let roots: Vec<Id> = model.rates.iter().chain(&model.outputs).copied().collect();
    !model.graph.rests(&roots).is_empty()
}

/// Arguments of all signs and steps in the rates and outputs that can change during a run. An argument and
/// its negative are one surface.
fn surfaces(graph: &mut Graph, model: &Model) -> Vec<Id> {
    let mut moving = model.states.clone();
    moving.extend(&model.inputs);
    moving.push(model.time);
    let mut surfaces: Vec<Id> = Vec::new();
    let roots: Vec<Id> = model.rates.iter().chain(&model.outputs).copied().collect();
    for id in graph.reachable(&roots) {
        if let Node::Unary(Unary::Sgn | Unary::Step | Unary::Rest, w) = graph.node(id) {
            let minus = graph.neg(w);
            if !surfaces.contains(&w) && !surfaces.contains(&minus) && graph.uses(&[w], &moving) {
                surfaces.push(w);
            }
        }
    }
    surfaces
}

/// The replacement of `|w|`: `pos(e w + b) - b + d`.
fn sizes(graph: &mut Graph, surfaces: &[Id], sides: &[Id], floors: &[Id], margins: &[Id]) -> Vec<Id> {
    let mut size = |k: usize| {
        let distance = graph.mul(sides[k], surfaces[k]);
        let distance = graph.add(distance, margins[k]);
        let distance = graph.unary(Unary::Pos, distance);
        let distance = graph.sub(distance, margins[k]);
        graph.add(distance, floors[k])
    };
    (0..surfaces.len()).map(&mut size).collect()
}

/// The replacements `sgn w -> s`, `|w| ->` its size, `step w -> (1 + s)/2`, `pos w -> w (1 + s)/2`, `rest w -> 1 - e^2`,
/// and the same for `-w` with `-s`.
fn replacements(
    graph: &mut Graph,
    (surfaces, sizes): (&[Id], &[Id]),
    modes: &[Id],
    sides: &[Id],
) -> HashMap<Id, Id> {
    let mut with = HashMap::new();
    let (half, one) = (graph.constant(0.5), graph.constant(1.0));
    for (k, &w) in surfaces.iter().enumerate() {
        let (s, size) = (modes[k], sizes[k]);
        let slips = graph.mul(sides[k], sides[k]);
        let rest = graph.sub(one, slips);
        let (minus_w, minus_s) = (graph.neg(w), graph.neg(s));
        for (w, s) in [(w, s), (minus_w, minus_s)] {
            let part = graph.mul(half, s);
            let step = graph.binary(Binary::Add, half, part);
            let pos = graph.mul(step, w);
            for (op, new) in [
                (Unary::Sgn, s),
                (Unary::Abs, size),
                (Unary::Step, step),
                (Unary::Pos, pos),
                (Unary::Rest, rest),
            ] {
                let old = graph.unary(op, w);
                with.insert(old, new);
            }
        }
    }
    // The graph moves a minus in front of a sign when it builds the node. -sgn(w) must be no key, or every
    // minus would disappear.
    with.retain(|&old, _| {
        let of = [Unary::Sgn, Unary::Abs, Unary::Step, Unary::Pos, Unary::Rest];
        matches!(graph.node(old), Node::Unary(op, _) if of.contains(&op))
    });
    with
}
