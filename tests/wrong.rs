//! Every file of specs/wrong holds one mistake; what the program says about it is a snapshot in
//! tests/snapshots.

#![allow(missing_docs)]

use crate::common::{files, phisindy, top};

#[test]
fn every_mistake_is_drawn_as_in_its_snapshot() {
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path(top().join("tests/snapshots"));
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    for spec in files("specs/wrong", "ron") {
        let name = spec.trim_start_matches("specs/wrong/").trim_end_matches(".ron");
        let said = phisindy(&["check", &spec]);
        assert_eq!(said.out, "", "{spec}");
        // A missing file may still come: an error only where a data folder was given.
        let expected = if name.starts_with("warn_") || name == "missing_file" { 0 } else { 2 };
        assert_eq!(said.code, expected, "{spec}: {}", said.err);
        assert!(!said.err.is_empty(), "{spec}: nothing is said");
        assert!(!said.err.contains('\u{1b}'), "{spec}: colours in a pipe");
        settings.bind(|| insta::assert_snapshot!(name, said.err));
    }
}

/// A law with one mistake each, in a folder of its own: `check`, `run`, `gap` and `laws` say where it is.
#[test]
fn every_mistake_of_a_law_is_drawn_as_in_its_snapshot() {
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path(top().join("tests/snapshots"));
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    for name in kinds_of_laws() {
        let folder = format!("specs/wrong/law/{name}");
        let said = phisindy(&["check", "specs/case1a.ron", "--laws", &folder]);
        let expected = if name.starts_with("warn_") { 0 } else { 2 };
        assert_eq!(said.code, expected, "{name}: {}", said.err);
        settings.bind(|| insta::assert_snapshot!(format!("law_{name}"), said.err));
        if expected == 2 {
            for command in [&["run", "specs/case1a.ron"][..], &["gap", "specs/case1a.ron"], &["laws"]] {
                let other = phisindy(&[command, &["--laws", &folder]].concat());
                assert_eq!((other.code, &other.err), (2, &said.err), "{command:?}");
            }
        }
    }
}

/// The folders of specs/wrong/law.
fn kinds_of_laws() -> Vec<String> {
    let folders = std::fs::read_dir(top().join("specs/wrong/law")).expect("specs/wrong/law");
    let mut all: Vec<String> =
        folders.map(|f| f.expect("a folder").file_name().to_string_lossy().into_owned()).collect();
    all.sort();
    all
}

#[test]
fn a_run_refuses_what_check_refuses() {
    for spec in files("specs/wrong", "ron").iter().filter(|s| !s.contains("/warn_")) {
        let said = phisindy(&["run", spec]);
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{spec}: {}", said.err);
        assert!(said.err.contains("error"), "{spec}");
    }
}

#[test]
fn every_snapshot_has_its_spec() {
    for snapshot in files("tests/snapshots", "snap") {
        let name = snapshot.trim_start_matches("tests/snapshots/").trim_end_matches(".snap");
        let law = name.strip_prefix("law_").map(|kind| top().join(format!("specs/wrong/law/{kind}")));
        let spec = top().join(format!("specs/wrong/{name}.ron"));
        assert!(spec.exists() || law.is_some_and(|l| l.exists()), "{snapshot} is left over");
    }
}
