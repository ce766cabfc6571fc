//! Records of one machine over time, and of many machines. Data of `common::slider`, an integrator that is not the program's.
//!
//! `PHISINDY_PAIRS=100 PHISINDY_SEED=7 cargo test -p phisindy-cli compare` draws so many pairs of each kind.
#![allow(missing_docs, clippy::print_stderr)]

use crate::common::slider::{Dice, Slider, spec};
use crate::common::{Outcome, Scratch, phisindy};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

/// A slider and the size of its drive (N).
#[derive(Clone, Copy)]
struct Rig {
    slider: Slider,
    drive: f64,
}

impl Rig {
    fn drawn(dice: &mut Dice) -> Rig {
        let drive = dice.between(3.0, 8.0);
        let [m, k, c] = [(0.5, 3.0), (200.0, 1200.0), (0.5, 3.0)].map(|(low, high)| dice.between(low, high));
        Rig { slider: Slider::plain(m, k, c, drive * dice.between(0.1, 0.25)), drive }
    }

    /// Three tones about its natural frequency, with phases of their own.
    fn record(&self, path: &Path, dice: &mut Dice) {
        let natural = (self.slider.stiffness / self.slider.mass).sqrt();
        let tones = [(1.0, 0.65), (0.6, 1.22), (0.4, 0.31)];
        let tones = tones.map(|(part, ratio)| (part * self.drive, ratio * natural, dice.between(0.0, TAU)));
        let drive = |t: f64| tones.iter().map(|(size, rate, phase)| size * (rate * t + phase).cos()).sum();
        fs::write(path, self.slider.record(&drive, dice)).expect("data");
    }

    /// Its spec: all numbers held, or all but the mass to be found from other ones.
    fn spec(&self, path: &Path, data: &str, held: bool) {
        let Slider { mass, stiffness: k, damping: c, friction: f, .. } = self.slider;
        let numbers = if held {
            self.slider.constants()
        } else {
            let [k0, k1, k2, c2, f1, f2] = [1.05 * k, 0.5 * k, 2.0 * k, 8.0 * c, 0.7 * f, 8.0 * f];
            format!(
                r#""m": ({mass:?}, "kg"), "k": (value: {k0:?}, unit: "N/m", within: ({k1:?}, {k2:?})),
                "c": (value: {c:?}, unit: "N*s/m", within: (0.0, {c2:?})), "Fc": Find(start: {f1:?}, unit: "N", within: (0.0, {f2:?}))"#
            )
        };
        fs::write(path, spec(&numbers, data)).expect("a spec");
    }
}

fn compared(paths: &[&str]) -> (i32, Value) {
    let Outcome { code, out, err } =
        phisindy(&[&["compare"], paths, &["--format", "json", "--quiet"]].concat());
    (code, serde_json::from_str(&out).unwrap_or_else(|_| panic!("no JSON: {out}{err}")))
}

/// Names of what is told: numbers that changed, laws that are new.
fn told(of: &Value) -> Vec<String> {
    let list = |key: &str| of[key].as_array().expect("a list").clone();
    let text = |value: &Value| value.as_str().expect("text").to_owned();
    let causes = list("causes");
    list("changed").iter().map(text).chain(causes.iter().map(|cause| text(&cause["law"]))).collect()
}

