//! The result of the gap workflow with what a report says beside it.

use crate::input::{Ending, Input};
use crate::next::Outcome as PlannedOutcome;
use crate::seen::{Model, Seen, Shown};
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
    /// What a run that was planned decided.
    pub planned: Option<&'a PlannedOutcome>,
    /// How the work ended.
    pub ending: Ending,
}

impl<'a> GapReport<'a> {
    /// Warnings that the text of the result does not hold.
    pub fn notes(&self) -> impl Iterator<Item = &'a Warning> {
        self.gap.warnings.iter().filter(|w| !matches!(w, Warning::Alternative(_)))
    }

    /// Each measured column beside what the model says of it.
    pub fn shown(&self) -> Vec<Shown> {
        self.seen().shown()
    }

    /// The records with the model before and after effects were added.
    pub(crate) fn seen(&self) -> Seen<'a> {
        let (was, now) = (&self.gap.initial, &self.gap.simulated);
        Seen {
            system: &self.input.case.system,
            records: self.input.records,
            was: (!self.gap.steps.is_empty()).then(|| Model::new(&was.system, &[], &was.records)),
            model: Some(Model::new(&now.system, &[], &now.records)),
        }
    }
}
