//! Results that are made again: the same bits, or what differs.
#![allow(missing_docs)]

use crate::common::{Outcome, Scratch, phisindy, top};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// A swing with friction, sampled every 10 ms and written with six digits.
fn measured(folder: &Path) {
    let swing = |t: f64| (t / std::f64::consts::PI).floor();
    let x = |t: f64| 0.3 * (-1f64).powf(swing(t)) + (1.7 - 0.6 * swing(t)) * t.cos();
    let rows: String =
        (0..800).map(|k| 0.01 * f64::from(k)).map(|t| format!("{t:.2},{:.6}\n", x(t))).collect();
    fs::write(folder.join("run.csv"), format!("t,x\n{rows}")).expect("data");
    let spec = r#"(
    states: { "x": "m", "v": "m/s" },
    constants: { "m": (1.0, "kg"), "k": (1.0, "N/m") },
    known: { "x": "v", "v": "-k*x/m" },
    unknown: { "v": (factor: "-sgn(v)/m", candidates: ["1"]) },
    contacts: ["v"],
    data: [ Csv(path: "run.csv", time: "t", columns: { "x": "x" }) ],
)
"#;
    fs::write(folder.join("rig.ron"), spec).expect("a spec");
}

fn verify(folder: &Path, more: &[&str]) -> (i32, Value) {
    let shown = folder.display().to_string();
    let Outcome { code, out, err } =
        phisindy(&[&["verify", shown.as_str(), "--quiet", "--format", "json"], more].concat());
    (code, serde_json::from_str(&out).unwrap_or_else(|_| panic!("no JSON: {out}{err}")))
}

/// Code and subject of each difference but for values.
fn differences(of: &Value) -> Vec<(String, String)> {
    let text = |d: &Value, key: &str| d[key].as_str().expect("text").to_owned();
    let all = of["differences"].as_array().expect("a list").iter().filter(|d| d["code"] != "value");
    all.map(|d| (text(d, "code"), text(d, "of"))).collect()
}

fn replaced(path: &Path, from: &str, to: &str) {
    let text = fs::read_to_string(path).expect("a file");
    assert!(text.contains(from), "{} holds {from}", path.display());
    fs::write(path, text.replacen(from, to, 1)).expect("a file");
}

