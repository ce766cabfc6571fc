//! A law at a place, and how it is written into a spec: a term in the known rates with movable constants, a contact, a sensor parameter.

use crate::place::{Place, Site};
use phisindy_phys::spec::{self, Spec};
use phisindy_phys::unit::{Dimension, Unit};
use phisindy_phys::{Law, SourceId, System, splice, takes_units};
use std::sync::Arc;

/// A law of the catalogue with its id.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The name of its file.
    pub id: String,
    /// What it says.
    pub law: Arc<Law>,
}

/// A law at a place.
#[derive(Clone, Debug)]
pub struct Effect {
    /// Which law.
    pub entry: Entry,
    /// Where.
    pub place: Place,
    /// Whether it is the law's mirror image.
    pub mirror: bool,
    /// A constant of the records, a force, that its levels scale with.
    pub load: Option<String>,
    /// For each parameter of the law where its search starts (SI).
    pub start: Vec<f64>,
    /// Where movable constants of the model start beside it (SI), by name: a damper that stood in for friction gives way to it.
    pub beside: Vec<(String, f64)>,
}

/// What was written for an effect.
#[derive(Clone, Debug)]
pub struct Written {
    /// The whole spec.
    pub text: String,
    /// The constant of each parameter of the law.
    pub names: Vec<String>,
    /// What was added to the rate, or the sensor parameter.
    pub expression: String,
    /// States that belong to the law.
    pub internal: Vec<String>,
}

impl Effect {
    /// Whether two effects are the same law at the same place.
    pub fn same(&self, other: &Effect) -> bool {
        self.entry.id == other.entry.id
            && self.place.at == other.place.at
            && self.place.site == other.place.site
            && self.mirror == other.mirror
            && self.load == other.load
    }

    /// What each parameter is called in results.
    pub fn labels(&self) -> Vec<String> {
        let law = &self.entry.law;
        let forces = law.parameters.iter().filter(|(_, p)| self.scales(&p.unit)).count();
        law.parameters
            .iter()
            .map(|(name, p)| {
                if !self.scales(&p.unit) {
                    return name.clone();
                }
                // mu for the level, mus, mu0, ... for more of them.
                match name.strip_prefix('F') {
                    Some(_) if forces == 1 => "mu".into(),
                    Some(rest) => format!("mu{rest}"),
                    None => format!("mu_{name}"),
                }
            })
            .collect()
    }

    /// Whether a parameter of this unit is one that a load scales.
    fn scales(&self, unit: &str) -> bool {
        self.load.is_some() && Unit::parse(unit).is_ok_and(|u| u.dimension.powers()[0] == 1.0)
    }

    /// The spec with this effect in it.
    ///
    /// # Errors
    /// In words: the spec cannot hold it.
    pub fn written(&self, text: &str, system: &System) -> Result<Written, String> {
        let (spec, _) = spec::read(text, SourceId(0)).map_err(|d| first(&d))?;
        let law = &self.entry.law;
        let labels = self.labels();
        let mut taken: Vec<String> = taken(&spec);
        let names: Vec<String> = labels.iter().map(|label| free(label, &self.place.at, &mut taken)).collect();
        let units = takes_units(&spec, SourceId(0));
        let mut text = text.to_owned();
        for (k, (_, p)) in law.parameters.iter().enumerate() {
            let unit = if units { self.unit(&p.unit, system) } else { String::new() };
            let start = self.start[k].clamp(p.within.0, p.within.1);
            let unit = if unit.is_empty() { String::new() } else { format!(", unit: \"{unit}\"") };
            let each = if p.each { ", each: true" } else { "" };
            let value =
                format!("Find(start: {start:?}{unit}, within: ({:?}, {:?}){each})", p.within.0, p.within.1);
            text = set(&text, &format!("constants.{}", names[k]), &value)?;
        }
        match &self.place.site {
            Site::Sensor(states) => self.on_sensors(text, &spec, system, states, names),
            Site::Force { displacement, velocity, acts, .. } => {
                self.on_rates(text, &spec, system, displacement.as_deref(), velocity, acts, names, &mut taken)
            }
        }
    }

