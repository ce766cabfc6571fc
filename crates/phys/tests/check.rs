//! Specs that read well and mean nothing: each mistake by its words and its help.

use phisindy_phys::unit::Unit;
use phisindy_phys::{Law, Model, SourceId, check, spec};

/// A good spec; each row breaks one thing.
const GOOD: &str = r#"(
    constants: { "k": (1.0, "1/s^2"), "A": (1.0, "m"), "W": (1.0, "rad/s") },
    states: { "x": "m", "y": "m/s" }, inputs: { "u": "m", "du": "m/s" },
    known: { "x": "y", "y": "-k*(x-u)" },
    unknown: { "y": (factor: "-sgn(y)", candidates: ["1"]) },
    contacts: ["y"],
    data: [ Synthetic(truth: { "y": "0" }, start: { "x": 1.0 }, duration: 10.0, step: 0.01,
        inputs: { "u": Formula("A*cos(W*t)") }, derive: { "du": Derivative("u") }, noise: Relative(0.1)) ],
)"#;

/// Message and help of every error.
fn mistakes(text: &str) -> Vec<String> {
    let (spec, _) = spec::read(text, SourceId(0)).unwrap_or_else(|e| panic!("{text}: {e:#?}"));
    let all = check(&spec, SourceId(0)).err().unwrap_or_default();
    all.iter().filter(|d| d.is_error()).map(|d| format!("{} | {}", d.message, d.help.join(" | "))).collect()
}

