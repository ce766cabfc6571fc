//! The misfit over time: rms of residual over noise in intervals of each record, darker for more.

use crate::chart::{Axis, Chart, Entry, Mark, Panel, Place, Sheet, Strip, Swatch, digits, legend, width_of};
use crate::seen::{Model, Seen};

const HIGH: f64 = 22.0;
/// Number of intervals of a chain.
const CELLS: usize = 72;
/// Levels of the map: least multiple of the noise, and class.
const LEVELS: [(f64, &str); 5] = [
    (1.25, "level one"),
    (2.0, "level two"),
    (5.0, "level three"),
    (20.0, "level four"),
    (80.0, "level five"),
];

/// Start, end, rms of residual over noise.
type Cell = (f64, f64, f64);

/// A chart for each chain; `noise` is the standard deviation of each column (SI).
pub(crate) fn charts(seen: &Seen<'_>, noise: &[(String, f64)], sheet: Sheet) -> Vec<(Chart, String)> {
    let all = seen.chains();
    all.iter().enumerate().map(|(k, chain)| chart(seen, noise, chain, (k + 1, sheet))).collect()
}

fn chart(
    seen: &Seen<'_>,
    noise: &[(String, f64)],
    chain: &[usize],
    (number, sheet): (usize, Sheet),
) -> (Chart, String) {
    let (from, to) = seen.span(chain);
    let mut rows: Vec<(String, Vec<Cell>)> = Vec::new();
    for column in seen.columns(chain) {
        let sigma = noise.iter().find(|(name, _)| name == column.name).map_or(1.0, |n| n.1);
        let was = seen.was.as_ref().map(|m| (format!("{}, before", column.name), m));
        let after = if was.is_some() { ", after" } else { "" };
        let now = seen.model.as_ref().map(|m| (format!("{}{after}", column.name), m));
        rows.extend(
            was.into_iter().chain(now).map(|(name, m)| (name, cells(seen, m, chain, column.name, sigma))),
        );
    }
    let said: Vec<String> = rows.iter().map(|(name, cells)| described(name, cells)).collect();
    let names = seen.names(chain);
    let title = format!("Where in time the gap sits: {names}");
    let high = HIGH + 8.0;
    let entry =
        |&(level, class): &(f64, &'static str)| -> Entry { (class, Swatch::Box, format!("over {level}×")) };
    let (keys, top) = legend(&LEVELS.iter().map(entry).collect::<Vec<_>>(), sheet);
    let size = (sheet.width(), top - 8.0 + high * rows.len() as f64 + 50.0);
    let mut chart = Chart::new(&format!("map-{number}"), &title, &said.join(" "), size);
    chart.draw(keys);
    let time = Axis::between("time", "s", from, to);
    let (left, width) = sheet.beside(rows.iter().map(|(name, _)| width_of(name)).fold(0.0, f64::max));
    let mut y = top - 12.0;
    for (name, cells) in &rows {
        let strip = Strip { name, x: &time, marks: marks(cells) };
        chart.draw([strip.live(Place { x: left, y, width, height: HIGH })]);
        y += high;
    }
    let foot = Panel { heading: String::new(), x: time, y: Axis::bare(), marks: vec![], labelled: true };
    chart.draw([foot.live(Place { x: left, y: y - 8.0, width, height: 0.0 })]);
    (chart, format!("{title}. Residual (rms) in multiples of the noise. {}", said.join(" ")))
}

fn cells(seen: &Seen<'_>, model: &Model<'_>, chain: &[usize], column: &str, sigma: f64) -> Vec<Cell> {
    let (from, to) = seen.span(chain);
    let length = (to - from) / CELLS as f64;
    let factor = model.system.column(column).map_or(1.0, |k| model.system.factor(k));
    let mut sums = vec![(0.0, 0usize); CELLS];
    for &r in chain {
        let Some(residual) = model.residual(r, column) else { continue };
        for (t, e) in seen.times(r, column).iter().zip(residual) {
            let cell = &mut sums[(((t - from) / length) as usize).min(CELLS - 1)];
            *cell = (cell.0 + (e * factor / sigma).powi(2), cell.1 + 1);
        }
    }
    let cell = |(k, (sum, count)): (usize, (f64, usize))| {
        let start = from + length * k as f64;
        (count > 0).then(|| (start, start + length, (sum / count as f64).sqrt()))
    };
    sums.into_iter().enumerate().filter_map(cell).collect()
}

fn marks(cells: &[Cell]) -> Vec<Mark> {
    let above = |k: usize| LEVELS.get(k).map_or(f64::INFINITY, |l| l.0);
    let level = |(k, &(least, class)): (usize, &(f64, &'static str))| {
        let inside = cells.iter().filter(|c| c.2 > least && c.2 <= above(k + 1));
        Mark::Boxes { class, boxes: inside.map(|c| (c.0, c.1, 0.0, 1.0)).collect() }
    };
    LEVELS.iter().enumerate().map(level).collect()
}

fn described(name: &str, cells: &[Cell]) -> String {
    let worst = cells.iter().max_by(|a, b| a.2.total_cmp(&b.2));
    worst.map_or(format!("{name}: no run."), |(from, to, gap)| {
        format!("{name}: at most {} between {} and {} s.", digits(*gap, 3), digits(*from, 3), digits(*to, 3))
    })
}
