//! System and records to an identified model.

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

pub use identify::{LearnOptions, at_bounds, dead_column, identify};
pub use result::identified::{
    Contribution, Estimate, FoundParameter, FoundTerm, Identified, LearnError, PathPoint, RecordFit, Verdict,
    sensitive_starts,
};
pub use result::unknown_part::{Course, Curve, UnknownPart, unknown_parts};
pub use step::train::{StepFit, StepOptions, train};
pub use sweep::{SweepRun, Truth, bound, project, sweep_one};
pub use trajectory::calibrate::{Calibration, Effort, RESTARTED, approach, calibrate, glance};
pub use trajectory::initial::smoothed;
