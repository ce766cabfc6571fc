//! The result of `gap` at a terminal.

use super::finding::{counted, finding, symbol};
use super::outcome::basis;
use super::report::GapReport;
use super::text::{bar, rivals};
use crate::format::capital;
use crate::run::terminal_warnings;
use crate::stretch::series;
use crate::table::{raised, short, with_error};
use crate::terminal::braille::plot;
use crate::terminal::{Ink, Look, unicode};
use phisindy_gap::{Gap, Step};

/// Laws that were tried and are listed.
const LISTED: usize = 5;

/// The text.
pub(crate) fn text(report: &GapReport<'_>, look: Look) -> String {
    let found = report.gap;
    let finding = finding(found);
    let ink = if found.status.holds() { Ink::Good } else { Ink::Open };
    let stopped = report.ending.stopped_words().map_or(String::new(), |s| format!(" ({s} before the end)"));
    let head = format!("{}{stopped}", look.ink(ink, &finding.headline.to_lowercase()));
    let seconds = look.ink(Ink::Faint, &format!("{:.1} s", report.ending.seconds));
    let mut out = vec![format!("{head}  {seconds}"), look.wrapped(&finding.sentence, 2), String::new()];
    out.extend(bars(found, look));
    out.push(String::new());
    for (k, s) in found.steps.iter().enumerate() {
        out.extend(step(report, s, &format!("{}.", k + 1), look));
    }
    if !found.partial.is_empty() {
        out.push("helps, but does not explain:".to_owned());
        found.partial.iter().for_each(|s| out.extend(step(report, s, " ", look)));
    }
    out.extend(tried(report, look));
    let plot = plot(series(&report.seen(), found.located.first().map(|r| r.column.as_str())), look);
    out.extend((!plot.is_empty()).then(String::new));
    out.extend(plot);
    if let Some(planned) = report.planned {
        out.extend([String::new(), look.wrapped(&planned.sentence, 2)]);
    }
    // A law that is ruled out stands among those that were tried.
    let warnings = report.notes().filter(|w| !matches!(w, phisindy_gap::Warning::Vetoed(_)));
    let warnings: Vec<String> =
        found.alternative.iter().map(ToString::to_string).chain(warnings.map(ToString::to_string)).collect();
    out.extend(terminal_warnings(&warnings, look));
    out.join("\n").trim_end().to_owned() + "\n"
}

fn bars(found: &Gap, look: Look) -> Vec<String> {
    let before = counted(found.before);
    let mut out = vec![format!("gap {}, in units of the noise (1 is perfect)", basis(found))];
    let line = |value: f64, ink: Ink, words: &str| {
        format!("  {:>8}  {}  {words}", short(three(value)), look.ink(ink, &bar(value, before)))
    };
    out.push(line(before, Ink::Before, "the model as it is"));
    for s in found.steps.iter().chain(&found.partial) {
        let after = s.validate.map_or(s.fit.1, |v| v.1);
        out.push(line(after, Ink::Model, &format!("+ {} at {}", s.effect.entry.law.name, s.effect.place.at)));
    }
    out
}

fn step(report: &GapReport<'_>, s: &Step, mark: &str, look: Look) -> Vec<String> {
    let name = format!("{mark} {} at {}", capital(&s.effect.entry.law.name), s.effect.place.at);
    let head = format!("{}: {}", look.ink(Ink::Strong, &name), unicode::expression(&s.expression, &[]));
    let mut out = vec![look.wrapped(&head, 3).trim_start().to_owned()];
    for p in &s.parameters {
        let line = |record: &str, value: f64, ci: (f64, f64)| {
            let shown = with_error(value, 0.5 * (ci.1 - ci.0).abs());
            format!("     {}{record} = {shown} {}", unicode::name(symbol(s, p)), raised(&p.unit))
                .trim_end()
                .to_owned()
        };
        if p.each.is_empty() {
            out.push(line("", p.value, p.ci95));
        }
        out.extend(p.each.iter().map(|r| line(&format!(" [{}]", r.record), r.value, r.ci95)));
    }
    for (rival, what) in rivals(s, report.catalogue) {
        let what = what.map_or(String::new(), |what| format!("; {what}"));
        out.push(look.ink(Ink::Faint, &look.wrapped(&format!("{rival}{what}"), 5)));
    }
    out
}

/// The best laws that were tried by themselves, and how many more.
fn tried(report: &GapReport<'_>, look: Look) -> Vec<String> {
    let found = report.gap;
    let name =
        |id: &str| report.catalogue.iter().find(|e| e.id == id).map_or(id.to_owned(), |e| e.law.name.clone());
    let fitted: Vec<String> = found
        .tried
        .iter()
        .filter_map(|t| {
            let gap = short(three(t.gap?));
            let out = t.vetoed.as_ref().map_or(String::new(), |why| format!(", ruled out: {why}"));
            let words = look.wrapped(&format!("{} at {}{out}", name(&t.at.law), t.at.at), 15);
            Some(format!("     {gap:>8}  {}", words.trim_start()))
        })
        .collect();
    if fitted.is_empty() {
        return vec![];
    }
    let more = found.tried.len() - fitted.len().min(LISTED);
    let mut out = vec![look.ink(Ink::Faint, "alone, each law leaves:")];
    out.extend(fitted.into_iter().take(LISTED));
    if more > 0 {
        out.push(look.ink(Ink::Faint, &format!("     and {more} more laws and places that do less")));
    }
    out
}

/// Three significant digits.
fn three(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}
