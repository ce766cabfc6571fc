//! Random rigs with laws of the catalogue, one of them taken for unknown: data without noise give its numbers
//! back, or the result says why not.
//!

//! A few dozen in the ordinary tests; `PHISINDY_MODELS=1000` makes it a thousand.

use crate::common;
use crate::random::{Acting, Dice, Rig};
use phisindy_learn::{Identified, LearnOptions, Verdict, identify};
use rayon::prelude::*;
use std::fmt::Write;
use std::ops::ControlFlow;
use std::time::Instant;

const MODELS: u64 = 6;

fn models() -> std::ops::Range<u64> {
    let wanted =
        std::env::var("PHISINDY_MODELS").ok().map(|n| n.parse().expect("PHISINDY_MODELS is a number"));
    0..wanted.unwrap_or(MODELS)
}

/// A law as factor and candidates with their coefficients; `None` if it is not linear in them. What bends it
/// is given.
fn dictionary(law: &Acting) -> Option<(String, Vec<(String, f64)>)> {
    let (x, v) = (format!("({})", law.place.named("x")), format!("({})", law.place.named("v")));
    let p = |name: &str| law.number(name);
    let friction = format!("sgn({v})");
    let one = |text: &str, value: f64| vec![(text.to_owned(), value)];
    Some(match law.id {
        "viscous" => ("1".to_owned(), one(&v, p("dc"))),
        "stiffness" => ("1".to_owned(), one(&x, p("dk"))),
        "quadratic-drag" => ("1".to_owned(), one(&format!("{v}*|{v}|"), p("d"))),
        "cubic-stiffness" => ("1".to_owned(), one(&format!("{x}^3"), p("k3"))),
        "quadratic-stiffness" => ("1".to_owned(), one(&format!("{x}^2"), p("k2"))),
        "coulomb" => (friction, one("1", p("Fc"))),
        "stribeck" => {
            let bend = format!("exp(-({v}/{:e})^2)", p("vs"));
            (friction, vec![("1".to_owned(), p("Fc")), (bend, p("Fs") - p("Fc"))])
        }
        "position-dependent-friction" => {
            (friction, vec![("1".to_owned(), p("F0")), (x.clone(), p("F1")), (format!("{x}^2"), p("F2"))])
        }
        _ => return None,
    })
}

/// The spec of a rig in which a law is unknown, and the true coefficients of its dictionary.
fn spec(rig: &Rig, unknown: usize) -> Option<(String, Vec<f64>)> {
    let law = &rig.laws[unknown];
    let (factor, terms) = dictionary(law)?;
    let names = rig.names();
    let list = |pairs: Vec<(String, String)>| {
        pairs.into_iter().map(|(a, b)| format!("\"{a}\": {b}")).collect::<Vec<_>>().join(", ")
    };
    let quoted = |text: &str| format!("\"{text}\"");
    let rates = rig.rates(&|k| k == unknown);
    let known: Vec<_> = names.iter().cloned().zip(rates.iter().map(|r| quoted(r))).collect();
    // A law between two bodies stands in two equations; a dictionary finds one of each.
    if law.place.other.is_some() {
        return None;
    }
    let body = law.place.body;
    let (velocity, mass) = (format!("v{}", body + 1), rig.mass[body]);
    let candidates: Vec<String> = terms.iter().map(|(c, _)| quoted(c)).collect();
    let truth = terms.iter().fold(String::new(), |mut sum, (c, a)| {
        let _ = write!(sum, " - ({a:e})*({c})*{factor}/{mass}");
        sum
    });
    let mut contacts: Vec<String> =
        rig.laws.iter().filter(|l| l.holds()).map(|l| quoted(&l.place.named("v").replace(' ', ""))).collect();
    contacts.sort();
    contacts.dedup();
    let text = format!(
        "(constants: {{}}, states: {{ {} }}, known: {{ {} }}, unknown: {{ \"{velocity}\": (factor: \"-{factor}/{mass}\", candidates: [{}]) }}, contacts: [{}],
          data: [Synthetic(truth: {{ \"{velocity}\": \"0{truth}\" }}, start: {{ {} }}, duration: 20.0, step: 0.04)])",
        list(names.iter().map(|x| (x.clone(), quoted(""))).collect()),
        list(known),
        candidates.join(", "),
        contacts.join(", "),
        list(names.iter().cloned().zip(rig.start.iter().map(|x| format!("{x:?}"))).collect()),
    );
    Some((text, terms.into_iter().map(|(_, a)| a).collect()))
}

/// Whether the result says that it should not be believed.
fn doubted(found: &Identified) -> bool {
    matches!(found.verdict, Verdict::Rejected(_)) || !found.warnings.is_empty()
}

/// What became of a model.
enum Outcome {
    Right,
    /// The result says that, and why, it should not be believed.
    Told(String),
    Wrong(String),
}

/// The first rig of this seed that has a law to be found, identified.
fn outcome(seed: u64) -> Outcome {
    let mut dice = Dice::new(seed.wrapping_add(1 << 32));
    let (rig, (text, truth)) = (0..1000)
        .find_map(|_| {
            let rig = Rig::draw(&mut dice);
            let made = (0..rig.laws.len()).find_map(|k| spec(&rig, k))?;
            Some((rig, made))
        })
        .expect("a rig with a law to be found");
    let (case, records) = common::load_text(&text, &[]);
    let found = match identify(&case, &records, &LearnOptions::default(), &mut |_| ControlFlow::Continue(()))
    {
        Err(why) => {
            return Outcome::Told(format!("{seed}: {why}\n{text}"));
        }
        Ok(found) => found,
    };
    let term = |t: usize| found.terms.iter().find(|f| f.term == t).map(|f| &f.coefficient);
    let value = |t: usize| term(t).map_or(0.0, |c| c.value);
    let size = truth.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    // A hundredth of the law, or what its interval allows.
    let off = |(t, x): (usize, &f64)| {
        let reach = term(t).map_or(0.0, |c| 0.5 * (c.ci95.1 - c.ci95.0));
        (value(t) - x).abs() > (0.01 * size).max(2.0 * reach)
    };
    if !truth.iter().enumerate().any(off) {
        Outcome::Right
    } else if doubted(&found) {
        Outcome::Told(format!("{seed}: {:?} {:?}", found.verdict, found.warnings))
    } else {
        let got: Vec<f64> = (0..truth.len()).map(value).collect();
        Outcome::Wrong(format!("{seed}: {got:?} in place of {truth:?}\n{rig:?}\n{text}"))
    }
}

#[test]
#[expect(clippy::print_stderr, reason = "a thousand take minutes: how far it is")]
fn clean_data_give_the_truth_back_or_the_reason_why_not() {
    let (mut right, mut told, mut wrong) = (0, Vec::new(), Vec::new());
    let outcomes: Vec<Outcome> = models()
        .into_par_iter()
        .map(|seed| {
            let start = Instant::now();
            let outcome = outcome(seed);
            eprintln!("{seed} {:.1} s", start.elapsed().as_secs_f64());
            outcome
        })
        .collect();
    for outcome in outcomes {
        match outcome {
            Outcome::Right => right += 1,
            Outcome::Told(why) => told.push(why),
            Outcome::Wrong(what) => wrong.push(what),
        }
    }
    eprintln!("{right} right, {} told, {} wrong", told.len(), wrong.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    assert!(right * 4 >= models().end * 3, "{right} right; {}", told.join("\n"));
}
