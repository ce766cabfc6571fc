//! Is anything left in a residual but noise? Noise has a flat spectrum; whatever a model lacks lies where the motion is, at low frequencies.

use realfft::RealFftPlanner;

/// A score beyond this is not noise: white residuals stay below 4.
pub(crate) const COLOURED: f64 = 6.0;

/// `(mean power in the band of the motion / mean power above - 1) sqrt(bins in the band)` of a residual, by a Hann periodogram: about a standard normal number for
/// white noise, in the hundreds for a missing effect. `motion` is the column, which says where its band ends. 0 for records too short to tell.
pub(crate) fn score(residual: &[f64], motion: &[f64]) -> f64 {
    let n = residual.len();
    if n < 64 || motion.len() != n {
        return 0.0;
    }
    let (left, column) = (periodogram(residual), periodogram(motion));
    let bins = left.len();
    let edge = band(&column);
    // The floor: the upper part, without lines.
    let above = &left[edge..];
    let floor = trimmed_mean(above);
    if floor <= 0.0 {
        return if left[..edge].iter().any(|p| *p > 0.0) { f64::INFINITY } else { 0.0 };
    }
    let inside = left[1..edge].iter().sum::<f64>() / (edge - 1) as f64;
    // Neighbouring bins of a Hann window are correlated: 1.94 bins count as one.
    let wide = (inside / floor - 1.0) * ((edge - 1) as f64 / 1.94).sqrt();
    // Where lines or slow drifts hold it all, a narrow band sees them better.
    let narrow_edge = (bins / 50).clamp(16, edge.max(17) - 1);
    let narrow = left[1..narrow_edge].iter().sum::<f64>() / (narrow_edge - 1) as f64;
    let narrow = (narrow / floor - 1.0) * ((narrow_edge - 1) as f64 / 1.94).sqrt();
    // The mean, which the periodogram leaves out: white noise of this floor has one of sqrt(floor / energy of the window / n).
    let mean = residual.iter().sum::<f64>() / n as f64;
    let variance = floor / (n as f64 * 0.375);
    let level = mean.abs() / (variance / n as f64).sqrt();
    wide.max(narrow).max(level)
}

/// The bin where the motion's band ends: from there up its power is that of the noise. Between a twentieth and a half of the axis.
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

/// Mean of exponentially distributed powers from the lower nine tenths.
fn trimmed_mean(power: &[f64]) -> f64 {
    let mut sorted = power.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let kept = (sorted.len() * 9 / 10).max(1).min(sorted.len());
    // The lower 90 % of an exponential of mean 1 have the mean 1 - 0.1 ln(10)/0.9.
    let share = 1.0 - 0.1 * 10f64.ln() / 0.9;
    sorted[..kept].iter().sum::<f64>() / kept.max(1) as f64 / share
}

/// Power at the frequencies k/n, k = 0 .. n/2, Hann window, mean removed.
fn periodogram(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let mean = values.iter().sum::<f64>() / n as f64;
    let mut windowed: Vec<f64> = values
        .iter()
        .enumerate()
        .map(|(i, v)| (v - mean) * (std::f64::consts::PI * (i as f64 + 0.5) / n as f64).sin().powi(2))
        .collect();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut spectrum = transform.make_output_vec();
    // The buffers come from the plan, so the transform cannot fail.
    let _ = transform.process(&mut windowed, &mut spectrum);
    spectrum.iter().map(|z| z.norm_sqr()).collect()
}

