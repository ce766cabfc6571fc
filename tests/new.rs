//! `phisindy new`: a data file as people have it becomes a spec that runs.

#![allow(missing_docs)]

use crate::common::{Outcome, Scratch, phisindy};
use std::fmt::Write;

/// A free oscillator with dry friction, x'' = -k (x - offset) - c v - f sgn v, in small steps: 40 rad/s^2,
/// 0.2 1/s, 0.5 m/s^2. Times and places.
fn ring_down(samples: usize, step: f64) -> Vec<(f64, f64)> {
    let (mut x, mut v, mut out) = (0.1, 0.0, Vec::new());
    for k in 0..samples {
        out.push((k as f64 * step, x));
        for _ in 0..200 {
            let h = step / 200.0;
            let push = -40.0 * x - 0.2 * v;
            let next: f64 = v + h * (push - 0.5 * f64::signum(if v == 0.0 { push } else { v }));
            // It stands still once friction holds it where it turns.
            v = if next * v < 0.0 || (v == 0.0 && push.abs() < 0.5) { 0.0 } else { next };
            x += h * v;
        }
    }
    out
}

/// A little disturbance of a given size, the same in every run of the test.
fn noise(k: usize, size: f64) -> f64 {
    let mixed = (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    size * 3.4
        * (((mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11) as f64 / (1_u64 << 53) as f64
            - 0.5)
}

/// The value of a parameter in the text of `run`.
fn fitted(run: &Outcome, name: &str) -> f64 {
    let line = run.out.lines().find(|l| l.starts_with(&format!("% {name} "))).expect(name);
    line.split_whitespace().nth(3).and_then(|v| v.parse().ok()).unwrap_or(f64::NAN)
}

/// `new` on a file with this content, then `check` on what it wrote: the spec and what was said.
#[track_caller]
fn made(name: &str, content: &[u8]) -> (Scratch, String, Outcome) {
    let scratch = Scratch::new(name);
    let (data, spec) = (scratch.path("rig.csv"), scratch.path("rig.ron"));
    std::fs::write(&data, content).expect("a file");
    let said = phisindy(&["new", &data, "--out", &spec]);
    assert_eq!((said.code, said.out.as_str()), (0, ""), "{}", said.err);
    let text = std::fs::read_to_string(&spec).expect("a spec");
    (scratch, text, said)
}

#[track_caller]
fn checked(scratch: &Scratch, text: &str) {
    let spec = scratch.path("rig.ron");
    let said = phisindy(&["check", &spec]);
    // A question of the draft stays open until somebody answers it.
    let open = text.matches("// QUESTION: ").count();
    assert_eq!(said.err.matches("a question of this draft is open").count(), open, "{text}\n{}", said.err);
    let last = said.err.lines().last().unwrap_or_default();
    let due = match open {
        0 => format!("{spec}: no mistakes"),
        1 => format!("{spec}: no mistakes, 1 warning"),
        n => format!("{spec}: no mistakes, {n} warnings"),
    };
    assert_eq!((said.code, last, said.err.matches("warning: ").count()), (0, due.as_str(), open), "{text}");
}

#[track_caller]
fn holds(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "expected {part:?} in\n{text}");
    }
}

#[test]
fn a_ring_down_runs_as_it_is() {
    let mut file = "# rig 7, Monday\ntime_s;Weg [mm];Bemerkung\n".to_owned();
    for (k, (t, x)) in ring_down(1200, 0.005).into_iter().enumerate() {
        let row = format!("{t:.4};{:.5};gut\n", 1e3 * x + 20.0 + noise(k, 0.02));
        file.push_str(&row.replace('.', ","));
    }
    let (scratch, text, said) = made("ringdown", file.as_bytes());
    holds(&said.err, &["1200 rows", "200 Hz", "motion `Weg [mm]`", "phisindy run"]);
    holds(
        &text,
        &[
            "separator: ';', decimal: ','",
            "(\"Weg [mm]\", \"mm\")",
            "role: Validate",
            "words, not used",
            "stands still",
            "// EDIT",
        ],
    );
    checked(&scratch, &text);
    let run = phisindy(&["run", &scratch.path("rig.ron"), "--format", "json"]);
    let result: serde_json::Value =
        serde_json::from_str(&run.out).unwrap_or_else(|e| panic!("{e}: {}", run.err));
    assert_eq!((run.code, &result["verdict"]), (0, &"identified".into()), "{}", run.err);
    let friction = result["equations"][0]["terms"][0]["coefficient"].as_f64().expect("a number");
    assert!((friction - 0.5).abs() < 0.02, "{}", run.out);
    let k = result["parameters"]
        .as_array()
        .expect("a list")
        .iter()
        .find(|p| p["name"] == "k")
        .expect("a stiffness");
    assert!((k["value"].as_f64().expect("a number") - 40.0).abs() < 0.5, "{k}");
}

/// A table with heading `heading`, `rows` rows written by `row`.
fn table(heading: &str, rows: usize, row: impl Fn(usize, f64) -> String) -> String {
    let body = (0..rows).fold(String::new(), |mut all, k| {
        let _ = writeln!(all, "{}", row(k, 0.01 * k as f64));
        all
    });
    if heading.is_empty() { body } else { format!("{heading}\n{body}") }
}

#[test]
fn every_way_to_write_a_table_is_read() {
    for (file, parts) in [
        (
            table("t x", 300, |_, t| format!("{t:.3}  {:.4}", (5.0 * t).sin())),
            &["separator: ' '", "taken: s", "gives no unit"] as &[&str],
        ),
        (
            table("t/s\tx/mm", 300, |_, t| format!("{t:.3}\t{:.4}", (5.0 * t).sin())),
            &["separator: '\\t'", "(\"t/s\", \"s\")", "(\"x/mm\", \"mm\")"],
        ),
        (
            table("", 300, |_, t| format!("{t:.3},{:.4}", (5.0 * t).sin())),
            &["header: false", "time: \"1\"", "\"x\": \"2\"", "which column is time"],
        ),
        (
            table("", 300, |_, t| format!("{t:.3} {:.4}", (5.0 * t).sin()).replace('.', ",")),
            &["separator: ' ', decimal: ','"],
        ),
        (
            table("Zeit;Weg\ns;mm", 300, |_, t| format!("{t:.3};{:.4}", (5.0 * t).sin()).replace('.', ",")),
            &["(\"Zeit\", \"s\")", "(\"Weg\", \"mm\")"],
        ),
        (
            table("x [mm],Time (ms)", 300, |_, t| format!("{:.4},{:.1}", (5.0 * t).sin(), 1e3 * t)),
            &["time: (\"Time (ms)\", \"ms\")", "0.7965 Hz"],
        ),
    ] {
        let name = format!("ways-{}", parts[0].len() * 1000 + file.len());
        let (scratch, text, _) = made(&name, file.as_bytes());
        holds(&text, parts);
        checked(&scratch, &text);
    }
}

#[test]
fn a_base_that_moves_is_an_input_with_its_velocity() {
    let file = table("time_s,x_mass_mm,u_base_mm,temperature_C", 600, |_, t| {
        format!(
            "{t:.3},{:.5},{:.5},21.5",
            (6.0 * t - 0.4).sin() + 0.1 * (18.0 * t).sin() + 3.0,
            (6.0 * t).sin()
        )
    });
    let (scratch, text, said) = made("base", file.as_bytes());
    holds(&said.err, &["base `u_base_mm`"]);
    holds(
        &text,
        &["derive: { \"du\": Derivative(\"u\") }", "offset: Find(", "- k*(x - u)", "constant, not used"],
    );
    checked(&scratch, &text);
}

#[test]
fn a_force_in_newtons_gives_a_mass_and_a_velocity_is_seen_in_the_numbers() {
    let file = table("time_s,ch1,ch2,Force (kN)", 600, |_, t| {
        format!(
            "{t:.3},{:.5},{:.5},{:.6}",
            (6.0 * t).sin(),
            6.0 * (6.0 * t).cos(),
            0.002 * (6.0 * t + 0.5).sin()
        )
    });
    let (scratch, text, said) = made("force", file.as_bytes());
    holds(&said.err, &["motion `ch1`", "force `Force (kN)`"]);
    holds(
        &text,
        &["inertia: { \"v\": \"m\" }", "(\"Force (kN)\", \"kN\")", "a velocity, not used", "\"m\": (value:"],
    );
    checked(&scratch, &text);
}

