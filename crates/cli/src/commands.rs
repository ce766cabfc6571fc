//! The subcommands: what is read, what is written, and with which exit code they end.

pub(crate) mod check;
pub(crate) mod compare;
pub(crate) mod editor;
pub(crate) mod export;
pub(crate) mod fmt;
pub(crate) mod gap;
pub(crate) mod go;
pub(crate) mod laws;
pub(crate) mod manual;
pub(crate) mod new;
pub(crate) mod next;
pub(crate) mod open;
pub(crate) mod run;
pub(crate) mod simulate;
mod spec_file;
pub(crate) mod sweep;
pub(crate) mod verify;
