//! Graphs to text: LaTeX for readers, and plain text that parses again.

use crate::{Binary, Graph, Id, Names, Node, Symbol, Unary};
use std::fmt::Write;

/// Precedence of a product, above which signs and sums need parentheses.
const PRODUCT: u8 = 2;
/// Precedence of things that never need parentheses.
const ATOM: u8 = 5;

/// An item still to be printed: the printer has its own stack, so no expression is too deep.
enum Piece {
    /// A node, in parentheses if its precedence is lower than this.
    Node(Id, u8),
    Text(&'static str),
}

#[derive(Clone, Copy, PartialEq)]
enum Style {
    Text,
    Latex,
}

impl Graph {
    /// Plain text in the language of specs: parsing it gives the same node.
    pub fn text(&self, root: Id, names: &Names) -> String {
        self.print(root, names, Style::Text)
    }

    /// LaTeX (math mode), numbers with four digits.
    ///
    /// ```
    /// # use phisindy_expr::*;
    /// # let (mut g, mut n) = (Graph::default(), Names::default());
    /// let f = g.lower(&parse("ln((|y1|+1e-6)/V)*sgn(y1)").unwrap(), |s| Some(n.intern(s))).unwrap();
    /// assert_eq!(g.latex(f, &n), r"\ln\left(\frac{\left|y_{1}\right| + 10^{-6}}{V}\right)\,\operatorname{sgn}(y_{1})");
    /// ```
    pub fn latex(&self, root: Id, names: &Names) -> String {
        self.print(root, names, Style::Latex)
    }

    fn print(&self, root: Id, names: &Names, style: Style) -> String {
        let mut out = String::new();
        let mut stack = vec![Piece::Node(root, 0)];
        while let Some(piece) = stack.pop() {
            let (id, floor) = match piece {
                Piece::Text(text) => {
                    out.push_str(text);
                    continue;
                }
                Piece::Node(id, floor) => (id, floor),
            };
            let (open, close) = match (self.precedence(id, style) < floor, style) {
                (false, _) => ("", ""),
                (true, Style::Text) => ("(", ")"),
                (true, Style::Latex) => ("\\left(", "\\right)"),
            };
            out.push_str(open);
            match (self.node(id), style) {
                (Node::Constant(bits), Style::Latex) => out.push_str(&latex_number(f64::from_bits(bits), 4)),
                (Node::Constant(bits), Style::Text) => out.push_str(&number(f64::from_bits(bits))),
                (Node::Symbol(s), Style::Latex) => out.push_str(&latex_symbol(s, names)),
                (Node::Symbol(s), Style::Text) => out.push_str(names.name(s)),
                _ => {}
            }
            stack.push(Piece::Text(close));
            stack.extend(self.pieces(id, style).into_iter().rev());
        }
        out
    }

    fn precedence(&self, id: Id, style: Style) -> u8 {
        match self.node(id) {
            Node::Constant(bits) if f64::from_bits(bits).is_sign_negative() => 1,
            // 1.5 x 10^-6 is a product.
            Node::Constant(bits)
                if style == Style::Latex && latex_number(f64::from_bits(bits), 4).contains("10^") =>
            {
                3
            }
            Node::Constant(_) | Node::Symbol(_) => ATOM,
            Node::Unary(Unary::Neg, _) => 1,
            Node::Binary(Binary::Mul, c, _) if self.value(c).is_some_and(|c| c < 0.0) => 1,
            Node::Binary(Binary::Div, ..) if style == Style::Latex => ATOM - 1,
            Node::Binary(op, ..) if op.row().precedence > 0 => op.row().precedence,
            _ => ATOM,
        }
    }

