//! The result of `run` at a terminal.

use super::report::RunReport;
use crate::format::role_name;
use crate::stretch::series;
use crate::table::{aligned, raised, short, with_error};
use crate::terminal::braille::plot;
use crate::terminal::{Ink, Look, unicode};
use phisindy_learn::{Estimate, Verdict};

/// The text.
pub(crate) fn text(report: &RunReport<'_>, look: Look) -> String {
    let (found, system) = (report.identified, &report.input.case.system);
    let mut out = vec![verdict(report, look), look.ink(Ink::Faint, &look.wrapped(&report.basis(), 2))];
    if !report.equations.is_empty() {
        out.push(String::new());
    }
    let half = |e: &Estimate| 0.5 * (e.ci95.1 - e.ci95.0).abs();
    let terms = found.terms.iter().map(|f| (f.coefficient.value, half(&f.coefficient)));
    let numbers = terms.chain(found.parameters.iter().map(|p| (p.estimate.value, half(&p.estimate))));
    let numbers: Vec<(f64, f64)> = numbers.collect();
    for e in &report.equations {
        let left = unicode::rate(&system.states[e.state].name);
        let right = look.wrapped(&unicode::expression(&e.text, &numbers), left.chars().count() + 4);
        out.push(format!("  {} = {}", look.ink(Ink::Strong, &left), right.trim_start()));
    }
    let mut rows = Vec::new();
    for f in &found.terms {
        let term = &system.terms[f.term];
        let unit = term.unit.map_or(String::new(), |u| raised(&u.to_string()));
        let what = match (term.factor_text.as_str(), term.candidate.as_str()) {
            ("1", candidate) => candidate.to_owned(),
            (factor, "1") => factor.to_owned(),
            (factor, candidate) => format!("{factor}·{candidate}"),
        };
        let bound = if f.at_bound { "at its bound".to_owned() } else { String::new() };
        // A force, where the inertia is known.
        let (value, unit) = match report.force(f) {
            Some((force, dimension)) => {
                let scale = (force / f.coefficient.value).abs();
                (with_error(force, half(&f.coefficient) * scale), raised(&dimension.to_string()))
            }
            None => (with_error(f.coefficient.value, half(&f.coefficient)), unit),
        };
        rows.push(vec![format!("  {}", unicode::expression(&what, &[])), value, unit, bound]);
    }
    for p in &found.parameters {
        let value = with_error(p.estimate.value / p.factor, half(&p.estimate) / p.factor);
        let bound = if p.at_bound { "at its bound".to_owned() } else { String::new() };
        rows.push(vec![format!("  {}", p.id), value, raised(&p.unit), bound]);
    }
    if !rows.is_empty() {
        out.push(String::new());
        out.extend(aligned(&rows));
    }
    let records = found.records.iter().map(|r| {
        let errors: Vec<String> =
            r.nrmse.iter().map(|(name, e)| format!("{name} {}", short(three(*e)))).collect();
        let errors = r.failure.as_ref().map_or(errors.join(", "), |why| format!("failed: {why}"));
        vec![format!("  {}", r.name), role_name(r.role).to_owned(), format!("NRMSE {errors}")]
    });
    let records: Vec<Vec<String>> = records.collect();
    if !records.is_empty() {
        out.push(String::new());
        out.extend(aligned(&records));
    }
    let plot = plot(series(&report.seen(), None), look);
    out.extend((!plot.is_empty()).then(String::new));
    out.extend(plot);
    out.extend(report.planned.iter().map(|planned| look.wrapped(&planned.sentence, 2)));
    out.extend(warnings(&report.warnings, look));
    out.join("\n").trim_end().to_owned() + "\n"
}

/// Each warning once, set off.
pub(crate) fn warnings(all: &[String], look: Look) -> Vec<String> {
    let mut told: Vec<&String> = vec![];
    for warning in all {
        if !told.contains(&warning) {
            told.push(warning);
        }
    }
    let line = |w: &&String| look.wrapped(&format!("{} {w}", look.ink(Ink::Open, "warning:")), 0);
    told.iter().map(line).collect()
}

fn verdict(report: &RunReport<'_>, look: Look) -> String {
    let found = report.identified;
    let word = match &found.verdict {
        Verdict::Identified if found.terms.is_empty() && !report.input.case.system.terms.is_empty() => {
            look.ink(Ink::Good, "identified: nothing of the dictionary is missing")
        }
        verdict => {
            let ink = if verdict.holds() { Ink::Good } else { Ink::Bad };
            match verdict.reason() {
                Some(why) => format!("{} {why}", look.ink(ink, &format!("{}:", verdict.word()))),
                None => look.ink(ink, verdict.word()),
            }
        }
    };
    let stopped =
        report.ending.stopped_words().map_or(String::new(), |s| format!("{s} before the end; so far "));
    let title = &report.input.case.system.title;
    let title = if title.is_empty() { report.input.name } else { title };
    let how = format!("method {}, {:.1} s", found.method.name(), report.ending.seconds);
    let words = format!("{stopped}{word}: {}, {}", look.ink(Ink::Strong, title), look.ink(Ink::Faint, &how));
    look.wrapped(&words, 0)
}

/// Three significant digits.
fn three(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}
