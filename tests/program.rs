//! The program from outside: exit codes, forms of the result, options.

#![allow(missing_docs)]

use crate::common::{self, Scratch, files, phisindy, program, top};
use serde_json::Value;
use std::io::Read;
use std::process::Stdio;

/// Case 1a without noise and with a small dictionary: a second of work.
const QUICK: &[&str] = &[
    "specs/case1a.ron",
    "--method",
    "step",
    "--set",
    "data.0.noise=Relative(0)",
    "--set",
    "data.0.duration=20.0",
    "--set",
    "unknown.y.candidates=[\"1\",\"x\"]",
    "--set",
    "learn.optimiser=GaussNewton",
];

fn quick(more: &[&str]) -> common::Outcome {
    phisindy(&[&["run"], QUICK, more].concat())
}

#[test]
fn every_spec_is_clean() {
    let specs = files("specs", "ron");
    let mut arguments = vec!["check"];
    arguments.extend(specs.iter().map(String::as_str));
    let said = phisindy(&arguments);
    assert_eq!((said.code, said.out.as_str()), (0, ""), "{}", said.err);
    // Measured files need not be here.
    assert!(
        said.err.lines().filter(|l| l.starts_with("warning")).all(|l| l.contains("there is no data file")),
        "{}",
        said.err
    );
    assert!(!said.err.contains("error"), "{}", said.err);
}

#[test]
fn latex_comes_first_and_the_rest_is_comment() {
    let said = quick(&[]);
    assert_eq!((said.code, said.err.as_str()), (0, ""));
    let mut lines = said.out.lines();
    let equation = lines.next().expect("an equation");
    assert!(equation.starts_with(r"\dot{y} = -0.1\,y - x + \cos\left(0.3\,t\right) - 0.5"), "{equation}");
    assert!(lines.all(|l| l.starts_with('%')), "{}", said.out);
    assert!(said.out.contains("95 % interval"), "{}", said.out);
}

#[test]
fn text_is_an_equation_in_the_language_of_the_specs() {
    let said = quick(&["--format", "text"]);
    let equation = said.out.lines().next().expect("an equation");
    let right = equation.strip_prefix("dy/dt = ").expect(equation);
    let root = phisindy_expr::parse(right).expect(right);
    assert!(root.names().all(|(n, _)| ["x", "y", "t"].contains(&n)), "{right}");
}

#[test]
fn json_has_the_keys_of_the_contract() {
    let said = quick(&["--format", "json"]);
    assert_eq!((said.code, said.err.as_str(), said.out.lines().count()), (0, "", 1));
    let result: Value = serde_json::from_str(&said.out).expect("JSON");
    let keys = "spec title method verdict equations parameters records noise_model selection warnings seconds version";
    for key in keys.split(' ') {
        assert!(!result[key].is_null(), "{key} is missing");
    }
    assert_eq!(
        (&result["spec"], &result["verdict"], &result["method"]),
        (&"specs/case1a.ron".into(), &"identified".into(), &"step".into())
    );
    let equation = &result["equations"][0];
    assert_eq!((&equation["state"], &equation["terms"][0]["candidate"]), (&"y".into(), &"1".into()));
    let coefficient = equation["terms"][0]["coefficient"].as_f64().expect("a number");
    assert!((coefficient - 0.5).abs() < 0.005, "{coefficient}");
    for key in ["latex", "text", "terms"] {
        assert!(!equation[key].is_null(), "{key}");
    }
    for key in ["coefficient", "std_error", "ci95"] {
        assert!(!equation["terms"][0][key].is_null(), "{key}");
    }
    assert_eq!(
        (&equation["terms"][0]["unit"], &equation["terms"][0]["force"]),
        (&"m/s^2".into(), &Value::Null)
    );
    for key in ["name", "role", "samples", "nrmse", "noise", "start"] {
        assert!(!result["records"][0][key].is_null(), "{key}");
    }
    assert!(result["records"][0]["nrmse"]["x"].as_f64().expect("a number") < 0.01);
}

