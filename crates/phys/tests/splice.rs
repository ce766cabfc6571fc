//! `--set` on texts.

use phisindy_phys::SourceId;
use phisindy_phys::spec::{DataSpec, NoiseSpec, read};
use phisindy_phys::splice::set;
use proptest::prelude::*;

const CASE7: &str = include_str!("spec/case7.ron");
const FRAME: &str = include_str!("spec/frame_250g.ron");
const FORMS: &str = include_str!("spec/forms.ron");

#[track_caller]
fn check(text: &str, path: &str, value: &str, expected: &str) {
    assert_eq!(set(text, path, value).as_deref(), Ok(expected));
}

#[test]
fn values_are_replaced_and_the_rest_stays() {
    check("(a: 1 /* one */, b: 2)", "a", "[3]", "(a: [3] /* one */, b: 2)");
    check("(m: { \"k\": (1.0, \"N\") })", "m.k.0", "2.0", "(m: { \"k\": (2.0, \"N\") })");
    check("(d: [1, X(n: 2)])", "d.1.n", "Y(3)", "(d: [1, X(n: Y(3))])");
    check("(d: [S(n: T({\"x\": 1}))])", "d.0.n.x", "2", "(d: [S(n: T({\"x\": 2}))])");
    check("(n: R(0.1))", "n.0", "0.2", "(n: R(0.2))");
    check("(m: { \"a.b\": 1 })", "m.\"a.b\"", "2", "(m: { \"a.b\": 2 })");
    check("(m: { r#\"a\"b\"#: 1 })", "m.a\"b", "2", "(m: { r#\"a\"b\"#: 2 })");
    check("#![enable(implicit_some)]\n(a: 1)", "a", " 2 ", "#![enable(implicit_some)]\n(a: 2)");
    check("(a: 1)", "a", "r#\"(\"#", "(a: r#\"(\"#)");
}

#[test]
fn what_is_missing_is_created() {
    check("(a: 1)", "learn.cutoff", "0.1", "(a: 1, learn: (cutoff: 0.1))");
    check("(a: 1,)", "b", "2", "(a: 1, b: 2)");
    check("()", "learn.cutoff", "0.1", "(learn: (cutoff: 0.1))");
    check("(a: 1)", "constants.k", "2.0", "(a: 1, constants: { \"k\": 2.0 })");
    check("(a: 1)", "unknown.y.factor", "\"-1\"", "(a: 1, unknown: { \"y\": (factor: \"-1\") })");
    check("(a: 1)", "let.w", "\"2*v\"", "(a: 1, let: { \"w\": \"2*v\" })");
    check("()", "outputs.a.reads", "\"v\"", "(outputs: { \"a\": (reads: \"v\") })");
    check("()", "places.r.enters.v", "\"1\"", "(places: { \"r\": (enters: { \"v\": \"1\" }) })");
    check("()", "energy.forces.F", "\"v\"", "(energy: (forces: { \"F\": \"v\" }))");
    check("(d: [S(a: 1)])", "d.0.detrend.x", "Mean", "(d: [S(a: 1, detrend: { \"x\": Mean })])");
    check("()", "streams.x.column", "\"x\"", "(streams: { \"x\": (column: \"x\") })");
    check("(inputs: {})", "inputs.u", "\"m\"", "(inputs: { \"u\": \"m\" })");
    check("(inputs: { // none\n})", "inputs.u", "\"m\"", "(inputs: { \"u\": \"m\"  // none\n})");
    check("(\n  a: 1, // one, two\n)", "b", "2", "(\n  a: 1, // one, two\n  b: 2,\n)");
    check("(\n  a: 1 // one, two\n)", "b", "2", "(\n  a: 1, // one, two\n  b: 2,\n)");
    check("(\n  a: 1 /* , */\n  , // ,\n)", "b", "2", "(\n  a: 1 /* , */\n  , // ,\n  b: 2,\n)");
    check("(\n  a: 1 // ,\n  ,\n)", "b", "2", "(\n  a: 1 // ,\n  ,\n  b: 2,\n)");
    check("(d: [S(a: 1)])", "d.0.sensors.x.offset", "1", "(d: [S(a: 1, sensors: { \"x\": (offset: 1) })])");
    check("(start: {})", "start.a\"b", "1", "(start: { r#\"a\"b\"#: 1 })");
}

