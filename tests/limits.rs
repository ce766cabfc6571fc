//! Sizes beyond a stated limit are refused at once, with the place and what to do; `--limit` ends what takes
//! too long or too much.

#![allow(missing_docs)]

use crate::common::{self, Outcome, Scratch, phisindy};
use std::fs;
use std::time::{Duration, Instant};

/// A refusal that comes soon, fits a screen, and says what to do.
#[track_caller]
fn refused(arguments: &[&str], words: &[&str]) {
    let begin = Instant::now();
    let said = phisindy(arguments);
    assert!(begin.elapsed() < Duration::from_secs(10), "{:?}", begin.elapsed());
    assert_eq!((said.code, said.out.as_str()), (2, ""), "{}", said.err);
    assert!(said.err.len() < 4000, "{} bytes: {:.1000}", said.err.len(), said.err);
    words.iter().for_each(|word| assert!(said.err.contains(word), "{word:?} is not in {:.2000}", said.err));
}

#[track_caller]
fn with_set(set: &str, words: &[&str]) {
    refused(&["simulate", "specs/case1a.ron", "--set", set], words);
}

#[test]
fn records_that_do_not_fit_into_memory_are_refused() {
    with_set(
        "data.0.duration=1e10",
        &["1.0e12 samples are too many", "at most 2e6", "help: take a longer step"],
    );
    with_set("data.0.step=1e-300", &["samples are too many"]);
    with_set("data.0.duration=1e308", &["samples are too many"]);
    with_set("data.0.step=1e300", &["longer than the duration", "help: "]);
    let record = "Synthetic(truth: {}, start: { \"x\": 0.0, \"y\": 0.0 }, duration: 19000.0, step: 0.01)";
    with_set(&format!("data=[{}]", [record; 20].join(", ")), &["more than 2e7 numbers", "help: "]);
    refused(
        &[
            "simulate",
            "specs/case4.ron",
            "--set",
            "data.0.duration=1000.0",
            "--set",
            "data.0.inputs.F=Jonswap(hs: 1.0, tp: 1.0, omega: (0.001, 99.0, 0.001))",
        ],
        &["sines at each of", "take fewer sines"],
    );
}

#[test]
fn expressions_and_dictionaries_have_an_end() {
    let nested = format!("{}y{}", "(".repeat(10_000), ")".repeat(10_000));
    with_set(&format!("known.x=\"{nested}\""), &["more than 20000 tokens", "help: split it"]);
    let deep = format!("{}y{}", "(".repeat(300), ")".repeat(300));
    with_set(
        &format!("known.x=\"{deep}\""),
        &["nested more than 200 levels deep", "help: name an inner part", "..."],
    );
    let scratch = Scratch::new("terms");
    let text = fs::read_to_string(common::top().join("specs/case1a.ron")).expect("a spec");
    let begin = text.find("candidates: [").expect("candidates") + "candidates: [".len();
    let with = |n: usize| {
        let terms: Vec<String> = (0..n).map(|k| format!("\"x^{k}\"")).collect();
        let path = scratch.path("terms.ron");
        fs::write(&path, format!("{}{}, {}", &text[..begin], terms.join(", "), &text[begin..]))
            .expect("written");
        path
    };
    refused(&["check", &with(30_000)], &["candidates are too many (at most 1000)", "help: "]);
    refused(&["check", &with(1_000_000)], &["longer than 1 MiB", "help: "]);
    let constants: String = (0..20_000).map(|k| format!("\"k{k}\": 1.0, ")).collect();
    let path = scratch.path("constants.ron");
    fs::write(&path, text.replacen("constants: {", &format!("constants: {{ {constants}"), 1))
        .expect("written");
    refused(&["check", &path], &["constants are too many (at most 1000)", "help: "]);
    with_set("known.x=\"1e309\"", &["this number is too large", "help: "]);
}

#[test]
fn seeds_do_not_wrap() {
    let last = u64::MAX.to_string();
    refused(
        &["sweep", "specs/case1a.ron", "--seed", &last, "--seeds", "2"],
        &["beyond the largest seed", "--seed"],
    );
    let said = phisindy(&[
        "sweep",
        "specs/case1a.ron",
        "--set",
        "data.0.duration=20.0",
        "--seed",
        &last,
        "--seeds",
        "1",
    ]);
    assert_eq!(said.code, 0, "{}", said.err);
}

#[track_caller]
fn met(said: &Outcome, words: &str) {
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains(words) && said.err.contains("allow more with --limit"), "{}", said.err);
}

#[test]
fn a_limit_keeps_what_is_finished() {
    let scratch = Scratch::new("limit");
    let folder = scratch.path("out");
    let sweep =
        ["sweep", "specs/case1a.ron", "--set", "data.0.duration=20.0", "--seeds", "100000", "--out", &folder];
    let said = phisindy(&[&sweep as &[&str], &["--limit", "2s"]].concat());
    met(&said, "the limit of 2 s is met");
    assert!(said.out.contains("exactly the true terms in"), "{}", said.out);
    assert!(fs::read_to_string(scratch.path("out/sweep.jsonl")).expect("a journal").lines().count() > 1);
    // A run that would take an hour prints what it has.
    let run =
        ["run", "specs/case1a.ron", "--method", "step", "--set", "learn=(epochs: [9000000], rates: [0.01])"];
    let said = phisindy(&[&run as &[&str], &["--limit", "1s"]].concat());
    met(&said, "the limit of 1 s is met");
    assert!(said.out.contains("stopped: the limit of 1 s is met before the end; so far"), "{}", said.out);
    if cfg!(target_os = "linux") {
        let said = phisindy(&[&run as &[&str], &["--limit", "1MB"]].concat());
        met(&said, "the limit of 1 MB of memory is met");
    }
    let said = phisindy(&["run", "specs/case1a.ron", "--limit", "soon"]);
    assert!(said.code == 2 && said.err.contains("10min,4GB"), "{}", said.err);
}
