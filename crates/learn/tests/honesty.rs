//! Data and models that do not suit each other: no panic, no hang, never a confident wrong number.

use crate::common;
use phisindy_learn::{
    Effort, Identified, LearnError, LearnOptions, Rejection, Verdict, Warning, calibrate, identify, smoothed,
};
use phisindy_phys::spec::Method;
use phisindy_phys::{Case, Record, SensorParameter};
use std::ops::ControlFlow;

const METHODS: [Method; 2] = [Method::Trajectory, Method::Step];

fn run_by(method: Method, case: &Case, records: &[Record]) -> Result<Identified, LearnError> {
    identify(case, records, &LearnOptions { method: Some(method), ..Default::default() }, &mut |_| {
        ControlFlow::Continue(())
    })
}

fn run(case: &Case, records: &[Record]) -> Result<Identified, LearnError> {
    run_by(Method::Trajectory, case, records)
}

fn rejected(found: &Identified) -> bool {
    matches!(found.verdict, Verdict::Rejected(_))
}

/// A driven mass on a spring; what differs is filled in.
fn oscillator(constants: &str, known: &str, unknown: &str, truth: &str) -> String {
    format!(
        r#"(constants: {{{constants}}}, states: {{"x": "", "v": ""}}, known: {{"x": "v", "v": "{known}"}},
            unknown: {{"v": {unknown}}}, contacts: ["v"],
            data: [Synthetic(truth: {{"v": "{truth}"}}, start: {{"x": 0.5, "v": 0.1}}, duration: 40.0, step: 0.02, noise: Additive(0.02), seed: 3)],
            learn: (optimiser: GaussNewton))"#
    )
}

const COULOMB: &str = r#"(factor: "-sgn(v)", candidates: ["1", "x"])"#;
const SPRING: &str = "-0.1*v - x + cos(0.7*t)";

#[test]
fn a_constant_column() {
    let (case, mut records) = common::load("case1a", &[]);
    records[0].columns[1].as_mut().unwrap().fill(0.2);
    for method in METHODS {
        let Err(LearnError::Data(why)) = run_by(method, &case, &records) else { panic!("{method:?}") };
        let text = why.to_string();
        assert!(text.contains("the column of y is constant"), "{text}");
    }
}

#[test]
fn too_few_samples() {
    let (case, records) = common::load("case1a", &[("data.0.duration", "0.12")]);
    assert_eq!(records[0].len(), 12);
    for method in METHODS {
        let Err(LearnError::Data(why)) = run_by(method, &case, &records) else { panic!("{method:?}") };
        let text = why.to_string();
        assert!(text.contains("12 samples"), "{text}");
    }
}

/// Few samples, but not too few: an answer with wide error bars or a rejection.
#[test]
fn barely_enough_samples() {
    let (case, records) = common::load("case1a", &[("data.0.duration", "0.25")]);
    for method in METHODS {
        if let Ok(found) = run_by(method, &case, &records) {
            for t in found.terms.iter().filter(|_| method == Method::Trajectory && !rejected(&found)) {
                let truth = if t.term == 0 { 0.5 } else { 0.0 };
                let e = t.coefficient;
                assert!((e.value - truth).abs() < 5.0 * e.std_error, "{method:?} {} {e:?}", t.term);
            }
        }
    }
}

