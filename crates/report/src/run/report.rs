//! The result of `run` with everything that a report adds to it.

use super::adapted;
use super::fixed::{FixedValue, fixed_values};
use crate::equation::{Equation, ImpactLine, equations, impacts_of};
use crate::html::friction::{force_unit, rate};
use crate::input::{Ending, Input};
use crate::next::Outcome as PlannedOutcome;
use crate::seen::{Model, Seen, Shown};
use crate::table::short;
use phisindy_learn::{Adapted, FoundTerm, Identified, RecordFit, Remainder};
use phisindy_phys::spec::Role;
use phisindy_phys::unit::Dimension;

/// The result of `run` for one spec.
pub struct RunReport<'a> {
    /// The case and its records.
    pub(crate) input: Input<'a>,
    /// The identified model.
    pub(crate) identified: &'a Identified,
    /// Its equations.
    pub(crate) equations: Vec<Equation>,
    /// What happens where gaps close.
    pub(crate) impacts: Vec<ImpactLine>,
    /// Numbers that the fit did not move.
    pub(crate) fixed: Vec<FixedValue>,
    /// Warnings of the identification, without the notes.
    pub warnings: Vec<String>,
    /// How the data were processed before the identification.
    pub notes: Vec<String>,
    /// What a run that was planned decided.
    pub planned: Option<PlannedOutcome>,
    /// How the work ended.
    pub(crate) ending: Ending,
}

impl<'a> RunReport<'a> {
    /// Derives the equations, and separates notes about the data from warnings.
    pub fn new(input: Input<'a>, found: &'a Identified, ending: Ending) -> RunReport<'a> {
        let case = input.case;
        let equations = equations(case, &found.terms, &found.parameters);
        let impacts = impacts_of(&case.system, case, &found.parameters);
        let of_records =
            input.records.iter().flat_map(|r| r.notes.iter().map(|note| format!("{}: {note}", r.name)));
        let mut notes: Vec<String> = of_records.collect();
        let mut warnings = Vec::new();
        for warning in &found.warnings {
            let text = warning.to_string();
            // Method step derives states too, and says so beside the notes of the records.
            if !notes.contains(&text) {
                if warning.is_note() { &mut notes } else { &mut warnings }.push(text);
            }
        }
        let fixed = fixed_values(input, found);
        RunReport {
            input,
            identified: found,
            equations,
            impacts,
            fixed,
            warnings,
            notes,
            planned: None,
            ending,
        }
    }

    /// Each measured column beside what the model says of it.
    pub fn shown(&self) -> Vec<Shown> {
        self.seen().shown()
    }

    /// The records with the identified model.
    pub(crate) fn seen(&self) -> Seen<'_> {
        let (system, found) = (&self.input.case.system, self.identified);
        let terms: Vec<usize> = found.terms.iter().map(|f| f.term).collect();
        let model = Model::new(system, &terms, &found.records);
        Seen { system, records: self.input.records, was: None, model: Some(model) }
    }

    /// The free runs that the verdict rests on, in words.
    pub(crate) fn basis(&self) -> String {
        let all: Vec<&RecordFit> =
            self.identified.records.iter().filter(|r| r.role == Role::Validate).collect();
        let predicted = |r: &&RecordFit| r.adapted.as_ref().is_none_or(|a| a.samples < r.samples);
        let validated: Vec<&RecordFit> = all.iter().copied().filter(predicted).collect();
        let worst = |records: &[&RecordFit]| {
            let worst = records.iter().max_by(|a, b| a.worst().total_cmp(&b.worst()));
            worst.map_or(String::new(), |r| format!("NRMSE up to {} ({})", short(r.worst()), r.name))
        };
        let (of, not_fitted) = match validated.len() {
            0 => {
                let fitted: Vec<&RecordFit> = self.identified.records.iter().collect();
                let why = match all.is_empty() {
                    true => "none has the role Validate",
                    false => "the others were adapted as a whole, which leaves nothing to predict",
                };
                return format!("rests on the fitted records alone, run freely: {}; {why}", worst(&fitted));
            }
            1 => ("the free run of a record".to_owned(), "was not fitted"),
            n => (format!("the free runs of {n} records"), "were not fitted"),
        };
        let adapted: Vec<&Adapted> = validated.iter().filter_map(|r| r.adapted.as_ref()).collect();
        let longest = adapted.iter().max_by(|a, b| (a.span.1 - a.span.0).total_cmp(&(b.span.1 - b.span.0)));
        let mut own: Vec<String> = adapted.iter().flat_map(|a| &a.values).map(adapted::name).collect();
        own.sort();
        own.dedup();
        let misses = worst(&validated);
        match (longest.map(|a| adapted::length(a)), own.is_empty()) {
            (None, _) => format!("rests on {of} that {not_fitted}: {misses}"),
            (Some(part), true) => format!(
                "rests on {of} that {not_fitted}: {misses}; start states were adapted on the first {part}, and only what \
                 follows is scored"
            ),
            (Some(part), false) => format!(
                "rests on {of} beyond the first {part}, to which {} and the start state were adapted: {misses}",
                own.join(", ")
            ),
        }
    }

    /// The coefficient times the inertia of its state, and the unit of that force, if the spec states an
    /// inertia that is one number.
    pub(crate) fn force(&self, found: &FoundTerm) -> Option<(f64, Dimension)> {
        let term = &self.input.case.system.terms[found.term];
        Some((found.coefficient.value * self.inertia(term.state)?, term.force?))
    }

    /// The identified inertia of a state, where the spec says what it is.
    fn inertia(&self, state: usize) -> Option<f64> {
        let system = &self.input.case.system;
        let moved = self.identified.parameters.iter().filter(|p| p.id.record().is_none());
        let values: Vec<_> = moved
            .filter_map(|p| Some((system.parameters[p.id.constant()?].node, p.estimate.value)))
            .collect();
        let mut graph = system.graph.clone();
        let inertia = system.with_values(&mut graph, system.inertia[state]?, &values);
        graph.value(inertia)
    }

    /// The forces that are left, each with its size and unit: a force where the spec states the inertia, else a rate.
    pub(crate) fn remainder(&self) -> Vec<(&'a Remainder, f64, String)> {
        let with_unit = |left: &'a Remainder| {
            let unit = &self.input.case.system.states[left.state].unit;
            match (self.inertia(left.state), force_unit(unit)) {
                (Some(inertia), Some(force)) => (left, left.rms * inertia, force.to_owned()),
                _ => (left, left.rms, rate(unit).map_or(String::new(), |rate| rate.to_string())),
            }
        };
        self.identified.remainder.iter().map(with_unit).collect()
    }
}
