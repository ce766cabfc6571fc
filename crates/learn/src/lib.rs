//! System and records to an identified model.

mod decisions;
mod differentiators;
mod identify;
mod least_squares;
mod linear;
mod result;
mod step;
#[cfg(test)]
mod straight;
mod sweep;
mod trajectory;

pub use decisions::decisions;
pub use identify::{LearnOptions, dead_column, identify};
pub use result::error::{DataError, LearnError, ModelError, NumericsError, TruthError};
pub use result::estimate::Estimate;
pub use result::identified::{Identified, NoiseModel, PathPoint, StopReason};
pub use result::parameter::FoundParameter;
pub use result::quantity::{ParameterId, ParameterOf, Quantity, RecordId, SensorPart, TermId};
pub use result::record_fit::RecordFit;
pub use result::term::{Contribution, FoundTerm};
pub use result::unknown_part::{Course, Curve, UnknownPart, unknown_parts};
pub use result::verdict::{Rejection, Verdict};
pub use result::warning::{Warning, at_bounds, sensitive_starts};
pub use step::options::StepOptions;
pub use step::train::{StepFit, train};
pub use sweep::{SweepRun, Truth, bound, project, sweep_one};
pub use trajectory::calibrate::{Calibration, Effort, RESTARTED, approach, calibrate, glance};
pub use trajectory::initial::smoothed;
