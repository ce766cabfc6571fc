//! Marks of many sets as tables.

use super::mark::{Mark, Verdict, words};
use super::truth::{Placed, Truth};
use crate::markdown::markdown;

/// A set with its marks.
pub(super) struct Marked {
    pub(super) set: String,
    pub(super) truth: Truth,
    pub(super) mark: Mark,
}

/// The largest final gap of an explained set on its Validate record.
const CLEAN: f64 = 1.05;

/// Tables by noise and by law.
pub(super) fn tables(all: &[Marked]) -> String {
    let mut noises: Vec<f64> = all.iter().map(|m| m.truth.noise).collect();
    noises.sort_by(f64::total_cmp);
    noises.dedup();
    let mut rows: Vec<Vec<String>> = noises
        .iter()
        .map(|&noise| row(&format!("{} %", 100.0 * noise), &of(all, |m| m.truth.noise == noise)))
        .collect();
    rows.push(row("all", &of(all, |_| true)));
    for masses in [1, 2] {
        rows.push(row(&format!("{masses} dof"), &of(all, |m| m.truth.masses == masses)));
    }
    rows.push(row("sticking", &of(all, |m| m.truth.sticks && one(m))));
    let mut out = markdown(&with_head("noise"), &rows);
    let mut laws: Vec<String> = all.iter().map(group).collect();
    laws.sort();
    laws.dedup();
    let rows: Vec<Vec<String>> = laws.iter().map(|law| row(law, &of(all, |m| group(m) == *law))).collect();
    out.push('\n');
    out += &markdown(&with_head("hidden"), &rows);
    out
}

/// One line for each failure.
pub(super) fn failures(all: &[Marked]) -> String {
    let mut out = String::new();
    for m in all.iter().filter(|m| !m.mark.good()) {
        let effects: Vec<Placed> =
            m.truth.effects.iter().map(|e| Placed { law: e.law.clone(), at: e.at.clone() }).collect();
        let margin =
            m.truth.margin.map_or(String::new(), |x| format!(", margin {x:.0} to {}", m.truth.nearest));
        let after = m.mark.after.map_or(String::new(), |x| format!(", gap after {x:.3}"));
        out += &format!(
            "{} {:?}: hidden {}; {}: {}{after} ({} %, gap before {:.2}{margin}; {})\n",
            m.set,
            m.mark.verdict,
            words(&effects),
            m.mark.status,
            m.mark.named,
            100.0 * m.truth.noise,
            m.truth.gap_before.validate,
            m.truth.rig,
        );
    }
    for m in all.iter().filter(|m| m.mark.values() == Some(false)) {
        let far: Vec<String> = m
            .mark
            .errors
            .iter()
            .filter(|(_, e)| **e > 0.05)
            .map(|(name, e)| format!("{name} {:.0} %", 100.0 * e))
            .collect();
        out += &format!(
            "{} values: {} ({} %, gap before {:.2})\n",
            m.set,
            far.join(", "),
            100.0 * m.truth.noise,
            m.truth.gap_before.validate
        );
    }
    out
}

fn of(all: &[Marked], keep: impl Fn(&Marked) -> bool) -> Vec<&Marked> {
    all.iter().filter(|m| keep(m)).collect()
}

fn one(m: &Marked) -> bool {
    matches!(m.truth.kind.as_str(), "one" | "two")
}

/// A law by its id, anything else by its kind.
fn group(m: &Marked) -> String {
    match (m.truth.kind.as_str(), m.truth.effects.first()) {
        ("one", Some(effect)) => effect.law.clone(),
        (kind, _) => format!("({kind})"),
    }
}

fn with_head(first: &'static str) -> Vec<&'static str> {
    vec![
        first,
        "sets",
        "named right",
        "by an equivalent",
        "false alarms",
        "unexplained rightly",
        "values within 5 %",
        "the same where all intervals are within 5 %",
        "intervals that hold the truth",
        "gap before (median)",
        "gap after (median, max)",
        "explained, but gap after above 1.05",
        "seconds (mean, max)",
    ]
}

fn row(name: &str, sets: &[&Marked]) -> Vec<String> {
    let part = |n: usize, of: usize| {
        if of == 0 { "-".to_owned() } else { format!("{n} of {of} ({:.1} %)", 100.0 * n as f64 / of as f64) }
    };
    let kind = |kind: &str| sets.iter().filter(|m| m.truth.kind == kind).copied().collect::<Vec<_>>();
    let (nothing, outside) = (kind("nothing"), kind("outside"));
    let named: Vec<&Marked> = sets.iter().filter(|m| one(m)).copied().collect();
    let count = |sets: &[&Marked], f: &dyn Fn(&Marked) -> bool| sets.iter().filter(|m| f(m)).count();
    let values: Vec<bool> = named.iter().filter_map(|m| m.mark.values()).collect();
    let told: Vec<bool> = named.iter().filter(|m| m.mark.told).filter_map(|m| m.mark.values()).collect();
    let intervals = named.iter().fold((0, 0), |s, m| (s.0 + m.mark.intervals.0, s.1 + m.mark.intervals.1));
    let mut before: Vec<f64> = named.iter().map(|m| m.truth.gap_before.validate).collect();
    let explained = |m: &Marked| matches!(m.mark.status.as_str(), "explained" | "described");
    let mut after: Vec<f64> = named.iter().filter(|m| explained(m)).filter_map(|m| m.mark.after).collect();
    let seconds: Vec<f64> = sets.iter().filter_map(|m| m.mark.seconds).collect();
    let number = |x: Option<f64>, digits: usize| x.map_or("-".to_owned(), |x| format!("{x:.digits$}"));
    let most = |x: &[f64]| x.iter().copied().reduce(f64::max);
    let mean = (!seconds.is_empty()).then(|| seconds.iter().sum::<f64>() / seconds.len() as f64);
    vec![
        name.to_owned(),
        sets.len().to_string(),
        part(count(&named, &|m| m.mark.good()), named.len()),
        count(&named, &|m| m.mark.verdict == Verdict::Equivalent).to_string(),
        part(count(&nothing, &|m| m.mark.verdict == Verdict::FalseAlarm), nothing.len()),
        part(count(&outside, &|m| m.mark.good()), outside.len()),
        part(values.iter().filter(|v| **v).count(), values.len()),
        part(told.iter().filter(|v| **v).count(), told.len()),
        part(intervals.1, intervals.0),
        number(median(&mut before), 2),
        format!("{}, {}", number(median(&mut after), 3), number(most(&after), 3)),
        after.iter().filter(|g| **g > CLEAN).count().to_string(),
        format!("{}, {}", number(mean, 1), number(most(&seconds), 1)),
    ]
}

fn median(x: &mut [f64]) -> Option<f64> {
    x.sort_by(f64::total_cmp);
    x.get(x.len() / 2).copied()
}
