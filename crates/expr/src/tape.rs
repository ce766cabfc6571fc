//! A graph compiled to a straight-line program over slots, and the scratch memory it runs in.

use crate::{Binary, Graph, Id, Names, Node, Symbol, Unary};
use pulp::Arch;
use std::sync::Arc;

/// Runs loops over lanes with the widest vectors that this machine has. What `work` calls must be inlined into it.
///
/// ```
/// let (a, mut b) = ([2.0; 64], [1.0; 64]);
/// phisindy_expr::wide(|| b.iter_mut().zip(&a).for_each(|(b, a)| *b += a * a));
/// assert_eq!(b, [5.0; 64]);
/// ```
#[inline]
pub fn wide<R>(work: impl FnOnce() -> R) -> R {
    Arch::new().dispatch(work)
}

/// One instruction.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Code {
    Unary { op: Unary, a: u32, out: u32 },
    Binary { op: Binary, a: u32, b: u32, out: u32 },
    Fused { op: Fused, a: u32, b: u32, c: u32, out: u32 },
}

/// A product and the sum that alone uses it, in one instruction: what a program does most. The product is rounded as if it stood alone (no
/// fused rounding), so that the bits are those of the two operations, on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fused {
    /// `c + a b`
    Plus,
    /// `c - a b`
    Minus,
    /// `a b - c`
    Less,
}

impl Fused {
    #[inline(always)]
    fn lanes<const N: usize>(self, a: &[f64; N], b: &[f64; N], c: &[f64; N], out: &mut [f64; N]) {
        match self {
            Fused::Plus => (0..N).for_each(|i| out[i] = c[i] + a[i] * b[i]),
            Fused::Minus => (0..N).for_each(|i| out[i] = c[i] - a[i] * b[i]),
            Fused::Less => (0..N).for_each(|i| out[i] = a[i] * b[i] - c[i]),
        }
    }
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
        let (mut slot, mut given) = (vec![u32::MAX; size], vec![false; size]);
        for (k, id) in inputs.iter().enumerate().filter(|(_, id)| id.index() < size) {
            slot[id.index()] = k as u32;
            given[id.index()] = true;
        }
        let steps = steps(graph, &order, outputs, &given);
        // Where each value is used last, so that its slot can serve again. Inputs, numbers and outputs are kept to the end.
        let mut last_use = vec![0usize; size];
        for (k, step) in steps.iter().enumerate() {
            step.operands().for_each(|a| last_use[a.index()] = k);
        }
        inputs.iter().filter(|id| id.index() < size).for_each(|id| last_use[id.index()] = usize::MAX);
        outputs.iter().for_each(|id| last_use[id.index()] = usize::MAX);

