//! What comes into the program and leaves it: windows that overlap, sensors of synthetic records, units,
//! folders with results of another command, names that hold ends of lines, exit codes of what is no result.

#![allow(missing_docs)]

use crate::common::{Outcome, Scratch, phisindy};

/// A damped oscillator of 1 kg that rubs; `more` are fields of its record.
fn oscillator(more: &str) -> String {
    format!(
        "(title: \"One\\nand two\",\n\
         constants: {{ \"m\": (1.0, \"kg\"), \"k\": (4.0, \"N/m\"), \"c\": (0.1, \"N*s/m\"), \"F\": (1.0, \"N\"), \"W\": (1.0, \"rad/s\") }},\n\
         states: {{ \"x\": \"m\", \"v\": \"m/s\" }}, known: {{ \"x\": \"v\", \"v\": \"(-k*x - c*v + F*cos(W*t))/m\" }}, inertia: {{ \"v\": \"m\" }},\n\
         unknown: {{ \"v\": (factor: \"-sgn(v)/m\", candidates: [\"1\"]) }}, contacts: [\"v\"],\n\
         data: [Synthetic(truth: {{ \"v\": \"-0.2*sgn(v)\" }}, start: {{ \"x\": 0.3, \"v\": 0.0 }}, duration: 30.0, step: 0.02, noise: Additive(0.005), seed: 1{more})])"
    )
}

/// The same with records of a file, `data.csv`, which is written beside it.
fn measured(scratch: &Scratch, records: &str) -> String {
    let made = scratch.path("made.ron");
    std::fs::write(&made, oscillator("")).expect("a file");
    let csv = phisindy(&["simulate", &made]).out;
    std::fs::write(scratch.path("data.csv"), csv).expect("a file");
    let spec = oscillator("");
    let (head, _) = spec.split_once("data: [").expect("data");
    let path = scratch.path("case.ron");
    std::fs::write(&path, format!("{head}data: [{records}])")).expect("a file");
    path
}

/// A record of `data.csv`.
fn record(more: &str) -> String {
    format!("Csv(path: \"data.csv\", time: \"t\", columns: {{ \"x\": \"x\" }}, {more})")
}

/// The numbers of a column.
fn column(out: &Outcome, name: &str) -> Vec<f64> {
    let mut lines = out.out.lines();
    let at = lines.next().expect("a heading").split(',').position(|h| h == name).expect("the column");
    lines.map(|l| l.split(',').nth(at).expect("a field").parse().expect("a number")).collect()
}

#[test]
fn validation_on_fitted_samples_is_told() {
    let scratch = Scratch::new("overlap");
    let apart = [record("window: (0.0, 15.0)"), record("window: (15.0, 30.0), role: Validate")].join(", ");
    let shared = [
        record("name: \"early\", window: (0.0, 20.0)"),
        record("name: \"late\", window: (15.0, 30.0), role: Validate"),
    ]
    .join(", ");
    for (records, told) in [(apart, false), (shared, true)] {
        let spec = measured(&scratch, &records);
        for command in ["check", "run", "gap"] {
            let err = phisindy(&[command, &spec]).err;
            assert_eq!(err.contains("no independent check"), told, "{command}: {err}");
            assert!(
                !told
                    || err.contains("`late`") && err.contains("`early`") && err.contains("from 15 s to 20 s"),
                "{err}"
            );
        }
    }
}