#[test]
fn coefficients_come_in_the_units_that_follow() {
    let mass = ["--set", "constants.m=(2.0, \"kg\")", "--set", "inertia={\"y\": \"m\"}"];
    // A factor without the mass: the coefficient is a rate, and the force stands beside it.
    let said = quick(&[&mass[..], &["--format", "json"]].concat());
    let result: Value = serde_json::from_str(&said.out).expect("JSON");
    let term = &result["equations"][0]["terms"][0];
    let (rate, force) = (term["coefficient"].as_f64(), term["force"]["value"].as_f64());
    assert_eq!((&term["unit"], &term["force"]["unit"]), (&"m/s^2".into(), &"N".into()));
    assert_eq!(rate.map(|rate| 2.0 * rate), force);
    // With the mass it is the force.
    let newtons = [&mass[..], &["--set", "unknown.y.factor=\"-sgn(y)/m\"", "--format", "text"]].concat();
    let said = quick(&newtons);
    let row = said.out.lines().find(|l| l.contains("-sgn(y)/m")).expect("a row of the table");
    let cells: Vec<&str> = row.split_whitespace().collect();
    assert_eq!(&cells[..4], ["y", "-sgn(y)/m", "1", "N"], "{row}");
    assert!(cells[4].starts_with('1') || cells[4].starts_with("0.99"), "{row}");
    assert!(!said.out.contains("times inertia"), "{}", said.out);
}

#[test]
fn several_specs_are_several_lines_of_json() {
    let said = quick(&["specs/case1a.ron", "--format", "json"]);
    assert_eq!(said.out.lines().count(), 2, "{}", said.err);
    assert!(said.out.lines().all(|l| serde_json::from_str::<Value>(l).is_ok()));
}

#[test]
fn a_rejected_model_ends_with_1() {
    // What is missing, the dictionary cannot name.
    let said = quick(&["--set", "data.0.truth={ \"y\": \"2*sin(2*t)\" }", "--format", "json"]);
    assert_eq!(said.code, 1, "{}", said.err);
    let result: Value = serde_json::from_str(&said.out).expect("JSON");
    assert_eq!(result["verdict"], "rejected");
}

#[test]
fn mistakes_of_the_command_line_end_with_2() {
    for arguments in [
        &["run"] as &[&str],
        &["fly", "specs/case1a.ron"],
        &["run", "specs/case1a.ron", "--formt", "json"],
        &["run", "specs/case1a.ron", "--format", "xml"],
        &["run", "specs/case1a.ron", "--set", "learn"],
        &["run", "specs/case1a.ron", "--set", "learn.cutof=0.1"],
        &["run", "specs/case1a.ron", "--set", "data.7.noise=Relative(0)"],
        &["run", "specs/case1a.ron", "--jobs", "0"],
        &["run", "specs/case1a.ron", "--jobs", "60000"],
        // Each would be left aside without a word.
        &["gap", "specs/case1a.ron", "--method", "step"],
        &["simulate", "specs/case1a.ron", "--out", "folder"],
        &["completions", "bash", "--seed", "1"],
        &["run", "specs/none.ron"],
        &["run", "specs"],
        &["laws", "stribek"],
        &["simulate", "specs/emps.ron"],
        &["check", "specs/emps.ron", "--data", "specs"],
        &["sweep", "specs/case1a.ron", "--seeds", "0"],
        &["sweep", "specs/case1a.ron", "--noise", " "],
        &["sweep", "specs/case1a.ron", "--noise", "Loud(1)"],
        &["sweep", "specs/case1a.ron", "--vary", "learn.cutof=1;2"],
        &["sweep", "specs/wrong/syntax_error.ron"],
        &["run", "specs/case1a.ron", "--out", "Cargo.toml"],
    ] {
        let said = phisindy(arguments);
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{arguments:?}: {}", said.err);
        assert!(said.err.contains("error"), "{arguments:?}: {}", said.err);
        assert!(!said.err.contains("panicked"), "{arguments:?}: {}", said.err);
    }
}