#[test]
fn paths_that_lead_nowhere_are_explained() {
    let check = |path: &str, value: &str, part: &str, message: &str| {
        let error = set("(a: 1, d: [X(n: 2)], t: (1, 2))", path, value).unwrap_err();
        assert_eq!(error.part, part, "{error}");
        assert!(error.to_string().contains(message), "{error}");
    };
    check("d.1.n", "1", "1", "`d` has one entry, 0, and no `1`; there is: 0");
    check("d.x", "1", "x", "has one entry");
    check("a.b", "1", "b", "`a` is a single value, 1");
    check("t.2", "1", "2", "entries 0 to 1");
    check("t.value", "1", "value", "entries 0 to 1");
    check("", "1", "", "empty");
    check("a..b", "1", "", "empty");
    check("\"a", "1", "\"a", "never closed");
    check("\"a\"b", "1", "b", "a dot is missing");
    check("contacts.0", "1", "contacts", "set all of it");
    check("known.y.x", "1", "y", "set all of it");
    check("b c", "1", "b c", "not the name of a field");
    check("a", "1, b: 2", "1, b: 2", "not RON");
    check("a", "", "", "not RON");
    check("a", "(", "(", "not RON");
    check("a", "1 // x", "1 // x", "more than one value");
    assert!(set("(a: 1", "a", "1").unwrap_err().message.contains("cannot be read"));
    let deep = format!("{}{}", "[".repeat(64), "]".repeat(64));
    assert!(set("(a: 1)", "a", &deep).unwrap_err().message.contains("deeper than 64"));
}

#[test]
fn the_examples_of_the_contract() {
    let apply = |path: &str, value: &str| {
        let text = set(CASE7, path, value).unwrap();
        (read(&text, SourceId(0)).unwrap_or_else(|m| panic!("{m:#?}")).0, text)
    };
    let (spec, text) = apply("learn.cutoff", "0.1");
    assert_eq!(spec.learn.cutoff.unwrap().value, 0.1);
    assert_eq!(text.replace("(cutoff: 0.1)", "(cutoff: 0.05)"), CASE7);
    let DataSpec::Synthetic(record) = &apply("data.0.noise", "Additive(0.02)").0.data[0] else { panic!() };
    assert!(matches!(&record.noise, NoiseSpec::Additive(s) if s.value == 0.02));
    assert!(apply("contacts", "[]").0.contacts.is_empty());
    assert_eq!(apply("unknown.y1.candidates", "[\"1\"]").0.unknown[0].1.candidates.len(), 1);
    assert_eq!(apply("inertia.y1", "\"m1\"").0.inertia[0].1.value, "m1");
    assert!(apply("data.0.sensors.x1.offset", "Find(start: 0.0, within: (-1.0, 1.0))").0.data.len() == 1);
    let DataSpec::Synthetic(record) = &apply("data.0.measure", "[\"x1\"]").0.data[0] else { panic!() };
    assert_eq!(record.measure.as_ref().unwrap().len(), 1);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn nothing_panics(
        text in "\\PC{0,30}|[(){}\\[\\]:,\"'r#a1/*\\\\ \n-]{0,40}", path in "\\PC{0,12}|[a1.\"]{0,8}", value in "\\PC{0,12}|[(){}1,\"/*# a]{0,8}"
    ) {
        let _ = set(&text, &path, &value);
    }

    #[test]
    fn what_is_set_is_read(which in 0..3_usize, number in 1e-6..1e6_f64, name in "[a-z][a-z0-9]{0,5}") {
        let text = [CASE7, FRAME, FORMS][which];
        let with = |path: &str, value: &str| {
            let text = set(text, path, value).unwrap();
            read(&text, SourceId(0)).unwrap_or_else(|m| panic!("{path}={value}: {m:#?}\n{text}")).0
        };
        let spec = with("learn.cutoff", &format!("{number:?}"));
        prop_assert_eq!(spec.learn.cutoff.unwrap().value, number);
        let spec = with(&format!("constants.{name}"), &format!("({number:?}, \"m\")"));
        prop_assert!(spec.constants.iter().any(|(key, _)| key.value == name));
        let spec = with(&format!("data.0.constants.{name}"), &format!("{number:?}"));
        let constants = match &spec.data[0] { DataSpec::Csv(r) => &r.constants, DataSpec::Synthetic(r) => &r.constants };
        prop_assert!(constants.iter().any(|(key, _)| key.value == name));
        let spec = with("data.0.start.x", &format!("{number:?}"));
        let start = match &spec.data[0] { DataSpec::Csv(r) => &r.start, DataSpec::Synthetic(r) => &r.start };
        prop_assert!(start.iter().any(|(key, v)| key.value == "x" && v.value == number));
    }

    #[test]
    fn comments_survive(path in "(title|contacts|learn\\.[a-z]{3}|data\\.0\\.[a-z]{4}|unknown\\.y[12])") {
        let text = set(CASE7, &path, "1").unwrap();
        let inside = path.starts_with("unknown");
        for comment in CASE7.lines().filter_map(|line| line.split_once("//")).map(|(_, c)| c) {
            prop_assert!(inside || text.contains(comment), "{} lost {}", path, comment);
        }
    }
}
