//! Is a residual more than white noise?
//!
//! There are two measures, because they are compared with two kinds of limits:
//!
//! - [`whiteness_p_value`] is a probability, for a verdict on one residual. It needs no motion beside it: the
//!   periodogram of white noise is a row of independent exponential numbers, and a line or an excess at low
//!   frequencies is improbable among them. No window is applied, since a window would make neighbours
//!   dependent.
//! - [`whiteness_score`] is a number of standard deviations, for ranking models of which all but the last
//!   leave far more than noise. There a probability would be 0. It compares the band in which the motion lies
//!   with the band above it, by a Hann window, which keeps the strong lines of a missing effect out of the
//!   band above.
//!
//! White noise scores below 4 and has a probability that is not small; the two numbers have no fixed
//! relation.

use crate::fft::{periodogram, power};
use crate::statistics::median;

/// Both measures need this many samples.
const MIN_SAMPLES: usize = 64;
/// The narrowest band of low frequencies that is tested, in bins; each further one is twice as wide.
const NARROWEST_BAND: usize = 4;
/// Neighbouring bins of a Hann window are correlated: this many count as one.
const BINS_PER_SAMPLE: f64 = 1.94;

/// The probability that white noise departs from a flat spectrum as far as this residual does.
///
/// Tested are the strongest single frequency (R. A. Fisher, Proc. R. Soc. A 125 (1929) 54-59), the power in
/// bands from zero up, and the mean, each against the median of the spectrum. The smallest probability is
/// multiplied by the number of tests (Bonferroni), so the result is an upper bound. Fewer than 64 samples and
/// a residual of zeros give 1; numbers that are not finite give 0.
///
/// ```
/// let noise: Vec<f64> = (0..2000_u32).map(|i| f64::from(i.wrapping_mul(2_654_435_769) >> 16) / 65536.0 - 0.5).collect();
/// let line: Vec<f64> = noise.iter().enumerate().map(|(i, e)| e + 0.2 * (0.1 * i as f64).sin()).collect();
/// assert!(phisindy_signal::whiteness_p_value(&line) < 1e-6);
/// ```
pub fn whiteness_p_value(residual: &[f64]) -> f64 {
    let n = residual.len();
    if residual.iter().any(|e| !e.is_finite()) {
        return 0.0;
    }
    if n < MIN_SAMPLES {
        return 1.0;
    }
    let spectrum = power(&mut residual.to_vec());
    // The mean has a test of its own; the last bin of an even length, with one degree of freedom only, none.
    let power = &spectrum[1..n.div_ceil(2)];
    let level = median(&mut power.to_vec()) / std::f64::consts::LN_2;
    if level <= 0.0 {
        return if power.iter().any(|p| *p > 0.0) { 0.0 } else { 1.0 };
    }
    let bins = power.len();
    let strongest = power.iter().copied().fold(0.0, f64::max) / level;
    let line = bins as f64 * (-strongest).exp();
    let widths: Vec<usize> =
        std::iter::successors(Some(NARROWEST_BAND), |w| Some(2 * w)).take_while(|w| *w <= bins / 4).collect();
    let band = |&width: &usize| widths.len() as f64 * upper_tail(&power[..width], level);
    // The power at zero is a chi square with one degree of freedom.
    let mean = (-0.5 * spectrum[0] / level).exp();
    (widths.iter().map(band).fold(line.min(mean), f64::min) * 3.0).min(1.0)
}

/// The probability of at least this power in a band, a chi square with two degrees of freedom for each bin
/// (E. B. Wilson and M. M. Hilferty, PNAS 17 (1931) 684-688).
fn upper_tail(power: &[f64], level: f64) -> f64 {
    let m = power.len() as f64;
    let ratio = power.iter().sum::<f64>() / (level * m);
    let z = (ratio.cbrt() - (1.0 - 1.0 / (9.0 * m))) * (9.0 * m).sqrt();
    // An upper bound of the tail of the normal distribution, close where it is small.
    if z <= 1.0 { 1.0 } else { (-0.5 * z * z).exp() / (z * (2.0 * std::f64::consts::PI).sqrt()) }
}

/// How far a residual departs from white noise, in standard deviations.
///
/// The score is `(mean power in the band of the motion / mean power above it - 1) * sqrt(bins in the band)`
/// by a Hann periodogram, or the same for the lowest frequencies alone, or the mean over its standard error,
/// whichever is largest. White noise gives about a standard normal number, a missing effect hundreds.
/// `motion` is the column itself, which tells where its band ends. Fewer than 64 samples and columns of two
/// lengths give 0; a residual without any power above the band gives infinity.
pub fn whiteness_score(residual: &[f64], motion: &[f64]) -> f64 {
    let n = residual.len();
    if n < MIN_SAMPLES || motion.len() != n {
        return 0.0;
    }
    let (left, column) = (periodogram(residual), periodogram(motion));
    let bins = left.len();
    let edge = band(&column);
    let floor = trimmed_mean(&left[edge..]);
    if floor <= 0.0 {
        return if left[..edge].iter().any(|p| *p > 0.0) { f64::INFINITY } else { 0.0 };
    }
    let inside = left[1..edge].iter().sum::<f64>() / (edge - 1) as f64;
    let wide = (inside / floor - 1.0) * ((edge - 1) as f64 / BINS_PER_SAMPLE).sqrt();
    // A narrow band is more sensitive to lines at low frequencies and to slow drifts.
    let narrow_edge = (bins / 50).clamp(16, edge.max(17) - 1);
    let narrow = left[1..narrow_edge].iter().sum::<f64>() / (narrow_edge - 1) as f64;
    let narrow = (narrow / floor - 1.0) * ((narrow_edge - 1) as f64 / BINS_PER_SAMPLE).sqrt();
    // The periodogram leaves out the mean. Its standard error is sqrt(variance / n), with the variance from
    // the floor; 0.375 is the mean square of a Hann window.
    let mean = residual.iter().sum::<f64>() / n as f64;
    let variance = floor / (n as f64 * 0.375);
    let level = mean.abs() / (variance / n as f64).sqrt();
    wide.max(narrow).max(level)
}

