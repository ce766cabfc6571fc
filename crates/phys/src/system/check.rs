//! Spec to [`System`]: every name resolved, every mistake of the file collected.

mod checker;
mod constants;
mod csv;
mod energy;
mod filters;
mod jumps;
mod rates;
mod record;
mod structure;
mod synthetic;

use crate::system::equations::System;
use crate::system::plan::RecordPlan;
use crate::system::requirement::Requirement;
use crate::text::diagnostic::{Diagnostic, Severity, SourceId};
use crate::text::files::Files;
use crate::text::spec::{ConstantSpec, DataSpec, Find, LearnSpec, Spec, Text};
use crate::units::dimensions::dimensions;
use checker::Checker;
use phisindy_expr::parse;
use std::collections::HashSet;
use std::sync::Arc;

/// A checked spec: the system, what its records will be, and how to learn.
#[derive(Clone, Debug)]
pub struct Case {
    /// The physics.
    pub system: System,
    /// In the order of the spec.
    pub records: Vec<RecordPlan>,
    /// As in the spec.
    pub learn: LearnSpec,
    /// Laws of the catalogue that `unknown` names, each with the state whose rate it may be missing in. The
    /// catalogue is not known here: whoever has it writes them into `known`.
    pub laws: Vec<(usize, Text)>,
    /// States whose rate lacks a formula that is looked for, each with the displacements and velocities that
    /// it may hold.
    pub searches: Vec<(usize, Vec<Text>)>,
    /// What must hold of the constants of laws that were written out.
    pub requirements: Vec<Requirement>,
    /// The system without the laws that were written out; `None` where none were.
    pub without_laws: Option<Arc<System>>,
    /// The system with each constant that is held as one more parameter, after its own: with it a result tells
    /// how it depends on them. `None` where nothing is held, or nothing is estimated.
    pub with_constants: Option<Arc<System>>,
}

impl Case {
    /// Whether something in its rates is asked for: candidates, laws or formulas.
    pub fn is_open(&self) -> bool {
        !self.system.terms.is_empty() || !self.laws.is_empty() || !self.searches.is_empty()
    }
}

/// Checks a spec.
///
/// # Errors
/// All mistakes found, errors and warnings; on success the warnings alone come with the case.
///
/// ```
/// use phisindy_phys::{SourceId, check, spec};
/// let text = |rate: &str| {
///     format!(
///         "(states: {{ \"x\": \"m\", \"v\": \"m/s\" }}, constants: {{ \"k\": (4.0, \"1/s^2\") }}, known: {{ \"x\": \"v\", \"v\": \"{rate}\" }},
///           unknown: {{ \"v\": (factor: \"-sgn(v)\", candidates: [\"1\", \"x\"]) }}, contacts: [\"v\"],
///           data: [Csv(path: \"run.csv\", time: \"t\", columns: {{ \"x\": \"x\" }})])"
///     )
/// };
/// let (good, _) = spec::read(&text("-k*x"), SourceId(0)).unwrap();
/// let (case, _) = check(&good, SourceId(0)).unwrap();
/// // A coefficient has the unit that makes its term a rate of the velocity.
/// assert_eq!(case.system.terms[1].unit.unwrap().to_string(), "1/s^2");
///
/// let (bad, _) = spec::read(&text("-k*v"), SourceId(0)).unwrap();
/// assert!(check(&bad, SourceId(0)).unwrap_err()[0].message.contains("m/s^2"));
/// ```
pub fn check(spec: &Spec, source: SourceId) -> Result<(Case, Vec<Diagnostic>), Vec<Diagnostic>> {
    checked(spec, source, true)
}

/// As [`check`], but for what the expressions measure: for texts that a program has changed after they were
/// checked.
///
/// # Errors
/// All mistakes found.
pub fn check_names(spec: &Spec, source: SourceId) -> Result<(Case, Vec<Diagnostic>), Vec<Diagnostic>> {
    checked(spec, source, false)
}

/// Whether a constant with a unit may be added: not where the units of the states and inputs alone do not
/// fit, which is only a warning as long as no constant speaks of units.
pub fn takes_units(spec: &Spec, source: SourceId) -> bool {
    speaks_of_units(spec) || dimensions(spec, source).is_ok()
}

/// Whether any constant has a unit: a spec without one does not speak of units, and is warned, not refused.
fn speaks_of_units(spec: &Spec) -> bool {
    let all = spec.constants.iter().chain(spec.data.iter().flat_map(DataSpec::constants));
    all.into_iter().any(|(_, c)| c.unit().is_some())
}

