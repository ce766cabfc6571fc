//! What is asked for beside the path of a spec.

use super::columns::Columns;
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
    /// Folders, relative to that of the spec, in place of those that the head of its text names: a text that
    /// came from elsewhere chooses none.
    pub named_data: Option<Vec<String>>,
    /// Folder of further laws, beside the folder `laws` of the spec (`--laws`).
    pub laws: Option<PathBuf>,
    /// Seed of synthetic data, in place of the spec's.
    pub seed: Option<u64>,
    /// How the caller names a folder of data files, for the help of a file that is not found.
    pub naming: Naming,
    /// Tables in the place of the files of the measured records, in their order; empty: the files are read.
    pub tables: Vec<Columns>,
}

/// How a caller names a folder of data files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Naming {
    /// By `--data` or the variable `PHISINDY_DATA`.
    #[default]
    Option,
    /// By the variable `PHISINDY_DATA`, or it is the folder of the spec.
    Variable,
}

impl Naming {
    /// What names the folder.
    pub(crate) fn how(self) -> &'static str {
        match self {
            Naming::Option => "with --data",
            Naming::Variable => "in the environment variable PHISINDY_DATA",
        }
    }

    /// What helps where there is no file.
    pub(crate) fn help(self) -> &'static str {
        match self {
            Naming::Option => {
                "say where the data files are with --data DIR or the environment variable PHISINDY_DATA"
            }
            Naming::Variable => {
                "name the folder of the data files in the environment variable PHISINDY_DATA, or put them into the folder of the spec"
            }
        }
    }
}

/// A field of a spec and its new value, `PATH=VALUE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Assignment {
    /// Fields, keys and indices joined by points.
    pub path: String,
    /// The value in RON.
    pub value: String,
}
