//! A motion from which start values are estimated.

use phisindy_signal::{noise_level, standard_deviation};

/// A motion and its inputs, in SI.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// Seconds, strictly increasing.
    pub time: Vec<f64>,
    /// Displacement or angle; the integral where only the velocity is measured.
    pub displacement: Vec<f64>,
    /// What an accelerometer reads, if the motion is known from that alone.
    pub acceleration: Option<Vec<f64>>,
    /// Motion of the base.
    pub base: Option<Vec<f64>>,
    /// Force or drive.
    pub force: Option<Vec<f64>>,
    /// Whether the angle is large: gravity takes the place of a linear spring.
    pub is_pendulum: bool,
    /// Strongest frequency, in Hz.
    pub frequency: Option<f64>,
}

/// A part of a motion that dies out is smaller than the one before it, but for this share: less is rounding, noise, or a
/// part that a beat makes larger.
const STEADY: f64 = 0.05;
/// Parts of a record that are compared.
const PARTS: usize = 4;

impl Motion {
    /// Whether each part of the motion is smaller than the one before it, as friction and damping have it: a motion
    /// that goes on is driven. What is too short to tell counts as one that does.
    pub(crate) fn dies_out(&self) -> bool {
        let values = self.acceleration.as_ref().unwrap_or(&self.displacement);
        let length = values.len() / PARTS;
        if length < 2 {
            return true;
        }
        let sizes: Vec<f64> = values.chunks_exact(length).take(PARTS).map(standard_deviation).collect();
        let noise = noise_level(values);
        sizes.windows(2).all(|w| w[1] < (1.0 - STEADY) * w[0] || w[1] < 3.0 * noise)
    }
}
