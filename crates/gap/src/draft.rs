//! A spec's text with effects written into it, checked, and the records as its system sees them.

use crate::effect::{Effect, Written};
use phisindy_learn::{approach, glance};
use phisindy_phys::unit::Unit;
use phisindy_phys::{Case, Record, SourceId, System, check_names, spec, splice};
use std::sync::Arc;

/// A model under test.
#[derive(Clone, Debug)]
pub struct Draft {
    /// The spec.
    pub text: String,
    /// Its meaning.
    pub case: Case,
    /// The records, for this system.
    pub records: Vec<Record>,
    /// Their smoothed states, to start from.
    pub smooth: Vec<Record>,
    /// The effects that were added, each with the constants of its parameters and its expression.
    pub effects: Vec<(Effect, Vec<String>, String)>,
    /// States that belong to laws.
    pub internal: Vec<String>,
    /// The model without any effect; `None` if this is it.
    pub base: Option<Arc<Draft>>,
}

impl Draft {
    /// How well it predicts over every `stride`-th of many short segments after a few steps of a fit: chi^2 per sample; `None` if it cannot be simulated.
    pub(crate) fn glance(&self, noise: &[Vec<f64>], stride: usize) -> Option<f64> {
        glance(&self.case.system, &self.records, &self.smooth, noise, stride)
    }

    /// The same in single runs.
    pub(crate) fn approach(&self, noise: &[Vec<f64>]) -> Option<f64> {
        approach(&self.case.system, &self.records, &self.smooth, noise)
    }

    /// The model as the spec has it.
    pub fn base(text: &str, case: Case, records: Vec<Record>) -> Draft {
        let smooth = records.iter().map(|r| phisindy_learn::smoothed(&case.system, r)).collect();
        Draft { text: text.to_owned(), case, records, smooth, effects: vec![], internal: vec![], base: None }
    }

    /// This model with one more effect.
    ///
    /// # Errors
    /// In words: the spec cannot hold it.
    pub fn with(&self, effect: &Effect) -> Result<Draft, String> {
        let text = starting(&self.text, &self.case.system, &effect.beside)?;
        let Written { text, names, expression, internal } = effect.written(&text, &self.case.system)?;
        let mut effects = self.effects.clone();
        effects.push((effect.clone(), names, expression));
        let internal = self.internal.iter().cloned().chain(internal).collect();
        self.rebuilt(text, effects, internal)
    }

    /// This model with several more, in their order.
    ///
    /// # Errors
    /// In words: the spec cannot hold one of them.
    pub fn with_all(&self, effects: &[Effect]) -> Result<Draft, String> {
        effects.iter().try_fold(self.clone(), |draft, effect| draft.with(effect))
    }

    /// This model with none of its effects.
    pub fn without_effects(&self) -> Draft {
        self.base.as_ref().map_or_else(|| self.clone(), |base| (**base).clone())
    }

    /// The same records under another text.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn rebuilt(
        &self,
        text: String,
        effects: Vec<(Effect, Vec<String>, String)>,
        internal: Vec<String>,
    ) -> Result<Draft, String> {
        let (spec, _) = spec::read(&text, SourceId(0)).map_err(|d| first(&d))?;
        let (case, _) = check_names(&spec, SourceId(0)).map_err(|d| first(&d))?;
        let (old, new) = (&self.case.system, &case.system);
        let seen = |record: &Record, keep_sensors: bool| -> Record {
            let column = |name: &str| old.state(name).and_then(|k| record.columns[k].clone());
            let mut out = record.clone();
            out.columns = new.states.iter().map(|s| column(&s.name)).collect();
            out.start = new.states.iter().map(|s| old.state(&s.name).and_then(|k| record.start[k])).collect();
            if keep_sensors {
                out.sensors = vec![phisindy_phys::Sensor::default(); new.states.len() + new.inputs.len()];
            }
            out
        };
        let mut records: Vec<Record> = self.records.iter().map(|r| seen(r, true)).collect();
        for (record, plan) in records.iter_mut().zip(&case.records) {
            record.sensors = plan.sensors.clone();
        }
        let smooth = self.smooth.iter().zip(&records).map(|(s, r)| {
            let mut out = seen(s, true);
            out.sensors = r.sensors.clone();
            // A state of a law starts from rest.
            for (k, state) in new.states.iter().enumerate() {
                if old.state(&state.name).is_none() {
                    out.columns[k] = Some(vec![0.0; r.len()]);
                }
            }
            out
        });
        let smooth = smooth.collect();
        let base = match &self.base {
            _ if effects.is_empty() => None,
            Some(base) => Some(base.clone()),
            None => Some(Arc::new(self.clone())),
        };
        Ok(Draft { text, case, records, smooth, effects, internal, base })
    }
}

/// A spec whose movable constants start at these values (SI), or at the bound that is next to them.
///
/// # Errors
/// In words: a constant cannot be set.
pub(crate) fn starting(text: &str, system: &System, values: &[(String, f64)]) -> Result<String, String> {
    let mut text = text.to_owned();
    for (name, value) in values {
        let Some(p) = system.parameters.iter().find(|p| p.name == *name) else { continue };
        let factor = Unit::parse(&p.unit).map_or(1.0, |u| u.factor);
        let field = if p.known { "value" } else { "start" };
        let value = value.clamp(p.within.0, p.within.1) / factor;
        text = splice::set(&text, &format!("constants.{name}.{field}"), &format!("{value:?}"))
            .map_err(|e| e.to_string())?;
    }
    Ok(text)
}

fn first(diagnostics: &[phisindy_phys::Diagnostic]) -> String {
    diagnostics.iter().find(|d| d.is_error()).map_or(String::new(), |d| d.message.clone())
}
