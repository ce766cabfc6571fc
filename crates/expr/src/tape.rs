//! A graph compiled to a straight-line program over slots, and its scratch memory.

use crate::{Binary, Graph, Id, Names, Node, Symbol, Unary};
use pulp::Arch;
use std::sync::Arc;

/// Runs loops over lanes with the widest vectors of this machine. `work` must inline the functions that it
/// calls.
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
    Unary {
        op: Unary,
        a: u32,
        out: u32,
    },
    Binary {
        op: Binary,
        a: u32,
        b: u32,
        out: u32,
    },
    /// Products added to or subtracted from a value: `count` pairs of factors in [`Program::factors`], from
    /// `first` on. A chain of products alone starts at -0, which changes no bit of the first one.
    Chain {
        op: Chain,
        count: u8,
        first: u32,
        start: u32,
        out: u32,
    },
}

/// Products and the sums that only they enter, in one instruction: the most frequent operations. Each
/// product and each sum is rounded separately (no fused rounding), so the bits are those of the single
/// operations on every machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Chain {
    /// `c + a b + ...`
    Plus,
    /// `c - a b - ...`
    Minus,
    /// `a b - c`, one product only
    Less,
}

/// The maximum number of products in one instruction.
const LONGEST: usize = 6;

impl Chain {
    #[inline(always)]
    fn lanes<const N: usize, const K: usize>(
        self,
        factors: [[&[f64; N]; 2]; K],
        start: &[f64; N],
        out: &mut [f64; N],
    ) {
        match self {
            Chain::Plus => (0..N).for_each(|i| {
                let mut sum = start[i];
                (0..K).for_each(|k| sum += factors[k][0][i] * factors[k][1][i]);
                out[i] = sum;
            }),
            Chain::Minus => (0..N).for_each(|i| {
                let mut sum = start[i];
                (0..K).for_each(|k| sum -= factors[k][0][i] * factors[k][1][i]);
                out[i] = sum;
            }),
            Chain::Less => (0..N).for_each(|i| out[i] = factors[0][0][i] * factors[0][1][i] - start[i]),
        }
    }
}

/// A symbol of the roots that is no input of the tape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unbound(pub Symbol);

impl Unbound {
    /// The message, with the name.
    pub fn message(self, names: &Names) -> String {
        format!("`{}` has no value here", names.name(self.0))
    }
}

/// The cost of a tape for each sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cost {
    /// Instructions, each a loop over the lanes.
    pub instructions: usize,
    /// Additions, multiplications, divisions and roots: see [`crate::ops::UnaryRow::flops`].
    pub flops: usize,
    /// Numbers that instructions read.
    pub loads: usize,
    /// Numbers that instructions write.
    pub stores: usize,
}

impl Cost {
    fn add(&mut self, flops: usize, loads: usize) {
        self.instructions += 1;
        self.flops += flops;
        self.loads += loads;
        self.stores += 1;
    }

    /// The cost of this tape and another one after it, repeated `times` times.
    #[must_use]
    pub fn with(self, other: Cost, times: usize) -> Cost {
        Cost {
            instructions: times * (self.instructions + other.instructions),
            flops: times * (self.flops + other.flops),
            loads: times * (self.loads + other.loads),
            stores: times * (self.stores + other.stores),
        }
    }
}

#[derive(Debug)]
struct Program {
    code: Vec<Code>,
    factors: Vec<[u32; 2]>,
    constants: Vec<(u32, f64)>,
    inputs: usize,
    outputs: Vec<u32>,
    slots: usize,
}

mod lanes;

use lanes::Lanes;

/// A compiled program: immutable, cheap to clone, shared between threads. Its memory is a [`Scratch`] of
/// one thread.
///
/// ```
/// use phisindy_expr::{Graph, Names, Scratch, Tape, parse};
/// let (mut graph, mut names) = (Graph::default(), Names::default());
/// let drag = graph.lower(&parse("d*v*|v|").unwrap(), |name| Some(names.intern(name))).unwrap();
/// let inputs = ["d", "v"].map(|name| graph.symbol(names.get(name).unwrap()));
/// let tape = Tape::compile(&graph, &inputs, &[drag]).unwrap();
/// let mut scratch = Scratch::<1>::new(&tape);
/// scratch.at([0.5, -2.0]);
/// assert_eq!(scratch.output(0)[0], -2.0);
/// ```
#[derive(Clone, Debug)]
pub struct Tape(Arc<Program>);

