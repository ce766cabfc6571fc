//! The regressors of a law at a place: columns with free coefficients, grid parameters, and the map from both
//! to the law's parameters.

use crate::place::{Effect, Site, bindings};
use phisindy_expr::{Graph, Id, Scratch, Tape};
use phisindy_phys::unit::{Dimension, Unit};
use phisindy_phys::{Law, LawGraph, LawScreen, System};

/// The quantity that scales a grid parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scale {
    /// A displacement.
    Displacement,
    /// A speed.
    Speed,
    /// An angular frequency.
    Frequency,
    /// No scale: powers of ten are nonlinear.
    Any,
}

/// A law at a place, ready to be evaluated on data.
pub(super) struct Regressors {
    pub(super) graph: Graph,
    /// Symbols of the grid parameters, in the order of `grid`.
    pub(super) symbols: Vec<Id>,
    /// The force that each regressor subtracts.
    pub(super) columns: Vec<Id>,
    /// The law's internal state and its rate.
    pub(super) internal: Option<(Id, Id)>,
    /// Displacement and velocity of the place.
    pub(super) displacement: Option<Id>,
    pub(super) velocity: Id,
    /// The grid parameters: scale, and whether they may be negative.
    pub(super) grid: Vec<(Scale, bool)>,
    back: Back,
}

/// The map from coefficients and grid values to parameters.
enum Back {
    /// Each parameter is a coefficient (`Ok`, its index) or a grid value (`Err`).
    Direct(Vec<Result<usize, usize>>),
    /// Expressions of c1, c2, ... and the grid values.
    Formulas(Tape),
}

impl Regressors {
    /// The regressors of an effect in a system. `None` for an effect on sensors, for a law with an internal
    /// state and no `screen` entry in its file, and for a law that uses names which the system does not have.
    pub(super) fn new(effect: &Effect, system: &System) -> Option<Regressors> {
        let Site::Force { displacement, velocity, .. } = &effect.place.site else { return None };
        let law = &effect.entry.law;
        let of = law.nodes();
        let mut system = system.clone();
        let mut with = bindings(effect, &mut system).ok()?;
        let hidden = |symbol: &Id, system: &mut System, k: usize| {
            // The space in the name avoids collisions with names of a spec.
            let name = system.names.intern(&format!("regressor {k}"));
            (*symbol, system.graph.symbol(name))
        };
        let grid_symbols = of.screen.iter().flat_map(|s| &s.grid);
        let own: Vec<&Id> = of.parameters.iter().chain(&of.internal).chain(grid_symbols).collect();
        for (k, symbol) in own.into_iter().enumerate() {
            if !with.contains_key(symbol) {
                let (symbol, node) = hidden(symbol, &mut system, k);
                with.insert(symbol, node);
            }
        }
        let roots: Vec<Id> = match &of.screen {
            Some(screen) => screen.columns.iter().copied().chain(screen.rate).collect(),
            None if law.has_memory() => return None,
            None => vec![if effect.mirror { of.mirror? } else { of.force? }],
        };
        let mut nodes = system.graph.graft(&of.graph, &roots, &with).ok()?;
        let load = match &effect.load {
            Some(load) => Some(system.quantity(load)?),
            None => None,
        };
        let here = |symbols: &[Id]| -> Vec<Id> { symbols.iter().map(|s| with[s]).collect() };
        let mut out = Regressors {
            symbols: vec![],
            columns: vec![],
            internal: None,
            displacement: displacement.as_ref().map(|d| d.node),
            velocity: velocity.node,
            grid: vec![],
            back: Back::Direct(vec![]),
            graph: system.graph,
        };
        match (&of.screen, &law.screen) {
            (Some(screen), Some(text)) => {
                out.internal =
                    screen.rate.and_then(|_| Some((here(&of.internal).first().copied()?, nodes.pop()?)));
                nodes.truncate(screen.columns.len());
                out.columns = nodes;
                out.symbols = here(&screen.grid);
                out.grid = text.grid.iter().map(|(name, unit)| (scale(unit), negative(law, name))).collect();
                out.back = Back::Formulas(formulas(of, screen)?);
            }
            _ => out.direct_from(law, nodes[0], &here(&of.parameters)),
        }
        if let Some(load) = load {
            out.columns = out.columns.iter().map(|&c| out.graph.mul(load, c)).collect();
        }
        Some(out)
    }

