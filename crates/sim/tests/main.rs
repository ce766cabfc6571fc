//! Tests of simulation, in one binary.
#![allow(missing_docs)]

mod closed_forms;
mod common;
mod contact_rule;
mod errors;
mod filters;
mod held;
mod impacts;
mod independent;
mod kinks;
mod outputs;
#[path = "common/random.rs"]
mod random;
mod random_models;
mod sensitivities;
mod stiff;
mod synthetic;
mod work;
