//! The report of `run`.

use super::page::{Banner, Page, Tone, add_data_remarks, add_warnings, paragraph, sentence};
use super::table::{Cell, code, estimate, in_unit, parameters, table, text, unit};
use super::{correlation, friction, hero, mathml, motion, next, reproduction, residual, selection};
use crate::chart::{Sheet, digits};
use crate::equation::names_of_records;
use crate::format::{capital, role_name as role};
use crate::horizon;
use crate::input::Invocation;
use crate::markup::{Element, element};
use crate::run::{RunReport, found_words};
use crate::seen::Seen;
use crate::sketch;
use phisindy_learn::{RecordFit, Verdict};
use phisindy_phys::spec::Role;

/// The page.
pub(crate) fn page(report: &RunReport<'_>, invocation: &Invocation) -> Page {
    let (input, case, found) = (report.input, report.input.case, report.identified);
    let seen = report.seen();
    let mut page = Page::new(input, banner(report));
    if let Verdict::Rejected(why) = &found.verdict {
        next::add(&mut page, &next::after_rejection(why, input.name));
    }
    first_screen(&mut page, report, &seen);
    page.sketch(sketch::of_run(report));
    let planned = report.planned.iter().map(|planned| sentence(&planned.sentence)).collect::<Vec<_>>();
    page.list("The planned run", &planned);
    add_warnings(&mut page, &report.warnings);
    page.section("Equation", equations(report));
    page.section("Coefficients", coefficients(report));
    page.section("Parameters", parameters(&found.parameters));
    page.figures("Measured against simulated", |sheet| motion::charts(&seen, sheet));
    page.figures("How far it predicts", |sheet| {
        horizon::chart(&found.horizon, &found.records, sheet).into_iter().collect()
    });
    page.section("Records", records(report));
    page.section("Numbers of their own", adapted(report));
    page.figures("What is left", |sheet| residual::charts(&seen, sheet));
    page.figures("Choice of terms", |sheet| selection::chart(found, sheet).into_iter().collect());
    page.figures("What the data can tell apart", |sheet| {
        correlation::chart(&case.system, found, sheet).into_iter().collect()
    });
    add_data_remarks(&mut page, input.doubts, &report.notes);
    reproduction::add(&mut page, input, invocation);
    page
}
/// The finding in pictures: the motion, and the friction against velocity.
fn first_screen(page: &mut Page, report: &RunReport<'_>, seen: &Seen<'_>) {
    let (case, records) = (report.input.case, report.input.records);
    let friction = |sheet| friction::charts(case, records, report.identified, sheet);
    let forces = page.drawn(Sheet::Half, friction);
    // The motion stands beside one picture of a force, or above several.
    let sheet = if forces.len() == 1 { Sheet::Half } else { Sheet::Full };
    let motion = page.drawn(sheet, |sheet| hero::chart(seen, None, sheet).into_iter().collect());
    if sheet == Sheet::Half {
        page.first(motion.into_iter().chain(forces).collect(), vec![]);
    } else {
        page.first(
            vec![],
            vec![element("div").class("full").all(motion), element("div").class("pair").all(forces)],
        );
    }
}

fn banner(report: &RunReport<'_>) -> Banner {
    let found = report.identified;
    let worst = |role: Role| {
        let of = found.records.iter().filter(|r| r.role == role);
        of.max_by(|a, b| a.worst().total_cmp(&b.worst()))
            .map(|r| (digits(100.0 * r.worst(), 2), noises(report, r)))
    };
    let fit = worst(Role::Fit)
        .map(|(e, noise)| format!("{e} % of its standard deviation{noise} where it was fitted"));
    let validate =
        worst(Role::Validate).map(|(e, noise)| format!("{e} %{noise} where it was only predicted"));
    let errors: Vec<String> = fit.into_iter().chain(validate).collect();
    let how = format!(
        "{}Method {}, {} s.",
        report
            .ending
            .stopped_words()
            .map_or(String::new(), |stopped| format!("{} before the end. ", capital(&stopped))),
        found.method.name(),
        digits(report.ending.seconds, 2),
    );
    let headline = capital(found.verdict.word());
    let ended = |why: String| format!("{}{}", capital(&why), if why.ends_with('?') { "" } else { "." });
    let reason = found.verdict.reason().map(ended);
    if !found.verdict.holds() {
        return Banner { tone: Tone::Bad, headline, text: reason.unwrap_or_default(), how };
    }
    let missed = format!(
        "{}. Run freely, the model misses the motion by at most {}.",
        capital(&found_words(report)),
        errors.join(" and ")
    );
    let text = reason.map_or(missed.clone(), |why| format!("{missed} {why}"));
    Banner { tone: Tone::Good, headline, text, how }
}

