//! How a model does on records as a workshop takes them: short ones, and with a drive that is measured with noise.
#![allow(missing_docs)]

use phisindy_gap::{Alternative, Gap, Status, gap, standing};
use phisindy_phys::spec::Spec;
use phisindy_phys::{Case, LawEntry, Origin, Record, SourceId, check, spec};
use phisindy_signal::test_signals::gaussian;
use phisindy_signal::{Interpolation, Signal};
use phisindy_sim::synthesize;
use std::ops::ControlFlow;

fn loaded(text: &str) -> (Spec, Case, Vec<Record>) {
    let (spec, _) = spec::read(text, SourceId(0)).expect("a spec");
    let (case, _) = check(&spec, SourceId(0)).expect("a case");
    let made = case.records.iter().map(|plan| {
        let Origin::Synthetic(truth) = &plan.origin else { panic!("a measured record") };
        synthesize(plan, truth, &case.system, None, &|_| Err("no files here".into())).expect("a record").0
    });
    let records = made.collect();
    (spec, case, records)
}

/// Columns tell the noise of six hundred samples to some five per cent, which is more than a complete model may leave
/// by chance; what a white model leaves tells it better.
#[test]
fn a_complete_model_of_short_records_stands() {
    let record = |name: &str, seed: usize, role: &str| {
        format!(
            r#"Synthetic(name: "{name}", truth: {{}}, start: {{ "x": 0.0, "v": 0.0 }}, duration: 24.0, step: 0.04,
                inputs: {{ "F": Multisine(amplitude: 6.0, band: (0.4, 5.0), count: 12) }}, interpolate: {{ "F": Cubic }},
                measure: ["x"], noise: Sensor({{ "x": (2e-4, "m") }}), seed: {seed}, role: {role})"#
        )
    };
    let gap = |seed: usize| {
        let text = format!(
            r#"(states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "F": "N" }},
                constants: {{ "k": (value: 400.0, unit: "N/(m*kg)", within: (320.0, 480.0)), "c": (value: 1.5, unit: "1/s", within: (0.0, 6.0)), "m": (2.0, "kg") }},
                known: {{ "x": "v", "v": "F/m - c*v - k*x" }}, unknown: {{}}, data: [{}, {}])"#,
            record("a", 2 * seed, "Fit"),
            record("b", 2 * seed + 1, "Validate")
        );
        let (spec, case, records) = loaded(&text);
        let found = standing(spec, case, records).expect("a fit");
        (!found.explains).then_some((seed, found.gap))
    };
    let missed: Vec<(usize, f64)> = (1..=100).filter_map(gap).collect();
    assert!(missed.is_empty(), "{missed:?}");
}

/// The noise of a force acts as one: a free run sums it up. The numbers come from the fit that leaves a force on the
/// body, so that their intervals hold.
#[test]
fn numbers_hold_beside_a_force_that_is_measured_with_noise() {
    let record = |amplitude: f64, duration: f64, seed: usize, role: &str| {
        format!(
            r#"Synthetic(inputs: {{ "f": Multisine(amplitude: {amplitude:?}, band: (0.5, 6.0)) }}, truth: {{ "v": "(-1.5*sgn(v) - 100.0*x - 1.0*v)/m" }},
                start: {{}}, duration: {duration:?}, step: 0.005, noise: Sensor({{ "x": (2e-5, "m"), "f": (0.2, "N") }}), measure: ["x", "f"], seed: {seed}, role: {role})"#
        )
    };
    let law = r#"(name: "Coulomb friction", roles: { "v": "m/s" }, force: "Fc*sgn(v)", family: "friction", parameters: { "Fc": (unit: "N", within: (0.0, 1e3)) })"#;
    let catalogue = [LawEntry::read("coulomb", law).expect("a law")];
    let mut missed = vec![];
    for seed in [8, 9] {
        let text = format!(
            r#"(constants: {{ "m": (2.0, "kg"), "k": (value: 700.0, unit: "N/m", within: (100.0, 3000.0)), "c": (value: 2.0, unit: "N*s/m", within: (0.0, 50.0)) }},
                states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "f": "N" }}, known: {{ "x": "v", "v": "(f - k*x - c*v)/m" }}, inertia: {{ "v": "m" }},
                unknown: {{}}, data: [{}, {}])"#,
            record(8.0, 5.0, seed, "Fit"),
            record(7.0, 3.0, 10 + seed, "Validate")
        );
        let (_, case, records) = loaded(&text);
        let found =
            gap(&text, case, records, &catalogue, &mut |_, _| ControlFlow::Continue(())).expect("a result");
        for (name, truth) in [("Fc", 1.5), ("k", 800.0), ("c", 3.0)] {
            let p = found.parameters.iter().find(|p| p.id.to_string() == name).expect("a number");
            let (low, high) = p.estimate.ci95;
            if !(low..=high).contains(&truth) {
                missed.push((seed, name, p.estimate.value, low, high));
            }
        }
    }
    // Of six intervals of 95 % one may miss; those of the free run miss five.
    assert!(missed.len() <= 1, "{missed:?}");
}

