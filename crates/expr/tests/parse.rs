//! Text to graph: what is accepted and how it binds, what is refused and what is said.

use crate::common::*;
use phisindy_expr::{Ast, AstKind, Graph, Names, ParseErrorKind as Kind, Span, parse};
use proptest::prelude::*;
use std::ops::Range;

/// `text` builds the same node as `due`, and `due` is how that node is written.
#[track_caller]
fn check(text: &str, due: &str) {
    let mut bench = Bench::new();
    let (got, same) = (bench.read(text), bench.read(due));
    assert_eq!(bench.text(got), due);
    assert_eq!(got, same);
}

#[track_caller]
fn check_error(text: &str, kind: Kind, span: Range<usize>) {
    let error = parse(text).expect_err(text);
    assert_eq!((error.kind, error.span), (kind, Span::new(span.start, span.end)), "{text}");
}

#[track_caller]
fn check_message(text: &str, message: &str, hint: &str) {
    let error = parse(text).expect_err(text);
    assert_eq!(
        (error.to_string().as_str(), error.hint().unwrap_or_default().as_str()),
        (message, hint),
        "{text}"
    );
}

/// The value that the text has, as written: the syntax tree is evaluated and nothing is simplified.
fn value(text: &str, names: &[(&str, f64)]) -> f64 {
    let ast: Ast = parse(text).unwrap_or_else(|e| panic!("{text}: {e}"));
    let mut values: Vec<f64> = Vec::new();
    for node in &ast.nodes {
        values.push(match &node.kind {
            AstKind::Table { .. } => panic!("no files here"),
            AstKind::Number(x) => *x,
            AstKind::Name(name) => names.iter().find(|n| n.0 == name).unwrap().1,
            AstKind::Unary(op, a) => (op.row().value)(values[*a]),
            AstKind::Binary(op, a, b) => (op.row().value)(values[*a], values[*b]),
        });
    }
    values[values.len() - 1]
}

#[test]
fn simplest_forms() {
    check("x*1 + 0", "x");
    check("0*x + 2", "2");
    check("x - x", "0");
    check("--x", "x");
    check("+x", "x");
    check("x + -y", "x - y");
    check("-x + y", "-x + y");
    check("x - -2", "x + 2");
    check("x*2", "2*x");
    check("x*2*y*3", "6*x*y");
    check("-x*-y", "x*y");
    check("2*x/4", "0.5*x");
    check("x/-y", "-x/y");
    check("x^1", "x");
    check("x^0", "1");
    check("sgn(-x)", "-sgn(x)");
    // A contact is the same one in any unit.
    check("sgn(-2*x)", "-sgn(x)");
    check("step(4*x)", "step(x)");
    check("step(x/4)", "step(x)");
    check("step(-2*x)", "step(-x)");
    check("rest(-2*x)", "rest(x)");
    check("rest(rest(x))", "1 - rest(x)");
    check("rest(|x|)*sgn(rest(x))", "rest(x)*rest(x)");
    check("||x||", "abs(x)");
    check("min(x, x)", "x");
    check("2^10 + sqrt(16)", "1028");
    check("0.0000001*x + 1.50e3", "1e-7*x + 1500");
    // What is not finite is not folded, and what may be zero does not cancel.
    check("ln(0)", "ln(0)");
    check("1/0", "1/0");
    check("x/x", "x/x");
    check("x*y/y", "x*y/y");
    check("sqrt(x^2)", "sqrt(x^2)");
}

#[test]
fn the_fixed_expression() {
    let text = "ln(c+V/(|y|+eps))*sgn(y)";
    check(text, "ln(c + V/(abs(y) + eps))*sgn(y)");
    let at = |y: f64| value(text, &[("c", 0.022), ("V", 0.003), ("eps", 1e-6), ("y", y)]);
    assert_eq!(at(0.1), (0.022f64 + 0.003 / (0.1 + 1e-6)).ln());
    assert_eq!(at(-0.1), -at(0.1));
    assert_eq!(at(0.0), 0.0);
}

#[test]
fn bars() {
    check("|x|*|y|", "abs(x)*abs(y)");
    check("||x|-1|", "abs(abs(x) - 1)");
    check("|a*|b||", "abs(a*abs(b))");
    check("|-|x||", "abs(x)");
    check("|x|^2", "abs(x)^2");
    check("-|x|", "-abs(x)");
    check("|x+1|*(|y|+|z|)", "abs(x + 1)*(abs(y) + abs(z))");
    check("|max(|x|, (|y|))|", "abs(max(abs(x), abs(y)))");
    check("|(|x|)*2|", "abs(2*abs(x))");
}

