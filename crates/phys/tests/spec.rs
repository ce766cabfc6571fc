//! Specs as texts: the contract's examples read, places are exact, and every mistake of form is named.

use phisindy_phys::spec::{
    ConstantSpec, DataSpec, DeriveSpec, InputSpec, Method, NoiseSpec, Optimiser, Role, SegmentsSpec,
    SelectionSpec, SensorValue, Spec, Text, read,
};
use phisindy_phys::{Diagnostic, SourceId};
use phisindy_signal::Interpolation;
use proptest::prelude::*;
use std::path::Path;

const CASE7: &str = include_str!("spec/case7.ron");
const FRAME: &str = include_str!("spec/frame_250g.ron");
const FORMS: &str = include_str!("spec/forms.ron");

fn good(text: &str) -> Spec {
    match read(text, SourceId(0)) {
        Ok((spec, warnings)) => {
            assert_eq!(warnings, []);
            spec
        }
        Err(mistakes) => panic!("{mistakes:#?}"),
    }
}

fn find<'a, T>(pairs: &'a [(Text, T)], name: &str) -> &'a T {
    &pairs.iter().find(|(key, _)| key.value == name).expect(name).1
}

#[test]
fn case_7_of_the_contract() {
    let spec = good(CASE7);
    assert_eq!(spec.title.unwrap().value, "Case 7: Coulomb and Dieterich-Ruina on two masses");
    assert_eq!(spec.constants.len(), 11);
    let ConstantSpec::Number { value, unit: Some(unit) } = find(&spec.constants, "c1") else { panic!() };
    assert_eq!((value.value, unit.value.as_str()), (0.1, "N*s/m"));
    let ConstantSpec::Number { value, unit: None } = find(&spec.constants, "c") else { panic!() };
    assert_eq!(&CASE7[value.span.range()], "0.022");
    let states: Vec<&str> = spec.states.iter().map(|(name, _)| name.value.as_str()).collect();
    assert_eq!(states, ["x1", "x2", "y1", "y2"]);
    assert!(spec.inputs.is_empty() && spec.inertia.is_empty());
    let unknown = find(&spec.unknown, "y1");
    assert_eq!(unknown.factor.as_ref().unwrap().value, "-sgn(y1)");
    assert_eq!(unknown.candidates.len(), 9);
    assert_eq!(spec.contacts.len(), 2);
    let [DataSpec::Synthetic(record)] = spec.data.as_slice() else { panic!() };
    assert!(matches!(&record.noise, NoiseSpec::Relative(s) if s.value == 0.1));
    assert_eq!(
        (record.duration.value, record.step.value, record.seed, record.role),
        (50.0, 0.01, Some(42), Role::Fit)
    );
    assert!(record.measure.is_none() && record.start.len() == 4);
    assert_eq!(find(&record.truth, "y1").value, "-0.3*sgn(y1)");
    assert_eq!(spec.learn.cutoff.unwrap().value, 0.05);
}

#[test]
fn the_frame_of_the_contract() {
    let spec = good(FRAME);
    let ConstantSpec::Movable(k) = find(&spec.constants, "k") else { panic!() };
    assert_eq!((k.value.value, k.within.0.value, k.within.1.value, k.each), (1191.0, 1000.0, 1300.0, false));
    assert_eq!(find(&spec.inertia, "v").value, "m");
    let [DataSpec::Csv(first), DataSpec::Csv(second)] = spec.data.as_slice() else { panic!() };
    assert_eq!((first.role, second.role), (Role::Fit, Role::Validate));
    assert_eq!((first.time.header.value.as_str(), first.time.unit.is_none()), ("time_s", true));
    assert_eq!(find(&first.columns, "x").unit.as_ref().unwrap().value, "m");
    let DeriveSpec::Derivative(of, _) = find(&first.derive, "du");
    assert_eq!(of.value, "u");
    let Some(SensorValue::Find(offset)) = &find(&first.sensors, "x").offset else { panic!() };
    assert_eq!((offset.start.value, offset.within.0.value), (0.0, -1e-3));
    assert_eq!(second.window.as_ref().map(|(a, b)| (a.value, b.value)), Some((5.0, 10.0)));
}

