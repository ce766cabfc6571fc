//! The name and the number of a part: `k = 1190 ± 20 N/m`.

use super::moving::Moving;
use super::probe::Probe;
use crate::table::{four, raised, with_error};
use crate::terminal::unicode;
use phisindy_expr::Id;
use phisindy_phys::System;
use std::collections::HashMap;

/// Letters of an expression that stands in the place of a name.
const LETTERS: usize = 14;
/// Letters of a formula beside a part.
const FORMULA: usize = 26;

/// The numbers of a model by the names of its constants (SI), with half of their 95 % intervals where they are found.
#[derive(Default)]
pub(super) struct Numbers {
    pub(super) values: HashMap<String, f64>,
    pub(super) errors: HashMap<String, f64>,
}

/// What a number measures, with its unit: of a body that slides, of one that turns, of one whose mass is not known.
pub(super) type Units = [&'static str; 3];
pub(super) const STIFFNESS: Units = ["N/m", "N*m/rad", "1/s^2"];
pub(super) const DAMPING: Units = ["N*s/m", "N*m*s/rad", "1/s"];
pub(super) const INERTIA: Units = ["kg", "kg*m^2", ""];

/// The unit of a number of a body; none where the spec speaks of no units.
pub(super) fn unit(system: &System, body: &Moving, units: Units) -> String {
    let own = &system.states[body.speed].unit;
    let bare = matches!(own.as_str(), "" | "1");
    let lengths = own.starts_with('m') && !own.starts_with("mol");
    let which = match (body.mass.is_some(), body.turns) {
        _ if bare => return String::new(),
        (true, true) => 1,
        (true, false) if lengths || own.contains("m/") => 0,
        (true, false) => return String::new(),
        (false, _) => 2,
    };
    raised(units[which])
}

/// A number with its name.
pub(super) fn words(
    system: &System,
    (probe, numbers): (&Probe, &Numbers),
    (node, units): (Id, Units),
    body: &Moving,
) -> String {
    let graph = &system.graph;
    let own = system.parameters.iter().find(|p| probe.same(graph, node, p.node));
    let text = graph.text(node, &system.names);
    let name = match own {
        Some(p) => unicode::name(&p.name),
        None if graph.value(node).is_some() => String::new(),
        // A sum of names is one; a product of many says less than its number.
        None => Some(unicode::expression(&text, &[])).filter(|t| is_sum(t)).unwrap_or_default(),
    };
    let value = probe.value(graph, node);
    let error = own.and_then(|p| numbers.errors.get(&p.name)).copied();
    let shown = match error {
        Some(error) => with_error(value, error),
        None => four(value).replace('-', "−"),
    };
    let unit = unit(system, body, units);
    match (name.is_empty(), value.is_finite()) {
        (true, false) => String::new(),
        (false, false) => format!("{name} = ?"),
        (true, true) => format!("{shown} {unit}").trim_end().to_owned(),
        (false, true) => format!("{name} = {shown} {unit}").trim_end().to_owned(),
    }
}

/// A force as a formula, if it is short, without the sign of a single product: a spring is not less for it.
pub(super) fn formula(system: &System, force: Id) -> String {
    let text = signed_formula(system, force);
    let bare = text.strip_prefix('−').filter(|rest| !is_several(rest)).unwrap_or(&text);
    bare.to_owned()
}

/// The same with its sign.
pub(super) fn signed_formula(system: &System, force: Id) -> String {
    let text = unicode::expression(&system.graph.text(force, &system.names), &[]);
    if text.chars().count() <= FORMULA { text } else { String::new() }
}

/// Whether it is a short sum of names.
fn is_sum(text: &str) -> bool {
    text.chars().count() <= LETTERS && text.chars().all(|c| c.is_alphanumeric() || " +−_".contains(c))
}

/// Whether a formula has several terms outside of brackets.
fn is_several(text: &str) -> bool {
    let mut depth = 0_i32;
    text.chars().any(|c| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        depth == 0 && c == ' '
    })
}
