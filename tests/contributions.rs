//! What an engineer asks of a result: shares and energies of terms, what was held, bounds of coefficients.

#![allow(missing_docs)]

use crate::common::{Scratch, phisindy};
use serde_json::Value;
use std::f64::consts::{PI, SQRT_2};

/// An oscillator of 2 kg, driven at 1.5 rad/s; in its steady state unless `start` says otherwise.
fn oscillator(unknown: &str, truth: &str, start: (f64, f64), more: &str) -> String {
    let ((x, y), duration) = (start, 10.0 * 2.0 * PI / 1.5);
    format!(
        "(constants: {{ \"m\": (2.0, \"kg\"), \"k\": (8.0, \"N/m\"), \"F\": (1000.0, \"mN\"), \"W\": (1.5, \"rad/s\"), \"w0\": \"sqrt(k/m)\" }},\n\
         states: {{ \"x\": \"m\", \"y\": \"m/s\" }}, known: {{ \"x\": \"y\", \"y\": \"-w0^2*x + F*cos(W*t)/m\" }}, inertia: {{ \"y\": \"m\" }},\n\
         unknown: {{ \"y\": ({unknown}) }}, contacts: [\"y\"],\n\
         data: [Synthetic(truth: {{ \"y\": \"{truth}\" }}, start: {{ \"x\": {x:?}, \"y\": {y:?} }}, duration: {duration:?}, step: 0.02,\n\
         noise: Additive(0.001), seed: 1)]{more})"
    )
}

#[track_caller]
fn run(name: &str, spec: &str, options: &[&str]) -> (Value, String) {
    let scratch = Scratch::new(name);
    let path = scratch.path("case.ron");
    std::fs::write(&path, spec).expect("a file");
    let json = phisindy(&[&["run", &path, "--format", "json"], options].concat());
    let text = phisindy(&[&["run", &path, "--format", "text", "--quiet"], options].concat());
    (serde_json::from_str(&json.out).unwrap_or_else(|e| panic!("{e}: {}", json.err)), text.out)
}

#[track_caller]
fn near(value: &Value, expected: f64, part: f64) {
    let x = value.as_f64().unwrap_or_else(|| panic!("{value} is no number"));
    assert!((x / expected - 1.0).abs() < part, "{x}, not {expected}");
}

#[test]
fn a_damper_takes_out_pi_c_omega_x_squared_per_cycle() {
    let (c, stiffness) = (0.5, 8.0 - 2.0 * 1.5 * 1.5);
    let (amplitude, phase) = (1.0 / f64::hypot(stiffness, c * 1.5), f64::atan2(c * 1.5, stiffness));
    let start = (amplitude * phase.cos(), 1.5 * amplitude * phase.sin());
    // Whichever way the candidate is written, what takes energy out is positive.
    for (factor, name) in [("-1/m", "damper"), ("1/m", "damper_turned")] {
        let unknown = format!("factor: \"{factor}\", candidates: [\"y\"]");
        let (result, text) = run(name, &oscillator(&unknown, "-0.5*y/m", start, ""), &[]);
        let term = &result["equations"][0]["terms"][0]["contribution"];
        let per_cycle = PI * c * 1.5 * amplitude * amplitude;
        // The coefficient is known to a thousandth, the frequency of the motion to a bin's small part.
        near(&term["energy_per_cycle"]["value"], per_cycle, 0.01);
        near(&term["power"]["value"], per_cycle * 1.5 / (2.0 * PI), 0.01);
        near(&term["rms"]["value"], c * amplitude * 1.5 / SQRT_2, 0.01);
        near(&term["share"], 1.0, 1e-9);
        assert_eq!((&term["power"]["unit"], &term["energy_per_cycle"]["unit"]), (&"W".into(), &"J".into()));
        assert_eq!(term["rms"]["unit"], "N");
        assert!(text.contains("dissipates") && text.contains("100.0 %"), "{text}");
    }
}

#[test]
fn what_was_held_is_listed_with_its_value() {
    let unknown = "factor: \"-1/m\", candidates: [\"y\"]";
    let (result, text) = run("held", &oscillator(unknown, "-0.5*y/m", (0.2, 0.0), ""), &[]);
    let line = text.lines().find(|l| l.starts_with("held: ")).unwrap_or_else(|| panic!("{text}"));
    assert_eq!(line, "held: m = 2 kg, k = 8 N/m, F = 1000 mN, W = 1.5 rad/s, w0 = 2");
    assert_eq!((&result["held"][2]["name"], &result["held"][2]["unit"]), (&"F".into(), &"mN".into()));
    near(&result["held"][2]["value"], 1000.0, 1e-12);
}

