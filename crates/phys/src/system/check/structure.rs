//! The matrices of a structure to the rates of its points and modes.

use super::checker::Checker;
use super::energy::Mechanism;
use crate::system::equations::{Point, State};
use crate::text::spec::{Spec, StructureSpec, Text};
use phisindy_expr::Id;

impl Checker {
    /// Adds what the matrices of a spec say; nothing of a spec without.
    pub(super) fn structure(
        &mut self,
        spec: &Spec,
        allowed: &[&str],
        states: &mut [State],
        all: &mut Mechanism,
    ) {
        let Some(structure) = &spec.structure else { return };
        let place = |name: &str| states.iter().rposition(|s| s.name == name).unwrap_or(0);
        let pairs: Vec<(usize, usize)> =
            structure.pairs().map(|(x, v, _)| (place(&x.value), place(&v.value))).collect();
        let points = structure.points.len();
        let forces = self.forces(structure, allowed, states, &pairs[..points]);
        let modes = &structure.modes;
        let (zero, one) = (self.graph.constant(0.0), self.graph.constant(1.0));
        let node = |k: usize| states[k].node;
        for (i, &(_, speed)) in pairs.iter().enumerate() {
            let mut rate = zero;
            let mut add = |graph: &mut phisindy_expr::Graph, factor: f64, of: Id| {
                if factor != 0.0 {
                    let factor = graph.constant(factor);
                    let part = graph.mul(factor, of);
                    rate = graph.add(rate, part);
                }
            };
            for (j, &(x, v)) in pairs.iter().enumerate() {
                add(&mut self.graph, -modes.stiffness[i][j], node(x));
                add(&mut self.graph, -modes.damping[i][j], node(v));
            }
            for (force, direction) in &forces {
                let by = (0..points).map(|j| modes.mobility[i][j] * direction[j]).sum();
                add(&mut self.graph, by, *force);
            }
            all.rates.push((speed, rate));
        }
        for (j, &(_, speed)) in pairs[..points].iter().enumerate() {
            let own = self.graph.constant(modes.mobility[j][j]);
            let own = self.graph.div(one, own);
            all.inertia.push((speed, own));
            // What the matrices do is no force at the point: the balance holds what acts there from outside.
            let mut sum = zero;
            for (force, direction) in forces.iter().filter(|(_, direction)| direction[j] != 0.0) {
                let by = self.graph.constant(direction[j]);
                let part = self.graph.mul(by, *force);
                sum = self.graph.add(sum, part);
            }
            let momentum = self.graph.mul(own, node(speed));
            all.momenta.push((speed, momentum, sum));
            let (of, name) = (structure.coordinates.value.clone(), structure.points[j].name.value.clone());
            all.points.push(Point { speed, of, name });
            for (i, &(_, other)) in pairs.iter().enumerate().filter(|(i, _)| *i != j) {
                let ratio = modes.mobility[i][j] / modes.mobility[j][j];
                if ratio != 0.0 {
                    all.coupling.push((speed, other, self.graph.constant(ratio)));
                }
            }
        }
        for &(x, v) in &pairs[points..] {
            (states[x].hidden, states[v].hidden) = (true, true);
        }
    }

    /// Each force, and how much of it acts at each point.
    fn forces(
        &mut self,
        structure: &StructureSpec,
        allowed: &[&str],
        states: &[State],
        points: &[(usize, usize)],
    ) -> Vec<(Id, Vec<f64>)> {
        let speeds: Vec<Id> = points.iter().map(|&(_, v)| states[v].node).collect();
        let mut all = Vec::new();
        for (force, at) in &structure.forces {
            let named = structure.points.iter().position(|point| point.name.value == at.value);
            let direction = match named {
                Some(k) => (0..speeds.len()).map(|j| f64::from(u8::from(j == k))).collect(),
                None => match self.along(structure, at, allowed, &speeds) {
                    Some(direction) => direction,
                    None => continue,
                },
            };
            all.extend(self.expression(force, allowed).map(|force| (force, direction)));
        }
        all
    }

    /// The derivatives of a speed by those of the points.
    fn along(
        &mut self,
        structure: &StructureSpec,
        at: &Text,
        allowed: &[&str],
        speeds: &[Id],
    ) -> Option<Vec<f64>> {
        let names: Vec<&str> = structure.points.iter().map(|point| point.name.value.as_str()).collect();
        if phisindy_expr::parse(&at.value).is_ok_and(|ast| ast.nodes.len() == 1)
            && !allowed.contains(&at.value.as_str())
        {
            self.unknown_name(&at.value, at.span, "point", &names);
            return None;
        }
        let speed = self.expression(at, allowed)?;
        let slopes = self.graph.gradient(speed, speeds);
        let direction: Option<Vec<f64>> = slopes.iter().map(|&slope| self.graph.value(slope)).collect();
        let direction = direction.filter(|all| all.iter().any(|by| *by != 0.0));
        if direction.is_none() {
            self.error(format!("`{}` is no point and no speed of points", at.value), at.span, "")
                .help
                .push(format!("the points are {}", names.join(", ")));
        }
        direction
    }
}
