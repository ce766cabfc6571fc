//! A rig and what somebody takes it for as the text of a spec: the truth of its records is what the known
//! part lacks.

use super::rig::{Physics, Rig};
use crate::names::substitute;
use std::fmt::Write;

/// Where the friction stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unknown {
    /// In a dictionary, to be found; the second record is there to validate.
    Dictionary,
    /// In the known part with movable coefficients; all records are fitted, and no noise is in them.
    Movable,
}

/// The spec. `known` is what it says of the rig.
pub(super) fn written(rig: &Rig, known: &Physics, title: &str, unknown: Unknown) -> String {
    let count = rig.count();
    let mut constants: Vec<String> =
        known.constants.iter().map(|(name, x)| format!("\"{name}\": {}", number(*x))).collect();
    let mut rates: Vec<String> = (0..count).map(|i| rate(known, i)).collect();
    if unknown == Unknown::Movable {
        for f in &rig.friction {
            let (i, v) = (f.mass + 1, format!("v{}", f.mass + 1));
            // As large as the friction itself, so that what is not there may come in.
            let size = f.terms.iter().fold(0.0_f64, |m, (_, x)| m.max(x.abs()));
            for (k, (candidate, value)) in f.terms.iter().enumerate() {
                let name = format!("f{i}{k}");
                let reach = number(1e6 * size);
                constants.push(format!(
                    "\"{name}\": Find(start: {}, unit: \"\", within: (-{reach}, {reach}))",
                    number(*value)
                ));
                let _ = write!(rates[f.mass], " - {name}*({candidate})*sgn({v})/m{i}");
            }
        }
    }
    let pair = |name: String, text: &str| format!("\"{name}\": \"{text}\"");
    let names = |letter: &str| (1..=count).map(|i| format!("{letter}{i}")).collect::<Vec<_>>();
    let states: Vec<String> = names("x").into_iter().chain(names("v")).map(|n| pair(n, "")).collect();
    let mut all: Vec<String> = (1..=count).map(|i| pair(format!("x{i}"), &format!("v{i}"))).collect();
    all.extend(rates.iter().enumerate().map(|(i, r)| pair(format!("v{}", i + 1), r)));
    let dictionary: Vec<String> = rig
        .friction
        .iter()
        .map(|f| {
            let candidates: Vec<String> = f.terms.iter().map(|(c, _)| format!("\"{c}\"")).collect();
            let i = f.mass + 1;
            format!("\"v{i}\": (factor: \"-sgn(v{i})/m{i}\", candidates: [{}])", candidates.join(", "))
        })
        .collect();
    let contacts: Vec<String> = rig.friction.iter().map(|f| format!("\"v{}\"", f.mass + 1)).collect();
    let mut text =
        format!("// {title}\n(\n    title: \"{title}\",\n    constants: {{ {} }},\n", constants.join(", "));
    let _ = writeln!(text, "    states: {{ {} }},\n    known: {{ {} }},", states.join(", "), all.join(", "));
    if unknown == Unknown::Dictionary {
        let _ = writeln!(text, "    unknown: {{ {} }},", dictionary.join(", "));
    }
    let _ = writeln!(text, "    contacts: [{}],\n    data: [", contacts.join(", "));
    for r in 0..if rig.validated { 2 } else { 1 } {
        text += &record(rig, known, r, unknown);
    }
    text + "    ],\n)\n"
}

fn record(rig: &Rig, known: &Physics, r: usize, unknown: Unknown) -> String {
    let count = rig.count();
    let truth = |i: usize| {
        // What stands in both falls out: a known part that is right lacks the friction alone.
        let (is, said) = (literal(&rig.physics, i), literal(known, i));
        let mut parts = if is == said { vec![] } else { vec![format!("({is}) - ({})", rate(known, i))] };
        for f in rig.friction.iter().filter(|f| f.mass == i) {
            let terms = f.terms.iter().filter(|(_, x)| *x != 0.0);
            let sum: Vec<String> = terms.map(|(c, x)| format!("({x:e})*({c})")).collect();
            let mass = rig.physics.mass(i);
            parts.push(format!("-({})*sgn(v{})/({mass:e})", sum.join(" + "), i + 1));
        }
        let rate = parts.join(" + ").replace("+ -", "- ");
        (!rate.is_empty()).then(|| format!("\"v{}\": \"{rate}\"", i + 1))
    };
    let truths: Vec<String> =
        (0..count).filter(|_| unknown == Unknown::Dictionary).filter_map(truth).collect();
    let (scale, start) = &rig.records[r];
    let names = (1..=count).map(|i| format!("x{i}")).chain((1..=count).map(|i| format!("v{i}")));
    let starts: Vec<String> =
        names.clone().zip(start).map(|(n, x)| format!("\"{n}\": {}", number(*x))).collect();
    let measured: Vec<String> =
        names.take(if rig.velocities { 2 * count } else { count }).map(|n| format!("\"{n}\"")).collect();
    let (role, noise) = match unknown {
        Unknown::Dictionary => {
            let (kind, level) = (if rig.relative { "Relative" } else { "Additive" }, number(rig.noise));
            (["Fit", "Validate"][r], format!("noise: {kind}({level}), seed: {}, ", rig.seed + r as u64))
        }
        Unknown::Movable => ("Fit", String::new()),
    };
    let constants =
        if rig.lines > 0 { format!("constants: {{ \"G\": {} }}, ", number(*scale)) } else { String::new() };
    format!(
        "        Synthetic(name: \"{}\", truth: {{ {} }},\n            start: {{ {} }}, duration: {}, step: {},\n            {constants}{noise}measure: [{}], role: {role}),\n",
        ["first", "second"][r],
        truths.join(", "),
        starts.join(", "),
        number(rig.duration),
        number(rig.step),
        measured.join(", "),
    )
}

/// The rate of a velocity with names of constants.
fn rate(physics: &Physics, mass: usize) -> String {
    let sum = physics.forces[mass].iter().fold(String::new(), |sum, s| {
        let sign = match (s.negative, sum.is_empty()) {
            (true, true) => "-",
            (true, false) => " - ",
            (false, true) => "",
            (false, false) => " + ",
        };
        sum + sign + &s.text
    });
    let sum = if sum.is_empty() { "0".to_owned() } else { sum };
    format!("({sum})/m{}", mass + 1)
}

/// The same with numbers in their place.
fn literal(physics: &Physics, mass: usize) -> String {
    let numbers: Vec<(&str, String)> =
        physics.constants.iter().map(|(name, x)| (name.as_str(), format!("({x:e})"))).collect();
    substitute(&rate(physics, mass), |name| {
        numbers.iter().find(|(n, _)| *n == name).map(|(_, number)| number.as_str())
    })
}

/// The shortest text that reads back as the same number, with a point in it.
fn number(x: f64) -> String {
    format!("{x:?}")
}
