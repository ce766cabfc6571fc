//! The result of a sweep: many seeds of one case, in cells that differ in noise, cut-off or anything else.

mod json;
mod runs;
mod statistics;
mod text;

pub use json::json;
pub use runs::{CellRuns, Found, NamedTruth, Run, RunVerdict, SweepRuns};
pub use statistics::{Coefficient, Statistics};
pub use text::table;
