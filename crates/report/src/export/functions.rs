//! The two functions that every exported model has: the rates in given modes, and the surfaces with all that the contact rule asks of them.

use super::identifier::Identifiers;
use super::subject::Subject;
use phisindy_expr::{Code, Id, Language, Naming, Node, Symbol};
use std::collections::HashMap;

/// A function's text: what it reads from its arguments, and its expressions.
pub(crate) struct Function {
    /// Local name, and the argument and place it comes from.
    pub(crate) reads: Vec<(String, Read)>,
    pub(crate) code: Code,
}

/// Where a local name gets its value.
pub(crate) enum Read {
    /// An element of an argument that is a list.
    Element(&'static str, usize),
    /// A constant, by its place.
    Constant(usize),
}

/// Both functions, and the identifiers they use.
pub(crate) struct Functions {
    pub(crate) identifiers: Identifiers,
    /// `dx/dt`.
    pub(crate) flow: Function,
    /// `w`, `dw/dt`, `d(dw/dt)/ds`, `dw/dx`.
    pub(crate) surfaces: Function,
}

impl Functions {
    /// Writes both in a language.
    pub(crate) fn new(subject: &Subject, language: Language) -> Functions {
        let mut identifiers = Identifiers::new(language, subject.names());
        let s = &subject.switched;
        let mut reads: HashMap<Symbol, (String, Read)> = HashMap::new();
        let symbol = |id: Id| match s.graph.node(id) {
            Node::Symbol(symbol) => symbol,
            _ => unreachable!("arguments are symbols"),
        };
        for (argument, list) in [("state", &subject.states), ("inputs", &subject.inputs)] {
            for (k, q) in list.iter().enumerate() {
                reads
                    .insert(symbol(q.node), (identifiers.of(&q.name).to_owned(), Read::Element(argument, k)));
            }
        }
        for (k, c) in subject.constants.iter().enumerate() {
            reads.insert(symbol(c.node), (identifiers.of(&c.name).to_owned(), Read::Constant(k)));
        }
        let groups = [
            ("slopes", "slope", &s.slopes),
            ("mode", "mode", &s.modes),
            ("side", "side", &s.sides),
            ("floors", "floor", &s.floors),
            ("margins", "margin", &s.margins),
        ];
        for (argument, stem, list) in groups {
            for (k, &id) in list.iter().enumerate() {
                let name = identifiers.fresh(&format!("{stem}{k}"));
                reads.insert(symbol(id), (name, Read::Element(argument, k)));
            }
        }
        let prefix = stem_of_temporaries(&subject.names().collect::<Vec<_>>());
        let moving = subject.moving();
        let time = symbol(subject.model.time);
        let naming = Naming {
            symbol: &|s| if s == time { "t".to_owned() } else { reads[&s].0.clone() },
            temporary: &|k| format!("{prefix}{k}"),
            moving: &moving,
        };
        let function = |roots: &[Id]| {
            let used = s.graph.symbols(roots).into_iter().filter(|&symbol| symbol != time);
            let read = |symbol: Symbol| match &reads[&symbol] {
                (name, Read::Element(argument, k)) => (name.clone(), Read::Element(argument, *k)),
                (name, Read::Constant(k)) => (name.clone(), Read::Constant(*k)),
            };
            Function { reads: used.map(read).collect(), code: s.graph.code(roots, language, &naming) }
        };
        let all: Vec<Id> = [&s.surfaces, &s.surface_rates, &s.influence, &s.normals]
            .into_iter()
            .flatten()
            .copied()
            .collect();
        let (flow, surfaces) = (function(&s.rates), function(&all));
        Functions { identifiers, flow, surfaces }
    }
}

/// A letter such that, with a number behind it, it is nobody's name.
pub(crate) fn stem_of_temporaries(names: &[&str]) -> String {
    let mut stem = "q".to_owned();
    while names.iter().any(|n| n.strip_prefix(&stem).is_some_and(|rest| rest.parse::<usize>().is_ok())) {
        stem.push('q');
    }
    stem
}
