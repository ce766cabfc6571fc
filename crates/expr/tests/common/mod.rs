//! What the tests share: random expressions, evaluation, and the one place with tolerances.
#![allow(dead_code, unreachable_pub, reason = "each test program uses a part of it")]

use phisindy_expr::ops::{BINARY, UNARY};
use phisindy_expr::{Binary, Graph, Id, Names, Scratch, Tape, Unary, parse};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// A graph with its names, and `x`, `y`, `z` in it.
pub struct Bench {
    pub graph: Graph,
    pub names: Names,
    pub xyz: [Id; 3],
}

impl Bench {
    pub fn new() -> Self {
        let (mut graph, mut names) = (Graph::default(), Names::default());
        let xyz = ["x", "y", "z"].map(|name| graph.symbol(names.intern(name)));
        Bench { graph, names, xyz }
    }

    #[track_caller]
    pub fn read(&mut self, text: &str) -> Id {
        let ast = parse(text).unwrap_or_else(|e| panic!("{text}: {e} at {:?}", e.span));
        self.graph.lower(&ast, |name| Some(self.names.intern(name))).unwrap()
    }

    pub fn text(&self, id: Id) -> String {
        self.graph.text(id, &self.names)
    }

    pub fn latex(&self, id: Id) -> String {
        self.graph.latex(id, &self.names)
    }

    /// Values at a point of `x`, `y`, `z`.
    pub fn at(&self, outputs: &[Id], point: [f64; 3]) -> Vec<f64> {
        run(&self.graph, &self.xyz, outputs, &point)
    }

    /// A node for each step.
    pub fn build(&mut self, steps: &[Step]) -> Vec<Id> {
        let mut ids: Vec<Id> = Vec::new();
        for (k, step) in steps.iter().enumerate() {
            let id = match *step {
                Step::Number(value) => self.graph.constant(value),
                Step::Symbol(s) => self.xyz[s],
                Step::Unary(op, a) => self.graph.unary(op, ids[back(k, a)]),
                Step::Binary(op, a, b) => self.graph.binary(op, ids[back(k, a)], ids[back(k, b)]),
            };
            ids.push(id);
        }
        ids
    }
}

pub fn run(graph: &Graph, inputs: &[Id], outputs: &[Id], at: &[f64]) -> Vec<f64> {
    let mut scratch = Scratch::<1>::new(&Tape::compile(graph, inputs, outputs).expect("inputs are complete"));
    at.iter().enumerate().for_each(|(k, &value)| scratch.input(k)[0] = value);
    scratch.run();
    (0..outputs.len()).map(|k| scratch.output(k)[0]).collect()
}

/// Equal to a relative or an absolute tolerance; NaN is close to nothing.
pub fn close(a: f64, b: f64, relative: f64, absolute: f64) -> bool {
    approx::relative_eq!(a, b, max_relative = relative, epsilon = absolute)
}

/// Equal bits; any NaN equals any other (sign and payload of a NaN are the processor's choice).
pub fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

#[track_caller]
pub fn accepts_latex(latex: &str) {
    let storage = pulldown_latex::Storage::new();
    for event in pulldown_latex::Parser::new(latex, &storage) {
        if let Err(e) = event {
            panic!("{latex}\n{e}");
        }
    }
}

/// One operation of a random expression; operands are counted backwards from it, so that every list of steps
/// has a meaning.
#[derive(Clone, Debug)]
pub enum Step {
    Number(f64),
    Symbol(usize),
    Unary(Unary, usize),
    Binary(Binary, usize, usize),
}

fn back(k: usize, a: usize) -> usize {
    k - 1 - a % k
}

/// What the steps mean, one after the other and nothing simplified.
pub fn direct(steps: &[Step], point: [f64; 3]) -> Vec<f64> {
    let mut values: Vec<f64> = Vec::new();
    for (k, step) in steps.iter().enumerate() {
        let value = match *step {
            Step::Number(value) => value,
            Step::Symbol(s) => point[s],
            Step::Unary(op, a) => (op.row().value)(values[back(k, a)]),
            Step::Binary(op, a, b) => (op.row().value)(values[back(k, a)], values[back(k, b)]),
        };
        values.push(value);
    }
    values
}

