//! Text files with one row of numbers on each line.
//!
//! ```text
//! bytes --Lines--> lines --Dialect--> cells --Header--> headings --record--> the columns and rows of a record
//!                                                          |
//!                                                          +------table---> all columns, up to a million rows
//! ```

mod dialect;
mod header;
mod lines;
mod mistakes;
mod record;
mod table;

pub use record::record;
pub use table::table;
