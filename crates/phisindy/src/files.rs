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
mod trends;

pub use columns::Columns;
pub(crate) use columns::headings;
pub use folders::{open_plain_file, opened};
pub use laws::{LawFolderError, beside, catalogue, doubts};
pub use load::{Purpose, Refusal, load, load_text, open, open_text, spec_text, start_of, with_assignments};

use std::path::PathBuf;

/// What is asked for beside the path of a spec. Nothing is taken from the environment.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Fields of the spec that are changed.
    pub assignments: Vec<Assignment>,
    /// Folder of the data files, which is searched first (`--data`).
    pub data: Option<PathBuf>,
    /// Folder that is searched next (the variable `PHISINDY_DATA`); the last one is that of the spec.
    pub further_data: Option<PathBuf>,
    /// Folder of further laws, beside the folder `laws` of the spec (`--laws`).
    pub laws: Option<PathBuf>,
    /// Seed of synthetic data, in place of the spec's.
    pub seed: Option<u64>,
    /// Tables in the place of the files of the measured records, in their order; empty: the files are read.
    pub tables: Vec<Columns>,
}

/// A field of a spec and its new value, `PATH=VALUE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Assignment {
    /// Fields, keys and indices joined by points.
    pub path: String,
    /// The value in RON.
    pub value: String,
}
