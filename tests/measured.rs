//! Other people's measurements, wherever their folder is given by `PHISINDY_DATA`; the files are no part of
//! the repository.

#![allow(missing_docs)]

use crate::common::{Scratch, measured, phisindy, top};
use serde_json::Value;

fn run(spec: &str, data: &std::path::Path) -> Value {
    let data = data.to_str().expect("UTF-8");
    let said = phisindy(&["run", spec, "--data", data, "--format", "json", "--quiet"]);
    serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{e}: {}{}", said.out, said.err))
}

/// Coefficient of a candidate, or value of a parameter.
#[track_caller]
fn number(result: &Value, name: &str) -> f64 {
    let terms = result["equations"]
        .as_array()
        .into_iter()
        .flatten()
        .flat_map(|e| e["terms"].as_array().into_iter().flatten());
    let term = terms.filter(|t| t["candidate"] == name).find_map(|t| t["coefficient"].as_f64());
    let parameters = result["parameters"].as_array().into_iter().flatten();
    let parameter = parameters.filter(|p| p["name"] == name).find_map(|p| p["value"].as_f64());
    term.or(parameter).unwrap_or_else(|| panic!("no {name} in {result}"))
}

fn worst_validation(result: &Value) -> f64 {
    let records = result["records"].as_array().into_iter().flatten().filter(|r| r["role"] == "validate");
    records
        .flat_map(|r| r["nrmse"].as_object().into_iter().flatten())
        .filter_map(|(_, v)| v.as_f64())
        .fold(0.0, f64::max)
}

#[track_caller]
fn near(value: f64, published: f64, part: f64) {
    assert!((value / published - 1.0).abs() < part, "{value} is not within {part} of {published}");
}

/// Mass, damping, friction and offset of a drive, from position and force.
#[test]
fn a_drive() {
    let Some(data) = measured("emps_train.csv") else { return };
    let found = run("specs/emps.ron", &data);
    for (name, published) in [("M", 95.1089), ("v", 203.5034), ("sgn(v)", 20.3935), ("1", -3.1648)] {
        near(number(&found, name), published, 0.02);
    }
}

/// A force under prescribed motion, without a state of motion: fitted on two sines, an earthquake follows.
/// Dahl's element alone leaves 0.21, 0.27 and 0.78.
#[test]
fn a_band_brake_damper() {
    let Some(data) = measured("damper_36lb_kocaeli_dbe.csv") else { return };
    let found = run("specs/damper.ron", &data);
    for (name, most) in [("0.5 Hz", 0.12), ("1 Hz", 0.18), ("Kocaeli", 0.40)] {
        let records = found["records"].as_array().into_iter().flatten();
        let nrmse = records.filter(|r| r["name"] == name).find_map(|r| r["nrmse"]["F"].as_f64());
        assert!(nrmse.is_some_and(|e| e < most), "{name}: {nrmse:?}");
    }
    // A level in proportion to the tension of the band is not what this damper has.
    let warnings = found["warnings"].to_string();
    assert!(warnings.contains("Fm is") && warnings.contains("from 30 lb alone"), "{warnings}");
}

/// The same file in millimetres and kilonewtons says the same.
#[test]
fn a_drive_in_other_units() {
    let Some(data) = measured("emps_train.csv") else { return };
    let text = std::fs::read_to_string(data.join("emps_train.csv")).expect("a file");
    let mut lines = text.lines();
    let heading: Vec<&str> = lines.next().expect("a heading").split(',').collect();
    let column = |name: &str| heading.iter().position(|h| *h == name).expect("a column");
    let (t, q, f) = (column("time_s"), column("q_m"), column("F_motor_N"));
    // The decimal point moves, no digit changes: 1.5e-3 m is 1.5e0 mm.
    let scaled = |field: &str, by: i32| {
        let (digits, exponent) = field.split_once(['e', 'E']).unwrap_or((field, "0"));
        format!("{digits}e{}", exponent.parse::<i32>().expect("an exponent") + by)
    };
    let mut other = "time_s,q_mm,F_kN\n".to_owned();
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        other += &format!("{},{},{}\n", fields[t], scaled(fields[q], 3), scaled(fields[f], -3));
    }
    let scratch = Scratch::new("units");
    std::fs::write(scratch.path("emps_train.csv"), other).expect("a file");
    let spec = std::fs::read_to_string(top().join("specs/emps.ron")).expect("a spec");
    let spec = spec
        .replace("(\"q_m\", \"m\")", "(\"q_mm\", \"mm\")")
        .replace("(\"F_motor_N\", \"N\")", "(\"F_kN\", \"kN\")");
    std::fs::write(scratch.path("emps.ron"), spec).expect("a file");
    let (one, two) = (run("specs/emps.ron", &data), run(&scratch.path("emps.ron"), &scratch.0));
    for name in ["M", "v", "sgn(v)", "1"] {
        // More digits than are printed: a factor of a thousand moves the last bit of some samples, and the
        // descent stops a step earlier or later.
        near(number(&two, name), number(&one, name), 1e-7);
    }
}

