//! A checked spec with its records, wherever they come from.

use crate::error::{Error, SpecError};
use crate::laws::Catalogue;
use phisindy_gap::{
    Activity, Effect, GapError, WithFormulas, WrittenLaw, requested_formulas, requested_laws, with_formulas,
    written_out,
};
use phisindy_phys::spec::Spec;
use phisindy_phys::{
    Case, Diagnostic, Files, LawEntry, Origin, Record, RecordPlan, Requirement, SourceId, Sources,
};
use phisindy_report::Input;
use phisindy_sim::Trajectory;
use std::ops::ControlFlow;
use std::sync::Arc;

/// A checked spec with its records, from memory or from files: what [`crate::identify`], [`crate::gap`] and
/// [`crate::simulate`] work on.
#[derive(Clone)]
pub struct Loaded {
    /// What the spec is called in messages: its path as it was given, or `the spec`.
    pub spec: String,
    /// Its text with every assignment, as it was given.
    pub given: String,
    /// The same with an entry of `data` for each record, and with the laws and formulas that `unknown` asks for.
    pub text: String,
    /// The text, read.
    pub parsed: Spec,
    /// The checked spec.
    pub case: Case,
    /// In the order of the spec.
    pub records: Vec<Record>,
    /// For each record, if it is synthetic: what it would be without noise.
    pub truths: Vec<Option<Trajectory>>,
    /// What was odd about the spec and its data, in words.
    pub doubts: Vec<String>,
}

impl Loaded {
    /// What a report needs of it.
    pub fn input(&self) -> Input<'_> {
        Input {
            name: &self.spec,
            text: &self.text,
            spec: &self.parsed,
            case: &self.case,
            records: &self.records,
            doubts: &self.doubts,
        }
    }

    /// The same with the formulas that `unknown` asks for: found in the records, and written into the model.
    /// `None` if it asks for none. Where no formula explains the records, a doubt says so. `observe` receives
    /// the progress as a fraction and an activity, and may stop the search.
    ///
    /// # Errors
    /// A formula is asked for where no force acts, or the model cannot be fitted without it.
    pub fn with_formulas(
        &self,
        observe: &mut (dyn FnMut(f64, &str) -> ControlFlow<()> + Send),
    ) -> Result<Option<Loaded>, Error> {
        if self.parsed.unknown.iter().all(|(_, unknown)| unknown.search.is_empty()) {
            return Ok(None);
        }
        let mut sources = Sources::default();
        let source = sources.add(self.spec.clone(), self.text.clone());
        let requested = requested_formulas(&self.case, source)
            .map_err(|mistakes| SpecError::new(mistakes, sources.clone()))?;
        let mut stopped = false;
        let mut tell = |part: f64, what: Activity| {
            let flow = observe(part, &what.to_string());
            stopped |= flow.is_break();
            flow
        };
        let records = self.records.clone();
        let found = with_formulas(&self.text, self.case.clone(), records, &requested, &mut tell);
        let WithFormulas { text, records, without } = found.map_err(GapError::Numerics)?;
        let source = sources.add(format!("{} (with its formulas)", self.spec), text.clone());
        let (parsed, mut case, _) = checked(&text, source, &self.parsed.files)
            .map_err(|mistakes| SpecError::new(mistakes, sources.clone()))?;
        let Case { laws, searches, requirements, system, without_laws, .. } = self.case.clone();
        let without_laws = without_laws.or_else(|| Some(Arc::new(system)));
        // The model with its formulas has a graph of its own.
        let requirements = requirements.iter().filter_map(|r| r.of(&mut case.system)).collect();
        let mut doubts = self.doubts.clone();
        doubts.extend(without.iter().map(|what| {
            if stopped {
                return format!("the search for a formula in {what} was stopped before its end");
            }
            format!("no formula in {what} explains the records; `phisindy gap` shows what the missing force depends on")
        }));
        let case = Case { laws, searches, requirements, without_laws, ..case };
        let (spec, given, truths) = (self.spec.clone(), self.given.clone(), self.truths.clone());
        Ok(Some(Loaded { spec, given, text, parsed, case, records, truths, doubts }))
    }

    /// The plans of the records that are simulated: of a model with an unknown part the synthetic ones.
    pub fn simulated(&self) -> impl Iterator<Item = &RecordPlan> {
        let open = self.case.is_open();
        self.case.records.iter().filter(move |p| !open || matches!(p.origin, Origin::Synthetic(_)))
    }

    /// To be simulated with one of its records alone.
    ///
    /// # Errors
    /// There is none of this name or place.
    pub fn only(mut self, record: &str) -> Result<Loaded, Diagnostic> {
        let k = record_named(record, self.records.iter().map(|r| r.name.as_str()))?;
        let plan = self.simulated().nth(k).cloned();
        self.case.records = plan.into_iter().collect();
        self.records = vec![self.records.swap_remove(k)];
        self.truths = vec![self.truths.swap_remove(k)];
        Ok(self)
    }
}

