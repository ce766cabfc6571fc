//! The terms of an expression where they stand in its text: taken out, or moved to another support.

use phisindy_expr::{Ast, AstKind, Binary, Span, Unary, parse};
use std::collections::HashMap;

/// Longest expression that is edited (nodes).
const LONGEST: usize = 2000;

/// Names of a support that moves: displacement and speed.
type Base<'a> = Option<&'a [Option<String>; 2]>;

/// What moves at the ends of a part: displacements and speeds of bodies, and of a support.
#[derive(Default)]
pub(crate) struct Ends {
    pub(crate) bodies: Vec<[Option<String>; 2]>,
    pub(crate) base: Option<[Option<String>; 2]>,
}

impl Ends {
    /// Displacements (0) or speeds (1) of all that moves.
    pub(crate) fn of(&self, order: usize) -> impl Iterator<Item = &String> {
        self.bodies.iter().chain(&self.base).filter_map(move |pair| pair[order].as_ref())
    }

    /// Each end that moves, as its names.
    pub(crate) fn each(&self) -> impl Iterator<Item = Vec<&String>> {
        self.bodies.iter().chain(&self.base).map(|pair| pair.iter().flatten().collect())
    }

    /// Whether a name is a displacement (0) or a speed (1) of a body.
    fn order(&self, name: &str) -> Option<usize> {
        self.bodies.iter().find_map(|pair| pair.iter().position(|own| own.as_deref() == Some(name)))
    }

    fn is_of_base(&self, name: &str) -> bool {
        self.base.iter().flatten().flatten().any(|own| own == name)
    }
}

/// An expression with its text.
pub(crate) struct Terms<'t> {
    text: &'t str,
    ast: Ast,
    parents: Vec<usize>,
}

/// The text with other texts at some places, which do not meet.
pub(crate) fn applied(text: &str, mut edits: Vec<(Span, String)>) -> String {
    edits.sort_by_key(|(span, _)| span.start);
    let mut out = text.to_owned();
    for (span, new) in edits.into_iter().rev() {
        out.replace_range(span.range(), &new);
    }
    out
}

/// An expression as it stands in a product.
pub(crate) fn factor(text: &str) -> String {
    let simple = text.chars().all(|c| c.is_alphanumeric() || "_.".contains(c));
    if simple { text.to_owned() } else { format!("({text})") }
}

