//! How the step method learns.

use crate::decisions::{CUTOFF, EPOCHS, LEARNING_RATES, STUCK_SPEED};
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
            epochs: EPOCHS.to_vec(),
            rates: LEARNING_RATES.to_vec(),
            cutoff: CUTOFF,
            tolerance: STUCK_SPEED,
            horizon: 1,
            crossings: Crossings::Keep,
        }
    }
}
