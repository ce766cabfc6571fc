//! Mechanical systems: states, inputs, constants, known rates, unknown terms, contacts; records of their
//! motion.
//!
//! Each folder uses only those to its left.
//!
//! ```text
//!    text                  units                 system                           suspicion
//! text --spec::read--> Spec --dimensions--> --check--> Case: System, RecordPlans
//!                                                        |        |
//!                                       Model <--model---+        +--from_table--> Record --> Suspicions
//! ```
//!
//! `law` compiles the files of the catalogue to nodes. All mistakes of a text are reported together, as
//! [`Diagnostic`]s, which the program draws. This crate reads no files and integrates nothing.

mod decision;
mod law;
mod suspicion;
mod system;
mod text;
mod units;

/// The outline of a text that may be half typed, for editors.
pub mod outline {
    pub use crate::text::raw::error_recovery::read;
    pub use crate::text::raw::{Entry, Node, Shape};
}

pub use decision::{Basis, Decision};
pub use law::{
    BUILT_IN, INPUT, Indistinguishable, Internal, Law, LawEntry, LawError, LawGraph, LawParameter, LawScreen,
    Need, Role as LawRole, Screen, Sketch, jointly_linear,
};
pub use suspicion::{Suspicion, Wrap, clipped, suspicions, wraps};
pub use system::check::{Case, check, check_names, takes_units};
pub use system::constants::Value;
pub use system::equations::with_reactions;
pub use system::equations::{
    Constraint, Contact, Input, NamedPlace, Output, Parameter, Point, State, System, TableRead, Term,
};
pub use system::filter::{Filter, FilterKind, NotLinear};
pub use system::impact::{Impact, Rebound};
pub use system::model::Model;
pub use system::note::Note;
pub use system::own_times::OwnTimes;
pub use system::plan::{Origin, RecordPlan, Synthetic, SyntheticInput};
pub use system::record::{Derivation, Overlap, OwnColumn, Record, Units, link_continuations, overlaps};
pub use system::requirement::Requirement;
pub use system::sensor::{LAG_MOMENTS, Sensor, SensorParameter, SensorPart};
pub use system::table::{Samples, Table};
pub use text::diagnostic::{Diagnostic, Label, Located, Severity, Source, SourceId, Sources};
pub use text::files::{Files, NamedFile, Numbers, named_files};
pub use text::format::format;
pub use text::{fields, spec, splice};
pub use units::dimensions::measures;
pub use units::unit;