/// The mean step of a time grid of two samples or more.
pub(crate) fn mean_step(time: &[f64]) -> f64 {
    (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64
}

/// The strongest frequencies (rad/s) of a uniformly sampled signal, refined between bins, strongest first. The power of its noise is taken
/// to rise with this power of the frequency: 4 for the second derivative of white noise.
pub(crate) fn lines(values: &[f64], step: f64, count: usize, rise: i32) -> Vec<f64> {
    let n = values.len();
    if n < 16 {
        return vec![];
    }
    let power: Vec<f64> =
        periodogram(values).iter().enumerate().map(|(k, p)| p / (k.max(1) as f64).powi(rise)).collect();
    let mut peaks: Vec<usize> =
        (1..power.len() - 1).filter(|&k| power[k] > power[k - 1] && power[k] >= power[k + 1]).collect();
    peaks.sort_unstable_by(|&a, &b| power[b].total_cmp(&power[a]));
    let mut chosen: Vec<f64> = Vec::new();
    for k in peaks {
        // A parabola through the logarithms.
        let [a, b, c] = [power[k - 1], power[k], power[k + 1]].map(|p| p.max(f64::MIN_POSITIVE).ln());
        let bend = a - 2.0 * b + c;
        let at = k as f64 + if bend < 0.0 { 0.5 * (a - c) / bend } else { 0.0 };
        let omega = 2.0 * std::f64::consts::PI * at / (n as f64 * step);
        if chosen.iter().all(|w| (w - omega).abs() * n as f64 * step > 2.0 * std::f64::consts::PI * 2.5) {
            chosen.push(omega);
        }
        if chosen.len() == count {
            break;
        }
    }
    chosen
}

/// The part of the variance of values that oscillates at so many radians per sample.
pub(crate) fn share(values: &[f64], turn: f64) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let (mut re, mut im, mut power) = (0.0, 0.0, 0.0);
    for (i, value) in values.iter().enumerate() {
        let (sin, cos) = (turn * i as f64).sin_cos();
        re += (value - mean) * cos;
        im += (value - mean) * sin;
        power += (value - mean).powi(2);
    }
    if power > 0.0 { 2.0 * (re * re + im * im) / (n * power) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(n: usize) -> Vec<f64> {
        let mut state = 1u64;
        (0..n)
            .map(|_| {
                let mut sum = 0.0;
                for _ in 0..12 {
                    state =
                        state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    sum += (state >> 11) as f64 / (1u64 << 53) as f64;
                }
                sum - 6.0
            })
            .collect()
    }

    #[test]
    fn noise_is_white_and_a_faint_line_is_not() {
        let n = 4000;
        let motion: Vec<f64> = (0..n).map(|i| 30.0 * (0.05 * i as f64).sin()).collect();
        let mut left = noise(n);
        let column: Vec<f64> = motion.iter().zip(&left).map(|(a, b)| a + b).collect();
        assert!(score(&left, &column).abs() < 4.0, "{}", score(&left, &column));
        // A line of a third of the noise: gap 1.05.
        left.iter_mut().zip(&motion).for_each(|(l, m)| *l += m / 30.0 * 0.45);
        assert!(score(&left, &column) > COLOURED, "{}", score(&left, &column));
    }

    #[test]
    fn a_line_is_found_between_bins() {
        let x: Vec<f64> = (0..2000).map(|i| (0.1234 * f64::from(i)).cos()).collect();
        let found = lines(&x, 0.1, 1, 0);
        assert!((found[0] - 1.234).abs() < 2e-3, "{found:?}");
    }

    /// Too short to tell, nothing at all, or a line without any noise round it.
    #[test]
    fn the_ends_of_the_score() {
        let motion: Vec<f64> =
            (0..1024).map(|i| (std::f64::consts::TAU * f64::from(i) / 64.0).cos()).collect();
        assert_eq!(score(&noise(63), &motion[..63]), 0.0);
        assert_eq!(score(&noise(64), &motion[..65]), 0.0);
        assert_eq!(score(&[0.0; 1024], &motion), 0.0);
        assert!(lines(&motion[..15], 0.1, 1, 0).is_empty());
    }

    #[test]
    fn a_tone_holds_its_part_of_the_power() {
        let tones: Vec<f64> = (0..5000)
            .map(|i| 3.0 + (0.07 * f64::from(i)).sin() + 0.5 * (0.31 * f64::from(i) + 1.0).cos())
            .collect();
        for (turn, due) in [(0.07, 0.8), (0.31, 0.2), (0.2, 0.0)] {
            let found = share(&tones, turn);
            assert!((found - due).abs() < 0.01, "{turn}: {found}");
        }
    }
}
