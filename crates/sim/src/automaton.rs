//! A model compiled to a hybrid automaton: smooth rates for every combination of modes, and the surfaces
//! between them.

use crate::held::{Held, Tick};
use crate::jacobian::Jacobian;
use crate::kinks::Kinks;
use crate::resets::Resets;
use crate::switched::{Switch, Switched, drift};
use phisindy_expr::{Id, Tape, Unbound};
use phisindy_phys::Model;
use std::iter::once;

/// The compiled automaton: immutable, shared between threads.
///
/// The inputs of all its tapes are `[t, x.., u.., du/dt.., p.., s.., e.., d.., b.., k.., d2u/dt2..]`; [`Switched`]
/// says what `s`, `e`, `d` and `b` are, and `k` are the modes of the kinks. The last ones are there beside impacts.
#[derive(Clone, Debug)]
pub struct Automaton {
    /// Names of the states, for messages.
    pub states: Vec<String>,
    /// How many inputs.
    pub inputs: usize,
    /// How many parameters.
    pub parameters: usize,
    /// How many outputs.
    pub outputs: usize,
    /// The surfaces of contacts.
    pub switches: Vec<Switch>,
    /// How many states there are with those that hold something, which follow the others.
    pub(crate) width: usize,
    /// When what is held jumps.
    pub(crate) ticks: Vec<Tick>,
    pub(crate) resets: Resets,
    /// How many inputs the tapes have.
    pub(crate) arguments: usize,
    /// For each impact, the contact at whose surface its gap rests too.
    pub(crate) twins: Vec<Option<usize>>,
    /// `dx/dt`: n outputs.
    pub(crate) flow: Tape,
    /// How many kinks: surfaces that follow those of the switches; the gaps of impacts follow them.
    pub(crate) kinks: usize,
    /// `w` (c), `dw/dt` (c), `d(dw/dt)/ds` (c x c), `dw/dx` (c x n), then `w` and `dw/dt` of the kinks.
    pub(crate) surface: Tape,
    /// `dw/dx` of kinks and gaps, row by row.
    pub(crate) kink_normals: Tape,
    /// `w` (c), `dw/dx` (c x n): what keeps a contact at rest.
    pub(crate) rest: Tape,
    /// `y` (q), its drift (q), `dy/dx` (q x n), `dy/ds` (q x c), `dy/dp` (q x p), then drift (c), `d/dx` (c x
    /// n) and `d/dp` (c x p) of `dw/dt`: see [`crate::output`].
    pub(crate) output: Tape,
    /// Derivatives, for sensitivities: see [`crate::sensitivity`].
    pub(crate) jacobian: Jacobian,
    /// Whether rates may jump as a contact lets go: some `rest(w)` stands in them.
    pub breaks_away: bool,
}

impl Automaton {
    /// Finds the switches of a model and compiles it.
    ///
    /// # Errors
    /// A symbol in the rates that is neither a state, an input, a parameter nor time.
    ///
    /// ```
    /// use phisindy_phys::Model;
    /// use phisindy_sim::Automaton;
    /// let model = Model::build(&["x", "v"], &[], &["mu"], &["v", "-x - mu*sgn(v)"]).unwrap();
    /// let automaton = Automaton::new(&model).unwrap();
    /// assert_eq!(automaton.switches.len(), 1);
    /// assert!(automaton.switches[0].can_stick);
    /// ```
    pub fn new(model: &Model) -> Result<Automaton, Unbound> {
        let mut model = model.clone();
        let own = model.states.len();
        let held = Held::replace(&mut model);
        let kinks = Kinks::replace(&mut model);
        let model = &model;
        let mut switched = Switched::new(model);
        let gaps = model.impacts.iter().map(|impact| impact.gap);
        let located: Vec<Id> = kinks.surfaces.iter().copied().chain(gaps).collect();
        let (located_rates, kink_normals) = motion(&mut switched, model, &located);
        let mut inputs = vec![model.time];
        let s = &switched;
        for group in [
            &model.states,
            &model.inputs,
            &s.slopes,
            &model.parameters,
            &s.modes,
            &s.sides,
            &s.floors,
            &s.margins,
            &kinks.modes,
            &s.bends,
        ] {
            inputs.extend(group);
        }
        let surface = [&s.surfaces, &s.surface_rates, &s.influence, &s.normals, &located, &located_rates];
        let surface: Vec<Id> = surface.into_iter().flatten().copied().collect();

        let rest: Vec<Id> = s.surfaces.iter().chain(&s.normals).copied().collect();

        let jacobian = Jacobian::new(model, &mut switched, &inputs)?;
        let resets = Resets::new(model, &held, &mut switched, &inputs)?;
        let mut ticks: Vec<Tick> = Vec::new();
        for held in &held {
            ticks.extend(held.ticks(ticks.len()));
        }
        let frictions = switched.switches.len() - switched.reactions;
        let twins = (frictions..switched.switches.len()).map(|k| {
            let own = [switched.surfaces[k], switched.graph.neg(switched.surfaces[k])];
            switched.surfaces[..frictions].iter().position(|w| own.contains(w))
        });
        let twins = twins.collect();
        let Switched {
            graph,
            switches,
            modes,
            rates,
            surface_rates,
            outputs,
            output_drifts,
            surface_drifts,
            breaks_away,
            ..
        } = &mut switched;
        let mut read: Vec<Id> = outputs.iter().chain(output_drifts.iter()).copied().collect();
        if !outputs.is_empty() || *breaks_away {
            for wrt in [&model.states, &*modes, &model.parameters] {
                outputs.iter().for_each(|&y| read.extend(graph.gradient(y, wrt)));
            }
            read.extend(surface_drifts.iter());
            for wrt in [&model.states, &model.parameters] {
                surface_rates.iter().for_each(|&r| read.extend(graph.gradient(r, wrt)));
            }
        }
        Ok(Automaton {
            states: (0..own).map(|k| model.state_name(k).to_owned()).collect(),
            inputs: model.inputs.len(),
            parameters: model.parameters.len(),
            outputs: model.outputs.len(),
            switches: switches.drain(..frictions).collect(),
            width: model.states.len(),
            ticks,
            resets,
            arguments: inputs.len(),
            twins,
            flow: Tape::compile(graph, &inputs, rates)?,
            kinks: kinks.surfaces.len(),
            surface: Tape::compile(graph, &inputs, &surface)?,
            kink_normals: Tape::compile(graph, &inputs, &kink_normals)?,
            rest: Tape::compile(graph, &inputs, &rest)?,
            output: Tape::compile(graph, &inputs, &read)?,
            jacobian,
            breaks_away: *breaks_away,
        })
    }

    /// How many resets there are of what is held; those of impacts follow.
    pub(crate) fn resets_of_held(&self) -> usize {
        self.ticks.len()
    }
}

/// `dw/dt` of each surface by the chain rule, and its `dw/dx`, row by row.
fn motion(of: &mut Switched, model: &Model, surfaces: &[Id]) -> (Vec<Id>, Vec<Id>) {
    let graph = &mut of.graph;
    let one = graph.constant(1.0);
    let given: Vec<Id> = model.states.iter().chain(&model.inputs).chain(once(&model.time)).copied().collect();
    let moves: Vec<Id> = of.rates.iter().chain(&of.slopes).chain(once(&one)).copied().collect();
    let rates = surfaces.iter().map(|&w| drift(graph, w, &given, &moves)).collect();
    (rates, surfaces.iter().flat_map(|&w| graph.gradient(w, &model.states)).collect())
}
