//! The result of `gap` for people.

use super::discovered_force::{beyond, remarks};
use super::finding::symbol;
use super::outcome::{basis, outcome};
use super::report::GapReport;
use crate::format::capital;
use crate::horizon;
use crate::table::{interval, short};
use phisindy_gap::{Gap, Rival, Status, Step, Tried};
use phisindy_phys::LawEntry;
use phisindy_phys::spec::Role;

/// Length of the bars, in characters.
const BAR: usize = 24;

/// A probability below is not told in words: what it is against holds by the convention of 95 %.
const TOLD: f64 = 0.05;

/// The text: first a bar for each step, then the steps with their numbers, then the outcome.
pub(crate) fn text(report: &GapReport<'_>) -> String {
    let GapReport { gap: found, catalogue, ending: how, .. } = *report;
    let mut out = bars(found);
    out.push(String::new());
    if let Some(first) = found.located.first()
        && found.status != Status::NothingMissing
    {
        let share = if found.located.len() > 1 {
            format!(" ({:.0} % of the gap)", 100.0 * first.share)
        } else {
            String::new()
        };
        out.push(format!("where: in {}{share}, {first}", first.column));
    }
    out.extend(found.alternative.as_ref().map(ToString::to_string));
    out.extend(found.force.as_ref().map(ToString::to_string));
    if found.status == Status::Unexplained && !found.steps.is_empty() {
        out.push("brings the gap far down, whatever else is missing:".into());
    }
    for (k, s) in found.steps.iter().enumerate() {
        out.push(format!(
            "{}. {} at {}: {}",
            k + 1,
            capital(&s.effect.entry.law.name),
            s.effect.place.at,
            s.expression
        ));
        details(found, s, catalogue, &mut out);
    }
    if !found.partial.is_empty() {
        out.push("helps, but does not explain:".into());
        for s in &found.partial {
            out.push(format!(
                "  {} at {}: {}",
                capital(&s.effect.entry.law.name),
                s.effect.place.at,
                s.expression
            ));
            details(found, s, catalogue, &mut out);
        }
    }
    out.extend(moved(found));
    out.extend(found.none.filter(|p| *p > TOLD).map(|p| {
        format!("none of these: a force of the motion in another form is there with probability {p:.2}")
    }));
    out.push(tried(found));
    // Several rounds may rule out the same law; it is listed once.
    let steps = found.steps.iter().chain(&found.partial);
    for veto in steps.flat_map(vetoes) {
        if !out.contains(&veto) {
            out.push(veto);
        }
    }
    for c in &found.repeat {
        out.push(format!(
            "{}: {} repeats from cycle to cycle ({} s) to NRMSE {:.3}",
            c.record,
            c.column,
            short(c.repeat.period),
            c.repeat.nrmse
        ));
    }
    for c in &found.nrmse {
        let role = if c.role == Role::Fit { "fit" } else { "validate" };
        out.push(format!("{} ({role}): NRMSE of {} {:.4} -> {:.4}", c.record, c.column, c.before, c.after));
    }
    out.extend(horizon::words(&found.horizon, &found.simulated.records));
    out.extend(how.stopped_words().map(|stopped| format!("{stopped} before the end; so far:")));
    out.extend(report.planned.map(|planned| planned.sentence.clone()));
    out.push(format!("{}: {}", found.status.name(), outcome(found)));
    out.push(format!("{:.1} s", how.seconds));
    out.join("\n") + "\n"
}

/// The gap of the model as it is, and after each step.
fn bars(found: &Gap) -> Vec<String> {
    let before = found.before.1.unwrap_or(found.before.0);
    let mut out = vec![
        format!("gap {}, in units of the noise (1 is perfect)", basis(found)),
        format!("  {:>8}  {}  the model as it is", short(before), bar(before, before)),
    ];
    out.extend(found.steps.iter().chain(&found.partial).map(|s| {
        let after = s.validate.map_or(s.fit.1, |v| v.1);
        let (law, at) = (&s.effect.entry.law.name, &s.effect.place.at);
        format!("  {:>8}  {}  + {law} at {at}", short(after), bar(after, before))
    }));
    out
}

/// How many laws were tried at how many places, and which were not.
fn tried(found: &Gap) -> String {
    let distinct = |of: &dyn Fn(&Tried) -> String| -> usize {
        found.tried.iter().map(of).collect::<std::collections::BTreeSet<_>>().len()
    };
    let (laws, places) = (distinct(&|t| t.at.law.clone()), distinct(&|t| t.at.at.clone()));
    let counted = |count: usize, one: &str| format!("{count} {one}{}", if count == 1 { "" } else { "s" });
    let tried = format!("tried: {} at {}", counted(laws, "law"), counted(places, "place"));
    // Laws with the same reason stand together.
    let mut reasons: Vec<(String, Vec<&str>)> = Vec::new();
    for law in &found.not_tried {
        let why = law.why.to_string();
        match reasons.iter_mut().find(|(reason, _)| *reason == why) {
            Some((_, laws)) => laws.push(&law.law),
            None => reasons.push((why, vec![&law.law])),
        }
    }
    let not_tried = reasons.iter().map(|(why, laws)| format!("; not tried: {} ({why})", laws.join(", ")));
    tried + &not_tried.collect::<String>()
}

