//! The scales of a motion, which say what values of inner numbers are tried and how far they may go.

use super::atom::Inner;

/// Quantile of a quantity that counts as its largest, to leave out outliers.
const TOP: f64 = 0.99;
/// Radians across the largest value that are tried: the first, the last, and the step between two.
const WAVES: (f64, f64, f64) = (0.4, 16.0, 0.3);
/// Sizes that are tried, as parts of the largest value: first, last, and how many.
const SIZES: (f64, f64, usize) = (0.02, 3.0, 24);
/// Rates that are tried, times the largest value.
const RATES: (f64, f64, usize) = (0.25, 6.0, 16);
/// Powers that are tried.
const POWERS: [f64; 8] = [0.25, 0.75, 1.25, 1.75, 2.25, 2.75, 3.5, 4.0];
/// Corners that are tried, as quantiles of the values.
const CORNERS: usize = 20;
/// How far beyond the values that are tried a number may be found.
const BEYOND: f64 = 100.0;

/// The values of a quantity along the motion.
#[derive(Clone, Debug)]
pub(super) struct Scale {
    /// The largest absolute value.
    top: f64,
    sorted: Vec<f64>,
}

impl Scale {
    pub(super) fn new(values: &[Vec<f64>]) -> Scale {
        let mut sorted: Vec<f64> = values.iter().flatten().copied().collect();
        sorted.sort_unstable_by(f64::total_cmp);
        let mut sizes: Vec<f64> = sorted.iter().map(|v| v.abs()).collect();
        sizes.sort_unstable_by(f64::total_cmp);
        Scale { top: quantile(&sizes, TOP), sorted }
    }

    /// The values that are tried for a number; fewer where `coarse`.
    pub(super) fn values(&self, inner: Inner, coarse: bool) -> Vec<f64> {
        let every = if coarse { 2 } else { 1 };
        let (top, sorted) = (self.top, &self.sorted);
        let all: Vec<f64> = match inner {
            Inner::No => vec![],
            Inner::Size => geometric(SIZES).map(|q| q * top).collect(),
            Inner::Rate => geometric(RATES).flat_map(|q| [q / top, -q / top]).collect(),
            Inner::Wave => {
                let count = ((WAVES.1 - WAVES.0) / WAVES.2) as usize;
                (0..=count).map(|k| (WAVES.0 + k as f64 * WAVES.2) / top).collect()
            }
            Inner::Corner => (1..CORNERS).map(|k| quantile(sorted, k as f64 / CORNERS as f64)).collect(),
            Inner::Power => POWERS.to_vec(),
        };
        let pairs = if inner == Inner::Rate { 2 } else { 1 };
        let kept = |(k, v): (usize, f64)| ((k / pairs) % every == 0 && v.is_finite()).then_some(v);
        all.into_iter().enumerate().filter_map(kept).collect()
    }

    /// The bounds of a number.
    pub(super) fn within(&self, inner: Inner) -> (f64, f64) {
        let top = if self.top > 0.0 { self.top } else { 1.0 };
        match inner {
            Inner::No => (0.0, 0.0),
            Inner::Size => (SIZES.0 / BEYOND * top, SIZES.1 * BEYOND * top),
            Inner::Rate => (-RATES.1 * BEYOND / top, RATES.1 * BEYOND / top),
            Inner::Wave => (WAVES.0 / BEYOND / top, WAVES.1 * BEYOND / top),
            Inner::Corner => (-BEYOND * top, BEYOND * top),
            Inner::Power => (0.1, 4.0),
        }
    }

    /// Least and largest value.
    pub(super) fn range(&self) -> (f64, f64) {
        (self.sorted.first().copied().unwrap_or(0.0), self.sorted.last().copied().unwrap_or(0.0))
    }

    /// How far one step of the grid goes from a value: the neighbours between which it is refined.
    pub(super) fn step(&self, inner: Inner, value: f64, coarse: bool) -> f64 {
        let every = if coarse { 2.0 } else { 1.0 };
        let ratio =
            |(first, last, count): (f64, f64, usize)| (last / first).powf(every / (count - 1) as f64) - 1.0;
        match inner {
            Inner::No => 0.0,
            Inner::Size => ratio(SIZES) * value.abs(),
            Inner::Rate => ratio(RATES) * value.abs(),
            Inner::Wave => every * WAVES.2 / self.top,
            Inner::Corner => {
                let (low, high) = self.range();
                (high - low) / CORNERS as f64
            }
            Inner::Power => 0.3,
        }
    }
}

fn geometric((first, last, count): (f64, f64, usize)) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| first * (last / first).powf(k as f64 / (count - 1) as f64))
}

fn quantile(sorted: &[f64], q: f64) -> f64 {
    sorted.get(((sorted.len().max(1) - 1) as f64 * q) as usize).copied().unwrap_or(0.0)
}
