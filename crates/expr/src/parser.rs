//! Tokens to a syntax tree.
//!
//! ```text
//! sum     = product { ("+" | "-") product }
//! product = sign { ("*" | "/") sign }
//! sign    = "-" product' | "+" product' | power          see below
//! power   = primary [ "^" sign ]                          right-associative: a^b^c is a^(b^c), -x^2 is -(x^2)
//! primary = number | name | name "(" sum { "," sum } ")" | "table" "(" file "," sum [ "," kind ] ")" | "(" sum ")" | "|" sum "|"
//! ```
//! A leading sign applies to a whole product: `-a*b` is `-(a*b)`. After an operator, a sign applies to what
//! that operator takes: `a/-b*c` is `(a/(-b))*c` and `2^-x*y` is `(2^(-x))*y`.
//!
//! A bar in the place of an operand opens `|...|`, a bar in the place of an operator closes it. So there is
//! no `||` token and no implicit multiplication.

use crate::ops::{Function, function, function_names};
use crate::token::Token;
use crate::{Ast, AstKind, AstNode, Binary, Span, Unary, nearest};
use logos::Logos;
use std::borrow::Cow;
use std::fmt;

/// The precedence above which operators belong to the operand of a leading sign.
const SIGN: u8 = 1;
/// The maximum depth of nested parentheses, bars, signs and powers: the parser recurses once for each.
const MAX_DEPTH: usize = 200;
/// The maximum number of tokens of an expression.
const MAX_TOKENS: usize = 20_000;

/// An error in an expression; the text gives advice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParseErrorKind {
    /// Nothing but white space.
    Empty,
    /// A character outside the language.
    UnknownCharacter(char),
    /// This token in the place of a value.
    ExpectedValue(String),
    /// This token in the place of an operator (`2x`).
    ExpectedOperator(String),
    /// A parenthesis without its partner.
    UnclosedParenthesis,
    /// A bar without its partner.
    UnclosedBar,
    /// `name(` where no such function exists.
    UnknownFunction(String),
    /// A function without its parentheses.
    FunctionWithoutArguments(String),
    /// A function with too few or too many arguments: name, expected number, given number.
    WrongArguments(String, usize, usize),
    /// An accessor with something else than a name in its parentheses.
    ExpectedName(String),
    /// A table without a file, an argument, or a kind that there is.
    Table,
    /// A literal too large for a double.
    NumberTooLarge,
    /// Nested deeper than allowed.
    TooDeep,
    /// Longer than allowed.
    TooLong,
}

/// An error and its place in the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParseError {
    /// The error.
    pub kind: ParseErrorKind,
    /// Its place.
    pub span: Span,
}

impl ParseError {
    /// Advice, if there is more than the message.
    pub fn hint(&self) -> Option<String> {
        use ParseErrorKind::*;
        match &self.kind {
            ExpectedOperator(found) if found == "`,`" => {
                Some("a comma only separates arguments; decimals are written with a point".into())
            }
            ExpectedOperator(_) => Some("multiplication is written with `*`".into()),
            UnknownFunction(name) => Some(match nearest(name, function_names()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("functions: {}", function_names().collect::<Vec<_>>().join(", ")),
            }),
            FunctionWithoutArguments(name) => Some(format!("write `{name}(...)`")),
            TooDeep => Some("name an inner part as a constant, or expand it".into()),
            TooLong => Some("split it: a candidate for each term, a constant for each number".into()),
            Empty => Some("write an expression, such as `0`".into()),
            UnknownCharacter(_) => {
                Some("there are numbers, names, `+ - * / ^`, parentheses, bars and commas".into())
            }
            ExpectedValue(_) => Some("a name or a number stands on both sides of an operator".into()),
            UnclosedParenthesis => {
                Some("every `(` needs its `)`: add the missing one, or delete this one".into())
            }
            UnclosedBar => Some("bars come in pairs, as in `|v|`; `abs(v)` says the same".into()),
            WrongArguments(name, due, _) => {
                Some(format!("write `{name}({})`", ["a", "a, b"][usize::from(*due > 1)]))
            }
            ExpectedName(word) => Some(format!("`{word}` takes one name, as in `{word}(v)`")),
            Table => Some("write `table('spring.csv', x)`, or `table('spring.csv', x, cubic)`".into()),
            NumberTooLarge => Some("numbers go up to 1.7e308: choose a larger unit".into()),
        }
    }
}

