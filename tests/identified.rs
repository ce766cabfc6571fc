//! `identified.ron`: what `run --out` writes is a spec that `simulate` predicts with.

#![allow(missing_docs)]

use crate::common::{Scratch, phisindy, top};
use serde_json::Value;
use std::fs;

/// Rows of numbers under their headings; words become NaN.
fn read(csv: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut lines = csv.lines();
    let head = lines.next().expect("a heading").split(',').map(str::to_owned).collect();
    (head, lines.map(|l| l.split(',').map(|x| x.parse().unwrap_or(f64::NAN)).collect()).collect())
}

fn column(csv: &str, name: &str) -> Vec<f64> {
    let (head, rows) = read(csv);
    let at = head.iter().position(|h| h == name).unwrap_or_else(|| panic!("no column {name} in {head:?}"));
    rows.iter().map(|r| r[at]).collect()
}

/// Root mean square difference over the standard deviation of the first.
fn nrmse(data: &[f64], model: &[f64]) -> f64 {
    let n = data.len() as f64;
    let mean = data.iter().sum::<f64>() / n;
    let spread = data.iter().map(|y| (y - mean).powi(2)).sum::<f64>();
    (data.iter().zip(model).map(|(y, p)| (y - p).powi(2)).sum::<f64>() / spread).sqrt()
}

#[test]
fn a_synthetic_case_is_spliced_and_its_comments_survive() {
    let scratch = Scratch::new("spliced");
    let folder = scratch.path("");
    let said = phisindy(&["run", "specs/case1b.ron", "--set", "data.0.duration=20.0", "--out", &folder]);
    assert_eq!(said.code, 0, "{}", said.err);
    let path = scratch.path("identified.ron");
    let text = fs::read_to_string(&path).expect("identified.ron");
    let original = fs::read_to_string(top().join("specs/case1b.ron")).expect("the spec");
    for comment in original.lines().filter(|l| l.trim_start().starts_with("//")) {
        assert!(text.contains(comment), "{comment}\n{text}");
    }
    assert!(text.contains("(-d*y - k*x + F0*cos(W*t))/m - sgn(y)*(c_y_1 + c_y_2*ln((|y|+eps)/V)"), "{text}");
    assert!(
        text.contains("\"c_y_1\": (0.") && text.contains("unknown: {}") && text.contains("truth: {}"),
        "{text}"
    );
    let checked = phisindy(&["check", &path]);
    assert_eq!((checked.code, checked.err), (0, format!("{path}: no mistakes\n")));
    // The identified model is the truth to a few parts in ten thousand, and so is its motion; any other
    // excitation is a --set away.
    for change in [[].as_slice(), &["--set", "constants.W=0.5"]] {
        let model = phisindy(&[["simulate", path.as_str()].as_slice(), change].concat());
        let truth = ["simulate", "specs/case1b.ron", "--set", "data.0.duration=20.0"];
        let truth = phisindy(&[truth.as_slice(), change].concat());
        assert_eq!((model.code, truth.code), (0, 0), "{}{}", model.err, truth.err);
        for name in ["x_true", "y_true"] {
            let miss = nrmse(&column(&truth.out, name), &column(&model.out, name));
            assert!(miss < 0.01, "{name}: {miss}");
        }
    }
}

