//! A model as data, for programs that write their own: `docs/model.md` says what each key holds.

use super::head::{RULE, kind};
use super::subject::{Quantity, Subject};
use crate::format::role_name;
use phisindy_expr::ops::{BINARY, UNARY};
use phisindy_expr::{Id, Node};
use phisindy_phys::Sensor;
use serde_json::{Map, Value, json};

/// Changes with every change of the form that a reader could stumble over.
const SCHEMA_VERSION: u32 = 1;

/// The text: indented, a line at the end.
pub(crate) fn written(subject: &Subject) -> String {
    let quantity = |q: &Quantity| json!({ "name": q.name, "unit": q.unit });
    let inputs = subject
        .inputs
        .iter()
        .zip(&subject.interpolation)
        .map(|(q, i)| json!({ "name": q.name, "unit": q.unit, "interpolation": kind(*i) }));
    let constants =
        subject.constants.iter().map(|c| json!({ "name": c.name, "value": c.value, "unit": c.unit }));
    let rates = subject.states.iter().zip(&subject.model.rates).map(|(q, &rate)| {
        json!({
            "state": q.name,
            "text": subject.model.text(rate),
            "latex": subject.model.graph.latex(rate, &subject.model.names),
            "tree": tree(subject, rate),
        })
    });
    let contacts = subject.switched.switches.iter().zip(&subject.switched.surfaces).map(|(switch, &w)| {
        json!({
            "velocity": switch.text,
            "tree": tree_in(&subject.switched.graph, &subject.switched.names, w),
            "can_stick": switch.can_stick,
            "shaped": switch.shaped,
        })
    });
    let records = subject.records.iter().map(|r| {
        let start: Map<String, Value> = named(subject.states.iter().map(|q| &q.name).zip(&r.start));
        let sensors: Map<String, Value> =
            r.sensors.iter().map(|(name, s)| (name.clone(), sensor(s))).collect();
        json!({
            "name": r.name,
            "role": role_name(r.role),
            "start_time": r.start_time,
            "start": start,
            "constants": named(r.constants.iter().map(|(name, value)| (name, value))),
            "sensors": sensors,
        })
    });
    let operations: Map<String, Value> = UNARY
        .iter()
        .map(|r| (if r.name.is_empty() { "neg" } else { r.name }, r.about))
        .chain(BINARY.iter().map(|r| (r.name, r.about)))
        .map(|(name, about)| (name.to_owned(), json!(about)))
        .collect();
    let model = json!({
        "schema": "phisindy-model",
        "schema_version": SCHEMA_VERSION,
        "version": env!("CARGO_PKG_VERSION"),
        "title": subject.title,
        "spec": subject.spec,
        "time": { "name": "t", "unit": "s" },
        "states": subject.states.iter().map(quantity).collect::<Vec<_>>(),
        "inputs": inputs.collect::<Vec<_>>(),
        "constants": constants.collect::<Vec<_>>(),
        "rates": rates.collect::<Vec<_>>(),
        "contacts": contacts.collect::<Vec<_>>(),
        "rule": RULE.join(" "),
        "record": subject.record,
        "records": records.collect::<Vec<_>>(),
        "operations": operations,
    });
    // Nothing in there can fail: keys are texts, and every number is finite.
    serde_json::to_string_pretty(&model).unwrap_or_default() + "\n"
}

fn named<'a, T: serde::Serialize + 'a>(
    pairs: impl Iterator<Item = (&'a String, &'a T)>,
) -> Map<String, Value> {
    pairs.map(|(name, value)| (name.clone(), json!(value))).collect()
}

fn sensor(s: &Sensor) -> Value {
    json!({ "offset": s.offset.start, "gain": s.gain.start, "delay": s.delay.start })
}

fn tree(subject: &Subject, root: Id) -> Value {
    tree_in(&subject.model.graph, &subject.model.names, root)
}

/// The tree of an expression as a list, operands before operations and the root last: no reader's stack is too small for it.
fn tree_in(graph: &phisindy_expr::Graph, names: &phisindy_expr::Names, root: Id) -> Value {
    let order = graph.reachable(&[root]);
    let place = |id: Id| order.binary_search(&id).unwrap_or_default();
    let node = |&id: &Id| match graph.node(id) {
        Node::Constant(bits) => json!({ "number": f64::from_bits(bits) }),
        Node::Symbol(symbol) => json!({ "name": names.name(symbol) }),
        Node::Unary(op, a) => {
            let name = op.row().name;
            json!({ "op": if name.is_empty() { "neg" } else { name }, "args": [place(a)] })
        }
        Node::Binary(op, a, b) => json!({ "op": op.row().name, "args": [place(a), place(b)] }),
    };
    Value::Array(order.iter().map(node).collect())
}
