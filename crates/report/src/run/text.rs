//! The result of `run` for people: equations as LaTeX (the rest as comments) or as plain text.

use super::adapted;
use super::contribution;
use super::fixed;
use super::report::RunReport;
use crate::equation::{Equation, names_of_records};
use crate::format::role_name as role;
use crate::horizon;
use crate::table::{aligned, interval, short};
use phisindy_learn::{Estimate, Verdict, Warning};

/// Equations as LaTeX, all else as comments.
pub(crate) fn latex(report: &RunReport<'_>) -> String {
    let mut lines: Vec<String> = report.equations.iter().map(|e| e.latex.clone()).collect();
    lines.extend(report.impacts.iter().map(|impact| impact.latex.clone()));
    let comment = |line: String| if line.is_empty() { "%".to_owned() } else { format!("% {line}") };
    lines.extend(details(report).into_iter().map(comment));
    lines.join("\n") + "\n"
}

/// Plain text, equations in the language of the specs.
pub(crate) fn plain(report: &RunReport<'_>) -> String {
    let state = |e: &Equation| &report.input.case.system.states[e.state].name;
    let mut lines: Vec<String> =
        report.equations.iter().map(|e| format!("d{}/dt = {}", state(e), e.text)).collect();
    lines.extend(report.impacts.iter().map(|impact| impact.text.clone()));
    lines.extend(details(report));
    lines.join("\n") + "\n"
}

/// Everything but the equations, as lines.
fn details(report: &RunReport<'_>) -> Vec<String> {
    let found = report.identified;
    let mut lines = vec![String::new()];
    let title = &report.input.case.system.title;
    lines.push(if title.is_empty() {
        report.input.name.to_owned()
    } else {
        format!("{title} ({})", report.input.name)
    });
    let verdict = match &found.verdict {
        Verdict::Identified if found.terms.is_empty() && !report.input.case.system.terms.is_empty() => {
            // What is left may be small and yet no noise.
            match found.warnings.iter().any(Warning::doubts_residual) {
                true => "identified: no term of the dictionary lessens the little that the known part leaves",
                false => "identified: the known part is complete, no term of the dictionary is missing",
            }
            .to_owned()
        }
        verdict => stated(verdict),
    };
    let verdict = match report.ending.stopped_words() {
        Some(stopped) => format!("{stopped} before the end; so far {verdict}"),
        None => verdict,
    };
    lines.push(format!("{verdict} (method {}, {:.1} s)", found.method.name(), report.ending.seconds));
    lines.push(report.basis());
    lines.extend(horizon::words(&found.horizon, &found.records));
    lines.extend(report.planned.iter().map(|planned| planned.sentence.clone()));
    let mut section = |rows: Vec<Vec<String>>| {
        if rows.len() > 1 {
            lines.push(String::new());
            lines.extend(aligned(&rows));
        }
    };
    section(coefficients(report));
    section(contribution::rows(&report.input.case.system, found));
    section(parameters(report));
    section(records(report));
    section(remainder(report));
    section(fixed::moves(&report.fixed));
    let system = &report.input.case.system;
    lines.extend(found.records.iter().filter_map(|record| adapted::words(system, record)));
    lines.extend(fixed::line(&report.fixed));
    let own = names_of_records(&report.input.case.system, &report.equations);
    if !own.is_empty() {
        lines.push(format!("{}: each record has its own", own.join(", ")));
    }
    if !report.warnings.is_empty() {
        lines.push(String::new());
        lines.extend(report.warnings.iter().flat_map(|w| w.lines()).map(|w| format!("warning: {w}")));
    }
    // Titles and names may contain line ends, after which the text would not be a comment.
    lines.into_iter().map(|line| line.replace(['\n', '\r'], " ")).collect()
}

/// The word of a verdict, and why it is no better.
pub(crate) fn stated(verdict: &Verdict) -> String {
    let why = verdict.reason().map_or(String::new(), |why| format!(": {why}"));
    format!("{}{why}", verdict.word())
}

fn coefficients(report: &RunReport<'_>) -> Vec<Vec<String>> {
    let mut rows = vec![words(&[
        "equation",
        "factor",
        "candidate",
        "unit",
        "coefficient",
        "std. error",
        "95 % interval",
    ])];
    if report.identified.terms.iter().any(|found| report.force(found).is_some()) {
        rows[0].push("times inertia".to_owned());
    }
    for found in &report.identified.terms {
        let term = &report.input.case.system.terms[found.term];
        let state = &report.input.case.system.states[term.state].name;
        let unit = term.unit.map_or("-".to_owned(), |unit| unit.to_string());
        let mut row = vec![state.clone(), term.factor_text.clone(), term.candidate.clone(), unit];
        row.extend(estimate(&found.coefficient, 1.0));
        if found.at_bound {
            row[6].push_str(" at its bound");
        }
        row.extend(report.force(found).map(|(force, unit)| format!("{} {unit}", short(force))));
        rows.push(row);
    }
    rows
}

fn parameters(report: &RunReport<'_>) -> Vec<Vec<String>> {
    let mut rows = vec![words(&["parameter", "unit", "value", "std. error", "95 % interval", ""])];
    for p in &report.identified.parameters {
        let mut row = vec![p.id.to_string(), if p.unit.is_empty() { "-".to_owned() } else { p.unit.clone() }];
        row.extend(estimate(&p.estimate, p.factor));
        row.push(if p.at_bound { "at its bound".to_owned() } else { String::new() });
        rows.push(row);
    }
    rows
}

fn records(report: &RunReport<'_>) -> Vec<Vec<String>> {
    let mut rows = vec![words(&["record", "role", "samples", "NRMSE of the free run"])];
    for record in &report.identified.records {
        let errors: Vec<String> =
            record.nrmse.iter().map(|(name, e)| format!("{name} {}", short(*e))).collect();
        let errors = record.failure.as_ref().map_or(errors.join(", "), |why| format!("failed: {why}"));
        rows.push(vec![
            record.name.clone(),
            role(record.role).to_owned(),
            record.samples.to_string(),
            errors,
        ]);
    }
    rows
}

/// The forces that are left.
fn remainder(report: &RunReport<'_>) -> Vec<Vec<String>> {
    let mut rows = vec![words(&["force that is left", "record", "rms", "of the whole", "strongest"])];
    rows.extend(report.remainder().into_iter().map(|(left, rms, unit)| {
        vec![
            format!("on {}", report.input.case.system.states[left.state].name),
            left.record.clone(),
            format!("{} {unit}", short(rms)),
            format!("{:.1} %", 100.0 * left.share),
            format!("{} to {} s", short(left.strongest.0), short(left.strongest.1)),
        ]
    }));
    rows
}

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|w| (*w).to_owned()).collect()
}

/// Value, standard error, interval.
fn estimate(e: &Estimate, factor: f64) -> [String; 3] {
    let interval = interval(e.ci95.0 / factor, e.ci95.1 / factor);
    [short(e.value / factor), short(e.std_error / factor), interval]
}
