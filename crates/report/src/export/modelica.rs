//! A model in Modelica: contacts are friction elements with modes, as in the standard library; the tool
//! solves contacts that stick together.

use super::functions::stem_of_temporaries;
use super::head::head;
use super::identifier::Identifiers;
use super::quoted::quoted;
use super::subject::{Quantity, Subject};
use phisindy_expr::{Code, Id, Language, Naming, Node, Scratch, Symbol, Tape};
use phisindy_sim::Switch;
use std::collections::HashMap;
use std::fmt::Write;

/// Distance from rest at which singular friction is evaluated, for speeds of about 1 m/s.
const OFF_SURFACE: f64 = 1e-6;

/// The text of the model.
pub(crate) fn written(subject: &Subject, name: &str) -> String {
    let mut identifiers = Identifiers::new(Language::Modelica, subject.names());
    let contacts = ContactNames::of(subject, &mut identifiers);
    let code = code(subject, &identifiers, &contacts);
    let usage = [
        "Simulate with event detection on; inputs are connected from outside. The contacts are written like the friction elements of the",
        "Modelica standard library: locked, sliding forward or backward, and load is the path parameter of friction.",
    ];
    let mut out = String::new();
    for line in head(subject, &identifiers, &usage) {
        let _ = writeln!(out, "{}", format!("// {line}").trim_end());
    }
    let _ = writeln!(out, "model {name} {}", quoted(&subject.title));
    declare_quantities(&mut out, subject, &identifiers);
    let switches = &subject.switched.switches;
    for (switch, contact) in switches.iter().zip(&contacts) {
        let text = quoted(&format!("Mode of {}: 1 forward, -1 backward, 0 sticks", switch.text));
        let _ = writeln!(out, "  Integer {}(start = 0, fixed = true) {text};", contact.mode);
    }
    out += "protected\n";
    for (k, (switch, contact)) in switches.iter().zip(&contacts).enumerate() {
        declare_contact(&mut out, switch, contact, floor_at_start(subject, k));
    }
    for (name, _) in &code.temporaries {
        let _ = writeln!(out, "  Real {name};");
    }
    out.push('\n');
    out += Language::Modelica.helpers();
    out += "equation\n";
    for (name, value) in &code.temporaries {
        let _ = writeln!(out, "  {name} = {value};");
    }
    let (rates, surfaces) = code.roots.split_at(subject.states.len());
    let (surfaces, surface_rates) = surfaces.split_at(switches.len());
    let (surface_rates, outputs) = surface_rates.split_at(switches.len());
    for (q, rate) in subject.states.iter().zip(rates) {
        let _ = writeln!(out, "  der({}) = {rate};", identifiers.of(&q.name));
    }
    for (q, reads) in subject.outputs.iter().zip(outputs) {
        let _ = writeln!(out, "  {} = {reads};", identifiers.of(&q.name));
    }
    for (k, (switch, contact)) in switches.iter().zip(&contacts).enumerate() {
        write_contact(&mut out, switch, contact, &surfaces[k], &surface_rates[k]);
    }
    let _ = writeln!(out, "end {name};");
    out
}

/// The variables of one contact.
struct ContactNames {
    friction: String,
    load: String,
    speed: String,
    locked: String,
    forward: String,
    backward: String,
    mode: String,
    floor: String,
}

impl ContactNames {
    /// Names for all contacts of a model.
    fn of(subject: &Subject, identifiers: &mut Identifiers) -> Vec<ContactNames> {
        let count = subject.switched.switches.len();
        let stems = ["friction", "load", "speed", "locked", "forward", "backward", "mode", "floor"];
        let all: [Vec<String>; 8] =
            stems.map(|stem| (0..count).map(|k| identifiers.fresh(&format!("{stem}{k}"))).collect());
        let of = |k: usize| {
            let [friction, load, speed, locked, forward, backward, mode, floor] =
                all.each_ref().map(|names| names[k].clone());
            ContactNames { friction, load, speed, locked, forward, backward, mode, floor }
        };
        (0..count).map(of).collect()
    }
}

/// Rates, surfaces and rates of surfaces as expressions.
fn code(subject: &Subject, identifiers: &Identifiers, contacts: &[ContactNames]) -> Code {
    let s = &subject.switched;
    // Margins account for rounding in our own simulation only; the side of a locked contact is 0.
    let mut graph = s.graph.clone();
    let zero = graph.constant(0.0);
    let without: HashMap<Id, Id> = s.margins.iter().map(|&id| (id, zero)).collect();
    let rates = graph.replace(&s.rates, &without);
    let surfaces = graph.replace(&s.surfaces, &without);
    let surface_rates = graph.replace(&s.surface_rates, &without);

    let mut words: HashMap<Symbol, String> = HashMap::new();
    let mut call = |id: Id, text: String| {
        if let Node::Symbol(symbol) = graph.node(id) {
            words.insert(symbol, text);
        }
    };
    call(subject.model.time, "time".to_owned());
    for q in subject.states.iter().chain(&subject.inputs) {
        call(q.node, identifiers.of(&q.name).to_owned());
    }
    subject.constants.iter().for_each(|c| call(c.node, identifiers.of(&c.name).to_owned()));
    for (q, &slope) in subject.inputs.iter().zip(&s.slopes) {
        call(slope, format!("der({})", identifiers.of(&q.name)));
    }
    for (k, contact) in contacts.iter().enumerate() {
        call(s.modes[k], contact.friction.clone());
        call(s.sides[k], format!("(if {} then 0 else {})", contact.locked, contact.friction));
        call(s.floors[k], contact.floor.clone());
    }
    let stem = stem_of_temporaries(&subject.names().collect::<Vec<_>>());
    let moving = subject.moving();
    let naming =
        Naming { symbol: &|s| words[&s].clone(), temporary: &|k| format!("{stem}{k}"), moving: &moving };
    let outputs = graph.replace(&s.outputs, &without);
    let roots: Vec<Id> =
        [&rates, &surfaces, &surface_rates, &outputs].into_iter().flatten().copied().collect();
    graph.code(&roots, Language::Modelica, &naming)
}

