//! The table of operations, row by row: every evaluator, derivative and printer against the row's own value.

use crate::common::*;
use num_dual::Dual64;
use phisindy_expr::ops::{BINARY, Function, UNARY, function, function_names};
use phisindy_expr::{Binary, Graph, Id, Node, Parity, Scratch, Span, Symbol, Tape, Unary};

const EVERY_SIZE: [f64; 23] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.5,
    -0.5,
    2.0,
    -2.0,
    3.0,
    0.1,
    -7.25,
    64.0,
    65.0,
    1e-6,
    -1e-6,
    1e300,
    -1e300,
    1e-300,
    5e-324,
    -5e-324,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

/// Ordinary points, none on a kink; some outside a domain.
const ORDINARY: [f64; 8] = [0.3, 1.7, 2.6, -0.4, -1.3, -2.2, 0.9, 4.1];

fn two_inputs() -> (Graph, [Id; 2]) {
    let mut graph = Graph::default();
    let inputs = [Symbol(0), Symbol(1)].map(|s| graph.symbol(s));
    (graph, inputs)
}

/// An operation whose operands are inputs, with its value and the distance of a point from the next kink.
struct Case {
    name: String,
    node: fn(&mut Graph, [Id; 2], usize) -> Id,
    row: usize,
    value: Box<dyn Fn(f64, f64) -> f64>,
    kink: Box<dyn Fn(f64, f64) -> f64>,
    dual: Box<dyn Fn(Dual64, Dual64) -> Option<Dual64>>,
}

fn all() -> Vec<Case> {
    let unary = UNARY.iter().enumerate().map(|(row, r)| Case {
        name: format!("{:?}", r.op),
        node: |g, [x, _], row| g.unary(UNARY[row].op, x),
        row,
        value: Box::new(|x, _| (r.value)(x)),
        kink: Box::new(|x, _| r.kinks.iter().map(|k| (x - k).abs()).fold(f64::INFINITY, f64::min)),
        dual: Box::new(|x, _| dual_unary(r.op, x)),
    });
    let binary = BINARY.iter().enumerate().map(|(row, r)| Case {
        name: format!("{:?}", r.op),
        node: |g, [a, b], row| g.binary(BINARY[row].op, a, b),
        row,
        value: Box::new(|a, b| (r.value)(a, b)),
        kink: Box::new(|a, b| (r.kink)(a, b)),
        dual: Box::new(|a, b| dual_binary(r.op, a, b)),
    });
    unary.chain(binary).collect()
}

fn pairs(of: &[f64]) -> Vec<[f64; 2]> {
    of.iter().flat_map(|&a| of.iter().map(move |&b| [a, b])).collect()
}

#[test]
fn lanes_equal_scalars_equal_rows_bit_for_bit() {
    for case in all() {
        let (mut graph, inputs) = two_inputs();
        let node = (case.node)(&mut graph, inputs, case.row);
        let tape = Tape::compile(&graph, &inputs, &[node]).unwrap();
        let (mut one, mut many) = (Scratch::<1>::new(&tape), Scratch::<64>::new(&tape));
        for chunk in pairs(&EVERY_SIZE).chunks(64) {
            for (lane, point) in chunk.iter().enumerate() {
                (0..2).for_each(|k| many.input(k)[lane] = point[k]);
            }
            many.run();
            for (lane, &[a, b]) in chunk.iter().enumerate() {
                one.input(0)[0] = a;
                one.input(1)[0] = b;
                one.run();
                let (due, scalar, lanes) = ((case.value)(a, b), one.output(0)[0], many.output(0)[lane]);
                assert!(
                    same(due, scalar) && same(due, lanes),
                    "{}({a:e}, {b:e}): row {due:e}, scalar {scalar:e}, lane {lanes:e}",
                    case.name
                );
            }
        }
    }
}

