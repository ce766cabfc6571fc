//! Counters that overflow, and angles that begin again after a turn.

use phisindy_signal::{bounds, holds_levels, median};

/// A step of more than this part of the range may be a wrap.
const LARGE: f64 = 0.5;
/// After the wraps are taken out no step is larger than this part of the period.
const SMOOTH: f64 = 0.25;

/// How a column wraps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrap {
    /// By how much the column jumps, in its unit.
    pub period: f64,
    /// The sample before the first jump.
    pub first: usize,
    /// How many jumps there are.
    pub count: usize,
}

/// The wraps of a column; none if it jumps otherwise, or not at all.
///
/// Each jump leads from one end of the range to the other, all have one height, which is the range but for
/// the motion in one step, and without them the column moves in small steps.
///
/// ```
/// use phisindy_phys::wraps;
/// let count = |k: i64| (65_000 + 40 * k).rem_euclid(65_536) as f64;
/// let wrap = wraps(&(0..500).map(count).collect::<Vec<f64>>()).unwrap();
/// assert_eq!((wrap.period, wrap.first, wrap.count), (65_536.0, 13, 1));
/// ```
pub fn wraps(values: &[f64]) -> Option<Wrap> {
    let (min, max) = bounds(values);
    let range = max - min;
    let steps = || values.windows(2).map(|w| w[1] - w[0]);
    let jumps: Vec<(usize, f64)> = steps().enumerate().filter(|(_, d)| d.abs() > LARGE * range).collect();
    let &(first, _) = jumps.first()?;
    if 20 * jumps.len() > values.len() || holds_levels(values) {
        return None;
    }
    let still = |k: usize| values.get(k + 1).map_or(0.0, |next| next - values[k]);
    // What the motion does beside a jump, it does in it.
    let beside = |k: usize| median(&mut [k.saturating_sub(1), k + 1].map(still).to_vec());
    let mut heights: Vec<f64> = jumps.iter().map(|(k, d)| (d - beside(*k)).abs()).collect();
    let period = median(&mut heights);
    let largest = steps().filter(|d| d.abs() <= LARGE * range).fold(0.0, |m: f64, d| m.max(d.abs()));
    let alike = heights.iter().all(|h| (h - period).abs() <= 2.0 * largest);
    let (usual, whole) = (largest < SMOOTH * period, (range - period).abs() <= 2.0 * largest);
    // Whole counts have a whole period, a power of two if that is near.
    let counts = values.iter().all(|v| v.fract() == 0.0);
    let power = period.log2().round().exp2();
    let near = |to: f64| (period - to).abs() <= 2.0 * largest;
    let period = if counts && near(power) { power } else { period };
    (alike && usual && whole).then_some(Wrap { period, first, count: jumps.len() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_and_counters_wrap_and_jumps_do_not() {
        let swing = |k: usize| 3.0 * (0.01 * k as f64).sin();
        let turn: Vec<f64> = (0..2000).map(|k| (swing(k) + 1.0).rem_euclid(std::f64::consts::TAU)).collect();
        let wrap = wraps(&turn).expect("a wrap");
        assert!((wrap.period - std::f64::consts::TAU).abs() < 0.01 && wrap.count > 3, "{wrap:?}");
        let slip: Vec<f64> = (0..2000).map(|k| swing(k) + if k > 900 { 9.0 } else { 0.0 }).collect();
        let relay: Vec<f64> = (0..2000).map(|k| if k / 50 % 2 == 0 { 1.0 } else { -1.0 }).collect();
        for column in [slip, relay, (0..2000).map(swing).collect()] {
            assert_eq!(wraps(&column), None);
        }
    }
}
