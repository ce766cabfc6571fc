//! Specs with a result in them: `identified.ron` of `run`, `completed.ron` of `gap`.

mod completed;
mod edit;
mod identified;

pub use completed::{COMPLETED, completed};
pub use identified::{IDENTIFIED, identified};

/// The start of the first line of the spec that a command leaves.
pub fn head(command: &str) -> String {
    format!("// What `phisindy {command} ")
}
