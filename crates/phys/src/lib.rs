//! Mechanical systems: states, inputs, constants, known rates, unknown terms, contacts; records of what they did.
//!
//! ```text
//! text --spec::read--> Spec (as written) --check--> Case: System (every name resolved) + RecordPlans --> Record (sampled data)
//!                                                      |
//!                                                      +-- System::model --> Model (rates as functions of time, states, inputs, parameters)
//! ```
//!
//! All mistakes of a text come back together, as [`Diagnostic`]s; drawing them is the program's job. This crate reads no files and knows
//! no integration.

mod check;
mod constants;
mod diagnostic;
mod dimensions;
mod law;
mod model;
mod plan;
mod raw;
mod record;
mod sensor;
pub mod spec;
pub mod splice;
mod suspicion;
mod system;
pub mod unit;

pub use check::{Case, check, check_names, takes_units};
pub use constants::Value;
pub use diagnostic::{Diagnostic, Label, Severity, Source, SourceId, Sources};
pub use law::{Internal, Law, LawParameter, Need, Screen, Sketch};
pub use model::Model;
pub use plan::{Origin, RecordPlan, Synthetic, SyntheticInput};
pub use record::{Derivation, Record, Table, Units, derivation_note, link_continuations, overlaps};
pub use sensor::{Sensor, SensorParameter};
pub use suspicion::{clipped, suspicions};
pub use system::{Contact, Input, Parameter, State, System, Term};