impl Tape {
    /// Compiles `outputs` as functions of `inputs`. An input may be any node; the nodes below it are not
    /// evaluated.
    ///
    /// # Errors
    /// A symbol in the outputs that is no input.
    pub fn compile(graph: &Graph, inputs: &[Id], outputs: &[Id]) -> Result<Tape, Unbound> {
        let order = graph.reachable_above(outputs, inputs);
        let size = order.last().map_or(0, |id| id.index() + 1);
        let (mut slot, mut given) = (vec![u32::MAX; size], vec![false; size]);
        for (k, id) in inputs.iter().enumerate().filter(|(_, id)| id.index() < size) {
            slot[id.index()] = k as u32;
            given[id.index()] = true;
        }
        let steps = steps(graph, &order, outputs, &given);
        // The last use of each value, after which its slot is free. Inputs, numbers and outputs keep their
        // slots.
        let mut last_use = vec![0usize; size];
        for (k, step) in steps.iter().enumerate() {
            step.operands().iter().for_each(|a| last_use[a.index()] = k);
        }
        inputs.iter().filter(|id| id.index() < size).for_each(|id| last_use[id.index()] = usize::MAX);
        outputs.iter().for_each(|id| last_use[id.index()] = usize::MAX);

        let (mut code, mut factors, mut constants, mut free) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut slots = inputs.len() as u32;
        let mut fresh = || {
            slots += 1;
            slots - 1
        };
        let mut nothing = None;
        if steps.iter().any(|step| matches!(step.form, Form::Chain(_, _, None))) {
            nothing = Some(fresh());
            constants.extend(nothing.map(|slot| (slot, -0.0)));
        }
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
            match &step.form {
                &Form::Unary(op, a) => code.push(Code::Unary { op, a: at(a), out }),
                Form::Chain(op, pairs, start) => {
                    let (count, first) = (pairs.len() as u8, factors.len() as u32);
                    factors.extend(pairs.iter().map(|pair| pair.map(at)));
                    let start = start.map(at).or(nothing).unwrap_or_else(|| unreachable!("a slot for -0"));
                    code.push(Code::Chain { op: *op, count, first, start, out });
                }
                &Form::Binary(Binary::Pow, a, n) if whole_power(graph, n).is_some() => {
                    let n = whole_power(graph, n).unwrap_or_default();
                    free.extend(multiplied((at(a), n, out), &mut code, &mut fresh));
                }
                &Form::Binary(op, a, b) => code.push(Code::Binary { op, a: at(a), b: at(b), out }),
            }
            slot[step.id.index()] = out;
            let mut ended: Vec<Id> =
                step.operands().into_iter().filter(|a| last_use[a.index()] == k).collect();
            ended.sort_unstable();
            ended.dedup();
            free.extend(ended.iter().map(|a| slot[a.index()]));
        }
        let outputs = outputs.iter().map(|id| slot[id.index()]).collect();
        let program =
            Program { code, factors, constants, inputs: inputs.len(), outputs, slots: slots as usize };
        program.assert_sound();
        Ok(Tape(Arc::new(program)))
    }

    /// Number of instructions per sample.
    pub fn operations(&self) -> usize {
        self.0.code.len()
    }

    /// The full cost of one sample: a product and the sum that it enters are two operations.
    ///
    /// ```
    /// use phisindy_expr::{Cost, Graph, Names, Tape, parse};
    /// let (mut graph, mut names) = (Graph::default(), Names::default());
    /// let f = graph.lower(&parse("a*b + c").unwrap(), |name| Some(names.intern(name))).unwrap();
    /// let inputs = ["a", "b", "c"].map(|name| graph.symbol(names.get(name).unwrap()));
    /// let cost = Tape::compile(&graph, &inputs, &[f]).unwrap().cost();
    /// assert_eq!(cost, Cost { instructions: 1, flops: 2, loads: 3, stores: 1 });
    /// ```
    pub fn cost(&self) -> Cost {
        let mut cost = Cost::default();
        for code in &self.0.code {
            match *code {
                Code::Unary { op, .. } => cost.add(op.row().flops as usize, 1),
                Code::Binary { op, .. } => cost.add(op.row().flops as usize, 2),
                Code::Chain { count, .. } => cost.add(2 * usize::from(count), 2 * usize::from(count) + 1),
            }
        }
        cost
    }

    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        self.0.outputs.len()
    }

    /// Number of slots: the scratch memory of one lane.
    pub fn slots(&self) -> usize {
        self.0.slots
    }
}

