//! What a record will be: its columns, constants, sensors; how synthetic data are made. Checked against the system.

use crate::system::check::Checker;
use crate::system::constants::{Value, record_constants};
use crate::system::equations::System;
use crate::system::model::Model;
use crate::system::sensor::{Sensor, SensorParameter};
use crate::text::spec::{
    CsvSpec, DataSpec, DeriveSpec, InputSpec, NoiseSpec, Role, SensorSpec, SensorValue, Spec, SyntheticSpec,
    Text,
};
use phisindy_expr::Id;
use phisindy_signal::{Differentiator, Interpolation};
use std::collections::HashMap;

/// What all records have.
#[derive(Clone, Debug)]
pub struct RecordPlan {
    /// Shown to the user.
    pub name: String,
    /// Fitted or only predicted.
    pub role: Role,
    /// One for each of [`System::record_constants`].
    pub constants: Vec<Value>,
    /// One for each state, then one for each input.
    pub sensors: Vec<Sensor>,
    /// For each input, the input whose derivative it is.
    pub derived: Vec<Option<usize>>,
    /// For each input, how it is derived if it is.
    pub differentiators: Vec<Differentiator>,
    /// For each input.
    pub interpolation: Vec<Interpolation>,
    /// Start values that the spec states.
    pub start: Vec<Option<f64>>,
    /// Where it comes from.
    pub origin: Origin,
}

/// Where a record comes from.
#[derive(Clone, Debug)]
pub enum Origin {
    /// A file: read by the program, then [`crate::Record::from_table`].
    Csv(Box<CsvSpec>),
    /// Simulated from a truth.
    Synthetic(Box<Synthetic>),
}

/// How synthetic data are made.
#[derive(Clone, Debug)]
pub struct Synthetic {
    /// The known rates plus the truth; parameters are the record constants. Inputs given by formulas are replaced by them.
    pub truth: Model,
    /// The truth's extra rate of each state alone.
    pub extra: Vec<Id>,
    /// For each input.
    pub inputs: Vec<SyntheticInput>,
    /// Start state (SI).
    pub start: Vec<f64>,
    /// Seconds.
    pub duration: f64,
    /// Seconds between samples.
    pub step: f64,
    /// As in the spec.
    pub noise: NoiseSpec,
    /// As in the spec.
    pub seed: u64,
    /// Which states are recorded.
    pub measured_states: Vec<bool>,
    /// Which inputs are recorded with noise (others are known exactly).
    pub measured_inputs: Vec<bool>,
    /// The part of the run that the record shows.
    pub window: Option<(f64, f64)>,
}

/// An input of a synthetic record.
#[derive(Clone, Debug)]
pub enum SyntheticInput {
    /// An expression of time (and record constants).
    Formula(Id),
    /// Multisine, Jonswap, file: made by the simulator.
    Generated(InputSpec),
    /// The derivative of another input.
    Derivative(usize),
}

/// Plans every record of a spec.
pub(crate) fn plan_records(checker: &mut Checker, spec: &Spec, system: &System) -> Vec<RecordPlan> {
    let mut plans = Vec::new();
    for (k, data) in spec.data.iter().enumerate() {
        let plan = match data {
            DataSpec::Csv(csv) => checker.csv(csv, spec, system),
            DataSpec::Synthetic(synthetic) => checker.synthetic(k, synthetic, spec, system),
        };
        plans.extend(plan);
    }
    plans
}

impl Checker {
    fn record_constants(&mut self, data: &DataSpec, spec: &Spec, system: &System, name: &Text) -> Vec<Value> {
        let mut values = Vec::new();
        for (constant, _) in &system.record_constants {
            let own = record_constants(data).iter().find(|(n, _)| n.value == *constant);
            let value = match own {
                Some((name, c)) => self.record_value(name, c, spec),
                None => self.constants.defaults.get(constant).cloned(),
            };
            if value.is_none() && own.is_none() {
                self.error(format!("this record has no value for constant `{constant}`"), name.span, "")
                    .help
                    .push(format!("add `constants: {{ \"{constant}\": ... }}` to it"));
            }
            values.push(value.unwrap_or(Value::Number(1.0)));
        }
        values
    }

