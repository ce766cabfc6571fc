//! A checked system: known rates, unknown terms, parameters, contacts. It exists only if every name in the
//! spec resolved.

use crate::system::filter::Filter;
use crate::system::impact::{Impact, Rebound};
use crate::system::model::Model;
use crate::text::files::Files;
use crate::units::unit::{Dimension, Unit};
use phisindy_expr::{Graph, Id, Names, Node, Unary};
use std::collections::HashMap;

/// A state of the system.
#[derive(Clone, Debug)]
pub struct State {
    /// As in the spec.
    pub name: String,
    /// As in the spec; numbers are in SI throughout.
    pub unit: String,
    /// Factor from `unit` to SI.
    pub factor: f64,
    /// Its node.
    pub node: Id,
    /// If its known rate is exactly another state: that state, its velocity.
    pub velocity: Option<usize>,
    /// Whether it is of a sensor's filter, or a mode of a structure: nothing acts on it alone, and no result shows it.
    pub hidden: bool,
    /// For the memory of a law: how large it becomes along the records (SI). It starts somewhere between
    /// minus and plus this; for any other state nothing is believed beforehand.
    pub memory: Option<f64>,
}

/// A given function of time.
#[derive(Clone, Debug)]
pub struct Input {
    /// As in the spec.
    pub name: String,
    /// As in the spec.
    pub unit: String,
    /// Factor from `unit` to SI.
    pub factor: f64,
    /// Its node.
    pub node: Id,
}

/// What a sensor reads that is neither a state nor an input.
#[derive(Clone, Debug)]
pub struct Output {
    /// As in the spec.
    pub name: String,
    /// As in the spec.
    pub unit: String,
    /// Factor from `unit` to SI.
    pub factor: f64,
    /// As in the spec.
    pub reads: String,
    /// The same as a node, in which [`System::rate_symbols`] stand for the rates of states.
    pub reading: Id,
    /// What its column shows: the reading behind [`System::filters`].
    pub node: Id,
}

/// A candidate of the unknown part: the rate of `state` may contain `coefficient * value`.
#[derive(Clone, Debug)]
pub struct Term {
    /// Which rate.
    pub state: usize,
    /// The candidate as the spec writes it.
    pub candidate: String,
    /// The factor as the spec writes it; `1` where it states none.
    pub factor_text: String,
    /// `factor`, fixed constants as numbers.
    pub factor: Id,
    /// The candidate, fixed constants as numbers.
    pub bare: Id,
    /// `factor * candidate`.
    pub value: Id,
    /// Bounds of the coefficient (SI); infinite where the spec states none.
    pub within: (f64, f64),
    /// SI unit of the coefficient; `None` where the spec does not determine it.
    pub unit: Option<Dimension>,
    /// SI unit of the coefficient times the inertia of the state, where that has one and neither factor nor
    /// candidate holds it: such a coefficient is a rate, and the product is the force behind it.
    pub force: Option<Dimension>,
    /// SI unit of the work of the term on its state: energy where the spec states the inertia, else energy
    /// per inertia.
    pub energy: Option<Dimension>,
}

/// A number of the model that may move in the fit.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// As in the spec.
    pub name: String,
    /// As in the spec.
    pub unit: String,
    /// Its node.
    pub node: Id,
    /// Where the fit starts, and the value a simulation of the spec uses (SI).
    pub start: f64,
    /// Bounds (SI).
    pub within: (f64, f64),
    /// Standard deviation of what is believed beforehand, round `start`; `None` for no belief.
    pub sigma: Option<f64>,
    /// Whether every record has a value of its own.
    pub each: bool,
    /// Whether it is known in principle (`within`) rather than wholly unknown (`Find`).
    pub known: bool,
}

/// A velocity that can stick.
#[derive(Clone, Debug)]
pub struct Contact {
    /// As in the spec.
    pub text: String,
    /// Its node.
    pub node: Id,
    /// Its unit (SI), as far as the spec says.
    pub unit: Option<Dimension>,
}

/// A place that the spec names.
#[derive(Clone, Debug)]
pub struct NamedPlace {
    /// What it is called.
    pub name: String,
    /// The speed along which a force acts there, or the signal that it depends on.
    pub of: Contact,
    /// States whose rates a unit force changes by so much; empty where that follows from the speed.
    pub enters: Vec<(usize, Contact)>,
    /// The input in whose place something may act, and no force.
    pub replaces: Option<usize>,
}

