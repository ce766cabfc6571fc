//! Tests of specs and their check, in one binary.
#![allow(missing_docs)]

mod check;
mod energy;
mod fields;
mod format;
mod laws;
mod mutated;
mod spec;
mod splice;
mod structure;
