//! Diagnostics as text for people: the place with its line, marked, and what to do.

mod clip;

use clip::Clipped;
use codespan_reporting::diagnostic as drawn;
use codespan_reporting::files::{self, Files};
use codespan_reporting::term::{self, Config, termcolor};
use phisindy_phys::{Diagnostic, Severity, Sources};
use std::borrow::Cow;
use std::io::{self, IsTerminal, Write};
use std::ops::Range;

/// Whether colours are wanted: not if NO_COLOR is set (no-color.org).
pub(crate) fn colours() -> bool {
    std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
}

/// Draws on standard error, in colour if that is a terminal and NO_COLOR is not set.
pub(crate) fn show<'d>(diagnostics: impl IntoIterator<Item = &'d Diagnostic>, sources: &Sources) {
    let colour = io::stderr().is_terminal() && colours();
    for diagnostic in diagnostics {
        let mut buffer = if colour { termcolor::Buffer::ansi() } else { termcolor::Buffer::no_color() };
        draw_or_tell(&mut buffer, diagnostic, sources);
        // Nobody is left to complain to if standard error is closed.
        let _ = io::stderr().write_all(buffer.as_slice());
    }
}

/// The same as text without colours.
pub(crate) fn text<'d>(diagnostics: impl IntoIterator<Item = &'d Diagnostic>, sources: &Sources) -> String {
    let mut buffer = termcolor::Buffer::no_color();
    diagnostics.into_iter().for_each(|d| draw_or_tell(&mut buffer, d, sources));
    String::from_utf8_lossy(buffer.as_slice()).into_owned()
}

fn draw_or_tell(buffer: &mut termcolor::Buffer, diagnostic: &Diagnostic, sources: &Sources) {
    if draw(buffer, diagnostic, sources).is_err() {
        // A place outside of its text would be a mistake of this program; the message matters more.
        let _ = writeln!(buffer, "{}\n{}", diagnostic.message, diagnostic.help.join("\n"));
    }
}

/// Draws one diagnostic.
fn draw(
    buffer: &mut termcolor::Buffer,
    diagnostic: &Diagnostic,
    sources: &Sources,
) -> Result<(), files::Error> {
    let clipped = Clipped::new(diagnostic, sources);
    let drawn = converted(&clipped.diagnostic, &clipped.sources);
    term::emit_to_write_style(
        &mut Printable(buffer),
        &Config::default(),
        &Texts { whole: sources, clipped: &clipped },
        &drawn,
    )
}

/// What is drawn may quote somebody else's file: its control bytes must not reach the terminal.
struct Printable<'a>(&'a mut termcolor::Buffer);

/// The text with a question mark in the place of each control byte that is no line end and no tab.
pub(crate) fn printable(text: &[u8]) -> Vec<u8> {
    let shown = |byte: &u8| if byte.is_ascii_control() && !b"\n\t".contains(byte) { b'?' } else { *byte };
    text.iter().map(shown).collect()
}

/// The same of a text whose colours are the program's own.
pub(crate) fn coloured(text: &str) -> Cow<'_, str> {
    let mut parts = text.split('\u{1b}');
    let plain = |part: &str| part.replace(|c: char| c.is_control() && !"\n\t".contains(c), "?");
    let mut out = plain(parts.next().unwrap_or_default());
    for part in parts {
        let code = part
            .strip_prefix('[')
            .map(|code| code.trim_start_matches(|c: char| c.is_ascii_digit() || c == ';'));
        out.push(if code.is_some_and(|rest| rest.starts_with('m')) { '\u{1b}' } else { '?' });
        out += &plain(part);
    }
    out.into()
}

impl Write for Printable<'_> {
    fn write(&mut self, text: &[u8]) -> io::Result<usize> {
        self.0.write_all(&printable(text))?;
        Ok(text.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

impl termcolor::WriteColor for Printable<'_> {
    fn supports_color(&self) -> bool {
        self.0.supports_color()
    }
    fn set_color(&mut self, spec: &termcolor::ColorSpec) -> io::Result<()> {
        self.0.set_color(spec)
    }
    fn reset(&mut self) -> io::Result<()> {
        self.0.reset()
    }
}

/// A diagnostic in the terms of the drawing crate.
fn converted(diagnostic: &Diagnostic, sources: &Sources) -> drawn::Diagnostic<usize> {
    let severity = match diagnostic.severity {
        Severity::Error => drawn::Severity::Error,
        Severity::Warning => drawn::Severity::Warning,
    };
    let labels = diagnostic.labels.iter().map(|label| {
        let style = if label.primary { drawn::LabelStyle::Primary } else { drawn::LabelStyle::Secondary };
        let range = inside(label.span.range(), &sources.get(label.source).text);
        drawn::Label::new(style, label.source.0, range).with_message(&label.message)
    });
    drawn::Diagnostic::new(severity)
        .with_message(&diagnostic.message)
        .with_labels(labels.collect())
        .with_notes(diagnostic.help.iter().map(|line| format!("help: {line}")).collect())
}

/// The range moved to whole characters inside of the text, so that drawing cannot fail.
fn inside(range: Range<usize>, text: &str) -> Range<usize> {
    let boundary = |mut at: usize| {
        at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let start = boundary(range.start);
    start..boundary(range.end).max(start)
}

/// The texts that were read, line numbers counted from where each piece stands in its file.
struct Texts<'a> {
    whole: &'a Sources,
    clipped: &'a Clipped<'a>,
}

impl<'a> Texts<'a> {
    fn text(&self, id: usize) -> Result<&'a str, files::Error> {
        self.clipped.sources.files.get(id).map(|f| f.text.as_str()).ok_or(files::Error::FileMissing)
    }
}

