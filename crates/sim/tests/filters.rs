//! Filters of sensors against the frequency response of Butterworth's poles.

use phisindy_phys::{Origin, SourceId, check, spec};
use phisindy_sim::synthesize;
use std::f64::consts::PI;

/// The motion `x = cos(W t)` and the time, as a filtered column shows it.
fn filtered(reads: &str, filter: &str) -> (Vec<f64>, Vec<f64>) {
    let text = format!(
        r#"(states: {{ "x": "m", "v": "m/s" }}, constants: {{ "W": (9.0, "rad/s"), "g": (0.4, "1/s^2") }},
            outputs: {{ "a": (unit: "m/s^2", reads: "{reads}") }},
            known: {{ "x": "v", "v": "-W^2*x" }}, unknown: {{}},
            data: [ Synthetic(truth: {{}}, start: {{ "x": 1.0 }}, duration: 14.0, step: 0.01, noise: None, sensors: {{ "a": ({filter}) }}) ])"#
    );
    let (spec, _) = spec::read(&text, SourceId(0)).unwrap_or_else(|e| panic!("{e:#?}"));
    let (case, _) = check(&spec, SourceId(0)).unwrap_or_else(|e| panic!("{e:#?}"));
    let Origin::Synthetic(truth) = &case.records[0].origin else { panic!("a measured record") };
    let file = |_: &phisindy_phys::spec::InputSpec| Err("no files here".into());
    let (record, _) = synthesize(&case.records[0], truth, &case.system, None, &file).expect("a record");
    (record.time.to_vec(), record.columns[case.system.column("a").expect("a")].clone().expect("a column"))
}

/// Real and imaginary part of the response of Butterworth's low-pass at the angular frequency `w`, from its
/// poles; of the high-pass with the same cutoff, which mirrors the frequency.
fn response(order: usize, cutoff: f64, w: f64, high: bool) -> (f64, f64) {
    let s = if high { -2.0 * PI * cutoff / w } else { w / (2.0 * PI * cutoff) };
    let (mut re, mut im) = (1.0, 0.0);
    for k in 1..=order {
        let angle = PI * (2 * k + order - 1) as f64 / (2 * order) as f64;
        // 1/(j s - pole)
        let (a, b) = (-angle.cos(), s - angle.sin());
        let size = a * a + b * b;
        (re, im) = ((re * a + im * b) / size, (im * a - re * b) / size);
    }
    (re, im)
}

#[test]
fn filters_of_every_order_have_the_response_of_their_poles() {
    // What a displacement and an accelerometer show of cos(W t).
    for (reads, amplitude) in [("g*x", 0.4), ("rate(v) + g*x", 0.4 - 81.0)] {
        for order in 1..=5 {
            for (kind, high) in [("lowpass", false), ("highpass", true)] {
                let cutoff = 1.3;
                let (time, shown) =
                    filtered(reads, &format!(r#"{kind}: (order: {order}, cutoff: ({cutoff}, "Hz"))"#));
                let (re, im) = response(order, cutoff, 9.0, high);
                for (t, a) in time.iter().zip(&shown).filter(|(t, _)| **t > 11.0) {
                    let due = amplitude * (re * (9.0 * t).cos() - im * (9.0 * t).sin());
                    assert!(
                        (a - due).abs() < 1e-6 * amplitude.abs(),
                        "{kind} {order} at {t}: {a}, due {due}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_band_is_what_both_filters_leave() {
    let filter = r#"lowpass: (order: 3, cutoff: (2.0, "Hz")), highpass: (order: 2, cutoff: (0.0007, "kHz"))"#;
    let (time, shown) = filtered("rate(v)", filter);
    let (a, b) = (response(3, 2.0, 9.0, false), response(2, 0.7, 9.0, true));
    let (re, im) = (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
    for (t, a) in time.iter().zip(&shown).filter(|(t, _)| **t > 11.0) {
        let due = -81.0 * (re * (9.0 * t).cos() - im * (9.0 * t).sin());
        assert!((a - due).abs() < 1e-5, "{t}: {a}, due {due}");
    }
}

#[test]
fn a_filter_has_settled_on_the_first_reading() {
    for (filter, due) in
        [("lowpass: (order: 4, cutoff: 0.01)", -81.0), ("highpass: (order: 4, cutoff: 1000.0)", 0.0)]
    {
        let (_, shown) = filtered("rate(v)", filter);
        assert!((shown[0] - due).abs() < 1e-6, "{filter}: {}", shown[0]);
    }
}
