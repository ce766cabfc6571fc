//! The exported model: no unknown part, constants as parameters, and the start states of its records.

use phisindy_expr::{Id, parse};
use phisindy_phys::spec::{ConstantSpec, DataSpec, Movable, Number, Role, Spec, Text};
use phisindy_phys::unit::Unit;
use phisindy_phys::{Case, Diagnostic, Model, Origin, Sensor, SourceId, System, Value, check_names};
use phisindy_signal::Interpolation;
use phisindy_sim::Switched;
use std::collections::HashSet;

/// A state, an input or an output.
pub(crate) struct Quantity {
    pub(crate) name: String,
    /// SI.
    pub(crate) unit: String,
    pub(crate) node: Id,
}

/// A constant of the model that a user of the export may change.
pub(crate) struct Constant {
    pub(crate) name: String,
    /// SI.
    pub(crate) value: f64,
    /// SI; empty if the spec states none.
    pub(crate) unit: String,
    pub(crate) node: Id,
}

/// A record without its samples.
pub(crate) struct RecordNote {
    pub(crate) name: String,
    pub(crate) role: Role,
    /// Time of the start state in seconds; `None` for the first sample.
    pub(crate) start_time: Option<f64>,
    /// Start state in SI; `None` where the spec does not state it.
    pub(crate) start: Vec<Option<f64>>,
    /// Constants of the record, SI.
    pub(crate) constants: Vec<(String, f64)>,
    /// Sensors of columns that do not read their quantity directly.
    pub(crate) sensors: Vec<(String, Sensor)>,
}

/// What is known of the motion of the chosen record, SI.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// The first time.
    pub from: f64,
    /// The last time.
    pub to: f64,
    /// The mean distance of the samples; 0 of a single one.
    pub step: f64,
    /// Each state at the first time, as its column reads it.
    pub first: Vec<f64>,
    /// The largest absolute value of each state.
    pub sizes: Vec<f64>,
}

/// An exported model; all numbers in SI.
pub struct Subject {
    pub(crate) title: String,
    /// Path of the spec.
    pub(crate) spec: String,
    pub(crate) states: Vec<Quantity>,
    pub(crate) inputs: Vec<Quantity>,
    /// What sensors read beside the states; the nodes are those of the model.
    pub(crate) outputs: Vec<Quantity>,
    /// One for each input.
    pub(crate) interpolation: Vec<Interpolation>,
    pub(crate) constants: Vec<Constant>,
    pub(crate) model: Model,
    pub(crate) switched: Switched,
    pub(crate) records: Vec<RecordNote>,
    /// The record whose start state and constants are written.
    pub(crate) record: usize,
    /// The motion of that record, where it could be simulated.
    pub experiment: Option<Experiment>,
}

impl Subject {
    /// The model of a checked spec for one of its records. `record_constants` are the constants of all
    /// records, needed if [`uses_largest_input`] holds.
    ///
    /// # Errors
    /// Diagnostics. They are mistakes of this program, for the spec was checked.
    ///
    /// # Panics
    /// `record` is not one of the case's records.
    pub fn new(
        mut spec: Spec,
        case: &Case,
        name: &str,
        record: usize,
        record_constants: Option<&[Vec<f64>]>,
    ) -> Result<Subject, Vec<Diagnostic>> {
        let records = notes(case, record_constants);
        let interpolation = case.records[record].interpolation.clone();
        freed(&mut spec);
        without_filters(&mut spec);
        // The caller has checked the dimensions with the constants as written.
        let (case, _) = check_names(&spec, SourceId(0))?;
        let system = case.system;
        let model = system.model(&[]);
        let constants = constants(&system, &model, &records[record], &spec);
        let switched = Switched::new(&model);
        let states = system.states.iter().map(|s| quantity(&s.name, &s.unit, s.node)).collect();
        let inputs = system.inputs.iter().map(|u| quantity(&u.name, &u.unit, u.node)).collect();
        let read = system.outputs.iter().zip(&model.outputs);
        let outputs = read.map(|(o, &node)| quantity(&o.name, &o.unit, node)).collect();
        let title = system.title;
        Ok(Subject {
            title,
            spec: name.to_owned(),
            states,
            inputs,
            outputs,
            interpolation,
            constants,
            model,
            switched,
            records,
            record,
            experiment: None,
        })
    }

