//! What is said of a result, from results written down by hand.

use super::*;
use crate::line_models::{STEP, records, scatter};
use crate::result::error::ModelError;
use crate::result::identified::{NoiseModel, StopReason};
use crate::result::term::FoundTerm;
use crate::result::verdict::{Verdict, verdict};
use approx::assert_relative_eq;
use phisindy_sim::Trajectory;

const SAMPLES: usize = 40;

fn texts(warnings: &[Warning]) -> Vec<String> {
    warnings.iter().map(ToString::to_string).collect()
}

/// Three terms, the first one between bounds, and a millimetre that may move.
const LINE: &str = r#"constants: {"c": (value: 1.0, unit: "mm", within: (-3.0, 4.0))}, states: {"x": ""}, known: {"x": "0"},
    unknown: {"x": (factor: "1", candidates: ["1", "x", "x^2"], within: {"1": (0.0, 5.0)})}"#;

/// 2 + 0.5 t and noise.
fn line() -> Vec<f64> {
    scatter(SAMPLES).iter().enumerate().map(|(i, e)| 2.0 + 0.5 * STEP * i as f64 + 0.01 * e).collect()
}

fn case() -> (Case, Vec<Record>) {
    records(LINE, &[(Role::Fit, line())])
}

/// A record whose columns are missed by this much, of motions of unit size.
fn ran(role: Role, nrmse: &[f64]) -> RecordFit {
    let missed = |e: &f64| vec![*e; SAMPLES];
    RecordFit {
        name: "r".into(),
        role,
        samples: SAMPLES,
        adapted: None,
        nrmse: nrmse.iter().map(|&e| ("x".into(), e)).collect(),
        noise: vec![],
        residuals: nrmse.iter().map(missed).collect(),
        own_times: Default::default(),
        start: vec![],
        run: Some(Trajectory::default()),
        failure: None,
        segments: None,
    }
}

fn term(value: f64, std_error: f64) -> FoundTerm {
    FoundTerm::new(0, Estimate { value, std_error, ci95: (value - 2.0 * std_error, value + 2.0 * std_error) })
}

fn said(terms: Vec<FoundTerm>, records: Vec<RecordFit>) -> Identified {
    let mut found = Identified {
        method: Method::Step,
        terms,
        parameters: vec![],
        records,
        noise_model: NoiseModel::Unweighted,
        remainder: vec![],
        held: vec![],
        horizon: vec![],
        selection: vec![],
        covariance: vec![],
        late: None,
        deviance: None,
        warnings: vec![],
        verdict: Verdict::Identified,
        stop_reason: StopReason::Finished,
    };
    remarks(&case().0.system, &mut found);
    found
}

#[test]
fn a_term_that_may_be_zero_or_is_at_its_bound_is_told() {
    // Value, error; the interval within the bounds; at a bound; what is said.
    for (value, error, interval, at_bound, says) in [
        (1.0, 0.3, (0.4, 1.6), false, ""),
        (1.0, 0.6, (0.0, 2.2), false, "1 of x' could be zero: its interval contains zero"),
        (4.5, 0.5, (3.5, 5.0), false, ""),
        (0.0, 0.1, (0.0, 0.2), true, "1 of x' ended at its bound 0: the data would take it further"),
        (5.0, 0.1, (4.8, 5.0), true, "1 of x' ended at its bound 5: the data would take it further"),
        (1.0, f64::INFINITY, (0.0, 5.0), false, ""),
    ] {
        let found = said(vec![term(value, error)], vec![]);
        let of = &found.terms[0];
        assert_relative_eq!(of.coefficient.ci95.0, interval.0, max_relative = 1e-12);
        assert_relative_eq!(of.coefficient.ci95.1, interval.1, max_relative = 1e-12);
        assert_eq!((of.at_bound, texts(&found.warnings).join("\n").as_str()), (at_bound, says), "{value}");
    }
    // Without bounds, on either side of zero.
    for value in [-1.0, 1.0] {
        let mut free = term(value, 0.3);
        free.term = 1;
        assert_eq!(texts(&said(vec![free], vec![]).warnings), [""; 0]);
    }
}

