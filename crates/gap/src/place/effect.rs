//! A law at a place.

use super::needs::Needs;
use super::{Place, Site};
use phisindy_expr::Id;
use phisindy_phys::unit::Unit;
use phisindy_phys::{Law, LawEntry, LawRole, System};
use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

/// A law at a place.
#[derive(Clone, Debug)]
pub struct Effect {
    /// The law.
    pub entry: LawEntry,
    /// The place.
    pub place: Place,
    /// Whether it is the law's mirror image.
    pub mirror: bool,
    /// A constant of the records, a force, that scales the force levels of the law.
    pub load: Option<String>,
    /// The force of the known part that the law's load stands for, in the language of the spec.
    pub pressed_by: Option<String>,
    /// Start value of each parameter of the law (SI).
    pub start: Vec<f64>,
    /// Start values (SI) of the model's movable constants, by name. Example: a damper that compensated for
    /// missing friction gets weaker.
    pub beside: Vec<(String, f64)>,
}

/// Why a law cannot act on a model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum EffectError {
    /// The law uses a name that the model does not have.
    UnknownName {
        /// The law's id.
        law: String,
        /// The name.
        name: String,
    },
    /// The law has no force.
    NoForce(String),
    /// The law is no property of a sensor.
    NoSensor(String),
}

impl fmt::Display for EffectError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            EffectError::UnknownName { law, name } => {
                write!(f, "the law `{law}` uses `{name}`, which the model does not have")
            }
            EffectError::NoForce(law) => write!(f, "the law `{law}` has no force"),
            EffectError::NoSensor(law) => write!(f, "the law `{law}` is no property of a sensor"),
        }
    }
}

impl std::error::Error for EffectError {}

/// The nodes of a model that replace the symbols of a law, except the law's own parameters and states.
pub(crate) fn bindings(effect: &Effect, system: &mut System) -> Result<HashMap<Id, Id>, EffectError> {
    let law = &effect.entry.law;
    let of = law.nodes();
    let start = system.graph.constant(system.counts_from);
    let mut with = HashMap::from([(of.time, system.graph.sub(system.time, start))]);
    if let Site::Force { displacement, velocity, .. } = &effect.place.site {
        with.extend(of.displacement.zip(displacement.as_ref()).map(|(x, place)| (x, place.node)));
        with.extend(of.velocity.map(|v| (v, velocity.node)));
    }
    if let (Site::Input(inputs), Some((symbol, _))) = (&effect.place.site, of.acting) {
        with.insert(symbol, system.inputs[inputs[0]].node);
    }
    if let (Some(symbol), Some(text)) = (of.load, &effect.pressed_by) {
        let node = lowered(system, text)
            .ok_or_else(|| EffectError::UnknownName { law: effect.entry.id.clone(), name: text.clone() })?;
        with.insert(symbol, node);
    }
    for (name, symbol) in &of.outside {
        let node = system
            .quantity(name)
            .ok_or_else(|| EffectError::UnknownName { law: effect.entry.id.clone(), name: name.clone() })?;
        with.insert(*symbol, node);
    }
    Ok(with)
}

/// An expression of the model's own names as a node.
fn lowered(system: &mut System, text: &str) -> Option<Id> {
    let ast = phisindy_expr::parse(text).ok()?;
    let names = &system.names;
    system.graph.lower(&ast, |name| names.get(name)).ok()
}

impl Effect {
    /// A law at a place as it stands, from these start values.
    pub(crate) fn new(entry: LawEntry, place: Place, start: Vec<f64>) -> Effect {
        Effect { entry, place, mirror: false, load: None, pressed_by: None, start, beside: vec![] }
    }

    /// Whether this is a law that another one contains, at the same place.
    pub(crate) fn is_simpler_form_of(&self, rich: &Effect) -> bool {
        rich.place.at == self.place.at
            && rich.load == self.load
            && rich.entry.law.simpler.contains(&self.entry.id)
    }

    /// Whether two effects are the same law at the same place.
    pub fn same(&self, other: &Effect) -> bool {
        self.entry.id == other.entry.id
            && self.place.is(&other.place)
            && self.mirror == other.mirror
            && self.load == other.load
            && self.pressed_by == other.pressed_by
    }