fn checked(
    spec: &Spec,
    source: SourceId,
    measured: bool,
) -> Result<(Case, Vec<Diagnostic>), Vec<Diagnostic>> {
    let mut checker = Checker::new(source, &spec.files);
    let mut system = checker.system(spec);
    let records = plan_records(&mut checker, spec, &system);
    checker.unused_constants(spec);
    // What names stand for must be settled before what they measure.
    if measured && !checker.diagnostics.iter().any(Diagnostic::is_error) {
        match dimensions(spec, source) {
            Ok(units) => {
                for (term, unit) in system.terms.iter_mut().zip(units.coefficients) {
                    (term.unit, term.force, term.energy) = (unit.coefficient, unit.force, unit.energy);
                }
                system
                    .contacts
                    .iter_mut()
                    .zip(units.contacts)
                    .for_each(|(contact, unit)| contact.unit = unit);
                for (place, (of, enters)) in system.places.iter_mut().zip(units.places) {
                    place.of.unit = of;
                    place.enters.iter_mut().zip(enters).for_each(|((_, by), unit)| by.unit = unit);
                }
            }
            Err(mut mistakes) => {
                if !speaks_of_units(spec) {
                    mistakes.iter_mut().for_each(|m| m.severity = Severity::Warning);
                }
                checker.diagnostics.extend(mistakes);
            }
        }
    }
    let diagnostics = std::mem::take(&mut checker.diagnostics);
    if diagnostics.iter().any(Diagnostic::is_error) {
        return Err(diagnostics);
    }
    let case = Case {
        system,
        records,
        learn: spec.learn.clone(),
        laws: checker.laws,
        searches: checker.searches,
        requirements: vec![],
        without_laws: None,
        // Texts that a program has changed are checked often, and their results ask for no more.
        with_constants: if measured {
            with_constants(spec, source, checker.timing).map(Arc::new)
        } else {
            None
        },
    };
    Ok((case, diagnostics))
}

/// The system with its held constants as parameters.
fn with_constants(spec: &Spec, source: SourceId, mut timing: HashSet<String>) -> Option<System> {
    // A period may be an expression of constants.
    while let Some(more) = spec.constants.iter().find_map(|(name, constant)| {
        let ConstantSpec::Expression(text) = constant else { return None };
        let ast = parse(&text.value).ok().filter(|_| timing.contains(&name.value))?;
        let own: Vec<String> = ast.names().map(|(name, _)| name.to_owned()).collect();
        own.iter().any(|name| !timing.contains(name)).then_some(own)
    }) {
        timing.extend(more);
    }
    let mut freed = spec.clone();
    let of_records = |name: &Text| spec.data.iter().flat_map(DataSpec::constants).any(|(n, _)| n == name);
    let mut held = vec![];
    for (name, constant) in &mut freed.constants {
        let ConstantSpec::Number { value, unit } = constant else { continue };
        if value.value == 0.0 || of_records(name) || timing.contains(&name.value) {
            continue;
        }
        held.push(name.value.clone());
        *constant = ConstantSpec::Find(Find {
            within: (value.clone(), value.clone()),
            span: value.span,
            start: value.clone(),
            unit: unit.clone(),
            sigma: None,
            each: false,
        });
    }
    let mut checker = Checker::new(source, &spec.files);
    let mut system = checker.system(&freed);
    let sound = !checker.diagnostics.iter().any(Diagnostic::is_error);
    let estimated = !system.terms.is_empty() || system.parameters.len() > held.len();
    system.parameters.sort_by_key(|p| held.contains(&p.name));
    (sound && estimated && !held.is_empty()).then_some(system)
}

/// Plans every record of a spec.
fn plan_records(checker: &mut Checker, spec: &Spec, system: &System) -> Vec<RecordPlan> {
    let mut plans = Vec::new();
    for (k, data) in spec.data.iter().enumerate() {
        let plan = match data {
            DataSpec::Csv(csv) => checker.csv(csv, spec, system),
            DataSpec::Synthetic(synthetic) => checker.synthetic(k, synthetic, spec, system),
        };
        plans.extend(plan);
    }
    plans
}
/// What is wrong with names that are declared, each with what it stands for: no name, a name of the language,
/// a name that stands twice.
pub(crate) fn declared_names<'n>(
    source: SourceId,
    names: impl IntoIterator<Item = (&'n Text, &'static str)>,
) -> Vec<Diagnostic> {
    let mut checker = Checker::new(source, &Files::default());
    for (name, what) in names {
        checker.declare(name, what);
    }
    checker.diagnostics
}