#[test]
fn counters_and_noise_are_no_motion() {
    let file = table("sample,timestamp,ch0,ch1", 600, |k, t| {
        format!("{k},{:.3},{:.5},{:.5}", 1.7e9 + t, noise(k, 1.0), (-0.2 * t).exp() * (9.0 * t).sin())
    });
    let (scratch, text, said) = made("counter", file.as_bytes());
    holds(&said.err, &["time `timestamp`", "motion `ch1`"]);
    holds(&text, &["counts rows", "nothing but noise"]);
    checked(&scratch, &text);
}

#[test]
fn trials_are_told_apart_by_the_column_that_counts_them() {
    let file = table("trial,enabled,time_s,x_mm", 900, |k, _| {
        let (trial, t) = (k / 300, 0.01 * (k % 300) as f64);
        format!("{},{},{t:.3},{:.5}", trial + 4, u8::from(t < 1.0), (-t).exp() * (9.0 * t).sin())
    });
    let (scratch, text, _) = made("trials", file.as_bytes());
    holds(
        &text,
        &[
            "rows: { \"trial\": 4.0, \"enabled\": 0.0 }",
            "rows: { \"trial\": 6.0, \"enabled\": 0.0 }",
            "jumps back 2 times",
        ],
    );
    assert_eq!(text.matches("role: Validate").count(), 1, "{text}");
    checked(&scratch, &text);
}

/// A logger that loses values here and there: the rows that lack one are left out, and are no noise.
#[test]
fn rows_that_lack_a_value_are_left_out() {
    let file = table("Zeit [s];Weg [mm];Temp", 800, |k, t| {
        let noise = 1e-3 * f64::from((k as u32).wrapping_mul(2_654_435_769).count_ones() % 2) - 5e-4;
        let x = if k % 19 == 7 { String::new() } else { format!("{:.4}", (3.0 * t).sin() + noise) };
        format!("{t:.3};{x};{:.1}", 20.0 + 0.1 * f64::from(k as u32 % 3)).replace('.', ",")
    });
    let (scratch, text, said) = made("dropouts", file.as_bytes());
    holds(&text, &["42 missing", "missing: Omit", "42 of 800 rows lack a value (first in line 9)"]);
    let noise = text
        .lines()
        .find(|l| l.starts_with("// Weg [mm]"))
        .and_then(|l| l.split_whitespace().nth(6)?.parse().ok());
    assert!(noise.is_some_and(|x: f64| (x / 5e-4 - 1.0).abs() < 0.2), "{noise:?} {text}");
    holds(&said.err, &["note: 42 of 800 rows"]);
    let run = phisindy(&["run", &scratch.path("rig.ron")]);
    holds(&run.err, &["21 rows of `rig.csv` are left out"]);
    let strict = text.replace("            missing: Omit,\n", "");
    std::fs::write(scratch.path("rig.ron"), strict).unwrap();
    let refused = phisindy(&["check", &scratch.path("rig.ron")]);
    assert_eq!(refused.code, 2);
    holds(&refused.err, &["has no value in line 9", "say `missing: Omit` in the record"]);
}

/// A number that no sensor reads is no value, for `new` as for a run.
#[test]
fn rows_with_an_infinite_number_are_left_out() {
    let file = table("time_s,x_mm", 800, |k, t| {
        if k == 300 { format!("{t:.3},inf") } else { format!("{t:.3},{:.4}", (9.0 * t).sin()) }
    });
    let (scratch, text, said) = made("infinite", file.as_bytes());
    holds(&said.err, &["1 of 800 rows lack a value (first in line 302)"]);
    checked(&scratch, &text);
}

#[test]
fn dates_in_days_are_no_seconds() {
    for first in [45_382.0, 739_340.0] {
        let file = table("Zeit;Weg [mm]", 600, |k, t| {
            format!("{:.11};{:.4}", first + 0.05 * k as f64 / 86_400.0, (9.0 * t).sin())
        });
        let (_, text, said) = made("days", file.as_bytes());
        holds(
            &said.err,
            &[
                "29.95 s at 20 Hz",
                "note: the heading `Zeit` gives no unit: its values are taken for dates in days",
            ],
        );
        holds(&text, &["time: (\"Zeit\", \"d\")", "EDIT: the unit of time is a guess"]);
    }
    let seconds = table("Zeit;Weg [mm]", 600, |_, t| format!("{:.3};{:.4}", 45_382.0 + t, (9.0 * t).sin()));
    let (_, text, _) = made("seconds", seconds.as_bytes());
    holds(&text, &["time: \"Zeit\""]);
}

#[test]
fn a_column_without_a_heading_is_called_by_its_number() {
    let file = table("time_s,,F_N", 600, |_, t| {
        format!("{t:.3},{:.5},{:.5}", (6.0 * t).sin(), 2.0 * (6.0 * t + 0.5).sin())
    });
    let (scratch, text, said) = made("unnamed", file.as_bytes());
    holds(&said.err, &["motion `2`", "note: column 2 has no heading: its number is its name"]);
    holds(&text, &["\"x\": \"2\""]);
    checked(&scratch, &text);
}

#[test]
fn one_column_is_a_motion_without_times() {
    let file = table("# fs = 100 Hz\nACC_Z [g]", 400, |_, t| format!("{:.4}", (9.0 * t).sin()));
    let (_, text, _) = made("one", file.as_bytes());
    holds(&text, &["time: Rate(100.0)", "(\"ACC_Z [g]\", \"gn\")", "// as the header of the file says"]);
}

#[test]
fn what_is_missing_repeated_or_dead_is_said() {
    let file = table("time_s,x_mm,v2", 800, |k, t| match k {
        100..110 => format!("{t:.3},NaN,0"),
        200 => format!("{:.3},1.0,0", t - 0.01),
        _ => format!("{:.3},{:.5},0", if k > 500 { t + 3.0 } else { t }, (9.0 * t).sin()),
    });
    let (scratch, text, said) = made("missing", file.as_bytes());
    holds(
        &text,
        &[
            "10 missing",
            "values are missing (first in line 102)",
            "a time stands twice (first in line 202)",
            "gaps in time once",
            "constant, not used",
        ],
    );
    holds(&said.err, &["values are missing"]);
    let check = phisindy(&["check", &scratch.path("rig.ron")]);
    assert_eq!(check.code, 0, "{text}");
    holds(&check.err, &["no samples from 5.000000 s to 8.010000 s"]);
    // Runs that no column tells apart are counted.
    let file = table("time_s,x_mm", 400, |k, _| {
        format!("{:.3},{:.4}", 0.01 * (k % 200) as f64, (0.1 * k as f64).sin())
    });
    let (scratch, text, said) = made("untold", file.as_bytes());
    holds(&said.err, &["time goes back at line 202", "no column tells them apart"]);
    holds(&text, &["name: \"run 0\"", "run: 0,", "name: \"run 1\"", "run: 1,", "role: Validate"]);
    checked(&scratch, &text);
}

#[test]
fn lines_before_the_heading_are_skipped() {
    let body = table("Time [s];Position [mm]", 400, |_, t| format!("{t:.2};{:.4}", 10.0 * (9.0 * t).cos()));
    for (name, before, skip) in [
        ("one", "Rig 7\n", "skip: 1"),
        ("many", "Logger; version 2\nSampling rate: 100 Hz\n\nChannel 1;Channel 2\n", "skip: 4"),
    ] {
        let (scratch, text, _) = made(&format!("preamble_{name}"), format!("{before}{body}").as_bytes());
        holds(&text, &[skip, "(\"Position [mm]\", \"mm\")"]);
        checked(&scratch, &text);
        let run = phisindy(&["check", &scratch.path("rig.ron"), "--set", "data.0.run=1"]);
        holds(&run.err, &["has 1 runs, so none has the number 1", "counted from 0"]);
    }
    let (_, text, _) = made("no_preamble", body.as_bytes());
    assert!(!text.contains("skip:"), "{text}");
    // Names over their units; a tonne per millisecond is a unit too.
    let swing = |_, t: f64| format!("{:.1};{:.4}", 1e3 * t, 10.0 * (9.0 * t).cos()).replace('.', ",");
    for before in ["", "Messung 12\nPruefer: Meier\n", "Zeit;Weg\n"] {
        let file = format!("{before}{}", table("t / ms;s / mm", 400, swing));
        let (scratch, text, _) = made("over_a_unit", file.as_bytes());
        holds(&text, &["time: (\"t / ms\", \"ms\")", "(\"s / mm\", \"mm\")"]);
        checked(&scratch, &text);
    }
}