#[test]
fn every_other_form() {
    let spec = good(FORMS);
    assert_eq!(spec.title.unwrap().value, "say \"hi\"");
    assert!(matches!(find(&spec.constants, "w"), ConstantSpec::Expression(e) if e.value == "sqrt(k/m)"));
    assert!(matches!(find(&spec.constants, "V"), ConstantSpec::Find(f) if f.each && f.sigma.is_some()));
    assert!(matches!(find(&spec.constants, "F0"), ConstantSpec::MaxAbs(input) if input.value == "F"));
    assert_eq!(find(&spec.known, "x").value, "y");
    assert_eq!(spec.unknown[0].1.laws[0].value, "stribeck");
    let DataSpec::Synthetic(one) = &spec.data[0] else { panic!() };
    let InputSpec::Jonswap { gamma, omega, .. } = find(&one.inputs, "F") else { panic!() };
    assert_eq!((gamma.value, omega.0.value, omega.1.value, omega.2.value), (3.3, 0.1, 50.0, 0.1));
    assert!(matches!(find(&one.inputs, "u"), InputSpec::Formula(f) if f.value == "A*cos(W*t)"));
    assert!(matches!(find(&one.inputs, "p"), InputSpec::Multisine { count: Some(n), .. } if n.value == 40));
    assert!(matches!(find(&one.inputs, "q"), InputSpec::File { column, .. } if column.unit.is_some()));
    let NoiseSpec::Sensor(columns) = &one.noise else { panic!() };
    assert_eq!(find(columns, "x").0.value, 1e-6);
    assert!(find(columns, "u").1.is_none());
    assert_eq!(one.measure.as_ref().unwrap().len(), 2);
    let DataSpec::Csv(two) = &spec.data[1] else { panic!() };
    assert_eq!(two.time.unit.as_ref().unwrap().value, "ms");
    assert_eq!((two.separator.as_ref().unwrap().value, two.decimal.as_ref().unwrap().value), ('\t', ','));
    assert_eq!((two.header, two.decimate.as_ref().unwrap().value), (Some(true), 4));
    assert_eq!(*find(&two.interpolate, "u"), Interpolation::Cubic);
    assert!(matches!(find(&two.sensors, "x").gain, Some(SensorValue::Number(_))));
    assert!(matches!(find(&two.constants, "N"), ConstantSpec::Number { unit: Some(_), .. }));
    let learn = spec.learn;
    assert_eq!((learn.optimiser, learn.method), (Some(Optimiser::Sgd), Some(Method::Trajectory)));
    assert_eq!((learn.epochs, learn.rates), (Some(vec![10, 20]), Some(vec![0.1, 0.01])));
    assert_eq!(
        (learn.selection, learn.segments),
        (Some(SelectionSpec::Cutoff(0.1)), Some(SegmentsSpec::Count(4)))
    );
    assert_eq!(learn.horizon, Some(100));
    assert!(learn.tolerance.is_none());
}

#[test]
fn places_are_exact() {
    for text in [CASE7, FRAME] {
        let spec = good(text);
        let exact = |t: &Text| assert_eq!(&text[t.span.range()], t.value);
        let pairs = spec.states.iter().chain(&spec.inputs).chain(&spec.known).chain(&spec.inertia);
        pairs.for_each(|(name, value)| (exact(name), exact(value)).1);
        spec.constants.iter().for_each(|(name, _)| exact(name));
        spec.contacts.iter().for_each(exact);
        spec.unknown.iter().for_each(|(_, u)| u.candidates.iter().chain(&u.factor).for_each(exact));
        for (_, u) in &spec.unknown {
            assert!(text[u.span.range()].starts_with("(factor") && text[u.span.range()].ends_with("])"));
        }
    }
    let raw = "(states: {}, known: { r#\"ä\"#: r\"b\" }, data: [Csv(path: \"p\", time: \"t\", columns: {})])";
    let spec = good(raw);
    assert_eq!((&raw[spec.known[0].0.span.range()], &raw[spec.known[0].1.span.range()]), ("ä", "b"));
}

/// A small good spec; each test breaks one thing.
const SMALL: &str = r#"(
    constants: { "k": (value: 1.0, unit: "N/m", within: (0.5, 2.0)) },
    states: { "x": "m", "y": "m/s" },
    known: { "x": "y", "y": "-k*x" },
    unknown: { "y": (factor: "-sgn(y)", candidates: ["1"]) },
    data: [ Synthetic(truth: { "y": "0" }, start: { "x": 1.0 }, duration: 10.0, step: 0.01, noise: Relative(0.1)) ],
    learn: (cutoff: 0.05),
)"#;