impl<'a> Files<'a> for Texts<'_> {
    type FileId = usize;
    type Name = &'a str;
    type Source = &'a str;

    fn name(&'a self, id: usize) -> Result<&'a str, files::Error> {
        self.whole.files.get(id).map(|f| f.name.as_str()).ok_or(files::Error::FileMissing)
    }

    fn source(&'a self, id: usize) -> Result<&'a str, files::Error> {
        self.text(id)
    }

    fn line_index(&'a self, id: usize, byte: usize) -> Result<usize, files::Error> {
        let text = self.text(id)?;
        Ok(text.as_bytes()[..byte.min(text.len())].iter().filter(|&&b| b == b'\n').count())
    }

    fn line_number(&'a self, id: usize, line: usize) -> Result<usize, files::Error> {
        self.whole.files.get(id).map(|f| f.first_line + line).ok_or(files::Error::FileMissing)
    }

    fn column_number(&'a self, id: usize, line: usize, byte: usize) -> Result<usize, files::Error> {
        let here = || Ok(files::column_index(self.text(id)?, self.line_range(id, line)?, byte) + 1);
        self.clipped.column(self.whole, id, byte).map_or_else(here, Ok)
    }

    fn line_range(&'a self, id: usize, line: usize) -> Result<Range<usize>, files::Error> {
        let text = self.text(id)?;
        let mut starts = files::line_starts(text).skip(line);
        let max = || files::line_starts(text).count();
        let start = starts.next().ok_or_else(|| files::Error::LineTooLarge { given: line, max: max() })?;
        Ok(start..starts.next().unwrap_or(text.len()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phisindy_expr::Span;

    #[test]
    fn an_excerpt_is_drawn_with_the_line_number_of_its_file() {
        let mut sources = Sources::default();
        let id = sources.add_excerpt("a.csv", "0.5,1\n0.5,2", 12);
        let d = Diagnostic::error("time stands").at(id, Span::new(6, 9), "not later").help("delete it");
        let text = drawn_text(&d, &sources);
        assert!(text.contains("a.csv:13:1"), "{text}");
        assert!(text.contains("= help: delete it"), "{text}");
    }

    #[test]
    fn places_outside_of_the_text_do_no_harm() {
        let mut sources = Sources::default();
        let id = sources.add("a.ron", "é");
        for span in [Span::new(1, 1), Span::new(7, 9), Span::new(2, 0), Span::new(0, 1)] {
            let d = Diagnostic::warning("odd").at(id, span, "");
            assert!(drawn_text(&d, &sources).contains("odd"));
        }
    }

    /// Ten thousand parentheses, marked in two places far apart: what is shown fits a screen, and the place
    /// is the real one.
    #[test]
    fn long_lines_are_clipped_around_what_is_marked() {
        let mut sources = Sources::default();
        let text = format!("(\n  a: \"{}é{}\",\n)", "(".repeat(10_000), ")".repeat(10_000));
        let id = sources.add("a.ron", text);
        for span in
            [Span::new(5_000, 5_001), Span::new(3, 20_000), Span::new(10_007, 10_010), Span::new(0, 20_012)]
        {
            let d =
                Diagnostic::error("odd").at(id, span, "here").also(id, Span::new(15_000, 15_002), "there");
            let drawn = drawn_text(&d, &sources);
            assert!(drawn.lines().all(|line| line.chars().count() < 400), "{drawn}");
            assert!(drawn.contains("there") && drawn.contains("..."), "{drawn}");
        }
        let d = Diagnostic::error("odd").at(id, Span::new(5_000, 5_001), "here");
        assert!(drawn_text(&d, &sources).contains("a.ron:2:4999"), "{}", drawn_text(&d, &sources));
    }

    fn drawn_text(diagnostic: &Diagnostic, sources: &Sources) -> String {
        let mut buffer = termcolor::Buffer::no_color();
        draw(&mut buffer, diagnostic, sources).expect("drawn");
        String::from_utf8(buffer.into_inner()).expect("UTF-8")
    }
}
