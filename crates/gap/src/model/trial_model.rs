//! The model of a spec with effects added to its graph, and the records as that system sees them.

use crate::place::{Effect, EffectError, Entry, Place, Quantity, Site, fits, places};
use phisindy_expr::Id;
use phisindy_phys::spec::{ConstantSpec, DataSpec, Movable, Number, Role, Spec};
use phisindy_phys::unit::Unit;
use phisindy_phys::{
    Case, Contact, Impact, Law, Record, RecordPlan, Sensor, SensorParameter, SensorPart, SourceId, System,
    check_names, takes_units,
};
use phisindy_sim::Stop;
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::Arc;

/// An effect that was added to a model.
#[derive(Clone, Debug)]
pub struct Applied {
    /// Law, place and start values.
    pub effect: Effect,
    /// Name of the constant for each parameter of the law.
    pub names: Vec<String>,
    /// Their indices into [`System::parameters`].
    pub parameters: Vec<usize>,
    /// Names of the internal states of the law.
    pub internal: Vec<String>,
    /// The subtracted force, a node of the system's graph; `None` for an effect on sensors.
    pub force: Option<phisindy_expr::Id>,
    /// The time from which the law counts.
    pub counts_from: f64,
}

/// What all models of one search share.
#[derive(Clone, Debug)]
pub(crate) struct Given {
    /// The spec as it was read.
    pub(crate) spec: Spec,
    /// The plan of each record.
    pub(crate) plans: Vec<RecordPlan>,
    /// Where laws can act.
    pub(crate) places: Vec<Place>,
    /// Names of the record constants that are forces.
    forces: Vec<String>,
    /// Whether a constant that is added may have a unit.
    takes_units: bool,
}

/// A model under test.
#[derive(Clone, Debug)]
pub struct TrialModel {
    /// The system with its effects.
    pub system: System,
    /// The records, for this system.
    pub records: Arc<Vec<Record>>,
    /// Smoothed states of the records, the start of every fit.
    pub smooth: Arc<Vec<Record>>,
    /// The effects that were added, in their order.
    pub effects: Vec<Applied>,
    pub(crate) given: Arc<Given>,
    /// The chi square that the model without effects leaves; 0 where it was not fitted.
    pub(crate) missed: f64,
    /// Ends fits where they are.
    pub(crate) stop: Stop,
    /// The model without any effect; `None` if this is it.
    base: Option<Arc<TrialModel>>,
}

impl TrialModel {
    /// The model of a spec.
    pub fn base(spec: Spec, case: Case, records: Vec<Record>) -> TrialModel {
        let smooth: Vec<Record> =
            records.par_iter().map(|r| phisindy_learn::smoothed(&case.system, r)).collect();
        let records = phisindy_learn::sized(&case.system, &records, &smooth);
        let first = records.iter().filter_map(|r| r.time.first().copied()).reduce(f64::min);
        TrialModel::of(spec, case, records, smooth).counting_from(first.unwrap_or(0.0))
    }

    /// The same model, whose laws count time from here.
    fn counting_from(mut self, start: f64) -> TrialModel {
        self.system.counts_from = start;
        self
    }

    /// The same model, whose fits end as this says.
    pub(crate) fn stopped_by(self, stop: Stop) -> TrialModel {
        TrialModel { stop, ..self }
    }

    /// The same model with the states that only outputs tell at rest where fits start; `None` if there are
    /// none.
    pub(crate) fn at_rest(&self) -> Option<TrialModel> {
        let system = &self.system;
        if !self.records.iter().any(|r| phisindy_learn::reads_outputs(system, r)) {
            return None;
        }
        let smooth: Vec<Record> =
            self.records.par_iter().map(|r| phisindy_learn::differentiated(system, r)).collect();
        let records = phisindy_learn::sized(system, &self.records, &smooth);
        Some(TrialModel { records: Arc::new(records), smooth: Arc::new(smooth), ..self.clone() })
    }

    fn of(spec: Spec, case: Case, records: Vec<Record>, smooth: Vec<Record>) -> TrialModel {
        let Case { mut system, records: plans, .. } = case;
        let places = places(&mut system, &plans);
        let names = system.record_constants.iter().map(|(name, _)| name);
        let forces = names.filter(|name| is_force_of_records(&spec, name)).cloned().collect();
        let takes_units = takes_units(&spec, SourceId(0));
        TrialModel {
            system,
            records: Arc::new(records),
            smooth: Arc::new(smooth),
            effects: vec![],
            given: Arc::new(Given { spec, plans, places, forces, takes_units }),
            missed: 0.0,
            stop: Stop::default(),
            base: None,
        }
    }

