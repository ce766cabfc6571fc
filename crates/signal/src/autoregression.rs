//! Autoregressive noise of first order, AR(1): each value keeps a part of the last one, `e_i = rho e_(i-1) + n_i` with
//! white `n`.
//!
//! G. E. P. Box and G. M. Jenkins, Time Series Analysis: Forecasting and Control, 1970, ch. 7.

use crate::statistics::lowest_point;

/// The white noise `n` behind values: `sqrt(1 - rho^2) e_1, e_2 - rho e_1, e_3 - rho e_2, ...`
fn innovations(values: &[f64], rho: f64) -> impl Iterator<Item = f64> {
    let first = values.first().map(|e| (1.0 - rho * rho).sqrt() * e);
    first.into_iter().chain(values.windows(2).map(move |e| e[1] - rho * e[0]))
}

/// Evidence (BIC) that values are AR(1) noise rather than white noise of variance one: the rise of twice the log-likelihood,
/// less the price of `rho`. Zero where they are white.
///
/// `-2 ln L = n (1 + ln s^2) - ln(1 - rho^2)`, with the mean square `s^2` of the white noise behind the values.
///
/// ```
/// let mut last = 0.0;
/// let slow: Vec<f64> = (0..300).map(|i| { last = 0.9 * last + f64::from(i * 7919 % 300 - 150) / 300.0; last }).collect();
/// assert!(phisindy_signal::evidence_of_colour(&slow) > 100.0);
/// ```
pub fn evidence_of_colour(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let unlikelihood = |rho: f64| {
        let mean = innovations(values, rho).map(|e| e * e).sum::<f64>() / n;
        n * (1.0 + mean.ln()) - (1.0 - rho * rho).ln()
    };
    let rho = lowest_point(0.0, 1.0 - 1.0 / n, 1e-3, unlikelihood);
    let worth = values.iter().map(|e| e * e).sum::<f64>() - unlikelihood(rho) - n.ln();
    // Nothing is foretold of one value, nor by zeros.
    if worth.is_finite() { worth.max(0.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_signals::gaussian;

    /// Of 400 values of `rho = 0.8` the worth is `-400 ln(1 - 0.64)`, but for chance and the price.
    #[test]
    fn a_colour_is_worth_what_it_foretells() {
        let white = gaussian(400, 3);
        assert_eq!(evidence_of_colour(&white), 0.0);
        let mut last = 0.0;
        let coloured: Vec<f64> = white
            .iter()
            .map(|n| {
                last = 0.8 * last + 0.6 * n;
                last
            })
            .collect();
        let due = -400.0 * 0.36f64.ln() - 400f64.ln();
        assert!(
            (evidence_of_colour(&coloured) / due - 1.0).abs() < 0.2,
            "{} {due}",
            evidence_of_colour(&coloured)
        );
        let back: Vec<f64> = innovations(&coloured, 0.8).skip(1).map(|n| n / 0.6).collect();
        assert!(back.iter().zip(&white[1..]).all(|(a, b)| (a - b).abs() < 1e-12));
        assert_eq!(
            [evidence_of_colour(&[1.0]), evidence_of_colour(&[0.0; 9]), evidence_of_colour(&[])],
            [0.0; 3]
        );
    }
}
