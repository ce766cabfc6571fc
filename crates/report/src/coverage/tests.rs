use super::*;
use phisindy_phys::{Origin, SourceId, check, spec};
use phisindy_sim::synthesize;

/// What a driven body with friction of 0.3 N and a free spring tells in so many seconds at this amplitude of the drive.
fn told(duration: f64, drive: f64, noise: f64) -> Coverage {
    let text = format!(
        r#"(states: {{ "x": "mm", "v": "mm/s" }}, inputs: {{ "F": "N" }}, inertia: {{ "v": "m" }}, contacts: ["v"],
        constants: {{ "m": (2.0, "kg"), "k": (value: 60.0, unit: "N/m", within: (1.0, 900.0)), "c": (value: 1.0, unit: "N*s/m", within: (0.0, 9.0)) }},
        known: {{ "x": "v", "v": "(F - k*x - c*v)/m" }}, unknown: {{}},
        data: [ Synthetic(truth: {{ "v": "(-0.3*sgn(v) - 20.0*x)/m" }}, start: {{ "x": 0.0, "v": 0.0 }},
            inputs: {{ "F": Formula("{drive:?}*cos(5*t)") }}, duration: {duration:?}, step: 0.004, noise: Additive({noise:?}), seed: 3) ])"#
    );
    let (spec, _) = spec::read(&text, SourceId(0)).expect("a spec");
    let (case, _) = check(&spec, SourceId(0)).expect("a case");
    let Origin::Synthetic(truth) = &case.records[0].origin else { panic!("a measured record") };
    let (record, _) = synthesize(&case.records[0], truth, &case.system, None, &|_| Err("no files".into()))
        .expect("a record");
    coverage(&case.system, &[record]).pop().expect("one body")
}

#[test]
fn the_force_at_each_speed_is_told_within_its_error() {
    let told = told(60.0, 3.0, 2e-4);
    assert_eq!((told.speed.0.as_str(), told.speed.1.as_str(), told.unit.as_str()), ("v", "mm/s", "N"));
    // The spring is found beside it; the damping is one over the speed, so the curve holds it: 1 N s/m.
    for node in &told.nodes {
        let due = 0.3 * node.speed.signum() + 1e-3 * node.speed;
        assert!((node.force - due).abs() < 2.0 * node.half + 0.01, "{node:?} for {due}");
    }
    assert!(told.is_enough() && told.to_string().starts_with("Enough"), "{told} {:?}", told.nodes);
}

#[test]
fn a_short_or_noisy_record_says_where_to_move() {
    let short = told(2.5, 3.0, 1e-3);
    assert!(!short.is_enough() && short.to_string().starts_with("Move"), "{short}");
    let noisy = told(20.0, 3.0, 0.5);
    assert!(!noisy.is_enough(), "{noisy} {:?}", noisy.nodes);
}