/// What is zero in a mechanism whatever moves: it closes a loop.
#[derive(Clone, Debug)]
pub struct Constraint {
    /// As written.
    pub text: String,
    /// What is zero, by coordinates and time.
    pub value: Id,
    /// Its rate, by coordinates, speeds and time.
    pub rate: Id,
}

/// A point of a structure of matrices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Point {
    /// Its speed, which is a state.
    pub speed: usize,
    /// What the coordinates of the structure are called.
    pub of: String,
    /// What it is called itself.
    pub name: String,
}

/// A table of a file that an expression reads.
#[derive(Clone, Debug, PartialEq)]
pub struct TableRead {
    /// The file, as the spec names it.
    pub path: String,
    /// Its argument.
    pub of: Id,
    /// Its first and last point (SI): beyond them it goes on with the slope of its end.
    pub within: (f64, f64),
}

/// A checked system.
#[derive(Clone, Debug)]
pub struct System {
    /// Title of the case; empty if it has none.
    pub title: String,
    /// Where the expressions live.
    pub graph: Graph,
    /// Names of the symbols.
    pub names: Names,
    /// The node of time.
    pub time: Id,
    /// The time from which laws count: with the clock moved, what a law says is the same.
    pub counts_from: f64,
    /// In the order of the spec.
    pub states: Vec<State>,
    /// In the order of the spec.
    pub inputs: Vec<Input>,
    /// In the order of the spec.
    pub outputs: Vec<Output>,
    /// What stands between outputs and their columns, in the order of the signal.
    pub filters: Vec<Filter>,
    /// The states whose whole rate an output reads, and the symbol that stands for it there.
    pub rate_symbols: Vec<(usize, Id)>,
    /// The known part of each rate; fixed constants are numbers.
    pub known: Vec<Id>,
    /// What turns a force into the rate of a state, where the spec says it.
    pub inertia: Vec<Option<Id>>,
    /// A speed of a mechanism, another one, and the rate of the latter that comes with a rate of 1 of the former
    /// from a force along it.
    pub coupling: Vec<(usize, usize, Id)>,
    /// Of a mechanism each speed with the momentum of its coordinate, and the known force that changes it.
    pub momenta: Vec<(usize, Id, Id)>,
    /// What closes loops of a mechanism, in the order of the spec.
    pub constraints: Vec<Constraint>,
    /// Of `energy` each speed with the force along it that is neither of inertia, potential nor an input: friction
    /// above all.
    pub undriven: Vec<(usize, Id)>,
    /// The dictionary, in the order of the spec.
    pub terms: Vec<Term>,
    /// What may move, in the order of the spec.
    pub parameters: Vec<Parameter>,
    /// Constants whose values come with each record: name and node.
    pub record_constants: Vec<(String, Id)>,
    /// Fixed constants and their values (SI), in the order of the spec.
    pub constants: Vec<(String, f64)>,
    /// In the order of the spec.
    pub contacts: Vec<Contact>,
    /// In the order of the spec.
    pub places: Vec<NamedPlace>,
    /// In the order of the spec.
    pub impacts: Vec<Impact>,
    /// The points of a structure of matrices.
    pub points: Vec<Point>,
    /// The tables that its expressions read.
    pub tables: Vec<TableRead>,
    /// The files that the spec names beside its records: a text that is made of it needs the same.
    pub files: Files,
}

impl System {
    /// The model with some terms of the dictionary. Its parameters are, in this order: the coefficients of
    /// `terms`, [`System::parameters`], [`System::record_constants`].
    ///
    /// # Panics
    /// If a term does not exist.
    pub fn model(&self, terms: &[usize]) -> Model {
        let (mut graph, mut names) = (self.graph.clone(), self.names.clone());
        let mut rates = self.known.clone();
        let mut parameters = Vec::new();
        // factor * (sum of coefficient * candidate): the factor is multiplied once, not once for each term.
        let mut sums: Vec<Option<(Id, Id)>> = vec![None; rates.len()];
        for &k in terms {
            let term = &self.terms[k];
            // A space keeps the name out of reach of any spec.
            let symbol = names.intern(&format!("coefficient {k}"));
            let coefficient = graph.symbol(symbol);
            let share = graph.mul(coefficient, term.bare);
            let sum = sums[term.state].map_or(share, |(_, sum)| graph.add(sum, share));
            sums[term.state] = Some((term.factor, sum));
            parameters.push(coefficient);
        }
        for (state, sum) in sums.into_iter().enumerate() {
            if let Some((factor, sum)) = sum {
                let unknown = graph.mul(factor, sum);
                self.add_rate(&mut graph, &mut rates, state, unknown);
            }
        }
        parameters.extend(self.parameters.iter().map(|p| p.node));
        parameters.extend(self.record_constants.iter().map(|&(_, node)| node));
        let impacts = self.rebounds(&mut graph, &mut names);
        let whole = with_reactions(&mut graph, &rates, &impacts);
        let outputs = self.outputs_with(&mut graph, &whole);
        Model {
            graph,
            names,
            time: self.time,
            states: self.states.iter().map(|s| s.node).collect(),
            inputs: self.inputs.iter().map(|u| u.node).collect(),
            parameters,
            rates,
            outputs,
            impacts,
        }
    }

