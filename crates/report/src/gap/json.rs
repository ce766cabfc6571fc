//! The result of `gap` as JSON: the keys are a contract with users.

use super::report::GapReport;
use phisindy_gap::Step;
use phisindy_phys::spec::Role;
use serde_json::{Map, Value, json};

/// One object.
pub(crate) fn object(report: &GapReport<'_>) -> Value {
    let GapReport { input, found, ending, .. } = *report;
    let pair = |p: (f64, f64)| json!({ "before": p.0, "after": p.1 });
    let step = |s: &Step| {
        let parameters: Map<String, Value> = s
            .parameters
            .iter()
            .map(|p| {
                let value = json!({ "value": p.value, "ci95": [p.ci95.0, p.ci95.1], "unit": p.unit, "constant": p.constant });
                (p.name.clone(), value)
            })
            .collect();
        json!({
            "law": s.effect.entry.id,
            "name": s.effect.entry.law.name,
            "at": s.effect.place.at,
            "mirror": s.effect.mirror,
            "scales_with": s.effect.load,
            "expression": s.expression,
            "parameters": parameters,
            "fit": pair(s.fit),
            "validate": s.validate.map(pair),
            "delta_bic": s.delta_bic,
            "rivals": s.rivals.iter().map(|r| json!({ "law": r.law, "at": r.at, "delta_bic": r.delta_bic })).collect::<Vec<_>>(),
            "vetoed": s.vetoed.iter().map(|(law, why)| json!({ "law": law, "why": why })).collect::<Vec<_>>(),
        })
    };
    let regions = |list: &[phisindy_gap::Region]| -> Vec<Value> {
        list.iter().map(|r| json!({ "column": r.column, "share": r.share, "region": r.region })).collect()
    };
    let noise: Map<String, Value> = found.noise.iter().map(|(name, s)| (name.clone(), json!(s))).collect();
    let records: Vec<Value> = found
        .nrmse
        .iter()
        .map(|(record, role, column, before, after)| {
            json!({
                "record": record, "role": if *role == Role::Fit { "fit" } else { "validate" }, "column": column,
                "nrmse": { "before": before, "after": after },
            })
        })
        .collect();
    let repeat: Vec<Value> = found
        .repeat
        .iter()
        .map(|(record, column, r)| {
            json!({ "record": record, "column": column, "nrmse": r.nrmse, "rms": r.rms, "period": r.period })
        })
        .collect();
    let parameters: Vec<Value> = found
        .parameters
        .iter()
        .map(|p| {
            let f = p.factor;
            json!({
                "name": p.name, "unit": p.unit, "value": p.estimate.value / f, "std_error": p.estimate.std_error / f,
                "ci95": [p.estimate.ci95.0 / f, p.estimate.ci95.1 / f], "bounds": [p.bounds.0 / f, p.bounds.1 / f], "at_bound": p.at_bound,
            })
        })
        .collect();
    json!({
        "spec": input.name,
        "title": input.case.system.title,
        "status": found.status.name(),
        "noise": noise,
        "where": regions(&found.located),
        "steps": found.steps.iter().map(step).collect::<Vec<_>>(),
        "partial": found.partial.iter().map(step).collect::<Vec<_>>(),
        "left": regions(&found.left),
        "initial": { "fit": found.before.0, "validate": found.before.1 },
        "final": { "fit": found.after.0, "validate": found.after.1, "within_errors": found.carried },
        "whiteness": { "before": found.colour.0, "after": found.colour.1 },
        "records": records,
        "repeatability": repeat,
        "parameters": parameters,
        "warnings": found.warnings,
        "doubts": input.doubts,
        "seconds": ending.seconds,
        "version": env!("CARGO_PKG_VERSION"),
    })
}
