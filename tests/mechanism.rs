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

const BY_HAND: &str = r#"states: { "x": "m", "v": "m/s", "th": "rad", "w": "rad/s" },
    known: { "x": "v", "th": "w",
        "v": "(F - c*v - k*x + m*l*w^2*sin(th) + m*g*sin(th)*cos(th) + b*w*cos(th)/l)/(M + m*sin(th)^2)",
        "w": "-g*sin(th)/l - b*w/(m*l^2) - cos(th)/l*(F - c*v - k*x + m*l*w^2*sin(th) + m*g*sin(th)*cos(th) + b*w*cos(th)/l)/(M + m*sin(th)^2)" },"#;

/// Rates that were solved by hand: where a force along the rail goes is shown by the drive, or said by a matrix.
#[test]
fn a_force_moves_what_hangs_on_its_body_in_rates_by_hand_too() {
    let folder = Scratch::new("mechanism_by_hand");
    write(&folder, |&[x, _, th, _]| [x, th]);
    let with_energy = spec(HANGING, r#""x": "a", "th": "b""#, "unknown: {},");
    let (head, tail) = with_energy.split_once("energy: (").expect("energies");
    let data = &tail[tail.find("unknown").expect("a field")..];
    let shown = r#"inertia: { "v": "M + m*sin(th)^2" },"#;
    let said = r#"inertia: { "v": { "v": "M + m", "w": "m*l*cos(th)" }, "w": "m*l^2" },"#;
    for inertia in [shown, said] {
        let text = format!("{head}{BY_HAND}{inertia}{data}");
        let rig = folder.path("rig.ron");
        std::fs::write(&rig, &text).expect("a file");
        let out = folder.path("out");
        let found = phisindy(&["gap", &rig, "--format", "json", "--quiet", "--out", &out, "--force"]);
        let found: Value = serde_json::from_str(&found.out).unwrap_or_else(|_| panic!("{}", found.err));
        assert_eq!(found["status"], "explained", "{inertia} {found}");
        let step = &found["steps"][0];
        assert_eq!((step["law"].as_str(), step["at"].as_str()), (Some("coulomb"), Some("v")));
        let level = step["parameters"]["Fc"]["value"].as_f64().expect("a number");
        assert!((level / FRICTION - 1.0).abs() < 0.01, "{inertia} {level}");
        // The completed model says it in both rates, and is as good.
        let completed = std::fs::read_to_string(format!("{out}/completed.ron")).expect("a spec");
        let again = answer(&folder, "run", &completed);
        let missed = again["records"][1]["nrmse"]["th"].as_f64().expect("a number");
        assert!(missed < 0.01, "{inertia} {missed}: {again}");
    }
}

/// Two chambers that a pump drives against each other: a leak between them is no force on a body.
#[test]
fn a_place_says_how_what_acts_there_enters_the_rates() {
    let (stiffness, outlet, leak) = (1e13, 2e-12, 3e-12);
    let flow = |t: f64| 2e-5 * (9.0 * t).cos() + 1.5e-5 * (31.0 * t + 0.4).cos();
    let [mut p, mut q] = [0.0, 0.0];
    let (mut text, h) = ("t,p1,p2,q\n".to_owned(), 1e-5);
    for step in 0..200_000 {
        let t = f64::from(step) * h;
        if step % 100 == 0 {
            // Even noise, by a hash: a sine of the step alone would be a tone.
            let wrong = |k: f64| 4e3 * (((k * f64::from(step)).sin() * 43_758.545_3).rem_euclid(1.0) - 0.5);
            let _ = writeln!(text, "{t},{},{},{}", p + wrong(12.9898), q + wrong(78.233), flow(t));
        }
        let over = leak * (p - q);
        (p, q) = (
            p + h * stiffness * (flow(t) - outlet * p - over),
            q + h * stiffness * (-0.5 * flow(t) - outlet * q + over),
        );
    }
    let folder = Scratch::new("mechanism_leak");
    std::fs::write(folder.path("run.csv"), text).expect("a file");
    let spec = r#"(constants: { "B": (1.0e13, "Pa/m^3"), "G": (2e-12, "m^3/s/Pa") }, states: { "p1": "Pa", "p2": "Pa" }, inputs: { "q": "m^3/s" },
        known: { "p1": "B*(q - G*p1)", "p2": "B*(-0.5*q - G*p2)" }, unknown: {},
        places: { "leak": (of: "p1 - p2", enters: { "p1": "-B", "p2": "B" }) },
        data: [ Csv(path: "run.csv", time: "t", columns: { "p1": "p1", "p2": "p2", "q": "q" }) ])"#;
    let found = answer(&folder, "gap", spec);
    let step = &found["steps"][0];
    assert_eq!((found["status"].as_str(), step["at"].as_str()), (Some("explained"), Some("leak")), "{found}");
    let numbers = step["parameters"].as_object().expect("numbers");
    assert!(
        numbers.values().any(|n| (n["value"].as_f64().unwrap_or(0.0) / leak - 1.0).abs() < 0.02),
        "{step}"
    );
    // What is no state, and what is no input, is told.
    for (wrong, said) in [
        (r#"enters: { "p3": "-B" }"#, "`p3` is no state"),
        (r#"replaces: "p1""#, "`p1` is no input that this place is of"),
        (r#"enter: { "p1": "-B" }"#, "enter"),
    ] {
        let text = spec.replace(r#"enters: { "p1": "-B", "p2": "B" }"#, wrong);
        std::fs::write(folder.path("wrong.ron"), text).expect("a file");
        let out = phisindy(&["check", &folder.path("wrong.ron")]);
        assert!(out.code == 2 && out.err.contains(said), "{}", out.err);
    }
}

/// A slider on a crank: the direction in which its friction acts turns with the crank.
#[test]
fn friction_acts_where_the_direction_turns_too() {
    let [inertia, m, r, l, d, friction] = [0.05, 2.5, 0.1, 0.28, 0.1, 14.0];
    let lever = |th: f64| {
        let (s, c) = th.sin_cos();
        r * s + r * r * s * c / (l * l - r * r * s * s).sqrt()
    };
    let torque = |t: f64| 1.2 + 1.5 * (2.3 * t).cos() + 0.9 * (5.1 * t + 0.7).cos();
    let (mut th, mut w, h, mut seed) = (0.4, 0.0, 5e-6, 11_u64);
    let mut text = "t,th,u\n".to_owned();
    for step in 0..1_800_000 {
        let t = f64::from(step) * h;
        if step % 2000 == 0 {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let wrong = 2e-3 * ((seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5);
            let _ = writeln!(text, "{t},{},{}", th + wrong, torque(t));
        }
        let (j, turn) = (lever(th), (lever(th + 1e-6) - lever(th - 1e-6)) / 2e-6);
        let mass = inertia + m * j * j;
        let free = w + h * (torque(t) - d * w - m * j * turn * w * w) / mass;
        // Friction takes what it can of the slider's speed.
        let most = h * friction * j.abs() / mass;
        w = free - free.clamp(-most, most);
        th += h * w;
    }
    let folder = Scratch::new("mechanism_crank");
    std::fs::write(folder.path("run.csv"), text).expect("a file");
    let spec = format!(
        r#"(constants: {{ "J": ({inertia:?}, "kg*m^2"), "m": ({m:?}, "kg"), "r": ({r:?}, "m"), "l": ({l:?}, "m"), "d": ({d:?}, "N*m*s") }},
        inputs: {{ "u": "N*m" }}, states: {{}},
        let: {{ "lever": "r*sin(th) + r^2*sin(th)*cos(th)/sqrt(l^2 - r^2*sin(th)^2)", "slide": "lever*w" }},
        energy: (coordinates: {{ "th": ("w", "rad") }}, kinetic: "J*w^2/2 + m*slide^2/2", dissipation: "d*w^2/2", forces: {{ "u": "w" }}),
        unknown: {{}}, places: {{ "slider": "slide" }},
        data: [ Csv(path: "run.csv", time: "t", columns: {{ "th": "th", "u": "u" }}, window: (0.0, 6.0)),
                Csv(path: "run.csv", time: "t", columns: {{ "th": "th", "u": "u" }}, window: (6.0, 9.0), role: Validate) ])"#
    );
    let rig = folder.path("rig.ron");
    std::fs::write(&rig, spec).expect("a file");
    let out = folder.path("out");
    let found = phisindy(&["gap", &rig, "--format", "json", "--quiet", "--out", &out]);
    let found: Value = serde_json::from_str(&found.out).unwrap_or_else(|_| panic!("{}", found.err));
    let step = &found["steps"][0];
    let place = (found["status"].as_str(), step["law"].as_str(), step["at"].as_str());
    assert_eq!(place, (Some("explained"), Some("coulomb"), Some("slider")), "{found}");
    let level = step["parameters"]["Fc"]["value"].as_f64().expect("a number");
    assert!((level / friction - 1.0).abs() < 0.02, "{level}");
    let completed = std::fs::read_to_string(format!("{out}/completed.ron")).expect("a spec");
    let again = answer(&folder, "run", &completed);
    let missed = again["records"][1]["nrmse"]["th"].as_f64().expect("a number");
    assert!(missed < 0.01, "{missed}: {again}");
}

/// A crank with a rod and a slider, in the crank's angle alone: place and speed of the crank, place of the slider. Friction
/// takes what it can of the speed in each step of 20 us.
fn slider_crank(seconds: f64) -> Vec<[f64; 3]> {
    let (h, every, [j, jr, m, r, l, c]) = (2e-5, 250, SLIDER_CRANK);
    let rod = |a: f64| -(r * a.sin() / l).asin();
    // The speeds of rod and slider for one of the crank.
    let moves = |a: f64| {
        let by = -r * a.cos() / (l * rod(a).cos());
        [by, -r * a.sin() - l * rod(a).sin() * by]
    };
    let mass = |a: f64| j + jr * moves(a)[0].powi(2) + m * moves(a)[1].powi(2);
    let [mut a, mut w]: [f64; 2] = [0.6, 0.0];
    let mut all = vec![];
    for step in 0..(seconds / h) as usize {
        if step % every == 0 {
            all.push([a, w, r * a.cos() + l * rod(a).cos()]);
        }
        let slope = (mass(a + 1e-5) - mass(a - 1e-5)) / 2e-5;
        let free = w + h * (torque(step as f64 * h) - c * w - 0.5 * slope * w * w) / mass(a);
        let along = moves(a)[1];
        let most = h * 18.0;
        // The impulse at the slider that would stop it.
        let push = (-free * mass(a) / along).clamp(-most, most);
        w = free + if along.abs() > 1e-9 { along * push / mass(a) } else { 0.0 };
        a += h * w;
    }
    all
}

/// Inertias of crank and rod (kg m^2), mass of the slider (kg), lengths (m), damping of the crank.
const SLIDER_CRANK: [f64; 6] = [0.02, 0.004, 1.5, 0.1, 0.3, 0.05];

fn torque(t: f64) -> f64 {
    1.2 + 3.0 * (2.1 * t).cos() + 2.5 * (5.3 * t + 0.4).cos()
}

/// The friction of a slider is found along its own speed, from the angle of the crank alone, and no damping beside it.
#[test]
fn friction_in_a_closed_loop_is_found_along_its_speed() {
    let folder = Scratch::new("slider-crank");
    let mut text = "t,a,T\n".to_owned();
    for (k, [a, ..]) in slider_crank(10.0).iter().enumerate() {
        let t = k as f64 * 0.005;
        let noise = 1e-3 * (12.9898 * (k * k % 7919) as f64 + 3.7 * k as f64).sin();
        let _ = writeln!(text, "{t},{},{}", a + noise, torque(t));
    }
    std::fs::write(folder.path("run.csv"), text).expect("a file");
    let spec = r#"(
        constants: { "J": (0.02, "kg*m^2"), "Jr": (0.004, "kg*m^2"), "m": (1.5, "kg"), "r": (0.1, "m"), "l": (0.3, "m"),
            "c": (value: 0.05, unit: "N*m*s", within: (0.0, 1.0)) },
        inputs: { "T": "N*m" },
        energy: (
            coordinates: { "a": ("w", "rad"), "b": ("wb", "rad"), "x": ("v", "m") },
            kinetic: "J*w^2/2 + Jr*wb^2/2 + m*v^2/2", dissipation: "c*w^2/2", forces: { "T": "w" },
            constraints: ["r*cos(a) + l*cos(b) - x", "r*sin(a) + l*sin(b)"],
        ),
        unknown: { "v": (candidates: ["-sgn(v)", "-v"]) }, contacts: ["v"],
        data: [ Csv(path: "run.csv", time: "t", columns: { "a": "a", "T": "T" }, window: (0.0, 6.0)),
                Csv(path: "run.csv", name: "rest", time: "t", columns: { "a": "a", "T": "T" }, window: (6.0, 10.0), role: Validate) ],
    )"#;
    std::fs::write(folder.path("crank.ron"), spec).expect("a spec");
    let found = phisindy(&["run", &folder.path("crank.ron"), "--format", "json", "--quiet"]);
    let json: Value = serde_json::from_str(&found.out).expect("JSON");
    let terms = json["equations"][0]["terms"].as_array().expect("terms");
    assert_eq!((found.code, terms.len()), (0, 1), "{}", found.out);
    assert_eq!(terms[0]["candidate"], "-sgn(v)", "{}", found.out);
    let friction = terms[0]["coefficient"].as_f64().expect("a number");
    // Its steps err by a part of a thousand.
    assert!((friction / 18.0 - 1.0).abs() < 2e-3, "{friction}");
}
