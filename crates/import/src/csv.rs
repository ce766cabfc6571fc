//! Text files with a row of numbers on each line.
//!
//! ```text
//! bytes --Lines--> text lines --Dialect--> fields --+-- record: the columns of a spec, only the rows that it selects
//!                                                   +-- survey: all columns, up to a stated amount
//! ```

mod dialect;
mod lines;
mod mistakes;
mod record;
mod survey;

pub use mistakes::unreadable;
pub use record::record;
pub use survey::{Column, Survey};
