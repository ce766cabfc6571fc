//! Method `step`, end to end on the cases of the paper.

use crate::common;
use phisindy_learn::{LearnOptions, StepFit, StepOptions, StopReason, identify, train};
use phisindy_phys::spec::{Method, Optimiser};
use phisindy_phys::{Case, Record};
use std::ops::ControlFlow;

const CLEAN: (&str, &str) = ("data.0.noise", "Relative(0)");

fn fit(case: &Case, records: &[Record], options: &StepOptions) -> StepFit {
    let records: Vec<&Record> = records.iter().collect();
    train(&case.system, &records, options, &mut |_| ControlFlow::Continue(()))
}

/// The paper's optimiser in fewer epochs, for tests that do not need its numbers.
fn short() -> StepOptions {
    StepOptions { epochs: vec![400, 200, 100], ..Default::default() }
}

fn gauss_newton() -> StepOptions {
    StepOptions { optimiser: Optimiser::GaussNewton, ..Default::default() }
}

/// `state:candidate` and coefficient of what survived.
fn named(case: &Case, fit: &StepFit) -> Vec<(String, f64)> {
    let system = &case.system;
    let name =
        |t: usize| format!("{}:{}", system.states[system.terms[t].state].name, system.terms[t].candidate);
    fit.terms.iter().map(|&t| name(t)).zip(fit.coefficients.iter().copied()).collect()
}

/// Exactly these terms: name, truth, relative tolerance.
fn assert_terms(what: &str, found: &[(String, f64)], truth: &[Expected]) {
    let names: Vec<&str> = found.iter().map(|(n, _)| n.as_str()).collect();
    assert_eq!(names, truth.iter().map(|t| t.0).collect::<Vec<_>>(), "{what}: {found:?}");
    for ((name, value), (_, truth, within)) in found.iter().zip(truth) {
        assert!((value - truth).abs() <= within * truth.abs(), "{what}: {name} is {value}, truth {truth}");
    }
}

const COULOMB: f64 = 0.01;
const DIETERICH_RUINA: f64 = 0.05;

