//! The outline of a RON text: where each bracket, key and value stands. ron reads the values themselves.
//!
//! ron stops at the first mistake and does not say where a value stands; a spec needs all mistakes with their
//! places, and a splice needs to change one value and leave everything else, comments too, as it is.

pub(crate) mod error_recovery;
mod mistake;
mod scan;

pub(crate) use mistake::Mistake;
use phisindy_expr::{Span, clipped};
use ron::extensions::Extensions;
pub(crate) use scan::{Kind, Token, fits, tokens};

/// Most characters of a text that a message repeats.
const LONGEST: usize = 200;

/// What a value looks like from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// It begins as a number does.
    Number,
    /// A string, raw or not.
    Text,
    /// A character in quotes.
    Char,
    /// A bare word: `Fit`, `true`.
    Name,
    /// `[...]`
    List,
    /// `{...}`
    Map,
    /// `(...)` or `Name(...)`: fields with keys, or a tuple without.
    Group,
}

/// One value.
#[derive(Clone, Debug)]
pub struct Node {
    /// From outside.
    pub shape: Shape,
    /// The whole value, quotes, brackets and variant name included.
    pub span: Span,
    /// The variant's name in front of a group.
    pub name: Option<Span>,
    /// Where the opening bracket ends.
    pub inside: usize,
    /// What the brackets hold.
    pub entries: Vec<Entry>,
}

/// One thing between commas.
#[derive(Clone, Debug)]
pub struct Entry {
    /// A field's name or a map's key; none in lists and tuples.
    pub key: Option<Node>,
    /// What stands behind the key, or alone.
    pub value: Node,
}

/// Length of the block comment that `text` starts with; none if it does not end.
pub(crate) fn comment_length(text: &str) -> Option<usize> {
    scan::comment_end(text, 0).ok()
}

/// The options every spec is read with: `Some` need not be written.
pub(crate) fn options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME)
}

/// The outline of a text that holds one RON value.
///
/// # Errors
/// The first mistake of syntax. Texts that ron does not read are refused.
pub(crate) fn parse(text: &str) -> Result<Node, Mistake> {
    let tokens = tokens(text)?;
    let mut outline = Outline { text, tokens: &tokens, next: 0 };
    outline.skip_attributes();
    let root = outline.value()?;
    if let Some(token) = outline.peek() {
        return Err(Mistake::new(
            "there is text after the end",
            token.span,
            "does not belong to the value before it",
        ));
    }
    match options().from_str::<serde::de::IgnoredAny>(text) {
        Ok(_) => Ok(root),
        Err(error) => {
            let (start, end) = (offset(text, error.span.start), offset(text, error.span.end));
            let message = error.code.to_string();
            Err(Mistake::new(format!("not valid RON: {message}"), Span::new(start.min(end), end), "here"))
        }
    }
}

/// Byte offset of ron's position, whose lines and columns count from 1 and in characters.
fn offset(text: &str, position: ron::error::Position) -> usize {
    let line: usize = text.split_inclusive('\n').take(position.line.saturating_sub(1)).map(str::len).sum();
    let rest = &text[line..];
    rest.char_indices().nth(position.col.saturating_sub(1)).map_or(text.len(), |(i, _)| line + i)
}

/// Builds nodes from tokens. It recurses no deeper than the brackets, which [`tokens`] has limited.
struct Outline<'t> {
    text: &'t str,
    tokens: &'t [Token],
    next: usize,
}

