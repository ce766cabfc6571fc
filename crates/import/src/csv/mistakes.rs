//! What can be wrong with a data file, in words, with the line it happened in.

use super::dialect::Dialect;
use super::lines::{Line, LineError};
use phisindy_expr::{Span, nearest};
use phisindy_phys::spec::{CsvSpec, Spanned, Text};
use phisindy_phys::{Diagnostic, Severity, SourceId, Sources};
use std::io;
use std::ops::Range;

/// Longer lines are not drawn as a whole.
const WIDEST: usize = 160;

/// A file that cannot be read; `at` is where it is asked for.
pub fn unreadable(name: &str, (source, at): (SourceId, Span), error: &io::Error) -> Diagnostic {
    let help = match error.kind() {
        io::ErrorKind::IsADirectory => "name a file in it",
        io::ErrorKind::InvalidInput => "save the data in a file first",
        io::ErrorKind::PermissionDenied => "give yourself the right to read it (chmod u+r), or copy it",
        io::ErrorKind::NotFound => "check its name and its folder",
        _ => "copy the file to a disk that can be read",
    };
    Diagnostic::error(format!("cannot read `{name}`: {error}")).at(source, at, "asked for here").help(help)
}

/// Makes diagnostics about one file.
pub(crate) struct Mistakes<'a> {
    /// What the user calls the file.
    pub(crate) name: &'a str,
    /// The spec that asked for it.
    pub(crate) spec: SourceId,
    /// Receives the offending lines.
    pub(crate) sources: &'a mut Sources,
}