/// The mass rests in its friction and only the sensor moves.
#[test]
fn no_motion() {
    let text =
        oscillator("", "-x", COULOMB, "-2*sgn(v)").replace(r#""x": 0.5, "v": 0.1"#, r#""x": 0.5, "v": 0.0"#);
    // Noise is a fraction of the column's deviation, and there is none: give it in metres.
    let text = text.replace("Additive(0.02)", r#"Sensor({"x": (1e-3, "m"), "v": (1e-3, "m/s")})"#);
    let (case, records) = common::load_text(&text, &[]);
    for method in METHODS {
        match run_by(method, &case, &records) {
            Err(LearnError::Data(_)) => {}
            Ok(found) => assert!(rejected(&found), "{method:?}: {:?} {:?}", found.terms, found.warnings),
            Err(e) => panic!("{method:?}: {e}"),
        }
    }
}

/// The known part feeds energy without end; no friction of the dictionary can hold it.
#[test]
fn an_unstable_wrong_model() {
    let text = oscillator(r#""d": 2.5"#, "d*v - x + cos(0.7*t)", COULOMB, "-2.6*v - 0.4*sgn(v)");
    let (case, records) = common::load_text(&text, &[]);
    for method in METHODS {
        match run_by(method, &case, &records) {
            Ok(found) => {
                assert!(rejected(&found), "{method:?}: {:?}", found.terms);
                let Verdict::Rejected(why) = found.verdict else { unreachable!() };
                assert!(!why.to_string().is_empty());
            }
            Err(LearnError::Numerics(why)) => {
                let why = why.to_string();
                assert!(why.contains("t = ") || why.contains("time"), "{why}");
            }
            Err(e) => panic!("{method:?}: {e}"),
        }
    }
}

#[test]
fn a_candidate_that_is_not_a_number_on_the_data() {
    let unknown = r#"(factor: "-sgn(v)", candidates: ["1", "ln(x)"])"#;
    let (case, records) = common::load_text(&oscillator("", SPRING, unknown, "-0.4*sgn(v)"), &[]);
    match run_by(Method::Step, &case, &records) {
        Err(LearnError::Numerics(why)) => assert!(why.to_string().contains("candidate"), "{why}"),
        Ok(found) => panic!("{:?} {:?}", found.terms, found.verdict),
        Err(e) => panic!("{e}"),
    }
    // The trajectory method may do without the candidate; it must not use it.
    match run(&case, &records) {
        Err(why) => assert!(!why.to_string().is_empty()),
        Ok(found) => assert!(
            rejected(&found) || found.terms.iter().all(|t| t.term == 0),
            "{:?} {:?}",
            found.terms,
            found.warnings
        ),
    }
}

#[test]
fn a_constant_that_runs_into_its_bound() {
    let k = r#""k": (value: 1.5, within: (1.3, 2.0))"#;
    let known = "-0.1*v - k*x + cos(0.7*t)";
    let (case, records) = common::load_text(&oscillator(k, known, COULOMB, "-0.2*sgn(v) + 0.5*x"), &[]);
    for method in METHODS {
        let found = run_by(method, &case, &records).unwrap();
        let k = &found.parameters[0];
        assert!(k.at_bound && k.estimate.value == 1.3, "{method:?}: {k:?}");
        assert!(
            found.warnings.iter().any(|w| w.to_string().contains("k ended at its bound 1.3")),
            "{:?}",
            found.warnings
        );
    }
}

/// What is missing is not in the dictionary: rejected, or at least said.
#[test]
fn a_truth_outside_the_dictionary() {
    let unknown = r#"(factor: "-sgn(v)", candidates: ["1", "x"])"#;
    for truth in ["-0.6*x^3", "-0.3*sgn(v) - 0.5*v*|v|", "-0.2*sgn(v) + 0.3*sin(2.1*t)"] {
        let (case, records) = common::load_text(&oscillator("", SPRING, unknown, truth), &[]);
        match run(&case, &records) {
            Ok(found) => assert!(
                rejected(&found)
                    || found.warnings.iter().any(|w| w.to_string().contains("something is still missing")),
                "{truth}: {:?} {:?} {:?}",
                found.terms,
                found.warnings,
                found.records[0].nrmse
            ),
            Err(e) => assert!(!e.to_string().is_empty()),
        }
    }
}

/// Two candidates that the data cannot tell apart, or that are the same.
#[test]
fn terms_that_cannot_be_told_apart() {
    let unknown = r#"(factor: "-sgn(v)", candidates: ["1", "1.0000001"])"#;
    let (case, records) =
        common::load_text(&oscillator("", SPRING, unknown, "-0.4*sgn(v)"), &[("learn.selection", "All")]);
    let found = run(&case, &records).unwrap();
    if found.terms.len() == 2 {
        assert!(
            found
                .warnings
                .iter()
                .any(|w| w.to_string().contains("do not tell") || w.to_string().contains("trade off")),
            "{:?} {:?}",
            found.terms,
            found.warnings
        );
    }
    let sum: f64 = found.terms.iter().map(|t| t.coefficient.value).sum();
    assert!((sum - 0.4).abs() < 0.02, "{:?}", found.terms);
    // Selection needs only one.
    let (case, records) = common::load_text(&oscillator("", SPRING, unknown, "-0.4*sgn(v)"), &[]);
    let found = run(&case, &records).unwrap();
    assert_eq!(found.terms.len(), 1, "{:?} {:?}", found.terms, found.warnings);
    assert!((found.terms[0].coefficient.value - 0.4).abs() < 0.01);
}

/// One amplitude, constant speed but for its sign: Coulomb and viscous friction do the same.
#[test]
fn a_trade_off_is_told_in_words() {
    // A free mass pushed to and fro: its speed hardly changes between reversals of a fast, small push.
    let text = r#"(states: {"v": ""}, known: {"v": "30*tanh(20*sin(0.5*t)) - 29*v"}, unknown: {"v": (factor: "-1", candidates: ["sgn(v)", "v"])},
        contacts: ["v"], data: [Synthetic(truth: {"v": "-0.4*sgn(v) - 0.2*v"}, start: {"v": 0.5}, duration: 40.0, step: 0.02, noise: Additive(0.05), seed: 3)],
        learn: (selection: All))"#;
    let (case, records) = common::load_text(text, &[]);
    let found = run(&case, &records).unwrap();
    assert!(
        found.warnings.iter().any(|w| w.to_string().contains("trade off")),
        "{:?} {:?}",
        found.terms,
        found.warnings
    );
}

/// Nothing is missing: nothing is invented.
#[test]
fn no_friction_at_all() {
    let unknown = r#"(factor: "-sgn(v)", candidates: ["1", "x", "v"])"#;
    let (case, records) = common::load_text(&oscillator("", SPRING, unknown, "0"), &[]);
    let found = run(&case, &records).unwrap();
    for t in &found.terms {
        assert!(t.coefficient.value.abs() < 4.0 * t.coefficient.std_error.max(1e-3), "{:?}", found.terms);
    }
    assert!(found.terms.is_empty() || rejected(&found), "{:?} {:?}", found.terms, found.verdict);
}

#[test]
fn stops_when_it_is_told_to() {
    let (case, records) = common::load("case1a", &[]);
    for method in METHODS {
        let found = identify(
            &case,
            &records,
            &LearnOptions { method: Some(method), ..Default::default() },
            &mut |_| ControlFlow::Break(()),
        );
        assert!(found.unwrap().interrupted(), "{method:?}");
    }
}

/// A mass that is released comes to rest after a few swings; a fit with a swing more or less is a side
/// minimum.
#[test]
fn a_released_mass_is_fitted_with_as_many_swings_as_it_makes() {
    let text = r#"(constants: {"m": 0.9247, "k": 3.717, "c": 0.06637}, states: {"x": "", "v": ""}, known: {"x": "v", "v": "(-k*x - c*v)/m"},
        unknown: {"v": (factor: "-sgn(v)/m", candidates: ["1", "x", "|v|"])}, contacts: ["v"],
        data: [Synthetic(truth: {"v": "-0.3051*sgn(v)/m"}, start: {"x": -1.999, "v": 0.0}, duration: 27.09, step: 0.02456,
            noise: Additive(0.04161), seed: 1, measure: ["x"])])"#;
    for seed in ["1", "2", "3", "4", "5"] {
        let (case, records) = common::load_text(text, &[("data.0.seed", seed)]);
        let found = run(&case, &records).unwrap();
        assert_eq!(
            found.terms.iter().map(|t| t.term).collect::<Vec<_>>(),
            [0],
            "seed {seed}: {:?}",
            found.warnings
        );
        let e = found.terms[0].coefficient;
        assert!((e.value - 0.3051).abs() < 5.0 * e.std_error, "seed {seed}: {e:?}");
        assert!(found.warnings.is_empty(), "seed {seed}: {:?}", found.warnings);
    }
}

/// Damping that the known part has too little of hides in the friction, and at another amplitude asks for
/// another one.
#[test]
fn a_validate_record_contradicts_friction_that_stands_for_damping() {
    let text = r#"(constants: {"m": 1.0}, states: {"x": "", "v": ""}, known: {"x": "v", "v": "(-0.08*v - x + G*cos(0.8*t))/m"},
        unknown: {"v": (factor: "-sgn(v)/m", candidates: ["1"])}, contacts: ["v"],
        data: [Synthetic(truth: {"v": "-0.2*sgn(v) - EXTRA*v"}, start: {"x": 0.0, "v": 0.0}, duration: 60.0, step: 0.05, constants: {"G": 0.7}, noise: Additive(0.05), seed: 1),
               Synthetic(truth: {"v": "-0.2*sgn(v) - EXTRA*v"}, start: {"x": 0.0, "v": 0.0}, duration: 60.0, step: 0.05, constants: {"G": 0.35}, noise: Additive(0.05), seed: 2, role: Validate)])"#;
    let warned = |extra: &str| {
        let (case, records) = common::load_text(&text.replace("EXTRA", extra), &[]);
        let found = run(&case, &records).unwrap();
        found.warnings.iter().any(|w| w.to_string().contains("do not carry over"))
    };
    assert!(warned("0.006"));
    assert!(!warned("0.0"));
}

