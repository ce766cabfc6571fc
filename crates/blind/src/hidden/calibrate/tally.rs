//! Many answers as tables.

use super::answer::{Answer, Said, Standing, class, told};
use super::band::band;
use crate::hidden::made::SEEN;
use crate::hidden::truth::Truth;
use crate::markdown::{markdown, short};
use crate::table::Table;

/// A world with its answer.
pub(super) struct World {
    pub(super) set: String,
    pub(super) truth: Truth,
    pub(super) answer: Answer,
}

/// Ranges of a probability, each up to the next, in words.
const RANGES: [(f64, f64, &str); 4] = [
    (0.99, 1.0, "above 0.99"),
    (0.9, 0.99, "0.9 to 0.99"),
    (0.5, 0.9, "0.5 to 0.9"),
    (0.0, 0.5, "below 0.5"),
];
/// A force differs from every law if the best one leaves more of it.
const APART: f64 = 0.05;

/// Probabilities of a kind of statement.
fn said<'a>(all: &'a [World], of: impl Fn(&'a Answer) -> Vec<Said>) -> Vec<Said> {
    all.iter().flat_map(|w| of(&w.answer)).collect()
}

/// The statements with a probability in a range.
fn within(all: &[Said], (low, high): (f64, f64)) -> Vec<Said> {
    all.iter().filter(|s| s.probability >= low && (s.probability < high || high == 1.0)).copied().collect()
}

/// The statements of each kind: laws at places, and none of these.
fn kinds(all: &[World]) -> [(&'static str, Vec<Said>); 2] {
    [("law", said(all, |a| a.laws.clone())), ("none", said(all, |a| a.none.into_iter().collect()))]
}

/// All tables, and the answers that are wrong with exit 0.
pub(super) fn tally(all: &[World]) -> Table {
    let table = [reliability(all), strangers(all), by_class(all)].join("\n");
    let wrong = |w: &&World| matches!(w.answer.standing, Standing::Wrong | Standing::Failed);
    let failures = all.iter().filter(wrong).map(|w| told(&w.set, &w.truth, &w.answer)).collect();
    Table { name: "calibrate", table, failures }
}

fn reliability(all: &[World]) -> String {
    let mut rows = Vec::new();
    for (kind, all) in kinds(all) {
        for (low, high, words) in RANGES {
            let of = within(&all, (low, high));
            let said: Vec<f64> = of.iter().map(|s| s.probability).collect();
            let due = band(&said);
            let right = of.iter().filter(|s| s.right).count();
            rows.push(vec![
                ["a law at its place", "none of these"][usize::from(kind == "none")].to_owned(),
                words.to_owned(),
                of.len().to_string(),
                if of.is_empty() { "-".into() } else { short(said.iter().sum::<f64>() / said.len() as f64) },
                right.to_string(),
                format!("{} to {}", due.0, due.1),
                if (due.0..=due.1).contains(&right) { "yes" } else { "no" }.to_owned(),
            ]);
        }
    }
    let head =
        ["statement", "probability said", "how often", "in the mean", "right", "due in 95 of 100", "as said"];
    markdown(&head, &rows)
}

/// What is said of forces of no catalogue.
fn strangers(all: &[World]) -> String {
    let apart = |w: &&World| w.truth.apart.is_some_and(|a| a > APART) && !w.answer.whole;
    let some: Vec<&World> = all.iter().filter(apart).collect();
    let shown: Vec<&World> =
        some.iter().filter(|w| w.truth.shown.is_some_and(|s| s > SEEN)).copied().collect();
    let row = |name: &str, of: &dyn Fn(&World) -> bool| {
        let count = |all: &[&World]| format!("{} of {}", all.iter().filter(|w| of(w)).count(), all.len());
        vec![name.to_owned(), count(&some), count(&shown)]
    };
    let none = |w: &World| w.answer.none.is_some_and(|s| s.probability > 0.5);
    let formula = |w: &World| w.answer.standing == Standing::Right;
    let rows = [
        row("P(none) above 0.5", &none),
        row("the force found as a formula", &formula),
        row("one of the two, or exit 1", &|w| {
            none(w) || matches!(w.answer.standing, Standing::Right | Standing::Honest)
        }),
    ];
    let head = ["forces that differ from every law by more than 5 %", "all", "if the records show it"];
    markdown(&head, &rows)
}

fn by_class(all: &[World]) -> String {
    let mut classes: Vec<&str> = all.iter().map(|w| class(&w.truth)).collect();
    classes.sort_unstable();
    classes.dedup();
    let row = |name: &str, of: &dyn Fn(&World) -> bool| {
        let of: Vec<&World> = all.iter().filter(|w| of(w)).collect();
        let count = |standing| of.iter().filter(|w| w.answer.standing == standing).count().to_string();
        let intervals =
            of.iter().map(|w| w.answer.mark.intervals).fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        let seconds: Vec<f64> = of.iter().filter_map(|w| w.answer.mark.seconds).collect();
        vec![
            name.to_owned(),
            of.len().to_string(),
            count(Standing::Right),
            count(Standing::Honest),
            of.iter().filter(|w| w.answer.standing == Standing::Honest && w.answer.whole).count().to_string(),
            count(Standing::Wrong),
            count(Standing::Failed),
            if intervals.0 == 0 { "-".to_owned() } else { format!("{} of {}", intervals.1, intervals.0) },
            format!("{:.0}", seconds.iter().sum::<f64>() / seconds.len().max(1) as f64),
        ]
    };
    let mut rows: Vec<Vec<String>> =
        classes.iter().map(|name| row(name, &|w| class(&w.truth) == *name)).collect();
    rows.push(row("all", &|_| true));
    let head = [
        "hidden",
        "worlds",
        "right",
        "honest (exit 1)",
        "of these with the right laws",
        "wrong with exit 0",
        "no answer",
        "intervals of 95 % that hold the truth",
        "seconds",
    ];
    markdown(&head, &rows)
}

/// The counts that reports quote: for each kind of statement and range of probability, how many there were and how many were
/// right.
pub(super) fn counts(all: &[World], seed: u64) -> String {
    let count = all.len();
    let mut out = format!(
        "# phisindy-blind calibrate --sets {count} --seed {seed} --table FILE\nworlds {count}\n\
         # statement, probability from, to, simulated cases, right\n"
    );
    for (kind, all) in kinds(all) {
        for (low, high, _) in RANGES {
            let of = within(&all, (low, high));
            let right = of.iter().filter(|s| s.right).count();
            out += &format!("{kind} {low} {high} {} {right}\n", of.len());
        }
    }
    out
}