impl fmt::Display for ParseError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use ParseErrorKind::*;
        match &self.kind {
            Empty => write!(f, "the expression is empty"),
            UnknownCharacter(c) => write!(f, "`{c}` has no meaning in an expression"),
            ExpectedValue(found) => write!(f, "a value is missing before {found}"),
            ExpectedOperator(found) => write!(f, "an operator is missing before {found}"),
            UnclosedParenthesis => write!(f, "this parenthesis has no partner"),
            UnclosedBar => write!(f, "this bar has no partner"),
            UnknownFunction(name) => write!(f, "unknown function `{name}`"),
            FunctionWithoutArguments(name) => write!(f, "`{name}` is a function and needs its arguments"),
            WrongArguments(name, due, given) => {
                write!(f, "`{name}` takes {due} argument{}, not {given}", if *due == 1 { "" } else { "s" })
            }
            ExpectedName(word) => write!(f, "`{word}` takes one name"),
            Table => {
                write!(f, "`table` takes a file in quotes, an argument, and perhaps `linear` or `cubic`")
            }
            NumberTooLarge => write!(f, "this number is too large"),
            TooDeep => write!(f, "nested more than {MAX_DEPTH} levels deep"),
            TooLong => write!(f, "the expression has more than {MAX_TOKENS} tokens"),
        }
    }
}

impl std::error::Error for ParseError {}

/// Parses one expression.
///
/// # Errors
/// The first error, with its place and advice.
///
/// ```
/// use phisindy_expr::parse;
/// assert!(parse("-k*x + F0*cos(W*t)").is_ok());
/// let e = parse("2x").unwrap_err();
/// assert_eq!((e.to_string().as_str(), e.span.start), ("an operator is missing before `x`", 1));
/// ```
pub fn parse(text: &str) -> Result<Ast, ParseError> {
    parse_with(text, &[])
}

/// As [`parse`], where each of `accessors` may also stand before a name in parentheses: `rate(v)` is then the
/// name `rate v`, which no text can write otherwise.
///
/// # Errors
/// As [`parse`].
///
/// ```
/// use phisindy_expr::parse_with;
/// let ast = parse_with("m*rate(v)", &["rate"]).unwrap();
/// assert_eq!(ast.names().map(|(name, _)| name).collect::<Vec<_>>(), ["m", "rate v"]);
/// ```
pub fn parse_with(text: &str, accessors: &[&str]) -> Result<Ast, ParseError> {
    let mut tokens = Vec::new();
    for (token, range) in Token::lexer(text).spanned() {
        let span = Span::new(range.start, range.end);
        match token {
            Ok(token) => tokens.push((token, span)),
            Err(()) => {
                let c = text[span.start..].chars().next().unwrap_or(' ');
                let span = Span::new(span.start, span.start + c.len_utf8());
                return Err(ParseError { kind: ParseErrorKind::UnknownCharacter(c), span });
            }
        }
        if tokens.len() > MAX_TOKENS {
            return Err(ParseError { kind: ParseErrorKind::TooLong, span });
        }
    }
    if tokens.is_empty() {
        return Err(ParseError { kind: ParseErrorKind::Empty, span: Span::new(0, text.len()) });
    }
    let mut parser =
        Parser { text, accessors, tokens: &tokens, next: 0, depth: 0, bars: 0, nodes: Vec::new() };
    parser.expression(0)?;
    match parser.peek() {
        None => Ok(Ast { nodes: parser.nodes }),
        Some((Token::Close, span)) => Err(ParseError { kind: ParseErrorKind::UnclosedParenthesis, span }),
        Some(_) => Err(parser.expected_operator()),
    }
}

/// The function whose values stand in a file.
const TABLE: &str = "table";

/// Most characters of a word that a message repeats.
const LONGEST: usize = 40;

/// The beginning of a text, of so many characters at most, for a message.
pub fn clipped(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}...", &text[..end]).into(),
        None => text.into(),
    }
}

struct Parser<'a> {
    text: &'a str,
    /// Words that take a name in parentheses.
    accessors: &'a [&'a str],
    tokens: &'a [(Token, Span)],
    next: usize,
    depth: usize,
    /// Bars that are open at this point and not hidden behind a parenthesis.
    bars: usize,
    nodes: Vec<AstNode>,
}