/// A falling friction and a growing one are nearly the same over a narrow range of speeds.
#[test]
fn another_choice_of_terms_that_does_as_well_is_told_of() {
    let text = r#"(states: {"x": "", "v": ""}, known: {"x": "v", "v": "-0.1*v - x + cos(0.7*t)"},
        unknown: {"v": (factor: "-sgn(v)", candidates: ["1", "1 + 0.001*x"])}, contacts: ["v"],
        data: [Synthetic(truth: {"v": "-0.3*sgn(v)"}, start: {"x": 0.5, "v": 0.1}, duration: 40.0, step: 0.02, noise: Additive(0.05), seed: 3)])"#;
    let (case, records) = common::load_text(text, &[]);
    let found = run(&case, &records).unwrap();
    assert_eq!(found.terms.len(), 1);
    assert!(found.warnings.iter().any(|w| w.to_string().contains("in place of")), "{:?}", found.warnings);
    let (case, records) = common::load_text(&text.replace("1 + 0.001*x", "x^2"), &[]);
    let found = run(&case, &records).unwrap();
    assert!(!found.warnings.iter().any(|w| w.to_string().contains("in place of")), "{:?}", found.warnings);
}

/// A little in the stiffness: far below the noise, but not noise.
#[test]
fn a_small_mistake_in_the_known_part_is_told_of() {
    let warned = |stiffness: &str| {
        let text = oscillator(
            "",
            "-0.05*v - x + 0.5*cos(0.9*t)",
            r#"(factor: "-sgn(v)", candidates: ["1"])"#,
            &format!("-0.1*sgn(v) - ({stiffness})*x"),
        );
        let (case, records) =
            common::load_text(&text, &[("data.0.duration", "100.0"), ("data.0.noise", "Additive(0.05)")]);
        let found = run(&case, &records).unwrap();
        (
            found
                .warnings
                .iter()
                .any(|w| w.to_string().contains("a number of the known part is a little wrong")),
            found.warnings,
        )
    };
    let (told, said) = warned("0.0012");
    assert!(told, "{said:?}");
    let (told, said) = warned("0.0");
    assert!(!told && said.is_empty(), "{said:?}");
}

