//! The table of constants: what replaces each in expressions, and which of them come with each record.

use phisindy_expr::{Graph, Id};
use std::collections::HashMap;

/// Where the value of a record constant comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number (SI).
    Number(f64),
    /// The largest absolute value of a generated input, by its index.
    MaxAbs(usize),
}

impl Value {
    /// The number, where it is one.
    pub(crate) fn number(&self) -> Option<f64> {
        if let Value::Number(x) = self { Some(*x) } else { None }
    }
}

/// All constants of a spec.
#[derive(Clone, Debug, Default)]
pub(crate) struct Constants {
    order: Vec<String>,
    /// What replaces each symbol: a number, or an expression of what may move.
    fold: HashMap<Id, Id>,
    fixed: Vec<(String, f64)>,
    records: Vec<(String, Id)>,
    /// Values of record constants for records that do not say.
    defaults: HashMap<String, Value>,
}

impl Constants {
    pub(crate) fn declare(&mut self, name: &str) {
        self.order.push(name.to_owned());
    }

    /// A constant whose value comes with each record.
    pub(crate) fn declare_of_records(&mut self, name: &str, node: Id) {
        self.records.push((name.to_owned(), node));
    }

    /// The value of a record constant for records that do not say.
    pub(crate) fn set_default(&mut self, name: &str, value: Value) {
        self.defaults.insert(name.to_owned(), value);
    }

    pub(crate) fn default_of(&self, name: &str) -> Option<&Value> {
        self.defaults.get(name)
    }

    /// A constant that is `value`, whose node in the graph is `number`.
    pub(crate) fn fix(&mut self, name: &str, node: Id, number: Id, value: f64) {
        self.fold.insert(node, number);
        self.fixed.push((name.to_owned(), value));
    }

    /// A constant that is an expression of constants that may move.
    pub(crate) fn replace(&mut self, node: Id, expression: Id) {
        self.fold.insert(node, expression);
    }

    pub(crate) fn knows(&self, name: &str) -> bool {
        self.order.iter().any(|n| n == name)
    }

    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.order.iter().map(String::as_str)
    }

    pub(crate) fn folded(&self, graph: &mut Graph, root: Id) -> Id {
        graph.replace(&[root], &self.fold)[0]
    }

    pub(crate) fn of_records(&self) -> Vec<(String, Id)> {
        self.records.clone()
    }

    pub(crate) fn fixed(&self) -> Vec<(String, f64)> {
        self.fixed.clone()
    }
}
