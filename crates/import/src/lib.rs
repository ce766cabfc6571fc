//! Data files to tables, to the records of a spec, and to drafts of specs.
//!
//! ```text
//! DataFile --csv::record, Selection--> phisindy_phys::Table: the columns and rows of a record, in SI
//!    |
//!    +--csv::table--> Table --TimeColumn, Statistics--> Roles --> Draft --spec_text--> a spec with comments
//! ```
//!
//! This crate opens no files: the caller passes the bytes and a name for messages. Each format has one module,
//! which delivers a [`Table`] or the columns of a record. Everything else is independent of the format.

pub mod csv;

mod clock;
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
pub use time_column::{Coarse, NoTime, TimeColumn};
pub use usage::Usage;
