//! Rates, terms and contacts: the fields of a spec that become a [`System`].

use super::checker::Checker;
use crate::system::equations::{Contact, Input, NamedPlace, Output, State, System, Term, contains_sign};
use crate::text::spec::{OutputSpec, Spec, Text, UnknownSpec};
use phisindy_expr::{Id, Span, nearest};
use std::collections::HashMap;

/// What an output calls the rate of a state by: `rate(v)`.
pub(crate) const RATE: &str = "rate";

impl Checker {
    /// The states, none of them a velocity yet.
    fn states(&mut self, spec: &Spec) -> Vec<State> {
        let mut states = Vec::new();
        for (name, unit) in &spec.states {
            let symbol = self.declare(name, "state");
            let node = self.graph.symbol(symbol);
            let factor = self.unit(unit).factor;
            states.push(State {
                name: name.value.clone(),
                unit: unit.value.clone(),
                factor,
                node,
                velocity: None,
                hidden: false,
                memory: None,
            });
        }
        states
    }

    /// The inputs.
    fn inputs(&mut self, spec: &Spec) -> Vec<Input> {
        let mut inputs = Vec::new();
        for (name, unit) in &spec.inputs {
            let symbol = self.declare(name, "input");
            let node = self.graph.symbol(symbol);
            let factor = self.unit(unit).factor;
            inputs.push(Input { name: name.value.clone(), unit: unit.value.clone(), factor, node });
        }
        inputs
    }

    /// The system that a spec describes.
    pub(super) fn system(&mut self, spec: &Spec) -> System {
        let time = self.names.intern("t");
        let time = self.graph.symbol(time);
        let mut states = self.states(spec);
        let inputs = self.inputs(spec);
        let outputs: Vec<_> = spec
            .outputs
            .iter()
            .map(|(name, output)| {
                self.declare(name, "output");
                (name, output, self.unit(&output.unit).factor)
            })
            .collect();
        let parameters = self.gather_constants(spec);
        let mut allowed: Vec<&str> = vec!["t"];
        allowed.extend(spec.states.iter().map(|(n, _)| n.value.as_str()));
        allowed.extend(spec.inputs.iter().map(|(n, _)| n.value.as_str()));
        for (name, text) in &spec.definitions {
            self.define(name, text, &allowed);
            allowed.push(&name.value);
        }

        let zero = self.graph.constant(0.0);
        let mut known = vec![zero; states.len()];
        let mut inertia = vec![None; states.len()];
        self.per_state("known", &spec.known, spec, |checker, k, text| {
            if let Some(id) = checker.expression(text, &allowed) {
                known[k] = id;
            }
        });
        let nodes: Vec<Id> = states.iter().map(|s| s.node).collect();
        let mechanism = self.mechanism(spec, &allowed, &nodes, time);
        let mut mechanism = mechanism;
        self.structure(spec, &allowed, &mut states, &mut mechanism);
        mechanism.rates.iter().for_each(|&(k, rate)| known[k] = rate);
        let moves = |name: &str| spec.is_moved(name) || spec.known.iter().any(|(k, _)| k.value == name);
        let hidden = |name: &str| states.iter().any(|s| s.hidden && s.name == name);
        for (name, _) in spec.states.iter().filter(|(n, _)| !moves(&n.value) && !hidden(&n.value)) {
            self.error(format!("state `{}` has no rate", name.value), name.span, "declared here")
                .help
                .push(format!("add `\"{}\": \"...\"` to `known`; the rate may be \"0\"", name.value));
        }
        self.per_state("inertia", &spec.inertia, spec, |checker, k, text| {
            inertia[k] = checker.expression(text, &allowed);
            if inertia[k].and_then(|own| checker.graph.value(own)).is_some_and(|own| own <= 0.0) {
                let message = format!("an inertia is positive, and `{}` is not", text.value);
                checker.error(message, text.span, "").help.push("a force over it is an acceleration".into());
            }
        });
        self.inertia_matrix(spec, &allowed, &inertia, &mut mechanism);
        mechanism.inertia.iter().for_each(|&(k, own)| inertia[k] = Some(own));
        for k in 0..states.len() {
            states[k].velocity = (0..states.len()).find(|&v| v != k && states[v].node == known[k]);
        }
        let mut terms = Vec::new();
        let entries: Vec<(Text, UnknownSpec)> = spec.unknown.clone();
        self.per_state("unknown", &entries, spec, |checker, k, unknown| {
            // Along a speed of a mechanism what is unknown is a force.
            let own = mechanism.inertia.iter().find(|(speed, _)| *speed == k).map(|&(_, own)| own);
            let own = own.filter(|_| spec.is_moved(&spec.states[k].0.value));
            checker.terms((k, own), unknown, &allowed, &mut terms);
        });
        let (rate_symbols, outputs) = self.outputs(outputs, &states, &allowed);
        let system_states: Vec<Id> = states.iter().map(|s: &State| s.node).collect();
        let contacts = self.contacts(spec, &allowed, &states, &system_states, &known, &terms);
        let places = self.places(spec, &allowed, (&states, &inputs), &system_states);
        self.limits(spec);
        let mut system = System {
            title: spec.title.as_ref().map_or(String::new(), |t| t.value.clone()),
            graph: self.graph.clone(),
            names: self.names.clone(),
            time,
            counts_from: 0.0,
            states,
            inputs,
            outputs,
            filters: vec![],
            rate_symbols,
            known,
            inertia,
            coupling: mechanism.coupling,
            momenta: mechanism.momenta,
            constraints: mechanism.constraints,
            undriven: mechanism.undriven,
            terms,
            parameters,
            record_constants: self.constants.of_records(),
            constants: self.constants.fixed(),
            contacts,
            places,
            impacts: vec![],
            points: mechanism.points,
            tables: self.tables.clone(),
            files: spec.files.clone(),
        };
        self.impacts(spec, &allowed, &mut system);
        self.filters(spec, &mut system);
        system
    }

