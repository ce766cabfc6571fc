//! Tests of the program, in one binary, for each link costs.
#![allow(missing_docs)]

mod border;
// `blind` belongs to the tests of the other program.
mod causes;
#[allow(dead_code)]
mod common;
mod compare;
mod contributions;
mod determinism;
mod editor;
mod export;
mod faults;
mod files;
mod fmt;
mod formula;
mod gap;
mod identified;
mod limits;
mod matrices;
mod measured;
mod mechanism;
mod new;
mod next;
mod outputs;
mod program;
mod records;
mod reference;
mod report;
mod results;
mod robots;
mod streams;
mod structure;
mod sweep;
mod terminal;
mod tutorial;
mod verify;
mod wrong;
