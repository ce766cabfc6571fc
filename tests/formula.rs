//! A formula that a spec asks for: `unknown: { "v": (search: ["x", "v"]) }`.

#![allow(missing_docs)]

use crate::common::{Outcome, Scratch, phisindy};
use serde_json::Value;

/// A driven mass with a spring, and a force that the model lacks; one record is fitted, one kept.
fn rig(unknown: &str, force: &str) -> String {
    let record = |name: &str, drive: &str, role: &str, seed: u32| {
        format!(
            "Synthetic(name: \"{name}\", truth: {{ \"v\": \"{force}\" }}, inputs: {{ \"F\": Formula(\"{drive}\") }}, start: {{ \"x\": 0.0, \"v\": 0.0 }},\n\
             duration: 25.0, step: 0.02, measure: [\"x\", \"v\"], noise: Additive(0.005), seed: {seed}, role: {role})"
        )
    };
    let fit = record("slow", "3*cos(1.1*t) + 2*cos(2.3*t)", "Fit", 1);
    let kept = record("fast", "2*cos(1.7*t) + 3*cos(0.8*t)", "Validate", 2);
    format!(
        "(constants: {{ \"m\": (1.0, \"kg\"), \"k\": (4.0, \"N/m\") }}, states: {{ \"x\": \"m\", \"v\": \"m/s\" }}, inputs: {{ \"F\": \"N\" }},\n\
         known: {{ \"x\": \"v\", \"v\": \"(F - k*x)/m\" }}, inertia: {{ \"v\": \"m\" }}, unknown: {{ {unknown} }}, data: [{fit}, {kept}])"
    )
}

fn said(name: &str, command: &str, spec: &str) -> Outcome {
    let scratch = Scratch::new(name);
    let path = scratch.path("rig.ron");
    std::fs::write(&path, spec).expect("a file");
    phisindy(&[command, &path, "--format", "json"])
}

const DRAG: &str = "-0.7*abs(v)^1.5*sgn(v)";

#[test]
fn a_formula_that_is_asked_for_is_found_and_fitted() {
    let run = said("found", "run", &rig("\"v\": (search: [\"x\", \"v\"])", DRAG));
    assert_eq!(run.code, 0, "{}", run.err);
    let result: Value = serde_json::from_str(&run.out).expect("JSON");
    let text = result["equations"][0]["text"].as_str().expect("an equation");
    assert!(text.contains("abs(v)^1.5"), "{text}");
    let coefficient = &result["parameters"][0];
    let (low, high) = (coefficient["ci95"][0].as_f64(), coefficient["ci95"][1].as_f64());
    assert!(low.is_some_and(|low| low < 0.7) && high.is_some_and(|high| high > 0.7), "{coefficient}");
    // A check looks at the request alone, and `gap` at the whole catalogue.
    assert_eq!(said("checked", "check", &rig("\"v\": (search: [\"v\"])", DRAG)).code, 0);
}

#[test]
fn a_formula_in_the_wrong_quantity_is_not_found() {
    let run = said("wrong", "run", &rig("\"v\": (search: [\"x\"])", DRAG));
    assert_eq!(run.code, 1, "{}", run.out);
    assert!(run.err.contains("no formula in x at v explains the records"), "{}", run.err);
}

#[test]
fn a_search_where_no_force_acts_is_refused() {
    for (unknown, words) in [
        ("\"v\": (search: [\"x\", \"F\"])", "all or some of: [\"x\", \"v\"]"),
        ("\"x\": (search: [\"x\"])", "put the search into the entry of a velocity"),
        ("\"v\": (search: [\"x\"], candidates: [\"x\"])", "candidates and a search"),
    ] {
        let run = said("refused", "run", &rig(unknown, DRAG));
        assert!(run.code == 2 && run.err.contains(words), "{unknown}: {}", run.err);
    }
}

#[test]
fn a_force_of_no_law_is_described_by_a_formula() {
    // A damper that grows with the deflection is no law of the catalogue.
    let gap = said("described", "gap", &rig("", "-0.8*abs(x)*v"));
    assert_eq!(gap.code, 0, "{}", gap.err);
    let result: Value = serde_json::from_str(&gap.out).expect("JSON");
    assert_eq!(result["status"], "described");
    let step = &result["steps"][0];
    assert_eq!(step["law"], "discovered");
    assert!(step["force"].as_str().is_some_and(|f| f.ends_with("*abs(x)*v")), "{step}");
}
