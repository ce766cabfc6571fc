//! Columns in memory in the place of a file.

use phisindy_import::{DataFile, record};
use phisindy_phys::spec::CsvSpec;
use phisindy_phys::{Diagnostic, SourceId, Sources, Table, Units};
use std::fmt::Write;

/// The columns that a file would have: headings, and numbers in the units that the record states for them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns(pub Vec<(String, Vec<f64>)>);

impl Columns {
    /// The columns of the record `csv`, as its file would give them: rows, window and decimation included.
    ///
    /// # Errors
    /// The columns differ in length, one is missing, or a number makes no sense.
    pub(crate) fn read(
        &self,
        csv: &CsvSpec,
        units: &Units,
        spec: SourceId,
        sources: &mut Sources,
    ) -> Result<(Table, Vec<Diagnostic>), Vec<Diagnostic>> {
        let used = self.used(csv);
        let rows = self.0.first().map_or(0, |(_, values)| values.len());
        if let Some((name, values)) = self.0.iter().find(|(_, values)| values.len() != rows) {
            let message =
                format!("the column `{name}` has {} rows, `{}` has {rows}", values.len(), self.0[0].0);
            return Err(vec![Diagnostic::error(message).at(spec, csv.path.span, "the table of this record")]);
        }
        let text = text(&used, rows);
        // The table is plain, however the file of the spec may be written.
        let plain = CsvSpec { separator: None, decimal: None, header: Some(true), skip: 0, ..csv.clone() };
        let name = csv.name.as_ref().map_or("the table", |name| &name.value);
        record(&plain, units, DataFile::of_bytes(name, text.as_bytes()), spec, sources)
    }

    /// The columns that the record needs; all of them where one of those is not there or there twice, for a
    /// message to name them.
    fn used(&self, csv: &CsvSpec) -> Vec<&(String, Vec<f64>)> {
        let once = |heading: &str| self.0.iter().filter(|(name, _)| name == heading).count() == 1;
        let all = !headings(csv).all(once);
        self.0.iter().filter(|(name, _)| all || headings(csv).any(|heading| heading == name)).collect()
    }
}

/// The headings of the columns that a record needs: its time, what it measures, and what chooses its rows.
pub(crate) fn headings(csv: &CsvSpec) -> impl Iterator<Item = &str> {
    let time = csv.rate.is_none().then_some(&csv.time.header);
    let columns = csv.columns.iter().map(|(_, column)| &column.header);
    let rows = csv.rows.iter().map(|(heading, _)| heading);
    time.into_iter().chain(columns).chain(rows).map(|heading| heading.value.as_str())
}

/// A line for the headings and one for each row; the shortest text of a number reads back as the same bits.
fn text(columns: &[&(String, Vec<f64>)], rows: usize) -> String {
    let mut text = String::with_capacity((rows + 1) * columns.len() * 20);
    for (k, (name, _)) in columns.iter().enumerate() {
        let plain = name.replace(['"', '\t', '\n', '\r'], " ");
        let _ = write!(text, "{}\"{plain}\"", if k > 0 { "\t" } else { "" });
    }
    for row in 0..rows {
        for (k, (_, values)) in columns.iter().enumerate() {
            let _ = write!(text, "{}{:?}", if k > 0 { '\t' } else { '\n' }, values[row]);
        }
    }
    text.push('\n');
    text
}
