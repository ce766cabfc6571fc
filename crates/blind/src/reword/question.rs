//! A question to the program: a spec, and the tables that its records read.

use super::format::Format;
use crate::folder::Folder;
use crate::names::substitute;
use anyhow::Result;
use phisindy_expr::Span;
use phisindy_phys::SourceId;
use phisindy_phys::spec::{self, ColumnSpec, ConstantSpec, CsvSpec, DataSpec, DeriveSpec, Spec, Text};
use phisindy_phys::splice;
use std::collections::BTreeMap;
use std::fs;

pub(super) const SPEC: &str = "spec.ron";

/// A table as it stands in a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sheet {
    pub(super) heads: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
    pub(super) format: Format,
}

/// A spec, and its tables by the names of their files.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Question {
    pub(super) command: &'static str,
    pub(super) spec: String,
    pub(super) sheets: BTreeMap<String, Sheet>,
    /// A quantity whose column has steps: so many in a millimetre.
    pub(super) counts: Option<(String, f64)>,
}

impl Question {
    /// What the spec says; none where nobody would understand it.
    pub(super) fn read(&self) -> Option<Spec> {
        spec::read(&self.spec, SourceId(0)).ok().map(|(spec, _)| spec)
    }

    /// Writes the files.
    ///
    /// # Errors
    /// One cannot be written.
    pub(super) fn write(&self, folder: &Folder) -> Result<()> {
        folder.write(SPEC, &self.spec)?;
        for (name, sheet) in &self.sheets {
            fs::write(folder.path().join(name), sheet.format.written(sheet)?)?;
        }
        Ok(())
    }

    /// With a value of the spec set.
    pub(super) fn set(mut self, path: &[&str], value: &str) -> Option<Question> {
        self.spec = splice::set_at(&self.spec, path, value).ok()?;
        Some(self)
    }

    /// With these places of the spec rewritten.
    pub(super) fn edited(mut self, mut places: Vec<(Span, String)>) -> Question {
        places.sort_by_key(|(span, _)| std::cmp::Reverse(span.start));
        places.dedup_by_key(|(span, _)| span.start);
        places.iter().for_each(|(span, text)| self.spec.replace_range(span.range(), text));
        self
    }

    /// With every number of a quantity's columns rewritten: the index of its record and its text.
    pub(super) fn rewrite(
        &mut self,
        quantity: &str,
        spec: &Spec,
        mut to: impl FnMut(&str) -> Option<String>,
    ) -> Option<()> {
        let mut done = Vec::new();
        for record in records(spec) {
            let Some(column) = heading(record, quantity) else { continue };
            let at = (record.path.value.clone(), column.header.value.clone());
            if done.contains(&at) {
                continue;
            }
            let sheet = self.sheets.get_mut(&at.0)?;
            let k = sheet.heads.iter().position(|head| *head == at.1)?;
            for row in &mut sheet.rows {
                row[k] = to(&row[k])?;
            }
            done.push(at);
        }
        (!done.is_empty()).then_some(())
    }
}

/// The column of a quantity, or of the time `t`.
pub(super) fn heading<'r>(record: &'r CsvSpec, quantity: &str) -> Option<&'r ColumnSpec> {
    let column = record.columns.iter().find(|(name, _)| name.value == quantity).map(|(_, column)| column);
    column.or((quantity == TIME).then_some(&record.time))
}

/// The name of time in expressions.
pub(super) const TIME: &str = "t";

pub(super) fn records(spec: &Spec) -> impl Iterator<Item = &CsvSpec> {
    spec.data.iter().filter_map(|data| match data {
        DataSpec::Csv(csv) => Some(&**csv),
        DataSpec::Synthetic(_) => None,
    })
}

/// An expression with other names.
pub(super) fn put(text: &str, with: &[(String, String)]) -> String {
    substitute(text, |name| with.iter().find(|(old, _)| old == name).map(|(_, new)| new.as_str()))
}

/// All expressions of a spec.
pub(super) fn expressions(spec: &Spec) -> Vec<&Text> {
    let constants = spec.constants.iter().filter_map(|(_, constant)| match constant {
        ConstantSpec::Expression(text) | ConstantSpec::MaxAbs(text) => Some(text),
        _ => None,
    });
    let unknown = spec.unknown.iter().flat_map(|(_, u)| {
        u.factor.iter().chain(&u.candidates).chain(u.within.iter().map(|(name, _)| name)).chain(&u.search)
    });
    constants
        .chain(spec.outputs.iter().map(|(_, output)| &output.reads))
        .chain([&spec.definitions, &spec.known, &spec.inertia].into_iter().flatten().map(|(_, text)| text))
        .chain(unknown)
        .chain(&spec.contacts)
        .chain(spec.places.iter().map(|(_, place)| &place.of))
        .collect()
}

/// Every place where a name of the spec stands alone, as a key or in a record.
pub(super) fn names(spec: &Spec) -> Vec<&Text> {
    let keys = spec.constants.iter().map(|(name, _)| name);
    let states = spec.states.iter().chain(&spec.inputs).map(|(name, _)| name);
    let rates = [&spec.definitions, &spec.known, &spec.inertia].into_iter().flatten().map(|(name, _)| name);
    let records = records(spec).flat_map(|r| {
        let derived = r.derive.iter().flat_map(|(name, DeriveSpec::Derivative(of, _))| [name, of]);
        (r.columns.iter().map(|(name, _)| name))
            .chain(derived)
            .chain(r.sensors.iter().map(|(name, _)| name))
            .chain(r.start.iter().map(|(name, _)| name))
            .chain(r.constants.iter().map(|(name, _)| name))
            .chain(r.interpolate.iter().map(|(name, _)| name))
            .chain(r.detrend.iter().map(|(name, _)| name))
    });
    keys.chain(states)
        .chain(spec.outputs.iter().map(|(name, _)| name))
        .chain(rates)
        .chain(spec.unknown.iter().map(|(name, _)| name))
        .chain(records)
        .collect()
}
