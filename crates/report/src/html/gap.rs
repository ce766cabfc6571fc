//! The report of `gap`.

use super::data::{Model, Seen, notes};
use super::page::{Banner, Page, Tone, add_remarks, capital, paragraph};
use super::table::{Cell, code, in_unit, parameters, table, text};
use super::{force, map, mathml, motion, reproduction, residual, shrink};
use crate::chart::digits;
use crate::equation::equations;
use crate::format::role_name as role;
use crate::gap::{GapReport, outcome, rivals, vetoes};
use crate::input::{Ending, Invocation};
use crate::markup::{Element, element};
use phisindy_gap::{ColumnGap, ColumnRepeat, Gap, Region, Status, Step};
use phisindy_phys::{LawEntry, SourceId, check_names, spec};

/// The page.
pub(crate) fn page(report: &GapReport<'_>, invocation: &Invocation) -> Page {
    let GapReport { input, gap: found, catalogue, ending } = *report;
    let (was, now) = (&found.initial, &found.simulated);
    let seen = Seen {
        system: &input.case.system,
        records: input.records,
        was: (!found.steps.is_empty()).then(|| Model::new(&was.system, &[], &was.records)),
        model: Some(Model::new(&now.system, &[], &now.records)),
    };
    let mut page = Page::new(input, banner(found, ending));
    let warnings: Vec<String> = found.warnings.iter().map(ToString::to_string).collect();
    add_remarks(&mut page, &warnings, input.doubts, &notes(input));
    page.figures("The gap", vec![shrink::chart(found)]);
    // A remark that applies to several steps is made once.
    let mut told = Vec::new();
    let mut missing = Vec::new();
    for (k, step) in found.steps.iter().enumerate() {
        let picture = force::chart(found, k + 1, step, input.records);
        let picture = picture.map(|(chart, said)| page.figure(chart, &said));
        missing.extend(shown(Some(k + 1), step, catalogue, picture, &mut told));
    }
    let whole = found.status != Status::Unexplained;
    page.section(if whole { "What is missing" } else { "What brings the gap far down" }, missing);
    let mut helps = Vec::new();
    for step in &found.partial {
        helps.extend(shown(None, step, catalogue, None, &mut told));
    }
    page.section("What helps, but does not explain", helps);
    if !found.steps.is_empty() || !found.partial.is_empty() {
        page.section("The completed equation", completed(found));
    }
    let maps: Vec<Element> =
        map::charts(&seen, &found.noise).into_iter().map(|(chart, said)| page.figure(chart, &said)).collect();
    page.section("Where the gap sits", located(found).into_iter().chain(maps));
    page.figures("Measured against simulated", motion::charts(&seen));
    page.section("Records", [records(found), repeatability(found)].into_iter().flatten());
    page.figures("What is left", residual::charts(&seen));
    page.section("Parameters", parameters(&found.parameters));
    reproduction::add(&mut page, input, invocation);
    page
}

fn banner(found: &Gap, how: Ending) -> Banner {
    let (tone, headline) = match found.status {
        Status::NothingMissing => (Tone::Good, "Nothing missing"),
        Status::Explained => (Tone::Good, "Explained"),
        Status::Described => (Tone::Good, "Described by a formula"),
        Status::Unexplained => (Tone::Open, "Unexplained"),
    };
    let stopped = how
        .stopped_words()
        .map_or(String::new(), |stopped| format!(" {} before the end.", capital(&stopped)));
    Banner {
        tone,
        headline: headline.to_owned(),
        text: format!("{}. {} s.{stopped}", capital(&outcome(found)), digits(how.seconds, 2)),
    }
}