    /// The names of the states.
    pub fn states(&self) -> impl Iterator<Item = &str> {
        self.states.iter().map(|q| q.name.as_str())
    }

    /// The record whose start state and constants are written.
    pub(crate) fn chosen(&self) -> &RecordNote {
        &self.records[self.record]
    }

    /// Every name that an exported text may contain.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> + Clone {
        let quantities = self.states.iter().chain(&self.inputs).chain(&self.outputs).map(|q| q.name.as_str());
        quantities.chain(self.constants.iter().map(|c| c.name.as_str()))
    }

    /// Nodes that vary during a simulation.
    pub(crate) fn moving(&self) -> Vec<Id> {
        let s = &self.switched;
        let own = self.states.iter().chain(&self.inputs).map(|q| q.node).chain([self.model.time]);
        own.chain([&s.slopes, &s.modes, &s.sides, &s.floors, &s.margins].into_iter().flatten().copied())
            .collect()
    }
}

fn quantity(name: &str, unit: &str, node: Id) -> Quantity {
    Quantity { name: name.to_owned(), unit: si(unit), node }
}

/// The SI unit of a unit's dimension; the unit itself if it is one.
fn si(unit: &str) -> String {
    match Unit::parse(unit) {
        Ok(parsed) if parsed.factor != 1.0 => parsed.dimension.to_string(),
        _ => unit.to_owned(),
    }
}

/// Makes every named number movable, so that expressions keep its name. Numbers that constants of records are
/// computed from must stay numbers.
fn freed(spec: &mut Spec) {
    let mut held: Vec<String> = Vec::new();
    for data in &spec.data {
        let own = match data {
            DataSpec::Csv(csv) => &csv.constants,
            DataSpec::Synthetic(synthetic) => &synthetic.constants,
        };
        own.iter().for_each(|(_, constant)| held.extend(names_in(constant)));
    }
    let mut seen: HashSet<String> = HashSet::new();
    while let Some(name) = held.pop() {
        if seen.insert(name.clone())
            && let Some((_, constant)) = spec.constants.iter().find(|(n, _)| n.value == name)
        {
            held.extend(names_in(constant));
        }
    }
    for (name, constant) in &mut spec.constants {
        if let (ConstantSpec::Number { value, unit }, false) = (&*constant, seen.contains(&name.value)) {
            let bound = |by: f64| Number { value: value.value + by, span: value.span };
            *constant = ConstantSpec::Movable(Movable {
                value: value.clone(),
                unit: unit.clone(),
                within: (bound(-1.0), bound(1.0)),
                sigma: None,
                each: false,
                span: value.span,
            });
        }
    }
}

/// Takes the filters of sensors out: the exported model is that of the rig, and tells what outputs read.
fn without_filters(spec: &mut Spec) {
    let states: Vec<String> = spec.states.iter().map(|(name, _)| name.value.clone()).collect();
    for data in &mut spec.data {
        let (sensors, start) = match data {
            DataSpec::Csv(csv) => (&mut csv.sensors, &mut csv.start),
            DataSpec::Synthetic(synthetic) => (&mut synthetic.sensors, &mut synthetic.start),
        };
        sensors.iter_mut().for_each(|(_, sensor)| (sensor.lowpass, sensor.highpass) = (None, None));
        start.retain(|(name, _)| states.contains(&name.value));
    }
}

fn names_in(constant: &ConstantSpec) -> Vec<String> {
    let ConstantSpec::Expression(Text { value, .. }) = constant else { return vec![] };
    parse(value).map(|ast| ast.names().map(|(name, _)| name.to_owned()).collect()).unwrap_or_default()
}

