//! The project's own specs and laws, damaged at random: whatever is left of them is read or refused with a
//! place, never worse. The long

//! version of this is `fuzz/`.

use phisindy_phys::{Diagnostic, Law, SourceId, check, spec};
use proptest::prelude::*;
use std::path::Path;

/// What damage inserts.
const TOKENS: &[&str] = &[
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    "\"",
    ",",
    ":",
    "-",
    "*",
    "/",
    "^",
    "|",
    "1e308",
    "-1e-320",
    "0.0",
    "NaN",
    "d",
    "sgn(",
    "ln(",
    "Find(",
    "Csv(",
    "within: (0.0, 1.0)",
    "\"km\"",
    "each: true",
    "é",
];

/// The texts of a folder.
fn texts(folder: &str) -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(folder);
    let mut paths: Vec<_> =
        std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "ron"));
    paths.sort();
    paths.iter().map(|p| std::fs::read_to_string(p).expect("a text")).collect()
}

/// A piece taken out, and a token put in its place.
fn damaged(mut text: String, edits: &[(usize, usize, Option<usize>)]) -> String {
    let boundary = |text: &str, mut at: usize| {
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    for (at, length, token) in edits {
        let start = boundary(&text, at % (text.len() + 1));
        let end = boundary(&text, (start + length).min(text.len())).max(start);
        text.replace_range(start..end, token.map_or("", |k| TOKENS[k]));
    }
    text
}

fn edits() -> impl Strategy<Value = Vec<(usize, usize, Option<usize>)>> {
    prop::collection::vec((0..100_000_usize, 0..4_usize, prop::option::of(0..TOKENS.len())), 1..4)
}

fn inside(said: &[Diagnostic], text: &str) {
    for d in said {
        assert!(!d.message.is_empty());
        for label in &d.labels {
            assert!(text.get(label.span.range()).is_some(), "{label:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn a_damaged_spec_is_checked_or_refused_with_a_place(which in 0..1000_usize, edits in edits()) {
        let all = texts("specs");
        let text = damaged(all[which % all.len()].clone(), &edits);
        match spec::read(&text, SourceId(0)) {
            Ok((spec, said)) => {
                inside(&said, &text);
                let (Ok((_, said)) | Err(said)) = check(&spec, SourceId(0));
                inside(&said, &text);
            }
            Err(said) => inside(&said, &text),
        }
    }

    #[test]
    fn a_damaged_law_is_read_or_refused(which in 0..1000_usize, edits in edits()) {
        let all = texts("specs/laws");
        let text = damaged(all[which % all.len()].clone(), &edits);
        if let Err(mistakes) = Law::checked(&text, SourceId(0)) {
            prop_assert!(!mistakes.is_empty());
        }
        match Law::read(&text) {
            // Whatever the law says, what it is can be asked.
            Ok(law) => {
                let given = law.dissipates() == Some(true) && law.has_memory();
                prop_assert!(!given && (law.parity().is_none() || law.property().is_none()));
            }
            Err(why) => prop_assert!(!why.to_string().is_empty()),
        }
    }
}
