//! Derivatives of whole expressions, against `num-dual` and against each other.

use crate::common::*;
use num_dual::{Dual2_64, Dual64, DualNum};
use phisindy_expr::{Binary, Graph, Id, Unary};
use proptest::prelude::*;
use std::collections::HashMap;

/// Smooth operations that stay of ordinary size; products and quotients make them coupled.
fn smooth() -> impl Strategy<Value = Step> {
    use Binary::{Add, Div, Mul, Sub};
    use Unary::{Atan, Cos, Exp, Ln, Neg, Sin, Sqrt, Tan, Tanh};
    let unary = prop::sample::select(vec![Neg, Ln, Exp, Sqrt, Sin, Cos, Tan, Tanh, Atan]);
    let binary = prop::sample::select(vec![Add, Sub, Mul, Div, Binary::Pow]);
    prop_oneof![
        plain_number().prop_map(Step::Number),
        (unary, 0usize..8).prop_map(|(op, a)| Step::Unary(op, a)),
        (binary, 0usize..8, 0usize..8).prop_map(|(op, a, b)| Step::Binary(op, a, b)),
    ]
}

/// Where every value and derivative on the way is of ordinary size, so that rounding stays small.
fn ordinary(values: impl IntoIterator<Item = f64>) -> bool {
    values.into_iter().all(|v| v == 0.0 || (1e-3..1e3).contains(&v.abs()))
}

/// The gradient of every step, if all values and derivatives on the way are ordinary.
fn dual_gradients(steps: &[Step], point: [f64; 3]) -> Option<Vec<[f64; 3]>> {
    let mut gradients = vec![[0.0; 3]; steps.len()];
    for k in 0..3 {
        let seeded = |j: usize| Dual64::new(point[j], if j == k { 1.0 } else { 0.0 });
        for (gradient, d) in gradients.iter_mut().zip(dual(steps, [0, 1, 2].map(seeded))) {
            if !ordinary([d.re, d.eps]) {
                return None;
            }
            gradient[k] = d.eps;
        }
    }
    Some(gradients)
}

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn gradients_agree_with_dual_numbers(
        steps in steps(smooth(), 16),
        point in prop::array::uniform3(0.2..2.0f64),
    ) {
        let mut bench = Bench::new();
        let f = *bench.build(&steps).last().unwrap();
        let xyz = bench.xyz;
        let gradient = bench.graph.gradient(f, &xyz);
        let due = dual_gradients(&steps, point);
        prop_assume!(due.is_some());
        for (got, due) in bench.at(&gradient, point).into_iter().zip(due.unwrap().pop().unwrap()) {
            prop_assert!(close(got, due, 1e-9, 1e-9), "d {} at {point:?}: {got} {due}", bench.text(f));
        }
    }

    #[test]
    fn second_derivatives_agree_with_dual_numbers(steps in steps(smooth(), 12), x in 0.2..2.0f64) {
        let duals = dual(&steps, [Dual2_64::new(x, 1.0, 0.0), 0.7.into(), 1.3.into()]);
        prop_assume!(ordinary(duals.iter().flat_map(|d| [d.re, d.v1, d.v2])));
        let mut bench = Bench::new();
        let f = *bench.build(&steps).last().unwrap();
        let x_node = bench.xyz[0];
        let first = bench.graph.gradient(f, &[x_node])[0];
        let second = bench.graph.gradient(first, &[x_node])[0];
        let (got, due) = (bench.at(&[second], [x, 0.7, 1.3])[0], duals[duals.len() - 1].v2);
        prop_assert!(close(got, due, 1e-7, 1e-7), "d2 {} at {x}: {got} {due}", bench.text(f));
    }

    /// Several roots at once: the sum of their gradients, each times its seed.
    #[test]
    fn seeds_weigh_the_roots(steps in steps(smooth(), 16), point in prop::array::uniform3(0.2..2.0f64)) {
        let gradients = dual_gradients(&steps, point);
        prop_assume!(gradients.is_some());
        let gradients = gradients.unwrap();
        let mut bench = Bench::new();
        let ids = bench.build(&steps);
        let (roots, seeds) = ([ids.len() - 1, ids.len() / 2, 0], [2.0, -0.5, 3.0]);
        let (root_ids, seed_ids) = (roots.map(|r| ids[r]), seeds.map(|s| bench.graph.constant(s)));
        let xyz = bench.xyz;
        let together = bench.graph.vjp(&root_ids, &seed_ids, &xyz);
        for (k, got) in bench.at(&together, point).into_iter().enumerate() {
            let due: f64 = roots.iter().zip(seeds).map(|(&r, seed)| seed * gradients[r][k]).sum();
            prop_assert!(close(got, due, 1e-9, 1e-9), "{k} at {point:?}: {got} {due}");
        }
    }

    /// Replacing a node rebuilds the same expression around the new one.
    #[test]
    fn replacing_equals_building_anew(
        steps in steps(any_step(true, plain_number()), 30),
        point in prop::array::uniform3(-3.0..3.0f64),
    ) {
        let mut bench = Bench::new();
        let ids = bench.build(&steps);
        let [x, y, z] = bench.xyz;
        let swapped = bench.graph.replace(&ids, &HashMap::from([(x, y), (y, x)]));
        let [a, b, c] = point;
        let anew: Vec<Step> = steps.iter().map(|s| match *s {
            Step::Symbol(k) => Step::Symbol([1, 0, 2][k]),
            ref other => other.clone(),
        }).collect();
        prop_assert_eq!(&swapped, &bench.build(&anew));
        for (old, new) in bench.at(&ids, [b, a, c]).into_iter().zip(bench.at(&swapped, point)) {
            prop_assert!(same(old, new));
        }
        prop_assert_eq!(bench.graph.replace(&swapped, &HashMap::from([(z, z)])), swapped);
    }
}

