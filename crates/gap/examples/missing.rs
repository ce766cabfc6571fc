//! Finds the laws that an incomplete model lacks, and how much of the gap each of them closes.
//!
//! ```text
//! cargo run --release -p phisindy-gap --example missing
//! ```
#![allow(clippy::print_stdout)]

use phisindy_gap::{Gap, gap};
use phisindy_phys::{LawEntry, LawError, Origin, Record, Sources, check, spec};
use phisindy_sim::synthesize;
use std::ops::ControlFlow;

/// A mass on a linear spring. The data come from a model that also has friction and a hardening spring.
/// The spec requests no law: `unknown` is empty.
const SPEC: &str = r#"(
    constants: { "m": (1.0, "kg"), "d": (0.1, "N*s/m"), "k": (1.0, "N/m"), "F0": (1.0, "N"), "W": (0.7, "rad/s") },
    states: { "x": "m", "v": "m/s" },
    known: { "x": "v", "v": "(-d*v - k*x + F0*cos(W*t))/m" },
    inertia: { "v": "m" },
    unknown: {},
    data: [
        Synthetic(truth: { "v": "-0.4*sgn(v) - 0.3*x^3" }, start: { "x": 0.0, "v": 0.0 }, duration: 40.0, step: 0.02, noise: Additive(0.02), seed: 1),
        Synthetic(truth: { "v": "-0.4*sgn(v) - 0.3*x^3" }, start: { "x": 0.5, "v": 0.0 }, duration: 40.0, step: 0.02, noise: Additive(0.02), seed: 2,
                  role: Validate),
    ],
)"#;

/// Some laws of the catalogue; each is a text file, and a new file is a new law.
const LAWS: [(&str, &str); 5] = [
    ("coulomb", include_str!("../../phys/laws/coulomb.ron")),
    ("stribeck", include_str!("../../phys/laws/stribeck.ron")),
    ("viscous", include_str!("../../phys/laws/viscous.ron")),
    ("cubic-stiffness", include_str!("../../phys/laws/cubic-stiffness.ron")),
    ("sensor-delay", include_str!("../../phys/laws/sensor-delay.ron")),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let source = Sources::default().add("rig.ron", SPEC);
    let words = |mistakes: Vec<phisindy_phys::Diagnostic>| mistakes[0].message.clone();
    let (spec, _) = spec::read(SPEC, source).map_err(words)?;
    let (case, _) = check(&spec, source).map_err(words)?;
    let mut records: Vec<Record> = Vec::new();
    for plan in &case.records {
        let Origin::Synthetic(truth) = &plan.origin else { return Err("a measured record".into()) };
        records.push(synthesize(plan, truth, &case.system, None, &|_| Err("no files here".into()))?.0);
    }
    let entries = LAWS.into_iter().map(|(id, text)| LawEntry::read(id, text));
    let catalogue = entries.collect::<Result<Vec<_>, LawError>>()?;

    let found: Gap = gap(SPEC, case, records, &catalogue, &mut |_, _| ControlFlow::Continue(()))?;
    // A gap is the rms of the residual over the noise; 1 is perfect. The Validate record counts, which was
    // not fitted.
    println!("gap on data not used, as the model is: {:.1}", found.before.1.unwrap_or(f64::NAN));
    for step in &found.steps {
        let after = step.validate.map_or(f64::NAN, |(_, after)| after);
        println!("with {} at {}: {after:.2}", step.effect.entry.law.name, step.effect.place.at);
        for p in &step.parameters {
            println!("    {} = {:.4} {} [{:.4}, {:.4}]", p.name, p.value, p.unit, p.ci95.0, p.ci95.1);
        }
    }
    println!("{}; the completed model is a spec again:", found.status.name());
    found.completed.lines().filter(|l| l.contains("known:")).for_each(|l| println!("{l}"));
    Ok(())
}
