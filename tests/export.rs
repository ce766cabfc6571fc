//! `phisindy export`: what is exported runs, and moves as `phisindy simulate` says.

#![allow(missing_docs)]

use crate::common::{self, Scratch, phisindy, skipped};
use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};

/// Largest deviation from our own simulation, as a part of the column's largest value.
const CLOSE: f64 = 1e-6;

/// Two masses in a chain: Coulomb friction on the first, Dieterich-Ruina on the second (case 7, with its
/// truth in the known rates).
const CHAIN: &str = r#"(
    title: "Case 7: Coulomb and Dieterich-Ruina on two masses",
    constants: {
        "m1": (1.0, "kg"), "m2": (1.0, "kg"), "c1": (0.1, "N*s/m"), "c2": (0.1, "N*s/m"), "k1": (1.0, "N/m"), "k2": (1.0, "N/m"),
        "F0": (1.0, "N"), "W": (0.6, "rad/s"), "V": (3.0, "mm/s"), "c": 0.022, "eps": (1e-6, "m/s"),
        "mu1": (0.3, "m/s^2"), "mu2": (0.3, "m/s^2"), "a": (0.07, "m/s^2"), "b": (0.09, "m/s^2"),
    },
    states: { "x1": "m", "x2": "m", "y1": "m/s", "y2": "m/s" },
    known: {
        "x1": "y1", "x2": "y2",
        "y1": "(-(c1+c2)*y1 + c2*y2 - (k1+k2)*x1 + k2*x2 + F0*cos(W*t))/m1 - mu1*sgn(y1)",
        "y2": "(c2*(y1-y2) + k2*(x1-x2))/m2 - sgn(y2)*(mu2 + a*ln((|y2|+eps)/V) + b*ln(c+V/(|y2|+eps)))",
    },
    contacts: ["y1", "y2"],
    data: [Synthetic(truth: {}, noise: Relative(0.0), start: {}, duration: 50.0, step: 0.05)],
)"#;

/// A block on a block on a table: two contacts that hold each other, and a drive that leaves them at rest for
/// long.
const COUPLED: &str = r#"(
    constants: { "m1": (1.0, "kg"), "m2": (2.0, "kg"), "k": (4.0, "N/m"), "mu": (1.2, "N"), "nu": (0.9, "N"), "A": (3.5, "N"), "W": (0.7, "rad/s") },
    states: { "x1": "m", "x2": "m", "y1": "m/s", "y2": "m/s" },
    known: {
        "x1": "y1", "x2": "y2",
        "y1": "(-k*x1 - mu*sgn(y1-y2) + A*sin(W*t)^3)/m1",
        "y2": "(-0.5*k*x2 + mu*sgn(y1-y2) - nu*sgn(y2))/m2",
    },
    contacts: ["y1-y2", "y2"],
    data: [Synthetic(truth: {}, noise: Relative(0.0), start: { "x1": 0.1 }, duration: 40.0, step: 0.05)],
)"#;

/// A stop on one side, play on the other, and names that no language takes as they are.
const STOP: &str = r#"(
    title: "Stop */ \"quoted\": \\ and play",
    constants: { "int": (1.0, "kg"), "lambda": (9.0, "N/m"), "gap": (0.2, "m"), "ks": (60.0, "N/m"), "Q": (0.4, "N"), "E": (6.0, "N"), "ω": (3.0, "rad/s"), "q0": 0.05, "vq": (1.0, "m/s") },
    states: { "state": "m", "while": "m/s" },
    known: {
        "state": "while",
        "while": "(-lambda*state - ks*pos(state-gap) - ks*dead(min(state, 0.0), 0.3) - Q*sgn(while)*(1 + q0*exp(-|while|/vq)) + E*sin(ω*t))/int",
    },
    contacts: ["while"],
    data: [Synthetic(truth: {}, noise: Relative(0.0), start: { "state": 0.05, "while": -0.1 }, duration: 6.0, step: 0.02)],
)"#;

/// Friction holds most of the time: short bursts of force tear the mass off.
const RESTS: &str = r#"(
    constants: { "m": (2.0, "kg"), "d": (0.3, "N*s/m"), "k": (5.0, "N/m"), "Fc": (2.0, "N"), "Fs": (3.0, "N"), "vs": (0.05, "m/s"), "A": (5.0, "N") },
    states: { "x": "m", "v": "m/s" },
    known: { "x": "v", "v": "(-d*v - k*x - sgn(v)*(Fc + (Fs-Fc)*exp(-(v/vs)^2)) + A*cos(0.5*t)^9)/m" },
    contacts: ["v"],
    data: [Synthetic(truth: {}, noise: Relative(0.0), start: {}, duration: 60.0, step: 0.05)],
)"#;

