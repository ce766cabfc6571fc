//! Runs the paper's cases 1a, 1b and 7 and says what they cost:
//!
//! ```text
//! cargo run --release -p phisindy-sim --example stick_slip
//! ```
#![allow(clippy::print_stdout)]

use phisindy_phys::Model;
use phisindy_sim::{Automaton, Drive, Options, simulate};
use std::time::Instant;

/// Name, states with start values and rates, parameters with values.
type Case<'a> = (&'a str, Vec<(&'a str, f64, String)>, Vec<(&'a str, f64)>);

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let times: Vec<f64> = (0..5000).map(|k| 0.01 * f64::from(k)).collect();
    for (name, states, parameters) in cases() {
        // A model is text: names, and one rate for each state.
        let names: Vec<&str> = states.iter().map(|s| s.0).collect();
        let rates: Vec<&str> = states.iter().map(|s| s.2.as_str()).collect();
        let symbols: Vec<&str> = parameters.iter().map(|p| p.0).collect();
        let model = Model::build(&names, &[], &symbols, &rates)?;
        // Compiled once, run often: every sgn(w) became a switch.
        let automaton = Automaton::new(&model).map_err(|unbound| unbound.message(&model.names))?;
        let values: Vec<f64> = parameters.iter().map(|p| p.1).collect();
        let start: Vec<f64> = states.iter().map(|s| s.1).collect();
        let drive = Drive { inputs: &[], parameters: &values };

        let plain = Options::default();
        let with_all = Options { sensitivities: Some((0..values.len()).collect()), ..Options::default() };
        let run = simulate(&automaton, &drive, 0.0, &start, &times, &plain)?;
        println!(
            "case {name}: {} events, {} steps, {} rejected, {} evaluations",
            run.events.len(),
            run.steps,
            run.rejected,
            run.evaluations
        );
        for event in run.events.iter().take(3) {
            let switch = &automaton.switches[event.switch].text;
            println!("  t = {:9.6}: {switch} goes from {} to {}", event.time, event.from, event.to);
        }
        for (what, options) in [("states", &plain), ("and all derivatives", &with_all)] {
            // The best of many: what it costs when nothing else runs.
            let mut best = f64::INFINITY;
            for _ in 0..200 {
                let begin = Instant::now();
                simulate(&automaton, &drive, 0.0, &start, &times, options)?;
                best = best.min(begin.elapsed().as_secs_f64());
            }
            println!("  {what}: {:.2} ms", 1e3 * best);
        }
    }
    Ok(())
}

fn cases() -> Vec<Case<'static>> {
    let law =
        |base: &str, y: &str| format!("({base} + a*ln((|{y}|+eps)/V) + b*ln(c0 + V/(|{y}|+eps)))*sgn({y})");
    let one = |friction: &str| {
        vec![("x", 0.1, "y".to_owned()), ("y", 0.1, format!("(-c*y - k*x + F*cos(W*t) - {friction})/m"))]
    };
    let frame = [("m", 1.0), ("c", 0.1), ("k", 1.0), ("F", 1.0), ("W", 0.3), ("mu", 0.5)];
    let shape = [("a", 0.07), ("b", 0.09), ("V", 0.003), ("c0", 0.022), ("eps", 1e-6)];
    let first = "(-(c1+c2)*y1 + c2*y2 - (k1+k2)*x1 + k2*x2 + F*cos(W*t) - mu1*sgn(y1))/m1".to_owned();
    let second = format!("(c2*(y1-y2) + k2*(x1-x2) - {})/m2", law("mu2", "y2"));
    let two = vec![
        ("x1", 0.0, "y1".to_owned()),
        ("x2", 0.0, "y2".to_owned()),
        ("y1", 0.0, first),
        ("y2", 0.0, second),
    ];
    let masses = [
        ("m1", 1.0),
        ("m2", 1.0),
        ("c1", 0.1),
        ("c2", 0.1),
        ("k1", 1.0),
        ("k2", 1.0),
        ("F", 1.0),
        ("W", 0.6),
        ("mu1", 0.3),
        ("mu2", 0.3),
    ];
    vec![
        ("1a", one("mu*sgn(y)"), frame.to_vec()),
        ("1b", one(&law("mu", "y")), [&frame[..], &shape].concat()),
        ("7", two, [&masses[..], &shape].concat()),
    ]
}
