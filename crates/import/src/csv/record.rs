//! The columns that a record needs, as numbers. The file streams by; only those numbers stay in memory, and of them only what is left of
//! `rows`, `run`, `window` and `decimate`.

use super::dialect::Dialect;
use super::lines::{Line, LineError, Lines};
use super::mistakes::{Mistakes, TimeCell};
use super::opening::Opening;
use crate::contradictions::{Reading, contradiction, crossed};
use crate::data_file::DataFile;
use crate::selection::{FEWEST, Selection, SelectionError};
use phisindy_phys::spec::{CsvSpec, Spanned, Text};
use phisindy_phys::unit::{Scale, Unit};
use phisindy_phys::{Diagnostic, SourceId, Sources, Table, Units};
use std::borrow::Cow;
use std::ops::Range;

/// Reads what `csv` needs from a file, whose columns are in `units`; `spec` is where `csv` stands. With the table come warnings.
///
/// # Errors
/// Everything that is wrong with the heading, or the first thing that is wrong in the rows, with the line of the file.
pub fn record(
    csv: &CsvSpec,
    units: &Units,
    file: DataFile<'_>,
    spec: SourceId,
    sources: &mut Sources,
) -> Result<(Table, Vec<Diagnostic>), Vec<Diagnostic>> {
    let mut mistakes = Mistakes { name: file.name, spec, sources };
    let mut lines = Lines::of(file, csv.skip);
    let character = |c: &Option<Spanned<char>>| c.as_ref().map(|c| c.value);
    let (separator, decimal) = (character(&csv.separator), character(&csv.decimal));
    let opening = match Opening::read(&mut lines, separator, decimal, csv.header) {
        Ok(Some(opening)) => opening,
        Ok(None) => return Err(vec![mistakes.empty(csv.path.span)]),
        Err(e) => return Err(vec![mistakes.bad_line(csv.path.span, &e)]),
    };
    let layout = Layout::of(csv, &opening, &mut mistakes)?;
    let warnings = match &opening.heading {
        Some(_) => contradictions(csv, units, &opening, &layout, spec),
        None => vec![],
    };
    let mut reader = Reader {
        csv,
        time: units.time.scale(),
        columns: units.columns.iter().map(|u| u.scale()).collect(),
        names: &opening.names,
        dialect: &opening.dialect,
        layout,
        mistakes,
        warnings,
        lines,
        selection: Selection::new(csv),
        values: Vec::with_capacity(csv.columns.len()),
        last: None,
        shortest: usize::MAX,
        seen_point: None,
        seen_comma: None,
    };
    let mut pending = opening.rows.into_iter();
    while let Some(line) =
        pending.next().map_or_else(|| reader.lines.next(), |line| Ok(Some(line))).transpose()
    {
        let line = line.map_err(|e| vec![reader.bad_line(&e)])?;
        reader.row(line).map_err(|d| vec![*d])?;
    }
    let Reader { selection, mistakes, warnings, lines, .. } = reader;
    match selection.finish() {
        Ok(table) => Ok((table, warnings)),
        Err(e) => Err(vec![e.diagnostic(csv, mistakes.name, spec, lines.part())]),
    }
}

/// Where the needed columns stand in a line.
struct Layout {
    /// None where a rate takes its place.
    time: Option<usize>,
    columns: Vec<usize>,
    rows: Vec<usize>,
}

impl Layout {
    /// Looks each column up in the heading.
    fn of(csv: &CsvSpec, opening: &Opening, mistakes: &mut Mistakes<'_>) -> Result<Layout, Vec<Diagnostic>> {
        let (names, header) = (&opening.names, opening.heading.as_ref());
        let mut wrong = Vec::new();
        let mut find = |text: &Text| {
            let mut same = (0..names.len()).filter(|&k| names[k] == text.value);
            match (same.next(), same.next(), header) {
                (Some(k), None, _) => return k,
                (Some(a), Some(b), Some((line, fields))) => {
                    wrong.push(mistakes.twice(text, line, fields[a].clone(), fields[b].clone()));
                }
                _ => wrong.push(mistakes.no_column(text, names, header.map(|(line, _)| line))),
            }
            0
        };
        let layout = Layout {
            time: csv.rate.is_none().then(|| find(&csv.time.header)),
            columns: csv.columns.iter().map(|(_, c)| find(&c.header)).collect(),
            rows: csv.rows.iter().map(|(name, _)| find(name)).collect(),
        };
        if wrong.is_empty() { Ok(layout) } else { Err(wrong) }
    }
}

/// Warns of headings that say another unit than the spec, or name each other's column.
fn contradictions(
    csv: &CsvSpec,
    units: &Units,
    opening: &Opening,
    layout: &Layout,
    spec: SourceId,
) -> Vec<Diagnostic> {
    let time = layout.time.map(|k| (k, Reading { name: None, column: &csv.time, unit: units.time }));
    let columns = csv.columns.iter().zip(&units.columns).zip(&layout.columns);
    let columns =
        columns.map(|(((name, column), &unit), &k)| (k, Reading { name: Some(name), column, unit }));
    let told = time.into_iter().chain(columns).filter_map(|(k, reading)| {
        let unit = opening.units.as_ref().and_then(|row| row.get(k)).map(String::as_str);
        contradiction(&reading, &opening.names[k], unit, spec)
    });
    told.chain(crossed(csv, spec)).collect()
}

