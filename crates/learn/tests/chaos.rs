//! Motion that forgets its start: Lorenz's equations of 1963 with nothing known.

use phisindy_learn::{Identified, LearnOptions, Verdict, Warning, identify};
use phisindy_phys::{Origin, Record, RecordPlan, SourceId, check, spec};
use phisindy_sim::synthesize;
use std::ops::ControlFlow;

/// The true terms of the dictionary: x, y; x, y, x z; z, x y.
const TRUE: [usize; 7] = [1, 2, 11, 12, 16, 23, 25];

/// A record of Lorenz's motion: its start, its seconds, its noise, its role and the ratio that is 28
/// elsewhere.
fn motion(start: [f64; 3], duration: f64, noise: f64, role: &str, ratio: f64) -> String {
    let seed = if role == "Fit" { 1 } else { 501 };
    let [x, y, z] = start;
    format!(
        r#"Synthetic(truth: {{ "x": "10*(y - x)", "y": "x*({ratio:?} - z) - y", "z": "x*y - 8/3*z" }},
            start: {{ "x": {x:?}, "y": {y:?}, "z": {z:?} }}, duration: {duration:?}, step: 0.01, role: {role},
            noise: Sensor({{ "x": ({noise:?}, ""), "y": ({noise:?}, ""), "z": ({noise:?}, "") }}), seed: {seed})"#
    )
}

fn identified(records: &[String]) -> Identified {
    let ten = r#"["1", "x", "y", "z", "x^2", "x*y", "x*z", "y^2", "y*z", "z^2"]"#;
    let unknown =
        ["x", "y", "z"].map(|state| format!(r#""{state}": (factor: "1", candidates: {ten})"#)).join(", ");
    let text = format!(
        r#"(states: {{ "x": "", "y": "", "z": "" }}, known: {{ "x": "0", "y": "0", "z": "0" }}, unknown: {{ {unknown} }}, data: [{}])"#,
        records.join(", ")
    );
    let (spec, _) = spec::read(&text, SourceId(0)).unwrap();
    let (case, _) = check(&spec, SourceId(0)).unwrap();
    let made = |plan: &RecordPlan| {
        let Origin::Synthetic(truth) = &plan.origin else { panic!("a measured record") };
        synthesize(plan, truth, &case.system, None, &|_| Err("no files here".into())).unwrap().0
    };
    let records: Vec<Record> = case.records.iter().map(made).collect();
    identify(&case, &records, &LearnOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap()
}

fn lorenz(duration: f64, noise: f64) -> Identified {
    identified(&[motion([-8.0, 8.0, 27.0], duration, noise, "Fit", 28.0)])
}

/// Fitted to ten seconds, asked about others.
fn validated(duration: f64, ratio: f64) -> Identified {
    let noise = 1.2753;
    let fit = motion([-8.0, 8.0, 27.0], 10.0, noise, "Fit", 28.0);
    identified(&[fit, motion([5.0, -3.0, 20.0], duration, noise, "Validate", ratio)])
}

fn terms(found: &Identified) -> Vec<usize> {
    found.terms.iter().map(|t| t.term).collect()
}

/// Noise of a fifth of the motion, six seconds: a disturbance grows a hundredfold.
#[test]
fn thirty_unknown_terms_of_a_chaotic_motion() {
    let found = lorenz(6.0, 2.5506);
    assert_eq!((terms(&found), &found.verdict), (TRUE.to_vec(), &Verdict::Identified));
    for (term, due) in found.terms.iter().zip([-10.0, 10.0, 28.0, -1.0, -1.0, -8.0 / 3.0, 1.0]) {
        let (value, error) = (term.coefficient.value, term.coefficient.std_error);
        assert!((value - due).abs() < 4.0 * error, "{value} +- {error} for {due}");
    }
}

/// In twenty seconds one run still follows the record, but along it the numbers cannot be told from the
/// start.
#[test]
fn numbers_of_a_run_that_is_all_but_lost_have_error_bars() {
    let found = lorenz(20.0, 1.2753);
    assert_eq!((terms(&found), &found.verdict), (TRUE.to_vec(), &Verdict::Identified));
    for (term, due) in found.terms.iter().zip([-10.0, 10.0, 28.0, -1.0, -1.0, -8.0 / 3.0, 1.0]) {
        let (value, error) = (term.coefficient.value, term.coefficient.std_error);
        assert!(error.is_finite() && (value - due).abs() < 4.0 * error, "{value} +- {error} for {due}");
    }
}

/// In forty seconds a disturbance grows by sixteen decades.
#[test]
fn a_run_that_no_start_can_follow_is_judged_by_what_it_keeps() {
    let found = lorenz(40.0, 1.2753);
    assert_eq!((terms(&found), &found.verdict), (TRUE.to_vec(), &Verdict::Identified));
    let chaos = found.warnings.iter().find_map(|w| if let Warning::Chaotic(c) = w { Some(c) } else { None });
    let chaos = chaos.expect("a chaotic motion");
    // The published exponent is 0.906 (Sprott, Chaos and Time-Series Analysis, 2003); over forty seconds it
    // scatters.
    assert!((chaos.exponent - 0.906).abs() < 0.25, "{chaos:?}");
}

/// The start of a Validate record says nothing about its end, however right the model is.
#[test]
fn a_record_that_no_start_can_follow_validates_by_its_segments() {
    let found = validated(20.0, 28.0);
    assert_eq!((terms(&found), &found.verdict), (TRUE.to_vec(), &Verdict::Identified));
    let judged = found.records[1].segments.expect("a motion that forgets its start");
    // The noise is 0.17 of the column that moves least.
    assert!(judged < 0.2 && found.records[1].worst() > 0.5, "{judged} {}", found.records[1].worst());
    assert!(!found.warnings.iter().any(Warning::doubts_validation), "{:?}", found.warnings);
}

/// With another ratio: no run of the model stays beside it, or its numbers are others.
#[test]
fn another_motion_does_not_validate() {
    for ratio in [32.0, 29.5] {
        let found = validated(20.0, ratio);
        assert_eq!(terms(&found), TRUE);
        assert!(found.warnings.iter().any(Warning::doubts_validation), "{ratio}: {:?}", found.warnings);
    }
}