/// Dieterich-Ruina without its small speed: without bound at rest, upwards where b is larger than a, else
/// downwards.
fn singular(a: f64, b: f64, drive: f64) -> String {
    format!(
        r#"(
    constants: {{ "k": (1.0, "1/s^2"), "V": (0.003, "m/s"), "c": 0.022, "F": (0.3, "m/s^2"), "a": ({a}, "m/s^2"), "b": ({b}, "m/s^2"), "A": ({drive}, "m/s^2") }},
    states: {{ "x": "m", "v": "m/s" }},
    known: {{ "x": "v", "v": "-k*x - sgn(v)*(F + a*ln(|v|/V) + b*ln(c+V/|v|)) + A*cos(0.4*t)" }},
    contacts: ["v"],
    data: [Synthetic(truth: {{}}, noise: Relative(0.0), start: {{ "x": 1.5, "v": 0.7 }}, duration: 30.0, step: 0.05)],
)"#
    )
}

/// A mass on a table that moves: the contact's velocity is one against an input, and the record has its own
/// load.
const BASE: &str = r#"(
    constants: { "m": (1.0, "kg"), "k": (30.0, "N/m"), "d": (0.2, "N*s/m"), "U": (0.05, "m"), "W": (4.0, "rad/s"), "mu": 0.35 },
    states: { "x": "m", "v": "m/s" },
    inputs: { "u": "m", "du": "m/s" },
    known: { "x": "v", "v": "(-d*v - k*x - mu*N*sgn(v-du))/m" },
    contacts: ["v-du"],
    data: [Synthetic(truth: {}, noise: Relative(0.0), start: { "x": 0.02 }, duration: 15.0, step: 0.005, constants: { "N": (2.0, "N") },
        inputs: { "u": Formula("U*sin(W*t) + 0.3*U*sin(2.7*W*t)") }, derive: { "du": Derivative("u") })],
)"#;

/// Nothing rubs, nothing drives.
const FREE: &str = r#"(
    constants: { "w": (2.0, "rad/s"), "d": 0.05 },
    states: { "x": "", "v": "" },
    known: { "x": "v", "v": "-w^2*sin(x) - d*v*|v| + 0.1*tanh(x)*atan(v)/sqrt(1 + x^2)" },
    data: [Synthetic(truth: {}, noise: Relative(0.0), start: { "x": 1.0 }, duration: 20.0, step: 0.05)],
)"#;

/// A measured force, held or joined by straight lines, on a mass that sticks.
fn measured(kind: &str) -> String {
    format!(
        r#"(
    constants: {{ "m": (1.0, "kg"), "k": (20.0, "N/m"), "d": (0.4, "N*s/m"), "Fc": (1.0, "N") }},
    states: {{ "x": "m", "v": "m/s" }},
    inputs: {{ "F": "N" }},
    known: {{ "x": "v", "v": "(F - d*v - k*x - Fc*sgn(v))/m" }},
    contacts: ["v"],
    data: [Csv(path: "force.csv", time: "t", columns: {{ "x": "x", "F": ("F", "kN") }}, interpolate: {{ "F": {kind} }}, start: {{ "x": 0.0, "v": 0.0 }})],
)"#
    )
}

/// A force with jumps and rests, and a displacement of about the right size.
fn force() -> String {
    let mut out = "t,x,F\n".to_owned();
    for k in 0..400_u32 {
        let t = f64::from(k) * 0.05;
        let level = [0.0, 2.5, 0.5, -3.0, -0.5, 0.0, 1.5, 3.5][(k / 25 % 8) as usize];
        out += &format!("{t},{},{}\n", 0.1 * t.sin(), (level + 0.3 * (3.0 * t).sin()) / 1000.0);
    }
    out
}

/// Rows of numbers under their headings; words become NaN.
fn column(csv: &str, name: &str) -> Vec<f64> {
    let mut lines = csv.lines();
    let head = lines.next().expect("a heading");
    let at = head.split(',').position(|h| h == name).unwrap_or_else(|| panic!("no column {name} in {head}"));
    lines.map(|l| l.split(',').nth(at).and_then(|x| x.parse().ok()).unwrap_or(f64::NAN)).collect()
}

