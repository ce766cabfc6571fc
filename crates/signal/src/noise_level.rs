//! The noise level of a column, without a model of the motion.

pub(crate) mod quantum;
#[cfg(test)]
mod tests;

use crate::fft::Forward;
use crate::interpolate::{Interpolation, Signal};
use crate::piecewise_constant::holds_levels;
use crate::statistics::median;
use crate::trend::without_line;

/// With fewer samples the spectrum has too few bins above the motion.
const MIN_SPECTRUM_SAMPLES: usize = 192;
/// A third difference beyond so many standard deviations is no noise: one in two million of normal noise is.
const STANDS_OUT: f64 = 5.0;
/// Steps are few: each shows in three or four differences.
const STEPS_AT_MOST: f64 = 0.05;
/// Steps over which a column is interpolated (told in words at `noise_level_at`).
const GAP: f64 = 8.0;
/// Where a larger part is filled the top of the spectrum is no longer that of the noise: the column stays as
/// it is, and the level is too large rather than too small.
const MOST_FILLED: f64 = 0.1;
/// Times that are farther off a grid, in steps, are not those of a sampler that lost some rows.
const OFF_GRID: f64 = 0.1;
/// The upper part of the frequency axis that must be flat to count as noise.
const MIN_FLAT_PART: f64 = 0.2;

/// Standard deviation of the white noise added to a smooth, uniformly sampled signal, in the signal's unit.
///
/// The noise is the flat upper part of the spectrum (Hann window, straight line removed), where the motion is
/// below it. Its level is a mean without spectral lines. For short records, and where the spectrum has no
/// flat part or shows leakage alone (data without noise), the smallest median of third and higher differences
/// is used, as it is where the column steps now and then: a force that follows the direction of a sliding
/// contact. The error is 1.5 % for 5000 samples; smooth data without noise give less than 1e-6 of the signal.
/// Quantisation counts as noise of step/sqrt(12), also at rest. A column that holds levels, such as a relay,
/// has no noise: its jumps are no scatter from sample to sample.
///
/// Fewer than 6 samples give 0, numbers that are not finite give NaN.
///
/// ```
/// // A harmonic motion with a deterministic disturbance of +-0.01 whose sign has no period.
/// let pattern = |i: u32| if i.wrapping_mul(2_654_435_769).count_ones() % 2 == 0 { 0.01 } else { -0.01 };
/// let column: Vec<f64> = (0..2000).map(|i| (0.02 * f64::from(i)).sin() + pattern(i)).collect();
/// let level = phisindy_signal::noise_level(&column);
/// assert!((level - 0.01).abs() < 0.003);
/// ```
pub fn noise_level(values: &[f64]) -> f64 {
    let n = values.len();
    if values.iter().any(|v| !v.is_finite()) {
        return f64::NAN;
    }
    if n < 6 || holds_levels(values) {
        return 0.0;
    }
    let rounding = quantum::rounding_error(values);
    let differences = level_of_differences(values);
    if n < MIN_SPECTRUM_SAMPLES {
        return differences.max(rounding);
    }
    // A median difference of zero means quantised data mostly at rest, which do not tell the noise in motion.
    let differences = if differences > 0.0 { differences } else { f64::INFINITY };
    let level = match flat_level(&periodograms(values)) {
        // Otherwise the spectrum has far more than the differences: leakage of motion without noise, or a few
        // steps in it.
        Floor::Flat(power) if differences > 0.1 * power.sqrt() && !has_steps(values, differences) => {
            power.sqrt()
        }
        Floor::Flat(power) | Floor::Falling(power) => power.sqrt().min(differences),
    };
    level.max(rounding)
}

