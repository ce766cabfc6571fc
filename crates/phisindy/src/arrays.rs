//! From a case and records in memory to what the crates below work on: a text that describes the records too,
//! checked, and the records in SI.

use crate::case::Case;
use crate::error::{Error, SpecError};
use crate::loaded::{Loaded, checked};
use crate::record::{Data, Record, RecordError};
use phisindy_phys::spec::{DataSpec, InputSpec};
use phisindy_phys::{
    self as phys, Diagnostic, Origin, RecordPlan, SourceId, Sources, Table, Units, splice, splice::quoted,
    suspicions,
};
use phisindy_sim::{Trajectory, synthesize};

impl Loaded {
    /// A case with these records, which take the place of its `data`. An entry `Arrays` of the text says what
    /// the record of its name is like.
    ///
    /// # Errors
    /// There are no records, or a record makes no sense with the case.
    pub fn of(case: &Case, records: &[Record]) -> Result<Loaded, Error> {
        if records.is_empty() {
            return Err(RecordError::NoRecords.into());
        }
        let text = with_entries(case, records)?;
        let mut sources = Sources::default();
        let source = sources.add("the spec with its records", text.clone());
        let wrong = |mistakes: Vec<Diagnostic>| Error::from(SpecError::new(mistakes, sources.clone()));
        let (parsed, checked, warnings) = checked(&text, source, &case.spec.files).map_err(wrong)?;
        let mut doubts: Vec<String> = warnings.into_iter().map(|d| d.message).collect();
        let (mut all, mut truths) = (vec![], vec![]);
        for (record, plan) in records.iter().zip(&checked.records) {
            let (record, truth) = match &record.data {
                Data::Columns { time, columns } => {
                    (measured(time, columns, plan, &checked, source).map_err(wrong)?, None)
                }
                Data::Synthetic { seed, .. } => {
                    let (record, truth) = synthetic(*seed, plan, &checked)?;
                    (record, Some(truth))
                }
            };
            let odd = suspicions(&checked.system, &record);
            doubts.extend(odd.into_iter().map(|what| format!("{}: {what}", record.name)));
            all.push(record);
            truths.push(truth);
        }
        let (spec, given) = ("the spec".to_owned(), text.clone());
        Ok(Loaded { spec, given, text, parsed, case: checked, records: all, truths, doubts })
    }

    /// Whether every record can be compared with a model.
    ///
    /// # Errors
    /// A record measures no state.
    pub(crate) fn comparable(&self) -> Result<(), RecordError> {
        let empty = |r: &phys::Record| r.columns.iter().all(Option::is_none);
        self.records.iter().position(empty).map_or(Ok(()), |record| Err(RecordError::NoState { record }))
    }
}

/// The text of a case with an entry of `data` for each record, and with nothing else there.
fn with_entries(case: &Case, records: &[Record]) -> Result<String, Error> {
    let own = |name: &str| {
        case.spec.data.iter().find_map(|data| match data {
            DataSpec::Csv(csv) if csv.in_memory && csv.path.value == name => {
                Some(&case.text[csv.span.range()])
            }
            _ => None,
        })
    };
    let entries: Vec<String> = records
        .iter()
        .enumerate()
        .map(|(k, record)| match &record.data {
            Data::Synthetic { entry, .. } => entry.clone(),
            Data::Columns { .. } => {
                let name = record.name_at(k);
                own(&name)
                    .map_or_else(|| format!("Arrays(name: {}, columns: [])", quoted(&name)), str::to_owned)
            }
        })
        .collect();
    let mut text = splice::set(&case.text, "data", &format!("[{}]", entries.join(", ")))?;
    for (k, record) in records.iter().enumerate() {
        if let Data::Columns { columns, .. } = &record.data {
            let names: Vec<String> = columns.iter().map(|(name, _)| quoted(name)).collect();
            text = splice::set(&text, &format!("data.{k}.columns"), &format!("[{}]", names.join(", ")))?;
        }
        for (field, value) in &record.fields {
            text = splice::set(&text, &format!("data.{k}.{field}"), value)?;
        }
    }
    Ok(text)
}

/// A record of columns in the units of the spec.
fn measured(
    time: &[f64],
    columns: &[(String, Vec<f64>)],
    plan: &RecordPlan,
    case: &phys::Case,
    source: SourceId,
) -> Result<phys::Record, Vec<Diagnostic>> {
    let Origin::Csv(csv) = &plan.origin else {
        return Err(vec![Diagnostic::error("the record of arrays is synthetic")]);
    };
    let units = Units::of(csv, &case.system);
    let si = columns.iter().zip(&units.columns).map(|((_, values), unit)| {
        let scale = unit.scale();
        values.iter().map(|x| scale.converted(*x)).collect()
    });
    let extent = time.first().copied().zip(time.last().copied());
    let table =
        Table { time: time.to_vec(), columns: si.collect(), lines: vec![], extent, ..Table::default() };
    phys::Record::from_table(plan, &table, &case.system, source)
}

fn synthetic(
    seed: Option<u64>,
    plan: &RecordPlan,
    case: &phys::Case,
) -> Result<(phys::Record, Trajectory), Error> {
    let Origin::Synthetic(truth) = &plan.origin else { return Err(RecordError::NoRecords.into()) };
    let no_file = |_: &InputSpec| Err("an input from a file is not read here".to_owned());
    synthesize(plan, truth, &case.system, seed, &no_file)
        .map_err(|error| Error::Synthetic { record: plan.name.clone(), error })
}
