//! What asks the same question in other words: a few cases of each kind; `PHISINDY_REWORD` is how many times as many.

#![allow(missing_docs)]

use crate::common::blind;

/// Rows by name: cases and disagreements of `run`, then of `gap`.
#[track_caller]
fn reworded(more: &[&str]) -> Vec<(String, Vec<usize>)> {
    let said = blind(&[&["reword", "--quiet"], more].concat());
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let rows = said.out.lines().filter(|line| line.starts_with("| ")).skip(2).map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let counts: Vec<usize> = cells[3..7].iter().filter_map(|cell| cell.parse().ok()).collect();
        assert!(counts[1] + counts[3] == 0, "{}", said.out);
        (cells[1].to_owned(), counts)
    });
    rows.collect()
}

#[test]
fn an_answer_does_not_depend_on_how_the_question_is_put() {
    let times: usize = std::env::var("PHISINDY_REWORD").ok().and_then(|n| n.parse().ok()).unwrap_or(1);
    let rows = reworded(&["--from", "rig", "--runs", &(3 * times).to_string(), "--seed", "7"]);
    // What no rig of the first few has: accelerometers, ...
    let rare = ["g for m/s^2"];
    for (name, counts) in &rows {
        assert!(counts[0] > 0 || rare.contains(&name.as_str()), "{name} was never tried");
    }
    assert!(rows.len() > 30);
}

#[cfg(unix)]
#[test]
fn an_answer_that_changes_is_told() {
    use crate::common::Scratch;
    use std::os::unix::fs::PermissionsExt;
    let scratch = Scratch::new("reword");
    let program = scratch.path("phisindy");
    // It hears nothing of gains, and counts the letters of all else.
    let script = r#"#!/bin/sh
case "$*" in simulate*) echo t,x1,x2,v1,v2; for k in 0 1 2 3; do echo $k,0.1,0.2,0.3,0.4; done; exit;; esac
grep -q gain "$2" && echo '{"verdict": "identified", "parameters": [{"name": "k", "value": 2.0, "ci95": [1.9, 2.1]}]}' && exit
echo '{"verdict": "identified", "parameters": [{"name": "k", "value": 1.0, "ci95": [0.9, 1.1]}]}'
"#;
    std::fs::write(&program, script).expect("a script");
    std::fs::set_permissions(&program, PermissionsExt::from_mode(0o755)).expect("it may run");
    let said = blind(&["reword", "--from", "rig", "--runs", "1", "--quiet", "--program", &program]);
    assert_eq!(said.code, 0, "{}", said.err);
    let lines: Vec<&str> = said.out.lines().filter(|line| line.starts_with("0 run, ")).collect();
    let told = "0 run, gain for a unit: k: [1.0, 0.9, 1.1] became [2.0, 1.9, 2.1]";
    assert_eq!(lines, [told], "{}", said.out);
}