/// The same at times of which some may be missing: rows that a logger has lost.
///
/// A column without gaps, or with times on no grid, is as [`noise_level`] takes it. A gap of up to eight
/// steps is filled by cubic interpolation, which holds the motion and none of the noise above it: the level
/// is raised for that part of the samples. Longer gaps divide the column, and its longest piece counts. Where
/// more than a tenth would be filled, the column stays as it is.
///
/// ```
/// let pattern = |i: u32| if i.wrapping_mul(2_654_435_769).count_ones() % 2 == 0 { 0.01 } else { -0.01 };
/// let rows = (0..2000).filter(|i| i % 17 != 3);
/// let time: Vec<f64> = rows.clone().map(|i| 0.02 * f64::from(i)).collect();
/// let column: Vec<f64> = rows.map(|i| (0.02 * f64::from(i)).sin() + pattern(i)).collect();
/// let level = phisindy_signal::noise_level_at(&time, &column);
/// assert!((level - 0.01).abs() < 0.003);
/// ```
pub fn noise_level_at(time: &[f64], values: &[f64]) -> f64 {
    match filled(time, values) {
        Some((column, measured)) => noise_level(&column) * (column.len() as f64 / measured as f64).sqrt(),
        None => noise_level(values),
    }
}

/// The longest piece of a column, its gaps filled, and how many of its samples are measured; none without
/// gaps.
fn filled(time: &[f64], values: &[f64]) -> Option<(Vec<f64>, usize)> {
    let mut steps: Vec<f64> = time.windows(2).map(|t| t[1] - t[0]).collect();
    if steps.is_empty() || values.len() != time.len() || values.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let step = median(&mut steps);
    let across = |k: usize| ((time[k] - time[k - 1]) / step).round();
    let on_the_grid =
        |k: usize| across(k) > GAP || ((time[k] - time[k - 1]) / step - across(k)).abs() < OFF_GRID;
    if !(1..time.len()).any(|k| across(k) > 1.0) || !(1..time.len()).all(on_the_grid) {
        return None;
    }
    let signal = Signal::new(time.into(), values.to_vec(), Interpolation::Cubic).ok()?;
    let (mut best, mut piece) = ((vec![], 0), (vec![values[0]], 1));
    for k in 1..time.len() {
        let wide = across(k);
        if wide > GAP {
            let done = std::mem::replace(&mut piece, (vec![values[k]], 1));
            best = if done.1 > best.1 { done } else { best };
            continue;
        }
        let inside =
            (1..wide.max(1.0) as usize).map(|j| time[k - 1] + (time[k] - time[k - 1]) * j as f64 / wide);
        piece.0.extend(inside.map(|t| signal.value(t)).chain([values[k]]));
        piece.1 += 1;
    }
    let best = if piece.1 > best.1 { piece } else { best };
    (best.1 as f64 >= (1.0 - MOST_FILLED) * best.0.len() as f64).then_some(best)
}

/// Whether a few samples stand out of noise of this level: the column steps. A step of `J` at every `m`-th
/// sample adds about `J^2/(4 m)` to the upper end of the spectrum.
fn has_steps(values: &[f64], level: f64) -> bool {
    let third = values.windows(4).map(|w| w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]);
    let far = STANDS_OUT * 20f64.sqrt() * level;
    let steps = third.filter(|d| d.abs() > far).count();
    steps > 0 && (steps as f64) < STEPS_AT_MOST * values.len() as f64
}

/// The shape of the upper end of a spectrum, with its power.
#[derive(Debug)]
enum Floor {
    Flat(f64),
    Falling(f64),
}

