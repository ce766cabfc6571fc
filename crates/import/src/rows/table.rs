//! Reads all columns of a file.

use super::dialect::{Dialect, is_missing, is_units_row, looks_like_number};
use super::header::{Header, has_row_name};
use super::line::{Line, LineError};
use super::lines::Lines;
use super::mistakes::Mistakes;
use super::thousands::{Marks, is_grouped};
use crate::cell::SEPARATOR;
use crate::clock::Clock;
use crate::data_file::{DataFile, unreadable};
use crate::headings::Heading;
use crate::refusal::Wanted;
use crate::spec_text::quoted;
use crate::stated_rate::{StatedRate, rate_of_column, stated_rate};
use crate::table::{Column, Table};
use phisindy_expr::Span;
use phisindy_phys::{Diagnostic, SourceId, Sources};
use std::borrow::Cow;

/// Most numbers in memory: 80 MB.
const MOST_NUMBERS: usize = 10_000_000;
/// Most rows that are read: more do not improve the statistics.
const MOST_ROWS: usize = 1_000_000;
/// Fewest rows of a table.
const FEWEST: usize = 20;

/// Reads all columns of a file, up to a million rows; `at` is where the user named it. Of a file with several
/// sheets it reads the one called `sheet`, or the one with most rows of numbers.
///
/// # Errors
/// The first mistake in the file.
pub fn table(
    file: DataFile<'_>,
    sheet: Option<&str>,
    at: (SourceId, Span),
    sources: &mut Sources,
) -> Result<Table, Box<Diagnostic>> {
    let name = file.name;
    let mut mistakes = Mistakes { name, line: "line", spec: at.0, sources };
    let mut lines =
        Lines::of(file, 0, &Wanted::All { sheet }).map_err(|e| mistakes.unreadable_line(at.1, &e))?;
    if lines.sheet().is_some() {
        mistakes.line = "row";
    }
    let (skip, beginning) = preamble(&mut lines);
    let mut lines = lines.restarted(skip).map_err(|e| unreadable(name, at, &e))?;
    let header = match Header::read(&mut lines, None, None, None) {
        Ok(Some(header)) => header,
        Ok(None) => return Err(Box::new(mistakes.empty(at.1))),
        Err(e) => return Err(Box::new(mistakes.unreadable_line(at.1, &e))),
    };
    let mut headings: Vec<Heading> = header.names.iter().map(|h| Heading::parse(h)).collect();
    if let Some(units) = &header.units {
        headings = headings.into_iter().zip(units).map(|(h, u)| h.with_unit(u)).collect();
    }
    let most = MOST_ROWS.min(MOST_NUMBERS / headings.len().max(1));
    let mut rows = Rows {
        dialect: &header.dialect,
        has_header: header.heading.is_some(),
        clocks: vec![Clock::default(); headings.len()],
        marks: vec![Marks::default(); headings.len()],
        columns: headings.into_iter().map(Column::new).collect(),
        numbers: vec![],
        comma: false,
        point: false,
        mistakes,
    };
    let mut fraction_read = 1.0;
    let mut pending = header.rows.into_iter();
    while let Some(line) = pending.next().map_or_else(|| lines.next(), |line| Ok(Some(line))).transpose() {
        let line = line.map_err(|e: LineError| rows.mistakes.unreadable_line(at.1, &e))?;
        rows.push(&line)?;
        if rows.numbers.len() == most {
            fraction_read = lines.fraction_read();
            break;
        }
    }
    let mut named = rows.columns.iter().zip(&rows.marks);
    if let Some(doubt) = named.find_map(|(c, marks)| rows.mistakes.thousands(&c.heading.raw, marks, at.1)) {
        return Err(Box::new(doubt));
    }
    if let Some((message, help)) = rows.defect() {
        return Err(Box::new(Diagnostic::error(message).at(at.0, at.1, "this file").help(help)));
    }
    for column in rows.columns.iter_mut().filter(|c| c.stamps > 0) {
        column.heading.unit = None;
        column.heading = column.heading.clone().with_unit("s");
    }
    let (columns, row_numbers) = (rows.columns, rows.numbers);
    let mut notes: Vec<String> = header
        .unnamed
        .iter()
        .map(|k| format!("column {} has no heading: its number is its name", k + 1))
        .collect();
    let last = row_numbers.first().copied().unwrap_or(usize::MAX);
    let stated = beginning.iter().filter(|line| line.number < last);
    let mut stated_rates: Vec<StatedRate> =
        stated.filter_map(|line| stated_rate(&line.text.replace(SEPARATOR, " "), line.number)).collect();
    let of_columns = columns.iter().filter_map(|c: &Column| rate_of_column(&c.heading, &c.values, last));
    stated_rates.extend(of_columns);
    let table = Table { columns, row_numbers, fraction_read, stated_rates, ..Table::default() };
    Ok(match lines.sheet() {
        None => {
            let record_fields = record_fields(&header.dialect, rows.comma, rows.has_header, skip);
            Table { record_fields, notes, ..table }
        }
        Some(sheet) => {
            let name = sheet.name.as_ref().map(|name| format!("sheet: {}", quoted(name)));
            let skip = (skip > 0).then(|| format!("skip: {skip}"));
            let header = (sheet.heading().is_none() && !rows.has_header).then(|| "header: false".to_owned());
            let record_fields = [name, header, skip].into_iter().flatten().collect();
            let other_sheets = sheet.others.clone();
            notes.extend(sheet.notes.iter().cloned());
            Table { is_text: false, other_sheets, notes, record_fields, ..table }
        }
    })
}

