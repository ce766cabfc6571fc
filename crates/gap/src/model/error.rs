//! Why a model cannot be built or fitted.

use super::spec_text::SpecTextError;
use crate::place::EffectError;

/// Why a model cannot be built or fitted.
#[derive(Clone, Debug, PartialEq)]
pub enum ModelError {
    /// It cannot be fitted.
    Fit(phisindy_learn::ModelError),
    /// An effect cannot act on it.
    Effect(EffectError),
    /// The text of the spec cannot hold it.
    Text(SpecTextError),
    /// The changed spec is invalid.
    Spec,
}

impl From<phisindy_learn::ModelError> for ModelError {
    fn from(why: phisindy_learn::ModelError) -> Self {
        ModelError::Fit(why)
    }
}

impl From<EffectError> for ModelError {
    fn from(why: EffectError) -> Self {
        ModelError::Effect(why)
    }
}

impl From<SpecTextError> for ModelError {
    fn from(why: SpecTextError) -> Self {
        ModelError::Text(why)
    }
}
