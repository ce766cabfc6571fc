//! The expressions of a law as nodes.

use super::{Law, Role};
use phisindy_expr::{Graph, Id, Names, ParseError, Symbol, parse};
use std::collections::HashMap;
use std::fmt;

/// The expressions of a law as nodes of a graph of their own. Its symbols become nodes of a model where the law acts.
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
    /// In the order of [`Law::parameters`].
    pub parameters: Vec<Id>,
    /// The states of [`Law::internal`], in their order, ...
    pub internal: Vec<Id>,
    /// ... and their rates.
    pub rates: Vec<Id>,
    /// The force that is subtracted; a push has its sign turned.
    pub force: Option<Id>,
    /// The same of the mirror image.
    pub mirror: Option<Id>,
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
    /// Each parameter from coefficients and grid, in the order of [`Law::parameters`].
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
            force: None,
            mirror: None,
            requirement: None,
            screen: None,
            outside: vec![],
        }
    }
}

impl LawGraph {
    pub(super) fn new(law: &Law) -> Result<LawGraph, LawError> {
        let mut compiler = Compiler { of: LawGraph::default(), given: HashMap::new() };
        let displacement = law.role(Role::Displacement).map(|name| compiler.symbol(name));
        let velocity = law.role(Role::Velocity).map(|name| compiler.symbol(name));
        let load = law.role(Role::Load).map(|name| compiler.symbol(name));
        let parameters = law.parameters.iter().map(|(name, _)| compiler.symbol(name)).collect();
        let internal: Vec<Id> = law.internal.iter().map(|(name, _)| compiler.symbol(name)).collect();
        for (name, (value, _)) in &law.given {
            let symbol = compiler.symbol(name);
            let number = compiler.of.graph.constant(*value);
            compiler.given.insert(symbol, number);
        }
        // What is known by now belongs to the law; any other name of a force is one of the model.
        let own = Own(compiler.of.names.clone());
        compiler.of.displacement = displacement;
        compiler.of.velocity = velocity;
        compiler.of.load = load;
        compiler.of.parameters = parameters;
        for (name, inner) in &law.internal {
            let rate = compiler.open(&format!("internal {name}"), &inner.rate, &own)?;
            compiler.of.rates.push(rate);
        }
        compiler.of.internal = internal;
        if let Some(text) = &law.force {
            compiler.of.force = Some(compiler.open("force", text, &own)?);
        } else if let Some(text) = &law.push {
            let push = compiler.open("push", text, &own)?;
            compiler.of.force = Some(compiler.of.graph.neg(push));
        }
        if let Some(text) = &law.mirror {
            compiler.of.mirror = Some(compiler.open("mirror", text, &own)?);
        }
        if let Some(need) = &law.needs {
            let names: Vec<&str> = law.parameters.iter().map(|(name, _)| name.as_str()).collect();
            compiler.of.requirement = Some(compiler.closed("needs", &need.positive, &names)?);
        }
        compiler.of.screen = law.screen.as_ref().map(|s| compiler.screen(law, s, &own)).transpose()?;
        Ok(compiler.of)
    }
}

/// Names that a law declares.
struct Own(Names);

struct Compiler {
    of: LawGraph,
    /// Held numbers, by symbol.
    given: HashMap<Id, Id>,
}

impl Compiler {
    fn symbol(&mut self, name: &str) -> Id {
        let symbol = self.of.names.intern(name);
        self.of.graph.symbol(symbol)
    }

    fn lower(
        &mut self,
        field: &str,
        text: &str,
        known: impl Fn(&Names, &str) -> Option<Symbol>,
    ) -> Result<Id, LawError> {
        let ast = parse(text).map_err(|error| LawError::Expression {
            field: field.into(),
            text: text.into(),
            error,
        })?;
        let names = &self.of.names;
        let root = self.of.graph.lower(&ast, |name| known(names, name)).map_err(|unknown| {
            LawError::UnknownName {
                field: field.into(),
                name: unknown.first().map_or(String::new(), |u| u.name.clone()),
            }
        })?;
        Ok(self.of.graph.replace(&[root], &self.given)[0])
    }

    /// An expression in which names of the model may stand beside the law's own.
    fn open(&mut self, field: &str, text: &str, own: &Own) -> Result<Id, LawError> {
        if let Ok(ast) = parse(text) {
            for (name, _) in ast.names().filter(|(name, _)| own.0.get(name).is_none() && *name != "pi") {
                let node = self.symbol(name);
                if !self.of.outside.iter().any(|(n, _)| n == name) {
                    self.of.outside.push((name.to_owned(), node));
                }
            }
        }
        self.lower(field, text, |names, name| names.get(name))
    }

    /// An expression of these names alone.
    fn closed(&mut self, field: &str, text: &str, allowed: &[&str]) -> Result<Id, LawError> {
        self.lower(field, text, |names, name| allowed.contains(&name).then(|| names.get(name)).flatten())
    }

    fn screen(&mut self, law: &Law, screen: &super::Screen, own: &Own) -> Result<LawScreen, LawError> {
        let grid: Vec<Id> = screen.grid.iter().map(|(name, _)| self.symbol(name)).collect();
        // The numbers of the grid are the law's own too.
        let mut own = Own(own.0.clone());
        screen.grid.iter().for_each(|(name, _)| {
            own.0.intern(name);
        });
        let columns = screen
            .columns
            .iter()
            .map(|text| self.open("screen columns", text, &own))
            .collect::<Result<_, _>>()?;
        let rate = screen.rate.as_ref().map(|text| self.open("screen rate", text, &own)).transpose()?;
        let names: Vec<String> = (1..=screen.columns.len()).map(|k| format!("c{k}")).collect();
        let coefficients = names.iter().map(|name| self.symbol(name)).collect();
        let allowed: Vec<&str> =
            names.iter().map(String::as_str).chain(screen.grid.iter().map(|(n, _)| n.as_str())).collect();
        let mut seeds = Vec::new();
        for (name, _) in &law.parameters {
            let seed = screen.seed.iter().find(|(n, _)| n == name);
            let (_, text) = seed.ok_or_else(|| LawError::NoSeed(name.clone()))?;
            seeds.push(self.closed(&format!("seed of {name}"), text, &allowed)?);
        }
        Ok(LawScreen { columns, coefficients, grid, rate, seeds })
    }
}

/// The parameters (by index) in which an expression is linear, jointly: the slope by each depends on none of them.
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
