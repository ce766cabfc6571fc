//! RON text cut into tokens. The brackets are matched and their depth is limited here, before anything
//! recursive looks at the text.

use super::mistake::Mistake;
use phisindy_expr::Span;

/// Deepest nesting of brackets: far more than a spec needs, far less than a stack holds.
pub(super) const DEEPEST: usize = 64;
/// Longest text in bytes; what is made of it takes about a hundred times as much.
const LONGEST: usize = 1 << 20;

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// `(`, `[` or `{`.
    Open(u8),
    /// `)`, `]` or `}`.
    Close(u8),
    Comma,
    Colon,
    /// A string, raw or not, with its quotes.
    Text,
    /// A character, with its quotes.
    Char,
    /// Anything else up to the next separator: a number or a name.
    Word,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Token {
    pub(crate) kind: Kind,
    pub(crate) span: Span,
}

/// Whether a text is short enough to be read.
pub(crate) fn fits(text: &str) -> Result<(), Mistake> {
    if text.len() <= LONGEST {
        return Ok(());
    }
    Err(Mistake::new("the text is longer than 1 MiB", Span::new(0, 0), "")
        .help("data belong into a data file, read with `Csv(path: ...)`"))
}

/// All tokens; white space and comments are left out.
pub(crate) fn tokens(text: &str) -> Result<Vec<Token>, Mistake> {
    fits(text)?;
    let mut tokens: Vec<Token> = Vec::new();
    let mut open: Vec<Token> = Vec::new();
    let mut at = 0;
    loop {
        at = skip_space(text, at)?;
        let Some(&byte) = text.as_bytes().get(at) else { break };
        let (kind, end) = match sign(byte) {
            Some(kind) => (kind, at + 1),
            None => quoted(text, at)?.unwrap_or_else(|| (Kind::Word, word_end(text, at))),
        };
        let token = Token { kind, span: Span::new(at, end) };
        match kind {
            Kind::Open(_) if open.len() == DEEPEST => {
                return Err(Mistake::new(
                    format!("brackets are nested deeper than {DEEPEST} levels"),
                    token.span,
                    "one level too many",
                ));
            }
            Kind::Open(_) => open.push(token),
            Kind::Close(byte) => close(open.pop(), token, byte)?,
            _ => {}
        }
        tokens.push(token);
        at = end;
    }
    if let Some(token) = open.pop() {
        let bracket = &text[token.span.range()];
        return Err(Mistake::new(
            format!("the bracket `{bracket}` is never closed"),
            token.span,
            "opened here",
        ));
    }
    Ok(tokens)
}

/// The tokens of a text that is being typed: brackets need not match, and a text without its closing quote ends with its
/// line.
pub(super) fn half_typed_tokens(text: &str) -> Vec<Token> {
    let (mut tokens, mut at) = (Vec::new(), 0);
    while text.len() <= LONGEST
        && let Ok(start) = skip_space(text, at)
        && let Some(&byte) = text.as_bytes().get(start)
    {
        let line_end = || start + text[start..].find('\n').unwrap_or(text.len() - start);
        let (kind, end) = match (sign(byte), quoted(text, start)) {
            (Some(kind), _) => (kind, start + 1),
            (None, Ok(Some((kind, end)))) if !text[start..end].contains('\n') => (kind, end),
            (None, Ok(None)) => (Kind::Word, word_end(text, start)),
            (None, _) => (Kind::Text, line_end()),
        };
        tokens.push(Token { kind, span: Span::new(start, end) });
        at = end;
    }
    tokens
}

/// The token of one byte, if this is one.
fn sign(byte: u8) -> Option<Kind> {
    match byte {
        b'(' | b'[' | b'{' => Some(Kind::Open(byte)),
        b')' | b']' | b'}' => Some(Kind::Close(byte)),
        b',' => Some(Kind::Comma),
        b':' => Some(Kind::Colon),
        _ => None,
    }
}

