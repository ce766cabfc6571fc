//! Text and LaTeX of random graphs, and that simplifying as they are built keeps their values.

use crate::common::*;
use phisindy_expr::ops::BINARY;
use phisindy_expr::{Binary, Node, Unary, latex_name, latex_number};
use proptest::prelude::*;

proptest! {
    #![proptest_config(cases(1000))]

    #[test]
    fn text_reads_back_as_the_same_node(steps in steps(any_step(false, any_number()), 40)) {
        let mut bench = Bench::new();
        for id in bench.build(&steps) {
            let text = bench.text(id);
            prop_assert_eq!(bench.read(&text), id, "{}", text);
        }
    }

    #[test]
    fn latex_is_accepted(steps in steps(any_step(true, any_number()), 40)) {
        let mut bench = Bench::new();
        let ids = bench.build(&steps);
        accepts_latex(&bench.latex(*ids.last().unwrap()));
    }

    /// Each construction against the plain operation on the values of its operands: holding at every step, it
    /// holds for the whole.
    #[test]
    fn every_construction_keeps_the_value(
        steps in steps(any_step(true, plain_number()), 40),
        point in prop::array::uniform3(-3.0..3.0f64),
    ) {
        let mut bench = Bench::new();
        let ids = bench.build(&steps);
        let values = bench.at(&ids, point);
        for (a, &va) in values.iter().enumerate() {
            for (b, &vb) in values.iter().enumerate().skip(a.saturating_sub(3)).take(6) {
                for row in BINARY {
                    let due = (row.value)(va, vb);
                    let id = bench.graph.binary(row.op, ids[a], ids[b]);
                    let got = bench.at(&[id], point)[0];
                    let ordinary = |v: f64| v == 0.0 || (1e-100..1e100).contains(&v.abs());
                    if [va, vb, due].into_iter().all(ordinary) {
                        prop_assert!(
                            close(due, got, 1e-12, 0.0),
                            "{:?}({}, {}) = {due} at {point:?} became {} = {got}",
                            row.op, bench.text(ids[a]), bench.text(ids[b]), bench.text(id)
                        );
                    }
                }
            }
        }
    }

    /// With whole numbers nothing rounds, so that the whole graph must agree exactly.
    #[test]
    fn whole_numbers_agree_exactly(
        steps in steps(any_step(true, plain_number()), 40),
        point in prop::array::uniform3(-4i8..=4),
    ) {
        use Binary::{Atan2, Div, Mod, Mul, Pow};
        use Unary::{Abs, Neg, Pos, Sgn};
        let exact = |step: &Step| match *step {
            Step::Number(x) => Step::Number(x.trunc()),
            Step::Unary(Neg | Abs | Sgn | Pos, _) | Step::Symbol(_) => step.clone(),
            Step::Unary(_, a) => Step::Unary(Neg, a),
            // A quotient rounds, and an angle tells -0 from 0.
            Step::Binary(Div | Pow | Mod | Atan2, a, b) => Step::Binary(Mul, a, b),
            Step::Binary(..) => step.clone(),
        };
        let steps: Vec<Step> = steps.iter().map(exact).collect();
        let point = point.map(f64::from);
        let mut bench = Bench::new();
        let ids = bench.build(&steps);
        let small = direct(&steps, point).into_iter().take_while(|v| v.abs() < 1e12);
        for ((due, got), id) in small.zip(bench.at(&ids, point)).zip(&ids) {
            prop_assert_eq!(due, got, "{}", bench.text(*id));
        }
    }

    #[test]
    fn latex_of_any_name_and_number_is_accepted(name in r"[\p{XID_Start}_]\p{XID_Continue}{0,6}|[a-z_0-9]{0,3}_[a-z_0-9]{0,3}", x in any::<f64>(), digits in 0usize..18) {
        accepts_latex(&latex_name(&name));
        accepts_latex(&latex_number(x, digits));
        let back = number_of(&latex_number(x, 17));
        prop_assert!(!x.is_finite() || back == x, "{x}: {back}");
    }
}

/// The number that LaTeX shows.
fn number_of(latex: &str) -> f64 {
    let plain = match latex.split_once("\\times 10^{") {
        Some((mantissa, exponent)) => format!("{mantissa}e{}", exponent.trim_end_matches('}')),
        None => latex.replace("10^{", "1e").replace('}', ""),
    };
    plain.parse().unwrap_or(f64::NAN)
}

#[track_caller]
fn shows(text: &str, latex: &str) {
    let mut bench = Bench::new();
    let id = bench.read(text);
    accepts_latex(latex);
    assert_eq!(bench.latex(id), latex);
}

