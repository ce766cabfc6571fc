//! A friction law as text becomes a value, its exact slope, LaTeX and Python:
//!
//! ```text
//! cargo run --release -p phisindy-expr --example slope
//! ```
#![allow(clippy::print_stdout)]

use phisindy_expr::{Graph, Names, Scratch, Tape, parse};

/// Stribeck friction: high at rest, lower when the body slides.
const LAW: &str = "(Fc + (Fs - Fc)*exp(-(v/vs)^2))*sgn(v)";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Text to a tree that knows its places in the text, tree to a graph in which equal parts are one node.
    let (mut graph, mut names) = (Graph::default(), Names::default());
    let force = graph.lower(&parse(LAW)?, |name| Some(names.intern(name))).map_err(|_| "an unknown name")?;
    let symbols = ["v", "Fc", "Fs", "vs"].map(|name| names.intern(name));
    let inputs = symbols.map(|symbol| graph.symbol(symbol));

    // Derivatives are nodes of the same graph: they are printed, simplified and run like all others.
    let slope = graph.gradient(force, &inputs[..1])[0];
    println!("force  {}", graph.text(force, &names));
    println!("slope  {}", graph.text(slope, &names));
    println!("LaTeX  {}\n", graph.latex(force, &names));

    // A tape is compiled once; each thread runs it with a scratch of its own.
    let tape = Tape::compile(&graph, &inputs, &[force, slope]).map_err(|_| "a name without a value")?;
    let mut scratch = Scratch::<1>::new(&tape);
    let mut at = |v: f64| {
        scratch.at([v, 1.2, 2.0, 0.02]);
        [0, 1].map(|k| scratch.output(k)[0])
    };
    println!("{:>8} {:>10} {:>12} {:>14}", "v (m/s)", "force (N)", "slope", "by difference");
    for v in [-0.05, -0.01, -0.001, 0.001, 0.01, 0.05] {
        let h = 1e-7;
        let difference = (at(v + h)[0] - at(v - h)[0]) / (2.0 * h);
        let [force, slope] = at(v);
        println!("{v:>8} {force:>10.6} {slope:>12.6} {difference:>14.6}");
    }
    println!("\nAt rest the force jumps, which no slope can say: the simulator finds the jump as an event.");
    Ok(())
}