#[track_caller]
fn slope(text: &str, x: f64) -> f64 {
    let mut bench = Bench::new();
    let f = bench.read(text);
    let node = bench.xyz[0];
    let d = bench.graph.gradient(f, &[node])[0];
    bench.at(&[d], [x, 2.0, 3.0])[0]
}

#[test]
fn powers_of_any_base() {
    assert_eq!(slope("x^2", -3.0), -6.0);
    assert_eq!(slope("x^2", 0.0), 0.0);
    assert_eq!(slope("x^3", -2.0), 12.0);
    assert_eq!(slope("x^-1", -2.0), -0.25);
    assert_eq!(slope("(-2)^2*x", 5.0), 4.0);
    assert!(close(slope("2^x", 3.0), 8.0 * 2.0f64.ln(), 1e-15, 0.0));
    assert!(close(slope("x^x", 2.0), 4.0 * (2.0f64.ln() + 1.0), 1e-15, 0.0));
}

#[test]
fn what_lies_below_a_node_is_held() {
    let mut bench = Bench::new();
    let (f, inner) = (bench.read("x*ln(x) + 3*ln(x)"), bench.read("ln(x)"));
    let x = bench.xyz[0];
    let d = bench.graph.gradient(f, &[inner, x]);
    assert_eq!(bench.text(d[0]), "3 + x");
    assert_eq!(d[1], inner);
    let y = bench.xyz[1];
    let zero = bench.graph.gradient(f, &[y])[0];
    assert_eq!(bench.graph.value(zero), Some(0.0));
    assert_eq!(bench.graph.gradient(x, &[x]).len(), 1);
}

#[test]
#[should_panic(expected = "one seed for each root")]
fn seeds_must_match_roots() {
    let mut bench = Bench::new();
    let x = bench.xyz[0];
    bench.graph.vjp(&[x, x], &[x], &[x]);
}

/// `gate(of, by)` and its first and second derivative by `x`, at several `x`.
fn gated(of: &str, by: &str, at: &[f64]) -> Vec<[f64; 3]> {
    let mut bench = Bench::new();
    let (of, by, x) = (bench.read(of), bench.read(by), bench.xyz[0]);
    let f = bench.graph.binary(Binary::Gate, of, by);
    let first = bench.graph.gradient(f, &[x])[0];
    let second = bench.graph.gradient(first, &[x])[0];
    let value = |&x: &f64| <[f64; 3]>::try_from(bench.at(&[f, first, second], [x, 2.0, -1.0])).unwrap();
    at.iter().map(value).collect()
}

