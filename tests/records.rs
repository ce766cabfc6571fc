//! Records as rigs give them: decimated, detrended, long, and with different columns.
#![allow(missing_docs)]

#[allow(dead_code)]
mod common;

use common::{Outcome, Scratch, phisindy};
use serde_json::Value;
use std::fmt::Write;

/// x = A cos(3 t) of an undamped oscillator x'' = -9 x, with a velocity beside it, and a zero and drift of the sensor.
fn swing(step: f64, rows: usize, zero: f64, drift: f64) -> String {
    (0..rows).fold("t,x,v\n".to_owned(), |mut all, k| {
        let t = k as f64 * step;
        let scatter = 2e-4 * (((k * 7919) % 101) as f64 / 50.0 - 1.0);
        let _ = writeln!(
            all,
            "{t:.5},{:.7},{:.7}",
            0.1 * (3.0 * t).cos() + zero + drift * t + scatter,
            -0.3 * (3.0 * t).sin() + scatter
        );
        all
    })
}

/// A spec with an unknown stiffness and these records.
fn spec(records: &str) -> String {
    format!(
        "(constants: {{ \"k\": (value: 7.0, unit: \"1/s^2\", within: (4.0, 20.0)) }}, states: {{ \"x\": \"m\", \"v\": \"m/s\" }},\n\
         known: {{ \"x\": \"v\", \"v\": \"-k*x\" }}, data: [{records}])"
    )
}

#[track_caller]
fn run(name: &str, files: &[(&str, String)], records: &str) -> (Outcome, Value) {
    let scratch = Scratch::new(name);
    for (file, content) in files {
        std::fs::write(scratch.path(file), content).expect("a file");
    }
    let path = scratch.path("case.ron");
    std::fs::write(&path, spec(records)).expect("a file");
    let said = phisindy(&["run", &path, "--format", "json"]);
    let result = serde_json::from_str(&said.out).unwrap_or(Value::Null);
    (said, result)
}

#[track_caller]
fn stiffness(said: &Outcome, result: &Value) -> f64 {
    let found = result["parameters"].as_array().and_then(|all| all.iter().find(|p| p["name"] == "k"));
    found.and_then(|k| k["value"].as_f64()).unwrap_or_else(|| panic!("{}", said.err))
}

#[test]
fn decimation_takes_means_and_says_so() {
    let columns = "time: \"t\", columns: { \"x\": (\"x\", \"m\") }";
    let files = [("a.csv", swing(0.001, 8000, 0.0, 0.0))];
    let (said, result) = run("decimate", &files, &format!("Csv(path: \"a.csv\", {columns}, decimate: 10)"));
    assert!((stiffness(&said, &result) - 9.0).abs() < 0.01, "{}", said.out);
    assert_eq!(result["records"][0]["samples"], 800);
    // Means of ten rows scatter less than the 1.2e-4 of single ones.
    let noise = result["records"][0]["noise"]["x"].as_f64().expect("a number");
    assert!(noise < 9e-5, "{noise}");
    assert!(said.err.contains("mean of 10 rows of `a.csv` (decimate)"), "{}", said.err);
}

#[test]
fn a_trend_is_taken_off_and_its_windows_share_it() {
    let columns = "time: \"t\", columns: { \"x\": (\"x\", \"m\") }, detrend: { \"x\": Linear }";
    // Two whole periods in each window, so that the line is not that of the swing.
    let files = [("a.csv", swing(0.01, 850, 0.5, 0.02))];
    let both = format!(
        "Csv(path: \"a.csv\", {columns}, window: (0.0, 4.19)), Csv(path: \"a.csv\", {columns}, window: (4.19, 8.38), role: Validate)"
    );
    let (said, result) = run("detrend", &files, &both);
    assert!((stiffness(&said, &result) - 9.0).abs() < 0.05, "{}", said.out);
    assert!(said.err.contains("`x` without its trend: the line"), "{}", said.err);
    assert!(said.err.contains("as in the first record of this file"), "{}", said.err);
    let nrmse = result["records"][1]["nrmse"]["x"].as_f64().expect("a number");
    assert!(nrmse < 0.05, "{nrmse}");
}

