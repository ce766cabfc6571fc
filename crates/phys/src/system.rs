//! What a spec means: every name resolved, every mistake collected.
//!
//! ```text
//! Spec --check--> Case: System (equations: known rates, unknown terms, parameters, contacts) + RecordPlans
//!                          |                                                                     |
//!                          +--System::model--> Model (rates alone)           table --from_table--+--> Record (samples in SI)
//! ```

pub(crate) mod check;
pub(crate) mod constants;
pub(crate) mod equations;
pub(crate) mod model;
pub(crate) mod note;
pub(crate) mod plan;
pub(crate) mod record;
pub(crate) mod sensor;
