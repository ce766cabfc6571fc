//! Causes that are no force of the motion: numbers that changed, drives that do not do what was recorded, bodies that
//! the model lacks. Data of an integrator of this file.

use crate::common::{Scratch, phisindy};
use serde_json::Value;
use std::fmt::Write as _;

/// What a slider on a spring is, and what is wrong with its drive.
#[derive(Clone, Copy)]
struct Rig {
    mass: f64,
    stiffness: f64,
    damping: f64,
    friction: f64,
    /// Dead band and limit of the drive (N), and its lag (s).
    dead: f64,
    top: f64,
    lag: f64,
    /// Mass, stiffness, damping and quadratic drag of a body that hangs on it.
    body: Option<[f64; 4]>,
}

/// As the spec says.
const STATED: Rig = Rig {
    mass: 1.5,
    stiffness: 620.0,
    damping: 2.0,
    friction: 1.1,
    dead: 0.0,
    top: f64::INFINITY,
    lag: 0.0,
    body: None,
};

fn drive(t: f64) -> f64 {
    5.0 * (13.0 * t).cos() + 3.0 * (24.7 * t + 0.8).cos() + 2.0 * (6.1 * t + 2.0).cos()
}

impl Rig {
    /// Places at each 5 ms, by steps of 10 us in which friction takes what it can of the speed (J. J. Moreau, Unilateral
    /// contact and dry friction in finite freedom dynamics, 1988).
    fn places(&self, seconds: f64) -> Vec<f64> {
        let (h, every) = (1e-5, 500);
        let [mut x, mut v, mut y, mut w] = [0.0; 4];
        let mut acts = drive(0.0);
        let [m, k, c, d] = self.body.unwrap_or([1.0, 0.0, 0.0, 0.0]);
        let mut all = vec![];
        for step in 0..(seconds / h) as usize {
            if step % every == 0 {
                all.push(x);
            }
            let u = drive(step as f64 * h);
            acts = if self.lag > 0.0 { acts + h * (u - acts) / self.lag } else { u };
            let beyond = (acts.abs() - self.dead).max(0.0).min(self.top) * acts.signum();
            let hangs = k * (x - y) + c * (v - w) + d * (v - w) * (v - w).abs();
            let free = v + h * (beyond - self.stiffness * x - self.damping * v - hangs) / self.mass;
            let most = h * self.friction / self.mass;
            v = free - free.clamp(-most, most);
            w += h * hangs / m;
            x += h * v;
            y += h * w;
        }
        all
    }

    /// What `gap` says of its motion with 1 % noise, where the spec has the stated numbers.
    fn searched(&self, name: &str) -> Value {
        let folder = Scratch::new(name);
        let mut seed = 11_u64;
        let mut unit = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((seed >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        };
        let places = self.places(9.0);
        let size = (places.iter().map(|x| x * x).sum::<f64>() / places.len() as f64).sqrt();
        let mut text = "t,x,F\n".to_owned();
        for (k, x) in places.iter().enumerate() {
            let noise = (-2.0 * unit().ln()).sqrt() * (std::f64::consts::TAU * unit()).cos();
            let t = 0.005 * k as f64;
            let _ = writeln!(text, "{t},{},{}", x + 0.01 * size * noise, drive(t));
        }
        std::fs::write(folder.path("run.csv"), text).expect("a file");
        let rig = folder.path("rig.ron");
        let Rig { mass, stiffness, damping, friction, .. } = STATED;
        let spec = format!(
            r#"(constants: {{ "m": ({mass:?}, "kg"), "k": ({stiffness:?}, "N/m"), "c": ({damping:?}, "N*s/m"), "Fc": ({friction:?}, "N") }},
            states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "F": "N" }},
            known: {{ "x": "v", "v": "(F - k*x - c*v - Fc*sgn(v))/m" }}, inertia: {{ "v": "m" }}, contacts: ["v"], unknown: {{}},
            data: [ Csv(path: "run.csv", time: "t", columns: {{ "x": "x", "F": "F" }}, window: (0.0, 6.0)),
                    Csv(path: "run.csv", time: "t", columns: {{ "x": "x", "F": "F" }}, window: (6.0, 9.0), role: Validate) ])"#
        );
        std::fs::write(&rig, spec).expect("a file");
        let out = phisindy(&["gap", &rig, "--format", "json", "--quiet", "--out", &folder.path("found")]);
        let found: Value = serde_json::from_str(&out.out).unwrap_or_else(|_| panic!("{}", out.err));
        if !found["steps"].as_array().is_none_or(Vec::is_empty) {
            // The completed spec is the model that was found.
            let again =
                phisindy(&["run", &folder.path("found/completed.ron"), "--format", "json", "--quiet"]);
            let again: Value = serde_json::from_str(&again.out).unwrap_or_else(|_| panic!("{}", again.err));
            let missed = again["records"][0]["nrmse"]["x"].as_f64().expect("a number");
            assert!(missed < 0.02, "{missed}: {again}");
        }
        found
    }
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
    let less = Rig { friction: 0.8 * STATED.friction, ..STATED };
    holds(&less.searched("changed_less"), &[("changed-constant", "Fc", &[("Fc", less.friction)])]);
    // More of a friction that the model has is that friction with another number, and no second one.
    let more = Rig { friction: 1.3 * STATED.friction, ..STATED };
    holds(&more.searched("changed_more"), &[("changed-constant", "Fc", &[("Fc", more.friction)])]);
}

#[test]
fn two_numbers_that_changed_are_named() {
    let both = Rig { friction: 0.8 * STATED.friction, stiffness: 0.97 * STATED.stiffness, ..STATED };
    let due: [Due<'_>; 2] =
        [("changed-constant", "Fc", &[("Fc", 0.88)]), ("changed-constant", "k", &[("k", 601.4)])];
    holds(&both.searched("changed_both"), &due);
}

#[test]
fn nothing_is_missing_where_nothing_changed() {
    let found = STATED.searched("unchanged");
    assert_eq!(found["status"], "nothing-missing", "{found}");
}

#[test]
fn a_drive_with_a_dead_band_a_limit_or_a_lag_is_told() {
    let dead = Rig { dead: 0.9, ..STATED };
    holds(&dead.searched("drive_dead"), &[("input-dead-band", "F", &[("d", 0.9)])]);
    let limited = Rig { top: 5.5, ..STATED };
    holds(&limited.searched("drive_limit"), &[("input-saturation", "F", &[("top", 5.5)])]);
    let late = Rig { lag: 0.02, ..STATED };
    holds(&late.searched("drive_lag"), &[("input-lag", "F", &[("tau", 0.02)])]);
}

#[test]
fn a_body_that_hangs_on_the_slider_is_found_with_the_drag_between_them() {
    let plain = Rig { body: Some([0.3, 90.0, 0.5, 0.0]), ..STATED };
    holds(&plain.searched("body"), &[("hanging-body", "v", &[("m", 0.3), ("k", 90.0)])]);
    let drag = Rig { body: Some([0.4, 70.0, 0.1, 6.0]), ..STATED };
    let due: [Due<'_>; 2] =
        [("hanging-body", "v", &[("m", 0.4), ("k", 70.0)]), ("quadratic-drag", "v-w", &[("d", 6.0)])];
    holds(&drag.searched("body_drag"), &due);
}