/// The noise of a force may leave as much as the model as it is does, and Stribeck's friction may follow it better than the
/// Coulomb friction that is there. What counts is how each law does beside a random force.
#[test]
fn noise_of_an_input_is_no_excuse_for_friction() {
    let law = |id: &str, text: &str| LawEntry::read(id, text).expect("a law");
    let catalogue = [
        law("coulomb", include_str!("../../phys/laws/coulomb.ron")),
        law("stribeck", include_str!("../../phys/laws/stribeck.ron")),
    ];
    let judged = |friction: f64| {
        let text = format!(
            r#"(constants: {{ "m": (2.0, "kg"), "k": (800.0, "N/m"), "c": (1.5, "N*s/m") }},
                states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "f": "N" }},
                known: {{ "x": "v", "v": "(f - k*x - c*v)/m" }}, inertia: {{ "v": "m" }}, unknown: {{}},
                data: [ Synthetic(inputs: {{ "f": Multisine(amplitude: 8.0, band: (0.5, 6.0)) }},
                    truth: {{ "v": "-{friction:?}*sgn(v)/m" }}, start: {{}}, duration: 8.0, step: 0.01,
                    noise: Sensor({{ "x": (2e-5, "m"), "f": (0.5, "N") }}), measure: ["x", "f"], seed: 6) ])"#
        );
        let (_, case, records) = loaded(&text);
        let found =
            gap(&text, case, records, &catalogue, &mut |_, _| ControlFlow::Continue(())).expect("a result");
        let laws: Vec<String> = found.steps.iter().map(|s| s.effect.entry.id.clone()).collect();
        let holds = found.steps.iter().all(|s| {
            let (low, high) = s.parameters[0].ci95;
            low <= friction && friction <= high
        });
        (found.status, laws.join(" + "), holds)
    };
    assert_eq!(judged(0.0), (Status::NothingMissing, String::new(), true));
    assert_eq!(judged(0.3), (Status::Explained, "coulomb".into(), true));
}

/// A driven mass on a spring, and what the model lacks in the record to fit and in the one to validate.
fn rig(lacks: [&str; 2]) -> String {
    let record = |lacks: &str, seed: usize, role: &str| {
        format!(
            r#"Synthetic(name: "{role}", inputs: {{ "F": Multisine(amplitude: 8.0, band: (0.5, 6.0), count: 15) }}, truth: {{ "v": "({lacks})/m" }},
                start: {{}}, duration: 6.0, step: 0.005, noise: Sensor({{ "x": (5e-5, "m") }}), measure: ["x"], seed: {seed}, role: {role})"#
        )
    };
    format!(
        r#"(constants: {{ "m": (2.0, "kg"), "k": (value: 800.0, unit: "N/m", within: (640.0, 960.0)), "c": (value: 1.5, unit: "N*s/m", within: (0.0, 6.0)) }},
            states: {{ "x": "m", "v": "m/s" }}, inputs: {{ "F": "N" }}, known: {{ "x": "v", "v": "(F - c*v - k*x)/m" }}, inertia: {{ "v": "m" }},
            unknown: {{}}, data: [{}, {}])"#,
        record(lacks[0], 31, "Fit"),
        record(lacks[1], 32, "Validate")
    )
}

fn found(text: &str, catalogue: &[LawEntry], changed: impl Fn(&mut Record)) -> Gap {
    let (_, case, mut records) = loaded(text);
    records.iter_mut().for_each(changed);
    gap(text, case, records, catalogue, &mut |_, _| ControlFlow::Continue(())).expect("a result")
}