/// Declarations of constants, states and inputs.
fn declare_quantities(out: &mut String, subject: &Subject, identifiers: &Identifiers) {
    for c in &subject.constants {
        let _ =
            writeln!(out, "  parameter Real {}{} = {:?};", identifiers.of(&c.name), unit(&c.unit), c.value);
    }
    let record = subject.chosen();
    for (q, start) in subject.states.iter().zip(&record.start) {
        let _ = writeln!(
            out,
            "  Real {}({}start = {:?}, fixed = true);",
            identifiers.of(&q.name),
            unit_in(q),
            start.unwrap_or(0.0)
        );
    }
    for q in &subject.inputs {
        let _ = writeln!(out, "  input Real {}{};", identifiers.of(&q.name), unit(&q.unit));
    }
    for q in &subject.outputs {
        let _ = writeln!(out, "  output Real {}{};", identifiers.of(&q.name), unit(&q.unit));
    }
}

/// Declarations of a contact, except for its mode, which is public.
fn declare_contact(out: &mut String, switch: &Switch, names: &ContactNames, floor_value: f64) {
    let text = &switch.text;
    let ContactNames { friction, load, speed, locked, forward, backward, floor, .. } = names;
    let _ = writeln!(out, "  Real {speed} {};", quoted(text));
    let _ = writeln!(
        out,
        "  Real {friction} {};",
        quoted(&format!("sgn({text}), or the part of its friction that holds it"))
    );
    if switch.can_stick {
        let _ = writeln!(out, "  Real {load} \"Path parameter\";");
        let _ = writeln!(out, "  Boolean {forward}(start = false, fixed = true);");
        let _ = writeln!(out, "  Boolean {backward}(start = false, fixed = true);");
    }
    let _ = writeln!(out, "  Boolean {locked};");
    let said = "Speed at which friction is looked at while it holds";
    let _ = writeln!(out, "  parameter Real {floor} = {floor_value:?} \"{said}\";");
}

/// Equations of a contact with the surface `w` and its rate `a`.
fn write_contact(out: &mut String, switch: &Switch, names: &ContactNames, w: &str, a: &str) {
    let ContactNames { friction, load, speed, locked, forward, backward, mode, .. } = names;
    let _ = writeln!(out, "  {speed} = {w};");
    if !switch.can_stick {
        let _ = writeln!(out, "  {locked} = false;");
        let _ = writeln!(
            out,
            "  {mode} = if {speed} > 0 then 1 elseif {speed} < 0 then -1 else 0;\n  {friction} = {mode};"
        );
        return;
    }
    let _ = write!(
        out,
        "  {forward} = pre({mode}) == 0 and {load} > 1 or initial() and {speed} > 0;
  {backward} = pre({mode}) == 0 and {load} < -1 or initial() and {speed} < 0;
  {locked} = not (pre({mode}) <> 0 or {forward} or {backward});
  {friction} = if {locked} then {load} elseif {forward} then 1 elseif {backward} then -1 else pre({mode});
  {a} = if {locked} then 0 elseif {forward} then {load} - 1 elseif {backward} then {load} + 1 else {load} - pre({mode});
  {mode} = if (pre({mode}) == 1 or {forward}) and {speed} > 0 then 1 elseif (pre({mode}) == -1 or {backward}) and {speed} < 0 then -1 else 0;
"
    );
}

/// The floor under `|w|`: friction that is singular or vanishes at rest is evaluated slightly off rest.
/// Decided at the start state.
fn floor_at_start(subject: &Subject, k: usize) -> f64 {
    let s = &subject.switched;
    if !s.switches[k].shaped {
        return 0.0;
    }
    let record = subject.chosen();
    let mut inputs: Vec<(Id, f64)> = vec![(subject.model.time, record.start_time.unwrap_or(0.0))];
    inputs.extend(subject.states.iter().zip(&record.start).map(|(q, x)| (q.node, x.unwrap_or(0.0))));
    inputs.extend(subject.inputs.iter().map(|q| (q.node, 0.0)));
    inputs.extend(subject.constants.iter().map(|c| (c.node, c.value)));
    inputs.extend(
        [&s.slopes, &s.modes, &s.sides, &s.floors, &s.margins].into_iter().flatten().map(|&id| (id, 0.0)),
    );
    let at = |floor: f64| {
        let symbols: Vec<Id> = inputs.iter().map(|(id, _)| *id).collect();
        let grip = s.influence[k * s.switches.len() + k];
        let Ok(tape) = Tape::compile(&s.graph, &symbols, &[grip]) else { return f64::NAN };
        let mut scratch = Scratch::<1>::new(&tape);
        for (place, (id, value)) in inputs.iter().enumerate() {
            scratch.input(place)[0] = if *id == s.floors[k] { floor } else { *value };
        }
        scratch.run();
        -scratch.output(0)[0]
    };
    let (rest, near) = (at(0.0), at(OFF_SURFACE));
    if rest.is_finite() && (rest >= near || !near.is_finite()) { 0.0 } else { OFF_SURFACE }
}

/// `(unit = "...")`; Modelica writes products with a dot.
fn unit(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!("(unit = {})", quoted(&pointed(unit))) }
}

fn unit_in(q: &Quantity) -> String {
    if q.unit.is_empty() { String::new() } else { format!("unit = {}, ", quoted(&pointed(&q.unit))) }
}

fn pointed(unit: &str) -> String {
    unit.replace('*', ".").replace('^', "")
}
