//! Expressions rebuilt: with other nodes in the place of some, or in another graph.

use crate::graph::{Graph, Id, Node};
use crate::{Symbol, Unary};
use std::collections::HashMap;

impl Graph {
    /// Replaces nodes: every use of a key becomes its value, and everything above is rebuilt (and simplified
    /// again).
    ///
    /// ```
    /// # use phisindy_expr::*;
    /// # use std::collections::HashMap;
    /// # let (mut g, mut n) = (Graph::default(), Names::default());
    /// # let mut e = |g: &mut Graph, t: &str| g.lower(&parse(t).unwrap(), |s| Some(n.intern(s))).unwrap();
    /// let (f, sign, mode, one) = (e(&mut g, "a*sgn(v) + x"), e(&mut g, "sgn(v)"), e(&mut g, "s"), e(&mut g, "a*s + x"));
    /// assert_eq!(g.replace(&[f], &HashMap::from([(sign, mode)])), [one]);
    /// ```
    pub fn replace(&mut self, roots: &[Id], with: &HashMap<Id, Id>) -> Vec<Id> {
        let mut new: HashMap<Id, Id> = HashMap::new();
        let keys: Vec<Id> = with.keys().copied().collect();
        for id in self.reachable_above(roots, &keys) {
            let node = match (with.get(&id), self.node(id)) {
                (Some(&replacement), _) => replacement,
                (None, Node::Unary(op, a)) => self.unary(op, new[&a]),
                (None, Node::Binary(op, a, b)) => self.binary(op, new[&a], new[&b]),
                (None, _) => id,
            };
            new.insert(id, node);
        }
        roots.iter().map(|id| new[id]).collect()
    }

    /// The expression with every `rest(w)` replaced by a number: 0 where all contacts slide, 1 where all stick.
    ///
    /// ```
    /// # use phisindy_expr::*;
    /// # let (mut g, mut n) = (Graph::default(), Names::default());
    /// # let mut e = |g: &mut Graph, t: &str| g.lower(&parse(t).unwrap(), |s| Some(n.intern(s))).unwrap();
    /// let (friction, kinetic) = (e(&mut g, "(a + b*rest(v))*sgn(v)"), e(&mut g, "a*sgn(v)"));
    /// assert_eq!(g.with_rest(friction, 0.0), kinetic);
    /// ```
    pub fn with_rest(&mut self, root: Id, mode: f64) -> Id {
        let mode = self.constant(mode);
        let with = self.rests(&[root]).into_iter().map(|id| (id, mode)).collect();
        self.replace(&[root], &with)[0]
    }

    /// The nodes `rest(w)` of these expressions.
    pub fn rests(&self, roots: &[Id]) -> Vec<Id> {
        let rest = |id: &Id| matches!(self.node(*id), Node::Unary(Unary::Rest, _));
        self.reachable(roots).into_iter().filter(rest).collect()
    }

    /// Expressions of another graph, built (and simplified) in this one. `with` maps nodes of `other`, its
    /// symbols above all, to nodes of this graph.
    ///
    /// # Errors
    /// A symbol of `other` that `with` does not map: the two graphs need not share a table of names.
    ///
    /// ```
    /// # use phisindy_expr::*;
    /// # use std::collections::HashMap;
    /// let (mut law, mut own, mut names) = (Graph::default(), Names::default(), Names::default());
    /// let force = law.lower(&parse("c*v^2").unwrap(), |n| Some(own.intern(n))).unwrap();
    /// let symbol = |g: &mut Graph, n: &mut Names, name: &str| { let s = n.intern(name); g.symbol(s) };
    /// let (c, v) = (symbol(&mut law, &mut own, "c"), symbol(&mut law, &mut own, "v"));
    /// let mut model = Graph::default();
    /// let (drag, speed) = (symbol(&mut model, &mut names, "drag"), symbol(&mut model, &mut names, "y"));
    /// let copy = model.graft(&law, &[force], &HashMap::from([(c, drag), (v, speed)])).unwrap();
    /// assert_eq!(model.text(copy[0], &names), "drag*y^2");
    /// assert!(model.graft(&law, &[force], &HashMap::new()).is_err());
    /// ```
    pub fn graft(&mut self, other: &Graph, roots: &[Id], with: &HashMap<Id, Id>) -> Result<Vec<Id>, Symbol> {
        let mut new: HashMap<Id, Id> = HashMap::new();
        let keys: Vec<Id> = with.keys().copied().collect();
        for id in other.reachable_above(roots, &keys) {
            let node = match (with.get(&id), other.node(id)) {
                (Some(&replacement), _) => replacement,
                (None, Node::Unary(op, a)) => self.unary(op, new[&a]),
                (None, Node::Binary(op, a, b)) => self.binary(op, new[&a], new[&b]),
                (None, Node::Constant(bits)) => self.intern(Node::Constant(bits)),
                (None, Node::Symbol(symbol)) => return Err(symbol),
            };
            new.insert(id, node);
        }
        Ok(roots.iter().map(|id| new[id]).collect())
    }
}