#[test]
fn a_result_comes_out_again_or_is_told_what_changed() {
    let scratch = Scratch::new("verify");
    let folder = scratch.0.as_path();
    measured(folder);
    let (rig, found) = (folder.join("rig.ron"), folder.join("found"));
    for (command, set) in [("run", "data.0.window=(0.0, 7.5)"), ("gap", "constants.k=(1.0, \"N/m\")")] {
        let (spec, out) = (rig.display().to_string(), found.display().to_string());
        let done = phisindy(&[command, &spec, "--out", &out, "--set", set, "--quiet", "--force"]);
        assert!(done.code <= 1, "{}", done.err);
        for jobs in ["1", "2"] {
            let (code, of) = verify(&found, &["--jobs", jobs]);
            assert_eq!((code, &of["same"], &of["same_values"]), (0, &true.into(), &true.into()), "{of}");
        }
    }
    // Another version.
    replaced(&found.join("provenance.json"), concat!("\"", env!("CARGO_PKG_VERSION"), "\""), "\"0.0.1\"");
    let (code, of) = verify(&found, &[]);
    assert_eq!((code, differences(&of)), (1, vec![("version".into(), String::new())]));
    assert_eq!(of["same_values"], true);
    replaced(&found.join("provenance.json"), "\"0.0.1\"", concat!("\"", env!("CARGO_PKG_VERSION"), "\""));
    // A constant of the spec: the result comes from the one that is kept.
    replaced(&rig, "\"m\": (1.0,", "\"m\": (1.1,");
    let (code, of) = verify(&found, &[]);
    assert_eq!((code, differences(&of)), (1, vec![("changed".into(), "../rig.ron".into())]));
    assert!(of["differences"][0]["words"].as_str().expect("words").contains("(1.1,"), "{of}");
    assert_eq!(of["same_values"], true);
    replaced(&rig, "(1.1,", "(1.0,");
    // A byte of the data.
    replaced(&folder.join("run.csv"), "\n4.00,", "\n4.00, ");
    let (code, of) = verify(&found, &[]);
    assert_eq!((code, differences(&of)), (1, vec![("changed".into(), "../run.csv".into())]));
    assert_eq!(of["same_values"], true, "a space is no other number");
    replaced(&folder.join("run.csv"), "\n4.00, ", "\n4.00,");
    // A number of the result, and of the spec that is kept.
    replaced(&found.join("result.json"), "\"fit\": ", "\"fit\": 1");
    let (code, of) = verify(&found, &[]);
    assert_eq!((code, differences(&of)), (1, vec![("edited".into(), "result.json".into())]));
    assert_eq!(of["same_values"], false);
    replaced(&found.join("result.json"), "\"fit\": 1", "\"fit\": ");
    assert_eq!(verify(&found, &[]).0, 0);
    // Its data are elsewhere.
    fs::create_dir(folder.join("data")).expect("a folder");
    fs::rename(folder.join("run.csv"), folder.join("data/run.csv")).expect("moved");
    let (code, of) = verify(&found, &[]);
    assert_eq!((code, &differences(&of)[0]), (1, &("missing".into(), "../run.csv".into())));
    let there = folder.join("data").display().to_string();
    assert_eq!(verify(&found, &["--data", &there]).0, 0);
}

#[test]
fn ten_results_come_out_again_on_another_number_of_threads() {
    let scratch = Scratch::new("ten");
    measured(&scratch.0);
    let (rig, data) = (scratch.path("rig.ron"), scratch.0.join("run.csv"));
    let found = |k: usize| scratch.0.join(format!("found-{k}"));
    for k in 0..10 {
        let (command, jobs, other) = (["run", "gap"][k % 2], ["1", "2", "3"][k % 3], ["3", "1", "2"][k % 3]);
        let (out, set) = (found(k).display().to_string(), format!("data.0.window=(0.0, 7.{k})"));
        let done = phisindy(&[command, &rig, "--out", &out, "--set", &set, "--jobs", jobs, "--quiet"]);
        assert!(done.code <= 1, "{}", done.err);
        let (code, of) = verify(&found(k), &["--jobs", other]);
        assert_eq!((code, &of["same"]), (0, &true.into()), "{command} {k}: {of}");
    }
    // The last digit of one reading: the file is told, and what became of the numbers.
    let text = fs::read_to_string(&data).expect("data");
    let row = text.lines().find(|line| line.starts_with("4.00,")).expect("a row").to_owned();
    let (most, last) = row.split_at(row.len() - 1);
    replaced(&data, &row, &format!("{most}{}", if last == "1" { "2" } else { "1" }));
    for k in [0, 1] {
        let (code, of) = verify(&found(k), &[]);
        assert_eq!((code, differences(&of)), (1, vec![("changed".into(), "../run.csv".into())]));
        assert_eq!(of["same_values"], false, "{of}");
    }
}

