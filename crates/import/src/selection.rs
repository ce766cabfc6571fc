//! The rows of a file that a record takes: `rows`, `run`, `window`, `decimate`. Independent of the format.

use phisindy_phys::spec::CsvSpec;
use phisindy_phys::{Diagnostic, SourceId, Table};
use phisindy_signal::Blocks;

/// Fewest rows of a record.
pub(crate) const FEWEST: usize = 10;
/// Most samples of a record: a fit evaluates each of them about a thousand times.
const MOST: usize = 2_000_000;

/// Where a row lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Admission {
    /// In the record.
    Inside,
    /// Before its window.
    Before,
    /// Elsewhere.
    Outside,
}

/// Receives the rows of a file in order and keeps those of the record.
pub(crate) struct Selection<'a> {
    csv: &'a CsvSpec,
    blocks: Option<Blocks>,
    table: Table,
    /// Number of rows so far that `rows` selects.
    counted: u64,
    /// Number of the run of the last row, and the time of that row.
    run: u64,
    previous: Option<f64>,
}

impl<'a> Selection<'a> {
    /// A selection without rows.
    pub(crate) fn new(csv: &'a CsvSpec) -> Selection<'a> {
        Selection {
            csv,
            blocks: csv.decimate.as_ref().map(|d| Blocks::new(d.value as usize)),
            table: Table { columns: vec![vec![]; csv.columns.len()], ..Table::default() },
            counted: 0,
            run: 0,
            previous: None,
        }
    }

    /// Number of rows so far that `rows` selects.
    pub(crate) fn counted(&self) -> u64 {
        self.counted
    }

    /// Time of the next row in seconds, if the record states a rate.
    pub(crate) fn counted_time(&self) -> f64 {
        self.counted as f64 / self.csv.rate.as_ref().map_or(1.0, |rate| rate.value)
    }

    /// Where a row that `rows` selects lies, by the run and the window of the record; `time` is in seconds,
    /// whatever the unit of the file.
    pub(crate) fn admits(&mut self, time: f64) -> Admission {
        self.counted += 1;
        if let Some(wanted) = &self.csv.run {
            self.run += u64::from(self.previous.replace(time).is_some_and(|before| time < before));
            if self.run != wanted.value {
                return Admission::Outside;
            }
        }
        let extent = self.table.extent.get_or_insert((time, time));
        *extent = (extent.0.min(time), extent.1.max(time));
        let Some((from, to)) = &self.csv.window else { return Admission::Inside };
        if (from.value..=to.value).contains(&time) {
            return Admission::Inside;
        }
        // Means of rows have times of their own.
        let lead = time < from.value && self.csv.decimate.is_none();
        if lead && self.table.time.is_empty() { Admission::Before } else { Admission::Outside }
    }

    /// Keeps a row before the window; one whose time is not later ends what is known of it. Of too many the later
    /// ones are kept.
    pub(crate) fn push_before(&mut self, time: f64, row: &[f64]) {
        let (times, columns) = &mut self.table.before;
        if times.len() == MOST {
            times.drain(..MOST / 2);
            columns.iter_mut().for_each(|column| drop(column.drain(..MOST / 2)));
        }
        if times.last().is_some_and(|last| time <= *last) {
            times.clear();
            columns.clear();
        }
        columns.resize(row.len(), vec![]);
        times.push(time);
        columns.iter_mut().zip(row).for_each(|(column, x)| column.push(*x));
    }

    /// Keeps an admitted row; `time` and `row` are in SI, `number` is its line in the file.
    ///
    /// # Errors
    /// The record has too many samples.
    pub(crate) fn push(&mut self, time: f64, row: &[f64], number: usize) -> Result<(), SelectionError> {
        let sample = match &mut self.blocks {
            Some(blocks) => blocks.push(time, row),
            None => Some((time, row)),
        };
        let Some((time, row)) = sample else { return Ok(()) };
        let table = &mut self.table;
        if table.time.len() == MOST {
            return Err(SelectionError::TooMany { extent: table.extent });
        }
        table.time.push(time);
        table.lines.push(number);
        table.columns.iter_mut().zip(row).for_each(|(column, x)| column.push(*x));
        Ok(())
    }

    /// Leaves an admitted row out: it lacks a value.
    pub(crate) fn omit(&mut self) {
        self.table.omitted += 1;
    }

    /// The rows that were kept.
    ///
    /// # Errors
    /// The file lacks the run, or has too few rows.
    pub(crate) fn finish(self) -> Result<Table, SelectionError> {
        let csv = self.csv;
        if csv.run.as_ref().is_some_and(|run| run.value > self.run) {
            return Err(SelectionError::NoRun { runs: self.run + 1 });
        }
        // `Record::from_table` reports too few rows in a window or after decimation, with the extent of the
        // file.
        let rows = self.table.time.len();
        if rows < FEWEST && csv.window.is_none() && csv.decimate.is_none() {
            return Err(SelectionError::TooFew { rows });
        }
        Ok(self.table)
    }
}

/// Why the rows of a file form no record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SelectionError {
    /// The file has this number of runs, fewer than the record needs.
    NoRun { runs: u64 },
    /// Only this number of rows is left.
    TooFew { rows: usize },
    /// The record has more than [`MOST`] samples; first and last time so far.
    TooMany { extent: Option<(f64, f64)> },
}