#[test]
fn known_sensors_of_synthetic_records_are_applied() {
    let scratch = Scratch::new("sensors");
    let path = scratch.path("case.ron");
    let quiet = ["--set", "data.0.noise=Relative(0.0)"];
    let simulated = |more: &str| {
        std::fs::write(&path, oscillator(more)).expect("a file");
        phisindy(&[&["simulate", &path], &quiet[..]].concat())
    };
    let out = simulated(
        ", sensors: { \"x\": (gain: 2.0, offset: 0.01, delay: 0.04), \"v\": (offset: Find(start: 0.5, unit: \"m/s\", within: (0.0, 1.0))) }",
    );
    let (x, exact) = (column(&out, "x"), column(&out, "x_true"));
    // Two samples late.
    let worst = (2..x.len()).map(|k| (x[k] - (2.0 * exact[k - 2] + 0.01)).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-12, "{worst}");
    // What is to be found is taken for perfect.
    assert_eq!(column(&out, "v"), column(&out, "v_true"));
    // And the fit takes the known ones for what they are.
    std::fs::write(&path, oscillator(", sensors: { \"x\": (gain: 2.0, offset: 0.01) }")).expect("a file");
    let result: serde_json::Value =
        serde_json::from_str(&phisindy(&["run", &path, "--format", "json"]).out).expect("JSON");
    let force = result["equations"][0]["terms"][0]["coefficient"].as_f64().expect("a number");
    assert!((force - 0.2).abs() < 0.002, "{force}");
}

#[test]
fn a_length_in_mm_is_the_same_number_as_in_m() {
    let scratch = Scratch::new("mm");
    let path = scratch.path("case.ron");
    // 4.1 * 0.001 is not 0.0041.
    let simulated = |force: &str| {
        let spec = oscillator("").replace("\"F\": (1.0, \"N\")", &format!("\"F\": {force}"));
        std::fs::write(&path, spec).expect("a file");
        phisindy(&["simulate", &path]).out
    };
    assert_eq!(simulated("(4.1, \"mN\")"), simulated("(0.0041, \"N\")"));
    assert_ne!(4.1 * 1e-3, 0.0041);
}

#[test]
fn what_makes_a_record_unfit_is_a_mistake_of_the_input() {
    let scratch = Scratch::new("unfit");
    for (records, command, why, help) in [
        (record("role: Validate"), "run", "no record has the role Fit", "take `role: Validate` off"),
        (record("role: Validate"), "gap", "no record has the role Fit", "take `role: Validate` off"),
        (record("role: Validate"), "check", "no record has the role Fit", "take `role: Validate` off"),
        (record("window: (0.0, 0.3)"), "run", "too few", "longer window"),
        (record("window: (0.0, 1.0)"), "gap", "64 at least", "longer window"),
    ] {
        let out = phisindy(&[command, &measured(&scratch, &records)]);
        assert_eq!(out.code, 2, "{command}: {}", out.err);
        assert!(out.err.contains(why) && out.err.contains(help), "{}", out.err);
    }
    let spec = measured(&scratch, &record(""));
    let dead: String = (0..500).map(|k| format!("{},0.1\n", 0.02 * f64::from(k))).collect();
    std::fs::write(scratch.path("data.csv"), format!("t,x\n{dead}")).expect("a file");
    for command in ["run", "gap"] {
        let out = phisindy(&[command, &spec]);
        assert_eq!(out.code, 2, "{command}: {}", out.err);
        assert!(
            out.err.contains("constant: nothing moved") && out.err.contains("leave the column out"),
            "{}",
            out.err
        );
    }
}

