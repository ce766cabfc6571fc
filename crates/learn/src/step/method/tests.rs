//! The paper's method on a line, whose loss has its minimum at the mean of the steps.

use super::*;
use crate::identify::{LearnOptions, identify};
use crate::line_models::{STEP, records, scatter};
use crate::result::identified::StopReason;
use crate::result::verdict::Verdict;
use approx::assert_relative_eq;

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

/// Where the spec gives one list alone.
#[test]
fn the_shorter_list_says_how_many_stages_there_are() {
    let stages = |learn: &str| {
        let case = records(&format!("{LINE}, learn: ({learn})"), &[(Role::Fit, line())]).0;
        let StepOptions { epochs, rates, horizon, .. } = step_options(&case);
        (epochs, rates, horizon)
    };
    let default = StepOptions::default();
    assert_eq!(stages(""), (default.epochs.clone(), default.rates.clone(), 1));
    assert_eq!(stages("epochs: [5, 6], horizon: 3"), (vec![5, 6], default.rates[..2].to_vec(), 3));
    assert_eq!(stages("rates: [0.5]"), (default.epochs[..1].to_vec(), vec![0.5], 1));
}

/// In the unit of the spec.
#[test]
fn a_parameter_at_a_bound_is_told() {
    let system = case().0.system;
    for (value, says) in [(4e-3, "c ended at its bound 4:"), (-3e-3, "c ended at its bound -3:"), (1e-3, "")]
    {
        let found = found_parameters(&system, &[value], &[1e-4]);
        assert_eq!(
            (found[0].id.constant(), found[0].factor, found[0].at_bound),
            (Some(0), 1e-3, !says.is_empty())
        );
        let told = texts(&at_bounds(&found)).concat();
        assert!(told.starts_with(says) && told.is_empty() == says.is_empty(), "{told}");
    }
}

fn by_method_step(learn: &str, change: impl Fn(&mut Record)) -> Identified {
    let text = LINE.replace(r#""x", "x^2"], within: {"1": (0.0, 5.0)}"#, r#"], within: {"1": (0.0, 5.0)}"#);
    let (case, mut records) =
        records(&format!("{text}, learn: ({learn})"), &[(Role::Fit, line()), (Role::Validate, line())]);
    records.iter_mut().for_each(change);
    let options = LearnOptions { method: Some(Method::Step), ..Default::default() };
    identify(&case, &records, &options, &mut |_| ControlFlow::Continue(())).unwrap()
}

/// Each step from one sample to the next, forward and backward, is met best on the mean by the mean of all
/// steps, which is from the first to the last sample.
#[test]
fn the_steps_of_a_line_are_met_by_their_mean() {
    let found = by_method_step("optimiser: GaussNewton, cutoff: 1e-3", |_| {});
    let x = line();
    let due = (x[SAMPLES - 1] - x[0]) / (STEP * (SAMPLES - 1) as f64);
    assert_eq!(found.terms.len(), 1);
    assert_relative_eq!(found.terms[0].coefficient.value, due, max_relative = 1e-9);
    assert_eq!(
        (found.verdict, found.method, found.stop_reason),
        (Verdict::Identified, Method::Step, StopReason::Finished)
    );
    assert_eq!(found.parameters.iter().map(|p| p.id.to_string()).collect::<Vec<_>>(), ["c"]);
    assert_eq!((found.covariance.len(), found.covariance[0].len()), (2, 2));
    assert_relative_eq!(
        found.covariance[0][0].sqrt(),
        found.terms[0].coefficient.std_error,
        max_relative = 1e-9
    );
}

/// A velocity that is derived may be derived otherwise; one that is measured is what it is.
#[test]
fn a_derived_velocity_is_doubted() {
    let text = r#"states: {"x": "", "v": ""}, known: {"x": "v", "v": "0"}, unknown: {"v": (factor: "1", candidates: ["x"])}, learn: (optimiser: GaussNewton, cutoff: 1e-3)"#;
    let wave = |turn: f64| (0..200).map(|i| (STEP * i as f64 + turn).cos()).collect::<Vec<_>>();
    let (case, mut records) = records(text, &[(Role::Fit, wave(0.0))]);
    let told = |records: &[Record]| {
        let options = LearnOptions { method: Some(Method::Step), ..Default::default() };
        let found = identify(&case, records, &options, &mut |_| ControlFlow::Continue(())).unwrap();
        assert_relative_eq!(found.terms[0].coefficient.value, -1.0, max_relative = 0.05);
        texts(&found.warnings).iter().any(|w| {
            w.starts_with("the result depends on how columns are differentiated")
                && w.contains(" x in v' would move")
        })
    };
    assert!(told(&records));
    records[0].columns[1] = Some(wave(0.5 * std::f64::consts::PI));
    assert!(!told(&records));
}

#[test]
fn what_method_step_holds_is_told() {
    let told = |learn: &str, change: fn(&mut Record)| {
        let found = by_method_step(&format!("epochs: [20], cutoff: 1e-3, {learn}"), change);
        let warnings = texts(&found.warnings);
        [" holds c at the spec's value", "holds sensor offsets, gains and delays"]
            .map(|says| warnings.iter().any(|w| w.contains(says)))
    };
    assert_eq!(told("", |_| {}), [true, false]);
    assert_eq!(told("optimiser: GaussNewton", |_| {}), [false, false]);
    assert_eq!(
        told("optimiser: GaussNewton", |r| r.sensors[0].gain.within = Some((-9.0, 9.0))),
        [false, true]
    );
}