/// What the first label marks, the message, and all help.
fn told(text: &str, diagnostic: &Diagnostic) -> (String, String) {
    let label = &diagnostic.labels[0];
    (text[label.span.range()].to_owned(), format!("{} | {}", diagnostic.message, diagnostic.help.join(" | ")))
}

#[test]
fn each_mistake_is_named() {
    good(SMALL);
    let check = |from: &str, to: &str, place: &str, message: &str| {
        assert_eq!(SMALL.matches(from).count(), 1, "{from} must stand once");
        let text = SMALL.replace(from, to);
        let mistakes = read(&text, SourceId(0)).expect_err(to);
        assert_eq!(mistakes.len(), 1, "{to}: {mistakes:#?}");
        let (marked, words) = told(&text, &mistakes[0]);
        assert_eq!(marked, place, "{words}");
        assert!(words.contains(message), "{to}: {words}");
    };
    check("\"m/s\" },", "\"m/s\" }", "", "comma before `known`");
    check("learn: (", "lern: (", "lern", "did you mean `learn`? allowed: title, constants");
    check("learn: (cutoff", "learn: (cutof", "cutof", "did you mean `cutoff`?");
    check(
        "learn: (cutoff: 0.05)",
        "learn: {\"cutoff\": 0.05}",
        "{\"cutoff\": 0.05}",
        "expected fields in round brackets",
    );
    check("\"y\": \"m/s\"", "\"x\": \"m/s\"", "x", "the key `x` stands here twice");
    check("step: 0.01,", "step: 0.01, step: 0.02,", "step", "the field `step` stands here twice");
    check("duration: 10.0, ", "", "Synthetic", "`duration` of `Synthetic` is missing");
    check("    states: { \"x\": \"m\", \"y\": \"m/s\" },\n", "", "(", "`states` of the spec is missing");
    check("10.0", "\"ten\"", "\"ten\"", "expected a number, found a text");
    check("10.0", "-10.0", "-10.0", "greater than zero");
    check("10.0", "inf", "inf", "not a finite number");
    check("10.0", "-NaN", "-NaN", "not a finite number");
    check("10.0", "1e999", "1e999", "not a finite number");
    check("10.0", "0.001", "0.01", "longer than the duration");
    check("10.0", "1e12", "0.01", "too many");
    check("0.01", "0.0", "0.0", "greater than zero");
    check("Relative(0.1)", "Relative(-0.1)", "-0.1", "zero or more");
    check("Relative(0.1)", "Gaussian(0.1)", "Gaussian", "allowed: Relative, Additive, Sensor");
    check("Relative(0.1)", "Relative", "Relative", "expected a kind of noise");
    check("Relative(0.1)", "Relative(0.1, 2.0)", "Relative(0.1, 2.0)", "takes one number");
    check("Relative(0.1)", "Sensor({\"x\": (-1e-6, \"m\")})", "-1e-6", "zero or more");
    check("Relative(0.1)", "Relative(0.1), window: (2.0, 1.0)", "(2.0, 1.0)", "2.0 is not less than 1.0");
    check("Relative(0.1)", "Relative(0.1), role: Validat", "Validat", "did you mean `Validate`");
    check("Relative(0.1)", "Relative(0.1), role: \"Fit\"", "\"Fit\"", "without quotes");
    check("Relative(0.1)", "Relative(0.1), seed: -1", "-1", "whole number");
    check("Relative(0.1)", "Relative(0.1), seed: 1.5", "1.5", "whole number");
    check("Relative(0.1)", "Relative(0.1), measure: []", "[]", "the list is empty");
    check(
        "Relative(0.1)",
        "Relative(0.1), inputs: { \"F\": Jonswap(hs: 1.0) }",
        "Jonswap",
        "`tp` of `Jonswap` is missing",
    );
    check(
        "Relative(0.1)",
        "Relative(0.1), derive: { \"u\": Integral(\"v\") }",
        "Integral",
        "allowed: Derivative",
    );
    check(
        "Relative(0.1)",
        "Relative(0.1), constants: { \"N\": Maxabs(\"F\") }",
        "Maxabs",
        "did you mean `MaxAbs`",
    );
    check("(0.5, 2.0)", "(2.0, 0.5)", "(2.0, 0.5)", "not less than");
    check("(0.5, 2.0)", "(1.5, 2.0)", "1.0", "lies outside its bounds");
    check("(0.5, 2.0)", "(0.5, 2.0), sigma: 0", "0", "greater than zero");
    check("(0.5, 2.0)", "(0.5, 2.0), each: 1", "1", "`true` or `false`");
    check("(0.5, 2.0)", "(0.5, 2.0, 3.0)", "(0.5, 2.0, 3.0)", "expected two numbers");
    check(
        "unit: \"N/m\", within: (0.5, 2.0)",
        "unit: \"N/m\"",
        "(",
        "`within` of a movable constant is missing",
    );
    check("(value: 1.0, unit: \"N/m\", within: (0.5, 2.0))", "kg", "kg", "a constant is 1.0, (1.0, \"kg\")");
    check("\"-k*x\"", "\"\"", "\"\"", "the text is empty");
    check("\"-k*x\"", "-k*x", "-k*x", "stands in quotes: \"-k*x\"");
    check("\"-k*x\"", "k", "k", "put it in quotes: \"k\"");
    check("\"-k*x\"", "2x", "2x", "not a number");
    check("\"-k*x\"", "\"-k\\n*x\"", "\\", "escapes");
    check("candidates: [\"1\"]", "candidates: []", "[]", "neither candidates, nor laws");
    check("(factor: \"-sgn(y)\", candidates: [\"1\"])", "[\"1\"]", "[\"1\"]", "expected fields");
    check("candidates: [\"1\"]", "candidates: [1]", "1", "expected a text in quotes, found a number");
    check("Synthetic(", "Simulated(", "Simulated", "allowed: Csv, Table, Synthetic");
    check("(cutoff: 0.05)", "(0.05)", "0.05", "expected a field with its name");
    check("(cutoff: 0.05)", "(epochs: [1, 2], rates: [0.1])", "[0.1]", "1 learning rates for 2 stages");
    check("(cutoff: 0.05)", "(epochs: [0])", "0", "from 1 to");
    check("(cutoff: 0.05)", "(selection: Some(Best))", "Best", "allowed: Auto, All, Cutoff(x)");
    check("(cutoff: 0.05)", "(selection: 3)", "3", "expected a selection");
    check("(cutoff: 0.05)", "(segments: 0)", "0", "from 1 to");
    check("(cutoff: 0.05)", "(segments: Many)", "Many", "allowed: Auto, Count(n)");
    check("(cutoff: 0.05)", "(segments: \"four\")", "\"four\"", "expected a number of segments");
    check("Relative(0.1)", "Relative(0.1), measure: \"x\"", "\"x\"", "expected a list");
    check("[\"1\"]", "[\"1\"], within: { \"1\": 3.0 }", "3.0", "expected bounds of a coefficient");
    let inputs = |kind: &str| format!("Relative(0.1), inputs: {{ \"F\": {kind} }}");
    let wrong = |kind: &str, place: &str, message: &str| {
        check("Relative(0.1)", &inputs(kind), place, message);
    };
    wrong("3.0", "3.0", "expected an input");
    wrong(
        "Jonswap(hs: 1.0, tp: 1.0, omega: (2.0, 1.0, 0.1))",
        "2.0, 1.0",
        "the first frequency is above the last",
    );
    wrong("Jonswap(hs: 1.0, tp: 1.0, omega: (1.0, 1e9, 1e-3))", "1e-3", "more than");
    wrong("Multisine(amplitude: 1.0, band: (0.1, 1.0), count: 1000000)", "1000000", "more than");
    wrong("Multisine(amplitude: 1.0, band: (-0.1, 1.0))", "-0.1", "a frequency is negative");
    check("Relative(0.1)", "Relative(0.1), derive: { \"u\": 3.0 }", "3.0", "expected `Derivative(\"u\")`");
}