#[test]
fn a_file_without_time_asks_for_its_rate() {
    let file =
        table("x_mm;F [N]", 400, |_, t| format!("{:.4};{:.3}", 10.0 * (9.0 * t).cos(), (2.0 * t).sin()));
    let scratch = Scratch::new("no_time");
    let (data, spec) = (scratch.path("rig.csv"), scratch.path("rig.ron"));
    std::fs::write(&data, file).expect("a file");
    for command in ["new", "go"] {
        let said = phisindy(&[command, &data, "--out", &spec]);
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{}", said.err);
        holds(&said.err, &["no column is time. How many rows are there in a second?", "--rate 1000Hz"]);
        assert!(!std::path::Path::new(&spec).exists(), "nothing is invented");
    }
    assert_eq!(phisindy(&["new", &data, "--out", &spec, "--rate", "0.1kHz"]).code, 0);
    checked(&scratch, &std::fs::read_to_string(&spec).expect("a spec"));
    // Twice the rate is half the time.
    let check = phisindy(&[
        "check",
        &scratch.path("rig.ron"),
        "--set",
        "data.0.time=Rate(200.0)",
        "--set",
        "data.0.window=(2.5, 5.0)",
    ]);
    holds(&check.err, &["runs from 0 s to 1.995 s"]);
}

/// The rate is said: nothing is left to edit there, and the windows are in seconds of it.
#[test]
fn the_rate_of_rows_can_be_said() {
    let scratch = Scratch::new("rate");
    let (data, spec) = (scratch.path("rig.csv"), scratch.path("rig.ron"));
    // Without times; and with stamps that are wrong.
    for (heading, first) in [("ACC_Z [g]", ""), ("time_s,ACC_Z [g]", "0.0,")] {
        let file = table(heading, 400, |_, t| format!("{first}{:.4}", (9.0 * t).sin()));
        std::fs::write(&data, file).expect("a file");
        let said = phisindy(&["new", &data, "--rate", "200", "--out", &spec, "--force"]);
        let text = std::fs::read_to_string(&spec).unwrap_or_else(|e| panic!("{e}: {}", said.err));
        holds(&said.err, &["400 rows, 1.995 s at 200 Hz", "time the rows, 200 in a second"]);
        holds(&text, &["time: Rate(200.0), columns: { \"a\": (\"ACC_Z [g]\", \"gn\") },\n"]);
        assert!(!text.contains("how many rows per second") && !said.err.contains("assumed"), "{text}");
        checked(&scratch, &text);
    }
    for wrong in ["0", "-3", "nan", "fast"] {
        let said = phisindy(&["new", &data, &format!("--rate={wrong}")]);
        assert_eq!(said.code, 2, "{wrong}");
        holds(&said.err, &["a number of rows per second"]);
    }
    // Without it the question is asked where it is seen.
    let said = phisindy(&["new", &data]);
    assert_eq!(said.code, 2, "stamps that do not grow");
    holds(&said.err, &["--rate HZ"]);
}

#[test]
fn inches_and_gravities_are_units() {
    let file = table("time (s),disp (in),acc (g)", 400, |_, t| {
        format!("{t:.2},{:.5},{:.5}", 0.4 * (9.0 * t).cos(), 0.01 * t.sin())
    });
    let (scratch, text, _) = made("imperial", file.as_bytes());
    holds(&text, &["(\"disp (in)\", \"in\")", "an acceleration, not used"]);
    checked(&scratch, &text);
}

#[test]
fn a_cut_signal_and_a_long_record_are_said() {
    let file = table("time_s,x_mm", 500, |_, t| format!("{t:.3},{:.5}", (6.0 * t).sin().clamp(-2.0, 0.7)));
    let (_scratch, text, _) = made("clipped", file.as_bytes());
    holds(&text, &["EDIT: `x_mm` stands at exactly its least or greatest value"]);
    let mut file = "time_s,x_mm\n".to_owned();
    for k in 0..60_000 {
        let t = 1e-4 * f64::from(k);
        let _ = writeln!(file, "{t:.4},{:.4}", (3.0 * t).sin());
    }
    let (scratch, text, _) = made("long", file.as_bytes());
    holds(&text, &["decimate: 2", "low-pass"]);
    checked(&scratch, &text);
}

#[test]
fn bad_files_are_refused_with_the_place_and_what_to_do() {
    let good = table("time_s,x_mm", 9000, |_, t| format!("{t:.3},{:.4}", (5.0 * t).sin()));
    let bad_row: String = good
        .lines()
        .enumerate()
        .map(|(k, l)| if k == 8416 { "84.15,overload\n".to_owned() } else { format!("{l}\n") })
        .collect();
    let cases: &[(&str, Vec<u8>, &[&str])] = &[
        ("empty", vec![], &["is empty", "heading"]),
        ("comments", b"# nothing\n".to_vec(), &["is empty"]),
        ("column", table("t", 50, |_, t| format!("{t}")).into(), &["no column of motion"]),
        ("words", table("a,b", 50, |_, _| "one,two".into()).into(), &["holds no numbers"]),
        ("few", b"t,x\n0,1\n1,2\n".to_vec(), &["2 rows", "at least 20"]),
        (
            "binary",
            [b"t,x\n0,1\n".as_slice(), &[0, 159, 146, 150, 10]].concat(),
            &["neither text nor a format that is known"],
        ),
        ("cut", format!("{good}90.0").into(), &["ends in the middle of line 9002", "cut off"]),
        (
            "text",
            bad_row.into(),
            &["`x_mm` holds the text `overload` in line 8417", "rig.csv:8417", "not a number"],
        ),
        (
            "dates",
            table("time,x_mm", 50, |k, t| format!("June 5 12:00:{k},{}", t.sin())).into(),
            &[
                "`time` holds the text `June 5 12:00:0` in line 2",
                "`time` should be time",
                "number of seconds",
            ],
        ),
        (
            "still",
            table("time_s,x_mm", 50, |_, t| format!("{t},1.5")).into(),
            &["no column of motion", "displacement"],
        ),
        (
            "footer",
            (table("time_s,x_mm", 50, |_, t| format!("{t},{}", t.sin())) + "end of record,1\n").into(),
            &["`time_s` holds the text `end of record` in line 52", "`time_s` should be time"],
        ),
        (
            "backwards",
            table("time_s,x_mm", 50, |_, t| format!("{},{}", 9.0 - t, t.sin())).into(),
            &["`time_s` should be time, and it falls from row to row", "turn the order of the rows round"],
        ),
        (
            "thousands",
            table("t;x", 200, |k, t| {
                if k == 150 { "1,5;1.234,5".into() } else { format!("{t};{k}").replace('.', ",") }
            })
            .into(),
            &["`x` holds the text `1.234,5` in line 152", "write numbers without marks of thousands"],
        ),
        (
            "thousands_from_the_first_row",
            table("t / s;x / um", 200, |k, t| {
                format!("{};{}.234,5", format!("{t}").replace('.', ","), 100 + k)
            })
            .into(),
            &["holds the text `100.234,5` in line 2", "write numbers without marks of thousands"],
        ),
        (
            "thousands_apart",
            table("t / s;x / um", 200, |k, t| format!("{t};{} 234,5", 100 + k).replace('.', ",")).into(),
            &["holds the text `100 234,5` in line 2", "write numbers without marks of thousands"],
        ),
        (
            "thousands_by_an_apostrophe",
            table("t / s;x / um", 200, |k, t| format!("{t};{k}'234.5")).into(),
            &["holds the text `1'234.5` in line 3", "write numbers without marks of thousands"],
        ),
        (
            "thousands_without_decimals",
            table("t_s\tcounts", 200, |k, t| match k {
                ..100 => format!("{t}\t{}", 900 + k),
                k => format!("{t}\t1,{:03}", k - 100),
            })
            .into(),
            &["column `counts`", "`1,000` beside `900`", "without marks of thousands"],
        ),
        (
            "commas",
            table("time_s,x_mm,F_N", 50, |k, t| {
                format!("{t:.4};{:.4};{k}.5", (5.0 * t).sin()).replace('.', ",").replace(';', ",")
            })
            .into(),
            &["line 2 of", "has 6 fields, the heading has 3", "the decimal mark too", "export them with `;`"],
        ),
        (
            "marks",
            table("t;x", 50, |k, t| {
                if k == 9 { "0,09;1.5".into() } else { format!("{t:.2};{k}").replace('.', ",") }
            })
            .into(),
            &["point", "comma"],
        ),
    ];
    for (name, file, parts) in cases {
        let scratch = Scratch::new(&format!("bad-{name}"));
        let (data, spec) = (scratch.path("rig.csv"), scratch.path("rig.ron"));
        std::fs::write(&data, file).expect("a file");
        let said = phisindy(&["new", &data, "--out", &spec]);
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{name}: {}", said.err);
        assert!(!std::path::Path::new(&spec).exists(), "{name}: something is written");
        holds(&said.err, parts);
        holds(&said.err, &["error"]);
    }
    let said = phisindy(&["new", "specs/nothing.csv"]);
    assert_eq!(said.code, 2);
    holds(&said.err, &["cannot read `specs/nothing.csv`"]);
}

