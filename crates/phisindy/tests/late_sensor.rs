//! Sensors that are late or show too much, by data that another integrator makes.
#![allow(missing_docs)]

use phisindy::{Case, Identified, Options, Record, Status, gap, identify};
use std::f64::consts::TAU;

const SLIDER: &str = r#"(constants: { "m": (2.0, "kg"), "k": Find(start: 700.0, unit: "N/m", within: (10.0, 1e4)), "c": Find(start: 3.0, unit: "N*s/m", within: (0.0, 100.0)) },
    states: { "x": "m", "v": "m/s" }, inputs: { "F": "N" }, known: { "x": "v", "v": "(F - k*x - c*v)/m" }, inertia: { "v": "m" },
    unknown: { "v": (factor: "-sgn(v)/m", candidates: ["1"]) }, contacts: ["v"])"#;
/// Stiffness, damping, friction.
const TRUTH: [f64; 3] = [800.0, 1.5, 1.2];
/// Steps of the integrator in a second.
const FINE: usize = 10_000;

fn drive(t: f64) -> f64 {
    6.0 * (12.3 * t).cos() + 4.0 * (27.1 * t + 1.0).cos()
}

/// A slider of 2 kg by the midpoint rule, in two parts where it stops within a step: its displacement, `FINE` values
/// a second.
fn motion(seconds: usize, [k, c, friction]: [f64; 3]) -> Vec<f64> {
    let (mut x, mut v) = (0.01, 0.0_f64);
    let next = |i: usize| {
        let now = x;
        let (mut t, mut left) = (i as f64 / FINE as f64, 1.0 / FINE as f64);
        while left > 0.0 {
            let force = drive(t + 0.5 * left) - k * (x + 0.5 * left * v) - c * v;
            let way = if v == 0.0 { force.signum() } else { v.signum() };
            let holds = v == 0.0 && force.abs() <= friction;
            let slope = if holds { 0.0 } else { (force - friction * way) / (2.0 + 0.5 * left * c) };
            let stops = v != 0.0 && v * (v + left * slope) < 0.0;
            let step = if stops { -v / slope } else { left };
            x += step * (v + 0.5 * step * slope);
            v = if stops { 0.0 } else { v + step * slope };
            (t, left) = (t + step, if stops { left - step } else { 0.0 });
        }
        now
    };
    (0..seconds * FINE).map(next).collect()
}