/// A spec may name its data by a path below the folder of data; what it wrote finds them, with that folder moved, too.
#[test]
fn data_below_the_folder_of_data_are_found() {
    let scratch = Scratch::new("below");
    let folder = scratch.0.as_path();
    measured(folder);
    fs::create_dir_all(folder.join("data/june")).expect("a folder");
    fs::rename(folder.join("run.csv"), folder.join("data/june/run.csv")).expect("moved");
    replaced(&folder.join("rig.ron"), "run.csv", "june/run.csv");
    let [rig, data, out] = ["rig.ron", "data", "found"].map(|name| folder.join(name).display().to_string());
    assert_eq!(phisindy(&["run", &rig, "--data", &data, "--out", &out, "--quiet"]).code, 0);
    assert_eq!(verify(&folder.join("found"), &[]).0, 0);
    for (command, spec) in [("run", "spec.ron"), ("simulate", "identified.ron")] {
        let done = phisindy(&[command, &format!("{out}/{spec}"), "--quiet"]);
        assert_eq!(done.code, 0, "{spec}: {}", done.err);
    }
    fs::rename(folder.join("data"), folder.join("moved")).expect("moved");
    let (code, of) = verify(&folder.join("found"), &[]);
    assert_eq!((code, &differences(&of)[0]), (1, &("missing".into(), "../data/june/run.csv".into())));
    assert_eq!(verify(&folder.join("found"), &["--data", &folder.join("moved").display().to_string()]).0, 0);
}

/// The kept spec finds its data by itself, and the report has the hash.
#[test]
fn a_result_keeps_its_spec() {
    let scratch = Scratch::new("kept-spec");
    let folder = scratch.0.as_path();
    measured(folder);
    let (spec, out) =
        (folder.join("rig.ron").display().to_string(), folder.join("found").display().to_string());
    assert_eq!(phisindy(&["run", &spec, "--out", &out, "--quiet"]).code, 0);
    let again = phisindy(&["run", &format!("{out}/spec.ron"), "--quiet"]);
    assert_eq!(again.code, 0, "{}", again.err);
    let page = fs::read_to_string(folder.join("found/report.html")).expect("a report");
    let after = page.split_once("SHA-256 of spec, data, laws and version").expect("the hash").1;
    let of_digits = |word: &str| word.len() == 64 && word.bytes().all(|b| b.is_ascii_hexdigit());
    assert!(after.split(['<', '>']).take(30).any(of_digits), "{}", &after[..500]);
}

#[test]
fn a_folder_without_a_result_cannot_be_verified() {
    let shown = top().join("specs").display().to_string();
    let Outcome { code, out, err } = phisindy(&["verify", &shown]);
    assert_eq!((code, out.as_str()), (2, ""));
    assert!(err.contains("--out DIR"), "{err}");
}

#[test]
fn a_result_that_is_damaged_is_not_called_stopped() {
    let scratch = Scratch::new("damaged");
    let folder = scratch.0.as_path();
    measured(folder);
    let (spec, out) = (scratch.path("rig.ron"), scratch.path("found"));
    assert_eq!(phisindy(&["run", &spec, "--out", &out, "--quiet"]).code, 0);
    fs::write(folder.join("found/result.json"), "{}").expect("a file");
    let (code, of) = verify(&folder.join("found"), &[]);
    assert_eq!((code, differences(&of)), (1, vec![("edited".into(), "result.json".into())]));
    fs::write(folder.join("found/result.json"), "{ \"verdict\": ").expect("a file");
    let Outcome { code, out, err } = phisindy(&["verify", &out]);
    assert_eq!((code, out.as_str()), (2, ""));
    assert!(err.contains("result.json` is damaged"), "{err}");
}

/// Of a comparison, a check and a design that has no run yet a part is worth nothing.
#[test]
fn work_that_keeps_nothing_does_not_say_that_it_does() {
    let scratch = Scratch::new("keeps-nothing");
    measured(&scratch.0);
    let (spec, out) = (scratch.path("rig.ron"), scratch.path("found"));
    assert!(phisindy(&["gap", &spec, "--out", &out, "--quiet"]).code <= 1);
    for command in [&["verify", &out][..], &["compare", &spec, &spec], &["next", &spec]] {
        let Outcome { code, out, err } = phisindy(&[command, &["--limit", "0.001s"]].concat());
        assert_eq!((code, out.as_str()), (3, ""), "{command:?}: {err}");
        assert!(err.contains("nothing of it is kept"), "{command:?}: {err}");
    }
}
