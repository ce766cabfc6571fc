//! Robots of URDF and MJCF against MuJoCo, against equations by hand, and broken ones.

use phisindy_expr::{Scratch, Tape};
use phisindy_import::Robot;
use phisindy_phys::{Case, SourceId, check, spec};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/robots").join(name)
}

fn robot(name: &str) -> Robot {
    let text = std::fs::read_to_string(file(name)).expect("a file");
    Robot::read(&text, SourceId(0)).unwrap_or_else(|d| panic!("{name}: {}", d.message))
}

fn case(text: &str) -> Case {
    let (spec, _) = spec::read(text, SourceId(0)).unwrap_or_else(|d| panic!("{d:?}\n{text}"));
    check(&spec, SourceId(0)).unwrap_or_else(|d| panic!("{d:?}\n{text}")).0
}

/// The accelerations of a robot at places, speeds and forces of its joints, without dry friction.
fn accelerations(case: &Case, points: &[[Vec<f64>; 3]]) -> Vec<Vec<f64>> {
    let model = case.system.model(&[]);
    let all: Vec<_> =
        [model.time].into_iter().chain(model.states).chain(model.inputs).chain(model.parameters).collect();
    let tape = Tape::compile(&model.graph, &all, &model.rates).expect("a tape");
    let parameters =
        case.system.parameters.iter().map(|p| if p.name.starts_with("Fc") { 0.0 } else { p.start });
    let parameters: Vec<f64> = parameters.collect();
    let mut scratch = Scratch::<1>::new(&tape);
    let each = |[q, v, force]: &[Vec<f64>; 3]| {
        let states = q.iter().zip(v).flat_map(|(q, v)| [*q, *v]);
        let values =
            [0.0].into_iter().chain(states).chain(force.iter().copied()).chain(parameters.iter().copied());
        values.enumerate().for_each(|(k, value)| scratch.input(k)[0] = value);
        scratch.run();
        (0..q.len()).map(|k| scratch.output(2 * k + 1)[0]).collect()
    };
    points.iter().map(each).collect()
}

/// A Python that has MuJoCo: that of PHISINDY_MUJOCO, or the one of the path.
fn mujoco() -> Option<PathBuf> {
    let python = std::env::var_os("PHISINDY_MUJOCO").map_or_else(|| PathBuf::from("python3"), PathBuf::from);
    let there =
        Command::new(&python).args(["-c", "import mujoco"]).output().is_ok_and(|out| out.status.success());
    if !there {
        let test = std::thread::current();
        let line = "Python has no package `mujoco` (PHISINDY_MUJOCO names another one)";
        let _ = writeln!(std::io::stderr(), "skipped: {}: {line}", test.name().unwrap_or("a test"));
    }
    there.then_some(python)
}

#[test]
fn shown() {
    for name in ["arm6.urdf", "cart_pole.xml", "two_link.urdf"] {
        let text = robot(name).spec_text(None, (name, ""), "");
        let t = std::time::Instant::now();
        let own = case(&text);
        println!("{text}\n{name} check {:?}", t.elapsed());
        let model = own.system.model(&[]);
        let all: Vec<_> = [model.time]
            .into_iter()
            .chain(model.states)
            .chain(model.inputs)
            .chain(model.parameters)
            .collect();
        let tape = Tape::compile(&model.graph, &all, &model.rates).expect("a tape");
        let mut scratch = Scratch::<1>::new(&tape);
        let t = std::time::Instant::now();
        for _ in 0..1000 {
            scratch.run();
        }
        println!(
            "{name} {} ops, one run {:?}, graph {}",
            tape.operations(),
            t.elapsed() / 1000,
            model.graph.reachable(&model.rates).len()
        );
    }
}

#[test]
fn robots_accelerate_as_in_mujoco() {
    let Some(python) = mujoco() else { return };
    for name in [
        "two_link.urdf",
        "two_link.xml",
        "cart_pole.urdf",
        "cart_pole.xml",
        "skew.urdf",
        "skew.xml",
        "arm6.urdf",
        "arm6.xml",
    ] {
        let out =
            Command::new(&python).arg(file("accelerations.py")).arg(file(name)).output().expect("Python");
        assert!(out.status.success(), "{name}: {}", String::from_utf8_lossy(&out.stderr));
        let out = String::from_utf8(out.stdout).expect("UTF-8");
        let mut lines = out.lines();
        let robot = robot(name);
        let own: Vec<&str> = robot.joints().map(|joint| joint.name.as_str()).collect();
        assert_eq!(lines.next().expect("names").split(' ').collect::<Vec<_>>(), own, "{name}");
        let n = own.len();
        let (mut points, mut due) = (vec![], vec![]);
        for line in lines {
            let all: Vec<f64> = line.split(' ').map(|x| x.parse().expect("a number")).collect();
            let part = |k: usize| all[k * n..(k + 1) * n].to_vec();
            points.push([part(0), part(1), part(2)]);
            due.push(part(3));
        }
        let found = accelerations(&case(&robot.spec_text(None, (name, ""), "")), &points);
        let mut worst = 0.0_f64;
        for (found, due) in found.iter().zip(&due) {
            let size = due.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let off = found.iter().zip(due).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
            worst = worst.max(off / size);
        }
        // Twelve digits of each number stand in the spec.
        assert!(points.len() == 40 && worst < 1e-8, "{name}: {worst:e}");
    }
}

/// J. J. Craig, Introduction to Robotics, 3rd ed., 6.7, with inertias about the centres of mass.
#[test]
fn two_links_move_as_their_equations_by_hand_say() {
    let case = case(&robot("two_link.urdf").spec_text(None, ("two_link.urdf", ""), ""));
    let (m1, a1, i1, l, g) = (1.5, 0.2, 0.021, 0.4, 9.81);
    // The hand as a part of the fore arm.
    let (ma, mb) = (0.8, 0.3);
    let (m2, a2) = (ma + mb, (ma * 0.15 + mb * 0.3) / (ma + mb));
    let i2 = 0.007 + ma * (0.15_f64 - a2).powi(2) + 0.0004 + mb * (0.3_f64 - a2).powi(2);
    for point in 0..20 {
        let turn = |j: usize| (1.7 * (point * 6 + j) as f64).sin();
        let [q1, q2, w1, w2, t1, t2] = std::array::from_fn(|j| 3.0 * turn(j));
        let (c2, s2): (f64, f64) = (q2.cos(), q2.sin());
        let m11 = i1 + i2 + m1 * a1 * a1 + m2 * (l * l + a2 * a2 + 2.0 * l * a2 * c2);
        let m12 = i2 + m2 * (a2 * a2 + l * a2 * c2);
        let m22 = i2 + m2 * a2 * a2;
        let h = m2 * l * a2 * s2;
        // About +y a turn brings the arm down.
        let torque1 = g * ((m1 * a1 + m2 * l) * q1.cos() + m2 * a2 * (q1 + q2).cos());
        let torque2 = g * m2 * a2 * (q1 + q2).cos();
        let f1 = t1 + torque1 + h * (2.0 * w1 * w2 + w2 * w2) - 0.05 * w1;
        let f2 = t2 + torque2 - h * w1 * w1 - 0.02 * w2;
        let det = m11 * m22 - m12 * m12;
        let due = [(m22 * f1 - m12 * f2) / det, (m11 * f2 - m12 * f1) / det];
        let found = &accelerations(&case, &[[vec![q1, q2], vec![w1, w2], vec![t1, t2]]])[0];
        for (a, b) in found.iter().zip(due) {
            assert!((a - b).abs() < 1e-9 * (1.0 + b.abs()), "{found:?} {due:?}");
        }
    }
}
