//! The expressions of a law as nodes of a graph.

use phisindy_expr::{Graph, Id, Names, ParseError, Tape};
use std::fmt;

/// The expressions of a law as nodes of a graph of their own. Its symbols become nodes of a model where the
/// law acts.
///
/// ```
/// use phisindy_phys::Law;
/// let law = Law::read(r#"(name: "Drag", roles: { "v": "m/s" }, parameters: { "d": (unit: "N*s^2/m^2", within: (0.0, 10.0)) }, force: "d*v*abs(v)")"#);
/// let law = law.unwrap();
/// let of = law.nodes();
/// assert_eq!(of.graph.text(of.force.unwrap(), &of.names), "d*v*abs(v)");
/// assert_eq!((of.parameters.len(), of.outside.len()), (1, 0));
/// ```
#[derive(Clone, Debug)]
pub struct LawGraph {
    /// Where the expressions live.
    pub graph: Graph,
    /// Names of its symbols.
    pub names: Names,
    /// The time.
    pub time: Id,
    /// The displacement of the place.
    pub displacement: Option<Id>,
    /// The velocity of the place.
    pub velocity: Option<Id>,
    /// A force of the known part of the model.
    pub load: Option<Id>,
    /// In the order of [`Law::parameters`](super::Law::parameters).
    pub parameters: Vec<Id>,
    /// The states of [`Law::internal`](super::Law::internal), in their order, ...
    pub internal: Vec<Id>,
    /// ... their rates, ...
    pub rates: Vec<Id>,
    /// ... and the inertias of those that are speeds of bodies.
    pub inertias: Vec<Option<Id>>,
    /// The force that is subtracted; a push has its sign turned.
    pub force: Option<Id>,
    /// The same of the mirror image.
    pub mirror: Option<Id>,
    /// The recorded input, and what acts in its place.
    pub acting: Option<(Id, Id)>,
    /// What may not be negative: an expression of the parameters.
    pub requirement: Option<Id>,
    /// How `gap` screens it.
    pub screen: Option<LawScreen>,
    /// Names that the law leaves to the model in which it acts.
    pub outside: Vec<(String, Id)>,
}

/// The expressions of [`super::Screen`] as nodes.
#[derive(Clone, Debug)]
pub struct LawScreen {
    /// What is added to the force, each with a coefficient of its own.
    pub columns: Vec<Id>,
    /// The coefficients, `c1`, `c2`, ...
    pub coefficients: Vec<Id>,
    /// Numbers that are tried on a grid.
    pub grid: Vec<Id>,
    /// The rate of the internal state in terms of the grid.
    pub rate: Option<Id>,
    /// Each parameter from coefficients and grid, in the order of
    /// [`Law::parameters`](super::Law::parameters).
    pub seeds: Vec<Id>,
}

/// Why a law cannot be read.
#[derive(Clone, Debug, PartialEq)]
pub enum LawError {
    /// It is no law by its form: what and where.
    Form(String),
    /// An expression that is none.
    Expression {
        /// Where it stands: `force`, `internal z`, ...
        field: String,
        /// As it is written.
        text: String,
        /// What is wrong with it.
        error: ParseError,
    },
    /// A name that stands for nothing there.
    UnknownName {
        /// Where it stands.
        field: String,
        /// The name.
        name: String,
    },
    /// A parameter that the screen gives no start.
    NoSeed(String),
}

impl fmt::Display for LawError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LawError::Form(what) => f.write_str(what),
            LawError::Expression { field, text, error } => write!(f, "`{field}`: {error} in `{text}`"),
            LawError::UnknownName { field, name } => {
                write!(f, "`{field}`: the name `{name}` stands for nothing here")
            }
            LawError::NoSeed(name) => write!(f, "`screen` has no seed for the parameter `{name}`"),
        }
    }
}

impl std::error::Error for LawError {}

impl Default for LawGraph {
    /// The graph of a law that says nothing.
    fn default() -> Self {
        let (mut graph, mut names) = (Graph::default(), Names::default());
        let time = names.intern("t");
        LawGraph {
            time: graph.symbol(time),
            graph,
            names,
            displacement: None,
            velocity: None,
            load: None,
            parameters: vec![],
            internal: vec![],
            rates: vec![],
            inertias: vec![],
            force: None,
            mirror: None,
            acting: None,
            requirement: None,
            screen: None,
            outside: vec![],
        }
    }
}

impl LawGraph {
    /// A program of some nodes, and the symbols that they use, which are its inputs.
    pub(super) fn program(graph: &mut Graph, outputs: &[Id]) -> (Vec<Id>, Tape) {
        let symbols: Vec<Id> = graph.symbols(outputs).into_iter().map(|s| graph.symbol(s)).collect();
        let tape = Tape::compile(graph, &symbols, outputs).expect("every symbol is an input");
        (symbols, tape)
    }
}

/// The parameters (by index) in which an expression is linear, jointly: the slope by each depends on none of
/// them.
pub fn jointly_linear(graph: &mut Graph, force: Id, parameters: &[Id]) -> Vec<usize> {
    let slopes = graph.gradient(force, parameters);
    let mut linear: Vec<usize> = Vec::new();
    for k in 0..parameters.len() {
        let free = linear.iter().chain([&k]).all(|&j| !graph.uses(&[slopes[k]], &[parameters[j]]))
            && linear.iter().all(|&j| !graph.uses(&[slopes[j]], &[parameters[k]]));
        if free {
            linear.push(k);
        }
    }
    linear
}