/// A pendulum that swings until it stops.
#[test]
fn a_pendulum() {
    let Some(data) = measured("pendulum_free_1.csv") else { return };
    let (scratch, folder) = (Scratch::new("pendulum"), data.to_str().expect("UTF-8").to_owned());
    let out = scratch.0.to_str().expect("UTF-8");
    phisindy(&["run", "specs/pendulum.ron", "--data", &folder, "--quiet", "--out", out]);
    let found = std::fs::read_to_string(scratch.path("result.json")).expect("a result");
    let found: Value = serde_json::from_str(&found).expect("JSON");
    near(number(&found, "gl"), 30.99, 0.005);
    near(number(&found, "sgn(w)"), 0.1825, 0.1);
    assert!(worst_validation(&found) < 0.06, "{found}");
    // Where it stops: the last sample at which the free run still moves; it really stopped at 71.4 s.
    let said = phisindy(&["simulate", &scratch.path("identified.ron"), "--data", &folder]);
    let rows = said.out.lines().skip(1).map(|l| l.split(',').collect::<Vec<_>>());
    let moving = rows.filter(|r| r[r.len() - 1].parse::<f64>().is_ok_and(|w| w != 0.0));
    let last = moving.filter_map(|r| r[1].parse::<f64>().ok()).fold(0.0, f64::max);
    assert!((last - 71.4).abs() < 1.0, "it stops at {last} s");
}

/// One friction coefficient for two loads, with a delay between the lasers.
#[test]
fn a_frame_under_two_loads() {
    let Some(data) = measured("frame_stickslip_250g.csv") else { return };
    let found = run("specs/frame_mu.ron", &data);
    let mu = number(&found, "1");
    assert!((0.26..0.34).contains(&mu), "mu {mu}");
    assert!(worst_validation(&found) < 0.08, "{found}");
    assert!(number(&found, "late") < 0.0, "the base is late");
}

/// `phisindy gap` on the spec that `phisindy new` writes.
fn gap_of_new(name: &str, file: &std::path::Path) -> Value {
    let scratch = Scratch::new(name);
    let spec = &scratch.path("new.ron");
    let file = file.to_str().expect("UTF-8");
    phisindy(&["new", file, "--out", spec, "--quiet"]);
    let folder = std::path::Path::new(file).parent().and_then(|p| p.to_str()).expect("a folder");
    let said = phisindy(&["gap", spec, "--data", folder, "--format", "json", "--quiet"]);
    serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{e}: {}{}", said.out, said.err))
}

/// The laws that a result names.
fn laws(found: &Value) -> Vec<&str> {
    found["steps"].as_array().into_iter().flatten().filter_map(|s| s["law"].as_str()).collect()
}

/// The frame in continuous motion repeats to 0.006: a damper of seventy times the published value leaves
/// 0.010, which is not the scatter of the rig. Friction is what is missing.
#[test]
fn a_floor_that_a_law_passes_is_no_floor() {
    let Some(folder) = measured("frame_continuous_70p83_10s_2kHz_mm.csv") else { return };
    let found = gap_of_new("measured-70p83", &folder.join("frame_continuous_70p83_10s_2kHz_mm.csv"));
    assert_eq!(laws(&found), ["coulomb"], "{}", found["steps"]);
    near(found["steps"][0]["parameters"]["Fc"]["value"].as_f64().unwrap_or(0.0), 0.12, 0.2);
    for record in found["repeatability"].as_array().into_iter().flatten() {
        assert!(record["nrmse"].as_f64().is_some_and(|r| r < 0.0075), "{record}");
    }
}

