//! Data files: the columns that a record needs, as numbers. The file streams by; only those numbers stay in memory, and of them only
//! what is left of `rows`, `window` and `decimate`.

use super::dialect::{Dialect, is_units_row, looks_like_number};
use super::lines::{Line, Lines};
use super::mistakes::Mistakes;
use crate::contradictions::{Reading, contradiction, crossed};
use crate::data_file::DataFile;
use phisindy_phys::spec::{CsvSpec, Text};
use phisindy_phys::unit::{Scale, Unit};
use phisindy_phys::{Diagnostic, SourceId, Sources, Table, Units};
use phisindy_signal::Blocks;
use std::borrow::Cow;
use std::ops::Range;

/// Fewer rows than this are no record.
const FEWEST: usize = 10;
/// Most samples of a record: a fit looks at each of them a thousand times.
const MOST: usize = 2_000_000;

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
    let name = file.name;
    let lines = Lines::of(file, csv.skip);
    let mistakes = Mistakes { name, spec, sources };
    let mut reader = Reader {
        csv,
        time: units.time.scale(),
        columns: units.columns.iter().map(|u| u.scale()).collect(),
        mistakes,
        warnings: vec![],
        lines,
        seen_point: None,
        seen_comma: None,
    };
    let Some(first) = reader.next_line().map_err(|d| vec![*d])? else {
        return Err(vec![reader.mistakes.empty(csv.path.span)]);
    };
    let second = reader.next_line().map_err(|d| vec![*d])?;
    let character = |c: &Option<phisindy_phys::spec::Spanned<char>>| c.as_ref().map(|c| c.value);
    let dialect = Dialect::guess(
        character(&csv.separator),
        character(&csv.decimal),
        &first.text,
        second.as_ref().map(|l| l.text.as_str()),
    );
    let fields = dialect.fields(&first.text);
    let heading: Vec<String> = fields.iter().map(|f| dialect.unquoted(&first.text, f)).collect();
    let has_header = csv.header.unwrap_or_else(|| heading.iter().any(|f| !looks_like_number(f)));
    let names = if has_header { heading } else { (1..=fields.len()).map(|k| k.to_string()).collect() };
    let layout = reader.layout(&names, has_header.then_some((&first, fields.as_slice())))?;
    let mut table = Table { columns: vec![vec![]; csv.columns.len()], ..Table::default() };
    let mut kept = Kept {
        blocks: csv.decimate.as_ref().map(|d| Blocks::new(d.value as usize)),
        row: Vec::with_capacity(csv.columns.len()),
        last: None,
        counted: 0,
        shortest: usize::MAX,
        run: 0,
        clock: None,
    };
    // A second heading line that only holds units is no row.
    let (units_row, second) = match second {
        Some(line) if has_header && is_units_row(&dialect, &line.text) => (Some(line), None),
        other => (None, other),
    };
    if has_header {
        let row = units_row.map(|line| {
            let fields = dialect.fields(&line.text);
            fields.iter().map(|f| dialect.unquoted(&line.text, f)).collect::<Vec<_>>()
        });
        reader.contradicted(&names, row.as_deref(), units, &layout);
    }
    let begin = if has_header { [None, second] } else { [Some(first), second] };
    let mut pending = begin.into_iter().flatten();
    loop {
        let line = match pending.next() {
            Some(line) => line,
            None => match reader.next_line().map_err(|d| vec![*d])? {
                Some(line) => line,
                None => break,
            },
        };
        reader.row(line, &dialect, &names, &layout, &mut table, &mut kept).map_err(|d| vec![*d])?;
    }
    if let Some(run) = csv.run.as_ref().filter(|run| run.value > kept.run) {
        return Err(vec![reader.mistakes.no_run(run, kept.run + 1)]);
    }
    // Too few in a window, or of `decimate`, is the business of the record.
    if table.time.len() < FEWEST && csv.window.is_none() && csv.decimate.is_none() {
        let rows = csv.rows.first().map(|(first, _)| first.span.to(csv.rows[csv.rows.len() - 1].1.span));
        return Err(vec![reader.mistakes.too_few(
            rows.unwrap_or(csv.path.span),
            table.time.len(),
            rows.is_some(),
        )]);
    }
    Ok((table, reader.warnings))
}

/// Where the needed columns stand in a line.
struct Layout {
    /// None where a rate takes its place.
    time: Option<usize>,
    columns: Vec<usize>,
    rows: Vec<usize>,
}

/// What of the rows before is needed for the next one.
struct Kept {
    blocks: Option<Blocks>,
    row: Vec<f64>,
    /// The last row inside of the window, its time, and where that stands.
    last: Option<(Line, f64, Range<usize>)>,
    /// Rows so far that `rows` selects.
    counted: u64,
    /// Length of the shortest last field so far.
    shortest: usize,
    /// Which run of the file the last row belongs to, and its time.
    run: u64,
    clock: Option<f64>,
}

struct Reader<'a> {
    csv: &'a CsvSpec,
    /// How the time and each column become SI.
    time: Scale,
    columns: Vec<Scale>,
    mistakes: Mistakes<'a>,
    warnings: Vec<Diagnostic>,
    lines: Lines<'a>,
    /// A number with a decimal point, and one with a decimal comma, if any was met.
    seen_point: Option<String>,
    seen_comma: Option<String>,
}