/// Which of these records is meant, by its name or its place.
///
/// # Errors
/// None of them.
pub fn record_named<'a>(
    wish: &str,
    names: impl Iterator<Item = &'a str> + Clone,
) -> Result<usize, Diagnostic> {
    let place = || wish.parse().ok().filter(|k| *k < names.clone().count());
    names.clone().position(|name| name == wish).or_else(place).ok_or_else(|| {
        let all: Vec<String> = names.clone().enumerate().map(|(k, name)| format!("{k} `{name}`")).collect();
        Diagnostic::error(format!("there is no record `{wish}`"))
            .help(format!("there is: {}", all.join(", ")))
    })
}

/// Form first, then meaning.
pub(crate) fn checked(
    text: &str,
    source: SourceId,
    files: &Files,
) -> Result<(Spec, Case, Vec<Diagnostic>), Vec<Diagnostic>> {
    let (spec, mut warnings) = phisindy_phys::spec::read_with_files(text, source, files)?;
    match phisindy_phys::check(&spec, source) {
        Ok((case, more)) => {
            warnings.extend(more);
            Ok((spec, case, warnings))
        }
        Err(mistakes) => {
            warnings.extend(mistakes);
            Err(warnings)
        }
    }
}

/// The laws that `unknown` names.
pub(crate) struct Laws {
    effects: Vec<Effect>,
    catalogue: Vec<LawEntry>,
}

impl Laws {
    /// Those of a case.
    ///
    /// # Errors
    /// A law that the catalogue does not have, or that cannot act there.
    pub(crate) fn of(case: &Case, catalogue: &Catalogue, source: SourceId) -> Result<Laws, Vec<Diagnostic>> {
        let catalogue = catalogue.laws().to_vec();
        Ok(Laws { effects: requested_laws(case, &catalogue, source)?, catalogue })
    }

    /// The spec with its laws written out, their numbers started where `records` say; none of them need be
    /// there.
    ///
    /// # Errors
    /// The spec cannot hold a law. Diagnostics are added to `found`, new warnings too.
    pub(crate) fn written(
        self,
        loaded: Loaded,
        records: Vec<Record>,
        sources: &mut Sources,
        found: &mut Vec<Diagnostic>,
    ) -> Result<Loaded, NotWritten> {
        let laws = loaded.case.laws.clone();
        let without_laws = Some(Arc::new(loaded.case.system.clone()));
        let draft = written_out(&loaded.text, loaded.case, records, &self.effects, &self.catalogue);
        let draft = draft.map_err(|why| {
            found.push(Diagnostic::error(format!(
                "the laws of `unknown` cannot be written into the model: {why}"
            )));
            NotWritten
        })?;
        let source = sources.add(format!("{} (its laws written out)", loaded.spec), draft.text.clone());
        let (parsed, mut case, warnings) =
            checked(&draft.text, source, &loaded.parsed.files).map_err(|mistakes| {
                found.extend(mistakes);
                NotWritten
            })?;
        let new: Vec<Diagnostic> =
            warnings.into_iter().filter(|w| found.iter().all(|d| d.message != w.message)).collect();
        found.extend(new);
        for WrittenLaw { entry, names } in &draft.laws {
            let LawEntry { id, law, .. } = entry;
            let need = law.needs.as_ref();
            let required =
                need.and_then(|need| Requirement::new(&mut case.system, id, need, &law.simpler, names));
            case.requirements.extend(required);
        }
        let (text, records) = (draft.text, draft.records);
        Ok(Loaded { text, parsed, case: Case { laws, without_laws, ..case }, records, ..loaded })
    }
}

/// The laws cannot be written into the spec; why is in the diagnostics.
pub(crate) struct NotWritten;