impl Outline<'_> {
    fn peek(&self) -> Option<Token> {
        self.tokens.get(self.next).copied()
    }

    fn peek_kind(&self) -> Option<Kind> {
        self.peek().map(|t| t.kind)
    }

    fn slice(&self, span: Span) -> &str {
        &self.text[span.range()]
    }

    /// Steps over `#![enable(...)]` lines.
    fn skip_attributes(&mut self) {
        while self.peek().is_some_and(|t| t.kind == Kind::Word && self.slice(t.span).starts_with('#')) {
            while self.peek_kind() == Some(Kind::Word) {
                self.next += 1;
            }
            let mut depth = 0_usize;
            while let Some(kind) = self.peek_kind() {
                match kind {
                    Kind::Open(_) => depth += 1,
                    Kind::Close(_) => depth = depth.saturating_sub(1),
                    _ => {}
                }
                self.next += 1;
                if depth == 0 {
                    break;
                }
            }
        }
    }

    fn value(&mut self) -> Result<Node, Mistake> {
        let Some(token) = self.peek() else {
            let end = self.text.len();
            return Err(Mistake::new("the text ends where a value is expected", Span::new(end, end), "here"));
        };
        let shape = match token.kind {
            Kind::Text => Shape::Text,
            Kind::Char => Shape::Char,
            Kind::Word => self.word(token.span)?,
            Kind::Open(_) => return self.brackets(None),
            Kind::Close(_) | Kind::Comma | Kind::Colon => {
                let found = self.slice(token.span);
                return Err(Mistake::new(
                    format!("expected a value, found `{found}`"),
                    token.span,
                    "a value is missing",
                ));
            }
        };
        self.next += 1;
        if shape == Shape::Name && self.peek_kind() == Some(Kind::Open(b'(')) {
            return self.brackets(Some(token.span));
        }
        Ok(Node { shape, span: token.span, name: None, inside: token.span.end, entries: Vec::new() })
    }

    fn word(&self, span: Span) -> Result<Shape, Mistake> {
        let word = self.slice(span);
        let unsigned = word.trim_start_matches(['+', '-']);
        let numeric = unsigned.starts_with(|c: char| c.is_ascii_digit() || c == '.');
        if numeric || matches!(unsigned, "inf" | "NaN") {
            return match options().from_str::<serde::de::IgnoredAny>(word) {
                Ok(_) => Ok(Shape::Number),
                Err(_) => Err(Mistake::new(
                    format!("`{}` is not a number", clipped(word, LONGEST)),
                    span,
                    "not a number",
                )
                .help(self.in_quotes())),
            };
        }
        let name = word.strip_prefix("r#").unwrap_or(word);
        if name.chars().all(|c| c.is_alphanumeric() || c == '_') {
            return Ok(Shape::Name);
        }
        Err(Mistake::new(
            format!("`{}` is neither a number nor a name", clipped(word, LONGEST)),
            span,
            "not a value",
        )
        .help(self.in_quotes()))
    }

    /// How the expression would be right.
    fn in_quotes(&self) -> String {
        format!("an expression stands in quotes: \"{}\"", clipped(self.expression(), LONGEST))
    }

    /// The expression without quotes that the present token is part of: from the colon before it, or from it
    /// where a text or a map stands between them, up to the comma or bracket that ends it, or to the end of
    /// the line.
    fn expression(&self) -> &str {
        let here = self.tokens[self.next].span.start;
        let colon = self.tokens[..self.next].iter().rfind(|t| t.kind == Kind::Colon);
        let begin = colon.map(|colon| colon.span.end).filter(|&begin| self.end_of(begin) > here);
        let whole = begin.map(|begin| &self.text[begin..self.end_of(begin)]);
        let plain = |text: &&str| !text.contains(['"', '[', '{', ':']);
        whole.filter(plain).unwrap_or_else(|| &self.text[here..self.end_of(here)]).trim()
    }

    /// The comma, bracket or line end that ends what begins at a place, outside of its own brackets.
    fn end_of(&self, start: usize) -> usize {
        let mut depth = 0_i32;
        let ends = |(_, c): &(usize, char)| {
            depth += match c {
                '(' | '[' | '{' => 1,
                ')' | ']' | '}' => -1,
                _ => 0,
            };
            depth < 0 || (depth == 0 && matches!(c, ',' | '\n'))
        };
        self.text[start..].char_indices().find(ends).map_or(self.text.len(), |(at, _)| start + at)
    }

    /// A bracket and what it holds; the next token opens it.
    fn brackets(&mut self, name: Option<Span>) -> Result<Node, Mistake> {
        let open = self.tokens[self.next];
        self.next += 1;
        let shape = match open.kind {
            Kind::Open(b'[') => Shape::List,
            Kind::Open(b'{') => Shape::Map,
            _ => Shape::Group,
        };
        let mut entries = Vec::new();
        loop {
            if let Some(Token { kind: Kind::Close(_), span }) = self.peek() {
                self.next += 1;
                let span = name.unwrap_or(open.span).to(span);
                return Ok(Node { shape, span, name, inside: open.span.end, entries });
            }
            let entry = self.entry(shape)?;
            let end = entry.value.span.end;
            entries.push(entry);
            match self.peek() {
                Some(Token { kind: Kind::Comma, .. }) => self.next += 1,
                Some(Token { kind: Kind::Close(_), .. }) => {}
                other => {
                    let next = other.map_or("", |t| self.slice(t.span));
                    let span = Span::new(end, end);
                    let mistake = Mistake::new(
                        format!("expected a comma before `{}`", clipped(next, LONGEST)),
                        span,
                        "a comma is missing",
                    );
                    // `v - k*x`: what follows a value is no key, but the next part of an expression.
                    let operator = next.starts_with(['+', '-', '*', '/', '^']);
                    return Err(if operator { mistake.help(self.in_quotes()) } else { mistake });
                }
            }
        }
    }

    fn entry(&mut self, shape: Shape) -> Result<Entry, Mistake> {
        let field = self.tokens.get(self.next + 1).is_some_and(|t| t.kind == Kind::Colon);
        if shape == Shape::List || (shape == Shape::Group && !field) {
            return Ok(Entry { key: None, value: self.value()? });
        }
        let key = self.value()?;
        if shape == Shape::Group && key.shape == Shape::Text {
            let (name, span) = (self.slice(key.span).to_owned(), key.span);
            return Err(Mistake::new(
                "names in quotes stand in a map `{...}`",
                span,
                "in a group `(...)` here",
            )
            .help(format!("put braces in place of the round brackets: {{ {name}: ... }}")));
        }
        if self.peek_kind() != Some(Kind::Colon) {
            let end = key.span.end;
            let mistake = Mistake::new(
                "expected `:` and a value after this key",
                Span::new(end, end),
                "`:` is missing",
            );
            // `"k": 801,0` reads as a number, a comma, and another key.
            let before = &self.text[..key.span.start];
            let whole =
                before.strip_suffix(',').and_then(|text| text.rsplit([' ', ':', '(', '{', '[']).next());
            let comma = whole.filter(|_| key.shape == Shape::Number).filter(|w| decimal(w));
            return Err(match comma {
                Some(whole) => mistake.help(decimal_help(whole, self.slice(key.span))),
                None => mistake.also(key.span, "the key"),
            });
        }
        self.next += 1;
        Ok(Entry { key: Some(key), value: self.value()? })
    }
}