/// The records are of another model: of this one no single run can be made, from whatever start.
#[test]
fn a_model_that_is_nowhere_a_number() {
    let (_, records) = common::load_text(&oscillator("", SPRING, COULOMB, "-0.4*sgn(v)"), &[]);
    let case = common::prepare(&oscillator("", "ln(-1 - x^2)", COULOMB, "0"), &[]);
    let due = "the model cannot be simulated: the rate of `v` is not finite at t = 0.000000";
    let why = run(&case, &records).unwrap_err();
    assert!(matches!(why, LearnError::Numerics(_)) && why.to_string() == due, "{why}");
    let Err(LearnError::Numerics(why)) = run_by(Method::Step, &case, &records) else { panic!("identified") };
    assert!(why.to_string().contains("the one-step loss is not finite"), "{why}");
    let smooth: Vec<Record> = records.iter().map(|r| smoothed(&case.system, r)).collect();
    for effort in [Effort::Plain, Effort::Thorough, Effort::Errors] {
        let why = calibrate(&case.system, &records, &smooth, &[vec![0.01; 2]], effort).unwrap_err();
        assert_eq!(why.to_string(), "the rate of `v` is not finite at t = 0.000000");
    }
}

/// What was fitted holds, but the record to check with asks for the root of a negative number.
#[test]
fn a_record_to_check_with_that_cannot_run_is_a_rejection() {
    let record = |more: &str| {
        format!(
            r#"Synthetic(truth: {{"v": "-0.4*sgn(v)"}}, start: {{"x": 0.5, "v": 0.1}}, duration: 40.0, step: 0.02, noise: Additive(0.02), seed: 3,
                constants: {{"a": 1.0}}, {more})"#
        )
    };
    let text = format!(
        r#"(states: {{"x": "", "v": ""}}, known: {{"x": "v", "v": "-0.1*v - sqrt(a)*x + cos(0.7*t)"}}, unknown: {{"v": {COULOMB}}}, contacts: ["v"],
            data: [{}, {}])"#,
        record(r#"name: "fitted""#),
        record(r#"name: "checked", role: Validate"#),
    );
    let (case, mut records) = common::load_text(&text, &[]);
    records[1].constants[0] = -1.0;
    let found = run(&case, &records).unwrap();
    let due = "the free run of checked fails: the rate of `v` is not finite at t = 0.000000";
    let Verdict::Rejected(why) = &found.verdict else { panic!("identified") };
    assert_eq!(why.to_string(), due);
    assert_eq!((found.terms.len(), found.records[1].worst()), (1, f64::INFINITY));
    assert!(found.records[0].worst() < 0.03 && found.terms[0].contribution.is_some());
}