/// A kind of change: what it is called, what it does, and what is to be told.
type Kind = (&'static str, fn(&mut Rig), &'static [&'static str]);

const KINDS: &[Kind] = &[
    ("nothing", |_| {}, &[]),
    ("friction -20 %", |rig| rig.slider.friction *= 0.8, &["Fc"]),
    ("stiffness -3 %", |rig| rig.slider.stiffness *= 0.97, &["k"]),
    ("a play", |rig| rig.slider.play = 0.12 * rig.drive / rig.slider.stiffness, &["dead zone (play)"]),
    ("another sensor", |rig| rig.slider.gain = 1.03, &["gain of x"]),
];

fn setting(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

#[test]
fn what_changed_is_told_by_its_name() {
    let (pairs, seed) = (setting("PHISINDY_PAIRS", 1), setting("PHISINDY_SEED", 1));
    for (k, (kind, change, wanted)) in KINDS.iter().enumerate() {
        let mut right = 0;
        for pair in 0..pairs {
            let mut dice = Dice::new(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (1000 * pair + 7 * k as u64));
            let scratch = Scratch::new("pair");
            let old = Rig::drawn(&mut dice);
            let mut new = old;
            change(&mut new);
            for (name, rig) in [("old", old), ("new", new)] {
                rig.record(&scratch.0.join(format!("{name}.csv")), &mut dice);
                // The spec is that of the machine as it was.
                old.spec(&scratch.0.join(format!("{name}.ron")), &format!("{name}.csv"), pair % 2 == 1);
            }
            let (code, of) = compared(&[&scratch.path("old.ron"), &scratch.path("new.ron")]);
            let good = told(&of) == *wanted && code == i32::from(!wanted.is_empty());
            right += u64::from(good);
            if !good {
                eprintln!("{kind}, pair {pair}: {} {:?}", of["verdict"], told(&of));
            }
        }
        if pairs > 1 {
            eprintln!("{kind}: {right} of {pairs} right");
        }
        // What is promised: a change has its name in 95 of 100, nothing is called a change in 2 of 100. By binomial chance
        // such a rate falls below this once in a thousand.
        let wrong = if wanted.is_empty() { 0.02 } else { 0.05 };
        let least = (1.0 - wrong) * pairs as f64 - 3.0 * (wrong * pairs as f64).sqrt();
        assert!(right as f64 >= least && right > 0, "{kind}: {right} of {pairs}");
    }
}

/// Some of the drawn pairs had a covariance with a negative variance, which became a change of the mass.
#[test]
fn numbers_that_trade_off_do_not_look_changed() {
    let mut dice = Dice::new(4901_u64.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 8000);
    let (scratch, rig) = (Scratch::new("trade-off"), Rig::drawn(&mut dice));
    for name in ["old", "new"] {
        rig.record(&scratch.0.join(format!("{name}.csv")), &mut dice);
        rig.spec(&scratch.0.join(format!("{name}.ron")), &format!("{name}.csv"), false);
    }
    let (code, of) = compared(&[&scratch.path("old.ron"), &scratch.path("new.ron")]);
    assert_eq!((code, told(&of)), (0, vec![]), "{of}");
}

/// `PHISINDY_FLEET=200` makes it a large one, with five worn machines.
#[test]
fn a_worn_machine_of_a_fleet_comes_first() {
    let (scratch, mut dice) = (Scratch::new("fleet"), Dice::new(setting("PHISINDY_SEED", 3)));
    let count = setting("PHISINDY_FLEET", 12) as usize;
    let worn: Vec<usize> = if count < 200 { vec![8] } else { (0..5).map(|k| 8 + k * count / 5).collect() };
    let base = Rig { slider: Slider::plain(2.0, 800.0, 1.5, 0.7), drive: 4.0 };
    let mut paths = vec![];
    for k in 0..count {
        let mut rig = base;
        rig.slider.stiffness *= 1.0 + 0.01 * dice.normal();
        rig.slider.friction *= if worn.contains(&k) { 1.5 } else { 1.0 + 0.03 * dice.normal() };
        rig.record(&scratch.0.join(format!("{k}.csv")), &mut dice);
        base.spec(&scratch.0.join(format!("{k}.ron")), &format!("{k}.csv"), false);
        paths.push(scratch.path(&format!("{k}.ron")));
    }
    let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
    let (code, of) = compared(&paths);
    let machines = of["machines"].as_array().expect("machines");
    assert_eq!((code, machines.len()), (1, count));
    let first: Vec<&str> =
        machines[..worn.len() + 1].iter().filter_map(|machine| machine["name"].as_str()).collect();
    assert!(worn.iter().all(|&k| first.contains(&paths[k])), "{first:?}");
    assert_eq!(
        (&machines[0]["needs_care"], worn.iter().any(|&k| first[0] == paths[k])),
        (&true.into(), true),
        "{}",
        machines[0]
    );
    let stands_out = |n: &Value| n["name"] == "Fc" && n["stands_out"] == true;
    assert!(machines[0]["numbers"].as_array().expect("numbers").iter().any(stands_out), "{}", machines[0]);
    // The spread of friction is that of the others.
    let friction =
        of["spreads"].as_array().expect("spreads").iter().find(|s| s["name"] == "Fc").expect("friction");
    let spread =
        friction["spread"].as_f64().expect("a number") / friction["mean"].as_f64().expect("a number");
    assert!((0.012..0.06).contains(&spread), "{friction}");
}

/// A folder of a result stands for its spec, and the comparison is kept with its picture.
#[test]
fn results_are_compared_and_kept() {
    let (scratch, mut dice) = (Scratch::new("results"), Dice::new(9));
    let mut rig = Rig::drawn(&mut dice);
    for name in ["old", "new"] {
        rig.record(&scratch.0.join(format!("{name}.csv")), &mut dice);
        // The model lacks its friction, which `gap` finds.
        let path = scratch.0.join(format!("{name}.ron"));
        rig.spec(&path, &format!("{name}.csv"), true);
        let text = fs::read_to_string(&path).expect("a spec");
        let start = text.find(r#", "Fc": ("#).expect("its friction");
        let end = start + text[start..].find(')').expect("an end") + 1;
        let text = format!("{}{}", &text[..start], &text[end..]).replace(" - Fc*sgn(v)", "");
        fs::write(&path, text).expect("a spec");
        rig.slider.friction *= 0.8;
    }
    let (old, new, out) = (scratch.path("old.ron"), scratch.path("new.ron"), scratch.path("found"));
    assert_eq!(phisindy(&["gap", &old, "--out", &out, "--quiet"]).code, 0);
    let kept = scratch.path("compared");
    let done = phisindy(&["compare", &out, &new, "--out", &kept, "--quiet", "--format", "text"]);
    assert_eq!(done.code, 1, "{}", done.err);
    assert!(
        done.out.starts_with("changed: Fc fell by ") || done.out.starts_with("changed: Fc_v fell by "),
        "{}",
        done.out
    );
    assert!(done.out.contains("not changed beyond these errors: "), "{}", done.out);
    let page = fs::read_to_string(scratch.0.join("compared/report.html")).expect("a report");
    assert!(page.contains("Fc fell by") && page.ends_with("</html>\n"));
    assert!(scratch.0.join("compared/figures/numbers.svg").is_file());
    // The forces of both records lie on top of each other: friction over speed, the spring over displacement.
    let forces = fs::read_to_string(scratch.0.join("compared/figures/forces.svg")).expect("a figure");
    for words in ["resisting force (N)", "restoring force (N)", "older: ", "newer: "] {
        assert!(forces.contains(words), "{words}: {forces}");
    }
    // What is read is not replaced, and nothing is done before that is said.
    for command in [&["compare", &new, &out][..], &["next", &out]] {
        let done = phisindy(&[command, &["--out", &format!("{out}/"), "--force"]].concat());
        assert!(done.code == 2 && done.err.contains("is what is read"), "{}", done.err);
        assert_eq!(done.out, "");
    }
}

#[test]
fn what_cannot_be_compared_is_told() {
    let (scratch, mut dice) = (Scratch::new("strangers"), Dice::new(5));
    let rig = Rig::drawn(&mut dice);
    rig.record(&scratch.0.join("a.csv"), &mut dice);
    rig.spec(&scratch.0.join("a.ron"), "a.csv", true);
    let text = fs::read_to_string(scratch.0.join("a.ron")).expect("a spec");
    fs::write(scratch.0.join("b.ron"), text.replace("\"x\"", "\"y\"").replace("k*x", "k*y")).expect("a spec");
    let [a, b] = ["a.ron", "b.ron"].map(|name| scratch.path(name));
    let empty = scratch.path("empty");
    fs::create_dir(&empty).expect("a folder");
    for (paths, why) in [
        (vec![a.as_str(), "nowhere.ron"], "nowhere.ron"),
        (vec![&a, &empty], "no folder of a result"),
        (vec![&a, &b], "column"),
        (vec![&a], "2 values required"),
    ] {
        let Outcome { code, out, err } = phisindy(&[&["compare"], paths.as_slice(), &["--quiet"]].concat());
        assert_eq!((code, out.as_str()), (2, ""), "{paths:?}: {err}");
        assert!(err.contains(why), "{err}");
    }
}
