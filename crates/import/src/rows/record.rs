//! Reads the columns of a record. The file is streamed: only the rows that `rows`, `run`, `window` and
//! `decimate` leave stay in memory.

use super::dialect::{Dialect, is_infinite, is_missing};
use super::header::Header;
use super::line::{Line, LineError};
use super::lines::Lines;
use super::mistakes::{Mistakes, TimeCell};
use super::thousands::Marks;
use super::turns::Turns;
use crate::clock::Clock;
use crate::contradictions::{StatedColumn, swapped_columns, unit_contradiction};
use crate::data_file::DataFile;
use crate::refusal::Wanted;
use crate::selection::{Admission, FEWEST, Selection, SelectionError};
use phisindy_phys::spec::{CsvSpec, Spanned, Text};
use phisindy_phys::unit::{Scale, Unit};
use phisindy_phys::{Diagnostic, Samples, SourceId, Sources, Table, Units};
use std::borrow::Cow;
use std::ops::Range;

/// Reads the columns of the record `csv` from a file whose columns are in `units`. Returns the table in SI,
/// and warnings.
///
/// `spec` is the source that contains `csv`; `sources` receives the lines of the file that diagnostics show.
///
/// # Errors
/// All mistakes in the heading, or the first mistake in a row.
pub fn record(
    csv: &CsvSpec,
    units: &Units,
    file: DataFile<'_>,
    spec: SourceId,
    sources: &mut Sources,
) -> Result<(Table, Vec<Diagnostic>), Vec<Diagnostic>> {
    let mut mistakes = Mistakes { name: file.name, line: "line", spec, sources };
    let mut lines = Lines::of(file, csv.skip, &Wanted::Record(csv)).map_err(|e| {
        let sheet = csv.sheet.as_ref().filter(|_| e.is_of_sheet());
        vec![mistakes.unreadable_line(sheet.map_or(csv.path.span, |s| s.span), &e)]
    })?;
    if lines.sheet().is_some() {
        mistakes.line = "row";
    }
    let character = |c: &Option<Spanned<char>>| c.as_ref().map(|c| c.value);
    let (separator, decimal) = (character(&csv.separator), character(&csv.decimal));
    let header = match Header::read(&mut lines, separator, decimal, csv.header) {
        Ok(Some(header)) => header,
        Ok(None) => return Err(vec![mistakes.empty(csv.path.span)]),
        Err(e) => return Err(vec![mistakes.unreadable_line(csv.path.span, &e)]),
    };
    let layout = Layout::of(csv, &header, &mut mistakes)?;
    let warnings = match &header.heading {
        Some(_) => contradictions(csv, units, &header, &layout, spec),
        None => vec![],
    };
    let warnings = warnings.into_iter().chain(told_of_sheet(csv, &lines, spec)).collect();
    let own = own(csv, units, &lines, &layout, &header.names);
    let turns = csv.columns.iter().map(|(name, _)| Turns::of(csv, &name.value)).collect();
    let mut reader = Reader {
        csv,
        time: units.time.scale(),
        columns: units.columns.iter().map(|u| u.scale()).collect(),
        names: &header.names,
        dialect: &header.dialect,
        layout,
        mistakes,
        warnings,
        lines,
        marks: vec![Marks::default(); header.names.len()],
        selection: Selection::new(csv),
        values: Vec::with_capacity(csv.columns.len()),
        turns,
        clock: Clock::default(),
        last: None,
        shortest: usize::MAX,
        seen_point: None,
        seen_comma: None,
    };
    let mut pending = header.rows.into_iter();
    while let Some(line) =
        pending.next().map_or_else(|| reader.lines.next(), |line| Ok(Some(line))).transpose()
    {
        let line = line.map_err(|e| vec![reader.unreadable_line(&e)])?;
        reader.row(line).map_err(|d| vec![*d])?;
    }
    let Reader { selection, mistakes, warnings, lines, marks, .. } = reader;
    let mut named = header.names.iter().zip(&marks);
    if let Some(doubt) = named.find_map(|(name, marks)| mistakes.thousands(name, marks, csv.path.span)) {
        return Err(vec![doubt]);
    }
    match selection.finish() {
        Ok(table) => Ok((Table { own, ..table }, warnings)),
        Err(e) => Err(vec![e.diagnostic(csv, mistakes.name, spec, lines.fraction_read())]),
    }
}

/// Positions of the columns that the record needs.
struct Layout {
    /// `None` if the record states a rate.
    time: Option<usize>,
    columns: Vec<usize>,
    rows: Vec<usize>,
}

