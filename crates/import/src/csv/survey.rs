//! The first look at a file: all of its columns as numbers, line by line, up to a stated amount.

use super::dialect::{Dialect, is_units_row, looks_like_number};
use super::lines::{Line, Lines};
use super::mistakes::{Mistakes, unreadable};
use crate::data_file::DataFile;
use crate::headings::Heading;
use phisindy_expr::Span;
use phisindy_phys::{Diagnostic, SourceId, Sources};

/// Most numbers that are kept: 80 MB.
const MOST_NUMBERS: usize = 10_000_000;
/// Most rows that are read: statistics get no better.
const MOST_ROWS: usize = 1_000_000;
/// Fewer rows than this are no record.
const FEWEST: usize = 20;

/// A column of the file.
#[derive(Clone, Debug)]
pub struct Column {
    /// Its name and unit.
    pub(crate) heading: Heading,
    /// NaN where there is nothing.
    pub(crate) values: Vec<f64>,
    /// How many cells hold words.
    pub(crate) words: usize,
    /// The first words that stand in it, as a mistake.
    pub(crate) mistake: Option<Diagnostic>,
}

/// What a file holds.
#[derive(Debug)]
pub struct Survey {
    /// In the order of the file.
    pub(crate) columns: Vec<Column>,
    /// The line of each row.
    pub(crate) lines: Vec<usize>,
    /// Between fields; None: blanks.
    pub(crate) separator: Option<char>,
    /// Whether decimals have a comma.
    pub(crate) comma: bool,
    /// Whether the file has a heading line.
    pub(crate) has_header: bool,
    /// Lines before the heading.
    pub(crate) skip: usize,
    /// The part of the file that was read, 1 for all.
    pub(crate) part: f64,
}

impl Survey {
    /// Reads a file; `at` is where the user named it.
    ///
    /// # Errors
    /// What is wrong with the file, where, and what to do.
    pub fn read(
        file: DataFile<'_>,
        (source, at): (SourceId, Span),
        sources: &mut Sources,
    ) -> Result<Survey, Box<Diagnostic>> {
        let name = file.name;
        let mut mistakes = Mistakes { name, spec: source, sources };
        let mut lines = Lines::of(file, 0);
        let skip = preamble(&mut lines);
        let mut lines = lines.restarted(skip).map_err(|e| unreadable(name, (source, at), &e))?;
        let next = |lines: &mut Lines<'_>, mistakes: &mut Mistakes<'_>| {
            lines.next().map_err(|e| Box::new(mistakes.bad_line(at, &e)))
        };
        let Some(first) = next(&mut lines, &mut mistakes)? else {
            return Err(Box::new(mistakes.empty(at)));
        };
        let second = next(&mut lines, &mut mistakes)?;
        let dialect = Dialect::guess(None, None, &first.text, second.as_ref().map(|l| l.text.as_str()));
        let cells = |line: &Line| -> Vec<String> {
            dialect.fields(&line.text).iter().map(|f| dialect.unquoted(&line.text, f)).collect()
        };
        let heading = cells(&first);
        let has_header = heading.iter().any(|f| !looks_like_number(f));
        let mut headings: Vec<Heading> = if has_header {
            heading.iter().map(|h| Heading::parse(h)).collect()
        } else {
            (1..=heading.len()).map(|k| Heading::parse(&k.to_string())).collect()
        };
        let mut second = second;
        if let Some(units) = second.take_if(|l| has_header && is_units_row(&dialect, &l.text)) {
            let units = cells(&units);
            headings = headings.into_iter().zip(&units).map(|(h, u)| h.with_unit(u)).collect();
        }
        let width = headings.len();
        let make = |heading| Column { heading, values: vec![], words: 0, mistake: None };
        let mut survey = Survey {
            columns: headings.into_iter().map(make).collect(),
            lines: vec![],
            separator: dialect.separator,
            comma: false,
            has_header,
            skip,
            part: 1.0,
        };
        let (mut point, most) = (false, MOST_ROWS.min(MOST_NUMBERS / width.max(1)));
        let mut pending = [(!has_header).then_some(first), second].into_iter().flatten();
        loop {
            let line = match pending.next() {
                Some(line) => line,
                None => match next(&mut lines, &mut mistakes)? {
                    Some(line) => line,
                    None => break,
                },
            };
            let fields = dialect.fields(&line.text);
            if fields.len() != width {
                let d = mistakes.ragged(&line, fields.len(), width, (!has_header).then_some(false));
                // What was taken for the heading is perhaps none.
                let preamble = has_header && survey.lines.len() < 3;
                let help = "if other lines stand before the heading, put `#` in front of each of them";
                return Err(Box::new(if preamble { d.help(help) } else { d }));
            }
            survey.lines.push(line.number);
            for (field, column) in fields.iter().zip(&mut survey.columns) {
                let text = dialect.unquoted(&line.text, field);
                let comma = dialect.separator != Some(',') && text.contains(',');
                let number =
                    if comma { text.replacen(',', ".", 1).parse::<f64>() } else { text.parse::<f64>() };
                if let Ok(x) = number {
                    survey.comma |= comma;
                    point |= text.contains('.');
                    column.values.push(if x.is_finite() { x } else { f64::NAN });
                    continue;
                }
                column.values.push(f64::NAN);
                if !is_missing(&text) {
                    column.words += 1;
                    if column.mistake.is_none() {
                        let name = column.heading.raw.clone();
                        column.mistake =
                            Some(mistakes.not_a_number(&line, field.clone(), &name, &text, &dialect));
                    }
                }
            }
            if survey.lines.len() == most {
                survey.part = lines.part();
                break;
            }
        }
        let refused = |message: String, help: &str| {
            Err(Box::new(Diagnostic::error(message).at(source, at, "this file").help(help)))
        };
        if survey.comma && point {
            return refused(
                format!("`{name}` has numbers with a point and numbers with a comma"),
                "write all decimals alike: in one of them the mark is perhaps one of thousands",
            );
        }
        if width < 2 {
            return refused(
                format!("`{name}` has only one column"),
                "a record needs a column of time and one of motion, in lines like `0.01, 0.0023`",
            );
        }
        if survey.columns.iter().all(|c| c.values.iter().all(|x| x.is_nan())) && !survey.lines.is_empty() {
            return refused(
                format!("`{name}` holds no numbers"),
                "a data file has a heading line, then rows of numbers separated by commas, semicolons, tabs or blanks",
            );
        }
        if survey.lines.len() < FEWEST {
            return refused(
                format!("`{name}` has {} rows of numbers", survey.lines.len()),
                "that is too few to say anything: at least 20 are needed, some hundred are good",
            );
        }
        Ok(survey)
    }

