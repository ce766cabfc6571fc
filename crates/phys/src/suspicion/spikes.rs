//! Spikes: single samples far from neighbours that lie on a smooth curve.

use super::scatter;

/// A spike deviates by this many times the scatter of the samples beside it; no one of a million normal
/// numbers does.
const SPIKE: f64 = 7.0;
/// The scatter is taken over this many samples on either side.
const ROUND: usize = 40;
/// More than one spike in this many samples is noise of the sensor.
const RARE: usize = 50;
/// A deviation that more than one of this many other samples has is none either: a fit weighs all samples of
/// a column alike.
const ELSEWHERE: usize = 200;

/// The samples that are spikes; none if they are frequent.
pub(super) fn spikes(column: &[f64]) -> Vec<usize> {
    let n = column.len();
    let least = SPIKE * scatter::of(column);
    // On one side of both neighbours, which are close to theirs: steps, corners and pulses of several samples
    // are motion.
    let stands_alone = |k: usize, size: f64| {
        let at = |j: usize| column[j];
        let (left, right) = (at(k) - at(k - 1), at(k) - at(k + 1));
        let quiet = |a: usize, b: usize, c: usize| (at(a) - at(b)).abs().min((at(a) - at(c)).abs());
        left * right > 0.0
            && left.abs().min(right.abs()) > 0.7 * size
            && quiet(k - 1, k - 2, k - 3).max(quiet(k + 1, k + 2, k + 3)) < size / 3.0
    };
    let apart = |k: usize| {
        let size = scatter::size(column, k).abs();
        size > least && stands_alone(k, size) && size > SPIKE * scatter::near(column, k, ROUND)
    };
    let mut all: Vec<usize> = (3..n.saturating_sub(3)).filter(|&k| apart(k)).collect();
    let mut others = vec![true; n];
    all.iter().for_each(|&k| others[k - 1..=k + 1].fill(false));
    let size = |k: usize| scatter::size(column, k).abs();
    let elsewhere = (1..n.saturating_sub(1)).filter(|&k| others[k]).map(size).collect();
    let usual = scatter::rarely(elsewhere, ELSEWHERE);
    all.retain(|&k| size(k) > usual);
    if all.len() * RARE <= n { all } else { vec![] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_signal::test_signals::gaussian;

    /// A harmonic motion with noise of this standard deviation.
    fn swing(noise: f64) -> Vec<f64> {
        let swing = |i: usize| (0.03 * i as f64).sin();
        gaussian(3000, 5).iter().enumerate().map(|(i, e)| swing(i) + noise * e).collect()
    }

    #[test]
    fn spikes_are_told_beside_others_and_in_noise() {
        for noise in [0.0, 0.01, 0.05] {
            let mut x = swing(noise);
            let at = [300, 302, 900, 1700, 1701, 2003];
            at.iter().for_each(|&k| x[k] += 3.0);
            // Two samples side by side may be a motion.
            assert_eq!(spikes(&x), [300, 302, 900, 2003], "{noise}");
            let mut many = swing(noise);
            (0..25).for_each(|k| many[100 * k + 50] -= 3.0);
            assert_eq!(spikes(&many).len(), 25);
        }
    }

    #[test]
    fn what_motion_and_noise_do_is_no_spike() {
        let noise = gaussian(3000, 8);
        // Noise that grows with the motion, stick-slip, a square wave, bounces, one hard kick.
        let relative: Vec<f64> = swing(0.0).iter().zip(&noise).map(|(x, e)| x * (1.0 + 0.1 * e)).collect();
        let slips = |i: usize| if i % 100 < 4 { [0.0, 0.5, 1.0, 0.5][i % 100] } else { 0.0 };
        let square = |i: usize| if i % 80 < 40 { 1.0 } else { -1.0 };
        let bounce = |i: usize| (0.05 * i as f64).sin().abs();
        let decay = |i: usize| if i < 1000 { 0.0 } else { (-0.5 * (i - 1000) as f64).exp() };
        let noisy = |f: &dyn Fn(usize) -> f64| (0..3000).map(|i| f(i) + 0.01 * noise[i]).collect();
        // A small deviation in the quiet part of a column that is a hundred times as noisy for a tenth of the
        // time.
        let level = |i: usize| if i < 2700 { 1e-3 } else { 0.1 };
        let mut quiet: Vec<f64> = (0..3000).map(|i| (0.03 * i as f64).sin() + level(i) * noise[i]).collect();
        quiet[1100] += 0.03;
        let columns: [Vec<f64>; 7] =
            [swing(0.03), relative, noisy(&slips), noisy(&square), noisy(&bounce), noisy(&decay), quiet];
        for (k, column) in columns.iter().enumerate() {
            assert_eq!(spikes(column), [], "{k}");
        }
        let clean: Vec<f64> = (0..3000).map(bounce).collect();
        assert_eq!(spikes(&clean), []);
    }
}