/// Central difference of `f` in operand `k`, a little more exact than the plain one (five points).
fn difference(f: impl Fn(f64, f64) -> f64, [a, b]: [f64; 2], k: usize) -> f64 {
    let h = 1e-3;
    let at = |s: f64| if k == 0 { f(a + s * h, b) } else { f(a, b + s * h) };
    (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h)
}

#[test]
fn slopes_agree_with_differences_and_with_dual_numbers() {
    for case in all() {
        let (mut graph, inputs) = two_inputs();
        let node = (case.node)(&mut graph, inputs, case.row);
        let slopes = graph.gradient(node, &inputs);
        let mut compared = 0;
        for [a, b] in pairs(&ORDINARY) {
            if (case.kink)(a, b) < 0.01 {
                continue;
            }
            let got = run(&graph, &inputs, &slopes, &[a, b]);
            for (k, got) in got.into_iter().enumerate() {
                let due = difference(&case.value, [a, b], k);
                if due.is_finite() {
                    let scale = 1e-7 * (1.0 + (case.value)(a, b).abs());
                    assert!(
                        close(got, due, 1e-6, scale),
                        "{} at {a}, {b}, operand {k}: {} {due}",
                        case.name,
                        got
                    );
                    compared += 1;
                }
                let seed = |of: usize| if of == k { 1.0 } else { 0.0 };
                let dual = (case.dual)(Dual64::new(a, seed(0)), Dual64::new(b, seed(1)));
                if let Some(dual) = dual.filter(|d| d.eps.is_finite()) {
                    assert!(close(got, dual.eps, 1e-13, 1e-15), "{} at {a}, {b}: {} {dual}", case.name, got);
                }
            }
        }
        assert!(compared >= 20, "{} was compared at {compared} points only", case.name);
    }
}

#[test]
fn parity_of_every_row_is_that_of_its_values() {
    for row in UNARY {
        let values: Vec<(f64, f64)> =
            ORDINARY.iter().map(|&x| ((row.value)(x.abs()), (row.value)(-x.abs()))).collect();
        let all = |sign: f64| values.iter().all(|(a, b)| *a == sign * b);
        let expected = if all(1.0) { Some(Parity::Even) } else { all(-1.0).then_some(Parity::Odd) };
        assert_eq!(row.parity, expected, "{:?}", row.op);
    }
}

#[test]
fn second_derivatives_agree_with_differences_of_first() {
    for case in all() {
        let (mut graph, inputs) = two_inputs();
        let node = (case.node)(&mut graph, inputs, case.row);
        let first = graph.gradient(node, &inputs);
        for (i, &slope) in first.iter().enumerate() {
            let second = graph.gradient(slope, &inputs);
            for [a, b] in pairs(&ORDINARY) {
                let got = run(&graph, &inputs, &second, &[a, b]);
                for (k, got) in got.into_iter().enumerate() {
                    let due = difference(|a, b| run(&graph, &inputs, &[slope], &[a, b])[0], [a, b], k);
                    if (case.kink)(a, b) >= 0.01 && due.is_finite() {
                        let scale = 1e-6 * (1.0 + (case.value)(a, b).abs());
                        assert!(
                            close(got, due, 1e-5, scale),
                            "{} at {a}, {b}, {i}{k}: {got} {due}",
                            case.name
                        );
                    }
                }
            }
        }
    }
}

