//! Records that are simulated from a truth.

use super::checker::Checker;
use super::record::quantity_names;
use crate::system::equations::{System, with_reactions};
use crate::system::model::Model;
use crate::system::plan::{Origin, RecordPlan, Synthetic, SyntheticInput};
use crate::text::spec::{DataSpec, InputSpec, NoiseSpec, Spec, SyntheticSpec, Text};
use phisindy_expr::Id;
use std::collections::HashMap;

/// States of filters, and where each starts.
type Settled = Vec<(usize, Id)>;

impl Checker {
    /// How each input is made; an input without an excitation is a mistake.
    fn excitations(
        &mut self,
        data: &SyntheticSpec,
        system: &System,
        derived: &[Option<usize>],
    ) -> Vec<SyntheticInput> {
        let zero = self.graph.constant(0.0);
        let mut inputs = Vec::new();
        let input_names: Vec<&str> = system.inputs.iter().map(|u| u.name.as_str()).collect();
        for (name, _) in data.inputs.iter().filter(|(n, _)| system.input(&n.value).is_none()) {
            self.unknown_name(&name.value, name.span, "input", &input_names);
        }
        for (k, input) in system.inputs.iter().enumerate() {
            let given = data.inputs.iter().find(|(n, _)| n.value == input.name);
            inputs.push(match (given, derived[k]) {
                (Some((_, InputSpec::Formula(text))), _) => {
                    SyntheticInput::Formula(self.expression(text, &["t"]).unwrap_or(zero))
                }
                (Some((_, other)), _) => SyntheticInput::Generated(other.clone()),
                (None, Some(of)) => SyntheticInput::Derivative(of),
                (None, None) => {
                    self.error(
                        format!("input `{}` has no excitation in this record", input.name),
                        data.span,
                        "",
                    )
                    .help
                    .push(format!("add `inputs: {{ \"{}\": Formula(\"...\") }}`", input.name));
                    SyntheticInput::Formula(zero)
                }
            });
        }
        inputs
    }

    /// The plan of a record that is simulated; none after an error.
    pub(super) fn synthetic(
        &mut self,
        index: usize,
        data: &SyntheticSpec,
        spec: &Spec,
        system: &System,
    ) -> Option<RecordPlan> {
        let errors = self.errors();
        let mut allowed: Vec<&str> = vec!["t"];
        allowed.extend(system.states.iter().map(|s| s.name.as_str()));
        allowed.extend(system.inputs.iter().map(|u| u.name.as_str()));
        allowed.extend(spec.definitions.iter().map(|(name, _)| name.value.as_str()));
        let zero = self.graph.constant(0.0);
        let mut extra = vec![zero; system.states.len()];
        let mut shown = vec![zero; system.outputs.len()];
        let names: Vec<&str> = system.quantities().take(system.columns()).map(|(name, _)| name).collect();
        for (name, text) in &data.truth {
            let part = system
                .state(&name.value)
                .or_else(|| system.column(&name.value))
                .map(|k| (k, self.expression(text, &allowed).unwrap_or(zero)));
            match part {
                Some((k, part)) if k < extra.len() => {
                    // Along a speed of a mechanism it is a force.
                    let inertia = system.inertia[k].filter(|_| spec.is_moved(&name.value));
                    extra[k] = inertia.map_or(part, |own| self.graph.div(part, own));
                }
                Some((k, part)) => shown[k - extra.len()] = part,
                None => self.unknown_name(&name.value, name.span, "state or output in `truth`", &names),
            }
        }
        let (derived, differentiators) = self.derived(&data.derive, system);
        let inputs = self.excitations(data, system, &derived);
        let start = self.start(&data.start, system);
        let (measured_columns, measured_inputs) = self.measured(data, system);
        self.noise(&data.noise, (&measured_columns, &measured_inputs), system);
        let title = Text { value: format!("record {index}"), span: data.span };
        let own = |k: usize| data.inputs.iter().any(|(n, _)| n.value == system.inputs[k].name);
        let unexcited: Vec<_> = derived.iter().enumerate().map(|(k, of)| of.filter(|_| !own(k))).collect();
        let constants =
            self.record_constants(&DataSpec::Synthetic(Box::new(data.clone())), spec, system, &title);
        let (truth, settled, constraints) = self.truth_model(system, &extra, &shown, &inputs);
        let settled = settled.into_iter().filter(|&(k, _)| start[k].is_none()).collect();
        let plan = RecordPlan {
            name: data.name.as_ref().map_or(format!("synthetic {index}"), |n| n.value.clone()),
            role: data.role,
            constants,
            sensors: self.sensors(&data.sensors, &unexcited, system),
            derived,
            differentiators,
            interpolation: self.interpolation(&data.interpolate, system),
            start: vec![None; system.states.len()],
            origin: Origin::Synthetic(Box::new(Synthetic {
                truth,
                extra,
                inputs,
                given: start.iter().map(Option::is_some).collect(),
                start: start.into_iter().map(|x| x.unwrap_or(0.0)).collect(),
                constraints,
                settled,
                duration: data.duration.value,
                step: data.step.value,
                noise: data.noise.clone(),
                seed: data.seed.unwrap_or(0),
                measured_columns,
                measured_inputs,
                window: data.window.as_ref().map(|w| (w.0.value, w.1.value)),
            })),
        };
        (self.errors() == errors).then_some(plan)
    }