/// Runs a program with a text on its standard input.
#[track_caller]
fn fed(command: &mut Command, input: &str) -> String {
    let mut child = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap_or_else(|e| panic!("{command:?}: {e}; the tests need python3 and a C compiler"));
    let mut stdin = child.stdin.take().expect("a pipe");
    let input = input.to_owned();
    let writer = std::thread::spawn(move || stdin.write_all(input.as_bytes()));
    let output = child.wait_with_output().expect("it ends");
    let _ = writer.join().expect("no panic");
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("UTF-8")
}

#[derive(Clone, Copy, PartialEq)]
enum Program {
    Python,
    C,
}

/// Exports a spec and runs what comes out along what `simulate` wrote.
#[track_caller]
fn run_exported(scratch: &Scratch, spec: &str, to: Program, motion: &str) -> String {
    let export = |language: &str, file: &str| {
        let said = phisindy(&["export", spec, "--to", language, "--out", file]);
        assert_eq!((said.code, said.out.as_str(), said.err.as_str()), (0, "", ""));
    };
    if to == Program::Python {
        let file = scratch.path("model.py");
        export("python", &file);
        return fed(Command::new("python3").arg(file), motion);
    }
    let (file, made) = (scratch.path("model.c"), scratch.path("model"));
    export("c", &file);
    let strict = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1"];
    fed(Command::new("cc").args(strict).args(["-c", &file, "-o", &scratch.path("model.o")]), "");
    fed(Command::new("cc").args(strict).args(["-DPHISINDY_MAIN", &file, "-o", &made, "-lm"]), "");
    fed(&mut Command::new(made), motion)
}

/// The largest deviation of an exported program from `simulate`, over all states.
#[track_caller]
fn deviation(name: &str, spec: &str, to: Program) -> f64 {
    let scratch = Scratch::new(&format!("export-{name}-{}", if to == Program::Python { "py" } else { "c" }));
    let path = scratch.path("spec.ron");
    fs::write(&path, spec).expect("written");
    fs::write(scratch.path("force.csv"), force()).expect("written");
    let ours = phisindy(&["simulate", &path, "--quiet"]);
    assert_eq!(ours.code, 0, "{}", ours.err);
    let theirs = run_exported(&scratch, &path, to, &ours.out);
    farthest(&ours.out, &theirs)
}

#[track_caller]
fn farthest(ours: &str, theirs: &str) -> f64 {
    let head = ours.lines().next().expect("a heading");
    let mut worst = 0.0_f64;
    let mut states = 0;
    for heading in head.split(',') {
        let Some(state) = heading.strip_suffix("_true").or(heading.strip_suffix("_model")) else { continue };
        let (ours, theirs) = (column(ours, heading), column(theirs, state));
        assert_eq!(ours.len(), theirs.len(), "{state}");
        let size = ours.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        assert!(size > 1e-3, "{state} does not move");
        for (a, b) in ours.iter().zip(&theirs) {
            let miss = (a - b).abs() / size;
            worst = if miss.is_nan() { f64::INFINITY } else { worst.max(miss) };
        }
        states += 1;
    }
    assert!(states > 0, "{head}");
    worst
}

#[track_caller]
fn moves_as_ours(name: &str, spec: &str) {
    for (to, language) in [(Program::C, "C"), (Program::Python, "Python")] {
        let miss = deviation(name, spec, to);
        assert!(miss <= CLOSE, "{name} in {language}: {miss:e}");
        if std::env::var_os("PHISINDY_DEVIATIONS").is_some() {
            let _ = writeln!(std::io::stderr(), "{name} in {language}: {miss:.1e}");
        }
    }
}

#[test]
fn two_contacts_of_which_one_is_dieterich_ruina() {
    moves_as_ours("chain", CHAIN);
}

#[test]
fn contacts_that_hold_each_other() {
    moves_as_ours("coupled", COUPLED);
}

#[test]
fn a_stop_and_names_that_are_words_elsewhere() {
    moves_as_ours("stop", STOP);
}

#[test]
fn a_mass_that_rests_most_of_the_time() {
    moves_as_ours("rests", RESTS);
}

#[test]
fn friction_that_is_singular_at_rest() {
    moves_as_ours("singular-up", &singular(0.02, 0.05, 0.3));
    // Python is slow at the millions of steps that the first, coarse run takes near rest.
    let miss = deviation("singular-down", &singular(0.04, 0.03, 0.9), Program::C);
    assert!(miss <= CLOSE, "{miss:e}");
}

#[test]
fn a_base_that_moves() {
    moves_as_ours("base", BASE);
}

#[test]
fn nothing_that_rubs() {
    moves_as_ours("free", FREE);
}

#[test]
fn a_measured_force_that_jumps_turns_or_bends() {
    for kind in ["Hold", "Linear", "Cubic"] {
        moves_as_ours(kind, &measured(kind));
    }
}

