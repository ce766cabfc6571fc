//! Graphs as source code of other languages. The tables of [`crate::ops`] contain the spelling of each
//! operation.

use crate::{Binary, Graph, Id, Node, Symbol, Unary};

/// Precedence of a product, above which signs and sums need parentheses.
const PRODUCT: u8 = 2;
/// Precedence of things that never need parentheses.
const ATOM: u8 = 5;
/// A temporary cuts an expression that is deeper: compilers limit the depth of parentheses.
const DEEPEST: usize = 24;

/// A target language; its position is that in [`crate::ops::Spelling`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// Python 3 with its standard library.
    Python,
    /// C99 with its mathematical library.
    C,
    /// Modelica 3.
    Modelica,
}

impl Language {
    /// All of them.
    pub const ALL: [Language; 3] = [Language::Python, Language::C, Language::Modelica];

    /// Definitions that the code needs before its expressions: operations that the language lacks, or that
    /// it refuses where this crate returns an infinity or NaN.
    pub fn helpers(self) -> &'static str {
        match self {
            Language::Python => include_str!("code/helpers.py"),
            Language::C => include_str!("code/helpers.c"),
            Language::Modelica => include_str!("code/helpers.mo"),
        }
    }

    /// Names used by [`Language::helpers`] and the operations: no symbol may have one of them.
    pub fn taken(self) -> impl Iterator<Item = &'static str> {
        let unary = crate::ops::UNARY.iter().map(move |row| row.code[self as usize]);
        let binary = crate::ops::BINARY.iter().map(move |row| row.code[self as usize]);
        unary
            .chain(binary)
            .filter_map(|spelling| spelling.split_once('('))
            .flat_map(|(name, _)| name.split('.'))
    }
}

/// Expressions as code: temporaries in the order of their computation, then the values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Code {
    /// Name and value of each subexpression that is used more than once or is too deep.
    pub temporaries: Vec<(String, String)>,
    /// One for each root.
    pub roots: Vec<String>,
}

/// Names of symbols and temporaries, and the nodes that vary.
pub struct Naming<'a> {
    /// The text of a symbol.
    pub symbol: &'a dyn Fn(Symbol) -> String,
    /// The name of a temporary, by its number.
    pub temporary: &'a dyn Fn(usize) -> String,
    /// Nodes that vary while a model runs. A divisor without them is written as an ordinary division; any
    /// other one is protected, because Python raises an error at zero.
    pub moving: &'a [Id],
}

/// A text and its precedence.
#[derive(Clone)]
struct Piece {
    text: String,
    precedence: u8,
    depth: usize,
}

impl Graph {
    /// The roots in a language.
    ///
    /// ```
    /// # use phisindy_expr::*;
    /// # let (mut g, mut n) = (Graph::default(), Names::default());
    /// let f = g.lower(&parse("-k*(x-u)^2/m").unwrap(), |s| Some(n.intern(s))).unwrap();
    /// let x = g.symbol(n.get("x").unwrap());
    /// let naming = Naming { symbol: &|s| n.name(s).to_owned(), temporary: &|k| format!("q{k}"), moving: &[x] };
    /// assert_eq!(g.code(&[f], Language::C, &naming).roots, ["-k*pow(x - u, 2.0)/m"]);
    /// assert_eq!(g.code(&[f], Language::Modelica, &naming).roots, ["-k*(x - u)^2.0/m"]);
    /// ```
    pub fn code(&self, roots: &[Id], language: Language, naming: &Naming<'_>) -> Code {
        let order = self.reachable(roots);
        let size = order.last().map_or(0, |id| id.index() + 1);
        let moves = self.dependence(&order, naming.moving);
        let symbols: Vec<Id> =
            order.iter().copied().filter(|&id| matches!(self.node(id), Node::Symbol(_))).collect();
        let named = self.dependence(&order, &symbols);
        let mut uses = vec![0_usize; size];
        order
            .iter()
            .flat_map(|&id| self.operands(id))
            .chain(roots.iter().copied())
            .for_each(|id| uses[id.index()] += 1);
        let mut pieces: Vec<Option<Piece>> = vec![None; size];
        let mut temporaries = Vec::new();
        for &id in &order {
            let operand = |id: Id| pieces[id.index()].as_ref().expect("operands precede operations");
            let mut piece = match self.node(id) {
                Node::Constant(bits) => number(f64::from_bits(bits)),
                Node::Symbol(s) => Piece { text: (naming.symbol)(s), precedence: ATOM, depth: 0 },
                Node::Unary(op, a) => {
                    let floor = if op == Unary::Neg { PRODUCT } else { 0 };
                    let precedence = if op == Unary::Neg { 1 } else { ATOM };
                    filled(op.row().code[language as usize], precedence, &[(operand(a), floor)])
                }
                Node::Binary(op, a, b) => {
                    let safe = self.value(b).map_or(named[b.index()] && !moves[b.index()], |b| b != 0.0);
                    let plain = op == Binary::Div && safe;
                    let spelling = if plain { "#1/#2" } else { op.row().code[language as usize] };
                    let (precedence, left, right) =
                        if spelling.contains('(') { (ATOM, 0, 0) } else { sides(op) };
                    filled(spelling, precedence, &[(operand(a), left), (operand(b), right)])
                }
            };
            let small = matches!(self.node(id), Node::Constant(_) | Node::Symbol(_))
                || matches!(self.node(id), Node::Unary(Unary::Neg, a) if operand(a).depth == 0);
            if !small && (uses[id.index()] > 1 || piece.depth > DEEPEST) {
                let name = (naming.temporary)(temporaries.len());
                temporaries.push((name.clone(), piece.text));
                piece = Piece { text: name, precedence: ATOM, depth: 0 };
            }
            pieces[id.index()] = Some(piece);
        }
        let text = |id: &Id| pieces[id.index()].as_ref().expect("every root is reachable").text.clone();
        Code { temporaries, roots: roots.iter().map(text).collect() }
    }
}

/// A number. A negative one has the precedence of a sum.
fn number(x: f64) -> Piece {
    let precedence = if x.is_sign_negative() { 1 } else { ATOM };
    Piece { text: format!("{x:?}"), precedence, depth: 0 }
}

/// The precedence of an infix operation, and the precedence below which its left and right operand need
/// parentheses.
fn sides(op: Binary) -> (u8, u8, u8) {
    let p = op.row().precedence;
    match op {
        Binary::Pow => (p, ATOM, ATOM),
        _ => (p, p, p + 1),
    }
}

/// A spelling with its operands, in parentheses where they have a lower precedence than this.
fn filled(spelling: &str, precedence: u8, operands: &[(&Piece, u8)]) -> Piece {
    let mut text = String::new();
    let mut rest = spelling;
    while let Some(at) = rest.find('#') {
        text.push_str(&rest[..at]);
        let (piece, floor) = operands[usize::from(&rest[at + 1..at + 2] == "2")];
        if piece.precedence < floor {
            text.push('(');
            text.push_str(&piece.text);
            text.push(')');
        } else {
            text.push_str(&piece.text);
        }
        rest = &rest[at + 2..];
    }
    text.push_str(rest);
    let depth = 1 + operands.iter().map(|(piece, _)| piece.depth).max().unwrap_or(0);
    Piece { text, precedence, depth }
}
