//! Models under test: the model of the spec with laws added to its graph, fitted to the records.

mod error;
mod fitted;
mod input_error;
mod noise_form;
mod occam_factor;
mod records;
mod score;
mod spec_text;
mod trial_model;

pub use error::ModelError;
pub(crate) use fitted::{Fitted, current, measured, power_of, values};
pub(crate) use input_error::ColumnError;
pub(crate) use records::{noise_of, shortened};
#[cfg(test)]
pub(crate) use score::tests;
pub(crate) use score::{Measure, Score, is_sure, most_apart_beforehand, probability_beside};
pub use spec_text::SpecTextError;
pub(crate) use spec_text::{expression, text_with};
pub use trial_model::{Applied, TrialModel};
