//! The report of `gap`.

use super::leaderboard::leaderboard;
use super::page::{
    Banner, Captioned, Page, Tone, add_data_remarks, add_warnings, paragraph, sentence, worded,
};
use super::table::{Cell, code, in_unit, parameters, table, text};
use super::{force, hero, map, mathml, missing_force, motion, next, reproduction, residual, shrink};
use crate::chart::{Sheet, digits};
use crate::equation::equations_of;
use crate::format::{capital, role_name as role};
use crate::gap::{Balance, Finding, GapReport, balance, finding, remarks, rivals, symbol};
use crate::horizon;
use crate::input::{Ending, Invocation};
use crate::markup::{Element, element};
use crate::seen::{Seen, notes};
use crate::sketch;
use phisindy_gap::{ColumnGap, ColumnRepeat, Gap, Region, Status, Step, Warning};
use phisindy_phys::{Case, LawEntry};

/// The page.
pub(crate) fn page(report: &GapReport<'_>, invocation: &Invocation) -> Page {
    let GapReport { input, gap: found, catalogue, ending, .. } = *report;
    let seen = report.seen();
    let mut page = Page::new(input, banner(found, ending));
    let balances: Vec<Option<Balance>> =
        found.steps.iter().map(|s| balance(found, s, input.records)).collect();
    let mut steps: Vec<String> =
        found.interrupted().then(|| next::after_stop(input.name)).into_iter().collect();
    if found.status == Status::Unexplained {
        steps.extend(next::after_unexplained(input.name));
    }
    next::add(&mut page, &steps);
    first_screen(&mut page, found, &seen, &balances);
    page.sketch(sketch::of_gap(report));
    page.list(
        "The planned run",
        &report.planned.map(|p| sentence(&p.sentence)).into_iter().collect::<Vec<_>>(),
    );
    page.section("All laws that were tried", leaderboard(found, catalogue));
    effects(&mut page, found, catalogue, &balances);
    // A law that is ruled out is told beside its step.
    let warnings = found.warnings.iter().filter(|w| !matches!(w, Warning::Vetoed(_)));
    add_warnings(&mut page, &warnings.map(ToString::to_string).collect::<Vec<_>>());
    if !found.steps.is_empty() || !found.partial.is_empty() {
        page.section("The completed equation", completed(input.case, found));
    }
    let maps = page.drawn(Sheet::Page, |sheet| map::charts(&seen, &found.noise, sheet));
    page.section("Where the gap sits", located(found).into_iter().chain(maps));
    page.figures("Measured against simulated", |sheet| motion::charts(&seen, sheet));
    page.figures("How far it predicts", |sheet| {
        horizon::chart(&found.horizon, &found.simulated.records, sheet).into_iter().collect()
    });
    page.section("Records", [records(found), repeatability(found)].into_iter().flatten());
    page.figures("What is left", |sheet| residual::charts(&seen, sheet));
    page.section("Parameters", parameters(&found.parameters));
    add_data_remarks(&mut page, input.doubts, &notes(input));
    reproduction::add(&mut page, input, invocation);
    page
}

/// The finding in pictures: the motion before and after, the force that was found first (of a law of the
/// catalogue or a discovered formula: both are steps), the shrinking gap.
fn first_screen(page: &mut Page, found: &Gap, seen: &Seen<'_>, balances: &[Option<Balance>]) {
    let column = found.located.first().map(|r| r.column.as_str());
    let mut figures = page.drawn(Sheet::Half, |sheet| hero::chart(seen, column, sheet).into_iter().collect());
    let shown = found.steps.iter().zip(balances).find_map(|(step, b)| b.as_ref().map(|b| (step, b)));
    let gap = |sheet| vec![shrink::chart(found, sheet)];
    let second = match shown {
        Some((step, balance)) => page.drawn(Sheet::Half, |sheet| vec![force::first(step, balance, sheet)]),
        None => page.drawn(Sheet::Half, |sheet| missing(found, sheet)),
    };
    if second.is_empty() {
        figures.extend(page.drawn(Sheet::Half, gap));
        return page.first(figures, vec![]);
    }
    figures.extend(second);
    let below = page.drawn(Sheet::Page, gap);
    page.first(figures, vec![element("div").class("beside").all(below)]);
}

/// The force without a formula, if there is one that can be drawn.
fn missing(found: &Gap, sheet: Sheet) -> Vec<Captioned> {
    found.force.iter().filter_map(|force| missing_force::chart(force, sheet)).collect()
}