    #[allow(clippy::too_many_arguments)] // everything that the place says
    fn on_rates(
        &self,
        mut text: String,
        spec: &Spec,
        system: &System,
        displacement: Option<&str>,
        velocity: &str,
        acts: &[(usize, f64)],
        names: Vec<String>,
        taken: &mut Vec<String>,
    ) -> Result<Written, String> {
        let law = &self.entry.law;
        let mut with: Vec<(String, String)> = Vec::new();
        let (x, v) = (role(law, 'x'), role(law, 'v'));
        with.extend(x.zip(displacement).map(|(x, d)| (x, d.to_owned())));
        with.extend(v.map(|v| (v, velocity.to_owned())));
        with.extend(law.parameters.iter().zip(&names).map(|((p, _), name)| (p.clone(), name.clone())));
        with.extend(law.given.iter().map(|(name, (value, _))| (name.clone(), format!("{value:?}"))));
        let mut internal = Vec::new();
        for (name, inner) in &law.internal {
            let state = free(name, &self.place.at, taken);
            with.push((name.clone(), state.clone()));
            text =
                set(&text, &format!("states.{state}"), &format!("\"{}\"", self.unit(&inner.unit, system)))?;
            internal.push(state);
        }
        for ((_, inner), state) in law.internal.iter().zip(&internal) {
            text = set(&text, &format!("known.{state}"), &format!("\"{}\"", substitute(&inner.rate, &with)))?;
        }
        let force = law.subtracted(self.mirror).ok_or("this law has no force")?;
        let mut force = substitute(&force, &with);
        if let Some(load) = &self.load {
            force = format!("{load}*({force})");
        }
        for &(state, sign) in acts {
            let name = &system.states[state].name;
            let known = spec.known.iter().find(|(n, _)| n.value == *name).ok_or("a state without a rate")?;
            let inertia = spec.inertia.iter().find(|(n, _)| n.value == *name).map(|(_, m)| &m.value);
            let over = inertia.map_or(String::new(), |m| format!("/({m})"));
            let sign = if sign < 0.0 { '-' } else { '+' };
            let rate = format!("\"{} {sign} ({force}){over}\"", known.1.value);
            text = set(&text, &format!("known.{name}"), &rate)?;
        }
        if law.sticks() {
            let contact = velocity.trim_start_matches('(').trim_end_matches(')');
            let mut all: Vec<&str> = spec.contacts.iter().map(|c| c.value.as_str()).collect();
            if !all.iter().any(|c| c.replace(' ', "") == contact) {
                all.push(contact);
                let list: Vec<String> = all.iter().map(|c| format!("\"{c}\"")).collect();
                text = set(&text, "contacts", &format!("[{}]", list.join(", ")))?;
            }
        }
        let expression = if force.starts_with("-(") && force.ends_with(')') && law.push.is_some() {
            force[2..force.len() - 1].to_owned()
        } else {
            format!("-({force})")
        };
        Ok(Written { text, names, expression, internal })
    }

    fn on_sensors(
        &self,
        mut text: String,
        spec: &Spec,
        system: &System,
        states: &[usize],
        names: Vec<String>,
    ) -> Result<Written, String> {
        let which = self.entry.law.sensor.as_deref().ok_or("this law has no sensor")?;
        for record in 0..spec.data.len() {
            for &state in states {
                let path = format!("data.{record}.sensors.{}.{which}", system.states[state].name);
                text = set(&text, &path, &format!("\"{}\"", names[0]))?;
            }
        }
        let expression = match which {
            "offset" => format!("{} + {}", self.place.at, names[0]),
            "gain" => format!("{}*{}", names[0], self.place.at),
            _ => format!("{}(t - {})", self.place.at, names[0]),
        };
        Ok(Written { text, names, expression, internal: vec![] })
    }

