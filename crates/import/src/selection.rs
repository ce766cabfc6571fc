//! Which rows of a file a record takes, and what becomes of them: `rows`, `run`, `window`, `decimate`. The same for every format.

use phisindy_phys::spec::CsvSpec;
use phisindy_phys::{Diagnostic, SourceId, Table};
use phisindy_signal::Blocks;

/// Fewer rows than this are no record.
pub(crate) const FEWEST: usize = 10;
/// Most samples of a record: a fit looks at each of them a thousand times.
const MOST: usize = 2_000_000;

/// Takes the rows of a file one after the other and keeps what the record needs.
pub(crate) struct Selection<'a> {
    csv: &'a CsvSpec,
    blocks: Option<Blocks>,
    table: Table,
    /// Rows so far that `rows` selects.
    counted: u64,
    /// Which run of the file the last row belongs to, and its time.
    run: u64,
    previous: Option<f64>,
}

impl<'a> Selection<'a> {
    /// No rows yet.
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

    /// Rows so far that `rows` selects.
    pub(crate) fn counted(&self) -> u64 {
        self.counted
    }

    /// The time of the next row where a rate takes the place of a column, in seconds.
    pub(crate) fn counted_time(&self) -> f64 {
        self.counted as f64 / self.csv.rate.as_ref().map_or(1.0, |rate| rate.value)
    }

    /// Whether the row that `rows` selected, at `time` in the unit of the file, is in the run and the window of the record.
    pub(crate) fn enters(&mut self, time: f64) -> bool {
        self.counted += 1;
        if let Some(wanted) = &self.csv.run {
            self.run += u64::from(self.previous.replace(time).is_some_and(|before| time < before));
            if self.run != wanted.value {
                return false;
            }
        }
        let extent = self.table.extent.get_or_insert((time, time));
        *extent = (extent.0.min(time), extent.1.max(time));
        self.csv.window.as_ref().is_none_or(|(a, b)| (a.value..=b.value).contains(&time))
    }

    /// Keeps a row that entered, in SI; `number` is where it stands in the file.
    ///
    /// # Errors
    /// There are more samples than a fit can use.
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

    /// What was kept.
    ///
    /// # Errors
    /// The file has not the run, or too few rows.
    pub(crate) fn finish(self) -> Result<Table, SelectionError> {
        let csv = self.csv;
        if csv.run.as_ref().is_some_and(|run| run.value > self.run) {
            return Err(SelectionError::NoRun { runs: self.run + 1 });
        }
        // Too few in a window, or of `decimate`, is the business of the record.
        let rows = self.table.time.len();
        if rows < FEWEST && csv.window.is_none() && csv.decimate.is_none() {
            return Err(SelectionError::TooFew { rows });
        }
        Ok(self.table)
    }
}

/// Why the rows of a file make no record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SelectionError {
    /// The file has only so many runs.
    NoRun { runs: u64 },
    /// So few rows are left.
    TooFew { rows: usize },
    /// More than [`MOST`] samples, up to the later one of these times.
    TooMany { extent: Option<(f64, f64)> },
}

impl SelectionError {
    /// As a mistake of the record in the spec. `part` of the file `name` was read.
    pub(crate) fn diagnostic(&self, csv: &CsvSpec, name: &str, spec: SourceId, part: f64) -> Diagnostic {
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
                // Twenty thousand samples are plenty for a model with a dozen unknowns.
                let now = csv.decimate.as_ref().map_or(1, |d| d.value) as f64;
                let every = (now * MOST as f64 / part.max(1e-6) / 20_000.0).ceil();
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