impl Parser<'_> {
    fn peek(&self) -> Option<(Token, Span)> {
        self.tokens.get(self.next).copied()
    }

    fn push(&mut self, kind: AstKind, span: Span) -> usize {
        self.nodes.push(AstNode { kind, span });
        self.nodes.len() - 1
    }

    fn token_text(&self) -> (String, Span) {
        match self.peek() {
            Some((_, span)) => (format!("`{}`", clipped(&self.text[span.range()], LONGEST)), span),
            None => ("the end".into(), Span::new(self.text.len(), self.text.len())),
        }
    }

    fn expected_operator(&self) -> ParseError {
        let (found, span) = self.token_text();
        ParseError { kind: ParseErrorKind::ExpectedOperator(found), span }
    }

    /// Parses operators that bind tighter than `floor`; returns the root's index. Pratt's method.
    fn expression(&mut self, floor: u8) -> Result<usize, ParseError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(ParseError { kind: ParseErrorKind::TooDeep, span: self.token_text().1 });
        }
        let mut left = self.operand(floor)?;
        while let Some((token, _)) = self.peek() {
            let op = match token {
                Token::Plus => Binary::Add,
                Token::Minus => Binary::Sub,
                Token::Star => Binary::Mul,
                Token::Slash => Binary::Div,
                Token::Caret => Binary::Pow,
                Token::Close | Token::Comma => break,
                Token::Bar if self.bars > 0 => break,
                _ => return Err(self.expected_operator()),
            };
            let precedence = op.row().precedence;
            if precedence <= floor {
                break;
            }
            self.next += 1;
            // `^` is right-associative: its right side may hold another `^`.
            let right = self.expression(if op == Binary::Pow { precedence - 1 } else { precedence })?;
            let span = self.nodes[left].span.to(self.nodes[right].span);
            left = self.push(AstKind::Binary(op, left, right), span);
        }
        self.depth -= 1;
        Ok(left)
    }

    /// A value with its signs; `floor` is that of the expression it begins.
    fn operand(&mut self, floor: u8) -> Result<usize, ParseError> {
        let Some((token, span)) = self.peek() else {
            let (found, span) = self.token_text();
            return Err(ParseError { kind: ParseErrorKind::ExpectedValue(found), span });
        };
        self.next += 1;
        let text = &self.text[span.range()];
        match token {
            Token::Number => match text.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(self.push(AstKind::Number(value), span)),
                _ => Err(ParseError { kind: ParseErrorKind::NumberTooLarge, span }),
            },
            Token::Name if matches!(self.peek(), Some((Token::Open, _))) => self.call(text.to_owned(), span),
            Token::Name if function(text).is_some() || text == TABLE => {
                Err(ParseError { kind: ParseErrorKind::FunctionWithoutArguments(text.to_owned()), span })
            }
            Token::Name => Ok(self.push(AstKind::Name(text.to_owned()), span)),
            Token::Open => {
                let bars = std::mem::take(&mut self.bars);
                let inner = self.expression(0)?;
                self.bars = bars;
                let end = self.close(Token::Close, span, ParseErrorKind::UnclosedParenthesis)?;
                // A larger expression includes the brackets in its span; a name or number is its own span.
                if let AstKind::Unary(..) | AstKind::Binary(..) = self.nodes[inner].kind {
                    self.nodes[inner].span = span.to(end);
                }
                Ok(inner)
            }
            Token::Bar => {
                self.bars += 1;
                let inner = self.expression(0)?;
                self.bars -= 1;
                let end = self.close(Token::Bar, span, ParseErrorKind::UnclosedBar)?;
                Ok(self.push(AstKind::Unary(Unary::Abs, inner), span.to(end)))
            }
            // A sign has the precedence of a product, but at least that of the operator before it.
            Token::Minus => {
                let inner = self.expression(floor.max(SIGN))?;
                let end = self.nodes[inner].span;
                Ok(self.push(AstKind::Unary(Unary::Neg, inner), span.to(end)))
            }
            Token::Plus => self.expression(floor.max(SIGN)),
            _ => {
                self.next -= 1;
                let (found, span) = self.token_text();
                Err(ParseError { kind: ParseErrorKind::ExpectedValue(found), span })
            }
        }
    }

    fn call(&mut self, name: String, span: Span) -> Result<usize, ParseError> {
        if self.accessors.contains(&name.as_str()) {
            return self.access(name, span);
        }
        if name == TABLE {
            return self.table(span);
        }
        let Some(function) = function(&name) else {
            let name = clipped(&name, LONGEST).into_owned();
            return Err(ParseError { kind: ParseErrorKind::UnknownFunction(name), span });
        };
        let open = self.tokens[self.next].1;
        self.next += 1;
        let bars = std::mem::take(&mut self.bars);
        let mut arguments = Vec::new();
        if !matches!(self.peek(), Some((Token::Close, _))) {
            arguments.push(self.expression(0)?);
            while matches!(self.peek(), Some((Token::Comma, _))) {
                self.next += 1;
                arguments.push(self.expression(0)?);
            }
        }
        self.bars = bars;
        let end = self.close(Token::Close, open, ParseErrorKind::UnclosedParenthesis)?;
        let kind = match (function, arguments.as_slice()) {
            (Function::One(op), &[a]) => AstKind::Unary(op, a),
            (Function::Two(op), &[a, b]) => AstKind::Binary(op, a, b),
            (Function::Two(Binary::Hold), &[a, b, c]) => {
                let timing = self.nodes[b].span.to(self.nodes[c].span);
                AstKind::Binary(Binary::Hold, a, self.push(AstKind::Binary(Binary::Timing, b, c), timing))
            }
            _ => {
                let kind = ParseErrorKind::WrongArguments(name, function.arity(), arguments.len());
                return Err(ParseError { kind, span: span.to(end) });
            }
        };
        Ok(self.push(kind, span.to(end)))
    }

    /// The rest of `table('spring.csv', x)` or `table('spring.csv', x, cubic)`.
    fn table(&mut self, span: Span) -> Result<usize, ParseError> {
        let wrong = |span: Span| ParseError { kind: ParseErrorKind::Table, span };
        let open = self.tokens[self.next].1;
        self.next += 1;
        let Some((Token::Quoted, file)) = self.peek() else { return Err(wrong(self.token_text().1)) };
        self.next += 1;
        let Some((Token::Comma, _)) = self.peek() else { return Err(wrong(self.token_text().1)) };
        self.next += 1;
        let bars = std::mem::take(&mut self.bars);
        let of = self.expression(0)?;
        let mut cubic = false;
        if let Some((Token::Comma, _)) = self.peek() {
            let kind = self.tokens.get(self.next + 1).map_or(open, |(_, span)| *span);
            cubic = match &self.text[kind.range()] {
                "cubic" => true,
                "linear" => false,
                _ => return Err(wrong(kind)),
            };
            self.next += 2;
        }
        self.bars = bars;
        let end = self.close(Token::Close, open, ParseErrorKind::UnclosedParenthesis)?;
        let inside = Span::new(file.start + 1, file.end - 1);
        let path = (self.text[inside.range()].to_owned(), inside);
        Ok(self.push(AstKind::Table { path, cubic, of }, span.to(end)))
    }

    /// The name in the parentheses of an accessor.
    fn access(&mut self, word: String, span: Span) -> Result<usize, ParseError> {
        let open = self.tokens[self.next].1;
        self.next += 1;
        let Some((Token::Name, of)) = self.peek() else {
            return Err(ParseError { kind: ParseErrorKind::ExpectedName(word), span: self.token_text().1 });
        };
        self.next += 1;
        if let Some((found, span)) = self.peek()
            && found != Token::Close
        {
            return Err(ParseError { kind: ParseErrorKind::ExpectedName(word), span: of.to(span) });
        }
        let end = self.close(Token::Close, open, ParseErrorKind::UnclosedParenthesis)?;
        let name = format!("{word} {}", &self.text[of.range()]);
        Ok(self.push(AstKind::Name(name), span.to(end)))
    }

    /// The closing token, or an error that points at the opening one.
    fn close(&mut self, token: Token, open: Span, missing: ParseErrorKind) -> Result<Span, ParseError> {
        match self.peek() {
            Some((found, span)) if found == token => {
                self.next += 1;
                Ok(span)
            }
            Some((Token::Comma, _)) if token == Token::Close => Err(self.expected_operator()),
            // Only these tokens end an expression: their opening partner is further out, or missing.
            _ => Err(ParseError { kind: missing, span: open }),
        }
    }
}
