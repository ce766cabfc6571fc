//! The stretch of the motion that a reader sees first: where the models differ most, on a page and at a
//! terminal.

use crate::seen::{Column, Model, Seen};
use phisindy_phys::spec::Role;
use phisindy_signal::strongest_line;

/// Periods of the motion that are shown.
const PERIODS: f64 = 3.0;
/// Part of a record that is shown where its motion has no period.
const PART: f64 = 0.15;

/// A stretch of a column of a record.
pub(crate) struct Stretch<'s> {
    pub(crate) record: usize,
    pub(crate) column: Column<'s>,
    /// First sample, and the one behind the last.
    pub(crate) samples: std::ops::Range<usize>,
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

/// The motion where the models differ most; none without a record on which the model runs. `column` is the
/// column with the largest part of the gap.
pub(crate) fn series(seen: &Seen<'_>, column: Option<&str>) -> Option<Series> {
    let stretch = stretch(seen, column)?;
    let Stretch { record, column, samples } = &stretch;
    let (name, time) = (&seen.records[*record].name, seen.times(*record, column.name));
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

/// Where the models differ most; of a Validate record if there is one.
pub(crate) fn stretch<'s>(seen: &'s Seen<'_>, wanted: Option<&str>) -> Option<Stretch<'s>> {
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
        let (samples, mean) = window(&seen.times(record, column.name), &column.parts[0].1, &gain);
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
