//! A motion from which start values are estimated.

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
