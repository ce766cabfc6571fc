//! Expressions as a graph with sharing.

use crate::{Binary, Symbol, Unary};
use std::collections::HashMap;

/// Handle of a node, valid only in the graph that made it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Id(pub(crate) u32);

impl Id {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// One node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Node {
    /// A number, as its bits, so that nodes can be compared and hashed.
    Constant(u64),
    /// A name.
    Symbol(Symbol),
    /// A function of one argument.
    Unary(Unary, Id),
    /// An operation with two operands.
    Binary(Binary, Id, Id),
}

/// An arena in which equal expressions are one node. It only grows. Operands precede operations, so every
/// pass is one loop.
///
/// Operations are made by the constructors in `simplify.rs`, by rules that hold wherever the original is
/// finite.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    nodes: Vec<Node>,
    traits: Vec<Traits>,
    index: HashMap<Node, Id>,
}

/// Properties of a node that derivatives depend on.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Traits {
    /// Its value is zero where its gates are closed.
    pub(crate) vanishing: bool,
    /// It may be infinite or NaN where its symbols are finite (`ln`, a quotient, a power, ...) and no gate
    /// hides that.
    pub(crate) singular: bool,
}

impl Graph {
    /// The node behind a handle.
    pub fn node(&self, id: Id) -> Node {
        self.nodes[id.index()]
    }

    pub(crate) fn intern(&mut self, node: Node) -> Id {
        if let Some(&id) = self.index.get(&node) {
            return id;
        }
        let id = Id(self.nodes.len() as u32);
        self.traits.push(self.traits_of(node));
        self.nodes.push(node);
        self.index.insert(node, id);
        id
    }

    pub(crate) fn traits(&self, id: Id) -> Traits {
        self.traits[id.index()]
    }

    fn traits_of(&self, node: Node) -> Traits {
        match node {
            Node::Constant(_) | Node::Symbol(_) => Traits::default(),
            Node::Unary(op, a) => {
                let of = self.traits(a);
                let vanishing = of.vanishing && (op.row().value)(0.0) == 0.0;
                Traits { vanishing, singular: of.singular || op.row().singular }
            }
            // An open gate passes on what would spoil the result in any case; a closed one passes nothing.
            Node::Binary(Binary::Gate, ..) => Traits { vanishing: true, singular: false },
            Node::Binary(op, a, b) => {
                let (left, right) = (self.traits(a), self.traits(b));
                let vanishing = match op {
                    Binary::Mul | Binary::Masked => left.vanishing || right.vanishing,
                    Binary::Add | Binary::Sub => left.vanishing && right.vanishing,
                    Binary::Div => left.vanishing,
                    _ => false,
                };
                let own = match op {
                    // Divided by a number, or raised to a positive integer.
                    Binary::Div => self.value(b).is_none(),
                    Binary::Pow => self.value(b).is_none_or(|n| n < 0.0 || n.fract() != 0.0),
                    _ => false,
                };
                Traits { vanishing, singular: own || left.singular || right.singular }
            }
        }
    }

    /// A number; minus zero is zero.
    pub fn constant(&mut self, value: f64) -> Id {
        self.intern(Node::Constant((value + 0.0).to_bits()))
    }

    /// A name.
    pub fn symbol(&mut self, symbol: Symbol) -> Id {
        self.intern(Node::Symbol(symbol))
    }

    /// The number, if the node is one.
    pub fn value(&self, id: Id) -> Option<f64> {
        match self.node(id) {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// Operands of a node.
    pub fn operands(&self, id: Id) -> impl Iterator<Item = Id> + use<> {
        let (a, b) = match self.node(id) {
            Node::Constant(_) | Node::Symbol(_) => (None, None),
            Node::Unary(_, a) => (Some(a), None),
            Node::Binary(_, a, b) => (Some(a), Some(b)),
        };
        a.into_iter().chain(b)
    }

    /// All nodes below the roots, operands first, including the roots.
    pub fn reachable(&self, roots: &[Id]) -> Vec<Id> {
        self.reachable_above(roots, &[])
    }

    /// As [`Graph::reachable`], without the nodes below `leaves` (the leaves themselves are listed).
    pub fn reachable_above(&self, roots: &[Id], leaves: &[Id]) -> Vec<Id> {
        let size = roots.iter().map(|id| id.index() + 1).max().unwrap_or(0);
        let mut leaf = vec![false; size];
        leaves.iter().filter(|id| id.index() < size).for_each(|id| leaf[id.index()] = true);
        let mut marked = vec![false; size];
        roots.iter().for_each(|id| marked[id.index()] = true);
        for k in (0..size).rev() {
            if marked[k] && !leaf[k] {
                self.operands(Id(k as u32)).for_each(|a| marked[a.index()] = true);
            }
        }
        (0..size).filter(|&k| marked[k]).map(|k| Id(k as u32)).collect()
    }

    /// For each node of `order` (operands first), whether it is or uses one of `of`.
    pub(crate) fn dependence(&self, order: &[Id], of: &[Id]) -> Vec<bool> {
        let size = order.last().map_or(0, |id| id.index() + 1);
        let mut depends = vec![false; size];
        of.iter().filter(|id| id.index() < size).for_each(|id| depends[id.index()] = true);
        for &id in order {
            depends[id.index()] |= self.operands(id).any(|a| depends[a.index()]);
        }
        depends
    }

    /// Whether any of the roots uses any of the nodes.
    pub fn uses(&self, roots: &[Id], of: &[Id]) -> bool {
        let depends = self.dependence(&self.reachable(roots), of);
        roots.iter().any(|id| depends[id.index()])
    }

    /// All symbols that the roots use, in the order in which they were first made.
    pub fn symbols(&self, roots: &[Id]) -> Vec<Symbol> {
        let of = |id: Id| if let Node::Symbol(s) = self.node(id) { Some(s) } else { None };
        self.reachable(roots).into_iter().filter_map(of).collect()
    }

    /// The border between constant and varying nodes: every node that does not depend on `varying` but is
    /// an operand of a node below `roots` that does (or is a root itself), except numbers. Evaluated once
    /// per data set, these nodes are the inputs of the rest in each epoch.
    ///
    /// ```
    /// # use phisindy_expr::*;
    /// # let (mut g, mut n) = (Graph::default(), Names::default());
    /// # let mut e = |g: &mut Graph, t: &str| g.lower(&parse(t).unwrap(), |s| Some(n.intern(s))).unwrap();
    /// let (loss, feature, a) = (e(&mut g, "a*ln(abs(v)+1)"), e(&mut g, "ln(abs(v)+1)"), e(&mut g, "a"));
    /// assert_eq!(g.border(&[loss], &[a]), [feature]);
    /// ```
    pub fn border(&self, roots: &[Id], varying: &[Id]) -> Vec<Id> {
        let order = self.reachable_above(roots, varying);
        let depends = self.dependence(&order, varying);
        let mut at = vec![false; depends.len()];
        for &id in &order {
            if depends[id.index()] && !varying.contains(&id) {
                self.operands(id).for_each(|a| at[a.index()] = true);
            }
        }
        roots.iter().for_each(|id| at[id.index()] = true);
        order
            .into_iter()
            .filter(|&id| at[id.index()] && !depends[id.index()] && self.value(id).is_none())
            .collect()
    }
}
