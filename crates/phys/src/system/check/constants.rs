//! The constants of a spec: numbers, expressions of other constants, movable and unknown ones, and those that
//! come with each record.

use super::checker::Checker;
use crate::system::constants::Value;
use crate::system::equations::Parameter;
use crate::text::spec::{ConstantSpec, DataSpec, Number, Spec, Text};
use phisindy_expr::{Id, parse};

impl Checker {
    /// Declares and evaluates all constants; returns those that may move.
    pub(super) fn gather_constants(&mut self, spec: &Spec) -> Vec<Parameter> {
        let of_records: Vec<&Text> =
            spec.data.iter().flat_map(DataSpec::constants).map(|(name, _)| name).collect();
        let mut parameters = Vec::new();
        let mut pending: Vec<(&Text, &Text)> = Vec::new();
        for (name, constant) in &spec.constants {
            let symbol = self.declare(name, "constant");
            let node = self.graph.symbol(symbol);
            self.constants.declare(&name.value);
            if of_records.iter().any(|n| n.value == name.value) || matches!(constant, ConstantSpec::MaxAbs(_))
            {
                self.constants.declare_of_records(&name.value, node);
                if let Some(value) = self.record_value(name, constant, spec) {
                    self.constants.set_default(&name.value, value);
                }
                continue;
            }
            match constant {
                ConstantSpec::Number { value, unit } => {
                    let factor = unit.as_ref().map_or(1.0, |u| self.unit(u).factor);
                    let value = self.si(value, factor);
                    self.fix(name, node, value);
                }
                ConstantSpec::Movable(m) => {
                    parameters.push(self.parameter(
                        name,
                        node,
                        &m.value,
                        m.unit.as_ref(),
                        &m.within,
                        m.sigma.as_ref(),
                        m.each,
                        true,
                    ));
                }
                ConstantSpec::Find(f) => {
                    parameters.push(self.parameter(
                        name,
                        node,
                        &f.start,
                        f.unit.as_ref(),
                        &f.within,
                        f.sigma.as_ref(),
                        f.each,
                        false,
                    ));
                }
                ConstantSpec::Expression(text) => pending.push((name, text)),
                ConstantSpec::MaxAbs(_) => {}
            }
        }
        for name in of_records {
            if !self.constants.knows(&name.value) {
                let symbol = self.declare(name, "constant");
                let node = self.graph.symbol(symbol);
                self.constants.declare(&name.value);
                self.constants.declare_of_records(&name.value, node);
            }
        }
        self.resolve(pending);
        parameters
    }

    fn fix(&mut self, name: &Text, node: Id, value: f64) {
        let number = self.graph.constant(value);
        self.constants.fix(&name.value, node, number, value);
    }

    #[allow(clippy::too_many_arguments)] // the fields that Movable and Find share
    fn parameter(
        &mut self,
        name: &Text,
        node: Id,
        start: &Number,
        unit: Option<&Text>,
        within: &(Number, Number),
        sigma: Option<&Number>,
        each: bool,
        known: bool,
    ) -> Parameter {
        let factor = unit.map_or(1.0, |u| self.unit(u).factor);
        Parameter {
            name: name.value.clone(),
            unit: unit.map_or(String::new(), |u| u.value.clone()),
            node,
            start: self.si(start, factor),
            within: (self.si(&within.0, factor), self.si(&within.1, factor)),
            sigma: sigma.map(|s| self.si(s, factor)),
            each,
            known,
        }
    }

    /// Resolves constants given by expressions, in any order: each one after all that it names.
    fn resolve(&mut self, mut pending: Vec<(&Text, &Text)>) {
        let names_in = |text: &Text| -> Vec<String> {
            parse(&text.value).map(|ast| ast.names().map(|(n, _)| n.to_owned()).collect()).unwrap_or_default()
        };
        loop {
            let waiting: Vec<String> = pending.iter().map(|(n, _)| n.value.clone()).collect();
            let ready =
                pending.iter().position(|(_, text)| !names_in(text).iter().any(|n| waiting.contains(n)));
            let Some(k) = ready else { break };
            let (name, text) = pending.remove(k);
            let Some(root) = self.expression(text, &[]) else { continue };
            let Some(symbol) = self.names.get(&name.value) else { continue };
            let node = self.graph.symbol(symbol);
            match self.graph.value(root) {
                Some(value) => self.fix(name, node, value),
                None if self.graph.symbols(&[root]).is_empty() => {
                    self.error(format!("constant `{}` is not a finite number", name.value), text.span, "")
                        .help
                        .push(
                            "look for a division by zero, or the root or logarithm of what is not positive"
                                .into(),
                        );
                }
                None => {
                    self.constants.replace(node, root);
                }
            }
        }
        // The remaining constants depend on themselves: follow one cycle to name it.
        if let Some(&(first, text)) = pending.first() {
            let mut circle = vec![first.value.clone()];
            let mut at = text;
            loop {
                let next = names_in(at)
                    .into_iter()
                    .find_map(|n| pending.iter().find(|(p, _)| p.value == n).copied());
                let Some((name, text)) = next else { break };
                if let Some(start) = circle.iter().position(|n| *n == name.value) {
                    circle.drain(..start);
                    circle.push(name.value.clone());
                    break;
                }
                circle.push(name.value.clone());
                at = text;
            }
            let start = pending
                .iter()
                .find(|(n, _)| Some(&n.value) == circle.first())
                .copied()
                .unwrap_or((first, text));
            self.error(
                format!("constants refer to each other in a circle: {}", circle.join(" -> ")),
                start.1.span,
                "",
            )
            .help
            .push("give one of them a number".into());
        }
    }

    /// The value of a constant that belongs to a record.
    pub(super) fn record_value(
        &mut self,
        name: &Text,
        constant: &ConstantSpec,
        spec: &Spec,
    ) -> Option<Value> {
        match constant {
            ConstantSpec::Number { value, unit } => {
                let factor = unit.as_ref().map_or(1.0, |u| self.unit(u).factor);
                Some(Value::Number(self.si(value, factor)))
            }
            ConstantSpec::MaxAbs(input) => {
                let index = spec.inputs.iter().position(|(n, _)| n.value == input.value);
                if index.is_none() {
                    let inputs: Vec<&str> = spec.inputs.iter().map(|(n, _)| n.value.as_str()).collect();
                    self.unknown_name(&input.value, input.span, "input", &inputs);
                }
                index.map(Value::MaxAbs)
            }
            ConstantSpec::Expression(text) => {
                let root = self.expression(text, &[])?;
                let value = self.graph.value(root).map(Value::Number);
                if value.is_none() {
                    self.error(format!("`{}` must be a number in each record", name.value), text.span, "")
                        .help
                        .push("use numbers and fixed constants only".into());
                }
                value
            }
            ConstantSpec::Movable(_) | ConstantSpec::Find(_) => {
                self.error(format!("`{}` cannot move inside a record", name.value), name.span, "")
                    .help
                    .push("declare it in the case's `constants` with `each: true`".into());
                None
            }
        }
    }
}
