//! Columns that hold a value and jump to the next one: relays, pulses, switches, commanded steps.

use crate::statistics::median;

/// Percentage of the jumps that are alone: the column stands still before and after.
const ALONE_PERCENT: usize = 90;
/// A column of at most this many levels may be held for equal times; one of more is a slow sensor.
const FEW_LEVELS: usize = 12;
/// A column of more levels than this that moves by its smallest step alone is a quantised motion.
const SWITCH_LEVELS: usize = 3;

/// Whether a column is piecewise constant by nature, as a relay, a series of pulses or commanded steps are.
/// It has no noise, no rate between its jumps, and no end of a range that cuts it off.
///
/// A coarse encoder moves by single steps, a logger that is faster than its sensor repeats many values
/// equally often; neither is piecewise constant by nature. Nor is a column without any change.
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

/// A step of this many times the median step is a jump ...
const JUMP: f64 = 10.0;
/// ... if the steps beside it are smaller than this part of it.
const BESIDE: f64 = 0.3;
/// The part of the mean square of all steps that jumps have in a column that moves by jumps.
const MOST: f64 = 0.9;

/// Whether a column moves by jumps from level to level, with the noise of a sensor on the levels or without:
/// [`holds_levels`], or a relay that was measured. Such an input is to be held between its samples.
///
/// ```
/// let noise = |k: u32| f64::from(k.wrapping_mul(2_654_435_769) >> 16) / 65_536.0;
/// let relay: Vec<f64> = (0..500).map(|k| 0.1 * noise(k) + if k / 37 % 2 == 0 { 13.3 } else { -13.3 }).collect();
/// assert!(phisindy_signal::moves_by_jumps(&relay) && !phisindy_signal::holds_levels(&relay));
/// ```
pub fn moves_by_jumps(values: &[f64]) -> bool {
    if holds_levels(values) {
        return true;
    }
    let steps: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    let least = JUMP * median(&mut steps.clone());
    let beside = |k: usize| steps.get(k).copied().unwrap_or(0.0);
    let is_jump = |k: &usize| {
        let quiet = beside(k + 1).max(k.checked_sub(1).map_or(0.0, beside)) < BESIDE * steps[*k];
        least > 0.0 && steps[*k] > least && quiet
    };
    let jumps: Vec<usize> = (0..steps.len()).filter(is_jump).collect();
    let square = |all: f64, step: f64| all + step * step;
    let of_jumps = jumps.iter().map(|&k| steps[k]).fold(0.0, square);
    let whole = steps.iter().copied().fold(0.0, square);
    // Between two jumps a level stays, unlike a saw.
    let leaves = |pair: &&[usize]| (values[pair[1]] - values[pair[0] + 1]).abs() > BESIDE * steps[pair[0]];
    let left = jumps.windows(2).filter(leaves).count();
    whole > 0.0 && of_jumps > MOST * whole && 100 * left <= (100 - ALONE_PERCENT) * jumps.len()
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
    use super::{holds_levels, moves_by_jumps};
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
    fn a_measured_relay_moves_by_jumps() {
        let random = gaussian(2000, 3);
        let column = |f: &dyn Fn(usize) -> f64| (0..2000).map(f).collect::<Vec<f64>>();
        let relay = |k: usize| if k % 70 < 30 { 12.0 } else { -12.0 };
        assert!(moves_by_jumps(&column(&|k| relay(k) + 0.05 * random[k])));
        assert!(moves_by_jumps(&column(&|k| ((relay(k) + 0.05 * random[k]) / 0.02).round() * 0.02)));
        // A hammer, a saw, a sine, a spike.
        let hammer = |k: usize| 40.0 * (-((k % 400) as f64 / 2.0 - 50.0).powi(2) / 4.0).exp();
        for (k, other) in [
            column(&|k| hammer(k) + 0.05 * random[k]),
            column(&|k| (k % 100) as f64),
            column(&|k| (0.3 * k as f64).sin() + 0.01 * random[k]),
            column(&|k| if k % 500 == 250 { 9.0 } else { 0.01 * random[k] }),
            random.clone(),
        ]
        .iter()
        .enumerate()
        {
            assert!(!moves_by_jumps(other), "{k}");
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
