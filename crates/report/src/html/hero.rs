//! The first figures of a report: the motion where the models differ most, before and after.

use super::data::{Column, Model, Seen};
use super::table::unit;
use crate::chart::{Axis, Chart, Entry, Mark, Panel, Place, Sheet, Swatch, digits, legend};
use crate::format::role_name;
use phisindy_phys::spec::Role;
use phisindy_signal::strongest_line;

const HIGH: f64 = 220.0;
/// The same over the whole width: with the frictions and their captions below it, it fits on a first screen.
const LOW: f64 = 120.0;
/// Periods of the motion that are shown.
const PERIODS: f64 = 3.0;
/// Part of a record that is shown where its motion has no period.
const PART: f64 = 0.15;
/// Most dots of the measurement.
const DOTS: usize = 600;

/// A stretch of a column of a record.
struct Stretch<'s> {
    record: usize,
    column: Column<'s>,
    /// First sample, and the one behind the last.
    samples: std::ops::Range<usize>,
}

/// The motion of a stretch as numbers, each point a time and a value.
pub(crate) struct Series {
    /// Name of the record.
    pub(crate) record: String,
    /// Name of the column.
    pub(crate) column: String,
    /// Its unit.
    pub(crate) unit: String,
    pub(crate) measured: Vec<(f64, f64)>,
    /// Of the model as it was; empty if there is none.
    pub(crate) before: Vec<(f64, f64)>,
    /// Of the final model.
    pub(crate) model: Vec<(f64, f64)>,
}

/// The motion where the models differ most; none without a record on which the model runs. `column` is the column with
/// the largest part of the gap.
pub(crate) fn series(seen: &Seen<'_>, column: Option<&str>) -> Option<Series> {
    let stretch = stretch(seen, column)?;
    let Stretch { record, column, samples } = &stretch;
    let (name, time) = (&seen.records[*record].name, &seen.records[*record].time);
    let values = &column.parts[0].1;
    let simulated = |model: &Model<'_>| -> Vec<(f64, f64)> {
        let residual = model.residual(*record, column.name).unwrap_or_default();
        let inside = samples.clone().filter(|i| *i < residual.len());
        inside.map(|i| (time[i], values[i] - residual[i])).collect()
    };
    Some(Series {
        record: name.clone(),
        column: column.name.to_owned(),
        unit: column.unit.to_owned(),
        measured: samples.clone().map(|i| (time[i], values[i])).collect(),
        before: seen.was.as_ref().map(simulated).unwrap_or_default(),
        model: seen.model.as_ref().map(simulated).unwrap_or_default(),
    })
}

/// The chart with its caption; none without a record on which the model runs. `column` is the column with the largest
/// part of the gap.
pub(crate) fn chart(seen: &Seen<'_>, column: Option<&str>, sheet: Sheet) -> Option<(Chart, String)> {
    let stretch = stretch(seen, column)?;
    let Stretch { record, column, samples } = &stretch;
    let (name, time) = (&seen.records[*record].name, &seen.records[*record].time);
    let (from, to) = (time[samples.start], time[samples.end - 1]);
    let Series { measured, before, model, .. } = series(seen, Some(column.name))?;
    let lines: Vec<(&str, Vec<(f64, f64)>)> =
        [("before", before), ("model", model)].into_iter().filter(|(_, points)| !points.is_empty()).collect();
    let (low, high) = Axis::around("", "", measured.iter().map(|p| p.1)).ends();
    let room = 0.3 * (high - low);
    let shown = lines.iter().flat_map(|(_, l)| l.iter().map(|p| p.1.clamp(low - room, high + room)));
    let y = Axis::around(column.name, &unit(column.unit), measured.iter().map(|p| p.1).chain(shown));
    let every = measured.len().div_ceil(DOTS).max(1);
    let dots = measured.into_iter().step_by(every).collect();
    let mut marks =
        vec![Mark::Dots { class: "measured", points: dots, radius: if every > 1 { 1.7 } else { 2.2 } }];
    marks.extend(lines.into_iter().map(|(class, points)| Mark::Line { class, points }));
    let x = Axis::between("time", "s", from, to);
    let panel = Panel { heading: String::new(), x, y, marks, labelled: true };
    let (title, caption) = words(seen, &stretch, name, (from, to));
    let (keys, top) = legend(&entries(seen), sheet);
    let height = if sheet == Sheet::Full { LOW } else { HIGH };
    let mut chart = Chart::new("first", &title, &caption, (sheet.width(), top + height + 50.0));
    chart.draw(keys);
    chart.draw([panel.live(Place { x: sheet.left(), y: top, width: sheet.inner(), height })]);
    Some((chart, format!("{title}: {caption}")))
}