/// The worst column of the worst record of each role counts.
#[test]
fn a_validation_that_is_much_worse_than_the_fit_is_told() {
    for (fit, validate, times) in [(0.01, 0.06, Some(6)), (0.01, 0.04, None), (0.03, 0.08, None)] {
        let records = vec![
            ran(Role::Fit, &[0.5 * fit, fit]),
            ran(Role::Validate, &[validate, 0.001]),
            ran(Role::Validate, &[0.001]),
            ran(Role::Fit, &[0.1 * fit]),
        ];
        let found = said(vec![], records);
        let due = times.map(|n| {
            format!("validation is {n} times worse than the fit (NRMSE {validate:.3} against {fit:.3})")
        });
        let heard = texts(&found.warnings).first().and_then(|w| w.split(": ").next().map(str::to_owned));
        assert_eq!(heard, due);
    }
}

/// A motion that is ten times smaller shows ten times the share of the same noise.
#[test]
fn a_small_motion_is_not_missed_by_more_than_the_noise() {
    let of = |size: f64| {
        let mut small = ran(Role::Validate, &[0.1 * size]);
        small.nrmse[0].1 = 0.1;
        said(vec![], vec![ran(Role::Fit, &[0.01]), small]).warnings.len()
    };
    assert_eq!((of(0.1), of(1.0)), (0, 1));
}

#[test]
fn what_makes_a_verdict() {
    let system = &case().0.system;
    let one = [term(1.0, 0.1)];
    let of = |terms: &[FoundTerm], fits: &[f64], without: &[f64]| {
        let all = |e: &[f64]| e.iter().map(|&e| ran(Role::Fit, &[e])).collect::<Vec<_>>();
        verdict(system, terms, &all(fits), &all(without), false)
    };
    let rejected = |v: Verdict, why: &str| match v {
        Verdict::Rejected(text) => assert!(text.to_string().contains(why), "{text}"),
        other => panic!("{other:?}, not rejected: {why}"),
    };
    assert_eq!(of(&one, &[0.1, 0.5], &[0.4, 0.4]), Verdict::Identified);
    assert_eq!(of(&one, &[0.4, 0.4], &[2.4, 0.1]), Verdict::Identified);
    rejected(
        of(&[], &[0.1], &[0.25]),
        "no candidate of the dictionary explains anything, so none is kept (NRMSE of the known part alone: r 0.250)",
    );
    rejected(
        of(&one, &[0.1, 0.51], &[0.9, 0.9]),
        "the free run of r misses the data by 51 % of their standard deviation (NRMSE 0.51)",
    );
    rejected(of(&one, &[0.1, 0.3], &[0.2, 0.1]), "no better with the identified part than without it");
    rejected(of(&one, &[0.25], &[0.25]), "no better");
    let mut failed = ran(Role::Validate, &[]);
    failed.failure = Some(ModelError::Unbound("at t = 3".into()));
    rejected(
        verdict(system, &one, &[failed], &[ran(Role::Fit, &[0.9])], false),
        "the free run of r fails: at t = 3",
    );
    // Nothing to choose from: parameters alone.
    let bare = records(r#"states: {"x": ""}, known: {"x": "0"}, unknown: {}"#, &[(Role::Fit, line())]).0;
    assert_eq!(
        verdict(&bare.system, &[], &[ran(Role::Fit, &[0.2])], &[ran(Role::Fit, &[0.2])], false),
        Verdict::Identified
    );
}

#[test]
fn twenty_samples_that_move_are_enough() {
    let of = |samples: Vec<f64>| {
        let (case, records) = records(LINE, &[(Role::Fit, samples)]);
        suitable(&case.system, &records[0]).err().map(|e| e.to_string())
    };
    assert_eq!(of(line()[..20].to_vec()), None);
    assert!(of(line()[..19].to_vec()).unwrap().contains("r0: 19 samples are too few"));
    assert!(of(vec![0.7; 30]).unwrap().contains("r0: the column of x is constant"));
}

/// A record to validate with may be dead; one to learn from there must be, and not a dead one.
#[test]
fn only_what_is_fitted_must_be_fit_for_it() {
    let refused = |of: &[(Role, Vec<f64>)]| {
        let (case, records) = records(LINE, of);
        let found = identify(&case, &records, &LearnOptions::default(), &mut |_| ControlFlow::Continue(()));
        found.err().map(|e| e.to_string()).unwrap_or_default()
    };
    let dead = vec![0.7; SAMPLES];
    assert_eq!(refused(&[(Role::Fit, line()), (Role::Validate, dead.clone())]), "");
    assert!(
        refused(&[(Role::Validate, line()), (Role::Fit, dead)]).contains("r1: the column of x is constant")
    );
    assert!(refused(&[(Role::Validate, line())]).contains("no record has the role Fit"));
}
