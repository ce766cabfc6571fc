//! A model as data, for programs that write their own: `docs/model.md` says what each key holds.
//!
//! Keys stand in alphabetical order, which is the order of the fields here.

use super::head::{RULE, kind};
use super::subject::{Constant, Quantity, RecordNote, Subject};
use crate::format::role_name;
use phisindy_expr::ops::{BINARY, UNARY};
use phisindy_expr::{Graph, Id, Names, Node};
use phisindy_phys::Sensor;
use serde::Serialize;
use std::collections::BTreeMap;

/// Increases with every change that can break a reader.
const SCHEMA_VERSION: u32 = 1;

#[derive(Serialize)]
struct ModelOut<'a> {
    constants: Vec<ConstantOut<'a>>,
    contacts: Vec<ContactOut<'a>>,
    inputs: Vec<InputOut<'a>>,
    operations: BTreeMap<&'a str, &'a str>,
    outputs: Vec<OutputOut<'a>>,
    rates: Vec<RateOut<'a>>,
    record: usize,
    records: Vec<RecordOut<'a>>,
    rule: String,
    schema: &'a str,
    schema_version: u32,
    spec: &'a str,
    states: Vec<QuantityOut<'a>>,
    time: QuantityOut<'a>,
    title: &'a str,
    version: &'a str,
}

#[derive(Serialize)]
struct QuantityOut<'a> {
    name: &'a str,
    unit: &'a str,
}

#[derive(Serialize)]
struct ConstantOut<'a> {
    name: &'a str,
    unit: &'a str,
    value: f64,
}

#[derive(Serialize)]
struct ContactOut<'a> {
    can_stick: bool,
    shaped: bool,
    tree: Vec<NodeOut<'a>>,
    velocity: &'a str,
}

#[derive(Serialize)]
struct InputOut<'a> {
    interpolation: &'a str,
    name: &'a str,
    unit: &'a str,
}

#[derive(Serialize)]
struct OutputOut<'a> {
    latex: String,
    name: &'a str,
    text: String,
    tree: Vec<NodeOut<'a>>,
    unit: &'a str,
}

#[derive(Serialize)]
struct RateOut<'a> {
    latex: String,
    state: &'a str,
    text: String,
    tree: Vec<NodeOut<'a>>,
}

#[derive(Serialize)]
struct RecordOut<'a> {
    constants: BTreeMap<&'a str, f64>,
    name: &'a str,
    role: &'a str,
    sensors: BTreeMap<&'a str, SensorOut>,
    start: BTreeMap<&'a str, Option<f64>>,
    start_time: Option<f64>,
}

#[derive(Serialize)]
struct SensorOut {
    #[serde(skip_serializing_if = "Option::is_none")]
    clock: Option<f64>,
    delay: f64,
    gain: f64,
    offset: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    since: Option<f64>,
}

/// A node of an expression; `args` are indices into the list of nodes.
#[derive(Serialize)]
#[serde(untagged)]
enum NodeOut<'a> {
    Number { number: f64 },
    Name { name: &'a str },
    Operation { args: Vec<usize>, op: &'a str },
}

/// The text, indented, with an end of line.
pub(crate) fn written(subject: &Subject) -> String {
    // This cannot fail: all keys are strings, and every number is finite.
    serde_json::to_string_pretty(&model(subject)).unwrap_or_default() + "\n"
}

fn model(subject: &Subject) -> ModelOut<'_> {
    let inputs = subject.inputs.iter().zip(&subject.interpolation);
    let rates = subject.states.iter().zip(&subject.model.rates);
    let contacts = subject.switched.switches.iter().zip(&subject.switched.surfaces);
    let unary = UNARY.iter().map(|r| (named(r.name), r.about));
    ModelOut {
        constants: subject.constants.iter().map(constant).collect(),
        contacts: contacts
            .map(|(switch, &w)| ContactOut {
                can_stick: switch.can_stick,
                shaped: switch.shaped,
                tree: tree(&subject.switched.graph, &subject.switched.names, w),
                velocity: &switch.text,
            })
            .collect(),
        inputs: inputs
            .map(|(q, i)| InputOut { interpolation: kind(*i), name: &q.name, unit: &q.unit })
            .collect(),
        operations: unary.chain(BINARY.iter().map(|r| (r.name, r.about))).collect(),
        outputs: subject.outputs.iter().map(|q| output(subject, q)).collect(),
        rates: rates
            .map(|(q, &rate)| RateOut {
                latex: subject.model.graph.latex(rate, &subject.model.names),
                state: &q.name,
                text: subject.model.text(rate),
                tree: tree(&subject.model.graph, &subject.model.names, rate),
            })
            .collect(),
        record: subject.record,
        records: subject.records.iter().map(|r| record(r, &subject.states)).collect(),
        rule: RULE.join(" "),
        schema: "phisindy-model",
        schema_version: SCHEMA_VERSION,
        spec: &subject.spec,
        states: subject.states.iter().map(|q| QuantityOut { name: &q.name, unit: &q.unit }).collect(),
        time: QuantityOut { name: "t", unit: "s" },
        title: &subject.title,
        version: env!("CARGO_PKG_VERSION"),
    }
}

fn output<'a>(subject: &'a Subject, q: &'a Quantity) -> OutputOut<'a> {
    let (graph, names) = (&subject.model.graph, &subject.model.names);
    OutputOut {
        latex: graph.latex(q.node, names),
        name: &q.name,
        text: subject.model.text(q.node),
        tree: tree(graph, names, q.node),
        unit: &q.unit,
    }
}

fn constant(c: &Constant) -> ConstantOut<'_> {
    ConstantOut { name: &c.name, unit: &c.unit, value: c.value }
}

fn record<'a>(r: &'a RecordNote, states: &'a [Quantity]) -> RecordOut<'a> {
    RecordOut {
        constants: r.constants.iter().map(|(name, value)| (name.as_str(), *value)).collect(),
        name: &r.name,
        role: role_name(r.role),
        sensors: r.sensors.iter().map(|(name, s)| (name.as_str(), sensor(s))).collect(),
        start: states.iter().zip(&r.start).map(|(q, x)| (q.name.as_str(), *x)).collect(),
        start_time: r.start_time,
    }
}

fn sensor(s: &Sensor) -> SensorOut {
    let [offset, gain, _, clock, _] = s.parameters().map(|p| p.start);
    let since = (clock != 0.0).then_some(s.since);
    let delay = s.lateness();
    SensorOut { clock: since.map(|_| clock), delay, gain, offset, since }
}

/// The name of an operation; negation has no name in the language of specs.
fn named(operation: &'static str) -> &'static str {
    if operation.is_empty() { "neg" } else { operation }
}

/// An expression as a list, operands before operations and the root last, so that readers need no recursion.
fn tree<'a>(graph: &Graph, names: &'a Names, root: Id) -> Vec<NodeOut<'a>> {
    let order = graph.reachable(&[root]);
    let place = |id: Id| order.binary_search(&id).unwrap_or_default();
    let node = |&id: &Id| match graph.node(id) {
        Node::Constant(bits) => NodeOut::Number { number: f64::from_bits(bits) },
        Node::Symbol(symbol) => NodeOut::Name { name: names.name(symbol) },
        Node::Unary(op, a) => NodeOut::Operation { args: vec![place(a)], op: named(op.row().name) },
        Node::Binary(op, a, b) => NodeOut::Operation { args: vec![place(a), place(b)], op: op.row().name },
    };
    order.iter().map(node).collect()
}
