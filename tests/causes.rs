//! Causes that are no force of the motion: numbers that changed, drives that do not do what was recorded, bodies that
//! the model lacks. Data of `common::slider`, an integrator that is not the program's.

use crate::common::slider::{Dice, Slider, spec, spec_from};
use crate::common::{Scratch, phisindy};
use serde_json::Value;

/// As the spec says.
const STATED: Slider = Slider::plain(1.5, 620.0, 2.0, 1.1);

fn drive(t: f64) -> f64 {
    5.0 * (13.0 * t).cos() + 3.0 * (24.7 * t + 0.8).cos() + 2.0 * (6.1 * t + 2.0).cos()
}

/// What `gap` says of a motion, where the spec has the stated numbers.
fn searched(slider: &Slider, name: &str) -> Value {
    let folder = Scratch::new(name);
    std::fs::write(folder.path("run.csv"), slider.record(&drive, &mut Dice(11))).expect("a file");
    let rig = folder.path("rig.ron");
    std::fs::write(&rig, spec(&STATED.constants(), "run.csv")).expect("a file");
    let out = phisindy(&["gap", &rig, "--format", "json", "--quiet", "--out", &folder.path("found")]);
    let found: Value = serde_json::from_str(&out.out).unwrap_or_else(|_| panic!("{}", out.err));
    if !found["steps"].as_array().is_none_or(Vec::is_empty) {
        // The completed spec is the model that was found.
        let again = phisindy(&["run", &folder.path("found/completed.ron"), "--format", "json", "--quiet"]);
        let again: Value = serde_json::from_str(&again.out).unwrap_or_else(|_| panic!("{}", again.err));
        let missed = again["records"][0]["nrmse"]["x"].as_f64().expect("a number");
        assert!(missed < 0.02, "{missed}: {again}");
    }
    found
}