    /// The parts of an operation in the order of printing; empty for numbers and names.
    fn pieces(&self, id: Id, style: Style) -> Vec<Piece> {
        match (self.node(id), style) {
            (Node::Constant(_) | Node::Symbol(_), _) => vec![],
            (Node::Unary(Unary::Neg, a), _) => vec![Piece::Text("-"), Piece::Node(a, PRODUCT)],
            (Node::Unary(op, a), Style::Text) => {
                vec![Piece::Text(op.row().name), Piece::Text("("), Piece::Node(a, 0), Piece::Text(")")]
            }
            (Node::Unary(op, a), Style::Latex) => self.filled(op.row().latex, &[(a, 0)]),
            (Node::Binary(Binary::Timing, a, b), Style::Text) => {
                vec![Piece::Node(a, 0), Piece::Text(", "), Piece::Node(b, 0)]
            }
            (Node::Binary(op, a, b), Style::Text) if op.row().precedence == 0 => {
                let open = [Piece::Text(op.row().name), Piece::Text("("), Piece::Node(a, 0)];
                open.into_iter().chain([Piece::Text(", "), Piece::Node(b, 0), Piece::Text(")")]).collect()
            }
            (Node::Binary(op, a, b), Style::Text) => {
                let sign = match op {
                    Binary::Add => " + ",
                    Binary::Sub => " - ",
                    _ => op.row().name,
                };
                let (mut left, mut right) = sides(op);
                if op == Binary::Mul && self.value(a).is_some() {
                    left = 0; // the minus of -2*x is the product's
                    if self.is_plain_product(b) {
                        right = PRODUCT; // 2*x*y and 2*(x*y) are the same node
                    }
                }
                vec![Piece::Node(a, left), Piece::Text(sign), Piece::Node(b, right)]
            }
            (Node::Binary(Binary::Div, a, b), Style::Latex) => {
                self.filled(Binary::Div.row().latex, &[(a, 0), (b, 0)])
            }
            (Node::Binary(Binary::Pow, a, b), Style::Latex) => {
                self.filled(Binary::Pow.row().latex, &[(a, ATOM), (b, 0)])
            }
            (Node::Binary(Binary::Mul, a, b), Style::Latex) => {
                // Two numbers side by side need a dot.
                let sign = if self.starts_with_number(b) {
                    " \\cdot "
                } else {
                    Binary::Mul.row().latex.trim_start_matches("#1").trim_end_matches("#2")
                };
                let left = if self.value(a).is_some() { 0 } else { PRODUCT };
                vec![Piece::Node(a, left), Piece::Text(sign), Piece::Node(b, PRODUCT)]
            }
            (Node::Binary(op, a, b), Style::Latex) => {
                let (left, right) = match op {
                    // a + (b - c) needs no parentheses.
                    Binary::Add if !self.starts_with_minus(b) => (0, 1),
                    _ if op.row().precedence == 0 => (0, 0),
                    _ => sides(op),
                };
                self.filled(op.row().latex, &[(a, left), (b, right)])
            }
        }
    }

    /// A product that begins neither with a number nor with a quotient.
    fn is_plain_product(&self, id: Id) -> bool {
        let mut first = id;
        while let Node::Binary(Binary::Mul, a, _) = self.node(first) {
            first = a;
        }
        first != id && !matches!(self.node(first), Node::Constant(_) | Node::Binary(Binary::Div, ..))
    }

    fn starts_with_minus(&self, mut id: Id) -> bool {
        while let Node::Binary(Binary::Add | Binary::Sub, a, _) = self.node(id) {
            id = a;
        }
        self.precedence(id, Style::Latex) == 1
    }

    fn starts_with_number(&self, mut id: Id) -> bool {
        loop {
            match self.node(id) {
                Node::Constant(_) => return true,
                Node::Binary(Binary::Mul | Binary::Pow, a, _) => id = a,
                _ => return false,
            }
        }
    }

