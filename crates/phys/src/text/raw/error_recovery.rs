//! The outline of a text that is being typed: whatever is missing or too much, what is there has its place.

use super::scan::{DEEPEST, Kind, Token, half_typed_tokens, tokens};
use super::{Entry, Node, Shape};
use phisindy_expr::Span;

/// The outline of a text that may be no RON. A value that is missing is a name without letters where it should
/// begin. What is too deep is left out.
///
/// ```
/// use phisindy_phys::outline::{Shape, read};
/// let text = "(states: { \"x\": \"m\", \"v\": }, kno";
/// let root = read(text);
/// let states = &root.entries[0].value;
/// assert_eq!((states.shape, states.entries.len()), (Shape::Map, 2));
/// assert!(states.entries[1].value.span.range().is_empty());
/// assert_eq!(&text[root.entries[1].value.span.range()], "kno");
/// ```
pub fn read(text: &str) -> Node {
    let tokens = tokens(text).unwrap_or_else(|_| half_typed_tokens(text));
    let all =
        Node { shape: Shape::List, span: Span::new(0, text.len()), name: None, inside: 0, entries: vec![] };
    let mut open = vec![Bracket { node: all, key: None, colon: 0, value: None }];
    for Token { kind, span } in tokens {
        let depth = open.len() - 1;
        let here = &mut open[depth];
        match kind {
            Kind::Open(byte) => {
                let adjacent = here.value.take_if(|value| byte == b'(' && value.shape == Shape::Name);
                if here.value.is_some() {
                    here.flush();
                }
                let name = adjacent.map(|value| value.span);
                let shape = match byte {
                    b'[' => Shape::List,
                    b'{' => Shape::Map,
                    _ => Shape::Group,
                };
                let (start, inside) = (name.unwrap_or(span).start, span.end);
                let node = Node { shape, span: Span::new(start, text.len()), name, inside, entries: vec![] };
                if depth < DEEPEST {
                    open.push(Bracket { node, key: None, colon: 0, value: None });
                }
            }
            Kind::Close(byte) => {
                let shape = match byte {
                    b']' => Shape::List,
                    b'}' => Shape::Map,
                    _ => Shape::Group,
                };
                // What was never closed ends with what is.
                if let Some(at) = open.iter().skip(1).rposition(|bracket| bracket.node.shape == shape) {
                    close(&mut open, at + 1, span);
                }
            }
            Kind::Comma => here.flush(),
            Kind::Colon => (here.key, here.colon) = (here.value.take(), span.end),
            Kind::Text | Kind::Char | Kind::Word => {
                if here.value.is_some() {
                    here.flush();
                }
                let digit = |c: char| c.is_ascii_digit() || "+-.".contains(c);
                let shape = match kind {
                    Kind::Text => Shape::Text,
                    Kind::Char => Shape::Char,
                    _ if text[span.range()].starts_with(digit) => Shape::Number,
                    _ => Shape::Name,
                };
                here.value = Some(leaf(shape, span));
            }
        }
    }
    let end = Span::new(text.len(), text.len());
    close(&mut open, 1, end);
    let mut all = open.remove(0);
    all.flush();
    let root = all.node.entries.iter().rposition(|entry| entry.value.shape == Shape::Group);
    root.map_or(all.node.clone(), |at| all.node.entries.swap_remove(at).value)
}

/// A bracket that is open, and the entry in it that is not ended.
struct Bracket {
    node: Node,
    key: Option<Node>,
    /// Where the colon behind the key ends.
    colon: usize,
    value: Option<Node>,
}

impl Bracket {
    /// Ends the entry.
    fn flush(&mut self) {
        let (key, value) = (self.key.take(), self.value.take());
        let missing = || leaf(Shape::Name, Span::new(self.colon, self.colon));
        if key.is_some() || value.is_some() {
            self.node.entries.push(Entry { key, value: value.unwrap_or_else(missing) });
        }
    }
}

/// Closes the brackets from this one on.
fn close(open: &mut Vec<Bracket>, from: usize, by: Span) {
    while open.len() > from {
        let Some(mut bracket) = open.pop() else { return };
        bracket.flush();
        bracket.node.span =
            Span::new(bracket.node.span.start, if open.len() == from { by.end } else { by.start });
        if let Some(parent) = open.last_mut() {
            parent.value = Some(bracket.node);
        }
    }
}

fn leaf(shape: Shape, span: Span) -> Node {
    Node { shape, span, name: None, inside: span.end, entries: vec![] }
}