    /// The model of a changed spec with the same states and records, without effects.
    ///
    /// `None` if the changed spec is invalid.
    pub(crate) fn variant(&self, spec: Spec) -> Option<TrialModel> {
        let base = self.without_effects();
        let (case, _) = check_names(&spec, SourceId(0)).ok()?;
        let seen = |records: &[Record]| -> Vec<Record> {
            let with =
                |(r, plan): (&Record, &RecordPlan)| Record { sensors: plan.sensors.clone(), ..r.clone() };
            records.iter().zip(&case.records).map(with).collect()
        };
        let (records, smooth) = (seen(&base.records), seen(&base.smooth));
        Some(TrialModel {
            missed: base.missed,
            stop: base.stop,
            ..TrialModel::of(spec, case, records, smooth).counting_from(base.system.counts_from)
        })
    }

    /// The same model on other records, e.g. shortened ones.
    pub(crate) fn for_records(&self, records: Vec<Record>) -> TrialModel {
        let smooth = records.iter().map(|r| phisindy_learn::smoothed(&self.system, r)).collect();
        TrialModel { records: Arc::new(records), smooth: Arc::new(smooth), ..self.clone() }
    }

    /// An effect of this model, before its force is known.
    fn applied(&self, effect: &Effect, names: Vec<String>, parameters: Vec<usize>) -> Applied {
        let counts_from = self.system.counts_from;
        Applied { effect: effect.clone(), names, parameters, internal: vec![], force: None, counts_from }
    }

    /// This model with one more effect.
    ///
    /// # Errors
    /// The law uses a name, or acts at a place, that the model does not have.
    pub fn with(&self, effect: &Effect) -> Result<TrialModel, EffectError> {
        if let Site::Constant { .. } = effect.place.site {
            return self.with_constant(effect);
        }
        // The effect may come from a variant of this model, whose nodes differ.
        let here = match effect.place.site {
            Site::Impact { .. } => Some(&effect.place),
            _ => self.places().iter().find(|p| p.is(&effect.place)),
        };
        let here = here.ok_or_else(|| EffectError::UnknownName {
            law: effect.entry.id.clone(),
            name: effect.place.at.clone(),
        })?;
        let effect = &Effect { place: here.clone(), ..effect.clone() };
        let mut out = self.starting_at(&effect.beside);
        if self.base.is_none() {
            out.base = Some(Arc::new(self.clone()));
        }
        let law = effect.entry.law.clone();
        let mut taken = out.taken();
        let at = &effect.place.at;
        let names: Vec<String> = effect.constants().iter().map(|label| free(label, at, &mut taken)).collect();
        let mut parameters = Vec::new();
        for ((name, (_, p)), start) in names.iter().zip(&law.parameters).zip(&effect.start) {
            let unit = if out.given.takes_units { effect.unit(&p.unit, &out.system) } else { String::new() };
            let start = start.clamp(p.within.0, p.within.1);
            parameters.push(out.system.add_parameter(name, &unit, start, p.within, p.each));
        }
        let mut applied = out.applied(effect, names, parameters);
        match &effect.place.site {
            Site::Sensor(columns) => {
                let columns = columns.iter().filter_map(|name| out.system.column(name)).collect();
                out.set_sensor_parameter(&applied, columns)?;
            }
            Site::Input(inputs) => {
                applied.internal = out.add_internal_states(effect, &mut taken);
                out.set_input_property(&applied, inputs)?;
            }
            Site::Constant { .. } => {}
            &Site::Impact { state, below } => out.add_impact(&applied, state, below),
            Site::Force { acts, enters, shows, velocity, .. } => {
                applied.internal = out.add_internal_states(effect, &mut taken);
                let system = &mut out.system;
                let numbers: Vec<_> = applied.parameters.iter().map(|&k| system.parameters[k].node).collect();
                let first = system.states.len() - applied.internal.len();
                let own: Vec<_> = system.states[first..].iter().map(|s| s.node).collect();
                let (force, rates) = effect.force(system, &numbers, &own)?;
                system.known[first..].copy_from_slice(&rates);
                let memory = rates.len();
                let bodies = effect.inertias(system, &numbers);
                let brought: Vec<Place> =
                    bodies.into_iter().filter_map(|(j, m)| body(system, effect, first, j, m)).collect();
                for (&(state, _), entry) in acts.iter().zip(enters) {
                    let (Entry::Force(of) | Entry::Rate(of)) = entry;
                    let share = system.graph.mul(of.node, force);
                    match entry {
                        Entry::Force(_) => system.add_force(state, share),
                        Entry::Rate(_) => system.known[state] = system.graph.add(system.known[state], share),
                    }
                }
                for &(state, sign) in acts.iter().filter(|_| enters.is_empty()) {
                    let part = system.graph.constant(sign);
                    let signed = system.graph.mul(part, force);
                    system.add_force(state, signed);
                }
                for &(output, sign) in shows {
                    let reads = system.outputs[output].reading;
                    system.outputs[output].reading = if sign < 0.0 {
                        system.graph.sub(reads, force)
                    } else {
                        system.graph.add(reads, force)
                    };
                }
                // A force is no rate, so what could be filtered still can.
                let _ = system.connect_filters();
                applied.force = Some(force);
                if !brought.is_empty() {
                    Arc::make_mut(&mut out.given).places.extend(brought);
                }
                if memory > 0 {
                    out.drive_memory(memory);
                }
                // A prescribed motion does not stick.
                if law.sticks() && !acts.is_empty() {
                    let system = &mut out.system;
                    let minus = system.graph.neg(velocity.node);
                    let own = |c: &Contact| c.node == velocity.node || c.node == minus;
                    if !system.contacts.iter().any(own) {
                        system.contacts.push(Contact { text: at.clone(), node: velocity.node, unit: None });
                    }
                }
            }
        }
        out.effects.push(applied);
        Ok(out)
    }

