//! Parameters that moved.

use super::estimate::Estimate;
use super::quantity::ParameterId;
use phisindy_phys::System;

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

impl FoundParameter {
    /// Whether its interval is all that the spec or its law allows: the data do not determine it.
    pub fn reaches_both_bounds(&self) -> bool {
        self.estimate.ci95.0 <= self.bounds.0 && self.estimate.ci95.1 >= self.bounds.1
    }
}

/// The values (SI) of [`System::parameters`] in a record, as far as they were found; the others as the spec
/// starts them.
pub fn parameter_values(parameters: &[FoundParameter], system: &System, record: usize) -> Vec<f64> {
    let mut values: Vec<f64> = system.parameters.iter().map(|p| p.start).collect();
    for p in parameters.iter().filter(|p| p.id.holds_in(record)) {
        if let Some(k) = p.id.constant() {
            values[k] = p.estimate.value;
        }
    }
    values
}
