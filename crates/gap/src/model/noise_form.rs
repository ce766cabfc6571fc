//! Noise that grows with the signal. Its level is no number of the column: a spectrum over the whole record
//! tells that of the middle, a median that of most samples, and where a motion dies away both are far below
//! what the first seconds have. The gap needs the root mean square along the record.
//!
//! Differences of an odd, high order hold hardly any motion, and what they hold of an oscillation is out of
//! phase with it. Their sizes are compared with the signal: `variance = a^2 + (s x)^2`.

use crate::decisions::{NOISE_FORM, NOISE_GROUPS, NOISE_ORDER};
use phisindy_signal::median;

/// Median of the square of a normal number.
const MEDIAN_SQUARE: f64 = 0.454_936_423_119_572_8;

/// Noise that grows with the signal: the variances of both parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GrowingNoise {
    additive: f64,
    relative: f64,
}

impl GrowingNoise {
    /// Of noise in `values` that grows with `signal`; `None` where one number describes its level, or the two
    /// do not.
    pub(crate) fn of(values: &[f64], signal: &[f64]) -> Option<GrowingNoise> {
        let weights = weights();
        let reach = weights.len();
        if values.len() != signal.len() || values.len() < reach {
            return None;
        }
        let gain: f64 = weights.iter().map(|w| w * w).sum();
        // For each difference its square, and the mean square of the signal that its noise would come from.
        let of = |from: usize| {
            let difference: f64 = weights.iter().zip(&values[from..]).map(|(w, v)| w * v).sum();
            let size: f64 = weights.iter().zip(&signal[from..]).map(|(w, x)| w * w * x * x).sum();
            (size / gain, difference * difference / gain)
        };
        // Where a column rests at zero such noise says nothing.
        let mut all: Vec<(f64, f64)> =
            (0..=values.len() - reach).map(of).filter(|(size, _)| *size > 0.0).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Neighbouring differences share their samples.
        let groups: Vec<(f64, f64)> = grouped(&all, reach * reach)
            .into_iter()
            .map(|group| {
                let middle =
                    |of: fn(&(f64, f64)) -> f64| median(&mut group.iter().map(of).collect::<Vec<_>>());
                (middle(|g| g.0), middle(|g| g.1) / MEDIAN_SQUARE)
            })
            .collect();
        if groups.len() < 3 {
            return None;
        }
        let (additive, relative) = form(&groups)?;
        let most = NOISE_FORM * NOISE_FORM;
        let near = |(size, variance): &(f64, f64)| {
            let ratio = variance / (additive + relative * size);
            (1.0 / most..=most).contains(&ratio)
        };
        let (least, largest) =
            groups.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), g| (a.min(g.1), b.max(g.1)));
        let one_number = largest <= most * most * least;
        // The median of a group in which the signal spans much is not that of its middle: the scale is that
        // of single differences, where the signal is large.
        let upper = all[all.len() / 2..].iter().map(|(size, square)| square / (additive + relative * size));
        let scale = median(&mut upper.collect::<Vec<_>>()) / MEDIAN_SQUARE;
        // Of many small groups a few are off by chance.
        let off = groups.iter().filter(|g| !near(g)).count();
        (!one_number && NOISE_GROUPS * off <= groups.len())
            .then_some(GrowingNoise { additive: scale * additive, relative: scale * relative })
    }

    /// The root mean square along a signal.
    pub(crate) fn root_mean_square(&self, signal: &[f64]) -> f64 {
        let mean = signal.iter().map(|x| x * x).sum::<f64>() / signal.len().max(1) as f64;
        (self.additive + self.relative * mean).sqrt()
    }
}