/// The decisions at the kinks, one by one.
#[test]
fn values_and_slopes_at_kinks_are_as_decided() {
    for (op, value, slope) in
        [(Unary::Abs, 0.0, 0.0), (Unary::Sgn, 0.0, 0.0), (Unary::Step, 0.5, 0.0), (Unary::Pos, 0.0, 0.5)]
    {
        let (mut graph, inputs) = two_inputs();
        let node = graph.unary(op, inputs[0]);
        let d = graph.gradient(node, &inputs)[0];
        assert_eq!(run(&graph, &inputs, &[node, d], &[0.0, 0.0]), [value, slope], "{op:?}");
    }
    for (op, a, b, due) in [
        (Binary::Min, 2.0, 2.0, [2.0, 0.5, 0.5]),
        (Binary::Max, 2.0, 2.0, [2.0, 0.5, 0.5]),
        (Binary::Dead, 2.0, 2.0, [0.0, 0.5, -0.5]),
        (Binary::Dead, -2.0, 2.0, [0.0, 0.5, 0.5]),
        (Binary::Gate, 3.0, 0.0, [0.0, 0.0, 0.0]),
    ] {
        let (mut graph, inputs) = two_inputs();
        let node = graph.binary(op, inputs[0], inputs[1]);
        let d = graph.gradient(node, &inputs);
        assert_eq!(run(&graph, &inputs, &[node, d[0], d[1]], &[a, b]), due, "{op:?}({a}, {b})");
    }
}

#[test]
fn only_gate_hides_nan() {
    for row in UNARY {
        assert!((row.value)(f64::NAN).is_nan(), "{:?}", row.op);
    }
    for row in BINARY.iter().filter(|r| r.op != Binary::Gate) {
        assert!((row.value)(f64::NAN, 2.0).is_nan(), "{:?}", row.op);
        // A period is a number.
        let timed = matches!(row.op, Binary::Hold | Binary::Timing);
        assert!(timed || (row.value)(2.0, f64::NAN).is_nan(), "{:?}", row.op);
    }
    let gate = Binary::Gate.row().value;
    assert_eq!(gate(f64::NAN, 0.0), 0.0);
    assert_eq!(gate(f64::INFINITY, -1.0), 0.0);
    assert_eq!(gate(2.0, f64::NAN), 0.0);
    assert!(gate(f64::NAN, 1.0).is_nan());
}

/// Odd in its first operand whatever the gap, and not fooled by an infinite one.
#[test]
fn dead_zone() {
    let dead = Binary::Dead.row().value;
    for (x, g, due) in [
        (3.0, 1.0, 2.0),
        (-3.0, 1.0, -2.0),
        (0.5, 1.0, 0.0),
        (-0.5, -1.0, -1.5),
        (0.5, -1.0, 1.5),
        (5.0, f64::INFINITY, 0.0),
    ] {
        assert_eq!(dead(x, g), due, "dead({x}, {g})");
    }
}

#[test]
fn latex_of_every_row_is_accepted() {
    for case in all() {
        let mut bench = Bench::new();
        let [x, y, _] = bench.xyz;
        let quotient = bench.graph.div(x, y);
        let sum = bench.graph.add(x, y);
        for operands in [[x, y], [quotient, sum], [sum, quotient]] {
            let node = (case.node)(&mut bench.graph, operands, case.row);
            let latex = bench.latex(node);
            accepts_latex(&latex);
            assert!(!latex.contains('#'), "{latex}");
            let nested = (case.node)(&mut bench.graph, [node, node], case.row);
            accepts_latex(&bench.latex(nested));
        }
    }
}

#[test]
fn every_function_is_found_by_its_name() {
    for name in function_names() {
        let arity = function(name).map(Function::arity);
        assert!(matches!(arity, Some(1 | 2)), "{name}");
    }
    assert_eq!(function_names().count(), 14 + 6);
    for hidden in ["", "gate", "timing", "+", "neg"] {
        assert_eq!(function(hidden), None, "{hidden}");
    }
    for row in UNARY {
        assert_eq!(row.op.row().name, row.name);
        assert!(!row.about.is_empty());
    }
}

/// A node that grows slows everything: this is noticed here.
#[test]
fn sizes() {
    assert_eq!(size_of::<Node>(), 16);
    assert_eq!(size_of::<Id>(), 4);
    assert_eq!(size_of::<Symbol>(), 4);
    assert_eq!((size_of::<Unary>(), size_of::<Binary>()), (1, 1));
    assert_eq!(size_of::<Span>(), 16);
}
