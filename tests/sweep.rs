//! `phisindy sweep` from outside.

#![allow(missing_docs)]

use crate::common::{self, Scratch, phisindy, program};
use serde_json::Value;
use std::fs;

/// Case 1a over 20 s: a tenth of a second for a run.
const QUICK: &[&str] = &["sweep", "specs/case1a.ron", "--seeds", "3", "--set", "data.0.duration=20.0"];

#[track_caller]
fn sweep(more: &[&str]) -> common::Outcome {
    let said = phisindy(&[QUICK, more].concat());
    assert!(!said.err.contains("panicked"), "{}", said.err);
    said
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect(text)
}

/// Without what may differ between two runs of the same thing.
fn timeless(text: &str) -> Value {
    let mut value = json(text);
    value["seconds"] = Value::Null;
    value
}

#[test]
fn one_cell_has_the_keys_of_the_contract() {
    let said = sweep(&["--format", "json"]);
    assert_eq!((said.code, said.err.as_str(), said.out.lines().count()), (0, "", 1));
    let result = json(&said.out);
    assert_eq!((&result["runs"], &result["exact_support"]), (&3.into(), &3.into()), "{}", said.out);
    assert!(result["seconds"].as_f64().expect("a number") > 0.0);
    let coefficient = &result["coefficients"]["y:1"];
    let number = |key: &str| coefficient[key].as_f64().expect(key);
    assert!((number("median") - 0.5).abs() < 0.0025, "{coefficient}");
    // Three runs: the error is some small multiple of the least possible one.
    assert!(number("rmse") > 0.0 && number("rmse") < 5.0 * number("bound"), "{coefficient}");
    assert!((0.0..=1.0).contains(&number("coverage95")));
    assert_eq!(result["seed"], 42);
}

#[test]
fn the_table_is_comment_in_latex_and_the_seconds_stand_elsewhere() {
    let said = sweep(&[]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.lines().all(|l| l.starts_with('%')), "{}", said.out);
    assert!(said.out.contains("exactly the true terms in 3 of 3 runs"), "{}", said.out);
    assert!(said.err.starts_with("3 runs in "), "{}", said.err);
    let text = sweep(&["--format", "text", "--quiet"]);
    assert_eq!(said.out.replace("% ", "").replace('%', ""), text.out.replace("% ", "").replace('%', ""));
    assert_eq!(text.err, "");
}

#[test]
fn the_number_of_jobs_changes_no_bit() {
    let scratch = Scratch::new("jobs");
    let runs = ["1", "2"].map(|jobs| {
        let folder = scratch.path(jobs);
        let said = sweep(&["--jobs", jobs, "--out", &folder, "--format", "json"]);
        assert_eq!(said.code, 0, "{}", said.err);
        let journal = fs::read_to_string(format!("{folder}/sweep.jsonl")).expect("a journal");
        let mut lines: Vec<String> = journal.lines().skip(1).map(|l| timeless(l).to_string()).collect();
        lines.sort();
        (timeless(&said.out), lines)
    });
    assert_eq!(runs[0], runs[1]);
    assert_eq!(runs[0].1.len(), 3);
}

#[test]
fn one_seed_of_a_sweep_is_a_run_with_that_seed() {
    let scratch = Scratch::new("one");
    let folder = scratch.path("");
    assert_eq!(sweep(&["--seed", "7", "--out", &folder]).code, 0);
    let journal = fs::read_to_string(scratch.path("sweep.jsonl")).expect("a journal");
    let of_8 = journal.lines().find(|l| l.contains("\"seed\":8")).expect("seed 8");
    let run = phisindy(&[
        "run",
        "specs/case1a.ron",
        "--set",
        "data.0.duration=20.0",
        "--seed",
        "8",
        "--format",
        "json",
    ]);
    assert_eq!(json(&run.out)["equations"][0]["terms"][0]["coefficient"], json(of_8)["found"][0]["value"]);
}

#[test]
fn a_sweep_goes_on_after_a_kill() {
    let scratch = Scratch::new("resume");
    let folder = scratch.path("");
    let whole = sweep(&["--out", &folder]);
    assert_eq!(whole.code, 0, "{}", whole.err);
    let (journal, result) = (scratch.path("sweep.jsonl"), scratch.path("sweep.json"));
    let (before, table) =
        (fs::read_to_string(&journal).expect("it"), fs::read_to_string(&result).expect("it"));
    assert_eq!(fs::read_dir(&folder).expect("a folder").count(), 2, "nothing else is left");
    // Killed in the middle of a line; then in the middle of the first one.
    for (keep, missing) in [(before.len() - 40, 1), (before.find('\n').expect("lines") - 3, 3), (0, 3)] {
        fs::write(&journal, &before.as_bytes()[..keep]).expect("written");
        let again = sweep(&["--out", &folder]);
        assert_eq!((again.code, &again.out), (0, &whole.out), "{}", again.err);
        assert!(again.err.starts_with(&format!("{missing} runs in ")), "{}", again.err);
        assert_eq!(timeless(&fs::read_to_string(&result).expect("it")), timeless(&table));
        assert_eq!(fs::read_to_string(&journal).expect("it").lines().count(), 4);
    }
    assert!(sweep(&["--out", &folder]).err.starts_with("0 runs in "));
    // More seeds build on those that are there.
    let more = phisindy(&[
        "sweep",
        "specs/case1a.ron",
        "--set",
        "data.0.duration=20.0",
        "--seeds",
        "4",
        "--out",
        &folder,
    ]);
    assert!(more.err.starts_with("1 runs in "), "{}", more.err);
}

