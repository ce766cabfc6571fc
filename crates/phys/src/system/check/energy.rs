//! Energies to the rates of their speeds.

use super::checker::Checker;
use crate::system::equations::{Constraint, Point};
use crate::system::lagrange::{Energies, Equations, NoEquations, mobility};
use crate::text::spec::{EnergySpec, Spec, Text};
use phisindy_expr::{Id, Scratch, Tape};

/// Far below the mobility of any body (1/kg), and its square is a number.
const LEAST_MOBILITY: f64 = 1e-30;

/// The rates that energies give, by the place of their state.
#[derive(Default)]
pub(super) struct Mechanism {
    /// Each speed with its rate.
    pub(super) rates: Vec<(usize, Id)>,
    /// Each speed with the momentum of its coordinate, and what changes that in a second.
    pub(super) momenta: Vec<(usize, Id, Id)>,
    /// Each speed with the part of that which nobody drives: friction above all.
    pub(super) undriven: Vec<(usize, Id)>,
    /// Each speed with the inertia that a force along it feels where all else follows.
    pub(super) inertia: Vec<(usize, Id)>,
    /// A speed, another one, and the rate of the latter for a rate of 1 that a force along the former makes.
    pub(super) coupling: Vec<(usize, usize, Id)>,
    pub(super) constraints: Vec<Constraint>,
    /// The points of a structure.
    pub(super) points: Vec<Point>,
}

impl Checker {
    /// What the energies of a spec say; nothing of a spec without.
    pub(super) fn mechanism(&mut self, spec: &Spec, allowed: &[&str], states: &[Id], time: Id) -> Mechanism {
        let Some(energy) = &spec.energy else { return Mechanism::default() };
        let place = |name: &Text| spec.states.iter().rposition(|(n, _)| n.value == name.value).unwrap_or(0);
        let of = |(q, (v, _)): &(Text, (Text, Text))| (place(q), place(v));
        let places: Vec<(usize, usize)> = energy.coordinates.iter().map(of).collect();
        for (name, _) in spec.known.iter().chain(&spec.inertia) {
            if spec.is_moved(&name.value) {
                self.error(
                    format!("the energies say how `{}` changes", name.value),
                    name.span,
                    "said once more",
                )
                .help
                .push("take it out here, or write a force along it in `energy.forces`".into());
            }
        }
        let (q, v): (Vec<Id>, Vec<Id>) = places.iter().map(|&(q, v)| (states[q], states[v])).unzip();
        let Some(energies) = self.energies(energy, allowed, (&q, &v), spec, time) else {
            return Mechanism::default();
        };
        match energies.equations(&mut self.graph) {
            Ok(equations) => {
                self.positive(energy, &equations, states);
                let constraint = |((text, &value), &rate): ((&Text, &Id), &Id)| Constraint {
                    text: text.value.clone(),
                    value,
                    rate,
                };
                let rates = &equations.constraint_rates;
                let constraints = energy.constraints.iter().zip(&energies.constraints).zip(rates);
                Mechanism {
                    constraints: constraints.map(constraint).collect(),
                    ..self.by_state(&equations, &places)
                }
            }
            Err(NoEquations::Redundant(k)) => {
                self.error("this constraint holds nothing", energy.constraints[k].span, "").help.push(
                    "it asks nothing of the coordinates that those before it do not: take it out".into(),
                );
                Mechanism::default()
            }
            Err(NoEquations::NotQuadratic) => {
                self.error("the kinetic energy is not quadratic in the speeds", energy.kinetic.span, "")
                    .help
                    .push(
                        "write it as in \"m*v^2/2\": a mass that depends on a speed has no equations here"
                            .into(),
                    );
                Mechanism::default()
            }
            Err(NoEquations::Massless(k)) => {
                let speed = &energy.coordinates[k].1.0;
                self.error(format!("no mass moves with `{}`", speed.value), speed.span, "not in `kinetic`")
                    .help
                    .push("add its kinetic energy, or make it a state with a rate of its own".into());
                Mechanism::default()
            }
        }
    }

