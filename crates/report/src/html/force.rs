//! The force of an effect that `gap` added, against the displacement, velocity or time that its law depends
//! on, beside the force that the measured motion asks for.

use super::table::unit as unit_words;
use crate::chart::{Axis, Chart, Entry, Mark, Panel, Place, Sheet, Swatch, digits, legend};
use crate::format::capital;
use crate::gap::{Balance, RecordForce};
use crate::measured_force::Parts;
use phisindy_gap::Step;

const HIGH: f64 = 220.0;
/// Most dots of all records together.
const DOTS: usize = 1500;
/// Part of the measured points that may lie outside of the picture at each end: those at the ends of stops.
const OUTLIERS: f64 = 0.01;

/// The chart of a step with a short caption: what to see.
pub(crate) fn first(step: &Step, balance: &Balance, sheet: Sheet) -> (Chart, String) {
    let (chart, _) = chart("force", step, balance, sheet);
    let law = &step.effect.entry.law.name;
    let what = if balance.axes.function { "with the band of its numbers (95 %)" } else { "along the motion" };
    let points = points(has_points(balance).then_some(balance.parts), balance.smoothed);
    (
        chart,
        format!(
            "{} at {} against {}, {what}.{points}",
            capital(law),
            step.effect.place.at,
            balance.axes.over
        ),
    )
}

/// The chart of a step.
pub(crate) fn chart(name: &str, step: &Step, balance: &Balance, sheet: Sheet) -> (Chart, String) {
    let axes = &balance.axes;
    let law = &step.effect.entry.law.name;
    let what = match (axes.push, axes.force) {
        (true, _) => "push",
        (false, true) => "resisting force",
        (false, false) => "resistance",
    };
    let drawn = || balance.records.iter().flat_map(|r| r.law.iter());
    let measured = || balance.records.iter().map(|r| &r.measured);
    let forces = drawn().flat_map(|p| [p.1, p.2.0, p.2.1]).chain([0.0]).chain(middle(measured().flatten()));
    let x = Axis::around(&axes.over, &unit_words(&axes.over_unit), drawn().map(|p| p.0));
    let y = Axis::around(what, &unit_words(&axes.unit), forces);
    let mut marks = vec![Mark::Level { class: "zero", y: 0.0 }];
    marks.extend(dots(measured(), (x.ends(), y.ends()), sheet));
    marks.extend(lines(balance));
    marks.extend(names(balance));
    let panel = Panel { heading: String::new(), x, y, marks, labelled: true };
    let title = format!("{} at {}", capital(law), step.effect.place.at);
    let said = said(balance, what);
    let (keys, top) = legend(&entries(balance, law), sheet);
    let mut chart = Chart::new(name, &title, &said, (sheet.width(), top + HIGH + 50.0));
    chart.draw(keys);
    let (x, width) = sheet.beside(panel.labels(HIGH));
    chart.draw([panel.live(Place { x, y: top, width, height: HIGH })]);
    (chart, format!("{title}: {said}"))
}

fn has_points(balance: &Balance) -> bool {
    balance.records.iter().any(|r| !r.measured.is_empty())
}

fn entries(balance: &Balance, law: &str) -> Vec<Entry> {
    let mut out: Vec<Entry> = vec![];
    if has_points(balance) {
        out.push(("measured", Swatch::Dot, balance.parts.name().to_owned()));
    }
    if balance.axes.function {
        out.push(("model", Swatch::Line, law.to_owned()));
        out.push(("band", Swatch::Box, "95 % band".to_owned()));
    } else {
        out.push(("model", Swatch::Dot, law.to_owned()));
    }
    out
}

/// The measured forces without the outermost ones.
pub(super) fn middle<'p>(points: impl Iterator<Item = &'p (f64, f64)>) -> Vec<f64> {
    let mut all: Vec<f64> = points.map(|p| p.1).collect();
    all.sort_unstable_by(f64::total_cmp);
    let out = (OUTLIERS * all.len() as f64).ceil() as usize;
    if all.len() > 2 * out { all[out..all.len() - out].to_vec() } else { vec![] }
}