    /// The template of a row with its operands; tall operands get tall parentheses.
    fn filled(&self, template: &'static str, operands: &[(Id, u8)]) -> Vec<Piece> {
        let leaf = |id: Id| matches!(self.node(id), Node::Constant(_) | Node::Symbol(_));
        let tall = !operands.iter().all(|&(id, _)| leaf(id));
        let mut pieces = Vec::new();
        let mut rest = template;
        while let Some(at) = rest.find(['#', '(', ')']) {
            pieces.push(Piece::Text(&rest[..at]));
            rest = &rest[at..];
            let (piece, length) = match &rest[..1] {
                "(" if tall => (Piece::Text("\\left("), 1),
                ")" if tall => (Piece::Text("\\right)"), 1),
                "#" => {
                    let (id, floor) = operands[usize::from(&rest[1..2] == "2")];
                    (Piece::Node(id, floor), 2)
                }
                _ => (Piece::Text(&rest[..1]), 1),
            };
            pieces.push(piece);
            rest = &rest[length..];
        }
        pieces.push(Piece::Text(rest));
        pieces
    }
}

/// The precedence below which the left and right operand need parentheses.
fn sides(op: Binary) -> (u8, u8) {
    let p = op.row().precedence;
    match op {
        Binary::Add => (p - 1, p + 1),
        Binary::Pow => (p + 1, p - 1),
        _ => (if p == 1 { 0 } else { p }, p + 1),
    }
}

/// The shortest text that reads back as the same number.
fn number(x: f64) -> String {
    let size = x.abs();
    if size != 0.0 && !(1e-4..1e15).contains(&size) { format!("{x:e}") } else { format!("{x}") }
}

/// A number in LaTeX with `digits` significant digits, trailing zeros dropped; below 10^5 every digit before
/// the point is kept.
///
/// ```
/// use phisindy_expr::latex_number;
/// assert_eq!(latex_number(1e-6, 4), "10^{-6}");
/// assert_eq!(latex_number(-0.30001, 3), "-0.3");
/// assert_eq!(latex_number(123456.0, 4), "1.235\\times 10^{5}");
/// ```
pub fn latex_number(x: f64, digits: usize) -> String {
    if !x.is_finite() {
        return if x.is_nan() {
            "\\mathrm{NaN}".into()
        } else if x > 0.0 {
            "\\infty".into()
        } else {
            "-\\infty".into()
        };
    }
    let x = x + 0.0; // no minus before a zero
    let scientific = format!("{:.*e}", digits.max(1) - 1, x);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..5).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        return trimmed(&format!("{x:.decimals$}")).to_owned();
    }
    let mut out = String::new();
    match trimmed(mantissa) {
        "1" => {}
        "-1" => out.push('-'),
        m => {
            let _ = write!(out, "{m}\\times ");
        }
    }
    let _ = write!(out, "10^{{{exponent}}}");
    out
}

fn trimmed(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

fn latex_symbol(symbol: Symbol, names: &Names) -> String {
    match names.rate_of(symbol) {
        Some(of) => latex_rate(names.name(of)),
        None => latex_name(names.name(symbol)),
    }
}

/// A name in LaTeX: Greek letters by name, trailing digits as an index, longer names upright.
///
/// ```
/// use phisindy_expr::latex_name;
/// assert_eq!(latex_name("x1"), "x_{1}");
/// assert_eq!(latex_name("mu"), "\\mu");
/// assert_eq!(latex_name("omega_n"), "\\omega_{\\mathrm{n}}");
/// assert_eq!(latex_name("load"), "\\mathrm{load}");
/// ```
pub fn latex_name(name: &str) -> String {
    const GREEK: &[&str] = &[
        "alpha", "beta", "gamma", "delta", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu", "nu",
        "xi", "pi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega", "Gamma", "Delta",
        "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi", "Omega",
    ];
    let (stem, index) = match name.split_once('_') {
        Some((stem, index)) if !stem.is_empty() && !index.is_empty() => (stem, index),
        _ => name.split_at(name.trim_end_matches(|c: char| c.is_ascii_digit()).len()),
    };
    let (stem, index) = if stem.is_empty() { (name, "") } else { (stem, index) };
    let stem = match stem {
        "eps" | "epsilon" => "\\varepsilon".to_owned(),
        greek if GREEK.contains(&greek) => format!("\\{greek}"),
        "_" => "\\_".to_owned(),
        one if one.chars().count() == 1 => one.to_owned(),
        word => format!("\\mathrm{{{}}}", word.replace('_', "\\_")),
    };
    match index {
        "" => stem,
        digits if digits.chars().all(|c| c.is_ascii_digit()) => format!("{stem}_{{{digits}}}"),
        word => format!("{stem}_{{\\mathrm{{{}}}}}", word.replace('_', "\\_")),
    }
}

/// The rate of a name in LaTeX, the name with a dot above it.
///
/// ```
/// use phisindy_expr::latex_rate;
/// assert_eq!(latex_rate("y1"), "\\dot{y}_{1}");
/// ```
pub fn latex_rate(name: &str) -> String {
    let latex = latex_name(name);
    match latex.find("_{") {
        Some(at) => format!("\\dot{{{}}}{}", &latex[..at], &latex[at..]),
        None => format!("\\dot{{{latex}}}"),
    }
}