impl SelectionError {
    /// As a diagnostic that points to the record; `fraction_read` is the fraction of the file that was read.
    pub(crate) fn diagnostic(
        &self,
        csv: &CsvSpec,
        name: &str,
        spec: SourceId,
        fraction_read: f64,
    ) -> Diagnostic {
        let in_spec = |message: String, at| Diagnostic::error(message).at(spec, at, "asked for here");
        match *self {
            SelectionError::NoRun { runs } => {
                let (wanted, at) = csv.run.as_ref().map_or((0, csv.path.span), |run| (run.value, run.span));
                in_spec(format!("`{name}` has {runs} runs, so none has the number {wanted}"), at)
                    .help("runs are counted from 0; a new one begins where the time goes back")
            }
            SelectionError::TooFew { rows } => {
                let count = match rows {
                    0 => "no row".to_owned(),
                    1 => "one row".to_owned(),
                    n => format!("{n} rows"),
                };
                let d = match (csv.rows.first(), csv.rows.last()) {
                    (Some((first, _)), Some((_, last))) => {
                        let is = if rows > 1 { "are" } else { "is" };
                        in_spec(format!("{count} of `{name}` {is} selected"), first.span.to(last.span))
                            .help("`rows` keeps the rows where every one of these columns has the given value: change the values")
                    }
                    _ => in_spec(format!("the data file `{name}` has {count} of numbers"), csv.path.span),
                };
                d.help("a record needs at least 10 rows")
            }
            SelectionError::TooMany { extent } => {
                let at = csv.window.as_ref().map_or(csv.path.span, |(a, b)| a.span.to(b.span));
                let d =
                    in_spec(format!("`{name}` has more than {} samples for one record", grouped(MOST)), at);
                // Twenty thousand samples are sufficient for a model with a dozen unknowns.
                let now = csv.decimate.as_ref().map_or(1, |d| d.value) as f64;
                let every = (now * MOST as f64 / fraction_read.max(1e-6) / 20_000.0).ceil();
                let d = d.help(format!(
                    "take the mean of every {every} rows, for about 20 000 samples: `decimate: {every}`"
                ));
                let Some((first, last)) = extent else { return d };
                let end = first + 0.01 * (last - first);
                d.help(format!("or take a part: `window: ({first:?}, {end:?})` would do"))
            }
        }
    }
}

/// 2000000 as `2 000 000`.
fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let pieces: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|p| std::str::from_utf8(p).ok()).collect();
    pieces.join(" ")
}