/// The points of the force balance of each record inside of the picture.
pub(super) fn dots<'p>(
    records: impl Iterator<Item = &'p Vec<(f64, f64)>> + Clone,
    (across, up): ((f64, f64), (f64, f64)),
    sheet: Sheet,
) -> Vec<Mark> {
    let inside = |(x, y): &(f64, f64)| *x >= across.0 && *x <= across.1 && *y >= up.0 && *y <= up.1;
    let count: usize = records.clone().map(Vec::len).sum();
    let most = if sheet.is_phone() { DOTS / 3 } else { DOTS };
    let every = count.div_ceil(most).max(1);
    let of = |points: &Vec<(f64, f64)>| Mark::Dots {
        class: "measured faint",
        points: points.iter().copied().filter(inside).step_by(every).collect(),
        radius: 1.5,
    };
    records.filter(|points| !points.is_empty()).map(of).collect()
}

/// A band and a line for each record, or dots.
fn lines(balance: &Balance) -> Vec<Mark> {
    let count: usize = balance.records.iter().map(|r| r.law.len()).sum();
    let every = count.div_ceil(DOTS).max(1);
    let mut out = vec![];
    for r in &balance.records {
        if balance.axes.function {
            out.push(Mark::Band {
                class: "band",
                points: r.law.iter().map(|p| (p.0, p.2.0, p.2.1)).collect(),
            });
            out.push(Mark::Line { class: "model", points: r.law.iter().map(|p| (p.0, p.1)).collect() });
        } else {
            let points = r.law.iter().step_by(every).map(|p| (p.0, p.1)).collect();
            out.push(Mark::Dots { class: "model", points, radius: 1.4 });
        }
    }
    out
}

/// Part of the range of forces by which the curves of two records must differ for each to have its name.
const APART: f64 = 0.08;

/// Names of records whose curves differ: a curve has its name at its end, a cloud at its top.
fn names(balance: &Balance) -> Vec<Mark> {
    let function = balance.axes.function;
    let forces = || balance.records.iter().flat_map(|r| r.law.iter().map(|p| p.1)).chain([0.0]);
    let (low, high) = forces().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let place = |r: &RecordForce| {
        let top = r.law.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let place = if function { r.law.last() } else { top };
        place.map(|p| (p.0, p.1))
    };
    // Curves are compared where the shorter one ends.
    let force = |r: &RecordForce, at: f64| {
        let near = |a: &f64, b: &f64| (a - at).abs().total_cmp(&(b - at).abs());
        let point = r.law.iter().min_by(|a, b| near(&a.0, &b.0));
        point.map_or(f64::NAN, |p| p.1)
    };
    let mut told: Vec<(&RecordForce, f64, f64)> = vec![];
    for r in &balance.records {
        let Some((x, y)) = place(r) else { continue };
        let differs = |(other, end, top): &(&RecordForce, f64, f64)| {
            let apart = if function { force(r, x.min(*end)) - force(other, x.min(*end)) } else { y - top };
            apart.abs() > APART * (high - low)
        };
        if told.iter().all(differs) {
            told.push((r, x, y));
        }
    }
    let name = |(r, x, y): &(&RecordForce, f64, f64)| Mark::Name { x: *x, y: *y, words: r.name.clone() };
    if told.len() > 1 { told.iter().map(name).collect() } else { vec![] }
}

/// What the measured points are; nothing where there are none.
pub(super) fn points(of: Option<Parts>, smoothed: f64) -> String {
    let Some(parts) = of else { return String::new() };
    let how = match smoothed {
        0.0 => String::new(),
        time => {
            format!(", smoothed over up to {} ms; none where the body sticks or turns", digits(1e3 * time, 2))
        }
    };
    format!(" Grey dots: {}{how}.", parts.words())
}

/// What it is, over which range, and what to see.
fn said(balance: &Balance, what: &str) -> String {
    let axes = &balance.axes;
    let all = || balance.records.iter().flat_map(|r| r.law.iter());
    let range = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        format!("{} to {}", digits(low, 3), digits(high, 3))
    };
    let unit = |unit: &str| if unit.is_empty() { String::new() } else { format!(" {}", unit_words(unit)) };
    let how = if axes.function {
        String::new()
    } else {
        format!(" It depends on more than {}, so that it is a cloud.", axes.over)
    };
    let points = points(has_points(balance).then_some(balance.parts), balance.smoothed);
    format!(
        "{what} from {}{} while {} goes from {}{}.{how}{points}",
        range(&mut all().map(|p| p.1)),
        unit(&axes.unit),
        axes.over,
        range(&mut all().map(|p| p.0)),
        unit(&axes.over_unit)
    )
}