#[test]
fn a_measured_case_predicts_its_records_as_run_did() {
    let scratch = Scratch::new("measured");
    // Two windows of one file, with an offset to find and a stiffness that may move.
    let data = phisindy(&["simulate", "specs/case1a.ron", "--set", "data.0.noise=Additive(0.01)"]);
    fs::write(scratch.path("made.csv"), &data.out).expect("written");
    let record = |name: &str, window: &str, role: &str| {
        format!(
            "Csv(path: \"made.csv\", name: \"{name}\", time: \"t\", columns: {{\"x\": \"x\"}}, window: {window}, role: {role}, \
             sensors: {{ \"x\": (offset: Find(start: 0.0, unit: \"m\", within: (-0.1, 0.1))) }})"
        )
    };
    let records = format!(
        "data=[{}, {}]",
        record("a", "(0.0, 25.0)", "Fit"),
        record("b", "(25.005, 50.0)", "Validate")
    );
    let folder = scratch.path("");
    let said = phisindy(&[
        "run",
        "specs/case1a.ron",
        "--data",
        &folder,
        "--out",
        &scratch.path("out"),
        "--format",
        "json",
        "--set",
        &records,
        "--set",
        "constants.k=(value: 1.1, unit: \"N/m\", within: (0.5, 2.0))",
    ]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let result: Value = serde_json::from_str(&said.out).expect("JSON");
    let text = fs::read_to_string(scratch.path("out/identified.ron")).expect("identified.ron");
    let k = result["parameters"][0]["value"].as_f64().expect("k");
    assert!((k - 1.0).abs() < 0.02, "{k}");
    assert!(text.contains(&format!("\"k\": (value: {k:?}, unit: \"N/m\", within: (0.5, 2.0))")), "{text}");
    assert!(!text.contains("Find"), "what was found of a sensor is held:\n{text}");
    let path = scratch.path("out/identified.ron");
    let run = phisindy(&["simulate", &path, "--data", &folder]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_eq!(run.out.lines().next(), Some("record,t,x,x_model,y_model"));
    let (x, model) = (column(&run.out, "x"), column(&run.out, "x_model"));
    let rows: Vec<bool> = run.out.lines().skip(1).map(|l| l.starts_with("a,")).collect();
    for (k, first) in [(0, true), (1, false)] {
        let from = result["records"][k]["adapted"]["samples"].as_u64().unwrap_or(0) as usize;
        let pick = |v: &[f64]| {
            let own = v.iter().zip(&rows).filter(|(_, a)| **a == first).map(|(v, _)| *v);
            own.skip(from).collect::<Vec<f64>>()
        };
        let (miss, said) =
            (nrmse(&pick(&x), &pick(&model)), result["records"][k]["nrmse"]["x"].as_f64().expect("it"));
        assert!((miss - said).abs() < 1e-6 * said, "{miss} {said}");
    }
}

/// A Validate record fits its own phase, zero and lateness: what, on which part and with which values is
/// said, only the rest is scored, and `simulate` of the result repeats the figure.
#[test]
fn what_a_validate_record_adapts_is_told_kept_and_not_scored() {
    let scratch = Scratch::new("adapted");
    let folder = scratch.path("");
    let known = "known: { \"x\": \"v\", \"v\": \"-4*x - 0.1*v + 2.0*cos(1.3*t + phi)\" }";
    for (name, phi) in [("a", 0.7), ("b", 2.0)] {
        let made = format!(
            "(constants: {{ \"phi\": {phi:?} }}, states: {{ \"x\": \"m\", \"v\": \"m/s\" }}, {known}, unknown: {{}}, contacts: [\"v\"],
            data: [ Synthetic(truth: {{ \"v\": \"-0.3*sgn(v)\" }}, start: {{ \"x\": 1.0, \"v\": 0.0 }}, duration: 30.0, step: 0.02,
                noise: Additive(0.02), measure: [\"x\"], seed: 1) ])"
        );
        fs::write(scratch.path("made.ron"), made).expect("written");
        let data = phisindy(&["simulate", &scratch.path("made.ron")]);
        fs::write(scratch.path(&format!("{name}.csv")), &data.out).expect("written");
    }
    let record = |name: &str, role: &str| {
        format!(
            "Csv(path: \"{name}.csv\", name: \"{name}\", time: \"t\", columns: {{\"x\": \"x\"}}, role: {role}, \
             sensors: {{ \"x\": (offset: Find(start: 0.0, unit: \"m\", within: (-0.1, 0.1)), delay: 0.03) }})"
        )
    };
    let spec = format!(
        "(constants: {{ \"phi\": Find(start: 0.1, unit: \"rad\", within: (-4.0, 4.0), each: true) }}, states: {{ \"x\": \"m\", \"v\": \"m/s\" }},
        {known}, unknown: {{ \"v\": (factor: \"-sgn(v)\", candidates: [\"1\"]) }}, contacts: [\"v\"], data: [{}, {}])",
        record("a", "Fit"),
        record("b", "Validate")
    );
    let path = scratch.path("case.ron");
    fs::write(&path, spec).expect("written");
    let said =
        phisindy(&["run", &path, "--data", &folder, "--out", &scratch.path("out"), "--format", "text"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(!said.out.contains("not fitted"), "{}", said.out);
    assert!(said.out.contains("b: adapted on its first 14.98 s: phi = 2.0"), "{}", said.out);
    // Its own phase is also what its coefficients are compared with.
    assert!(!said.out.contains("by b alone"), "{}", said.out);
    let result = fs::read_to_string(scratch.path("out/result.json")).expect("result.json");
    let result: Value = serde_json::from_str(&result).expect("JSON");
    let b = &result["records"][1];
    assert_eq!(b["adapted"]["samples"], 750);
    assert_eq!(b["scored"]["from"], 15.0);
    let own: Vec<&str> = b["adapted"]["parameters"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|p| p["name"].as_str())
        .collect();
    assert_eq!(own, ["phi", "x.offset"]);
    assert!(result["records"][0]["adapted"].is_null());
    let run =
        phisindy(&["simulate", &scratch.path("out/identified.ron"), "--data", &folder, "--record", "b"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let (x, model) = (column(&run.out, "x"), column(&run.out, "x_model"));
    let miss = nrmse(&x[750..], &model[750..]);
    let told = b["nrmse"]["x"].as_f64().expect("it");
    assert!((miss - told).abs() < 1e-6 * told && told < 0.03, "{miss} {told}");
    let html = fs::read_to_string(scratch.path("out/report.html")).expect("report.html");
    assert!(html.contains("What Validate records were given of their own"));
}

#[test]
fn a_model_with_an_unknown_part_is_not_simulated_along_measured_records() {
    let said = phisindy(&["simulate", "specs/frame_250g.ron"]);
    assert_eq!((said.code, said.out.as_str()), (2, ""));
    assert!(said.err.contains("identify it first"), "{}", said.err);
}

#[test]
fn a_rejected_model_says_so_in_its_file() {
    let scratch = Scratch::new("rejected");
    let said = phisindy(&[
        "run",
        "specs/case1a.ron",
        "--set",
        "data.0.duration=20.0",
        "--set",
        "data.0.truth={ \"y\": \"2*sin(2*t)\" }",
        "--out",
        &scratch.path(""),
    ]);
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    let text = fs::read_to_string(scratch.path("identified.ron")).expect("identified.ron");
    assert!(text.lines().next().expect("a line").contains("REJECTED"), "{text}");
}