struct Reader<'a> {
    csv: &'a CsvSpec,
    /// How the time and each column become SI.
    time: Scale,
    columns: Vec<Scale>,
    /// Of all columns of the file.
    names: &'a [String],
    dialect: &'a Dialect,
    layout: Layout,
    mistakes: Mistakes<'a>,
    warnings: Vec<Diagnostic>,
    lines: Lines<'a>,
    selection: Selection<'a>,
    /// The numbers of a row, kept for the next one.
    values: Vec<f64>,
    /// The last row inside of the window.
    last: Option<TimeCell>,
    /// Length of the shortest last field so far.
    shortest: usize,
    /// A number with a decimal point, and one with a decimal comma, if any was met.
    seen_point: Option<String>,
    seen_comma: Option<String>,
}

impl Reader<'_> {
    fn bad_line(&mut self, error: &LineError) -> Diagnostic {
        self.mistakes.bad_line(self.csv.path.span, error)
    }

    /// One line of the file.
    fn row(&mut self, line: Line) -> Result<(), Box<Diagnostic>> {
        let csv = self.csv;
        let fields = self.dialect.fields(&line.text);
        if fields.len() != self.names.len() {
            let d = self.mistakes.ragged(&line, fields.len(), self.names.len(), csv.header);
            return Err(Box::new(d));
        }
        for (j, (_, wanted)) in csv.rows.iter().enumerate() {
            let (x, _) = self.number(&line, &fields, self.layout.rows[j], Unit::ONE.scale())?;
            if (x - wanted.value).abs() > 1e-9 * wanted.value.abs() {
                return Ok(());
            }
        }
        let (field, (time, seconds)) = match self.layout.time {
            Some(k) => (fields[k].clone(), self.number(&line, &fields, k, self.time)?),
            None => (0..0, (self.selection.counted_time(), self.selection.counted_time())),
        };
        self.end_of(&line, fields.last());
        // What lies outside of the window is not looked at: a record is often bad at its ends.
        if !self.selection.enters(time) {
            return Ok(());
        }
        self.values.clear();
        for j in 0..self.columns.len() {
            let (_, x) = self.number(&line, &fields, self.layout.columns[j], self.columns[j])?;
            self.values.push(x);
        }
        let now = TimeCell { line, field, time };
        if let Some(before) = self.last.as_ref().filter(|before| time <= before.time) {
            return Err(Box::new(self.mistakes.time_order(&now, before, csv.rows.is_empty())));
        }
        let kept = self.selection.push(seconds, &self.values, now.line.number);
        kept.map_err(|e| Box::new(self.refused(&e)))?;
        self.last = Some(now);
        Ok(())
    }

    fn refused(&self, error: &SelectionError) -> Diagnostic {
        error.diagnostic(self.csv, self.mistakes.name, self.mistakes.spec, self.lines.part())
    }

    /// Looks at how a line ends: a file that was cut off may end inside a number.
    fn end_of(&mut self, line: &Line, last: Option<&Range<usize>>) {
        let Some(last) = last else { return };
        if !line.ended && last.len() < self.shortest && self.selection.counted() as usize >= FEWEST {
            self.warnings.push(self.mistakes.perhaps_cut(line, last));
        }
        self.shortest = self.shortest.min(last.len());
    }

    /// A field as it stands there, and in SI.
    fn number(
        &mut self,
        line: &Line,
        fields: &[Range<usize>],
        column: usize,
        scale: Scale,
    ) -> Result<(f64, f64), Box<Diagnostic>> {
        let (dialect, field, column) = (self.dialect, &fields[column], self.names[column].as_str());
        let text = dialect.unquoted(&line.text, field);
        let comma = text.contains(',');
        let plain = match (comma, dialect.decimal) {
            (true, Some('.')) => None,
            (true, _) if text.contains('.') || dialect.separator == Some(',') => None,
            (true, _) => Some(Cow::from(text.replacen(',', ".", 1))),
            (false, Some(',')) if text.contains('.') => None,
            (false, _) => Some(Cow::from(&text)),
        };
        let parsed = plain.and_then(|plain| {
            let x = plain.parse::<f64>().ok()?;
            Some((x, if x.is_finite() { scale.si(&plain)? } else { x }))
        });
        match parsed {
            Some((x, si)) if x.is_finite() && si.is_finite() => {}
            Some(_) => return Err(Box::new(self.mistakes.not_finite(line, field.clone(), column, &text))),
            None => {
                return Err(Box::new(self.mistakes.not_a_number(
                    line,
                    field.clone(),
                    column,
                    &text,
                    dialect,
                )));
            }
        }
        // "1,500" beside "0.5" is a thousand or a decimal comma: better ask than guess.
        if dialect.decimal.is_none() && (comma || text.contains('.')) {
            let seen = if comma { &mut self.seen_comma } else { &mut self.seen_point };
            if seen.is_none() {
                *seen = Some(text.clone());
            }
            if let (Some(a), Some(b)) = (&self.seen_point, &self.seen_comma) {
                return Err(Box::new(self.mistakes.two_marks(line, field.clone(), a, b)));
            }
        }
        Ok(parsed.unwrap_or((f64::NAN, f64::NAN)))
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
