//! The terms of a formula that are laws of the catalogue.

use super::scale::Scale;
use super::shape::{Program, Shape};
use crate::place::{Effect, Place, fits};
use phisindy_phys::LawEntry;

/// Where forces are compared, in parts of the largest displacement and velocity.
const PARTS: [f64; 7] = [-1.0, -0.53, -0.11, 0.07, 0.29, 0.61, 1.0];
/// Forces that differ by a smaller part of the largest one are one force.
const SAME_FORCE: f64 = 1e-9;

/// The laws of the catalogue that the terms of a formula are, with their numbers; `None` where a term is none. `numbers`
/// are the coefficient and the inner numbers of each term. A law is a term if its force is the same on a grid of the
/// motion.
pub(super) fn known_laws(
    shapes: &[Shape],
    numbers: &[f64],
    scales: &[Scale; 2],
    place: &Place,
    catalogue: &[LawEntry],
) -> Option<Vec<Effect>> {
    let [x, v] = scales.each_ref().map(|scale| {
        let (low, high) = scale.range();
        PARTS.map(|part| part * low.abs().max(high.abs()))
    });
    let (x, v): (Vec<f64>, Vec<f64>) = x.iter().flat_map(|x| v.map(|v| (*x, v))).unzip();
    let mut numbers = numbers.iter().copied();
    let law = |shape: &Shape| {
        let coefficient = numbers.next()?;
        let inner: Vec<f64> = numbers.by_ref().take(shape.inner().len()).collect();
        let due = Program::new(*shape, scales)?.evaluate(&x, &v, &inner);
        let largest = due.iter().fold(0.0, |a: f64, f| a.max(f.abs()));
        let same = |force: &[f64]| force.iter().zip(&due).all(|(a, b)| (a - b).abs() <= SAME_FORCE * largest);
        let as_law = |entry: &LawEntry| {
            let law = &entry.law;
            let [linear] = law.linear_parameters()[..] else { return None };
            let (low, high) = law.parameters[linear].1.within;
            let each = law.parameters.iter().any(|(_, p)| p.each);
            let fitting = law.parameters.len() == 1 + inner.len() && !each && fits(law, place);
            if !fitting || coefficient < low || coefficient > high {
                return None;
            }
            let with = |coefficient: f64| {
                let mut all = inner.clone();
                all.insert(linear, coefficient);
                all
            };
            let force = Program::of(law)?.force(&x, &v, &with(1.0));
            same(&force).then(|| Effect::new(entry.clone(), place.clone(), with(coefficient)))
        };
        catalogue.iter().find_map(as_law)
    };
    shapes.iter().map(law).collect()
}

#[cfg(test)]
mod tests {
    use super::super::shape::{formula, shapes};
    use super::*;
    use crate::test_models::model;

    /// A cube of the displacement and a sign of the velocity are a cubic spring and dry friction; a friction that pushes, and
    /// an arc tangent, are no laws here.
    #[test]
    fn terms_that_are_laws_have_their_names() {
        let (base, _) = model(
            r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "N/m"), "m": (1.0, "kg") },
            known: { "x": "v", "v": "-k*x/m" }, inertia: { "v": "m" }, unknown: {},
            data: [ Synthetic(truth: {}, start: { "x": 1.0, "v": 0.0 }, duration: 30.0, step: 0.05, noise: Additive(0.02), seed: 1) ])"#,
        );
        let law = |id: &str, text: &str| LawEntry::read(id, text).expect("a law");
        let catalogue = [
            law("coulomb", include_str!("../../../phys/laws/coulomb.ron")),
            law("cubic-stiffness", include_str!("../../../phys/laws/cubic-stiffness.ron")),
            law("power-law-damping", include_str!("../../../phys/laws/power-law-damping.ron")),
        ];
        let scales = [vec![-1.0, 0.5, 2.0], vec![-0.4, 0.1, 0.3]].map(|v| Scale::new(&[v]));
        let all = shapes(true);
        let shape = |text: &str| {
            let is = |s: &&Shape| {
                formula("t", "t", "", &[**s], &scales)
                    .is_ok_and(|f| f.entry.law.force.as_deref() == Some(text))
            };
            *all.iter().find(is).unwrap_or_else(|| panic!("no {text}"))
        };
        let place = base.places().iter().find(|p| p.at == "v").expect("a place").clone();
        let said = |terms: &[&str], numbers: &[f64]| {
            let terms: Vec<Shape> = terms.iter().map(|t| shape(t)).collect();
            let found = known_laws(&terms, numbers, &scales, &place, &catalogue)?;
            Some(found.into_iter().map(|e| (e.entry.id, e.start)).collect::<Vec<_>>())
        };
        let named = |id: &str, numbers: &[f64]| (id.to_owned(), numbers.to_vec());
        assert_eq!(
            said(&["c*x^3", "c*sgn(v)"], &[5.0, 0.3]),
            Some(vec![named("cubic-stiffness", &[5.0]), named("coulomb", &[0.3])])
        );
        assert_eq!(said(&["c*x^3", "c*sgn(v)"], &[5.0, -0.3]), None);
        assert_eq!(said(&["c*atan(x/l)"], &[5.0, 0.3]), None);
    }
}