/// The rows read so far.
struct Rows<'a> {
    dialect: &'a Dialect,
    has_header: bool,
    columns: Vec<Column>,
    /// Of each column, for times of day.
    clocks: Vec<Clock>,
    /// Of each column, for marks of thousands.
    marks: Vec<Marks>,
    /// The line of each row.
    numbers: Vec<usize>,
    /// Whether a number with a decimal comma occurred, and one with a point.
    comma: bool,
    point: bool,
    mistakes: Mistakes<'a>,
}

impl Rows<'_> {
    fn push(&mut self, line: &Line) -> Result<(), Box<Diagnostic>> {
        let (dialect, width) = (self.dialect, self.columns.len());
        let fields = dialect.fields_of(line, width);
        if fields.len() != width {
            let header = (!self.has_header).then_some(false);
            let d = self.mistakes.field_count(line, fields.len(), width, header, dialect);
            // The presumed heading may be a line of a preamble.
            let preamble = self.has_header && self.numbers.len() < 3;
            let help = "if other lines stand before the heading, put `#` in front of each of them";
            return Err(Box::new(if preamble { d.help(help) } else { d }));
        }
        self.numbers.push(line.number);
        let states = self.clocks.iter_mut().zip(&mut self.marks);
        for ((field, column), (clock, marks)) in fields.iter().zip(&mut self.columns).zip(states) {
            let text = dialect.unquoted(&line.text, field);
            let comma = dialect.separator != Some(',') && text.contains(',');
            let number = if comma { text.replacen(',', ".", 1).parse::<f64>() } else { text.parse::<f64>() };
            if let Ok(x) = number {
                self.comma |= comma;
                self.point |= text.contains('.');
                if x.is_finite() {
                    marks.see(&text);
                }
                column.values.push(if x.is_finite() { x } else { f64::NAN });
                continue;
            }
            // A column of stamps holds nothing else.
            if column.stamps == column.values.len()
                && let Some(seconds) = clock.seconds(&text)
            {
                column.values.push(seconds);
                column.stamps += 1;
                continue;
            }
            if is_grouped(&text) {
                let name = &column.heading.raw;
                return Err(Box::new(self.mistakes.not_a_number(line, field.clone(), name, &text, dialect)));
            }
            column.values.push(f64::NAN);
            if !is_missing(&text) {
                column.text_cells += 1;
                column.words.see(&text);
                if column.first_text.is_none() {
                    let name = &column.heading.raw;
                    let d = self.mistakes.not_a_number(line, field.clone(), name, &text, dialect);
                    column.first_text = Some(d);
                }
            }
        }
        Ok(())
    }

    /// Why the rows form no usable table, and what to do.
    fn defect(&self) -> Option<(String, &'static str)> {
        let name = self.mistakes.name;
        let rows = self.numbers.len();
        if self.comma && self.point {
            return Some((
                format!("`{name}` has numbers with a point and numbers with a comma"),
                "write all decimals alike: in one of them the mark is perhaps one of thousands",
            ));
        }
        let numbers = self.columns.iter().any(|c| c.values.iter().any(|x| x.is_finite()));
        if self.columns.len() < 2 && !numbers {
            return Some((
                format!("`{name}` has only one column"),
                "a record needs a column of time and one of motion, in lines like `0.01, 0.0023`",
            ));
        }
        if rows > 0 && !numbers {
            return Some((
                format!("`{name}` holds no numbers"),
                "a data file has a heading line, then rows of numbers separated by commas, semicolons, tabs or blanks",
            ));
        }
        (rows < FEWEST).then(|| {
            (
                format!("`{name}` has {rows} rows of numbers"),
                "that is too few to say anything: at least 20 are needed, some hundred are good",
            )
        })
    }
}