impl Mistakes<'_> {
    fn in_spec(&self, message: impl Into<String>, at: Span) -> Diagnostic {
        Diagnostic::error(message).at(self.spec, at, "asked for here")
    }

    /// An error in one field of a line.
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

    /// Keeps the line; of a very long one what surrounds the field.
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

    /// The last number of a file that ends without a line end is shorter than all above it.
    pub(crate) fn perhaps_cut(&mut self, line: &Line, field: &Range<usize>) -> Diagnostic {
        let message = format!(
            "`{}` ends in line {} without an end of line, perhaps inside its last number",
            self.name, line.number
        );
        let mut d = self.in_line(message, line, field, "shorter than in every line above");
        d.severity = Severity::Warning;
        d.help("if the file was cut off, copy it again or delete its last line; if not, end the line")
    }

    pub(crate) fn bad_line(&mut self, at: Span, error: &LineError) -> Diagnostic {
        match error {
            LineError::Io(e) => unreadable(self.name, (self.spec, at), e),
            LineError::Utf16 => self
                .in_spec(format!("`{}` is UTF-16 text, not UTF-8", self.name), at)
                .help("save the file as CSV in UTF-8"),
            LineError::Endless(number) => self
                .in_spec(format!("line {number} of `{}` does not end: this is no table", self.name), at)
                .help("a data file is text, one row of numbers on each line"),
            LineError::Changed => self
                .in_spec(format!("`{}` changed while it was read", self.name), at)
                .help("wait until it is written completely, or copy it and read the copy"),
            LineError::NotText(good, number) => {
                let line = Line { text: good.clone(), number: *number, ended: true };
                let end = good.len();
                self.in_line(
                    format!("`{}` is not UTF-8 text", self.name),
                    &line,
                    &(end..end),
                    "a byte that is no character follows here",
                )
                .help("save the file as CSV in UTF-8")
            }
        }
    }

    pub(crate) fn empty(&self, at: Span) -> Diagnostic {
        self.in_spec(format!("the data file `{}` is empty", self.name), at)
            .help("give a file with a heading line and rows of numbers")
    }

    pub(crate) fn too_few(&self, at: Span, rows: usize, selected: bool) -> Diagnostic {
        let count = match rows {
            0 => "no row".to_owned(),
            1 => "one row".to_owned(),
            n => format!("{n} rows"),
        };
        let d = if selected {
            self.in_spec(format!("{count} of `{}` {} selected", self.name, if rows > 1 { "are" } else { "is" }), at)
                .help("`rows` keeps the rows where every one of these columns has the given value: change the values")
        } else {
            self.in_spec(format!("the data file `{}` has {count} of numbers", self.name), at)
        };
        d.help("a record needs at least 10 rows")
    }

    /// A run that the file does not have.
    pub(crate) fn no_run(&self, wanted: &Spanned<u64>, runs: u64) -> Diagnostic {
        let message = format!("`{}` has {runs} runs, so none has the number {}", self.name, wanted.value);
        self.in_spec(message, wanted.span)
            .help("runs are counted from 0; a new one begins where the time goes back")
    }

    /// More samples than a fit can use. `part` of the file was read, up to the time `extent.1`.
    pub(crate) fn too_many(
        &self,
        csv: &CsvSpec,
        most: usize,
        extent: Option<(f64, f64)>,
        part: f64,
    ) -> Diagnostic {
        let at = csv.window.as_ref().map_or(csv.path.span, |(a, b)| a.span.to(b.span));
        let message = format!("`{}` has more than {} samples for one record", self.name, grouped(most));
        let mut d = self.in_spec(message, at);
        // Twenty thousand samples are plenty for a model with a dozen unknowns.
        let now = csv.decimate.as_ref().map_or(1, |d| d.value) as f64;
        let every = (now * most as f64 / part.max(1e-6) / 20_000.0).ceil();
        d = d.help(format!(
            "take the mean of every {every} rows, for about 20 000 samples: `decimate: {every}`"
        ));
        if let Some((first, last)) = extent {
            d = d.help(format!(
                "or take a part: `window: ({first:?}, {:?})` would do",
                first + 0.01 * (last - first)
            ));
        }
        d
    }

    /// A column that the heading does not have.
    pub(crate) fn no_column(&mut self, wanted: &Text, names: &[String], header: Option<&Line>) -> Diagnostic {
        let message = format!("the data file `{}` has no column `{}`", self.name, wanted.value);
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
            d = d.help(format!("did you mean `{near}`?"));
        }
        let list: Vec<&str> = names.iter().take(20).map(String::as_str).collect();
        let more = if names.len() > 20 { format!(" and {} more", names.len() - 20) } else { String::new() };
        d = d.help(format!("columns of the file: {}{more}", list.join(", ")));
        if header.is_none() {
            d = d.help("the file has no heading line, so its columns are called 1, 2, ...; if it has one, say `header: true`");
        } else if names.len() == 1 {
            d = d.help(
                "the whole line is one field: say how fields are separated, for example `separator: ';'`",
            );
        }
        d
    }

    /// A column that the heading has twice.
    pub(crate) fn twice(
        &mut self,
        wanted: &Text,
        line: &Line,
        a: Range<usize>,
        b: Range<usize>,
    ) -> Diagnostic {
        let (first, first_at) = self.excerpt(line, &a);
        self.in_line(
            format!("the data file `{}` has two columns `{}`", self.name, wanted.value),
            line,
            &b,
            "again here",
        )
        .also(first, first_at, "first here")
        .also(self.spec, wanted.span, "asked for here")
        .help("rename one of them in the file")
    }

    /// A line with more or fewer fields than the heading.
    pub(crate) fn ragged(
        &mut self,
        line: &Line,
        found: usize,
        wanted: usize,
        header: Option<bool>,
    ) -> Diagnostic {
        let count = |n: usize| if n == 1 { "1 field".to_owned() } else { format!("{n} fields") };
        let whole = 0..line.text.len();
        if found < wanted && !line.ended {
            let message = format!("`{}` ends in the middle of line {}", self.name, line.number);
            return self
                .in_line(message, line, &whole, &format!("{} of {wanted}", count(found)))
                .help("the file was cut off: copy it again, or delete its last line");
        }
        let first = if header == Some(false) { "the first line" } else { "the heading" };
        let message =
            format!("line {} of `{}` has {}, {first} has {wanted}", line.number, self.name, count(found));
        self.in_line(message, line, &whole, &count(found))
            .help("every line needs one field for each column; an unmeasured row is best deleted")
    }

    pub(crate) fn not_a_number(
        &mut self,
        line: &Line,
        field: Range<usize>,
        column: &str,
        text: &str,
        dialect: &Dialect,
    ) -> Diagnostic {
        let message = if text.is_empty() {
            format!("column `{column}` has no value in line {}", line.number)
        } else {
            format!("column `{column}` holds the text `{text}` in line {}", line.number)
        };
        let mut d = self.in_line(message, line, &field, "not a number");
        if text.contains(',') && dialect.decimal != Some(',') {
            d = d.help("if the comma is a decimal mark, say `decimal: ','`");
        } else if text.contains('.') && dialect.decimal == Some(',') {
            d = d.help("the spec says `decimal: ','`, and this number has a point");
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
        self.in_line(format!("column `{column}` is `{text}` in line {}", line.number), line, &field, "not a finite number")
            .help("delete the line, or leave it out with `window` or `rows`: a gap in time does no harm, an invented value does")
    }

    pub(crate) fn two_marks(
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

    /// A time that does not come after the one before.
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn time_order(
        &mut self,
        line: &Line,
        place: Range<usize>,
        time: f64,
        before: &Line,
        there: Range<usize>,
        earlier: f64,
        whole_file: bool,
    ) -> Diagnostic {
        let message = if time == earlier {
            format!(
                "the time {time} stands twice in `{}`, in lines {} and {}",
                self.name, before.number, line.number
            )
        } else {
            format!("the time goes back from {earlier} to {time} in line {} of `{}`", line.number, self.name)
        };
        let mut d = if before.number + 1 == line.number && before.text.len() + line.text.len() < WIDEST {
            let text = format!("{}\n{}", before.text, line.text);
            let source = self.sources.add_excerpt(self.name, text, before.number);
            let at = span(&place).shifted(before.text.len() + 1);
            Diagnostic::error(message).at(source, at, "not later").also(source, span(&there), "than this")
        } else {
            let (source, at) = self.excerpt(before, &there);
            self.in_line(message, line, &place, "not later").also(source, at, "than this")
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

/// The bytes of a range as a span.
fn span(range: &Range<usize>) -> Span {
    Span::new(range.start, range.end)
}

/// 2000000 as `2 000 000`.
fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let pieces: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|p| std::str::from_utf8(p).ok()).collect();
    pieces.join(" ")
}