    /// Adds a force on a state to the known part: to all rates that it changes.
    pub fn add_force(&mut self, state: usize, force: Id) {
        let share = match self.inertia[state] {
            Some(inertia) => self.graph.div(force, inertia),
            None => force,
        };
        let (mut graph, mut rates) = (std::mem::take(&mut self.graph), std::mem::take(&mut self.known));
        self.add_rate(&mut graph, &mut rates, state, share);
        for (_, _, sum) in self.momenta.iter_mut().filter(|(speed, ..)| *speed == state) {
            *sum = graph.add(*sum, force);
        }
        (self.graph, self.known) = (graph, rates);
    }

    /// Adds what a force does to the rate of its state, and to the rates of all speeds that it moves too.
    pub fn add_rate(&self, graph: &mut Graph, rates: &mut [Id], state: usize, share: Id) {
        rates[state] = graph.add(rates[state], share);
        for &(_, other, ratio) in self.coupling.iter().filter(|(of, ..)| *of == state) {
            let with = graph.mul(ratio, share);
            rates[other] = graph.add(rates[other], with);
        }
    }

    /// The outputs, with these rates of the states in the place of their symbols.
    pub fn outputs_with(&self, graph: &mut Graph, rates: &[Id]) -> Vec<Id> {
        let map: HashMap<Id, Id> = self.rate_symbols.iter().map(|&(k, symbol)| (symbol, rates[k])).collect();
        graph.replace(&self.outputs.iter().map(|output| output.node).collect::<Vec<_>>(), &map)
    }

    /// Number of columns that a record can have of what a run shows: the states, then the outputs.
    pub fn columns(&self) -> usize {
        self.states.len() + self.outputs.len()
    }

    /// Index of the column of a state or output.
    pub fn column(&self, name: &str) -> Option<usize> {
        let output = || self.outputs.iter().position(|o| o.name == name).map(|k| self.states.len() + k);
        // A filtered column of a state is an output with the name of the state.
        output().or_else(|| self.state(name))
    }

    /// What a column is called where states and what sensors show of them stand side by side: the filtered
    /// column of a state has a name of its own. None for a state of a filter, which is of no interest.
    pub fn motion_column(&self, k: usize) -> Option<String> {
        let name = self.measured(k).0;
        match k.checked_sub(self.states.len()) {
            None => (!self.states[k].hidden).then(|| name.to_owned()),
            Some(_) if self.state(name).is_some() => Some(format!("{name}_filtered")),
            Some(_) => Some(name.to_owned()),
        }
    }

    /// Index of the sensor of a state, output or input.
    pub fn sensor(&self, name: &str) -> Option<usize> {
        self.column(name).or_else(|| self.input(name).map(|k| self.columns() + k))
    }

    /// Whether the known rates hold the sign of a contact's velocity: friction that the model has already.
    pub fn rubs(&self, contact: &Contact) -> bool {
        contains_sign(&mut self.graph.clone(), &self.known, contact.node)
    }

    /// What the system's expressions depend on, in one order for every tape: time, states, inputs,
    /// parameters, constants of the records.
    pub fn arguments(&self) -> Vec<Id> {
        let states = self.states.iter().map(|s| s.node);
        let inputs = self.inputs.iter().map(|u| u.node);
        let parameters = self.parameters.iter().map(|p| p.node);
        let constants = self.record_constants.iter().map(|&(_, node)| node);
        [self.time].into_iter().chain(states).chain(inputs).chain(parameters).chain(constants).collect()
    }

