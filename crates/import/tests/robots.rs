//! Robots of URDF and MJCF against MuJoCo, against equations by hand, and broken ones.

use phisindy_expr::{Scratch, Span, Tape};
use phisindy_import::{Answers, DataFile, Refitted, Robot, RobotLog, table};
use phisindy_phys::{Case, SourceId, Sources, check, spec};
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

/// What is wrong with a file, and the text at the place that is named.
fn mistake(text: &str) -> (String, String) {
    let d = Robot::read(text, SourceId(0)).expect_err(text);
    assert!(!d.help.is_empty(), "{}", d.message);
    let span = d.labels.first().unwrap_or_else(|| panic!("{} has no place", d.message)).span;
    (d.message.clone(), text[span.start..span.end].to_owned())
}

#[test]
fn mistakes_of_robots_have_their_places() {
    let [urdf, mjcf] =
        ["two_link.urdf", "two_link.xml"].map(|name| std::fs::read_to_string(file(name)).expect("a file"));
    for (text, from, to, message, at) in [
        (&urdf, "<link name=\"base\"/>", "<link name=\"base\">", "this is no XML", ""),
        (&urdf, "<robot name=\"two_link\">", "<robt>", "this is no XML", ""),
        (&urdf, "mass value=\"1.5\"", "mass value=\"heavy\"", "`value` holds no numbers: \"heavy\"", "heavy"),
        (&urdf, "xyz=\"0.2 0 0\"", "xyz=\"0.2 0\"", "`xyz` has 3 numbers, and here are 2", "0.2 0"),
        (&urdf, "ixx=\"0.002\"", "ixx=\"-0.002\"", "no body has such an inertia", "<inertial>"),
        (
            &urdf,
            "type=\"continuous\"",
            "type=\"floating\"",
            "joint `elbow` is `floating`",
            "<joint name=\"elbow\" type=\"floating\">",
        ),
        (
            &urdf,
            "<child link=\"hand\"/>",
            "<child link=\"base\"/>",
            "joint `shoulder` is in a closed loop",
            "<joint name=\"shoulder\" type=\"revolute\">",
        ),
        (
            &urdf,
            "<child link=\"hand\"/>",
            "<child link=\"upper\"/>",
            "joints `shoulder` and `wrist` carry the same link: a closed loop",
            "<joint name=\"wrist\" type=\"fixed\">",
        ),
        (
            &urdf,
            "<parent link=\"fore\"/>",
            "<parent link=\"for\"/>",
            "there is no link `for`",
            "<parent link=\"for\"/>",
        ),
        (&urdf, "<joint name=\"elbow\"", "<joint", "`<joint>` has no `name`", "<joint type=\"continuous\">"),
        (
            &urdf,
            "<axis xyz=\"0 1 0\"/><dynamics damping=\"0.02\"/>",
            "<mimic joint=\"shoulder\"/>",
            "joint `elbow` follows another one",
            "<mimic joint=\"shoulder\"/>",
        ),
        (&urdf, "damping=\"0.02\"", "damping=\"-1\"", "`damping` is not negative, and -1 is", "-1"),
        (
            &urdf,
            "<link name=\"base\"/>",
            "<link name=\"base\"/><link name=\"table\"/>",
            "`table` hangs on nothing, and so does `base`",
            "<link name=\"table\"/>",
        ),
        (
            &mjcf,
            "<joint name=\"elbow\"",
            "<joint type=\"ball\" name=\"elbow\"",
            "`elbow` is a ball joint",
            "<joint type=\"ball\" name=\"elbow\" class=\"main\" damping=\"0.15\"/>",
        ),
        (
            &mjcf,
            "<joint name=\"elbow\"",
            "<freejoint/><joint name=\"elbow\"",
            "a free joint is not read",
            "<freejoint/>",
        ),
        (
            &mjcf,
            "<actuator>",
            "<equality><weld body1=\"hand\"/></equality><actuator>",
            "closed loops",
            "<equality>",
        ),
        (
            &mjcf,
            "<actuator>",
            "<tendon><fixed name=\"t\"/></tendon><actuator>",
            "tendons are not read",
            "<tendon>",
        ),
        (
            &mjcf,
            "<inertial pos=\"0.2 0 0\" mass=\"1.5\" diaginertia=\"0.002 0.021 0.02\"/>",
            "<geom type=\"mesh\" mesh=\"upper\"/>",
            "the inertia of a mesh is not read",
            "<geom type=\"mesh\" mesh=\"upper\"/>",
        ),
        (
            &mjcf,
            "childclass=\"arm\"",
            "childclass=\"arms\"",
            "there is no class `arms`",
            "<joint name=\"shoulder\" range=\"-3 3\"/>",
        ),
        (
            &mjcf,
            "joint=\"elbow\"",
            "joint=\"elbo\"",
            "there is no joint `elbo`",
            "<motor name=\"m_elbow\" joint=\"elbo\"/>",
        ),
        (
            &mjcf,
            "<worldbody>",
            "<include file=\"a.xml\"/><worldbody>",
            "other files are not read",
            "<include file=\"a.xml\"/>",
        ),
        (
            &mjcf,
            "<joint axis=\"0 1 0\"/>",
            "<joint axis=\"0 0 0\"/>",
            "this axis has no direction",
            "<joint name=\"shoulder\" range=\"-3 3\"/>",
        ),
    ] {
        assert!(text.contains(from), "{from}");
        let (found, place) = mistake(&text.replacen(from, to, 1));
        assert!(found.starts_with(message), "{found}");
        assert!(at.is_empty() || place == at, "{found}: {place}");
    }
    let massless = r#"<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="revolute"><parent link="a"/><child link="b"/></joint></robot>"#;
    assert_eq!(mistake(massless).0, "joint `j` moves nothing that has a mass");
    assert_eq!(mistake("<mujoco><worldbody/></mujoco>").0, "nothing moves: there are no joints");
    assert_eq!(mistake("<html/>").0, "`<html>` is no robot");
    assert!(
        mistake("<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"><xacro:a/></robot>")
            .0
            .contains("xacro")
    );
    // What is nested as deep as nobody nests it ends in a message, too.
    let deep = format!(
        "<mujoco><worldbody>{}{}</worldbody></mujoco>",
        "<body>".repeat(5000),
        "</body>".repeat(5000)
    );
    assert!(Robot::read(&deep, SourceId(0)).is_err());
}

/// Whatever is cut off or damaged, there is a message or a robot.
#[test]
fn a_damaged_robot_makes_no_panic() {
    for name in ["two_link.urdf", "skew.xml", "arm6.xml"] {
        let text = std::fs::read_to_string(file(name)).expect("a file");
        for at in (0..text.len()).step_by(7) {
            let _ = Robot::read(&text[..at], SourceId(0));
            let mut damaged = text.clone().into_bytes();
            damaged[at] = b"<>\"0- e9"[at % 8];
            let damaged = String::from_utf8(damaged).expect("ASCII");
            if let Ok(robot) = Robot::read(&damaged, SourceId(0)) {
                let _ = robot.spec_text(None, (name, ""), "");
            }
        }
    }
}

/// The columns of a log and the joints that they are of.
#[test]
fn logs_name_their_joints_in_many_ways() {
    let robot = robot("two_link.xml");
    for (headings, due) in [
        ("t,shoulder_pos,shoulder_vel,shoulder_effort,elbow_pos,elbow_effort", "q1 dq1 tau1 q2 tau2"),
        ("time,q1,dq1,tau1,q2,dq2,tau2", "q1 dq1 tau1 q2 dq2 tau2"),
        ("time,q_0,q_1,current_0,current_1", "q1 i1 q2 i2"),
        (
            "t [s],/joint_states/shoulder/position,/joint_states/elbow/position,m_shoulder,m_elbow",
            "q1 u1 q2 u2",
        ),
        ("t,position[0],position[1],effort[0],target_q_1", "q1 tau1 q2"),
        ("t,shoulder_pos,elbow_pos,m_shoulder_effort,elbow_temperature,elbow_V", "q1 u1 q2"),
        ("t_ms,shoulder_deg,elbow_deg,shoulder_Nm", "q1 tau1 q2"),
    ] {
        let rows: Vec<String> = (0..60)
            .map(|k| {
                headings
                    .split(',')
                    .enumerate()
                    .map(|(c, _)| {
                        format!(
                            "{}",
                            if c == 0 { f64::from(k) * 10.0 } else { (0.1 * f64::from(k) * c as f64).sin() }
                        )
                    })
                    .collect::<Vec<_>>()
                    .join(",")
            })
            .collect();
        let bytes = format!("{headings}\n{}\n", rows.join("\n")).into_bytes();
        let size = bytes.len() as u64;
        let mut sources = Sources::default();
        let at = (sources.add("line", "log"), Span::new(0, 3));
        let data = DataFile::new("log.csv", std::io::Cursor::new(bytes), size);
        let table = table(data, None, at, &mut sources).unwrap_or_else(|d| panic!("{}", d.message));
        let log = RobotLog::of(table, &robot, &Answers::default())
            .unwrap_or_else(|why| panic!("{headings}: {}", why.diagnostic("log.csv", at).message));
        let text = robot.spec_text(Some(&log), ("two_link.xml", "log.csv"), "robot.ron");
        let read = spec::read(&text, SourceId(0)).unwrap_or_else(|d| panic!("{d:?}\n{text}")).0;
        let case = check(&read, SourceId(0)).unwrap_or_else(|d| panic!("{d:?}\n{text}")).0;
        assert_eq!(case.records.len(), 2);
        let columns = text.split("columns: { ").nth(1).expect("columns").split(" },").next().expect("an end");
        // What stands before a colon.
        let found: Vec<&str> = columns.split("\": ").filter_map(|part| part.rsplit('"').next()).collect();
        let found = &found[..found.len() - 1];
        assert_eq!(found.join(" "), due, "{headings}: {columns}");
        assert_eq!(text.contains("\"50*u1\": \"dq1\""), due.contains(" u1"));
        assert_eq!(text.contains("\"K1*i1\": \"dq1\""), due.contains("i1"));
    }
}

/// A file that gets its own numbers back, and new ones, says the same otherwise.
#[test]
fn friction_goes_back_where_it_came_from() {
    for name in ["two_link.urdf", "two_link.xml", "skew.urdf", "skew.xml", "arm6.xml"] {
        let text = std::fs::read_to_string(file(name)).expect("a file");
        let before = robot(name);
        let refitted: Vec<Refitted> = before
            .joints()
            .map(|joint| Refitted {
                joint: joint.name.clone(),
                dry: joint.friction + 0.25,
                viscous: 2.0 * joint.damping + 0.5,
                armature: Some(0.125),
            })
            .collect();
        let (written, lost) = Robot::with_friction(&text, SourceId(0), &refitted)
            .unwrap_or_else(|d| panic!("{name}: {}", d.message));
        assert!(lost.is_empty(), "{lost:?}");
        let after =
            Robot::read(&written, SourceId(0)).unwrap_or_else(|d| panic!("{name}: {}\n{written}", d.message));
        for ((old, new), due) in before.joints().zip(after.joints()).zip(&refitted) {
            assert!(
                (new.friction - due.dry).abs() < 1e-12 && (new.damping - due.viscous).abs() < 1e-12,
                "{name}: {new:?}"
            );
            assert_eq!(new.armature, if name.ends_with("xml") { 0.125 } else { 0.0 });
            assert_eq!((&old.name, old.motion), (&new.name, new.motion));
        }
        // Lines that are about no joint are untouched.
        assert_eq!(text.lines().count(), written.lines().count());
        assert!(
            text.lines().zip(written.lines()).all(|(a, b)| a == b
                || a.contains("<joint")
                || a.contains("dynamics")
                || a.contains("<axis")
                || a.contains("<limit")),
            "{written}"
        );
    }
}
