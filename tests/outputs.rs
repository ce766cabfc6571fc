//! What sensors read that is no state: accelerometers and force cells, from `run` and `gap` to the completed
//! spec.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder for the test");
    folder
}

fn phisindy(folder: &Path, command: &str, spec: &str, arguments: &[&str]) -> Output {
    let path = folder.join("spec.ron");
    std::fs::write(&path, spec).expect("the spec can be written");
    let mut program = Command::new(env!("CARGO_BIN_EXE_phisindy"));
    program
        .current_dir(folder)
        .arg(command)
        .args(arguments)
        .arg("spec.ron")
        .output()
        .expect("the program runs")
}

fn json(out: &Output) -> Value {
    let text = String::from_utf8_lossy(&out.stdout);
    serde_json::from_str(&text)
        .unwrap_or_else(|e| panic!("{e}: {text}{}", String::from_utf8_lossy(&out.stderr)))
}

/// A mass on a spring, pushed by a measured force, seen by an accelerometer alone.
fn accelerometer(unknown: &str, seed: u32) -> String {
    format!(
        r#"(states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "f": "N" }},
            outputs: {{ "a": (unit: "m/s^2", reads: "rate(v)") }},
            constants: {{ "m": (1.0, "kg"), "k": (value: 380.0, unit: "N/m", within: (200.0, 800.0)), "c": (value: 2.0, unit: "N*s/m", within: (0.0, 20.0)) }},
            known: {{ "x": "v", "v": "(f - k*x - c*v)/m" }}, inertia: {{ "v": "m" }}, {unknown}
            data: [ Synthetic(truth: {{ "v": "(-1.5*sgn(v) - 20*x + 1.0*v)/m" }}, start: {{}}, duration: 8.0, step: 0.005, noise: Additive(0.01), seed: {seed},
                inputs: {{ "f": Multisine(amplitude: 8.0, band: (0.5, 6.0)) }}) ])"#
    )
}

fn interval(value: &Value) -> (f64, f64, f64) {
    let of = |v: &Value| v.as_f64().unwrap_or(f64::NAN);
    let ci = &value["ci95"];
    (of(&value["value"]), of(&ci[0]), of(&ci[1]))
}

#[test]
fn an_accelerometer_alone_tells_friction_with_intervals_that_cover() {
    let unknown =
        r#"unknown: { "v": (factor: "-sgn(v)/m", candidates: ["1", "|x|", "v^2"]) }, contacts: ["v"],"#;
    let mut covered = 0;
    for seed in [5, 6, 7] {
        let spec = accelerometer(unknown, seed);
        let out = phisindy(&folder("outputs-run"), "run", &spec, &["--format", "json"]);
        assert_eq!(out.status.code(), Some(0), "{}", String::from_utf8_lossy(&out.stderr));
        let found = json(&out);
        let terms = found["equations"][0]["terms"].as_array().expect("terms");
        assert_eq!(terms.len(), 1, "{terms:?}");
        assert_eq!(terms[0]["candidate"], "1");
        let ci = &terms[0]["ci95"];
        let [low, high] = [&ci[0], &ci[1]].map(|v| v.as_f64().unwrap_or(f64::NAN));
        assert!(high - low < 0.02 && low < 1.505 && 1.495 < high, "{ci}");
        covered += usize::from(low <= 1.5 && 1.5 <= high);
    }
    // Of intervals of 95 % one in twenty misses: two of three do in seven of a thousand.
    assert!(covered > 1, "{covered}");
}

