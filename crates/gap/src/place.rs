//! The places where a law can act: on a body, between two bodies, between a body and an input, on a column,
//! on all columns.

mod coupling;
mod effect;
mod joints;
mod known_force;
mod needs;

pub use effect::{Effect, EffectError};
pub(crate) use effect::{bindings, fits, is_force, needs, product};
pub(crate) use known_force::known_forces;
pub use needs::Needs;

use phisindy_expr::{Graph, Id, rename};
use phisindy_phys::unit::{Dimension, Unit};
use phisindy_phys::{Contact, NamedPlace, Output, RecordPlan, System};

/// A place where a law can act.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Name in results: `v`, `v1-v2`, `v-du`, a contact of the spec such as `v-V`, the column `x`, or
    /// `motion`.
    pub at: String,
    /// Kind of place, with its expressions.
    pub site: Site,
}

/// A displacement or velocity of a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Expression in the language of the spec, in brackets unless it is a name.
    pub text: String,
    /// Its node in the graph of the system.
    pub node: Id,
}

impl Quantity {
    /// Its text without the brackets.
    pub fn bare(&self) -> &str {
        self.text.trim_start_matches('(').trim_end_matches(')')
    }
}

/// What a place is.
#[derive(Clone, Debug, PartialEq)]
pub enum Site {
    /// A force: displacement (if there is one), velocity, and the states whose rates the force enters.
    Force {
        /// The `x` of a law.
        displacement: Option<Quantity>,
        /// The `v` of a law.
        velocity: Quantity,
        /// States whose rates the force enters, with the part that they feel: -1 where the force is subtracted.
        acts: Vec<(usize, f64)>,
        /// How the force enters at each of these states where that is no number; empty elsewhere.
        enters: Vec<Entry>,
        /// Unit of what acts there, then of what it depends on. `None`: a force on a body, and its speed.
        units: Option<[Dimension; 2]>,
        /// Outputs that the force enters, with sign: what a force cell under prescribed motion reads.
        shows: Vec<(usize, f64)>,
        /// The velocity state whose units the force takes; `None` where the motion is prescribed.
        state: Option<usize>,
        /// Whether the body moves against what carries it: an input, or a belt.
        on_base: bool,
    },
    /// Sensors of the columns with these names.
    Sensor(Vec<String>),
    /// A recorded input and, where the model uses it too, its rate of change.
    Input(Vec<usize>),
    /// A wall that a displacement, a state, does not pass.
    Impact {
        /// Which state.
        state: usize,
        /// Whether the body comes from above, where it is larger.
        below: bool,
    },
    /// A constant of the spec.
    Constant {
        /// Its value there, in its unit.
        stated: f64,
    },
}

/// How a force enters at a state.
#[derive(Clone, Debug, PartialEq)]
pub enum Entry {
    /// So much of it acts along the state: a direction that turns with the motion.
    Force(Quantity),
    /// It changes the rate of the state by so much, as the spec says.
    Rate(Quantity),
}

impl Place {
    /// Whether both are the same place, perhaps of two systems with different nodes.
    pub fn is(&self, other: &Place) -> bool {
        self.at == other.at && std::mem::discriminant(&self.site) == std::mem::discriminant(&other.site)
    }

    /// Whether a force enters there by more than a number.
    pub(crate) fn enters(&self) -> bool {
        matches!(&self.site, Site::Force { enters, .. } if !enters.is_empty())
    }

    /// Whether a force acts between a body and what carries it: an input, or a belt.
    pub fn is_on_base(&self) -> bool {
        matches!(self.site, Site::Force { on_base: true, .. })
    }

    /// Whether what it reads is the speed of something that moves, as far as the spec says: not a pressure, a current or
    /// a temperature. Those have flows and drops, but nothing that rubs.
    pub(crate) fn is_of_motion(&self, system: &System) -> bool {
        let Site::Force { state: Some(state), .. } = self.site else { return true };
        let own = &system.states[state];
        let dimension = Unit::parse(&own.unit).map_or(Dimension::NONE, |u| u.dimension);
        let speed = [Dimension::METRE, Dimension::NONE].map(|of| of.div(Dimension::SECOND));
        own.unit.is_empty()
            || system.inertia[state].is_some()
            || displacement(system, state).is_some()
            || speed.contains(&dimension)
    }

