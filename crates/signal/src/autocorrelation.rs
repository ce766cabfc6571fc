//! The autocorrelation of a residual and its effective number of samples.

use crate::fft::{Forward, Inverse};
use crate::statistics::largest;

/// The effective number of independent samples of a residual: n / (1 + 2 * sum of its autocorrelations),
/// within [1, n].
///
/// The sum runs over the initial positive sequence of pairs (C. J. Geyer, Practical Markov chain Monte Carlo,
/// 1992). The mean is removed first. White residuals give about n, constant ones n. Numbers that are not
/// finite give NaN.
///
/// ```
/// let alternating_slowly: Vec<f64> = (0..1000).map(|i| (0.01 * f64::from(i)).sin()).collect();
/// assert!(phisindy_signal::effective_samples(&alternating_slowly) < 20.0);
/// ```
pub fn effective_samples(residual: &[f64]) -> f64 {
    let n = residual.len();
    if residual.iter().any(|r| !r.is_finite()) {
        return f64::NAN;
    }
    let correlation = autocorrelation(residual);
    if n < 4 || correlation.is_empty() {
        return n as f64;
    }
    let mut pairs = 0.0;
    for pair in correlation.chunks_exact(2) {
        let sum = pair[0] + pair[1];
        if sum <= 0.0 {
            break;
        }
        pairs += sum;
    }
    // The pairs count lag 0 once; 1 + 2 * (lags > 0) counts it as one.
    let inflation = 2.0 * pairs - 1.0;
    if inflation <= 1.0 { n as f64 } else { (n as f64 / inflation).max(1.0) }
}

/// Autocorrelations at lags 0 .. n-1 (mean removed, divided by n, so that the sequence is positive definite);
/// empty if the values do not vary.
///
/// ```
/// let alternating = phisindy_signal::autocorrelation(&[1.0, -1.0, 1.0, -1.0]);
/// assert_eq!(alternating[..2], [1.0, -0.75]);
/// ```
pub fn autocorrelation(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    if n == 0 {
        return Vec::new();
    }
    let mean = values.iter().sum::<f64>() / n as f64;
    // Zero padding keeps the circular correlation from wrapping round.
    let padded = (2 * n).next_power_of_two();
    let mut buffer: Vec<f64> = values.iter().map(|v| v - mean).collect();
    buffer.resize(padded, 0.0);
    let mut spectrum = Forward::new(padded).of(&mut buffer);
    for z in &mut spectrum {
        *z = (z.norm_sqr()).into();
    }
    let mut buffer = Inverse::new(padded).of(&mut spectrum);
    let variance = buffer[0];
    let scale = largest(values);
    if variance / padded as f64 <= n as f64 * (1e-15 * scale).powi(2) {
        return Vec::new();
    }
    buffer.truncate(n);
    buffer.iter().map(|c| c / variance).collect()
}