#[test]
fn a_trend_needs_a_column_and_a_known_kind() {
    let files = [("a.csv", swing(0.01, 100, 0.0, 0.0))];
    for (field, parts) in [
        (
            "detrend: { \"v\": Mean }",
            &["`v` has no column here", "`columns` of this record holds: x"] as &[&str],
        ),
        ("detrend: { \"x\": Parabola }", &["Parabola", "Mean, Linear"]),
        ("detrend: Mean", &["expected a map"]),
        ("decimate: 0", &["from 1"]),
        ("decimate: 50", &["only 2 samples are left", "`decimate`"]),
    ] {
        let (said, _) = run(
            "trend-wrong",
            &files,
            &format!("Csv(path: \"a.csv\", time: \"t\", columns: {{ \"x\": \"x\" }}, {field})"),
        );
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{field}: {}", said.err);
        parts.iter().for_each(|part| assert!(said.err.contains(part), "{field}: {}", said.err));
    }
}

#[test]
fn a_column_may_be_missing_in_some_records() {
    let files = [("a.csv", swing(0.01, 500, 0.0, 0.0)), ("b.csv", swing(0.02, 300, 0.0, 0.0))];
    let records = "Csv(path: \"a.csv\", time: \"t\", columns: { \"x\": \"x\", \"v\": \"v\" }), Csv(path: \"b.csv\", time: \"t\", columns: { \"x\": \"x\" })";
    let (said, result) = run("missing", &files, records);
    assert!((stiffness(&said, &result) - 9.0).abs() < 0.01, "{} {}", said.out, said.err);
    let noise = |r: usize| result["records"][r]["noise"].as_object().expect("an object").len();
    assert_eq!((noise(0), noise(1)), (2, 1), "{}", said.out);
    // The velocity alone, in the other record.
    let records = "Csv(path: \"a.csv\", time: \"t\", columns: { \"v\": \"v\" }), Csv(path: \"b.csv\", time: \"t\", columns: { \"x\": \"x\" })";
    let (said, result) = run("crossed", &files, records);
    assert!((stiffness(&said, &result) - 9.0).abs() < 0.02, "{} {}", said.out, said.err);
}

#[test]
fn too_many_samples_are_refused_with_the_way_out() {
    let mut file = String::from("t,x\n");
    for k in 0..2_000_050 {
        let _ = writeln!(file, "{k},{}", k % 7);
    }
    let scratch = Scratch::new("huge");
    std::fs::write(scratch.path("huge.csv"), file).expect("a file");
    let path = scratch.path("case.ron");
    let check = |more: &str| {
        let record = format!(
            "Csv(path: \"huge.csv\", time: (\"t\", \"ms\"), columns: {{ \"x\": (\"x\", \"mm\") }}{more})"
        );
        std::fs::write(&path, spec(&record)).expect("a file");
        phisindy(&["check", &path])
    };
    let said = check("");
    assert_eq!(said.code, 2, "{}", said.err);
    for part in ["more than 2 000 000 samples", "decimate: 10", "window: (0.0,"] {
        assert!(said.err.contains(part), "expected {part:?} in {}", said.err);
    }
    assert_eq!(check(", decimate: 100").code, 0);
    assert_eq!(check(", window: (10.0, 5000.0)").code, 0);
}

/// What is odd about a record is told, and nothing is told about a good one.
#[test]
fn odd_records_are_told_of() {
    let columns = "time: \"t\", columns: { \"x\": (\"x\", \"m\"), \"v\": (\"v\", \"m/s\") }";
    let odd = |name: &str, content: String, unit: &str| {
        let columns = columns.replace("(\"x\", \"m\")", unit);
        run(name, &[("a.csv", content)], &format!("Csv(path: \"a.csv\", {columns})")).0.err
    };
    let good = swing(0.01, 2000, 0.0, 0.0);
    let said = odd("good", good.clone(), "(\"x\", \"m\")");
    assert!(
        !said.contains("swapped") && !said.contains("unit of one") && !said.contains("no samples"),
        "{said}"
    );
    assert!(
        odd("thousand", good.clone(), "(\"x\", \"mm\")").contains("at 1/1000 of the rate that `v` gives")
    );
    let swapped = good.replace("t,x,v", "t,v,x");
    assert!(odd("swapped", swapped, "(\"x\", \"m\")").contains("probably swapped"));
    let hole: String = good
        .lines()
        .enumerate()
        .filter(|(k, _)| !(700..900).contains(k))
        .fold(String::new(), |all, (_, l)| all + l + "\n");
    assert!(odd("hole", hole, "(\"x\", \"m\")").contains("no samples from"));
}
