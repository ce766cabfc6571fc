//! The runs as JSON: the keys are a contract with users. Numbers are in the units that stand beside them.

use super::{HALF_WIDTH_95, NextReport};
use phisindy_design::{Aim, Range, Run};
use serde_json::{Value, json};

pub(super) fn object(report: &NextReport) -> Value {
    let models: Vec<Value> =
        report.rivals.iter().map(|r| json!({ "name": r.name, "probability": r.probability })).collect();
    let (aim, number) = match &report.aim {
        Aim::Separate => ("separate", None),
        Aim::Narrow(name) => ("narrow", Some(name.clone())),
        Aim::NarrowAll => ("narrow", None),
    };
    let named = |(name, run): (&str, &Run)| {
        let mut out = of(report, run);
        out["words"] = name.into();
        out
    };
    let runs: Vec<Value> = report.design.runs.iter().map(|run| of(report, run)).collect();
    json!({
        "spec": report.name, "status": report.status, "sentence": report.sentence(),
        "models": models, "none": report.none, "aim": aim, "number": number, "runs": runs,
        "as_before": report.controls().map(named).collect::<Vec<_>>(),
        "limits": limits(report), "looked_at": report.design.tried,
        "refused": report.design.refused.iter().map(|(what, n)| json!({ "what": what, "runs": n })).collect::<Vec<_>>(),
        "doubts": report.doubts, "stopped": report.design.stopped, "version": env!("CARGO_PKG_VERSION"),
    })
}

fn of(report: &NextReport, run: &Run) -> Value {
    let drive = run.trial.waveform.map(|w| {
        let q = &report.inputs[w.input];
        json!({
            "input": q.name, "unit": q.unit, "form": w.shape.name(), "frequency": w.frequency, "end": w.end,
            "amplitude": w.amplitude / q.factor, "middle": w.middle / q.factor,
        })
    });
    let start = run.trial.start.iter().map(|(name, value)| {
        let shown = report.columns.iter().find(|q| q.name == *name);
        (name.clone(), json!(value / shown.map_or(1.0, |q| q.factor)))
    });
    let numbers = report.asked().map(|k| {
        let (shown, before) = report.shown(k);
        let after = HALF_WIDTH_95 * run.narrowed.std_errors[k];
        json!({ "name": shown.name, "unit": shown.unit, "half_width": before / shown.factor, "promised": after / shown.factor })
    });
    let right = report.rivals.iter().zip(&run.separation.right);
    json!({
        "words": report.described(run), "drive": drive, "start": start.collect::<serde_json::Map<_, _>>(),
        "with": report.settings[run.trial.setting], "duration": run.trial.duration(), "step": run.trial.step,
        "wrong": run.separation.wrong, "decides": run.separation.decides,
        "decides_if": right.map(|(r, p)| json!({ "model": r.name, "probability": p })).collect::<Vec<_>>(),
        "numbers": numbers.collect::<Vec<_>>(), "steady": run.steady,
    })
}

fn limits(report: &NextReport) -> Value {
    let limits = &report.limits;
    let range = |range: &Range| {
        let within = [range.within.0, range.within.1].map(|x| x / range.factor);
        json!({ "name": range.name, "unit": range.unit, "within": within, "stated": range.stated })
    };
    let ranges = limits.inputs.iter().chain(&limits.columns).map(|(_, r)| r).chain(&limits.constants);
    json!({
        "ranges": ranges.map(range).collect::<Vec<_>>(),
        "duration": limits.duration.0, "band": [limits.band.0, limits.band.1],
    })
}