    /// Converts a unit of a law, times newtons to the power `newtons`, to the units of the place. A law is
    /// written in newtons and metres; the model may use volts, radians, or forces per mass.
    pub(crate) fn unit(&self, unit: &str, newtons: f64, system: &System) -> String {
        let Ok(parsed) = Unit::parse(unit) else { return String::new() };
        match &self.site {
            Site::Constant { .. } | Site::Impact { .. } => return unit.to_owned(),
            // What acts is measured as the input is.
            Site::Input(inputs) => {
                return if unit == "N" { system.inputs[inputs[0]].unit.clone() } else { unit.to_owned() };
            }
            _ => {}
        }
        let Site::Force { state, .. } = &self.site else {
            let Site::Sensor(columns) = &self.site else { return String::new() };
            // An offset has the unit of its column.
            let own =
                columns.first().and_then(|name| system.column(name)).map_or("", |k| system.measured(k).1);
            return if unit == "m" { own.to_owned() } else { unit.to_owned() };
        };
        let [kg, m, s, ..] = parsed.dimension.powers();
        // Powers of newton, metre and second.
        let (force, length, time) = (kg + newtons, m - kg, s + 2.0 * kg);
        // A force cell under prescribed motion: the law's own units.
        let Some(state) = state else { return unit.to_owned() };
        if let Site::Force { units: Some([acting, of]), .. } = &self.site {
            let parts = [acting.pow(force), of.pow(length), Dimension::SECOND.pow(time + length)];
            let all = parts.into_iter().flatten().fold(Dimension::NONE, Dimension::mul);
            return if all == Dimension::NONE { String::new() } else { all.to_string() };
        }
        let v = &system.states[*state];
        let x = system.states.iter().find(|x| x.velocity == Some(*state));
        let x_unit = x.map_or("", |x| x.unit.as_str());
        let dimension = |u: &str| Unit::parse(u).map_or(Dimension::NONE, |u| u.dimension);
        let lengths = x.is_none_or(|_| dimension(x_unit) == Dimension::METRE);
        let si_velocity = dimension(&v.unit) == Dimension::METRE.div(Dimension::SECOND);
        let mut parts: Vec<(&str, f64)> = Vec::new();
        match (system.inertia[*state].is_some(), lengths && si_velocity) {
            (true, true) => parts.extend([("N", force), ("m", length), ("s", time)]),
            (true, false) => parts.extend([("N", force), ("m", force), (x_unit, length), ("s", time)]),
            (false, true) => parts.extend([("m", force + length), ("s", time - 2.0 * force)]),
            (false, false) => parts.extend([(x_unit, force + length), ("s", time - 2.0 * force)]),
        }
        if unit == "rad" || newtons == 0.0 && system.inertia[*state].is_some() && lengths && si_velocity {
            return unit.to_owned();
        }
        product(&parts)
    }
}

/// What a unit force at a place does to the rate of a state.
pub(crate) struct Entered<T> {
    pub(crate) state: usize,
    /// What the state is of the speed of the place; 0 of one that only follows.
    pub(crate) part: f64,
    /// The rate.
    pub(crate) rate: T,
}

/// How rates are made: as numbers, or as nodes of a graph.
pub(crate) trait Rates {
    type Rate: Copy;
    /// The rate of a state by a unit force, of which it feels this part.
    fn unit(&mut self, act: (usize, f64)) -> Self::Rate;
    /// What follows from a rate by the coupling of this place in [`System::coupling`].
    fn following(&mut self, coupling: usize, rate: Self::Rate) -> Self::Rate;
    fn sum(&mut self, a: Self::Rate, b: Self::Rate) -> Self::Rate;
}

/// What a unit force does that acts on these states, each with its sign: on them, and on all that follow.
pub(crate) fn entered<R: Rates>(
    system: &System,
    acts: &[(usize, f64)],
    rates: &mut R,
) -> Vec<Entered<R::Rate>> {
    // A force on a place is subtracted where the speed of the state adds to that of the place.
    let direct =
        acts.iter().map(|&act| Entered { state: act.0, part: -act.1, rate: rates.unit(act) }).collect();
    with_followers(system, direct, rates)
}