impl Reader<'_> {
    /// The next line that is neither empty nor a comment.
    fn next_line(&mut self) -> Result<Option<Line>, Box<Diagnostic>> {
        self.lines.next().map_err(|e| Box::new(self.mistakes.bad_line(self.csv.path.span, &e)))
    }

    fn layout(
        &mut self,
        names: &[String],
        header: Option<(&Line, &[Range<usize>])>,
    ) -> Result<Layout, Vec<Diagnostic>> {
        let mut wrong = Vec::new();
        let mut find = |text: &Text| {
            let mut found = (0..names.len()).filter(|&k| names[k] == text.value);
            let (first, again) = (found.next(), found.next());
            match (first, again, header) {
                (Some(k), None, _) => return k,
                (Some(a), Some(b), Some((line, fields))) => {
                    wrong.push(self.mistakes.twice(text, line, fields[a].clone(), fields[b].clone()));
                }
                _ => wrong.push(self.mistakes.no_column(text, names, header.map(|(line, _)| line))),
            }
            0
        };
        let layout = Layout {
            time: self.csv.rate.is_none().then(|| find(&self.csv.time.header)),
            columns: self.csv.columns.iter().map(|(_, c)| find(&c.header)).collect(),
            rows: self.csv.rows.iter().map(|(name, _)| find(name)).collect(),
        };
        if wrong.is_empty() { Ok(layout) } else { Err(wrong) }
    }

    /// Warns of headings that say another unit than the spec, or name each other's column.
    fn contradicted(&mut self, names: &[String], row: Option<&[String]>, units: &Units, layout: &Layout) {
        let time = layout.time.map(|k| (k, Reading { name: None, column: &self.csv.time, unit: units.time }));
        let columns = self.csv.columns.iter().zip(&units.columns).zip(&layout.columns);
        let columns =
            columns.map(|(((name, column), &unit), &k)| (k, Reading { name: Some(name), column, unit }));
        let told = time.into_iter().chain(columns).filter_map(|(k, reading)| {
            let unit = row.and_then(|row| row.get(k)).map(String::as_str);
            contradiction(&reading, &names[k], unit, self.mistakes.spec)
        });
        let crossed = crossed(self.csv, self.mistakes.spec);
        self.warnings.extend(told.chain(crossed).collect::<Vec<_>>());
    }

    /// One line of the file.
    fn row(
        &mut self,
        line: Line,
        dialect: &Dialect,
        names: &[String],
        layout: &Layout,
        table: &mut Table,
        kept: &mut Kept,
    ) -> Result<(), Box<Diagnostic>> {
        let fields = dialect.fields(&line.text);
        if fields.len() != names.len() {
            return Err(Box::new(self.mistakes.ragged(&line, fields.len(), names.len(), self.csv.header)));
        }
        for (k, (_, wanted)) in layout.rows.iter().zip(&self.csv.rows) {
            let (x, _) = self.number(&line, dialect, &fields[*k], &names[*k], Unit::ONE.scale())?;
            if (x - wanted.value).abs() > 1e-9 * wanted.value.abs() {
                return Ok(());
            }
        }
        let (place, (time, seconds)) = match (layout.time, &self.csv.rate) {
            (Some(k), _) => {
                (fields[k].clone(), self.number(&line, dialect, &fields[k], &names[k], self.time)?)
            }
            (None, rate) => {
                let time = kept.counted as f64 / rate.as_ref().map_or(1.0, |rate| rate.value);
                (0..0, (time, time))
            }
        };
        self.end_of(&line, fields.last(), kept);
        kept.counted += 1;
        if let Some(wanted) = &self.csv.run {
            kept.run += u64::from(kept.clock.replace(time).is_some_and(|before| time < before));
            if kept.run != wanted.value {
                return Ok(());
            }
        }
        let extent = table.extent.get_or_insert((time, time));
        *extent = (extent.0.min(time), extent.1.max(time));
        // What lies outside of the window is not looked at: a record is often bad at its ends.
        if self.csv.window.as_ref().is_some_and(|(a, b)| !(a.value..=b.value).contains(&time)) {
            return Ok(());
        }
        kept.row.clear();
        for (j, &k) in layout.columns.iter().enumerate() {
            let (_, x) = self.number(&line, dialect, &fields[k], &names[k], self.columns[j])?;
            kept.row.push(x);
        }
        if let Some((before, earlier, there)) = kept.last.as_ref().filter(|(_, earlier, _)| time <= *earlier)
        {
            let d = self.mistakes.time_order(
                &line,
                place,
                time,
                before,
                there.clone(),
                *earlier,
                self.csv.rows.is_empty(),
            );
            return Err(Box::new(d));
        }
        let row = match &mut kept.blocks {
            Some(blocks) => blocks.push(seconds, &kept.row),
            None => Some((seconds, kept.row.as_slice())),
        };
        if let Some((time, row)) = row {
            if table.time.len() == MOST {
                let d = self.mistakes.too_many(self.csv, MOST, table.extent, self.lines.part());
                return Err(Box::new(d));
            }
            table.time.push(time);
            table.lines.push(line.number);
            table.columns.iter_mut().zip(row).for_each(|(column, x)| column.push(*x));
        }
        kept.last = Some((line, time, place));
        Ok(())
    }

    /// Looks at how a line ends: a file that was cut off may end inside a number.
    fn end_of(&mut self, line: &Line, last: Option<&Range<usize>>, kept: &mut Kept) {
        let Some(last) = last else { return };
        if !line.ended && last.len() < kept.shortest && kept.counted as usize >= FEWEST {
            let d = self.mistakes.perhaps_cut(line, last);
            self.warnings.push(d);
        }
        kept.shortest = kept.shortest.min(last.len());
    }

    /// A field as it stands there, and in SI.
    fn number(
        &mut self,
        line: &Line,
        dialect: &Dialect,
        field: &Range<usize>,
        column: &str,
        scale: Scale,
    ) -> Result<(f64, f64), Box<Diagnostic>> {
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
