//! Columns that hold a value and jump to the next one: relays, pulses, switches, commanded steps.

/// Percentage of the jumps that are alone: the column stands still before and after.
const ALONE_PERCENT: usize = 90;
/// A column of at most this many levels may be held for equal times; one of more is a slow sensor.
const FEW_LEVELS: usize = 12;
/// A column of more levels than this that moves by its smallest step alone is a quantised motion.
const SWITCH_LEVELS: usize = 3;

/// Whether a column is piecewise constant by nature, as a relay, a series of pulses or commanded steps are. It
/// has no noise, no rate between its jumps, and no end of a range that cuts it off.
///
/// A coarse encoder moves by single steps, a logger that is faster than its sensor repeats many values equally
/// often; neither is piecewise constant by nature. Nor is a column without any change.
///
/// ```
/// let relay: Vec<f64> = (0..500).map(|k| if k / 37 % 2 == 0 { 13.3 } else { -13.3 }).collect();
/// assert!(phisindy_signal::holds_levels(&relay));
/// let motion: Vec<f64> = (0..500).map(|k| (0.02 * f64::from(k)).sin()).collect();
/// assert!(!phisindy_signal::holds_levels(&motion));
/// ```
pub fn holds_levels(values: &[f64]) -> bool {
    let jumps: Vec<usize> = (1..values.len()).filter(|&k| values[k] != values[k - 1]).collect();
    if jumps.is_empty() {
        return false;
    }
    let still = |k: usize| k == 0 || k >= values.len() || values[k] == values[k - 1];
    let alone = jumps.iter().filter(|&&k| still(k - 1) && still(k + 1)).count();
    if 100 * alone < ALONE_PERCENT * jumps.len() {
        return false;
    }
    let mut levels: Vec<f64> = values.to_vec();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let few = levels.len() <= FEW_LEVELS;
    levels.len() <= SWITCH_LEVELS || (!moves_by_single_steps(values, &jumps) && (few || !evenly_held(&jumps)))
}

/// Whether most jumps have the height of the smallest one.
fn moves_by_single_steps(values: &[f64], jumps: &[usize]) -> bool {
    let height = |k: &usize| (values[*k] - values[k - 1]).abs();
    let least = jumps.iter().map(height).fold(f64::INFINITY, f64::min);
    2 * jumps.iter().filter(|k| height(k) < 1.5 * least).count() > jumps.len()
}

/// Whether nearly all values are held for the same number of samples, or one more.
fn evenly_held(jumps: &[usize]) -> bool {
    let mut lengths: Vec<usize> = jumps.windows(2).map(|w| w[1] - w[0]).collect();
    lengths.sort_unstable();
    let Some(&shortest) = lengths.get(lengths.len() / 20) else { return false };
    let alike = lengths.iter().filter(|n| (shortest..=shortest + 1).contains(*n)).count();
    100 * alike >= ALONE_PERCENT * lengths.len()
}

#[cfg(test)]
mod tests {
    use super::holds_levels;
    use crate::test_signals::{gaussian, stick_slip};

    #[test]
    fn relays_pulses_and_steps_hold_levels() {
        let column = |f: &dyn Fn(usize) -> f64| (0..2000).map(f).collect::<Vec<f64>>();
        let random = gaussian(2000, 3);
        for (k, held) in [
            column(&|k| if k % 70 < 30 { 12.0 } else { -12.0 }),
            column(&|k| if k < 700 { 0.0 } else { 5.0 }),
            column(&|k| if k % 200 < 10 { random[k / 200] } else { 0.0 }),
            // Equal times, few levels; random times, many levels.
            column(&|k| (random[k / 200] * 4.0).round()),
            column(&|k| random[(k + 17 * (k / 90 % 3)) / 60]),
        ]
        .iter()
        .enumerate()
        {
            assert!(holds_levels(held), "{k}");
        }
    }

    #[test]
    fn motion_noise_encoders_and_slow_loggers_do_not() {
        let random = gaussian(2000, 3);
        let swing = |k: usize| (0.01 * k as f64).sin();
        let column = |f: &dyn Fn(usize) -> f64| (0..2000).map(f).collect::<Vec<f64>>();
        for (k, moving) in [
            vec![1.0; 50],
            column(&swing),
            column(&|k| random[k]),
            column(&|k| (8.0 * swing(k)).round()),
            column(&|k| (8.0 * swing(k) + random[k]).round()),
            column(&|k| swing(k / 4 * 4) + 0.01 * random[k / 4]),
            stick_slip().1,
            stick_slip().2,
        ]
        .iter()
        .enumerate()
        {
            assert!(!holds_levels(moving), "{k}");
        }
    }
}
