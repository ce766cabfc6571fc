//! Specs and their data on disk. This is the one module of the library that reads files; it writes none.
//!
//! ```text
//! path --spec_text--> text --with_assignments--> text --load_text--> Loaded: case and records
//!                                                  +-- Folders: where data files are; catalogue: where laws are
//! ```
//!
//! ```no_run
//! use phisindy::{Options, files};
//! use std::path::Path;
//! let loaded = files::open(Path::new("rig.ron"), &files::Request::default())?;
//! let found = loaded.identify(&Options::default())?;
//! println!("{}", found.latex());
//! # Ok::<(), phisindy::Error>(())
//! ```

mod columns;
mod folders;
mod laws;
mod load;
mod request;
mod trends;

pub use columns::Columns;
pub(crate) use columns::headings;
pub use folders::{open_plain_file, opened};
pub use laws::{LawFolderError, beside, catalogue, doubts};
pub use load::{Purpose, Refusal, load, load_text, open, open_text, spec_text, start_of, with_assignments};
pub use request::{Assignment, Naming, Request};
