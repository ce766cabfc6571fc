//! Parameters that moved.

use super::estimate::Estimate;
use super::quantity::ParameterId;

/// A parameter that was allowed to move.
#[derive(Clone, Debug)]
pub struct FoundParameter {
    /// Which; `Display` of it is the label.
    pub id: ParameterId,
    /// As in the spec.
    pub unit: String,
    /// Factor from `unit` to SI.
    pub factor: f64,
    /// Value (SI).
    pub estimate: Estimate,
    /// Bounds (SI).
    pub bounds: (f64, f64),
    /// Whether it ended at one of them.
    pub at_bound: bool,
}
