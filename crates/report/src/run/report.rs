//! A result for people: equations as LaTeX (the rest as comments) or as plain text.

use super::contribution;
use super::fixed::{self, Held};
use super::json;
use crate::equation::{Equation, equations, names_of_records};
use crate::format::{Format, method_name as method, role_name as role};
use crate::table::{aligned, interval, short};
use crate::{Ending, Input};
use phisindy_learn::{Estimate, FoundTerm, Identified, RecordFit, Verdict};
use phisindy_phys::SourceId;
use phisindy_phys::spec::{self, Role, Text, UnknownSpec};
use phisindy_phys::unit::Dimension;

/// Everything that is to be told about one spec.
pub struct RunReport<'a> {
    /// The case and its records.
    pub(crate) input: Input<'a>,
    /// What was found.
    pub(crate) found: &'a Identified,
    /// The same as equations.
    pub(crate) equations: Vec<Equation>,
    /// States and what their candidates are multiplied by, as the spec writes it: the coefficients of the table stand before both.
    factors: Vec<(String, String)>,
    /// What the fit did not move.
    pub(crate) held: Vec<Held>,
    /// What a careful reader should know.
    pub warnings: Vec<String>,
    /// What was done to the data.
    pub notes: Vec<String>,
    /// How the work ended.
    pub(crate) ending: Ending,
}