/// Whether a text is a plain number without a point.
fn decimal(text: &str) -> bool {
    let digits = text.trim_start_matches(['-', '+']);
    !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit())
}

fn decimal_help(whole: &str, part: &str) -> String {
    format!("decimals take a point: {whole}.{part}")
}

/// Advice about a decimal comma in a text such as `(801,0, "N/m")`.
pub(crate) fn comma_advice(text: &str) -> Option<String> {
    let words: Vec<&str> = text.trim_matches(['(', ')']).split(',').collect();
    let mut pairs = words.windows(2);
    let found = pairs
        .find(|w| decimal(w[0].trim()) && !w[1].is_empty() && w[1].bytes().all(|b| b.is_ascii_digit()))?;
    Some(decimal_help(found[0].trim(), found[1]))
}

/// The content of a string literal, without quotes, and whether it was written raw; none if it is something
/// else.
pub(crate) fn content(text: &str, literal: Span) -> Option<(Span, bool)> {
    let slice = &text[literal.range()];
    let raw = slice.strip_prefix('r').unwrap_or(slice);
    let hashes = raw.bytes().take_while(|b| *b == b'#').count();
    let head = slice.len() - raw.len() + hashes + 1;
    if raw.as_bytes().get(hashes) != Some(&b'"') || slice.len() < head + hashes + 1 {
        return None;
    }
    Some((Span::new(literal.start + head, literal.end - hashes - 1), raw.len() != slice.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_expression_is_to_stand_in_quotes() {
        for (text, due) in [
            ("(a: {\"v\": -(k*x + 2*v)/m + cos(3*t)})", "-(k*x + 2*v)/m + cos(3*t)"),
            ("(a: {\"v\": v - k*x, \"x\": 1})", "v - k*x"),
            ("(a: {\"v\": cos(3*t), \"x\": 1})", "cos(3*t)"),
            ("(a: [1, x^2, 3])", "x^2"),
            ("(a: (2*x, \"N\"))", "2*x"),
        ] {
            let mistake = parse(text).expect_err(text);
            assert_eq!(mistake.help, Some(format!("an expression stands in quotes: \"{due}\"")), "{text}");
        }
    }

    #[test]
    fn a_long_line_does_not_come_back_as_a_message() {
        let long = "x".repeat(5000);
        for text in [format!("- {long}"), format!("-{long}+"), format!("3{long}"), format!("(a: 1 +{long}")] {
            let Mistake { message, help, .. } = parse(&text).expect_err("no value");
            let length = message.len() + help.as_ref().map_or(0, String::len);
            assert!(length < 1000, "{length} bytes: {message}");
            assert!(help.is_none_or(|help| help.contains("...\"")), "{message}");
        }
    }

    #[test]
    fn brackets_strings_and_comments_do_not_confuse_it() {
        let text = "#![enable(implicit_some)]\n( // a ) here\n a: \"]\\\")\", /* ( /* [ */ */ b: r#\"\"(\"#, c: ')', d: X(1, [2,]), )";
        let root = parse(text).expect("valid");
        let keys: Vec<&str> =
            root.entries.iter().map(|e| &text[e.key.as_ref().unwrap().span.range()]).collect();
        assert_eq!(keys, ["a", "b", "c", "d"]);
        let values: Vec<&str> = root.entries.iter().map(|e| &text[e.value.span.range()]).collect();
        assert_eq!(values, ["\"]\\\")\"", "r#\"\"(\"#", "')'", "X(1, [2,])"]);
        assert_eq!(&text[content(text, root.entries[1].value.span).unwrap().0.range()], "\"(");
    }

    #[test]
    fn mistakes_point_at_their_place() {
        let check = |text: &str, message: &str, place: std::ops::Range<usize>| {
            let mistake = parse(text).expect_err(text);
            assert!(mistake.message.contains(message), "{text}: {}", mistake.message);
            assert_eq!(mistake.span.range(), place, "{text}: {}", mistake.message);
        };
        check("(a: 1 b: 2)", "comma before `b`", 5..5);
        check("(a: [1, 2)", "expected `]`, found `)`", 9..10);
        check("(a: 1", "never closed", 0..1);
        check("(a: 1))", "closes nothing", 6..7);
        check("(a: \"x)", "never closed", 4..5);
        check("(a: r#\"x\")", "never closed", 4..7);
        check("/* (a: 1)", "never closed", 0..2);
        check("{ \"a\" }", "expected `:`", 5..5);
        check("(a: )", "expected a value, found `)`", 4..5);
        check("", "the text ends", 0..0);
        check("() ()", "after the end", 3..4);
        check(&"(".repeat(100_000), "deeper than 64", 64..65);
        check("(a: 1_é)", "`1_é` is not a number", 4..8);
        check("(a: -k*x)", "neither a number nor a name", 4..8);
        check("(é: \"\\q\")", "not valid RON", 6..8);
    }

    #[test]
    fn a_long_text_is_refused() {
        let text = " ".repeat((1 << 20) + 1);
        assert!(parse(&text).expect_err("too long").message.contains("1 MiB"));
    }
}
