//! A model in the plain mathematical sense: rates as functions of time, states, inputs and parameters.

use crate::system::impact::Rebound;
use phisindy_expr::{Graph, Id, Names, Symbol};

/// Rates of change of states, as expressions. What the simulator and the estimator work on; it knows nothing
/// of files or units.
///
/// ```
/// use phisindy_phys::Model;
/// let model = Model::build(&["x", "v"], &[], &["mu"], &["v", "-x - mu*sgn(v)"]).unwrap();
/// assert_eq!(model.states.len(), 2);
/// ```
#[derive(Clone, Debug)]
pub struct Model {
    /// Where the expressions live.
    pub graph: Graph,
    /// Names of the symbols in the graph.
    pub names: Names,
    /// The node of time.
    pub time: Id,
    /// The nodes of the states.
    pub states: Vec<Id>,
    /// The nodes of the inputs (given functions of time).
    pub inputs: Vec<Id>,
    /// The nodes of the parameters (numbers that can differ between runs).
    pub parameters: Vec<Id>,
    /// dx/dt for each state.
    pub rates: Vec<Id>,
    /// What is read beside the states.
    pub outputs: Vec<Id>,
    /// What happens where gaps close.
    pub impacts: Vec<Rebound>,
}

impl Model {
    /// A model from texts, for tests and examples: one rate for each state, `t` is time.
    ///
    /// # Errors
    /// The first mistake, in words.
    pub fn build(
        states: &[&str],
        inputs: &[&str],
        parameters: &[&str],
        rates: &[&str],
    ) -> Result<Model, String> {
        let (mut graph, mut names) = (Graph::default(), Names::default());
        let time = names.intern("t");
        let mut nodes = |list: &[&str]| -> Vec<Id> {
            list.iter()
                .map(|n| names.intern(n))
                .collect::<Vec<Symbol>>()
                .into_iter()
                .map(|s| graph.symbol(s))
                .collect()
        };
        let (states, inputs, parameters) = (nodes(states), nodes(inputs), nodes(parameters));
        let time = graph.symbol(time);
        let mut roots = Vec::new();
        for text in rates {
            let ast = phisindy_expr::parse(text).map_err(|e| format!("{e} in `{text}`"))?;
            let root = graph.lower(&ast, |name| names.get(name));
            roots.push(root.map_err(|e| format!("unknown name `{}` in `{text}`", e[0].name))?);
        }
        if roots.len() != states.len() {
            return Err(format!("{} states but {} rates", states.len(), roots.len()));
        }
        Ok(Model {
            graph,
            names,
            time,
            states,
            inputs,
            parameters,
            rates: roots,
            outputs: vec![],
            impacts: vec![],
        })
    }

    /// The model with an output more, for tests and examples.
    ///
    /// # Errors
    /// As [`Model::build`].
    pub fn reading(mut self, text: &str) -> Result<Model, String> {
        let root = self.lowered(text)?;
        self.outputs.push(root);
        Ok(self)
    }

    /// An expression among the names of the model.
    pub(crate) fn lowered(&mut self, text: &str) -> Result<Id, String> {
        let ast = phisindy_expr::parse(text).map_err(|e| format!("{e} in `{text}`"))?;
        let names = &self.names;
        let root = self.graph.lower(&ast, |name| names.get(name));
        root.map_err(|e| format!("unknown name `{}` in `{text}`", e[0].name))
    }

    /// What the rates are functions of, in the order in which tapes take it: time, states, inputs,
    /// parameters.
    pub fn arguments(&self) -> Vec<Id> {
        let moving =
            [self.time].into_iter().chain(self.states.iter().copied()).chain(self.inputs.iter().copied());
        moving.chain(self.parameters.iter().copied()).collect()
    }

    /// Name of the state with this index.
    pub fn state_name(&self, index: usize) -> &str {
        match self.graph.node(self.states[index]) {
            phisindy_expr::Node::Symbol(s) => self.names.name(s),
            _ => "",
        }
    }

    /// A node as text in the language of the specs.
    pub fn text(&self, node: Id) -> String {
        self.graph.text(node, &self.names)
    }
}