        let (mut code, mut constants, mut free) = (Vec::new(), Vec::new(), Vec::new());
        let mut slots = inputs.len() as u32;
        let mut fresh = || {
            slots += 1;
            slots - 1
        };
        for &id in order.iter().filter(|id| !given[id.index()]) {
            match graph.node(id) {
                Node::Symbol(symbol) => return Err(Unbound(symbol)),
                Node::Constant(bits) => {
                    slot[id.index()] = fresh();
                    last_use[id.index()] = usize::MAX;
                    constants.push((slot[id.index()], f64::from_bits(bits)));
                }
                _ => {}
            }
        }
        for (k, step) in steps.iter().enumerate() {
            let at = |id: Id| slot[id.index()];
            let out = free.pop().unwrap_or_else(&mut fresh);
            match step.form {
                Form::Unary(op, a) => code.push(Code::Unary { op, a: at(a), out }),
                Form::Fused(op, [a, b, c]) => code.push(Code::Fused { op, a: at(a), b: at(b), c: at(c), out }),
                // x^2 is x*x, x^3 is x*x*x: the commonest powers, without a call.
                Form::Binary(Binary::Pow, a, n) if graph.value(n) == Some(2.0) => {
                    code.push(Code::Binary { op: Binary::Mul, a: at(a), b: at(a), out });
                }
                Form::Binary(Binary::Pow, a, n) if graph.value(n) == Some(3.0) => {
                    let (a, square) = (at(a), fresh());
                    code.push(Code::Binary { op: Binary::Mul, a, b: a, out: square });
                    code.push(Code::Binary { op: Binary::Mul, a: square, b: a, out });
                    free.push(square);
                }
                Form::Binary(op, a, b) => code.push(Code::Binary { op, a: at(a), b: at(b), out }),
            }
            slot[step.id.index()] = out;
            let mut ended: Vec<Id> = step.operands().filter(|a| last_use[a.index()] == k).collect();
            ended.sort_unstable();
            ended.dedup();
            free.extend(ended.iter().map(|a| slot[a.index()]));
        }
        let outputs = outputs.iter().map(|id| slot[id.index()]).collect();
        Ok(Tape(Arc::new(Program { code, constants, inputs: inputs.len(), outputs, slots: slots as usize })))
    }

    /// Number of instructions: what one sample costs.
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
#[derive(Debug)]
pub struct Scratch<const N: usize> {
    tape: Tape,
    /// The slots, from [`Scratch::first`] on.
    memory: Vec<f64>,
}

/// Bytes of a line of the first cache, and of the widest vector: slots begin on such borders.
const LINE: usize = 64;

impl<const N: usize> Scratch<N> {
    /// Memory for one thread.
    pub fn new(tape: &Tape) -> Self {
        let mut scratch =
            Scratch { tape: tape.clone(), memory: vec![0.0; tape.0.slots * N + LINE / size_of::<f64>()] };
        for &(slot, value) in &tape.0.constants {
            scratch.slots()[slot as usize] = [value; N];
        }
        scratch
    }

    /// Where the slots begin in the memory.
    fn first(&self) -> usize {
        if N == 1 { 0 } else { self.memory.as_ptr().align_offset(LINE) }
    }

    fn slots(&mut self) -> &mut [[f64; N]] {
        let first = self.first();
        self.memory[first..].as_chunks_mut::<N>().0
    }

    /// The lanes of input `k`, in the order given to [`Tape::compile`].
    ///
    /// # Panics
    /// If there is no such input.
    pub fn input(&mut self, k: usize) -> &mut [f64; N] {
        assert!(k < self.tape.0.inputs, "input {k} of {}", self.tape.0.inputs);
        &mut self.slots()[k]
    }

    /// The lanes of output `k`, in the order given to [`Tape::compile`].
    ///
    /// # Panics
    /// If there is no such output.
    pub fn output(&self, k: usize) -> &[f64; N] {
        &self.memory[self.first()..].as_chunks::<N>().0[self.tape.0.outputs[k] as usize]
    }

    /// Evaluates every output from the inputs, with the widest vectors that this machine has.
    pub fn run(&mut self) {
        let first = self.first();
        let (code, slots) = (self.tape.0.code.as_slice(), self.memory[first..].as_chunks_mut::<N>().0);
        if N == 1 {
            run_one(code, slots);
        } else {
            wide(
                #[inline(always)]
                || run_lanes(code, slots),
            );
        }
    }
}

impl<const N: usize> Clone for Scratch<N> {
    /// The copy lies elsewhere, so that its slots may begin at another place of its memory.
    fn clone(&self) -> Self {
        let mut copy = Scratch::new(&self.tape);
        let first = copy.first();
        copy.memory[first..].iter_mut().zip(&self.memory[self.first()..]).for_each(|(to, from)| *to = *from);
        copy
    }
}