/// Two pushes that nobody measured are told with their times, beside numbers that hold; a cubic spring that the model lacks
/// is no push, although its force comes in bursts.
#[test]
fn pushes_that_nobody_measured_are_told_with_their_times() {
    let half_sine = |from: f64, size: f64| {
        format!("{size:?}*pos(sin(3.14159*(t - {from:?})/0.2))*step(t - {from:?})*step({from:?} + 0.2 - t)")
    };
    let pushed = found(&rig([&half_sine(2.1, 12.0), &half_sine(3.4, -9.0)]), &[], |_| ());
    let Some(Alternative::Pushes(pushes)) = &pushed.alternative else { panic!("{:?}", pushed.status) };
    assert_eq!(pushed.status, Status::Named);
    for (record, from, change) in [("Fit", 2.1, 12.0), ("Validate", 3.4, -9.0)] {
        let own = pushes.iter().find(|p| p.record == record).expect("a push");
        assert!(own.from < from + 0.05 && own.to > from + 0.15 && own.to - own.from < 0.6, "{own:?}");
        // The impulse of half a sine over the mass.
        let due = change * 0.2 * std::f64::consts::FRAC_2_PI / 2.0;
        assert!((own.changes / due - 1.0).abs() < 0.15, "{own:?} for {due}");
    }
    let k = pushed.parameters.iter().find(|p| p.id.to_string() == "k").expect("a number").estimate.ci95;
    assert!(k.0 < 800.0 && k.1 > 800.0, "{k:?}");
    let bent = found(&rig(["-2e7*x^3", "-2e7*x^3"]), &[], |_| ());
    assert!(!matches!(bent.alternative, Some(Alternative::Pushes(_))), "{:?}", bent.alternative);
    // One that lasts for a fifth of the record.
    let leaned = found(&rig(["1.5*step(t - 2.0)*step(3.2 - t)", "0"]), &[], |_| ());
    let Some(Alternative::Pushes(pushes)) = &leaned.alternative else { panic!("{:?}", leaned.status) };
    let [push] = &pushes[..] else { panic!("{pushes:?}") };
    assert!((push.from - 2.0).abs() < 0.06 && (push.to - 3.2).abs() < 0.06, "{push:?}");
}

