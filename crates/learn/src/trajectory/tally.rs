//! Residuals in units of their noise: how many there are, how many of them are independent, and their power.

use crate::decisions::INFLATED;
use crate::trajectory::problem::{ColumnResidual, Noise};
use phisindy_signal::effective_samples;

/// Counts and power of residuals in units of their noise.
pub(crate) struct Tally {
    pub(crate) samples: usize,
    /// How many of them are independent.
    pub(crate) effective: f64,
    /// Sum of their squares.
    pub(crate) power: f64,
}

pub(crate) fn tally(noise: &Noise, residuals: &[Vec<ColumnResidual>]) -> Tally {
    counted(whitened(noise, residuals))
}

/// As [`tally`], of residuals with the weights `1/variance`, by record, column and sample.
pub(crate) fn weighed(weights: &[Vec<Vec<f64>>], residuals: &[Vec<ColumnResidual>]) -> Tally {
    counted(whitened_by(weights, residuals))
}

fn counted(columns: impl Iterator<Item = Vec<f64>>) -> Tally {
    let mut tally = Tally { samples: 0, effective: 0.0, power: 0.0 };
    for white in columns {
        tally.samples += white.len();
        tally.effective += effective_samples(&white);
        tally.power += white.iter().map(|e| e * e).sum::<f64>();
    }
    tally
}

/// The residuals of each measured column in units of its noise.
pub(crate) fn whitened(noise: &Noise, residuals: &[Vec<ColumnResidual>]) -> impl Iterator<Item = Vec<f64>> {
    residuals.iter().zip(noise).flat_map(|(columns, noise)| columns.iter().zip(noise)).filter_map(
        |(c, noise)| {
            let scaled = |(e, p): (&f64, &f64)| e / noise.variance(*p).sqrt();
            (!c.residual.is_empty()).then(|| c.residual.iter().zip(&c.prediction).map(scaled).collect())
        },
    )
}

/// As [`whitened`], by the weights of the samples.
pub(crate) fn whitened_by(
    weights: &[Vec<Vec<f64>>],
    residuals: &[Vec<ColumnResidual>],
) -> impl Iterator<Item = Vec<f64>> {
    residuals.iter().zip(weights).flat_map(|(columns, weights)| columns.iter().zip(weights)).filter_map(
        |(c, weights)| {
            let scaled = |(e, w): (&f64, &f64)| e * w.sqrt();
            let own = weights.iter().filter(|w| **w > 0.0);
            (!c.residual.is_empty()).then(|| c.residual.iter().zip(own).map(scaled).collect())
        },
    )
}

/// Factor on the variance of an estimate from correlated samples.
pub(crate) fn inflation(samples: usize, effective: f64) -> f64 {
    let f = samples as f64 / effective.max(1.0);
    // The estimate itself scatters round 1.
    if f < INFLATED { 1.0 } else { f }
}
