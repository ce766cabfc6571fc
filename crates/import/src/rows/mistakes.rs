//! Diagnostics for mistakes in a text file, with the offending line.

use super::dialect::{Dialect, is_infinite, is_missing};
use super::line::{Line, LineError};
use super::thousands::{Marks, is_grouped};
use crate::data_file::unreadable;
use crate::listing;
use phisindy_expr::{Span, nearest};
use phisindy_phys::spec::Text;
use phisindy_phys::{Diagnostic, Severity, SourceId, Sources};
use std::ops::Range;

/// What to do about a missing value.
const OMIT: &str = "to leave out the rows that lack a value, say `missing: Omit` in the record: a short gap in time does no harm";
/// Longest line that is shown in full.
const WIDEST: usize = 160;

/// Creates the diagnostics for one file.
pub(crate) struct Mistakes<'a> {
    /// Name of the file in messages.
    pub(crate) name: &'a str,
    /// What a message calls a line: text has lines, other formats rows.
    pub(crate) line: &'static str,
    /// The spec that names the file.
    pub(crate) spec: SourceId,
    /// Receives copies of the offending lines.
    pub(crate) sources: &'a mut Sources,
}

impl Mistakes<'_> {
    fn in_spec(&self, message: impl Into<String>, at: Span) -> Diagnostic {
        Diagnostic::error(message).at(self.spec, at, "asked for here")
    }

    /// An error in a field of a line.
    fn in_line(
        &mut self,
        message: impl Into<String>,
        line: &Line,
        field: &Range<usize>,
        label: &str,
    ) -> Diagnostic {
        let (source, at) = self.excerpt(line, field);
        Diagnostic::error(message).at(source, at, label)
    }

    /// Stores the line, or the surroundings of the field in a long one.
    fn excerpt(&mut self, line: &Line, field: &Range<usize>) -> (SourceId, Span) {
        if line.text.len() <= WIDEST {
            return (self.sources.add_excerpt(self.name, line.text.clone(), line.number), span(field));
        }
        let boundary = |mut at: usize| {
            while !line.text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let from = boundary(field.start.saturating_sub(WIDEST / 2).min(line.text.len()));
        let to = boundary((from + WIDEST).min(line.text.len()));
        let piece = line.text[from..to].to_owned();
        let end = field.end.min(to).max(field.start) - from;
        (self.sources.add_excerpt(self.name, piece, line.number), Span::new(field.start - from, end))
    }

    /// The file ends without line end, and its last field is shorter than all above it.
    pub(crate) fn truncated(&mut self, line: &Line, field: &Range<usize>) -> Diagnostic {
        let message = format!(
            "`{}` ends in line {} without an end of line, perhaps inside its last number",
            self.name, line.number
        );
        let mut d = self.in_line(message, line, field, "shorter than in every line above");
        d.severity = Severity::Warning;
        d.help("if the file was cut off, copy it again or delete its last line; if not, end the line")
    }

    pub(crate) fn unreadable_line(&mut self, at: Span, error: &LineError) -> Diagnostic {
        match error {
            LineError::Io(e) => unreadable(self.name, (self.spec, at), e),
            LineError::Format(refusal) => {
                let d = self.in_spec(refusal.message.clone(), at);
                refusal.help.iter().fold(d, |d, help| d.help(help.clone()))
            }
            LineError::TooLong(number) => self
                .in_spec(format!("line {number} of `{}` does not end: this is no table", self.name), at)
                .help("a data file is text, one row of numbers on each line"),
            LineError::Changed => self
                .in_spec(format!("`{}` changed while it was read", self.name), at)
                .help("wait until it is written completely, or copy it and read the copy"),
            LineError::NotText(good, number) => {
                let line = Line { text: good.clone(), number: *number, ended: true };
                let end = good.len();
                self.in_line(
                    format!("`{}` is neither text nor a format that is known", self.name),
                    &line,
                    &(end..end),
                    "a zero byte follows here",
                )
                .help("export the data as text, or in a format that the reference lists under `Table`")
            }
        }
    }

    pub(crate) fn empty(&self, at: Span) -> Diagnostic {
        self.in_spec(format!("the data file `{}` is empty", self.name), at)
            .help("give a file with a heading line and rows of numbers")
    }

    /// The heading lacks a column.
    pub(crate) fn missing_column(
        &mut self,
        wanted: &Text,
        names: &[String],
        header: Option<&Line>,
    ) -> Diagnostic {
        let message =
            format!("the data file `{}` has no column `{}`", self.name, listing::name(&wanted.value));
        let mut d = Diagnostic::error(message).at(self.spec, wanted.span, "asked for here");
        let near = nearest(&wanted.value, names.iter().map(String::as_str));
        if let Some(line) = header {
            let field = near.and_then(|n| line.text.find(n).map(|at| at..at + n.len()));
            let (place, words) = match field {
                Some(field) => (field, "the nearest heading"),
                None => (0..line.text.len().min(WIDEST), "the headings"),
            };
            let (source, at) = self.excerpt(line, &place);
            d = d.also(source, at, words);
        }
        if let Some(near) = near {
            d = d.help(format!("did you mean `{}`?", listing::name(near)));
        }
        d = d.help(format!("columns of the file: {}", listing::listing(names)));
        if header.is_none() {
            d = d.help("the file has no heading line, so its columns are called 1, 2, ...; if it has one, say `header: true`");
        } else if names.len() == 1 {
            d = d.help(
                "the whole line is one field: say how fields are separated, for example `separator: ';'`",
            );
        }
        d
    }

    /// The heading has a column twice.
    pub(crate) fn duplicate_column(
        &mut self,
        wanted: &Text,
        line: &Line,
        a: Range<usize>,
        b: Range<usize>,
    ) -> Diagnostic {
        let (first, first_at) = self.excerpt(line, &a);
        self.in_line(
            format!("the data file `{}` has two columns `{}`", self.name, listing::name(&wanted.value)),
            line,
            &b,
            "again here",
        )
        .also(first, first_at, "first here")
        .also(self.spec, wanted.span, "asked for here")
        .help("rename one of them in the file")
    }

    /// A line has more or fewer fields than the heading.
    pub(crate) fn field_count(
        &mut self,
        line: &Line,
        fields: usize,
        wanted: usize,
        header: Option<bool>,
        dialect: &Dialect,
    ) -> Diagnostic {
        let count = |n: usize| if n == 1 { "1 field".to_owned() } else { format!("{n} fields") };
        let whole = 0..line.text.len();
        if fields < wanted && !line.ended {
            let message = format!("`{}` ends in the middle of line {}", self.name, line.number);
            return self
                .in_line(message, line, &whole, &format!("{} of {wanted}", count(fields)))
                .help("the file was cut off: copy it again, or delete its last line");
        }
        let first = if header == Some(false) { "the first line" } else { "the heading" };
        let message =
            format!("line {} of `{}` has {}, {first} has {wanted}", line.number, self.name, count(fields));
        self.in_line(message, line, &whole, &count(fields)).help(if dialect.may_split_decimals(&line.text) {
            "if the comma is the decimal mark too, nothing tells the fields apart: export them with `;` in between"
        } else {
            "every line needs one field for each column; an unmeasured row is best deleted"
        })
    }

    pub(crate) fn not_a_number(
        &mut self,
        line: &Line,
        field: Range<usize>,
        column: &str,
        text: &str,
        dialect: &Dialect,
    ) -> Diagnostic {
        let (column, shown) = (listing::name(column), listing::name(text));
        let message = if text.is_empty() {
            format!("column `{column}` has no value in {} {}", self.line, line.number)
        } else {
            format!("column `{column}` holds the text `{shown}` in {} {}", self.line, line.number)
        };
        let mut d = self.in_line(message, line, &field, "not a number");
        if is_grouped(text) {
            d = d.help("write numbers without marks of thousands: `1234.5`");
        } else if text.replacen(',', ".", 1).parse::<f64>().is_ok() && dialect.decimal != Some(',') {
            d = d.help("if the comma is a decimal mark, say `decimal: ','`");
        } else if text.contains('.') && dialect.decimal == Some(',') {
            d = d.help("the spec says `decimal: ','`, and this number has a point");
        } else if is_missing(text) {
            d = d.help(OMIT);
        } else {
            d = d.help("correct or delete the line, or leave it out with `window` or `rows`");
        }
        d
    }

    pub(crate) fn not_finite(
        &mut self,
        line: &Line,
        field: Range<usize>,
        column: &str,
        text: &str,
    ) -> Diagnostic {
        let (column, shown) = (listing::name(column), listing::name(text));
        let message = format!("column `{column}` is `{shown}` in {} {}", self.line, line.number);
        let d = self.in_line(message, line, &field, "not a finite number");
        d.help(if is_missing(text) || is_infinite(text) {
            OMIT
        } else {
            "delete the line, or leave it out with `window` or `rows`: a gap in time does no harm, an invented value does"
        })
    }

    pub(crate) fn mixed_decimal_marks(
        &mut self,
        line: &Line,
        field: Range<usize>,
        point: &str,
        comma: &str,
    ) -> Diagnostic {
        self.in_line(
            format!("`{}` has numbers with a point (`{point}`) and with a comma (`{comma}`)", self.name),
            line,
            &field,
            "",
        )
        .help("say which is the decimal mark: `decimal: '.'` or `decimal: ','`")
    }

    /// Whether the mark in the numbers of a column is one of thousands is in doubt.
    pub(crate) fn thousands(&self, column: &str, marks: &Marks, at: Span) -> Option<Diagnostic> {
        let (three, hundreds) = marks.doubt()?;
        let (column, name) = (listing::name(column), self.name);
        let message = format!(
            "column `{column}` of `{name}` has `{three}` beside `{hundreds}`: is its mark one of thousands?"
        );
        let d = Diagnostic::error(message).at(self.spec, at, "this file");
        Some(d.help("write numbers without marks of thousands: `1234`; or give all of them their decimals"))
    }

    /// The time of a row is not later than that of the previous row.
    pub(crate) fn time_order(&mut self, now: &TimeCell, before: &TimeCell, whole_file: bool) -> Diagnostic {
        let (time, earlier) = (now.time, before.time);
        let (line, other) = (&now.line, &before.line);
        let message = if time == earlier {
            format!(
                "the time {time} stands twice in `{}`, in {}s {} and {}",
                self.name, self.line, other.number, line.number
            )
        } else {
            let place = format!("{} {} of `{}`", self.line, line.number, self.name);
            format!("the time goes back from {earlier} to {time} in {place}")
        };
        let mut d = if other.number + 1 == line.number && other.text.len() + line.text.len() < WIDEST {
            let text = format!("{}\n{}", other.text, line.text);
            let source = self.sources.add_excerpt(self.name, text, other.number);
            let at = span(&now.field).shifted(other.text.len() + 1);
            let than = span(&before.field);
            Diagnostic::error(message).at(source, at, "not later").also(source, than, "than this")
        } else {
            let (source, at) = self.excerpt(other, &before.field);
            self.in_line(message, line, &now.field, "not later").also(source, at, "than this")
        };
        d = d.help("time must grow from row to row: delete or correct the row");
        if whole_file && time < earlier {
            d = d.help(
                "if the file holds several runs, take one of them: `run: 0`, or `rows: { \"trial\": 0.0 }` by a column that counts them",
            );
        }
        d
    }
}

/// The time of a row with its position.
pub(crate) struct TimeCell {
    pub(crate) line: Line,
    pub(crate) field: Range<usize>,
    /// In the unit of the file.
    pub(crate) time: f64,
}

/// The bytes of a range as a span.
fn span(range: &Range<usize>) -> Span {
    Span::new(range.start, range.end)
}
