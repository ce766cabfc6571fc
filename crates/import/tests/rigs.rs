//! Drafts of the kind of rig that the user says, and what is asked where nobody says it.
#![allow(missing_docs)]

use phisindy_expr::Span;
use phisindy_import::{
    Answers, DataFile, Draft, Input, Question, Rig, accepted, spec_text, spec_text_of, table,
};
use phisindy_phys::Sources;
use std::fmt::Write;

fn drafted(content: &str, answers: &Answers) -> Result<(Draft, String), String> {
    let mut sources = Sources::default();
    let at = (sources.add("command line", "rig.csv"), Span::new(0, 7));
    let table =
        table(DataFile::of_bytes("rig.csv", content.as_bytes()), None, at, &mut sources).expect("a table");
    let draft =
        Draft::with_answers(table, answers, &|_| {}).map_err(|why| why.diagnostic("rig.csv", at).message)?;
    let text = spec_text(&draft, "rig.csv", "rig.ron");
    accepted(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    Ok((draft, text))
}

fn said(rig: Rig) -> Answers {
    Answers { rig: Some(rig), ..Answers::default() }
}

/// Rows of this heading at 100 Hz.
fn rows(heading: &str, row: impl Fn(f64) -> Vec<f64>) -> String {
    let mut text = format!("{heading}\n");
    for k in 0..2000 {
        let numbers: Vec<String> = row(0.01 * f64::from(k)).iter().map(|x| format!("{x:.6}")).collect();
        let _ = writeln!(text, "{}", numbers.join(","));
    }
    text
}

#[test]
fn a_motion_that_goes_on_is_driven_by_something() {
    let going = rows("t_s,x_m", |t| vec![t, (5.0 * t).sin() + 0.3 * (11.3 * t).sin()]);
    let (draft, text) = drafted(&going, &Answers::default()).expect("a draft");
    assert_eq!(draft.questions, [Question::Drive { heading: "x_m".to_owned(), beside: None }]);
    assert!(text.starts_with("// QUESTION: `x_m` does not die out"), "{text}");
    // The user says that nothing does.
    let mut answers = Answers::default();
    draft.questions[0].answered("free", &mut answers).expect("an answer");
    assert_eq!(drafted(&going, &answers).expect("a draft").0.questions, []);
    assert!(draft.questions[0].answered("wind", &mut answers).expect_err("no rig").contains("quarter-car"));
    // What dies out is free, to its rest too.
    let ringing = rows("t_s,x_m", |t| vec![t, (-0.4 * t).exp() * (5.0 * t).sin()]);
    assert_eq!(drafted(&ringing, &Answers::default()).expect("a draft").0.questions, []);
    let stopping = rows("t_s,x_m", |t| vec![t, (1.0 - 0.1 * t).max(0.0) * (5.0 * t.min(10.0)).sin()]);
    assert_eq!(drafted(&stopping, &Answers::default()).expect("a draft").0.questions, []);
}

#[test]
fn a_rig_that_is_said_has_its_model() {
    let turned = rows("t_s,theta_rad,i_A", |t| vec![t, (2.0 * t).sin(), 3.0 * (2.0 * t + 0.4).sin()]);
    let (draft, text) = drafted(&turned, &said(Rig::Motor)).expect("a draft");
    assert!(matches!(draft.roles.input, Input::Drive(2)) && text.contains("\"w\": \"-c*w + b*F\""), "{text}");
    for rig in [Rig::RobotJoint, Rig::Pendulum] {
        let (_, text) = drafted(&turned, &said(rig)).expect("a draft");
        assert!(text.contains("k*sin(theta) + b*F"), "{rig}: {text}");
    }
    // A base without a word for it, and a base that is none.
    let two =
        rows("t_s,x1_mm,x2_mm,F_N", |t| vec![t, (5.0 * t).sin(), (5.0 * t + 0.3).sin(), (9.0 * t).sin()]);
    let (draft, text) = drafted(&two, &said(Rig::BaseExcited)).expect("a draft");
    assert!(
        matches!(draft.roles.input, Input::Base(_)) && text.contains("-c*(v - du) - k*(x - u)"),
        "{text}"
    );
    let (draft, _) = drafted(&two, &said(Rig::Slider)).expect("a draft");
    assert!(matches!(draft.roles.input, Input::Force(3)), "{:?}", draft.roles);
    let (_, text) = drafted(&two, &said(Rig::Tester)).expect("a draft");
    assert!(text.contains("outputs: { \"F\""), "{text}");
    // Of what is not there it is told.
    for (rig, content, what) in [
        (Rig::BaseExcited, &turned, "for `--rig base-excited` there is no column of the motion of the base"),
        (
            Rig::QuarterCar,
            &two,
            "for `--rig quarter-car` there is no column of the displacement of the wheel",
        ),
        (
            Rig::Motor,
            &rows("t_s,theta_rad", |t| vec![t, (2.0 * t).sin()]),
            "for `--rig motor` there is no column of a force, torque, current or voltage",
        ),
        (Rig::Tester, &turned, "for `--rig tester` there is no column of a displacement along a line"),
        (Rig::Pendulum, &two, "for `--rig pendulum` there is no column of an angle"),
        (Rig::RobotJoint, &two, "for `--rig robot-joint` there is no column of an angle"),
        (Rig::Slider, &turned, "for `--rig slider` there is no column of a displacement along a line"),
    ] {
        let why = drafted(content, &said(rig)).expect_err("no draft");
        assert!(why.contains(what), "{why}");
    }
}

#[test]
fn a_quarter_car_has_two_bodies() {
    let content = rows("t_s,body_mm,wheel_mm,road_mm", |t| {
        vec![t, 20.0 * (7.0 * t).sin(), 9.0 * (7.0 * t + 0.5).sin(), 8.0 * (7.0 * t + 0.6).sin()]
    });
    let (draft, text) = drafted(&content, &said(Rig::QuarterCar)).expect("a draft");
    for part in [
        "\"x1\": (\"body_mm\", \"mm\"), \"x2\": (\"wheel_mm\", \"mm\"), \"u\": (\"road_mm\", \"mm\")",
        "\"v2\": \"(k1*(x1 - x2) + c1*(v1 - v2) - k2*(x2 - u))/m2\"",
    ] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    assert_eq!(draft.roles.wheel, Some(2));
}

/// Slow cycles, as a testing machine writes them: displacement and force, no time.
#[test]
fn a_tester_needs_no_times() {
    let way = |t: f64| 5.0 * (1.0 - 0.02 * t) * (0.9 * t).sin();
    let content = rows("x_mm,F_kN", |t| {
        let (x, ahead) = (way(t), way(t + 1e-3));
        vec![x, 0.4 * x + 1.3 * (ahead - x).signum()]
    });
    let (draft, text) = drafted(&content, &Answers::default()).expect("a draft");
    assert!(matches!(draft.roles.input, Input::Reaction(1)), "{:?}", draft.roles.input);
    assert!(
        text.contains("time: Rate(1.0)")
            && text.contains("reads: \"k*x\"")
            && draft.questions == [Question::Rate],
        "{text}"
    );
    // A body without times is asked for its rate as before.
    let body = rows("x_mm,v_mm/s", |t| vec![5.0 * (3.0 * t).sin(), 15.0 * (3.0 * t).cos()]);
    let why = drafted(&body, &Answers::default()).expect_err("no rate");
    assert!(why.contains("time"), "{why}");
}

#[test]
fn files_of_one_rig_have_one_spec() {
    let of = |load: f64| {
        rows("t_s,x_mm,F_N,load_kg", |t| vec![t, (5.0 * t).sin(), 3.0 * (5.0 * t + 0.2).sin(), load])
    };
    let drafts = [of(0.25), of(0.45)].map(|text| drafted(&text, &Answers::default()).expect("a draft").0);
    let text = spec_text_of(&[(&drafts[0], "rig_250g.csv"), (&drafts[1], "rig_450g.csv")], "rig.ron")
        .expect("a spec");
    accepted(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    for part in [
        "path: \"rig_250g.csv\"",
        "path: \"rig_450g.csv\"",
        "the names of the files: 250g, 450g; `load_kg`: 0.25, 0.45",
    ] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
    let other = drafted(&of(1.0).replace("x_mm", "x_m"), &Answers::default()).expect("a draft").0;
    let why = spec_text_of(&[(&drafts[0], "a.csv"), (&other, "b.csv")], "rig.ron").expect_err("another unit");
    assert!(
        why.contains("`b.csv` is read in another way than `a.csv`") && why.contains("`x_m` in m,"),
        "{why}"
    );
}