/// An input that is derived from another one has no sensor of its own.
#[test]
fn the_sensor_of_a_derived_input_is_told_once() {
    let spec = "(constants: { \"k\": (40.0, \"1/s^2\") }, states: { \"x\": \"m\", \"v\": \"m/s\" }, inputs: { \"u\": \"m\", \"du\": \"m/s\" },
        known: { \"x\": \"v\", \"v\": \"-k*(x-u) - 0.3*(v-du)\" }, unknown: { \"v\": (factor: \"-1\", candidates: [\"sgn(v)\"]) }, contacts: [\"v\"],
        data: [Synthetic(truth: { \"v\": \"-0.2*sgn(v)\" }, inputs: { \"u\": Formula(\"0.02*sin(5*t) + 0.01*sin(8.3*t)\") }, derive: { \"du\": Derivative(\"u\") },
        sensors: { \"u\": (gain: Find(start: 1.0, within: (0.5, 2.0)), delay: Find(start: 0.0, unit: \"s\", within: (-0.05, 0.05))) },
        start: { \"x\": 0.0, \"v\": 0.0 }, duration: 6.0, step: 0.01, measure: [\"x\", \"u\"], noise: Additive(0.0001), seed: 1)])";
    let (result, text) = run("derived", spec, &[]);
    assert!(text.contains("u.gain") && !text.contains("du."), "{text}");
    assert_eq!(result["held"].as_array().map(Vec::len), Some(1), "{}", result["held"]);
}

#[test]
fn coefficients_stay_within_their_bounds_and_say_so() {
    let ways: [&[&str]; 3] = [
        &["--method", "trajectory", "--set", "learn.selection=All"],
        &["--method", "step", "--set", "learn.optimiser=GaussNewton", "--set", "learn.cutoff=0"],
        &[
            "--method",
            "step",
            "--set",
            "learn.optimiser=RAdam",
            "--set",
            "learn.epochs=[300]",
            "--set",
            "learn.rates=[0.1]",
            "--set",
            "learn.cutoff=0",
        ],
    ];
    // Friction is 0.2 N against the motion: with the wrong sign only zero is left, with too small a bound
    // that bound.
    let cases =
        [("sgn(y)/m", "Positive", 0.0), ("-sgn(y)/m", "(0.05, 0.1)", 0.1), ("-sgn(y)/m", "Positive", 0.2)];
    for (k, way) in ways.iter().enumerate() {
        for (j, (factor, within, expected)) in cases.into_iter().enumerate() {
            let unknown =
                format!("factor: \"{factor}\", candidates: [\"1\", \"x^2\"], within: {{ \"1\": {within} }}");
            let spec = oscillator(&unknown, "-0.2*sgn(y)/m", (0.5, 0.0), "");
            let (result, _) = run(&format!("bounds_{k}_{j}"), &spec, way);
            let term = &result["equations"][0]["terms"][0];
            let (value, free) = (term["coefficient"].as_f64().expect("a number"), expected == 0.2);
            assert!((value - expected).abs() < if free { 0.02 } else { 1e-12 }, "{way:?} {within}: {value}");
            assert_eq!(term["at_bound"], !free, "{way:?} {within}");
            let said = result["warnings"].to_string().contains("1 of y' ended at its bound");
            assert_eq!(said, !free, "{}", result["warnings"]);
            assert!(term["ci95"][0].as_f64() >= Some(0.0), "{term}");
        }
    }
}

#[test]
fn a_term_that_may_only_be_zero_is_not_selected() {
    let unknown = "factor: \"sgn(y)/m\", candidates: [\"1\", \"-x^2\"], within: { \"1\": Positive }";
    let spec = oscillator(unknown, "-(0.2 + 0.5*x^2)*sgn(y)/m", (0.5, 0.0), "");
    let (result, _) = run("no_choice", &spec, &[]);
    let terms = result["equations"][0]["terms"].as_array().expect("terms");
    assert!(terms.iter().all(|t| t["candidate"] == "-x^2"), "{terms:?}");
}

#[test]
fn the_verdict_says_which_runs_it_rests_on() {
    let unknown = "factor: \"-1/m\", candidates: [\"y\"]";
    let spec = oscillator(unknown, "-0.5*y/m", (0.2, 0.0), "");
    let (result, text) = run("basis_fit", &spec, &[]);
    assert!(text.contains("rests on the fitted records alone") && text.contains("role Validate"), "{text}");
    assert_eq!(result["verdict"], "identified");
    // Another record, which the model does not predict: never fitted, and yet it decides.
    let (head, record) = spec.split_once("data: [").expect("data");
    let other = record
        .trim_end_matches("])")
        .replace("-0.5*y/m", "-9.0*y/m")
        .replace("seed: 1", "seed: 2, role: Validate, name: \"other\"");
    let (result, text) =
        run("basis_validate", &format!("{head}data: [{}, {other}])", record.trim_end_matches("])")), &[]);
    assert_eq!(result["verdict"], "rejected", "{text}");
    assert!(result["reason"].as_str().is_some_and(|why| why.contains("other")), "{}", result["reason"]);
    assert!(result["basis"].as_str().is_some_and(|b| b.contains("a record that was not fitted: NRMSE up to") && b.contains("(other)")));
    assert!(
        result["equations"][0]["terms"][0]["coefficient"].as_f64().is_some_and(|c| (c - 0.5).abs() < 0.01),
        "{text}"
    );
}

/// A body of 2 kg on a spring, which a slow drive carries through stick and slip; friction is Stribeck's: Fs
/// 1.5 N, Fc 1 N, vs 0.1 m/s.
fn stribeck(unknown: &str, more: &str) -> String {
    format!(
        "(constants: {{ \"m\": (2.0, \"kg\"), \"k\": (8.0, \"N/m\"), \"F\": (4.0, \"N\"), \"W\": (0.8, \"rad/s\") }},\n\
         states: {{ \"x\": \"m\", \"y\": \"m/s\" }}, known: {{ \"x\": \"y\", \"y\": \"(-k*x + F*cos(W*t))/m\" }}, inertia: {{ \"y\": \"m\" }},\n\
         unknown: {{ \"y\": ({unknown}) }},\n\
         data: [Synthetic(truth: {{ \"y\": \"-(1.0 + 0.5*exp(-(y/0.1)^2))*sgn(y)/m - 0.3*y/m\" }}, start: {{ \"x\": 0.5, \"y\": 0.0 }}, duration: 40.0, step: 0.02,\n\
         noise: Additive(0.01), seed: 3)]{more})"
    )
}

#[test]
fn a_law_of_the_catalogue_is_fitted_within_its_intervals() {
    // The damping beside it is a law too, or a candidate, which stands behind the factor.
    let ways =
        ["laws: [\"stribeck\", \"viscous\"]", "factor: \"-1/m\", candidates: [\"y\"], laws: [\"stribeck\"]"];
    for (k, unknown) in ways.iter().enumerate() {
        let (result, text) = run(&format!("stribeck_{k}"), &stribeck(unknown, ""), &[]);
        assert_eq!(result["verdict"], "identified", "{text}");
        for (name, truth, unit) in [("Fc", 1.0, "N"), ("Fs", 1.5, "N"), ("vs", 0.1, "m/s")] {
            let all = result["parameters"].as_array().expect("parameters");
            let p = all.iter().find(|p| p["name"] == name).unwrap_or_else(|| panic!("no {name}: {text}"));
            let (low, high) =
                (p["ci95"][0].as_f64().expect("a number"), p["ci95"][1].as_f64().expect("a number"));
            assert!(low < truth && truth < high && high - low < 0.2 * truth, "{name}: [{low}, {high}]");
            assert_eq!((&p["unit"], &p["at_bound"]), (&unit.into(), &false.into()));
        }
        let latex = result["equations"][0]["latex"].as_str().expect("latex");
        assert!(latex.contains("\\exp") && latex.contains("\\operatorname{sgn}(y)"), "{latex}");
        let damping = match k {
            0 => &result["parameters"]
                .as_array()
                .expect("parameters")
                .iter()
                .find(|p| p["name"] == "dc")
                .expect("dc")["value"],
            _ => &result["equations"][0]["terms"][0]["coefficient"],
        };
        near(damping, 0.3, 0.1);
    }
}

/// Friction that grows with the speed fits the form of Stribeck's, with a static level below the kinetic one:
/// that is no Stribeck friction, in `run` as in `gap`.
#[test]
fn a_law_that_run_fits_fulfils_what_its_file_asks_for() {
    let spec = |truth: &str| {
        oscillator("laws: [\"stribeck\"]", truth, (0.2, 0.0), "").replace("duration: 41.88", "duration: 20.0")
    };
    let (result, text) = run("smooth", &spec("-0.6*tanh(y/0.05)/m"), &[]);
    assert_eq!(result["verdict"], "rejected", "{text}");
    assert!(
        result["reason"].as_str().is_some_and(|why| why.contains("its friction would grow with the speed"))
    );
    assert!(text.contains("try `coulomb`"), "{text}");
    let (result, text) = run("falling", &spec("-(0.3 + 0.3*exp(-(y/0.1)^2))*sgn(y)/m"), &[]);
    assert_eq!(result["verdict"], "identified", "{text}");
}

/// A driven mass on a spring for which a law is asked for.
fn asked_for(law: &str, truth: &str) -> String {
    format!(
        "(constants: {{ \"d\": (0.2, \"1/s\"), \"k\": (2.0, \"1/s^2\"), \"F\": (1.0, \"m/s^2\") }}, states: {{ \"x\": \"m\", \"y\": \"m/s\" }},\n\
         known: {{ \"x\": \"y\", \"y\": \"-d*y - k*x + F*cos(1.1*t) + 0.6*F*cos(0.37*t)\" }},\n\
         unknown: {{ \"y\": (candidates: [], laws: [\"{law}\"]) }}, contacts: [\"y\"],\n\
         data: [Synthetic(truth: {{ {truth} }}, start: {{ \"x\": 0.1, \"y\": 0.0 }}, duration: 40.0, step: 0.02, noise: Additive(0.01), seed: 9)])"
    )
}

/// A law whose level is nothing, or that is at its end while something is left, is not in the data.
#[test]
fn a_law_that_vanished_is_rejected() {
    for (name, law, truth, why) in [
        (
            "vanished",
            "coulomb",
            "0.2*sgn(y)",
            "the force that is left on y in synthetic 0 follows the motion",
        ),
        (
            "at_its_end",
            "asymmetric-coulomb",
            "-0.3*sgn(y) - 0.4",
            "Fm ended at 0 m/s^2, the limit of its law",
        ),
    ] {
        let (result, text) = run(name, &asked_for(law, &format!("\"y\": \"{truth}\"")), &[]);
        assert!(text.contains(&format!("rejected: {why}")), "{result} {text}");
    }
    let (_, text) = run("stays", &asked_for("coulomb", "\"y\": \"-0.2*sgn(y)\""), &[]);
    assert!(text.contains("\nidentified (") || text.contains("% identified ("), "{text}");
}

/// The best of many frequencies lowers the misfit of noise, too.
#[test]
fn a_frequency_that_follows_the_noise_is_rejected() {
    let (_, text) = run("tone", &asked_for("harmonic-force", ""), &[]);
    assert!(text.contains("rejected: the known part is complete"), "{text}");
    let (_, text) = run("true_tone", &asked_for("harmonic-force", "\"y\": \"0.2*cos(2.3*t + 0.4)\""), &[]);
    assert!(text.contains("identified ("), "{text}");
}

/// A free oscillator with dry friction: stiffness, damping and friction of a mass that is stated. All three are in
/// proportion to it, for the motion tells accelerations alone.
fn of_mass(mass: &str, records: usize) -> String {
    let record = r#"Synthetic(truth: { "v": "-1.2*sgn(v)/m" }, start: { "x": 0.05, "v": 0.0 }, duration: 5, step: 0.01,
        noise: Additive(0.01), seed: 1)"#;
    let records = vec![record; records].join(", ");
    format!(
        r#"(constants: {{ "m": {mass}, "k": Find(start: 700.0, unit: "N/m", within: (1.0, 5000.0)), "c": Find(start: 1.0, unit: "N*s/m", within: (0.0, 50.0)) }},
            states: {{ "x": "m", "v": "m/s" }}, known: {{ "x": "v", "v": "(-k*x - c*v)/m" }}, inertia: {{ "v": "m" }},
            unknown: {{ "v": (factor: "-sgn(v)/m", candidates: ["1"]) }}, contacts: ["v"], data: [{records}])"#
    )
}

#[test]
fn numbers_tell_how_they_hang_on_a_mass_that_is_held() {
    let (result, text) = run("held_mass", &of_mass(r#"(2.0, "kg")"#, 1), &[]);
    let moves = result["held"][0]["moves"].as_array().expect("what hangs on the mass");
    assert_eq!(moves.len(), 3, "{moves:?}");
    moves.iter().for_each(|m| near(&m["percent"], 1.0, 0.01));
    assert!(text.contains("with 1 % more") && text.contains("+1.00 %"), "{text}");
    // With a standard deviation of 1 % the others are not known better than that.
    let believed = of_mass(r#"(value: 2.0, unit: "kg", sigma: 0.02)"#, 1);
    let (result, _) = run("believed_mass", &believed, &[]);
    let error = |name: &str| {
        let all = result["parameters"].as_array().expect("parameters");
        let one = all.iter().find(|p| p["name"] == name).expect("the parameter");
        one["std_error"].as_f64().expect("a number") / one["value"].as_f64().expect("a number")
    };
    assert!((error("k") / 0.01 - 1.0).abs() < 0.05 && (error("m") / 0.01 - 1.0).abs() < 0.05, "{result}");
}

/// The error of predictions stays that of the noise; a linear model does not stop where friction does.
#[test]
fn a_model_tells_how_far_it_predicts() {
    let (result, text) = run("horizon", &of_mass(r#"(2.0, "kg")"#, 1), &[]);
    let of = |column: &str| {
        let all = result["horizon"].as_array().expect("horizons");
        all.iter().filter(|h| h["column"] == column).cloned().collect::<Vec<Value>>()
    };
    let x = of("x");
    assert_eq!(x.len(), of("v").len());
    let number = |value: &Value| value.as_f64().expect("a number");
    assert!(x.windows(2).all(|pair| number(&pair[0]["seconds"]) < number(&pair[1]["seconds"])));
    let (first, last) = (&x[0], &x[x.len() - 1]);
    near(&first["seconds"], 0.01, 1e-9);
    near(&last["seconds"], 2.5, 0.01);
    assert!(x.iter().all(|h| number(&h["nrmse"]) < 0.02), "{x:?}");
    assert!(number(&last["baseline"]) > 5.0 * number(&last["nrmse"]), "{last}");
    assert!(text.contains("the model misses ") && text.contains("; a linear model by"), "{text}");
}

#[test]
fn a_record_that_is_listed_twice_counts_once() {
    let (once, _) = run("once", &of_mass(r#"(2.0, "kg")"#, 1), &[]);
    let (twice, _) = run("twice", &of_mass(r#"(2.0, "kg")"#, 3), &[]);
    let error = |of: &Value| of["equations"][0]["terms"][0]["std_error"].clone();
    assert_eq!(error(&once), error(&twice));
    assert_eq!(twice["records"].as_array().map(Vec::len), Some(3));
    assert!(twice["warnings"].to_string().contains("holds the same samples as"), "{}", twice["warnings"]);
    assert!(!once["warnings"].to_string().contains("same samples"));
}

/// What is believed of a mass and what the records say add up, also beside a force that is left.
#[test]
fn a_belief_is_worth_no_more_than_it_says_beside_a_force_that_is_left() {
    let scratch = Scratch::new("belief");
    let spec = scratch.path("rig.ron");
    assert_eq!(phisindy(&["new", "docs/tutorial/rig.csv", "--out", &spec, "--quiet"]).code, 0);
    let mass = |set: &str| {
        let said = phisindy(&["run", &spec, "--data", "docs/tutorial", "--format", "json", "--set", set]);
        let result: Value = serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{e}: {}", said.err));
        let all = result["parameters"].as_array().expect("parameters").clone();
        all.iter().find(|p| p["name"] == "m").expect("the mass")["std_error"].as_f64().expect("a number")
    };
    let alone = mass(r#"constants.m=(value: 2.0, unit: "kg", within: (0.5, 8.0))"#);
    let believed = mass(r#"constants.m=(value: 2.0, unit: "kg", sigma: 0.02)"#);
    let both = (alone.powi(-2) + 0.02_f64.powi(-2)).sqrt().recip();
    assert!(
        (believed / both - 1.0).abs() < 0.3,
        "{alone} alone, {believed} with the belief, {both} together"
    );
}
