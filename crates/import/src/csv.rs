//! Text files with a row of numbers on each line.
//!
//! ```text
//! bytes --Lines--> text lines --Dialect--> fields --Opening--> headings, units --+-- record: the columns and rows that a spec selects
//!                                                                                +-- table: all columns, up to a stated amount
//! ```

mod dialect;
mod lines;
mod mistakes;
mod opening;
mod record;
mod table;

pub use record::record;
pub use table::table;
