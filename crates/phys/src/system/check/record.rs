//! What measured and synthetic records share: constants, sensors, derived inputs, interpolation, start
//! values.

use super::checker::Checker;
use crate::system::constants::Value;
use crate::system::equations::System;
use crate::system::sensor::{Sensor, SensorParameter, SensorPart};
use crate::text::spec::{DataSpec, DeriveSpec, Number, SensorSpec, SensorValue, Spec, Text};
use crate::units::unit::Unit;
use phisindy_signal::{Differentiator, Interpolation};

impl Checker {
    pub(super) fn record_constants(
        &mut self,
        data: &DataSpec,
        spec: &Spec,
        system: &System,
        name: &Text,
    ) -> Vec<Value> {
        let mut values = Vec::new();
        for (constant, _) in &system.record_constants {
            let own = data.constants().iter().find(|(n, _)| n.value == *constant);
            let value = match own {
                Some((name, c)) => self.record_value(name, c, spec),
                None => self.constants.default_of(constant).cloned(),
            };
            if value.is_none() && own.is_none() {
                self.error(format!("this record has no value for constant `{constant}`"), name.span, "")
                    .help
                    .push(format!("add `constants: {{ \"{constant}\": ... }}` to it"));
            }
            values.push(value.unwrap_or(Value::Number(1.0)));
        }
        values
    }

    /// The sensors of a record, in which `derived` inputs have those of the inputs that they are derived
    /// from.
    pub(super) fn sensors(
        &mut self,
        sensors: &[(Text, SensorSpec)],
        derived: &[Option<usize>],
        system: &System,
    ) -> Vec<Sensor> {
        let mut all = vec![Sensor::default(); system.columns() + system.inputs.len()];
        for (name, sensor) in sensors {
            let Some(index) = system.sensor(&name.value) else {
                self.unknown_name(&name.value, name.span, "column in `sensors`", &quantity_names(system));
                continue;
            };
            if let Some((step, unit)) = &sensor.quantum {
                let theirs = unit.as_ref().map(|unit| (unit, self.unit(unit)));
                let own = system.quantities().nth(index).map_or("", |(_, own)| own);
                let wrong = |unit: Unit| Unit::parse(own).is_ok_and(|own| own.dimension != unit.dimension);
                if let Some((unit, _)) = theirs.filter(|(_, theirs)| wrong(*theirs)) {
                    let message = format!(
                        "the quantum of `{}` is in `{}`, and it is in `{own}`",
                        name.value, unit.value
                    );
                    self.error(message, unit.span, "").help.push("give a unit of the same kind".into());
                }
                all[index].quantum = Some(self.si(step, theirs.map_or(1.0, |(_, unit)| unit.factor)));
            }
            if let Some((time, unit)) = &sensor.average {
                all[index].average = self.average(name, time, unit.as_ref(), index < system.columns());
            }
            let slots = [&sensor.offset, &sensor.gain, &sensor.delay, &sensor.clock, &sensor.lag];
            for (part, value) in SensorPart::ALL.into_iter().zip(slots) {
                let Some(value) = value else { continue };
                let parameter = match value {
                    SensorValue::Number(x) => {
                        if part == SensorPart::Gain && x.value == 0.0 {
                            self.error("a gain of 0 shows nothing of what is measured", x.span, "")
                                .help
                                .push(
                                    "write the factor from the quantity to the reading, or `Find(...)`"
                                        .into(),
                                );
                        }
                        SensorParameter::fixed(x.value)
                    }
                    SensorValue::Constant(name) => match self.sensor_constant(name, system) {
                        Some(parameter) => parameter,
                        None => continue,
                    },
                    SensorValue::Find(f) => {
                        let factor = f.unit.as_ref().map_or(1.0, |u| self.unit(u).factor);
                        let within = Some((self.si(&f.within.0, factor), self.si(&f.within.1, factor)));
                        SensorParameter {
                            start: self.si(&f.start, factor),
                            within,
                            sigma: f.sigma.as_ref().map(|s| self.si(s, factor)),
                            shared: None,
                        }
                    }
                };
                if part == SensorPart::Lag {
                    self.lag(name, &parameter, index < system.columns());
                }
                *all[index].parameters_mut()[part as usize] = parameter;
            }
        }
        let n = system.columns();
        for (k, of) in derived.iter().enumerate().filter_map(|(k, of)| Some((k, (*of)?))) {
            // A zero error has no derivative.
            all[n + k] =
                Sensor { offset: SensorParameter::fixed(0.0), follows: Some(of), ..all[n + of].clone() };
        }
        all
    }

