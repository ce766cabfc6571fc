//! Friction from noisy positions: which terms it has, how large they are, and how sure that is.
//!
//! ```text
//! cargo run --release -p phisindy-learn --example friction
//! ```
#![allow(clippy::print_stdout)]

use phisindy_learn::{LearnOptions, Verdict, identify};
use phisindy_phys::{Origin, Sources, check, spec};
use phisindy_sim::synthesize;
use std::ops::ControlFlow;

/// The data are made by the program itself: the truth holds two terms, the dictionary six. The velocity is
/// not measured.
const SPEC: &str = r#"(
    constants: { "m": (1.0, "kg"), "d": (0.1, "N*s/m"), "k": (value: 1.1, unit: "N/m", within: (0.5, 2.0)) },
    states: { "x": "m", "v": "m/s" },
    known: { "x": "v", "v": "(-d*v - k*x + 1*cos(0.3*t))/m" },
    unknown: { "v": (factor: "-sgn(v)/m", candidates: ["1", "x", "v", "x^2", "x*v", "v^2"]) },
    contacts: ["v"],
    data: [ Synthetic(truth: { "v": "-(0.5 + 0.2*v^2)*sgn(v) + 0.1*x" }, start: { "x": 0.1, "v": 0.1 }, duration: 60.0, step: 0.02,
                      noise: Additive(0.05), seed: 1, measure: ["x"]) ],
)"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A text becomes a checked case; a file would be read by the caller, for no library here reads any.
    let source = Sources::default().add("friction.ron", SPEC);
    let words = |mistakes: Vec<phisindy_phys::Diagnostic>| mistakes[0].message.clone();
    let (spec, _) = spec::read(SPEC, source).map_err(words)?;
    let (case, _) = check(&spec, source).map_err(words)?;

    // Stick and slip are simulated, then the noise is added: 5 % of what the column moves.
    let plan = &case.records[0];
    let Origin::Synthetic(truth) = &plan.origin else { return Err("a measured record".into()) };
    let (record, _) = synthesize(plan, truth, &case.system, None, &|_| Err("no files here".into()))?;

    // The truth has a spring that is softer by 0.1 N/m than the spec believes: k may move, and goes to 1.0.
    let found = identify(&case, &[record], &LearnOptions::default(), &mut |_| ControlFlow::Continue(()))?;
    println!("{:<6} {:>9} {:>10}   95 % interval", "term", "found", "std. error");
    for term in &found.terms {
        let (c, name) = (term.coefficient, &case.system.terms[term.term].candidate);
        println!("{name:<6} {:>9.5} {:>10.5}   [{:.5}, {:.5}]", c.value, c.std_error, c.ci95.0, c.ci95.1);
    }
    for p in &found.parameters {
        let e = p.estimate;
        println!(
            "{:<6} {:>9.5} {:>10.5}   [{:.5}, {:.5}]",
            p.id.to_string(),
            e.value,
            e.std_error,
            e.ci95.0,
            e.ci95.1
        );
    }
    println!(
        "\nthe truth: 0.5 + 0.2 v^2, k = 1; {} of {} candidates survive",
        found.terms.len(),
        case.system.terms.len()
    );
    match &found.verdict {
        Verdict::Identified => println!(
            "identified: the free run misses the data by {:.3} of their spread",
            found.records[0].worst()
        ),
        verdict => println!("{}: {}", verdict.word(), verdict.reason().unwrap_or_default()),
    }
    found.warnings.iter().for_each(|w| println!("warning: {w}"));
    Ok(())
}
