//! Equations with their numbers: the known part, then the identified terms.

mod linear_combination;

use linear_combination::{LinearCombination, split};
use phisindy_expr::{Binary, Graph, Id, Names, Node, Unary, latex_name, latex_rate};
use phisindy_learn::{FoundParameter, FoundTerm};
use phisindy_phys::{Case, Impact, Point, System};
use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;

/// The equation of one state, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Equation {
    /// Index of the state.
    pub state: usize,
    /// The whole line, `\dot{y} = ...`.
    pub latex: String,
    /// The right side in the language of the specs, numbers in full precision.
    pub text: String,
    /// The names that the right side uses.
    pub(crate) uses: Vec<String>,
}

/// What happens where a gap closes, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ImpactLine {
    /// What the spec calls it.
    pub name: String,
    /// The gap in the language of the specs.
    pub when: String,
    /// The number, if it is one for all records.
    pub restitution: Option<f64>,
    /// The whole line.
    pub latex: String,
    /// The same in the language of the specs.
    pub text: String,
}

/// The impacts of a system with the numbers that were found.
pub(crate) fn impacts_of(system: &System, case: &Case, parameters: &[FoundParameter]) -> Vec<ImpactLine> {
    let mut writer = Writer::new(system, case, parameters);
    let line = |impact: &Impact| {
        let (gap, part) = (writer.filled(impact.gap), writer.filled(impact.restitution));
        let (graph, names) = (&writer.graph, &writer.names);
        let [gap_latex, part_latex] = [gap, part].map(|id| graph.latex(id, names));
        let [when, part_text] = [gap, part].map(|id| graph.text(id, names));
        let rate = match graph.node(gap) {
            Node::Symbol(of) => latex_rate(names.name(of)),
            _ => format!("\\frac{{d}}{{dt}}\\left({gap_latex}\\right)"),
        };
        ImpactLine {
            name: impact.name.clone(),
            latex: format!("{gap_latex} = 0:\\; {rate}^{{+}} = -{part_latex}\\,{rate}^{{-}}"),
            text: format!("{}: where {when} = 0 its rate is reversed, times {part_text}", impact.name),
            restitution: graph.value(part),
            when,
        }
    };
    system.impacts.iter().map(line).collect()
}

/// The equations of all states that have candidates. Where the spec names laws, asks for formulas, or has no
/// candidates, the equations of all states whose rate is more than another state are among them.
pub fn equations(case: &Case, terms: &[FoundTerm], parameters: &[FoundParameter]) -> Vec<Equation> {
    equations_of(&case.system, case, terms, parameters)
}

/// The same of a system with the inputs of a case, such as its system with effects added.
pub(crate) fn equations_of(
    system: &System,
    case: &Case,
    terms: &[FoundTerm],
    parameters: &[FoundParameter],
) -> Vec<Equation> {
    let mut shown: Vec<bool> =
        (0..system.states.len()).map(|k| system.terms.iter().any(|t| t.state == k)).collect();
    // A law may add a state; a formula stands in the known part.
    if !shown.contains(&true) || !case.laws.is_empty() || !case.searches.is_empty() {
        shown
            .iter_mut()
            .zip(&system.states)
            .for_each(|(shown, s)| *shown |= s.velocity.is_none() && !s.hidden);
    }
    let mut writer = Writer::new(system, case, parameters);
    (0..system.states.len()).filter(|&k| shown[k]).map(|k| writer.equation(system, k, terms)).collect()
}

struct Writer {
    graph: Graph,
    /// The value of each movable constant, as a node.
    values: HashMap<Id, Id>,
    /// Those of the system; derived inputs are marked as rates.
    names: Names,
}