#[test]
fn a_list_is_no_spec_and_two_marks_are_not_one() {
    let first = |text: &str| {
        let mistakes = read(text, SourceId(0)).unwrap_err();
        told(text, &mistakes[0])
    };
    let (_, words) = first("[1, 2]");
    assert!(words.contains("expected fields in round brackets"), "{words}");
    let (_, words) = first("Spec(title: \"a\")");
    assert!(words.contains("the spec's fields in round brackets, without a name"), "{words}");
    let (from, to) = (SMALL.find("Synthetic").unwrap(), SMALL.rfind(" ]").unwrap());
    let csv = |more: &str| {
        let record = format!("Csv(path: \"a.csv\", time: \"t\", columns: {{ \"x\": \"x\" }}, {more})");
        first(&[&SMALL[..from], &record, &SMALL[to..]].concat())
    };
    let (marked, words) = csv("separator: ',', decimal: ','");
    assert!(
        marked.contains(',') && words.contains("separator and decimal mark are the same"),
        "{marked} {words}"
    );
    let (marked, words) = csv("separator: \";;\"");
    assert!(marked == "\";;\"" && words.contains("one character in quotes"), "{marked} {words}");
}

#[test]
fn all_mistakes_at_once() {
    let text = SMALL
        .replace("10.0", "\"ten\"")
        .replace("(0.5, 2.0)", "(1.5, 2.0)")
        .replace("learn: (cutoff", "learn: (cutof")
        .replace("\"-k*x\"", "\"\"")
        .replace("0.01", "-1.0");
    let mistakes = read(&text, SourceId(0)).unwrap_err();
    let marked: Vec<String> = mistakes.iter().map(|m| told(&text, m).0).collect();
    assert_eq!(marked, ["1.0", "\"\"", "\"ten\"", "-1.0", "cutof"]);
}