/// What was added, and what helps.
fn effects(page: &mut Page, found: &Gap, catalogue: &[LawEntry], balances: &[Option<Balance>]) {
    // A remark that applies to several steps is made once.
    let mut told = Vec::new();
    let mut effects = Vec::new();
    for (k, (step, balance)) in found.steps.iter().zip(balances).enumerate() {
        let name = format!("effect-{}", k + 1);
        let draw = |sheet| balance.iter().map(|b| force::chart(&name, step, b, sheet)).collect();
        let picture = page.drawn(Sheet::Page, draw).pop();
        effects.extend(shown(found, Some(k + 1), step, catalogue, picture, &mut told));
    }
    let whole = found.status != Status::Unexplained;
    page.section(if whole { "What is missing" } else { "What brings the gap far down" }, effects);
    if !found.steps.is_empty() {
        page.figures("The missing force without a formula", |sheet| missing(found, sheet));
    }
    let mut helps = Vec::new();
    for step in &found.partial {
        helps.extend(shown(found, None, step, catalogue, None, &mut told));
    }
    page.section("What helps, but does not explain", helps);
}

fn banner(found: &Gap, how: Ending) -> Banner {
    let tone = match found.status {
        Status::NothingMissing | Status::Explained | Status::Described | Status::Named => Tone::Good,
        Status::Undetermined | Status::Unexplained => Tone::Open,
    };
    let stopped = how
        .stopped_words()
        .map_or(String::new(), |stopped| format!(" {} before the end.", capital(&stopped)));
    let Finding { headline, sentence } = finding(found);
    let laws: std::collections::BTreeSet<&str> = found.tried.iter().map(|t| t.at.law.as_str()).collect();
    let tried = if laws.is_empty() { String::new() } else { format!("{} laws tried, ", laws.len()) };
    Banner {
        tone,
        headline: headline.to_owned(),
        text: sentence,
        how: format!("{}{} s.{stopped}", capital(&tried), digits(how.seconds, 2)),
    }
}

/// A step: law, place, parameters, picture, and the remarks about rivals and vetoes that are not in `told`.
fn shown(
    found: &Gap,
    number: Option<usize>,
    s: &Step,
    catalogue: &[LawEntry],
    picture: Option<Element>,
    told: &mut Vec<String>,
) -> Vec<Element> {
    let number = number.map_or(String::new(), |k| format!("{k}. "));
    let name = &s.effect.entry.law.name;
    let heading = element("h3")
        .text(format!("{number}{} at ", capital(name)))
        .add(element("code").text(&s.effect.place.at));
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
        let turned = if symbol(s, p) == p.constant { "" } else { "-" };
        let constant = format!("{turned}{}", p.constant);
        let shared = p.each.is_empty().then(|| row(p, constant, p.value, p.ci95));
        let each = p.each.iter().map(|r| row(p, format!("{} [{}]", p.constant, r.record), r.value, r.ci95));
        shared.into_iter().chain(each).collect::<Vec<_>>()
    });
    let head = ["parameter", "constant of the spec", "value", "95 % interval", "unit"];
    let numbers = table(&format!("Numbers of {name}"), &head, rows.collect());
    let others = rivals(s, catalogue)
        .into_iter()
        .map(|(rival, what)| capital(&rival) + &what.map_or(String::new(), |what| format!("; {what}")) + ".");
    let own = remarks(found, s, catalogue).into_iter().map(|remark| capital(&remark) + ".");
    let lines: Vec<String> = own.chain(others).chain(vetoes(s, catalogue)).collect();
    let new: Vec<String> = lines.into_iter().filter(|line| !told.contains(line)).collect();
    let said =
        (!new.is_empty()).then(|| element("ul").all(new.iter().map(|line| worded(element("li"), line))));
    told.extend(new);
    let front = [heading, added].into_iter().chain(load).chain([paragraph(&gain)]).chain(numbers);
    front.chain(picture).chain(said).collect()
}

/// The laws that other evidence rules out, by their names.
fn vetoes<'a>(s: &'a Step, catalogue: &'a [LawEntry]) -> impl Iterator<Item = String> + 'a {
    s.vetoed.iter().map(|v| {
        let entry = catalogue.iter().find(|e| e.id == v.law.law);
        let name = entry.map_or(v.law.law.as_str(), |e| e.law.name.as_str());
        format!("{} is ruled out: {}.", capital(name), v.why)
    })
}

/// The equations of the completed model.
fn completed(case: &Case, found: &Gap) -> Vec<Element> {
    let all = equations_of(&found.simulated.system, case, &[], &found.parameters);
    all.iter().map(|e| mathml::equation(&e.latex)).collect()
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