/// Law, place, and some of its numbers.
type Due<'a> = (&'a str, &'a str, &'a [(&'a str, f64)]);

/// Asserts the steps: law, place, and some of its numbers within 3 %.
#[track_caller]
fn holds(found: &Value, steps: &[Due<'_>]) {
    assert_eq!(found["status"], "explained", "{found}");
    let all = found["steps"].as_array().expect("steps");
    assert_eq!(all.len(), steps.len(), "{found}");
    for (law, at, numbers) in steps {
        let own = |s: &&Value| s["law"] == *law && s["at"] == *at;
        let step = all.iter().find(own).unwrap_or_else(|| panic!("no {law} at {at}: {found}"));
        for (name, due) in *numbers {
            let value = step["parameters"][name]["value"].as_f64().unwrap_or(f64::NAN);
            assert!((value / due - 1.0).abs() < 0.03, "{name} = {value}, not {due}: {found}");
        }
    }
}

#[test]
fn a_number_that_changed_is_named() {
    let less = Slider { friction: 0.8 * STATED.friction, ..STATED };
    holds(&searched(&less, "changed_less"), &[("changed-constant", "Fc", &[("Fc", less.friction)])]);
    // More of a friction that the model has is that friction with another number, and no second one.
    let more = Slider { friction: 1.3 * STATED.friction, ..STATED };
    holds(&searched(&more, "changed_more"), &[("changed-constant", "Fc", &[("Fc", more.friction)])]);
}

#[test]
fn two_numbers_that_changed_are_named() {
    let both = Slider { friction: 0.8 * STATED.friction, stiffness: 0.97 * STATED.stiffness, ..STATED };
    let due: [Due<'_>; 2] =
        [("changed-constant", "Fc", &[("Fc", 0.88)]), ("changed-constant", "k", &[("k", 601.4)])];
    holds(&searched(&both, "changed_both"), &due);
}

#[test]
fn nothing_is_missing_where_nothing_changed() {
    let found = searched(&STATED, "unchanged");
    assert_eq!(found["status"], "nothing-missing", "{found}");
}

#[test]
fn a_drive_with_a_dead_band_a_limit_or_a_lag_is_told() {
    let dead = Slider { dead: 0.9, ..STATED };
    holds(&searched(&dead, "drive_dead"), &[("input-dead-band", "F", &[("d", 0.9)])]);
    let limited = Slider { top: 5.5, ..STATED };
    holds(&searched(&limited, "drive_limit"), &[("input-saturation", "F", &[("top", 5.5)])]);
    let late = Slider { lag: 0.02, ..STATED };
    holds(&searched(&late, "drive_lag"), &[("input-lag", "F", &[("tau", 0.02)])]);
}

#[test]
fn a_body_that_hangs_on_the_slider_is_found_with_the_drag_between_them() {
    let plain = Slider { body: Some([0.3, 90.0, 0.5, 0.0]), ..STATED };
    holds(&searched(&plain, "body"), &[("hanging-body", "v", &[("m", 0.3), ("k", 90.0)])]);
    let drag = Slider { body: Some([0.4, 70.0, 0.1, 6.0]), ..STATED };
    let due: [Due<'_>; 2] =
        [("hanging-body", "v", &[("m", 0.4), ("k", 70.0)]), ("quadratic-drag", "v-w", &[("d", 6.0)])];
    holds(&searched(&drag, "body_drag"), &due);
}

/// Static friction, and a lower kinetic friction at every speed.
#[test]
fn static_friction_is_found() {
    let stated = Slider { friction: 0.0, ..STATED }.constants();
    let folder = Scratch::new("breakaway");
    let rig = folder.path("rig.ron");
    for (friction, holds) in [(0.9, 1.6), (0.4, 1.2)] {
        let slider = Slider { friction, holds, ..STATED };
        let slow = |t: f64| 0.6 * drive(0.25 * t);
        std::fs::write(folder.path("run.csv"), slider.record(&slow, &mut Dice(11))).expect("a file");
        std::fs::write(&rig, spec(&stated, "run.csv")).expect("a file");
        let out = phisindy(&["gap", &rig, "--format", "json", "--quiet"]);
        let found = serde_json::from_str(&out.out).unwrap_or_else(|_| panic!("{}", out.err));
        let due: [Due<'_>; 1] = [("breakaway", "v", &[("Fc", friction), ("Fs", friction + holds)])];
        self::holds(&found, &due);
    }
}

/// A clock that started long before shows the same wear.
#[test]
fn friction_that_grows_is_found_by_any_clock() {
    let worn = Slider { wear: 0.06, ..STATED };
    let stated = Slider { friction: 0.0, ..STATED }.constants();
    let folder = Scratch::new("worn");
    let rig = folder.path("rig.ron");
    for clock in [0.0, 1000.0] {
        std::fs::write(folder.path("run.csv"), worn.record_from(clock, &drive, &mut Dice(11)))
            .expect("a file");
        std::fs::write(&rig, spec_from(clock, &stated, "run.csv")).expect("a file");
        let out = phisindy(&["gap", &rig, "--format", "json", "--quiet"]);
        let found = serde_json::from_str(&out.out).unwrap_or_else(|_| panic!("{}", out.err));
        holds(&found, &[("drifting-friction", "v", &[("Fc", worn.friction), ("r", worn.wear)])]);
    }
}

/// A body that falls through air on a floor of which the model knows nothing.
#[test]
fn a_floor_and_the_air_above_it_are_found() {
    a_floor_is_found(0.03);
    a_floor_is_found(0.0);
}

fn a_floor_is_found(drag: f64) {
    let (floor, left, step) = (0.3, 0.72, 1e-5);
    let (mut z, mut v, mut dice) = (6.0_f64, 0.0_f64, Dice(11));
    let mut text = "t,z\n".to_owned();
    for k in 0..700_000 {
        if k % 2000 == 0 {
            text += &format!("{},{}\n", step * f64::from(k), z + 0.01 * dice.normal());
        }
        v -= step * (9.81 + drag * v * v.abs());
        z += step * v;
        if z < floor && v < 0.0 {
            v *= -left;
        }
    }
    let folder = Scratch::new("floor");
    let rig = folder.path("rig.ron");
    std::fs::write(folder.path("run.csv"), text).expect("a file");
    let spec = r#"(states: { "z": "m", "v": "m/s" }, known: { "z": "v", "v": "-9.81" }, unknown: {},
        data: [ Csv(path: "run.csv", time: ("t", "s"), columns: { "z": ("z", "m") }) ])"#;
    std::fs::write(&rig, spec).expect("a file");
    let out = phisindy(&["gap", &rig, "--format", "json", "--quiet", "--out", &folder.path("found")]);
    let found: Value = serde_json::from_str(&out.out).unwrap_or_else(|_| panic!("{}", out.err));
    let air = [("d", drag)];
    let due: [Due<'_>; 2] = [("impact", "z", &[("x0", floor), ("e", left)]), ("quadratic-drag", "v", &air)];
    holds(&found, &due[..if drag > 0.0 { 2 } else { 1 }]);
    let again = phisindy(&["run", &folder.path("found/completed.ron"), "--format", "json", "--quiet"]);
    let again: Value = serde_json::from_str(&again.out).unwrap_or_else(|_| panic!("{}", again.err));
    assert!(again["records"][0]["nrmse"]["z"].as_f64().is_some_and(|missed| missed < 0.02), "{again}");
}
