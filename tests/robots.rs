//! Robots of URDF and MJCF: from MuJoCo's motion to friction, and back into MuJoCo.

use crate::common::{Scratch, phisindy, skipped, top};
use std::path::PathBuf;
use std::process::Command;

fn fixture(name: &str) -> PathBuf {
    top().join("crates/import/tests/fixtures/robots").join(name)
}

/// The motion of a robot, with this noise of its places (rad), as the text of a log.
fn moved(python: &std::ffi::OsStr, model: &str, noise: &str) -> String {
    let mut run = Command::new(python);
    run.arg(fixture("simulate.py")).args([model, "12", "0.01", noise, "1.2", "1.5", "0"]);
    let out = run.output().expect("Python");
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    String::from_utf8(out.stdout).expect("UTF-8")
}

/// The places of the joints in a log.
fn places(log: &str) -> Vec<[f64; 2]> {
    let row = |line: &str| {
        let all: Vec<f64> = line.split(',').map(|x| x.parse().expect("a number")).collect();
        [all[1], all[4]]
    };
    log.lines().skip(1).map(row).collect()
}

/// Friction that MuJoCo has and the file that is read does not is found, goes back into the file, and moves the robot
/// there as it was.
#[test]
fn friction_in_mujoco_is_found_and_goes_back() {
    let python = std::env::var_os("PHISINDY_MUJOCO").unwrap_or_else(|| "python3".into());
    if !Command::new(&python).args(["-c", "import mujoco"]).output().is_ok_and(|out| out.status.success()) {
        skipped("Python has no package `mujoco` (PHISINDY_MUJOCO names another one)");
        return;
    }
    let folder = Scratch::new("robot");
    let noise = 2e-4;
    let truth = fixture("two_link.xml").to_str().expect("UTF-8").to_owned();
    std::fs::write(folder.path("log.csv"), moved(&python, &truth, &noise.to_string())).expect("a log");
    let model = folder.path("arm.xml");
    let text = std::fs::read_to_string(&truth).expect("a robot");
    let friction = " frictionloss=\"0.4\"";
    assert!(text.contains(friction));
    std::fs::write(&model, text.replace(friction, "")).expect("a robot");
    let (spec, found, back) = (folder.path("arm.ron"), folder.path("found"), folder.path("back.xml"));
    let new = phisindy(&["new", &model, "--data", &folder.path("log.csv"), "--out", &spec]);
    assert_eq!(new.code, 0, "{}", new.err);
    assert!(new.err.contains("elbow: `elbow_pos`, `elbow_vel`, `elbow_effort`"), "{}", new.err);
    let gap = phisindy(&["gap", &spec, "--out", &found, "--quiet"]);
    assert_eq!(gap.code, 0, "{}{}", gap.out, gap.err);
    assert!(gap.out.contains("Coulomb friction at dq1"), "{}", gap.out);
    let export = phisindy(&["export", &found, "--to", "mjcf", "--model", &model, "--out", &back]);
    assert_eq!(export.code, 0, "{}", export.err);
    assert!(export.err.starts_with("shoulder: dry 0.400"), "{}", export.err);
    let (due, again) = (places(&moved(&python, &truth, "0")), places(&moved(&python, &back, "0")));
    assert!(due.len() == 1200 && again.len() == 1200);
    for (a, b) in due.iter().zip(&again) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2.0 * noise), "{a:?} {b:?}");
    }
}

#[test]
fn what_no_robot_can_be_is_refused_with_what_to_do() {
    let folder = Scratch::new("robot_refused");
    let arm = fixture("two_link.urdf").to_str().expect("UTF-8").to_owned();
    let log = folder.path("log.csv");
    let rows: Vec<String> =
        (0..100).map(|k| format!("{},{}", f64::from(k) * 0.01, (0.1 * f64::from(k)).sin())).collect();
    std::fs::write(&log, format!("t,pressure\n{}\n", rows.join("\n"))).expect("a log");
    let says = |arguments: &[&str], code: i32, words: &str| {
        let out = phisindy(arguments);
        assert!(out.code == code && out.err.contains(words), "{arguments:?}: {} {}", out.code, out.err);
    };
    says(
        &["new", &arm, "--data", &log],
        2,
        "no column is the place or the speed of a joint: `shoulder`, `elbow`",
    );
    says(&["new", &log, "--data", &arm], 2, "is neither URDF nor MJCF");
    says(&["go", &arm], 2, "is a robot, whose draft has to be looked at first");
    let spec = folder.path("arm.ron");
    says(&["new", &arm, "--out", &spec], 0, "phisindy simulate");
    says(&["check", &spec], 0, "no mistakes");
    says(&["export", &spec, "--to", "urdf"], 2, "say which one, as in `--model robot.urdf`");
    says(&["export", &spec, "--to", "mjcf", "--model", &arm], 2, "is URDF: say `--to urdf`");
    says(&["export", &spec, "--to", "python", "--model", &arm], 2, "means nothing to `--to python`");
    // What the file says of friction comes back as it was.
    let out = phisindy(&["export", &spec, "--to", "urdf", "--model", &arm]);
    assert!(out.out.contains("<dynamics damping=\"0.05\" friction=\"0.4\"/>"), "{}{}", out.out, out.err);
    let broken = folder.path("broken.xml");
    std::fs::write(&broken, "<mujoco>\n  <worldbody>\n    <body\n</mujoco>").expect("a file");
    says(&["new", &broken], 2, "this is no XML");
    says(&["new", &broken], 2, "broken.xml:4");
}