    /// A unit of the law in the units of the place: a law speaks of newtons and metres, the model perhaps of volts, radians, or forces per mass.
    pub fn unit(&self, unit: &str, system: &System) -> String {
        let Ok(parsed) = Unit::parse(unit) else { return String::new() };
        let Site::Force { state, .. } = &self.place.site else {
            let Site::Sensor(states) = &self.place.site else { return String::new() };
            // An offset has the unit of its column.
            return if unit == "m" { system.states[states[0]].unit.clone() } else { unit.to_owned() };
        };
        let [kg, m, s, ..] = parsed.dimension.powers();
        // Newtons, metres, seconds.
        let (force, length, time) = (kg, m - kg, s + 2.0 * kg);
        let force = if self.scales(unit) { force - 1.0 } else { force };
        let v = &system.states[*state];
        let x = system.states.iter().find(|x| x.velocity == Some(*state));
        let x_unit = x.map_or("", |x| x.unit.as_str());
        let dimension = |u: &str| Unit::parse(u).map_or(Dimension::NONE, |u| u.dimension);
        let lengths = x.is_none_or(|_| dimension(x_unit) == Dimension::METRE);
        let si_velocity = dimension(&v.unit) == Dimension::METRE.div(Dimension::SECOND);
        let mut parts: Vec<(&str, f64)> = Vec::new();
        match (system.inertia[*state].is_some(), lengths && si_velocity) {
            (true, true) => parts.extend([("N", force), ("m", length), ("s", time)]),
            (true, false) => parts.extend([("N", force), ("m", force), (x_unit, length), ("s", time)]),
            (false, true) => parts.extend([("m", force + length), ("s", time - 2.0 * force)]),
            (false, false) => parts.extend([(x_unit, force + length), ("s", time - 2.0 * force)]),
        }
        if unit == "rad" {
            return "rad".into();
        }
        product(&parts)
    }
}

/// A unit from powers: `N*s/m`.
fn product(parts: &[(&str, f64)]) -> String {
    let mut parts: Vec<(&str, f64)> = parts.iter().copied().filter(|(u, _)| !u.is_empty()).collect();
    // A metre may come twice.
    for k in (1..parts.len()).rev() {
        if let Some(j) = (0..k).find(|&j| parts[j].0 == parts[k].0) {
            parts[j].1 += parts[k].1;
            parts.remove(k);
        }
    }
    let power = |(u, p): &(&str, f64)| {
        let p = p.abs();
        if p == 1.0 { (*u).to_owned() } else { format!("{u}^{p}") }
    };
    let top: Vec<String> = parts.iter().filter(|(_, p)| *p > 0.0).map(power).collect();
    let bottom: Vec<String> = parts.iter().filter(|(_, p)| *p < 0.0).map(power).collect();
    let top = if top.is_empty() && !bottom.is_empty() { "1".to_owned() } else { top.join("*") };
    match bottom.len() {
        0 => top,
        1 => format!("{top}/{}", bottom[0]),
        _ => format!("{top}/({})", bottom.join("*")),
    }
}

/// The name that a law gives to displacement (`x`) or velocity (`v`): by the unit of the role.
pub(crate) fn role(law: &Law, which: char) -> Option<String> {
    let of = |unit: &str| Unit::parse(unit).map(|u| u.dimension).ok();
    let wanted = if which == 'x' { Dimension::METRE } else { Dimension::METRE.div(Dimension::SECOND) };
    law.roles.iter().find(|(_, unit)| of(unit) == Some(wanted)).map(|(name, _)| name.clone())
}

/// Whether a law can act at a place.
pub(crate) fn fits(law: &Law, place: &Place) -> bool {
    match &place.site {
        Site::Sensor(states) => match law.sensor.as_deref() {
            // An offset common to all columns, of different units, is nothing.
            Some("offset") => states.len() == 1,
            Some(_) => true,
            None => false,
        },
        Site::Force { displacement, .. } => {
            // A push that asks for nothing of the place is the same against the wall as against the base.
            let told_apart = !(law.roles.is_empty() && place.is_on_base());
            law.sensor.is_none() && told_apart && (role(law, 'x').is_none() || displacement.is_some())
        }
    }
}

/// Names in the place of names, all at once.
pub(crate) fn substitute(text: &str, with: &[(String, String)]) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let number = c.is_ascii_digit() || c == '.';
        let word = c.is_alphabetic() || c == '_';
        let len = if number {
            // 1e-6 is one number, not a name `e`.
            let mut end = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
            let tail = &rest[end..];
            if tail.starts_with(['e', 'E']) {
                let sign = usize::from(tail[1..].starts_with(['+', '-']));
                let digits = tail[1 + sign..].chars().take_while(char::is_ascii_digit).count();
                if digits > 0 {
                    end += 1 + sign + digits;
                }
            }
            end
        } else if word {
            rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len())
        } else {
            c.len_utf8()
        };
        let part = &rest[..len];
        match with.iter().find(|(name, _)| word && name == part) {
            Some((_, replacement)) => out.push_str(replacement),
            None => out.push_str(part),
        }
        rest = &rest[len..];
    }
    out
}