/// One sample: operands are copied, which is cheaper than proving that slots differ.
#[inline(always)]
fn run_one<const N: usize>(code: &[Code], slots: &mut [[f64; N]]) {
    for code in code {
        let value = |k: u32| [slots[k as usize][0]];
        let mut result = [0.0];
        let out = match *code {
            Code::Unary { op, a, out } => {
                op.lanes(&value(a), &mut result);
                out
            }
            Code::Binary { op, a, b, out } => {
                op.lanes(&value(a), &value(b), &mut result);
                out
            }
            Code::Fused { op, a, b, c, out } => {
                op.lanes(&value(a), &value(b), &value(c), &mut result);
                out
            }
        };
        slots[out as usize][0] = result[0];
    }
}

/// Many samples: each instruction is a loop over the lanes.
#[inline(always)]
fn run_lanes<const N: usize>(code: &[Code], slots: &mut [[f64; N]]) {
    for code in code {
        match *code {
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
            // Operands of a fused instruction differ, or it was not fused.
            Code::Fused { op, a, b, c, out } => {
                let [a, b, c, out] = disjoint(slots, [a, b, c, out]);
                op.lanes(a, b, c, out);
            }
        }
    }
}

/// Slots of one instruction: the compiler gives the result a slot of its own, so they never overlap.
#[inline(always)]
fn disjoint<const N: usize, const M: usize>(slots: &mut [[f64; N]], at: [u32; M]) -> [&mut [f64; N]; M] {
    slots
        .get_disjoint_mut(at.map(|k| k as usize))
        .expect("an instruction's operands and result have slots of their own")
}

/// A node to be computed, products fused into the sums that use them.
struct Step {
    id: Id,
    form: Form,
}

enum Form {
    Unary(Unary, Id),
    Binary(Binary, Id, Id),
    Fused(Fused, [Id; 3]),
}

impl Step {
    fn operands(&self) -> impl Iterator<Item = Id> + use<> {
        let (list, n) = match self.form {
            Form::Unary(_, a) => ([a, a, a], 1),
            Form::Binary(_, a, b) => ([a, b, b], 2),
            Form::Fused(_, all) => (all, 3),
        };
        list.into_iter().take(n)
    }
}

/// What is computed, in order.
fn steps(graph: &Graph, order: &[Id], outputs: &[Id], given: &[bool]) -> Vec<Step> {
    let size = order.last().map_or(0, |id| id.index() + 1);
    let mut uses = vec![0u32; size];
    outputs.iter().for_each(|id| uses[id.index()] += 1);
    for &id in order.iter().filter(|&&id| !given[id.index()]) {
        graph.operands(id).for_each(|a| uses[a.index()] += 1);
    }
    // A product that one sum alone uses, of factors that differ from each other and from the other summand.
    let product = |id: Id, other: Id| match graph.node(id) {
        Node::Binary(Binary::Mul, a, b)
            if uses[id.index()] == 1 && !given[id.index()] && a != b && a != other && b != other =>
        {
            Some([a, b, other])
        }
        _ => None,
    };
    let mut fused = vec![false; size];
    let mut steps = Vec::with_capacity(order.len());
    // From the end: whoever uses a product decides first.
    for &id in order.iter().rev().filter(|&&id| !given[id.index()]) {
        if fused[id.index()] {
            continue;
        }
        let form = match graph.node(id) {
            Node::Constant(_) | Node::Symbol(_) => continue,
            Node::Unary(op, a) => Form::Unary(op, a),
            Node::Binary(op, a, b) => {
                let found = match op {
                    Binary::Add => product(b, a).or_else(|| product(a, b)).map(|o| (Fused::Plus, o, o[2] == a)),
                    Binary::Sub => product(b, a)
                        .map(|o| (Fused::Minus, o, true))
                        .or_else(|| product(a, b).map(|o| (Fused::Less, o, false))),
                    _ => None,
                };
                match found {
                    Some((op, operands, second)) => {
                        fused[if second { b } else { a }.index()] = true;
                        Form::Fused(op, operands)
                    }
                    None => Form::Binary(op, a, b),
                }
            }
        };
        steps.push(Step { id, form });
    }
    steps.reverse();
    steps
}