impl Writer {
    fn new(system: &System, case: &Case, parameters: &[FoundParameter]) -> Writer {
        let mut graph = system.graph.clone();
        let mut values = HashMap::new();
        for found in parameters {
            // A constant with one value per record keeps its name.
            if let (Some(k), None) = (found.id.constant(), found.id.record()) {
                values.insert(system.parameters[k].node, graph.constant(found.estimate.value));
            }
        }
        let derived = |k: usize| case.records.first().and_then(|first| first.derived[k]);
        let everywhere =
            |k: usize| case.records.iter().all(|r| r.derived[k].is_some() && r.derived[k] == derived(k));
        let mut names = system.names.clone();
        let symbol = |names: &Names, k: usize| names.get(&system.inputs[k].name);
        for k in (0..system.inputs.len()).filter(|&k| everywhere(k)) {
            let of = derived(k).and_then(|of| symbol(&names, of));
            if let (Some(rate), Some(of)) = (symbol(&names, k), of) {
                names.mark_rate(rate, of);
            }
        }
        Writer { graph, values, names }
    }

    fn filled(&mut self, node: Id) -> Id {
        let with = std::mem::take(&mut self.values);
        let filled = self.graph.replace(&[node], &with)[0];
        self.values = with;
        filled
    }

    /// The rate of a state. Of a speed of a mechanism the line says what changes its momentum: the rate has the whole
    /// inverse of the mass matrix in it. Of a point of a structure it is the row of the point in the matrices.
    fn equation(&mut self, system: &System, state: usize, terms: &[FoundTerm]) -> Equation {
        let rate = self.right_side(system, state, system.known[state], terms, false);
        let point = system.points.iter().find(|point| point.speed == state);
        let Some(&(_, momentum, force)) = system.momenta.iter().find(|(speed, ..)| *speed == state) else {
            return rate;
        };
        if let Some(Point { of, name, .. }) = point {
            let balance = self.right_side(system, state, force, terms, true);
            let (_, right) = balance.latex.split_once(" = ").unwrap_or(("", &balance.latex));
            let (of, name) = (latex_name(of), latex_name(name));
            let latex = format!(
                "\\left(M\\,\\ddot{{{of}}} + C\\,\\dot{{{of}}} + K\\,{of}\\right)_{{{name}}} = {right}"
            );
            return Equation { latex, ..rate };
        }
        let momentum = self.filled(momentum);
        let sum = LinearCombination::of(&mut self.graph, momentum);
        let names = &self.names;
        let latex = |graph: &Graph, id: Id| graph.latex(id, names);
        let left =
            written(&mut self.graph, &sum, &[], &latex, ["\\left(", "\\right)", "\\left[", "\\right]"]);
        let balance = self.right_side(system, state, force, terms, true);
        let (_, right) = balance.latex.split_once(" = ").unwrap_or(("", &balance.latex));
        let (pulls, loops) = self.constraints(system, state);
        Equation { latex: format!("\\frac{{d}}{{dt}}\\left({left}\\right) = {right}{pulls}{loops}"), ..rate }
    }

    /// The forces with which constraints hold a coordinate, each with its multiplier; and behind the last coordinate what
    /// the constraints say.
    fn constraints(&mut self, system: &System, state: usize) -> (String, String) {
        let coordinate = system.states.iter().find(|s| s.velocity == Some(state)).map(|s| s.node);
        let (mut pulls, mut loops) = (String::new(), String::new());
        for (k, constraint) in system.constraints.iter().enumerate() {
            let value = self.filled(constraint.value);
            let slope = coordinate.map(|q| self.graph.gradient(value, &[q])[0]);
            if let Some(slope) = slope.filter(|&s| self.graph.value(s) != Some(0.0)) {
                let _ = write!(
                    pulls,
                    " + \\lambda_{{{}}}\\left({}\\right)",
                    k + 1,
                    self.graph.latex(slope, &self.names)
                );
            }
            let _ = write!(loops, ",\\quad {} = 0", self.graph.latex(value, &self.names));
        }
        let last = system.momenta.iter().map(|(speed, ..)| *speed).max();
        (pulls, if last == Some(state) { loops } else { String::new() })
    }

