//! What is asked for and what is found, in a sketch.

use super::acting::Acting;
use super::number::Numbers;
use super::read::Reading;
use super::scheme::{End, Kind, Known};
use crate::format::capital;
use crate::gap::GapReport;
use crate::run::RunReport;
use crate::table::{raised, with_error};
use crate::terminal::unicode;
use phisindy_expr::{Id, parse};
use phisindy_gap::{Place, Site, Step};
use phisindy_learn::FoundParameter;
use phisindy_phys::{Case, Law};

/// The numbers that were found, by the names of constants.
pub(super) fn numbers(found: &[FoundParameter]) -> Numbers {
    let mut all = Numbers::default();
    for p in found.iter().filter(|p| p.id.constant().is_some() && p.id.record().is_none()) {
        let name = p.id.of.to_string();
        let (low, high) = p.estimate.ci95;
        all.values.insert(name.clone(), p.estimate.value);
        all.errors.insert(name, 0.5 * (high - low));
    }
    all
}

/// Lights what the spec asks for.
pub(super) fn add_sought(reading: &mut Reading, case: &Case) {
    let states: Vec<usize> = case.system.terms.iter().map(|t| t.state).collect();
    for k in 0..states.len() {
        add_term(reading, k, "", Known::Sought);
    }
    let asked = case.laws.iter().map(|(state, _)| state).chain(case.searches.iter().map(|(state, _)| state));
    for &state in asked {
        add_at(reading, state, "", Known::Sought);
    }
}

/// Lights the terms that were found.
pub(super) fn add_found(reading: &mut Reading, report: &RunReport<'_>) {
    let terms = &report.identified.terms;
    // Terms that are one part, such as the logarithms of a friction, have no number alone.
    let part = |reading: &mut Reading, term: usize| {
        let own = reading.system.terms.get(term)?;
        let (state, value) = (own.state, own.value);
        let body = reading.bodies.iter().position(|b| b.speed == state);
        Some((state, body.map(|body| reading.view().0.acting(body, value))))
    };
    let parts: Vec<_> = terms.iter().map(|found| part(reading, found.term)).collect();
    for (k, found) in terms.iter().enumerate() {
        let term = &report.input.case.system.terms[found.term];
        let several = parts.iter().filter(|part| **part == parts[k]).count();
        let (low, high) = found.coefficient.ci95;
        let (value, half) = (found.coefficient.value, 0.5 * (high - low));
        let (value, unit) = match report.force(found) {
            Some((force, unit)) => (force, unit.to_string()),
            None => (value, term.unit.map_or(String::new(), |u| u.to_string())),
        };
        let scale = if found.coefficient.value == 0.0 { 1.0 } else { value / found.coefficient.value };
        let said = match several {
            1 => format!("{} {}", with_error(value, half * scale.abs()), raised(&unit)),
            n => format!("{n} terms"),
        };
        add_term(reading, found.term, said.trim_end(), Known::Found);
    }
}

/// Lights a term of the dictionary.
fn add_term(reading: &mut Reading, term: usize, said: &str, known: Known) {
    let Some(own) = reading.system.terms.get(term) else { return };
    let (state, value) = (own.state, own.value);
    let Some(body) = reading.bodies.iter().position(|b| b.speed == state) else {
        return add_at(reading, state, said, known);
    };
    let words = words_of(said);
    let (mut view, scheme, _) = reading.view();
    match view.acting(body, value) {
        Acting::Push => {
            scheme.push(body, if said.is_empty() { "?".to_owned() } else { said.to_owned() }, known)
        }
        Acting::Between(kind, ends) => scheme.add(kind, ends, words, known),
    }
}

/// Lights a force of a kind that is not known, on a body or in the rate of a state.
fn add_at(reading: &mut Reading, state: usize, said: &str, known: Known) {
    if let Some(body) = reading.bodies.iter().position(|b| b.speed == state) {
        return reading.scheme.add(Kind::Force, (End::Ground, End::Body(body)), words_of(said), known);
    }
    let Some(own) = reading.system.states.get(state) else { return };
    let name = unicode::name(&own.name);
    if let Some(block) = reading.scheme.blocks.iter_mut().find(|b| b.name == name) {
        block.words = if said.is_empty() { "?".to_owned() } else { said.to_owned() };
        block.known = known;
    }
}