/// The same with what follows from these rates.
fn with_followers<R: Rates>(
    system: &System,
    mut all: Vec<Entered<R::Rate>>,
    rates: &mut R,
) -> Vec<Entered<R::Rate>> {
    let direct: Vec<(usize, R::Rate)> = all.iter().map(|e| (e.state, e.rate)).collect();
    for (state, rate) in direct {
        for (j, &(_, other, _)) in system.coupling.iter().enumerate().filter(|(_, (of, ..))| *of == state) {
            let more = rates.following(j, rate);
            match all.iter_mut().find(|e| e.state == other) {
                Some(e) => e.rate = rates.sum(e.rate, more),
                None => all.push(Entered { state: other, part: 0.0, rate: more }),
            }
        }
    }
    all
}

/// What a unit force at a place does, as nodes of a graph.
pub(crate) fn entered_nodes(system: &System, graph: &mut Graph, site: &Site) -> Vec<Entered<Id>> {
    let Site::Force { acts, enters, .. } = site else { return vec![] };
    let mut nodes = Nodes { system, graph };
    if enters.is_empty() {
        return entered(system, acts, &mut nodes);
    }
    let (mut by_force, mut by_rate) = (vec![], vec![]);
    for (&(state, part), entry) in acts.iter().zip(enters) {
        match entry {
            Entry::Force(of) => {
                let unit = nodes.unit((state, 1.0));
                let rate = nodes.graph.mul(of.node, unit);
                by_force.push(Entered { state, part: -part, rate });
            }
            Entry::Rate(of) => by_rate.push(Entered { state, part: -part, rate: of.node }),
        }
    }
    let mut all = with_followers(system, by_force, &mut nodes);
    all.extend(by_rate);
    all
}

/// Rates as nodes of a graph.
pub(crate) struct Nodes<'a> {
    pub(crate) system: &'a System,
    pub(crate) graph: &'a mut Graph,
}

impl Rates for Nodes<'_> {
    type Rate = Id;

    fn unit(&mut self, (state, weight): (usize, f64)) -> Id {
        let (one, weight) = (self.graph.constant(1.0), self.graph.constant(weight));
        self.graph.div(weight, self.system.inertia[state].unwrap_or(one))
    }

    fn following(&mut self, coupling: usize, rate: Id) -> Id {
        self.graph.mul(self.system.coupling[coupling].2, rate)
    }

    fn sum(&mut self, a: Id, b: Id) -> Id {
        self.graph.add(a, b)
    }
}

