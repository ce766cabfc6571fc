//! Tests of the language, in one binary.
#![allow(missing_docs)]

mod code;
mod common;
mod ops;
mod parse;
mod properties;
mod round_trip;
mod tape;
mod vjp;