    /// Adds a number that may move in the fit; returns its index. Start and bounds are in SI.
    ///
    /// The name must not be taken: a symbol of this name would be the same number.
    pub fn add_parameter(
        &mut self,
        name: &str,
        unit: &str,
        start: f64,
        within: (f64, f64),
        each: bool,
    ) -> usize {
        let symbol = self.names.intern(name);
        let node = self.graph.symbol(symbol);
        self.parameters.push(Parameter {
            name: name.to_owned(),
            unit: unit.to_owned(),
            node,
            start,
            within,
            sigma: None,
            each,
            known: false,
        });
        self.parameters.len() - 1
    }

    /// Adds a state whose rate is still zero; returns its index. It has no inertia and is nobody's velocity.
    ///
    /// The name must not be taken.
    pub fn add_state(&mut self, name: &str, unit: &str) -> usize {
        let symbol = self.names.intern(name);
        let node = self.graph.symbol(symbol);
        let factor = Unit::parse(unit).map_or(1.0, |u| u.factor);
        self.states.push(State {
            name: name.to_owned(),
            unit: unit.to_owned(),
            factor,
            node,
            velocity: None,
            hidden: false,
            memory: None,
        });
        self.known.push(self.graph.constant(0.0));
        self.inertia.push(None);
        self.states.len() - 1
    }

    /// What a name of the spec stands for in expressions: the time, a state, an input, a number that moves,
    /// or the value of a constant.
    pub fn quantity(&mut self, name: &str) -> Option<Id> {
        if let Some((_, value)) = self.constants.iter().find(|(n, _)| n == name) {
            return Some(self.graph.constant(*value));
        }
        let states = self.states.iter().map(|s| (&s.name, s.node));
        let inputs = self.inputs.iter().map(|u| (&u.name, u.node));
        let parameters = self.parameters.iter().map(|p| (&p.name, p.node));
        let records = self.record_constants.iter().map(|(name, node)| (name, *node));
        let mut all = states.chain(inputs).chain(parameters).chain(records);
        all.find(|(n, _)| *n == name).map(|(_, node)| node).or((name == "t").then_some(self.time))
    }

    /// Index of a state by name.
    pub fn state(&self, name: &str) -> Option<usize> {
        self.states.iter().position(|s| s.name == name)
    }

    /// Index of an input by name.
    pub fn input(&self, name: &str) -> Option<usize> {
        self.inputs.iter().position(|u| u.name == name)
    }

    /// Name and unit of what a sensor measures: the states, then the outputs, then the inputs.
    pub fn measured(&self, sensor: usize) -> (&str, &str) {
        self.quantities().nth(sensor).expect("one sensor for each quantity")
    }

    /// Factor from the unit of what a sensor measures to SI.
    pub fn factor(&self, sensor: usize) -> f64 {
        let states = self.states.iter().map(|s| s.factor);
        let outputs = self.outputs.iter().map(|o| o.factor);
        let mut all = states.chain(outputs).chain(self.inputs.iter().map(|u| u.factor));
        all.nth(sensor).expect("one sensor for each quantity")
    }

    /// Name and unit of all that a sensor can measure, in this order: the states, the outputs, the inputs.
    pub fn quantities(&self) -> impl Iterator<Item = (&str, &str)> {
        let states = self.states.iter().map(|s| (s.name.as_str(), s.unit.as_str()));
        let outputs = self.outputs.iter().map(|o| (o.name.as_str(), o.unit.as_str()));
        let inputs = self.inputs.iter().map(|u| (u.name.as_str(), u.unit.as_str()));
        states.chain(outputs).chain(inputs)
    }

    /// A node with numbers in the place of parameters, for printing.
    pub fn with_values(&self, graph: &mut Graph, node: Id, values: &[(Id, f64)]) -> Id {
        let map: HashMap<Id, Id> = values.iter().map(|&(id, v)| (id, graph.constant(v))).collect();
        graph.replace(&[node], &map)[0]
    }
}

/// The rates with what holds closed gaps closed.
pub fn with_reactions(graph: &mut Graph, rates: &[Id], impacts: &[Rebound]) -> Vec<Id> {
    let mut whole = rates.to_vec();
    for of in impacts {
        for &(state, by) in &of.direction {
            let share = graph.mul(by, of.reaction);
            whole[state] = graph.add(whole[state], share);
        }
    }
    whole
}

/// Whether expressions contain the sign or the step function of `w` or `-w`.
pub(crate) fn contains_sign(graph: &mut Graph, roots: &[Id], w: Id) -> bool {
    let own = [w, graph.neg(w)];
    let sign =
        |id: &Id| matches!(graph.node(*id), Node::Unary(Unary::Sgn | Unary::Step, a) if own.contains(&a));
    graph.reachable(roots).iter().any(sign)
}
