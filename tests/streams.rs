//! Records whose channels have clocks of their own. Data of an integrator that is not the program's.
#![allow(missing_docs)]

use crate::common::slider::Dice;
use crate::common::{Outcome, Scratch, phisindy};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;

const FRICTION: f64 = 1.2;

/// What pushes: two tones, the faster one beyond what 30 samples a second show.
fn push(t: f64) -> f64 {
    4.0 * (TAU * 0.9 * t).sin() + 9.0 * (TAU * 13.0 * t).sin()
}

/// Places of 1.5 kg on 50 N/m with friction at each of these times.
fn places(times: &[f64]) -> Vec<f64> {
    motion(times).into_iter().map(|(x, _)| x).collect()
}

/// Places and accelerations there, by steps in which friction takes what it can of the speed (J. J. Moreau, Unilateral
/// contact and dry friction in finite freedom dynamics, 1988). With steps of 10 us the accelerations would be visibly late.
fn motion(times: &[f64]) -> Vec<(f64, f64)> {
    let (h, m, k, c) = (1e-6, 1.5, 50.0, 0.5);
    let [mut x, mut v, mut a, mut now] = [0.0_f64; 4];
    let mut all = vec![];
    for &t in times {
        while now + h <= t {
            let free = v + h * (push(now) - k * x - c * v) / m;
            let most = h * FRICTION / m;
            let after = free - free.clamp(-most, most);
            (a, v) = ((after - v) / h, after);
            x += h * v;
            now += h;
        }
        all.push((x + (t - now) * v, a));
    }
    all
}

/// So many samples a second, up to an end.
fn times(rate: f64, seconds: f64) -> Vec<f64> {
    (0..(rate * seconds) as usize).map(|k| k as f64 / rate).collect()
}

/// The noise of a good camera (m).
const FINE: f64 = 2e-5;

/// A camera at 30 Hz that stamps a frame late and by a clock that runs fast: `t_ms`, `x_mm`.
fn camera(seconds: f64, (late, drift): (f64, f64), noise: f64, dice: &mut Dice) -> String {
    let stamps = times(30.0, seconds);
    let seen: Vec<f64> = stamps.iter().map(|t| t + drift * t - late).collect();
    let mut text = "t_ms,x_mm\n".to_owned();
    for (t, x) in stamps.iter().zip(places(&seen)) {
        let _ = writeln!(text, "{},{}", 1e3 * t, 1e3 * (x + noise * dice.normal()));
    }
    text
}

/// A load cell at 1 kHz: `t_us`, `F_N`.
fn cell(seconds: f64) -> String {
    let mut text = "t_us;F_N\n".to_owned();
    for t in times(1e3, seconds) {
        let _ = writeln!(text, "{:.0};{}", 1e6 * t, push(t));
    }
    text
}

const CAMERA: &str = r#""x": (path: "camera.csv", time: ("t_ms", "ms"), column: ("x_mm", "mm"))"#;
const CELL: &str = r#""F": (path: "cell.csv", time: ("t_us", "us"), column: ("F_N", "N"))"#;

fn spec(record: &str) -> String {
    format!(
        r#"(
    constants: {{ "m": (1.5, "kg"), "k": Find(start: 40.0, unit: "N/m", within: (5.0, 500.0)), "c": Find(start: 1.0, unit: "N*s/m", within: (0.0, 20.0)) }},
    states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "F": "N" }},
    known: {{ "x": "v", "v": "(F - k*x - c*v)/m" }}, inertia: {{ "v": "m" }},
    unknown: {{ "v": (factor: "-sgn(v)/m", candidates: ["1"]) }}, contacts: ["v"],
    data: [ {record} ],
)
"#
    )
}

/// Runs `command` on a record of these files.
fn run(command: &str, name: &str, record: &str, files: &[(&str, &str)]) -> Outcome {
    let scratch = Scratch::new(name);
    files.iter().for_each(|(file, text)| fs::write(scratch.path(file), text).expect("a file"));
    let path = scratch.path("case.ron");
    fs::write(&path, spec(record)).expect("a spec");
    phisindy(&[command, &path, "--format", "json", "--quiet"])
}

