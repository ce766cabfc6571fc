//! What counts panics, hangs and wrong verdicts.

#![allow(missing_docs)]

use crate::common::{Scratch, blind};

#[test]
fn odd_cases_neither_panic_nor_hang_nor_lead_astray() {
    let said = blind(&["odd", "--runs", "150", "--seed", "3", "--quiet"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let all =
        said.out.lines().find(|l| l.starts_with("| all | 150 |")).unwrap_or_else(|| panic!("{}", said.out));
    let cells: Vec<&str> = all.split('|').map(str::trim).collect();
    // Another exit code, panics, hangs, wrong verdicts.
    assert_eq!(cells[9..13], ["0"; 4], "{}", said.out);
}

#[cfg(unix)]
#[test]
fn a_program_that_panics_or_errs_is_told_and_its_files_are_kept() {
    use std::os::unix::fs::PermissionsExt;
    let scratch = Scratch::new("odd");
    let (program, kept) = (scratch.path("phisindy"), scratch.path("kept"));
    let script = |text: &str| {
        std::fs::write(&program, format!("#!/bin/sh\n{text}\n")).expect("a script");
        std::fs::set_permissions(&program, PermissionsExt::from_mode(0o755)).expect("it may run");
        blind(&["odd", "--runs", "20", "--quiet", "--program", &program, "--out", &kept])
    };
    // Refusing what is valid is wrong, but no accident.
    let said = script("exit 2");
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains(": refused: "), "{}", said.out);
    let said = script("echo \"thread 'main' panicked at x.rs\" >&2; exit 101");
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(said.err.contains("20 of 20 executions panicked"), "{}", said.err);
    assert!(std::path::Path::new(&kept).join("0/odd.ron").is_file(), "the files are kept");
}
