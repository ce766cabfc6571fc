//! The condition that the parameters of a law must meet, from the law's file. Example: the static level of
//! Stribeck friction is not below its kinetic level.

use crate::decisions::INSIDE;
use phisindy_expr::{Scratch, Tape};
use phisindy_phys::Law;

/// The value of the condition at these parameters, met where it is not negative; `None` if the law has none.
pub(crate) fn fulfilled(law: &Law, parameters: &[f64]) -> Option<f64> {
    Some(value_and_gradient(law, parameters)?.0)
}

/// Moves parameters along the gradient until the condition exceeds `INSIDE` times the level, which is the
/// first parameter. Returns them unchanged if they meet it already or the law has no condition.
pub(crate) fn inside(law: &Law, parameters: &[f64]) -> Vec<f64> {
    let level = parameters.first().map_or(0.0, |p| p.abs());
    let moved = || {
        let (value, gradient) = value_and_gradient(law, parameters)?;
        let steep: f64 = gradient.iter().map(|g| g * g).sum();
        let step = (INSIDE * level - value) / steep;
        let move_by = |((p, g), (_, of)): ((&f64, &f64), &(String, phisindy_phys::LawParameter))| {
            (p + step * g).clamp(of.within.0, of.within.1)
        };
        let moved = parameters.iter().zip(&gradient).zip(&law.parameters).map(move_by).collect();
        (step > 0.0 && step.is_finite()).then_some(moved)
    };
    moved().unwrap_or_else(|| parameters.to_vec())
}

fn value_and_gradient(law: &Law, parameters: &[f64]) -> Option<(f64, Vec<f64>)> {
    let of = law.nodes();
    let mut graph = of.graph.clone();
    let value = of.requirement?;
    let mut outputs = vec![value];
    outputs.extend(graph.gradient(value, &of.parameters));
    let mut scratch = Scratch::<1>::new(&Tape::compile(&graph, &of.parameters, &outputs).ok()?);
    scratch.at(parameters.iter().copied());
    Some((scratch.output(0)[0], (1..outputs.len()).map(|k| scratch.output(k)[0]).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(text: &str) -> Law {
        Law::read(text).expect("a law")
    }

    #[test]
    fn a_start_is_moved_inside_and_no_further() {
        let stribeck = law(include_str!("../../phys/laws/stribeck.ron"));
        assert_eq!(fulfilled(&stribeck, &[2.0, 1.0, 0.1]), Some(-1.0));
        // From the border and from outside it; the third parameter, a speed, does not enter the condition.
        for start in [[2.0, 2.0, 0.1], [2.0, 1.0, 0.1]] {
            let moved = inside(&stribeck, &start);
            assert!((moved[1] - moved[0] - 0.5).abs() < 1e-12 && moved[2] == 0.1, "{moved:?}");
            assert!((moved[1] + moved[0] - start[0] - start[1]).abs() < 1e-12);
        }
        assert_eq!(inside(&stribeck, &[1.0, 2.0, 0.1]), [1.0, 2.0, 0.1]);
        let coulomb = law(include_str!("../../phys/laws/coulomb.ron"));
        assert_eq!((fulfilled(&coulomb, &[1.0]), inside(&coulomb, &[1.0])), (None, vec![1.0]));
    }
}