impl Program {
    /// Asserts the conditions of `lanes`.
    fn assert_sound(&self) {
        for code in &self.code {
            let (reads, out) = match *code {
                Code::Unary { a, out, .. } => (vec![a], out),
                Code::Binary { a, b, out, .. } => (vec![a, b], out),
                Code::Chain { count, first, start, out, .. } => {
                    let pairs = &self.factors[first as usize..][..usize::from(count)];
                    assert!((1..=LONGEST).contains(&pairs.len()));
                    (pairs.iter().flatten().copied().chain([start]).collect(), out)
                }
            };
            let slot = |k: u32| (k as usize) < self.slots;
            assert!(reads.iter().all(|&k| slot(k) && k != out) && slot(out) && out as usize >= self.inputs);
        }
        assert!(self.outputs.iter().all(|&k| (k as usize) < self.slots));
    }
}

/// Memory to run a [`Tape`] for `N` samples at once (1 for a simulation, 64 for data sets).
///
/// Write [`Scratch::input`], call [`Scratch::run`], read [`Scratch::output`]. Inputs keep their values
/// between runs.
#[derive(Debug)]
pub struct Scratch<const N: usize> {
    tape: Tape,
    /// The slots, from [`Scratch::first`] on.
    memory: Vec<f64>,
}

/// Bytes of a cache line, and of the widest vector: slots are aligned to it.
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

    /// The offset of the first slot in the memory.
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

    /// Evaluates every output from the inputs, with the widest vectors of this machine.
    #[inline]
    pub fn run(&mut self) {
        self.run_on(&[]);
    }

    /// The same, with the first inputs copied from `head`: a copy is cheaper than operands in two places.
    ///
    /// # Panics
    /// If `head` has more rows than the tape has inputs.
    pub fn run_on(&mut self, head: &[[f64; N]]) {
        assert!(head.len() <= self.tape.0.inputs, "{} inputs of {}", head.len(), self.tape.0.inputs);
        let first = self.first();
        let (program, slots) = (&*self.tape.0, self.memory[first..].as_chunks_mut::<N>().0);
        slots[..head.len()].copy_from_slice(head);
        wide(
            #[inline(always)]
            || run(program, slots),
        );
    }
}

impl Scratch<1> {
    /// Evaluates every output at these values of the inputs, in order.
    ///
    /// # Panics
    /// If there are more values than inputs.
    pub fn at(&mut self, inputs: impl IntoIterator<Item = f64>) -> &mut Self {
        inputs.into_iter().enumerate().for_each(|(k, value)| self.input(k)[0] = value);
        self.run();
        self
    }
}

/// Each instruction is a loop over the lanes.
#[inline(always)]
fn run<const N: usize>(program: &Program, slots: &mut [[f64; N]]) {
    let lanes = Lanes::new(program.slots, &program.factors, slots);
    for code in &program.code {
        match *code {
            Code::Unary { op, a, out } => op.lanes(lanes.read(a), lanes.write(out)),
            Code::Binary { op, a, b, out } => op.lanes(lanes.read(a), lanes.read(b), lanes.write(out)),
            Code::Chain { op, count, first, start, out } => {
                let (start, result) = (lanes.read(start), lanes.write(out));
                let pair = |k: u32| lanes.factors(first + k);
                match count {
                    1 => op.lanes([pair(0)], start, result),
                    2 => op.lanes([pair(0), pair(1)], start, result),
                    3 => op.lanes([pair(0), pair(1), pair(2)], start, result),
                    4 => op.lanes([pair(0), pair(1), pair(2), pair(3)], start, result),
                    5 => op.lanes([pair(0), pair(1), pair(2), pair(3), pair(4)], start, result),
                    _ => op.lanes([pair(0), pair(1), pair(2), pair(3), pair(4), pair(5)], start, result),
                }
            }
        }
    }
}

/// A number as the exponent of a power that is made of products.
fn whole_power(graph: &Graph, exponent: Id) -> Option<u32> {
    let n = graph.value(exponent)?;
    ((2.0..=MOST_FACTORS).contains(&n) && n.fract() == 0.0).then_some(n as u32)
}

/// The largest whole exponent for which [`crate::ops`] multiplies: beyond it the library is more accurate.
const MOST_FACTORS: f64 = 64.0;

