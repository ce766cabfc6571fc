//! Derivatives, by reverse mode: the adjoint of an expression is more nodes of the same graph, so it is shared, simplified, compiled and
//! printed like everything else, and can be differentiated again.

use crate::{Binary, Graph, Id, Node};
use std::collections::HashMap;

/// What reaches each node from the roots, one sum for each gate it came through. A gate is applied last, at the end of the way: closed in
/// between, its 0 would still meet the infinite slopes below it (`gate(ln(y), y)` at y = 0), and 0 times infinity is NaN.
type Adjoint = HashMap<Id, Vec<(Option<Id>, Id)>>;

impl Graph {
    /// Vector-Jacobian product: for roots `f_i` and seeds `s_i`, the nodes of `sum_i s_i df_i/dw_j`, one for each `w_j` of `wrt`
    /// (any nodes: what lies below them is held constant).
    ///
    /// # Panics
    /// If there are not as many seeds as roots.
    pub fn vjp(&mut self, roots: &[Id], seeds: &[Id], wrt: &[Id]) -> Vec<Id> {
        assert_eq!(roots.len(), seeds.len(), "one seed for each root");
        let order = self.reachable_above(roots, wrt);
        let active = self.dependence(&order, wrt);
        let mut adjoint = Adjoint::new();
        for (&root, &seed) in roots.iter().zip(seeds) {
            self.accumulate(&mut adjoint, root, None, seed);
        }
        for &id in order.iter().rev() {
            if !active[id.index()] || wrt.contains(&id) {
                continue;
            }
            for (gate, bar) in adjoint.remove(&id).unwrap_or_default() {
                match self.node(id) {
                    Node::Constant(_) | Node::Symbol(_) => {}
                    Node::Unary(op, a) => {
                        let slope = (op.row().slope)(self, a, id);
                        let share = self.mul(bar, slope);
                        self.accumulate(&mut adjoint, a, gate, share);
                    }
                    Node::Binary(Binary::Gate, a, condition) => {
                        let both = gate.map_or(condition, |g| self.binary(Binary::Min, g, condition));
                        self.accumulate(&mut adjoint, a, Some(both), bar);
                    }
                    Node::Binary(op, a, b) => {
                        // Only the sides that matter: the other may be singular (ln of a negative base in x^2).
                        if active[a.index()] {
                            let slope = (op.row().slope_a)(self, a, b, id);
                            let share = self.mul(bar, slope);
                            self.accumulate(&mut adjoint, a, gate, share);
                        }
                        if active[b.index()] {
                            let slope = (op.row().slope_b)(self, a, b, id);
                            let share = self.mul(bar, slope);
                            self.accumulate(&mut adjoint, b, gate, share);
                        }
                    }
                }
            }
        }
        wrt.iter().map(|w| self.total(adjoint.get(w).map_or(&[], Vec::as_slice))).collect()
    }

    /// The derivatives of one expression with respect to nodes.
    ///
    /// ```
    /// # use phisindy_expr::*;
    /// # let (mut g, mut n) = (Graph::default(), Names::default());
    /// # let mut e = |g: &mut Graph, t: &str| g.lower(&parse(t).unwrap(), |s| Some(n.intern(s))).unwrap();
    /// let (f, x, df) = (e(&mut g, "x^3 + 2*x"), e(&mut g, "x"), e(&mut g, "2 + 3*x^2"));
    /// assert_eq!(g.gradient(f, &[x]), [df]);
    /// ```
    pub fn gradient(&mut self, root: Id, wrt: &[Id]) -> Vec<Id> {
        let one = self.constant(1.0);
        self.vjp(&[root], &[one], wrt)
    }

    fn accumulate(&mut self, adjoint: &mut Adjoint, id: Id, gate: Option<Id>, share: Id) {
        let parts = adjoint.entry(id).or_default();
        match parts.iter_mut().find(|part| part.0 == gate) {
            Some(part) => part.1 = self.add(part.1, share),
            None => parts.push((gate, share)),
        }
    }

    fn total(&mut self, parts: &[(Option<Id>, Id)]) -> Id {
        let zero = self.constant(0.0);
        parts.iter().fold(zero, |sum, &(gate, bar)| {
            let part = gate.map_or(bar, |g| self.binary(Binary::Gate, bar, g));
            self.add(sum, part)
        })
    }
}