/// A spring on an air track: nothing is named for a scale that bends by a quarter of a per cent.
#[test]
fn a_linear_oscillator_needs_no_law() {
    let Some(folder) = measured("schmidt_lipson_linear_1.txt") else { return };
    let found = gap_of_new("measured-air-track", &folder.join("schmidt_lipson_linear_1.txt"));
    assert_eq!(laws(&found), [""; 0], "{}", found["steps"]);
}

/// What `new` drafts for each record and `check` then says of it: a person who looks at the plots sees
/// nothing that is wrong, but for a drive sampled at three points a period.
#[test]
fn no_false_alarm_about_data() {
    for (file, alarms) in [
        ("cart_relay_0m10.csv", 0),
        ("damper_30lb_0p25Hz_1in.csv", 0),
        ("damper_36lb_0p5Hz_1in.csv", 0),
        ("damper_36lb_1Hz_0p5in.csv", 0),
        ("damper_36lb_kocaeli_dbe.csv", 0),
        ("emps_train.csv", 0),
        ("frame_continuous_70p83_10s_2kHz_mm.csv", 0),
        ("frame_stickslip_250g.csv", 0),
        ("multiarm_pendulum_55s.csv", 0),
        ("pendulum_free_1.csv", 0),
        ("schmidt_lipson_linear_1.txt", 0),
        ("servo_xl330_driven.csv", 0),
        ("servo_xl330_lift_and_drop.csv", 0),
        ("silverbox_multisine.csv", 1),
    ] {
        let Some(folder) = measured(file) else { return };
        let scratch = Scratch::new("alarms");
        let spec = scratch.path("rig.ron");
        let path = folder.join(file);
        let said = phisindy(&["new", path.to_str().expect("UTF-8"), "--out", &spec]);
        assert_eq!(said.code, 0, "{file}: {}", said.err);
        let said = phisindy(&["check", &spec, "--data", folder.to_str().expect("UTF-8")]);
        // A question of the draft is no alarm about the data.
        let told = alarms + said.err.matches("a question of this draft is open").count();
        assert_eq!(
            (said.code, said.err.matches("warning").count()),
            (0, told + usize::from(told > 0)),
            "{file}: {}",
            said.err
        );
    }
}

/// A cart that a relay drives to and fro, without a spring: M = 6.28 kg.
#[test]
fn a_cart_on_a_relay_is_drafted_without_a_spring() {
    let Some(folder) = measured("cart_relay_0m10.csv") else { return };
    let path = folder.join("cart_relay_0m10.csv");
    let said = phisindy(&["new", path.to_str().expect("UTF-8")]);
    assert!(
        said.out.contains("interpolate: { \"F\": Hold }") && said.out.contains("show no spring"),
        "{}",
        said.out
    );
    let mass = said.out.split("\"m\": (value: ").nth(1).and_then(|rest| rest.split(',').next());
    let mass: f64 = mass.and_then(|m| m.parse().ok()).expect("a mass");
    assert!((5.5..7.2).contains(&mass), "{mass}");
}

/// Friction in proportion to the load, before the small effects: laws with memory, whose segments always
/// leave little, once kept the plain laws out of the race.
#[test]
fn a_frame_under_two_loads_has_coulomb_friction() {
    let Some(data) = measured("frame_stickslip_250g.csv") else { return };
    let data = data.to_str().expect("UTF-8");
    let said = phisindy(&["gap", "specs/frame_gap.ron", "--data", data, "--format", "json", "--quiet"]);
    let found: Value = serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{e}: {}", said.err));
    let first = &found["steps"][0];
    assert_eq!(
        (found["status"].as_str(), first["law"].as_str()),
        (Some("explained"), Some("coulomb")),
        "{found}"
    );
    assert_eq!(first["scales_with"], "N", "{first}");
    near(first["parameters"]["mu"]["value"].as_f64().unwrap_or(0.0), 0.298, 0.05);
}