/// However a sweep is cut, and wherever its parts lie, the table is the same to the bit.
#[test]
fn shards_merge_to_the_table_of_one_program() {
    let cells = ["--noise", "Relative(0.1), Additive(0.02)", "--format", "json"];
    let whole = sweep(&cells);
    assert_eq!(whole.code, 0, "{}", whole.err);
    for count in [2, 5] {
        let scratch = Scratch::new(&format!("shards-{count}"));
        // Shards in one folder, and the last one in another.
        let folder = |k: usize| scratch.path(if k < count { "parts" } else { "last" });
        for k in 1..=count {
            let shard = format!("{k}/{count}");
            let said = sweep(&[&cells as &[&str], &["--shard", &shard, "--out", &folder(k)]].concat());
            assert_eq!(said.code, 0, "{}", said.err);
        }
        let (parts, last, out) = (folder(1), folder(count), scratch.path("out"));
        let merged = phisindy(&["sweep", "--format", "json", "--out", &out, "--merge", &parts, &last]);
        assert_eq!((merged.code, merged.err.as_str()), (0, ""));
        assert_eq!(timeless(&merged.out), timeless(&whole.out));
        let kept = fs::read_to_string(scratch.path("out/sweep.json")).expect("the table");
        assert_eq!(timeless(&kept), timeless(&whole.out));
        // A shard that is done is not done again; one that is missing is missed.
        let shard = format!("1/{count}");
        let again = [&cells as &[&str], &["--shard", &shard, "--out", &parts]].concat();
        let before = fs::read_to_string(format!("{parts}/sweep-1-of-{count}.jsonl")).expect("a journal");
        assert_eq!(sweep(&again).code, 0);
        let after = fs::read_to_string(format!("{parts}/sweep-1-of-{count}.jsonl")).expect("a journal");
        assert_eq!(before, after);
        let some = phisindy(&["sweep", "--format", "json", "--merge", &parts]);
        assert_eq!((some.code, &json(&some.out)["stopped"]), (1, &true.into()));
        assert!(some.err.contains("are in no journal"), "{}", some.err);
    }
}

#[test]
fn shards_of_different_sweeps_are_not_merged() {
    let scratch = Scratch::new("shards-wrong");
    let (parts, other) = (scratch.path("parts"), scratch.path("other"));
    assert_eq!(sweep(&["--shard", "1/3", "--out", &parts]).code, 0);
    assert_eq!(sweep(&["--shard", "2/3", "--out", &other, "--set", "learn.cutoff=0.1"]).code, 0);
    let said = phisindy(&["sweep", "--merge", &parts, &other]);
    assert_eq!((said.code, said.out.as_str()), (2, ""));
    assert!(said.err.contains("are not of one sweep"), "{}", said.err);
    // Another result of the same run.
    let journal = format!("{parts}/sweep-1-of-3.jsonl");
    let text = fs::read_to_string(&journal).expect("a journal");
    fs::write(format!("{parts}/sweep-2-of-3.jsonl"), text.replace("\"exact\":true", "\"exact\":false"))
        .expect("written");
    let said = phisindy(&["sweep", "--merge", &parts]);
    assert!(said.code == 2 && said.err.contains("has another result for seed"), "{}", said.err);
    fs::write(format!("{parts}/sweep-2-of-3.jsonl"), "a,b\n1,2\n").expect("written");
    let said = phisindy(&["sweep", "--merge", &parts]);
    assert!(said.code == 2 && said.err.contains("no journal of a sweep"), "{}", said.err);
    for (words, says) in [
        (vec!["--merge", "specs"], "holds no journal"),
        (vec!["--merge", "nowhere"], "cannot read the folder"),
        (vec![], "required"),
        (vec!["specs/case1a.ron", "--merge", "specs"], "cannot be used with"),
        (vec!["specs/case1a.ron", "--shard", "4/3", "--out", &parts], "such as 3/16"),
        (vec!["specs/case1a.ron", "--shard", "1/3"], "--out DIR"),
    ] {
        let said = phisindy(&[&["sweep"], words.as_slice()].concat());
        assert!(said.code == 2 && said.err.contains(says), "{words:?}: {}", said.err);
    }
}

