//! Seeded random streams, one for each purpose, and the noise of sensors.

use phisindy_signal::standard_deviation;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

/// Independent random streams drawn from one seed, one per name.
///
/// An additional column, or another order of columns, does not change the noise of the others. The same
/// seed and name give the same numbers on every machine.
///
/// ```
/// use phisindy_sim::Streams;
/// let streams = Streams(42);
/// assert_eq!(streams.stream("noise of x"), Streams(42).stream("noise of x"));
/// assert_ne!(streams.stream("noise of x"), streams.stream("noise of v"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Streams(
    /// The seed all streams come from.
    pub u64,
);

impl Streams {
    /// The stream for `purpose`, from its beginning.
    pub fn stream(&self, purpose: &str) -> Pcg64 {
        let mut state = self.mixed(purpose);
        let mut bytes = [0; 32];
        for word in bytes.chunks_exact_mut(8) {
            word.copy_from_slice(&split_mix(&mut state).to_le_bytes());
        }
        Pcg64::from_seed(bytes)
    }

    /// A seed for `purpose`, for an object with a seed of its own: two random inputs of one seed must
    /// differ.
    pub fn seed(&self, purpose: &str) -> u64 {
        split_mix(&mut self.mixed(purpose))
    }

    /// FNV-1a over the seed and the name. Unlike the standard hasher, it never changes.
    fn mixed(&self, purpose: &str) -> u64 {
        self.0.to_le_bytes().iter().chain(purpose.as_bytes()).fold(0xcbf2_9ce4_8422_2325, |hash, &byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        })
    }
}

/// One step of SplitMix64 (G. L. Steele, D. Lea, C. H. Flood 2014): spreads nearby states over all 64 bits.
fn split_mix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The noise that a sensor adds to a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Noise {
    /// No noise: the column is exact.
    None,
    /// Each sample times `1 + s n` with `n` standard normal (the paper's eq. 34); `s` has no unit.
    Relative(f64),
    /// `s` times the column's standard deviation (taken once, before anything is added); `s` has no unit.
    Additive(f64),
    /// A standard deviation in the column's own unit.
    Sensor(f64),
}

/// Adds white Gaussian noise to a column.
///
/// One normal number is drawn for each sample, whatever the kind (none for [`Noise::None`]), so that
/// another level scales the same noise. A column with NaN or infinity keeps them. Every level is accepted.
///
/// ```
/// use phisindy_sim::{Noise, Streams, add_noise};
/// let mut column = vec![1.0; 4];
/// add_noise(&mut column, Noise::Sensor(1e-3), &mut Streams(1).stream("noise of x"));
/// assert!(column.iter().all(|x| *x != 1.0 && (x - 1.0).abs() < 1e-2));
/// ```
pub fn add_noise(values: &mut [f64], noise: Noise, rng: &mut Pcg64) {
    let sigma = match noise {
        Noise::None => return,
        Noise::Relative(share) => {
            for value in values {
                *value *= 1.0 + share * normal(rng);
            }
            return;
        }
        Noise::Additive(share) => share * standard_deviation(values),
        Noise::Sensor(sigma) => sigma,
    };
    for value in values {
        *value += sigma * normal(rng);
    }
}

fn normal(rng: &mut Pcg64) -> f64 {
    StandardNormal.sample(rng)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draws(stream: &str, count: usize) -> Vec<f64> {
        let mut column = vec![0.0; count];
        add_noise(&mut column, Noise::Sensor(1.0), &mut Streams(7).stream(stream));
        column
    }

    #[test]
    fn moments_are_those_of_a_standard_normal() {
        let n = 200_000;
        let z = draws("a", n);
        let moment = |k: i32| z.iter().map(|v| v.powi(k)).sum::<f64>() / n as f64;
        // Standard errors: 1, sqrt 2, sqrt 15, sqrt 96 over sqrt n.
        let limit = |variance: f64| 4.0 * (variance / n as f64).sqrt();
        assert!(moment(1).abs() < limit(1.0));
        assert!((moment(2) - 1.0).abs() < limit(2.0));
        assert!(moment(3).abs() < limit(15.0));
        assert!((moment(4) - 3.0).abs() < limit(96.0));
        let lag = z.windows(2).map(|p| p[0] * p[1]).sum::<f64>() / n as f64;
        assert!(lag.abs() < limit(1.0));
    }

    #[test]
    fn streams_of_different_names_are_not_correlated() {
        let names = ["x", "y", "x1", "x2", "noise of x", ""];
        for (i, a) in names.iter().enumerate() {
            for b in &names[i + 1..] {
                let product: f64 = draws(a, 20_000).iter().zip(draws(b, 20_000)).map(|(p, q)| p * q).sum();
                assert!(product.abs() / 20_000.0 < 4.5 / 20_000f64.sqrt(), "{a} {b}");
            }
        }
        assert_ne!(Streams(0).seed("F"), Streams(0).seed("u"));
        assert_ne!(Streams(0).seed("F"), Streams(1).seed("F"));
    }

    #[test]
    fn kinds_scale_as_documented() {
        let clean: Vec<f64> = (0..50_000).map(|i| 3.0 + 2.0 * (0.01 * f64::from(i)).sin()).collect();
        let z = draws("k", clean.len());
        let noisy = |noise| {
            let mut column = clean.clone();
            add_noise(&mut column, noise, &mut Streams(7).stream("k"));
            column
        };
        assert_eq!(noisy(Noise::None), clean);
        let cases: [(Noise, &dyn Fn(usize) -> f64); 3] = [
            (Noise::Relative(0.1), &|i| clean[i] * (1.0 + 0.1 * z[i])),
            // The standard deviation of 2 sin is sqrt 2.
            (Noise::Additive(0.02), &|i| clean[i] + 0.02 * 2f64.sqrt() * z[i]),
            (Noise::Sensor(1e-6), &|i| clean[i] + 1e-6 * z[i]),
        ];
        for (noise, expected) in cases {
            for (i, v) in noisy(noise).into_iter().enumerate() {
                let change = (expected(i) - clean[i]).abs();
                assert!((v - expected(i)).abs() <= 2e-3 * change + 1e-15, "{noise:?} {i}");
            }
        }
    }

    #[test]
    fn nothing_and_nonsense_do_not_panic() {
        add_noise(&mut [], Noise::Additive(1.0), &mut Streams(0).stream(""));
        let mut column = [f64::NAN, 1.0];
        add_noise(&mut column, Noise::Additive(f64::INFINITY), &mut Streams(0).stream(""));
        assert!(column[0].is_nan());
    }

    /// A new release must reproduce the data of an old one.
    #[test]
    fn the_first_numbers_are_pinned() {
        let seeds = [Streams(42).seed("x"), Streams(42).seed("v")];
        assert_eq!(seeds, PINNED_SEEDS);
        assert_eq!(draws("x", 2), PINNED_DRAWS);
    }

    const PINNED_SEEDS: [u64; 2] = [11_034_769_607_595_551_400, 18_076_942_479_422_847_121];
    const PINNED_DRAWS: [f64; 2] = [-2.056_769_483_855_189_8, -0.683_939_992_385_456_4];
}
