//! System and records to an identified model.

mod agreement;
mod assess;
mod batch;
mod calibrate;
mod contribution;
mod cost;
mod descent;
mod differentiators;
mod fit;
mod identified;
mod identify;
mod initial;
mod input_sensors;
mod least_squares;
mod linear;
mod looks;
mod noise;
mod onestep;
mod problem;
mod profile;
mod rollout;
mod select;
mod shares;
#[cfg(test)]
mod straight;
mod sweep;
mod train;
mod trajectory;
mod unknown_part;

pub use calibrate::{Calibration, Effort, RESTARTED, approach, calibrate, glance};
pub use identified::{
    Contribution, Estimate, FoundParameter, FoundTerm, Identified, LearnError, PathPoint, RecordFit, Verdict,
    sensitive_starts,
};
pub use identify::{LearnOptions, at_bounds, dead_column, identify};
pub use initial::smoothed;
pub use sweep::{SweepRun, Truth, bound, project, sweep_one};
pub use train::{StepFit, StepOptions, train};
pub use unknown_part::{Course, Curve, UnknownPart, unknown_parts};