fn entries(seen: &Seen<'_>) -> Vec<Entry> {
    let mut out = vec![("measured", Swatch::Dot, "measured".to_owned())];
    if seen.was.is_some() {
        out.push(("before", Swatch::Line, "before".to_owned()));
    }
    out.push(("model", Swatch::Line, if seen.was.is_some() { "after" } else { "model" }.to_owned()));
    out
}

/// Title and caption: what to see.
fn words(seen: &Seen<'_>, stretch: &Stretch<'_>, name: &str, (from, to): (f64, f64)) -> (String, String) {
    let Stretch { record, column, .. } = stretch;
    let of = |model: &Option<Model<'_>>| {
        model.as_ref().and_then(|m| m.nrmse(*record, column.name)).map(|e| digits(100.0 * e, 2))
    };
    let missed = match (of(&seen.was), of(&seen.model)) {
        (Some(was), Some(now)) => format!(
            "over the whole record the model as it was misses {} by {was} % of its standard deviation, the completed one by {now} %",
            column.name
        ),
        (_, Some(now)) => {
            format!(
                "over the whole record the model misses {} by {now} % of its standard deviation",
                column.name
            )
        }
        _ => "there is no run".to_owned(),
    };
    let role = seen.records[*record].role;
    let used = if role == Role::Validate { "not used in the fit" } else { role_name(role) };
    let when =
        if seen.was.is_some() { "where the two models differ most" } else { "where the model misses most" };
    let span = format!("{} to {} s", digits(from, 3), digits(to, 3));
    (format!("{} of {name} ({used})", column.name), format!("{when}, {span}; {missed}."))
}

/// Where the models differ most; of a Validate record if there is one.
fn stretch<'s>(seen: &'s Seen<'_>, wanted: Option<&str>) -> Option<Stretch<'s>> {
    let model = seen.model.as_ref()?;
    let mut best: Option<(bool, f64, Stretch<'s>)> = None;
    for (record, data) in seen.records.iter().enumerate() {
        let columns = seen.columns(&[record]);
        let index = columns.iter().position(|c| Some(c.name) == wanted).unwrap_or(0);
        let Some(column) = columns.into_iter().nth(index) else { continue };
        let Some(after) = model.residual(record, column.name) else { continue };
        let before = seen.was.as_ref().and_then(|was| was.residual(record, column.name));
        let step = |i: usize| match &before {
            Some(before) => before.get(i).map_or(0.0, |b| b - after[i]),
            None => after[i],
        };
        let gain: Vec<f64> = (0..after.len()).map(step).collect();
        let (samples, mean) = window(&data.time, &column.parts[0].1, &gain);
        let validate = data.role == Role::Validate;
        let better = best.as_ref().is_none_or(|(v, m, _)| (validate, mean) > (*v, *m));
        if better && samples.len() > 1 {
            best = Some((validate, mean, Stretch { record, column, samples }));
        }
    }
    best.map(|b| b.2)
}

/// A few periods in which the square of `gain` is largest, and its mean there.
fn window(time: &[f64], values: &[f64], gain: &[f64]) -> (std::ops::Range<usize>, f64) {
    let n = gain.len().min(values.len()).min(time.len());
    if n < 2 {
        return (0..n, 0.0);
    }
    let whole = time[n - 1] - time[0];
    let period = strongest_line(&time[..n], &values[..n]).map(|l| PERIODS / l.frequency);
    let length = period.filter(|p| *p < whole).unwrap_or(PART * whole);
    let wide = ((length / whole * n as f64) as usize).clamp(2.min(n), n);
    let mut sums = vec![0.0];
    for g in &gain[..n] {
        let g = if g.is_finite() { g * g } else { 0.0 };
        sums.push(sums[sums.len() - 1] + g);
    }
    let power = |i: usize| sums[i + wide] - sums[i];
    let start = (0..=n - wide).max_by(|&a, &b| power(a).total_cmp(&power(b))).unwrap_or(0);
    (start..start + wide, power(start) / wide as f64)
}

#[cfg(test)]
mod tests {
    use super::window;

    #[test]
    fn the_window_lies_where_the_difference_is() {
        let time: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
        let values: Vec<f64> = time.iter().map(|t| (6.0 * t).sin()).collect();
        let gain: Vec<f64> = time.iter().map(|t| if *t > 7.0 { 1.0 } else { 0.1 }).collect();
        let (samples, mean) = window(&time, &values, &gain);
        assert!(samples.start >= 680 && samples.end <= 1000 && mean > 0.9, "{samples:?} {mean}");
        let periods = time[samples.end - 1] - time[samples.start];
        assert!((periods - 3.0 * std::f64::consts::TAU / 6.0).abs() < 0.2, "{periods}");
    }
}