    /// The outputs, and the symbols of the rates that they read.
    fn outputs(
        &mut self,
        declared: Vec<(&Text, &OutputSpec, f64)>,
        states: &[State],
        allowed: &[&str],
    ) -> (Vec<(usize, Id)>, Vec<Output>) {
        let rates: Vec<String> = states.iter().map(|s| format!("rate {}", s.name)).collect();
        let symbols: Vec<Id> = rates
            .iter()
            .map(|name| {
                let symbol = self.names.intern(name);
                self.graph.symbol(symbol)
            })
            .collect();
        let allowed: Vec<&str> = allowed.iter().copied().chain(rates.iter().map(String::as_str)).collect();
        let zero = self.graph.constant(0.0);
        let mut outputs = Vec::new();
        for (name, spec, factor) in declared {
            // After a mistake the name stays known: what else names it is right.
            let node = self.expression_with(&spec.reads, &allowed, &[RATE]).unwrap_or(zero);
            let (name, unit, reads) = (name.value.clone(), spec.unit.value.clone(), spec.reads.value.clone());
            outputs.push(Output { name, unit, factor, reads, reading: node, node });
        }
        let nodes: Vec<Id> = outputs.iter().map(|o| o.node).collect();
        let used = |symbol: &Id| self.graph.uses(&nodes, &[*symbol]);
        (symbols.into_iter().enumerate().filter(|(_, s)| used(s)).collect(), outputs)
    }

    /// Calls `each` for every entry of a map whose keys are states.
    fn per_state<T>(
        &mut self,
        field: &str,
        map: &[(Text, T)],
        spec: &Spec,
        mut each: impl FnMut(&mut Self, usize, &T),
    ) {
        let names: Vec<&str> = spec.states.iter().map(|(n, _)| n.value.as_str()).collect();
        for (name, value) in map {
            match names.iter().position(|n| *n == name.value) {
                Some(k) => each(self, k, value),
                None => self.unknown_name(&name.value, name.span, &format!("state in `{field}`"), &names),
            }
        }
    }

