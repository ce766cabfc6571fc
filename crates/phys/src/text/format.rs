//! `phisindy fmt`: the white space of a spec or a law, and nothing else. Values, comments and their order stay.
//!
//! ```text
//! text --pieces--> tokens and comments --entries--> what stands between commas --Printer--> text
//! ```
//!
//! Brackets stay on one line where they fit, unless their author began a new line after the opening one; what
//! began a line goes on to do so. The fields of the whole stand below each other.

use crate::text::diagnostic::{Diagnostic, SourceId};
use crate::text::raw::{Kind, Mistake, comment_length, fits, parse, tokens};

/// Most characters of a line, where a break can keep to it.
const WIDTH: usize = 110;
/// By how much a bracket indents what it holds.
const INDENT: usize = 4;

/// The text of a spec or a law with its white space as it should be.
///
/// # Errors
/// The text is not RON.
///
/// ```
/// use phisindy_phys::{SourceId, format};
/// let text = "(states:{\"x\" : \"m\"}, // metres\n  contacts:[ ])";
/// let formatted = "(\n    states: { \"x\": \"m\" }, // metres\n    contacts: [],\n)\n";
/// assert_eq!(format(text, SourceId(0)).unwrap(), formatted);
/// assert_eq!(format(formatted, SourceId(0)).unwrap(), formatted);
/// ```
pub fn format(text: &str, source: SourceId) -> Result<String, Diagnostic> {
    let (head, pieces) = pieces(text).map_err(|mistake| mistake.diagnostic(source))?;
    let ending = if text.find('\n').is_some_and(|at| text[..at].ends_with('\r')) { "\r\n" } else { "\n" };
    let mut printer = Printer { out: head.to_owned(), indent: 0, ending };
    printer.entries(&Reader { pieces: &pieces, at: 0, late: vec![] }.entries(), Layout::Whole);
    let formatted = printer.out + ending;
    // Deep brackets on many lines take more room than on one: nobody could read the text any more.
    fits(&formatted).map_err(|mistake| mistake.diagnostic(source))?;
    Ok(formatted)
}

/// A token or a comment.
#[derive(Clone, Copy, Debug)]
struct Piece<'t> {
    text: &'t str,
    what: What,
    /// Line ends in front of it; two are an empty line.
    newlines: usize,
    /// Where it stood in its line, if more than a space away from what is in front of it.
    column: Option<usize>,
    /// Whether nothing stands behind it in its line.
    last: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    Token(Kind),
    /// `// ...`
    LineComment,
    /// `/* ... */`
    BlockComment,
}

/// What a text is made of, white space left out; and what stands in front of it if that is an attribute
/// (`#![enable(...)]`), which stays as it is.
fn pieces(text: &str) -> Result<(&str, Vec<Piece<'_>>), Mistake> {
    let (root, tokens) = (parse(text)?, tokens(text)?);
    let attribute = tokens.first().is_some_and(|first| text[first.span.range()].starts_with('#'));
    let (head, end) = (if attribute { root.span.start } else { 0 }, text.len());
    let mut all: Vec<Piece<'_>> = Vec::new();
    let mut at = head;
    let mut add = |space: usize, start: usize, end: usize, what| {
        let newlines = text[space..start].matches('\n').count();
        let column = (newlines == 0 && start - space > 1).then(|| {
            let line = text[..start].rfind('\n').map_or(0, |end| end + 1);
            text[line..start].chars().count()
        });
        all.iter_mut().last().into_iter().for_each(|previous: &mut Piece<'_>| previous.last = newlines > 0);
        all.push(Piece { text: text[start..end].trim_end(), what, newlines, column, last: true });
    };
    let tokens = tokens.into_iter().filter(|t| t.span.start >= head).map(|t| (t.span.range(), Some(t.kind)));
    for (span, kind) in tokens.chain([(end..end, None)]) {
        // Between two tokens there is nothing but white space and comments.
        while let Some(found) = text[at..span.start].find('/') {
            let start = at + found;
            let block = if text[start..].starts_with("/*") { comment_length(&text[start..]) } else { None };
            let line = || text[start..].find('\n').unwrap_or(end - start);
            let what = if block.is_some() { What::BlockComment } else { What::LineComment };
            let after = start + block.unwrap_or_else(line);
            add(at, start, after, what);
            at = after;
        }
        if let Some(kind) = kind {
            add(at, span.start, span.end, What::Token(kind));
            at = span.end;
        }
    }
    Ok((&text[..head], all))
}

impl Piece<'_> {
    fn is_comment(&self) -> bool {
        matches!(self.what, What::LineComment | What::BlockComment)
    }

    /// The piece, where others may stand behind it in its line.
    fn flat(&self) -> Option<&str> {
        (self.what != What::LineComment && !self.text.contains('\n')).then_some(self.text)
    }
}

/// What stands between two commas. The last one of a bracket may be nothing but comments.
#[derive(Debug, Default)]
struct Entry<'t> {
    /// Comments in front of it.
    before: Vec<Piece<'t>>,
    parts: Vec<Part<'t>>,
    /// Comments behind it and its comma, in its line.
    after: Vec<Piece<'t>>,
}