/// All places of a system: bodies, then pairs of bodies, bodies against inputs, contacts, then sensors. Adds
/// the relative displacements and velocities to the graph of the system.
///
/// ```
/// use phisindy_gap::places;
/// use phisindy_phys::{SourceId, check, spec};
/// let text = r#"(states: { "x1": "m", "x2": "m", "v1": "m/s", "v2": "m/s" },
///     constants: { "k": (1.0, "1/s^2") },
///     known: { "x1": "v1", "x2": "v2", "v1": "-2*k*x1 + k*x2", "v2": "k*(x1 - x2)" }, unknown: {},
///     data: [ Csv(path: "run.csv", time: "t", columns: { "x1": "x1" }) ])"#;
/// let (spec, _) = spec::read(text, SourceId(0)).unwrap();
/// let (mut case, _) = check(&spec, SourceId(0)).unwrap();
/// let all = places(&mut case.system, &case.records);
/// // On each body, between them, and at the one sensor.
/// assert_eq!(all.iter().map(|place| place.at.as_str()).collect::<Vec<_>>(), ["v1", "v2", "v1-v2", "x1"]);
/// ```
pub fn places(system: &mut System, plans: &[RecordPlan]) -> Vec<Place> {
    // Energies say it themselves.
    if system.coupling.is_empty() && system.momenta.is_empty() {
        let mut graph = std::mem::take(&mut system.graph);
        system.coupling = coupling::shown_by_inputs(system, &mut graph);
        system.graph = graph;
    }
    let states = &system.states;
    let bodies: Vec<usize> =
        (0..states.len()).filter(|&k| states[k].velocity.is_none() && !states[k].hidden).collect();
    let mut all: Vec<Place> = bodies.iter().map(|&v| on_body(system, v)).collect();
    all.extend(between_bodies(system, &bodies));
    all.extend(against_inputs(system, plans, &bodies));
    let named = directions(system, &bodies, &all);
    let first = system.places.len();
    let of_contacts = |p: &Place| system.places.iter().take(first).all(|own| own.name != p.at);
    let (later, mut at_first): (Vec<Place>, Vec<Place>) = named.into_iter().partition(of_contacts);
    // What the user names is looked at first.
    let replaced = |p: &Place| {
        system.places.iter().any(|own| own.replaces.is_some_and(|u| system.inputs[u].name == p.at))
    };
    let (inputs, others) = recorded(system, plans).into_iter().partition::<Vec<Place>, _>(replaced);
    at_first.extend(inputs);
    at_first.append(&mut all);
    all = at_first;
    all.extend(later);
    all.extend(prescribed(system, plans));
    let names: Vec<String> = system.quantities().take(system.columns()).map(|(n, _)| n.to_owned()).collect();
    // A filtered state shows its output alone.
    let own = |k: usize| system.column(&names[k]) == Some(k);
    let shown = |k: &usize| own(*k) && plans.iter().any(|p| is_measured(p, &names[*k], *k));
    let measured: Vec<String> = (0..names.len()).filter(shown).map(|k| names[k].clone()).collect();
    all.extend(
        measured.iter().map(|name| Place { at: name.clone(), site: Site::Sensor(vec![name.clone()]) }),
    );
    if measured.len() > 1 {
        all.push(Place { at: "motion".into(), site: Site::Sensor(measured) });
    }
    all.extend(others);
    all
}

/// The site of a force on bodies, with the velocity of body `state`.
fn force(displacement: Option<Quantity>, velocity: Quantity, acts: Vec<(usize, f64)>, state: usize) -> Site {
    let (enters, units, shows) = (vec![], None, vec![]);
    Site::Force { displacement, velocity, acts, enters, units, shows, state: Some(state), on_base: false }
}

/// The site of a force between body `state` and what carries it.
fn on_base(displacement: Option<Quantity>, velocity: Quantity, state: usize) -> Site {
    let (acts, enters, units, shows) = (vec![(state, -1.0)], vec![], None, vec![]);
    Site::Force { displacement, velocity, acts, enters, units, shows, state: Some(state), on_base: true }
}

/// The displacement whose rate is a velocity.
fn displacement(system: &System, velocity: usize) -> Option<usize> {
    system.states.iter().position(|x| x.velocity == Some(velocity))
}

/// A state as a quantity.
fn of_state(system: &System, k: usize) -> Quantity {
    Quantity { text: system.states[k].name.clone(), node: system.states[k].node }
}

/// The place of a force between a body and the ground.
fn on_body(system: &System, v: usize) -> Place {
    let x = displacement(system, v).map(|x| of_state(system, x));
    let site = force(x, of_state(system, v), vec![(v, -1.0)], v);
    Place { at: system.states[v].name.clone(), site }
}

/// The places between every two bodies that move in the same unit.
///
/// Those that the model connects, by a spring or a damper say, as far as it connects them: their number grows with the
/// joints, not with its square.
fn between_bodies(system: &mut System, bodies: &[usize]) -> Vec<Place> {
    let feels = |a: usize, b: usize| {
        let of_mechanism = system.momenta.iter().find(|(speed, ..)| *speed == a);
        let forces = of_mechanism.map_or(system.known[a], |&(.., force)| force);
        let moved: Vec<Id> =
            displacement(system, b).into_iter().chain([b]).map(|k| system.states[k].node).collect();
        system.graph.uses(&[forces], &moved)
    };
    let joined = |a: usize, b: usize| feels(a, b) || feels(b, a);
    let alone: Vec<bool> = bodies.iter().map(|&a| !bodies.iter().any(|&b| b != a && joined(a, b))).collect();
    let pairs: Vec<(usize, usize)> = (0..bodies.len())
        .flat_map(|i| (i + 1..bodies.len()).map(move |j| (i, j)))
        .filter(|&(i, j)| alone[i] || alone[j] || joined(bodies[i], bodies[j]))
        // Any two points of a structure are joined: the user names those between which something acts.
        .filter(|&(i, j)| ![i, j].iter().all(|&k| system.points.iter().any(|p| p.speed == bodies[k])))
        .map(|(i, j)| (bodies[i], bodies[j]))
        .collect();
    let mut all = Vec::new();
    for (a, b) in pairs {
        let (Some(x), Some(y)) = (displacement(system, a), displacement(system, b)) else { continue };
        if system.states[a].unit != system.states[b].unit {
            continue;
        }
        let at = format!("{}-{}", system.states[a].name, system.states[b].name);
        let [x, y, v, w] = [x, y, a, b].map(|k| of_state(system, k));
        let (x, v) = (difference(system, &x, &y), difference(system, &v, &w));
        all.push(Place { at, site: force(Some(x), v, vec![(a, -1.0), (b, 1.0)], a) });
    }
    all
}