#[test]
fn help_is_broken_at_words_and_shows_what_a_command_takes() {
    let help = |arguments: &[&str]| {
        let output = common::program(arguments).env("COLUMNS", "70").output().expect("starts");
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    for command in ["run", "gap", "new", "sweep", "go", "export", "open", "check"] {
        let said = help(&[command, "--help"]);
        let long = said.lines().find(|line| line.chars().count() > 70 && line.trim().contains(' '));
        assert!(long.is_none(), "{command}: {long:?}");
    }
    assert!(help(&["run", "--help"]).contains("--method") && !help(&["gap", "--help"]).contains("--method"));
    assert!(
        !help(&["simulate", "--help"]).contains("--out <") && help(&["man", "--help"]).contains("--out <")
    );
}

#[test]
fn help_teaches_by_examples() {
    let said = phisindy(&["--help"]);
    assert_eq!(said.code, 0);
    assert!(said.out.starts_with("Examples:") && said.out.contains("Exit codes"), "{}", said.out);
}

#[test]
fn set_changes_the_spec_and_seed_the_noise() {
    let plain = ["simulate", "specs/case1a.ron", "--set", "data.0.duration=1.0"];
    let with = |more: &[&str]| phisindy(&[&plain, more].concat()).out;
    assert_eq!(with(&[]).lines().count(), 101);
    assert_eq!(with(&[]), with(&[]));
    assert_ne!(with(&[]), with(&["--seed", "7"]));
    assert_eq!(with(&["--seed", "7"]), with(&["--set", "data.0.seed=7"]));
}

#[test]
fn simulated_data_read_back() {
    let scratch = Scratch::new("read-back");
    let data = phisindy(&[
        "simulate",
        "specs/case1a.ron",
        "--set",
        "data.0.noise=Relative(0)",
        "--set",
        "data.0.duration=20.0",
    ]);
    assert_eq!(data.code, 0, "{}", data.err);
    assert_eq!(data.out.lines().next(), Some("t,x,y,x_true,y_true"));
    std::fs::write(scratch.path("made.csv"), &data.out).expect("a file");
    let record = "data=[Csv(path: \"made.csv\", time: \"t\", columns: {\"x\": \"x\", \"y\": \"y\"})]";
    let folder = scratch.path("");
    let options = [
        "--set",
        record,
        "--data",
        &folder,
        "--set",
        "unknown.y.candidates=[\"1\"]",
        "--set",
        "learn.optimiser=GaussNewton",
    ];
    let said = phisindy(&[&["run", "specs/case1a.ron", "--format", "json"], options.as_slice()].concat());
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let result: Value = serde_json::from_str(&said.out).expect("JSON");
    let coefficient = result["equations"][0]["terms"][0]["coefficient"].as_f64().expect("a number");
    assert!((coefficient - 0.5).abs() < 0.005, "{coefficient}");
}

#[test]
fn out_writes_whole_files() {
    let scratch = Scratch::new("out");
    let folder = scratch.path("deep/er");
    assert_eq!(quick(&["--out", &folder]).code, 0);
    let json = std::fs::read_to_string(scratch.path("deep/er/result.json")).expect("result.json");
    assert!(serde_json::from_str::<Value>(&json).is_ok());
    let latex = std::fs::read_to_string(scratch.path("deep/er/equation.tex")).expect("equation.tex");
    assert!(latex.starts_with("\\dot{y} = "));
    assert!(std::path::Path::new(&scratch.path("deep/er/identified.ron")).exists());
    let entries = std::fs::read_dir(&folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    let wanted = [
        "equation.tex",
        "figures",
        "identified.ron",
        "provenance.json",
        "report.html",
        "result.json",
        "spec.ron",
    ];
    assert_eq!(names, wanted);
}

#[test]
fn a_missing_data_file_is_an_error_where_a_folder_is_given() {
    let said = phisindy(&["check", "specs/wrong/missing_file.ron", "--data", "specs"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("looked in `specs` (--data)"), "{}", said.err);
    let environment = program(&["check", "specs/wrong/missing_file.ron"])
        .env("PHISINDY_DATA", "nowhere")
        .output()
        .expect("runs");
    assert_eq!(environment.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&environment.stderr).contains("which is no folder"));
}

#[cfg(unix)]
#[test]
fn a_link_out_of_the_data_folder_is_refused() {
    let scratch = Scratch::new("link");
    std::os::unix::fs::symlink(top().join("specs/wrong/good.csv"), scratch.path("no_such_file.csv"))
        .expect("a link");
    let said = phisindy(&["run", "specs/wrong/missing_file.ron", "--data", &scratch.path("")]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("a link that leads out of the data folder"), "{}", said.err);
}

#[test]
fn the_catalogue_is_the_folder() {
    let said = phisindy(&["laws"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let listed: Vec<&str> = said.out.lines().filter_map(|l| l.split_whitespace().next()).collect();
    let folder: Vec<String> = files("specs/laws", "ron");
    let mut ids: Vec<&str> =
        folder.iter().map(|f| f.trim_start_matches("specs/laws/").trim_end_matches(".ron")).collect();
    ids.sort_unstable();
    assert_eq!(listed, ids);
    for id in ids {
        let law = phisindy(&["laws", id]);
        assert_eq!(law.code, 0, "{id}: {}", law.err);
        assert!(law.out.contains("Reference: "), "{id}");
        let text = std::fs::read_to_string(top().join(format!("specs/laws/{id}.ron"))).expect("a law");
        assert!(
            text.lines().all(|l| law.out.contains(l)),
            "{id}: the built-in text is not that of the folder"
        );
    }
}

#[test]
fn a_folder_of_laws_adds_to_the_catalogue() {
    let scratch = Scratch::new("laws");
    std::fs::write(
        scratch.path("mine.ron"),
        "(name: \"Mine\", parameters: {\"a\": (unit: \"N\", within: (0.0, 1.0))}, force: \"a*v\")",
    )
    .expect("a file");
    let said = phisindy(&["laws", "mine", "--laws", &scratch.path("")]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("a*v") && said.out.contains("0 to 1"), "{}", said.out);
    assert!(!said.err.contains("built in"), "{}", said.err);
    std::fs::copy(scratch.path("mine.ron"), scratch.path("coulomb.ron")).expect("a file");
    let said = phisindy(&["laws", "mine", "--laws", &scratch.path("")]);
    assert!(said.err.contains("`coulomb` stands for the law of this name that is built in"), "{}", said.err);
    // Control bytes of somebody else's file do not reach the terminal.
    std::fs::write(scratch.path("bad.ron"), "(name: 1, about: \"\u{1b}[2J\")").expect("a file");
    let said = phisindy(&["laws", "--laws", &scratch.path("")]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("?[2J") && !said.err.contains('\u{1b}'), "{}", said.err);
}

#[test]
fn a_broken_pipe_is_no_failure() {
    let mut child = program(&["simulate", "specs/case1a.ron"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    let mut first = [0; 16];
    child.stdout.take().expect("a pipe").read_exact(&mut first).expect("some output");
    let output = child.wait_with_output().expect("ends");
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), b"".as_slice()));
}

/// A file in place of a command, two letters that changed places, a data file in place of a spec.
#[test]
fn a_slip_on_the_command_line_gets_the_command_that_was_meant() {
    for (words, tip) in [
        (&["gpa", "a.ron"][..], "'gap'"),
        (&["simulatr", "a.ron"], "'simulate'"),
        (&["rig.csv"], "'go rig.csv'"),
        (&["rig.ron"], "'run rig.ron'"),
    ] {
        let said = phisindy(words);
        assert!(said.code == 2 && said.err.contains(tip), "{words:?}: {}", said.err);
    }
    let scratch = Scratch::new("program-data-file");
    std::fs::write(scratch.path("rig.csv"), "t,x\n0,0\n1,1\n").expect("a file");
    std::fs::write(scratch.path("rig.xlsx"), [0x50, 0x4b, 0x03, 0x04, 0xff, 0xfe]).expect("a file");
    for (command, file) in [("run", "rig.csv"), ("gap", "rig.csv"), ("check", "rig.xlsx")] {
        let path = scratch.path(file);
        let said = phisindy(&[command, &path]);
        assert_eq!(said.code, 2, "{}", said.err);
        assert!(said.err.contains(&format!("phisindy new {path} --out rig.ron")), "{}", said.err);
    }
}

#[test]
fn help_begins_with_what_a_command_takes_and_ends_with_examples() {
    for command in ["run", "gap", "new", "sweep", "go"] {
        let said = phisindy(&[command, "--help"]);
        assert_eq!((said.code, said.err.as_str()), (0, ""), "{command}");
        let at =
            |words: &str| said.out.find(words).unwrap_or_else(|| panic!("{command}: {words}: {}", said.out));
        assert!(at("Usage:") < at("Arguments:"), "{command}");
        assert!(at("Arguments:") < at("Common options:") && at("Common options:") < at("Examples:"));
        assert_eq!(phisindy(&[command, "-h"]).out, said.out, "{command}");
    }
}