    /// Noise of a sensor stands beside the column that it falls on.
    fn noise(&mut self, noise: &NoiseSpec, (columns, inputs): (&[bool], &[bool]), system: &System) {
        let NoiseSpec::Sensor(each) = noise else { return };
        for (name, _) in each {
            match (system.column(&name.value), system.input(&name.value)) {
                (Some(k), _) if columns[k] => {}
                (_, Some(k)) if inputs[k] => {}
                (None, None) => {
                    self.unknown_name(&name.value, name.span, "column in `noise`", &quantity_names(system));
                }
                _ => self.without_column(name, "noise"),
            }
        }
    }

    /// Which columns and which inputs are recorded: the outputs where there are some, else the states, unless
    /// the record says it.
    fn measured(&mut self, data: &SyntheticSpec, system: &System) -> (Vec<bool>, Vec<bool>) {
        let (n, columns) = (system.states.len(), system.columns());
        let Some(list) = &data.measure else {
            let declared = system.outputs.iter().any(|o| system.state(&o.name).is_none());
            let own = |k: usize| system.column(&system.states[k].name) == Some(k) && !system.states[k].hidden;
            let recorded = |k| k >= n || (!declared && own(k));
            return ((0..columns).map(recorded).collect(), vec![false; system.inputs.len()]);
        };
        let (mut measured, mut inputs) = (vec![false; columns], vec![false; system.inputs.len()]);
        for name in list {
            match (system.column(&name.value), system.input(&name.value)) {
                (Some(k), _) => measured[k] = true,
                (_, Some(k)) => inputs[k] = true,
                _ => self.unknown_name(
                    &name.value,
                    name.span,
                    "state, output or input in `measure`",
                    &quantity_names(system),
                ),
            }
        }
        if !measured.contains(&true) {
            self.error("no state or output is measured, so there is nothing to fit", data.span, "");
        }
        (measured, inputs)
    }

    /// Known rates and outputs plus truth, formulas in the place of inputs, movable constants at their
    /// nominal values; where the states of filters start, after the system has been at its start for long; and
    /// the constraints with their rates.
    fn truth_model(
        &mut self,
        system: &System,
        extra: &[Id],
        shown: &[Id],
        inputs: &[SyntheticInput],
    ) -> (Model, Settled, Vec<(Id, Id)>) {
        let mut with: HashMap<Id, Id> = HashMap::new();
        for parameter in &system.parameters {
            let value = self.graph.constant(parameter.start);
            with.insert(parameter.node, value);
        }
        let formulas: Vec<Option<Id>> =
            (0..inputs.len()).map(|k| self.formula(inputs, k, system.time)).collect();
        for (input, formula) in system.inputs.iter().zip(formulas) {
            if let Some(formula) = formula {
                with.insert(input.node, formula);
            }
        }
        let mut truth = System { graph: self.graph.clone(), ..system.clone() };
        let impacts = truth.rebounds(&mut self.graph, &mut self.names);
        truth.graph.clone_from(&self.graph);
        for (output, &part) in truth.outputs.iter_mut().zip(shown) {
            output.reading = truth.graph.add(output.reading, part);
        }
        // What a force adds to a reading is no rate, so the reading stays as linear as it was.
        let _ = truth.connect_filters();
        self.graph = truth.graph;
        let mut sums = truth.known.clone();
        for (k, &part) in extra.iter().enumerate() {
            system.add_rate(&mut self.graph, &mut sums, k, part);
        }
        let rates = self.graph.replace(&sums, &with);
        let read: Vec<Id> = truth.outputs.iter().map(|o| o.node).collect();
        let outputs = self.graph.replace(&read, &with);
        let moved = with_reactions(&mut self.graph, &rates, &impacts);
        let whole: HashMap<Id, Id> =
            system.rate_symbols.iter().map(|&(k, symbol)| (symbol, moved[k])).collect();
        let outputs = self.graph.replace(&outputs, &whole);
        let mut settled = Vec::new();
        for filter in &truth.filters {
            let known = self.graph.replace(&filter.settled, &with);
            let starts = self.graph.replace(&known, &whole);
            settled.extend(starts.into_iter().enumerate().map(|(k, id)| (filter.first + k, id)));
        }
        let constraints = system.constraints.iter().map(|c| {
            let both = self.graph.replace(&[c.value, c.rate], &with);
            (both[0], both[1])
        });
        let constraints = constraints.collect();
        let mut model = Model {
            graph: self.graph.clone(),
            names: self.names.clone(),
            time: system.time,
            states: system.states.iter().map(|s| s.node).collect(),
            inputs: system.inputs.iter().map(|u| u.node).collect(),
            parameters: system.record_constants.iter().map(|&(_, node)| node).collect(),
            rates,
            outputs,
            impacts,
        };
        model.replace_in_impacts(&with);
        (model, settled, constraints)
    }

    /// The expression of an input, or of the derivative of one, if it has one.
    fn formula(&mut self, inputs: &[SyntheticInput], k: usize, time: Id) -> Option<Id> {
        match inputs[k] {
            SyntheticInput::Formula(id) => Some(id),
            SyntheticInput::Derivative(of) => match inputs[of] {
                SyntheticInput::Formula(id) => Some(self.graph.gradient(id, &[time])[0]),
                _ => None,
            },
            SyntheticInput::Generated(_) => None,
        }
    }
}
