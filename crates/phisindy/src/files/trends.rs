//! The trends that `detrend` takes off, shared by the records of one file.

use phisindy_phys::spec::CsvSpec;
use phisindy_phys::{Note, Table, Units};
use phisindy_signal::{Detrend, Trend};

/// Trends of the columns met so far. The windows of a file share the trend of the first one: a window that
/// continues another one would
/// begin with a jump if each had its own, and a Validate window must not be fitted, not even to a line.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trends {
    found: Vec<(Key, Trend)>,
}

/// A column of a file: its path and sheet, its selected rows, its heading, and the kind of its trend.
type Key = ((String, Option<String>), Vec<(String, f64)>, String, Detrend);

impl Trends {
    /// Takes off what the record asks for; returns what was done.
    pub(crate) fn take_off(&mut self, csv: &CsvSpec, units: &Units, table: &mut Table) -> Vec<Note> {
        let mut done = Vec::new();
        for (name, kind) in &csv.detrend {
            // That there is one was checked when the spec was read.
            let Some(k) = csv.columns.iter().position(|(n, _)| n.value == name.value) else { continue };
            let run = csv.run.iter().map(|run| ("run".to_owned(), run.value as f64));
            let rows = csv.rows.iter().map(|(n, v)| (n.value.clone(), v.value)).chain(run).collect();
            let sheet = csv.sheet.as_ref().map(|sheet| sheet.value.clone());
            let key = ((csv.path.value.clone(), sheet), rows, csv.columns[k].1.header.value.clone(), *kind);
            let values = &mut table.columns[k];
            let known = self.found.iter().find(|(other, _)| *other == key).map(|(_, trend)| *trend);
            let trend = known.unwrap_or_else(|| Trend::of(&table.time, values, *kind));
            trend.remove(&table.time, values);
            if let Some(Some(own)) = table.own.get_mut(k) {
                trend.remove(&own.time, &mut own.values);
            }
            let factor = units.columns[k].factor;
            done.push(Note::Detrended {
                column: name.value.clone(),
                unit: csv.columns[k].1.unit.as_ref().map(|u| u.value.clone()),
                trend: Trend { offset: trend.offset / factor, slope: trend.slope / factor, ..trend },
                shared: known.is_some(),
            });
            if known.is_none() {
                self.found.push((key, trend));
            }
        }
        done
    }
}