/// Only the parentheses that a reader needs.
#[test]
fn latex_is_as_people_write_it() {
    shows("0.3*sgn(v)", r"0.3\,\operatorname{sgn}(v)");
    shows(
        "-(0.3 + 0.07*ln((|y2|+eps)/V))*sgn(y2)",
        r"-\left(0.3 + 0.07\,\ln\left(\frac{\left|y_{2}\right| + \varepsilon}{V}\right)\right)\,\operatorname{sgn}(y_{2})",
    );
    shows(
        "(Fc + (Fs-Fc)*exp(-(v/vs)^2))*sgn(v)",
        r"\left(\mathrm{Fc} + \left(\mathrm{Fs} - \mathrm{Fc}\right)\,\exp\left(-\left(\frac{v}{\mathrm{vs}}\right)^{2}\right)\right)\,\operatorname{sgn}(v)",
    );
    shows("a + (b - c)", "a + b - c");
    shows("a - (b - c)", r"a - \left(b - c\right)");
    shows("a + (-2*b - c)", r"a + \left(-2\,b - c\right)");
    shows("a*(b*c)", r"a\,b\,c");
    shows("a - -b", "a + b");
    shows("-(-x)", "x");
    shows("-(a - b)", "b - a");
    shows("1e-6*x", r"10^{-6}\,x");
    shows("2*10^x", r"2 \cdot 10^{x}");
    shows("1.5e-6*3^x", r"1.5\times 10^{-6} \cdot 3^{x}");
    shows("1e-6^x", r"\left(10^{-6}\right)^{x}");
    shows("x^(a/b)", r"x^{\frac{a}{b}}");
    shows("(a/b)^2", r"\left(\frac{a}{b}\right)^{2}");
    shows("x^-2", "x^{-2}");
    shows("-2*x/y", r"-\frac{2\,x}{y}");
    shows("max(a/b, c)", r"\max\left(\frac{a}{b}, c\right)");
    shows("omega_n*t", r"\omega_{\mathrm{n}}\,t");
}

#[test]
fn text_has_only_the_parentheses_it_needs() {
    for text in [
        "2*x*y",
        "a*(b/c)",
        "a - (b + c)",
        "(a + b)*c",
        "-x^2",
        "(-x)^2",
        "a^b^c",
        "(a^b)^c",
        "-a*b",
        "2*(x/y)",
        "a/b/c",
        "-(a + b)",
        "hold(a - b, T)",
        "min(hold(a, 0.01, 0.002), 2*c)",
    ] {
        let mut bench = Bench::new();
        let id = bench.read(text);
        assert_eq!(bench.text(id), text);
    }
}

/// A negative numerator shows its sign in front, not inside.
#[test]
fn signs_come_out_of_quotients() {
    let mut bench = Bench::new();
    let [x, y, _] = bench.xyz;
    let minus = bench.graph.constant(-2.0);
    let top = bench.graph.mul(minus, x);
    let quotient = bench.graph.div(top, y);
    assert!(matches!(bench.graph.node(quotient), Node::Unary(Unary::Neg, _)));
    let sum = bench.graph.add(x, quotient);
    assert_eq!(bench.text(sum), "x - 2*x/y");
}

/// Millions of nested nodes print and lower without recursion.
#[test]
fn deep_graphs_do_not_overflow() {
    let mut bench = Bench::new();
    let mut id = bench.xyz[0];
    for _ in 0..300_000 {
        id = bench.graph.unary(Unary::Sin, id);
    }
    assert!(bench.text(id).len() > 1_000_000);
    assert!(bench.latex(id).len() > 1_000_000);
    assert!(bench.at(&[id], [1.0; 3])[0] > 0.0);
    let x = bench.xyz[0];
    assert_eq!(bench.graph.gradient(id, &[x]).len(), 1);
}

/// The negative of such a number is no number, so that rules that turn signs must leave it alone; they used
/// to call each other for ever.
#[test]
fn numbers_that_are_not_finite_end_the_rules() {
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut bench = Bench::new();
        let [a, b, _] = bench.xyz;
        let number = bench.graph.constant(x);
        let product = bench.graph.mul(number, a);
        let minus = bench.graph.neg(product);
        for op in [Binary::Add, Binary::Sub, Binary::Mul, Binary::Div, Binary::Pow] {
            for (left, right) in [(minus, b), (b, minus), (minus, minus), (minus, number), (number, minus)] {
                let id = bench.graph.binary(op, left, right);
                bench.graph.neg(id);
            }
        }
    }
}

/// A fit that went wrong is printed like one that did not, and can be typeset.
#[test]
fn numbers_that_are_not_finite_have_a_latex_form() {
    for (x, latex) in
        [(f64::INFINITY, r"\infty"), (f64::NEG_INFINITY, r"-\infty"), (f64::NAN, r"\mathrm{NaN}")]
    {
        assert_eq!(latex_number(x, 4), latex);
        accepts_latex(latex);
    }
}

/// What a misspelt constant stands in must not matter.
#[test]
fn an_unknown_name_behind_a_sign_is_told() {
    for text in ["-d*y", "-(d*y)/m", "x - d*y", "x/(-d*y)", "-y*-d", "-d^-y", "|-d*y|*-d"] {
        let mut bench = Bench::new();
        let unknown = bench.graph.lower(&phisindy_expr::parse(text).unwrap(), |_| None).unwrap_err();
        assert!(unknown.iter().any(|u| u.name == "d"), "{text}");
    }
}