    fn terms(
        &mut self,
        (state, inertia): (usize, Option<Id>),
        unknown: &UnknownSpec,
        allowed: &[&str],
        terms: &mut Vec<Term>,
    ) {
        let one = self.graph.constant(1.0);
        let factor = match &unknown.factor {
            Some(text) => self.expression(text, allowed),
            None => Some(one),
        };
        let factor = factor.map(|factor| inertia.map_or(factor, |own| self.graph.div(factor, own)));
        if !unknown.search.is_empty() {
            self.searches.push((state, unknown.search.clone()));
        }
        if let (Some(first), Some(_)) = (unknown.search.first(), unknown.candidates.first()) {
            self.error("candidates and a search at the same place", first.span, "searched beside candidates")
                .help
                .push("give one of them: a formula may be any of the candidates".into());
        }
        if unknown.candidates.is_empty() && unknown.laws.is_empty() && unknown.search.is_empty() {
            self.error("there is nothing to look for: `candidates` is empty", unknown.span, "")
                .help
                .push("list candidates such as \"1\", or leave this entry out".into());
        }
        for law in &unknown.laws {
            if self.laws.iter().any(|(k, before)| *k == state && before.value == law.value) {
                self.error("the same law twice", law.span, "again here")
                    .help
                    .push("delete one of the two: no data can tell them apart".into());
                continue;
            }
            self.laws.push((state, law.clone()));
        }
        let texts: Vec<&str> = unknown.candidates.iter().map(|c| c.value.as_str()).collect();
        for (name, _) in unknown.within.iter().filter(|(name, _)| !texts.contains(&name.value.as_str())) {
            self.unknown_name(&name.value, name.span, "candidate in `within`", &texts);
        }
        let mut seen: HashMap<Id, Span> = HashMap::new();
        for candidate in &unknown.candidates {
            let (Some(factor), Some(bare)) = (factor, self.expression(candidate, allowed)) else { continue };
            if self.graph.value(bare) == Some(0.0) {
                self.error("this candidate is zero", candidate.span, "")
                    .help
                    .push("delete it, or correct the expression".into());
                continue;
            }
            if let Some(&first) = seen.get(&bare) {
                let source = self.source;
                let d = self.error("the same candidate twice", candidate.span, "again here");
                *d = d
                    .clone()
                    .also(source, first, "first here")
                    .help("delete one of the two: no data can tell them apart");
                continue;
            }
            seen.insert(bare, candidate.span);
            let value = self.graph.mul(factor, bare);
            if !self.graph.rests(&[value]).is_empty() {
                self.warn("a coefficient of what acts at rest alone is not found", candidate.span, "")
                    .help
                    .push("write the term in `known` with a constant `Find(...)`, or ask `phisindy gap`, which knows breakaway".into());
            }
            let candidate = candidate.value.clone();
            let bounds = unknown.within.iter().find(|(name, _)| name.value == candidate);
            let within = bounds.map_or((f64::NEG_INFINITY, f64::INFINITY), |(_, within)| *within);
            let (unit, force, energy) = (None, None, None);
            let factor_text = unknown.factor.as_ref().map_or("1", |text| &text.value).to_owned();
            terms.push(Term {
                state,
                candidate,
                factor_text,
                factor,
                bare,
                value,
                within,
                unit,
                force,
                energy,
            });
        }
    }

    /// The contacts: velocities that are linear in states, inputs and constants, and contain no displacement.
    fn contacts(
        &mut self,
        spec: &Spec,
        allowed: &[&str],
        states: &[State],
        nodes: &[Id],
        known: &[Id],
        terms: &[Term],
    ) -> Vec<Contact> {
        let mut contacts: Vec<Contact> = Vec::new();
        for text in &spec.contacts {
            let Some(node) = self.expression(text, allowed) else { continue };
            if !self.is_speed(text, node, states, nodes, ("so it cannot stick", "a contact")) {
                continue;
            }
            let minus = self.graph.neg(node);
            if contacts.iter().any(|c| c.node == node || c.node == minus) {
                self.error("the same contact twice", text.span, "")
                    .help
                    .push("delete one of the two: the sign of a velocity makes no difference".into());
                continue;
            }
            let mut roots: Vec<Id> = known.to_vec();
            roots.extend(terms.iter().map(|t| t.value));
            // Laws and formulas may contribute friction; their forces are not known here.
            if self.laws.is_empty()
                && self.searches.is_empty()
                && !contains_sign(&mut self.graph, &roots, node)
            {
                let message = format!(
                    "no rate holds `sgn({0})`: contact `{0}` has no friction and never sticks, unless `gap` finds some there",
                    text.value
                );
                self.warn(message, text.span, "");
            }
            contacts.push(Contact { text: text.value.clone(), node, unit: None });
        }
        contacts
    }

