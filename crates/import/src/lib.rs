//! Data files: what they hold, the records that a spec takes from them, and drafts of specs for them.
//!
//! ```text
//!                    +-- csv::record: what a spec asks for --Selection--> phisindy_phys::Table (SI)
//! DataFile (bytes) --+
//!                    +-- csv::table: all columns --> Table --TimeColumn, Statistics, Roles, Records--> Draft --> text of a spec
//! ```
//!
//! This crate opens no files: the caller passes bytes and the name that the user knows. Each format has one module, which delivers a
//! [`Table`] or the columns of a record; the rest is the same for all of them.

pub mod csv;

mod contradictions;
mod data_file;
mod draft;
mod headings;
mod records;
mod remarks;
mod roles;
mod selection;
mod spec_text;
mod start_values;
mod statistics;
mod table;
mod time_column;
mod usage;

pub use data_file::{DataFile, ReadSeek, unreadable};
pub use draft::{Draft, NoDraft};
pub use headings::{Heading, Quantity};
pub use records::RecordDraft;
pub use remarks::Remark;
pub use roles::{Doubt, Input, NoMotion, Roles, Selector};
pub use spec_text::{accepted, spec_text, summary};
pub use start_values::{Estimate, Motion};
pub use statistics::{Statistics, Stops};
pub use table::{Column, Table};
pub use time_column::{NoTime, TimeColumn};
pub use usage::Usage;