#[test]
fn what_is_said_of_a_column_that_a_record_does_not_have_is_a_warning() {
    let warnings = |text: &str| {
        let (spec, _) = spec::read(text, SourceId(0)).expect("a spec");
        let (_, said) = check(&spec, SourceId(0)).expect("a case");
        said.iter().map(|d| d.message.clone()).collect::<Vec<_>>()
    };
    let noise = "noise: Relative(0.1)";
    let of_x = GOOD.replace(noise, r#"noise: Sensor({ "x": (0.1, "mm") }), measure: ["y"]"#);
    assert_eq!(warnings(&of_x), ["this record has no column of `x`, so its noise does nothing"]);
    assert_eq!(warnings(&of_x.replace(r#"measure: ["y"]"#, r#"measure: ["x"]"#)), [""; 0]);
    let synthetic = &GOOD[GOOD.find("Synthetic").unwrap()..GOOD.rfind(" ]").unwrap()];
    let file = GOOD.replace(
        synthetic,
        r#"Csv(path: "a.csv", time: "t", columns: { "x": "x", "u": "u", "du": "du" }, sensors: { "y": (gain: 2.0), "x": (gain: 2.0) })"#,
    );
    let unused = |w: &String| w.contains("this record has no column of");
    let said: Vec<String> = warnings(&file).into_iter().filter(unused).collect();
    assert_eq!(said, ["this record has no column of `y`, so its sensor does nothing"]);
}

#[test]
fn each_mistake_is_told_with_what_to_do() {
    assert_eq!(mistakes(GOOD), [""; 0]);
    let long = format!("constants: {{ \"{}\": 1.0, ", "a".repeat(101));
    let moving = r#""k": (value: 1.0, unit: "1/s^2", within: (0.5, 2.0))"#;
    let noise = "noise: Relative(0.1)";
    let and = |more: &str| format!("{noise}, {more}");
    for (from, to, due) in [
        (
            "constants: { ",
            r#"constants: { "tan": 1.0, "#.to_owned(),
            "`tan` has a meaning of its own and cannot name a constant | give it another name",
        ),
        ("constants: { ", long, "a name has at most 100 letters | shorten it"),
        (
            r#"(1.0, "1/s^2")"#,
            r#"(1e308, "1/ms^2")"#.into(),
            "this number is too large in SI units | numbers go up to 1.7e308: choose a larger unit",
        ),
        (
            r#"["1"]"#,
            r#"["1", "x - x"]"#.into(),
            "this candidate is zero | delete it, or correct the expression",
        ),
        (
            r#"["1"]"#,
            r#"["1"], laws: ["viscous", "viscous"]"#.into(),
            "the same law twice | delete one of the two: no data can tell them apart",
        ),
        (
            r#"contacts: ["y"]"#,
            r#"contacts: ["y", "-y"]"#.into(),
            "the same contact twice | delete one of the two: the sign of a velocity makes no difference",
        ),
        (
            noise,
            and(r#"constants: { "N": Find(start: 1.0, within: (0.0, 2.0)) }"#),
            "`N` cannot move inside a record | declare it in the case's `constants` with `each: true`",
        ),
        (noise, and(r#"constants: { "N": MaxAbs("w") }"#), "unknown input `w` | known here: u, du"),
        (
            noise,
            and(r#"interpolate: { "w": Hold }"#),
            "unknown input in `interpolate` `w` | known here: u, du",
        ),
        (noise, and(r#"measure: ["u"]"#), "no state or output is measured, so there is nothing to fit | "),
        (
            noise,
            and(r#"measure: ["x", "z"]"#),
            "unknown state, output or input in `measure` `z` | known here: x, y, u, du",
        ),
        (
            r#"contacts: ["y"]"#,
            r#"contacts: ["y", "y^2"]"#.into(),
            "`y^2` is no velocity, so it cannot stick | a contact is a velocity or a difference of velocities",
        ),
        (
            noise,
            and(r#"sensors: { "w": (offset: 1.0) }"#),
            "unknown column in `sensors` `w` | known here: x, y, u, du",
        ),
        (
            noise,
            r#"noise: Sensor({ "w": 0.1 })"#.into(),
            "unknown column in `noise` `w` | known here: x, y, u, du",
        ),
        (
            noise,
            and(r#"sensors: { "x": (lowpass: (order: 11, cutoff: (9.0, "Hz"))) }"#),
            "a filter has at most 10 poles | give the order of the sensor's data sheet",
        ),
        (
            noise,
            and(r#"sensors: { "x": (lowpass: (order: 2, cutoff: (0.0, "Hz"))) }"#),
            "a cutoff is greater than zero | give the frequency at which the filter halves the power",
        ),
        (
            r#""du": Derivative("u")"#,
            r#""du": Derivative("u"), "dw": Derivative("u")"#.into(),
            "unknown input in `derive` `dw` | did you mean `du`?",
        ),
        (
            r#""u": Formula("#,
            r#""w": Formula("1"), "u": Formula("#.into(),
            "unknown input `w` | known here: u, du",
        ),
        (
            r#"derive: { "du": Derivative("u") }, "#,
            String::new(),
            "input `du` has no excitation in this record | add `inputs: { \"du\": Formula(\"...\") }`",
        ),
    ] {
        assert_eq!(GOOD.matches(from).count(), 1, "{from} must stand once");
        let said = mistakes(&GOOD.replace(from, &to));
        assert!(said.len() == 1 && said[0].starts_with(due), "{to}: {said:#?}");
    }
    let said = mistakes(&GOOD.replace(r#"Derivative("u")"#, r#"Derivative("du")"#));
    assert!(said[0].starts_with("`du` cannot be its own derivative"), "{said:#?}");
    let said = mistakes(&GOOD.replace(r#"Derivative("u")"#, r#"Derivative("w")"#));
    assert!(said[0].starts_with("unknown input `w`"), "{said:#?}");
    // A constant of a record is one number: of fixed constants, not of one that moves.
    let own = |with: &str| GOOD.replace(noise, &and(&format!(r#"constants: {{ "N": "{with}" }}"#)));
    assert_eq!(mistakes(&own("2*3 + W")), [""; 0]);
    let said = mistakes(&own("2*k").replace(r#""k": (1.0, "1/s^2")"#, moving));
    assert!(
        said[0].starts_with("`N` must be a number in each record | use numbers and fixed constants only"),
        "{said:#?}"
    );
    // A sensor's number may be a constant of the case.
    let named = GOOD
        .replace(noise, &and(r#"sensors: { "x": (gain: "g") }"#))
        .replace("constants: { \"k\"", "constants: { \"g\": 1.5, \"k\"");
    let (spec, _) = spec::read(&named, SourceId(0)).expect("a spec");
    let (case, _) = check(&spec, SourceId(0)).expect("a case");
    assert_eq!(case.records[0].sensors[0].gain.start, 1.5);
    // What one record has the other one needs.
    let one = &GOOD[GOOD.find("Synthetic").unwrap()..GOOD.rfind(" ]").unwrap()];
    let two =
        GOOD.replace(one, &format!("{}, {one}", one.replace(noise, &and(r#"constants: { "N": 2.0 }"#))));
    assert_eq!(
        mistakes(&two),
        ["this record has no value for constant `N` | add `constants: { \"N\": ... }` to it"]
    );
}

#[test]
fn a_law_has_each_name_once() {
    let law = |more: &str| {
        Law::read(&format!(
            r#"(name: "Drag", roles: {{ "v": "m/s" }}, parameters: {{ "d": (unit: "N*s^2/m^2", within: (0.0, 10.0)){more} }}, force: "d*v*|v|")"#
        ))
    };
    assert!(law("").is_ok());
    let said = law(r#", "d": (unit: "N", within: (0.0, 1.0))"#).unwrap_err();
    assert!(said.to_string().contains("`d` stands here twice"), "{said}");
}

#[test]
fn each_state_has_a_rate() {
    let said = Model::build(&["x", "v"], &[], &[], &["v"]).err();
    assert_eq!(said.as_deref(), Some("2 states but 1 rates"));
}

#[test]
fn powers_of_units_that_are_none_are_told() {
    for (text, due) in [("m^(0/0)", "this power is not a number"), ("m^(1/2", "this bracket is never closed")]
    {
        assert_eq!(Unit::parse(text).unwrap_err().to_string(), due);
    }
}

#[test]
fn times_and_inertias_have_units_of_their_own() {
    let spec = |time: &str, inertia: &str| {
        format!(
            r#"(constants: {{ "m": (1.0, "kg"), "J": (1.0, "kg*m^2"), "d": (1.0, "N*s/m"), "k": (1.0, "N/m"), "n": 2.0 }}, states: {{ "x": "m", "v": "m/s" }},
            known: {{ "x": "v", "v": "-k*x/m" }}, inertia: {{ "v": "{inertia}" }},
            data: [Csv(path: "a.csv", time: ("t", "{time}"), columns: {{ "x": "x" }})])"#
        )
    };
    for good in ["s", "ms", "us", "min"] {
        assert_eq!(mistakes(&spec(good, "m")), [""; 0], "{good}");
    }
    for none in ["kg", "Hz", "deg", "%", "m/s"] {
        let said = mistakes(&spec(none, "m"));
        assert!(said.len() == 1 && said[0].starts_with(&format!("`{none}` is no unit of time")), "{said:?}");
    }
    // A number without a unit may stand for any.
    for good in ["m", "n*m"] {
        assert_eq!(mistakes(&spec("s", good)), [""; 0], "{good}");
    }
    for wrong in ["d", "J", "m*x", "0", "-2.5"] {
        let said = mistakes(&spec("s", wrong));
        assert!(said.len() == 1 && said[0].contains("inertia"), "{wrong}: {said:?}");
    }
}