/// The level of the flat upper end of `power`.
fn flat_level(power: &[f64]) -> Floor {
    let blocks = (power.len() / 48).clamp(8, 64);
    let block = power.len() / blocks;
    let top = |count: usize| &power[power.len() - count * block..];
    let levels: Vec<f64> = power.rchunks(block).take(blocks).map(median_level).collect();
    // A median over m exponential powers scatters by 1.44/sqrt(m), and 1.4 times more because neighbouring
    // bins are correlated.
    let scatter = |bins: usize| 2.0 / (bins as f64).sqrt();
    // The first comparison is with half of the part that must be flat: enough for a level.
    let mut flat = ((MIN_FLAT_PART / 2.0) * blocks as f64).ceil() as usize;
    while flat < blocks {
        // 3 standard deviations, since dozens of blocks are tested. Motion rises steeply and keeps rising, so
        // a single block that stands out does so by chance.
        let allowed = 3.0 * (scatter(block).powi(2) + scatter(flat * block).powi(2)).sqrt();
        let level = median_level(top(flat));
        let off = |k: usize| levels.get(k).is_none_or(|l| (l / level).ln().abs() > allowed);
        if off(flat) && off(flat + 1) {
            break;
        }
        flat += 1;
    }
    // The last block may already contain some motion.
    let used = if flat < blocks { (flat - 1).max(1) } else { flat };
    let level = clipped_mean(top(used));
    if flat as f64 >= MIN_FLAT_PART * blocks as f64 { Floor::Flat(level) } else { Floor::Falling(level) }
}

/// Mean of exponentially distributed powers, from their median.
fn median_level(power: &[f64]) -> f64 {
    median(&mut power.to_vec()) / std::f64::consts::LN_2
}

/// Mean of exponentially distributed powers with lines among them: powers above four times the level are left
/// out, and the bias of that is corrected. Its variance is half of that of the median.
fn clipped_mean(power: &[f64]) -> f64 {
    let start = median_level(power);
    let clip = 4.0 * start;
    let (sum, count) = power.iter().filter(|p| **p < clip).fold((0.0, 0.0), |(s, c), p| (s + p, c + 1.0));
    if count == 0.0 || start == 0.0 {
        return start;
    }
    // The mean of an exponential of mean m, truncated at c, is m - c/(exp(c/m) - 1).
    (0..20).fold(start, |mean, _| sum / count + clip / (clip / mean).exp_m1())
}

/// Power at the frequencies k/n, k = 3 .. n/2 - 1, from the lowest up, scaled so that white noise has its
/// variance at each; two independent numbers for each frequency.
///
/// The second taper, sin(pi t) sin(2 pi t), is orthogonal to the Hann window sin(pi t)^2, has as little
/// leakage, and weights the parts of the record that the first one attenuates. With both the level scatters
/// as little as without a window.
fn periodograms(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let level = without_line(values);
    let transform = Forward::new(n);
    let tapered = |order: f64| {
        let mut energy = 0.0;
        let mut windowed: Vec<f64> = level
            .iter()
            .enumerate()
            .map(|(i, v)| {
                let angle = std::f64::consts::PI * (i as f64 + 0.5) / n as f64;
                let taper = angle.sin() * (order * angle).sin();
                energy += taper * taper;
                taper * v
            })
            .collect();
        (transform.of(&mut windowed), energy)
    };
    let ((first, first_energy), (second, second_energy)) = (tapered(1.0), tapered(2.0));
    let bins = 3..n / 2;
    bins.flat_map(|k| [first[k].norm_sqr() / first_energy, second[k].norm_sqr() / second_energy]).collect()
}

/// Level from the median absolute difference of order 3, or of a higher order as long as that is clearly
/// smaller.
fn level_of_differences(values: &[f64]) -> f64 {
    // Median of |normal|.
    const HALF_NORMAL: f64 = 0.674_489_750_196_081_7;
    let mut differences = values.to_vec();
    // Sum of squared binomials, C(2k, k): the variance of a k-th difference of unit noise.
    let mut gain = 1.0;
    let mut level = f64::INFINITY;
    for order in 1..=10_usize {
        if differences.len() < 4 {
            break;
        }
        for i in 0..differences.len() - 1 {
            differences[i] = differences[i + 1] - differences[i];
        }
        differences.pop();
        gain *= 2.0 * (2 * order - 1) as f64 / order as f64;
        if order < 3 {
            continue;
        }
        let mut sizes: Vec<f64> = differences.iter().map(|d| d.abs()).collect();
        let now = median(&mut sizes) / (HALF_NORMAL * f64::sqrt(gain));
        if now > 0.7 * level {
            break;
        }
        level = now;
    }
    if level.is_finite() { level } else { 0.0 }
}