fn set(text: &str, path: &str, value: &str) -> Result<String, String> {
    splice::set(text, path, value).map_err(|e| e.to_string())
}

fn first(diagnostics: &[phisindy_phys::Diagnostic]) -> String {
    diagnostics.iter().find(|d| d.is_error()).map_or(String::new(), |d| d.message.clone())
}

/// All names that a spec uses.
fn taken(spec: &Spec) -> Vec<String> {
    let of_records = spec.data.iter().flat_map(|d| match d {
        spec::DataSpec::Csv(c) => &c.constants,
        spec::DataSpec::Synthetic(s) => &s.constants,
    });
    spec.states
        .iter()
        .chain(&spec.inputs)
        .map(|(n, _)| n.value.clone())
        .chain(spec.constants.iter().map(|(n, _)| n.value.clone()))
        .chain(of_records.map(|(n, _)| n.value.clone()))
        .collect()
}

/// A name that is not taken: as wished, with the place behind it, or with a number.
fn free(wish: &str, at: &str, taken: &mut Vec<String>) -> String {
    let plain: String = at.chars().filter(|c| c.is_alphanumeric()).collect();
    let usable = |name: &str, taken: &[String]| {
        !taken.iter().any(|t| t == name)
            && name != "t"
            && name != "pi"
            && phisindy_expr::ops::function(name).is_none()
    };
    let mut names = [wish.to_owned(), format!("{wish}_{plain}")]
        .into_iter()
        .chain((2..).map(|k| format!("{wish}_{plain}{k}")));
    let name = names.find(|n| usable(n, taken)).unwrap_or_else(|| wish.to_owned());
    taken.push(name.clone());
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_replaced_whole_and_at_once() {
        let with = [("x".to_owned(), "v".to_owned()), ("v".to_owned(), "(x-y)".to_owned())];
        assert_eq!(substitute("x*exp(v)+1e-6*ex", &with), "v*exp((x-y))+1e-6*ex");
        // The time is a name like any other.
        let time = [("t".to_owned(), "(s*t)".to_owned())];
        let other = substitute("F*cos(2.5*t + t0) - dt*tanh(t)/(t_1+t)", &time);
        assert_eq!(other, "F*cos(2.5*(s*t) + t0) - dt*tanh((s*t))/(t_1+(s*t))");
        assert_eq!(substitute("-k*x", &time), "-k*x");
    }

    /// Where only states and inputs have units, and these do not fit without a mass, a constant with a unit would turn a warning into a mistake.
    #[test]
    fn a_spec_without_units_gets_none() {
        let written = |k: &str| {
            let text = format!(
                r#"(constants: {{ "k": {k} }}, states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "F": "N" }}, known: {{ "x": "v", "v": "F - k*x" }}, unknown: {{}},
                data: [Csv(path: "a.csv", time: "t", columns: {{ "x": "x", "v": "v", "F": "F" }})])"#
            );
            let (spec, _) = spec::read(&text, SourceId(0)).expect("a spec");
            let (case, _) = phisindy_phys::check_names(&spec, SourceId(0)).expect("a case");
            let law = Law::read(include_str!("../../../specs/laws/coulomb.ron")).expect("a law");
            let place = crate::place::places(&case.system, &case.records, &[]).remove(0);
            let entry = Entry { id: "coulomb".into(), law: Arc::new(law) };
            let effect = Effect { entry, place, mirror: false, load: None, start: vec![1.0], beside: vec![] };
            effect.written(&text, &case.system).expect("a text").text
        };
        let plain = written("7.5");
        let (spec, _) = spec::read(&plain, SourceId(0)).expect("a spec");
        assert!(!plain.contains("m/s^2") && phisindy_phys::check(&spec, SourceId(0)).is_ok(), "{plain}");
        assert!(written("(7.5, \"N/m\")").contains("m/s^2"));
    }

    #[test]
    fn units_multiply() {
        assert_eq!(product(&[("N", 1.0), ("m", -1.0), ("s", 1.0)]), "N*s/m");
        assert_eq!(product(&[("V", -2.0), ("s", -2.0)]), "1/(V^2*s^2)");
        assert_eq!(product(&[("N", 0.0), ("m", 0.0)].map(|(u, p)| (u, p))), "");
    }
}