#[test]
fn a_journal_of_another_case_is_refused() {
    let scratch = Scratch::new("other");
    let folder = scratch.path("");
    assert_eq!(sweep(&["--out", &folder]).code, 0);
    for other in [&["--set", "learn.cutoff=0.1"] as &[&str], &["--method", "step"]] {
        let said = sweep(&[&["--out", folder.as_str()], other].concat());
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{}", said.err);
        assert!(said.err.contains("holds runs of another case"), "{}", said.err);
        assert!(said.err.contains("give another --out, or delete the file"), "{}", said.err);
    }
    let journal = scratch.path("sweep.jsonl");
    let damaged = fs::read_to_string(&journal).expect("it").replace("\"exact\":true", "\"exact\":tr");
    fs::write(&journal, damaged).expect("written");
    let said = sweep(&["--out", &folder]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("line 2 of"), "{}", said.err);
    for foreign in ["a,b", "a,b\n1,2\n3", "a,b\n1,2\n"] {
        fs::write(&journal, foreign).expect("written");
        let said = sweep(&["--out", &folder]);
        assert_eq!(said.code, 2);
        assert!(said.err.contains("no journal of a sweep"), "{}", said.err);
        assert_eq!(
            fs::read_to_string(&journal).expect("it"),
            foreign,
            "a file that is not ours stays as it is"
        );
    }
}

#[test]
fn a_journal_knows_files_by_their_content() {
    let scratch = Scratch::new("content");
    let (out, push) = (scratch.path("out"), scratch.path("push.csv"));
    let written = |size: f64| {
        let row = |k: u32| format!("{},{}\n", f64::from(k) * 0.01, size * (f64::from(k) * 0.02).sin());
        fs::write(&push, format!("t,F\n{}", (0..2200).map(row).collect::<String>())).expect("written");
    };
    let path = scratch.path("case.ron");
    let spec = r#"(constants: {}, states: { "x": "m", "v": "m/s" }, inputs: { "F": "N" }, known: { "x": "v", "v": "F - x" },
        unknown: { "v": (factor: "-sgn(v)", candidates: ["1"]) }, contacts: ["v"],
        data: [Synthetic(truth: { "v": "-0.2*sgn(v)" }, start: { "x": 1.0, "v": 0.0 }, duration: 20.0, step: 0.02,
            noise: Additive(0.001), inputs: { "F": File(path: "push.csv", time: "t", column: "F") })])"#;
    fs::write(&path, spec).expect("written");
    let swept = || phisindy(&["sweep", &path, "--seeds", "2", "--out", &out]);
    written(1.0);
    assert_eq!(swept().code, 0, "{}", swept().err);
    assert!(swept().err.contains("0 runs in "));
    written(2.0);
    let said = swept();
    assert!(said.code == 2 && said.err.contains("holds runs of another case"), "{}", said.err);
}

#[test]
fn a_part_of_a_sweep_replaces_no_whole_table() {
    let scratch = Scratch::new("part");
    let (parts, out) = (scratch.path("parts"), scratch.path("out"));
    assert_eq!(sweep(&["--out", &out]).code, 0);
    let before = fs::read_to_string(scratch.path("out/sweep.json")).expect("a table");
    assert_eq!(sweep(&["--shard", "1/3", "--out", &parts]).code, 0);
    assert_eq!(phisindy(&["sweep", "--merge", &parts, "--out", &out]).code, 1);
    assert_eq!(fs::read_to_string(scratch.path("out/sweep.json")).expect("a table"), before);
}

#[test]
fn cells_are_all_combinations() {
    let said = sweep(&[
        "--seeds",
        "2",
        "--format",
        "json",
        "--noise",
        "Relative(0.1), Additive(0.02)",
        "--vary",
        "unknown.y.candidates=[\"1\"];[\"1\", \"x\"]",
    ]);
    // A later --seeds is an error of the command line, not a silent choice.
    assert_eq!(said.code, 2, "{}", said.out);
    let said = phisindy(&[
        "sweep",
        "specs/case1a.ron",
        "--set",
        "data.0.duration=20.0",
        "--seeds",
        "2",
        "--format",
        "json",
        "--noise",
        "Relative(0.1), Additive(0.02)",
        "--vary",
        "unknown.y.candidates=[\"1\"];[\"1\", \"x\"]",
    ]);
    assert_eq!(said.code, 0, "{}", said.err);
    let result = json(&said.out);
    let cells = result["cells"].as_array().expect("cells");
    let labels: Vec<&str> = cells.iter().map(|c| c["cell"].as_str().expect("a label")).collect();
    assert_eq!(
        labels,
        [
            "noise=Relative(0.1), unknown.y.candidates=[\"1\"]",
            "noise=Relative(0.1), unknown.y.candidates=[\"1\", \"x\"]",
            "noise=Additive(0.02), unknown.y.candidates=[\"1\"]",
            "noise=Additive(0.02), unknown.y.candidates=[\"1\", \"x\"]",
        ]
    );
    assert_eq!(result["runs"], 8);
    for cell in cells {
        assert!(cell["coefficients"]["y:1"]["median"].is_number(), "{cell}");
    }
}

