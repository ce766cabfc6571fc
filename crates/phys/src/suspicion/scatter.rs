//! The deviation of a sample from the mean of its neighbours, and its scatter by medians, which are robust to
//! spikes.

use phisindy_signal::{median, rounding_error};
use std::ops::Range;

/// Median of |normal|, times the standard deviation of `e1 - (e0 + e2)/2`.
const UNIT: f64 = 0.674_489_750_196_081_7 * 1.224_744_871_391_589;

/// The 90 % quantile of |normal|, times the same.
const TENTH: f64 = 1.644_853_626_951_472_6 * 1.224_744_871_391_589;

/// A sample less the mean of its two neighbours.
pub(super) fn size(column: &[f64], k: usize) -> f64 {
    column[k] - 0.5 * (column[k - 1] + column[k + 1])
}

/// Standard deviation of the samples about their neighbours, over the whole column; not less than its
/// rounding.
pub(super) fn of(column: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = (1..column.len().saturating_sub(1)).map(|k| size(column, k).abs()).collect();
    median(&mut sizes) / UNIT + rounding_error(column)
}

/// The same over a range of samples that is not looked beyond, without the rounding.
pub(super) fn within(column: &[f64], range: Range<usize>) -> f64 {
    let mut sizes: Vec<f64> =
        (range.start + 1..range.end.max(1) - 1).map(|k| size(column, k).abs()).collect();
    median(&mut sizes) / UNIT
}

/// The size that one in `rare` of these sizes exceeds.
pub(super) fn rarely(mut sizes: Vec<f64>, rare: usize) -> f64 {
    sizes.sort_by(f64::total_cmp);
    sizes.get((sizes.len() - sizes.len() / rare).saturating_sub(1)).copied().unwrap_or(0.0)
}

/// Standard deviation of the samples about their neighbours over `round` samples before and after `k`, by the
/// median or by the 90 % quantile, whichever is larger: noise may vary with the motion.
pub(super) fn near(column: &[f64], k: usize, round: usize) -> f64 {
    let from = k.saturating_sub(round).max(1);
    let to = (k + round + 1).min(column.len().saturating_sub(1));
    let mut sizes: Vec<f64> =
        (from..to).filter(|j| j.abs_diff(k) > 2).map(|j| size(column, j).abs()).collect();
    let middle = median(&mut sizes) / UNIT;
    sizes.sort_by(f64::total_cmp);
    let tenth = sizes.get(sizes.len() * 9 / 10).copied().unwrap_or(0.0);
    middle.max(tenth / TENTH)
}
