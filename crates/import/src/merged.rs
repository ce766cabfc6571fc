//! Merged logs: channels of several rates in one table, with empty cells where one has no sample in a row.

use crate::headings::Quantity;
use crate::selection::FEWEST;
use crate::table::{Column, Table};
use phisindy_signal::on_straight_lines;

/// From one sample of a channel that is slower than the rows to the next, in rows.
const APART: usize = 2;

/// Of a merged log the rows of what moves slowest, with the other channels between their samples; a draft needs no
/// more. Returns what is told of it; `None` of another table, which stays as it is.
pub(crate) fn thinned(table: &mut Table, time: usize) -> Option<String> {
    let sampled = |c: &Column| (0..c.values.len()).filter(|&r| c.values[r].is_finite()).collect::<Vec<_>>();
    let rows: Vec<Vec<usize>> = table.columns.iter().map(sampled).collect();
    let is_slow = |k: &usize| *k != time && rows[*k].len() >= FEWEST && apart(&rows[*k]) >= APART;
    let slow: Vec<usize> = (0..rows.len()).filter(is_slow).collect();
    let moves = |k: &usize| {
        use Quantity::{Angle, AngularSpeed, Length, Speed};
        matches!(table.columns[*k].heading.quantity, Length | Angle | Speed | AngularSpeed)
    };
    let all = (0..rows.len()).filter(|&k| k != time && rows[k].len() >= FEWEST);
    let moving: Vec<usize> = all.filter(moves).collect();
    let of = if moving.is_empty() { &slow } else { &moving };
    let base = *of.iter().min_by_key(|&&k| rows[k].len()).filter(|_| !slow.is_empty())?;
    let times = &table.columns[time].values;
    let kept: Vec<usize> = rows[base].iter().copied().filter(|&r| times[r].is_finite()).collect();
    let at: Vec<f64> = kept.iter().map(|&r| times[r]).collect();
    let count = rows[time].len();
    let of_rows = |k: usize| format!("`{}` in {}", table.columns[k].heading.raw, rows[k].len());
    let told = (0..rows.len()).filter(|&k| k != time && (slow.contains(&k) || rows[k].len() < count));
    let told = told.map(of_rows).collect::<Vec<_>>().join(", ");
    let told = format!(
        "of {count} rows not each holds all channels ({told}): each is read with its own times, as `streams`"
    );
    let values = |k: usize| -> Vec<f64> {
        let own = &table.columns[k].values;
        if k == base || k == time || rows[k].len() < 2 {
            return kept.iter().map(|&r| own[r]).collect();
        }
        let (from, values): (Vec<f64>, Vec<f64>) = rows[k].iter().map(|&r| (times[r], own[r])).unzip();
        let inside = |t: f64| t >= from[0] && t <= from[from.len() - 1];
        let between = on_straight_lines(&from, &values, &at);
        at.iter().zip(between).map(|(&t, x)| if inside(t) { x } else { f64::NAN }).collect()
    };
    let columns: Vec<Vec<f64>> = (0..rows.len()).map(values).collect();
    table.row_numbers = kept.iter().map(|&r| table.row_numbers[r]).collect();
    table.columns.iter_mut().zip(columns).for_each(|(column, values)| column.values = values);
    Some(told)
}

/// The usual number of rows from one sample to the next.
fn apart(rows: &[usize]) -> usize {
    let mut steps: Vec<usize> = rows.windows(2).map(|w| w[1] - w[0]).collect();
    steps.sort_unstable();
    steps.get(steps.len() / 2).copied().unwrap_or(0)
}
