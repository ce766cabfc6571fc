//! Synthetic records: inputs of every kind, what is recorded of them, and what is said where one cannot be

//! made.

use approx::assert_abs_diff_eq;
use phisindy_phys::spec::InputSpec;
use phisindy_phys::{Note, Origin, Record, SourceId, check, spec};
use phisindy_signal::{Interpolation, Signal};
use phisindy_sim::{ExcitationError, SyntheticError, Trajectory, synthesize};
use std::sync::Arc;

/// A mass that a spring ties to a moving base, without friction or noise; the rest of the record is filled
/// in.
fn made(
    constants: &str,
    truth: &str,
    record: &str,
    file: &dyn Fn(&InputSpec) -> Result<Signal, String>,
) -> Result<(Record, Trajectory), SyntheticError> {
    let text = format!(
        r#"(constants: {{"A": (0.5, "m"), "W": (2.0, "rad/s"), "k": (9.0, "1/s^2"), {constants}}}, states: {{"x": "m", "v": "m/s"}},
            inputs: {{"u": "m", "du": "m/s"}}, known: {{"x": "v", "v": "-k*(x - u)"}}, unknown: {{}},
            data: [Synthetic(truth: {{"v": "{truth}"}}, start: {{"x": 0.3}}, duration: 10.0, step: 0.01, {record})])"#
    );
    let (spec, _) = spec::read(&text, SourceId(0)).unwrap_or_else(|e| panic!("{e:#?}"));
    let (case, _) = check(&spec, SourceId(0)).unwrap_or_else(|e| panic!("{e:#?}"));
    let Origin::Synthetic(truth) = &case.records[0].origin else { panic!("a measured record") };
    synthesize(&case.records[0], truth, &case.system, None, file)
}

fn no_file(_: &InputSpec) -> Result<Signal, String> {
    Err("no such file".into())
}

const BASE: &str = r#"inputs: {"u": Formula("A*cos(W*t)")}, derive: {"du": Derivative("u")}"#;

/// Its record holds what a rig's would: the derivative is that of the samples, and a note says how it was
/// made.
#[test]
fn the_derivative_of_a_measured_input_is_derived_from_its_samples() {
    let (record, clean) = made("", "0", &format!(r#"{BASE}, measure: ["x", "u"]"#), &no_file).unwrap();
    for (k, &t) in record.time.iter().enumerate() {
        let (u, du) = (0.5 * (2.0 * t).cos(), -(2.0 * t).sin());
        assert_abs_diff_eq!(record.inputs[0].values()[k], u, epsilon = 1e-4);
        // Without noise what is left is the error of the differentiator, largest at the ends.
        assert_abs_diff_eq!(record.inputs[1].values()[k], du, epsilon = 2e-2);
        // x'' = -9 (x - u) from 0.3 at rest: a free part and 9 * 0.5/(9 - 4) cos 2t.
        let x = -0.6 * (3.0 * t).cos() + 0.9 * (2.0 * t).cos();
        assert_abs_diff_eq!(clean.states[2 * k], x, epsilon = 1e-6);
    }
    assert_eq!((record.derivations.len(), record.derivations[0].input, record.derivations[0].of), (1, 1, 0));
    let derived = |n: &Note| matches!(n, Note::DerivedInput { input, of, .. } if input == "du" && of == "u");
    assert!(record.notes.iter().any(derived), "{:?}", record.notes);
    assert!(record.columns[0].is_some() && record.columns[1].is_none());
}

#[test]
fn the_largest_value_of_a_formula_is_a_constant_of_the_record() {
    let (record, _) = made(r#""top": MaxAbs("u")"#, "0", BASE, &no_file).unwrap();
    assert_eq!(record.constants, [0.5]);
    // A formula may hold constants of the record that stand before.
    let record = r#"inputs: {"u": Formula("B*cos(W*t)")}, derive: {"du": Derivative("u")}, constants: {"B": (0.7, "m")}"#;
    let (record, _) = made(r#""B": (0.2, "m"), "top": MaxAbs("u")"#, "0", record, &no_file).unwrap();
    assert_eq!(record.constants, [0.7, 0.7]);
    let said = made(r#""top": MaxAbs("du")"#, "0", BASE, &no_file).unwrap_err().to_string();
    assert_eq!(said, "MaxAbs needs an input with an excitation of its own");
}

/// What a sensor is known to do to its input is done and undone, each by its own.
#[test]
fn a_sensor_of_known_gain_leaves_its_input_as_it_is() {
    let record = r#"inputs: {"u": Formula("A*cos(W*t)"), "du": Formula("0.6*A*sin(W*t)")}, measure: ["x", "u", "du"],
        sensors: {"u": (gain: 0.5), "du": (gain: 4.0, offset: 1.0)}"#;
    let (record, _) = made("", "0", record, &no_file).unwrap();
    for (k, &t) in record.time.iter().enumerate() {
        assert_abs_diff_eq!(record.inputs[0].values()[k], 0.5 * (2.0 * t).cos(), epsilon = 1e-12);
        assert_abs_diff_eq!(record.inputs[1].values()[k], 0.3 * (2.0 * t).sin(), epsilon = 1e-12);
    }
}

#[test]
fn an_input_from_a_file_is_what_the_file_says() {
    let record =
        r#"inputs: {"u": File(path: "u.csv", time: "t", column: "u_m")}, derive: {"du": Derivative("u")}"#;
    let ramp = |_: &InputSpec| {
        Signal::new(Arc::from([0.0, 20.0]), vec![1.0, 5.0], Interpolation::Linear).map_err(|e| e.to_string())
    };
    let (made_of, clean) = made("", "0", record, &ramp).unwrap();
    for (k, &t) in made_of.time.iter().enumerate() {
        assert_abs_diff_eq!(made_of.inputs[0].values()[k], 1.0 + 0.2 * t, epsilon = 1e-12);
        assert_abs_diff_eq!(made_of.inputs[1].values()[k], 0.2, epsilon = 1e-12);
        // Behind a ramp it swings round it: x = 1 + t/5 - 0.7 cos 3t - sin(3t)/15.
        let x = 1.0 + 0.2 * t - 0.7 * (3.0 * t).cos() - (3.0 * t).sin() / 15.0;
        assert_abs_diff_eq!(clean.states[2 * k], x, epsilon = 1e-7);
    }
    assert_eq!(made("", "0", record, &no_file).unwrap_err(), SyntheticError::Other("no such file".into()));
}

/// `v` passes through -k/e = -4e10 between the first two samples, of which none shows it.
#[test]
fn what_is_large_between_samples_alone_does_not_grow_without_bound() {
    let truth = "-1e22*x - 2e11*v";
    let (_, clean) = made("", truth, BASE, &no_file).expect("a stable system");
    assert!(clean.states[2].abs() < 1e-9 && clean.states[3].abs() < 1e-3, "{:?}", &clean.states[2..4]);
}

#[test]
fn what_cannot_be_made_says_why() {
    let said = |truth: &str, record: &str| made("", truth, record, &no_file).unwrap_err().to_string();
    assert_eq!(
        said("1e-3*ln(-1 - (x/A)^2)", BASE),
        "the truth cannot be simulated: the rate of `v` is not finite at t = 0.000000"
    );
    assert_eq!(said("0", &format!("{BASE}, window: (1.0, 1.05)")), "the window leaves fewer than 10 samples");
    assert_eq!(
        SyntheticError::Excitation(ExcitationError::EmptyBand { low: 2.0, high: 1.0 }).to_string(),
        "the excitation cannot be made: the band from 2 to 1 is empty"
    );
}