    /// Adds the wall of an impact.
    fn add_impact(&mut self, applied: &Applied, state: usize, below: bool) {
        let system = &mut self.system;
        let [wall, restitution] = [0, 1].map(|k| system.parameters[applied.parameters[k]].node);
        let x = system.states[state].node;
        let (to, from) = if below { (x, wall) } else { (wall, x) };
        let gap = system.graph.sub(to, from);
        let (name, text) = (applied.effect.entry.id.clone(), system.graph.text(gap, &system.names));
        system.impacts.push(Impact { name, text, gap, restitution });
    }

    /// This model with a constant of the spec that is to be found: all effects are added anew to what the changed
    /// spec says.
    fn with_constant(&self, effect: &Effect) -> Result<TrialModel, EffectError> {
        let unknown =
            || EffectError::UnknownName { law: effect.entry.id.clone(), name: effect.place.at.clone() };
        let base = self.without_effects();
        let effects = self.effects.iter().map(|a| &a.effect).chain([effect]);
        let (of_spec, others): (Vec<&Effect>, Vec<&Effect>) =
            effects.partition(|e| matches!(e.place.site, Site::Constant { .. }));
        let mut spec = base.given.spec.clone();
        for e in &of_spec {
            let (_, own) =
                spec.constants.iter_mut().find(|(name, _)| name.value == e.place.at).ok_or_else(unknown)?;
            let ConstantSpec::Number { value, unit } = own.clone() else { return Err(unknown()) };
            let factor = unit.as_ref().and_then(|u| Unit::parse(&u.value).ok()).map_or(1.0, |u| u.factor);
            let bound = |x: f64| Number { value: x / factor, ..value.clone() };
            let (low, high) = e.entry.law.parameters[0].1.within;
            let (within, span) = ((bound(low), bound(high)), value.span);
            *own = ConstantSpec::Movable(Movable { value, unit, within, sigma: None, each: false, span });
        }
        let mut out = base.variant(spec).ok_or_else(unknown)?;
        for e in others {
            out = out.with(e)?;
        }
        let now = self.system.parameters.iter().map(|p| (p.name.clone(), p.start));
        let own = (effect.place.at.clone(), effect.start[0]);
        let starts: Vec<(String, f64)> = now.chain(effect.beside.iter().cloned()).chain([own]).collect();
        out = out.starting_at(&starts);
        for e in of_spec {
            let parameters = (0..out.system.parameters.len())
                .filter(|&k| out.system.parameters[k].name == e.place.at)
                .collect();
            let names = vec![e.place.at.clone()];
            let applied = out.applied(e, names, parameters);
            out.effects.push(applied);
        }
        out.base = Some(Arc::new(base));
        Ok(out)
    }

