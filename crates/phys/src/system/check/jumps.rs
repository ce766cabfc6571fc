//! States that jump: impacts, and what a sampled controller holds.

use super::checker::Checker;
use crate::system::equations::{Parameter, System};
use crate::system::impact::Impact;
use crate::text::spec::{ImpactSpec, SensorValue, Spec, Text};
use phisindy_expr::{Ast, AstKind, Binary, Id, Node};

impl Checker {
    /// The impacts, and their numbers that are to be found.
    pub(super) fn impacts(&mut self, spec: &Spec, allowed: &[&str], system: &mut System) {
        for (name, impact) in &spec.impacts {
            let gap = self.expression(&impact.when, allowed);
            let restitution = self.restitution(name, impact, system);
            let (Some(gap), Some(restitution)) = (gap, restitution) else { continue };
            system.graph.clone_from(&self.graph);
            if self.is_gap(&impact.when, gap, system) {
                let (name, text) = (name.value.clone(), impact.when.value.clone());
                system.impacts.push(Impact { name, text, gap, restitution });
            }
        }
        (system.graph, system.names) = (self.graph.clone(), self.names.clone());
    }

    /// The restitution, which is a number from 0 to 1 whatever the constants are.
    fn restitution(&mut self, name: &Text, impact: &ImpactSpec, system: &mut System) -> Option<Id> {
        let (node, span) = match &impact.restitution {
            SensorValue::Number(number) => (self.graph.constant(number.value), number.span),
            SensorValue::Constant(text) => (self.expression(text, &[])?, text.span),
            SensorValue::Find(find) if find.each => {
                self.error("a restitution has one value for all records", find.span, "")
                    .help
                    .push("declare a constant with `each: true`, and write its name here in quotes".into());
                return None;
            }
            SensorValue::Find(find) => {
                let parameter = format!("{}.restitution", name.value);
                let symbol = self.names.intern(&parameter);
                let node = self.graph.symbol(symbol);
                system.parameters.push(Parameter {
                    name: parameter,
                    unit: String::new(),
                    node,
                    start: find.start.value,
                    within: (find.within.0.value, find.within.1.value),
                    sigma: find.sigma.as_ref().map(|s| s.value),
                    each: false,
                    known: false,
                });
                (node, find.span)
            }
        };
        let bounds: Vec<_> = system.parameters.iter().map(|p| (p.node, p.within)).collect();
        let of_records: Vec<Id> = system.record_constants.iter().map(|&(_, node)| node).collect();
        let (low, high) = self.graph.range(node, &bounds);
        if (low < 0.0 || high > 1.0) && !self.graph.uses(&[node], &of_records) {
            let message = format!("the restitution of `{}` may leave 0 to 1", name.value);
            let reach = format!("from {low} to {high}");
            self.error(message, span, if low == high { "" } else { &reach }).help.push(
                "0 is a body that stays where it falls, 1 one that loses nothing: choose bounds within"
                    .into(),
            );
            return None;
        }
        Some(node)
    }

    /// Whether an expression is a gap along whose rate an impulse acts; otherwise a mistake says why not.
    fn is_gap(&mut self, text: &Text, gap: Id, system: &System) -> bool {
        let free = system.states.iter().find(|s| s.velocity.is_none() && self.graph.uses(&[gap], &[s.node]));
        if let Some(state) = free {
            let message = format!("`{}` is no gap: `{}` is no displacement", text.value, state.name);
            self.error(message, text.span, "").help.push(format!(
                "a gap depends on states whose rate is exactly another state; give `{}` such a rate, or leave it out",
                state.name
            ));
            return false;
        }
        let held = |id: &Id| matches!(self.graph.node(*id), Node::Binary(Binary::Hold, ..));
        if self.graph.reachable(&[gap]).iter().any(held) {
            let message = format!("`{}` is no gap: what is held jumps", text.value);
            self.error(message, text.span, "")
                .help
                .push("write the gap between the bodies, without a controller".into());
            return false;
        }
        let mut graph = self.graph.clone();
        let closing = system.closing(&mut graph, gap);
        let shared = |k: usize| system.inertia[k].is_none();
        match closing.as_slice() {
            [] => {
                let message = format!("`{}` holds no displacement, so no motion closes it", text.value);
                self.error(message, text.span, "")
                    .help
                    .push("write the distance that becomes zero, such as \"z\" or \"x2 - x1 - d\"".into());
                false
            }
            [_, _, ..] if closing.iter().any(|&(k, _)| shared(k)) => {
                let missing = closing.iter().filter(|&&(k, _)| shared(k));
                let names: Vec<String> =
                    missing.map(|&(k, _)| format!("`{}`", system.states[k].name)).collect();
                let message = format!("`{}` closes between bodies whose masses are not known", text.value);
                self.error(message, text.span, "").help.push(format!(
                    "how an impulse is shared hangs on them: give {} an `inertia`",
                    names.join(" and ")
                ));
                false
            }
            _ => true,
        }
    }

    /// The period and the delay of what is held are numbers, for the times of jumps do not move in a fit.
    pub(super) fn timings(&mut self, text: &Text, ast: &Ast, root: Id) {
        let holds = |kind: &AstKind| matches!(kind, AstKind::Binary(Binary::Hold, ..));
        if !ast.nodes.iter().any(|node| holds(&node.kind)) {
            return;
        }
        // Their times stay numbers where constants are freed.
        self.timing.extend(
            ast.nodes
                .iter()
                .filter_map(|node| match node.kind {
                    AstKind::Binary(Binary::Hold, _, timing) => Some(timing),
                    _ => None,
                })
                .flat_map(|timing| names_below(ast, timing)),
        );
        let sampled = ast.nodes.iter().filter_map(|node| match node.kind {
            AstKind::Binary(Binary::Hold, of, _) => Some(of),
            _ => None,
        });
        if sampled.flat_map(|of| names_below(ast, of)).any(|name| name.starts_with("rate ")) {
            self.error("`hold` takes no `rate(...)`", text.span, "")
                .help
                .push("a rate jumps where friction does: hold what makes it, such as the force".into());
            return;
        }
        for id in self.graph.reachable(&[root]) {
            let Node::Binary(Binary::Hold, _, timing) = self.graph.node(id) else { continue };
            let (period, delay) = match self.graph.node(timing) {
                Node::Binary(Binary::Timing, period, delay) => (period, self.graph.value(delay)),
                _ => (timing, Some(0.0)),
            };
            let what = match (self.graph.value(period), delay) {
                (Some(period), _) if period <= 0.0 => "the period of `hold` is not positive",
                (Some(_), Some(delay)) if delay < 0.0 => "the delay of `hold` is negative",
                (Some(period), Some(delay)) if delay >= period => {
                    "the delay of `hold` is not shorter than its period"
                }
                (Some(_), Some(_)) => continue,
                _ => "period and delay of `hold` are numbers, and one here is to be found or moves",
            };
            self.error(what, text.span, "").help.push(
                "write `hold(expression, period, delay)` with times in seconds, or constants in \"ms\", that are held"
                    .into(),
            );
            return;
        }
    }
}

/// The names in the part of an expression that ends at a node.
fn names_below(ast: &Ast, root: usize) -> Vec<String> {
    let mut waiting = vec![root];
    let mut names = vec![];
    while let Some(k) = waiting.pop() {
        match &ast.nodes[k].kind {
            AstKind::Name(name) => names.push(name.clone()),
            AstKind::Number(_) => {}
            AstKind::Unary(_, a) | AstKind::Table { of: a, .. } => waiting.push(*a),
            AstKind::Binary(_, a, b) => waiting.extend([*a, *b]),
        }
    }
    names
}
