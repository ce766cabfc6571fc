//! Rows of numbers: the lines of a text file, and what other formats give as lines.
//!
//! ```text
//! bytes --Lines--> lines --Dialect--> cells --Header--> headings --record--> the columns and rows of a record
//!                                                          |
//!                                                          +------table---> all columns, up to a million rows
//! ```

mod comment;
mod dialect;
mod encoding;
mod header;
mod line;
mod lines;
mod mistakes;
mod record;
mod table;
mod thousands;
mod turns;

pub(crate) use line::{Line, LineError};
pub(crate) use lines::Lines;
pub use record::record;
pub use table::table;
