//! Data files of every format: `new` writes a spec that `check` accepts, and bad files end with exit code 2
//! and a reason.

#![allow(missing_docs)]

use crate::common::{Scratch, phisindy, top};

/// The fixtures that are no plain text, made by other programs.
const FILES: &[&str] = &[
    "run.xlsx",
    "run.ods",
    "run.xls",
    "run.mat",
    "run.npz",
    "packed.npz",
    "run.npy",
    "run.uff",
    "binary.uff",
    "run.tdms",
    "rates.tdms",
    "run_utf16.csv",
    "run_1252.csv",
];

fn fixture(name: &str) -> Vec<u8> {
    std::fs::read(top().join("crates/import/tests/fixtures").join(name)).expect("a fixture")
}

#[test]
fn new_writes_a_spec_for_every_format() {
    for name in FILES {
        let scratch = Scratch::new("formats");
        let (data, spec) = (scratch.path(name), scratch.path("rig.ron"));
        std::fs::write(&data, fixture(name)).expect("a file");
        let said = phisindy(&["new", &data, "--out", &spec]);
        assert_eq!((said.code, said.out.as_str()), (0, ""), "{name}: {}", said.err);
        let said = phisindy(&["check", &spec]);
        assert_eq!(said.code, 0, "{name}: {}", said.err);
    }
}

#[test]
fn bad_files_end_with_a_reason() {
    for name in FILES.iter().filter(|name| !name.ends_with(".csv")) {
        let scratch = Scratch::new("bad-formats");
        let data = scratch.path(name);
        let good = fixture(name);
        // Half of `run.uff` is a file of its own: its first function.
        std::fs::write(&data, &good[..good.len() * 2 / 5]).expect("a file");
        let said = phisindy(&["new", &data]);
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{name}: {}", said.err);
        assert!(
            said.err.contains("error") && said.err.contains(name) && !said.err.contains("panicked"),
            "{name}: {}",
            said.err
        );
        std::fs::write(&data, &good).expect("a file");
        let said = phisindy(&["new", &data, "--sheet", "no such sheet"]);
        assert_eq!(said.code, 2, "{name}: {}", said.err);
        assert!(said.err.contains("no sheet, variable or group `no such sheet`"), "{name}: {}", said.err);
    }
}
