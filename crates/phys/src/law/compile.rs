//! Reads a law: its text, and its expressions as nodes.

use super::graph::{LawError, LawGraph, LawScreen};
use super::{INPUT, Law, Role, Screen};
use phisindy_expr::{Id, Names, Symbol, parse};
use std::collections::HashMap;

impl Law {
    /// Reads the text of a law and compiles its expressions.
    ///
    /// # Errors
    /// The form (with line and column), bounds between which there is no number, an expression that cannot be
    /// parsed, a name that stands for nothing, a parameter without a seed.
    pub fn read(text: &str) -> Result<Law, LawError> {
        let mut law: Law = ron::Options::default()
            .with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME)
            .from_str(text)
            .map_err(|e| LawError::Form(e.to_string()))?;
        for (name, parameter) in &law.parameters {
            let (low, high) = parameter.within;
            if low > high || low.is_nan() || high.is_nan() {
                return Err(LawError::Form(format!(
                    "`{name}`: there is no number within ({low:?}, {high:?})"
                )));
            }
        }
        // The short form of `gain*u`.
        if let (Some("gain"), Some((gain, _))) = (law.input.as_deref(), law.parameters.first()) {
            law.input = Some(format!("{gain}*{INPUT}"));
        }
        Ok(Law { compiled: compiled(&law)?, ..law })
    }
}

/// The expressions of a law as nodes.
fn compiled(law: &Law) -> Result<LawGraph, LawError> {
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
    let input = law.acting().map(|_| compiler.symbol(INPUT));
    // What is known by now belongs to the law; any other name of a force is one of the model.
    let own = Own(compiler.of.names.clone());
    compiler.of.displacement = displacement;
    compiler.of.velocity = velocity;
    compiler.of.load = load;
    compiler.of.parameters = parameters;
    let numbers: Vec<&str> = law.parameters.iter().map(|(name, _)| name.as_str()).collect();
    for (name, inner) in &law.internal {
        let rate = compiler.open(&format!("internal {name}"), &inner.rate, &own)?;
        compiler.of.rates.push(rate);
        let closed = |text: &String| compiler.closed(&format!("inertia of {name}"), text, &numbers);
        let inertia = inner.inertia.as_ref().map(closed).transpose()?;
        compiler.of.inertias.push(inertia);
    }
    compiler.of.internal = internal;
    if let Some(text) = &law.force {
        compiler.of.force = Some(compiler.open("force", text, &own)?);
    } else if let Some(text) = &law.push {
        let push = compiler.open("push", text, &own)?;
        compiler.of.force = Some(compiler.of.graph.neg(push));
    }
    if let (Some(input), Some(text)) = (input, law.acting()) {
        compiler.of.acting = Some((input, compiler.open("input", text, &own)?));
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

    fn screen(&mut self, law: &Law, screen: &Screen, own: &Own) -> Result<LawScreen, LawError> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_have_a_number_between_them() {
        let law = |within: &str| {
            let text = format!(
                r#"(name: "A", roles: {{ "v": "m/s" }}, parameters: {{ "c": (unit: "", within: {within}) }}, force: "c*sgn(v)")"#
            );
            Law::read(&text).map(|law| law.sticks() && law.dissipates().is_some())
        };
        assert_eq!(law("(2.0, 2.0)"), Ok(true));
        for within in ["(5.1, 4.0)", "(NaN, 1.0)", "(0.0, NaN)"] {
            assert!(matches!(law(within), Err(LawError::Form(why)) if why.contains("`c`")), "{within}");
        }
    }
}