/// One step ahead the model is good; left alone it runs away, and along a run that does not exist no term
/// does anything.
#[test]
fn a_fitted_record_that_cannot_run_freely_says_nothing_of_what_terms_do() {
    let text = oscillator(
        "",
        "20*x + cos(0.7*t)",
        r#"(factor: "-1", candidates: ["v"])"#,
        "-21*x - 0.2*v - 0.1*sgn(v)",
    );
    let (case, records) = common::load_text(&text, &[]);
    let found = run_by(Method::Step, &case, &records).unwrap();
    let Verdict::Rejected(why) = &found.verdict else { panic!("{:?}", found.terms) };
    let why = why.to_string();
    assert!(why.contains("fails: `") && why.contains("grows without bound at t = "), "{why}");
    assert!(!found.terms.is_empty() && found.terms.iter().all(|t| t.contribution.is_none()));
}

#[test]
fn what_method_step_leaves_as_it_is_is_told() {
    let k = r#""k": (value: 1.0, unit: "1/s^2", within: (0.5, 2.0))"#;
    let text = oscillator(k, "-0.1*v - k*x + cos(0.7*t)", COULOMB, "-0.4*sgn(v)")
        .replace("optimiser: GaussNewton", "epochs: [20], rates: [0.1]");
    let (case, mut records) = common::load_text(&text, &[]);
    records[0].sensors[0].offset =
        SensorParameter { within: Some((-0.1, 0.1)), ..SensorParameter::fixed(0.0) };
    let found = run_by(Method::Step, &case, &records).unwrap();
    for due in [
        "method step with RAdam holds k at the spec's value; learn: (optimiser: GaussNewton) moves it",
        "method step holds sensor offsets, gains and delays at their start values",
    ] {
        assert!(found.warnings.iter().any(|w| w.to_string() == due), "{:?}", found.warnings);
    }
    assert!(found.parameters.is_empty());
}