    /// Number of parameters in this many records, of which each has its own value of some.
    pub(crate) fn size(&self, records: usize) -> usize {
        self.entry.law.parameters.iter().map(|(_, p)| if p.each { records } else { 1 }).sum()
    }

    /// The effect with a level of its own in each record: the first coefficient of its force. `None` if it
    /// acts on a sensor, scales with a load, or has one already.
    pub(crate) fn with_own_levels(&self) -> Option<Effect> {
        let &level = self.entry.law.linear_parameters().first()?;
        if self.load.is_some() || self.entry.law.parameters[level].1.each {
            return None;
        }
        let mut law = (*self.entry.law).clone();
        law.parameters[level].1.each = true;
        Some(Effect { entry: LawEntry { law: Arc::new(law), ..self.entry.clone() }, ..self.clone() })
    }

    /// Name of each parameter in results.
    pub fn labels(&self) -> Vec<String> {
        let law = &self.entry.law;
        let forces = law.parameters.iter().filter(|(_, p)| self.scales(&p.unit)).count();
        law.parameters
            .iter()
            .map(|(name, p)| {
                if !self.scales(&p.unit) {
                    return name.clone();
                }
                // `mu` for a single force level; `mus`, `mu0`, ... if there are several.
                match name.strip_prefix('F') {
                    Some(_) if forces == 1 => "mu".into(),
                    Some(rest) => format!("mu{rest}"),
                    None => format!("mu_{name}"),
                }
            })
            .collect()
    }

    /// The name of each parameter's constant, if it is free. The delay of an input's sensor is that of its
    /// record: what acts late was recorded early.
    pub(crate) fn constants(&self) -> Vec<String> {
        if self.is_input_delay() { vec!["delay".into()] } else { self.labels() }
    }

    /// Whether the number in the model is the negative of the law's: the delay of an input.
    pub(crate) fn is_input_delay(&self) -> bool {
        self.entry.law.input.as_deref() == Some("delay")
    }

    /// Whether the load scales a parameter of this unit.
    fn scales(&self, unit: &str) -> bool {
        self.load.is_some() && is_force(unit)
    }

    /// The force that the effect subtracts, its load included, and the rates of its internal states, as nodes
    /// of the system. The system must hold the effect's parameters and states already.
    ///
    /// # Errors
    /// The law has no force, or uses a name that the system does not have.
    pub(crate) fn force(
        &self,
        system: &mut System,
        parameters: &[Id],
        internal: &[Id],
    ) -> Result<(Id, Vec<Id>), EffectError> {
        let of = self.entry.law.nodes();
        let force = if self.mirror { of.mirror } else { of.force };
        let (mut force, rates) = self.with_rates(force, system, parameters, internal)?;
        if let Some(load) = &self.load {
            let load = system
                .quantity(load)
                .ok_or_else(|| EffectError::UnknownName { law: self.entry.id.clone(), name: load.clone() })?;
            force = system.graph.mul(load, force);
        }
        Ok((force, rates))
    }

    /// What acts in the place of an input, and the rates of the effect's internal states, as nodes of the system.
    ///
    /// # Errors
    /// As [`Effect::force`].
    pub(crate) fn acting(
        &self,
        input: usize,
        system: &mut System,
        parameters: &[Id],
        internal: &[Id],
    ) -> Result<(Id, Vec<Id>), EffectError> {
        let place = Place { site: Site::Input(vec![input]), ..self.place.clone() };
        let acts = self.entry.law.nodes().acting.map(|(_, acts)| acts);
        Effect { place, ..self.clone() }.with_rates(acts, system, parameters, internal)
    }