    /// The sensors of a record, in which `derived` inputs have those of the inputs that they are derived from.
    fn sensors(
        &mut self,
        sensors: &[(Text, SensorSpec)],
        derived: &[Option<usize>],
        system: &System,
    ) -> Vec<Sensor> {
        let mut all = vec![Sensor::default(); system.states.len() + system.inputs.len()];
        for (name, sensor) in sensors {
            let index =
                system.state(&name.value).or(system.input(&name.value).map(|u| u + system.states.len()));
            let Some(index) = index else {
                self.unknown_name(&name.value, name.span, "column in `sensors`", &quantity_names(system));
                continue;
            };
            let slots = [(&sensor.offset, 0), (&sensor.gain, 1), (&sensor.delay, 2)];
            for (value, which) in slots {
                let Some(value) = value else { continue };
                let parameter = match value {
                    SensorValue::Number(x) => SensorParameter::held(x.value),
                    SensorValue::Constant(name) => match self.sensor_constant(name, system) {
                        Some(parameter) => parameter,
                        None => continue,
                    },
                    SensorValue::Find(f) => {
                        let factor = f.unit.as_ref().map_or(1.0, |u| self.unit(u).factor);
                        let within = Some((self.si(&f.within.0, factor), self.si(&f.within.1, factor)));
                        SensorParameter {
                            start: self.si(&f.start, factor),
                            within,
                            sigma: f.sigma.as_ref().map(|s| self.si(s, factor)),
                            shared: None,
                        }
                    }
                };
                let target = &mut all[index];
                *[&mut target.offset, &mut target.gain, &mut target.delay]
                    .into_iter()
                    .nth(which)
                    .expect("three sensor parameters") = parameter;
            }
        }
        let n = system.states.len();
        for (k, of) in derived.iter().enumerate().filter_map(|(k, of)| Some((k, (*of)?))) {
            // A zero error has no derivative.
            all[n + k] =
                Sensor { offset: SensorParameter::held(0.0), follows: Some(of), ..all[n + of].clone() };
        }
        all
    }

    /// A sensor parameter that is a constant of the case.
    fn sensor_constant(&mut self, name: &Text, system: &System) -> Option<SensorParameter> {
        self.used.insert(name.value.clone());
        if let Some((_, value)) = system.constants.iter().find(|(n, _)| *n == name.value) {
            return Some(SensorParameter::held(*value));
        }
        let Some(shared) = system.parameters.iter().position(|p| p.name == name.value) else {
            let names: Vec<&str> = system
                .constants
                .iter()
                .map(|(n, _)| n.as_str())
                .chain(system.parameters.iter().map(|p| p.name.as_str()))
                .collect();
            self.unknown_name(&name.value, name.span, "constant", &names);
            return None;
        };
        let p = &system.parameters[shared];
        Some(SensorParameter { start: p.start, within: Some(p.within), sigma: None, shared: Some(shared) })
    }

    /// For each input, what it is derived from, and how.
    fn derived(
        &mut self,
        derive: &[(Text, DeriveSpec)],
        system: &System,
    ) -> (Vec<Option<usize>>, Vec<Differentiator>) {
        let names: Vec<&str> = system.inputs.iter().map(|u| u.name.as_str()).collect();
        let mut derived = vec![None; names.len()];
        let mut differentiators = vec![Differentiator::default(); names.len()];
        for (name, DeriveSpec::Derivative(of, how)) in derive {
            match (system.input(&name.value), system.input(&of.value)) {
                (Some(k), Some(u)) if k != u => {
                    (derived[k], differentiators[k]) = (Some(u), how.unwrap_or_default());
                }
                (Some(_), Some(_)) => {
                    self.error(format!("`{}` cannot be its own derivative", name.value), of.span, "");
                }
                (None, _) => self.unknown_name(&name.value, name.span, "input in `derive`", &names),
                (_, None) => self.unknown_name(&of.value, of.span, "input", &names),
            }
        }
        (derived, differentiators)
    }

