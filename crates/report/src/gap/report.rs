//! The result of the gap workflow with what a report says beside it.

use crate::input::{Ending, Input};
use phisindy_gap::{Gap, Warning};
use phisindy_phys::LawEntry;

/// Everything that is told about a spec after the gap workflow.
#[derive(Clone, Copy)]
pub struct GapReport<'a> {
    /// The case and its records.
    pub input: Input<'a>,
    /// What the workflow found.
    pub gap: &'a Gap,
    /// The laws that were tried.
    pub catalogue: &'a [LawEntry],
    /// How the work ended.
    pub ending: Ending,
}

impl<'a> GapReport<'a> {
    /// Warnings that the text of the result does not hold.
    pub fn notes(&self) -> impl Iterator<Item = &'a Warning> {
        self.gap.warnings.iter().filter(|w| !matches!(w, Warning::Alternative(_)))
    }
}