/// Checks that a closing bracket fits the one that is open.
fn close(open: Option<Token>, token: Token, byte: u8) -> Result<(), Mistake> {
    let found = char::from(byte);
    let Some(open) = open else {
        return Err(Mistake::new(format!("`{found}` closes nothing"), token.span, "no bracket is open here"));
    };
    let (opening, expected) = match open.kind {
        Kind::Open(b'(') => ('(', ')'),
        Kind::Open(b'[') => ('[', ']'),
        _ => ('{', '}'),
    };
    if found == expected {
        return Ok(());
    }
    Err(Mistake::new(
        format!("expected `{expected}`, found `{found}`"),
        token.span,
        format!("should be `{expected}`"),
    )
    .also(open.span, format!("because of this `{opening}`")))
}

/// The first byte at or after `at` that is neither white space nor comment.
fn skip_space(text: &str, mut at: usize) -> Result<usize, Mistake> {
    loop {
        let rest = &text[at..];
        let space = rest.find(|c| !is_space(c)).unwrap_or(rest.len());
        at += space;
        let rest = &rest[space..];
        if rest.starts_with("//") {
            at += rest.find('\n').unwrap_or(rest.len());
        } else if rest.starts_with("/*") {
            at = comment_end(text, at)?;
        } else {
            return Ok(at);
        }
    }
}

/// One past a block comment that starts at `start`; such comments nest.
pub(super) fn comment_end(text: &str, start: usize) -> Result<usize, Mistake> {
    let bytes = text.as_bytes();
    let (mut at, mut depth) = (start + 2, 1_usize);
    while depth > 0 {
        match bytes.get(at..at + 2) {
            Some(b"/*") => (at, depth) = (at + 2, depth + 1),
            Some(b"*/") => (at, depth) = (at + 2, depth - 1),
            Some(_) => at += 1,
            None => {
                let span = Span::new(start, start + 2);
                return Err(Mistake::new("the comment `/*` is never closed", span, "opened here"));
            }
        }
    }
    Ok(at)
}

/// The string or character that starts at `at`, if one does.
fn quoted(text: &str, at: usize) -> Result<Option<(Kind, usize)>, Mistake> {
    let bytes = text.as_bytes();
    let plain = if bytes[at] == b'b' { at + 1 } else { at };
    match bytes.get(plain) {
        Some(b'"') => return Ok(Some((Kind::Text, escaped_end(bytes, plain)?))),
        Some(b'\'') => return Ok(Some((Kind::Char, escaped_end(bytes, plain)?))),
        Some(b'r') => {}
        _ => return Ok(None),
    }
    let hashes = bytes[plain + 1..].iter().take_while(|b| **b == b'#').count();
    let quote = plain + 1 + hashes;
    if bytes.get(quote) != Some(&b'"') {
        return Ok(None);
    }
    let ending = format!("\"{}", "#".repeat(hashes));
    match text[quote + 1..].find(&ending) {
        Some(length) => Ok(Some((Kind::Text, quote + 1 + length + ending.len()))),
        None => Err(unclosed(at, quote)),
    }
}

/// One past the closing quote of a string or character whose opening quote is at `open`.
fn escaped_end(bytes: &[u8], open: usize) -> Result<usize, Mistake> {
    let mut at = open + 1;
    while let Some(&byte) = bytes.get(at) {
        match byte {
            b'\\' => at += 2,
            _ if byte == bytes[open] => return Ok(at + 1),
            _ => at += 1,
        }
    }
    Err(unclosed(open, open))
}

fn unclosed(start: usize, quote: usize) -> Mistake {
    Mistake::new("the text is never closed", Span::new(start, quote + 1), "opened here")
        .help("a closing quote is missing here or in a later text")
}

fn word_end(text: &str, at: usize) -> usize {
    let rest = &text[at..];
    let ends = |(i, c): (usize, char)| {
        let separator = is_space(c) || "()[]{},:\"'".contains(c);
        separator || rest[i..].starts_with("//") || rest[i..].starts_with("/*")
    };
    // The first character belongs to the word whatever it is, or the scan would not advance.
    rest.char_indices().skip(1).find(|&p| ends(p)).map_or(text.len(), |(i, _)| at + i)
}

/// White space as ron has it.
fn is_space(c: char) -> bool {
    matches!(
        c,
        ' ' | '\t'
            | '\n'
            | '\r'
            | '\x0B'
            | '\x0C'
            | '\u{85}'
            | '\u{200E}'
            | '\u{200F}'
            | '\u{2028}'
            | '\u{2029}'
    )
}
