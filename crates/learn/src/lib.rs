//! System and records to an identified model.
//!
//! ```text
//! Case + Records --identify--> step:       windows --> loss over one or more steps --> train ----------+
//!                         |                                                                            +--> Identified (terms, parameters,
//!                         +--> trajectory: initial --> fit (simulate, minimise) --> select --> report -+    free runs, warnings, verdict)
//! Case + Records + noise --calibrate--> Calibration (parameters, free runs)
//! ```
//!
//! Results, warnings and errors are data; `Display` gives their sentences. This crate reads no files, prints
//! nothing and knows no clock.

mod copies;
mod decisions;
mod differentiator_dependence;
mod identify;
mod input_noise;
mod least_squares;
#[cfg(test)]
mod line_models;
mod linear;
mod record_mistakes;
mod result;
mod step;
mod sweep;
mod trajectory;

pub use decisions::decisions;
pub use identify::{LearnOptions, identify};
pub use input_noise::noisier;
pub use record_mistakes::{dead_column, suitable};
pub use result::error::{DataError, LearnError, ModelError, NumericsError, TruthError};
pub use result::estimate::Estimate;
pub use result::held::HeldConstant;
pub use result::horizon::Horizon;
pub use result::identified::{Identified, NoiseModel, PathPoint, StopReason};
pub use result::late_column::LateColumn;
pub use result::parameter::{FoundParameter, parameter_values};
pub use result::passivity_violation::PassivityViolation;
pub use result::quantity::{ParameterId, ParameterOf, Quantity, RecordId, TermId};
pub use result::record_fit::{Adapted, OwnValue, RecordFit};
pub use result::remainder::Remainder;
pub use result::term::{Contribution, FoundTerm};
pub use result::unknown_part::{Curve, PartValues, UnknownPart, unknown_parts};
pub use result::verdict::{Contradiction, FitFailure, Rejection, Unfulfilled, Verdict};
pub use result::warning::{Bias, Chaos, Warning, at_bounds, sensitive_starts};
pub use step::options::StepOptions;
pub use step::train::{StepFit, train};
pub use sweep::{SweepRun, Truth, bound, project, sweep_one};
pub use trajectory::calibrate::{
    Calibration, Effort, RESTART_RANGE, SegmentFit, calibrate, calibrate_from, segment_cost, segment_fit,
    single_run_cost,
};
pub use trajectory::free_run::{Predicted, Predictor, predicted};
pub use trajectory::horizon::free_run_horizons;
pub use trajectory::initial::{differentiated, sized, smoothed};
pub use trajectory::kalman_smoother::reads_outputs;