#[derive(Debug)]
enum Part<'t> {
    Piece(Piece<'t>),
    Brackets(Brackets<'t>),
}

#[derive(Debug)]
struct Brackets<'t> {
    open: Piece<'t>,
    close: &'t str,
    /// Whether their author began a new line after the opening one.
    broken: bool,
    entries: Vec<Entry<'t>>,
}

impl Entry<'_> {
    /// Line ends in front of it.
    fn newlines(&self) -> usize {
        self.before.first().or_else(|| self.parts.first().map(Part::first)).map_or(0, |piece| piece.newlines)
    }

    /// All in front of its comma on one line, where it can be.
    fn flat(&self) -> Option<String> {
        let mut text = String::new();
        for (k, comment) in self.before.iter().enumerate() {
            text += comment.flat()?;
            text += if self.parts.is_empty() && k + 1 == self.before.len() { "" } else { " " };
        }
        for (k, part) in self.parts.iter().enumerate() {
            text += if k > 0 && self.parts[k - 1].apart(part) { " " } else { "" };
            match part {
                Part::Piece(piece) => text += piece.flat()?,
                Part::Brackets(brackets) => text += &brackets.flat()?,
            }
        }
        Some(text)
    }
}

impl Part<'_> {
    fn first(&self) -> &Piece<'_> {
        match self {
            Part::Piece(piece) => piece,
            Part::Brackets(brackets) => &brackets.open,
        }
    }

    /// Whether a space stands between it and the part behind it.
    fn apart(&self, next: &Part<'_>) -> bool {
        let (this, next, colon) = (self.first(), next.first(), What::Token(Kind::Colon));
        next.what != colon && (this.what == colon || this.is_comment() || next.is_comment())
    }
}

impl Brackets<'_> {
    /// All on one line, where it can be.
    fn flat(&self) -> Option<String> {
        let mut inside = String::new();
        for (k, entry) in self.entries.iter().enumerate() {
            inside += if k > 0 { " " } else { "" };
            inside += &entry.flat()?;
            inside +=
                if self.entries.get(k + 1).is_some_and(|next| !next.parts.is_empty()) { "," } else { "" };
            for comment in &entry.after {
                inside += " ";
                inside += comment.flat()?;
            }
        }
        let space = if self.open.text == "{" && !inside.is_empty() { " " } else { "" };
        (!self.broken).then(|| format!("{}{space}{inside}{space}{}", self.open.text, self.close))
    }
}

/// Joins pieces to entries. It recurses no deeper than the brackets, which [`tokens`] has limited.
struct Reader<'p, 't> {
    pieces: &'p [Piece<'t>],
    at: usize,
    /// Comments in lines of their own in front of a comma or the end: they belong to what follows.
    late: Vec<Piece<'t>>,
}

impl<'t> Reader<'_, 't> {
    fn peek(&self) -> Option<Piece<'t>> {
        self.pieces.get(self.at).copied()
    }

    /// Up to the end, or the bracket that closes.
    fn entries(&mut self) -> Vec<Entry<'t>> {
        let ends =
            |piece: Option<Piece<'_>>| piece.is_none_or(|p| matches!(p.what, What::Token(Kind::Close(_))));
        let mut entries = Vec::new();
        while !ends(self.peek()) || !self.late.is_empty() {
            entries.push(self.entry());
        }
        entries
    }

    fn entry(&mut self) -> Entry<'t> {
        let mut entry = Entry { before: std::mem::take(&mut self.late), ..Entry::default() };
        let mut comments: Vec<Piece<'t>> = Vec::new();
        while let Some(piece) = self.peek() {
            match piece.what {
                What::Token(Kind::Close(_) | Kind::Comma) => break,
                What::Token(kind) => {
                    self.at += 1;
                    entry.parts.extend(comments.drain(..).map(Part::Piece));
                    let opens = matches!(kind, Kind::Open(_));
                    entry.parts.push(if opens { self.brackets(piece) } else { Part::Piece(piece) });
                }
                What::LineComment | What::BlockComment => {
                    self.at += 1;
                    let to = if entry.parts.is_empty() { &mut entry.before } else { &mut comments };
                    to.push(piece);
                }
            }
        }
        if self.peek().is_some_and(|p| p.what == What::Token(Kind::Comma)) {
            self.at += 1;
            let here = self.pieces[self.at..].iter().take_while(|p| p.is_comment() && p.newlines == 0);
            let here: Vec<Piece<'t>> = here.copied().collect();
            // What stands in front of the next entry in its line is its own.
            let ended = comments.last().is_some_and(|c| c.what == What::LineComment);
            if !ended && here.last().is_some_and(|comment| comment.last) {
                self.at += here.len();
                comments.extend(here);
            }
        }
        let own = comments.iter().position(|c| c.newlines > 0).unwrap_or(comments.len());
        self.late = comments.split_off(own);
        entry.after = comments;
        entry
    }

    fn brackets(&mut self, open: Piece<'t>) -> Part<'t> {
        let inside = self.peek().filter(|p| !matches!(p.what, What::Token(Kind::Close(_))));
        let broken = inside.is_some_and(|p| p.newlines > 0);
        let entries = self.entries();
        let close = self.peek().map_or("", |p| p.text);
        self.at += 1;
        Part::Brackets(Brackets { open, close, broken, entries })
    }
}

