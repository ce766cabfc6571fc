//! The step of a quantised column (an encoder's count, the last digit of a text file).

use crate::statistics::largest;
use std::collections::BTreeSet;

/// Fewer levels are a switching signal, not a quantised motion.
const MIN_LEVELS: usize = 12;
/// The part of the samples that must repeat the one before. In faster motion quantisation appears as plain
/// noise.
const MIN_REPEATS: f64 = 0.02;

/// Standard deviation of the rounding error of a quantised column, step/sqrt(12); 0 for a column that is not
/// quantised.
///
/// A column at rest shows no noise, but its value is not known better than its step.
pub fn rounding_error(values: &[f64]) -> f64 {
    quantum(values, MIN_LEVELS).unwrap_or(0.0) / f64::sqrt(12.0)
}

/// The quantisation step of a column; none if samples hardly ever repeat, if changes are no multiples of one
/// step, or if it has fewer than `least_levels` levels.
pub fn quantum(values: &[f64], least_levels: usize) -> Option<f64> {
    let scale = largest(values);
    let changes = || values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    // Changes of this size are rounding errors.
    let same = 1e-12 * scale;
    let repeats = changes().filter(|c| *c <= same).count();
    let smallest = changes().filter(|c| *c > same).fold(f64::INFINITY, f64::min);
    if !smallest.is_finite() || (repeats as f64) < MIN_REPEATS * values.len() as f64 {
        return None;
    }
    // In rounded text files the mean over single steps is more accurate than the smallest.
    let (sum, count) = changes()
        .filter(|c| *c > same && *c < 1.5 * smallest)
        .fold((0.0, 0.0), |(sum, count), c| (sum + c, count + 1.0));
    let step = sum / count;
    let multiple = |c: f64| (c / step - (c / step).round()).abs() < 0.1;
    let (fitting, moved) = changes()
        .filter(|c| *c > same)
        .fold((0, 0), |(fitting, moved), c| (fitting + usize::from(multiple(c)), moved + 1));
    let levels: BTreeSet<i64> = values.iter().map(|v| ((v - values[0]) / step).round() as i64).collect();
    (fitting * 100 >= moved * 98 && levels.len() >= least_levels).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::rounding_error;
    use crate::test_signals::{gaussian, stick_slip};

    fn swing(f: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..2000).map(|i| f((0.005 * f64::from(i)).sin())).collect()
    }

    #[test]
    fn steps_are_found_and_nothing_else() {
        let step = 6.136e-4;
        let exact = step / 12f64.sqrt();
        let encoder = swing(|x| (0.5 * x / step).round() * step);
        assert!((rounding_error(&encoder) / exact - 1.0).abs() < 1e-9);
        // As a text file with six decimals gives it.
        let printed: Vec<f64> = encoder.iter().map(|v| (v * 1e6).round() / 1e6).collect();
        assert!((rounding_error(&printed) / exact - 1.0).abs() < 0.01);
        let resting: Vec<f64> = stick_slip().0;
        for column in [
            swing(|x| x),
            swing(f64::signum),
            resting,
            stick_slip().2,
            gaussian(500, 3),
            vec![1.0; 9],
            vec![],
        ] {
            assert_eq!(rounding_error(&column), 0.0);
        }
    }
}