#[test]
fn repeated_names_show_both_places() {
    let text = SMALL.replace("\"y\": \"m/s\"", "\"x\": \"m/s\"");
    let mistakes = read(&text, SourceId(0)).unwrap_err();
    let [again, first] = mistakes[0].labels.as_slice() else { panic!() };
    assert!(first.span.end < again.span.start && again.primary && !first.primary);
}

#[test]
fn hostile_texts_are_refused_quickly() {
    for text in
        ["(".repeat(100_000), "[".repeat(1 << 20), "a(".repeat(50_000), " ".repeat(9 << 20), "{".repeat(64)]
    {
        assert_eq!(read(&text, SourceId(0)).unwrap_err().len(), 1);
    }
    let with = |terms: usize| SMALL.replace("[\"1\"]", &format!("[{}]", "\"x\",".repeat(terms)));
    assert!(read(&with(1000), SourceId(0)).is_ok());
    for (terms, message) in
        [(1001, "1001 candidates are too many"), (100_000, "too many"), (1 << 20, "1 MiB")]
    {
        let mistakes = read(&with(terms), SourceId(0)).unwrap_err();
        assert!(mistakes.len() == 1 && mistakes[0].message.contains(message), "{mistakes:?}");
    }
    let many = format!("({})", "a:1,".repeat(10_000));
    assert_eq!(read(&many, SourceId(0)).unwrap_err().len(), 100);
}

#[test]
fn the_specs_of_the_project_read() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../specs");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "ron") {
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(read(&text, SourceId(0)).is_ok(), "{}: {:#?}", path.display(), read(&text, SourceId(0)));
            count += 1;
        }
    }
    assert!(count > 20);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn no_text_panics(text in "\\PC{0,60}|[(){}\\[\\]:,\"'r#a1/*\\\\ \n-]{0,60}") {
        let _ = read(&text, SourceId(0));
    }

    #[test]
    fn no_mutation_panics_and_places_stand_in_the_text(
        which in 0..3_usize, cuts in prop::collection::vec((0.0..1.0_f64, 0..12_usize, "[(){}\\[\\]:,\"'r#é1/*.-]{0,3}"), 1..4)
    ) {
        let mut text = [CASE7, FRAME, FORMS][which].to_owned();
        for (at, length, new) in cuts {
            let floor = |mut i: usize| { while !text.is_char_boundary(i) { i -= 1 } i };
            let start = floor((at * text.len() as f64) as usize);
            let end = floor((start + length).min(text.len()));
            text.replace_range(start..end, &new);
        }
        if let Err(mistakes) = read(&text, SourceId(0)) {
            prop_assert!(!mistakes.is_empty());
            for label in mistakes.iter().flat_map(|m| &m.labels) {
                prop_assert!(text.get(label.span.range()).is_some(), "{:?}", label);
            }
        }
    }
}
