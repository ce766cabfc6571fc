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
//!
//! Constraints `g(q, t) = 0` close loops. Their forces `J' l`, `J = dg/dq`, keep `g'' = -2 r g' - r^2 g`, so that what the
//! steps of an integrator or a start leave of `g` dies out (J. Baumgarte, Comput. Methods Appl. Mech. Eng. 1 (1972) 1-16).
//! With `X = M^-1 J'` and `S = J X` the multipliers solve `S l = -(J a + g'' without rates + 2 r g' + r^2 g)`, where `a` are the
//! rates without constraints; a force along a speed moves what `M^-1 - X S^-1 X'` says.

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
    /// What is zero, of coordinates and time.
    pub(crate) constraints: Vec<Id>,
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
    /// The rate of each constraint, by coordinates, speeds and time.
    pub(crate) constraint_rates: Vec<Id>,
}

/// How fast what is left of a constraint dies out (1/s). A convention: faster than rigs fall apart, slower than they shake.
const RETURN: f64 = 10.0;

/// Why energies give no equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoEquations {
    /// The kinetic energy is not quadratic in the speeds.
    NotQuadratic,
    /// The kinetic energy knows nothing of the speed of this coordinate.
    Massless(usize),
    /// This constraint asks nothing of what moves that those before it do not.
    Redundant(usize),
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
        let factored = Factored::new(graph, &mass).map_err(NoEquations::Massless)?;
        let rates = factored.solved(graph, &force);
        let mobility = factored.inverse(graph);
        let loops = Loops::new(graph, self, &factored)?;
        let rates = loops.held(graph, &rates, true);
        let mobility = mobility.iter().map(|column| loops.held(graph, column, false)).collect();
        let Loops { rates: constraint_rates, .. } = loops;
        let pivots = factored.pivots;
        Ok(Equations { rates, momenta: balances, undriven, mobility, pivots, constraint_rates })
    }
}

/// The constraints of a mechanism.
struct Loops {
    /// `g'`.
    rates: Vec<Id>,
    /// `g'' + 2 r g' + r^2 g` without the part `J v'`.
    bias: Vec<Id>,
    /// `J`, by rows.
    jacobian: Vec<Vec<Id>>,
    /// `X'`: the rates that a unit of each multiplier makes.
    moves: Vec<Vec<Id>>,
    /// `S`.
    feels: Factored,
}

impl Loops {
    fn new(graph: &mut Graph, of: &Energies, mass: &Factored) -> Result<Loops, NoEquations> {
        let (q, v): (Vec<Id>, Vec<Id>) = of.coordinates.iter().copied().unzip();
        let along: Vec<Id> = q.iter().copied().chain([of.time]).collect();
        // The rate of what depends on places and time alone.
        let rate = |graph: &mut Graph, value: Id| {
            let slopes = graph.gradient(value, &along);
            let by_time = slopes[q.len()];
            slopes.iter().zip(&v).fold(by_time, |sum, (&slope, &v)| {
                let part = graph.mul(slope, v);
                graph.add(sum, part)
            })
        };
        let (r2, rr) = (graph.constant(2.0 * RETURN), graph.constant(RETURN * RETURN));
        let (mut rates, mut bias) = (vec![], vec![]);
        for &g in &of.constraints {
            let first = rate(graph, g);
            let second = rate(graph, first);
            let (drift, offset) = (graph.mul(r2, first), graph.mul(rr, g));
            let back = graph.add(drift, offset);
            rates.push(first);
            bias.push(graph.add(second, back));
        }
        let jacobian: Vec<Vec<Id>> = of.constraints.iter().map(|&g| graph.gradient(g, &q)).collect();
        let moves: Vec<Vec<Id>> = jacobian.iter().map(|row| mass.solved(graph, row)).collect();
        let entries: Vec<Vec<Id>> =
            jacobian.iter().map(|row| moves.iter().map(|m| product(graph, row, m)).collect()).collect();
        let feels = Factored::new(graph, &entries).map_err(NoEquations::Redundant)?;
        Ok(Loops { rates, bias, jacobian, moves, feels })
    }

    /// What the constraints leave of these rates: with their bias, or of a force alone.
    fn held(&self, graph: &mut Graph, free: &[Id], with_bias: bool) -> Vec<Id> {
        let asked: Vec<Id> = (self.jacobian.iter().zip(&self.bias))
            .map(|(row, &bias)| {
                let moved = product(graph, row, free);
                if with_bias { graph.add(moved, bias) } else { moved }
            })
            .collect();
        let multipliers = self.feels.solved(graph, &asked);
        let mut held = free.to_vec();
        for (moves, &multiplier) in self.moves.iter().zip(&multipliers) {
            for (rate, &by) in held.iter_mut().zip(moves) {
                let part = graph.mul(by, multiplier);
                *rate = graph.sub(*rate, part);
            }
        }
        held
    }
}

fn product(graph: &mut Graph, a: &[Id], b: &[Id]) -> Id {
    let zero = graph.constant(0.0);
    a.iter().zip(b).fold(zero, |sum, (&a, &b)| {
        let part = graph.mul(a, b);
        graph.add(sum, part)
    })
}

/// The inverse of a mass matrix, by rows.
pub(crate) fn mobility(graph: &mut Graph, mass: &[Vec<Id>]) -> Result<Vec<Vec<Id>>, NoEquations> {
    Ok(Factored::new(graph, mass).map_err(NoEquations::Massless)?.inverse(graph))
}

/// `M = L D L'`: the pivots `D`, and the rows of `L` below its diagonal of ones.
struct Factored {
    pivots: Vec<Id>,
    lower: Vec<Vec<Id>>,
}

impl Factored {
    /// The index of a row whose pivot is zero is the error.
    fn new(graph: &mut Graph, mass: &[Vec<Id>]) -> Result<Factored, usize> {
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
                return Err(i);
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
