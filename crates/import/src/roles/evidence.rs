//! What the headings and the numbers of the columns say about each other.

use super::names::COPIES;
use crate::headings::{Heading, Quantity, factor};
use crate::statistics::Statistics;
use crate::table::Table;
use crate::time_column::{TimeColumn, is_counter};
use phisindy_signal::{automatic, standard_deviation};
use std::ops::Range;

/// The columns of a file, as far as they are known.
pub(crate) struct Evidence<'a> {
    pub(crate) table: &'a Table,
    pub(crate) time: &'a TimeColumn,
    /// Of each column.
    pub(crate) statistics: &'a [Statistics],
    /// The longest stretch of rows in which time does not go back.
    pub(crate) run: &'a Range<usize>,
}

impl Evidence<'_> {
    pub(crate) fn heading(&self, k: usize) -> &Heading {
        &self.table.columns[k].heading
    }

    pub(crate) fn name(&self, k: usize) -> &str {
        &self.heading(k).raw
    }

    /// Whether a column without a unit holds nothing but noise.
    pub(crate) fn is_noise(&self, k: usize) -> bool {
        let look = &self.statistics[k];
        self.heading(k).quantity == Quantity::Unsaid && look.noise > 0.8 * look.std
    }

    /// Whether a column before this one has its heading: no spec can tell the two apart.
    pub(crate) fn is_namesake(&self, k: usize) -> bool {
        (0..k).any(|j| self.name(j) == self.name(k))
    }

    /// The column of which this one is another form, `x` of `x_true`.
    pub(crate) fn original(&self, k: usize) -> Option<usize> {
        let own = self.heading(k);
        let plain = |h: &Heading| -> Vec<String> {
            h.words().filter(|w| !COPIES.contains(w)).map(str::to_owned).collect()
        };
        let same = |&j: &usize| {
            let other = self.heading(j);
            j != k && !other.says(COPIES) && other.quantity == own.quantity && plain(other) == plain(own)
        };
        (0..self.table.columns.len()).find(same).filter(|_| own.says(COPIES))
    }

    /// Columns with a signal in them.
    pub(crate) fn signals(&self) -> Vec<usize> {
        let usable = |&k: &usize| {
            let (column, look) = (&self.table.columns[k], &self.statistics[k]);
            let selector = look.values.is_some()
                && matches!(column.heading.quantity, Quantity::Unsaid | Quantity::Other);
            k != self.time.column
                && !is_counter(column)
                && !self.is_noise(k)
                && self.original(k).is_none()
                && !self.is_namesake(k)
                && column.text_cells == 0
                && !look.is_dead()
                && !selector
                && look.missing * 2 < self.table.rows()
        };
        (0..self.table.columns.len()).filter(usable).collect()
    }

    /// At most twenty thousand rows of the run, for comparisons.
    pub(crate) fn piece(&self, k: usize) -> Vec<f64> {
        let run = self.run.start..self.run.end.min(self.run.start + 20_000);
        self.table.columns[k].values[run].to_vec()
    }

    pub(crate) fn correlation(&self, a: usize, b: usize) -> f64 {
        correlation(&self.piece(a), &self.piece(b))
    }

    /// Whether `b` is the derivative of `a`: alike, and of the right size.
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

/// Of Pearson, over the rows where both have numbers.
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
