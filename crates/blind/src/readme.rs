//! The tables of the documents, made from the specs and the code, so that nobody copies numbers by
//! hand.

mod cases;
mod decisions;
mod language;
mod paper;
mod seeds;

use crate::args::{CaseArgs, Options, SweepArgs};
use crate::program::Program;
use anyhow::Result;
use cases::chosen;

pub(crate) use decisions::table as decisions;
pub(crate) use language::table as language;

/// Each case with the printed result of the paper; none if the user stopped it.
///
/// # Errors
/// There is no such case, or its spec cannot be run.
pub(crate) fn paper(args: &CaseArgs, options: &Options) -> Result<Option<String>> {
    paper::table(&chosen(args)?, args, &Program::find(options)?, options)
}

/// Many seeds of each case; none if the user stopped it.
///
/// # Errors
/// There is no such case, or its spec cannot be swept.
pub(crate) fn sweep(args: &SweepArgs, options: &Options) -> Result<Option<String>> {
    seeds::table(&chosen(&args.cases)?, args, &Program::find(options)?, options)
}