    /// Adds the internal states of a law, and returns their names.
    fn add_internal_states(&mut self, effect: &Effect, taken: &mut Vec<String>) -> Vec<String> {
        let mut names = Vec::new();
        for (name, inner) in &effect.entry.law.internal {
            let name = free(name, &effect.place.at, taken);
            let unit = effect.unit(&inner.unit, &self.system);
            self.add_internal_state(&name, &unit);
            names.push(name);
        }
        names
    }

    /// Adds an internal state of a law, which starts at zero in every record.
    fn add_internal_state(&mut self, name: &str, unit: &str) {
        let n = self.system.add_state(name, unit);
        for record in Arc::make_mut(&mut self.records) {
            record.columns.insert(n, None);
            record.own_times.insert(n);
            record.start.push(None);
            record.sensors.insert(n, Sensor::default());
        }
        for record in Arc::make_mut(&mut self.smooth) {
            record.columns.insert(n, Some(vec![0.0; record.time.len()]));
            record.own_times.insert(n);
            record.start.push(None);
            record.sensors.insert(n, Sensor::default());
        }
    }

    /// Lets what the effect says act in the place of these inputs, or makes its parameter the delay of their sensors.
    fn set_input_property(&mut self, applied: &Applied, inputs: &[usize]) -> Result<(), EffectError> {
        if applied.effect.is_input_delay() {
            let first = self.system.columns();
            let own =
                |&j: &usize| self.records.first().is_none_or(|r| r.sensors[first + j].follows.is_none());
            let columns = inputs.iter().filter(|j| own(j)).map(|j| first + j).collect();
            return self.set_sensor_parameter(applied, columns);
        }
        let system = &mut self.system;
        let numbers: Vec<_> = applied.parameters.iter().map(|&k| system.parameters[k].node).collect();
        let first = system.states.len() - applied.internal.len();
        let own: Vec<_> = system.states[first..].iter().map(|s| s.node).collect();
        let mut with = HashMap::new();
        for &j in inputs {
            let (acts, rates) = applied.effect.acting(j, system, &numbers, &own)?;
            with.insert(system.inputs[j].node, acts);
            system.known[first..].copy_from_slice(&rates);
        }
        let known = system.graph.replace(&system.known[..first], &with);
        system.known[..first].copy_from_slice(&known);
        let reads: Vec<_> = system.outputs.iter().map(|o| o.node).collect();
        for (output, node) in system.outputs.iter_mut().zip(system.graph.replace(&reads, &with)) {
            output.node = node;
        }
        let memory = self.system.states.len() - first;
        if memory > 0 {
            self.drive_memory(memory);
        }
        Ok(())
    }

    /// Makes the effect's parameter the offset, gain, delay or lag of the sensors of these columns.
    fn set_sensor_parameter(&mut self, applied: &Applied, columns: Vec<usize>) -> Result<(), EffectError> {
        let entry = &applied.effect.entry;
        let which = entry.law.property().and_then(SensorPart::named);
        let which = which.ok_or_else(|| EffectError::NoSensor(entry.id.clone()))?;
        let k = applied.parameters[0];
        let p = &self.system.parameters[k];
        let parameter =
            SensorParameter { start: p.start, within: Some(p.within), sigma: None, shared: Some(k) };
        for record in Arc::make_mut(&mut self.records) {
            for &column in &columns {
                let mut parameter = parameter.clone();
                if column >= self.system.columns() {
                    // The samples of the input have nothing undone.
                    parameter.start = 0.0;
                }
                *record.sensors[column].parameters_mut()[which as usize] = parameter;
            }
        }
        Ok(())
    }

    /// This model with several more effects, in their order.
    ///
    /// # Errors
    /// As [`TrialModel::with`].
    pub fn with_all(&self, effects: &[Effect]) -> Result<TrialModel, EffectError> {
        effects.iter().try_fold(self.clone(), |model, effect| model.with(effect))
    }

    /// This model as the one that is believed complete.
    pub(crate) fn into_base(self) -> TrialModel {
        TrialModel { effects: vec![], base: None, ..self }
    }

