//! Models for the tests of this crate: specs with synthetic records, fitted.

use crate::model::{Fitted, TrialModel, noise_of};
use crate::place::Effect;
use crate::result::Gap;
use crate::workflow::gap;
use phisindy_learn::Effort;
use phisindy_phys::{LawEntry, Origin, SourceId, check, spec};
use phisindy_sim::synthesize;
use std::ops::ControlFlow;

/// The model of a spec with synthetic records, and the noise of these.
pub(crate) fn model(text: &str) -> (TrialModel, Vec<Vec<f64>>) {
    let (spec, _) = spec::read(text, SourceId(0)).expect("a spec");
    let (case, _) = check(&spec, SourceId(0)).expect("a case");
    let made = case.records.iter().map(|plan| {
        let Origin::Synthetic(truth) = &plan.origin else { panic!("a measured record") };
        let made = synthesize(plan, truth, &case.system, None, &|_| Err("no files here".into()));
        made.expect("a record").0
    });
    let records: Vec<_> = made.collect();
    let noise = noise_of(&records);
    (TrialModel::base(spec, case, records), noise)
}

/// A slowly driven mass on a spring that lacks `truth`; its position is measured.
pub(crate) fn slowly_driven(truth: &str) -> (TrialModel, Vec<Vec<f64>>) {
    let spec = r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "N/m"), "m": (1.0, "kg"), "F0": (0.8, "N") },
        known: { "x": "v", "v": "(-k*x + F0*cos(0.3*t))/m" }, inertia: { "v": "m" }, contacts: ["v"], unknown: {},
        data: [ Synthetic(truth: { "v": "TRUTH" }, start: { "x": 1.0, "v": 0.0 }, duration: 40.0, step: 0.05,
            measure: ["x"], noise: Additive(0.01), seed: 1) ])"#;
    model(&spec.replace("TRUTH", truth))
}

/// What the workflow finds with these laws.
pub(crate) fn found(text: &str, laws: &[(&str, &str)]) -> Gap {
    let (base, _) = model(text);
    let (spec, _) = spec::read(text, SourceId(0)).expect("a spec");
    let (case, _) = check(&spec, SourceId(0)).expect("a case");
    let catalogue: Vec<LawEntry> =
        laws.iter().map(|(id, law)| LawEntry::read(id, law).expect("a law")).collect();
    gap(text, case, base.records.to_vec(), &catalogue, &mut |_, _| ControlFlow::Continue(()))
        .expect("a result")
}

/// The fitted model.
pub(crate) fn fitted(model: TrialModel, noise: &[Vec<f64>]) -> Fitted {
    Fitted::new(model, noise, Effort::Plain).expect("a fit")
}

/// A law at a place of a model, with start values (SI).
pub(crate) fn effect(model: &TrialModel, id: &str, law: &str, at: &str, start: &[f64]) -> Effect {
    let entry = LawEntry::read(id, law).expect("a law");
    let place = model.places().iter().find(|p| p.at == at).expect("a place").clone();
    Effect::new(entry, place, start.to_vec())
}

/// The model fitted with effects, with error bars.
pub(crate) fn with_effects(model: &TrialModel, effects: &[Effect], noise: &[Vec<f64>]) -> Fitted {
    let plain = fitted(model.with_all(effects).expect("a model"), noise);
    Fitted::new(plain.settled(), noise, Effort::Errors).expect("a fit")
}
