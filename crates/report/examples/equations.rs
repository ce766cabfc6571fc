//! A result as text: the equation in LaTeX with a table of coefficients, the number of figures of the report,
//! and the identified model as a C program.
//!
//! ```text
//! cargo run --release -p phisindy-report --example equations
//! ```
#![allow(clippy::print_stdout)]

use phisindy_learn::{LearnOptions, identify};
use phisindy_phys::{Diagnostic, Origin, Sources, check, spec};
use phisindy_report::export::{EXPORTERS, Subject, Writer, model_name};
use phisindy_report::spec_text::identified;
use phisindy_report::{Ending, Format, Input, Invocation, RunReport, html};
use phisindy_sim::synthesize;
use std::ops::ControlFlow;

/// A mass on a spring, with dry friction that is to be found.
const SPEC: &str = r#"(
    title: "A mass with friction",
    constants: { "m": (2.0, "kg"), "k": (8.0, "N/m") },
    states: { "x": "m", "v": "m/s" },
    known: { "x": "v", "v": "(-k*x + 2*cos(1.3*t))/m" },
    unknown: { "v": (factor: "-sgn(v)/m", candidates: ["1", "v^2", "x^2"]) },
    contacts: ["v"],
    data: [ Synthetic(truth: { "v": "-(0.5 + 0.2*v^2)*sgn(v)/m" }, start: { "x": 0.1, "v": 0.1 }, duration: 40.0,
                      step: 0.02, noise: Relative(0.01), seed: 1, measure: ["x"]) ],
)"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let source = Sources::default().add("mass.ron", SPEC);
    let words = |mistakes: Vec<Diagnostic>| mistakes[0].message.clone();
    let (spec, _) = spec::read(SPEC, source).map_err(words)?;
    let (case, _) = check(&spec, source).map_err(words)?;
    let plan = &case.records[0];
    let Origin::Synthetic(truth) = &plan.origin else { return Err("a measured record".into()) };
    let (record, _) = synthesize(plan, truth, &case.system, None, &|_| Err("no files here".into()))?;
    let records = [record];
    let found = identify(&case, &records, &LearnOptions::default(), &mut |_| ControlFlow::Continue(()))?;

    // The clock is the caller's: libraries do not read it.
    let ending = Ending { seconds: 0.0, stopped: None };
    let input =
        Input { name: "mass.ron", text: SPEC, spec: &spec, case: &case, records: &records, doubts: &[] };
    let report = RunReport::new(input, &found, ending);
    println!("{}", report.written(Format::Latex));

    let page = html::run(&report, &Invocation::default());
    let names: Vec<&str> = page.figures.iter().map(|(name, _)| name.as_str()).collect();
    println!("report.html: {} bytes, figures: {}", page.page.len(), names.join(", "));

    // The identified terms go into the text of the spec, which is then a model without unknown part.
    let text = identified(input, &found)?;
    let (spec, _) = spec::read(&text, source).map_err(words)?;
    let (case, _) = check(&spec, source).map_err(words)?;
    let subject = Subject::new(spec, &case, "identified.ron", 0, None).map_err(words)?;
    for exporter in EXPORTERS {
        let name = model_name(&subject, None);
        let lines = match exporter.write {
            Writer::Text(write) => write(&subject, &name).lines().count(),
            Writer::Fmu(write) => {
                write(&subject, &name).files.iter().map(|(_, text)| text.lines().count()).sum()
            }
            // It needs a robot.
            Writer::Robot => continue,
        };
        println!("{:<9} {lines:>4} lines: {}", exporter.name, exporter.about);
    }
    Ok(())
}