/// A term's name, its true coefficient, its relative tolerance.
type Expected = (&'static str, f64, f64);

/// What each case hides; Dieterich-Ruina terms are biased by the loss itself.
fn truths() -> Vec<(&'static str, Vec<Expected>)> {
    let ruina = |a: f64, b: f64| {
        vec![
            ("y:1", 0.5, DIETERICH_RUINA),
            ("y:ln((|y|+eps)/V)", a, DIETERICH_RUINA),
            ("y:ln(c+V/(|y|+eps))", b, DIETERICH_RUINA),
        ]
    };
    let two = vec![
        ("y1:1", 0.3, COULOMB),
        ("y2:1", 0.3, DIETERICH_RUINA),
        ("y2:ln((|y2|+eps)/V)", 0.07, DIETERICH_RUINA),
        ("y2:ln(c+V/(|y2|+eps))", 0.09, DIETERICH_RUINA),
    ];
    vec![
        ("case1a", vec![("y:1", 0.5, COULOMB)]),
        ("case1b", ruina(0.07, 0.09)),
        ("case2a", vec![("y:1", 0.5, COULOMB)]),
        ("case2b", ruina(0.07, 0.09)),
        ("case3_coulomb", vec![("y:1", 0.5, COULOMB)]),
        ("case3_dr", ruina(0.05, 0.07)),
        ("case4", vec![("y:1", 0.2, COULOMB)]),
        ("case5", vec![("y2:1", 0.5, COULOMB)]),
        ("case6", vec![("y1:1", 0.5, COULOMB), ("y2:1", 0.3, COULOMB)]),
        ("case7", two.clone()),
        ("case7_expert", two),
    ]
}

/// The options that a spec asks for.
fn of_spec(case: &Case) -> StepOptions {
    let learn = &case.learn;
    StepOptions {
        cutoff: learn.cutoff.as_ref().unwrap().value,
        tolerance: learn.tolerance.as_ref().unwrap().value,
        crossings: learn.crossings.unwrap_or(StepOptions::default().crossings),
        ..Default::default()
    }
}

#[test]
fn clean_data_give_the_exact_terms_of_every_case() {
    for (name, truth) in truths() {
        let (case, records) = common::load(name, &[CLEAN]);
        let options = StepOptions { optimiser: Optimiser::GaussNewton, ..of_spec(&case) };
        assert_terms(name, &named(&case, &fit(&case, &records, &options)), &truth);
    }
}

#[test]
fn clean_data_give_the_exact_terms_with_radam() {
    for (name, truth) in truths().into_iter().filter(|(n, _)| *n == "case1a") {
        let (case, records) = common::load(name, &[CLEAN]);
        let found = fit(&case, &records, &of_spec(&case));
        assert_terms(name, &named(&case, &found), &truth);
        assert_eq!(found.stages.len(), 3, "{name}");
    }
}

/// On the same terms all three optimisers find the same minimum; the plain one needs rates that suit the
/// loss.
#[test]
fn optimisers_agree_on_the_minimum() {
    let (case, records) = common::load("case1a", &[CLEAN, ("unknown.y.candidates", r#"["1", "y"]"#)]);
    let keep = |options: StepOptions| StepOptions { cutoff: 0.0, ..options };
    let exact = fit(&case, &records, &keep(gauss_newton()));
    let radam = fit(&case, &records, &keep(short()));
    // The curvature of the loss is about (step / deviation)^2.
    let rates = vec![500.0; 3];
    let plain = fit(&case, &records, &keep(StepOptions { optimiser: Optimiser::Sgd, rates, ..short() }));
    for (what, other) in [("RAdam", &radam), ("Sgd", &plain)] {
        assert_eq!(other.terms, exact.terms);
        for (a, b) in other.coefficients.iter().zip(&exact.coefficients) {
            assert!((a - b).abs() < 1e-3, "{what}: {a} against {b}");
        }
        assert!(other.loss >= exact.loss * (1.0 - 1e-9), "{what} is below the minimum");
    }
}

/// Stages only lose terms; those that are left are trained as if the others had never been.
#[test]
fn what_was_cut_stays_zero() {
    let (case, records) = common::load("case1a", &[]);
    for optimiser in [Optimiser::RAdam, Optimiser::GaussNewton] {
        let found = fit(
            &case,
            &records,
            &StepOptions {
                optimiser,
                cutoff: 0.1,
                epochs: vec![600, 200, 200],
                rates: vec![0.1, 0.1, 0.01],
                ..Default::default()
            },
        );
        assert_eq!(found.stages[0].0, 6);
        assert!(found.stages.windows(2).all(|w| w[0].0 >= w[1].0), "{:?}", found.stages);
        assert!(!found.terms.is_empty() && found.terms.len() < 6, "something is cut: {:?}", found.terms);
        assert!(found.coefficients.iter().all(|c| c.abs() >= 0.1));
        let left: Vec<String> =
            found.terms.iter().map(|&t| format!("{:?}", case.system.terms[t].candidate)).collect();
        let (alone, records) =
            common::load("case1a", &[("unknown.y.candidates", &format!("[{}]", left.join(",")))]);
        let alone = fit(&alone, &records, &StepOptions { cutoff: 0.0, ..gauss_newton() });
        for (a, b) in found.coefficients.iter().zip(&alone.coefficients) {
            assert!((a - b).abs() < 2e-3, "{optimiser:?}: {a} against {b}");
        }
    }
}

/// A cut before the last stage: had the term stayed, the last stage would have let it grow again.
#[test]
fn a_stage_after_the_cut_does_not_revive_a_term() {
    let (case, records) = common::load("case1a", &[CLEAN]);
    // One epoch leaves every coefficient small: all are cut, and 1000 more epochs do not bring the true one
    // back.
    let found = fit(
        &case,
        &records,
        &StepOptions { epochs: vec![1, 1000], rates: vec![1e-3, 0.1], ..Default::default() },
    );
    assert_eq!(found.stages.iter().map(|s| s.0).collect::<Vec<_>>(), [6, 0]);
    assert!(found.terms.is_empty() && found.loss.is_finite());
}

#[test]
fn the_same_bits_on_one_and_two_threads() {
    for (name, horizon) in [("case1a", 1), ("case7", 40), ("case1a", 3)] {
        // Several blocks of samples for each of two threads.
        let (case, records) = common::load(name, &[("data.0.duration", "10.0")]);
        for optimiser in [Optimiser::RAdam, Optimiser::GaussNewton] {
            let options = StepOptions {
                optimiser,
                horizon,
                // Threads differ from the first epoch on, if they do.
                epochs: vec![6, 3],
                rates: vec![0.1, 0.01],
                ..Default::default()
            };
            let run = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| fit(&case, &records, &options))
            };
            let (one, two) = (run(1), run(2));
            let bits = |f: &StepFit| -> Vec<u64> {
                f.coefficients
                    .iter()
                    .chain(f.covariance.iter().flatten())
                    .chain([&f.loss])
                    .map(|v| v.to_bits())
                    .collect()
            };
            assert_eq!(one.terms, two.terms);
            assert_eq!(bits(&one), bits(&two), "{name}, {optimiser:?}, horizon {horizon}");
        }
    }
}

/// The bias that the event condition removes: the paper's 0.354 for 0.5 (case 1a), 0.389 (case 5).
#[test]
fn without_the_event_condition_friction_comes_out_low() {
    for (name, state, expected) in [("case1a", "y", 0.33), ("case5", "y2", 0.389)] {
        let candidates = format!("unknown.{state}.candidates");
        let (case, records) = common::load(name, &[("contacts", "[]"), (&candidates, r#"["1"]"#)]);
        for optimiser in [Optimiser::RAdam, Optimiser::GaussNewton] {
            let found = fit(&case, &records, &StepOptions { optimiser, ..short() });
            let value = found.coefficients[0];
            assert!((value - expected).abs() < 0.1 * expected, "{name}, {optimiser:?}: {value}");
        }
    }
}

/// A horizon of several steps has the same minimum on clean data.
#[test]
fn a_longer_horizon_finds_the_same_friction() {
    let (case, records) = common::load("case1a", &[CLEAN]);
    let found = fit(&case, &records, &StepOptions { horizon: 5, ..gauss_newton() });
    assert_terms("case1a over 5 steps", &named(&case, &found), &[("y:1", 0.5, COULOMB)]);
}

/// Gauss-Newton moves constants within their bounds, and stops at them.
#[test]
fn constants_move() {
    for (within, expected) in [("(0.5, 2.0)", 1.0), ("(0.2, 0.6)", 0.6)] {
        let k = format!("(value: 0.55, unit: \"N/m\", within: {within})");
        // The truth adds what the spec's k lacks.
        let truth = r#""-0.5*sgn(y) - 0.45*x""#;
        let sets =
            [CLEAN, ("constants.k", &k), ("data.0.truth.y", truth), ("unknown.y.candidates", r#"["1"]"#)];
        let (case, records) = common::load("case1a", &sets);
        let found = fit(&case, &records, &gauss_newton());
        assert!((found.parameters[0] - expected).abs() < 1e-3, "{:?}", found.parameters);
    }
}

/// The errors and correlations of a result are of one covariance, in the order of what it lists.
#[test]
fn the_covariance_is_that_of_the_errors() {
    let k = "(value: 0.9, unit: \"N/m\", within: (0.5, 2.0))";
    let sets = [("constants.k", k), ("learn.optimiser", "GaussNewton"), ("learn.cutoff", "0.0")];
    let (case, records) = common::load("case1a", &sets);
    let options = LearnOptions { method: Some(Method::Step), ..Default::default() };
    let found = identify(&case, &records, &options, &mut |_| ControlFlow::Continue(())).unwrap();
    let errors: Vec<f64> = found.terms.iter().map(|t| t.coefficient.std_error).collect();
    let errors = [errors, found.parameters.iter().map(|p| p.estimate.std_error).collect()].concat();
    assert_eq!((errors.len(), found.covariance.len()), (7, 7));
    for (i, row) in found.covariance.iter().enumerate() {
        assert!((row[i].sqrt() - errors[i]).abs() <= 1e-12 * errors[i]);
        for (j, c) in row.iter().enumerate() {
            assert!(i == j || (*c != 0.0 && c.abs() < errors[i] * errors[j]), "{i}, {j}: {c}");
        }
    }
}

/// Rates that are too large for the loss, candidates that are not numbers: said, not cut away.
#[test]
fn what_is_not_finite_is_not_cut() {
    let (case, records) = common::load("case1a", &[CLEAN]);
    let wild = StepOptions { optimiser: Optimiser::Sgd, rates: vec![1e6; 3], ..short() };
    let found = fit(&case, &records, &wild);
    assert!(!found.loss.is_finite() && found.terms.len() == 6, "{found:?}");
    let (case, records) = common::load("case1a", &[CLEAN, ("unknown.y.candidates", r#"["1", "ln(1*x)"]"#)]);
    for optimiser in [Optimiser::RAdam, Optimiser::GaussNewton] {
        let found = fit(&case, &records, &StepOptions { optimiser, ..short() });
        assert!(found.loss.is_nan() && found.terms.len() == 2, "{found:?}");
    }
}

#[test]
fn stops_when_it_is_told_to() {
    let (case, records) = common::load("case1a", &[]);
    let fitted: Vec<&Record> = records.iter().collect();
    let mut heard = 0;
    let found = train(&case.system, &fitted, &StepOptions::default(), &mut |_| {
        heard += 1;
        ControlFlow::Break(())
    });
    assert!(found.stop_reason == StopReason::Interrupted && heard == 1 && found.stages.len() == 1);
}

/// What an epoch costs, without a clock: instructions of the loss and its gradient for one step. A change
/// that makes it dearer is seen here.
#[test]
fn the_loss_is_not_dearer_than_it_was() {
    for (name, most) in [("case1a", 109), ("case1b", 152), ("case7", 362)] {
        let (case, records) = common::load(name, &[]);
        let records: Vec<&Record> = records.iter().collect();
        let none = StepOptions { epochs: vec![0], ..Default::default() };
        let fit = train(&case.system, &records, &none, &mut |_| ControlFlow::Continue(()));
        let instructions = fit.cost.instructions;
        assert!(instructions <= most, "{name}: {instructions} instructions, {most} before");
    }
}
