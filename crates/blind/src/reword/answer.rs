//! What the program answered, in terms that two answers can be compared by.

use crate::dice::Dice;
use crate::program::Output;
use phisindy_expr::{Graph, Names, Scratch, Tape, parse};
use serde_json::Value;
use std::collections::BTreeMap;

use super::question::put;

/// How exactly two answers must agree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Agree {
    /// The program computes with the same numbers in the same order.
    Bits,
    /// Rounding differs, and with it where the fit stops: costs that differ by less than a millionth of themselves
    /// are one to it (`learn`: `gain`), which in a few thousand samples is a hundredth of what an interval stands for.
    Solver,
    /// Other samples of the same motion: their intervals meet. Which doubt speaks first may hang on the samples, so that
    /// what is not accepted is not accepted, in whatever words.
    Interval,
}

impl Agree {
    /// For a table.
    pub(super) fn word(self) -> &'static str {
        match self {
            Agree::Bits => "to the bit",
            Agree::Solver => "as the fit stops",
            Agree::Interval => "within intervals",
        }
    }
}

/// Value and interval.
type Number = [f64; 3];
/// Part of half an interval within which the fit stops.
const STOPS: f64 = 0.02;

/// Verdict, what was found and where, and its numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Answer {
    verdict: String,
    /// The program's exit code.
    code: Option<i32>,
    /// Whether noise is a part of the reading, and whether readings count from another zero.
    relative: bool,
    moved: bool,
    /// By what it is, in a form that does not depend on its spelling: what is shown, and its numbers.
    found: BTreeMap<String, (String, Vec<Number>)>,
}

/// How names and signs of an answer are turned back.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Back {
    /// Each name that is new or means something else: what it was.
    pub(super) names: Vec<(String, String)>,
    /// Each state whose rate stands for another's.
    pub(super) rates: Vec<(String, String)>,
    /// Whether a coordinate was turned: a law that pushes to one side does so to the other.
    pub(super) turned: bool,
    /// Whether readings count from another zero: noise that is a part of a reading is another one there.
    pub(super) moved: bool,
}

impl Answer {
    /// Of standard output; what stopped the program where there is none.
    pub(super) fn of(said: &Output, back: &Back) -> Answer {
        let code = said.status.and_then(|status| status.code());
        let Ok(json) = serde_json::from_str::<Value>(&said.out) else {
            let why = said.err.lines().find(|line| line.starts_with("error")).unwrap_or_default();
            return Answer {
                verdict: format!("exit code {code:?} {why}"),
                code,
                relative: false,
                moved: back.moved,
                found: BTreeMap::new(),
            };
        };
        let word = |of: &Value| of.as_str().unwrap_or_default().to_owned();
        let verdict = format!("{}{}", word(&json["verdict"]), word(&json["status"]));
        let mut found = BTreeMap::new();
        let mut put_in = |key: String, shown: String, numbers: Vec<Number>| {
            found.insert(key, (shown, numbers));
        };
        for equation in each(&json["equations"]) {
            let state = word(&equation["state"]);
            let rate = back.rates.iter().find(|(new, _)| *new == state).map(|(_, old)| old.clone());
            let rate =
                rate.unwrap_or_else(|| put(&state, &back.names).trim_matches(['(', '-', ')']).to_owned());
            for term in each(&equation["terms"]) {
                let candidate = word(&term["candidate"]);
                let key = format!("{rate}' {}", fingerprint(&put(&candidate, &back.names), false));
                put_in(
                    key,
                    format!("{candidate} in {state}'"),
                    vec![number(&term["coefficient"], &term["ci95"])],
                );
            }
        }
        let mut laws: Vec<String> = vec![];
        for step in each(&json["steps"]) {
            let (law, at) = (word(&step["law"]), word(&step["at"]));
            let parameters = step["parameters"].as_object().into_iter().flatten();
            let numbers = parameters.map(|(_, p)| {
                laws.push(word(&p["constant"]));
                let [value, low, high] = number(&p["value"], &p["ci95"]);
                if back.turned && value < 0.0 { [-value, -high, -low] } else { [value, low, high] }
            });
            let numbers = numbers.collect();
            let key = format!("{law} at {}", fingerprint(&put(&at, &back.names), true));
            put_in(key, format!("{law} at {at}"), numbers);
        }
        for parameter in each(&json["parameters"]) {
            let name = word(&parameter["name"]);
            if !laws.contains(&name) {
                put_in(
                    put(&name, &back.names),
                    name.clone(),
                    vec![number(&parameter["value"], &parameter["ci95"])],
                );
            }
        }
        let relative = json["noise_model"].as_str().is_some_and(|noise| noise != "additive");
        Answer { verdict, code, relative, moved: back.moved, found }
    }

