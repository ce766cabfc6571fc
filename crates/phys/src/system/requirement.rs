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
    /// The same in the language of the specs.
    text: String,
}

impl Requirement {
    /// The condition of a law's file for these constants of a system, given as pairs of the law's name and
    /// the system's; `None` if a name stands for nothing there.
    pub fn new(
        system: &mut System,
        law: &str,
        need: &Need,
        simpler: &[String],
        names: &[(String, String)],
    ) -> Option<Requirement> {
        let text = rename(&need.positive, names).ok()?;
        let node = lowered(&text, system)?;
        let (law, because, simpler) = (law.to_owned(), need.because.clone(), simpler.to_vec());
        Some(Requirement { law, because, simpler, node, text })
    }

    /// The same condition on the constants of another system; `None` if it lacks one of them.
    pub fn of(&self, system: &mut System) -> Option<Requirement> {
        Some(Requirement { node: lowered(&self.text, system)?, ..self.clone() })
    }
}

/// A condition as a node of a system's graph.
fn lowered(text: &str, system: &mut System) -> Option<Id> {
    let mut ast = parse(text).ok()?;
    // Constants that are held are numbers and not names of the graph.
    if ast.names().any(|(name, _)| system.names.get(name).is_none()) {
        let held = system.constants.iter().map(|(name, x)| (name.clone(), format!("({x:?})")));
        ast = parse(&rename(text, &held.collect::<Vec<_>>()).ok()?).ok()?;
    }
    system.graph.lower(&ast, |name| system.names.get(name)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::read;
    use crate::{SourceId, check};
    use phisindy_expr::{Scratch, Tape};

    fn system(known: &str) -> System {
        let text = format!(
            r#"(
                constants: {{ "Fc": Find(start: 1.0, within: (0.0, 9.0)),
                    "Fs": Find(start: 3.0, within: (0.0, 9.0)) }},
                states: {{ "v": "" }},
                known: {{ "v": "{known}" }},
                data: [Csv(path: "a.csv", time: ("t", "s"), columns: {{ "v": "v" }})],
            )"#
        );
        let (spec, _) = read(&text, SourceId(0)).unwrap();
        check(&spec, SourceId(0)).unwrap().0.system
    }

    fn value(required: &Requirement, system: &System) -> f64 {
        let parameters: Vec<Id> = system.parameters.iter().map(|p| p.node).collect();
        let tape = Tape::compile(&system.graph, &parameters, &[required.node]).unwrap();
        let mut scratch = Scratch::<1>::new(&tape);
        scratch.at(system.parameters.iter().map(|p| p.start));
        scratch.output(0)[0]
    }

    #[test]
    fn a_condition_moves_to_another_graph() {
        let mut first = system("Fs - Fc*sgn(v)");
        let need = Need { positive: "Fs - Fc".into(), because: "so".into() };
        let names = [("Fc".to_owned(), "Fc".to_owned()), ("Fs".to_owned(), "Fs".to_owned())];
        let required = Requirement::new(&mut first, "stribeck", &need, &[], &names).unwrap();
        let mut other = system("sin(v) + Fs*exp(-v^2) - Fc*sgn(v)");
        let moved = required.of(&mut other).unwrap();
        assert_eq!((value(&required, &first), value(&moved, &other)), (2.0, 2.0));
        assert_ne!(required.node, moved.node);
    }
}
