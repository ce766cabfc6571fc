//! How the step method learns.

use phisindy_phys::spec::{Crossings, Optimiser};

/// How the step method learns; the defaults are the paper's (Table 4).
#[derive(Clone, Debug, PartialEq)]
pub struct StepOptions {
    /// Which optimiser.
    pub optimiser: Optimiser,
    /// Epochs of each stage.
    pub epochs: Vec<u32>,
    /// Learning rate of each stage.
    pub rates: Vec<f64>,
    /// Coefficients smaller than this are cut after each stage.
    pub cutoff: f64,
    /// Speed below which a contact counts as stuck (SI).
    pub tolerance: f64,
    /// Steps that are unrolled.
    pub horizon: usize,
    /// Whether steps across a change of sign are used.
    pub crossings: Crossings,
}

impl Default for StepOptions {
    fn default() -> Self {
        StepOptions {
            optimiser: Optimiser::RAdam,
            epochs: vec![1000, 1000, 1000],
            rates: vec![0.1, 0.01, 0.001],
            cutoff: 0.05,
            tolerance: 1e-3,
            horizon: 1,
            crossings: Crossings::Keep,
        }
    }
}