    /// This model with none of its effects.
    pub fn without_effects(&self) -> TrialModel {
        self.base.as_ref().map_or_else(|| self.clone(), |base| (**base).clone())
    }

    /// This model with movable constants that start at these values (SI), clamped to their bounds.
    pub(crate) fn starting_at(&self, values: &[(String, f64)]) -> TrialModel {
        let mut out = self.clone();
        for (name, value) in values {
            let Some(k) = out.system.parameters.iter().position(|p| p.name == *name) else { continue };
            let p = &mut out.system.parameters[k];
            p.start = value.clamp(p.within.0, p.within.1);
            let start = p.start;
            let read =
                |r: &Record| r.sensors.iter().any(|s| s.parameters().iter().any(|p| p.shared == Some(k)));
            // The smoothed records keep the sensors by which they were made.
            if !out.records.iter().any(read) {
                continue;
            }
            // The start of an input's sensor says what its samples have undone already.
            let own = out.system.columns();
            for sensor in Arc::make_mut(&mut out.records).iter_mut().flat_map(|r| &mut r.sensors[..own]) {
                for parameter in sensor.parameters_mut() {
                    if parameter.shared == Some(k) {
                        parameter.start = start;
                    }
                }
            }
        }
        out
    }

    /// Cost over every `stride`-th of many short segments after a few steps of a fit: chi^2 per sample.
    /// `None` if the model cannot be simulated.
    pub(crate) fn segment_cost(&self, noise: &[Vec<f64>], stride: usize) -> Option<f64> {
        if self.stop.requested() {
            return None;
        }
        phisindy_learn::segment_cost(&self.system, &self.records, &self.smooth, noise, stride)
    }

    /// The same over all segments, with its end, from which a full fit goes on.
    pub(crate) fn segment_fit(&self, noise: &[Vec<f64>]) -> Option<phisindy_learn::SegmentFit> {
        phisindy_learn::segment_fit(&self.system, &self.records, &self.smooth, noise, 1)
    }

    /// The same cost over one free run per record.
    pub(crate) fn free_run_cost(&self, noise: &[Vec<f64>]) -> Option<f64> {
        phisindy_learn::single_run_cost(&self.system, &self.records, &self.smooth, noise)
    }

    /// Whether short segments flatter it. A law with memory has one more start state in each of them. Static friction holds
    /// whatever starts at rest.
    pub(crate) fn is_flattered(&self) -> bool {
        let flatters = |law: &Law| law.has_memory() || !law.static_levels().is_empty();
        self.effects.iter().any(|a| flatters(&a.effect.entry.law))
    }

    /// Number of Fit records.
    pub(crate) fn fit_records(&self) -> usize {
        self.records.iter().filter(|r| r.role == Role::Fit).count()
    }

    /// Number of parameters of all effects; one of which each record has its own counts once for each Fit
    /// record.
    pub(crate) fn size(&self) -> usize {
        self.effects.iter().map(|a| a.effect.size(self.fit_records())).sum()
    }

    /// Where laws can act.
    pub(crate) fn places(&self) -> &[Place] {
        &self.given.places
    }

    /// Whether a law can act at a place: friction where something moves.
    pub(crate) fn takes(&self, law: &Law, place: &Place) -> bool {
        fits(law, place) && (law.family != "friction" || place.is_of_motion(&self.system))
    }

    /// Record constants that can load friction: positive forces that differ between records and are not used
    /// by the known rates.
    pub(crate) fn loads(&self) -> Vec<String> {
        let system = &self.system;
        (0..system.record_constants.len())
            .filter(|&k| {
                let (name, node) = &system.record_constants[k];
                let values: Vec<f64> = self.records.iter().map(|r| r.constants[k]).collect();
                values.iter().all(|v| *v > 0.0)
                    && values.iter().any(|v| (v - values[0]).abs() > 1e-9 * values[0])
                    && !system.graph.uses(&system.known, &[*node])
                    && self.given.forces.contains(name)
            })
            .map(|k| system.record_constants[k].0.clone())
            .collect()
    }

