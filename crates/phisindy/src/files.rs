//! Specs, their data and results on disk. This is the one module of the libraries that reads and writes files.
//!
//! ```text
//! path --spec_text--> text --with_assignments--> text --load_text--> Loaded: case and records
//!                                                  +-- Folders: where data files are; catalogue: where laws are
//! result --ResultFolder--> a folder that appears as a whole (write_whole: a file that does)
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
mod compare;
mod compared_models;
mod fleet;
mod folders;
mod judged;
mod laws;
mod load;
mod next;
mod provenance;
mod request;
mod results;
mod source;
mod streams;
mod trends;
mod whole;

pub use columns::Columns;
pub(crate) use columns::headings;
pub use compare::compare;
pub use fleet::{fleet_of, machine, machine_files};
pub use folders::{data_file, named_files, named_numbers, open_plain_file, opened};
pub use laws::{LawFolderError, beside, catalogue, doubts, law_files};
pub use load::{
    Purpose, Refusal, case_of, load, load_text, open, open_text, spec_text, start_of, with_assignments,
};
pub use next::next;
pub use provenance::{Asked, Difference, Provenance, Verified, verify};
pub use request::{Assignment, Naming, Request};
pub use results::{FolderError, Kept, ResultFolder, put_new};
pub use whole::{try_to_write, write_whole};