impl<'a> RunReport<'a> {
    /// Writes the equations, and tells notes about the data from warnings.
    pub fn new(input: Input<'a>, found: &'a Identified, ending: Ending) -> RunReport<'a> {
        let case = input.case;
        let equations = equations(case, &found.terms, &found.parameters);
        let of_records =
            input.records.iter().flat_map(|r| r.notes.iter().map(|note| format!("{}: {note}", r.name)));
        let mut notes: Vec<String> = of_records.collect();
        let mut warnings = Vec::new();
        for warning in &found.warnings {
            if notes.contains(warning) {
                continue;
            }
            // Method step derives states too, and says so in the same words.
            if warning.contains(" is the derivative of ") { &mut notes } else { &mut warnings }
                .push(warning.clone());
        }
        let spec = spec::read(input.text, SourceId(0)).ok();
        let held = spec.as_ref().map_or(vec![], |(spec, _)| fixed::held(input, spec, found));
        let unknown = spec.map_or(vec![], |(spec, _)| spec.unknown);
        let factor = |(state, u): (Text, UnknownSpec)| Some((state.value, u.factor?.value));
        let factors = unknown.into_iter().filter_map(factor).collect();
        RunReport { input, found, equations, factors, held, warnings, notes, ending }
    }

    /// The result in one of its forms, with an end of line.
    pub fn written(&self, format: Format) -> String {
        match format {
            Format::Json => json::line(self) + "\n",
            Format::Latex => {
                let mut lines: Vec<String> = self.equations.iter().map(|e| e.latex.clone()).collect();
                let comment =
                    |line: String| if line.is_empty() { "%".to_owned() } else { format!("% {line}") };
                lines.extend(self.details().into_iter().map(comment));
                lines.join("\n") + "\n"
            }
            Format::Text => {
                let state = |e: &Equation| &self.input.case.system.states[e.state].name;
                let mut lines: Vec<String> =
                    self.equations.iter().map(|e| format!("d{}/dt = {}", state(e), e.text)).collect();
                lines.extend(self.details());
                lines.join("\n") + "\n"
            }
        }
    }

    /// All that is not an equation, as lines.
    fn details(&self) -> Vec<String> {
        let found = self.found;
        let mut lines = vec![String::new()];
        let title = &self.input.case.system.title;
        lines.push(if title.is_empty() {
            self.input.spec.to_owned()
        } else {
            format!("{title} ({})", self.input.spec)
        });
        let verdict = match &found.verdict {
            Verdict::Identified => "identified".to_owned(),
            Verdict::Rejected(why) => format!("rejected: {why}"),
        };
        let verdict = match self.ending.stopped_words() {
            Some(stopped) => format!("{stopped} before the end; so far {verdict}"),
            None => verdict,
        };
        lines.push(format!("{verdict} (method {}, {:.1} s)", method(found.method), self.ending.seconds));
        lines.push(self.basis());
        let mut section = |rows: Vec<Vec<String>>| {
            if rows.len() > 1 {
                lines.push(String::new());
                lines.extend(aligned(&rows));
            }
        };
        section(self.coefficients());
        section(contribution::rows(&self.input.case.system, found));
        section(self.parameters());
        section(self.records());
        lines.extend(fixed::line(&self.held));
        let own = names_of_records(&self.input.case.system, &self.equations);
        if !own.is_empty() {
            lines.push(format!("{}: each record has its own", own.join(", ")));
        }
        if !self.warnings.is_empty() {
            lines.push(String::new());
            lines.extend(self.warnings.iter().flat_map(|w| w.lines()).map(|w| format!("warning: {w}")));
        }
        // Titles and names may hold ends of lines, behind which nothing would be a comment.
        lines.into_iter().map(|line| line.replace(['\n', '\r'], " ")).collect()
    }

    /// Which free runs the verdict rests on.
    pub(crate) fn basis(&self) -> String {
        let validated: Vec<&RecordFit> =
            self.found.records.iter().filter(|r| r.role == Role::Validate).collect();
        let worst = |records: &[&RecordFit]| {
            let worst = records.iter().max_by(|a, b| a.worst().total_cmp(&b.worst()));
            worst.map_or(String::new(), |r| format!("NRMSE up to {} ({})", short(r.worst()), r.name))
        };
        match validated.len() {
            0 => {
                let fitted: Vec<&RecordFit> = self.found.records.iter().collect();
                format!(
                    "rests on the fitted records alone, run freely: {}; none has the role Validate",
                    worst(&fitted)
                )
            }
            1 => format!("rests on the free run of a record that was not fitted: {}", worst(&validated)),
            n => format!("rests on the free runs of {n} records that were not fitted: {}", worst(&validated)),
        }
    }

    fn coefficients(&self) -> Vec<Vec<String>> {
        let mut rows = vec![words(&[
            "equation",
            "factor",
            "candidate",
            "unit",
            "coefficient",
            "std. error",
            "95 % interval",
        ])];
        if self.found.terms.iter().any(|found| self.force(found).is_some()) {
            rows[0].push("times inertia".to_owned());
        }
        for found in &self.found.terms {
            let term = &self.input.case.system.terms[found.term];
            let state = &self.input.case.system.states[term.state].name;
            let factor = self.factor(state);
            let unit = term.unit.map_or("-".to_owned(), |unit| unit.to_string());
            let mut row = vec![state.clone(), factor.to_owned(), term.candidate.clone(), unit];
            row.extend(estimate(&found.coefficient, 1.0));
            if found.at_bound {
                row[6].push_str(" at its bound");
            }
            row.extend(self.force(found).map(|(force, unit)| format!("{} {unit}", short(force))));
            rows.push(row);
        }
        rows
    }

    /// What the candidates of a state are multiplied by.
    pub(crate) fn factor(&self, state: &str) -> &str {
        self.factors.iter().find(|(s, _)| s == state).map_or("1", |(_, factor)| factor)
    }

    /// The force behind a coefficient that is a rate, and its unit, where the spec states the inertia and it is one number.
    pub(crate) fn force(&self, found: &FoundTerm) -> Option<(f64, Dimension)> {
        let system = &self.input.case.system;
        let term = &system.terms[found.term];
        let (unit, inertia) = (term.force?, system.inertia[term.state]?);
        let moved = self.found.parameters.iter().filter(|p| p.record.is_none());
        let values: Vec<_> =
            moved.filter_map(|p| Some((system.parameters[p.parameter?].node, p.estimate.value))).collect();
        let mut graph = system.graph.clone();
        let inertia = system.with_values(&mut graph, inertia, &values);
        Some((found.coefficient.value * graph.value(inertia)?, unit))
    }

    fn parameters(&self) -> Vec<Vec<String>> {
        let mut rows = vec![words(&["parameter", "unit", "value", "std. error", "95 % interval", ""])];
        for p in &self.found.parameters {
            let mut row =
                vec![p.name.clone(), if p.unit.is_empty() { "-".to_owned() } else { p.unit.clone() }];
            row.extend(estimate(&p.estimate, p.factor));
            row.push(if p.at_bound { "at its bound".to_owned() } else { String::new() });
            rows.push(row);
        }
        rows
    }

    fn records(&self) -> Vec<Vec<String>> {
        let mut rows = vec![words(&["record", "role", "samples", "NRMSE of the free run"])];
        for record in &self.found.records {
            let errors: Vec<String> =
                record.nrmse.iter().map(|(name, e)| format!("{name} {}", short(*e))).collect();
            let errors = record.failure.as_ref().map_or(errors.join(", "), |why| format!("failed: {why}"));
            rows.push(vec![
                record.name.clone(),
                role(record.role).to_owned(),
                record.samples.to_string(),
                errors,
            ]);
        }
        rows
    }
}

fn words(words: &[&str]) -> Vec<String> {
    words.iter().map(|w| (*w).to_owned()).collect()
}

/// Value, error, interval.
fn estimate(e: &Estimate, factor: f64) -> [String; 3] {
    let interval = interval(e.ci95.0 / factor, e.ci95.1 / factor);
    [short(e.value / factor), short(e.std_error / factor), interval]
}
