//! Mechanisms as energies: the same physics gives the same answer in any coordinates.

use crate::common::{Scratch, phisindy};
use serde_json::Value;
use std::fmt::Write as _;

/// Friction of the rail (N).
const FRICTION: f64 = 2.2;
/// Masses of the cart and of the load (kg), length (m), stiffness, damping of rail and hinge.
const RIG: [f64; 6] = [1.7, 0.8, 0.5, 25.0, 1.5, 0.015];

fn drive(t: f64) -> f64 {
    9.0 * (3.1 * t).cos() + 5.0 * (7.7 * t + 0.4).cos()
}

/// A cart with a hanging load, by steps of 20 us in which friction takes what it can of the speed (J. J. Moreau,
/// Unilateral contact and dry friction in finite freedom dynamics, 1988): place, angle and their speeds.
fn motion(seconds: f64) -> Vec<[f64; 4]> {
    let (h, every) = (2e-5, 500);
    let [big, m, l, k, c, b] = RIG;
    let [mut x, mut v, mut th, mut w] = [0.0, 0.0, 0.3, 0.0];
    let mut all = vec![];
    for step in 0..(seconds / h) as usize {
        if step % every == 0 {
            all.push([x, v, th, w]);
        }
        let (s, cos) = f64::sin_cos(th);
        let (p, q, r) = (big + m, m * l * cos, m * l * l);
        let det = p * r - q * q;
        let force = drive(step as f64 * h) - k * x - c * v + m * l * w * w * s;
        let torque = -m * 9.81 * l * s - b * w;
        let free = v + h * (r * force - q * torque) / det;
        let most = h * FRICTION;
        let push = (-free * det / r).clamp(-most, most);
        v = free + r * push / det;
        w += h * (p * torque - q * force) / det - q * push / det;
        x += h * v;
        th += h * w;
    }
    all
}

/// Writes the record, with noise of 0.2 %, of what two sensors see.
fn write(folder: &Scratch, seen: impl Fn(&[f64; 4]) -> [f64; 2]) {
    let mut seed = 7_u64;
    let mut noise = || {
        let mut unit = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((seed >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        };
        (-2.0 * unit().ln()).sqrt() * (std::f64::consts::TAU * unit()).cos()
    };
    let mut text = "t,a,b,F\n".to_owned();
    for (k, state) in motion(12.0).iter().enumerate() {
        let (t, [a, b]) = (k as f64 * 0.01, seen(state));
        let _ = writeln!(text, "{t},{},{},{}", a + 4e-4 * noise(), b + 1e-3 * noise(), drive(t));
    }
    std::fs::write(folder.path("run.csv"), text).expect("a file");
}

/// A spec with these energies: coordinates, kinetic, potential, dissipation, and what the columns are.
fn spec(energy: [&str; 4], columns: &str, more: &str) -> String {
    let [coordinates, kinetic, potential, dissipation] = energy;
    let [big, m, l, k, c, b] = RIG;
    format!(
        r#"(constants: {{ "M": ({big:?}, "kg"), "m": ({m:?}, "kg"), "l": ({l:?}, "m"), "g": (9.81, "m/s^2"), "k": ({k:?}, "N/m"), "c": ({c:?}, "N*s/m"), "b": ({b:?}, "N*m*s") }},
        inputs: {{ "F": "N" }},
        energy: (coordinates: {{ {coordinates} }}, kinetic: "{kinetic}", potential: "{potential}", dissipation: "{dissipation}", forces: {{ "F": "v" }}),
        {more}
        data: [ Csv(path: "run.csv", time: "t", columns: {{ {columns}, "F": "F" }}, window: (0.0, 8.0)),
                Csv(path: "run.csv", time: "t", columns: {{ {columns}, "F": "F" }}, window: (8.0, 12.0), role: Validate) ])"#
    )
}

const HANGING: [&str; 4] = [
    r#""x": ("v", "m"), "th": ("w", "rad")"#,
    "(M + m)*v^2/2 + m*l*v*w*cos(th) + m*(l*w)^2/2",
    "k*x^2/2 - m*g*l*cos(th)",
    "c*v^2/2 + b*w^2/2",
];

