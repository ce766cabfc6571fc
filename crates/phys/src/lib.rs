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

mod decision;
mod law;
mod suspicion;
mod system;
mod text;
mod units;

pub use decision::{Basis, Decision};
pub use law::{
    BUILT_IN, Indistinguishable, Internal, Law, LawEntry, LawError, LawGraph, LawParameter, LawScreen, Need,
    Role as LawRole, Screen, Sketch,
};
pub use suspicion::{Suspicion, clipped, suspicions};
pub use system::check::{Case, check, check_names, takes_units};
pub use system::constants::Value;
pub use system::equations::{Contact, Input, Parameter, State, System, Term};
pub use system::model::Model;
pub use system::note::Note;
pub use system::plan::{Origin, RecordPlan, Synthetic, SyntheticInput};
pub use system::record::{Derivation, Overlap, Record, Table, Units, link_continuations, overlaps};
pub use system::sensor::{Sensor, SensorParameter};
pub use text::diagnostic::{Diagnostic, Label, Located, Severity, Source, SourceId, Sources};
pub use text::{spec, splice};
pub use units::unit;
