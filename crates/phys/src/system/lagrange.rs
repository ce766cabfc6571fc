//! Equations of motion from energies.
//!
//! With coordinates `q`, speeds `v`, kinetic energy `T = v' M v / 2 + ...`, potential `V`, dissipation `D` and forces
//! `F` along speeds `w(q, v)`, Lagrange's equations (H. Goldstein, Classical Mechanics, 3rd ed., 1.4 and 1.5) are
//!
//! ```text
//! M v' = sum F dw/dv - dV/dq - dD/dv + dT/dq - (d2T/dv dq) v - d2T/dv dt,        M = d2T/dv dv
//! ```
//!
//! `M = L D L'` is factored without pivots, as its definiteness allows (G. Golub, C. Van Loan, Matrix Computations,
//! 4th ed., 4.1), as operations of the graph: one program evaluates and differentiates it with everything else, and
//! entries that are zero cost nothing.

use phisindy_expr::{Graph, Id};

/// What energies say of a mechanism.
pub(crate) struct Energies {
    /// Coordinates and their speeds.
    pub(crate) coordinates: Vec<(Id, Id)>,
    pub(crate) kinetic: Id,
    pub(crate) potential: Id,
    pub(crate) dissipation: Id,
    /// Each force with its derivatives by the speeds: the direction in which it acts.
    pub(crate) forces: Vec<(Id, Vec<Id>)>,
    pub(crate) time: Id,
    /// A force that depends on one of them drives.
    pub(crate) inputs: Vec<Id>,
}

/// The equations of motion.
pub(crate) struct Equations {
    /// The rate of each speed.
    pub(crate) rates: Vec<Id>,
    /// The momentum of each coordinate, and what changes it in a second.
    pub(crate) momenta: Vec<(Id, Id)>,
    /// Of these the dissipation and the forces that nobody drives: friction above all.
    pub(crate) undriven: Vec<Id>,
    /// The rates that a unit force along each speed makes: the columns of the inverse of `M`.
    pub(crate) mobility: Vec<Vec<Id>>,
    /// The pivots of `M`: all are positive where the kinetic energy is.
    pub(crate) pivots: Vec<Id>,
}

/// Why energies give no equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoEquations {
    /// The kinetic energy is not quadratic in the speeds.
    NotQuadratic,
    /// The kinetic energy knows nothing of the speed of this coordinate.
    Massless(usize),
}

impl Energies {
    /// The equations of motion.
    ///
    /// # Errors
    /// The kinetic energy has no mass matrix that can be inverted.
    pub(crate) fn equations(&self, graph: &mut Graph) -> Result<Equations, NoEquations> {
        let (q, v): (Vec<Id>, Vec<Id>) = self.coordinates.iter().copied().unzip();
        let n = q.len();
        let momenta = graph.gradient(self.kinetic, &v);
        let mass: Vec<Vec<Id>> = momenta.iter().map(|&p| graph.gradient(p, &v)).collect();
        let entries: Vec<Id> = mass.iter().flatten().copied().collect();
        if graph.uses(&entries, &v) {
            return Err(NoEquations::NotQuadratic);
        }
        let by_place = graph.gradient(self.kinetic, &q);
        let [potential, dissipation] =
            [(self.potential, &q), (self.dissipation, &v)].map(|(of, by)| graph.gradient(of, by));
        let driven: Vec<bool> = self.forces.iter().map(|&(of, _)| graph.uses(&[of], &self.inputs)).collect();
        let (mut force, mut balances, mut undriven) =
            (Vec::with_capacity(n), Vec::with_capacity(n), Vec::with_capacity(n));
        for i in 0..n {
            let mut sum = graph.sub(by_place[i], potential[i]);
            sum = graph.sub(sum, dissipation[i]);
            let mut own = graph.neg(dissipation[i]);
            for ((of, direction), driven) in self.forces.iter().zip(&driven) {
                let part = graph.mul(*of, direction[i]);
                sum = graph.add(sum, part);
                own = if *driven { own } else { graph.add(own, part) };
            }
            undriven.push(own);
            balances.push((momenta[i], sum));
            // The momentum changes with the place, and with the time.
            let along: Vec<Id> = q.iter().copied().chain([self.time]).collect();
            let changes = graph.gradient(momenta[i], &along);
            for (j, &change) in changes.iter().enumerate() {
                let lost = if j < n { graph.mul(change, v[j]) } else { change };
                sum = graph.sub(sum, lost);
            }
            force.push(sum);
        }
        let factored = Factored::new(graph, &mass)?;
        let rates = factored.solved(graph, &force);
        let mobility = factored.inverse(graph);
        Ok(Equations { rates, momenta: balances, undriven, mobility, pivots: factored.pivots })
    }
}

/// The inverse of a mass matrix, by rows.
pub(crate) fn mobility(graph: &mut Graph, mass: &[Vec<Id>]) -> Result<Vec<Vec<Id>>, NoEquations> {
    Ok(Factored::new(graph, mass)?.inverse(graph))
}

/// `M = L D L'`: the pivots `D`, and the rows of `L` below its diagonal of ones.
struct Factored {
    pivots: Vec<Id>,
    lower: Vec<Vec<Id>>,
}

impl Factored {
    fn new(graph: &mut Graph, mass: &[Vec<Id>]) -> Result<Factored, NoEquations> {
        let mut all = Factored { pivots: vec![], lower: vec![] };
        for (i, of_mass) in mass.iter().enumerate() {
            // `(L D)_ij`, then `L_ij`.
            let mut scaled: Vec<Id> = Vec::with_capacity(i);
            for (j, &entry) in of_mass.iter().enumerate().take(i) {
                let mut entry = entry;
                for (k, &own) in scaled.iter().enumerate() {
                    let part = graph.mul(own, all.lower[j][k]);
                    entry = graph.sub(entry, part);
                }
                scaled.push(entry);
            }
            let row: Vec<Id> = scaled.iter().zip(&all.pivots).map(|(&s, &d)| graph.div(s, d)).collect();
            let mut pivot = of_mass[i];
            for (&s, &l) in scaled.iter().zip(&row) {
                let part = graph.mul(s, l);
                pivot = graph.sub(pivot, part);
            }
            if graph.value(pivot) == Some(0.0) {
                return Err(NoEquations::Massless(i));
            }
            all.pivots.push(pivot);
            all.lower.push(row);
        }
        Ok(all)
    }

    /// `M^-1`, by rows.
    fn inverse(&self, graph: &mut Graph) -> Vec<Vec<Id>> {
        let n = self.pivots.len();
        let (zero, one) = (graph.constant(0.0), graph.constant(1.0));
        let unit = |k: usize| (0..n).map(|i| if i == k { one } else { zero }).collect::<Vec<Id>>();
        (0..n).map(|k| self.solved(graph, &unit(k))).collect()
    }

    /// `M^-1 b`.
    fn solved(&self, graph: &mut Graph, b: &[Id]) -> Vec<Id> {
        let n = b.len();
        let mut x = b.to_vec();
        for i in 0..n {
            for j in 0..i {
                let part = graph.mul(self.lower[i][j], x[j]);
                x[i] = graph.sub(x[i], part);
            }
        }
        x.iter_mut().zip(&self.pivots).for_each(|(x, &pivot)| *x = graph.div(*x, pivot));
        for i in (0..n).rev() {
            for j in i + 1..n {
                let part = graph.mul(self.lower[j][i], x[j]);
                x[i] = graph.sub(x[i], part);
            }
        }
        x
    }
}
