//! How a column was smoothed for its derivative, as numbers and in words.

use std::fmt;

/// How [`differentiate`](super::differentiate) smoothed a column. `noise` is the standard deviation of the
/// noise that it assumed, in the column's unit.
#[derive(Clone, Debug, PartialEq)]
pub enum Smoothing {
    /// Local cubics in windows of so many samples.
    LocalCubics {
        /// Samples in the narrowest window.
        least: usize,
        /// Samples in the median window.
        median: usize,
        /// Samples in the widest window.
        most: usize,
        /// Noise.
        noise: f64,
    },
    /// A Fourier series that ends at a frequency.
    FourierSeries {
        /// The last frequency, in periods per unit of time.
        cutoff: f64,
        /// Noise.
        noise: f64,
        /// Whether the column was resampled to a uniform grid.
        resampled: bool,
    },
    /// A smoothing spline.
    Spline {
        /// Length of its equivalent kernel in samples.
        length: f64,
        /// Noise.
        noise: f64,
    },
}

impl fmt::Display for Smoothing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Smoothing::LocalCubics { least, median, most, noise } => {
                write!(f, "local cubics over {least} to {most} samples (median {median}), noise {noise:.3e}")
            }
            Smoothing::FourierSeries { cutoff, noise, resampled } => {
                write!(f, "Fourier series up to {cutoff:.4} per unit of time, noise {noise:.3e}")?;
                f.write_str(if *resampled { ", resampled" } else { "" })
            }
            Smoothing::Spline { length, noise } => {
                write!(f, "smoothing spline, length {length:.4} samples, noise {noise:.3e}")
            }
        }
    }
}
