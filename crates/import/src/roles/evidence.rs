//! Relations between the columns of a table, from headings and numbers.

use super::names::COPIES;
use crate::headings::{Heading, Quantity, factor};
use crate::statistics::Statistics;
use crate::table::Table;
use crate::time_column::{TimeColumn, is_counter};
use phisindy_signal::{automatic, standard_deviation};
use std::ops::Range;

/// A table with its time column and statistics.
pub(crate) struct Evidence<'a> {
    pub(crate) table: &'a Table,
    pub(crate) time: &'a TimeColumn,
    /// Of each column.
    pub(crate) statistics: &'a [Statistics],
    /// The longest range of rows in which time does not go back.
    pub(crate) run: &'a Range<usize>,
}

impl Evidence<'_> {
    pub(crate) fn heading(&self, k: usize) -> &Heading {
        &self.table.columns[k].heading
    }

    pub(crate) fn name(&self, k: usize) -> &str {
        &self.heading(k).raw
    }

    /// Whether a column without unit holds noise only.
    pub(crate) fn is_noise(&self, k: usize) -> bool {
        let statistics = &self.statistics[k];
        self.heading(k).quantity == Quantity::Unknown && statistics.noise > 0.8 * statistics.std
    }

    /// Whether an earlier column has the same heading: a spec cannot tell the two apart.
    pub(crate) fn is_namesake(&self, k: usize) -> bool {
        (0..k).any(|j| self.name(j) == self.name(k))
    }

    /// The column of which this one is a copy: `x` for `x_true`.
    pub(crate) fn original(&self, k: usize) -> Option<usize> {
        let own = self.heading(k);
        let plain = |h: &Heading| -> Vec<String> {
            h.words().filter(|w| !COPIES.contains(w)).map(str::to_owned).collect()
        };
        let same = |&j: &usize| {
            let other = self.heading(j);
            j != k && !other.has_word(COPIES) && other.quantity == own.quantity && plain(other) == plain(own)
        };
        (0..self.table.columns.len()).find(same).filter(|_| own.has_word(COPIES))
    }

    /// Columns that hold a signal and may have a role.
    pub(crate) fn signals(&self) -> Vec<usize> {
        let usable = |&k: &usize| {
            let (column, statistics) = (&self.table.columns[k], &self.statistics[k]);
            let selector = statistics.values.is_some()
                && matches!(column.heading.quantity, Quantity::Unknown | Quantity::Other);
            k != self.time.column
                && !is_counter(column)
                && !self.is_noise(k)
                && self.original(k).is_none()
                && !self.is_namesake(k)
                && column.text_cells == 0
                && !statistics.is_constant()
                && !selector
                && statistics.missing * 2 < self.table.rows()
        };
        (0..self.table.columns.len()).filter(usable).collect()
    }

    /// The first 20 000 rows of the run, for comparisons.
    pub(crate) fn piece(&self, k: usize) -> Vec<f64> {
        let run = self.run.start..self.run.end.min(self.run.start + 20_000);
        self.table.columns[k].values[run].to_vec()
    }

    pub(crate) fn correlation(&self, a: usize, b: usize) -> f64 {
        correlation(&self.piece(a), &self.piece(b))
    }

    /// Whether `b` is the derivative of `a`: correlated, and of the same size in common units.
    pub(crate) fn is_derivative(&self, a: usize, b: usize) -> bool {
        let (time, x) = (self.piece(self.time.column), self.piece(a));
        let Ok(slope) = automatic(&time, &x) else { return false };
        let y = self.piece(b);
        let ratio = standard_deviation(&y)
            / (standard_deviation(&slope.derivative)
                / factor(self.heading(self.time.column).unit.as_deref()));
        correlation(&slope.derivative, &y) > 0.9
            && [1e-3, 1.0, 1e3, std::f64::consts::PI / 180.0, 180.0 / std::f64::consts::PI]
                .iter()
                .any(|f| (ratio / f - 1.0).abs() < 0.25)
    }
}

/// Pearson correlation over the rows in which both columns have numbers.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let pairs: Vec<(f64, f64)> =
        a.iter().copied().zip(b.iter().copied()).filter(|(a, b)| a.is_finite() && b.is_finite()).collect();
    let n = pairs.len().max(1) as f64;
    let (ma, mb) = pairs.iter().fold((0.0, 0.0), |(s, t), (a, b)| (s + a / n, t + b / n));
    let (aa, bb, ab) = pairs.iter().fold((0.0, 0.0, 0.0), |(aa, bb, ab), (a, b)| {
        (aa + (a - ma).powi(2), bb + (b - mb).powi(2), ab + (a - ma) * (b - mb))
    });
    if aa > 0.0 && bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}