/// A record of a motion that a sensor reads so often a second with this noise.
fn record(case: &Case, read: &[f64], rate: usize, part: f64) -> Record {
    let every = FINE / rate;
    let size = read.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
    let mut seed = 1_u64;
    let mut noise = || {
        let mut unit = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((seed >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        };
        part * size * (-2.0 * unit().ln()).sqrt() * (TAU * unit()).cos()
    };
    let x: Vec<f64> = read.iter().step_by(every).map(|x| x + noise()).collect();
    let t: Vec<f64> = (0..x.len()).map(|i| i as f64 / rate as f64).collect();
    let force: Vec<f64> = t.iter().map(|&t| drive(t)).collect();
    case.record(&[("t", &t), ("x", &x), ("F", &force)]).expect("a record")
}

/// What is found of a motion that is read so often a second with this noise, where the record says more.
fn found_in(read: &[f64], rate: usize, noise: f64, with: impl Fn(Record) -> Record) -> Identified {
    let case = Case::read(SLIDER).expect("a spec");
    identify(&case, &[with(record(&case, read, rate, noise))], &Options::default()).expect("a result")
}

fn found(read: &[f64]) -> Identified {
    found_in(read, 100, 0.01, |record| record)
}

/// Values of stiffness, damping, friction, each in standard errors from the truth.
fn errors(found: &Identified) -> [f64; 3] {
    let number =
        |name: &str| found.parameters().iter().find(|p| p.id.to_string() == name).expect("found").estimate;
    let all = [number("k"), number("c"), found.terms()[0].coefficient];
    [0, 1, 2].map(|i| ((all[i].value - TRUTH[i]) / all[i].std_error).abs())
}

fn number(found: &Identified, name: &str) -> Option<f64> {
    found.parameters().iter().find(|p| p.id.to_string() == name).map(|p| p.estimate.value)
}

fn told(found: &Identified) -> bool {
    found.warnings().iter().any(|w| w.contains("which the spec does not say"))
}

#[test]
fn what_a_sensor_is_late_by_is_found_beside_the_rest() {
    let x = motion(5, TRUTH);
    let good = found(&x);
    assert!(!told(&good) && good.parameters().len() == 2, "{:?}", good.warnings());

    let late: Vec<f64> = (0..x.len()).map(|i| x[i.saturating_sub(FINE / 200)]).collect();
    let found_late = found(&late);
    let delay = number(&found_late, "x_delay").expect("a delay");
    assert!(told(&found_late) && (delay - 0.005).abs() < 3e-4, "{delay}");
    assert!(errors(&found_late).iter().all(|e| *e < 3.0), "{:?}", errors(&found_late));

    // A low-pass is one, exact along straight lines: its lag is found, not a delay.
    let (mut held, mut before) = (x[0], x[0]);
    let (follow, tau) = ((-TAU * 20.0 / FINE as f64).exp(), FINE as f64 / (TAU * 20.0));
    let slow = x.iter().map(|x| {
        let behind = tau * (x - before);
        held = x - behind + (held - before + behind) * follow;
        before = *x;
        held
    });
    let slow: Vec<f64> = slow.collect();
    let found_slow = found(&slow);
    let lag = number(&found_slow, "x_lag").expect("a lag");
    assert!(told(&found_slow) && (TAU * 20.0 * lag - 1.0).abs() < 0.05, "{lag}");
    assert!(errors(&found_slow).iter().all(|e| *e < 3.0), "{:?}", errors(&found_slow));

    // Also where the noise is below a thousandth of the motion.
    let fine = found_in(&slow, 500, 6e-5, |record| record);
    let lag = number(&fine, "x_lag").expect("a lag");
    assert!(
        (TAU * 20.0 * lag - 1.0).abs() < 0.005 && errors(&fine).iter().all(|e| *e < 3.0),
        "{lag} {:?}",
        errors(&fine)
    );

    // What was found can be run again: the sensor stands in the text.
    let again = found_slow.case().expect("a case");
    assert!(again.text().contains("lag: \"x_lag\""));

    // What the user states of a sensor stays, also where the records ask for more.
    let stated = found_in(&slow, 100, 0.01, |record| record.with("sensors", r#"{ "x": (lag: 0.003) }"#));
    assert_eq!(number(&stated, "x_lag"), None);
    assert!(stated.case().expect("a case").text().contains("lag: 0.003"));
}

/// On a linear rig a sensor that shows a tenth more is a drive that is a tenth stronger, and beside a spring and a damper to be
/// found a mass that is a tenth less: no record tells them apart, so they are one answer.
#[test]
fn names_of_one_motion_are_one_answer() {
    let said = |k: &str, c: &str| {
        let text = format!(
            r#"(constants: {{ "m": (2.0, "kg"), "k": {k}, "c": {c} }}, states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "F": "N" }},
                known: {{ "x": "v", "v": "(F - k*x - c*v)/m" }}, inertia: {{ "v": "m" }}, unknown: {{}})"#
        );
        let case = Case::read(&text).expect("a spec");
        let much: Vec<f64> = motion(5, [800.0, 1.5, 0.0]).iter().map(|x| 1.1 * x).collect();
        let said = gap(&case, &[record(&case, &much, 100, 0.01)], &Options::default()).expect("a result");
        let [step] = said.steps() else { panic!("{}", said.status().name()) };
        let same = step.rivals.iter().filter(|r| r.same).map(|r| r.law().to_owned());
        let mut same: Vec<String> = same.collect();
        same.sort_unstable();
        (said.status(), step.effect.entry.id.clone(), same.join(", "))
    };
    let due = |law: &str, same: &str| (Status::Explained, law.to_owned(), same.to_owned());
    assert_eq!(said(r#"(800.0, "N/m")"#, r#"(1.5, "N*s/m")"#), due("sensor-gain", "input-gain"));
    let free = (
        r#"(value: 800.0, unit: "N/m", within: (400.0, 1600.0))"#,
        r#"(value: 1.5, unit: "N*s/m", within: (0.0, 6.0))"#,
    );
    assert_eq!(said(free.0, free.1), due("changed-constant", "input-gain, sensor-gain"));
}
