//! The tables of the documents, by the program that writes them.

#![allow(missing_docs)]

#[allow(dead_code)] // each test uses its part
use crate::common::{Scratch, blind, top};
use std::fs;

#[test]
fn the_tables_of_the_documents_are_the_codes() {
    for (table, document, rows) in [
        ("language", "docs/reference.md", ["`tanh(x)`", "`a ^ b`"]),
        ("decisions", "docs/method.md", ["`WORST_NRMSE`", "`EXPLAINED`"]),
    ] {
        let said = blind(&[table]);
        assert_eq!(said.code, 0, "{}", said.err);
        let text = fs::read_to_string(top().join(document)).expect("a document");
        assert!(rows.iter().all(|row| said.out.contains(row)), "{}", said.out);
        let hint = format!("out of date: phisindy-blind {table} --write {document}");
        assert!(text.contains(&said.out), "{hint}\n{}", said.out);
    }
}

#[test]
fn tables_go_into_the_readme() {
    let scratch = Scratch::new("table");
    let readme = scratch.path("README.md");
    let text = "# R\n<!-- table:paper -->\nold\n<!-- end -->\n<!-- table:sweep -->\n<!-- end -->\nlast\n";
    fs::write(&readme, text).expect("written");
    let quick = ["--cases", "1a", "--set", "data.0.duration=20.0", "--set", "learn.epochs=[50, 50, 50]"];
    let paper = blind(&[&["paper", "--write", readme.as_str()], quick.as_slice()].concat());
    assert_eq!(paper.code, 0, "{}", paper.err);
    assert!(paper.out.contains("| 1a | 0.5 | 0.502, eq. (41) | "), "{}", paper.out);
    assert!(paper.out.contains("| 1a | 0.5 | 0.354, eq. (42) | "), "{}", paper.out);
    let seeds = blind(&[&["sweep", "--seeds", "2", "--write", readme.as_str()], quick.as_slice()].concat());
    assert_eq!(seeds.code, 0, "{}", seeds.err);
    assert!(seeds.out.contains("| 1a | additive, 2 % | 2 of 2 | "), "{}", seeds.out);
    let written = fs::read_to_string(&readme).expect("it");
    assert_eq!(
        written,
        text.replace("old\n", &paper.out).replace("sweep -->\n", &format!("sweep -->\n{}", seeds.out))
    );
    fs::write(&readme, "no marks").expect("written");
    let said = blind(&[&["sweep", "--seeds", "2", "--write", readme.as_str()], quick.as_slice()].concat());
    assert_eq!(said.code, 2);
    assert!(said.err.contains("`<!-- table:sweep -->` is missing"), "{}", said.err);
}

#[test]
fn mistakes_of_the_command_line_end_with_2() {
    for arguments in [
        &["paper", "--cases", "11"] as &[&str],
        &["sweep", "--cases", "1a", "--method", "step"],
        &["hidden"],
        &["score", "--out", "specs"],
        &["wrong", "--only", "nothing of the kind"],
        &["language", "--write", "no such file"],
    ] {
        let said = blind(arguments);
        assert_eq!(said.code, 2, "{arguments:?}: {}", said.err);
        assert!(said.err.contains("error") && !said.err.contains("panicked"), "{arguments:?}: {}", said.err);
    }
}
