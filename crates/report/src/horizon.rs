//! How far the model predicts: in a sentence, as data, as a curve.

use crate::chart::{Axis, Chart, Mark, Panel, Place, Scale, Sheet, Swatch, legend};
use crate::format::capital;
use crate::table::short;
use phisindy_learn::{Horizon, RecordFit};
use phisindy_phys::spec::Role;
use serde::Serialize;

/// `the model misses x of run 1 by 0.3 % of its motion; a linear model by 0.6 % 0.02 s ahead, by 28 % 10 s ahead`: the
/// column that is predicted worst so far ahead, among the records that the model has not seen if there are any.
pub(crate) fn words(all: &[Horizon], records: &[RecordFit]) -> Option<String> {
    let curve = worst(all, records);
    let (first, worst) = (curve.first()?, curve.last()?);
    let percent = |part: f64| format!("{} %", short(two_digits(100.0 * part)));
    let (near, far) = (short(first.seconds), short(worst.seconds));
    let (column, record) = (&worst.column, &worst.record);
    let linear = match (first.baseline, worst.baseline) {
        (Some(a), Some(b)) => {
            format!("; a linear model by {} {near} s ahead, by {} {far} s ahead", percent(a), percent(b))
        }
        _ => String::new(),
    };
    // Of a model without a force that is left the state is known from its own run: near and far are the same.
    let own = if first.nrmse > 0.5 * worst.nrmse {
        format!("by {}", percent(worst.nrmse))
    } else {
        format!("by {} {near} s ahead, by {} {far} s ahead", percent(first.nrmse), percent(worst.nrmse))
    };
    Some(format!("the model misses {column} of {record} {own} of its motion{linear}"))
}

/// An error is not known better.
fn two_digits(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}

/// The horizons of the column that is predicted worst.
fn worst<'a>(all: &'a [Horizon], records: &[RecordFit]) -> Vec<&'a Horizon> {
    let unseen = |r: &&RecordFit| r.role == Role::Validate;
    let is = |h: &Horizon| records.iter().filter(unseen).any(|r| r.name == h.record);
    let judged = |h: &&Horizon| !records.iter().any(|r| unseen(&r)) || is(h);
    let farthest = all.iter().filter(judged).map(|h| h.seconds).fold(0.0, f64::max);
    let last = all.iter().filter(judged).filter(|h| h.seconds == farthest);
    let Some(worst) = last.max_by(|a, b| a.nrmse.total_cmp(&b.nrmse)) else { return vec![] };
    all.iter().filter(|h| (&h.record, &h.column) == (&worst.record, &worst.column)).collect()
}

/// The same as a curve over the time ahead; `None` for fewer than two points.
pub(crate) fn chart(all: &[Horizon], records: &[RecordFit], sheet: Sheet) -> Option<(Chart, String)> {
    let curve = worst(all, records);
    let said = words(all, records).filter(|_| curve.len() > 1)?;
    let line = |of: &dyn Fn(&Horizon) -> Option<f64>| -> Vec<(f64, f64)> {
        let points = curve.iter().filter_map(|h| Some((h.seconds, 100.0 * of(h)?)));
        points.filter(|p| p.1 > 0.0 && p.1.is_finite()).collect()
    };
    let (model, linear) = (line(&|h| Some(h.nrmse)), line(&|h| h.baseline));
    let entries = [
        ("model", Swatch::Line, "this model".to_owned()),
        ("before", Swatch::Line, "a linear model".to_owned()),
    ];
    let (keys, top) = legend(&entries[..if linear.is_empty() { 1 } else { 2 }], sheet);
    let ends = |of: fn(&(f64, f64)) -> f64| {
        let all = model.iter().chain(&linear).map(of);
        all.fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(v), b.max(v)))
    };
    let ((from, to), (low, high)) = (ends(|p| p.0), ends(|p| p.1));
    let x = Axis::between("looks ahead", "s", from, to).on(Scale::Log);
    let y = Axis::between("error", "% of the motion", 0.7 * low, 1.4 * high).on(Scale::Log);
    let marks = vec![
        Mark::Line { class: "before", points: linear },
        Mark::Dots { class: "model", points: model.clone(), radius: 2.5 },
        Mark::Line { class: "model", points: model },
    ];
    let said = format!("{}.", capital(&said));
    let panel = Panel { heading: String::new(), x, y, marks, labelled: true };
    let high = 170.0;
    let mut chart = Chart::new("horizon", "How far it predicts", &said, (sheet.width(), top + high + 50.0));
    chart.draw(keys);
    let (x, width) = sheet.beside(panel.labels(high));
    chart.draw([panel.live(Place { x, y: top, width, height: high })]);
    Some((chart, said))
}

#[derive(Serialize)]
pub(crate) struct HorizonOut<'a> {
    record: &'a str,
    column: &'a str,
    seconds: f64,
    nrmse: f64,
    /// Of a linear model.
    baseline: Option<f64>,
}

impl<'a> HorizonOut<'a> {
    pub(crate) fn new(of: &'a Horizon) -> HorizonOut<'a> {
        let Horizon { record, column, seconds, nrmse, baseline } = of;
        HorizonOut { record, column, seconds: *seconds, nrmse: *nrmse, baseline: *baseline }
    }
}
