//! Files that a spec names: matrices of a structure, tables. Motions are those of integrators that are not ours.

use crate::common::{Scratch, phisindy};
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;

fn found(args: &[&str]) -> Value {
    let done = phisindy(args);
    assert_eq!(done.code, 0, "{}{}", done.out, done.err);
    serde_json::from_str(&done.out).expect("JSON")
}

/// SciPy's Radau shook the beam. Its matrices, ten degrees of freedom, are reduced to the modes below 200 Hz, or to the three that
/// the points show.
#[test]
fn friction_at_a_point_of_a_structure_is_found_in_any_band() {
    for band in ["(0.0, 200.0)", "(0.0, 60.0)"] {
        let set = format!("structure.band={band}");
        let result = found(&["run", "specs/beam/beam.ron", "--set", &set, "--format", "json", "--quiet"]);
        let number = &result["parameters"][0];
        assert_eq!(number["name"], "Fc", "{result}");
        let value = number["value"].as_f64().expect("a number");
        assert!((value - 2.0).abs() < 0.02, "{band}: {number}");
    }
}

/// A mass on a spring with play, whose force stands in a file, by steps of 20 us in which friction takes what it can of
/// the speed (J. J. Moreau, 1988).
fn spring_rig(folder: &Scratch) {
    let points: [(f64, f64); 7] =
        [(-30.0, -9.0), (-10.0, -2.5), (-4.0, 0.0), (0.0, 0.0), (4.0, 0.0), (12.0, 4.0), (30.0, 9.4)];
    let force = |x: f64| {
        let k = points.windows(2).position(|p| 1e3 * x < p[1].0).unwrap_or(points.len() - 2);
        let ((a, fa), (b, fb)) = (points[k], points[k + 1]);
        fa + (fb - fa) * (1e3 * x - a) / (b - a)
    };
    let (h, every, m, friction) = (2e-5, 250, 0.5, 0.8);
    let drive = |t: f64| 3.2 * (9.1 * t).cos() + 2.4 * (15.3 * t + 1.0).cos();
    let (mut x, mut v, mut rows) = (0.004, 0.0_f64, "t,x,F\n".to_owned());
    let mut seed = 11_u64;
    for step in 0..600_000 {
        let t = f64::from(step) * h;
        if step % every == 0 {
            // Twelve even numbers are nearly a normal one.
            let mut noise = -6.0;
            for _ in 0..12 {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                noise += (seed >> 11) as f64 / (1_u64 << 53) as f64;
            }
            let _ = writeln!(rows, "{t},{},{}", x + 2e-5 * noise, drive(t));
        }
        let free = v + h * (drive(t) - force(x)) / m;
        v = free - free.clamp(-h * friction / m, h * friction / m);
        x += h * v;
    }
    fs::write(folder.path("run.csv"), rows).expect("a file");
    let spring: String = points.iter().map(|(x, f)| format!("{x},{f}\n")).collect();
    fs::write(folder.path("spring.csv"), format!("x [mm],F [N]\n{spring}")).expect("a file");
    let columns = r#"time: "t", columns: { "x": "x", "F": "F" }"#;
    let spec = format!(
        r#"(
    states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "F": "N" }}, constants: {{ "m": (0.5, "kg") }},
    known: {{ "x": "v", "v": "(F - table('spring.csv', x))/m" }}, inertia: {{ "v": "m" }},
    contacts: ["v"], unknown: {{ "v": (factor: "-sgn(v)/m", candidates: ["1", "|v|"]) }},
    data: [ Csv(path: "run.csv", name: "fit", {columns}, window: (0.0, 8.0)), Csv(path: "run.csv", name: "later", {columns}, window: (8.0, 12.0), role: Validate) ],
)"#
    );
    fs::write(folder.path("rig.ron"), spec).expect("a file");
}

#[test]
fn a_spring_of_a_table_stands_beside_friction_that_is_found() {
    let folder = Scratch::new("table");
    spring_rig(&folder);
    let (spec, out) = (folder.path("rig.ron"), folder.path("out"));
    let result = found(&["run", &spec, "--out", &out, "--format", "json", "--quiet"]);
    let terms = result["equations"][0]["terms"].as_array().expect("terms");
    assert_eq!(terms.len(), 1, "{result}");
    let value = terms[0]["coefficient"].as_f64().expect("a number");
    assert!((value - 0.8).abs() < 0.01, "{}", terms[0]);
    // The folder knows the table as it knows the record.
    let verified = |code: i32| {
        let done = phisindy(&["verify", &out, "--format", "json", "--quiet"]);
        assert_eq!(done.code, code, "{}{}", done.out, done.err);
        done.out
    };
    verified(0);
    let table = folder.path("spring.csv");
    let changed = fs::read_to_string(&table).expect("a table").replace("30,9.4", "30,9.5");
    fs::write(&table, changed).expect("a file");
    let told: Value = serde_json::from_str(&verified(1)).expect("JSON");
    let all = told["differences"].as_array().expect("a list");
    assert!(
        all.iter()
            .any(|d| d["code"] == "changed" && d["of"].as_str().is_some_and(|of| of.ends_with("spring.csv"))),
        "{told}"
    );
}