impl<'t> Terms<'t> {
    /// None of what is no expression, or too long a one.
    pub(crate) fn read(text: &'t str) -> Option<Terms<'t>> {
        let ast = parse(text).ok().filter(|ast| ast.nodes.len() <= LONGEST)?;
        let mut parents: Vec<usize> = (0..ast.nodes.len()).collect();
        for (k, node) in ast.nodes.iter().enumerate() {
            operands(&node.kind).for_each(|o| parents[o] = k);
        }
        Some(Terms { text, ast, parents })
    }

    pub(crate) fn root(&self) -> usize {
        self.ast.nodes.len() - 1
    }

    fn span(&self, node: usize) -> Span {
        self.ast.nodes[node].span
    }

    fn inside(&self, node: usize) -> impl Iterator<Item = usize> + use<'_, 't> {
        let all = self.span(node);
        (0..=node).filter(move |&k| all.start <= self.span(k).start && self.span(k).end <= all.end)
    }

    fn name(&self, node: usize) -> Option<&str> {
        match &self.ast.nodes[node].kind {
            AstKind::Name(name) => Some(name),
            _ => None,
        }
    }

    /// The names in a part of it.
    pub(crate) fn names(&self, node: usize) -> Vec<&str> {
        self.inside(node).filter_map(|k| self.name(k)).collect()
    }

    /// The terms with these names; `loose` takes a difference of two names for one thing.
    pub(crate) fn with_names(&self, wanted: &dyn Fn(&str) -> bool, loose: bool) -> Vec<usize> {
        self.found(&|k| self.name(k).is_some_and(wanted), loose)
    }

    /// The terms with a sign of something with these names.
    pub(crate) fn with_sign(&self, along: &dyn Fn(&[&str]) -> bool) -> Vec<usize> {
        let is = |k: usize| match self.ast.nodes[k].kind {
            AstKind::Unary(Unary::Sgn, of) => along(&self.names(of)),
            _ => false,
        };
        self.found(&is, false)
    }

    /// The innermost terms of sums that hold what is wanted.
    fn found(&self, wanted: &dyn Fn(usize) -> bool, loose: bool) -> Vec<usize> {
        let n = self.ast.nodes.len();
        let (mut holds, mut inner) = (vec![false; n], vec![false; n]);
        let bare = |k: usize| matches!(self.ast.nodes[k].kind, AstKind::Name(_) | AstKind::Number(_));
        for k in 0..n {
            let kind = &self.ast.nodes[k].kind;
            holds[k] = wanted(k) || operands(kind).any(|o| holds[o]);
            inner[k] = match *kind {
                AstKind::Binary(Binary::Add | Binary::Sub, a, b) if !(loose && bare(a) && bare(b)) => {
                    holds[a] || holds[b]
                }
                AstKind::Binary(Binary::Mul | Binary::Div, a, b) => inner[a] || inner[b],
                AstKind::Unary(Unary::Neg, a) => inner[a],
                _ => false,
            };
        }
        let (mut all, mut waiting) = (vec![], vec![self.root()]);
        while let Some(k) = waiting.pop() {
            if !holds[k] {
                continue;
            }
            let sum = matches!(self.ast.nodes[k].kind, AstKind::Binary(Binary::Add | Binary::Sub, ..));
            match inner[k] {
                true => waiting.extend(operands(&self.ast.nodes[k].kind).filter(|&o| sum || inner[o])),
                false => all.push(k),
            }
        }
        all
    }

    /// The product about a term in which something moves.
    pub(crate) fn motion(&self, term: usize, moving: &dyn Fn(&str) -> bool) -> usize {
        let mut k = term;
        while !self.names(k).iter().any(|n| moving(n)) && self.parents[k] != k {
            k = self.parents[k];
        }
        k
    }

    /// The text without some terms; none if nothing is left.
    pub(crate) fn without(&self, terms: &[usize]) -> Option<String> {
        self.written(&terms.iter().map(|&k| (k, None)).collect())
    }

    /// The text with some terms along another support: `v` becomes `(v - w)`, or the other way round.
    pub(crate) fn moved(
        &self,
        terms: &[usize],
        moving: &dyn Fn(&str) -> bool,
        ends: &Ends,
        base: Base<'_>,
    ) -> Option<String> {
        let mut changes = HashMap::new();
        for &term in terms {
            let all = self.motion(term, moving);
            let own = |k: usize| self.name(k).is_some_and(|n| ends.order(n).is_some());
            if base.is_none() && !self.inside(all).any(own) {
                changes.insert(term, None);
            }
            changes.extend(self.shifts(all, ends, base));
        }
        self.written(&changes)
    }

    /// All of it along another support.
    pub(crate) fn shifted(&self, ends: &Ends, base: Base<'_>) -> Option<String> {
        let changes: HashMap<_, _> = self.shifts(self.root(), ends, base).into_iter().collect();
        let bare =
            changes.get(&self.root()).and_then(Option::as_ref).map(|t| t.trim_matches(['(', ')']).to_owned());
        if changes.is_empty() { None } else { bare.or_else(|| self.written(&changes)) }
    }

    fn shifts(&self, node: usize, ends: &Ends, base: Base<'_>) -> Vec<(usize, Option<String>)> {
        let relative = |k: usize| match (&self.ast.nodes[k].kind, base) {
            (AstKind::Name(own), Some(base)) => {
                let other = base[ends.order(own)?].as_ref()?;
                let function =
                    |p: usize| matches!(self.ast.nodes[p].kind, AstKind::Unary(u, _) if u != Unary::Neg);
                let moved = format!("{own} - {other}");
                Some((k, Some(if function(self.parents[k]) { moved } else { format!("({moved})") })))
            }
            (AstKind::Binary(Binary::Sub, a, b), None) => match (self.name(*a)?, self.name(*b)?) {
                (own, other) if ends.order(own).is_some() && ends.is_of_base(other) => {
                    Some((k, Some(own.to_owned())))
                }
                (other, own) if ends.order(own).is_some() && ends.is_of_base(other) => {
                    Some((k, Some(format!("(-{own})"))))
                }
                _ => None,
            },
            _ => None,
        };
        self.inside(node).filter_map(relative).collect()
    }

    /// The text with one more force against the motion, divided by a mass.
    pub(crate) fn with_force(&self, force: &str, mass: Option<&str>) -> String {
        let root = &self.ast.nodes[self.root()];
        if let (AstKind::Binary(Binary::Div, sum, by), Some(mass)) = (&root.kind, mass) {
            let (sum, by) = (self.span(*sum), self.span(*by));
            let inner = &self.text[sum.range()];
            if self.text[by.range()].trim() == mass && inner.starts_with('(') && inner.ends_with(')') {
                return format!("{} - {force}{}", &self.text[..sum.end - 1], &self.text[sum.end - 1..]);
            }
        }
        let over = mass.map_or(String::new(), |m| format!("/{}", factor(m)));
        match root.kind {
            AstKind::Number(0.0) => format!("-{force}{over}"),
            _ => format!("{} - {force}{over}", self.text.trim_end()),
        }
    }

    /// The text with some nodes left out or written anew; none if nothing is left.
    fn written(&self, changes: &HashMap<usize, Option<String>>) -> Option<String> {
        let mut all: Vec<Option<String>> = Vec::with_capacity(self.ast.nodes.len());
        for (k, node) in self.ast.nodes.iter().enumerate() {
            let (span, text) = (node.span, self.text);
            let made = match (changes.get(&k), &node.kind) {
                (Some(new), _) => new.clone(),
                (None, AstKind::Unary(_, a)) => {
                    let own = self.span(*a);
                    let inner = all[*a].take();
                    inner.map(|inner| {
                        text[span.start..own.start].to_owned() + &inner + &text[own.end..span.end]
                    })
                }
                (None, AstKind::Binary(op, a, b)) => {
                    let (first, second) = (self.span(*a), self.span(*b));
                    let sum = matches!(op, Binary::Add | Binary::Sub);
                    let [head, gap, tail] =
                        [span.start..first.start, first.end..second.start, second.end..span.end]
                            .map(|r| &text[r]);
                    match (all[*a].take(), all[*b].take()) {
                        (Some(a), Some(b)) => Some(format!("{head}{a}{gap}{b}{tail}")),
                        (Some(a), None) if sum => Some(format!("{head}{a}{tail}")),
                        (None, Some(b)) if *op == Binary::Add => Some(format!("{head}{b}{tail}")),
                        (None, Some(b)) if sum => Some(format!("{head}-{b}{tail}")),
                        _ => None,
                    }
                }
                (None, _) => Some(text[span.range()].to_owned()),
            };
            all.push(made);
        }
        let (root, whole) = (self.span(self.root()), all.pop()??);
        Some(self.text[..root.start].to_owned() + &whole + &self.text[root.end..])
    }
}

fn operands(kind: &AstKind) -> impl Iterator<Item = usize> + use<> {
    let both = match *kind {
        AstKind::Unary(_, a) => [Some(a), None],
        AstKind::Binary(_, a, b) => [Some(a), Some(b)],
        AstKind::Table { of, .. } => [Some(of), None],
        _ => [None, None],
    };
    both.into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_are_taken_out_where_they_stand() {
        for (text, name, left) in [
            ("(F - k*x - d*v)/m", "d", Some("(F - k*x)/m")),
            ("(F - k*x - d*v)/m", "F", Some("(-k*x - d*v)/m")),
            ("-k*x - d*v", "k", Some("-d*v")),
            ("k*x + d*v", "k", Some("d*v")),
            ("(-(c1+c2)*v + c2*w)/m", "c1", Some("(-(c2)*v + c2*w)/m")),
            ("-k/m*x", "k", None),
            (" F/m - c/m*v*abs(v) ", "c", Some(" F/m ")),
        ] {
            let terms = Terms::read(text).unwrap();
            let found = terms.with_names(&|n| n == name, false);
            assert_eq!(terms.without(&found).as_deref(), left, "{text} without {name}");
        }
        let terms = Terms::read("(F - d*v)/m").unwrap();
        assert_eq!(terms.with_force("k*x", Some("m")), "(F - d*v - k*x)/m");
        assert_eq!(Terms::read("F/m").unwrap().with_force("k*x", Some("m")), "F/m - k*x/m");
    }
}