    /// The inertias of a matrix: what a force along each speed feels where all else follows, and what follows.
    pub(super) fn inertia_matrix(
        &mut self,
        spec: &Spec,
        allowed: &[&str],
        diagonal: &[Option<Id>],
        all: &mut Mechanism,
    ) {
        let place = |name: &Text| spec.states.iter().rposition(|(n, _)| n.value == name.value);
        let mut entries: Vec<(usize, usize, Id)> = Vec::new();
        for (a, b, text) in &spec.between {
            let [i, j] = [a, b].map(|name| place(name).filter(|&k| diagonal[k].is_some()));
            let (Some(i), Some(j)) = (i, j) else {
                let missing = if i.is_none() { a } else { b };
                self.error(format!("`{}` has no inertia of its own", missing.value), missing.span, "")
                    .help
                    .push("a matrix has an entry for each state and itself: `\"v\": { \"v\": \"M+m\", \"w\": \"...\" }`".into());
                continue;
            };
            let Some(node) = self.expression(text, allowed) else { continue };
            let same = |e: &&(usize, usize, Id)| (e.0, e.1) == (j, i);
            match entries.iter().find(same) {
                Some(&(.., other)) if other != node => {
                    self.error("an inertia matrix is symmetric", text.span, "said otherwise before")
                        .help
                        .push("one of the two entries is enough".into());
                }
                Some(_) => {}
                None => entries.push((i, j, node)),
            }
        }
        let mut places: Vec<usize> = entries.iter().flat_map(|&(i, j, _)| [i, j]).collect();
        places.sort_unstable();
        places.dedup();
        let zero = self.graph.constant(0.0);
        let entry = |i: usize, j: usize| match i == j {
            true => diagonal[i].unwrap_or(zero),
            false => {
                let own = entries.iter().find(|e| (e.0, e.1) == (i, j) || (e.0, e.1) == (j, i));
                own.map_or(zero, |e| e.2)
            }
        };
        let mass: Vec<Vec<Id>> =
            places.iter().map(|&i| places.iter().map(|&j| entry(i, j)).collect()).collect();
        let Ok(mobility) = mobility(&mut self.graph, &mass) else {
            let span = spec.between[0].2.span;
            self.error("the inertia matrix has no inverse", span, "");
            return;
        };
        self.follow(&mobility, &places, false, all);
    }

    fn energies(
        &mut self,
        energy: &EnergySpec,
        allowed: &[&str],
        (q, v): (&[Id], &[Id]),
        spec: &Spec,
        time: Id,
    ) -> Option<Energies> {
        let zero = self.graph.constant(0.0);
        let lowered = |checker: &mut Checker, text: &Option<Text>| match text {
            Some(text) => checker.expression(text, allowed),
            None => Some(zero),
        };
        let kinetic = self.expression(&energy.kinetic, allowed);
        let potential = lowered(self, &energy.potential);
        let dissipation = lowered(self, &energy.dissipation);
        if let (Some(text), Some(potential)) = (&energy.potential, potential)
            && self.graph.uses(&[potential], v)
        {
            self.error("the potential energy depends on a speed", text.span, "")
                .help
                .push("what depends on speeds is `kinetic`, `dissipation` or one of `forces`".into());
        }
        let inputs: Vec<Id> = spec
            .inputs
            .iter()
            .map(|(name, _)| {
                let symbol = self.names.intern(&name.value);
                self.graph.symbol(symbol)
            })
            .collect();
        if let Some(kinetic) = kinetic
            && self.graph.uses(&[kinetic], &inputs)
        {
            self.error("the kinetic energy depends on an input", energy.kinetic.span, "")
                .help
                .push("its rate would be needed: take coordinates beside the moving base, whose acceleration is a force".into());
        }
        let mut forces = Vec::new();
        for (force, along) in &energy.forces {
            let (force, speed) = (self.expression(force, allowed)?, self.expression(along, allowed)?);
            let direction = self.graph.gradient(speed, v);
            let nowhere = direction.iter().all(|&d| self.graph.value(d) == Some(0.0));
            if nowhere || self.graph.uses(&direction, v) {
                self.error(format!("`{}` is no speed along which a force acts", along.value), along.span, "")
                    .help
                    .push(
                        "name a speed, or an expression that is linear in speeds, such as \"r*w - v\"".into(),
                    );
                continue;
            }
            forces.push((force, direction));
        }
        let mut constraints = Vec::new();
        for text in &energy.constraints {
            let zero = self.expression(text, allowed)?;
            let (moves, others) = (self.graph.uses(&[zero], q), [v, &inputs[..]].concat());
            if !moves || self.graph.uses(&[zero], &others) {
                self.error(format!("`{}` closes no loop", text.value), text.span, "")
                    .help
                    .push(
                        "write what is zero as coordinates, constants and `t` say it, such as \"l*cos(a) + r*cos(b) - x\""
                            .into(),
                    );
                return None;
            }
            constraints.push(zero);
        }
        let coordinates = q.iter().copied().zip(v.iter().copied()).collect();
        Some(Energies {
            coordinates,
            kinetic: kinetic?,
            potential: potential?,
            dissipation: dissipation?,
            forces,
            constraints,
            time,
            inputs,
        })
    }