#[test]
fn what_binds_tighter() {
    let xyz = [("a", 5.0), ("b", 3.0), ("c", 2.0), ("x", 3.0)];
    for (text, due) in [
        ("-x^2", -9.0),
        ("(-x)^2", 9.0),
        ("2^-1", 0.5),
        ("a^b^c", 1953125.0),
        ("(a^b)^c", 15625.0),
        ("-a*b", -15.0),
        ("a*-b", -15.0),
        ("a-b-c", 0.0),
        ("a-(b-c)", 4.0),
        ("a/b/c", 5.0 / 6.0),
        ("a/(b*c)", 5.0 / 6.0),
        ("a/b*c", 10.0 / 3.0),
        ("a--b", 8.0),
        ("a-+b", 2.0),
        // A sign after an operator takes what the operator takes, no more.
        ("a/-b*c", -10.0 / 3.0),
        ("a/+b*c", 10.0 / 3.0),
        ("a*-b+c", -13.0),
        ("2^-c*a", 1.25),
        ("2^-c^2", 0.0625),
        ("2^-c+a", 5.25),
        ("-c^-1*a", -2.5),
        ("--a*b", 15.0),
        ("1e3 + 1E-3 + .5 + 2.", 1002.501),
        ("dead(a, b) + step(x) + pos(-x)", 3.0),
    ] {
        assert!(close(value(text, &xyz), due, 1e-15, 0.0), "{text} = {} but {due} is due", value(text, &xyz));
    }
}

#[test]
fn every_error_with_its_place() {
    let s = str::to_owned;
    check_error("", Kind::Empty, 0..0);
    check_error(" \t\n", Kind::Empty, 0..3);
    check_error("x $ y", Kind::UnknownCharacter('$'), 2..3);
    check_error("x + µ€", Kind::UnknownCharacter('€'), 6..9);
    check_error("ln(", Kind::ExpectedValue(s("the end")), 3..3);
    check_error("x +", Kind::ExpectedValue(s("the end")), 3..3);
    check_error("x + * y", Kind::ExpectedValue(s("`*`")), 4..5);
    check_error("()", Kind::ExpectedValue(s("`)`")), 1..2);
    check_error("max(x,)", Kind::ExpectedValue(s("`)`")), 6..7);
    check_error("||", Kind::ExpectedValue(s("the end")), 2..2);
    check_error("(x", Kind::UnclosedParenthesis, 0..1);
    check_error("ln(x", Kind::UnclosedParenthesis, 2..3);
    check_error("x)", Kind::UnclosedParenthesis, 1..2);
    check_error("2*|x", Kind::UnclosedBar, 2..3);
    check_error("(|x)", Kind::UnclosedBar, 1..2);
    check_error("max(|x, y|)", Kind::UnclosedBar, 4..5);
    check_error("1 + foo(x)", Kind::UnknownFunction(s("foo")), 4..7);
    check_error("gate(x, y)", Kind::UnknownFunction(s("gate")), 0..4);
    check_error("sgn*x", Kind::FunctionWithoutArguments(s("sgn")), 0..3);
    check_error("1 + max(x)", Kind::WrongArguments(s("max"), 2, 1), 4..10);
    check_error("sin()", Kind::WrongArguments(s("sin"), 1, 0), 0..5);
    check_error("sin(x, y)", Kind::WrongArguments(s("sin"), 1, 2), 0..9);
    check_error("2*1e999", Kind::NumberTooLarge, 2..7);
}

#[test]
fn no_implicit_multiplication() {
    let found = |text: &str| Kind::ExpectedOperator(format!("`{text}`"));
    check_error("2x", found("x"), 1..2);
    check_error("x y", found("y"), 2..3);
    check_error("2 3", found("3"), 2..3);
    check_error("(x)(y)", found("("), 3..4);
    check_error("|x||y|", found("|"), 3..4);
    check_error("|x|y", found("y"), 3..4);
    check_error("(x 2)", found("2"), 3..4);
    check_error("2(x)", found("("), 1..2);
    check_error("|(x|)", found("|"), 3..4);
    check_error("0,5*x", found(","), 1..2);
    check_error("(x, y)", found(","), 2..3);
    check_error("1.2.3", found(".3"), 3..5);
}

#[test]
fn messages_say_what_to_do() {
    check_message("2x", "an operator is missing before `x`", "multiplication is written with `*`");
    check_message(
        "0,5",
        "an operator is missing before `,`",
        "a comma only separates arguments; decimals are written with a point",
    );
    check_message("sqr(x)", "unknown function `sqr`", "did you mean `sqrt`?");
    check_message(
        "hypot(x)",
        "unknown function `hypot`",
        "functions: abs, sgn, step, rest, pos, ln, exp, sqrt, sin, cos, tan, tanh, atan, floor, min, max, dead, mod, atan2, hold",
    );
    check_message("sgn", "`sgn` is a function and needs its arguments", "write `sgn(...)`");
    check_message("max(x)", "`max` takes 2 arguments, not 1", "write `max(a, b)`");
    check_message("sin()", "`sin` takes 1 argument, not 0", "write `sin(a)`");
    check_message("", "the expression is empty", "write an expression, such as `0`");
    check_message(
        "#",
        "`#` has no meaning in an expression",
        "there are numbers, names, `+ - * / ^`, parentheses, bars and commas",
    );
    check_message(
        "(",
        "a value is missing before the end",
        "a name or a number stands on both sides of an operator",
    );
    check_message(
        "(x",
        "this parenthesis has no partner",
        "every `(` needs its `)`: add the missing one, or delete this one",
    );
    check_message("|x", "this bar has no partner", "bars come in pairs, as in `|v|`; `abs(v)` says the same");
    check_message("1e400", "this number is too large", "numbers go up to 1.7e308: choose a larger unit");
    check_message(
        &"(".repeat(10_000),
        "nested more than 200 levels deep",
        "name an inner part as a constant, or expand it",
    );
    check_message(
        &"x+".repeat(20_000),
        "the expression has more than 20000 tokens",
        "split it: a candidate for each term, a constant for each number",
    );
}