impl Layout {
    /// Finds each column in the heading.
    fn of(csv: &CsvSpec, header: &Header, mistakes: &mut Mistakes<'_>) -> Result<Layout, Vec<Diagnostic>> {
        let (names, commented, header) = (&header.names, header.commented, header.heading.as_ref());
        let mut wrong = Vec::new();
        let number = |text: &Text| text.value.parse::<usize>().ok();
        let mut find = |text: &Text| {
            let mut same = (0..names.len()).filter(|&k| names[k] == text.value);
            match (same.next(), same.next(), header) {
                (Some(k), None, _) => return k,
                // Behind a comment sign stands perhaps no heading: the columns keep their numbers.
                (None, ..) if commented && number(text).is_some_and(|k| (1..=names.len()).contains(&k)) => {
                    return number(text).map_or(0, |k| k - 1);
                }
                (Some(a), Some(b), Some((line, fields))) => {
                    wrong.push(mistakes.duplicate_column(text, line, fields[a].clone(), fields[b].clone()));
                }
                _ => wrong.push(mistakes.missing_column(text, names, header.map(|(line, _)| line))),
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

/// Warnings for headings that contradict the spec.
fn contradictions(
    csv: &CsvSpec,
    units: &Units,
    header: &Header,
    layout: &Layout,
    spec: SourceId,
) -> Vec<Diagnostic> {
    let time = layout.time.map(|k| (k, StatedColumn { name: None, column: &csv.time, unit: units.time }));
    let columns = csv.columns.iter().zip(&units.columns).zip(&layout.columns);
    let columns =
        columns.map(|(((name, column), &unit), &k)| (k, StatedColumn { name: Some(name), column, unit }));
    let units_differ = time.into_iter().chain(columns).filter_map(|(k, stated)| {
        let unit = header.units.as_ref().and_then(|row| row.get(k)).map(String::as_str);
        unit_contradiction(&stated, &header.names[k], unit, spec)
    });
    units_differ.chain(swapped_columns(csv, spec)).collect()
}

/// What is told of how the sheet was taken.
fn told_of_sheet(csv: &CsvSpec, lines: &Lines<'_>, spec: SourceId) -> Vec<Diagnostic> {
    let notes = lines.sheet().map_or(&[][..], |sheet| &sheet.notes);
    let warning = |note: &String| Diagnostic::warning(note.clone()).at(spec, csv.path.span, "this file");
    notes.iter().map(warning).collect()
}

/// The columns that have times of their own in the file, in SI by the same arithmetic as those of its rows.
fn own(
    csv: &CsvSpec,
    units: &Units,
    lines: &Lines<'_>,
    layout: &Layout,
    names: &[String],
) -> Vec<Option<Samples>> {
    let Some(sheet) = lines.sheet().filter(|sheet| !sheet.own.is_empty()) else { return vec![] };
    let of = |j: usize| {
        let own = sheet.own.iter().find(|own| own.name == names[layout.columns[j]])?;
        let (time, column) = (units.time.scale(), units.columns[j].scale());
        let samples = own.time.iter().zip(&own.values).filter(|(_, x)| x.is_finite());
        let mut turns = Turns::of(csv, &csv.columns[j].0.value);
        let mut unwrapped = |x: f64| turns.as_mut().map_or(x, |turns| turns.unwrapped(x));
        let both = |(t, x): (&f64, &f64)| (time.converted(*t), unwrapped(column.converted(*x)));
        let (time, values) = samples.map(both).unzip();
        Some(Samples { time, values })
    };
    (0..csv.columns.len()).map(of).collect()
}

struct Reader<'a> {
    csv: &'a CsvSpec,
    /// Conversion of the time and of each column to SI.
    time: Scale,
    columns: Vec<Scale>,
    /// Names of all columns of the file.
    names: &'a [String],
    dialect: &'a Dialect,
    layout: Layout,
    mistakes: Mistakes<'a>,
    warnings: Vec<Diagnostic>,
    lines: Lines<'a>,
    /// Of each column of the file, for marks of thousands, unless the spec says which mark is the decimal one.
    marks: Vec<Marks>,
    selection: Selection<'a>,
    /// Buffer for the numbers of a row.
    values: Vec<f64>,
    /// Of each column, if it begins anew after a turn.
    turns: Vec<Option<Turns>>,
    /// For times of day in the column of time.
    clock: Clock,
    /// Time of the last row inside the window.
    last: Option<TimeCell>,
    /// Length of the shortest last field so far, in bytes.
    shortest: usize,
    /// The first number with a decimal point, and the first with a decimal comma.
    seen_point: Option<String>,
    seen_comma: Option<String>,
}

impl Reader<'_> {
    fn unreadable_line(&mut self, error: &LineError) -> Diagnostic {
        self.mistakes.unreadable_line(self.csv.path.span, error)
    }

    /// Reads a row of numbers.
    fn row(&mut self, line: Line) -> Result<(), Box<Diagnostic>> {
        let csv = self.csv;
        let fields = self.dialect.fields_of(&line, self.names.len());
        if fields.len() != self.names.len() {
            let (mistakes, width) = (&mut self.mistakes, self.names.len());
            let d = mistakes.field_count(&line, fields.len(), width, csv.header, self.dialect);
            return Err(Box::new(d));
        }
        // Seconds from the first row of the file, whichever rows are selected.
        let stamp = self.layout.time.and_then(|k| {
            let text = &line.text[fields[k].clone()];
            text.contains(':').then(|| self.clock.seconds(&self.dialect.unquoted(&line.text, &fields[k])))?
        });
        for (j, (_, wanted)) in csv.rows.iter().enumerate() {
            let (x, _) = self.number(&line, &fields, self.layout.rows[j], Unit::ONE.scale())?;
            if (x - wanted.value).abs() > 1e-9 * wanted.value.abs() {
                return Ok(());
            }
        }
        // A row without a time is in no window.
        if csv.omits_missing && self.layout.time.is_some_and(|k| self.lacks(&line, &fields[k])) {
            self.selection.omit();
            return Ok(());
        }
        let (field, (time, seconds)) = match self.layout.time {
            Some(k) => match stamp {
                Some(seconds) => (fields[k].clone(), (seconds, seconds)),
                None => (fields[k].clone(), self.number(&line, &fields, k, self.time)?),
            },
            None => (0..0, (self.selection.counted_time(), self.selection.counted_time())),
        };
        self.check_line_end(&line, fields.last());
        // Values outside the window are not parsed: records often have bad rows at their ends.
        match self.selection.admits(seconds) {
            Admission::Inside => {}
            Admission::Before => {
                self.row_before(&line, &fields, seconds);
                return Ok(());
            }
            Admission::Outside => return Ok(()),
        }
        if csv.omits_missing && self.layout.columns.iter().any(|&k| self.lacks(&line, &fields[k])) {
            self.selection.omit();
            return Ok(());
        }
        self.values.clear();
        for j in 0..self.columns.len() {
            let (_, x) = self.number(&line, &fields, self.layout.columns[j], self.columns[j])?;
            let turns = self.turns[j].as_mut();
            self.values.push(turns.map_or(x, |turns| turns.unwrapped(x)));
        }
        let now = TimeCell { line, field, time };
        if let Some(before) = self.last.as_ref().filter(|before| time <= before.time) {
            return Err(Box::new(self.mistakes.time_order(&now, before, csv.rows.is_empty())));
        }
        let kept = self.selection.push(seconds, &self.values, now.line.number);
        kept.map_err(|e| Box::new(self.selection_error(&e)))?;
        self.last = Some(now);
        Ok(())
    }

    /// Reads a row before the window, if it holds numbers.
    fn row_before(&mut self, line: &Line, fields: &[Range<usize>], seconds: f64) {
        let read: Option<Vec<f64>> = (0..self.columns.len())
            .map(|j| Some(self.number(line, fields, self.layout.columns[j], self.columns[j]).ok()?.1))
            .collect();
        if let Some(mut row) = read {
            for (x, turns) in row.iter_mut().zip(&mut self.turns) {
                *x = turns.as_mut().map_or(*x, |turns| turns.unwrapped(*x));
            }
            self.selection.push_before(seconds, &row);
        }
    }

    /// Whether a field holds no measured value: no entry, or a number that is not finite.
    fn lacks(&self, line: &Line, field: &Range<usize>) -> bool {
        let text = self.dialect.unquoted(&line.text, field);
        is_missing(&text) || is_infinite(&text)
    }

    fn selection_error(&self, error: &SelectionError) -> Diagnostic {
        error.diagnostic(self.csv, self.mistakes.name, self.mistakes.spec, self.lines.fraction_read())
    }

    /// Warns if the file may be truncated inside its last number.
    fn check_line_end(&mut self, line: &Line, last: Option<&Range<usize>>) {
        let Some(last) = last else { return };
        if !line.ended && last.len() < self.shortest && self.selection.counted() as usize >= FEWEST {
            self.warnings.push(self.mistakes.truncated(line, last));
        }
        self.shortest = self.shortest.min(last.len());
    }

    /// Parses a field; returns the number as written and in SI.
    fn number(
        &mut self,
        line: &Line,
        fields: &[Range<usize>],
        column: usize,
        scale: Scale,
    ) -> Result<(f64, f64), Box<Diagnostic>> {
        let (k, dialect) = (column, self.dialect);
        let (field, column) = (&fields[k], self.names[k].as_str());
        let text = dialect.unquoted(&line.text, field);
        let comma = text.contains(',');
        let plain = match (comma, dialect.decimal) {
            (true, Some('.')) => None,
            (true, _) if text.contains('.') || dialect.separator == Some(',') => None,
            (true, _) => Some(Cow::from(text.replacen(',', ".", 1))),
            (false, Some(',')) if text.contains('.') => None,
            (false, _) => Some(Cow::from(&*text)),
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
        if dialect.decimal.is_none() {
            self.marks[k].see(&text);
        }
        // Beside "0.5", "1,500" may be a thousand or have a decimal comma: the user has to decide.
        if dialect.decimal.is_none() && (comma || text.contains('.')) {
            let seen = if comma { &mut self.seen_comma } else { &mut self.seen_point };
            if seen.is_none() {
                *seen = Some(text.to_string());
            }
            if let (Some(a), Some(b)) = (&self.seen_point, &self.seen_comma) {
                return Err(Box::new(self.mistakes.mixed_decimal_marks(line, field.clone(), a, b)));
            }
        }
        Ok(parsed.unwrap_or((f64::NAN, f64::NAN)))
    }
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