/// The friction of a result, and its standard error.
fn friction(said: &Outcome) -> (f64, f64) {
    let json: Value =
        serde_json::from_str(&said.out).unwrap_or_else(|_| panic!("{}\n{}", said.out, said.err));
    let term = &json["equations"][0]["terms"][0];
    let number = |key: &str| term[key].as_f64().unwrap_or_else(|| panic!("{json:#}"));
    (number("coefficient"), number("std_error"))
}

#[test]
fn each_stream_has_its_own_times() {
    let mut dice = Dice::new(1);
    let files = [("camera.csv", &*camera(12.0, (0.0, 0.0), FINE, &mut dice)), ("cell.csv", &*cell(12.0))];
    let said = run("run", "streams", &format!("Csv(streams: {{ {CAMERA}, {CELL} }})"), &files);
    let (found, error) = friction(&said);
    assert!((found - FRICTION).abs() < 4.0 * error && error < 0.005, "{found} +- {error}\n{}", said.err);
    // At the camera's frames alone the faster tone is not to be seen.
    let of_camera = "Csv(path: \"camera.csv\", time: (\"t_ms\", \"ms\"), columns: { \"x\": (\"x_mm\", \"mm\") }, streams: { CELL })";
    let again = run("run", "streams-rows", &of_camera.replace("CELL", CELL), &files);
    assert_eq!(friction(&again), (found, error), "{}", again.err);
}

/// An accelerometer at 1 kHz, whose samples lie beside the frames of a camera: `t_s`, `a`.
fn accelerometer(seconds: f64, dice: &mut Dice) -> String {
    let stamps: Vec<f64> = times(1e3, seconds).iter().map(|t| t + 3.3e-4).collect();
    let mut text = "t_s,a\n".to_owned();
    for (t, (_, a)) in stamps.iter().zip(motion(&stamps)) {
        let _ = writeln!(text, "{t},{}", a + 0.05 * dice.normal());
    }
    text
}