/// What a free run leaves of the worst column of a record, in units of its noise: ` (1.0 times its noise)`.
fn noises(report: &RunReport<'_>, record: &RecordFit) -> String {
    let system = &report.input.case.system;
    let worst = record.nrmse.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    let ratio = worst.and_then(|(column, _)| {
        let noise = record.noise.iter().find(|(name, _)| name == column)?.1;
        let left = record.residuals.get(system.column(column)?)?;
        let rms = (left.iter().map(|e| e * e).sum::<f64>() / left.len().max(1) as f64).sqrt();
        Some(rms / noise).filter(|x| x.is_finite() && *x > 0.0)
    });
    ratio.map_or(String::new(), |x| format!(" ({} times its noise)", digits(x, 2)))
}

fn equations(report: &RunReport<'_>) -> Vec<Element> {
    let mut out: Vec<Element> = report.equations.iter().map(|e| mathml::equation(&e.latex)).collect();
    out.extend(report.impacts.iter().map(|impact| mathml::equation(&impact.latex)));
    let own = names_of_records(&report.input.case.system, &report.equations);
    if !own.is_empty() {
        out.push(paragraph(&format!("Each record has its own {}.", own.join(", "))));
    }
    out
}

fn coefficients(report: &RunReport<'_>) -> Option<Element> {
    let system = &report.input.case.system;
    let forces = report.identified.terms.iter().any(|f| report.force(f).is_some());
    let mut head =
        vec!["equation", "factor", "candidate", "unit", "coefficient", "std. error", "95 % interval"];
    head.extend(forces.then_some("times inertia"));
    let rows = report.identified.terms.iter().map(|f| {
        let term = &system.terms[f.term];
        let state = &system.states[term.state].name;
        let dimension = term.unit.map_or(String::new(), |unit| unit.to_string());
        let mut row = vec![code(state), code(&term.factor_text), code(&term.candidate), in_unit(&dimension)];
        row.extend(estimate(&f.coefficient, 1.0));
        if forces {
            let force = report.force(f);
            row.push(force.map_or(text("–"), |(value, dimension)| {
                text(format!("{} {}", digits(value, 5), unit(&dimension.to_string())))
            }));
        }
        row
    });
    table("Identified coefficients", &head, rows.collect())
}

fn records(report: &RunReport<'_>) -> Option<Element> {
    let system = &report.input.case.system;
    let mut rows = Vec::new();
    for record in &report.identified.records {
        let samples = record.samples.to_string();
        let mut row = |cells: [Cell; 4]| {
            let front = [text(&record.name), text(role(record.role)), text(&samples)];
            rows.push(front.into_iter().chain(cells).collect());
        };
        if let Some(why) = &record.failure {
            row([text("–"), text(format!("failed: {why}")), text("–"), text("–")]);
        }
        for ((column, nrmse), (_, noise)) in record.nrmse.iter().zip(&record.noise) {
            let index = system.column(column);
            let (factor, unit) = index.map_or((1.0, ""), |k| (system.factor(k), system.measured(k).1));
            row([code(column), Cell::Number(*nrmse), Cell::Number(noise / factor), in_unit(unit)]);
        }
    }
    let head = ["record", "role", "samples", "column", "NRMSE of the free run", "noise (std. dev.)", "unit"];
    table("Records and how the model does on them", &head, rows)
}

/// What Validate records were given of their own.
fn adapted(report: &RunReport<'_>) -> Option<Element> {
    let system = &report.input.case.system;
    let mut rows = Vec::new();
    for record in &report.identified.records {
        let Some(adapted) = &record.adapted else { continue };
        let own = adapted.values.iter().map(|v| (v.id.of.to_string(), v.value / v.factor, v.unit.as_str()));
        let start = system.states.iter().zip(&record.start);
        let start = start.map(|(s, x)| (format!("{} at the start", s.name), x / s.factor, s.unit.as_str()));
        let (from, until) = adapted.span;
        for (name, value, unit) in own.chain(start) {
            let part = Cell::Interval(from, until);
            rows.push(vec![text(&record.name), code(name), in_unit(unit), Cell::Number(value), part]);
        }
    }
    let head = ["record", "number", "unit", "value", "adapted on (s)"];
    table("What Validate records were given of their own; only what follows is scored", &head, rows)
}