    /// What is known, then the terms: rates, or forces along a speed.
    fn right_side(
        &mut self,
        system: &System,
        state: usize,
        known: Id,
        terms: &[FoundTerm],
        forces: bool,
    ) -> Equation {
        let known = self.filled(known);
        let mut plain = LinearCombination::of(&mut self.graph, known);
        let mut brackets: Vec<(Id, LinearCombination)> = Vec::new();
        for found in terms.iter().filter(|f| system.terms[f.term].state == state) {
            let term = &system.terms[found.term];
            let factor = match system.inertia[state].filter(|_| forces) {
                Some(inertia) => force_of(&mut self.graph, term.factor, inertia),
                None => term.factor,
            };
            let (factor, bare) = (self.filled(factor), self.filled(term.bare));
            let ((c, factor), (d, bare)) = (split(&mut self.graph, factor), split(&mut self.graph, bare));
            let part = (found.coefficient.value * c * d, bare);
            match brackets.iter_mut().find(|(f, _)| *f == factor) {
                Some((_, sum)) => sum.parts.push(part),
                None => brackets.push((factor, LinearCombination { parts: vec![part] })),
            }
        }
        let one = self.graph.constant(1.0);
        brackets.retain(|(factor, sum)| {
            // A group that needs no brackets continues the sum. It is not merged with a like part, so that
            // the identified term stays visible.
            let open = *factor == one || sum.parts.len() == 1;
            if open {
                plain.parts.extend(sum.parts.iter().map(|&(c, bare)| (c, self.graph.mul(bare, *factor))));
            }
            !open
        });
        let names = &self.names;
        let latex = |graph: &Graph, id: Id| graph.latex(id, names);
        let text = |graph: &Graph, id: Id| graph.text(id, names);
        let graph = &mut self.graph;
        let of_brackets = brackets.iter().flat_map(|(factor, sum)| sum.nodes().chain([*factor]));
        let nodes: Vec<Id> = plain.nodes().chain(of_brackets).collect();
        let uses = graph.symbols(&nodes).into_iter().map(|s| names.name(s).to_owned()).collect();
        let left = latex_rate(&system.states[state].name);
        Equation {
            state,
            latex: format!(
                "{left} = {}",
                written(graph, &plain, &brackets, &latex, ["\\left(", "\\right)", "\\left[", "\\right]"])
            ),
            text: written(graph, &plain, &brackets, &text, ["(", ")", "*(", ")"]),
            uses,
        }
    }
}

/// What makes a rate with an inertia: that of `-force/inertia` is `-force`.
fn force_of(graph: &mut Graph, rate: Id, inertia: Id) -> Id {
    match graph.node(rate) {
        Node::Binary(Binary::Div, force, over) if over == inertia => force,
        Node::Unary(Unary::Neg, inner) => {
            let force = force_of(graph, inner, inertia);
            graph.neg(force)
        }
        _ => graph.mul(inertia, rate),
    }
}

/// The plain sum, then each factor times its sum in brackets.
fn written(
    graph: &mut Graph,
    plain: &LinearCombination,
    brackets: &[(Id, LinearCombination)],
    print: &dyn Fn(&Graph, Id) -> String,
    [open, close, open_sum, close_sum]: [&str; 4],
) -> String {
    let mut out = if plain.parts.is_empty() && !brackets.is_empty() {
        String::new()
    } else {
        plain.written(graph, print)
    };
    for (factor, sum) in brackets {
        let minus = sum.parts.first().is_some_and(|&(c, _)| c < 0.0);
        let sign = if minus { -1.0 } else { 1.0 };
        let inner =
            LinearCombination { parts: sum.parts.iter().map(|&(c, bare)| (sign * c, bare)).collect() };
        let front = print(graph, *factor);
        let front = match graph.node(*factor) {
            Node::Binary(Binary::Add | Binary::Sub, ..) => format!("{open}{front}{close}"),
            _ => front,
        };
        out.push_str(match (out.is_empty(), minus) {
            (true, true) => "-",
            (true, false) => "",
            (false, true) => " - ",
            (false, false) => " + ",
        });
        out.push_str(&format!("{front}{open_sum}{}{close_sum}", inner.written(graph, print)));
    }
    out
}

/// Names in the equations that have one value per record.
pub(crate) fn names_of_records(system: &System, equations: &[Equation]) -> Vec<String> {
    let used: HashSet<&String> = equations.iter().flat_map(|e| &e.uses).collect();
    let each = system.parameters.iter().filter(|p| p.each).map(|p| &p.name);
    let all = system.record_constants.iter().map(|(name, _)| name).chain(each);
    all.filter(|name| used.contains(name)).cloned().collect()
}

#[cfg(test)]
mod tests;