    /// One more column, for a file without time: what the time would be at so many rows per second.
    pub(crate) fn count_rows(&mut self, rate: f64) -> usize {
        let values = (0..self.rows()).map(|k| k as f64 / rate).collect();
        let heading = Heading { unit: Some("s".to_owned()), ..Heading::parse("row") };
        self.columns.push(Column { heading, values, words: 0, mistake: None });
        self.columns.len() - 1
    }

    /// Number of rows that were read.
    pub(crate) fn rows(&self) -> usize {
        self.lines.len()
    }
}

/// Of the lines at the start of a file this many are looked at for its heading.
const START: usize = 100;

/// How many lines stand before the heading: those before the last line of words above the first rows of numbers.
fn preamble(lines: &mut Lines<'_>) -> usize {
    let mut start: Vec<Line> = Vec::new();
    while let (true, Ok(Some(line))) = (start.len() < START, lines.next()) {
        start.push(line);
    }
    let [.., before, last] = start.as_slice() else { return 0 };
    let dialect = Dialect::guess(None, None, &before.text, Some(&last.text));
    let width = dialect.fields(&last.text).len();
    let numbers = |line: &Line| {
        let fields = dialect.fields(&line.text);
        let good = fields.iter().filter(|f| looks_like_number(&dialect.unquoted(&line.text, f))).count();
        fields.len() == width && 2 * good > width
    };
    // A preamble may hold numbers too, but not as many in a row as fill the rest of what was read.
    let Some(words) = start.iter().rposition(|line| !numbers(line)) else { return 0 };
    let units = words > 0 && is_units_row(&dialect, &start[words].text);
    let heading = if units { words - 1 } else { words };
    match dialect.fields(&start[heading].text).len() == width && words + 3 < start.len() {
        true if heading > 0 => start[heading].number - 1,
        // Numbers without a heading, below lines of words.
        false if words + 3 < start.len() && width > 1 => start[words].number,
        _ => 0,
    }
}

/// How people write that there is no value.
fn is_missing(text: &str) -> bool {
    matches!(
        text.to_lowercase().as_str(),
        "" | "na" | "n/a" | "#n/a" | "#na" | "null" | "none" | "-" | "--" | "?" | "missing"
    )
}
