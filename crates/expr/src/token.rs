//! Text to tokens.

use logos::Logos;

/// One token; its span comes with it from the lexer.
#[derive(Logos, Clone, Copy, Debug, PartialEq, Eq)]
#[logos(skip r"[ \t\r\n]+")]
pub(crate) enum Token {
    #[regex(r"[0-9]+(\.[0-9]*)?([eE][+-]?[0-9]+)?")]
    #[regex(r"\.[0-9]+([eE][+-]?[0-9]+)?")]
    Number,
    #[regex(r"[\p{XID_Start}_]\p{XID_Continue}*")]
    Name,
    /// The path of a file; single quotes, where the whole expression stands in double ones.
    #[regex(r"'[^']*'")]
    #[regex("\"[^\"]*\"")]
    Quoted,
    #[token("+")]
    Plus,
    #[token("-")]
    Minus,
    #[token("*")]
    Star,
    #[token("/")]
    Slash,
    #[token("^")]
    Caret,
    #[token("(")]
    Open,
    #[token(")")]
    Close,
    #[token("|")]
    Bar,
    #[token(",")]
    Comma,
}