fn answer(folder: &Scratch, command: &str, text: &str) -> Value {
    let rig = folder.path("rig.ron");
    std::fs::write(&rig, text).expect("a file");
    let out = phisindy(&[command, &rig, "--format", "json", "--quiet"]);
    serde_json::from_str(&out.out).unwrap_or_else(|_| panic!("{}", out.err))
}

#[test]
fn friction_of_a_rail_under_a_swinging_load_is_found_from_energies() {
    let folder = Scratch::new("mechanism_rail");
    write(&folder, |&[x, _, th, _]| [x, th]);
    let columns = r#""x": "a", "th": "b""#;
    let found = answer(&folder, "gap", &spec(HANGING, columns, "unknown: {},"));
    assert_eq!(found["status"], "explained", "{found}");
    let step = &found["steps"][0];
    assert_eq!((step["law"].as_str(), step["at"].as_str()), (Some("coulomb"), Some("v")));
    let level = step["parameters"]["Fc"]["value"].as_f64().expect("a number");
    assert!((level / FRICTION - 1.0).abs() < 0.01, "{level}");
}

/// What was identified stands among the forces of the mechanism, and predicts.
#[test]
fn what_is_identified_can_be_run_again() {
    let folder = Scratch::new("mechanism_identified");
    write(&folder, |&[x, _, th, _]| [x, th]);
    let columns = r#""x": "a", "th": "b""#;
    let more = r#"unknown: { "v": (factor: "-sgn(v)", candidates: ["1"]) }, contacts: ["v"],"#;
    let rig = folder.path("rig.ron");
    std::fs::write(&rig, spec(HANGING, columns, more)).expect("a file");
    let out = folder.path("out");
    phisindy(&["run", &rig, "--out", &out, "--quiet"]);
    let text = std::fs::read_to_string(format!("{out}/identified.ron")).expect("a spec");
    assert!(text.contains(r#""-c_v*sgn(v)": "v""#), "{text}");
    let again = answer(&folder, "run", &text);
    let missed = again["records"][1]["nrmse"]["x"].as_f64().expect("a number");
    assert!(missed < 0.01, "{missed}: {again}");
}

#[test]
fn an_answer_does_not_depend_on_the_coordinates() {
    let folder = Scratch::new("mechanism_coordinates");
    let more = r#"unknown: { "v": (factor: "-sgn(v)", candidates: ["1", "v^2"]) }, contacts: ["v"],"#;
    let [_, _, l, ..] = RIG;
    let mut levels = vec![];
    // The load by its angle, by its place beside the cart, and the cart by its distance to a wall on the other side.
    write(&folder, |&[x, _, th, _]| [x, th]);
    levels.push(answer(&folder, "run", &spec(HANGING, r#""x": "a", "th": "b""#, more)));
    write(&folder, |&[x, _, th, _]| [x, l * th]);
    let by_arc = [
        r#""x": ("v", "m"), "s": ("u", "m")"#,
        "(M + m)*v^2/2 + m*v*u*cos(s/l) + m*u^2/2",
        "k*x^2/2 - m*g*l*cos(s/l)",
        "c*v^2/2 + b*(u/l)^2/2",
    ];
    levels.push(answer(&folder, "run", &spec(by_arc, r#""x": "a", "s": "b""#, more)));
    write(&folder, |&[x, _, th, _]| [-x, th]);
    let mirrored = [
        r#""y": ("z", "m"), "th": ("w", "rad")"#,
        "(M + m)*z^2/2 - m*l*z*w*cos(th) + m*(l*w)^2/2",
        "k*y^2/2 - m*g*l*cos(th)",
        "c*z^2/2 + b*w^2/2",
    ];
    let more = more.replace("\"v\"", "\"z\"").replace("sgn(v)", "sgn(z)").replace("v^2", "z^2");
    let text = spec(mirrored, r#""y": "a", "th": "b""#, &more).replace(r#"{ "F": "v" }"#, r#"{ "F": "-z" }"#);
    levels.push(answer(&folder, "run", &text));
    for found in &levels {
        assert_eq!(found["verdict"], "identified", "{found}");
        let terms = found["equations"][0]["terms"].as_array().expect("terms");
        let level = terms[0]["coefficient"].as_f64().expect("a number");
        assert_eq!((terms.len(), terms[0]["unit"].as_str()), (1, Some("N")));
        assert!((level / FRICTION - 1.0).abs() < 0.005, "{level}");
    }
}