    fn interpolation(&mut self, given: &[(Text, Interpolation)], system: &System) -> Vec<Interpolation> {
        let mut all = vec![Interpolation::Cubic; system.inputs.len()];
        for (name, kind) in given {
            match system.input(&name.value) {
                Some(k) => all[k] = *kind,
                None => {
                    let names: Vec<&str> = system.inputs.iter().map(|u| u.name.as_str()).collect();
                    self.unknown_name(&name.value, name.span, "input in `interpolate`", &names);
                }
            }
        }
        all
    }

    fn start(&mut self, given: &[(Text, crate::text::spec::Number)], system: &System) -> Vec<Option<f64>> {
        let mut start = vec![None; system.states.len()];
        let names: Vec<&str> = system.states.iter().map(|s| s.name.as_str()).collect();
        for (name, value) in given {
            match system.state(&name.value) {
                Some(k) => start[k] = Some(self.si(value, system.states[k].factor)),
                None => self.unknown_name(&name.value, name.span, "state in `start`", &names),
            }
        }
        start
    }

    fn csv(&mut self, csv: &CsvSpec, spec: &Spec, system: &System) -> Option<RecordPlan> {
        let errors = self.diagnostics.len();
        let path = std::path::Path::new(&csv.path.value);
        let plain = path
            .components()
            .all(|c| matches!(c, std::path::Component::Normal(_) | std::path::Component::CurDir));
        if !plain || csv.path.value.contains('\\') {
            self.error(format!("`{}` leads out of the data folder", csv.path.value), csv.path.span, "")
                .help
                .push("name the file alone, and its folder with --data".into());
        }
        let names = quantity_names(system);
        for (name, column) in &csv.columns {
            if !names.contains(&name.value.as_str()) {
                self.unknown_name(&name.value, name.span, "state or input in `columns`", &names);
                continue;
            }
            let own = system
                .states
                .iter()
                .map(|s| (&s.name, &s.unit))
                .chain(system.inputs.iter().map(|u| (&u.name, &u.unit)));
            let own: HashMap<&String, &String> = own.collect();
            if let Some(unit) = &column.unit {
                let theirs = self.unit(unit);
                let ours = crate::units::unit::Unit::parse(own[&name.value])
                    .unwrap_or(crate::units::unit::Unit::ONE);
                if theirs.dimension != ours.dimension {
                    let message = format!(
                        "`{}` cannot be converted to `{}`, the unit of `{}`",
                        unit.value, own[&name.value], name.value
                    );
                    let help = format!(
                        "`(header, unit)` says in which unit the file's numbers stand: give one of `{}`, or another column",
                        own[&name.value]
                    );
                    self.error(message, unit.span, "").help.push(help);
                }
            }
        }
        if !csv.columns.iter().any(|(n, _)| system.state(&n.value).is_some()) {
            self.error("no column measures a state, so there is nothing to fit", csv.path.span, "")
                .help
                .push(format!("give at least one of {} a column", names[..system.states.len()].join(", ")));
        }
        let (derived, differentiators) = self.derived(&csv.derive, system);
        for (k, input) in system.inputs.iter().enumerate() {
            if derived[k].is_none() && !csv.columns.iter().any(|(n, _)| n.value == input.name) {
                self.error(format!("input `{}` has neither a column nor a derivation in this record", input.name), csv.path.span, "")
                    .help
                    .push(format!("add `\"{0}\": (\"header\", \"{1}\")` to `columns`, or `derive: {{ \"{0}\": Derivative(...) }}`", input.name, input.unit));
            }
        }
        let measured = |k: usize| csv.columns.iter().any(|(n, _)| n.value == system.inputs[k].name);
        let unmeasured: Vec<_> =
            derived.iter().enumerate().map(|(k, of)| of.filter(|_| !measured(k))).collect();
        let constants = self.record_constants(&DataSpec::Csv(Box::new(csv.clone())), spec, system, &csv.path);
        let plan = RecordPlan {
            name: csv.name.as_ref().map_or(csv.path.value.clone(), |n| n.value.clone()),
            role: csv.role,
            constants,
            sensors: self.sensors(&csv.sensors, &unmeasured, system),
            derived,
            differentiators,
            interpolation: self.interpolation(&csv.interpolate, system),
            start: self.start(&csv.start, system),
            origin: Origin::Csv(Box::new(csv.clone())),
        };
        (self.diagnostics.len() == errors).then_some(plan)
    }

