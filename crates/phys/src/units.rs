//! Units and what they measure.
//!
//! `unit` reads a text such as `"N*s/m"` into a factor and a dimension; `dimensions` checks that what a spec
//! adds, compares and equates has one dimension, and finds the units of coefficients.

pub(crate) mod dimensions;
pub mod unit;
