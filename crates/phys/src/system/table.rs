//! The numbers of a record as they were read, before they are a record: is there enough of them?

use crate::system::equations::System;
use crate::system::own_times::OwnTimes;
use crate::system::plan::RecordPlan;
use crate::text::diagnostic::{Diagnostic, SourceId};
use crate::text::spec::CsvSpec;
use phisindy_signal::bounds;

/// Numbers read from a file: the selected rows (`rows`, `window`, `decimate`) of the needed columns.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// The time column (SI).
    pub time: Vec<f64>,
    /// The columns of `CsvSpec::columns`, in that order (SI).
    pub columns: Vec<Vec<f64>>,
    /// Line number of each row in the file; of a mean of rows, that of the last.
    pub lines: Vec<usize>,
    /// First and last time of `rows` in the file, in seconds, whatever the window.
    pub extent: Option<(f64, f64)>,
    /// Rows that were left out because a value is missing (`missing: Omit`).
    pub omitted: usize,
    /// Times before the window, and the columns there: what drove the rig then.
    pub before: (Vec<f64>, Vec<Vec<f64>>),
    /// The samples of an input that has times of its own, as it was sampled, before and behind the window too;
    /// `columns` holds what it is at `time`. Empty where no input has.
    pub own: Vec<Option<Samples>>,
    /// At which rows each state and output was sampled; `columns` holds what lies on straight lines elsewhere.
    pub own_times: OwnTimes,
}

/// Samples of one quantity and their times (SI).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// Strictly increasing.
    pub time: Vec<f64>,
    /// One for each time.
    pub values: Vec<f64>,
}

/// Fewer samples than this are no record.
const FEWEST: usize = 10;

/// Refuses a table with too few rows. Without columns they are only the times of a prediction.
pub(crate) fn enough(csv: &CsvSpec, table: &Table, spec: SourceId) -> Result<(), Diagnostic> {
    let fewest = if csv.columns.is_empty() { 1 } else { FEWEST };
    if table.time.len() >= fewest {
        return Ok(());
    }
    let decimated = csv.decimate.as_ref().map(|d| d.span);
    let span = csv.window.as_ref().map_or(decimated.unwrap_or(csv.path.span), |(a, b)| a.span.to(b.span));
    let mut d =
        Diagnostic::error(format!("only {} samples are left of `{}`", table.time.len(), csv.path.value))
            .at(spec, span, "");
    if csv.in_memory {
        return Err(d.help(format!("a record needs at least {fewest}")));
    }
    if let Some((first, last)) = table.extent {
        d = d.help(format!("the file's time runs from {first} s to {last} s"));
    }
    if decimated.is_some() {
        d = d.help("each of them is the mean of as many rows as `decimate` says: a record needs at least 10");
    }
    Err(d)
}

/// Refuses a column that moves by less than its sensor's step: it shows no motion.
pub(crate) fn finer(
    csv: &CsvSpec,
    table: &Table,
    plan: &RecordPlan,
    system: &System,
    spec: SourceId,
) -> Result<(), Diagnostic> {
    for (name, sensor) in &csv.sensors {
        let place = csv.columns.iter().position(|(n, _)| n.value == name.value);
        let (Some((step, _)), Some(place)) = (&sensor.quantum, place) else { continue };
        let own = system.sensor(&name.value).and_then(|k| plan.sensors[k].quantum).unwrap_or(0.0);
        let (low, high) = bounds(&table.columns[place]);
        if own > high - low {
            let message = format!(
                "the quantum of `{}` is larger than what it shows: its column moves by {:?} (SI), which is less than one step",
                name.value,
                high - low
            );
            return Err(Diagnostic::error(message)
                .at(spec, step.span, "a step of the column")
                .help("is it in the unit of the column? A plain number is in SI: write (0.1, \"mm\"), or leave it out"));
        }
    }
    Ok(())
}
