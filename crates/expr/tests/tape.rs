//! Tapes: slots are used again only when their value is no longer needed, and what is odd but allowed works.

use crate::common::*;
use phisindy_expr::{Graph, Id, Names, Node, Scratch, Tape, Unbound};
use proptest::prelude::*;

/// The value of every node below `top`, from its operands' values, no slot ever used twice.
fn node_by_node(bench: &Bench, top: usize, ids: &[Id], point: [f64; 3]) -> Vec<(Id, f64)> {
    let mut values: Vec<(Id, f64)> = Vec::new();
    for id in bench.graph.reachable(&ids[..=top]) {
        let of = |a: Id| values[values.binary_search_by_key(&a, |v| v.0).unwrap()].1;
        let value = match bench.graph.node(id) {
            Node::Constant(bits) => f64::from_bits(bits),
            Node::Symbol(_) => point[bench.xyz.iter().position(|&s| s == id).unwrap()],
            Node::Unary(op, a) => (op.row().value)(of(a)),
            Node::Binary(op, a, b) => (op.row().value)(of(a), of(b)),
        };
        values.push((id, value));
    }
    values
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn slots_are_not_used_too_early(
        steps in steps(any_step(true, plain_number()), 60),
        picks in prop::collection::vec(any::<prop::sample::Index>(), 1..6),
        point in prop::array::uniform3(-3.0..3.0f64),
    ) {
        let mut bench = Bench::new();
        let ids = bench.build(&steps);
        let outputs: Vec<Id> = picks.iter().map(|p| ids[p.index(ids.len())]).collect();
        let due = node_by_node(&bench, ids.len() - 1, &ids, point);
        let tape = Tape::compile(&bench.graph, &bench.xyz, &outputs).unwrap();
        let mut scratch = Scratch::<2>::new(&tape);
        for run in 0..2 {
            (0..3).for_each(|k| *scratch.input(k) = [point[k], point[2 - k]]);
            scratch.run();
            for (k, id) in outputs.iter().enumerate() {
                let due = due[due.binary_search_by_key(id, |v| v.0).unwrap()].1;
                prop_assert!(same(due, scratch.output(k)[0]), "run {run}: {} = {due}", bench.text(*id));
            }
        }
    }

    /// The vectors of this machine, chains of products, inputs that lie elsewhere: the same bits as each
    /// operation alone.
    #[test]
    fn the_fast_path_gives_the_same_bits(
        steps in steps(any_step(true, plain_number()), 60),
        points in prop::collection::vec(prop::array::uniform3(-3.0..3.0f64), 64),
        elsewhere in 0usize..=3,
    ) {
        let mut bench = Bench::new();
        let ids = bench.build(&steps);
        // An input may be an output too.
        let outputs: Vec<Id> = ids[ids.len().saturating_sub(4)..].iter().copied().chain([bench.xyz[0]]).collect();
        let tape = Tape::compile(&bench.graph, &bench.xyz, &outputs).unwrap();
        let mut scratch = Scratch::<64>::new(&tape);
        let column = |k: usize| std::array::from_fn(|lane| points[lane][k]);
        let head: Vec<[f64; 64]> = (0..elsewhere).map(column).collect();
        (elsewhere..3).for_each(|k| *scratch.input(k) = column(k));
        scratch.run_on(&head);
        for lane in [0, 17, 63] {
            let due = node_by_node(&bench, ids.len() - 1, &ids, points[lane]);
            for (k, id) in outputs.iter().enumerate() {
                let due = due[due.binary_search_by_key(id, |v| v.0).unwrap()].1;
                prop_assert!(same(due, scratch.output(k)[lane]), "{} = {due}", bench.text(*id));
            }
        }
    }

    /// Any nodes may be inputs: the tape above them gives the same bits as the whole.
    #[test]
    fn two_stages_equal_one(
        steps in steps(any_step(true, plain_number()), 60),
        point in prop::array::uniform3(-3.0..3.0f64),
        varying in 0usize..3,
    ) {
        let mut bench = Bench::new();
        let ids = bench.build(&steps);
        let roots = &ids[ids.len().saturating_sub(3)..];
        let varying = bench.xyz[varying];
        let border = bench.graph.border(roots, &[varying]);
        prop_assert!(!bench.graph.uses(&border, &[varying]));
        let mut at = bench.at(&border, point);
        at.push(bench.at(&[varying], point)[0]);
        let inputs: Vec<Id> = border.iter().copied().chain([varying]).collect();
        let staged = run(&bench.graph, &inputs, roots, &at);
        for (due, got) in bench.at(roots, point).into_iter().zip(staged) {
            prop_assert!(same(due, got), "{due} {got}");
        }
    }
}

