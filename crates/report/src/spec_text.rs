//! Specs with a result in them: `identified.ron` of `run`, `completed.ron` of `gap`.

mod completed;
mod edit;
mod identified;

pub use completed::{COMPLETED, completed};
pub use edit::{head, named_data, with_data, without_head};
pub use identified::{IDENTIFIED, identified};
