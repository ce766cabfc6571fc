//! Identification: which terms are in the unknown part, and with which numbers.

use crate::case::Case;
use crate::error::{Error, SpecError};
use crate::laws::Catalogue;
use crate::loaded::{Laws, Loaded, NotWritten};
use crate::options::Options;
use crate::record::Record;
use phisindy_learn::{self as learn, Estimate, FoundParameter, LearnOptions, RecordFit, Verdict};
use phisindy_phys::Sources;
use phisindy_report::{
    Ending, Folder, Format, Invocation, RunReport, Shown, StopReason, equations, spec_text,
};

/// Identifies the unknown part of a case from its records.
///
/// # Errors
/// A record makes no sense with the case, or the numerics fail altogether. A model that merely does not fit
/// is a verdict, not an error.
pub fn identify(case: &Case, records: &[Record], options: &Options<'_>) -> Result<Identified, Error> {
    Loaded::of(case, records)?.identify(options)
}

impl Loaded {
    /// As [`identify`].
    ///
    /// # Errors
    /// As [`identify`].
    pub fn identify(self, options: &Options<'_>) -> Result<Identified, Error> {
        self.comparable()?;
        let loaded = self.with_laws(options)?;
        let mut observe = |fraction: f64, activity: &str| options.progress(fraction, activity);
        let loaded = loaded.with_formulas(&mut observe)?.unwrap_or(loaded);
        let learn = LearnOptions { method: options.method, ..Default::default() };
        let mut observe = |fraction| options.progress(fraction, "");
        let (loaded, result) = loaded.identified(&learn, &mut observe)?;
        Ok(Identified { loaded, result })
    }

    /// The same with the laws that `unknown` names written into the model, if that has not been done.
    fn with_laws(self, options: &Options<'_>) -> Result<Loaded, Error> {
        // Laws that are written out stand in `unknown` no more.
        if self.parsed.unknown.iter().all(|(_, unknown)| unknown.laws.is_empty()) {
            return Ok(self);
        }
        let (mut sources, mut found) = (Sources::default(), Vec::new());
        let source = sources.add(self.spec.clone(), self.text.clone());
        let built_in;
        let catalogue = match options.laws {
            Some(laws) => laws,
            None => {
                built_in = Catalogue::built_in();
                &built_in
            }
        };
        let laws = Laws::of(&self.case, catalogue, source)
            .map_err(|mistakes| SpecError::new(mistakes, sources.clone()))?;
        let records = self.records.clone();
        laws.written(self, records, &mut sources, &mut found)
            .map_err(|NotWritten| SpecError::new(found, sources).into())
    }
}

/// What was identified. Numbers are in SI.
pub struct Identified {
    pub(crate) loaded: Loaded,
    pub(crate) result: learn::Identified,
}

/// The rate of one state.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Equation {
    /// Name of the state.
    pub state: String,
    /// The equation in LaTeX, `\dot{v} = ...`.
    pub latex: String,
    /// Its right side in the language of specs.
    pub text: String,
}

/// A candidate that is in the unknown part.
#[derive(Clone, Debug)]
pub struct Term {
    /// Name of the state whose rate it is in.
    pub state: String,
    /// As the spec has it.
    pub candidate: String,
    /// Its coefficient with standard error and 95 % interval.
    pub coefficient: Estimate,
    /// Unit of the coefficient; empty where the spec does not determine it.
    pub unit: String,
    /// Whether the coefficient ended at a bound of the spec.
    pub at_bound: bool,
}

impl Identified {
    /// The equations that have an unknown part.
    pub fn equations(&self) -> Vec<Equation> {
        let case = &self.loaded.case;
        let all = equations(case, &self.result.terms, &self.result.parameters).into_iter();
        all.map(|e| Equation {
            state: case.system.states[e.state].name.clone(),
            latex: e.latex,
            text: e.text,
        })
        .collect()
    }

    /// The equations in LaTeX, a line for each.
    pub fn latex(&self) -> String {
        self.equations().into_iter().map(|e| e.latex).collect::<Vec<_>>().join("\n")
    }

    /// The terms that were found, in the order of the spec.
    pub fn terms(&self) -> Vec<Term> {
        let system = &self.loaded.case.system;
        let term = |found: &learn::FoundTerm| {
            let term = &system.terms[found.term];
            Term {
                state: system.states[term.state].name.clone(),
                candidate: term.candidate.clone(),
                coefficient: found.coefficient,
                unit: term.unit.map_or(String::new(), |unit| unit.to_string()),
                at_bound: found.at_bound,
            }
        };
        self.result.terms.iter().map(term).collect()
    }

    /// Constants and sensors that were fitted beside the terms.
    pub fn parameters(&self) -> &[FoundParameter] {
        &self.result.parameters
    }

    /// How the model runs along each record.
    pub fn records(&self) -> &[RecordFit] {
        &self.result.records
    }

    /// Whether to believe it.
    pub fn verdict(&self) -> &Verdict {
        &self.result.verdict
    }

    /// What a careful reader should know of the text, the records and the result.
    pub fn warnings(&self) -> Vec<String> {
        let found = self.result.warnings.iter().map(ToString::to_string);
        self.loaded.doubts.iter().cloned().chain(found).collect()
    }

    /// Whether the observer stopped the work before its end.
    pub fn stopped(&self) -> bool {
        self.result.interrupted()
    }

    /// The result as `phisindy run` prints it; the work took so many seconds.
    pub fn written(&self, format: Format, seconds: f64) -> String {
        self.report(seconds, StopReason::Interrupt).written(format)
    }

    /// The files that `phisindy run --out` keeps.
    pub fn folder(&self, seconds: f64) -> Folder {
        self.folder_of(seconds, &Invocation::default(), StopReason::Interrupt)
    }

    /// The same of a command line, which the report shows as what repeats it; if the observer stopped the work, it
    /// says why.
    pub fn folder_of(&self, seconds: f64, how: &Invocation, why: StopReason) -> Folder {
        Folder::of_run(&self.report(seconds, why), self.loaded.input(), &self.result, how)
    }

    /// Each measured column of each record beside what the model says of it, in the units of the spec.
    pub fn shown(&self) -> Vec<Shown> {
        self.report(0.0, StopReason::Interrupt).shown()
    }

    fn report(&self, seconds: f64, why: StopReason) -> RunReport<'_> {
        let stopped = self.stopped().then_some(why);
        RunReport::new(self.loaded.input(), &self.result, Ending { seconds, stopped })
    }

    /// The identified model as a case: the terms stand in its known part, so that [`crate::simulate`]
    /// predicts.
    ///
    /// # Errors
    /// The text cannot hold what was identified.
    pub fn case(&self) -> Result<Case, Error> {
        Ok(Case::read_with(&self.model()?, &self.loaded.parsed.files)?)
    }

    /// The same as the text of a spec.
    pub(crate) fn model(&self) -> Result<String, Error> {
        spec_text::identified(self.loaded.input(), &self.result)
            .map_err(|why| Error::Completed(why.to_string()))
    }
}
