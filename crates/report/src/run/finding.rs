//! What was found in one sentence, with its numbers: terms of the same equation and factor stand together.

use super::report::RunReport;
use crate::table::{raised, with_error};
use phisindy_expr::{Node, Unary};
use phisindy_learn::{Estimate, FoundTerm};
use phisindy_phys::System;

/// Most numbers in the sentence; the others stand in their table.
const NUMBERS: usize = 4;

/// `dry friction of y1: 0.3000 ± 0.0001 m/s²; ...`: coefficients of terms first, then parameters, each with
/// half of its 95 % interval.
pub(crate) fn found_words(report: &RunReport<'_>) -> String {
    let terms = &report.identified.terms;
    let constants = report.identified.parameters.iter().filter(|p| p.id.constant().is_some());
    let all = terms.len() + constants.clone().count();
    if all == 0 {
        return "the known part is complete".to_owned();
    }
    let mut groups: Vec<Group<'_>> = Vec::new();
    for f in terms.iter().take(NUMBERS) {
        let term = &report.input.case.system.terms[f.term];
        let own = (term.state, term.factor_text.trim());
        match groups.iter_mut().find(|g| (g.state, g.factor) == own) {
            Some(group) => group.terms.push(f),
            None => groups.push(Group { state: own.0, factor: own.1, terms: vec![f] }),
        }
    }
    let parameters = constants.take(NUMBERS.saturating_sub(terms.len())).map(|p| {
        let value = with_error(p.estimate.value / p.factor, half(&p.estimate) / p.factor);
        format!("{} = {value}{}", p.id, spaced(&p.unit))
    });
    let mut words: Vec<String> = groups.iter().map(|g| g.words(report)).collect();
    words.extend(parameters);
    let more = all.saturating_sub(NUMBERS);
    if more > 0 {
        words.push(format!("and {more} more number{}", if more == 1 { "" } else { "s" }));
    }
    words.join("; ")
}

/// Terms of an equation with the same factor.
struct Group<'a> {
    state: usize,
    factor: &'a str,
    terms: Vec<&'a FoundTerm>,
}

impl Group<'_> {
    fn words(&self, report: &RunReport<'_>) -> String {
        let system = &report.input.case.system;
        let state = &system.states[self.state].name;
        let numbers: Vec<(String, String, &str)> = self.terms.iter().map(|f| number(report, f)).collect();
        // One unit that all share stands at the end.
        let unit = &numbers[0].1;
        let shared = numbers.iter().all(|n| n.1 == *unit);
        let one = numbers.len() == 1;
        let sum: Vec<String> = numbers
            .iter()
            .map(|(value, unit, candidate)| match (*candidate, shared) {
                ("1", true) => value.clone(),
                ("1", false) => format!("{value}{}", spaced(unit)),
                (candidate, true) if !one => format!("({value})·{candidate}"),
                (candidate, _) => format!("({value}){}·{candidate}", spaced(unit)),
            })
            .collect();
        let sum = sum.join(" + ");
        let unit = match (shared, one, numbers[0].2) {
            (true, true, "1") => spaced(unit),
            (true, false, _) if !unit.is_empty() => format!(", in {}", raised(unit)),
            _ => String::new(),
        };
        match against_sign(system, self.terms[0]) {
            Some(velocity) => format!("dry friction of {velocity}: {sum}{unit}"),
            None if self.factor == "1" => format!("in d{state}/dt: {sum}{unit}"),
            None => format!("in d{state}/dt: {}·[{sum}]{unit}", self.factor.replace('-', "−")),
        }
    }
}

/// The velocity against whose sign a term acts: its factor is `-sgn(v)`.
fn against_sign(system: &System, f: &FoundTerm) -> Option<String> {
    let graph = &system.graph;
    let Node::Unary(Unary::Neg, sign) = graph.node(system.terms[f.term].factor) else { return None };
    let Node::Unary(Unary::Sgn, velocity) = graph.node(sign) else { return None };
    Some(graph.text(velocity, &system.names))
}

/// Value with its error, unit, and candidate of a term: a force where the inertia is known.
fn number<'a>(report: &'a RunReport<'_>, f: &FoundTerm) -> (String, String, &'a str) {
    let term = &report.input.case.system.terms[f.term];
    let own = term.unit.map_or(String::new(), |u| u.to_string());
    let (scale, unit) = report
        .force(f)
        .map_or((1.0, own), |(force, dimension)| (force / f.coefficient.value, dimension.to_string()));
    let value = with_error(f.coefficient.value * scale, half(&f.coefficient) * scale.abs());
    (value, unit, term.candidate.trim())
}

fn half(e: &Estimate) -> f64 {
    0.5 * (e.ci95.1 - e.ci95.0).abs()
}

fn spaced(unit: &str) -> String {
    let unit = raised(unit);
    if unit.is_empty() { unit } else { format!(" {unit}") }
}