    /// The places where a force may act.
    fn places(
        &mut self,
        spec: &Spec,
        allowed: &[&str],
        (states, inputs): (&[State], &[Input]),
        nodes: &[Id],
    ) -> Vec<NamedPlace> {
        let mut all: Vec<NamedPlace> = Vec::new();
        for (name, place) in &spec.places {
            let lowered = |checker: &mut Checker, text: &Text| {
                let node = checker.expression(text, allowed)?;
                Some(Contact { text: text.value.clone(), node, unit: None })
            };
            let Some(of) = lowered(self, &place.of) else { continue };
            let replaces = place.replaces.as_ref().map(|input| {
                let own = inputs.iter().position(|u| u.name == input.value && u.node == of.node);
                if own.is_none() {
                    let message = format!("`{}` is no input that this place is of", input.value);
                    self.error(message, input.span, "").help.push(
                        "what acts in the place of an input is written `(of: \"u\", replaces: \"u\")`".into(),
                    );
                }
                own
            });
            let mut enters = Vec::new();
            for (state, text) in &place.enters {
                let own = states.iter().position(|s| s.name == state.value);
                if own.is_none() {
                    self.error(
                        format!("`{}` is no state", state.value),
                        state.span,
                        "its rate cannot change",
                    );
                }
                enters.extend(own.zip(lowered(self, text)));
            }
            let speed = || ("so no force acts along it", "a place");
            if replaces.is_some()
                || !place.enters.is_empty()
                || self.is_speed(&place.of, of.node, states, nodes, speed())
            {
                let name = name.value.clone();
                all.push(NamedPlace { name, of, enters, replaces: replaces.flatten() });
            }
        }
        all
    }

    /// The limits of the rig: of what the model knows.
    fn limits(&mut self, spec: &Spec) {
        let declared = [&spec.inputs, &spec.states].into_iter().flatten().map(|(name, _)| name);
        let outputs = spec.outputs.iter().map(|(name, _)| name);
        let constants = spec.constants.iter().map(|(name, _)| name);
        let known: Vec<&str> =
            declared.chain(outputs).chain(constants).map(|name| name.value.as_str()).collect();
        for (name, _) in spec.limits.iter().flat_map(|limits| &limits.ranges) {
            if !known.contains(&name.value.as_str()) {
                let message = format!("`{}` is no input, state, output or constant", name.value);
                let near = nearest(&name.value, known.iter().copied());
                let help = near.map_or_else(
                    || format!("there is: {}", known.join(", ")),
                    |near| format!("did you mean `{near}`?"),
                );
                self.error(message, name.span, "no limits").help.push(help);
            }
        }
    }

    /// Whether an expression is linear in velocities, and holds no displacement; otherwise a mistake says why not.
    fn is_speed(
        &mut self,
        text: &Text,
        node: Id,
        states: &[State],
        nodes: &[Id],
        (not, what): (&str, &str),
    ) -> bool {
        let is_place = |k: usize| states[k].velocity.is_some();
        let speeds: Vec<Id> = (0..nodes.len()).filter(|&k| !is_place(k)).map(|k| nodes[k]).collect();
        let gradient = self.graph.gradient(node, &speeds);
        let moves = gradient.iter().any(|&g| self.graph.value(g) != Some(0.0));
        let linear = !self.graph.uses(&gradient, &speeds);
        // Where nothing moves, there is no speed: a displacement only turns the direction.
        let zero = self.graph.constant(0.0);
        let at_rest = speeds.iter().map(|&v| (v, zero)).collect();
        let still = self.graph.replace(&[node], &at_rest)[0];
        let displacement = (0..nodes.len()).find(|&k| is_place(k) && self.graph.uses(&[still], &[nodes[k]]));
        if moves && linear && displacement.is_none() {
            return true;
        }
        let d = self.error(format!("`{}` is no velocity, {not}", text.value), text.span, "");
        d.help.push(match displacement {
            Some(k) => {
                let (x, v) = (&states[k].name, states[k].velocity.map_or("", |v| &states[v].name));
                format!("`{x}` is a displacement; its velocity is `{v}`")
            }
            None => {
                format!("{what} is a velocity or a difference of velocities, such as \"v\" or \"v1-v2\"")
            }
        });
        false
    }

    pub(super) fn unused_constants(&mut self, spec: &Spec) {
        for (name, _) in &spec.constants {
            if !self.used.contains(&name.value) {
                self.warn(format!("constant `{}` is not used", name.value), name.span, "");
            }
        }
    }
}
