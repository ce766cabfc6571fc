//! The same spec, seed and version give the same bits, with any number of threads, again and again; only the
//! seconds differ.

#![allow(missing_docs)]

use crate::common::{Scratch, phisindy};
use std::fs;

/// Numbers of threads. A run that differs from itself differs from one with more threads, too.
const JOBS: &[&str] = &["1", "2", "8"];
const SHORT: &[&str] = &["specs/case1a.ron", "--set", "data.0.duration=20.0"];

/// The output without what a clock says.
fn timeless(text: &str) -> String {
    let without = |line: &str| match serde_json::from_str::<serde_json::Value>(line) {
        Ok(mut object) if object.is_object() => {
            object["seconds"] = serde_json::Value::Null;
            object.to_string()
        }
        _ => line.to_owned(),
    };
    text.lines().map(|line| without(line) + "\n").collect()
}

#[track_caller]
fn same(arguments: &[&str]) -> String {
    let of = |jobs: &str| {
        let said = phisindy(&[arguments, &["--quiet", "--jobs", jobs]].concat());
        assert!(said.code < 2, "{arguments:?}: {}", said.err);
        assert!(said.out.len() > 100, "{arguments:?}: {}", said.out);
        timeless(&said.out)
    };
    let first = of(JOBS[0]);
    JOBS[1..].iter().for_each(|jobs| assert!(of(jobs) == first, "--jobs {jobs} differs: {arguments:?}"));
    first
}

#[test]
fn a_run_has_the_same_bits_by_either_method() {
    let json = ["--format", "json"];
    let step = ["--method", "step", "--set", "learn=(epochs: [60, 60], rates: [0.1, 0.01])"];
    let by_steps = same(&[&["run"], SHORT, &step, &json].concat());
    let by_trajectory = same(&[&["run"], SHORT, &json].concat());
    assert_ne!(by_steps, by_trajectory);
    assert_ne!(same(&[&["run"], SHORT, &json, &["--seed", "7"]].concat()), by_trajectory);
}

#[test]
fn simulated_data_have_the_same_bits() {
    same(&["simulate", "specs/case5.ron", "--set", "data.0.duration=20.0"]);
}

#[test]
fn a_gap_has_the_same_bits() {
    let scratch = Scratch::new("gap");
    let record = |x: f64, seed: u32, role: &str| {
        format!(
            "Synthetic(truth: {{ \"v\": \"-0.4*sgn(v)\" }}, start: {{ \"x\": {x:?}, \"v\": 0.0 }}, duration: 20.0, step: 0.04, noise: Additive(0.02), seed: {seed}, role: {role})"
        )
    };
    let spec = format!(
        "(constants: {{ \"k\": (1.0, \"1/s^2\"), \"A\": (1.0, \"m/s^2\") }}, states: {{ \"x\": \"m\", \"v\": \"m/s\" }}, known: {{ \"x\": \"v\", \"v\": \"-k*x + A*cos(0.7*t)\" }}, unknown: {{}},\n\
         data: [{}, {}])",
        record(0.0, 1, "Fit"),
        record(0.5, 2, "Validate")
    );
    let path = scratch.path("spec.ron");
    fs::write(&path, spec).expect("written");
    assert!(same(&["gap", &path, "--format", "json"]).contains("coulomb"));
}

#[test]
fn a_sweep_has_the_same_bits_in_one_piece_or_in_several() {
    let sweep = [&["sweep"], SHORT, &["--seeds", "6", "--format", "json"]].concat();
    let whole = same(&sweep);
    let scratch = Scratch::new("pieces");
    let folder = scratch.path("out");
    let kept = [&sweep as &[&str], &["--quiet", "--out", &folder]].concat();
    assert_eq!(timeless(&phisindy(&kept).out), whole);
    // As a kill leaves it: three runs and a half.
    let journal = scratch.path("out/sweep.jsonl");
    let text = fs::read_to_string(&journal).expect("a journal");
    let half: usize = text.lines().take(4).map(|line| line.len() + 1).sum::<usize>() + 20;
    fs::write(&journal, &text[..half]).expect("written");
    assert_eq!(timeless(&phisindy(&[&kept as &[&str], &["--jobs", "2"]].concat()).out), whole);
}