/// The bin where the band of the motion ends: above it the column has the power of its noise. Between a
/// twentieth and a half of the axis.
fn band(column: &[f64]) -> usize {
    let bins = column.len();
    let floor = trimmed_mean(&column[bins / 2..]);
    let block = (bins / 64).max(4);
    let mut edge = bins / 20;
    for start in (0..bins / 2).step_by(block) {
        let slice = &column[start..(start + block).min(bins)];
        if slice.iter().sum::<f64>() / slice.len() as f64 > 3.0 * floor {
            edge = edge.max(start + block);
        }
    }
    edge.clamp((bins / 20).max(17), (bins / 2).max(18))
}

/// Mean of exponentially distributed powers, from their lower nine tenths, so that lines do not count.
fn trimmed_mean(power: &[f64]) -> f64 {
    let mut sorted = power.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let kept = (sorted.len() * 9 / 10).max(1).min(sorted.len());
    // The lower 90 % of an exponential of mean 1 have the mean 1 - 0.1 ln(10)/0.9.
    let share = 1.0 - 0.1 * 10f64.ln() / 0.9;
    sorted[..kept].iter().sum::<f64>() / kept.max(1) as f64 / share
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normal enough: sums of twelve uniform numbers.
    fn noise(n: usize, seed: u64) -> Vec<f64> {
        let mut state = seed;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..n).map(|_| (0..12).map(|_| uniform()).sum::<f64>() - 6.0).collect()
    }

    #[test]
    fn white_noise_has_the_chance_that_is_said() {
        let runs = 2000;
        let below = |p: f64| {
            (0..runs).filter(|&s| whiteness_p_value(&noise(700, 7 + 13 * s)) < p).count() as f64 / runs as f64
        };
        // Looks are paid for as if they were independent, so the chance is at most what is said; four
        // standard errors are room.
        for p in [0.1, 0.01] {
            assert!(below(p) < p + 4.0 * (p / runs as f64).sqrt(), "{} below {p}", below(p));
        }
        assert!(below(0.5) > 0.1, "{}", below(0.5));
    }

    #[test]
    fn a_faint_line_and_a_slow_drift_are_seen() {
        let with = |f: &dyn Fn(f64) -> f64| -> f64 {
            let left: Vec<f64> = noise(1500, 3).iter().enumerate().map(|(i, e)| e + f(i as f64)).collect();
            whiteness_p_value(&left)
        };
        assert!(with(&|_| 0.0) > 0.01);
        // A quarter of the noise: the rms rises by a thirtieth.
        assert!(with(&|i| 0.35 * (2.0 * i).sin()) < 1e-6);
        assert!(with(&|i| 0.9 * (i / 1500.0 - 0.5)) < 1e-4);
        // Neither line nor slow: a constant misfit of a quarter of the noise.
        assert!(with(&|_| 0.25) < 1e-6);
    }

    #[test]
    fn nothing_and_too_little_are_no_evidence() {
        assert_eq!(whiteness_p_value(&[]), 1.0);
        assert_eq!(whiteness_p_value(&[0.0; 500]), 1.0);
        assert_eq!(whiteness_p_value(&[f64::NAN; 500]), 0.0);
    }

    #[test]
    fn noise_is_white_and_a_faint_line_is_not() {
        let n = 4000;
        let motion: Vec<f64> = (0..n).map(|i| 30.0 * (0.05 * i as f64).sin()).collect();
        let mut left = noise(n, 1);
        let column: Vec<f64> = motion.iter().zip(&left).map(|(a, b)| a + b).collect();
        assert!(whiteness_score(&left, &column).abs() < 4.0, "{}", whiteness_score(&left, &column));
        // A line of a third of the noise: gap 1.05.
        left.iter_mut().zip(&motion).for_each(|(l, m)| *l += m / 30.0 * 0.45);
        assert!(whiteness_score(&left, &column) > 6.0, "{}", whiteness_score(&left, &column));
    }

    /// Too short to tell, nothing at all, or a line without any noise round it.
    #[test]
    fn the_ends_of_the_score() {
        let motion: Vec<f64> =
            (0..1024).map(|i| (std::f64::consts::TAU * f64::from(i) / 64.0).cos()).collect();
        assert_eq!(whiteness_score(&noise(63, 1), &motion[..63]), 0.0);
        assert_eq!(whiteness_score(&noise(64, 1), &motion[..65]), 0.0);
        assert_eq!(whiteness_score(&[0.0; 1024], &motion), 0.0);
    }
}
