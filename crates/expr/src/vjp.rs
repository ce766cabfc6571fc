//! Derivatives by reverse mode. The adjoint of an expression consists of nodes of the same graph, so it is
//! shared, simplified, compiled and printed like any other expression, and can be differentiated again.

use crate::{Binary, Graph, Id, Node};
use std::collections::HashMap;

impl Graph {
    /// Vector-Jacobian product: for roots `f_i` and seeds `s_i`, the nodes of `sum_i s_i df_i/dw_j`, one
    /// for each `w_j` of `wrt` (any nodes; the nodes below them are constant).
    ///
    /// # Panics
    /// If the numbers of seeds and roots differ.
    pub fn vjp(&mut self, roots: &[Id], seeds: &[Id], wrt: &[Id]) -> Vec<Id> {
        assert_eq!(roots.len(), seeds.len(), "one seed for each root");
        let order = self.reachable_above(roots, wrt);
        let active = self.dependence(&order, wrt);
        let mut adjoint: HashMap<Id, Id> = HashMap::new();
        for (&root, &seed) in roots.iter().zip(seeds) {
            self.accumulate(&mut adjoint, root, seed);
        }
        for &id in order.iter().rev() {
            if !active[id.index()] || wrt.contains(&id) {
                continue;
            }
            let Some(bar) = adjoint.remove(&id) else { continue };
            match self.node(id) {
                Node::Constant(_) | Node::Symbol(_) => {}
                Node::Unary(op, a) => {
                    let slope = (op.row().slope)(self, a, id);
                    let share = self.share(bar, slope);
                    self.accumulate(&mut adjoint, a, share);
                }
                Node::Binary(Binary::Gate, a, condition) => {
                    let share = self.binary(Binary::Gate, bar, condition);
                    self.accumulate(&mut adjoint, a, share);
                }
                Node::Binary(op, a, b) => {
                    // Only the operands that depend on `wrt`: the slope by another one may be singular (ln
                    // of a negative base in x^2).
                    if active[a.index()] {
                        let slope = (op.row().slope_a)(self, a, b, id);
                        let share = self.share(bar, slope);
                        self.accumulate(&mut adjoint, a, share);
                    }
                    if active[b.index()] {
                        let slope = (op.row().slope_b)(self, a, b, id);
                        let share = self.share(bar, slope);
                        self.accumulate(&mut adjoint, b, share);
                    }
                }
            }
        }
        let zero = self.constant(0.0);
        wrt.iter().map(|w| adjoint.get(w).copied().unwrap_or(zero)).collect()
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

    fn accumulate(&mut self, adjoint: &mut HashMap<Id, Id>, id: Id, share: Id) {
        let sum = adjoint.get(&id).map_or(share, |&bar| self.add(bar, share));
        adjoint.insert(id, sum);
    }

    /// `bar * slope`. A closed gate gives 0 and keeps it, although slopes below the gate may be infinite
    /// there (`gate(ln(y), y)` at y = 0): where both can meet, zero wins in the product.
    fn share(&mut self, bar: Id, slope: Id) -> Id {
        let (a, b) = (self.traits(bar), self.traits(slope));
        let meet = (a.vanishing && b.singular) || (b.vanishing && a.singular);
        if meet { self.binary(Binary::Masked, bar, slope) } else { self.mul(bar, slope) }
    }
}
