//! Errors of the workflow.

use crate::model::ModelError;

/// Why the workflow has no result.
#[derive(Clone, Debug, PartialEq)]
pub enum GapError {
    /// The records are unsuitable.
    Data(DataError),
    /// The initial model cannot be simulated, or the fit of the final one fails.
    Numerics(ModelError),
}

impl GapError {
    /// Whether a state of the model grew without bound.
    pub fn diverged(&self) -> bool {
        matches!(self, GapError::Numerics(ModelError::Fit(error)) if error.diverged())
    }
}

/// Why records are unsuitable.
#[derive(Clone, Debug, PartialEq)]
pub enum DataError {
    /// No record has the role Fit.
    NoFit,
    /// A record is too short.
    FewSamples {
        /// Its name.
        record: String,
        /// How many samples it has.
        samples: usize,
        /// How many are needed.
        least: usize,
    },
    /// A column from which nothing can be learned.
    DeadColumn(phisindy_learn::DataError),
    /// All columns are mostly noise.
    MostlyNoise {
        /// Name of the record.
        record: String,
        /// The smallest part of a column's standard deviation that is noise.
        share: f64,
    },
    /// The text of the spec cannot be read.
    Spec(String),
}