#[test]
fn set_changes_a_draft() {
    let scratch = Scratch::new("set");
    let data = scratch.path("rig.csv");
    std::fs::write(&data, table("time_s,x_mm", 300, |_, t| format!("{t:.3},{:.4}", (5.0 * t).sin())))
        .expect("a file");
    let said = phisindy(&["new", &data, "--set", "title=\"Mine\"", "--set", "learn.cutoff=0.07"]);
    assert_eq!(said.code, 0, "{}", said.err);
    holds(&said.out, &["title: \"Mine\"", "cutoff: 0.07"]);
    let wrong = phisindy(&["new", &data, "--set", "data.9.role=Fit"]);
    assert_eq!((wrong.code, wrong.out.as_str()), (2, ""), "{}", wrong.err);
}

/// A spec is UTF-8, names of files need not be.
#[cfg(target_os = "linux")]
#[test]
fn names_of_files_need_not_be_utf8() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let scratch = Scratch::new("names");
    let path = |name: &[u8]| scratch.0.join(OsStr::from_bytes(name));
    let (data, spec, out) = (path(b"r\xffg.csv"), path(b"s\xfe.ron"), path(b"o\xfdt"));
    std::fs::write(
        &data,
        table("time_s,x_mm", 600, |k, t| format!("{t:.3},{:.4}", (5.0 * t).sin() + noise(k, 0.01))),
    )
    .expect("a file");
    let run = |words: &[&OsStr]| {
        let output = crate::common::program(&[]).args(words).output().expect("starts");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let word = OsStr::new;
    let new = run(&[word("new"), data.as_os_str(), word("--out"), spec.as_os_str()]);
    assert_eq!(new.0, Some(0), "{}", new.1);
    assert_eq!(run(&[word("check"), spec.as_os_str()]).0, Some(0));
    let done = run(&[word("run"), spec.as_os_str(), word("--out"), out.as_os_str()]);
    assert!(matches!(done.0, Some(0 | 1)), "{}", done.1);
    let again = run(&[word("check"), out.join("identified.ron").as_os_str()]);
    assert_eq!(again.0, Some(0), "{}", again.1);
    // A page can name it in no request.
    let page = run(&[word("open"), word("--no-open"), word("--limit"), word("1s"), spec.as_os_str()]);
    assert!(page.0 == Some(2) && page.1.contains("not UTF-8"), "{}", page.1);
    // In the working folder too.
    let here = |words: &[&OsStr]| {
        let output =
            crate::common::program(&[]).current_dir(&scratch.0).args(words).output().expect("starts");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let new = here(&[word("new"), OsStr::from_bytes(b"r\xffg.csv"), word("--out"), word("here.ron")]);
    assert_eq!(new.0, Some(0), "{}", new.1);
    let check = here(&[word("check"), word("here.ron")]);
    assert!(check.0 == Some(0) && !check.1.contains("no data file"), "{}", check.1);
    // What a spec cannot name is no mistake of the program.
    std::fs::copy(&data, path(b"quo\"te\\x.csv")).expect("a file");
    let new = here(&[word("new"), word("quo\"te\\x.csv")]);
    assert!(new.0 == Some(2) && new.1.contains("without `\\`"), "{}", new.1);
    std::fs::copy(&data, path(b"quo\"te.csv")).expect("a file");
    assert_eq!(here(&[word("new"), word("quo\"te.csv"), word("--out"), word("quote.ron")]).0, Some(0));
}

#[test]
fn times_that_no_number_can_hold_are_refused() {
    for unit in ["e-300", "e+300"] {
        let rows =
            table("time_s,x_mm", 600, |k, t| format!("{k}{unit},{:.4}", (5.0 * t).sin() + noise(k, 0.01)));
        let scratch = Scratch::new("times");
        std::fs::write(scratch.path("a.csv"), rows).expect("a file");
        let said = phisindy(&["new", &scratch.path("a.csv")]);
        assert_eq!(said.code, 2, "{}", said.err);
        assert!(said.err.contains("such times cannot be used"), "{}", said.err);
    }
}

#[test]
fn nothing_is_overwritten_without_force() {
    let scratch = Scratch::new("overwrite");
    let (data, spec) = (scratch.path("rig.csv"), scratch.path("rig.ron"));
    std::fs::write(&data, table("time_s,x_mm", 300, |_, t| format!("{t:.3},{:.4}", (5.0 * t).sin())))
        .expect("a file");
    std::fs::write(&spec, "hours of work").expect("a file");
    let said = phisindy(&["new", &data, "--out", &spec]);
    assert_eq!((said.code, std::fs::read_to_string(&spec).expect("a file").as_str()), (2, "hours of work"));
    holds(&said.err, &["is there already", "--force"]);
    assert_eq!(phisindy(&["new", &data, "--out", &spec, "--force"]).code, 0);
    let (printed, dashed) = (phisindy(&["new", &data, "--quiet"]), phisindy(&["new", &data, "--out", "-"]));
    assert_eq!((printed.code, printed.err.as_str()), (0, ""));
    assert_eq!(printed.out, dashed.out);
    assert!(printed.out.contains("// Written by `phisindy new rig.csv`"), "{}", printed.out);
    let folder = phisindy(&["new", &data, "--out", scratch.0.to_str().expect("UTF-8")]);
    assert_eq!(folder.code, 2);
    holds(&folder.err, &["is a folder"]);
}

#[test]
fn a_time_without_a_unit_is_no_record_of_one_row_a_second() {
    for (step, unit, rate) in [(4.0, "ms", "250 Hz"), (4000.0, "us", "250 Hz")] {
        let mut file = "time,x_mm\n".to_owned();
        for (k, (_, x)) in ring_down(2500, 0.004).into_iter().enumerate() {
            let _ = writeln!(file, "{},{:.5}", k as f64 * step, 1e3 * x + noise(k, 0.02));
        }
        let (scratch, text, said) = made(&format!("time_{unit}"), file.as_bytes());
        holds(
            &text,
            &[
                &format!("time: (\"time\", \"{unit}\")"),
                "EDIT: the heading `time` gives no unit",
                "EDIT: the unit of time is a guess",
            ],
        );
        holds(&said.err, &[rate, &format!("are taken for {unit}")]);
        checked(&scratch, &text);
    }
}

#[test]
fn a_motion_without_a_unit_is_told() {
    let file = table("time_s,x", 300, |_, t| format!("{t:.3},{:.4}", 10.0 * (5.0 * t).sin()));
    let (scratch, _, said) = made("motion_unit", file.as_bytes());
    holds(
        &said.err,
        &["note: the heading `x` gives no unit: its numbers are taken for m (", "(\"x\", \"mm\")"],
    );
    checked(&scratch, &std::fs::read_to_string(scratch.path("rig.ron")).expect("a spec"));
}

#[test]
fn rates_have_their_unit_behind_an_underscore() {
    let mut file = "t_s,x_mm,v_mm/s\n".to_owned();
    let motion = ring_down(800, 0.005);
    for (k, w) in motion.windows(2).enumerate() {
        let ((t, x), (_, next)) = (w[0], w[1]);
        let _ = writeln!(file, "{t:.4},{:.5},{:.4}", 1e3 * x + noise(k, 0.02), 1e3 * (next - x) / 0.005);
    }
    let (scratch, text, said) = made("rates", file.as_bytes());
    holds(&said.err, &["time `t_s`, motion `x_mm`"]);
    holds(&text, &["a velocity, not used"]);
    checked(&scratch, &text);
}

#[test]
fn what_a_program_computed_is_no_base() {
    let file = |heading: &str| {
        let row = |(k, (t, x)): (usize, (f64, f64))| format!("{t:.4},{:.6},{x:.6}\n", x + noise(k, 0.002));
        format!("{heading}\n{}", ring_down(800, 0.005).into_iter().enumerate().map(row).collect::<String>())
    };
    for heading in ["t,x,x_true", "t,x_m,x_model_m", "time_s,pos filtered [m],pos [m]"] {
        let (scratch, text, _) = made("computed", file(heading).as_bytes());
        holds(&text, &["not used: another form of `", "inputs: {}"]);
        checked(&scratch, &text);
    }
}

#[test]
fn of_columns_with_one_heading_the_first_is_taken() {
    let row = |(k, (t, x)): (usize, (f64, f64))| {
        format!("{t:.4},{:.5},{:.5}\n", 1e3 * x + noise(k, 0.02), noise(k, 5.0))
    };
    let file: String = ring_down(800, 0.005).into_iter().enumerate().map(row).collect();
    let (_, text, said) = made("namesakes", format!("t_s,x_mm,x_mm\n{file}").as_bytes());
    holds(&text, &["not used: another column has its heading", "inputs: {}"]);
    assert_eq!(
        said.err.matches("two columns are called `x_mm`: rename one of them").count(),
        1,
        "{}",
        said.err
    );
}

/// Times of day, with and without a date, over midnight; the fraction counts.
#[test]
fn stamps_of_a_clock_are_seconds_from_the_first_row() {
    let swing = ring_down(1200, 0.01);
    let clock = |t: f64| {
        let millis = (1000.0 * t).round() as u64 + 23 * 3_600_000 + 59 * 60_000 + 55_000;
        let (day, rest) = (17 + millis / 86_400_000, millis % 86_400_000);
        (
            day,
            format!(
                "{:02}:{:02}:{:02}.{:03}",
                rest / 3_600_000,
                rest / 60_000 % 60,
                rest / 1000 % 60,
                rest % 1000
            ),
        )
    };
    let iso = |t: f64| format!("2024-05-{}T{}Z", clock(t).0, clock(t).1);
    let german = |t: f64| format!("{}.05.2024 {}", clock(t).0, clock(t).1);
    let stamps: [&dyn Fn(f64) -> String; 3] = [&iso, &german, &|t| clock(t).1];
    for (k, stamp) in stamps.iter().enumerate() {
        let mut file = "Timestamp,x_mm\n".to_owned();
        for (row, (t, x)) in swing.iter().enumerate() {
            writeln!(file, "{},{:.4}", stamp(*t), 1e3 * x + noise(row, 0.02)).expect("text");
        }
        let (scratch, text, said) = made(&format!("clock{k}"), file.as_bytes());
        holds(&said.err, &["1200 rows, 11.99 s at 100 Hz, uniform", "time `Timestamp`"]);
        holds(&text, &["time: (\"Timestamp\", \"s\")", "window: (0.0, 1.0"]);
        checked(&scratch, &text);
    }
}

#[test]
fn a_column_called_ms_is_the_time() {
    let mut file = "ms,x_mm\n".to_owned();
    for (k, (t, x)) in ring_down(1200, 0.01).into_iter().enumerate() {
        writeln!(file, "{:.0},{:.4}", 1e3 * t, 1e3 * x + noise(k, 0.02)).expect("text");
    }
    let (scratch, text, said) = made("ms", file.as_bytes());
    holds(&said.err, &["11.99 s at 100 Hz", "time `ms`"]);
    holds(&text, &["time: (\"ms\", \"ms\")"]);
    checked(&scratch, &text);
}

/// A logger that writes full seconds: the rows are counted.
#[test]
fn stamps_coarser_than_the_rows_give_a_rate() {
    let swing = ring_down(1200, 0.01);
    let second = |t: f64| (t + 0.375).floor();
    let plain = |t: f64| format!("{}", second(t));
    let clock = |t: f64| format!("10:15:{:02.0}", second(t));
    let stamps: [(&str, &dyn Fn(f64) -> String); 2] = [("time_s", &plain), ("Zeit", &clock)];
    for (k, (heading, stamp)) in stamps.iter().enumerate() {
        let mut file = format!("{heading},x_mm\n");
        for (row, (t, x)) in swing.iter().enumerate() {
            writeln!(file, "{},{:.4}", stamp(*t), 1e3 * x + noise(row, 0.02)).expect("text");
        }
        let (scratch, text, said) = made(&format!("coarse{k}"), file.as_bytes());
        holds(&said.err, &["at 100 Hz", "a new stamp every 1 for 100 rows each"]);
        holds(
            &text,
            &["time: Rate(100.0)", "is this the exact rate?", "counts rows or tells the time, not used"],
        );
        checked(&scratch, &text);
    }
}

/// A counter of 16 bits that overflows: what to do is said, and it is not called a sensor that slipped.
#[test]
fn a_counter_that_wraps_is_told() {
    let mut file = "t_s,encoder\n".to_owned();
    for (t, x) in ring_down(1200, 0.01) {
        let count = (1e6 * x).round() as i64 + 65_000;
        writeln!(file, "{t:.2},{}", count.rem_euclid(65_536)).expect("text");
    }
    let (scratch, text, said) = made("wraps", file.as_bytes());
    holds(&said.err, &["`encoder` wraps", "65536", "numpy.unwrap"]);
    let said = phisindy(&["check", &scratch.path("rig.ron")]);
    assert!(said.err.contains("wraps") && !said.err.contains("slipped"), "{}{text}", said.err);
}

/// Numbers that are missing in every few rows leave no stretch to estimate start values from: what is there
/// must do.
#[test]
fn gaps_every_few_rows_leave_no_nan_in_the_spec() {
    let rows = ring_down(400, 0.02);
    let row = |k: usize, x: f64| {
        if k.is_multiple_of(4) { format!("{},nan\n", rows[k].0) } else { format!("{},{x}\n", rows[k].0) }
    };
    let content: String = rows.iter().enumerate().map(|(k, (_, x))| row(k, *x)).collect();
    let (_, text, said) = made("gaps_in_rows", format!("t_s,x_m\n{content}").as_bytes());
    assert!(!text.contains("NaN") && !said.err.contains("please report"), "{text}");
}

/// Neither displacement nor velocity: the spec reads the rate of a state, and runs. The sensor is in g and
/// stands upright.
#[test]
fn an_accelerometer_alone_is_drafted_and_identified() {
    let scratch = Scratch::new("new-accelerometer");
    let truth = r#"(states: { "x": "m", "v": "m/s" }, inputs: { "f": "N" }, outputs: { "a": (unit: "gn", reads: "rate(v)") },
        constants: { "m": (2.0, "kg"), "k": (700.0, "N/m"), "c": (3.0, "N*s/m") },
        known: { "x": "v", "v": "(f - k*x - c*v)/m" }, inertia: { "v": "m" }, unknown: {},
        data: [ Synthetic(truth: { "v": "-2.5*sgn(v)/m" }, start: {}, duration: 10.0, step: 0.005, noise: Additive(0.01), seed: 12,
            inputs: { "f": Multisine(amplitude: 15.0, band: (0.5, 6.0)) }, sensors: { "a": (offset: 9.80665) }) ])"#;
    let case = scratch.path("truth.ron");
    std::fs::write(&case, truth).expect("a spec");
    let simulated = phisindy(&["simulate", &case]).out;
    // The column of the sensor, in g, and the force.
    let mut text = String::from("time_s,acc_g,force_N\n");
    for line in simulated.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let reading: f64 = cells[1].parse::<f64>().expect("a number") / 9.80665;
        text += &format!("{},{reading:.7},{}\n", cells[0], cells[cells.len() - 1]);
    }
    std::fs::write(scratch.path("run.csv"), text).expect("a file");
    let spec = scratch.path("run.ron");
    let new = phisindy(&["new", &scratch.path("run.csv"), "--out", &spec]);
    assert_eq!(new.code, 0, "{}", new.err);
    let run = phisindy(&["run", &spec]);
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    let value = |name: &str| fitted(&run, name);
    assert!((value("m") / 2.0 - 1.0).abs() < 0.02 && (value("k") / 700.0 - 1.0).abs() < 0.02, "{}", run.out);
    assert!((value("a.offset") - 9.80665).abs() < 0.05, "{}", run.out);
}

