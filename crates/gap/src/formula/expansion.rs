//! The expansion of a smooth force about zero: what a linear or cubic model of the same rig would have for
//! numbers.

use phisindy_expr::{Graph, Id, Node, Scratch, Tape, Unary};
use phisindy_phys::Law;

/// The highest order.
const ORDER: usize = 3;

/// The terms of a law's force to third order in its displacement `x` and velocity `v`, with these parameters
/// (SI), as `12*x - 3.1*x^3`. `None` for a polynomial, which is its own expansion, and for a force with a
/// kink.
pub(crate) fn expansion(law: &Law, parameters: &[f64]) -> Option<String> {
    let of = law.nodes();
    let mut graph = of.graph.clone();
    let force = of.force?;
    let reached = graph.reachable(&[force]);
    let functions = reached.iter().filter_map(|&id| match graph.node(id) {
        Node::Unary(op, _) if op != Unary::Neg => Some(op),
        _ => None,
    });
    let functions: Vec<Unary> = functions.collect();
    if functions.is_empty() || functions.iter().any(|op| !op.row().kinks.is_empty()) {
        return None;
    }
    let quantities: Vec<(&str, Id)> = [("x", of.displacement), ("v", of.velocity)]
        .into_iter()
        .filter_map(|(n, id)| Some((n, id?)))
        .collect();
    let inputs: Vec<Id> = quantities.iter().map(|q| q.1).chain(of.parameters.iter().copied()).collect();
    let mut terms = Vec::new();
    for (powers, node) in derivatives(&mut graph, force, &quantities) {
        let tape = Tape::compile(&graph, &inputs, &[node]).ok()?;
        let mut scratch = Scratch::<1>::new(&tape);
        scratch.at(quantities.iter().map(|_| 0.0).chain(parameters.iter().copied()));
        let value = scratch.output(0)[0];
        if !value.is_finite() {
            return None;
        }
        let factorials: f64 = powers.iter().map(|&p| (1..=p).product::<usize>() as f64).product();
        terms.push((powers, value / factorials));
    }
    let said = terms.iter().filter(|t| t.1 != 0.0).map(|(powers, c)| {
        let factors = quantities
            .iter()
            .zip(powers)
            .filter(|(_, p)| **p > 0)
            .map(|((name, _), p)| if *p == 1 { format!("*{name}") } else { format!("*{name}^{p}") });
        (*c, factors.collect::<String>())
    });
    let mut out = String::new();
    for (c, factors) in said {
        let sign = match (out.is_empty(), c < 0.0) {
            (true, true) => "-",
            (true, false) => "",
            (false, true) => " - ",
            (false, false) => " + ",
        };
        out += &format!("{sign}{}{factors}", short(c.abs()));
    }
    (!out.is_empty()).then_some(out)
}

/// A number with three digits.
pub(super) fn short(x: f64) -> String {
    let rounded: f64 = format!("{x:.2e}").parse().unwrap_or(x);
    format!("{rounded}")
}

/// Every derivative up to the highest order, with the power of each quantity, lowest order first.
fn derivatives(graph: &mut Graph, force: Id, of: &[(&str, Id)]) -> Vec<(Vec<usize>, Id)> {
    let mut all = vec![(vec![0; of.len()], force)];
    let mut first = 0;
    for _ in 0..ORDER {
        let last = all.len();
        for k in first..last {
            let (powers, node) = all[k].clone();
            // Each mixed derivative once: a later quantity is not followed by an earlier one.
            let from = powers.iter().rposition(|p| *p > 0).unwrap_or(0);
            for q in from..of.len() {
                let mut powers = powers.clone();
                powers[q] += 1;
                let slope = graph.gradient(node, &[of[q].1])[0];
                all.push((powers, slope));
            }
        }
        first = last;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::expansion;
    use phisindy_phys::LawEntry;

    fn of(force: &str, parameters: &[f64]) -> Option<String> {
        let names = ["a", "b"][..parameters.len()]
            .iter()
            .map(|p| format!("\"{p}\": (unit: \"\", within: (0.0, 9.0))"));
        let names = names.collect::<Vec<_>>().join(", ");
        let text = format!(
            "(name: \"x\", roles: {{ \"x\": \"m\", \"v\": \"m/s\" }}, parameters: {{ {names} }}, force: \"{force}\")"
        );
        expansion(&LawEntry::read("law", &text).expect("a law").law, parameters)
    }

    #[test]
    fn series_of_textbooks() {
        assert_eq!(of("a*sin(b*x) + 0*v", &[2.0, 3.0]).as_deref(), Some("6*x - 9*x^3"));
        assert_eq!(of("a*v*exp(-x^2/b) ", &[2.0, 4.0]).as_deref(), Some("2*v - 0.5*x^2*v"));
        assert_eq!(of("a*tanh(v/b) + x^2", &[1.0, 2.0]).as_deref(), Some("0.5*v + 1*x^2 - 0.0417*v^3"));
    }

    #[test]
    fn what_has_none() {
        assert_eq!(of("a*x^5 + b*v", &[1.0, 1.0]), None);
        assert_eq!(of("a*abs(x)*exp(v*b)", &[1.0, 1.0]), None);
    }
}