/// Products that make `x^n`: of the squares of `x`, by the binary digits of `n`, lowest first. So does a
/// call, with the same bits; products are as wide as the vectors of the machine. Returns the slots that are
/// free afterwards.
fn multiplied(
    (x, n, out): (u32, u32, u32),
    code: &mut Vec<Code>,
    fresh: &mut impl FnMut() -> u32,
) -> Vec<u32> {
    let (mut square, mut rest, mut product) = (x, n, None);
    let mut used = Vec::new();
    let mut next = |last: bool| {
        let slot = if last { out } else { fresh() };
        used.extend((!last).then_some(slot));
        slot
    };
    loop {
        if rest & 1 == 1 {
            product = Some(product.map_or(square, |a| {
                let to = next(rest == 1);
                code.push(Code::Binary { op: Binary::Mul, a, b: square, out: to });
                to
            }));
        }
        rest >>= 1;
        if rest == 0 {
            return used;
        }
        let to = next(rest == 1 && product.is_none());
        code.push(Code::Binary { op: Binary::Mul, a: square, b: square, out: to });
        square = to;
    }
}

/// An operation of the program, with products joined to the sums that they enter.
struct Step {
    id: Id,
    form: Form,
}

enum Form {
    Unary(Unary, Id),
    Binary(Binary, Id, Id),
    /// Products, and the value that they are added to or subtracted from, if any.
    Chain(Chain, Vec<[Id; 2]>, Option<Id>),
}

impl Step {
    fn operands(&self) -> Vec<Id> {
        match &self.form {
            Form::Unary(_, a) => vec![*a],
            Form::Binary(_, a, b) => vec![*a, *b],
            Form::Chain(_, pairs, start) => pairs.iter().flatten().copied().chain(*start).collect(),
        }
    }
}

/// The operations in the order of computation.
fn steps(graph: &Graph, order: &[Id], outputs: &[Id], given: &[bool]) -> Vec<Step> {
    let mut uses = vec![0u32; given.len()];
    outputs.iter().for_each(|id| uses[id.index()] += 1);
    for &id in order.iter().filter(|id| !given[id.index()]) {
        graph.operands(id).for_each(|a| uses[a.index()] += 1);
    }
    let alone = |id: Id| uses[id.index()] == 1 && !given[id.index()];
    // The factors of a product with a single use.
    let product = |id: Id| match graph.node(id) {
        Node::Binary(Binary::Mul, a, b) if alone(id) => Some([a, b]),
        _ => None,
    };
    // A sum with a product: its kind, the product with its factors, and the other summand. The negative of
    // a product is subtracted from nothing.
    let split = |id: Id| match graph.node(id) {
        Node::Binary(Binary::Add, a, b) => product(b)
            .map(|pair| (Chain::Plus, b, pair, Some(a)))
            .or_else(|| product(a).map(|pair| (Chain::Plus, a, pair, Some(b)))),
        Node::Binary(Binary::Sub, a, b) => product(b)
            .map(|pair| (Chain::Minus, b, pair, Some(a)))
            .or_else(|| product(a).map(|pair| (Chain::Less, a, pair, Some(b)))),
        Node::Unary(Unary::Neg, a) => product(a).map(|pair| (Chain::Minus, a, pair, None)),
        _ => None,
    };
    let mut inside = vec![false; given.len()];
    let mut steps = Vec::with_capacity(order.len());
    // From the end: the last use of a product decides.
    for &id in order.iter().rev().filter(|id| !given[id.index()]) {
        if inside[id.index()] {
            continue;
        }
        let form = match (split(id), graph.node(id)) {
            (_, Node::Constant(_) | Node::Symbol(_)) => continue,
            (Some((op, within, pair, mut start)), _) => {
                let mut pairs = vec![pair];
                inside[within.index()] = true;
                while let Some(sum) = start.filter(|&sum| alone(sum))
                    && op != Chain::Less
                    && pairs.len() < LONGEST
                {
                    if let Some((more, within, pair, rest)) = split(sum)
                        && more == op
                    {
                        inside[within.index()] = true;
                        pairs.push(pair);
                        start = rest;
                    } else if let Some(pair) = product(sum).filter(|_| op == Chain::Plus) {
                        pairs.push(pair);
                        start = None;
                    } else {
                        break;
                    }
                    inside[sum.index()] = true;
                }
                pairs.reverse();
                Form::Chain(op, pairs, start)
            }
            (None, Node::Unary(op, a)) => Form::Unary(op, a),
            (None, Node::Binary(op, a, b)) => Form::Binary(op, a, b),
        };
        steps.push(Step { id, form });
    }
    steps.reverse();
    steps
}