    fn synthetic(
        &mut self,
        index: usize,
        data: &SyntheticSpec,
        spec: &Spec,
        system: &System,
    ) -> Option<RecordPlan> {
        let errors = self.diagnostics.iter().filter(|d| d.is_error()).count();
        let mut allowed: Vec<&str> = vec!["t"];
        allowed.extend(system.states.iter().map(|s| s.name.as_str()));
        allowed.extend(system.inputs.iter().map(|u| u.name.as_str()));
        let zero = self.graph.constant(0.0);
        let mut extra = vec![zero; system.states.len()];
        let state_names: Vec<&str> = system.states.iter().map(|s| s.name.as_str()).collect();
        for (name, text) in &data.truth {
            match system.state(&name.value) {
                Some(k) => extra[k] = self.expression(text, &allowed).unwrap_or(zero),
                None => self.unknown_name(&name.value, name.span, "state in `truth`", &state_names),
            }
        }
        let (derived, differentiators) = self.derived(&data.derive, system);
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
        let start = self.start(&data.start, system);
        let (measured_states, measured_inputs) = self.measured(data, system);
        let title = Text { value: format!("record {index}"), span: data.span };
        let own = |k: usize| data.inputs.iter().any(|(n, _)| n.value == system.inputs[k].name);
        let unexcited: Vec<_> = derived.iter().enumerate().map(|(k, of)| of.filter(|_| !own(k))).collect();
        let constants =
            self.record_constants(&DataSpec::Synthetic(Box::new(data.clone())), spec, system, &title);
        let truth = self.truth_model(system, &extra, &inputs);
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
                start: start.into_iter().map(|x| x.unwrap_or(0.0)).collect(),
                duration: data.duration.value,
                step: data.step.value,
                noise: data.noise.clone(),
                seed: data.seed.unwrap_or(0),
                measured_states,
                measured_inputs,
                window: data.window.as_ref().map(|w| (w.0.value, w.1.value)),
            })),
        };
        (self.diagnostics.iter().filter(|d| d.is_error()).count() == errors).then_some(plan)
    }

    fn measured(&mut self, data: &SyntheticSpec, system: &System) -> (Vec<bool>, Vec<bool>) {
        let Some(list) = &data.measure else {
            return (vec![true; system.states.len()], vec![false; system.inputs.len()]);
        };
        let (mut states, mut inputs) = (vec![false; system.states.len()], vec![false; system.inputs.len()]);
        for name in list {
            match (system.state(&name.value), system.input(&name.value)) {
                (Some(k), _) => states[k] = true,
                (_, Some(k)) => inputs[k] = true,
                _ => self.unknown_name(
                    &name.value,
                    name.span,
                    "state or input in `measure`",
                    &quantity_names(system),
                ),
            }
        }
        if !states.contains(&true) {
            self.error("no state is measured, so there is nothing to fit", data.span, "");
        }
        (states, inputs)
    }

    /// Known rates plus truth, formulas in the place of inputs, movable constants at their nominal values.
    fn truth_model(&mut self, system: &System, extra: &[Id], inputs: &[SyntheticInput]) -> Model {
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
        let sums: Vec<Id> = system.known.iter().zip(extra).map(|(&g, &f)| self.graph.add(g, f)).collect();
        let rates = self.graph.replace(&sums, &with);
        Model {
            graph: self.graph.clone(),
            names: self.names.clone(),
            time: system.time,
            states: system.states.iter().map(|s| s.node).collect(),
            inputs: system.inputs.iter().map(|u| u.node).collect(),
            parameters: system.record_constants.iter().map(|&(_, node)| node).collect(),
            rates,
        }
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

fn quantity_names(system: &System) -> Vec<&str> {
    system
        .states
        .iter()
        .map(|s| s.name.as_str())
        .chain(system.inputs.iter().map(|u| u.name.as_str()))
        .collect()
}