/// The fields of a record that describe this file.
fn record_fields(dialect: &Dialect, comma: bool, has_header: bool, skip: usize) -> Vec<String> {
    let separator = match dialect.separator {
        Some(',') => None,
        Some('\t') => Some("'\\t'".to_owned()),
        Some(c) => Some(format!("'{c}'")),
        None => Some("' '".to_owned()),
    };
    let separator = separator.map(|s| format!("separator: {s}"));
    let decimal = comma.then(|| "decimal: ','".to_owned());
    let header = (!has_header).then(|| "header: false".to_owned());
    let skip = (skip > 0).then(|| format!("skip: {skip}"));
    [separator, decimal, header, skip].into_iter().flatten().collect()
}

/// Number of lines in which the heading is searched.
const START: usize = 100;

/// Number of lines before the heading, which is the last line of words above the first rows of numbers; and
/// the first lines of the file, with the comments between them.
fn preamble(lines: &mut Lines<'_>) -> (usize, Vec<Line>) {
    let separator = match lines.sheet() {
        // Nothing stands before the names of columns that are stored one by one.
        Some(sheet) if sheet.heading().is_some() => return (0, vec![]),
        Some(_) => Some(SEPARATOR),
        None => None,
    };
    let mut start: Vec<Line> = Vec::new();
    while let (true, Ok(Some(line))) = (start.len() < START, lines.next()) {
        start.push(line);
    }
    let skip = words_before(&start, separator);
    let comments = lines.comments().iter().cloned();
    (skip, start.into_iter().chain(comments).collect())
}

/// Number of lines of words before the heading.
fn words_before(start: &[Line], separator: Option<char>) -> usize {
    let [.., before, last] = start else { return 0 };
    let dialect = Dialect::guess(separator, None, &before.text, Some(&last.text));
    let width = dialect.fields(&last.text).len();
    // Behind a trailing separator a value may be missing, in all rows but the first ones.
    let trailing = dialect.fields_of(last, width + 1).len() == width + 1;
    let fits = |count: usize| count == width || (trailing && count == width + 1);
    let numbers = |line: &Line| {
        let cells: Vec<Cow<'_, str>> =
            dialect.fields_of(line, width).iter().map(|f| dialect.unquoted(&line.text, f)).collect();
        let good = cells.iter().filter(|cell| looks_like_number(cell)).count();
        let missing = cells.iter().filter(|cell| is_missing(cell)).count();
        fits(cells.len()) && good > 0 && 2 * (good + missing) > width
    };
    // A preamble may hold numbers too, but they do not fill all following lines.
    let Some(words) = start.iter().rposition(|line| !numbers(line)) else { return 0 };
    let units = words > 0 && is_units_row(&dialect, &start[words].text);
    let heading = if units { words - 1 } else { words };
    let names = dialect.fields(&start[heading].text).len();
    // Of a comma in every number each name has two fields; the first row is refused then.
    let halved = names > 1 && (names + 1..=2 * names).contains(&width);
    let is_heading = fits(names)
        || has_row_name(&dialect, last, names)
        || (halved && dialect.may_split_decimals(&last.text));
    match is_heading && words + 3 < start.len() {
        true if heading > 0 => start[heading].number - 1,
        // Lines of words above numbers without heading.
        false if words + 3 < start.len() && width > 1 => start[words].number,
        _ => 0,
    }
}