#[test]
fn names_that_mean_nothing_are_all_listed() {
    let (mut graph, mut names) = (Graph::default(), Names::default());
    let y = names.intern("y");
    let ast = parse("epss + pi*y + F").unwrap();
    let unknown = graph.lower(&ast, |name| (name == "y").then_some(y)).unwrap_err();
    let found: Vec<_> = unknown.iter().map(|u| (u.name.as_str(), u.span.range())).collect();
    assert_eq!(found, [("epss", 0..4), ("F", 14..15)]);
    // Even where the rest would cancel them.
    assert!(graph.lower(&parse("0*q").unwrap(), |_| None).is_err());
    assert_eq!(ast.names().map(|n| n.0).collect::<Vec<_>>(), ["epss", "pi", "y", "F"]);
}

#[test]
fn spans_cover_what_they_mean() {
    let text = "a + |b| * max(c, -d)";
    let ast = parse(text).unwrap();
    let of = |k: usize| &text[ast.nodes[k].span.range()];
    let found: Vec<&str> = (0..ast.nodes.len()).map(of).collect();
    assert_eq!(found, ["a", "b", "|b|", "c", "d", "-d", "max(c, -d)", "|b| * max(c, -d)", text]);
}

/// Deep or long texts are refused with a message or read, on a stack much smaller than any real one.
#[test]
fn no_text_overflows_the_stack() {
    let million = 1_000_000;
    let mut texts: Vec<String> =
        ["(", "|", "-", "+", "x^", "2^-", "ln(", "max(x,", "-(", "((|", "x+(", "x*-", "a-|"]
            .iter()
            .flat_map(|part| [part.repeat(10_000), part.repeat(million / part.len())])
            .collect();
    texts.push("(".repeat(10_000) + "x" + &")".repeat(10_000));
    texts.push("x".repeat(million));
    texts.push("9".repeat(million));
    texts.push(" ".repeat(million));
    texts.push("é".repeat(million / 2) + "(x)");
    texts.push("x+".repeat(million / 2) + "x");
    let small = std::thread::Builder::new().stack_size(256 * 1024);
    let done = small.spawn(move || {
        for text in texts {
            match parse(&text) {
                Ok(ast) => assert_eq!(ast.nodes.len(), 1),
                Err(e) => {
                    assert!(text.get(e.span.range()).is_some());
                    assert!(e.to_string().len() < 120 && e.hint().unwrap_or_default().len() < 120);
                }
            }
        }
    });
    done.unwrap().join().unwrap();
}

#[test]
fn two_hundred_levels_are_allowed() {
    let nested = |n: usize| "(".repeat(n) + "x" + &")".repeat(n);
    assert!(parse(&nested(199)).is_ok());
    check_error(&nested(200), Kind::TooDeep, 200..201);
    // Siblings are not levels.
    assert!(parse(&vec!["(x)^2"; 2000].join("+")).is_ok());
}

proptest! {
    #![proptest_config(cases(5000))]

    #[test]
    fn no_text_panics(text in prop_oneof![any::<String>(), r"[-+*/^(),| .0-9a-eπ€]{0,40}"]) {
        never_panics(&text)?;
    }

    #[test]
    fn no_sequence_of_words_panics(
        words in prop::collection::vec(
            prop::sample::select(vec!["(", ")", "|", ",", "+", "-", "*", "/", "^", "x", "ln(", "max(", "sgn", "2", "1e9", ".", "µ", "€", "  "]),
            0..40,
        )
    ) {
        never_panics(&words.concat())?;
    }
}

/// An error's span can be sliced out of the text, a tree's spans too, and a tree can be built.
fn never_panics(text: &str) -> Result<(), TestCaseError> {
    match parse(text) {
        Err(error) => {
            prop_assert!(text.get(error.span.range()).is_some(), "{text:?}: {error:?}");
            prop_assert!(!error.to_string().is_empty());
            error.hint();
        }
        Ok(ast) => {
            prop_assert!(ast.nodes.iter().all(|n| text.get(n.span.range()).is_some_and(|t| !t.is_empty())));
            let (mut graph, mut names) = (Graph::default(), Names::default());
            let id = graph.lower(&ast, |name| Some(names.intern(name))).unwrap();
            let again = parse(&graph.text(id, &names)).unwrap();
            prop_assert_eq!(graph.lower(&again, |name| Some(names.intern(name))).unwrap(), id);
        }
    }
    Ok(())
}
