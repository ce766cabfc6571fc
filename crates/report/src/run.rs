//! The result of `run`: an identified model.

mod contribution;
mod fixed;
mod json;
mod report;

pub use report::RunReport;
