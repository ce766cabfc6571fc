//! The functions of every exported model: the rates in given modes, the surfaces with the derivatives that
//! the contact rule needs, and what sensors read.

use super::identifier::Identifiers;
use super::subject::Subject;
use phisindy_expr::{Code, Id, Language, Naming, Node, Symbol};
use std::collections::HashMap;

/// A function: the arguments it reads, and its expressions.
pub(crate) struct Function {
    /// Local name and source of its value.
    pub(crate) reads: Vec<(String, Read)>,
    pub(crate) code: Code,
}

/// The source of a local variable's value.
pub(crate) enum Read {
    /// An element of a list argument.
    Element(&'static str, usize),
    /// A constant, by its index.
    Constant(usize),
}

/// The functions and their identifiers.
pub(crate) struct Functions {
    pub(crate) identifiers: Identifiers,
    /// `dx/dt`.
    pub(crate) flow: Function,
    /// `w`, `dw/dt`, `d(dw/dt)/ds`, `dw/dx`.
    pub(crate) surfaces: Function,
    /// The outputs.
    pub(crate) outputs: Function,
}

impl Functions {
    /// The functions in a language.
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
        let (flow, surfaces, outputs) = (function(&s.rates), function(&all), function(&s.outputs));
        Functions { identifiers, flow, surfaces, outputs }
    }
}

/// A prefix that gives unused names when followed by a number.
pub(crate) fn stem_of_temporaries(names: &[&str]) -> String {
    let mut stem = "q".to_owned();
    while names.iter().any(|n| n.strip_prefix(&stem).is_some_and(|rest| rest.parse::<usize>().is_ok())) {
        stem.push('q');
    }
    stem
}
