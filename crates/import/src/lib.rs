//! Data files: what they hold, the records that a spec takes from them, and drafts of specs for them.
//!
//! ```text
//!                    +-- csv::record, what a spec asks for ----------------> phisindy_phys::Table (SI)
//! DataFile (bytes) --+
//!                    +-- csv::survey, all columns --> Table --> TimeColumn, Statistics, Roles --> Draft --> text of a spec
//! ```
//!
//! This crate opens no files: the caller passes bytes and the name that the user knows. Each format has one folder; headings, roles and
//! drafts are the same for all of them.

pub mod csv;

mod contradictions;
mod data_file;
mod draft;
mod headings;
mod roles;
mod spec_text;
mod start_values;
mod statistics;
mod time_column;

pub use data_file::{DataFile, ReadSeek};
pub use draft::{Draft, Trouble};
pub use spec_text::{accepted, spec, summary};