/// How entries are spread over lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layout {
    /// The value with the comments around it; without commas.
    Whole,
    /// Each in a line of its own.
    Fields,
    /// As many in a line as stood there and fit.
    Filled,
}

struct Printer {
    out: String,
    indent: usize,
    ending: &'static str,
}

impl Printer {
    /// Whether a text and some more characters fit into the line.
    fn fits(&self, flat: &str, more: usize) -> bool {
        let line = self.out.rfind('\n').map_or(0, |end| end + 1);
        self.out[line..].chars().count() + flat.chars().count() + more <= WIDTH
    }

    /// Begins a line, after an empty one where there were several ends of lines.
    fn line(&mut self, newlines: usize) {
        self.out += &self.ending.repeat(newlines.clamp(1, 2));
        self.out += &" ".repeat(self.indent);
    }

    /// A comment behind something: at its column, if its author left more than a space and there is room.
    fn behind(&mut self, comment: &Piece<'_>) {
        let line = self.out.rfind('\n').map_or(0, |end| end + 1);
        let column = self.out[line..].chars().count();
        self.out += &" ".repeat(comment.column.map_or(1, |wanted| wanted.saturating_sub(column).max(1)));
        self.out += comment.text;
    }

    fn entries(&mut self, entries: &[Entry<'_>], layout: Layout) {
        // Whether what stands in the line leaves room for another entry.
        let mut room = false;
        for (k, entry) in entries.iter().enumerate() {
            let comma = if layout == Layout::Whole || entry.parts.is_empty() { "" } else { "," };
            let flat = entry.flat();
            let joins = room && layout == Layout::Filled && entry.newlines() == 0;
            match flat.as_ref().filter(|flat| joins && self.fits(flat, 1 + comma.len())) {
                Some(flat) => {
                    self.out.push(' ');
                    self.out += flat;
                }
                None => room = self.entry(entry, k == 0, layout) && flat.is_some(),
            }
            self.out += comma;
            entry.after.iter().for_each(|comment| self.behind(comment));
            room &= entry.after.iter().all(|comment| comment.flat().is_some());
        }
    }

    /// An entry in lines of its own; returns whether it is a single one.
    fn entry(&mut self, entry: &Entry<'_>, first: bool, layout: Layout) -> bool {
        // Nothing is in front of the first line of a text, and no empty line follows a bracket.
        let begin = |printer: &mut Printer, newlines: usize| match (first, layout) {
            (true, Layout::Whole) => {}
            (true, _) => printer.line(1),
            (false, _) => printer.line(newlines),
        };
        let mut previous: Option<&Piece<'_>> = None;
        for comment in &entry.before {
            match previous {
                None if first && layout != Layout::Whole && comment.newlines == 0 && comment.last => {
                    self.behind(comment);
                }
                Some(previous) if comment.newlines == 0 && previous.what == What::BlockComment => {
                    self.behind(comment);
                }
                _ => {
                    match previous {
                        Some(_) => self.line(comment.newlines),
                        None => begin(self, comment.newlines),
                    }
                    self.out += comment.text;
                }
            }
            previous = Some(comment);
        }
        let newlines = entry.parts.first().map_or(0, |part| part.first().newlines);
        match previous {
            _ if entry.parts.is_empty() => {}
            None => begin(self, newlines),
            Some(comment) if newlines == 0 && comment.what == What::BlockComment => self.out.push(' '),
            Some(_) => self.line(newlines),
        }
        let start = self.out.len();
        for (k, part) in entry.parts.iter().enumerate() {
            match k.checked_sub(1).map(|before| &entry.parts[before]) {
                Some(Part::Piece(Piece { what: What::LineComment, .. })) => {
                    self.indent += INDENT;
                    self.line(1);
                    self.indent -= INDENT;
                }
                Some(before) if before.apart(part) => self.out.push(' '),
                _ => {}
            }
            match part {
                Part::Piece(piece) => self.out += piece.text,
                Part::Brackets(brackets) => self.brackets(brackets),
            }
        }
        !self.out[start..].contains('\n')
    }

    fn brackets(&mut self, brackets: &Brackets<'_>) {
        let whole = self.indent == 0 && !brackets.entries.is_empty();
        if let Some(flat) = brackets.flat().filter(|flat| !whole && self.fits(flat, 1)) {
            self.out += &flat;
            return;
        }
        self.out += brackets.open.text;
        self.indent += INDENT;
        self.entries(&brackets.entries, if whole { Layout::Fields } else { Layout::Filled });
        self.indent -= INDENT;
        self.line(1);
        self.out += brackets.close;
    }
}
