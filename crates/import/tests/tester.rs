//! A force beside a displacement: of a friction tester, of a body that it drives, or of either.
#![allow(missing_docs)]

use phisindy_expr::Span;
use phisindy_import::{DataFile, Draft, Drive, Usage, accepted, spec_text, table};
use phisindy_phys::Sources;
use std::fmt::Write;

/// Time, displacement in millimetres and force of 4000 samples.
fn file(motion: impl Fn(f64) -> f64, force: impl Fn(f64, f64) -> f64) -> String {
    let mut text = "time_s,x_mm,F_N\n".to_owned();
    for k in 0..4000_u64 {
        let (t, h) = (0.005 * k as f64, 1e-4);
        let v = (motion(t + h) - motion(t - h)) / (2.0 * h);
        // One per cent or so of noise, the same in every run.
        let mixed = (k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let noise = (mixed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        let _ = writeln!(text, "{t:.4},{:.6},{:.4}", 1e3 * motion(t), force(motion(t), v) + noise);
    }
    text
}

fn drafted(content: &str) -> (Draft, String) {
    let mut sources = Sources::default();
    let at = (sources.add("command line", "rig.csv"), Span::new(0, 7));
    let table =
        table(DataFile::of_bytes("rig.csv", content.as_bytes()), None, at, &mut sources).expect("a table");
    let draft = Draft::of(table).expect("a draft");
    let text = spec_text(&draft, "rig.csv", "rig.ron");
    accepted(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    (draft, text)
}

fn triangle(t: f64) -> f64 {
    let phase = (0.4 * t).rem_euclid(1.0);
    10e-3 * (4.0 * (phase - 0.5).abs() - 1.0)
}

#[test]
fn a_friction_tester_gets_a_force_as_output_and_no_state() {
    let dry = |x: f64, v: f64| 2000.0 * x + (30.0 + 20.0 * (-(v / 5e-3).powi(2)).exp()) * v.signum() + 4.0;
    let two = |t: f64| 10e-3 * (2.0 * t).sin() + 4e-3 * (5.0 * t).sin();
    // A triangle has two speeds, so that a damper is dry friction.
    let damped = "reads: \"k*x + c*dx\"";
    for (content, reads) in [
        (file(two, dry), damped),
        (file(|t| 10e-3 * (3.0 * t).sin(), dry), damped),
        (file(triangle, dry), "reads: \"k*x\""),
    ] {
        let (draft, text) = drafted(&content);
        let Drive::Tester { stiffness, .. } = draft.drive else {
            panic!("{:?} of\n{}", draft.drive, &content[..400])
        };
        assert!((1000.0..3000.0).contains(&stiffness), "{stiffness}");
        assert_eq!(draft.usages[1..], [Usage::Prescribed, Usage::Reaction]);
        for part in [
            "states: {},",
            "inputs: { \"x\": \"m\", \"dx\": \"m/s\" }",
            reads,
            // A formula stands in one line.
            "\"(F - c*v - k*x)/m\"",
            "derive: { \"dx\": Derivative(\"x\") }",
            "\"x\": (\"x_mm\", \"mm\"), \"F\": (\"F_N\", \"N\")",
        ] {
            assert!(text.contains(part), "expected {part:?} in\n{text}");
        }
    }
}

#[test]
fn the_damper_of_a_tester_starts_where_the_data_say() {
    let two = |t: f64| 10e-3 * (2.0 * t).sin() + 4e-3 * (5.0 * t).sin();
    let (draft, text) = drafted(&file(two, |x, v| 500.0 * x + 300.0 * v + 20.0 * v.signum()));
    let Drive::Tester { damping: Some(damping), .. } = draft.drive else { panic!("{:?}", draft.drive) };
    assert!((damping / 300.0 - 1.0).abs() < 0.2, "{damping}\n{text}");
    // A force that falls with the speed has no damper to begin with.
    let falling = file(two, |_, v| (30.0 + 20.0 * (-(v / 5e-3).powi(2)).exp()) * v.signum());
    assert!(drafted(&falling).1.contains("\"c\": (value: 0.0,"));
}

#[test]
fn what_the_data_do_not_tell_is_drafted_as_a_body_beside_the_other_form() {
    let (draft, text) = drafted(&file(|t| 10e-3 * (3.0 * t).sin(), |x, v| 2000.0 * x + 40.0 * v));
    assert_eq!(draft.drive, Drive::Open);
    assert!(text.contains("\"v\": \"(F") && text.contains("For a tester:"), "{text}");
}

#[test]
fn a_body_is_a_body() {
    // F = m a + c v + k x + Fc sgn(v), of two tones.
    let body = |t: f64| 10e-3 * (3.0 * t).sin() + 3e-3 * (17.0 * t).sin();
    let text: String = {
        let a = |t: f64| -0.09 * (3.0 * t).sin() - 0.867 * (17.0 * t).sin();
        let mut text = "time_s,x_mm,F_N\n".to_owned();
        for k in 0..4000 {
            let t = 0.005 * f64::from(k);
            let v = 0.03 * (3.0 * t).cos() + 0.051 * (17.0 * t).cos();
            let force = 40.0 * a(t) + 2000.0 * body(t) + 10.0 * v + 3.0 * v.signum();
            let _ = writeln!(text, "{t:.4},{:.6},{force:.5}", 1e3 * body(t));
        }
        text
    };
    let (draft, text) = drafted(&text);
    assert_eq!(draft.drive, Drive::Body);
    assert!(text.contains("\"v\": \"(F") && !text.contains("tester"), "{text}");
}