/// From a data file to the report; a spec that is there is used as it is.
#[test]
fn go_leads_from_a_data_file_to_a_report() {
    let scratch = Scratch::new("go");
    // A free oscillation with a little damping.
    let rows: String = (0..1500)
        .map(|k| {
            let t = f64::from(k) * 0.01;
            format!("{t},{}\n", (-0.1 * t).exp() * (3.0 * t).cos() + 1e-4 * (f64::from(k) * 12.9898).sin())
        })
        .collect();
    // Its draft is not in the place of a result.
    std::fs::write(scratch.path("completed.csv"), format!("t/s,x/m\n{rows}")).expect("a data file");
    let (data, out) = (scratch.path("completed.csv"), scratch.path("found"));
    let said = phisindy(&["go", &data, "--out", &out, "--limit", "3min"]);
    assert!(said.code < 2, "{}{}", said.out, said.err);
    assert!(said.err.contains("EDIT"), "{}", said.err);
    let report = std::fs::read_to_string(scratch.path("found/report.html")).expect("a report");
    assert!(report.contains("class=\"finding\""));
    // What was found runs where it lies.
    let again = phisindy(&["check", &scratch.path("found/completed.ron")]);
    assert!(again.code == 0 && !again.err.contains("no data file"), "{}", again.err);
    let second = phisindy(&["go", &data, "--out", &out, "--limit", "3min"]);
    assert!(second.err.contains("is used as it is"), "{}", second.err);
    // What is said of the file counts for a draft alone.
    let other = phisindy(&["go", &data, "--out", &out, "--rig", "pendulum"]);
    assert!(other.code == 2 && other.err.contains("would not count"), "{}", other.err);
}