/// What a closed gate hides may be infinite or no number, in the value and in every derivative.
#[test]
fn a_closed_gate_hides_singular_slopes() {
    let closed = [0.0; 3];
    assert_eq!(gated("ln(x)", "x", &[-1.0, 0.0, 2.0]), [closed, closed, [2.0f64.ln(), 0.5, -0.25]]);
    assert_eq!(gated("sqrt(x)", "x", &[-1.0, 0.0]), [closed; 2]);
    assert_eq!(gated("sin(ln(sqrt(x)) + 1/x)^3", "x", &[-1.0, 0.0]), [closed; 2]);
    assert_eq!(gated("1/x", "z", &[0.0, 1.0]), [closed; 2]);
    assert_eq!(gated("x^x*exp(1/x)", "x", &[0.0, -0.5]), [closed; 2]);
}

/// The hidden node may be used elsewhere too, by gates of other conditions and by none.
#[test]
fn gates_share_what_they_hide() {
    let mut bench = Bench::new();
    let [x, y, z] = bench.xyz;
    let log = bench.read("ln(x)");
    let root = bench.read("sqrt(x)");
    let g = &mut bench.graph;
    let mut gate = |a: Id, b: Id| g.binary(Binary::Gate, a, b);
    let (by_x, by_y, nested) = (gate(log, x), gate(log, y), gate(root, x));
    let nested = gate(nested, z);
    let sum = [by_x, by_y, nested, x].into_iter().reduce(|a, b| bench.graph.add(a, b)).unwrap();
    let d = bench.graph.gradient(sum, &[x])[0];
    let at = |point| bench.at(&[d], point)[0];
    assert_eq!(at([0.0, -1.0, 1.0]), 1.0);
    assert_eq!(at([4.0, -1.0, -1.0]), 1.25);
    assert_eq!(at([4.0, 1.0, -1.0]), 1.5);
    assert_eq!(at([4.0, 1.0, 1.0]), 1.75);
    assert_eq!(at([0.0, 1.0, 1.0]), f64::INFINITY);
}

/// Gates change nothing where they are open.
#[test]
fn an_open_gate_is_not_there() {
    for (text, x) in [("ln(x)*x", 0.7), ("x^2/(x + y)", 1.3), ("tan(x)", 0.4)] {
        let got = gated(text, "y", &[x])[0];
        assert_eq!(got[1], slope(text, x), "{text}");
    }
}

#[test]
fn the_border_is_what_stays() {
    let mut bench = Bench::new();
    let border = |bench: &mut Bench, f: &str, varying: &[&str]| -> Vec<String> {
        let f = bench.read(f);
        let varying: Vec<Id> = varying.iter().map(|v| bench.read(v)).collect();
        bench.graph.border(&[f], &varying).into_iter().map(|id| bench.text(id)).collect()
    };
    assert_eq!(border(&mut bench, "a*ln(|v|+1) + b*(v^3 + 2)", &["a", "b"]), ["ln(abs(v) + 1)", "v^3 + 2"]);
    assert_eq!(border(&mut bench, "ln(v)", &["a"]), ["ln(v)"]);
    assert_eq!(border(&mut bench, "2*a", &["a"]), [""; 0]);
    // What varies may be any node; what is below it is not asked for.
    assert_eq!(border(&mut bench, "c*sgn(w)", &["sgn(w)"]), ["c"]);
}

/// A function of the test's own, the oracle written by hand: the friction law of the paper.
#[test]
fn the_friction_law_of_dieterich_and_ruina() {
    fn law<D: DualNum<Primitive = f64> + Copy>(y: D, c: D) -> D {
        (c + (y.abs() + 1e-6).recip() * 0.003).ln() * y.signum()
    }
    let mut graph = Graph::default();
    let mut names = phisindy_expr::Names::default();
    let ast = phisindy_expr::parse("ln(c+0.003/(|y|+1e-6))*sgn(y)").unwrap();
    let f = graph.lower(&ast, |name| Some(names.intern(name))).unwrap();
    let inputs = ["y", "c"].map(|name| graph.symbol(names.get(name).unwrap()));
    let slopes = graph.gradient(f, &inputs);
    for y in [-2.0, -0.1, -1e-7, 1e-7, 1e-3, 0.5] {
        let got = run(&graph, &inputs, &slopes, &[y, 0.022]);
        let by_y = law(Dual64::new(y, 1.0), 0.022.into()).eps;
        let by_c = law(Dual64::from(y), Dual64::new(0.022, 1.0)).eps;
        assert!(
            close(got[0], by_y, 1e-13, 0.0) && close(got[1], by_c, 1e-13, 0.0),
            "{y}: {got:?} {by_y} {by_c}"
        );
    }
}