/// The parameters of a step, and those of its rivals that earlier steps do not list.
fn details(found: &Gap, s: &Step, catalogue: &[LawEntry], out: &mut Vec<String>) {
    for p in &s.parameters {
        let line = |record: &str, value: f64, ci95: (f64, f64)| {
            format!(
                "     {}{record} = {} {} {}",
                symbol(s, p),
                short(value),
                p.unit,
                interval(ci95.0, ci95.1)
            )
        };
        if p.each.is_empty() {
            out.push(line("", p.value, p.ci95));
        }
        out.extend(p.each.iter().map(|r| line(&format!(" [{}]", r.record), r.value, r.ci95)));
    }
    out.extend(remarks(found, s, catalogue).into_iter().map(|remark| format!("     {remark}")));
    for (rival, what) in rivals(s, catalogue) {
        let rival = format!("     {rival}");
        if !out.contains(&rival) {
            out.push(rival);
            out.extend(what.map(|what| format!("       {what}")));
        }
    }
}

/// Fitted constants and sensor parameters of the spec itself.
fn moved(found: &Gap) -> Vec<String> {
    let steps = || found.steps.iter().chain(&found.partial);
    let own = |name: &str| steps().any(|s| s.parameters.iter().any(|p| p.constant == name));
    let said = found.parameters.iter().filter(|p| !own(&p.id.to_string())).map(|p| {
        let f = p.factor;
        let (low, high) = p.estimate.ci95;
        let bound = if p.at_bound { ", at its bound" } else { "" };
        let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
        format!(
            "     {} = {}{unit} [{}, {}]{bound}",
            p.id,
            short(p.estimate.value / f),
            short(low / f),
            short(high / f)
        )
    });
    let said: Vec<String> = said.collect();
    if said.is_empty() { said } else { ["with".to_owned()].into_iter().chain(said).collect() }
}

/// Laws that fit nearly as well, each with the measurement that would decide.
pub(crate) fn rivals(s: &Step, catalogue: &[LawEntry]) -> Vec<(String, Option<String>)> {
    let near = s.rivals.iter().filter(|r| r.same || r.delta_bic < 10.0);
    let said = near.map(|r| {
        // A richer description may fit better and still not be preferred: its gain does not carry over to
        // unused data.
        let by = if r.same {
            "these records cannot tell the two apart".to_owned()
        } else if r.delta_bic < 0.0 {
            format!("fits better, BIC {} lower, but says little more about data not used", two(-r.delta_bic))
        } else {
            format!("BIC {} higher", two(r.delta_bic))
        };
        let what = beyond(s).or_else(|| deciding(&s.effect.entry, r, catalogue));
        let what = what.or_else(|| r.completed.is_some().then(|| DESIGNED.to_owned()));
        (format!("not excluded: {r} ({by})"), what.map(|what| format!("{what} would decide")))
    });
    let same = s.effect.entry.law.indistinguishable.iter();
    said.chain(same.map(|same| (same.cause.clone(), Some(same.check.clone())))).collect()
}

/// The measurement that distinguishes two models of which no file says it.
const DESIGNED: &str = "the run that `phisindy next` designs";

/// A difference of criteria, of which more than two digits say nothing.
fn two(x: f64) -> String {
    short(format!("{x:.1e}").parse().unwrap_or(x))
}

/// Laws that other evidence rules out.
fn vetoes(s: &Step) -> impl Iterator<Item = String> {
    s.vetoed.iter().map(ToString::to_string)
}

/// The measurement that distinguishes a law from its rival, if there is one.
fn deciding(own: &LawEntry, rival: &Rival, catalogue: &[LawEntry]) -> Option<String> {
    let named = |law: &LawEntry, other: &str| {
        law.law.told_apart_by.iter().find(|(id, _)| id == other).map(|(_, what)| what.clone())
    };
    let of = |law: &str| catalogue.iter().find(|e| e.id == law);
    let first = of(&rival.laws.first()?.law)?;
    let named = named(own, &first.id).or_else(|| named(first, &own.id)).filter(|_| rival.laws.len() == 1);
    if named.is_some() {
        return named;
    }
    if own.law.property().is_some() || first.law.property().is_some() {
        return Some("the same motion read by a second sensor".to_owned());
    }
    // A combination of laws has no such measurement.
    let other = Some(first).filter(|_| rival.laws.len() == 1)?;
    let both = own.law.family == "friction" && other.law.family == "friction";
    let what = match (both, other.law.has_memory()) {
        (true, true) => "a close look at the displacement in the stops",
        (true, false) => "runs at other speeds and amplitudes",
        (false, _) => "a run at another amplitude",
    };
    Some(what.to_owned())
}

/// A gap as a bar on a logarithmic scale from 1 to the initial gap.
pub(super) fn bar(value: f64, whole: f64) -> String {
    let full = whole.max(1.5).ln();
    let part = (value.max(1.0).ln() / full).clamp(0.0, 1.0);
    let cells = (part * BAR as f64).round() as usize;
    format!("{}{}", "█".repeat(cells), "·".repeat(BAR - cells))
}
