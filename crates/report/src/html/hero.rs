//! The first figures of a report: the motion where the models differ most, before and after.

use super::table::unit;
use crate::chart::{Axis, Chart, Entry, Mark, Panel, Place, Sheet, Swatch, digits, legend};
use crate::format::role_name;
use crate::seen::{Model, Seen};
use crate::stretch::{Series, Stretch, series, stretch};
use phisindy_phys::spec::Role;

const HIGH: f64 = 220.0;
/// The same over the whole width: with the frictions and their captions below it, it fits on a first screen.
const LOW: f64 = 120.0;
/// Most dots of the measurement.
const DOTS: usize = 600;

/// The chart with its caption; none without a record on which the model runs. `column` is the column with the
/// largest part of the gap.
pub(crate) fn chart(seen: &Seen<'_>, column: Option<&str>, sheet: Sheet) -> Option<(Chart, String)> {
    let stretch = stretch(seen, column)?;
    let Stretch { record, column, samples } = &stretch;
    let (name, time) = (&seen.records[*record].name, seen.times(*record, column.name));
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
    let (x, width) = sheet.beside(panel.labels(height));
    chart.draw([panel.live(Place { x, y: top, width, height })]);
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
    // As many digits as tell one hundredth of the stretch.
    let count = 2 + (from.abs().max(to.abs()) / (to - from)).log10().ceil().max(1.0) as usize;
    let span = format!("{} to {} s", digits(from, count), digits(to, count));
    (format!("{} of {name} ({used})", column.name), format!("{when}, {span}; {missed}."))
}
