//! How large a spec may be: far more than a rig needs, far less than a machine holds. What exceeds it is
//! refused before anything grows with it.

use super::reader::Reader;
use super::{DataSpec, Spec};
use crate::text::diagnostic::Diagnostic;
use phisindy_expr::Span;

/// Most constants, those of the records included.
const CONSTANTS: usize = 1000;
/// Most states.
const STATES: usize = 100;
/// Most inputs.
const INPUTS: usize = 100;
/// Most outputs.
const OUTPUTS: usize = 100;
/// Most candidates of all equations together.
const CANDIDATES: usize = 1000;
/// Most contacts.
const CONTACTS: usize = 100;
/// Most impacts.
const IMPACTS: usize = 20;
/// Most records.
const RECORDS: usize = 1000;
/// Most samples of a simulated record.
pub(super) const SAMPLES: f64 = 2e6;
/// Most numbers of all simulated records together: samples times states and inputs.
const NUMBERS: f64 = 2e7;

impl Reader<'_> {
    /// Refuses what is too large. The first thing of each kind that is too much has its place.
    pub(super) fn within_size(&mut self, spec: &Spec) {
        let of_structure: usize = spec.structure.iter().map(|structure| 2 * structure.pairs().count()).sum();
        let written = spec.states.len() - of_structure;
        let constants = spec.constants.iter().chain(spec.data.iter().flat_map(DataSpec::constants));
        self.at_most(
            "constants",
            CONSTANTS,
            constants.map(|(n, _)| n.span),
            "put numbers that never change into the expressions",
        );
        self.at_most(
            "states",
            STATES,
            // Those of a structure are as many as its matrices have, twice.
            spec.states[..written].iter().map(|(n, _)| n.span),
            "leave out bodies that hardly move",
        );
        self.at_most(
            "inputs",
            INPUTS,
            spec.inputs.iter().map(|(n, _)| n.span),
            "leave out what the rates do not need",
        );
        self.at_most(
            "outputs",
            OUTPUTS,
            spec.outputs.iter().map(|(n, _)| n.span),
            "leave out what no record holds",
        );
        let candidates = spec.unknown.iter().flat_map(|(_, u)| &u.candidates);
        self.at_most(
            "candidates",
            CANDIDATES,
            candidates.map(|c| c.span),
            "no record tells so many terms apart: list those that physics suggests",
        );
        self.at_most(
            "contacts",
            CONTACTS,
            spec.contacts.iter().map(|c| c.span),
            "list the velocities that can stick",
        );
        self.at_most(
            "impacts",
            IMPACTS,
            spec.impacts.iter().map(|(n, _)| n.span),
            "list the gaps that close",
        );
        let records = spec.data.iter().map(|d| match d {
            DataSpec::Csv(csv) => csv.path.span,
            DataSpec::Synthetic(synthetic) => synthetic.duration.span,
        });
        self.at_most("records", RECORDS, records, "fit some of them, and check the others in a second spec");
        self.numbers(spec);
    }

    fn at_most(&mut self, what: &str, most: usize, mut places: impl Iterator<Item = Span>, help: &str) {
        if let Some(first) = places.nth(most) {
            let message = format!("{} {what} are too many (at most {most})", most + 1 + places.count());
            self.note(Diagnostic::error(message).at(self.source, first, "one too many").help(help));
        }
    }

    /// Simulated records that would not fit into memory, if only together.
    fn numbers(&mut self, spec: &Spec) {
        let (width, mut sum) = ((spec.states.len() + spec.inputs.len() + spec.outputs.len()) as f64, 0.0);
        for data in &spec.data {
            let DataSpec::Synthetic(synthetic) = data else { continue };
            let samples = synthetic.duration.value / synthetic.step.value;
            sum += samples * width;
            // A record that is too long by itself has been told of.
            if sum > NUMBERS && samples <= SAMPLES {
                let message = format!(
                    "the simulated records hold more than {NUMBERS:.0e} numbers (samples times states, inputs and outputs)"
                );
                let d =
                    Diagnostic::error(message).at(self.source, synthetic.duration.span, "with this record");
                self.note(d.help("take shorter records, or longer steps"));
                return;
            }
        }
    }
}
