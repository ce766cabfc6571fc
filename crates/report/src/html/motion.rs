//! Measured and simulated motion of each chain of records: a panel for each column, regimes of contacts
//! below.

use super::regimes;
use super::table::unit;
use crate::chart::{Axis, Chart, Entry, Mark, Panel, Place, Sheet, Swatch, digits, legend, width_of};
use crate::seen::{Column, Model, Seen};

const HIGH: f64 = 168.0;
const GAP: f64 = 24.0;
/// Up to this number of samples, the measurement is drawn as dots.
const DOTS: usize = 400;

/// A chart for each chain.
pub(crate) fn charts(seen: &Seen<'_>, sheet: Sheet) -> Vec<(Chart, String)> {
    seen.chains().iter().enumerate().map(|(k, chain)| chart(seen, chain, k + 1, sheet)).collect()
}

fn chart(seen: &Seen<'_>, chain: &[usize], number: usize, sheet: Sheet) -> (Chart, String) {
    let columns = seen.columns(chain);
    let (from, to) = seen.span(chain);
    let time = Axis::between("time", "s", from, to);
    let strips = regimes::strips(seen, chain, &time);
    let last = |k: usize| k + 1 == columns.len() && strips.is_empty();
    let panels: Vec<Panel> =
        columns.iter().enumerate().map(|(k, c)| panel(seen, chain, c, &time, last(k))).collect();
    let labels = panels.iter().map(|p| p.labels(HIGH)).chain(strips.iter().map(|s| width_of(s.name)));
    let (left, width) = sheet.beside(labels.fold(0.0, f64::max));
    let (keys, top) = legend(&entries(seen, chain, !strips.is_empty()), sheet);
    // Labels that stand above their panel need room there.
    let (top, gap) = if sheet.is_phone() { (top + 12.0, GAP + 8.0) } else { (top, GAP) };
    let below = top + columns.len() as f64 * (HIGH + gap) - gap;
    let strips_high = strips.len() as f64 * 26.0;
    let size = (sheet.width(), below + strips_high + 58.0);
    let names = seen.names(chain);
    let what = if seen.model.is_some() { "Measured and simulated motion" } else { "Measured motion" };
    let said: Vec<String> = columns.iter().map(|c| described(seen, c)).collect();
    let rests = regimes::described(seen, chain);
    let description = format!(
        "{what} of {names} from {} to {} s. {}{rests}",
        digits(from, 4),
        digits(to, 4),
        said.join(" ")
    );
    let name = format!("motion-{number}");
    let mut chart = Chart::new(&name, &format!("{what}: {names}"), &description, size);
    chart.draw(keys);
    let mut y = top;
    for (k, panel) in panels.iter().enumerate() {
        if k > 0 {
            chart.may_be_cut(y - 17.0);
        }
        chart.draw([panel.live(Place { x: left, y, width, height: HIGH })]);
        y += HIGH + gap;
    }
    let mut y = below + 10.0;
    for (k, strip) in strips.iter().enumerate() {
        chart.draw([strip.live(Place { x: left, y, width, height: 18.0 })]);
        y += 26.0;
        if k + 1 == strips.len() {
            chart.draw([below_labels(&time, Place { x: left, y: y - 8.0, width, height: 0.0 })]);
        }
    }
    let caption = format!("{names}. {}{rests}", said.join(" "));
    (chart, caption)
}

/// Ticks and label of the time axis below the strips.
fn below_labels(time: &Axis, place: Place) -> crate::markup::Element {
    let y = Axis::bare();
    let panel = Panel { heading: String::new(), x: time.clone(), y, marks: vec![], labelled: true };
    panel.live(place)
}

/// Values to draw for a record, from its index and its samples.
type Values<'v> = dyn Fn(usize, &[f64]) -> Option<Vec<f64>> + 'v;

fn panel(seen: &Seen<'_>, chain: &[usize], column: &Column<'_>, time: &Axis, labelled: bool) -> Panel {
    let points = |values: &Values<'_>| -> Vec<(f64, f64)> {
        let mut all = Vec::new();
        for (r, samples) in &column.parts {
            let Some(values) = values(*r, samples) else { continue };
            all.extend(seen.times(*r, column.name).iter().copied().zip(values));
            // Separate runs are not joined by a line.
            all.push((f64::NAN, f64::NAN));
        }
        all
    };
    let simulated = |model: &Model<'_>| {
        points(&|r, samples: &[f64]| {
            let residual = model.residual(r, column.name)?;
            Some(samples.iter().zip(residual).map(|(y, e)| y - e).collect())
        })
    };
    let measured = points(&|_, samples: &[f64]| Some(samples.to_vec()));
    let model = seen.model.as_ref().map(simulated).unwrap_or_default();
    let was = seen.was.as_ref().map(simulated).unwrap_or_default();
    let (low, high) = Axis::around("", "", measured.iter().map(|p| p.1)).ends();
    // A diverging model must not compress the measured motion.
    let room = 0.3 * (high - low);
    let shown = model.iter().chain(&was).map(|p| p.1.clamp(low - room, high + room));
    let y = Axis::around(column.name, &unit(column.unit), measured.iter().map(|p| p.1).chain(shown));
    let unfitted = seen.unfitted(chain).into_iter();
    let mut marks: Vec<Mark> =
        unfitted.map(|(from, to)| Mark::Span { from, to, words: "validate: not fitted" }).collect();
    marks.push(if measured.len() <= DOTS {
        Mark::Dots { class: "measured", points: measured, radius: 2.0 }
    } else {
        Mark::Line { class: "measured", points: measured }
    });
    let lines = [("before", was), ("model", model)].into_iter().filter(|(_, p)| !p.is_empty());
    marks.extend(lines.map(|(class, points)| Mark::Line { class, points }));
    Panel { heading: String::new(), x: time.clone(), y, marks, labelled }
}

fn entries(seen: &Seen<'_>, chain: &[usize], rests: bool) -> Vec<Entry> {
    let few = chain.iter().map(|&r| seen.records[r].len() + 1).sum::<usize>() <= DOTS;
    let swatch = if few { Swatch::Dot } else { Swatch::Line };
    let mut out = vec![("measured", swatch, "measured".to_owned())];
    if seen.was.is_some() {
        out.push(("before", Swatch::Line, "model as it was".to_owned()));
    }
    if seen.model.is_some() {
        let text = if seen.was.is_some() { "completed model" } else { "simulated" };
        out.push(("model", Swatch::Line, text.to_owned()));
    }
    if rests {
        out.push(("stick", Swatch::Box, "sticks".to_owned()));
        out.push(("slip", Swatch::Box, "slips (+ up, − down)".to_owned()));
    }
    out
}

/// The numbers of a column, in words.
fn described(seen: &Seen<'_>, column: &Column<'_>) -> String {
    let all = column.parts.iter().flat_map(|(_, samples)| samples);
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    let errors: Vec<String> = column
        .parts
        .iter()
        .filter_map(|(r, _)| {
            let after = digits(seen.model.as_ref()?.nrmse(*r, column.name)?, 2);
            let before = seen.was.as_ref().and_then(|was| was.nrmse(*r, column.name));
            let before = before.map_or(String::new(), |e| format!("{} → ", digits(e, 2)));
            Some(format!("{before}{after} ({})", crate::format::role_name(seen.records[*r].role)))
        })
        .collect();
    let range =
        format!("{} runs from {} to {} {}", column.name, digits(low, 3), digits(high, 3), unit(column.unit));
    let errors = if errors.is_empty() { String::new() } else { format!(", NRMSE {}", errors.join(", ")) };
    format!("{}{errors}.", range.trim_end())
}
