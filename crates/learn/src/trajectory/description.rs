//! How long it takes to write down a candidate: what it costs to believe it before any data are seen.

use phisindy_expr::{Id, Node};
use phisindy_phys::System;
use std::collections::HashSet;

/// What each term of the dictionary costs beside the price of any term, on the scale of chi square.
///
/// A candidate of `s` symbols out of an alphabet of `a` is believed in proportion to `a^-s` (Rissanen,
/// Automatica 14 (1978) 465-471; for formulas Bartlett et al., IEEE Trans. Evol. Comput. 28 (2024) 950-964).
/// The shortest candidates cost nothing here, so that a dictionary of one length is judged as if there were
/// no lengths.
pub(crate) fn descriptions(system: &System) -> Vec<f64> {
    let below = |t: usize| system.graph.reachable(&[system.terms[t].bare]);
    let mut alphabet: HashSet<Symbol> = HashSet::new();
    let mut lengths: Vec<f64> = Vec::with_capacity(system.terms.len());
    for t in 0..system.terms.len() {
        let nodes = below(t);
        alphabet.extend(nodes.iter().map(|&id| letter(system, id)));
        lengths.push(nodes.len() as f64);
    }
    let letters = (alphabet.len().max(1) as f64).ln();
    let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    lengths.iter().map(|length| 2.0 * letters * (length - shortest)).collect()
}

/// What is written for a node.
#[derive(PartialEq, Eq, Hash)]
enum Symbol {
    Number,
    Name(Id),
    Operation(String),
}

fn letter(system: &System, id: Id) -> Symbol {
    match system.graph.node(id) {
        Node::Constant(_) => Symbol::Number,
        Node::Symbol(_) => Symbol::Name(id),
        Node::Unary(op, _) => Symbol::Operation(format!("{op:?}")),
        Node::Binary(op, ..) => Symbol::Operation(format!("{op:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_phys::{SourceId, check, spec};

    fn of(candidates: &str) -> Vec<f64> {
        let text = format!(
            r#"(states: {{ "x": "", "y": "" }}, known: {{ "x": "0", "y": "0" }}, unknown: {{ "y": (factor: "1", candidates: [{candidates}]) }},
                data: [ Synthetic(truth: {{}}, start: {{ "x": 1.0 }}, duration: 1.0, step: 0.01, noise: None, seed: 1) ])"#
        );
        let (spec, _) = spec::read(&text, SourceId(0)).unwrap();
        descriptions(&check(&spec, SourceId(0)).unwrap().0.system)
    }

    #[test]
    fn long_candidates_cost_more_and_the_shortest_nothing() {
        // Letters: x, y, the product; x*y is three of them.
        let letters = 3_f64.ln();
        let found = of(r#""x", "y", "x*y""#);
        assert!(found.iter().zip([0.0, 0.0, 4.0 * letters]).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        assert!(of(r#""sin(x)", "cos(x)", "sin(y)""#).iter().all(|d| *d == 0.0));
    }
}