/// Accelerometers on a body and on its base: the states are relative to the base.
#[test]
fn a_base_may_be_known_by_its_acceleration() {
    // 1600/s^2 and 4/s, driven by two tones, in steps of 0.1 ms.
    let shaken = |t: f64| 3.0 * (25.0 * t).sin() + 2.0 * (47.0 * t + 1.0).sin();
    let (mut x, mut v, h) = (0.0, 0.0, 1e-4);
    let rows: String = (0..4000)
        .map(|k| {
            let t = 0.002 * f64::from(k);
            let row = format!(
                "{t:.3},{:.5},{:.5}\n",
                -1600.0 * x - 4.0 * v + noise(k as usize, 0.01),
                shaken(t) + noise(k as usize + 7, 0.001)
            );
            for n in 0..20 {
                v += h * (-1600.0 * x - 4.0 * v - shaken(t + h * f64::from(n)));
                x += h * v;
            }
            row
        })
        .collect();
    let scratch = Scratch::new("two-accelerometers");
    let (data, spec) = (scratch.path("rig.csv"), scratch.path("rig.ron"));
    std::fs::write(&data, format!("time_s,acc_mass_m/s^2,acc_base_m/s^2\n{rows}")).expect("a file");
    let asked = phisindy(&["new", &data, "--out", &spec, "--force"]);
    holds(&asked.err, &["Say `--rig base-excited` if it is"]);
    let said = phisindy(&["new", &data, "--rig", "base-excited", "--out", &spec, "--force"]);
    holds(&said.err, &["motion `acc_mass_m/s^2`, base `acc_base_m/s^2`: base-excited"]);
    let run = phisindy(&["run", &spec]);
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    assert!((fitted(&run, "k") / 1600.0 - 1.0).abs() < 0.01, "{}", run.out);
}

/// A slider on a spring as in other tests, with a force that moves it: times, places, forces.
fn driven(samples: usize) -> Vec<(f64, f64, f64)> {
    let force = |t: f64| 5.0 * (7.0 * t).sin() + 4.0 * (15.0 * t + 1.0).sin();
    let motion = |t: f64| 8e-3 * (7.0 * t - 0.2).sin() + 12e-3 * (15.0 * t + 0.1).sin();
    (0..samples).map(|k| 0.004 * k as f64).map(|t| (t, motion(t), force(t))).collect()
}

/// A file with this beginning, and a row for each sample of [`driven`].
fn rig(head: &str, row: impl Fn(usize, f64, f64, f64) -> String) -> String {
    let rows = driven(900).into_iter().enumerate();
    let rows = rows.map(|(k, (t, x, f))| row(k, t, 1e3 * x + noise(k, 0.01), f) + "\n");
    head.to_owned() + &rows.collect::<String>()
}

#[test]
fn a_heading_behind_a_comment_sign_is_read() {
    let plain = |_: usize, t: f64, x: f64, f: f64| format!("{t:.4},{x:.5},{f:.4}");
    let blanks = |_: usize, t: f64, x: f64, f: f64| format!("{t:.4} {x:.5} {f:.4}");
    let german = |_: usize, t: f64, x: f64, f: f64| format!("{t:.4};{x:.5};{f:.4}").replace('.', ",");
    let files = [
        (rig("# time_s,x_mm,F_N\n", plain), ["time_s", "x_mm", "F_N"]),
        (rig("# slider, run 3\n# t,x,F\n# s,mm,N\n", plain), ["t", "x", "F"]),
        (rig("t,x,F\n# s,mm,N\n", plain), ["t", "x", "F"]),
        (rig("# time_s x_mm F_N\n", blanks), ["time_s", "x_mm", "F_N"]),
        (rig("# t [s], x [mm], F [N]\n", blanks), ["t [s]", "x [mm]", "F [N]"]),
        (rig("## time_s\tx_mm\tF_N\n", blanks), ["time_s", "x_mm", "F_N"]),
        (rig("t_s, x_mm, F_N\n", blanks), ["t_s", "x_mm", "F_N"]),
        (rig("! time_s  x_mm  F_N\n", blanks), ["time_s", "x_mm", "F_N"]),
        (rig("#Fields: time_s x_mm F_N\n", blanks), ["time_s", "x_mm", "F_N"]),
        (
            rig("// Schlitten, Lauf 3\n// Zeit [s];Weg [mm];Kraft [N]\n", german),
            ["Zeit [s]", "Weg [mm]", "Kraft [N]"],
        ),
        (rig("; t_s, x_mm, F_N\n", plain), ["t_s", "x_mm", "F_N"]),
        (rig("% Zeit;Weg;Kraft\n% sec;mm;N\n", german), ["Zeit", "Weg", "Kraft"]),
    ];
    for (k, (file, [time, x, force])) in files.iter().enumerate() {
        let (scratch, text, said) = made(&format!("commented{k}"), file.as_bytes());
        holds(&said.err, &[&format!("taken for time `{time}`, motion `{x}`, force `{force}`")]);
        holds(
            &text,
            &[
                &format!(
                    "time: (\"{time}\", \"s\"), columns: {{ \"x\": (\"{x}\", \"mm\"), \
                     \"F\": (\"{force}\", \"N\") }}"
                ),
                "\"m\": (value:",
            ],
        );
        assert!(!text.contains("header: false"), "{text}");
        checked(&scratch, &text);
    }
    // A sentence is no heading; columns keep their numbers.
    let (scratch, text, said) =
        made("sentence", rig("# of Monday, slider 7\n# rig seven again\n", blanks).as_bytes());
    holds(&text, &["time: \"1\"", "header: false"]);
    holds(&said.err, &["question: no heading says what `2`, `3` are"]);
    checked(&scratch, &text);
    // A spec that calls the columns by their numbers reads them as before.
    std::fs::write(scratch.path("rig.csv"), &files[0].0).expect("a file");
    let numbered =
        text.replace("header: false,", "").replace("separator: ' ', ", "").replace("separator: ' '", "");
    std::fs::write(scratch.path("rig.ron"), numbered.replace("\n            \n", "\n")).expect("a spec");
    let said = phisindy(&["check", &scratch.path("rig.ron")]);
    assert_eq!(said.code, 0, "{}{numbered}", said.err);
}

