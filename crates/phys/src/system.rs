//! The meaning of a spec: every name resolved, every mistake collected.
//!
//! ```text
//! Spec --check--> Case: System (known rates, unknown terms, parameters, contacts) --System::model--> Model (rates)
//!                       RecordPlans --from_table, with a Table--> Records (samples in SI, with Notes)
//! ```

mod butterworth;
pub(crate) mod check;
pub(crate) mod constants;
pub(crate) mod curve;
pub(crate) mod equations;
pub(crate) mod filter;
pub(crate) mod impact;
mod lagrange;
mod measured;
pub(crate) mod model;
pub(crate) mod note;
pub(crate) mod own_times;
pub(crate) mod plan;
pub(crate) mod record;
pub(crate) mod requirement;
pub(crate) mod sensor;
pub(crate) mod table;
