//! The text of a completed spec. Effects and changed values are spliced into the user's text, so that its
//! comments remain.

use super::trial_model::{Applied, TrialModel};
use crate::place::{Entry, Quantity, Site};
use phisindy_expr::{Id, rename};
use phisindy_phys::unit::Unit;
use phisindy_phys::{INPUT, LawRole, splice};
use phisindy_signal::Interpolation;
use std::fmt;

/// Why a text cannot hold an effect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SpecTextError {
    /// The path in the spec that cannot be set.
    pub path: String,
    /// Why not.
    pub why: String,
}

impl fmt::Display for SpecTextError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` cannot be set: {}", self.path, self.why)
    }
}

impl std::error::Error for SpecTextError {}

/// The text under construction.
struct Text(String);

impl Text {
    fn set(&mut self, path: &str, value: &str) -> Result<(), SpecTextError> {
        let wrong = |why: String| SpecTextError { path: path.to_owned(), why };
        self.0 = splice::set(&self.0, path, value).map_err(|e| wrong(e.to_string()))?;
        Ok(())
    }
}

/// The spec's text with the effects of a model. Every number has its start value in the model. `inputs` says
/// how the inputs go between their samples, if not as the spec has it.
///
/// # Errors
/// The text cannot hold an effect.
pub(crate) fn text_with(
    text: &str,
    model: &TrialModel,
    inputs: Option<Interpolation>,
) -> Result<String, SpecTextError> {
    let mut text = Text(text.to_owned());
    if let Some(kind) = inputs {
        let names = model.given.spec.inputs.iter().map(|(name, _)| format!("{:?}: {kind:?}", name.value));
        let all = format!("{{ {} }}", names.collect::<Vec<_>>().join(", "));
        for record in 0..model.given.spec.data.len() {
            text.set(&format!("data.{record}.interpolate"), &all)?;
        }
    }
    start_values(&mut text, model)?;
    let spec = &model.given.spec;
    let mut parts = Parts {
        rates: spec.known.iter().map(|(name, rate)| (name.value.clone(), rate.value.clone())).collect(),
        outputs: spec.outputs.iter().map(|(name, o)| (name.value.clone(), o.reads.value.clone())).collect(),
        contacts: spec.contacts.iter().map(|c| c.value.clone()).collect(),
        forces: {
            let of_energy = spec.energy.iter().flat_map(|e| &e.forces).map(|force| ("energy", force));
            let of_structure =
                spec.structure.iter().flat_map(|s| &s.forces).map(|force| ("structure", force));
            let all = of_energy.chain(of_structure);
            all.map(|(field, (force, along))| (field, force.value.clone(), along.value.clone())).collect()
        },
        inertia: spec.inertia.iter().map(|(name, m)| (name.value.clone(), m.value.clone())).collect(),
    };
    for applied in &model.effects {
        constants(&mut text, model, applied)?;
        match &applied.effect.place.site {
            Site::Sensor(columns) => sensor(&mut text, model, applied, columns)?,
            Site::Input(inputs) if applied.effect.is_input_delay() => {
                delay(&mut text, model, applied, inputs)?
            }
            Site::Input(inputs) => acting(&mut text, model, applied, inputs, &mut parts)?,
            Site::Force { .. } => force(&mut text, model, applied, &mut parts)?,
            Site::Impact { below, .. } => impact(&mut text, model, applied, *below)?,
            // It stands among the constants by now.
            Site::Constant { .. } => {}
        }
    }
    Ok(text.0)
}

/// The texts that effects extend, one after the other.
struct Parts {
    rates: Vec<(String, String)>,
    outputs: Vec<(String, String)>,
    contacts: Vec<String>,
    /// Forces of energies and structures: the field that holds it, the force, the speed along which it acts.
    forces: Vec<(&'static str, String, String)>,
    inertia: Vec<(String, String)>,
}

/// The constants with their start values in the model.
fn start_values(text: &mut Text, model: &TrialModel) -> Result<(), SpecTextError> {
    let base = model.without_effects();
    for p in &base.system.parameters {
        let own = model.system.parameters.iter().find(|own| own.name == p.name);
        let now = own.map_or(p.start, |own| own.start);
        let field = if p.known { "value" } else { "start" };
        let factor = Unit::parse(&p.unit).map_or(1.0, |u| u.factor);
        if now.to_bits() != p.start.to_bits() {
            let impact = model.system.impacts.iter().find(|of| of.restitution == p.node);
            let path = match impact {
                Some(impact) if p.name.contains('.') => format!("impacts.{}.restitution", impact.name),
                _ => format!("constants.{}", p.name),
            };
            text.set(&format!("{path}.{field}"), &format!("{:?}", now / factor))?;
        }
    }
    Ok(())
}

/// A property of a sensor, in every record.
fn sensor(
    text: &mut Text,
    model: &TrialModel,
    applied: &Applied,
    columns: &[String],
) -> Result<(), SpecTextError> {
    let which = applied.effect.entry.law.sensor.as_deref().unwrap_or_default();
    for record in 0..model.given.spec.data.len() {
        for name in columns {
            let path = format!("data.{record}.sensors.{name}.{which}");
            text.set(&path, &format!("\"{}\"", applied.names[0]))?;
        }
    }
    Ok(())
}

/// A delay of inputs that are measured, in every record.
fn delay(
    text: &mut Text,
    model: &TrialModel,
    applied: &Applied,
    inputs: &[usize],
) -> Result<(), SpecTextError> {
    for (record, plan) in model.given.plans.iter().enumerate() {
        for &input in inputs.iter().filter(|&&j| plan.derived.get(j).is_none_or(Option::is_none)) {
            let name = &model.system.inputs[input].name;
            let path = format!("data.{record}.sensors.{name}.delay");
            text.set(&path, &format!("\"{}\"", applied.names[0]))?;
        }
    }
    Ok(())
}

/// What acts in the place of inputs, wherever they stand in rates, outputs and forces.
fn acting(
    text: &mut Text,
    model: &TrialModel,
    applied: &Applied,
    inputs: &[usize],
    parts: &mut Parts,
) -> Result<(), SpecTextError> {
    let acts = applied.effect.entry.law.acting().unwrap_or(INPUT);
    let of = |&j: &usize| {
        let name = model.system.inputs[j].name.clone();
        let own =
            |(from, to): (String, String)| if from == INPUT { (from, name.clone()) } else { (from, to) };
        let with: Vec<(String, String)> = replacements(applied).into_iter().map(own).collect();
        let acts = rename(acts, &with).unwrap_or_else(|_| acts.to_owned());
        (name, format!("({acts})"))
    };
    let with: Vec<(String, String)> = inputs.iter().map(of).collect();
    let changed = |text: &str| rename(text, &with).unwrap_or_else(|_| text.to_owned());
    for (name, rate) in &mut parts.rates {
        *rate = changed(rate);
        text.set(&format!("known.{name}"), &format!("\"{rate}\""))?;
    }
    for (name, reads) in &mut parts.outputs {
        *reads = changed(reads);
        text.set(&format!("outputs.{name}.reads"), &format!("\"{reads}\""))?;
    }
    // A force of energies is the key of its entry: another one adds what changes.
    let more = parts.forces.iter().filter_map(|(field, force, along)| {
        let now = changed(force);
        (now != *force).then(|| (*field, format!("{now} - ({force})"), along.clone()))
    });
    let more: Vec<(&'static str, String, String)> = more.collect();
    for (field, force, along) in &more {
        text.set(&format!("{field}.forces.\"{force}\""), &format!("\"{along}\""))?;
    }
    parts.forces.extend(more);
    // Its own states see the input as it is recorded.
    internal(text, model, applied, parts)
}

/// A force in the rates of the bodies on which it acts and in the outputs that show it.
fn force(
    text: &mut Text,
    model: &TrialModel,
    applied: &Applied,
    parts: &mut Parts,
) -> Result<(), SpecTextError> {
    let Site::Force { acts, enters, shows, velocity, .. } = &applied.effect.place.site else {
        return Ok(());
    };
    internal(text, model, applied, parts)?;
    let force = force_text(applied).unwrap_or_default();
    let sign = |sign: f64| if sign < 0.0 { '-' } else { '+' };
    let size = |way: f64| if way.abs() == 1.0 { String::new() } else { format!("{:?}*", way.abs()) };
    let mut add = |text: &mut Text, state: usize, more: &str| {
        let name = &model.system.states[state].name;
        let Some((_, rate)) = parts.rates.iter_mut().find(|(n, _)| n == name) else { return Ok(()) };
        *rate = format!("{rate} {more}");
        text.set(&format!("known.{name}"), &format!("\"{rate}\""))
    };
    let written = |node: Id| model.system.graph.text(node, &model.system.names);
    for (k, &(state, way)) in acts.iter().enumerate() {
        let name = &model.system.states[state].name;
        let (way, by) = match enters.get(k) {
            Some(Entry::Rate(by)) => {
                add(text, state, &format!("+ {}*({force})", by.text))?;
                continue;
            }
            Some(Entry::Force(by)) => (1.0, format!("{}*", by.text)),
            None => (way, size(way)),
        };
        if model.given.spec.is_moved(name) {
            // Along a direction that turns it is said once.
            let (signed, along) = match enters.get(k) {
                Some(_) => (format!("-({force})"), velocity.bare()),
                None if way < 0.0 => (format!("-{by}({force})"), name.as_str()),
                None => (format!("{by}({force})"), name.as_str()),
            };
            let field = model.given.spec.forces_along(name);
            text.set(&format!("{field}.forces.\"{signed}\""), &format!("\"{along}\""))?;
            continue;
        }
        let follows: Vec<&(usize, usize, Id)> =
            model.system.coupling.iter().filter(|(of, ..)| *of == state).collect();
        let stated = parts.inertia.iter().find(|(n, _)| n == name).map(|(_, m)| m.clone());
        let inertia = match (model.given.spec.between.is_empty(), model.system.inertia[state]) {
            (false, Some(felt)) => Some(written(felt)),
            _ => stated,
        };
        let over = inertia.map_or(String::new(), |m| format!("/({m})"));
        let share = format!("{by}({force}){over}");
        add(text, state, &format!("{} {share}", sign(way)))?;
        for &&(_, other, ratio) in &follows {
            add(text, other, &format!("{} ({})*{share}", sign(way), written(ratio)))?;
        }
    }
    for &(output, way) in shows {
        let name = &model.system.outputs[output].name;
        let Some((_, reads)) = parts.outputs.iter_mut().find(|(n, _)| n == name) else { continue };
        *reads = format!("{reads} {} ({force})", sign(way));
        text.set(&format!("outputs.{name}.reads"), &format!("\"{reads}\""))?;
    }
    if applied.effect.entry.law.sticks() && !acts.is_empty() {
        contact(text, model, applied, &mut parts.contacts)?;
    }
    Ok(())
}

/// The gap of an impact: what is larger less what is smaller.
fn gap_text(applied: &Applied, below: bool) -> String {
    let (x, wall) = (&applied.effect.place.at, applied.names.first().map_or("", String::as_str));
    if below { format!("{x} - {wall}") } else { format!("{wall} - {x}") }
}

fn impact(text: &mut Text, model: &TrialModel, applied: &Applied, below: bool) -> Result<(), SpecTextError> {
    let taken = |name: &str| model.given.spec.impacts.iter().any(|(own, _)| own.value == name);
    let side = if below { "floor" } else { "ceiling" };
    let name = if taken(side) { format!("{side}_{}", applied.effect.place.at) } else { side.to_owned() };
    let value = format!("(when: \"{}\", restitution: \"{}\")", gap_text(applied, below), applied.names[1]);
    text.set(&format!("impacts.{name}"), &value)
}

fn constants(text: &mut Text, model: &TrialModel, applied: &Applied) -> Result<(), SpecTextError> {
    for &k in &applied.parameters {
        let p = &model.system.parameters[k];
        let factor = Unit::parse(&p.unit).map_or(1.0, |u| u.factor);
        let unit = if p.unit.is_empty() { String::new() } else { format!(", unit: \"{}\"", p.unit) };
        let each = if p.each { ", each: true" } else { "" };
        let (start, low, high) = (p.start / factor, p.within.0 / factor, p.within.1 / factor);
        let value = format!("Find(start: {start:?}{unit}, within: ({low:?}, {high:?}){each})");
        text.set(&format!("constants.{}", p.name), &value)?;
    }
    Ok(())
}

fn internal(
    text: &mut Text,
    model: &TrialModel,
    applied: &Applied,
    parts: &mut Parts,
) -> Result<(), SpecTextError> {
    let law = &applied.effect.entry.law;
    let with = replacements(applied);
    for ((_, inner), name) in law.internal.iter().zip(&applied.internal) {
        let unit = applied.effect.unit(&inner.unit, &model.system);
        text.set(&format!("states.{name}"), &format!("\"{unit}\""))?;
    }
    for ((_, inner), name) in law.internal.iter().zip(&applied.internal) {
        let rate = rename(&inner.rate, &with).unwrap_or_else(|_| inner.rate.clone());
        text.set(&format!("known.{name}"), &format!("\"{rate}\""))?;
        parts.rates.push((name.clone(), rate));
        if let Some(inertia) = &inner.inertia {
            let inertia = rename(inertia, &with).unwrap_or_else(|_| inertia.clone());
            text.set(&format!("inertia.{name}"), &format!("\"{inertia}\""))?;
            parts.inertia.push((name.clone(), inertia));
        }
    }
    Ok(())
}

/// Adds the contact of a friction law, if the spec does not list it.
fn contact(
    text: &mut Text,
    model: &TrialModel,
    applied: &Applied,
    all: &mut Vec<String>,
) -> Result<(), SpecTextError> {
    let Site::Force { velocity, .. } = &applied.effect.place.site else { return Ok(()) };
    let at = &velocity.bare().to_owned();
    let base = model.without_effects();
    let of_spec = base.system.contacts.iter().any(|c| c.node == velocity.node);
    if of_spec || all.contains(at) {
        return Ok(());
    }
    all.push(at.clone());
    let list: Vec<String> = all.iter().map(|c| format!("\"{c}\"")).collect();
    text.set("contacts", &format!("[{}]", list.join(", ")))
}

/// What replaces each name of the law in the text.
fn replacements(applied: &Applied) -> Vec<(String, String)> {
    let law = &applied.effect.entry.law;
    let mut with: Vec<(String, String)> = Vec::new();
    if let Site::Force { displacement, velocity, .. } = &applied.effect.place.site {
        let of = |role: LawRole, quantity: Option<&Quantity>| {
            law.role(role).zip(quantity).map(|(name, q)| (name.to_owned(), q.text.clone()))
        };
        with.extend(of(LawRole::Displacement, displacement.as_ref()));
        with.extend(of(LawRole::Velocity, Some(velocity)));
    }
    if applied.counts_from != 0.0 {
        let sign = if applied.counts_from > 0.0 { '-' } else { '+' };
        with.push(("t".to_owned(), format!("(t {sign} {:?})", applied.counts_from.abs())));
    }
    if let Site::Input(_) = applied.effect.place.site {
        with.push((INPUT.to_owned(), applied.effect.place.at.clone()));
    }
    let pressed_by = law.role(LawRole::Load).zip(applied.effect.pressed_by.as_ref());
    with.extend(pressed_by.map(|(name, text)| (name.to_owned(), format!("({text})"))));
    with.extend(law.parameters.iter().zip(&applied.names).map(|((p, _), name)| (p.clone(), name.clone())));
    with.extend(law.given.iter().map(|(name, (value, _))| (name.clone(), format!("{value:?}"))));
    with.extend(law.internal.iter().zip(&applied.internal).map(|((z, _), name)| (z.clone(), name.clone())));
    with
}

/// The subtracted force as text, its load included.
fn force_text(applied: &Applied) -> Option<String> {
    let effect = &applied.effect;
    let force = rename(&effect.entry.law.subtracted(effect.mirror)?, &replacements(applied)).ok()?;
    Some(match &effect.load {
        Some(load) => format!("{load}*({force})"),
        None => force,
    })
}

/// What an effect adds to the rate of its body, or does to a column, in the language of the spec.
pub(crate) fn expression(applied: &Applied) -> String {
    let effect = &applied.effect;
    let (at, name) = (&effect.place.at, applied.names.first().map_or("", String::as_str));
    if let Site::Constant { stated } = effect.place.site {
        // Digits that a person reads.
        let stated: f64 = format!("{stated:.4e}").parse().unwrap_or(stated);
        return format!("the spec says {stated:?}");
    }
    if let Site::Impact { below, .. } = effect.place.site {
        return format!("{} > 0", gap_text(applied, below));
    }
    if effect.is_input_delay() {
        // The law's own number: the constant of the spec, the delay of the record, is its negative.
        return format!("{at}(t - {})", effect.labels().first().map_or("", String::as_str));
    }
    match effect.entry.law.property() {
        Some("offset") => return format!("{at} + {name}"),
        Some("gain") => return format!("{name}*{at}"),
        Some(acts) if effect.entry.law.acting().is_some() => {
            return rename(acts, &replacements(applied)).unwrap_or_default();
        }
        Some("lag") => return format!("{at} with a lag of {name}"),
        Some(_) => return format!("{at}(t - {name})"),
        None => {}
    }
    match (&effect.entry.law.push, &effect.load) {
        (Some(push), None) => rename(push, &replacements(applied)).unwrap_or_default(),
        _ => format!("-({})", force_text(applied).unwrap_or_default()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_models::model;
    use phisindy_phys::{SourceId, check, spec};

    /// Inputs that are drawn otherwise are so in the completed spec, which can be read.
    #[test]
    fn a_completed_spec_draws_its_inputs_as_the_model_does() {
        let text = r#"(states: { "x": "", "v": "" }, constants: { "k": 1.0 }, inputs: { "F": "", "u": "" },
            known: { "x": "v", "v": "F - k*(x - u)" }, unknown: {},
            data: [ Synthetic(truth: {}, start: { "x": 1.0, "v": 0.0 }, duration: 10.0, step: 0.1, seed: 1,
                inputs: { "F": Formula("sin(t)"), "u": Formula("cos(2*t)") }, noise: Additive(0.01)) ])"#;
        let (model, _) = model(text);
        let written = text_with(text, &model, Some(Interpolation::Linear)).expect("a text");
        let (spec, _) = spec::read(&written, SourceId(0)).expect("a spec");
        let (case, _) = check(&spec, SourceId(0)).expect("a case");
        assert_eq!(case.records[0].interpolation, [Interpolation::Linear; 2]);
    }
}