#[test]
fn cutoffs_act_on_the_method_in_use() {
    let step =
        ["--method", "step", "--set", "learn.optimiser=GaussNewton", "--set", "data.0.noise=Relative(0)"];
    let said = sweep(&[&step as &[&str], &["--cutoffs", "0.05,0.9", "--format", "json"]].concat());
    assert_eq!(said.code, 0, "{}", said.err);
    let cells = json(&said.out)["cells"].clone();
    assert_eq!((&cells[0]["exact_support"], &cells[1]["exact_support"]), (&3.into(), &0.into()), "{cells}");
    assert_eq!(cells[1]["failures"][0]["missing"][0], "y:1");
    let said = sweep(&["--cutoffs", "0.9", "--format", "json"]);
    assert_eq!(json(&said.out)["exact_support"], 0, "{}", said.out);
}

#[test]
fn a_truth_outside_of_the_dictionary_is_said() {
    let said = sweep(&["--set", "unknown.y.candidates=[\"x\", \"y\"]", "--format", "json"]);
    assert_eq!(said.code, 1, "{}", said.err);
    assert!(said.err.contains("outside the dictionary"), "{}", said.err);
    let result = json(&said.out);
    assert_eq!((&result["runs"], &result["exact_support"]), (&0.into(), &0.into()));
    assert!(result["error"].as_str().expect("words").contains("outside the dictionary"));
}

#[test]
fn a_sweep_needs_a_truth_and_a_dictionary() {
    let said = phisindy(&["sweep", "specs/frame_250g.ron", "--seeds", "2"]);
    assert_eq!(said.code, 2, "{}", said.err);
    let said = sweep(&["--set", "unknown={}"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("`unknown` is empty"), "{}", said.err);
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_is_finished() {
    let scratch = Scratch::new("interrupt");
    let folder = scratch.path("");
    let mut child = program(&["sweep", "specs/case1a.ron", "--seeds", "100000", "--out", &folder])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("starts");
    let lines = || fs::read_to_string(scratch.path("sweep.jsonl")).map_or(0, |t| t.lines().count());
    let begin = std::time::Instant::now();
    while lines() < 3 {
        assert!(begin.elapsed().as_secs() < 60, "no run is finished");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("kill runs").success());
    let _ = child.wait();
    let output = child.wait_with_output().expect("ends");
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(130), "{err}");
    assert!(err.contains("the same command goes on from there"), "{err}");
    assert!(out.contains("exactly the true terms in"), "{out}");
    assert!(lines() >= 3);
}

#[test]
fn more_cells_than_anybody_reads_are_refused_before_they_are_made() {
    let axes: Vec<String> = (0..20).map(|k| format!("learn.cutoff{k}=0.1;0.2")).collect();
    let many: Vec<&str> = axes.iter().flat_map(|axis| ["--vary", axis.as_str()]).collect();
    let refused = |more: &[&str], words: &str| {
        let said = sweep(more);
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{}", said.err);
        assert!(said.err.contains(words), "{}", said.err);
    };
    refused(&many, "1048576 cells with 3 seeds each are too many");
    // Cells that could not be told apart, or whose values the seeds of the sweep replace.
    refused(&["--vary", "data.0.step=0.1;0.2;0.1"], "lists `0.1` twice");
    refused(&["--vary", "data.0.step=0.1", "--vary", "data.0.step=0.2"], "is given twice");
    refused(&["--vary", "data.0.seed=1;2"], "each run has a seed of its own");
}

#[test]
fn a_limit_is_heard_while_cells_are_made() {
    let axis = |path: &str| {
        let values: Vec<String> = (0..300).map(|k| format!("{}", 20.0 + 0.01 * f64::from(k))).collect();
        format!("data.0.{path}={}", values.join(";"))
    };
    let (one, two) = (axis("duration"), axis("start.y"));
    let begin = std::time::Instant::now();
    let words =
        ["sweep", "specs/case1a.ron", "--seeds", "1", "--vary", &one, "--vary", &two, "--limit", "1s"];
    let said = phisindy(&words);
    assert!(begin.elapsed().as_secs() < 10, "{:?}", begin.elapsed());
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("stopped before the first run"), "{}", said.err);
}