/// The places between a body and a support whose motion is an input.
fn against_inputs(system: &mut System, plans: &[RecordPlan], bodies: &[usize]) -> Vec<Place> {
    let mut all = Vec::new();
    for (u, du) in bases(system, plans) {
        for &v in bodies {
            let Some(x) = displacement(system, v) else { continue };
            let (states, inputs) = (&system.states, &system.inputs);
            if states[v].unit != inputs[du].unit || states[x].unit != inputs[u].unit {
                continue;
            }
            let input = |k: usize| Quantity { text: inputs[k].name.clone(), node: inputs[k].node };
            let (u, du) = (input(u), input(du));
            let at = format!("{}-{}", states[v].name, du.text);
            let [x, w] = [x, v].map(|k| of_state(system, k));
            let (x, w) = (difference(system, &x, &u), difference(system, &w, &du));
            all.push(Place { at, site: on_base(Some(x), w, v) });
        }
    }
    all
}

/// The inputs that files hold, but for the rates of others.
fn recorded(system: &System, plans: &[RecordPlan]) -> Vec<Place> {
    let files = plans.iter().all(|p| matches!(p.origin, phisindy_phys::Origin::Csv(_)));
    let pairs = bases(system, plans);
    let roots: Vec<Id> = system.known.iter().copied().chain(system.outputs.iter().map(|o| o.node)).collect();
    let of = |u: usize| {
        let own: Vec<usize> =
            [u].into_iter().chain(pairs.iter().filter(|(x, _)| *x == u).map(|(_, du)| *du)).collect();
        let nodes: Vec<Id> = own.iter().map(|&k| system.inputs[k].node).collect();
        let used = system.graph.uses(&roots, &nodes);
        used.then(|| Place { at: system.inputs[u].name.clone(), site: Site::Input(own) })
    };
    let alone = |u: &usize| files && !pairs.iter().any(|(_, du)| du == u);
    (0..system.inputs.len()).filter(alone).filter_map(of).collect()
}

/// Prescribed motions with force cells: a law between the moving part and the ground enters what they read.
fn prescribed(system: &System, plans: &[RecordPlan]) -> Vec<Place> {
    let force = Unit::parse("N").map_or(Dimension::NONE, |u| u.dimension);
    let is_force = |o: &Output| Unit::parse(&o.unit).is_ok_and(|u| u.dimension == force);
    let reads = |o: &Output, input: usize| {
        let symbols: Vec<Id> = system.states.iter().map(|s| s.node).collect();
        is_force(o) && !system.graph.uses(&[o.node], &symbols) && system.inputs.len() > input
    };
    let mut all = Vec::new();
    for (u, du) in bases(system, plans) {
        let shows: Vec<(usize, f64)> =
            (0..system.outputs.len()).filter(|&k| reads(&system.outputs[k], du)).map(|k| (k, 1.0)).collect();
        let plain = |k: usize| Quantity { text: system.inputs[k].name.clone(), node: system.inputs[k].node };
        if !shows.is_empty() {
            all.push(Place {
                at: system.inputs[du].name.clone(),
                site: Site::Force {
                    displacement: Some(plain(u)),
                    velocity: plain(du),
                    acts: vec![],
                    enters: vec![],
                    units: None,
                    shows,
                    state: None,
                    on_base: false,
                },
            });
        }
    }
    all
}

