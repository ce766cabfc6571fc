//! Whether a law takes energy from the motion at all times.

use super::Law;
use super::graph::{LawGraph, jointly_linear};
use phisindy_expr::{Graph, Id, Names, Scratch, Unary};
use std::collections::HashMap;

/// Points at which a law is asked whether it gives energy.
const POINTS: usize = 400;
/// A smaller part of the largest power is rounding.
const ROUNDING: f64 = 1e-9;

impl Law {
    /// Whether the force is never along the velocity: its power `F v` is not negative, whatever the motion
    /// and whatever the parameters within their bounds. `Some(true)` is a proof by intervals, `Some(false)` a
    /// motion on which it gives energy; `None` where neither is found, and for a law with memory, which
    /// stores energy and may return it.
    ///
    /// ```
    /// use phisindy_phys::Law;
    /// let law = |force: &str, least: f64| {
    ///     let text = format!(r#"(name: "A", roles: {{ "v": "m/s" }}, parameters: {{ "c": (unit: "", within: ({least:?}, 1.0)) }}, force: "{force}")"#);
    ///     Law::read(&text).unwrap()
    /// };
    /// assert_eq!(law("c*v*abs(v)", 0.0).dissipates(), Some(true));
    /// assert_eq!(law("c*v*abs(v)", -1.0).dissipates(), Some(false));
    /// ```
    pub fn dissipates(&self) -> Option<bool> {
        let of = self.nodes();
        let force = of.force.filter(|_| !self.has_memory())?;
        // A force that does not know the velocity gives on the way back what it takes.
        let Some(v) = of.velocity.filter(|v| of.graph.uses(&[force], &[*v])) else { return Some(false) };
        if [1.0, -1.0].into_iter().all(|direction| self.resists(force, v, direction)) {
            return Some(true);
        }
        self.gives_energy(force, v).then_some(false)
    }

    /// Whether intervals show that the force is against a motion in this direction: the sum of its least
    /// parts, of which each is one parameter times its slope, is not negative. Taken apart so, no parameter
    /// stands twice.
    fn resists(&self, force: Id, v: Id, direction: f64) -> bool {
        let of = self.nodes();
        let (mut graph, mut names): (Graph, Names) = (of.graph.clone(), of.names.clone());
        // No name of the language has a space.
        let speed = graph.symbol(names.intern("the speed"));
        let sign = graph.constant(direction);
        let velocity = graph.mul(sign, speed);
        let with = HashMap::from([
            (v, velocity),
            (graph.unary(Unary::Abs, v), speed),
            (graph.unary(Unary::Sgn, v), sign),
        ]);
        let along = graph.replace(&[force], &with)[0];
        let against = graph.mul(sign, along);
        let bounds = self.parameters.iter().map(|(_, p)| p.within);
        let mut within: Vec<(Id, (f64, f64))> = of.parameters.iter().copied().zip(bounds).collect();
        within.push((speed, (0.0, f64::INFINITY)));
        let linear: Vec<Id> = jointly_linear(&mut graph, against, &of.parameters)
            .into_iter()
            .map(|k| of.parameters[k])
            .collect();
        let slopes = graph.gradient(against, &linear);
        let zero = graph.constant(0.0);
        let rest = graph.replace(&[against], &linear.iter().map(|&p| (p, zero)).collect())[0];
        let parts = linear.iter().zip(slopes).map(|(&p, slope)| graph.mul(p, slope));
        let parts: Vec<Id> = parts.chain([rest]).collect();
        parts.iter().map(|&part| graph.range(part, &within).0).sum::<f64>() >= 0.0
    }

    /// Whether there is a motion, with parameters within their bounds, on which the force is along the
    /// velocity.
    fn gives_energy(&self, force: Id, v: Id) -> bool {
        let of = self.nodes();
        let (symbols, tape) = LawGraph::program(&mut of.graph.clone(), &[force]);
        let mut scratch = Scratch::<1>::new(&tape);
        let mut powers = Vec::with_capacity(POINTS);
        for point in 0..POINTS {
            // Numbers of no meaning, of both signs and several sizes.
            let number = |k: usize| {
                let angle = (1 + point) as f64 * (1.0 + (k as f64).sqrt());
                2.0 * angle.sin() * angle.cos().powi(2)
            };
            let value = |(k, id): (usize, &Id)| {
                let (low, high) = self.bounds_of(*id).unwrap_or((-10.0, 10.0));
                number(k).clamp(low, high)
            };
            let values: Vec<f64> = symbols.iter().enumerate().map(value).collect();
            let speed = symbols.iter().position(|id| *id == v).map_or(0.0, |k| values[k]);
            scratch.at(values);
            powers.push(scratch.output(0)[0] * speed);
        }
        let largest = powers.iter().filter(|p| p.is_finite()).fold(0.0, |most: f64, p| most.max(p.abs()));
        powers.iter().any(|p| p.is_finite() && *p < -ROUNDING * largest)
    }
}
