//! Data files to tables, to the records of a spec, and to drafts of specs.
//!
//! ```text
//! DataFile --record, Selection--> phisindy_phys::Table: the columns and rows of a record, in SI
//!    |
//!    +--table--> Table --TimeColumn, Statistics--> Roles --> Draft --spec_text--> a spec with comments
//! ```
//!
//! This crate opens no files: the caller passes the bytes and a name for messages. Each format has one module
//! in `format`, which delivers cells or channels. Everything else is independent of the format.

mod bytes;
mod cell;
mod channel;
mod channels;
mod clock;
mod columns;
mod contradictions;
mod data_file;
mod draft;
mod format;
mod headings;
mod listing;
mod matrix;
mod merged;
mod no_draft;
mod numbers;
mod question;
mod records;
mod refusal;
mod remarks;
mod rig;
mod robot;
mod roles;
mod rows;
mod selection;
mod sheet;
mod spec_text;
mod start_values;
mod stated_rate;
mod statistics;
mod table;
mod time_column;
mod usage;

pub use data_file::{DataFile, ReadSeek, unreadable};
pub use draft::Draft;
pub use headings::{Heading, Quantity};
pub use no_draft::NoDraft;
pub use numbers::numbers;
pub use question::{Answers, CountUnit, Counted, OPEN_QUESTION, Question, rate, time_unit};
pub use records::RecordDraft;
pub use remarks::Remark;
pub use rig::Rig;
pub use robot::{Joint, Log as RobotLog, Motion as JointMotion, Refitted, Robot};
pub use roles::{Doubt, Input, NoMotion, Roles, Selector};
pub use rows::{record, table};
pub use spec_text::{accepted, next_step, spec_text, spec_text_of, summary};
pub use start_values::{Drive, Estimate, Motion};
pub use stated_rate::StatedRate;
pub use statistics::{Statistics, Stops};
pub use table::{Column, Table};
pub use time_column::{Coarse, NoTime, TimeColumn};
pub use usage::Usage;