fn words_of(said: &str) -> Vec<String> {
    if said.is_empty() { vec![] } else { vec![said.to_owned()] }
}

/// Lights the steps of a gap.
pub(super) fn add_steps(reading: &mut Reading, report: &GapReport<'_>) {
    for step in &report.gap.steps {
        add_step(reading, step);
    }
}

fn add_step(reading: &mut Reading, step: &Step) {
    let law = &step.effect.entry.law;
    let number = step.parameters.first().map(|p| {
        let (low, high) = p.ci95;
        let value = match p.each.is_empty() {
            true => with_error(p.value, 0.5 * (high - low)),
            false => "one for each record".to_owned(),
        };
        format!("{} = {value} {}", unicode::name(&p.name), raised(&p.unit)).trim_end().to_owned()
    });
    let name =
        if step.effect.entry.id == "discovered" { "discovered force".to_owned() } else { law.name.clone() };
    let words: Vec<String> = [capital(&name)].into_iter().chain(number).collect();
    let place = &step.effect.place;
    match &place.site {
        Site::Force { velocity, acts, .. } => {
            let ends = node(reading, &velocity.text).and_then(|w| reading.view().0.along(w));
            let ends = ends.or_else(|| ends_of(reading, acts));
            match ends {
                Some((End::Ground, End::Body(body))) if law.push.is_some() => {
                    reading.scheme.push(body, words.join(", "), Known::Found);
                }
                Some(ends) => reading.scheme.add(kind(law), ends, words, Known::Found),
                None => add_anywhere(reading, words),
            }
        }
        Site::Sensor(columns) => add_to_sensor(reading, columns, &words),
        Site::Input(_) | Site::Constant { .. } | Site::Impact { .. } => add_to_name(reading, place, &words),
    }
}

/// The kind of part that a law is.
fn kind(law: &Law) -> Kind {
    let linear = !law.is_curve();
    match () {
        () if law.sticks() => Kind::Friction,
        () if law.is_linear_spring() => Kind::Spring,
        () if law.is_spring() => Kind::BentSpring,
        () if law.is_resistance() && linear => Kind::Damper,
        () if law.is_resistance() => Kind::BentDamper,
        () => Kind::Force,
    }
}

/// An expression of the system's own names as a node.
fn node(reading: &mut Reading, text: &str) -> Option<Id> {
    let ast = parse(text).ok()?;
    let names = &reading.system.names;
    reading.system.graph.lower(&ast, |name| names.get(name)).ok()
}

/// The ends by the states whose rates a force enters.
fn ends_of(reading: &Reading, acts: &[(usize, f64)]) -> Option<(End, End)> {
    let body = |state: usize| reading.bodies.iter().position(|b| b.speed == state).map(End::Body);
    match acts {
        [(one, _)] => Some((End::Ground, body(*one)?)),
        [(a, _), (b, _), ..] => Some((body(*a)?, body(*b)?)),
        [] => None,
    }
}

/// A law of a model whose parts are only states.
fn add_anywhere(reading: &mut Reading, words: Vec<String>) {
    if let Some(block) = reading.scheme.blocks.first_mut() {
        (block.words, block.known) = (words.join(", "), Known::Found);
    }
}

fn add_to_sensor(reading: &mut Reading, columns: &[String], words: &[String]) {
    let shown: Vec<String> = columns.iter().map(|c| unicode::name(c)).collect();
    for body in &mut reading.scheme.bodies {
        if body.sensors.iter().any(|s| shown.contains(s)) && body.lit.is_empty() {
            body.lit = words.to_vec();
            break;
        }
    }
}

fn add_to_name(reading: &mut Reading, place: &Place, words: &[String]) {
    let name = unicode::name(&place.at);
    let scheme = &mut reading.scheme;
    let has = |said: &str| said.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == name);
    let part = scheme.elements.iter_mut().find(|e| e.words.first().is_some_and(|w| has(w)));
    if let Some(part) = part {
        part.known = Known::Found;
        part.words = words[1..].to_vec();
    } else if let Some(push) = scheme.pushes.iter_mut().find(|p| has(&p.words)) {
        push.known = Known::Found;
        push.words = format!("{}: {}", push.words, words.join(", "));
    }
}
