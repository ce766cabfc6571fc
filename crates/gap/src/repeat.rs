//! Repeatability of a motion from cycle to cycle: the accuracy that no deterministic model of a rig can
//! exceed.

use crate::decisions::{PERIOD_FINE_STEP, PERIOD_STEP, PERIODIC, STEADY, TREND};
use crate::whiteness::{lines, mean_step};
use phisindy_signal::{lowest_point, standard_deviation};

/// The repeatability of one column of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeat {
    /// Period (s).
    pub period: f64,
    /// rms of the difference between a cycle and the mean of the others, over the standard deviation of the
    /// column.
    pub nrmse: f64,
    /// The same in the unit of the column.
    pub rms: f64,
}

/// Cycle-to-cycle scatter of a column at these times. `None` where the motion is not periodic or has fewer than four cycles,
/// or where the cycles follow a trend (a transient is not scatter).
pub fn repeatability(time: &[f64], column: &[f64]) -> Option<Repeat> {
    let n = column.len();
    let step = mean_step(time);
    let uniform = time.windows(2).all(|t| (t[1] - t[0] - step).abs() < 0.01 * step);
    let first = *lines(column, step, 1, 0).first()?;
    if !uniform {
        return None;
    }
    let deviation = standard_deviation(column);
    // The fundamental may lie below the strongest line, so the period that predicts best is chosen.
    let guess = 2.0 * std::f64::consts::PI / first / step;
    let miss = |period: f64| scatter(column, period).map_or(f64::INFINITY, |(rms, _)| rms);
    let mut best = (f64::INFINITY, 0.0);
    for multiple in [1.0, 2.0, 3.0] {
        for k in -20..=20 {
            let period = guess * multiple * (1.0 + PERIOD_STEP * f64::from(k));
            let rms = miss(period);
            if rms < best.0 * 0.98 {
                best = (rms, period);
            }
        }
    }
    if best.0.is_infinite() {
        return None;
    }
    // An error of the period counts as scatter, so the period is refined between its neighbours on the grid.
    let reach = PERIOD_STEP * best.1;
    let period = lowest_point(best.1 - reach, best.1 + reach, 1e-7 * best.1, miss);
    // A transient decays; scatter is the same in both halves.
    let middle = n / 2;
    let (early, late) = (scatter(&column[..middle], period), scatter(&column[middle..], period));
    if let (Some((a, _)), Some((b, _))) = (early, late)
        && (a > STEADY * b || b > STEADY * a)
    {
        return None;
    }
    if (n as f64) < 4.0 * period {
        return None;
    }
    let (rms, trend) = scatter(column, period)?;
    (rms < PERIODIC * deviation && trend < TREND).then_some(Repeat {
        period: period * step,
        nrmse: rms / deviation,
        rms,
    })
}

/// Error of the mean cycle of a column as a prediction of the column that continues it: the best accuracy
/// without a model of the rig.
pub(crate) fn prediction(
    (before, column): (&[f64], &[f64]),
    (after, continued): (&[f64], &[f64]),
) -> Option<Repeat> {
    let own = repeatability(before, column)?;
    let step = mean_step(before);
    let deviation = standard_deviation(continued);
    // The errors of the mean cycle of a period in the first record and in the one that continues it.
    let errors = |period: f64| {
        let cells = ((period / step).round() as usize).max(1);
        let cell = |t: f64| (((t - before[0]) / period).fract() * cells as f64) as usize % cells;
        let (mut sums, mut counts) = (vec![0.0; cells], vec![0usize; cells]);
        for (t, v) in before.iter().zip(column) {
            sums[cell(*t)] += v;
            counts[cell(*t)] += 1;
        }
        let error = |times: &[f64], values: &[f64]| -> f64 {
            let (mut sum, mut count) = (0.0, 0usize);
            for (t, v) in times.iter().zip(values) {
                let c = cell(*t);
                if counts[c] > 0 {
                    sum += (v - sums[c] / counts[c] as f64).powi(2);
                    count += 1;
                }
            }
            (sum / count.max(1) as f64).sqrt()
        };
        (error(before, column), error(after, continued))
    };
    // The period is that of the drive, which is known throughout, so both records choose it.
    let miss = |period: f64| {
        let (own, continued) = errors(period);
        own.hypot(continued)
    };
    let grid = (-10..=10).map(|k| own.period * (1.0 + PERIOD_FINE_STEP * f64::from(k)));
    let coarse = grid.min_by(|a, b| miss(*a).total_cmp(&miss(*b)))?;
    let reach = PERIOD_FINE_STEP * coarse;
    let period = lowest_point(coarse - reach, coarse + reach, 1e-7 * coarse, miss);
    let (_, rms) = errors(period);
    Some(Repeat { period, nrmse: rms / deviation, rms })
}

