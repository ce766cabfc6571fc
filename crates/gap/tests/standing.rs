//! How a model does as it is, from records as short as a workshop takes them.
#![allow(missing_docs)]

use phisindy_gap::standing;
use phisindy_phys::{Origin, SourceId, check, spec};
use phisindy_sim::synthesize;

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
        let (spec, _) = spec::read(&text, SourceId(0)).expect("a spec");
        let (case, _) = check(&spec, SourceId(0)).expect("a case");
        let made = case.records.iter().map(|plan| {
            let Origin::Synthetic(truth) = &plan.origin else { panic!("a measured record") };
            synthesize(plan, truth, &case.system, None, &|_| Err("no files here".into())).expect("a record").0
        });
        let records = made.collect();
        let found = standing(spec, case, records).expect("a fit");
        (!found.explains).then_some((seed, found.gap))
    };
    let missed: Vec<(usize, f64)> = (1..=100).filter_map(gap).collect();
    assert!(missed.is_empty(), "{missed:?}");
}
