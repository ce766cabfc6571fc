//! Random draws: the same for a seed on every machine, and named, so that a draw more in one set leaves the
//! others alone.

use phisindy_sim::Streams;

/// A source of draws.
pub(crate) struct Dice {
    streams: Streams,
    count: u64,
}

impl Dice {
    /// For one purpose under a seed.
    pub(crate) fn new(seed: u64, purpose: &str) -> Dice {
        Dice { streams: Streams(Streams(seed).seed(purpose)), count: 0 }
    }

    /// A seed for something else.
    pub(crate) fn seed(&mut self) -> u64 {
        self.count += 1;
        self.streams.seed(&self.count.to_string())
    }

    /// From 0 to 1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.seed() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Even between two numbers.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Even in the logarithm. Four digits: a person would have written such a number.
    pub(crate) fn log(&mut self, low: f64, high: f64) -> f64 {
        rounded(low * (high / low).powf(self.unit()))
    }

    /// A whole number from `low` to `high`, both included.
    pub(crate) fn whole(&mut self, low: usize, high: usize) -> usize {
        low + (self.unit() * (high - low + 1) as f64) as usize
    }

    /// One of several.
    pub(crate) fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.whole(0, of.len() - 1)]
    }

    /// True with this probability.
    pub(crate) fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    /// +1 or -1.
    pub(crate) fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }
}

/// A number with four digits.
pub(crate) fn rounded(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_repeat_and_fill_their_range() {
        let draws = |seed| {
            (0..2000)
                .map({
                    let mut d = Dice::new(seed, "x");
                    move |_| d.unit()
                })
                .collect::<Vec<_>>()
        };
        assert_eq!(draws(1), draws(1));
        assert_ne!(draws(1), draws(2));
        let mean = draws(1).iter().sum::<f64>() / 2000.0;
        // Six standard errors.
        assert!((mean - 0.5).abs() < 6.0 * (1.0 / 12.0f64 / 2000.0).sqrt());
        let mut dice = Dice::new(3, "whole");
        let seen: std::collections::BTreeSet<usize> = (0..200).map(|_| dice.whole(2, 4)).collect();
        assert_eq!(seen.into_iter().collect::<Vec<_>>(), [2, 3, 4]);
    }

    #[test]
    fn rounding_keeps_four_digits() {
        assert_eq!(rounded(0.001_234_56), 0.001_235);
        assert_eq!(rounded(-98_765.4), -98_770.0);
    }
}
