//! What is due where probabilities are said.

/// The number of statements that hold with 95 % if each holds with the probability that was said of it: the first and last
/// count that leave at most 2.5 % beyond them. The same probability for all is the binomial distribution.
pub(super) fn band(said: &[f64]) -> (usize, usize) {
    // chance[k]: k of those so far hold (the Poisson binomial distribution).
    let mut chance = vec![1.0];
    for p in said {
        chance.push(0.0);
        for k in (0..chance.len()).rev() {
            let one_less = if k == 0 { 0.0 } else { chance[k - 1] };
            chance[k] = chance[k] * (1.0 - p) + one_less * p;
        }
    }
    let first = |of: &mut dyn Iterator<Item = &f64>| {
        let mut sum = 0.0;
        of.take_while(|p| {
            sum += **p;
            sum <= 0.025
        })
        .count()
    };
    (first(&mut chance.iter()), chance.len() - 1 - first(&mut chance.iter().rev()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables of the binomial distribution: of 20 at one half, 6 to 14; of 100 at 0.95, 90 to 99 (R: `qbinom`).
    #[test]
    fn equal_probabilities_are_the_binomial_distribution() {
        assert_eq!(band(&[0.5; 20]), (6, 14));
        assert_eq!(band(&[0.95; 100]), (90, 99));
        assert_eq!(band(&[1.0; 7]), (7, 7));
        assert_eq!(band(&[]), (0, 0));
    }

    /// Half of them sure, half impossible: there is no spread.
    #[test]
    fn probabilities_are_not_replaced_by_their_mean() {
        let said: Vec<f64> = (0..20).map(|k| f64::from(k % 2)).collect();
        assert_eq!(band(&said), (10, 10));
    }
}
