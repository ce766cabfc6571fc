//! Tests of both methods, in one binary.
#![allow(missing_docs)]

mod chaos;
mod common;
mod honesty;
mod nncc;
mod noise_estimates;
#[path = "../../sim/tests/common/random.rs"]
mod random;
mod random_models;
mod step_method;
mod trajectory_method;