/// `(a-b)`.
fn difference(system: &mut System, a: &Quantity, b: &Quantity) -> Quantity {
    Quantity { text: format!("({}-{})", a.text, b.text), node: system.graph.sub(a.node, b.node) }
}

/// The places that the spec names, its contacts, and joints that the model has, each a place for friction: speeds that are
/// sums of those of bodies with numbers, or one of a body against what carries it. `others` are places that are known already.
fn directions(system: &mut System, bodies: &[usize], others: &[Place]) -> Vec<Place> {
    let nodes: Vec<Id> = system.states.iter().map(|s| s.node).collect();
    let (by_speed, by_rate): (Vec<NamedPlace>, Vec<NamedPlace>) =
        system.places.iter().filter(|p| p.replaces.is_none()).cloned().partition(|p| p.enters.is_empty());
    let places = by_speed.into_iter().map(|p| (p.name, p.of));
    let contacts = system.contacts.iter().map(|c| (c.text.replace(' ', ""), c.clone()));
    let named: Vec<(String, Contact)> = places.chain(contacts).collect();
    let listed: Vec<(String, Contact)> = named.into_iter().chain(joints::geared(system, bodies)).collect();
    let mut all: Vec<Place> = by_rate.iter().map(|place| by_its_rates(system, place, &nodes)).collect();
    for (at, contact) in listed {
        let minus = system.graph.neg(contact.node);
        let same = |p: &Place| match &p.site {
            Site::Force { velocity, .. } => velocity.node == contact.node || velocity.node == minus,
            _ => false,
        };
        let slopes = system.graph.gradient(contact.node, &nodes);
        let parts: Option<Vec<(usize, f64)>> = slopes
            .iter()
            .enumerate()
            .map(|(k, &slope)| Some((k, system.graph.value(slope)?)))
            .filter(|part| part.is_none_or(|(_, slope)| slope != 0.0))
            .collect();
        if others.iter().chain(&all).any(same) {
            continue;
        }
        let Some(mut parts) = parts else {
            all.extend(turning(system, at, &contact, &slopes, bodies));
            continue;
        };
        if !parts.iter().all(|(k, _)| bodies.contains(k)) {
            continue;
        }
        // The units of the place are those of a body that moves as it does.
        parts.sort_by_key(|(_, slope)| slope.abs() != 1.0);
        let velocity = Quantity { text: format!("({})", contact.text), node: contact.node };
        let site = match parts[..] {
            // A body on a belt has no displacement relative to it that a spring could use.
            [(v, 1.0)] => on_base(None, velocity, v),
            [] => continue,
            _ => {
                let x = along(system, &parts);
                let acts = parts.iter().map(|&(v, slope)| (v, -slope)).collect();
                force(x, velocity, acts, parts[0].0)
            }
        };
        all.push(Place { at, site });
    }
    all
}

/// Whether an expression has this name in it.
fn mentions(text: &str, name: &str) -> bool {
    phisindy_expr::parse(text).is_ok_and(|ast| ast.names().any(|(own, _)| own == name))
}

/// The unit of a state, or of its rate.
fn rate_of(system: &System, state: usize, times: i32) -> Dimension {
    let own = Unit::parse(&system.states[state].unit).map_or(Dimension::NONE, |u| u.dimension);
    (0..times).fold(own, |of, _| of.div(Dimension::SECOND))
}

