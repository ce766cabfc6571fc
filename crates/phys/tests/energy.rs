//! Equations of motion from energies, against those that are derived by hand.

use phisindy_expr::{Scratch, Tape};
use phisindy_phys::{Case, Diagnostic, SourceId, System, check, spec};

/// A cart on a rail with a hanging load.
const CRANE: &str = r#"(constants: { "M": (2.0, "kg"), "m": (1.0, "kg"), "l": (0.6, "m"), "g": (9.81, "m/s^2"), "c": (2.0, "N*s/m"), "k": (20.0, "N/m"), "b": (0.02, "N*m*s") },
    inputs: { "F": "N" }, let: { "tip": "v + l*w*cos(th)" },
    energy: (coordinates: { "x": ("v", "m"), "th": ("w", "rad") },
        kinetic: "M*v^2/2 + m*(tip^2 + (l*w*sin(th))^2)/2", potential: "k*x^2/2 - m*g*l*cos(th)",
        dissipation: "c*v^2/2 + b*w^2/2", forces: { "F": "v" }),
    unknown: { "v": (factor: "-sgn(v)", candidates: ["1"]) }, contacts: ["v"], data: [])"#;

fn case(text: &str) -> Result<(Case, Vec<Diagnostic>), Vec<Diagnostic>> {
    let (spec, _) = spec::read_without_data(text, SourceId(0))?;
    check(&spec, SourceId(0))
}

fn mistakes(text: &str) -> Vec<String> {
    case(text).err().unwrap_or_default().into_iter().filter(Diagnostic::is_error).map(|d| d.message).collect()
}

/// The rates of a model with these terms at a point: states, inputs, then coefficients.
fn rates(system: &System, terms: &[usize], states: &[f64], inputs: &[f64], numbers: &[f64]) -> Vec<f64> {
    let model = system.model(terms);
    let all: Vec<_> =
        [model.time].into_iter().chain(model.states).chain(model.inputs).chain(model.parameters).collect();
    let tape = Tape::compile(&model.graph, &all, &model.rates).expect("a tape");
    let mut scratch = Scratch::<1>::new(&tape);
    for (k, value) in [0.0].iter().chain(states).chain(inputs).chain(numbers).enumerate() {
        scratch.input(k)[0] = *value;
    }
    scratch.run();
    (0..states.len()).map(|k| scratch.output(k)[0]).collect()
}

#[test]
fn a_crane_moves_as_its_equations_by_hand_say() {
    let (case, doubts) = case(CRANE).expect("a case");
    assert!(doubts.is_empty(), "{doubts:?}");
    let names: Vec<&str> = case.system.states.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["x", "v", "th", "w"]);
    assert_eq!(case.system.states[3].unit, "rad/s");
    let (big, m, l, g, c, k, b) = (2.0, 1.0, 0.6, 9.81, 2.0, 20.0, 0.02);
    for point in 0..20 {
        let turn = |j: usize| (1.3 * (point * 5 + j) as f64).sin();
        let (x, v, th, w, f, fc): (f64, f64, f64, f64, f64, f64) =
            (turn(0), turn(1), 2.0 * turn(2), 3.0 * turn(3), 5.0 * turn(4), 0.7);
        // [M + m, m l cos; m l cos, m l^2] (v', w') = (F - c v - k x + m l w^2 sin - Fc sgn v, -m g l sin - b w).
        let (s, cos) = th.sin_cos();
        let a = f - c * v - k * x + m * l * w * w * s - fc * v.signum();
        let d = -m * g * l * s - b * w;
        let (p, q, r) = (big + m, m * l * cos, m * l * l);
        let by_hand = [v, (r * a - q * d) / (p * r - q * q), w, (p * d - q * a) / (p * r - q * q)];
        let found = rates(&case.system, &[0], &[x, v, th, w], &[f], &[fc]);
        for (a, b) in found.iter().zip(by_hand) {
            assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()), "{found:?} {by_hand:?}");
        }
    }
    // What is unknown along `v` is a force, in newtons.
    assert_eq!(case.system.terms[0].unit.map(|u| u.to_string()).as_deref(), Some("N"));
}

/// The known force of a base that moves by the time alone enters through the momentum that it changes.
#[test]
fn a_kinetic_energy_may_depend_on_the_time() {
    let text = r#"(constants: { "m": 2.0, "A": 0.5, "W": 3.0 },
        energy: (coordinates: { "y": ("u", "") }, kinetic: "m*(u - A*W*sin(W*t))^2/2"), data: [])"#;
    let (case, _) = case(text).expect("a case");
    let model = case.system.model(&[]);
    let all: Vec<_> = [model.time].into_iter().chain(model.states.iter().copied()).collect();
    let tape = Tape::compile(&model.graph, &all, &model.rates).expect("a tape");
    let mut scratch = Scratch::<1>::new(&tape);
    (scratch.input(0)[0], scratch.input(1)[0], scratch.input(2)[0]) = (0.4, 0.1, 0.2);
    scratch.run();
    assert!((scratch.output(1)[0] - 0.5 * 9.0 * (1.2_f64).cos()).abs() < 1e-12);
}

#[test]
fn mistakes_of_energies_have_their_places() {
    let with = |from: &str, to: &str| {
        assert!(CRANE.contains(from), "{from}");
        mistakes(&CRANE.replace(from, to))
    };
    let one = |from: &str, to: &str, expected: &str| {
        let found = with(from, to);
        assert!(found.iter().any(|m| m.contains(expected)), "{from} -> {to}: {found:?}");
    };
    one("M*v^2/2", "M*|v|*v/2", "the kinetic energy is not quadratic in the speeds");
    one(
        "kinetic: \"M*v^2/2 + m*(tip^2 + (l*w*sin(th))^2)/2\"",
        "kinetic: \"M*v^2/2\"",
        "no mass moves with `w`",
    );
    one("k*x^2/2 -", "k*x^2/2 - 0*M*v^3 + c*v*x -", "the potential energy depends on a speed");
    one("forces: { \"F\": \"v\" }", "forces: { \"F\": \"x\" }", "`x` is no speed along which a force acts");
    one(
        "forces: { \"F\": \"v\" })",
        "forces: { \"F\": \"v\" }), known: { \"v\": \"0\" }",
        "the energies say how `v` changes",
    );
    one("M*v^2/2 + m", "M*F*v^2/2 + m", "the kinetic energy depends on an input");
    one(
        "potential: \"k*x^2/2 - m*g*l*cos(th)\"",
        "potential: \"k*x\"",
        "potential is in N, but beside this kinetic energy",
    );
    one("forces: { \"F\": \"v\" }", "forces: { \"F\": \"w\" }", "a force times its speed is");
    one("\"tip\": \"v + l*w*cos(th)\"", "\"tip\": \"v + l*cos(th)\"", "m/s and m cannot be added");
    one("tip^2", "tap^2", "unknown name `tap`");
    one("\"tip\": \"v", "\"v\": \"v", "`v` is declared twice");
    one(
        "coordinates: { \"x\": (\"v\", \"m\"), \"th\": (\"w\", \"rad\") }",
        "coordinates: {}",
        "`energy` has no coordinates",
    );
    let doubts = case(&CRANE.replace("M*v^2/2 + m", "-M*v^2/2 - m")).expect("a case").1;
    assert!(doubts.iter().any(|d| d.message.contains("the kinetic energy is not positive")), "{doubts:?}");
}