    /// An expression of the law, and the rates of its internal states, as nodes of the system.
    fn with_rates(
        &self,
        expression: Option<Id>,
        system: &mut System,
        parameters: &[Id],
        internal: &[Id],
    ) -> Result<(Id, Vec<Id>), EffectError> {
        let of = self.entry.law.nodes();
        let expression = expression.ok_or_else(|| EffectError::NoForce(self.entry.id.clone()))?;
        let mut with = bindings(self, system)?;
        with.extend(of.parameters.iter().copied().zip(parameters.iter().copied()));
        with.extend(of.internal.iter().copied().zip(internal.iter().copied()));
        let roots: Vec<Id> = [expression].into_iter().chain(of.rates.iter().copied()).collect();
        let nodes = system.graph.graft(&of.graph, &roots, &with).map_err(|symbol| {
            EffectError::UnknownName { law: self.entry.id.clone(), name: of.names.name(symbol).to_owned() }
        })?;
        Ok((nodes[0], nodes[1..].to_vec()))
    }

    /// The inertias of the bodies that the effect brings along, as nodes of the system, each with the internal state that
    /// is its speed.
    pub(crate) fn inertias(&self, system: &mut System, parameters: &[Id]) -> Vec<(usize, Id)> {
        let of = self.entry.law.nodes();
        let with: HashMap<Id, Id> = of.parameters.iter().copied().zip(parameters.iter().copied()).collect();
        let all = of.inertias.iter().enumerate().filter_map(|(j, inertia)| Some((j, (*inertia)?)));
        all.filter_map(|(j, inertia)| Some((j, system.graph.graft(&of.graph, &[inertia], &with).ok()?[0])))
            .collect()
    }

    /// Converts a unit of the law to the units of the place, without the load.
    pub fn unit(&self, unit: &str, system: &System) -> String {
        self.place.unit(unit, if self.scales(unit) { -1.0 } else { 0.0 }, system)
    }
}

/// Whether a unit contains a force: its power of the kilogram is one.
pub(crate) fn is_force(unit: &str) -> bool {
    Unit::parse(unit).is_ok_and(|u| u.dimension.powers()[0] == 1.0)
}

/// Text of a unit from powers of its parts, e.g. `N*s/m`.
pub(crate) fn product(parts: &[(&str, f64)]) -> String {
    let mut parts: Vec<(&str, f64)> = parts.iter().copied().filter(|(u, _)| !u.is_empty()).collect();
    // A unit may occur twice; its powers are added.
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

/// What a law acts on.
pub(crate) fn needs(law: &Law) -> Needs {
    if law.sensor.is_some() {
        Needs::Sensor
    } else if law.input.is_some() {
        Needs::Input
    } else if law.role(LawRole::Load).is_some() {
        Needs::Load
    } else if law.role(LawRole::Displacement).is_some() {
        Needs::Displacement
    } else {
        Needs::Velocity
    }
}

/// Whether a law can act at a place.
pub(crate) fn fits(law: &Law, place: &Place) -> bool {
    // A prescribed motion has no rate in which forces of the known part stand.
    if law.role(LawRole::Load).is_some()
        && !matches!(&place.site, Site::Force { acts, .. } if !acts.is_empty())
    {
        return false;
    }
    match &place.site {
        Site::Sensor(columns) => match law.sensor.as_deref() {
            // Columns of different units have no common offset.
            Some("offset") => columns.len() == 1,
            Some(_) => true,
            None => false,
        },
        // What acts for the rate of an input too is its factor or its delay.
        Site::Input(inputs) => match law.acting() {
            Some(_) => inputs.len() == 1 || law.is_input_gain(),
            None => law.input.is_some(),
        },
        Site::Constant { .. } | Site::Impact { .. } => false,
        Site::Force { displacement, .. } => {
            // A force that uses no quantity of the place is the same on the body as between body and base.
            let told_apart = !(law.roles.is_empty() && place.is_on_base());
            let has_role = law.role(LawRole::Displacement).is_none() || displacement.is_some();
            law.property().is_none() && told_apart && has_role
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_multiply() {
        assert_eq!(product(&[("N", 1.0), ("m", -1.0), ("s", 1.0)]), "N*s/m");
        assert_eq!(product(&[("V", -2.0), ("s", -2.0)]), "1/(V^2*s^2)");
        assert_eq!(product(&[("N", 0.0), ("m", 0.0)]), "");
    }
}