#[test]
fn the_rate_stands_in_the_header() {
    let two = |_: usize, _: f64, x: f64, f: f64| format!("{x:.5};{f:.4}");
    let comma = |k: usize, t: f64, x: f64, f: f64| two(k, t, x, f).replace('.', ",");
    for (k, file) in [
        rig("# fs = 250 Hz\nx_mm;F_N\n", two),
        rig("# Sampling rate: 0.25 kHz\n# x_mm;F_N\n", two),
        rig("% dt = 0.004 s\nx_mm;F_N\n", two),
        rig("Abtastrate;250,0;Hz\nKanal;1;2\nx;F\nmm;N\n", comma),
        rig("Prüfstand 7\nAbtastintervall: 4 ms\nx_mm;F_N\n", comma),
        rig("x_mm;F_N;Ts\n", |k, t, x, f| {
            format!("{};{}", two(k, t, x, f), if k == 0 { "0.004" } else { "" })
        }),
    ]
    .iter()
    .enumerate()
    {
        let (scratch, text, said) = made(&format!("rated{k}"), file.as_bytes());
        holds(
            &said.err,
            &["900 rows, 3.596 s at 250 Hz", "note: no column is time: 250 rows per second, as line"],
        );
        holds(&text, &["time: Rate(250.0)", "// as the header of the file says"]);
        assert!(!text.contains("QUESTION"), "{text}");
        checked(&scratch, &text);
    }
    let scratch = Scratch::new("rates-differ");
    let data = scratch.path("rig.csv");
    std::fs::write(&data, rig("# fs = 500 Hz\n# dt = 4 ms\nx_mm;F_N\n", two)).expect("a file");
    let said = phisindy(&["new", &data]);
    assert_eq!(said.code, 2);
    holds(
        &said.err,
        &["contradicts itself on the rate", "line 1 says `# fs = 500 Hz`", "line 2 says `# dt = 4 ms`"],
    );
    // An index is no time.
    std::fs::write(&data, rig("index;x_mm;F_N\n", |k, t, x, f| format!("{k};{}", two(k, t, x, f))))
        .expect("a file");
    let said = phisindy(&["new", &data]);
    assert_eq!(said.code, 2);
    holds(&said.err, &["`index` counts the rows. How many are there in a second?"]);
    // The header tells the unit of times.
    let timed =
        rig("# fs = 250 Hz\ntime;x_mm;F_N\n", |k, t, x, f| format!("{:.0};{}", 1e6 * t, two(k, t, x, f)));
    let (_, text, _) = made("rated-time", timed.as_bytes());
    holds(&text, &["time: (\"time\", \"us\")"]);
    assert!(!text.contains("the unit of time is a guess"), "{text}");
    let timed = rig("# fs = 2 kHz\ntime_s;x_mm;F_N\n", |k, t, x, f| format!("{t:.4};{}", two(k, t, x, f)));
    let (_, text, _) = made("rated-otherwise", timed.as_bytes());
    holds(&text, &["EDIT: the times make 250.0000 rows per second, and line 1 says 2000: `# fs = 2 kHz`"]);
}

#[test]
fn the_unit_of_times_is_seen_by_name_and_by_size() {
    let row = |time: String, x: f64, f: f64| format!("{time},{x:.5},{f:.4}");
    for (heading, time, unit) in [
        ("timestamp_us", (8e9, 1e6), "us"),
        ("micros", (5e6, 1e6), "us"),
        ("t (\u{3bc}sec)", (0.0, 1e6), "us"),
        ("timestamp", (1.7e12, 1e3), "ms"),
        ("timestamp", (1.7e15, 1e6), "us"),
        ("stamp", (1.7e18, 1e9), "ns"),
        ("time", (0.0, 1e9), "ns"),
        ("seconds_elapsed", (3.0, 1.0), "s"),
    ] {
        let file = rig(&format!("{heading},x_mm,F_N\n"), |k, _, x, f| {
            let digits = if time.1 == 1.0 { 4 } else { 0 };
            row(format!("{:.digits$}", time.0 + 0.004 * k as f64 * time.1), x, f)
        });
        let (scratch, text, said) = made(&format!("stamped-{unit}-{}", heading.len()), file.as_bytes());
        holds(&said.err, &["3.596 s at 250 Hz"]);
        holds(&text, &[&format!("time: (\"{heading}\", \"{unit}\")")]);
        checked(&scratch, &text);
    }
    // Steps of more than an hour are no record of a motion, whatever the heading says: it is asked.
    let file = rig("time_s,x_mm,F_N\n", |_, t, x, f| row(format!("{:.0}", 1e6 * t), x, f));
    let (scratch, text, said) = made("years", file.as_bytes());
    holds(
        &said.err,
        &["question: the heading `time_s` says s, and steps of 4000 s make no record", "is it us?"],
    );
    assert!(text.starts_with("// QUESTION: the heading `time_s`"), "{text}");
    let data = scratch.path("rig.csv");
    let go = phisindy(&["go", &data, "--out", &scratch.path("found")]);
    assert_eq!(go.code, 2, "{}", go.err);
    holds(&go.err, &["is it us?", "--time-unit us"]);
    assert!(!std::path::Path::new(&scratch.path("found")).exists(), "nothing is searched");
    let told = phisindy(&["new", &data, "--time-unit", "us"]);
    assert!(
        told.out.contains("time: (\"time_s\", \"us\")") && !told.out.contains("QUESTION"),
        "{}",
        told.out
    );
}

#[test]
fn counts_are_asked_for_and_never_a_length() {
    let file =
        |head: &str| rig(head, |_, t, x, f| format!("{:.0},{:.0},{f:.3}", 1e6 * t, 32_000.0 + 4e3 * x));
    for (k, head) in [
        "timestamp_us,enc_cnt,i_A\n",
        "t_us,motor_ticks,voltage\n",
        "Zeit,Geber,Strom\n[us],[Inkr],[A]\n",
        "micros,encoder,pwm\n",
        "micros,pos,u\n",
    ]
    .iter()
    .enumerate()
    {
        let (scratch, text, said) = made(&format!("counts{k}"), file(head).as_bytes());
        holds(
            &said.err,
            &["question: `", "how many counts are a turn or a millimetre?", "--counts 4096/rev", ", drive `"],
        );
        holds(&text, &["\"x\": \"count\", \"v\": \"count/s\"", "\"us\")"]);
        assert!(text.starts_with("// QUESTION: "), "{text}");
        checked(&scratch, &text);
        let data = scratch.path("rig.csv");
        let go = phisindy(&["go", &data, "--out", &scratch.path("found")]);
        assert_eq!(go.code, 2, "{}", go.err);
        holds(&go.err, &["how many counts"]);
        let spec = scratch.path("rig.ron");
        for (counts, parts) in [
            ("4096/rev", ["\"rev/4096\")", "\"theta\": \"rad\""]),
            ("200/mm", ["\"mm/200\")", "\"x\": \"m\""]),
        ] {
            let told = phisindy(&["new", &data, "--counts", counts, "--out", &spec, "--force"]);
            assert_eq!(told.code, 0, "{}", told.err);
            let text = std::fs::read_to_string(&spec).expect("a spec");
            holds(&text, &parts);
            assert!(!text.contains("QUESTION") && !told.err.contains("question"), "{text}");
            checked(&scratch, &text);
        }
        for wrong in ["4096", "0/rev", "4096/kg", "x/rev"] {
            let said = phisindy(&["new", &data, "--counts", wrong]);
            assert_eq!(said.code, 2, "{wrong}");
            holds(&said.err, &["how many counts are a turn or a length"]);
        }
        // A count is no radian.
        std::fs::write(
            &spec,
            text.replace("count/s", "rad/s")
                .replace("\"v\": \"count", "\"v\": \"rad")
                .replace("\"x\": \"count\"", "\"x\": \"rad\"")
                .replace("\"count\")", "\"rad\")"),
        )
        .expect("a spec");
        let check = phisindy(&["check", &spec]);
        assert!(k > 2 || check.err.contains("says counts"), "{}", check.err);
    }
}

