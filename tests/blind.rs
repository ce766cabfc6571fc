//! Tests of the program for developers, in one binary, for each link costs.
#![allow(missing_docs)]

mod book;
// Not all of it is used here.
#[allow(dead_code)]
mod common;
mod hidden;
mod odd;
mod reword;
mod tables;