    /// Where two answers disagree, if they do.
    pub(super) fn against(&self, other: &Answer, agree: Agree) -> Option<String> {
        let another = other.moved && (self.relative || other.relative);
        let agree = if another { Agree::Interval } else { agree };
        if agree == Agree::Interval && (self.code, other.code) == (Some(1), Some(1)) {
            return None;
        }
        if self.verdict != other.verdict {
            return Some(format!("{} became {}", self.verdict, other.verdict));
        }
        let only = |a: &Answer, b: &Answer| {
            let all = a.found.iter().filter(|(key, _)| !b.found.contains_key(*key));
            all.map(|(_, (shown, _))| shown.clone()).collect::<Vec<_>>().join(", ")
        };
        let (lost, new) = (only(self, other), only(other, self));
        if !(lost.is_empty() && new.is_empty()) {
            return Some(format!("[{lost}] became [{new}]"));
        }
        self.found.iter().find_map(|(key, (shown, numbers))| {
            let others = &other.found.get(key)?.1;
            let off = numbers.iter().zip(others).find(|(a, b)| !same(a, b, agree))?;
            Some(format!("{shown}: {:?} became {:?}", off.0, off.1))
        })
    }

    /// Whether there is anything to compare.
    pub(super) fn told(&self) -> bool {
        !self.verdict.starts_with("exit code")
    }
}

fn each(list: &Value) -> impl Iterator<Item = &Value> {
    list.as_array().into_iter().flatten()
}

fn number(value: &Value, interval: &Value) -> Number {
    [value, &interval[0], &interval[1]].map(|x| x.as_f64().unwrap_or(f64::NAN))
}

fn same(a: &Number, b: &Number, agree: Agree) -> bool {
    // Without an interval a number is as good as its digits.
    let half = |n: &Number| {
        let half = 0.5 * (n[2] - n[1]);
        if half.is_finite() { half } else { 1e-6 * n[0].abs() }
    };
    let near = |x: f64, y: f64, by: f64| (x - y).abs() <= by || x.is_nan() && y.is_nan() || x == y;
    match agree {
        Agree::Bits => a.map(f64::to_bits) == b.map(f64::to_bits),
        Agree::Solver => (0..3).all(|k| near(a[k], b[k], STOPS * half(a))),
        Agree::Interval => near(a[0], b[0], half(a) + half(b)),
    }
}

/// The values of an expression where each name has a value of its own: the same for each way to write it, and for
/// each sign if `either`. A text that is no expression is its own.
fn fingerprint(text: &str, either: bool) -> String {
    let (mut graph, mut names) = (Graph::default(), Names::default());
    let Ok(ast) = parse(text) else { return text.to_owned() };
    let Ok(root) = graph.lower(&ast, |name| (name != "pi").then(|| names.intern(name))) else {
        return text.to_owned();
    };
    let symbols = graph.symbols(&[root]);
    let inputs: Vec<_> = symbols.iter().map(|&symbol| graph.symbol(symbol)).collect();
    let Ok(tape) = Tape::compile(&graph, &inputs, &[root]) else { return text.to_owned() };
    let mut scratch = Scratch::<1>::new(&tape);
    let values = [0, 1, 2, 3].map(|seed| {
        // Names without a sign first, so that no power or logarithm is without a value.
        let value = |name: &str| Dice::new(seed, name).between(if seed < 2 { 0.1 } else { -2.0 }, 2.0);
        let at: Vec<f64> = symbols.iter().map(|&symbol| value(names.name(symbol))).collect();
        at.into_iter().enumerate().for_each(|(k, x)| scratch.input(k)[0] = x);
        scratch.run();
        scratch.output(0)[0]
    });
    let sign = if either && values[0] < 0.0 { -1.0 } else { 1.0 };
    values.map(|x| format!("{:.8e}", sign * x + 0.0)).join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spelling_does_not_count_but_meaning_does() {
        let is = |text: &str| fingerprint(text, false);
        assert_eq!(is("x1*(v2-v1)"), is("(-v1 + v2)*x1"));
        assert_eq!(is("-v2 + v1"), is("v1-v2"));
        assert_ne!(is("v2-v1"), is("v1-v2"));
        assert_ne!(is("x^2"), is("x"));
        assert_eq!(fingerprint("v2-v1", true), fingerprint("v1-v2", true));
        assert_eq!(is("motion of all"), "motion of all");
    }

    #[test]
    fn numbers_agree_as_exactly_as_they_should() {
        let a = [1.0, 0.9, 1.1];
        let near = |by: f64, agree| same(&a, &a.map(|x| x + by), agree);
        assert!(near(0.0, Agree::Bits) && !near(1e-15, Agree::Bits));
        assert!(near(1e-4, Agree::Solver) && !near(1e-2, Agree::Solver));
        assert!(near(0.15, Agree::Interval) && !near(0.25, Agree::Interval));
    }
}