/// Whatever is in counts, the draft is a spec.
#[test]
fn counts_of_all_kinds_are_drafted() {
    for (k, (head, unit, counts)) in [
        ("t_s,vel [counts/s],i_A", "count/s", "4096/rev"),
        ("t_s,acc [LSB],F_N", "count", "16384/gn"),
        ("t_s,enc_cnt,F_N", "count", "4096/rev"),
        ("t_s,base_cnt,enc_cnt", "count", "200/mm"),
        ("t_s,enc_cnt,load_cnt", "count", "200/mm"),
    ]
    .into_iter()
    .enumerate()
    {
        let file = rig(&format!("{head}\n"), |_, t, x, f| format!("{t:.4},{:.0},{:.0}", 4e3 * x, 1e3 * f));
        let (scratch, text, said) = made(&format!("counted{k}"), file.as_bytes());
        holds(&said.err, &["question: `", "counts: how many counts are"]);
        holds(&text, &[&format!("\"{unit}\")")]);
        checked(&scratch, &text);
        let (data, spec) = (scratch.path("rig.csv"), scratch.path("rig.ron"));
        let told = phisindy(&["new", &data, "--counts", counts, "--out", &spec, "--force"]);
        assert_eq!(told.code, 0, "{}", told.err);
        let text = std::fs::read_to_string(&spec).expect("a spec");
        assert!(!text.contains("QUESTION"), "{text}");
        checked(&scratch, &text);
    }
}

#[test]
fn a_torque_called_t_is_no_time() {
    for (head, said) in [
        ("t_s,phi_rad,T_Nm", "force `T_Nm`"),
        ("t_s,x_m,T_Nm", "drive `T_Nm`"),
        ("t,theta,T", "drive `T`"),
        ("Zeit_s,Winkel_rad,M_Nm", "force `M_Nm`"),
        ("t_s,q_rad,tau_in", "drive `tau_in`"),
        ("t_s,q_rad,voltage", "drive `voltage`"),
        ("T,theta,F", "time `T`"),
    ] {
        let file = rig(&format!("{head}\n"), |_, t, x, f| format!("{t:.4},{:.6},{f:.4}", 0.05 * x));
        let (scratch, text, told) = made(&format!("torque-{}", head.replace(',', "-")), file.as_bytes());
        holds(&told.err, &[said]);
        assert!(!text.contains("counts rows"), "{text}");
        checked(&scratch, &text);
    }
}

#[test]
fn columns_that_nothing_names_are_asked_for() {
    for (k, head) in ["", "TIME,CH1,CH2\n"].iter().enumerate() {
        let file = rig(head, |_, t, x, f| format!("{t:.4},{x:.5},{f:.4}"));
        let (scratch, text, said) = made(&format!("untold{k}"), file.as_bytes());
        holds(&said.err, &["question: no heading says what", "which one moves, and what drives it?"]);
        checked(&scratch, &text);
        let data = scratch.path("rig.csv");
        assert_eq!(phisindy(&["go", &data, "--out", &scratch.path("found")]).code, 2);
        let told = phisindy(&["new", &data, "--columns", "time_s,x_mm,F_N"]);
        assert_eq!(told.code, 0, "{}", told.err);
        holds(&told.out, &["\"mm\"), \"F\": (", "inertia: { \"v\": \"m\" }"]);
        assert!(!told.out.contains("QUESTION"), "{}", told.out);
        let free = phisindy(&["new", &data, "--columns", "time_s,x_mm,-"]);
        assert!(free.out.contains("inputs: {}") && !free.out.contains("QUESTION"), "{}", free.out);
        let wrong = phisindy(&["new", &data, "--columns", "time_s,x_mm"]);
        assert_eq!(wrong.code, 2);
        holds(&wrong.err, &["2 names are said for 3 columns"]);
    }
}

#[test]
fn a_draft_replaces_no_data_and_takes_no_set_that_a_run_refuses() {
    let scratch = Scratch::new("itself");
    let data = scratch.path("rig.csv");
    std::fs::copy(crate::common::top().join("docs/tutorial/rig.csv"), &data).expect("copied");
    let before = std::fs::read(&data).expect("the data");
    let said = phisindy(&["new", &data, "--out", &data, "--force"]);
    assert!(said.code == 2 && said.err.contains("is the data file itself"), "{}", said.err);
    assert!(std::fs::read(&data).expect("the data") == before);
    let spec = scratch.path("rig.ron");
    for set in ["foo=1", "learn.cutof=0.1"] {
        let said = phisindy(&["new", &data, "--out", &spec, "--set", set]);
        assert!(said.code == 2 && said.err.contains("after --set"), "{set}: {}", said.err);
        assert!(!std::fs::exists(&spec).expect("a folder"));
    }
}

/// A record that counts twice would seem to be known better than it is.
#[test]
fn a_file_is_named_once() {
    let scratch = Scratch::new("new_twice");
    let data = scratch.path("rig.csv");
    let rows: String = ring_down(400, 0.01).iter().map(|(t, x)| format!("{t},{x}\n")).collect();
    std::fs::write(&data, format!("t_s,x_m\n{rows}")).expect("a file");
    let other = data.replace("rig.csv", "./rig.csv");
    for command in ["new", "go"] {
        let said = phisindy(&[command, &data, &other]);
        assert!(
            said.code == 2 && said.err.contains("is named twice"),
            "{command}: {} {}",
            said.code,
            said.err
        );
    }
}

/// Files of two masses on a spring: what their names say is a load, if the motions differ as they do.
#[test]
fn a_mass_in_the_names_of_files_is_a_load() {
    let file = |mass: f64| {
        let (mut x, mut v, h) = (0.0_f64, 0.0_f64, 1e-4);
        let mut text = "t_s,x_mm,F_N\n".to_owned();
        for k in 0..3000 {
            let force = |t: f64| 12.0 * (7.0 * t).sin() + 8.0 * (17.0 * t + 1.0).sin();
            if k % 2 == 0 {
                let t = 2e-3 * f64::from(k);
                let _ = writeln!(text, "{t},{},{}", 1e3 * x + noise(k as usize, 0.01), force(t));
            }
            for part in 0..20 {
                let t = 2e-3 * f64::from(k) + h * f64::from(part);
                v += h * (force(t) - 300.0 * x - 2.0 * v) / mass;
                x += h * v;
            }
        }
        text
    };
    let scratch = Scratch::new("new_loads");
    let drafted = |one: (&str, f64), other: (&str, f64)| {
        let paths = [one, other].map(|(name, mass)| {
            let path = scratch.path(name);
            std::fs::write(&path, file(mass)).expect("a file");
            path
        });
        let said = phisindy(&["new", &paths[0], &paths[1], "--out", &scratch.path("loads.ron"), "--force"]);
        assert_eq!(said.code, 0, "{}", said.err);
        std::fs::read_to_string(scratch.path("loads.ron")).expect("a spec")
    };
    let text = drafted(("rig_500g.csv", 1.5), ("rig_1500g.csv", 2.5));
    holds(
        &text,
        &[
            "\"m\": \"m0 + load\"",
            "constants: { \"load\": (0.5, \"kg\") }",
            "constants: { \"load\": (1.5, \"kg\") }",
        ],
    );
    let said = phisindy(&["run", &scratch.path("loads.ron"), "--quiet"]);
    assert!(said.code == 0 && said.out.contains("identified"), "{}{}", said.out, said.err);
    // A mass that presses and does not move with the body, and names that say nothing.
    for text in
        [drafted(("rig_500g.csv", 1.5), ("rig_1500g.csv", 1.5)), drafted(("a1.csv", 1.5), ("a2.csv", 2.5))]
    {
        assert!(!text.contains("m0 + load") && text.contains("If it is a load"), "{text}");
    }
}