/// A place whose direction turns with the motion: a force along the speed `J v` acts as `J'` times it.
fn turning(
    system: &mut System,
    at: String,
    contact: &Contact,
    slopes: &[Id],
    bodies: &[usize],
) -> Option<Place> {
    let own: Vec<usize> =
        bodies.iter().copied().filter(|&v| system.graph.value(slopes[v]) != Some(0.0)).collect();
    let moves: Vec<Id> = own.iter().map(|&v| slopes[v]).collect();
    let speeds: Vec<Id> = bodies.iter().map(|&v| system.states[v].node).collect();
    if own.is_empty() || system.graph.uses(&moves, &speeds) {
        return None;
    }
    // Linear in the speeds: with 1 for one of them and 0 for the others it is what it has of that one, in its units.
    let names: Vec<&str> = own.iter().map(|&v| system.states[v].name.as_str()).collect();
    let is_open = names.iter().all(|name| mentions(&contact.text, name));
    let alone = |one: &str| {
        let with: Vec<(String, String)> = names
            .iter()
            .map(|name| ((*name).to_owned(), if *name == one { "1.0" } else { "0.0" }.to_owned()))
            .collect();
        rename(&contact.text, &with).ok().filter(|_| is_open)
    };
    let texts: Vec<Option<String>> = names.iter().map(|name| alone(name)).collect();
    let enters = own
        .iter()
        .zip(texts)
        .map(|(&v, text)| {
            let node = system.graph.neg(slopes[v]);
            let text = text.map(|text| format!("-({text})"));
            let text = text.unwrap_or_else(|| system.graph.text(node, &system.names));
            Entry::Force(Quantity { text: format!("({text})"), node })
        })
        .collect();
    // The power of a body's inertia at its speed is that of the force along this one.
    let speed = rate_of(system, own[0], 0);
    let power = Dimension::NEWTON.mul(Dimension::METRE).div(Dimension::SECOND);
    let along_state = match system.inertia[own[0]] {
        Some(_) => Some(power),
        None => speed.pow(2.0).map(|square| square.div(Dimension::SECOND)),
    };
    let units = contact.unit.zip(along_state).map(|(of, power)| [power.div(of), of]);
    let site = Site::Force {
        displacement: None,
        velocity: Quantity { text: format!("({})", contact.text), node: contact.node },
        acts: own.iter().map(|&v| (v, -1.0)).collect(),
        enters,
        units,
        shows: vec![],
        state: Some(own[0]),
        on_base: false,
    };
    Some(Place { at, site })
}

/// A place whose force enters rates as the spec says.
fn by_its_rates(system: &mut System, place: &NamedPlace, nodes: &[Id]) -> Place {
    let slopes = system.graph.gradient(place.of.node, nodes);
    let part = |k: usize| system.graph.value(slopes[k]).unwrap_or(0.0);
    let acts = place.enters.iter().map(|&(state, _)| (state, -part(state))).collect();
    let quantity = |of: &Contact| Quantity { text: format!("({})", of.text), node: of.node };
    let acting = place.enters.first().and_then(|(state, by)| Some(rate_of(system, *state, 1).div(by.unit?)));
    let site = Site::Force {
        displacement: None,
        velocity: quantity(&place.of),
        acts,
        enters: place.enters.iter().map(|(_, rate)| Entry::Rate(quantity(rate))).collect(),
        units: acting.zip(place.of.unit).map(|(acting, of)| [acting, of]),
        shows: vec![],
        state: place.enters.first().map(|(state, _)| *state),
        on_base: false,
    };
    Place { at: place.name.clone(), site }
}

/// The displacement along a direction, if every body in it has one.
fn along(system: &mut System, parts: &[(usize, f64)]) -> Option<Quantity> {
    let mut sum: Option<(String, Id)> = None;
    for &(v, slope) in parts {
        let x = of_state(system, displacement(system, v)?);
        let number = system.graph.constant(slope);
        let part = (format!("{slope:?}*{}", x.text), system.graph.mul(number, x.node));
        sum = Some(match sum {
            Some((text, node)) => (format!("{text} + {}", part.0), system.graph.add(node, part.1)),
            None => part,
        });
    }
    sum.map(|(text, node)| Quantity { text: format!("({text})"), node })
}

fn is_measured(plan: &RecordPlan, name: &str, column: usize) -> bool {
    match &plan.origin {
        phisindy_phys::Origin::Csv(csv) => csv.columns.iter().any(|(n, _)| n.value == name),
        phisindy_phys::Origin::Synthetic(s) => s.measured_columns[column],
    }
}

/// Inputs that are a displacement and its velocity.
fn bases(system: &System, plans: &[RecordPlan]) -> Vec<(usize, usize)> {
    (0..system.inputs.len())
        .filter_map(|du| {
            let derived = plans.first().and_then(|p| p.derived.get(du).copied().flatten());
            let named = || {
                let name = system.inputs[du].name.strip_prefix('d')?;
                system.input(name)
            };
            Some((derived.or_else(named)?, du))
        })
        .collect()
}
