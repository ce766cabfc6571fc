//! A graph compiled to a straight-line program over slots, and the scratch memory it runs in.

use crate::{Binary, Graph, Id, Names, Node, Symbol, Unary};
use std::sync::Arc;

/// One instruction: 12 bytes and a tag.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Code {
    Unary { op: Unary, a: u32, out: u32 },
    Binary { op: Binary, a: u32, b: u32, out: u32 },
}

/// A symbol that the roots use but that is no input of the tape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unbound(pub Symbol);

impl Unbound {
    /// The message, with the name.
    pub fn message(self, names: &Names) -> String {
        format!("`{}` has no value here", names.name(self.0))
    }
}

#[derive(Debug)]
struct Program {
    code: Vec<Code>,
    constants: Vec<(u32, f64)>,
    inputs: usize,
    outputs: Vec<u32>,
    slots: usize,
}

/// A compiled program: immutable, cheap to clone, shared between threads. Its memory is a [`Scratch`], which belongs to one thread.
#[derive(Clone, Debug)]
pub struct Tape(Arc<Program>);

impl Tape {
    /// Compiles `outputs` as functions of `inputs`. An input may be any node, not only a symbol: what lies below it is not evaluated.
    ///
    /// # Errors
    /// A symbol that is needed and is no input.
    pub fn compile(graph: &Graph, inputs: &[Id], outputs: &[Id]) -> Result<Tape, Unbound> {
        let order = graph.reachable_above(outputs, inputs);
        let size = order.last().map_or(0, |id| id.index() + 1);
        // Where each value is used last, so that its slot can serve again. Outputs are used to the end.
        let mut last_use = vec![0usize; size];
        for (k, &id) in order.iter().enumerate() {
            graph.operands(id).filter(|a| a.index() < size).for_each(|a| last_use[a.index()] = k);
        }
        let mut slot = vec![u32::MAX; size];
        for (k, id) in inputs.iter().enumerate() {
            if id.index() < size {
                slot[id.index()] = k as u32;
                last_use[id.index()] = usize::MAX;
            }
        }
        outputs.iter().for_each(|id| last_use[id.index()] = usize::MAX);

        let (mut code, mut constants, mut free) = (Vec::new(), Vec::new(), Vec::new());
        let mut slots = inputs.len() as u32;
        for (k, &id) in order.iter().enumerate() {
            if slot[id.index()] != u32::MAX {
                continue;
            }
            let node = graph.node(id);
            if let Node::Symbol(symbol) = node {
                return Err(Unbound(symbol));
            }
            // Constants are written once, when the scratch is made: their slots are never reused.
            let reused = if matches!(node, Node::Constant(_)) { None } else { free.pop() };
            let out = reused.unwrap_or_else(|| {
                slots += 1;
                slots - 1
            });
            slot[id.index()] = out;
            match node {
                Node::Constant(bits) => {
                    constants.push((out, f64::from_bits(bits)));
                    last_use[id.index()] = usize::MAX;
                }
                Node::Unary(op, a) => code.push(Code::Unary { op, a: slot[a.index()], out }),
                Node::Binary(op, a, b) => {
                    let (left, right) = (slot[a.index()], slot[b.index()]);
                    match graph.value(b).filter(|_| op == Binary::Pow) {
                        // x^2 is x*x, x^3 is x*x*x: the commonest powers, without a call.
                        Some(2.0) => code.push(Code::Binary { op: Binary::Mul, a: left, b: left, out }),
                        Some(3.0) => {
                            let square = slots;
                            slots += 1;
                            code.push(Code::Binary { op: Binary::Mul, a: left, b: left, out: square });
                            code.push(Code::Binary { op: Binary::Mul, a: square, b: left, out });
                        }
                        _ => code.push(Code::Binary { op, a: left, b: right, out }),
                    }
                }
                Node::Symbol(_) => {}
            }
            let mut operands: Vec<Id> = graph.operands(id).collect();
            operands.dedup();
            for a in operands {
                if last_use[a.index()] == k {
                    free.push(slot[a.index()]);
                }
            }
        }
        let outputs = outputs.iter().map(|id| slot[id.index()]).collect();
        Ok(Tape(Arc::new(Program { code, constants, inputs: inputs.len(), outputs, slots: slots as usize })))
    }

    /// Number of operations: what one sample costs.
    pub fn operations(&self) -> usize {
        self.0.code.len()
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.0.outputs.len()
    }

    /// Number of slots: what one lane of scratch memory holds.
    pub fn slots(&self) -> usize {
        self.0.slots
    }
}

/// Memory to run a [`Tape`] for `N` samples at once (1 for a simulation, 64 for data sets).
///
/// Write [`Scratch::input`], call [`Scratch::run`], read [`Scratch::output`]. Inputs keep their values between runs.
#[derive(Clone, Debug)]
pub struct Scratch<const N: usize> {
    tape: Tape,
    slots: Vec<[f64; N]>,
}

impl<const N: usize> Scratch<N> {
    /// Memory for one thread.
    pub fn new(tape: &Tape) -> Self {
        let mut slots = vec![[0.0; N]; tape.0.slots];
        for &(slot, value) in &tape.0.constants {
            slots[slot as usize] = [value; N];
        }
        Scratch { tape: tape.clone(), slots }
    }

    /// The lanes of input `k`, in the order given to [`Tape::compile`].
    ///
    /// # Panics
    /// If there is no such input.
    pub fn input(&mut self, k: usize) -> &mut [f64; N] {
        assert!(k < self.tape.0.inputs, "input {k} of {}", self.tape.0.inputs);
        &mut self.slots[k]
    }

    /// The lanes of output `k`, in the order given to [`Tape::compile`].
    ///
    /// # Panics
    /// If there is no such output.
    pub fn output(&self, k: usize) -> &[f64; N] {
        &self.slots[self.tape.0.outputs[k] as usize]
    }

    /// Evaluates every output from the inputs.
    pub fn run(&mut self) {
        let slots = self.slots.as_mut_slice();
        for code in &self.tape.0.code {
            match *code {
                // One sample: operands are copied, which is cheaper than proving that slots differ.
                Code::Unary { op, a, out } if N == 1 => {
                    let a = [slots[a as usize][0]];
                    let mut value = [0.0];
                    op.lanes(&a, &mut value);
                    slots[out as usize][0] = value[0];
                }
                Code::Binary { op, a, b, out } if N == 1 => {
                    let (a, b) = ([slots[a as usize][0]], [slots[b as usize][0]]);
                    let mut value = [0.0];
                    op.lanes(&a, &b, &mut value);
                    slots[out as usize][0] = value[0];
                }
                Code::Unary { op, a, out } => {
                    let [a, out] = disjoint(slots, [a, out]);
                    op.lanes(a, out);
                }
                Code::Binary { op, a, b, out } if a == b => {
                    let [a, out] = disjoint(slots, [a, out]);
                    op.lanes(a, a, out);
                }
                Code::Binary { op, a, b, out } => {
                    let [a, b, out] = disjoint(slots, [a, b, out]);
                    op.lanes(a, b, out);
                }
            }
        }
    }
}

/// Slots of one instruction: the compiler gives the result a slot of its own, so they never overlap.
fn disjoint<const N: usize, const M: usize>(slots: &mut [[f64; N]], at: [u32; M]) -> [&mut [f64; N]; M] {
    slots
        .get_disjoint_mut(at.map(|k| k as usize))
        .expect("an instruction's operands and result have slots of their own")
}