/// At the frames alone the accelerometer tells little: all of its samples are compared.
#[test]
fn outputs_are_compared_at_their_own_samples() {
    let mut dice = Dice::new(5);
    let scratch = Scratch::new("streams-outputs");
    let shaken = accelerometer(4.0, &mut dice);
    let files = [("camera.csv", camera(4.0, (0.0, 0.0), 2e-3, &mut dice)), ("cell.csv", cell(4.0))];
    files.iter().for_each(|(file, text)| fs::write(scratch.path(file), text).expect("a file"));
    let stream = r#""a": (path: "a.csv", time: ("t_s", "s"), column: ("a", "m/s^2"))"#;
    let text = spec(&format!("Csv(streams: {{ {CAMERA}, {CELL}, {stream} }})"))
        .replace("    known:", r#"    outputs: { "a": (unit: "m/s^2", reads: "rate(v)") }, known:"#);
    let path = scratch.path("case.ron");
    let run = |command: &str, text: &str, every: usize| {
        let rows = shaken.lines().enumerate().filter(|(row, _)| row % every == 0);
        fs::write(scratch.path("a.csv"), rows.map(|(_, line)| format!("{line}\n")).collect::<String>())
            .expect("a file");
        fs::write(&path, text).expect("a spec");
        phisindy(&[command, &path, "--format", "json", "--quiet"])
    };
    let said = run("run", &text, 1);
    let (found, error) = friction(&said);
    assert!((found - FRICTION).abs() < 4.0 * error, "{found} +- {error}\n{}", said.err);
    assert!(said.out.contains(r#""verdict":"identified""#), "{}", said.out);
    let (_, of_few) = friction(&run("run", &text, 30));
    assert!(of_few > 2.0 * error, "{of_few} {error}");
    // A law that is missing is found from both.
    let lacking = text.replace(r#""v": (factor: "-sgn(v)/m", candidates: ["1"])"#, "");
    assert!(lacking != text);
    let said = run("gap", &lacking, 1);
    assert!(said.out.contains(r#""status":"explained""#), "{}{}", said.out, said.err);
    assert!(said.out.contains(r#""law":"coulomb""#), "{}", said.out);
}

/// A logger that shows means over 20 ms takes a tenth off the faster tone, and is late by half of that.
#[test]
fn a_logger_shows_means() {
    let mut dice = Dice::new(6);
    let mut text = "t_s,x_m\n".to_owned();
    let parts = 50;
    let rate = 50.0 * f64::from(parts);
    let fine = places(&times(rate, 8.0).iter().map(|t| t + 0.5 / rate).collect::<Vec<_>>());
    for (k, of) in fine.chunks(parts as usize).enumerate() {
        let mean = of.iter().sum::<f64>() / of.len() as f64;
        let _ = writeln!(text, "{},{}", (k + 1) as f64 / 50.0, mean + 2e-5 * dice.normal());
    }
    let files = [("log.csv", &*text), ("cell.csv", &*cell(9.0))];
    let stream = r#""x": (path: "log.csv", time: ("t_s", "s"), column: ("x_m", "m"))"#;
    let record =
        format!("Csv(streams: {{ {stream}, {CELL} }}, sensors: {{ \"x\": (average: (20.0, \"ms\")) }})");
    let said = run("run", "streams-mean", &record, &files);
    let (found, error) = friction(&said);
    assert!((found - FRICTION).abs() < 4.0 * error && error < 0.005, "{found} +- {error}\n{}", said.err);
    let at_once = run("run", "streams-at-once", &record.replace("20.0", "0.0"), &files);
    let (_, wide) = friction(&at_once);
    assert!(wide > 10.0 * error, "{wide} {error}");
    for (wrong, what) in [("(20.0, \"mm\")", "averaged over no time"), ("-1.0", "averaged over no time")] {
        let said = run("check", "streams-no-mean", &record.replace("(20.0, \"ms\")", wrong), &files);
        assert!(said.code == 2 && said.err.contains(what), "{wrong}: {}", said.err);
    }
    let of_input = record.replace("sensors: { \"x\"", "sensors: { \"F\"");
    let said = run("check", "streams-mean-of-input", &of_input, &files);
    assert!(said.code == 2 && said.err.contains("is an input"), "{}", said.err);
}

/// A log of two channels in one table: most rows have an empty cell.
fn merged(seed: u64) -> String {
    let mut dice = Dice::new(seed);
    let stamps = times(500.0, 12.0);
    let mut text = "t_s,F_N,x_m\n".to_owned();
    for (k, (t, x)) in stamps.iter().zip(places(&stamps)).enumerate() {
        let x = if k % 16 == 3 { (x + 2e-5 * dice.normal()).to_string() } else { String::new() };
        let force = if k % 2 == 1 { push(*t).to_string() } else { String::new() };
        let _ = writeln!(text, "{t},{force},{x}");
    }
    text
}

#[test]
fn a_merged_file_has_two_streams() {
    let text = merged(2);
    let record = "Csv(path: \"log.csv\", time: (\"t_s\", \"s\"), streams: { \"x\": (column: \"x_m\"), \"F\": (column: \"F_N\") })";
    let said = run("run", "streams-merged", record, &[("log.csv", &text)]);
    let (found, error) = friction(&said);
    assert!((found - FRICTION).abs() < 4.0 * error && error < 0.005, "{found} +- {error}\n{}", said.err);
}

#[test]
fn what_is_wrong_with_a_stream_is_told() {
    let mut dice = Dice::new(3);
    let (seen, pushed) = (camera(3.0, (0.0, 0.0), FINE, &mut dice), cell(3.0));
    let back = pushed.replace("\n1500000;", "\n500;");
    let record = |camera: &str, cell: &str| format!("Csv(streams: {{ {camera}, {cell} }})");
    // A minute later than the camera.
    let minute = |line: &str| match line.split_once(';') {
        Some((t, force)) if t != "t_us" => format!("{:.0};{force}\n", t.parse::<f64>().unwrap_or(0.0) + 6e7),
        _ => format!("{line}\n"),
    };
    let far: String = pushed.lines().map(minute).collect();
    for (record, cell, what) in [
        (record(CAMERA, CELL), &back, "the time goes back from 1499000 to 500"),
        (record(CAMERA, CELL), &far, "no time lies in both"),
        (record(CAMERA, &CELL.replace("F_N", "f_N")), &pushed, "no column `f_N`"),
        (
            record(CAMERA, &CELL.replace("\"F\"", "\"G\"")),
            &pushed,
            "unknown state, output or input in `columns` `G`",
        ),
        (record(CAMERA, &CELL.replace("\"us\"", "\"m\"")), &pushed, "`m` is no unit of time"),
        (record(CAMERA, &CELL.replace("cell.csv", "../cell.csv")), &pushed, "leads out of the data folder"),
        (
            record(CAMERA, &CELL.replace("cell.csv", "cells.csv")),
            &pushed,
            "there is no data file `cells.csv`",
        ),
        (
            record(CAMERA, &CELL.replace("time: (\"t_us\", \"us\"), ", "")),
            &pushed,
            "the field `time` of a stream is missing",
        ),
        (record(&format!("{CAMERA}, {CAMERA}"), CELL), &pushed, "the key `x` stands here twice"),
        (
            record(CAMERA, CELL)
                .replace("Csv(", "Csv(columns: { \"F\": \"F_N\" }, time: \"t\", path: \"cell.csv\", "),
            &pushed,
            "`F` stands in `columns` and in `streams`",
        ),
    ] {
        let said = run("run", "streams-wrong", &record, &[("camera.csv", &seen), ("cell.csv", cell)]);
        assert!(said.code == 2 && said.err.contains(what), "{record}: {} {}", said.code, said.err);
    }
}

/// A number of a sensor in a result, and its standard error.
fn sensor(said: &Outcome, name: &str) -> (f64, f64) {
    let json: Value =
        serde_json::from_str(&said.out).unwrap_or_else(|_| panic!("{}\n{}", said.out, said.err));
    let all = json["parameters"].as_array().unwrap_or_else(|| panic!("{json:#}"));
    let own = all.iter().find(|p| p["name"] == name).unwrap_or_else(|| panic!("{json:#}"));
    let number = |key: &str| own[key].as_f64().unwrap_or_else(|| panic!("{json:#}"));
    (number("value"), number("std_error"))
}

#[test]
fn the_offset_and_the_drift_of_a_clock_are_found() {
    let mut dice = Dice::new(4);
    let (late, drift) = (0.037, 50e-6);
    let files = [("camera.csv", &*camera(40.0, (late, drift), FINE, &mut dice)), ("cell.csv", &*cell(40.0))];
    let record = |sensors: &str| format!("Csv(streams: {{ {CAMERA}, {CELL} }}, sensors: {{ {sensors} }})");
    let find = |delay: &str, clock: &str| {
        format!("(delay: Find(start: 0.0, within: {delay}), clock: Find(start: 0.0, within: {clock}))")
    };
    let of_camera = find("(-0.2, 0.2)", "(-1e-3, 1e-3)");
    let said = run("run", "streams-clock", &record(&format!("\"x\": {of_camera}")), &files);
    let ((found, error), (delay, of_delay), (clock, of_clock)) =
        (friction(&said), sensor(&said, "x.delay"), sensor(&said, "x.clock"));
    assert!((found - FRICTION).abs() < 4.0 * error && error < 0.005, "{found} +- {error}\n{}", said.err);
    assert!((delay - late).abs() < 4.0 * of_delay && of_delay < 1e-3, "{delay} +- {of_delay}");
    assert!((clock - drift).abs() < 4.0 * of_clock && of_clock < 2e-5, "{clock} +- {of_clock}");
    // The clock of the load cell is as much too early and too slow: nearly the same numbers, the other way round.
    let of_cell = find("(-0.2, 0.2)", "(-1e-3, 1e-3)");
    // What pushed before its first sample is not known: the camera looks on from a tenth of a second later.
    let lines = files[0].1.lines().enumerate().filter(|(k, _)| !(1..4).contains(k));
    let later = lines.map(|(_, line)| format!("{line}\n")).collect::<String>();
    let files = [("camera.csv", &*later), files[1]];
    let again = run("run", "streams-clock-input", &record(&format!("\"F\": {of_cell}")), &files);
    let ((delay, of_delay), (clock, of_clock)) = (sensor(&again, "F.delay"), sensor(&again, "F.clock"));
    assert!((delay + late - 0.1 * drift).abs() < 4.0 * of_delay && of_delay < 1e-3, "{delay} +- {of_delay}");
    assert!((clock + drift).abs() < 4.0 * of_clock && of_clock < 2e-5, "{clock} +- {of_clock}");
}

#[test]
fn counts_that_begin_anew_are_an_angle() {
    // A rotor that turns on, 4096 counts a turn, read at 500 Hz.
    let rate = |t: f64| 30.0 * t + 4.0 * (3.0 * t).sin();
    let mut text = "t,enc\n".to_owned();
    for t in times(500.0, 4.0) {
        let _ = writeln!(text, "{t},{}", (rate(t) / TAU * 4096.0).round().rem_euclid(4096.0));
    }
    let scratch = Scratch::new("streams-counts");
    fs::write(scratch.path("rotor.csv"), &text).expect("a file");
    let simulated = |sensor: &str| {
        let path = scratch.path("case.ron");
        let spec = format!(
            r#"(states: {{ "q": "rad", "w": "rad/s" }}, known: {{ "q": "w", "w": "-a*sin(3*t)" }}, unknown: {{}}, constants: {{ "a": Find(start: 20.0, within: (0.0, 90.0)) }},
                data: [ Csv(path: "rotor.csv", time: "t", columns: {{ "q": "enc" }}, sensors: {{ "q": {sensor} }}) ])"#
        );
        fs::write(&path, spec).expect("a spec");
        phisindy(&["run", &path, "--format", "json", "--quiet"])
    };
    let said = simulated("(per: (\"rev\", 4096), unwrap: \"2*pi\")");
    assert_eq!(said.code, 0, "{}\n{}", said.out, said.err);
    for (sensor, what) in [
        ("(per: (\"rev\", 4096), quantum: 1e4)", "the quantum of `q` is larger than what it shows"),
        ("(per: (\"rev\", 0))", "expected a number greater than zero"),
        ("(per: (\"kg\", 4096))", "cannot be converted to `rad`"),
        ("(unwrap: \"2*q\")", "`2*q` is no turn"),
        ("(quantum: (0.1, \"mm\"))", "the quantum of `q`"),
    ] {
        let said = simulated(sensor);
        assert!(said.code == 2 && said.err.contains(what), "{sensor}: {} {}", said.code, said.err);
    }
}

#[test]
fn a_draft_of_a_merged_log_has_streams() {
    let text = merged(5);
    let scratch = Scratch::new("streams-draft");
    let (data, draft) = (scratch.path("log.csv"), scratch.path("case.ron"));
    fs::write(&data, &text).expect("a file");
    let said = phisindy(&["new", &data, "--out", &draft]);
    assert_eq!(said.code, 0, "{}", said.err);
    let spec = fs::read_to_string(&draft).expect("a draft");
    let streams = r#"streams: { "x": (column: ("x_m", "m")), "F": (column: ("F_N", "N")) }"#;
    assert!(spec.contains(streams), "{spec}");
    assert!(said.err.contains("`F_N` in 3000, `x_m` in 375"), "{}", said.err);
    assert_eq!(phisindy(&["check", &draft]).code, 0);
}

#[test]
fn what_drives_is_read_before_a_window() {
    let mut dice = Dice::new(6);
    let stamps = times(200.0, 12.0);
    let mut text = "t,x,F\n".to_owned();
    // A command that stands in the log two seconds before it acts.
    for (t, x) in stamps.iter().zip(places(&stamps)) {
        let _ = writeln!(text, "{t},{},{}", x + 2e-5 * dice.normal(), push(t + 2.0));
    }
    let record = "Csv(path: \"log.csv\", time: \"t\", columns: { \"x\": \"x\", \"F\": \"F\" }, window: (5.0, 11.0), sensors: { \"F\": SENSOR })";
    for sensor in ["(delay: -2.0)", "(delay: Find(start: -2.02, within: (-2.2, -1.8)))"] {
        let said = run("run", "streams-window", &record.replace("SENSOR", sensor), &[("log.csv", &text)]);
        let (found, error) = friction(&said);
        let near = (found - FRICTION).abs() < 4.0 * error && error < 0.005;
        assert!(said.code == 0 && near, "{sensor}: {found} +- {error}\n{}\n{}", said.out, said.err);
    }
}

/// What a controller puts out: another level every 48 ms, none before the log begins.
fn level(t: f64) -> f64 {
    let mixed = (((t / 0.048).floor() as i64 + 7) as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    match t {
        t if t < 0.0 => 0.0,
        _ => 16.0 * (((mixed ^ (mixed >> 29)) >> 11) as f64 / (1_u64 << 53) as f64 - 0.5),
    }
}

/// A log of the command, at 250 Hz, and of the places of 1.5 kg on 50 N/m with friction on which it acts 20 ms later.
fn late_command(seconds: f64, dice: &mut Dice) -> String {
    let (h, m, k, c) = (1e-5, 1.5, 50.0, 0.5);
    let [mut x, mut v] = [0.0_f64; 2];
    let mut text = "t,cmd,x\n".to_owned();
    for i in 0..(seconds / h) as usize {
        let now = i as f64 * h;
        if i % 400 == 0 {
            let _ = writeln!(text, "{now:.3},{},{}", level(now + 1e-9), x + 2e-5 * dice.normal());
        }
        let free = v + h * (level(now + 0.5 * h - 0.02) - k * x - c * v) / m;
        let most = h * FRICTION / m;
        v = free - free.clamp(-most, most);
        x += h * v;
    }
    text
}

#[test]
fn a_held_command_that_is_late_is_found() {
    let text = late_command(12.0, &mut Dice::new(8));
    let record = |sensor: &str| {
        let of = |window: &str, role: &str| {
            format!(
                "Csv(path: \"log.csv\", name: \"{role}\", time: \"t\", columns: {{ \"x\": \"x\", \"F\": \"cmd\" }}, interpolate: {{ \"F\": Hold }}, sensors: {{ {sensor} }}, window: {window}, role: {role})"
            )
        };
        format!("{}, {}", of("(0.0, 8.0)", "Fit"), of("(8.0, 12.0)", "Validate"))
    };
    let files = [("log.csv", &*text)];
    // Wherever the search starts, a part of a sample off too.
    for start in ["0.0", "0.0015", "-0.03"] {
        let found = record(&format!("\"F\": (delay: Find(start: {start}, within: (-0.2, 0.2)))"));
        let said = run("run", "streams-held", &found, &files);
        let ((found, error), (delay, of_delay)) = (friction(&said), sensor(&said, "F.delay"));
        assert!(
            said.code == 0 && (found - FRICTION).abs() < 4.0 * error && error < 0.005,
            "{start}: {found} +- {error}\n{}",
            said.err
        );
        assert!((delay + 0.02).abs() < 4.0 * of_delay && of_delay < 1e-4, "{start}: {delay} +- {of_delay}");
    }
    // Nobody says that anything is late, or that there is friction.
    let said = run("gap", "streams-held-gap", &record(""), &files);
    let json: Value =
        serde_json::from_str(&said.out).unwrap_or_else(|_| panic!("{}\n{}", said.out, said.err));
    let laws: Vec<&str> =
        json["steps"].as_array().into_iter().flatten().filter_map(|s| s["law"].as_str()).collect();
    assert!(said.code == 0 && laws.len() == 2 && laws.contains(&"coulomb"), "{json:#}");
    assert!(laws.contains(&"input-delay") || laws.contains(&"sensor-delay"), "{laws:?}");
}
