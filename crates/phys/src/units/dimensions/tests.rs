//! Specs that fit, specs that do not and where, and expressions made at random.

use super::*;
use crate::system::check::check;
use crate::text::spec;
use proptest::prelude::*;

/// The mistakes of a spec with some of its parts replaced: the text they point at, and the message.
fn mistakes(text: &str) -> Vec<(String, String)> {
    let (spec, _) = spec::read(text, SourceId(0)).unwrap_or_else(|e| panic!("{e:?}\n{text}"));
    let found = check(&spec, SourceId(0)).err().unwrap_or_default();
    let errors = found.iter().filter(|d| d.is_error());
    errors.map(|d| (text[d.labels[0].span.range()].to_owned(), d.message.clone())).collect()
}

fn fits(text: &str) {
    assert_eq!(mistakes(text), [], "{text}");
}

/// A mass on a spring.
fn mass(constants: &str, rate: &str, unknown: &str) -> String {
    format!(
        r#"(constants: {{ "m": (1.0, "kg"), "k": (2.0, "N/m"), "V": (3.0, "mm/s"), "W": (4.0, "rad/s"), {constants} }},
            states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "F": "kN" }}, known: {{ "x": "v", "v": "{rate}" }},
            unknown: {{ "v": {unknown} }}, data: [Csv(path: "a.csv", time: "t", columns: {{ "x": "x", "F": "F" }})])"#
    )
}

const NOTHING: &str = r#"(factor: "-1", candidates: ["1"])"#;

/// What is said of one rate, with the place.
fn rate(constants: &str, rate: &str) -> Vec<(String, String)> {
    mistakes(&mass(constants, rate, NOTHING))
}

/// The units of the coefficients: with the factor, of each candidate.
fn units(constants: &str, inertia: &str, factor: &str, candidates: &[&str]) -> Vec<String> {
    let unknown = format!("(factor: \"{factor}\", candidates: {candidates:?})");
    let text = mass(constants, "(F - k*x)/m", &unknown);
    let text = text.replace("data: [", &format!("inertia: {{ {inertia} }}, data: ["));
    let (spec, _) = spec::read(&text, SourceId(0)).unwrap_or_else(|e| panic!("{e:?}\n{text}"));
    let (case, _) = check(&spec, SourceId(0)).unwrap_or_else(|e| panic!("{e:?}\n{text}"));
    let shown = |unit: Option<Dimension>| unit.map_or("-".to_owned(), |u| u.to_string());
    let both = case.system.terms.iter().map(|t| match t.force {
        Some(force) => format!("{} -> {force}", shown(t.unit)),
        None => shown(t.unit),
    });
    both.collect()
}

#[test]
fn every_operation_has_its_rule() {
    for good in [
        "(F - k*x)/m",
        "-W^2*x",
        "V*W*cos(W*t + 0.5) - k/m*x*tanh(v/V)",
        "sqrt(k/m)*v - sqrt(k*k)*|x|/m + v^2/x*sgn(x)",
        "min(F, k*x)/m + max(W*v, k/m*pos(x)) - step(t)*W*v",
        "k*dead(x, 0.1)/m - k*dead(x, V/W)/m",
        "W*V*exp(-(v/V)^2) + W*v*ln(1 + |v|/V)",
        "(k*x/F)^(v/V)*F/m",
        "(x^3)^(1/3)*W^2 + W^(6/3)*x",
        "9.81 + 2*x + 3*v - 0.3*sgn(v)",
        "pi*x - F/m",
        "cos(2*t)*F/m + F/m*sin(3*x/0.5)",
        "0",
    ] {
        assert_eq!(rate("", good), [], "{good}");
    }
    let wrong = |text: &str, place: &str, message: &str| {
        let found = rate("", text);
        assert_eq!(found.len(), 1, "{text}: {found:?}");
        assert_eq!((found[0].0.as_str(), found[0].1.as_str()), (place, message), "{text}");
    };
    wrong("(F - (k*v))/m", "(k*v)", "N and N/s cannot be subtracted");
    wrong("F/m + W*x*(1 + v/V)", "W*x*(1 + v/V)", "m/s^2 and m/s cannot be added");
    wrong("F/m*cos(t)", "t", "`cos` takes a plain number, not s");
    wrong("F/m*ln(|v|)", "|v|", "`ln` takes a plain number, not m/s");
    wrong("F/m + min(F, x)/m", "x", "N and m cannot be compared by `min`");
    wrong("k*dead(x, v)/m", "v", "m and m/s cannot be compared by `dead`");
    wrong("F/m*(v/V)^x", "x", "an exponent is a plain number, not m");
    wrong("x^(v/V)", "x", "what is raised to a power that varies is a plain number, not m");
    wrong("F", "F", "`v` changes in m/s^2, but its rate is in N");
    wrong("x^0.37*W^2", "x^0.37*W^2", "`v` changes in m/s^2, but its rate is in m^0.37*s^-2");
    wrong("v", "v", "`v` changes in m/s^2, but its rate is in m/s");
    wrong("sgn(v)", "sgn(v)", "`v` changes in m/s^2, but its rate is a plain number");
    wrong("F/m + tanh(v/V)", "tanh(v/V)", "m/s^2 and a plain number cannot be added");
}