/// Neighbours in size, at least `least` together: as many as make equal groups, or fewer where the size has
/// grown fourfold. A motion that is short beside the rest after it has groups of its own.
fn grouped(all: &[(f64, f64)], least: usize) -> Vec<&[(f64, f64)]> {
    let most = all.len().div_ceil(NOISE_GROUPS).max(least);
    let (mut groups, mut from) = (Vec::new(), 0);
    while all.len() - from >= 2 * least {
        let grown = all[from..].partition_point(|g| g.0 <= 4.0 * all[from].0);
        let to = from + grown.clamp(least, most);
        if all.len() - to < least {
            break;
        }
        groups.push(&all[from..to]);
        from = to;
    }
    if all.len() > from {
        groups.push(&all[from..]);
    }
    groups
}

/// Both variances, from the level of each group, by least squares relative to the levels; `None` where the
/// noise does not grow.
fn form(groups: &[(f64, f64)]) -> Option<(f64, f64)> {
    if groups.iter().any(|g| g.1 <= 0.0 || !g.1.is_finite() || !g.0.is_finite()) {
        return None;
    }
    let sum = |f: &dyn Fn(f64, f64) -> f64| groups.iter().map(|g| f(1.0 / g.1, g.0 / g.1)).sum::<f64>();
    let (aa, ab, bb) = (sum(&|a, _| a * a), sum(&|a, b| a * b), sum(&|_, b| b * b));
    let (a, b) = (sum(&|a, _| a), sum(&|_, b| b));
    let determinant = aa * bb - ab * ab;
    let (additive, relative) = ((bb * a - ab * b) / determinant, (aa * b - ab * a) / determinant);
    let (additive, relative) = if additive < 0.0 { (0.0, b / bb) } else { (additive, relative) };
    (relative > 0.0 && relative.is_finite()).then_some((additive, relative))
}

/// The weights of the samples in a difference.
fn weights() -> Vec<f64> {
    let mut weights = vec![1.0];
    for _ in 0..NOISE_ORDER {
        weights = (0..=weights.len())
            .map(|i| {
                let before = if i > 0 { weights[i - 1] } else { 0.0 };
                before - weights.get(i).copied().unwrap_or(0.0)
            })
            .collect();
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_sim::{Noise, Streams, add_noise};

    /// A swing that dies away, with this noise.
    fn swing(noise: Noise, seed: u64) -> (Vec<f64>, Vec<f64>) {
        let clean: Vec<f64> =
            (0..3000).map(|i| (-0.002 * f64::from(i)).exp() * (0.03 * f64::from(i)).cos()).collect();
        let mut noisy = clean.clone();
        add_noise(&mut noisy, noise, &mut Streams(seed).stream("x"));
        (clean, noisy)
    }

    #[test]
    fn noise_that_dies_away_with_the_motion_has_its_root_mean_square() {
        for seed in 1..20 {
            let (clean, noisy) = swing(Noise::Relative(0.01), seed);
            let due = (clean.iter().map(|x| (0.01 * x).powi(2)).sum::<f64>() / 3000.0).sqrt();
            let found = GrowingNoise::of(&noisy, &noisy).map_or(0.0, |n| n.root_mean_square(&noisy));
            assert!((found / due - 1.0).abs() < 0.15, "{found}, not {due}");
        }
    }

    /// A body that comes to rest at zero has no such noise there.
    #[test]
    fn noise_that_ends_with_the_motion_is_that_of_the_motion() {
        let (mut clean, mut noisy) = swing(Noise::Relative(0.01), 5);
        clean[600..].fill(0.0);
        noisy[600..].fill(0.0);
        let due = (clean.iter().map(|x| (0.01 * x).powi(2)).sum::<f64>() / 3000.0).sqrt();
        let found = GrowingNoise::of(&noisy, &noisy).map_or(0.0, |n| n.root_mean_square(&noisy));
        assert!((found / due - 1.0).abs() < 0.2, "{found}, not {due}");
    }

    /// One number is one number, with hardly any noise, too.
    #[test]
    fn noise_of_a_sensor_does_not_grow() {
        for noise in [Noise::Additive(0.01), Noise::Sensor(1e-7)] {
            for seed in 1..20 {
                let (_, noisy) = swing(noise, seed);
                assert_eq!(GrowingNoise::of(&noisy, &noisy), None, "{noise:?}");
            }
        }
    }
}