/// Whether a constant of a record is the largest absolute value of an input, which is known only once the
/// input is generated.
pub fn uses_largest_input(case: &Case) -> bool {
    case.records.iter().flat_map(|r| &r.constants).any(|c| matches!(c, Value::MaxAbs(_)))
}

/// Why a model cannot be exported: it has an unknown part, or states that jump, which the copies of the integrator do not
/// know.
pub fn refusal(spec: &Spec, case: &Case, name: &str, source: SourceId) -> Option<Diagnostic> {
    if case.system.jumps() {
        let what = if case.system.holds() { "`hold`" } else { "`impacts`" };
        let d = Diagnostic::error(format!("a model with {what} cannot be exported: its states jump"));
        let d = match spec.impacts.first().filter(|_| !case.system.holds()) {
            Some((name, _)) => d.at(source, name.span, "here a speed jumps"),
            None => d,
        };
        return Some(d.help("`phisindy simulate` predicts with it; exports know stick and slip alone"));
    }
    if !case.is_open() {
        return None;
    }
    let mut d = Diagnostic::error("the model has an unknown part, so there is nothing to export yet");
    if let Some((name, _)) = spec.unknown.first() {
        d = d.at(source, name.span, "what is missing here is not known");
    }
    Some(d.help(format!("identify it first, `phisindy run {name} --out DIR`, then `phisindy export DIR`")))
}

fn notes(case: &Case, largest: Option<&[Vec<f64>]>) -> Vec<RecordNote> {
    let system = &case.system;
    let note = |(r, plan): (usize, &phisindy_phys::RecordPlan)| {
        let value = |(k, constant): (usize, &Value)| match (constant, largest) {
            (Value::Number(x), _) => Some(*x),
            (Value::MaxAbs(_), Some(all)) => Some(all[r][k]),
            (Value::MaxAbs(_), None) => None,
        };
        let values = plan.constants.iter().enumerate().filter_map(value);
        let (start_time, start) = match &plan.origin {
            Origin::Synthetic(made) => (Some(0.0), made.start.iter().copied().map(Some).collect()),
            Origin::Csv(_) => (None, plan.start.clone()),
        };
        let sensors = plan.sensors.iter().enumerate().filter(|(_, sensor)| **sensor != Sensor::default());
        RecordNote {
            name: plan.name.clone(),
            role: plan.role,
            start_time,
            start,
            constants: system.record_constants.iter().map(|(name, _)| name.clone()).zip(values).collect(),
            sensors: sensors.map(|(k, s)| (system.measured(k).0.to_owned(), s.clone())).collect(),
        }
    };
    case.records.iter().enumerate().map(note).collect()
}

/// The SI unit of a constant of the records, as the first record states it.
fn unit_of(name: &str, spec: &Spec) -> String {
    let own = spec.data.iter().flat_map(|data| match data {
        DataSpec::Csv(csv) => &csv.constants,
        DataSpec::Synthetic(synthetic) => &synthetic.constants,
    });
    let mut stated =
        own.chain(&spec.constants).filter(|(n, _)| n.value == name).filter_map(|(_, c)| match c {
            ConstantSpec::Number { unit, .. } => unit.as_ref(),
            _ => None,
        });
    stated.next().map_or(String::new(), |unit| si(&unit.value))
}

/// The constants that the rates use: those of the spec in its order, then those of the records.
fn constants(system: &System, model: &Model, record: &RecordNote, spec: &Spec) -> Vec<Constant> {
    let movable = system.parameters.iter().map(|p| Constant {
        name: p.name.clone(),
        value: p.start,
        unit: si(&p.unit),
        node: p.node,
    });
    let own = system.record_constants.iter().zip(&record.constants).map(|((name, node), (_, value))| {
        Constant { name: name.clone(), value: *value, unit: unit_of(name, spec), node: *node }
    });
    let roots: Vec<Id> = model.rates.iter().chain(&model.outputs).copied().collect();
    movable.chain(own).filter(|c| model.graph.uses(&roots, &[c.node])).collect()
}