    fn by_state(&mut self, equations: &Equations, places: &[(usize, usize)]) -> Mechanism {
        let mut all = Mechanism::default();
        for (i, &(_, speed)) in places.iter().enumerate() {
            all.rates.push((speed, equations.rates[i]));
            let (momentum, force) = equations.momenta[i];
            all.momenta.push((speed, momentum, force));
            all.undriven.push((speed, equations.undriven[i]));
        }
        let speeds: Vec<usize> = places.iter().map(|&(_, speed)| speed).collect();
        self.follow(&equations.mobility, &speeds, !equations.constraint_rates.is_empty(), &mut all);
        all
    }

    /// What a force along each speed feels, and what follows from its rate, by the inverse of the mass matrix.
    fn follow(&mut self, mobility: &[Vec<Id>], speeds: &[usize], held: bool, all: &mut Mechanism) {
        // Where constraints hold a speed for a moment, at a dead centre, it feels no force, and what follows from it is
        // told in parts of it: next to nothing, but not nothing.
        let least = self.graph.constant(if held { LEAST_MOBILITY } else { 0.0 });
        let one = self.graph.constant(1.0);
        for (i, &speed) in speeds.iter().enumerate() {
            let own = self.graph.add(mobility[i][i], least);
            all.inertia.push((speed, self.graph.div(one, own)));
            for (j, &other) in speeds.iter().enumerate() {
                let cross = mobility[i][j];
                if j != i && self.graph.value(cross) != Some(0.0) {
                    all.coupling.push((speed, other, self.graph.div(cross, own)));
                }
            }
        }
    }

    /// Warns of a kinetic energy that is not positive wherever it is looked at.
    fn positive(&mut self, energy: &EnergySpec, equations: &Equations, states: &[Id]) {
        let symbols = self.graph.symbols(&equations.pivots);
        let inputs: Vec<Id> = symbols.into_iter().map(|s| self.graph.symbol(s)).collect();
        let Ok(tape) = Tape::compile(&self.graph, &inputs, &equations.pivots) else { return };
        let mut scratch = Scratch::<1>::new(&tape);
        let mut at = |point: usize| {
            for (k, &id) in inputs.iter().enumerate() {
                // Constants that are to be found are positive as a rule; coordinates are looked at on both sides.
                let turn = (0.7 * (point * (k + 1)) as f64).sin();
                scratch.input(k)[0] = if states.contains(&id) { turn } else { 1.0 };
            }
            scratch.run();
            (0..equations.pivots.len()).all(|k| scratch.output(k)[0] > 0.0)
        };
        if !(0..8).any(&mut at) {
            self.warn("the kinetic energy is not positive", energy.kinetic.span, "")
                .help
                .push("no body has such a mass: look at the signs, and at constants that are zero".into());
        }
    }
}
