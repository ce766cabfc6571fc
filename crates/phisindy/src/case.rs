//! A case: the text of a spec, and what it means.

use crate::error::{Error, SpecError};
use crate::files::headings;
use crate::record::{Record, RecordError};
use phisindy_phys::spec::{DataSpec, Spec, read_in_memory};
use phisindy_phys::{self as phys, Diagnostic, Files, Sources, check, splice};
use std::fmt;

/// A checked spec. Records come from memory, so it need not have `data`.
#[derive(Clone)]
pub struct Case {
    pub(crate) text: String,
    pub(crate) spec: Spec,
    pub(crate) checked: phys::Case,
    warnings: Vec<Diagnostic>,
    sources: Sources,
}

impl Case {
    /// Reads and checks the text of a spec.
    ///
    /// # Errors
    /// All mistakes of the text.
    pub fn read(text: &str) -> Result<Case, SpecError> {
        Case::read_with(text, &Files::default())
    }

    /// As [`Case::read`], of a text that names files beside its records, as `structure` and `table(...)` do: with their
    /// numbers.
    ///
    /// ```
    /// use phisindy::{Case, Files, Numbers, named_files};
    /// let text = r#"(states: { "x": "m", "v": "m/s" }, known: { "x": "v", "v": "-table('spring.csv', x)" })"#;
    /// assert!(Case::read(text).is_err());
    /// let spring = Numbers { columns: 2, values: vec![-0.1, -30.0, 0.0, 0.0, 0.1, 50.0], headings: vec![] };
    /// let files: Files = named_files(text).into_iter().map(|file| (file, spring.clone())).collect();
    /// assert_eq!(Case::read_with(text, &files)?.states().count(), 2);
    /// # Ok::<(), phisindy::Error>(())
    /// ```
    ///
    /// # Errors
    /// All mistakes of the text and of the files, and files that are not given.
    pub fn read_with(text: &str, files: &Files) -> Result<Case, SpecError> {
        let mut sources = Sources::default();
        let source = sources.add("spec", text);
        let (spec, mut warnings) =
            read_in_memory(text, source, files).map_err(|d| SpecError::new(d, sources.clone()))?;
        let (checked, more) = check(&spec, source).map_err(|d| SpecError::new(d, sources.clone()))?;
        warnings.extend(more);
        Ok(Case { text: text.to_owned(), spec, checked, warnings, sources })
    }

    /// The case with one field of its text changed or added, as `--set PATH=VALUE` does.
    ///
    /// ```
    /// # let text = r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") }, known: { "x": "v", "v": "-k*x" })"#;
    /// let stiff = phisindy::Case::read(text)?.with("constants.k", r#"(4.0, "1/s^2")"#)?;
    /// assert!(stiff.text().contains("(4.0, \"1/s^2\")"));
    /// # Ok::<(), phisindy::Error>(())
    /// ```
    ///
    /// # Errors
    /// The path leads nowhere, or the new text has a mistake.
    pub fn with(&self, path: &str, value: &str) -> Result<Case, Error> {
        Ok(Case::read_with(&splice::set(&self.text, path, value)?, &self.spec.files)?)
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The title; empty where the text has none.
    pub fn title(&self) -> &str {
        &self.checked.system.title
    }

    /// Whether it has `Synthetic` records, which need no data and take a seed.
    pub fn has_synthetic(&self) -> bool {
        self.spec.data.iter().any(|data| matches!(data, DataSpec::Synthetic(_)))
    }

    /// Whether it has records that files hold, or tables in their place ([`crate::files::Request::tables`]).
    pub fn has_files(&self) -> bool {
        self.spec.data.iter().any(|data| data.of_file().is_some())
    }

    /// The headings that the records with files need of them, in their order: a name may come twice.
    pub fn headings(&self) -> impl Iterator<Item = &str> {
        self.spec.data.iter().filter_map(DataSpec::of_file).flat_map(headings)
    }

    /// Names of the states.
    pub fn states(&self) -> impl Iterator<Item = &str> {
        self.checked.system.states.iter().map(|s| s.name.as_str())
    }

    /// Names of the inputs.
    pub fn inputs(&self) -> impl Iterator<Item = &str> {
        self.checked.system.inputs.iter().map(|u| u.name.as_str())
    }

    /// Names of the states, outputs and inputs, each with how many SI units the unit of the spec is.
    pub fn factors(&self) -> impl Iterator<Item = (&str, f64)> {
        let system = &self.checked.system;
        system.quantities().enumerate().map(|(k, (name, _))| (name, system.factor(k)))
    }

    /// What is odd about the text, with its place.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        self.warnings.iter().map(|d| d.located(&self.sources).to_string())
    }

    /// A record of measured columns, copied from slices: `t` is the time in seconds, every other name a state
    /// or an input, in the unit that the
    /// spec states for it. The record is fitted; [`Record::validate`] keeps it for validation.
    ///
    /// # Errors
    /// There is no time, a name is unknown or repeated, columns differ in length, a number is not finite, or
    /// the time does not grow.
    pub fn record<C: AsRef<[f64]>>(&self, columns: &[(&str, C)]) -> Result<Record, RecordError> {
        let names: Vec<&str> = self.checked.system.quantities().map(|(name, _)| name).collect();
        Record::measured(columns, &names)
    }

    /// The `Synthetic` records that the text describes. `seed` replaces that of the first one; further
    /// records have seeds that follow from it.
    pub fn synthetic(&self, seed: Option<u64>) -> Vec<Record> {
        let records = self.spec.data.iter().enumerate().filter_map(|(index, data)| match data {
            DataSpec::Synthetic(synthetic) => {
                // Records of one spec must not repeat each other's noise.
                let own =
                    seed.map(|seed| seed.wrapping_add((index as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)));
                let name = self.checked.records[index].name.clone();
                Some(Record::synthetic(name, &self.text[synthetic.span.range()], own))
            }
            DataSpec::Csv(_) => None,
        });
        records.collect()
    }
}

impl fmt::Debug for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Case").field("text", &self.text).finish_non_exhaustive()
    }
}
