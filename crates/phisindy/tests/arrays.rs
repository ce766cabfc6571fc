//! Records from memory: what is refused and how, and that they give what the same numbers give otherwise.
#![allow(missing_docs)]

use phisindy::{Case, Error, Options, Progress, Record, RecordError, Role, Status, gap, identify, simulate};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A mass on a spring, in millimetres.
const MILLIMETRES: &str = r#"(states: { "x": "mm", "v": "mm/s" }, constants: { "k": (1.0, "1/s^2") },
    known: { "x": "v", "v": "-k*x" }, contacts: ["v"],
    unknown: { "v": (factor: "-sgn(v)", candidates: ["1", "x^2"]) })"#;

fn case() -> Case {
    Case::read(MILLIMETRES).expect("a spec")
}

/// Friction of 0.3 m/s^2 from 2 m, in millimetres.
fn swings() -> (Vec<f64>, Vec<f64>) {
    let time: Vec<f64> = (0..900).map(|k| 0.01 * f64::from(k)).collect();
    let position = |t: &f64| {
        let swing = (t / std::f64::consts::PI).floor();
        300.0 * (-1f64).powf(swing) + (1700.0 - 600.0 * swing) * t.cos()
    };
    let x = time.iter().map(|t| position(t).round()).collect();
    (time, x)
}

#[test]
fn columns_are_in_the_units_of_the_spec_and_results_in_si() {
    let (t, x) = swings();
    let case = case();
    let record = case.record(&[("x", &x), ("t", &t)]).expect("a record");
    let found = identify(&case, &[record], &Options::default()).expect("a result");
    let terms = found.terms();
    assert_eq!((terms.len(), terms[0].state.as_str(), terms[0].candidate.as_str()), (1, "v", "1"));
    assert!((terms[0].coefficient.value - 0.3).abs() < 1e-3, "{:?}", terms[0]);
    assert_eq!(terms[0].unit, "m/s^2");
    let equations = found.equations();
    assert_eq!(equations.len(), 1);
    assert!(equations[0].latex.starts_with("\\dot{v} = ") && equations[0].text.contains("sgn(v)"));
    assert_eq!(found.latex(), equations[0].latex);
}

#[test]
fn the_identified_case_predicts_the_record() {
    let (t, x) = swings();
    let case = case();
    let records = [case.record(&[("t", &t), ("x", &x)]).expect("a record").named("run")];
    let found = identify(&case, &records, &Options::default()).expect("a result");
    let motion = simulate(&found.case().expect("a case"), &records).expect("a run");
    assert!(motion[0].predicted && motion[0].record == "run");
    let predicted = motion[0].state("x").expect("a state");
    let worst = predicted.iter().zip(&x).map(|(p, x)| (1e3 * p - x).abs()).fold(0.0, f64::max);
    // The readings are whole millimetres.
    assert!(worst < 2.0, "{worst} mm");
    assert!(matches!(simulate(&case, &records), Err(Error::Open)));
}

#[test]
fn arrays_that_make_no_record_are_refused_with_the_reason() {
    let case = case();
    let t = [0.0, 0.1, 0.2];
    let refused = |columns: &[(&str, &[f64])]| case.record(columns).expect_err("a mistake");
    assert_eq!(refused(&[("x", &t)]), RecordError::NoTime);
    let unknown = refused(&[("t", &t), ("xx", &t)]);
    assert_eq!(unknown.to_string(), "`xx` is neither `t` nor a state nor an input; did you mean `x`?");
    assert_eq!(refused(&[("t", &t), ("x", &t), ("x", &t)]), RecordError::Repeated("x".into()));
    let short = refused(&[("t", &t), ("x", &t[..2])]);
    assert_eq!(short, RecordError::Length { column: "x".into(), rows: 2, times: 3 });
    let missing = refused(&[("t", &t), ("x", &[0.0, f64::NAN, 1.0])]);
    assert_eq!(missing, RecordError::NotFinite { column: "x".into(), row: 1 });
    assert_eq!(refused(&[("t", &[0.0, 0.2, 0.2]), ("x", &t)]), RecordError::TimeOrder { row: 2 });
    let none = identify(&case, &[], &Options::default());
    assert!(matches!(none, Err(Error::Record(RecordError::NoRecords))));
    let few = case.record(&[("t", &t), ("x", &t)]).expect("a record");
    assert!(matches!(identify(&case, &[few], &Options::default()), Err(Error::Spec(_))));
    let time: Vec<f64> = (0..100).map(f64::from).collect();
    let blind = case.record(&[("t", &time)]).expect("a record");
    let blind = identify(&case, &[blind], &Options::default());
    assert!(matches!(blind, Err(Error::Record(RecordError::NoState { record: 0 }))));
}