/// A tone in a sensor is hum, a force that oscillates moves the mass as the model moves: the same size in the column, the
/// same phase in all.
#[test]
fn a_tone_in_a_sensor_is_hum_and_a_force_is_a_force() {
    let laws = [
        ("harmonic-force", include_str!("../../phys/laws/harmonic-force.ron")),
        ("cubic-stiffness", include_str!("../../phys/laws/cubic-stiffness.ron")),
    ];
    let catalogue = laws.map(|(id, law)| LawEntry::read(id, law).expect("a law"));
    let named = |gap: &Gap| gap.steps.iter().map(|s| s.effect.entry.id.clone()).collect::<Vec<_>>();
    let hum = |record: &mut Record| {
        for (k, size, phase) in [(0, 2e-4, 0.0), (1, 6e-3, 2.0)] {
            let Some(column) = record.columns[k].as_mut() else { continue };
            column.iter_mut().zip(&*record.time).for_each(|(x, t)| *x += size * (31.0 * t + phase).sin());
        }
    };
    let both = |lacks: &str| {
        let one = rig([lacks, lacks]).replace(r#"["x"]"#, r#"["x", "v"]"#);
        one.replace(r#"(5e-5, "m")"#, r#"(5e-5, "m"), "v": (1.5e-3, "m/s")"#)
    };
    let (cubic, force) = ("-5e5*x^3", "1.5*sin(31.0*t)");
    for text in [rig(["0", "0"]), both("0")] {
        let in_sensor = found(&text, &catalogue, hum);
        assert_eq!((in_sensor.status, named(&in_sensor)), (Status::NothingMissing, vec![]));
    }
    let beside_a_law = found(&both(cubic), &catalogue, hum);
    assert_eq!(
        (beside_a_law.status, named(&beside_a_law)),
        (Status::Explained, vec!["cubic-stiffness".to_owned()]),
        "{:?}",
        beside_a_law.none
    );
    for text in [rig([force, force]), both(force)] {
        let on_mass = found(&text, &catalogue, |_| ());
        assert_eq!((on_mass.status, named(&on_mass)), (Status::Explained, vec!["harmonic-force".to_owned()]));
    }
}

/// The same rig with an accelerometer alone.
fn with_accelerometer(lacks: &str) -> String {
    let one = rig([lacks, lacks]).replace(r#"["x"]"#, r#"["a"]"#);
    let one = one.replace(r#""x": (5e-5, "m")"#, r#""a": (0.05, "m/s^2")"#);
    one.replace(r#"inertia: {"#, r#"outputs: { "a": (unit: "m/s^2", reads: "rate(v)") }, inertia: {"#)
}

/// A force of one frequency is not left as noise of another size, however large it is; hum is no force.
#[test]
fn a_tone_of_an_accelerometer_is_not_passed_over() {
    let law = include_str!("../../phys/laws/harmonic-force.ron");
    let catalogue = [LawEntry::read("harmonic-force", law).expect("a law")];
    let on_mass = found(&with_accelerometer("1.5*sin(31.0*t)"), &catalogue, |_| ());
    assert!(on_mass.status != Status::NothingMissing && on_mass.steps.len() <= 1, "{:?}", on_mass.status);
    let hum = |record: &mut Record| {
        let Some(column) = record.columns[2].as_mut() else { panic!("an accelerometer") };
        column.iter_mut().zip(&*record.time).for_each(|(a, t)| *a += 0.4 * (31.0 * t).sin());
    };
    let in_sensor = found(&with_accelerometer("0"), &catalogue, hum);
    let said = in_sensor.status;
    assert!(said == Status::NothingMissing || said == Status::Undetermined, "{said:?}");
}

/// Each reading keeps four fifths of the last one's error.
fn with_slow_noise(record: &mut Record) {
    let white = gaussian(record.len(), record.name.len() as u64);
    let Some(column) = record.columns[0].as_mut() else { panic!("a displacement") };
    let mut last = 0.0;
    for (x, e) in column.iter_mut().zip(white) {
        last = 0.8 * last + 1.2e-4 * e;
        *x += last;
    }
}

/// Noise with a colour is no force: a complete model stays as it is, and a law that is there is the answer.
#[test]
fn noise_with_a_colour_is_no_force() {
    let laws = [
        ("coulomb", include_str!("../../phys/laws/coulomb.ron")),
        ("viscous", include_str!("../../phys/laws/viscous.ron")),
        ("cubic-stiffness", include_str!("../../phys/laws/cubic-stiffness.ron")),
    ];
    let catalogue = laws.map(|(id, law)| LawEntry::read(id, law).expect("a law"));
    let complete = found(&rig(["0", "0"]), &catalogue, with_slow_noise);
    assert_eq!((complete.status, complete.steps.len()), (Status::NothingMissing, 0));
    let cubic = found(&rig(["-5e5*x^3", "-5e5*x^3"]), &catalogue, with_slow_noise);
    let named: Vec<&str> = cubic.steps.iter().map(|s| s.effect.entry.id.as_str()).collect();
    assert_eq!((cubic.status, &named[..]), (Status::Explained, &["cubic-stiffness"][..]), "{:?}", cubic.none);
}

/// A displacement through a filter of first order, straight between the tenths of a sample, and what the converter adds.
fn behind_a_filter(record: &mut Record, lag: f64) {
    let (time, added) = (record.time.clone(), gaussian(record.len(), 7 + record.name.len() as u64));
    let Some(column) = record.columns[0].as_mut() else { panic!("a displacement") };
    let motion = Signal::new(time.clone(), column.clone(), Interpolation::Cubic).expect("a signal");
    let (mut shown, mut before) = (column[0], column[0]);
    for k in 1..column.len() {
        let step = 0.1 * (time[k] - time[k - 1]);
        let stays = (-step / lag).exp();
        for tenth in 1..=10 {
            let now = motion.value(time[k - 1] + f64::from(tenth) * step);
            let behind = (now - before) / step * lag;
            shown = now - behind + (shown - before + behind) * stays;
            before = now;
        }
        column[k] = shown + 5e-5 * added[k];
    }
}

/// A filter before the converter is a lag and no delay, and the numbers of the rig hold beside it.
#[test]
fn a_filter_of_the_sensors_is_named() {
    let laws = [
        ("coulomb", include_str!("../../phys/laws/coulomb.ron")),
        ("sensor-delay", include_str!("../../phys/laws/sensor-delay.ron")),
        ("sensor-lag", include_str!("../../phys/laws/sensor-lag.ron")),
        ("viscous", include_str!("../../phys/laws/viscous.ron")),
    ];
    let catalogue = laws.map(|(id, law)| LawEntry::read(id, law).expect("a law"));
    let said = found(&rig(["0", "0"]), &catalogue, |record| behind_a_filter(record, 6e-3));
    let named: Vec<&str> = said.steps.iter().map(|s| s.effect.entry.id.as_str()).collect();
    assert_eq!((said.status, &named[..]), (Status::Explained, &["sensor-lag"][..]), "{:?}", said.none);
    let tau = said.parameters.iter().find(|p| p.id.to_string() == "tau").expect("a number").estimate.ci95;
    assert!(tau.0 < 6e-3 && tau.1 > 6e-3 && tau.1 - tau.0 < 1e-3, "{tau:?}");
}

/// Noise with heavy tails (Student's t, three degrees of freedom) on a speed that is read late.
fn late_with_outliers(record: &mut Record, seed: u64) {
    for (k, size) in [(0, 0.037), (1, 0.064)] {
        let [a, b, c, d] = [0, 1, 2, 3].map(|part| gaussian(record.len(), 100 * seed + 10 * k as u64 + part));
        let tail = |i: usize| a[i] / (b[i].powi(2) + c[i].powi(2) + d[i].powi(2)).sqrt();
        let Some(column) = record.columns[k].as_mut() else { panic!("a column") };
        let mut before = column[0];
        for (i, value) in column.iter_mut().enumerate() {
            let late = *value - 0.27 * k as f64 * (*value - before);
            before = std::mem::replace(value, late + size * tail(i));
        }
    }
}

/// Outliers are no pushes: a stretch without them is no evidence of a force within it.
#[test]
fn outliers_are_no_pushes() {
    let record = |samples: f64, seed: usize, role: &str| {
        format!(
            r#"Synthetic(name: "{role}", truth: {{}}, start: {{ "x": 0.0, "v": 0.0 }}, duration: {:?}, step: 0.0789,
                noise: Additive(1e-9), seed: {seed}, role: {role})"#,
            0.0789 * samples
        )
    };
    let text = format!(
        r#"(constants: {{ "m": (1.3, "kg"), "c": (0.047, "N*s/m"), "k": (2.97, "N/m") }}, states: {{ "x": "m", "v": "m/s" }},
            known: {{ "x": "v", "v": "(0.93*cos(1.96*t) - c*v - k*x)/m" }}, inertia: {{ "v": "m" }}, unknown: {{}}, data: [{}, {}])"#,
        record(207.0, 1, "Fit"),
        record(139.0, 2, "Validate")
    );
    for seed in [14, 21] {
        let said = found(&text, &[], |record| late_with_outliers(record, seed + record.name.len() as u64));
        assert!(!matches!(said.alternative, Some(Alternative::Pushes(_))), "{:?}", said.alternative);
    }
}

/// A spring so faint that the residual is white is not told, nor is it said that nothing is missing.
#[test]
fn nothing_is_missing_where_no_law_is_likely() {
    let law = include_str!("../../phys/laws/quadratic-stiffness.ron");
    let catalogue = [LawEntry::read("quadratic-stiffness", law).expect("a law")];
    let status = |lacks: &str| found(&rig([lacks, lacks]), &catalogue, |_| ()).status;
    assert_eq!([status("0"), status("-1.6*x^2")], [Status::NothingMissing, Status::Undetermined]);
}

/// A decay that is too noisy to tell drag from a damping constant that changed: neither is said alone.
#[test]
fn a_constant_that_changed_has_laws_as_rivals() {
    let record = |start: &str, duration: f64, seed: usize, role: &str| {
        format!(
            r#"Synthetic(name: "{role}", truth: {{ "v": "-0.02*v*abs(v)/m" }}, start: {{ {start} }}, duration: {duration:?}, step: 0.18,
                noise: Additive(0.15), measure: ["x"], seed: {seed}, role: {role})"#
        )
    };
    let text = format!(
        r#"(constants: {{ "m": (1.0, "kg"), "k": (1.0, "N/m"), "c": (0.03, "N*s/m") }}, states: {{ "x": "m", "v": "m/s" }},
            known: {{ "x": "v", "v": "(-c*v - k*x)/m" }}, inertia: {{ "v": "m" }}, unknown: {{}}, data: [{}, {}])"#,
        record(r#""x": 1.0, "v": 0.0"#, 40.0, 2, "Fit"),
        record(r#""x": 0.9, "v": 0.3"#, 26.0, 12, "Validate")
    );
    let law = include_str!("../../phys/laws/quadratic-drag.ron");
    let catalogue = [LawEntry::read("quadratic-drag", law).expect("a law")];
    let told = found(&text, &catalogue, |_| ());
    let rivals: Vec<&str> =
        told.steps[0].rivals.iter().flat_map(|r| r.laws.iter().map(|law| law.law.as_str())).collect();
    let own = told.steps[0].effect.entry.id.as_str();
    assert_eq!((told.status, own), (Status::Undetermined, "changed-constant"), "{rivals:?}");
    assert!(rivals.contains(&"quadratic-drag"), "{rivals:?}");
}
