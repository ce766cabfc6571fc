//! The trends that `detrend` takes off, shared by the records of one file.

use phisindy_phys::spec::CsvSpec;
use phisindy_phys::{Table, Units};
use phisindy_signal::Detrend;
use phisindy_signal::Trend;

/// Trends of the columns met so far. The windows of a file share the trend of the first one: a window that continues another one would
/// begin with a jump if each had its own, and a Validate window must not be fitted, not even to a line.
#[derive(Clone, Debug, Default)]
pub(crate) struct Trends {
    found: Vec<(Key, Trend)>,
}

/// A column of a file: its path, its selected rows, its heading, and the kind of its trend.
type Key = (String, Vec<(String, f64)>, String, Detrend);

impl Trends {
    /// Takes off what the record asks for; what was done, in words.
    pub(crate) fn take_off(&mut self, csv: &CsvSpec, units: &Units, table: &mut Table) -> Vec<String> {
        let mut done = Vec::new();
        for (name, kind) in &csv.detrend {
            // That there is one was checked when the spec was read.
            let Some(k) = csv.columns.iter().position(|(n, _)| n.value == name.value) else { continue };
            let run = csv.run.iter().map(|run| ("run".to_owned(), run.value as f64));
            let rows = csv.rows.iter().map(|(n, v)| (n.value.clone(), v.value)).chain(run).collect();
            let key = (csv.path.value.clone(), rows, csv.columns[k].1.header.value.clone(), *kind);
            let values = &mut table.columns[k];
            let known = self.found.iter().find(|(other, _)| *other == key).map(|(_, trend)| *trend);
            let trend = known.unwrap_or_else(|| Trend::of(&table.time, values, *kind));
            trend.remove(&table.time, values);
            let unit = csv.columns[k].1.unit.as_ref().map_or(String::new(), |u| format!(" {}", u.value));
            let of = if known.is_some() { ", as in the first record of this file" } else { "" };
            let factor = units.columns[k].factor;
            let (offset, slope) = (trend.offset / factor, trend.slope / factor);
            let line = if slope == 0.0 {
                format!("{offset:.6e}{unit}")
            } else {
                format!(
                    "the line {offset:.6e}{unit} at time {:.6} s, slope {slope:.3e}{unit} per s",
                    trend.at
                )
            };
            done.push(format!("`{}` without its trend: {line} is taken off (detrend{of})", name.value));
            if known.is_none() {
                self.found.push((key, trend));
            }
        }
        done
    }
}