/// A velocity is the derivative of its displacement; the other way round a constant is missing.
#[test]
fn method_step_without_a_displacement() {
    let (case, mut records) = common::load("case1a", &[("data.0.name", "\"run 1\"")]);
    records[0].columns[0] = None;
    let due = "run 1: method step needs samples of every state, and x cannot be derived from a column; use --method trajectory";
    let why = run_by(Method::Step, &case, &records).unwrap_err();
    assert!(matches!(why, LearnError::Data(_)) && why.to_string() == due, "{why}");
}

/// The spring begins to harden where the motion never comes.
#[test]
fn a_constant_that_nothing_depends_on() {
    let q = r#""q": (value: 1.0, unit: "1/s^2", within: (0.1, 2.0))"#;
    let text = oscillator(q, "-0.1*v - x - q*pos(x - 50) + cos(0.7*t)", COULOMB, "-0.4*sgn(v)");
    let (case, records) = common::load_text(&text, &[]);
    let found = run(&case, &records).unwrap();
    let due = "the data say nothing about q: give it a value, or leave it out";
    assert!(found.warnings.iter().any(|w| w.to_string() == due), "{:?}", found.warnings);
    let q = found.parameters[0].estimate;
    assert_eq!((q.std_error, q.ci95), (f64::INFINITY, (0.1, 2.0)));
    assert!((found.terms[0].coefficient.value - 0.4).abs() < 0.01);
}