    /// Names already in use.
    fn taken(&self) -> Vec<String> {
        let spec = &self.given.spec;
        let of_records = spec.data.iter().flat_map(record_constants).map(|(name, _)| name.value.clone());
        let own = |map: &[(phisindy_phys::spec::Text, _)]| -> Vec<String> {
            map.iter().map(|(name, _): &(_, ConstantSpec)| name.value.clone()).collect()
        };
        let of_effects = self.effects.iter().flat_map(|a| a.names.iter().chain(&a.internal).cloned());
        let states = self.system.states.iter().map(|s| s.name.clone());
        let inputs = self.system.inputs.iter().map(|u| u.name.clone());
        let outputs = self.system.outputs.iter().map(|o| o.name.clone());
        states
            .chain(inputs)
            .chain(outputs)
            .chain(own(&spec.constants))
            .chain(of_records)
            .chain(of_effects)
            .collect()
    }
}

/// The place between where an effect acts and the body that it brought: internal state `j` of it is the body's speed, and
/// `inertia` its mass.
fn body(system: &mut System, effect: &Effect, first: usize, j: usize, inertia: Id) -> Option<Place> {
    let Site::Force { velocity, acts, enters, state, .. } = &effect.place.site else { return None };
    if !enters.is_empty() {
        return None;
    }
    let own = first + j;
    system.inertia[own] = Some(inertia);
    let speed = system.graph.sub(velocity.node, system.states[own].node);
    let text = |node: usize| system.states[node].name.clone();
    let spring = (first..system.states.len()).find(|&k| system.known[k] == speed);
    let displacement = spring.map(|k| Quantity { text: text(k), node: system.states[k].node });
    let name = format!("{}-{}", velocity.bare(), text(own));
    Some(Place {
        at: name.clone(),
        site: Site::Force {
            displacement,
            velocity: Quantity { text: format!("({name})"), node: speed },
            acts: acts.iter().copied().chain([(own, 1.0)]).collect(),
            enters: vec![],
            units: None,
            shows: vec![],
            state: *state,
            on_base: false,
        },
    })
}

fn record_constants(data: &DataSpec) -> &[(phisindy_phys::spec::Text, ConstantSpec)] {
    match data {
        DataSpec::Csv(csv) => &csv.constants,
        DataSpec::Synthetic(synthetic) => &synthetic.constants,
    }
}

fn is_force_of_records(spec: &Spec, name: &str) -> bool {
    use phisindy_phys::unit::Dimension;
    spec.data.iter().flat_map(record_constants).any(|(n, c)| {
        n.value == name
            && matches!(c, ConstantSpec::Number { unit: Some(u), .. }
                if Unit::parse(&u.value).is_ok_and(|u| u.dimension == Dimension::NEWTON))
    })
}

