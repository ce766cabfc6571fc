//! Motion that forgets its start: Lorenz's equations of 1963 with nothing known.

use phisindy_learn::{Identified, LearnOptions, Verdict, Warning, identify};
use phisindy_phys::{Origin, SourceId, check, spec};
use phisindy_sim::synthesize;
use std::ops::ControlFlow;

/// The true terms of the dictionary: x, y; x, y, x z; z, x y.
const TRUE: [usize; 7] = [1, 2, 11, 12, 16, 23, 25];

fn lorenz(duration: f64, noise: f64) -> Identified {
    let ten = r#"["1", "x", "y", "z", "x^2", "x*y", "x*z", "y^2", "y*z", "z^2"]"#;
    let unknown =
        ["x", "y", "z"].map(|state| format!(r#""{state}": (factor: "1", candidates: {ten})"#)).join(", ");
    let text = format!(
        r#"(states: {{ "x": "", "y": "", "z": "" }}, known: {{ "x": "0", "y": "0", "z": "0" }}, unknown: {{ {unknown} }},
            data: [ Synthetic(truth: {{ "x": "10*(y - x)", "y": "x*(28 - z) - y", "z": "x*y - 8/3*z" }},
                start: {{ "x": -8.0, "y": 8.0, "z": 27.0 }}, duration: {duration:?}, step: 0.01,
                noise: Sensor({{ "x": ({noise:?}, ""), "y": ({noise:?}, ""), "z": ({noise:?}, "") }}), seed: 1) ])"#
    );
    let (spec, _) = spec::read(&text, SourceId(0)).unwrap();
    let (case, _) = check(&spec, SourceId(0)).unwrap();
    let Origin::Synthetic(truth) = &case.records[0].origin else { panic!("a measured record") };
    let (record, _) =
        synthesize(&case.records[0], truth, &case.system, None, &|_| Err("no files here".into())).unwrap();
    identify(&case, &[record], &LearnOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap()
}

fn terms(found: &Identified) -> Vec<usize> {
    found.terms.iter().map(|t| t.term).collect()
}

/// Noise of a fifth of the motion, six seconds: a disturbance grows a hundredfold.
#[test]
fn thirty_unknown_terms_of_a_chaotic_motion() {
    let found = lorenz(6.0, 2.5506);
    assert_eq!((terms(&found), &found.verdict), (TRUE.to_vec(), &Verdict::Identified));
    for (term, due) in found.terms.iter().zip([-10.0, 10.0, 28.0, -1.0, -1.0, -8.0 / 3.0, 1.0]) {
        let (value, error) = (term.coefficient.value, term.coefficient.std_error);
        assert!((value - due).abs() < 4.0 * error, "{value} +- {error} for {due}");
    }
}

/// In forty seconds a disturbance grows by sixteen decades.
#[test]
fn a_run_that_no_start_can_follow_is_judged_by_what_it_keeps() {
    let found = lorenz(40.0, 1.2753);
    assert_eq!((terms(&found), &found.verdict), (TRUE.to_vec(), &Verdict::Identified));
    let chaos = found.warnings.iter().find_map(|w| if let Warning::Chaotic(c) = w { Some(c) } else { None });
    let chaos = chaos.expect("a chaotic motion");
    // The published exponent is 0.906 (Sprott, Chaos and Time-Series Analysis, 2003); over forty seconds it scatters.
    assert!((chaos.exponent - 0.906).abs() < 0.25, "{chaos:?}");
}
