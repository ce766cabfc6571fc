//! A spec is checked before anything runs: units find mistakes, and give coefficients their units.
//!
//! ```text
//! cargo run --release -p phisindy-phys --example units
//! ```
#![allow(clippy::print_stdout)]

use phisindy_phys::{Case, Diagnostic, Sources, check, spec};

/// A mass on a spring whose friction is not known; `RATE` is the known rate of its velocity.
const SPEC: &str = r#"(
    constants: { "m": (2.0, "kg"), "k": (800.0, "N/m"), "d": (1.5, "N*s/m"), "F0": (4.0, "N"), "W": (20.0, "rad/s") },
    states: { "x": "mm", "v": "m/s" },
    known: { "x": "v", "v": "RATE" },
    unknown: { "v": (factor: "-sgn(v)/m", candidates: ["1", "v^2", "x"]) },
    contacts: ["v"],
    data: [ Synthetic(truth: { "v": "-1.2*sgn(v)/m" }, start: { "x": 0.0, "v": 0.0 }, duration: 5.0, step: 0.01) ],
)"#;

/// Form first, then meaning; all mistakes come back together.
fn read(text: &str) -> Result<Case, Vec<Diagnostic>> {
    let source = Sources::default().add("case.ron", text);
    let (spec, _) = spec::read(text, source)?;
    check(&spec, source).map(|(case, _)| case)
}

fn main() {
    let rates = [
        ("the mass is forgotten", "-d*v - k*x + F0*cos(W*t)"),
        ("a name is misspelt", "(-d*v - k*x + FO*cos(W*t))/m"),
        ("as it should be", "(-d*v - k*x + F0*cos(W*t))/m"),
    ];
    for (what, rate) in rates {
        println!("{what}: dv/dt = {rate}");
        match read(&SPEC.replace("RATE", rate)) {
            Err(mistakes) => {
                for d in mistakes.iter().filter(|d| d.is_error()) {
                    println!("  error: {}", d.message);
                    d.help.iter().for_each(|line| println!("  help:  {line}"));
                }
            }
            Ok(case) => {
                // A coefficient has the unit that makes its term fit: here newtons, because the factor
                // divides by the mass.
                for term in &case.system.terms {
                    let unit = term.unit.map_or("any unit".to_owned(), |unit| unit.to_string());
                    println!("  the coefficient of {:<4} is in {unit}", term.candidate);
                }
            }
        }
        println!();
    }
}