#[test]
fn long_chains_need_few_slots() {
    let mut bench = Bench::new();
    let chain = bench.read("sin(cos(sin(cos(exp(x) + 1) + 2) + 3) + 4)");
    let tape = Tape::compile(&bench.graph, &bench.xyz, &[chain]).unwrap();
    // Three inputs, four numbers that stay, two to alternate between.
    assert_eq!((tape.operations(), tape.slots()), (9, 9));
    let square = bench.read("(x + y)^2");
    let tape = Tape::compile(&bench.graph, &bench.xyz, &[square]).unwrap();
    assert_eq!(tape.operations(), 2);
}

/// Products make a power with a number as its exponent, a call one with an input: the same bits.
#[test]
fn whole_powers_are_products_with_the_bits_of_a_call() {
    let mut bench = Bench::new();
    let called = bench.read("x^y");
    for n in 2..=64_u32 {
        let made = bench.read(&format!("x^{n}"));
        let tape = Tape::compile(&bench.graph, &bench.xyz, &[made]).unwrap();
        // A square for each binary digit but the first, a product for each digit 1 but one.
        assert_eq!(tape.operations() as u32, n.ilog2() + n.count_ones() - 1, "x^{n}");
        for x in [-1.3, -0.0, 0.7, 1e30, f64::INFINITY, f64::NAN] {
            let [due, got] = bench.at(&[called, made], [x, f64::from(n), 0.0])[..] else { panic!() };
            assert!(same(due, got), "{x}^{n}: {due} {got}");
        }
    }
}

#[test]
fn outputs_may_be_inputs_numbers_and_repeated() {
    let mut bench = Bench::new();
    let [x, y, _] = bench.xyz;
    let (seven, sum) = (bench.read("7"), bench.read("x + y"));
    assert_eq!(bench.at(&[x, seven, sum, sum, y, seven], [1.0, 2.0, 3.0]), [1.0, 7.0, 3.0, 3.0, 2.0, 7.0]);
    assert_eq!(bench.at(&[], [1.0, 2.0, 3.0]), [0.0; 0]);
}

#[test]
fn an_input_may_be_any_node_and_hides_what_is_below() {
    let mut bench = Bench::new();
    let (inner, outer, both) = (bench.read("ln(x)"), bench.read("2*ln(x) + y"), bench.read("x + ln(x)"));
    let [x, y, _] = bench.xyz;
    assert_eq!(run(&bench.graph, &[inner, y], &[outer], &[10.0, 1.0]), [21.0]);
    // Given both, both count.
    assert_eq!(run(&bench.graph, &[inner, x], &[both, inner], &[10.0, 1.0]), [11.0, 10.0]);
}

#[test]
fn inputs_keep_their_values_between_runs() {
    let mut bench = Bench::new();
    let f = bench.read("sin(x)*y + z");
    let tape = Tape::compile(&bench.graph, &bench.xyz, &[f]).unwrap();
    let mut scratch = Scratch::<1>::new(&tape);
    (0..3).for_each(|k| scratch.input(k)[0] = 2.0);
    scratch.run();
    let first = scratch.output(0)[0];
    scratch.run();
    assert_eq!(scratch.output(0)[0], first);
    assert_eq!(first, 2.0 * 2.0f64.sin() + 2.0);
}

#[test]
fn a_symbol_without_value_is_named() {
    let (mut graph, mut names) = (Graph::default(), Names::default());
    let (a, b) = (graph.symbol(names.intern("a")), graph.symbol(names.intern("load")));
    let product = graph.mul(a, b);
    let error = Tape::compile(&graph, &[a], &[product]).unwrap_err();
    assert_eq!(error, Unbound(names.get("load").unwrap()));
    assert_eq!(error.message(&names), "`load` has no value here");
    // What is not needed may be missing.
    assert!(Tape::compile(&graph, &[a], &[a]).is_ok());
    assert!(Tape::compile(&graph, &[product], &[product]).is_ok());
}

#[test]
#[should_panic(expected = "input 3 of 3")]
fn an_input_that_is_not_there() {
    let bench = Bench::new();
    let tape = Tape::compile(&bench.graph, &bench.xyz, &bench.xyz).unwrap();
    Scratch::<1>::new(&tape).input(3);
}
