//! The residual over time with the noise band, and its autocorrelation with the band of white noise.

use super::table::unit;
use crate::chart::{Axis, Chart, Mark, Panel, Place, Sheet, Swatch, digits, legend};
use crate::seen::{Column, Model, Part, Seen};
use crate::table::REACH;
use phisindy_phys::spec::Role;
use phisindy_signal::autocorrelation;

const HIGH: f64 = 150.0;
/// Part of the width that the residual over time takes beside its autocorrelation.
const SHARE: f64 = 0.63;
/// Between the two, for ticks and a label.
const BETWEEN: f64 = 10.0;
/// Below each row, for ticks and a label.
const BELOW: f64 = 62.0;
/// Most lags shown.
const LAGS: usize = 160;

/// A chart for each chain on which the model runs.
pub(crate) fn charts(seen: &Seen<'_>, sheet: Sheet) -> Vec<(Chart, String)> {
    let Some(model) = &seen.model else { return vec![] };
    let all = seen.chains();
    all.iter().enumerate().filter_map(|(k, chain)| chart(seen, model, chain, (k + 1, sheet))).collect()
}

fn chart(
    seen: &Seen<'_>,
    model: &Model<'_>,
    chain: &[usize],
    (number, sheet): (usize, Sheet),
) -> Option<(Chart, String)> {
    let columns: Vec<Column<'_>> = seen.columns(chain);
    let left: Vec<(&Column<'_>, Vec<Part>)> = columns
        .iter()
        .map(|c| (c, c.parts.iter().filter_map(|(r, _)| Some((*r, model.residual(*r, c.name)?))).collect()))
        .filter(|(_, parts): &(_, Vec<_>)| !parts.is_empty())
        .collect();
    if left.is_empty() {
        return None;
    }
    let names = seen.names(chain);
    let said: Vec<String> = left.iter().map(|(c, parts)| described(seen, c, parts)).collect();
    let entries = [
        ("model", Swatch::Line, "measured − simulated".to_owned()),
        ("limit", Swatch::Line, "95 % of the estimated noise; of white noise".to_owned()),
    ];
    let (keys, top) = legend(&entries, sheet);
    let rows = left.len() * if sheet.is_phone() { 2 } else { 1 };
    let size = (sheet.width(), top + rows as f64 * (HIGH + BELOW));
    let title = format!("Residual and its autocorrelation: {names}");
    let description = format!("Measured less simulated. {}", said.join(" "));
    let mut chart = Chart::new(&format!("residual-{number}"), &title, &description, size);
    chart.draw(keys);
    let mut y = top;
    for (k, (column, parts)) in left.iter().enumerate() {
        if k > 0 {
            // Between the names of the axes above and the words over the panels below.
            chart.may_be_cut(y - 19.0);
        }
        let height = HIGH;
        let residual = over_time(seen, model, chain, column, parts);
        let lags = correlogram(seen, column, shown(seen, parts));
        // On a phone the two stand above each other.
        let below = if sheet.is_phone() { lags.labels(HIGH) } else { 0.0 };
        let (x, whole) = sheet.beside(residual.labels(HIGH).max(below));
        if sheet.is_phone() {
            chart.draw([residual.live(Place { x, y, width: whole, height })]);
            y += HIGH + BELOW;
            chart.draw([lags.live(Place { x, y, width: whole, height })]);
        } else {
            let width = SHARE * whole;
            chart.draw([residual.live(Place { x, y, width, height })]);
            let between = BETWEEN + sheet.beside(lags.labels(HIGH)).0;
            let (x, width) = (x + width + between, whole - width - between);
            chart.draw([lags.live(Place { x, y, width, height })]);
        }
        y += HIGH + BELOW;
    }
    Some((chart, format!("{names}. {}", said.join(" "))))
}

fn over_time(
    seen: &Seen<'_>,
    model: &Model<'_>,
    chain: &[usize],
    column: &Column<'_>,
    parts: &[Part],
) -> Panel {
    let (from, to) = seen.span(chain);
    let mut points = Vec::new();
    for (r, residual) in parts {
        points.extend(seen.times(*r, column.name).iter().copied().zip(residual.iter().copied()));
        points.push((f64::NAN, f64::NAN));
    }
    let factor = model.system.column(column.name).map_or(1.0, |k| model.system.factor(k));
    let noise = parts.iter().find_map(|(r, _)| {
        let found = model.fits[*r].noise.iter().find(|(name, _)| name == column.name);
        found.map(|(_, sigma)| REACH * sigma / factor).filter(|v| *v > 0.0)
    });
    let largest = points.iter().map(|p| p.1.abs()).filter(|v| v.is_finite()).fold(0.0, f64::max);
    let limits = noise.filter(|v| *v < 50.0 * largest).map_or(vec![], |v| vec![-v, v]);
    let y = Axis::around(
        &format!("residual of {}", column.name),
        &unit(column.unit),
        points.iter().map(|p| p.1).chain(limits.clone()),
    );
    let unfitted = seen.unfitted(chain).into_iter();
    let mut marks: Vec<Mark> =
        unfitted.map(|(from, to)| Mark::Span { from, to, words: "validate: not fitted" }).collect();
    marks.push(Mark::Line { class: "residual", points });
    marks.extend(limits.into_iter().map(|y| Mark::Level { class: "limit", y }));
    Panel { heading: String::new(), x: Axis::between("time", "s", from, to), y, marks, labelled: true }
}

/// The record whose autocorrelation is shown: the longest fitted one, else the longest.
fn shown<'p>(seen: &Seen<'_>, parts: &'p [Part]) -> &'p Part {
    let rank = |p: &&Part| (seen.records[p.0].role == Role::Fit, p.1.len());
    // There is at least one part.
    parts.iter().max_by_key(rank).unwrap_or(&parts[0])
}

fn correlogram(seen: &Seen<'_>, column: &Column<'_>, (record, residual): &Part) -> Panel {
    let time = seen.times(*record, column.name);
    let n = residual.len();
    let step = (time[n.min(time.len()) - 1] - time[0]) / (n - 1).max(1) as f64;
    let all = autocorrelation(residual);
    // From lag 1 (at lag 0 it is 1) over a twentieth of the record, thinned if there are many lags.
    let most = (n / 20).clamp(20, n.saturating_sub(1).max(1));
    let every = most.div_ceil(LAGS);
    let lags = (1..=most).step_by(every).filter(|&k| k < all.len());
    let points: Vec<(f64, f64)> = lags.map(|k| (k as f64 * step, all[k])).collect();
    let values: Vec<f64> = points.iter().map(|p| p.1).collect();
    let white = REACH / (n as f64).sqrt();
    let reach = [-3.0 * white, 3.0 * white];
    let marks = vec![
        Mark::Stems { class: "residual", points },
        Mark::Level { class: "zero", y: 0.0 },
        Mark::Level { class: "limit", y: white },
        Mark::Level { class: "limit", y: -white },
    ];
    let x = Axis::between("lag", "s", 0.0, most as f64 * step);
    let y = Axis::around("autocorrelation", "", values.into_iter().chain(reach));
    Panel { heading: String::new(), x, y, marks, labelled: true }
}

fn described(seen: &Seen<'_>, column: &Column<'_>, parts: &[Part]) -> String {
    let (_, residual) = shown(seen, parts);
    let n = residual.len();
    let rms = (residual.iter().map(|e| e * e).sum::<f64>() / n.max(1) as f64).sqrt();
    let all = autocorrelation(residual);
    let first = all.get(1).copied().unwrap_or(0.0);
    format!(
        "{}: rms {} {}, autocorrelation at the first lag {} (95 % of white noise is within ±{}).",
        column.name,
        digits(rms, 3),
        unit(column.unit),
        digits(first, 2),
        digits(REACH / (n.max(1) as f64).sqrt(), 2)
    )
}
