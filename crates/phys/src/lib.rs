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

mod blocks;
mod check;
mod constants;
mod derivative;
mod diagnostic;
mod dimensions;
mod interpolate;
mod law;
mod model;
mod noise_level;
mod plan;
mod raw;
mod record;
mod sensor;
pub mod spec;
mod spectrum;
pub mod splice;
mod spread;
mod suspicion;
mod system;
mod trend;
pub mod unit;
mod whiteness;

pub use blocks::Blocks;
pub use check::{Case, check, check_names, takes_units};
pub use constants::Value;
pub use derivative::{Differentiated, Differentiator, automatic, differentiate};
pub use diagnostic::{Diagnostic, Label, Severity, Source, SourceId, Sources};
pub use interpolate::{Interpolation, Signal, SignalError};
pub use law::{Internal, Law, LawParameter, Need, Screen, Sketch};
pub use model::Model;
pub use noise_level::{autocorrelation, effective_samples, noise_level};
pub use plan::{Origin, RecordPlan, Synthetic, SyntheticInput};
pub use record::{Derivation, Record, Table, Units, derivation_note, link_continuations, overlaps};
pub use sensor::{Sensor, SensorParameter};
pub use spectrum::{Line, strongest_line};
pub use spread::standard_deviation;
pub use suspicion::{clipped, suspicions};
pub use system::{Contact, Input, Parameter, State, System, Term};
pub use trend::Trend;
pub use whiteness::chance_of_white;