/// A step: law, place, parameters, picture, and the remarks about rivals and vetoes that are not in `told`.
fn shown(
    number: Option<usize>,
    s: &Step,
    catalogue: &[LawEntry],
    picture: Option<Element>,
    told: &mut Vec<String>,
) -> Vec<Element> {
    let number = number.map_or(String::new(), |k| format!("{k}. "));
    let name = &s.effect.entry.law.name;
    let heading =
        element("h3").text(format!("{number}{name} at ")).add(element("code").text(&s.effect.place.at));
    let added = element("p").text("Added: ").add(element("code").text(&s.expression));
    let load = s.effect.load.as_ref().map(|load| paragraph(&format!("Its levels scale with {load}.")));
    let gains = [("fitted records", Some(s.fit)), ("validate records", s.validate)];
    let gains = gains.into_iter().filter_map(|(which, pair)| pair.map(|p| (which, p)));
    let gains: Vec<String> =
        gains.map(|(which, (a, b))| format!("{} → {} on {which}", digits(a, 3), digits(b, 3))).collect();
    let gain = format!("Gap {}; the criterion falls by {}.", gains.join(", "), digits(s.delta_bic, 3));
    let row = |p: &phisindy_gap::StepParameter, constant: String, value: f64, ci95: (f64, f64)| {
        vec![
            code(&p.name),
            code(&constant),
            Cell::Number(value),
            Cell::Interval(ci95.0, ci95.1),
            in_unit(&p.unit),
        ]
    };
    let rows = s.parameters.iter().flat_map(|p| {
        let shared = p.each.is_empty().then(|| row(p, p.constant.clone(), p.value, p.ci95));
        let each = p.each.iter().map(|r| row(p, format!("{} [{}]", p.constant, r.record), r.value, r.ci95));
        shared.into_iter().chain(each).collect::<Vec<_>>()
    });
    let head = ["parameter", "constant of the spec", "value", "95 % interval", "unit"];
    let numbers = table(&format!("Numbers of {name}"), &head, rows.collect());
    let others = rivals(s, catalogue)
        .into_iter()
        .map(|(rival, what)| capital(&rival) + &what.map_or(String::new(), |what| format!("; {what}")) + ".");
    let lines: Vec<String> = others.chain(vetoes(s).map(|v| capital(&v) + ".")).collect();
    let new: Vec<String> = lines.into_iter().filter(|line| !told.contains(line)).collect();
    let said = (!new.is_empty()).then(|| element("ul").all(new.iter().map(|line| element("li").text(line))));
    told.extend(new);
    let front = [heading, added].into_iter().chain(load).chain([paragraph(&gain)]).chain(numbers);
    front.chain(picture).chain(said).collect()
}

/// The equations of the completed spec.
fn completed(found: &Gap) -> Vec<Element> {
    let checked = spec::read(&found.completed, SourceId(0))
        .ok()
        .and_then(|(spec, _)| check_names(&spec, SourceId(0)).ok());
    let Some((case, _)) = checked else { return vec![] };
    equations(&case, &[], &found.parameters).iter().map(|e| mathml::equation(&e.latex)).collect()
}

fn located(found: &Gap) -> Vec<Element> {
    let side = |which: &'static str, list: &[Region]| {
        let row = move |r: &Region| {
            let share = text(format!("{:.0} %", 100.0 * r.share));
            vec![text(which), code(&r.column), share, text(r.to_string())]
        };
        list.iter().map(row).collect::<Vec<_>>()
    };
    let mut rows = side("the model as it was", &found.located);
    if !found.steps.is_empty() {
        rows.extend(side("the completed model", &found.left));
    }
    let head = ["model", "column", "share of the gap", "mostly"];
    table("Where each model misses", &head, rows).into_iter().collect()
}

fn records(found: &Gap) -> Option<Element> {
    let noise = |column: &str| found.noise.iter().find(|(name, _)| name == column).map_or(f64::NAN, |n| n.1);
    let row = |c: &ColumnGap| {
        let noise = Cell::Number(noise(&c.column));
        let (before, after) = (Cell::Number(c.before), Cell::Number(c.after));
        vec![text(&c.record), text(role(c.role)), code(&c.column), before, after, noise]
    };
    let head = ["record", "role", "column", "NRMSE before", "NRMSE after", "noise (SI)"];
    table("Records and how the models do on them", &head, found.nrmse.iter().map(row).collect())
}

fn repeatability(found: &Gap) -> Option<Element> {
    let row = |c: &ColumnRepeat| {
        vec![text(&c.record), code(&c.column), Cell::Number(c.repeat.period), Cell::Number(c.repeat.nrmse)]
    };
    let head = ["record", "column", "period (s)", "repeats to NRMSE"];
    table("How well the motion itself repeats", &head, found.repeat.iter().map(row).collect())
}