#[test]
fn masses_that_never_move_do_not_stop_the_simulation() {
    // The lower block's friction is larger than what the upper one can push it with: its motion is rounding,
    // and no scale for a step.
    moves_but("rounding", &COUPLED.replace(r#""nu": (0.9, "N")"#, r#""nu": (1.5, "N")"#), &["x1", "y1"]);
}

/// The third contact is decided by the first two, which hold the blocks; the drive overcomes the one of
/// another mass.
#[test]
fn what_is_held_twice_does_not_hold_another_mass() {
    let spec = r#"(
    constants: { "mu": (0.5, "m/s^2"), "nu": (0.25, "m/s^2"), "a": (0.1, "m/s^3"), "k": (0.2, "1/s^2") },
    states: { "y1": "m/s", "y2": "m/s", "x3": "m", "y3": "m/s" },
    known: {
        "y1": "a*t/4 - mu*sgn(y1) - mu*sgn(y1-y2)", "y2": "mu*sgn(y1-y2) - mu*sgn(y2)",
        "x3": "y3", "y3": "a*t - k*x3 - nu*sgn(y3)",
    },
    contacts: ["y1", "y1-y2", "y2", "y3"],
    data: [Synthetic(truth: {}, noise: Relative(0.0), start: {}, duration: 20.0, step: 0.05)],
)"#;
    moves_but("held-twice", spec, &["x3", "y3"]);
}

/// As [`moves_as_ours`], where only these states move.
#[track_caller]
fn moves_but(name: &str, spec: &str, moving: &[&str]) {
    let scratch = Scratch::new(&format!("export-{name}"));
    let path = scratch.path("spec.ron");
    fs::write(&path, spec).expect("written");
    let ours = phisindy(&["simulate", &path, "--quiet"]);
    assert_eq!(ours.code, 0, "{}", ours.err);
    for to in [Program::C, Program::Python] {
        let theirs = run_exported(&scratch, &path, to, &ours.out);
        for state in moving {
            let (a, b) = (column(&ours.out, &format!("{state}_true")), column(&theirs, state));
            assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= CLOSE), "{state}");
        }
    }
}