/// rms difference of successive cycles over root 2, and the correlation of successive differences.
fn scatter(column: &[f64], period: f64) -> Option<(f64, f64)> {
    let n = column.len();
    if (n as f64) < 2.2 * period || period < 8.0 {
        return None;
    }
    let at = |t: f64| {
        let i = (t as usize).min(n - 2);
        let f = t - i as f64;
        column[i] * (1.0 - f) + column[i + 1] * f
    };
    let last = (n - 1) as f64;
    let (mut sum, mut count, mut product, mut pairs) = (0.0, 0usize, 0.0, 0usize);
    let mut i = 0;
    while (i as f64) + period <= last {
        let t = i as f64;
        let d = at(t + period) - column[i];
        sum += d * d;
        count += 1;
        if t + 2.0 * period <= last {
            product += d * (at(t + 2.0 * period) - at(t + period));
            pairs += 1;
        }
        i += 1;
    }
    let power = sum / count.max(1) as f64;
    let correlation = if power > 0.0 { product / pairs.max(1) as f64 / power } else { 0.0 };
    Some(((0.5 * power).sqrt(), correlation))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So many samples from one on, a hundred a second.
    fn times(from: usize, n: usize) -> Vec<f64> {
        (from..from + n).map(|i| 0.01 * i as f64).collect()
    }

    /// A sine with uniform jitter of width 0.1.
    fn jittering(n: usize) -> Vec<f64> {
        let mut state = 7u64;
        let mut jitter = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as f64 / (1u64 << 31) as f64 - 0.5
        };
        (0..n).map(|i| (0.0503 * i as f64).sin() + 0.1 * jitter()).collect()
    }

    #[test]
    fn scatter_is_measured_and_a_transient_is_not_scatter() {
        let n = 4000;
        let noisy = jittering(n);
        let found = repeatability(&times(0, n), &noisy).expect("periodic");
        assert!((found.rms - 0.1 / 12f64.sqrt()).abs() < 0.006, "{found:?}");
        let decaying: Vec<f64> =
            (0..n).map(|i| (0.0503 * i as f64).sin() * (1.0 + 0.3 * (-0.001 * i as f64).exp())).collect();
        assert_eq!(repeatability(&times(0, n), &decaying), None);
    }

    /// The mean of thirty cycles misses the next ones by the scatter of both, and misses a motion of twice
    /// the amplitude by half of that motion.
    #[test]
    fn the_mean_cycle_predicts_what_goes_on() {
        let n = 4000;
        let all = jittering(2 * n);
        let (before, after) = (times(0, n), times(n, n));
        let found = prediction((&before, &all[..n]), (&after, &all[n..])).expect("periodic");
        assert!((found.period - 0.01 * std::f64::consts::TAU / 0.0503).abs() < 5e-3, "{found:?}");
        // Besides the jitter, a cell of the mean cycle is one sample wide.
        let cell = 0.0503 / 24f64.sqrt();
        let due = (0.01 / 12.0 * (1.0 + 1.0 / 32.0) + cell * cell).sqrt();
        assert!((found.rms - due).abs() < 0.1 * due, "{found:?} {due}");
        let large: Vec<f64> = all[n..].iter().map(|x| 2.0 * x).collect();
        let found = prediction((&before, &all[..n]), (&after, &large)).expect("periodic");
        assert!((found.nrmse - 0.5).abs() < 0.03, "{found:?}");
        // No cycle repeats, so there is no prediction.
        let drift: Vec<f64> = (0..n).map(|i| (1e-3 * i as f64).powi(2)).collect();
        assert_eq!(prediction((&before, &drift), (&after, &all[n..])), None);
    }

    #[test]
    fn samples_at_uneven_times_are_not_compared_cycle_by_cycle() {
        let (mut time, column) = (times(0, 4000), jittering(4000));
        assert!(repeatability(&time, &column).is_some());
        time[2000] += 0.004;
        assert_eq!(repeatability(&time, &column), None);
    }
}