    /// Over how long the samples of a column are means (s).
    fn average(&mut self, name: &Text, time: &Number, unit: Option<&Text>, is_compared: bool) -> f64 {
        let second = Unit::parse("s").map(|unit| unit.dimension);
        let theirs = unit.map(|unit| self.unit(unit)).unwrap_or(Unit::ONE);
        if unit.is_some() && second != Ok(theirs.dimension) || time.value < 0.0 {
            let message = format!("`{}` is averaged over no time", name.value);
            self.error(message, unit.map_or(time.span, |unit| unit.span), "")
                .help
                .push("write a time, as in (10.0, \"ms\")".into());
            return 0.0;
        }
        if !is_compared {
            let message = format!("`{}` is an input: what acts on the rig is no mean", name.value);
            self.error(message, time.span, "").help.push(
                "state what acts at each moment; a mean over so short a time is late by half of it: `delay`"
                    .into(),
            );
        }
        self.si(time, theirs.factor)
    }

    /// A sensor does not follow what is to come, and what acts on the rig does not lag.
    fn lag(&mut self, name: &Text, lag: &SensorParameter, is_compared: bool) {
        let span = name.span;
        if lag.within.map_or(lag.start, |within| within.0) < 0.0 {
            let message = format!("`{}` would follow what is to come", name.value);
            self.error(message, span, "")
                .help
                .push("a lag is a time from 0 on; what is early has a negative `delay`".into());
        }
        if !is_compared {
            let message = format!("`{}` is an input: what acts on the rig does not lag", name.value);
            self.error(message, span, "").help.push(
                "write what acts as a state that follows the input: `\"z\": \"(u - z)/tau\"`; a short lag is a `delay`".into(),
            );
        }
    }

    /// A sensor parameter that is a constant of the case.
    fn sensor_constant(&mut self, name: &Text, system: &System) -> Option<SensorParameter> {
        self.used.insert(name.value.clone());
        if let Some((_, value)) = system.constants.iter().find(|(n, _)| *n == name.value) {
            return Some(SensorParameter::fixed(*value));
        }
        let Some(shared) = system.parameters.iter().position(|p| p.name == name.value) else {
            let names: Vec<&str> = system
                .constants
                .iter()
                .map(|(n, _)| n.as_str())
                .chain(system.parameters.iter().map(|p| p.name.as_str()))
                .collect();
            self.unknown_name(&name.value, name.span, "constant", &names);
            return None;
        };
        let p = &system.parameters[shared];
        Some(SensorParameter { start: p.start, within: Some(p.within), sigma: None, shared: Some(shared) })
    }

    /// For each input, what it is derived from, and how.
    pub(super) fn derived(
        &mut self,
        derive: &[(Text, DeriveSpec)],
        system: &System,
    ) -> (Vec<Option<usize>>, Vec<Differentiator>) {
        let names: Vec<&str> = system.inputs.iter().map(|u| u.name.as_str()).collect();
        let mut derived = vec![None; names.len()];
        let mut differentiators = vec![Differentiator::default(); names.len()];
        for (name, DeriveSpec::Derivative(of, how)) in derive {
            match (system.input(&name.value), system.input(&of.value)) {
                (Some(k), Some(u)) if k != u => {
                    (derived[k], differentiators[k]) = (Some(u), how.unwrap_or_default());
                }
                (Some(_), Some(_)) => {
                    self.error(format!("`{}` cannot be its own derivative", name.value), of.span, "");
                }
                (None, _) => self.unknown_name(&name.value, name.span, "input in `derive`", &names),
                (_, None) => self.unknown_name(&of.value, of.span, "input", &names),
            }
        }
        (derived, differentiators)
    }

    pub(super) fn interpolation(
        &mut self,
        given: &[(Text, Interpolation)],
        system: &System,
    ) -> Vec<Interpolation> {
        let mut all = vec![Interpolation::Cubic; system.inputs.len()];
        for (name, kind) in given {
            match system.input(&name.value) {
                Some(k) => all[k] = *kind,
                None => {
                    let names: Vec<&str> = system.inputs.iter().map(|u| u.name.as_str()).collect();
                    self.unknown_name(&name.value, name.span, "input in `interpolate`", &names);
                }
            }
        }
        all
    }

    pub(super) fn start(&mut self, given: &[(Text, Number)], system: &System) -> Vec<Option<f64>> {
        let mut start = vec![None; system.states.len()];
        let names: Vec<&str> = system.states.iter().map(|s| s.name.as_str()).collect();
        for (name, value) in given {
            match system.state(&name.value) {
                Some(k) => start[k] = Some(self.si(value, system.states[k].factor)),
                None => self.unknown_name(&name.value, name.span, "state in `start`", &names),
            }
        }
        start
    }
}

/// The names of what a sensor can measure: the states, the outputs, the inputs.
pub(super) fn quantity_names(system: &System) -> Vec<&str> {
    let own =
        |(k, (name, _)): (usize, (&'_ str, &'_ str))| system.sensor(name) == Some(k) && !name.contains(' ');
    system.quantities().enumerate().filter(|&q| own(q)).map(|(_, (name, _))| name).collect()
}
