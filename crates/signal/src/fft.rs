//! The discrete Fourier transform of real columns: the one place where transforms are planned.

use realfft::num_complex::Complex;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use std::sync::Arc;

/// The transform of `n` real numbers: frequencies k/n for k = 0 .. n/2, not scaled.
pub(crate) struct Forward(Arc<dyn RealToComplex<f64>>);

impl Forward {
    pub(crate) fn new(n: usize) -> Forward {
        Forward(RealFftPlanner::new().plan_fft_forward(n))
    }

    /// Uses `values` as working memory. They must be as many as planned for.
    pub(crate) fn of(&self, values: &mut [f64]) -> Vec<Complex<f64>> {
        let mut spectrum = self.0.make_output_vec();
        // It fails for wrong lengths alone.
        let _ = self.0.process(values, &mut spectrum);
        spectrum
    }
}

/// The inverse of [`Forward`], times `n`.
pub(crate) struct Inverse(Arc<dyn ComplexToReal<f64>>);

impl Inverse {
    pub(crate) fn new(n: usize) -> Inverse {
        Inverse(RealFftPlanner::new().plan_fft_inverse(n))
    }

    /// Uses `spectrum` as working memory. Its first number is real, and for an even `n` its last one.
    pub(crate) fn of(&self, spectrum: &mut [Complex<f64>]) -> Vec<f64> {
        let mut values = self.0.make_output_vec();
        // It fails for wrong lengths, and for ends that are not real.
        let _ = self.0.process(spectrum, &mut values);
        values
    }
}

/// Squared amplitudes at the frequencies k/n, k = 0 .. n/2. Uses `values` as working memory.
pub(crate) fn power(values: &mut [f64]) -> Vec<f64> {
    Forward::new(values.len()).of(values).iter().map(|z| z.norm_sqr()).collect()
}

/// The Hann window of `n` samples at sample `i`.
pub(crate) fn hann(i: usize, n: usize) -> f64 {
    (std::f64::consts::PI * (i as f64 + 0.5) / n as f64).sin().powi(2)
}

/// Squared amplitudes at the frequencies k/n, k = 0 .. n/2, after the mean is removed and a Hann window
/// applied.
pub(crate) fn periodogram(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let mean = values.iter().sum::<f64>() / n as f64;
    let mut windowed: Vec<f64> = values.iter().enumerate().map(|(i, v)| (v - mean) * hann(i, n)).collect();
    power(&mut windowed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cosine_is_one_line_and_comes_back() {
        let n = 60;
        let cosine: Vec<f64> =
            (0..n).map(|i| (std::f64::consts::TAU * 7.0 * i as f64 / n as f64).cos()).collect();
        let mut spectrum = Forward::new(n).of(&mut cosine.clone());
        for (k, z) in spectrum.iter().enumerate() {
            let due = if k == 7 { n as f64 / 2.0 } else { 0.0 };
            assert!((z.re - due).abs() < 1e-12 && z.im.abs() < 1e-12, "{k}: {z}");
        }
        (spectrum[0].im, spectrum[n / 2].im) = (0.0, 0.0);
        let back = Inverse::new(n).of(&mut spectrum);
        assert!(back.iter().zip(&cosine).all(|(a, b)| (a / n as f64 - b).abs() < 1e-14));
    }
}