/// A free name: the wish, else with the place appended, else with a number.
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
    use crate::model::text_with;
    use phisindy_phys::{LawEntry, check, spec};

    /// Where only states and inputs have units, and the equation needs a mass to be consistent, a unit on the
    /// new constant would turn a warning into an error.
    #[test]
    fn a_spec_without_units_gets_none() {
        let written = |k: &str| {
            let text = format!(
                r#"(constants: {{ "k": {k} }}, states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "F": "N" }}, known: {{ "x": "v", "v": "F - k*x" }}, unknown: {{}},
                data: [Csv(path: "a.csv", time: "t", columns: {{ "x": "x", "v": "v", "F": "F" }})])"#
            );
            let (spec, _) = spec::read(&text, SourceId(0)).expect("a spec");
            let (case, _) = check_names(&spec, SourceId(0)).expect("a case");
            let base = TrialModel::base(spec, case, vec![]);
            let entry = LawEntry::read("coulomb", include_str!("../../../phys/laws/coulomb.ron"));
            let (entry, place) = (entry.expect("a law"), base.places()[0].clone());
            let effect = Effect::new(entry, place, vec![1.0]);
            text_with(&text, &base.with(&effect).expect("a model"), None).expect("a text")
        };
        let plain = written("7.5");
        let (spec, _) = spec::read(&plain, SourceId(0)).expect("a spec");
        assert!(!plain.contains("m/s^2") && check(&spec, SourceId(0)).is_ok(), "{plain}");
        assert!(written("(7.5, \"N/m\")").contains("m/s^2"));
    }

    /// The graph and the text of the completed spec describe the same model: every built-in law at every
    /// place, rates compared at random states.
    #[test]
    fn the_graph_and_the_completed_text_are_one_model() {
        let text = r#"(states: { "x1": "mm", "x2": "mm", "v1": "m/s", "v2": "m/s" }, inputs: { "u": "mm", "du": "m/s" },
            constants: { "m": (2.0, "kg"), "k": (3.0, "N/m"), "c": (value: 0.5, unit: "N*s/m", within: (0.0, 1.0)) },
            known: { "x1": "v1", "x2": "v2", "v1": "(-k*x1 + c*(v2-v1))/m", "v2": "(k*(u-x2) - c*(v2-v1))/m" }, inertia: { "v1": "m", "v2": "m" }, unknown: {},
            contacts: ["v1 - du"],
            data: [Csv(path: "a.csv", time: "t", columns: { "x1": "x1", "x2": "x2", "u": "u", "du": "du" }, constants: { "N": (2.0, "N") }),
                   Csv(path: "b.csv", time: "t", columns: { "x1": "x1", "x2": "x2", "u": "u", "du": "du" }, constants: { "N": (4.0, "N") })])"#;
        let (spec, _) = spec::read(text, SourceId(0)).expect("a spec");
        let (case, _) = check_names(&spec, SourceId(0)).expect("a case");
        let base = TrialModel::base(spec, case, vec![]).counting_from(-2.5);
        let mut compared = 0;
        for (id, law) in phisindy_phys::BUILT_IN {
            let entry = LawEntry::read(id, law).expect("a law");
            for place in base.places().iter().filter(|p| crate::place::fits(&entry.law, p)) {
                let start: Vec<f64> =
                    entry.law.parameters.iter().map(|(_, p)| 0.7_f64.clamp(p.within.0, p.within.1)).collect();
                let load = entry.law.role(phisindy_phys::LawRole::Load);
                let forces = crate::place::known_forces(&base.system, place);
                let effect = Effect {
                    pressed_by: load.and(forces.first().cloned()),
                    beside: vec![("c".into(), 0.25)],
                    ..Effect::new(entry.clone(), place.clone(), start)
                };
                let mirror = Effect { mirror: true, ..effect.clone() };
                let effects = if entry.law.mirror.is_some() { vec![effect, mirror] } else { vec![effect] };
                let model = base.with_all(&effects).expect("a model");
                let completed = text_with(text, &model, None).expect("a text");
                let (spec, _) = spec::read(&completed, SourceId(0)).expect("a spec");
                let (case, _) =
                    check_names(&spec, SourceId(0)).unwrap_or_else(|d| panic!("{d:?}\n{completed}"));
                same(&model.system, &case.system, &completed);
                compared += 1;
            }
        }
        assert!(compared > 60, "{compared}");
    }

    /// Compares rates at some states, names, starts and bounds of two systems.
    fn same(a: &System, b: &System, text: &str) {
        use phisindy_expr::{Scratch, Tape};
        let names = |s: &System| -> Vec<String> {
            let states = s.states.iter().map(|s| s.name.clone());
            states.chain(s.parameters.iter().map(|p| p.name.clone())).collect()
        };
        assert_eq!(names(a), names(b), "{text}");
        assert_eq!(a.contacts.len(), b.contacts.len(), "{text}");
        for (p, q) in a.parameters.iter().zip(&b.parameters) {
            let near = |x: f64, y: f64| (x - y).abs() <= 1e-12 * x.abs().max(y.abs());
            assert!(
                near(p.start, q.start) && near(p.within.0, q.within.0) && near(p.within.1, q.within.1),
                "{text}"
            );
        }
        let rates = |s: &System, at: f64| -> Vec<f64> {
            let tape = Tape::compile(&s.graph, &s.arguments(), &s.known).expect("a tape");
            let mut scratch = Scratch::<1>::new(&tape);
            let before = 1 + s.states.len() + s.inputs.len();
            let moving = (0..before).map(|k| (at * (k + 1) as f64).sin());
            let starts = s.parameters.iter().map(|p| p.start);
            scratch.at(moving.chain(starts).chain(s.record_constants.iter().map(|_| 2.0)));
            (0..s.known.len()).map(|k| scratch.output(k)[0]).collect()
        };
        for at in [0.3, 1.7, 2.9] {
            for (x, y) in rates(a, at).iter().zip(rates(b, at)) {
                assert!((x - y).abs() <= 1e-9 * x.abs().max(1.0), "{x} {y} {text}");
            }
        }
    }
}