#[test]
fn what_run_identified_is_exported_with_its_coefficients_by_name() {
    let scratch = Scratch::new("export-run");
    let folder = scratch.path("found");
    let said =
        phisindy(&["run", "specs/case1a.ron", "--set", "data.0.duration=20.0", "--out", &folder, "--quiet"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let ours = phisindy(&["simulate", &format!("{folder}/identified.ron"), "--quiet"]);
    for to in [Program::C, Program::Python] {
        let theirs = run_exported(&scratch, &folder, to, &ours.out);
        let miss = farthest(&ours.out, &theirs);
        assert!(miss <= CLOSE, "{miss:e}");
    }
    let python = phisindy(&["export", &folder, "--to", "python"]);
    assert_eq!((python.code, python.err.as_str()), (0, ""));
    assert!(
        python.out.contains("\n    \"c_y\": 0.") || python.out.contains("\n    \"c_y\": 0.5,"),
        "{}",
        python.out
    );
    assert!(python.out.contains("# m/s^2") || python.out.contains("# N"), "the coefficient has its unit");
    // Another coefficient is a --set away, and a folder takes a file with a plain name.
    let into = scratch.path("there/");
    let said =
        phisindy(&["export", &folder, "--to", "python", "--set", "constants.c_y=0.125", "--out", &into]);
    assert_eq!((said.code, said.out.as_str(), said.err.as_str()), (0, "", ""));
    let text = fs::read_to_string(scratch.path("there/model.py")).expect("model.py");
    assert!(text.contains("\"c_y\": 0.125,"), "{text}");
    let names: Vec<_> = fs::read_dir(scratch.path("there")).expect("a folder").collect();
    assert_eq!(names.len(), 1, "nothing half-written stays: {names:?}");
}

/// A mass on a belt whose speed is measured: what sticks moves with an input.
const BELT: &str = r#"(
    constants: { "m": (1.0, "kg"), "k": (20.0, "N/m"), "d": (0.4, "N*s/m"), "Fc": (1.0, "N") },
    states: { "x": "m", "v": "m/s" },
    inputs: { "w": "m/s" },
    known: { "x": "v", "v": "(-d*v - k*x - Fc*sgn(v-w))/m" },
    contacts: ["v-w"],
    data: [Csv(path: "force.csv", time: "t", columns: { "x": "x", "w": ("F", "m/s") }, interpolate: { "w": Linear }, start: { "x": 0.0, "v": 0.0 })],
)"#;

/// The small importer of the tests, on an FMU with a table on standard input.
#[track_caller]
fn imported(fmu: &str, kind: &str, table: &str) -> String {
    fed(Command::new("python3").arg(common::top().join("tests/fmu/importer.py")).args([fmu, kind]), table)
}

/// An FMU of a spec, its sources compiled without a warning, and what `simulate` says of the same spec.
#[track_caller]
fn fmu_of(scratch: &Scratch, spec: &str) -> (String, String) {
    let (path, fmu) = (scratch.path("spec.ron"), scratch.path("model.fmu"));
    fs::write(&path, spec).expect("written");
    fs::write(scratch.path("force.csv"), force()).expect("written");
    let ours = phisindy(&["simulate", &path, "--quiet"]);
    assert_eq!(ours.code, 0, "{}", ours.err);
    let said = phisindy(&["export", &path, "--to", "fmu", "--out", &fmu]);
    assert_eq!((said.code, said.out.as_str(), said.err.as_str()), (0, "", ""));
    let code = "import sys, zipfile; sys.stdout.write(zipfile.ZipFile(sys.argv[1]).read('sources/model.c').decode())";
    let text = fed(Command::new("python3").args(["-c", code, &fmu]), "");
    let strict = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1", "-x", "c", "-c", "-", "-o"];
    fed(Command::new("cc").args(strict).arg(scratch.path("model.o")), &text);
    (fmu, ours.out)
}

#[test]
fn an_fmu_moves_as_ours_in_both_kinds() {
    // The importer holds a column of this heading.
    let (same, held) = ("", "_held");
    let all = [
        // Friction with a shape near rest needs steps of its own: see `tests/fmu/check.py`.
        ("chain", CHAIN, same, &["cosim"] as &[&str]),
        ("coupled", COUPLED, same, &["cosim", "exchange"]),
        ("belt", BELT, same, &["cosim", "exchange"]),
        ("hold", &measured("Hold"), held, &["cosim", "exchange"]),
        ("linear", &measured("Linear"), same, &["cosim", "exchange"]),
    ];
    for (name, spec, ending, kinds) in all {
        let scratch = Scratch::new(&format!("fmu-{name}"));
        let (fmu, ours) = fmu_of(&scratch, spec);
        for kind in kinds {
            let miss =
                farthest(&ours, &imported(&fmu, kind, &ours.replacen(",F\n", &format!(",F{ending}\n"), 1)));
            assert!(miss <= CLOSE, "{name}, {kind}: {miss:e}");
        }
    }
}

#[test]
fn an_fmu_refuses_wrong_calls_and_keeps_its_state() {
    let scratch = Scratch::new("fmu-misuse");
    let (fmu, ours) = fmu_of(&scratch, COUPLED);
    assert_eq!(imported(&fmu, "misuse", &ours), "fine\n");
}

#[test]
fn an_fmu_without_a_compiler_holds_its_sources_and_says_so() {
    let scratch = Scratch::new("fmu-plain");
    let (path, fmu) = (scratch.path("spec.ron"), scratch.path("model.fmu"));
    fs::write(&path, STOP).expect("written");
    let said = common::program(&["export", &path, "--to", "fmu", "--out", &fmu]).env("PATH", "").output();
    let said = said.expect("it starts");
    let err = String::from_utf8_lossy(&said.stderr);
    assert!(
        said.status.success() && err.contains("sources and no binary, for there is no C compiler"),
        "{err}"
    );
    let code = "import sys, zipfile; print(sorted(zipfile.ZipFile(sys.argv[1]).namelist()))";
    let names = fed(Command::new("python3").args(["-c", code, &fmu]), "");
    assert_eq!(names, "['modelDescription.xml', 'sources/buildDescription.xml', 'sources/model.c']\n");
    let said = phisindy(&["export", &path, "--to", "fmu"]);
    assert!(said.code == 2 && said.err.contains("--out model.fmu"), "{}", said.err);
}

/// Runs an exported MEX function along what `simulate` wrote, and asks it what it refuses.
const OCTAVE: &str = r#"
info = model_mex();
file = fopen('motion.csv'); head = strsplit(fgetl(file), ','); fclose(file);
rows = dlmread('motion.csv', ',', 1, 0);
t = rows(:, strcmp(head, 't'));
u = zeros(numel(t), 0);
for name = info.inputs, u(:, end + 1) = rows(:, strcmp(head, name{1})); end
[x, mode, y] = model_mex(t, u);
printf('%s\n', strjoin([{'t'}, info.states, info.outputs], ','));
for i = 1:numel(t), printf('%s\n', strjoin(arrayfun(@(v) sprintf('%.17g', v), [t(i), x(i, :), y(i, :)], 'UniformOutput', false), ',')); end
% The rates at a point that slips are the slope of the motion; the modes of the whole motion come with it.
assert(size(mode), [numel(t), numel(info.contacts)]);
assert(all(ismember(mode(:), [-1, 0, 1])));
[dx, s] = model_mex('rates', t(1), x(1, :), u(1, :));
assert(numel(dx), numel(info.states));
assert(numel(s), numel(info.contacts));
same = model_mex(t, u, info.start, info.constants);
assert(same, x);
function refused(words, varargin)
    try
        model_mex(varargin{:});
    catch problem
        assert(! isempty(strfind(problem.message, words)), problem.message);
        return
    end
    error('it takes what it should refuse: %s', words);
end
refused('increase', t(end:-1:1), u);
refused('at least one time', []);
refused('not a finite number', [t(1:end - 1); NaN], u);
refused('one for each of the states', t, u, 1);
refused('there is no constant', t, u, [], struct('nothing', 1));
refused('only word', 'run');
refused('after', 'rates');
refused('real numbers', single(t), u);
"#;

/// The form for MATLAB in GNU Octave, where that and its `mkoctfile` are installed (octave, octave-dev).
#[test]
fn a_mex_function_moves_as_ours() {
    let there = |program: &str| Command::new(program).arg("--version").output().is_ok();
    if !there("octave-cli") || !there("mkoctfile") {
        return skipped("octave-cli and mkoctfile are not both installed");
    }
    let all = [
        ("chain", CHAIN.to_owned()),
        ("coupled", COUPLED.to_owned()),
        ("stop", STOP.to_owned()),
        ("base", BASE.to_owned()),
        ("cubic", measured("Cubic")),
        ("free", FREE.to_owned()),
    ];
    for (name, spec) in all {
        let scratch = Scratch::new(&format!("mex-{name}"));
        let path = scratch.path("spec.ron");
        fs::write(&path, spec).expect("written");
        fs::write(scratch.path("force.csv"), force()).expect("written");
        let ours = phisindy(&["simulate", &path, "--quiet"]);
        assert_eq!(ours.code, 0, "{}", ours.err);
        fs::write(scratch.path("motion.csv"), &ours.out).expect("written");
        let said = phisindy(&["export", &path, "--to", "matlab", "--out", &scratch.path("model_mex.c")]);
        assert_eq!((said.code, said.out.as_str(), said.err.as_str()), (0, "", ""));
        fed(Command::new("mkoctfile").args(["--mex", "model_mex.c"]).current_dir(&scratch.0), "");
        let octave = ["--quiet", "--no-init-file", "--eval", OCTAVE];
        let theirs = fed(Command::new("octave-cli").args(octave).current_dir(&scratch.0), "");
        let miss = farthest(&ours.out, &theirs);
        assert!(miss <= CLOSE, "{name}: {miss:e}");
    }
}

/// What the tool of the FMI project says, where `PHISINDY_FMPY` names a Python with fmpy and cmake.
#[test]
fn fmpy_has_no_complaint() {
    let Some(python) = std::env::var_os("PHISINDY_FMPY") else {
        return skipped("PHISINDY_FMPY names no Python with fmpy");
    };
    for case in ["case1a", "case6", "case7"] {
        let scratch = Scratch::new(&format!("fmpy-{case}"));
        let found = scratch.path(case);
        let said = phisindy(&["run", &format!("specs/{case}.ron"), "--out", &found, "--quiet"]);
        assert_eq!(said.code, 0, "{}", said.err);
        let (fmu, table) = (scratch.path("model.fmu"), scratch.path("motion.csv"));
        assert_eq!(phisindy(&["export", &found, "--to", "fmu", "--out", &fmu]).code, 0);
        let ours = phisindy(&["simulate", &format!("{found}/identified.ron"), "--quiet"]);
        fs::write(&table, ours.out).expect("written");
        let check = common::top().join("tests/fmu/check.py");
        let said = fed(Command::new(&python).arg(check).args([&fmu, &table]), "");
        assert!(said.contains("no problems"), "{said}");
    }
}

/// Runs a few lines of Python that import the exported module as `model`.
#[track_caller]
fn asked(name: &str, spec: &str, lines: &str) -> String {
    let scratch = Scratch::new(&format!("export-asked-{name}"));
    let path = scratch.path("spec.ron");
    fs::write(&path, spec).expect("written");
    let said = phisindy(&["export", &path, "--to", "python", "--out", &scratch.path("model.py")]);
    assert_eq!(said.code, 0, "{}", said.err);
    fed(Command::new("python3").args(["-B", "-c", lines]).current_dir(&scratch.0), "")
}

#[test]
fn rates_and_modes_follow_the_contact_rule() {
    // Friction at rest is 3 N, the drive 1 N, the spring pulls with 5 N/m: 0.5, 2.98 and 3.02 N, and 8.5 N;
    // at v = -0.5 friction is 2 N.
    let spec = RESTS.replace(r#""A": (5.0, "N")"#, r#""A": (1.0, "N")"#);
    let expected = "0 0.000000000\n0 0.000000000\n1 0.010000000\n1 2.750000000\n-1 0.325000000\n";
    let python = "
import model
for x, v in [(0.1, 0.0), (-0.396, 0.0), (-0.404, 0.0), (-1.5, 0.0), (0.5, -0.5)]:
    s = model.modes(0.0, [x, v], [])
    print(s[0], '%.9f' % model.rates(0.0, [x, v], [], s)[1])
";
    assert_eq!(asked("rule", &spec, python), expected);
    let c = r#"
#include "model.c"
int main(void)
{
    double points[5][2] = {{0.1, 0.0}, {-0.396, 0.0}, {-0.404, 0.0}, {-1.5, 0.0}, {0.5, -0.5}}, dx[2];
    for (int k = 0; k < 5; k++) {
        int s;
        model_modes(0.0, points[k], NULL, NULL, NULL, NULL, &s);
        model_rates(0.0, points[k], NULL, &s, NULL, NULL, dx);
        printf("%d %.9f\n", s, dx[1]);
    }
    return 0;
}
"#;
    let scratch = Scratch::new("export-rule-c");
    let (path, made) = (scratch.path("spec.ron"), scratch.path("rule"));
    fs::write(&path, &spec).expect("written");
    fs::write(scratch.path("rule.c"), c).expect("written");
    let said = phisindy(&["export", &path, "--to", "c", "--out", &scratch.path("")]);
    assert_eq!((said.code, said.err.as_str()), (0, ""));
    fed(Command::new("cc").args(["-std=c99", &scratch.path("rule.c"), "-o", &made, "-lm"]), "");
    assert_eq!(fed(&mut Command::new(made), ""), expected);
    // With ten times the friction it holds.
    let stronger = "
import model
print(model.modes(0.0, [-1.5, 0.0], [], p=dict(model.PARAMETERS, Fs=30.0)))
";
    assert_eq!(asked("stronger", &spec, stronger), "[0]\n");
}

#[test]
fn friction_without_bound_at_rest_holds_and_a_table_carries() {
    let up = "
import model
print(model.modes(0.0, [0.0, 0.0], []), model.rates(0.0, [0.0, 0.0], [], [0]))
";
    assert_eq!(asked("singular", &singular(0.02, 0.05, 0.3), up), "[0] [0.0, 0.0]\n");
    let carried = "
import model
print([round(r, 9) for r in model.rates(0.0, [0.0, 0.25], [0.0, 0.25], [0], du=[0.25, 0.125])])
motion = model.simulate([0.0, 1.0], [0.0, 0.0], [lambda t: 0.001*t, (lambda t: 0.001, lambda t: 0.0)])
print([round(x, 9) for x in motion.states[1]], motion.modes)
";
    // The table slips under the mass until friction, 0.7 m/s^2, has given it the table's speed: 1e-3^2/2/0.7
    // m less than the table's way.
    assert_eq!(asked("carried", BASE, carried), "[0.25, 0.125]\n[0.000999286, 0.001] [[-1], [0]]\n");
}

#[test]
fn the_tree_in_json_is_the_rate() {
    let scratch = Scratch::new("export-json");
    let path = scratch.path("spec.ron");
    fs::write(&path, BASE).expect("written");
    let said = phisindy(&["export", &path, "--to", "json"]);
    assert_eq!((said.code, said.err.as_str()), (0, ""));
    let model: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
    assert_eq!(
        (model["schema"].as_str(), model["schema_version"].as_u64()),
        (Some("phisindy-model"), Some(1))
    );
    let mut graph = phisindy_expr::Graph::default();
    let mut names = phisindy_expr::Names::default();
    for rate in model["rates"].as_array().expect("rates") {
        let ast = phisindy_expr::parse(rate["text"].as_str().expect("text")).expect("it parses");
        let text = graph.lower(&ast, |name| Some(names.intern(name))).expect("every name");
        let mut nodes: Vec<phisindy_expr::Id> = Vec::new();
        for node in rate["tree"].as_array().expect("a list") {
            let operand = |k: usize| nodes[node["args"][k].as_u64().expect("a place") as usize];
            let id = match (&node["number"], &node["name"], &node["op"]) {
                (serde_json::Value::Number(x), _, _) => graph.constant(x.as_f64().expect("a number")),
                (_, serde_json::Value::String(name), _) => graph.symbol(names.intern(name)),
                (_, _, op) => {
                    let op = op.as_str().expect("an operation");
                    assert!(model["operations"][op].is_string(), "{op}");
                    let args = node["args"].as_array().expect("operands").len();
                    let mut unary = phisindy_expr::ops::UNARY.iter();
                    let mut binary = phisindy_expr::ops::BINARY.iter();
                    match (op, args) {
                        ("neg", _) => graph.neg(operand(0)),
                        (_, 1) => graph.unary(unary.find(|r| r.name == op).expect("a row").op, operand(0)),
                        _ => graph.binary(
                            binary.find(|r| r.name == op).expect("a row").op,
                            operand(0),
                            operand(1),
                        ),
                    }
                }
            };
            nodes.push(id);
        }
        assert_eq!(nodes.last(), Some(&text));
    }
    let constants = model["constants"].as_array().expect("constants");
    let load = constants.iter().find(|c| c["name"] == "N").expect("the record's load");
    assert_eq!((load["value"].as_f64(), load["unit"].as_str()), (Some(2.0), Some("N")));
}

#[test]
fn modelica_is_as_it_was_looked_at() {
    let scratch = Scratch::new("export-modelica");
    for (name, spec) in [("chain", CHAIN), ("stop", STOP), ("base", BASE)] {
        let path = scratch.path(&format!("{name}.ron"));
        fs::write(&path, spec).expect("written");
        let file = scratch.path("Chain.mo");
        let said = phisindy(&["export", &path, "--to", "modelica", "--out", &file, "--force"]);
        assert_eq!((said.code, said.err.as_str()), (0, ""));
        let text = fs::read_to_string(&file).expect("written").replace(&path, "SPEC");
        let text = text.replace(env!("CARGO_PKG_VERSION"), "VERSION");
        insta::with_settings!({ snapshot_path => "models", prepend_module_to_snapshot => false, omit_expression => true }, {
            insta::assert_snapshot!(format!("modelica_{name}"), text);
        });
    }
}

#[test]
fn what_cannot_be_exported_is_said() {
    let said = phisindy(&["export", "specs/case7.ron", "--to", "python"]);
    assert_eq!((said.code, said.out.as_str()), (2, ""));
    assert!(
        said.err.contains("unknown part") && said.err.contains("phisindy run specs/case7.ron --out DIR"),
        "{}",
        said.err
    );
    let said = phisindy(&["export", "specs", "--to", "c"]);
    assert!(said.code == 2 && said.err.contains("neither identified.ron nor completed.ron"), "{}", said.err);
    let scratch = Scratch::new("export-record");
    let path = scratch.path("spec.ron");
    fs::write(&path, BASE).expect("written");
    let said = phisindy(&["export", &path, "--to", "c", "--record", "7"]);
    assert!(said.code == 2 && said.err.contains("there is: 0 `synthetic 0`"), "{}", said.err);
}

#[test]
fn completions_and_the_manual_know_every_subcommand() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let said = phisindy(&["completions", shell]);
        assert_eq!((said.code, said.err.as_str()), (0, ""), "{shell}");
        for word in ["simulate", "export", "sweep", "record"] {
            assert!(said.out.contains(word), "{shell}: {word}");
        }
    }
    let scratch = Scratch::new("manual");
    let said = phisindy(&["man", "--out", &scratch.path("")]);
    assert_eq!((said.code, said.out.as_str(), said.err.as_str()), (0, "", ""));
    let whole = phisindy(&["man"]).out;
    for name in
        ["run", "new", "gap", "simulate", "check", "sweep", "laws", "export", "open", "completions", "man"]
    {
        let page = fs::read_to_string(scratch.path(&format!("phisindy-{name}.1"))).expect(name);
        assert!(page.starts_with(".ie") || page.starts_with(".TH"), "{page}");
        assert!(page.contains(".SH EXAMPLES") && page.contains(&format!("phisindy {name}")), "{page}");
        assert!(whole.contains(&format!(".SH \"PHISINDY {}\"", name.to_uppercase())), "{name}");
    }
    assert!(!scratch.0.join("phisindy-table.1").exists(), "what is hidden has no page");
}
