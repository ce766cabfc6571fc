//! What the constants of a law must fulfil in a model where it is written out.

use crate::law::Need;
use crate::system::equations::System;
use phisindy_expr::{Id, parse, rename};

/// A condition on the constants of a law that stands in a model.
#[derive(Clone, Debug)]
pub struct Requirement {
    /// The law, by its id in the catalogue.
    pub law: String,
    /// What is wrong where the condition does not hold, in words.
    pub because: String,
    /// Laws that it contains, by id, simplest first.
    pub simpler: Vec<String>,
    /// The condition, a node of the system's graph: not negative where it holds.
    pub node: Id,
}

impl Requirement {
    /// The condition of a law's file for these constants of a system, given as pairs of the law's name and the
    /// system's; `None` if a name stands for nothing there.
    pub fn new(
        system: &mut System,
        law: &str,
        need: &Need,
        simpler: &[String],
        names: &[(String, String)],
    ) -> Option<Requirement> {
        let text = rename(&need.positive, names).ok()?;
        let ast = parse(&text).ok()?;
        // Constants that are held are numbers and not names of the graph.
        let fixed: Vec<(String, String)> =
            system.constants.iter().map(|(name, x)| (name.clone(), format!("({x:?})"))).collect();
        let ast = if ast.names().any(|(name, _)| system.names.get(name).is_none()) {
            parse(&rename(&text, &fixed).ok()?).ok()?
        } else {
            ast
        };
        let node = system.graph.lower(&ast, |name| system.names.get(name)).ok()?;
        let (law, because, simpler) = (law.to_owned(), need.because.clone(), simpler.to_vec());
        Some(Requirement { law, because, simpler, node })
    }
}