#[test]
fn all_mistakes_come_at_once() {
    let found = rate("\"w\": \"sqrt(k/m) + k\"", "F + cos(t)*sin(x)");
    let places: Vec<&str> = found.iter().map(|(place, _)| place.as_str()).collect();
    assert_eq!(places, ["k", "t", "x", "cos(t)*sin(x)"]);
}

#[test]
fn constants_without_a_unit_take_what_fits() {
    for (constants, text) in [
        ("\"c\": 0.022", "W*v*ln(c + V/|v|)"),
        ("\"a\": 1.0, \"b\": Find(start: 1.0, within: (0.0, 2.0))", "a*x + b*v"),
        // One number for two things: its units contradict each other, but it states none.
        ("\"a\": 1.0", "a*x + a*v"),
        ("\"a\": (1.0, \"\")", "a + cos(a)*F/m"),
        // A half of something: any unit.
        ("\"a\": \"2*k\", \"b\": \"a/m\"", "b*x + a*v"),
        ("\"n\": 1.5", "|v/V|^n*F/m + |v|^n*|x|^(1-n)*W^(3/2-0.5+1)*1"),
        // The unit of a power that is to be found comes with it.
        ("\"n\": Find(start: 1.5, within: (1.0, 2.0))", "|v|^n*W"),
    ] {
        assert_eq!(rate(constants, text), [], "{text}");
    }
    // A unit that is stated counts, behind a definition too.
    let found = rate("\"a\": \"k*1.0\", \"w\": \"sqrt(k/m)\"", "w*x + a*v");
    assert_eq!(found[0].1, "`v` changes in m/s^2, but its rate is in m/s", "{found:?}");
    let found = rate("\"n\": (2.0, \"m\")", "|v|^n");
    assert_eq!(found[0].1, "an exponent is a plain number, not m", "{found:?}");
    // A power that is a constant counts with its number.
    assert_eq!(rate("\"n\": 2, \"p\": \"n/4\"", "(v*v)^p*v^(n-1)/(V*t)^(n/2)"), []);
}

#[test]
fn angles_are_plain_numbers() {
    fits(
        r#"(constants: { "gl": (30.0, "1/s^2"), "r": (0.1, "m"), "J": (1.0, "kg*m^2"), "c": (1.0, "N*m*s/rad"), "k": (1.0, "N/m"), "W": (60.0, "rpm") },
            states: { "a": "deg", "w": "rad/s" }, known: { "a": "w", "w": "gl*sin(a) - (c*w + k*r*a*r)/J + gl*cos(W*t)" },
            contacts: ["w"], data: [Csv(path: "a.csv", time: "t", columns: { "a": "a" })])"#,
    );
}

#[test]
fn states_without_units() {
    let text = |known: &str| {
        format!(
            r#"(constants: {{ "m": (1.0, "kg"), "k": (2.0, "N/m") }}, states: {{ "x": "", "v": "" }}, known: {{ "x": "v", "v": "{known}" }},
                data: [Csv(path: "a.csv", time: "t", columns: {{ "x": "x" }})])"#
        )
    };
    fits(&text("-x - v + cos(t)"));
    // What is stated counts.
    assert_eq!(
        mistakes(&text("-x + v*(k + m)")),
        [("m".to_owned(), "N/m and kg cannot be added".to_owned())]
    );
}