    /// For a law without a `screen` entry: the derivatives by the parameters in which its force is linear are
    /// columns, the other parameters are on the grid.
    fn direct_from(&mut self, law: &Law, force: Id, parameters: &[Id]) {
        let linear = law.linear_parameters();
        let slopes = self.graph.gradient(force, parameters);
        let nonlinear: Vec<usize> = (0..parameters.len()).filter(|k| !linear.contains(k)).collect();
        let of = |k: usize| match linear.iter().position(|&l| l == k) {
            Some(column) => Ok(column),
            None => Err(nonlinear.iter().position(|&l| l == k).unwrap_or(0)),
        };
        self.symbols = nonlinear.iter().map(|&k| parameters[k]).collect();
        self.columns = linear.iter().map(|&k| slopes[k]).collect();
        let number = |&k: &usize| (scale(&law.parameters[k].1.unit), law.parameters[k].1.within.0 < 0.0);
        self.grid = nonlinear.iter().map(number).collect();
        self.back = Back::Direct((0..parameters.len()).map(of).collect());
    }

    /// The law's parameters from coefficients and grid values; `None` if one is not finite.
    pub(super) fn parameters(&self, coefficients: &[f64], grid: &[f64]) -> Option<Vec<f64>> {
        let all: Vec<f64> = match &self.back {
            Back::Direct(of) => of
                .iter()
                .map(|source| match *source {
                    Ok(column) => coefficients[column],
                    Err(g) => grid[g],
                })
                .collect(),
            Back::Formulas(tape) => {
                let mut scratch = Scratch::<1>::new(tape);
                scratch.at(coefficients.iter().chain(grid).copied());
                (0..self.outputs()).map(|k| scratch.output(k)[0]).collect()
            }
        };
        all.iter().all(|v| v.is_finite()).then_some(all)
    }

    /// Coefficients and grid values that give these parameters, where each parameter is one of them.
    pub(super) fn direct(&self, parameters: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        let Back::Direct(of) = &self.back else { return None };
        let (mut coefficients, mut grid) = (vec![0.0; self.columns.len()], vec![0.0; self.grid.len()]);
        for (source, value) in of.iter().zip(parameters) {
            match *source {
                Ok(k) => coefficients[k] = *value,
                Err(g) => grid[g] = *value,
            }
        }
        Some((coefficients, grid))
    }

    fn outputs(&self) -> usize {
        match &self.back {
            Back::Direct(of) => of.len(),
            Back::Formulas(tape) => tape.outputs(),
        }
    }
}

/// The parameters, in the order of the law, as functions of c1, c2, ... and the grid.
fn formulas(of: &LawGraph, screen: &LawScreen) -> Option<Tape> {
    let inputs: Vec<Id> = screen.coefficients.iter().chain(&screen.grid).copied().collect();
    Tape::compile(&of.graph, &inputs, &screen.seeds).ok()
}

fn dimension(unit: &str) -> Dimension {
    Unit::parse(unit).map_or(Dimension::NONE, |u| u.dimension)
}

fn scale(unit: &str) -> Scale {
    let d = dimension(unit);
    if d == Dimension::METRE {
        Scale::Displacement
    } else if d == Dimension::METRE.div(Dimension::SECOND) {
        Scale::Speed
    } else if d == Dimension::NONE.div(Dimension::SECOND) {
        Scale::Frequency
    } else {
        Scale::Any
    }
}

fn negative(law: &Law, name: &str) -> bool {
    law.parameters.iter().any(|(n, p)| n == name && p.within.0 < 0.0)
}