/// Friction that feeds the motion, however well it follows the data, is a wrong model: damping that falls
/// with the amplitude ends as a dashpot beside negative dry friction. Nothing of the kind is said of the same
/// friction where it dissipates, of friction that falls with the speed, and of an oscillator that excites
/// itself.
#[test]
fn dry_friction_that_feeds_the_motion_is_rejected() {
    let free = |unknown: &str, truth: &str| {
        let text = format!(
            r#"(states: {{"x": "m", "v": "m/s"}}, known: {{"x": "v", "v": "-4*x"}}, unknown: {{"v": {unknown}}}, contacts: ["v"],
            data: [Synthetic(truth: {{"v": "{truth}"}}, start: {{"x": 1.0, "v": 0.0}}, duration: 30.0, step: 0.02, noise: Additive(0.002), seed: 3)])"#
        );
        let (case, records) = common::load_text(&text, &[]);
        run(&case, &records).unwrap()
    };
    let both = r#"(factor: "-1", candidates: ["sgn(v)", "v"])"#;
    let found = free(both, "-0.03*v*|v|");
    let Verdict::Rejected(why) = &found.verdict else { panic!("{:?} {:?}", found.terms, found.warnings) };
    assert!(why.to_string().starts_with("the dry friction of v is negative: -0.0"), "{why}");
    let told = found.warnings.iter().any(|w| w.to_string().contains("which `phisindy gap` looks for"));
    assert!(told, "{:?}", found.warnings);
    // Written as a polynomial of the speed under one sign the damper hides the push: the mean dissipates.
    let found = free(r#"(factor: "-sgn(v)", candidates: ["1", "|v|"])"#, "0.02*sgn(v) - 0.12*v");
    let Verdict::Rejected(why) = &found.verdict else { panic!("{:?} {:?}", found.terms, found.warnings) };
    assert!(why.to_string().starts_with("the dry friction of v is negative: -0.0"), "{why}");
    for (unknown, truth) in [
        (both, "-0.03*v - 0.01*sgn(v)"),
        // The level falls with the speed, and stays above zero.
        (r#"(factor: "-sgn(v)", candidates: ["1", "|v|"])"#, "-(0.05 - 0.012*|v|)*sgn(v)"),
        (r#"(candidates: ["v", "x^2*v", "sgn(v)"])"#, "0.8*(1 - x^2)*v"),
    ] {
        let found = free(unknown, truth);
        assert_eq!(found.verdict, Verdict::Identified, "{truth}: {:?} {:?}", found.terms, found.warnings);
        assert_eq!(found.terms.len(), 2, "{truth}: {:?}", found.terms);
    }
}

/// `+c*v` in the known part is no damper: the fit makes its constant negative, and that is said.
#[test]
fn a_damper_with_the_wrong_sign_is_rejected() {
    let of = |known: &str, truth: &str| {
        let text = oscillator(r#""c": Find(start: 0.1, within: (-5.0, 5.0))"#, known, COULOMB, truth);
        let text = text.replace(r#"{"x": "", "v": ""}"#, r#"{"x": "m", "v": "m/s"}"#);
        let (case, records) = common::load_text(&text, &[]);
        run(&case, &records).unwrap()
    };
    // What is to be found is made as it starts.
    let found = of("c*v - x + cos(0.7*t)", "-0.6*v - 0.2*sgn(v)");
    let Verdict::Rejected(why) = &found.verdict else { panic!("{:?}", found.parameters) };
    assert!(why.to_string().contains("c is negative: -0.5"), "{why}");
    assert!(found.warnings.iter().any(|w| w.to_string().contains("change the sign of the term with c")));
    let found = of("-c*v - x + cos(0.7*t)", "-0.4*v - 0.2*sgn(v)");
    assert_eq!(found.verdict, Verdict::Identified, "{:?} {:?}", found.parameters, found.warnings);
    // Less friction than the spec says, and a damping that feeds: a dashpot cannot.
    let found = of("-c*v - x - 0.6*sgn(v) + cos(0.7*t)", "0.2*v + 0.2*sgn(v)");
    assert!(rejected(&found), "{:?} {:?}", found.parameters, found.terms);
}

/// A right model that lacks nothing is no rejection, and one that lacks what the dictionary cannot name is.
#[test]
fn a_known_part_that_is_complete_is_identified() {
    let unknown = r#"(factor: "-sgn(v)", candidates: ["1"])"#;
    let of = |truth: &str| {
        let (case, records) = common::load_text(&oscillator("", SPRING, unknown, truth), &[]);
        run(&case, &records).unwrap()
    };
    let found = of("0");
    assert!(found.terms.is_empty());
    assert_eq!(found.verdict, Verdict::Identified, "{:?}", found.warnings);
    let found = of("0.1*sin(1.9*t)");
    assert!(!found.terms.is_empty() || rejected(&found), "{:?}", found.warnings);
}

/// Two tanks, one above the other, of which the lower one is seen: `sqrt(|h|)` has no finite slope at zero,
/// where a state without a column starts.
fn tanks(rate: &str) -> (Case, Vec<Record>) {
    let text = format!(
        r#"(constants: {{"k1": Find(start: 0.1, within: (0.0, 1.0)), "k4": Find(start: 0.1, within: (0.0, 1.0))}}, states: {{"h1": "", "h2": ""}},
            inputs: {{"u": ""}}, known: {{"h1": "{rate}", "h2": "0.05*sqrt(|h1|) - 0.05*sqrt(|h2|)"}}, unknown: {{}},
            data: [Synthetic(truth: {{}}, start: {{"h1": 6.0, "h2": 5.0}}, duration: 2000.0, step: 4.0, noise: Additive(0.02), measure: ["h2"],
            inputs: {{"u": Formula("2.5 + sin(0.011*t) + sin(0.004*t)")}}, seed: 3)])"#
    );
    let set = r#"(value: 0.06, within: (0.0, 1.0))"#;
    let (_, records) = common::load_text(
        &text,
        &[("constants.k1", set), ("constants.k4", r#"(value: 0.05, within: (0.0, 1.0))"#)],
    );
    let mut records = records;
    records[0].start.fill(None);
    (common::prepare(&text, &[]), records)
}

#[test]
fn a_state_that_would_start_where_a_root_has_no_slope_starts_elsewhere() {
    let (case, records) = tanks("-k1*sqrt(|h1|) + k4*u");
    let found = run(&case, &records).unwrap();
    assert_eq!(found.verdict, Verdict::Identified, "{:?}", found.warnings);
    for (p, truth) in found.parameters.iter().zip([0.06, 0.05]) {
        assert!((p.estimate.value - truth).abs() < 4.0 * p.estimate.std_error, "{p:?}");
        assert!((p.estimate.value - truth).abs() < 0.05 * truth, "{p:?}");
    }
}

/// A fit that cannot move says so, with the reason, and nothing of what the data tell apart.
#[test]
fn a_fit_that_failed_is_not_told_as_identifiability() {
    let (case, records) = tanks("-k1*sqrt(|h1|) + k4*u - 0.1*sqrt(|h1|*step(h1 - 100))");
    let found = run(&case, &records).unwrap();
    let Verdict::Rejected(why) = &found.verdict else { panic!("{:?}", found.parameters) };
    assert!(
        why.to_string().starts_with("the fit failed, and every value is where it started: sqrt("),
        "{why}"
    );
    assert!(why.to_string().contains("has no finite slope at h1 = "), "{why}");
    let about = |w: &phisindy_learn::Warning| {
        let w = w.to_string();
        w.contains("do not tell") || w.contains("say nothing") || w.contains("trade off")
    };
    assert!(!found.warnings.iter().any(about), "{:?}", found.warnings);
}

/// What a prescribed motion meets: a spring, a damper, and `lacks`.
fn tester(lacks: &str) -> (Case, Vec<Record>) {
    common::load_text(
        &r#"(constants: { "k": (value: 900.0, unit: "N/m", within: (0.0, 1e5)), "c": (value: 20.0, unit: "N*s/m", within: (0.0, 1e4)) },
            states: {}, inputs: { "x": "m", "dx": "m/s" }, outputs: { "F": (unit: "N", reads: "k*x + c*dx") },
            known: {}, unknown: {},
            data: [Synthetic(truth: { "F": "LACKS" }, start: {}, duration: 40.0, step: 0.02, seed: 5,
                inputs: { "x": Formula("0.01*sin(3*t) + 0.004*cos(7.3*t)") }, derive: { "dx": Derivative("x") },
                noise: Sensor({ "F": (0.02, "N") }))])"#
            .replace("LACKS", lacks),
        &[],
    )
}

/// What is left of an output and follows the motion is a law that the model lacks, whatever the intervals say; noise of
/// the same size and colour is noise.
#[test]
fn a_law_that_an_output_shows_is_missing_and_coloured_noise_is_none() {
    let (case, records) = tester("4*sgn(dx)");
    let found = run(&case, &records).unwrap();
    let Verdict::Rejected(Rejection::LawMissing { of, output: true, share, .. }) = &found.verdict else {
        panic!("{:?}", found.verdict)
    };
    assert!(of == "F" && *share > 0.1, "{of} {share}");
    let (case, mut records) = tester("0");
    let mut left = 0.0;
    let noise = phisindy_signal::test_signals::gaussian(records[0].len(), 11);
    for (force, drawn) in records[0].columns[0].as_mut().unwrap().iter_mut().zip(noise) {
        left = 0.9 * left + 0.7 * drawn;
        *force += left;
    }
    let found = run(&case, &records).unwrap();
    assert_eq!(found.verdict, Verdict::Identified, "{:?}", found.warnings);
    assert!(found.warnings.iter().any(Warning::doubts_residual), "{:?}", found.warnings);
}
