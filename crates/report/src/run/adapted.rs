//! What Validate records were given of their own before their free runs, and the part of each that is scored.

use crate::table::short;
use phisindy_learn::{Adapted, OwnValue, RecordFit};
use phisindy_phys::{Record, System};
use serde::Serialize;

/// Samples of a record between two of its times.
#[derive(Serialize)]
pub(crate) struct Part {
    samples: usize,
    /// Time of the first of them (s).
    from: f64,
    /// Time of the last of them (s).
    until: f64,
}

impl Part {
    /// The samples that a record is judged by.
    pub(crate) fn scored(fit: &RecordFit, record: &Record) -> Part {
        let scored = fit.scored();
        Part { samples: scored.len(), from: record.time[scored.start], until: record.time[scored.end - 1] }
    }
}

/// A number that a record was given of its own.
#[derive(Serialize)]
pub(crate) struct OwnOut<'a> {
    /// `phi`, or `x.offset` for a sensor.
    name: String,
    /// In `unit`.
    value: f64,
    unit: &'a str,
}

/// The part that a record was adapted on, with the numbers that it was given there beside its start state.
#[derive(Serialize)]
pub(crate) struct AdaptedOut<'a> {
    #[serde(flatten)]
    part: Part,
    parameters: Vec<OwnOut<'a>>,
}

impl<'a> AdaptedOut<'a> {
    /// Of a record that was adapted.
    pub(crate) fn new(adapted: &'a Adapted) -> AdaptedOut<'a> {
        let (from, until) = adapted.span;
        let own = |v: &'a OwnValue| OwnOut { name: name(v), value: v.value / v.factor, unit: &v.unit };
        AdaptedOut {
            part: Part { samples: adapted.samples, from, until },
            parameters: adapted.values.iter().map(own).collect(),
        }
    }
}

/// The name of a number without its record.
pub(crate) fn name(own: &OwnValue) -> String {
    own.id.of.to_string()
}

/// How long the part of a record is that it was adapted on: `5 s`.
pub(crate) fn length(adapted: &Adapted) -> String {
    format!("{} s", short(adapted.span.1 - adapted.span.0))
}

/// `adapted on its first 5 s: phi = 1.2 rad, start x = 0.1 m, v = 0 m/s`, and what is scored.
pub(crate) fn words(system: &System, fit: &RecordFit) -> Option<String> {
    let adapted = fit.adapted.as_ref()?;
    let with_unit = |x: f64, unit: &str| format!("{} {unit}", short(x)).trim_end().to_owned();
    let own =
        adapted.values.iter().map(|v| format!("{} = {}", name(v), with_unit(v.value / v.factor, &v.unit)));
    let start = system.states.iter().zip(&fit.start);
    let start: Vec<String> =
        start.map(|(s, x)| format!("{} = {}", s.name, with_unit(x / s.factor, &s.unit))).collect();
    let all: Vec<String> = own.chain([format!("start {}", start.join(", "))]).collect();
    let scored =
        if adapted.samples < fit.samples { "the rest" } else { "all of it: nothing is left to predict" };
    Some(format!(
        "{}: adapted on its first {}: {}; scored on {scored}",
        fit.name,
        length(adapted),
        all.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_learn::{ParameterId, ParameterOf, RecordId};
    use phisindy_phys::spec::Role;
    use phisindy_phys::{SourceId, check, spec};

    #[test]
    fn what_was_adapted_is_told_with_its_values_and_its_part() {
        let text = r#"(states: {"x": "mm"}, known: {"x": "0"}, unknown: {}, data: [Synthetic(truth: {}, start: {}, duration: 1.0, step: 0.1, noise: None)])"#;
        let (spec, _) = spec::read(text, SourceId(0)).expect("a spec");
        let (case, _) = check(&spec, SourceId(0)).expect("a case");
        let owner = Some(RecordId { index: 1, name: "b".into(), only: false });
        let of = ParameterOf::Constant { index: 0, name: "phi".into() };
        let id = ParameterId { of, owner };
        let own = OwnValue { id, unit: "deg".into(), factor: 0.1, value: 0.25 };
        let mut fit = RecordFit {
            name: "b".into(),
            role: Role::Validate,
            samples: 100,
            adapted: Some(Adapted { samples: 50, span: (2.0, 7.0), values: vec![own], took_more: false }),
            nrmse: vec![],
            noise: vec![],
            residuals: vec![],
            own_times: Default::default(),
            start: vec![0.003],
            run: None,
            failure: None,
            segments: None,
        };
        let told = |fit: &RecordFit| words(&case.system, fit);
        assert_eq!(
            told(&fit).as_deref(),
            Some("b: adapted on its first 5 s: phi = 2.5 deg, start x = 3 mm; scored on the rest")
        );
        fit.samples = 50;
        let all = told(&fit).expect("words");
        assert!(all.ends_with("scored on all of it: nothing is left to predict"), "{all}");
        fit.adapted = None;
        assert_eq!(told(&fit), None);
    }
}