#[test]
fn fields_of_records_are_checked_where_they_are_used() {
    let (t, x) = swings();
    let case = case();
    let record = |field: &str, value: &str| {
        let record: Record = case.record(&[("t", &t), ("x", &x)]).expect("a record");
        identify(&case, &[record.with(field, value)], &Options::default()).map(|_| ())
    };
    let error = record("start", r#"{ "w": 0.0 }"#).expect_err("a mistake").to_string();
    assert!(error.starts_with("error: unknown state in `start` `w`"), "{error}");
    assert!(error.contains("the spec with its records:"), "{error}");
    assert!(record("colour", "1").expect_err("a mistake").to_string().contains("unknown field of `Arrays`"));
    let alone = case.record(&[("t", &t), ("x", &x)]).expect("a record").role(Role::Validate);
    let error = identify(&case, &[alone], &Options::default()).map(|_| ()).expect_err("a mistake");
    assert!(matches!(error, Error::Identify(_)) && error.to_string().contains("no record has the role Fit"));
}

#[test]
fn an_observer_hears_of_the_progress_and_may_stop_it() {
    let (t, x) = swings();
    let case = case();
    let record = case.record(&[("t", &t), ("x", &x)]).expect("a record");
    let calls = AtomicUsize::new(0);
    let observe = |progress: Progress<'_>| {
        assert!((0.0..=1.0).contains(&progress.fraction));
        calls.fetch_add(1, Ordering::Relaxed);
        ControlFlow::Break(())
    };
    let options = Options { observe: Some(&observe), ..Options::default() };
    match identify(&case, &[record], &options) {
        Ok(found) => assert!(found.stopped()),
        Err(error) => assert!(matches!(error, Error::Identify(_)), "{error}"),
    }
    assert!(calls.into_inner() > 0);
}

#[test]
fn the_search_names_a_missing_law_and_its_case_can_be_identified() {
    let case = Case::read(
        r#"(states: { "x": "m", "v": "m/s" }, constants: { "m": (1.0, "kg"), "k": (40.0, "N/m"), "c": (0.4, "N*s/m") },
            known: { "x": "v", "v": "(-k*x - c*v)/m" }, inertia: { "v": "m" },
            data: [
                Synthetic(truth: { "v": "-0.8*sgn(v)/m" }, start: { "x": 0.2, "v": 0.0 }, duration: 6.0, step: 0.004, noise: Additive(0.01), seed: 1),
            ])"#,
    )
    .expect("a spec");
    let records = case.synthetic(Some(3));
    assert_eq!(records.len(), 1);
    // The same numbers, given as arrays.
    let truth = &simulate(&case, &records).expect("a run")[0];
    let (x, t) = (truth.state("x").expect("a state").to_vec(), truth.time.clone());
    assert!(!truth.predicted && x.len() == t.len() && (x[0] - 0.2).abs() < 1e-12);
    let found = gap(&case, &records, &Options::default()).expect("a result");
    assert_eq!(found.status(), Status::Explained, "{:?}", found.warnings());
    assert_eq!(found.steps()[0].effect.entry.id, "coulomb");
    assert!(found.after().0 < found.before().0);
    assert!(found.case().expect("a case").text().contains("sgn(v)"));
}

/// An observer that ends the work is heard between fits, on whatever thread they run.
#[test]
fn a_search_ends_between_fits() {
    let case = Case::read(
        r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") }, known: { "x": "v", "v": "-k*x" },
            data: [
                Synthetic(truth: { "v": "-0.05*sgn(v) - 0.05*v" }, start: { "x": 2.0, "v": 0.0 }, duration: 40.0, step: 0.05, noise: Additive(0.02), seed: 1),
            ])"#,
    )
    .expect("a spec");
    let records = case.synthetic(None);
    let fits = AtomicUsize::new(0);
    let observe = |progress: Progress<'_>| {
        fits.fetch_add(usize::from(progress.activity.contains(" compared")), Ordering::Relaxed);
        if fits.load(Ordering::Relaxed) > 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let found =
        gap(&case, &records, &Options { observe: Some(&observe), ..Options::default() }).expect("a result");
    assert!(found.stopped() && found.steps().is_empty(), "{:?}", found.steps().len());
    assert!(fits.into_inner() > 0);
}

#[test]
fn a_spec_that_names_a_law_is_identified_with_it() {
    let (t, x) = swings();
    let case = case().with("unknown", r#"{ "v": (laws: ["coulomb"]) }"#).expect("a spec");
    let record = case.record(&[("t", &t), ("x", &x)]).expect("a record");
    let found = identify(&case, &[record], &Options::default()).expect("a result");
    let level = &found.parameters()[0];
    assert!((level.estimate.value - 0.3).abs() < 1e-3, "{level:?}");
}
