//! Runs that cannot go on, and odd requests: an error or a result, never a panic or a hang.

use crate::common::{self, Case, grid};
use phisindy_sim::SimError;

#[test]
fn logarithm_of_a_negative_state() {
    let case = Case::new(&[("x", 1.0, "-1"), ("z", 0.0, "ln(x)")], &[]);
    match case.try_run(&[2.0]) {
        Err(SimError::NotFinite { time, state }) => {
            assert_eq!(state, "z");
            assert!((time - 1.0).abs() < 1e-3, "{time}");
        }
        other => panic!("{other:?}"),
    }
    assert!(matches!(
        Case::new(&[("x", -1.0, "ln(x)")], &[]).try_run(&[2.0]),
        Err(SimError::NotFinite { time: 0.0, .. })
    ));
}

#[test]
fn a_parameter_or_start_that_is_no_number() {
    let case = Case::new(&[("x", 1.0, "v"), ("v", 0.5, "-k*x - sgn(v)")], &[("k", f64::NAN)]);
    assert!(matches!(case.try_run(&[1.0]), Err(SimError::NotFinite { .. })));
    let case = Case::new(&[("x", f64::NAN, "v"), ("v", f64::NAN, "-x - sgn(v)")], &[]);
    assert!(case.try_run(&[1.0]).is_err());
}

/// It starts on its surface, so that the contact rule sees the load before any step does.
#[test]
fn a_load_at_rest_that_is_no_number() {
    let case = Case::new(&[("x", 0.0, "v"), ("v", 0.0, "sqrt(x - 1) - sgn(v)")], &[]);
    let due = SimError::NotFinite { time: 0.0, state: "v".into() };
    assert_eq!(case.try_run(&[1.0]).unwrap_err(), due);
}

/// The step that finds the event ends where the state is too large already.
#[test]
fn what_has_diverged_at_an_event_ends_there() {
    let mut case = Case::new(&[("x", 0.0, "v"), ("v", 1.0, "(1 + sgn(x - 5))/2")], &[]);
    case.options.diverged = 4.0;
    match case.try_run(&[20.0]) {
        Err(SimError::Diverged { time, state }) => {
            assert_eq!(state, "x");
            assert!((time - 5.0).abs() < 1e-9, "{time}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn blow_up_in_finite_time() {
    match Case::new(&[("x", 1.0, "x^2")], &[]).try_run(&[2.0]) {
        Err(SimError::Diverged { time, state }) => {
            assert_eq!(state, "x");
            assert!((time - 1.0).abs() < 1e-6, "{time}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn no_samples_one_sample_and_samples_at_the_start() {
    let case = common::case_1a();
    let none = case.run_with_sensitivities(&[]);
    assert!(none.states.is_empty() && none.events.is_empty() && none.steps == 0);
    let start = case.run(&[0.0, 0.0]);
    assert_eq!(start.states, [0.1, 0.1, 0.1, 0.1]);
    assert_eq!((start.modes, start.steps), (vec![1, 1], 0));
    let one = case.run(&[40.0]);
    let many = case.run(&grid(40.0, 4000));
    for i in 0..2 {
        assert!((one.states[i] - many.states[8000 + i]).abs() < 1e-9);
    }
    assert_eq!(one.events.len(), many.events.len());
    let twice = case.run(&[1.0, 1.0, 2.0, 2.0]);
    assert_eq!(twice.states[..2], twice.states[2..4]);
    assert_eq!(twice.states[4..6], twice.states[6..8]);
}

#[test]
fn a_single_late_sample_of_something_stuck() {
    let case = Case::new(&[("x", 0.0, "v"), ("v", 0.0, "0.4*sin(t) - 0.5*sgn(v)")], &[]);
    let run = case.run(&[1000.0]);
    assert_eq!(run.states, [0.0, 0.0]);
    assert!(run.steps < 2000, "{}", run.steps);
}

/// Bouncing between two force switches with ever shorter flights (a relay that meets friction) ends at an
/// instant.
#[test]
fn flutter_ends_in_an_error_or_a_result() {
    let relay = Case::new(&[("x", 0.3, "v"), ("v", 0.0, "-sgn(x) - 0.3*sgn(v)")], &[]);
    match relay.try_run(&[100.0]) {
        Err(SimError::TooManyEvents { time, .. }) => assert!((5.0..6.0).contains(&time), "{time}"),
        other => panic!("{other:?}"),
    }
    let stops =
        Case::new(&[("x", 0.0, "v"), ("v", 1.0, "-1e4*(step(x-1e-3)+step(-x-1e-3)-1)*sgn(x) - v")], &[]);
    let _ = stops.try_run(&[10.0]);
    // Pushed onto the surface from both sides, without friction: it slides along, which is sticking.
    let slide = Case::new(&[("x", 1.0, "0.5 - sgn(x)")], &[]).run(&[1.0, 5.0]);
    assert!((slide.states[0] - 0.5).abs() < 1e-12 && slide.states[1] == 0.0);
}

#[test]
fn too_many_steps_is_an_error() {
    let mut case = common::case_1a();
    case.options.max_steps = 50;
    match case.try_run(&[50.0]) {
        Err(SimError::TooManySteps { time }) => assert!(time > 0.0 && time < 50.0),
        other => panic!("{other:?}"),
    }
}

#[test]
fn errors_say_what_where_and_when() {
    let (time, name) = (1.25, || "x".to_owned());
    for (error, text) in [
        (SimError::NotFinite { time, state: name() }, "the rate of `x` is not finite at t = 1.250000"),
        (SimError::Diverged { time, state: name() }, "`x` grows without bound at t = 1.250000"),
        (SimError::TooManySteps { time }, "the step length collapsed at t = 1.250000"),
        (SimError::TooManyEvents { time, switch: name() }, "`x` changes sign without end at t = 1.250000"),
    ] {
        assert_eq!(error.to_string(), text);
    }
}

#[test]
#[should_panic(expected = "finite times")]
fn a_sample_time_that_is_no_number_is_the_callers_mistake() {
    let _ = common::case_1a().try_run(&[f64::NAN]);
}

/// A trial whose result is no longer needed ends at its next step; other work runs on to its end.
#[test]
fn an_aborting_stop_ends_a_run() {
    let mut case = Case::new(&[("x", 1.0, "v"), ("v", 0.0, "-x - 0.1*sgn(v)")], &[]);
    let stop = phisindy_sim::Stop::default();
    stop.request();
    case.options.stop = stop.finishing();
    assert!(case.try_run(&[2.0]).is_ok());
    case.options.stop = stop.aborting();
    assert_eq!(case.try_run(&[2.0]).unwrap_err(), SimError::Stopped { time: 0.0 });
}