#[test]
fn records_are_checked_too() {
    let text = |more: &str, truth: &str| {
        format!(
            r#"(constants: {{ "m": (1.0, "kg"), "k": (2.0, "N/m") }}, states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "u": "m", "du": "m/s" }},
                known: {{ "x": "v", "v": "-k/m*(x - u) - N*sgn(v - du)/m" }},
                data: [Synthetic({more}, derive: {{ "du": Derivative("u") }}, truth: {{ "v": "{truth}" }}, start: {{}}, duration: 1.0, step: 0.1),
                       Synthetic(inputs: {{ "u": Formula("sin(3*t)*2") }}, constants: {{ "N": (1.0, "N") }}, derive: {{ "du": Derivative("u") }},
                           truth: {{}}, start: {{}}, duration: 1.0, step: 0.1)])"#
        )
    };
    let load = r#"constants: { "N": (1.0, "N") }, inputs: { "u": Formula("2*t") }"#;
    let said = |more: &str, truth: &str| {
        let mut found = mistakes(&text(more, truth));
        assert!(found.len() < 2, "{found:?}");
        found.pop().map_or(String::new(), |(place, message)| format!("{place}: {message}"))
    };
    assert_eq!(said(load, "-0.1*N*sgn(v) - N/m"), "");
    assert_eq!(
        said(load, "-N*sgn(v)"),
        "-N*sgn(v): `v` changes in m/s^2, but the truth's part of it is in N"
    );
    let kilograms = load.replace("(1.0, \"N\")", "(1.0, \"kg\")");
    assert_eq!(said(&kilograms, "0"), "N: `N` is in N here and in kg elsewhere");
    assert_eq!(said(&load.replace("2*t", "N*sin(t/2)/k"), "0"), "");
    assert_eq!(said(&load.replace("2*t", "t"), "0"), "t: input `u` is in m, but its formula is in s");
    let sensor = |part: &str| said(&format!("{load}, sensors: {{ \"x\": ({part}) }}"), "0");
    assert_eq!(sensor(r#"offset: Find(start: 0.0, unit: "mm", within: (-1.0, 1.0)), gain: 1.01"#), "");
    assert_eq!(
        sensor(r#"delay: Find(start: 0.0, unit: "mm", within: (-1.0, 1.0))"#),
        "mm: the delay of `x` is in s, not in m"
    );
    assert_eq!(
        said(&format!("{load}, noise: Sensor({{\"x\": (1e-6, \"m/s\")}})"), "0"),
        "m/s: the noise of `x` is in m, not in m/s"
    );
    let wrong = text(load, "0").replace(r#""du": "m/s""#, r#""du": "m""#).replace("v - du", "v");
    assert_eq!(mistakes(&wrong)[0].1, "the derivative of `u` is in m/s, but `du` is in m");
}

#[test]
fn a_constant_that_a_sensor_names_has_the_unit_of_its_place() {
    let constants = r#""f": (50.0, "Hz"), "T": (2.0, "ms"), "n": 3.0"#;
    let said = |part: &str| {
        let sensor = format!("\"F\": \"F\" }}, sensors: {{ \"x\": ({part}) }}");
        let mut found = mistakes(&mass(constants, "(F - k*x)/m", NOTHING).replace("\"F\": \"F\" }", &sensor));
        assert!(found.len() < 2, "{found:?}");
        found.pop().map_or(String::new(), |(place, message)| format!("{place}: {message}"))
    };
    assert_eq!(said(r#"delay: "T", gain: "n", offset: 0.1, lowpass: (order: 1, cutoff: "f")"#), "");
    assert_eq!(said(r#"delay: "k""#), "k: the delay of `x` is in s, but `k` is in N/m");
    assert_eq!(said(r#"gain: "k""#), "k: the gain of `x` is a plain number, but `k` is in N/m");
    assert_eq!(said(r#"offset: "T""#), "T: the offset of `x` is in m, but `T` is in s");
    let cutoff = |name: &str| said(&format!(r#"highpass: (order: 1, cutoff: "{name}")"#));
    assert_eq!(cutoff("k"), "k: a cutoff is a frequency in Hz, but `k` is in N/m");
    assert_eq!(cutoff("W"), "W: a cutoff is a frequency in Hz, but `W` is in rad/s");
}

#[test]
fn coefficients_have_the_units_that_follow() {
    let candidates = ["1", "x", "v", "x^2", "ln(|v|/V)", "2*x", "1 + x/0.1", "cos(3*t)"];
    assert_eq!(
        units("", "", "-sgn(v)", &candidates),
        ["m/s^2", "1/s^2", "1/s", "1/(m*s^2)", "m/s^2", "1/s^2", "1/s^2", "m/s^2"]
    );
    assert_eq!(
        units("", r#""v": "m""#, "-sgn(v)/m", &candidates[..5]),
        ["N", "N/m", "N*s/m", "N/m^2", "N"],
        "with the inertia in the factor"
    );
    assert_eq!(
        units("", r#""v": "m""#, "-sgn(v)", &["1", "x", "v/m"]),
        ["m/s^2 -> N", "1/s^2 -> N/m", "N*s/m"],
        "the coefficient is a rate, unless the candidate holds the inertia"
    );
    assert_eq!(units(r#""N": (2.0, "N")"#, "", "-N*sgn(v)/m", &["1", "x"]), ["1", "1/m"]);
}

#[test]
fn units_that_are_not_stated_follow_from_the_rest() {
    // eps stands beside a speed; q is alone; p is both, so nothing is known of it.
    let one = r#""eps": 1e-6, "q": 3.0"#;
    assert_eq!(units(one, "", "-1", &["|v| + eps", "eps", "q*x", "1"]), ["1/s", "1/s", "-", "m/s^2"]);
    let two = r#""p": 1.0"#;
    assert_eq!(units(two, "", "-1", &["x + p", "v + p", "p", "x"]), ["1/s^2", "1/s", "-", "1/s^2"]);
}

#[test]
fn help_names_the_constant_that_is_missing() {
    let help = |text: &str| {
        let text = mass("\"M\": (2.0, \"kg\")", text, NOTHING);
        let (spec, _) = spec::read(&text, SourceId(0)).expect("well formed");
        let found = check(&spec, SourceId(0)).expect_err("a mistake");
        found.iter().find(|d| d.is_error()).expect("an error").help.join("")
    };
    assert_eq!(help("F"), "is a division by `m` or `M` missing here?");
    assert_eq!(help("V"), "is a factor `W` missing here?");
    assert_eq!(help("F/m*cos(t)"), "is a factor `W` missing here?");
    assert_eq!(help("F/m*ln(x*x)"), "divide by a reference in the same unit, as in `ln(|v|/v0)`");
    assert!(help("W*W*x*x").starts_with("a constant in 1/m as a factor would make it fit"));
}

/// Powers of kg, m, s.
type Powers = [i8; 3];

/// An expression of these powers, in which every name is used once.
#[derive(Clone, Debug)]
enum Made {
    Leaf(Powers),
    Sum(&'static str, Box<Made>, Box<Made>),
    Product(Box<Made>, Box<Made>),
    Quotient(Box<Made>, Box<Made>),
    Square(Box<Made>),
    Root(Box<Made>),
    Function(&'static str, Box<Made>),
    Kept(&'static str, Box<Made>),
}

/// Expressions of given powers, so deep.
fn made(powers: Powers, depth: u32) -> BoxedStrategy<Made> {
    let leaf = Just(Made::Leaf(powers)).boxed();
    if depth == 0 {
        return leaf;
    }
    let boxed = move |powers: Powers| made(powers, depth - 1).prop_map(Box::new);
    let split = proptest::array::uniform3(-2_i8..=2);
    let other = move |with: fn(i8, i8) -> i8, a: Powers| std::array::from_fn(|k| with(powers[k], a[k]));
    let mut all = vec![
        leaf,
        (
            prop_oneof![Just("+"), Just("-"), Just("min"), Just("max"), Just("dead")],
            boxed(powers),
            boxed(powers),
        )
            .prop_map(|(op, a, b)| Made::Sum(op, a, b))
            .boxed(),
        split
            .clone()
            .prop_flat_map(move |a| (boxed(a), boxed(other(|p, a| p - a, a))))
            .prop_map(|(a, b)| Made::Product(a, b))
            .boxed(),
        split
            .prop_flat_map(move |a| (boxed(other(|p, a| p + a, a)), boxed(a)))
            .prop_map(|(a, b)| Made::Quotient(a, b))
            .boxed(),
        boxed(powers.map(|p| 2 * p)).prop_map(Made::Root).boxed(),
        (prop_oneof![Just("-"), Just("abs"), Just("pos")], boxed(powers))
            .prop_map(|(f, a)| Made::Kept(f, a))
            .boxed(),
    ];
    if powers.iter().all(|p| p % 2 == 0) {
        all.push(boxed(powers.map(|p| p / 2)).prop_map(Made::Square).boxed());
    }
    if powers == [0; 3] {
        let functions = prop_oneof![
            Just("ln"),
            Just("exp"),
            Just("sin"),
            Just("cos"),
            Just("tan"),
            Just("tanh"),
            Just("atan")
        ];
        all.push((functions, boxed(powers)).prop_map(|(f, a)| Made::Function(f, a)).boxed());
    }
    proptest::strategy::Union::new(all).boxed()
}

impl Made {
    /// The text, and the powers of the names `q0`, `q1`, ... in it.
    fn written(&self, leaves: &mut Vec<Powers>) -> String {
        match self {
            Made::Leaf(powers) => {
                leaves.push(*powers);
                format!("q{}", leaves.len() - 1)
            }
            Made::Sum(op @ ("+" | "-"), a, b) => {
                format!("({} {op} {})", a.written(leaves), b.written(leaves))
            }
            Made::Sum(op, a, b) => format!("{op}({}, {})", a.written(leaves), b.written(leaves)),
            Made::Product(a, b) => format!("({})*({})", a.written(leaves), b.written(leaves)),
            Made::Quotient(a, b) => format!("({})/({})", a.written(leaves), b.written(leaves)),
            Made::Square(a) => format!("({})^2", a.written(leaves)),
            Made::Root(a) => format!("sqrt({})", a.written(leaves)),
            Made::Function(f, a) | Made::Kept(f, a) => format!("({f}({}))", a.written(leaves)),
        }
    }
}

/// Whether an expression of names with these powers can measure `due`; names without powers have an unknown
/// unit.
fn consistent(text: &str, leaves: &[Option<Powers>], due: Powers) -> bool {
    let form = |p: &Powers| Form {
        base: [f64::from(p[0]), f64::from(p[1]), f64::from(p[2]), 0.0, 0.0],
        unknown: vec![],
    };
    let (mut unknowns, mut conflicts) = (Unknowns::default(), vec![]);
    let quantities: Vec<Quantity> = leaves
        .iter()
        .map(|p| Quantity::varying(Measure::Fixed(p.as_ref().map_or_else(|| unknowns.add(), form))))
        .collect();
    let names = |name: &str| Some(quantities[name[1..].parse::<usize>().expect("an index")].clone());
    let ast = parse(text).expect("an expression");
    let loose = |_: &str| [Measure::Loose(None), Measure::Loose(None)];
    let found = infer(&ast, names, (&Measure::Loose(None), &loose), &mut unknowns, &mut conflicts);
    let fits = match &found.measure {
        Measure::Fixed(found) => unknowns.equate(found, &form(&due)),
        Measure::Loose(_) => true,
    };
    conflicts.is_empty() && fits
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// What is made to fit fits, with one unit changed it does not, and a number beside that unit makes up
    /// for it.
    #[test]
    fn expressions_made_to_fit(
        (powers, made) in proptest::array::uniform3(-2_i8..=2).prop_flat_map(|p| (Just(p), made(p, 4))),
        at in any::<prop::sample::Index>(),
        base in 0..3_usize,
    ) {
        let mut leaves = Vec::new();
        let text = made.written(&mut leaves);
        let known: Vec<Option<Powers>> = leaves.iter().copied().map(Some).collect();
        prop_assert!(consistent(&text, &known, powers), "{}", text);
        let at = at.index(leaves.len());
        let mut changed = known.clone();
        if let Some(p) = &mut changed[at] { p[base] += 1; }
        prop_assert!(!consistent(&text, &changed, powers), "{} with q{} changed", text, at);
        // Numbers without a unit, in the place of the name or beside it.
        let name = format!("q{at}");
        let swapped = |with: &str| {
            let parts = text.split(&name).collect::<Vec<_>>();
            // `q1` also begins `q10`.
            let mut out = parts[0].to_owned();
            for part in &parts[1..] {
                let own = !part.starts_with(|c: char| c.is_ascii_digit());
                out += if own { with } else { &name };
                out += part;
            }
            out
        };
        prop_assert!(consistent(&swapped(&format!("(3*{name})")), &changed, powers), "{}", text);
        prop_assert!(consistent(&swapped("0.5"), &changed, powers), "{}", text);
        // An unknown unit is found.
        changed[at] = None;
        prop_assert!(consistent(&text, &changed, powers), "{}", text);
    }
}
