//! System and records to an identified model.

mod assess;
mod batch;
mod descent;
mod identified;
mod identify;
mod least_squares;
mod linear;
mod noise;
mod onestep;
mod problem;
mod rollout;
mod train;

pub use identified::{Estimate, FoundParameter, FoundTerm, Identified, LearnError, PathPoint, RecordFit, Verdict};
pub use identify::{LearnOptions, identify};
pub use train::{StepFit, StepOptions, train};
