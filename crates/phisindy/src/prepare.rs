//! From a case and its records to what the crates below work on: a text that describes the records too, checked, and the records in SI.

use crate::case::Case;
use crate::error::{Error, SpecError};
use crate::laws::Catalogue;
use crate::record::{Data, Record, RecordError};
use phisindy_gap::{asked, written_in};
use phisindy_phys::spec::{Spec, read_without_data};
use phisindy_phys::{
    self as phys, Diagnostic, Origin, RecordPlan, SourceId, Sources, Table, Units, check, splice, suspicions,
};
use phisindy_sim::{Trajectory, synthesize};

/// The texts that were read, and what is odd about them.
#[derive(Default)]
pub(crate) struct Texts {
    pub(crate) sources: Sources,
    pub(crate) warnings: Vec<Diagnostic>,
}

/// A case with its records.
pub(crate) struct Prepared {
    /// The spec with an entry of `data` for each record.
    pub(crate) text: String,
    pub(crate) spec: Spec,
    pub(crate) case: phys::Case,
    /// In the order in which they were given.
    pub(crate) records: Vec<phys::Record>,
    /// For each record, if it is synthetic: what it would be without noise.
    pub(crate) truths: Vec<Option<Trajectory>>,
    /// What is odd about the text and the records.
    pub(crate) doubts: Vec<String>,
}

/// Reads and checks a text, which is `name` in messages.
pub(crate) fn spec_of(text: &str, name: &str, texts: &mut Texts) -> Result<(Spec, phys::Case), SpecError> {
    let source = texts.sources.add(name, text);
    let mistakes = |diagnostics: Vec<Diagnostic>, texts: &Texts| SpecError::new(diagnostics, texts.sources.clone());
    let (spec, warnings) = read_without_data(text, source).map_err(|d| mistakes(d, texts))?;
    texts.warnings.extend(warnings);
    let (case, warnings) = check(&spec, source).map_err(|d| mistakes(d, texts))?;
    texts.warnings.extend(warnings);
    Ok((spec, case))
}

impl Prepared {
    /// A case with these records.
    pub(crate) fn new(case: &Case, records: &[Record]) -> Result<Prepared, Error> {
        if records.is_empty() {
            return Err(RecordError::NoRecords.into());
        }
        let entries: Vec<String> = records.iter().enumerate().map(|(k, record)| record.entry(k)).collect();
        let text = splice::set(&case.text, "data", &format!("[{}]", entries.join(", ")))?;
        let mut texts = Texts::default();
        let (spec, checked) = spec_of(&text, "spec (with its records)", &mut texts)?;
        let source = SourceId(texts.sources.files.len() - 1);
        let mut prepared = Prepared { text, spec, case: checked, records: vec![], truths: vec![], doubts: vec![] };
        let plans = prepared.case.records.clone();
        for (record, plan) in records.iter().zip(&plans) {
            let made = prepared.made(record, plan, source);
            let (record, truth) = made.map_err(|made| made.into_error(&texts.sources))?;
            let odd = suspicions(&prepared.case.system, &record);
            prepared.doubts.extend(odd.into_iter().map(|what| format!("{}: {what}", record.name)));
            prepared.records.push(record);
            prepared.truths.push(truth);
        }
        let of_text = texts.warnings.iter().map(|d| d.message.clone());
        prepared.doubts.splice(0..0, of_text);
        Ok(prepared)
    }

    /// The same, to be compared with a model: each record measures a state.
    pub(crate) fn measured(case: &Case, records: &[Record]) -> Result<Prepared, Error> {
        let prepared = Prepared::new(case, records)?;
        match prepared.records.iter().position(|r| r.columns.iter().all(Option::is_none)) {
            Some(record) => Err(RecordError::NoState { record }.into()),
            None => Ok(prepared),
        }
    }

    fn made(
        &self,
        record: &Record,
        plan: &RecordPlan,
        source: SourceId,
    ) -> Result<(phys::Record, Option<Trajectory>), NotMade> {
        let system = &self.case.system;
        match (&record.data, &plan.origin) {
            (Data::Columns { time, columns }, Origin::Csv(csv)) => {
                let units = Units::of(csv, system);
                let si = columns.iter().zip(&units.columns).map(|((_, values), unit)| {
                    let scale = unit.scale();
                    values.iter().map(|x| scale.converted(*x)).collect()
                });
                let extent = time.first().copied().zip(time.last().copied());
                let table = Table { time: time.clone(), columns: si.collect(), lines: vec![], extent };
                let record = phys::Record::from_table(plan, &table, system, source).map_err(NotMade::Spec)?;
                Ok((record, None))
            }
            (Data::Synthetic { seed, .. }, Origin::Synthetic(truth)) => {
                let no_file = |_: &phys::spec::InputSpec| Err("an input from a file is not read here".to_owned());
                let made = synthesize(plan, truth, system, *seed, &no_file);
                let (record, truth) = made.map_err(|error| {
                    NotMade::Other(Error::Synthetic { record: plan.name.clone(), error })
                })?;
                Ok((record, Some(truth)))
            }
            // The entries of the text are those of the records, in their order.
            _ => Err(NotMade::Other(RecordError::NoRecords.into())),
        }
    }

    /// The same with the laws that `unknown` names written into the model, their numbers started where the records say.
    pub(crate) fn with_laws(self, catalogue: &Catalogue) -> Result<Prepared, Error> {
        if self.case.laws.is_empty() {
            return Ok(self);
        }
        let mut texts = Texts::default();
        let source = texts.sources.add("spec (with its records)", self.text.clone());
        let effects = asked(&self.case, &catalogue.entries, source)
            .map_err(|mistakes| SpecError::new(mistakes, texts.sources.clone()))?;
        let laws = self.case.laws.clone();
        let draft = written_in(&self.text, self.case, self.records, &effects, &catalogue.entries)
            .map_err(|why| Error::Laws(why.to_string()))?;
        let (spec, case) = spec_of(&draft.text, "spec (its laws written out)", &mut texts)?;
        Ok(Prepared {
            text: draft.text,
            spec,
            case: phys::Case { laws, ..case },
            records: draft.records,
            truths: self.truths,
            doubts: self.doubts,
        })
    }
}

/// Why a record cannot be made.
enum NotMade {
    Spec(Vec<Diagnostic>),
    Other(Error),
}

impl NotMade {
    fn into_error(self, sources: &Sources) -> Error {
        match self {
            NotMade::Spec(mistakes) => SpecError::new(mistakes, sources.clone()).into(),
            NotMade::Other(error) => error,
        }
    }
}