#[test]
fn gap_names_a_friction_that_only_an_accelerometer_sees() {
    let folder = folder("outputs-gap");
    let out =
        phisindy(&folder, "gap", &accelerometer("unknown: {},", 6), &["--format", "json", "--out", "out"]);
    let found = json(&out);
    assert_eq!((found["status"].as_str(), out.status.code()), (Some("explained"), Some(0)), "{found}");
    let step = &found["steps"][0];
    assert_eq!((step["law"].as_str(), step["at"].as_str()), (Some("coulomb"), Some("v")), "{step}");
    let (value, low, high) = interval(&step["parameters"]["Fc"]);
    assert!(low <= 1.5 && 1.5 <= high && high - low < 0.1, "{value} [{low}, {high}]");
    let completed = std::fs::read_to_string(folder.join("out/completed.ron")).expect("the completed spec");
    assert!(completed.contains(r#"reads: "rate(v)""#), "{completed}");
}

/// A force cell under a prescribed motion: no state at all.
#[test]
fn gap_names_the_friction_of_a_tester_without_a_state() {
    let text = r#"(states: {}, inputs: { "x": "mm", "dx": "mm/s" },
        outputs: { "R": (unit: "N", reads: "c*dx") }, constants: { "c": (value: 30.0, unit: "N*s/m", within: (0.0, 200.0)) },
        known: {}, unknown: {},
        data: [ Synthetic(truth: { "R": "(30+20*exp(-(dx/0.005)^2))*sgn(dx) - 10*dx" }, start: {}, duration: 20.0, step: 0.005, noise: Additive(0.02),
            seed: 8, inputs: { "x": Formula("10e-3*sin(2*t)+4e-3*sin(5*t)"), "dx": Formula("20e-3*cos(2*t)+20e-3*cos(5*t)") }) ])"#;
    let folder = folder("outputs-tester");
    let out = phisindy(&folder, "gap", text, &["--format", "json", "--out", "out"]);
    let found = json(&out);
    assert_eq!((found["status"].as_str(), out.status.code()), (Some("explained"), Some(0)), "{found}");
    let step = &found["steps"][0];
    assert_eq!((step["law"].as_str(), step["at"].as_str()), (Some("stribeck"), Some("dx")), "{step}");
    for (name, truth) in [("Fc", 30.0), ("Fs", 50.0), ("vs", 0.005)] {
        let (value, ..) = interval(&step["parameters"][name]);
        assert!((value / truth - 1.0).abs() < 0.02, "{name}: {value}");
    }
    // There is no body: no inertia, no acceleration.
    let report = std::fs::read_to_string(folder.join("out/report.html")).expect("a report");
    assert!(
        report.contains("Grey dots: the measured force less the known part of it")
            && !report.contains("inertia times")
    );
    let completed = std::fs::read_to_string(folder.join("out/completed.ron")).expect("the completed spec");
    let checked = phisindy(&folder, "check", &completed, &[]);
    assert_eq!(checked.status.code(), Some(0), "{completed}{}", String::from_utf8_lossy(&checked.stderr));
}

#[test]
fn mistakes_in_outputs_are_told_with_their_place() {
    let folder = folder("outputs-mistakes");
    let with = |output: &str| {
        format!(
            r#"(states: {{ "x": "m", "v": "m/s" }}, outputs: {{ {output} }}, constants: {{ "k": (4.0, "1/s^2") }},
                known: {{ "x": "v", "v": "-k*x" }}, unknown: {{}},
                data: [Synthetic(truth: {{}}, start: {{ "x": 1.0 }}, duration: 5.0, step: 0.01, noise: None)])"#
        )
    };
    for (output, told) in [
        (r#""a": (unit: "m/s^2", reads: "rate(w)")"#, "unknown state in `rate(...)` `w`"),
        (r#""a": (unit: "m/s", reads: "rate(v)")"#, "output `a` is"),
        (r#""a": (unit: "m/s^2", reads: "rate(2*v)")"#, "`rate` takes one name"),
        (r#""a": (unit: "m/s^2", reads: "rate(v*2)")"#, "`rate` takes one name"),
        (r#""a": (unit: "m/s^2", reads: "rate(rate(x))")"#, "`rate` takes one name"),
        (r#""a": (unit: "m/s^2", read: "rate(v)")"#, "did you mean `reads`"),
        (r#""x": (unit: "m", reads: "2*x")"#, "`x` is declared twice"),
        (r#""a": (unit: "m/s^2", reads: "-k*y")"#, "unknown name `y`"),
    ] {
        let out = phisindy(&folder, "check", &with(output), &[]);
        let text = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(2), "{output}: {text}");
        assert!(text.contains(told), "{output}: {text}");
    }
    // A mistake in an output is told once, and not where its name stands.
    let read = with(r#""a": (unit: "m/s^2", reads: "rate(w)")"#).replace("noise", "measure: [\"a\"], noise");
    let out = phisindy(&folder, "check", &read, &[]);
    let text = String::from_utf8_lossy(&out.stderr);
    assert!(text.matches("error:").count() == 1 && text.contains("`rate(...)` `w`"), "{text}");
    // The rate stands in outputs alone.
    let known = with(r#""a": (unit: "m/s^2", reads: "rate(v)")"#)
        .replace("-k*x\" }, unknown", "-k*rate(v)\" }, unknown");
    let out = phisindy(&folder, "check", &known, &[]);
    assert_eq!(out.status.code(), Some(2), "{}", String::from_utf8_lossy(&out.stderr));
}

/// The exported model shows what the sensor reads, while it sticks too.
#[test]
fn an_exported_model_reads_its_sensors() {
    let text = r#"(states: { "x": "m", "v": "m/s" }, inputs: { "u": "N" },
        outputs: { "a": (unit: "m/s^2", reads: "rate(v)"), "R": (unit: "N", reads: "c*v + F*sgn(v)") },
        constants: { "m": (1.2, "kg"), "k": (30.0, "N/m"), "c": (0.4, "N*s/m"), "F": (1.1, "N") },
        known: { "x": "v", "v": "(u - k*x - c*v - F*sgn(v))/m" }, inertia: { "v": "m" }, unknown: {}, contacts: ["v"],
        data: [ Synthetic(truth: {}, start: { "v": 0.4 }, duration: 4.0, step: 0.01, noise: None, seed: 1,
            inputs: { "u": Formula("3*sin(2*t)+1.5*sin(5*t)") }) ])"#;
    let folder = folder("outputs-export");
    let simulated = phisindy(&folder, "simulate", text, &[]).stdout;
    std::fs::write(folder.join("in.csv"), &simulated).expect("a file");
    let exported = phisindy(&folder, "export", text, &["--to", "python", "--out", "model.py"]);
    assert_eq!(exported.status.code(), Some(0), "{}", String::from_utf8_lossy(&exported.stderr));
    let input = std::fs::File::open(folder.join("in.csv")).expect("a file");
    let python = Command::new("python3").current_dir(&folder).arg("model.py").stdin(input).output();
    let column = |text: &str, name: &str| -> Vec<f64> {
        let k = text.lines().next().unwrap_or("").split(',').position(|h| h == name).expect(name);
        text.lines()
            .skip(1)
            .map(|l| l.split(',').nth(k).and_then(|c| c.parse().ok()).unwrap_or(f64::NAN))
            .collect()
    };
    let theirs = String::from_utf8(python.expect("python3 runs").stdout).expect("text");
    let ours = String::from_utf8(simulated).expect("text");
    for name in ["a", "R"] {
        let apart = column(&theirs, name).into_iter().zip(column(&ours, &format!("{name}_true")));
        let worst = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-3, "{name}: {worst}");
    }
    assert!(column(&theirs, "mode v").contains(&0.0), "it sticks somewhere");
}

/// A measured force with 5 % of noise: the noise passes through the plant, and the error bars count it.
#[test]
fn noise_of_an_input_enters_the_error_bars() {
    let text = |noise: &str| {
        format!(
            r#"(states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "f": "N" }},
                constants: {{ "m": (1.0, "kg"), "k": (value: 390.0, unit: "N/m", within: (200.0, 800.0)), "c": (value: 1.2, unit: "N*s/m", within: (0.0, 20.0)) }},
                known: {{ "x": "v", "v": "(f - k*x - c*v)/m" }}, inertia: {{ "v": "m" }},
                unknown: {{ "v": (factor: "-sgn(v)/m", candidates: ["1"]) }}, contacts: ["v"],
                data: [ Synthetic(truth: {{ "v": "(-1.5*sgn(v) - 10*x + 0.2*v)/m" }}, start: {{}}, duration: 10.0, step: 0.005,
                    noise: Sensor({{ "x": (2e-4, "m"), {noise} }}), seed: 5, inputs: {{ "f": Multisine(amplitude: 8.0, band: (0.5, 6.0)) }},
                    measure: ["x", "f"]) ])"#
        )
    };
    let folder = folder("outputs-input-noise");
    let run = |noise: &str| -> (f64, f64) {
        let found = json(&phisindy(&folder, "run", &text(noise), &["--format", "json"]));
        let term = &found["equations"][0]["terms"][0];
        let of = |key: &str| term[key].as_f64().unwrap_or(f64::NAN);
        (of("coefficient"), of("std_error"))
    };
    let (value, error) = run(r#""f": (0.4, "N")"#);
    let (_, exact) = run("");
    assert!((value - 1.5).abs() < 3.0 * error, "{value} +- {error}");
    assert!(error > 2.0 * exact, "{error} beside {exact} without the noise");
}

#[test]
fn a_cutoff_is_found_beside_the_friction_and_its_spec_runs_again() {
    let spec = r#"(states: { "x": "m", "v": "m/s" }, inputs: { "f": "N" },
        outputs: { "a": (unit: "m/s^2", reads: "rate(v)") },
        constants: { "m": (2.0, "kg"), "k": (800.0, "N/m"), "c": (1.0, "N*s/m") },
        known: { "x": "v", "v": "(f - k*x - c*v)/m" }, contacts: ["v"],
        unknown: { "v": (factor: "-sgn(v)/m", candidates: ["1", "v^2"]) },
        data: [ Synthetic(truth: { "v": "-1.5*sgn(v)/m" }, start: {}, duration: 5.0, step: 0.004, noise: Additive(0.01), seed: 8,
            sensors: { "a": (lowpass: (order: 2, cutoff: Find(start: 30.0, unit: "Hz", within: (5.0, 100.0))), highpass: (order: 1, cutoff: (0.5, "Hz"))) },
            inputs: { "f": Multisine(amplitude: 8.0, band: (0.5, 6.0)) }) ])"#;
    let folder = folder("outputs-filter");
    let out = phisindy(&folder, "run", spec, &["--format", "json", "--out", "found"]);
    assert_eq!(out.status.code(), Some(0), "{}", String::from_utf8_lossy(&out.stderr));
    let found = json(&out);
    let term = &found["equations"][0]["terms"][0];
    let (_, low, high) = interval(term);
    let force = &term["coefficient"];
    assert!(low < 1.5 && 1.5 < high && high - low < 0.1, "{force} [{low}, {high}]");
    let cutoff = &found["parameters"][0];
    assert_eq!(cutoff["name"], "a.lowpass.cutoff [synthetic 0]", "{cutoff}");
    let (value, low, high) = interval(cutoff);
    assert!(low < 30.0 && 30.0 < high && high - low < 3.0, "{value} [{low}, {high}]");
    let identified = std::fs::read_to_string(folder.join("found/identified.ron")).expect("identified.ron");
    assert!(identified.contains(&format!(r#"cutoff: ({value:?}, "Hz")"#)), "{identified}");
    let again = phisindy(&folder, "simulate", &identified, &[]);
    let header = String::from_utf8_lossy(&again.stdout).lines().next().map(str::to_owned);
    assert_eq!(header.as_deref(), Some("t,a,x_true,v_true,a_true,f"));
}

/// A friction tester is all outputs: it has inputs and a force, and nothing that moves by itself.
#[test]
fn a_model_without_states_has_an_answer() {
    let folder = folder("outputs-tester-2");
    let row = |k: u32| {
        let t = f64::from(k) * 0.005;
        let noise = 0.2 * (43758.5453 * (f64::from(k) * 12.9898).sin()).fract();
        format!("{t},{:.8},{:.6}\n", 0.01 * (6.0 * t).sin(), 0.06 * 800.0 * (6.0 * t).cos() + noise)
    };
    std::fs::write(folder.join("a.csv"), format!("t,x,F\n{}", (0..1200).map(row).collect::<String>()))
        .expect("a file");
    for c in [r#"(800.0, "N*s/m")"#, r#"(value: 700.0, unit: "N*s/m", within: (0.0, 2000.0))"#] {
        let spec = format!(
            r#"(constants: {{ "c": {c} }}, states: {{}}, inputs: {{ "x": "m", "dx": "m/s" }}, outputs: {{ "F": (unit: "N", reads: "c*dx") }},
                known: {{}}, unknown: {{}},
                data: [Csv(path: "a.csv", time: "t", columns: {{ "x": "x", "F": "F" }}, derive: {{ "dx": Derivative("x") }})])"#
        );
        for command in ["run", "gap"] {
            let out = phisindy(&folder, command, &spec, &["--out", command, "--format", "json", "--force"]);
            let err = String::from_utf8_lossy(&out.stderr);
            assert!(matches!(out.status.code(), Some(0 | 1)), "{command} {c}: {err}");
            assert!(folder.join(command).join("report.html").is_file(), "{command}");
            assert!(json(&out)["records"].as_array().is_some_and(|all| !all.is_empty()), "{command}");
        }
    }
}
