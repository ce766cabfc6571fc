//! A model compiled to a hybrid automaton: smooth rates for every combination of modes, and the surfaces
//! between them.

use crate::switched::{Switch, Switched};
use phisindy_expr::{Id, Tape, Unbound};
use phisindy_phys::Model;

/// The compiled automaton: immutable, shared between threads.
///
/// The inputs of all its tapes are `[t, x.., u.., du/dt.., p.., s.., e.., d.., b..]`; [`Switched`] says what
/// the last four are.
#[derive(Clone, Debug)]
pub struct Automaton {
    /// Names of the states, for messages.
    pub states: Vec<String>,
    /// How many inputs.
    pub inputs: usize,
    /// How many parameters.
    pub parameters: usize,
    /// The surfaces.
    pub switches: Vec<Switch>,
    /// `dx/dt`: n outputs.
    pub(crate) flow: Tape,
    /// `w` (c), `dw/dt` (c), `d(dw/dt)/ds` (c x c), `dw/dx` (c x n).
    pub(crate) surface: Tape,
    /// `w` (c), `dw/dx` (c x n): what keeps a contact at rest.
    pub(crate) rest: Tape,
    /// Derivatives, for sensitivities: see [`crate::sensitivity`].
    pub(crate) jacobian: Tape,
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
        let mut switched = Switched::new(model);
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
        ] {
            inputs.extend(group);
        }
        let surface: Vec<Id> = [&s.surfaces, &s.surface_rates, &s.influence, &s.normals]
            .into_iter()
            .flatten()
            .copied()
            .collect();

        let rest: Vec<Id> = s.surfaces.iter().chain(&s.normals).copied().collect();

        let Switched { graph, switches, modes, rates, surfaces, surface_rates, .. } = &mut switched;
        let mut derivatives = Vec::new();
        for (of, wrt) in [
            (&*rates, &model.states),
            (&*rates, &model.parameters),
            (&*rates, &*modes),
            (&*surface_rates, &model.states),
            (&*surface_rates, &model.parameters),
            (&*surfaces, &model.parameters),
        ] {
            of.iter().for_each(|&f| derivatives.extend(graph.gradient(f, wrt)));
        }
        Ok(Automaton {
            states: (0..model.states.len()).map(|k| model.state_name(k).to_owned()).collect(),
            inputs: model.inputs.len(),
            parameters: model.parameters.len(),
            switches: std::mem::take(switches),
            flow: Tape::compile(graph, &inputs, rates)?,
            surface: Tape::compile(graph, &inputs, &surface)?,
            rest: Tape::compile(graph, &inputs, &rest)?,
            jacobian: Tape::compile(graph, &inputs, &derivatives)?,
        })
    }
}