/// The same in the numbers of `num-dual`, for operations that are smooth.
pub fn dual<D: num_dual::DualNum<Primitive = f64> + Copy>(steps: &[Step], point: [D; 3]) -> Vec<D> {
    let mut values: Vec<D> = Vec::new();
    for (k, step) in steps.iter().enumerate() {
        let value = match *step {
            Step::Number(value) => D::from(value),
            Step::Symbol(s) => point[s],
            Step::Unary(op, a) => dual_unary(op, values[back(k, a)]).expect("smooth"),
            Step::Binary(op, a, b) => {
                dual_binary(op, values[back(k, a)], values[back(k, b)]).expect("smooth")
            }
        };
        values.push(value);
    }
    values
}

/// The operation as `num-dual` knows it, if it does.
pub fn dual_unary<D: num_dual::DualNum<Primitive = f64> + Copy>(op: Unary, x: D) -> Option<D> {
    Some(match op {
        Unary::Neg => -x,
        Unary::Abs => x.abs(),
        Unary::Sgn => x.signum(),
        Unary::Ln => x.ln(),
        Unary::Exp => x.exp(),
        Unary::Sqrt => x.sqrt(),
        Unary::Sin => x.sin(),
        Unary::Cos => x.cos(),
        Unary::Tan => x.tan(),
        Unary::Tanh => x.tanh(),
        Unary::Atan => x.atan(),
        Unary::Step | Unary::Rest | Unary::Pos | Unary::Floor => return None,
    })
}

/// The operation as `num-dual` knows it, if it does.
pub fn dual_binary<D: num_dual::DualNum<Primitive = f64> + Copy>(op: Binary, a: D, b: D) -> Option<D> {
    Some(match op {
        Binary::Add => a + b,
        Binary::Sub => a - b,
        Binary::Mul => a * b,
        Binary::Div => a / b,
        Binary::Pow => a.powd(b),
        Binary::Atan2 => a.atan2(b),
        Binary::Hold | Binary::Timing => a,
        Binary::Min | Binary::Max | Binary::Dead | Binary::Mod | Binary::Gate | Binary::Masked => {
            return None;
        }
    })
}

pub fn steps(step: impl Strategy<Value = Step>, most: usize) -> impl Strategy<Value = Vec<Step>> {
    prop::collection::vec(step, 1..most).prop_map(|rest| (0..3).map(Step::Symbol).chain(rest).collect())
}

/// Any operation and number; `gate` and `masked` too if asked for (they have no name in the language).
pub fn any_step(gate: bool, numbers: BoxedStrategy<f64>) -> impl Strategy<Value = Step> {
    let unary = (0..UNARY.len(), 0usize..8).prop_map(|(op, a)| Step::Unary(UNARY[op].op, a));
    let timed = |op: Binary| matches!(op, Binary::Hold | Binary::Timing);
    let ops: Vec<Binary> = BINARY.iter().map(|row| row.op).filter(|op| !timed(*op)).collect();
    let binary = (0..ops.len(), 0usize..8, 0usize..8).prop_map(move |(op, a, b)| match ops[op] {
        Binary::Gate | Binary::Masked if !gate => Step::Binary(Binary::Mul, a, b),
        op => Step::Binary(op, a, b),
    });
    prop_oneof![2 => numbers.prop_map(Step::Number), 1 => (0usize..3).prop_map(Step::Symbol), 3 => unary, 6 => binary]
}

/// Finite numbers of every size and sign, subnormal ones too, with enough small and special ones among them.
pub fn any_number() -> BoxedStrategy<f64> {
    use proptest::num::f64;
    let every = f64::POSITIVE | f64::NEGATIVE | f64::NORMAL | f64::SUBNORMAL | f64::ZERO;
    prop_oneof![every, plain_number(), Just(1e200), Just(-1e-200), Just(5e-324)].boxed()
}

/// Small whole numbers and halves, signs and zeros.
pub fn plain_number() -> BoxedStrategy<f64> {
    (-6i8..=6, prop_oneof![3 => Just(1.0), 1 => Just(0.5)]).prop_map(|(n, unit)| f64::from(n) * unit).boxed()
}

/// So many cases, always the same: a failure found today is found tomorrow. `PROPTEST_CASES`,
/// `PROPTEST_RNG_SEED` search further.
pub fn cases(n: u32) -> ProptestConfig {
    let default = ProptestConfig::default();
    let set = |name| std::env::var_os(name).is_some();
    ProptestConfig {
        cases: if set("PROPTEST_CASES") { default.cases } else { n },
        rng_seed: if set("PROPTEST_RNG_SEED") { default.rng_seed } else { RngSeed::Fixed(1) },
        failure_persistence: None,
        max_global_rejects: u32::MAX,
        ..default
    }
}