#[test]
fn results_of_two_commands_do_not_mix() {
    let scratch = Scratch::new("mixed");
    let sensor = "sensors: { \"x\": (offset: Find(start: 0.05, unit: \"m\", within: (-0.1, 0.1))) }";
    let spec = measured(&scratch, &record(sensor));
    let (run, gap) = (scratch.path("run"), scratch.path("gap"));
    assert_eq!(phisindy(&["run", &spec, "--out", &run]).code, 0);
    assert_eq!(phisindy(&["gap", &spec, "--out", &gap]).code, 0);
    // Each may stand in the place of the other, whose result is kept beside.
    for (command, out, own, other) in
        [("run", &gap, "identified.ron", "completed.ron"), ("gap", &run, "completed.ron", "identified.ron")]
    {
        let said = phisindy(&[command, &spec, "--out", out]);
        let there = |folder: &str, name: &str| std::fs::exists(format!("{folder}/{name}")).expect("a folder");
        let earlier = format!("{out}.1");
        assert!(said.code == 0 && said.err.contains(&format!("kept in `{earlier}`")), "{}", said.err);
        assert!(there(out, own) && !there(out, other) && there(&earlier, other), "{command}");
    }
    let (run, gap) = (gap, run);
    // Where the search for the sensor's zero goes on: at the zero, which it has.
    let completed = std::fs::read_to_string(format!("{gap}/completed.ron")).expect("a spec");
    let zero =
        completed.split("offset: Find(start: ").nth(1).and_then(|s| s.split(',').next()?.parse::<f64>().ok());
    assert!(zero.is_some_and(|zero| zero.abs() < 0.005), "{completed}");
    // The model's start is in what `gap` leaves, and with it in what is exported.
    let model = scratch.path("model.json");
    assert_eq!(phisindy(&["export", &gap, "--to", "json", "--out", &model]).code, 0);
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(&model).expect("a file")).expect("JSON");
    let start = json["records"][0]["start"].clone();
    assert!(start.to_string().contains("0.") && !start.to_string().contains("null"), "{start}");
    let refused = phisindy(&["export", &run, "--to", "json", "--out", &model]);
    assert!(refused.code == 2 && refused.err.contains("--force"), "{}", refused.err);
    assert_eq!(phisindy(&["export", &run, "--to", "json", "--out", &model, "--force"]).code, 0);
}

#[test]
fn one_record_of_several_is_simulated() {
    let scratch = Scratch::new("one_record");
    let path = scratch.path("case.ron");
    let spec = oscillator("");
    let (head, one) = spec.split_once("data: [").expect("data");
    let one = one.trim_end_matches("])");
    let two = one.replace("seed: 1", "seed: 2, name: \"second\"");
    std::fs::write(&path, format!("{head}data: [{one}, {two}])")).expect("a file");
    let both = phisindy(&["simulate", &path]).out;
    let (named, placed) = (
        phisindy(&["simulate", &path, "--record", "second"]),
        phisindy(&["simulate", &path, "--record", "1"]),
    );
    assert_eq!(named.out, placed.out);
    assert!(named.out.starts_with("t,x,v,"), "{}", &named.out[..40]);
    let tail: Vec<&str> = both.lines().filter_map(|l| l.strip_prefix("second,")).collect();
    assert_eq!(named.out.lines().skip(1).collect::<Vec<_>>(), tail);
    let wrong = phisindy(&["simulate", &path, "--record", "third"]);
    assert!(wrong.code == 2 && wrong.err.contains("1 `second`"), "{}", wrong.err);
}

#[test]
fn ends_of_lines_in_titles_and_names_do_no_harm() {
    let scratch = Scratch::new("lines");
    let spec = measured(&scratch, &record("name: \"run\\n1\""));
    let folder = scratch.path("out");
    let out = phisindy(&["run", &spec, "--quiet", "--out", &folder]);
    let comments = out.out.lines().skip(1);
    assert!(comments.clone().count() > 5 && comments.clone().all(|l| l.starts_with('%')), "{}", out.out);
    assert!(out.out.contains("One and two"), "{}", out.out);
    let c = phisindy(&["export", &folder, "--to", "c"]).out;
    assert!(c.contains("RECORD[] = \"run\\n1\""), "{c}");
    let python = phisindy(&["export", &folder, "--to", "python"]).out;
    assert!(python.contains("RECORD = \"run\\n1\""), "{python}");
}

#[test]
fn numbers_that_only_count_together_are_told() {
    let scratch = Scratch::new("together");
    let path = scratch.path("case.ron");
    // Free motion: a larger sensor gain and a smaller friction are the same displacement.
    let spec =
        oscillator(", measure: [\"x\"], sensors: { \"x\": (gain: Find(start: 1.0, within: (0.0, 100.0))) }")
            .replace("\"F\": (1.0, \"N\")", "\"F\": (0.0, \"N\")")
            .replace("\"x\": 0.3", "\"x\": 1.3");
    std::fs::write(&path, spec).expect("a file");
    let err = phisindy(&["run", &path]).err;
    assert!(err.contains("the data do not tell 1 in v', x.gain apart"), "{err}");
    assert!(!err.contains("could be zero"), "{err}");
}
