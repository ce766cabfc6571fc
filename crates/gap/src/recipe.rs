//! How a law at a place is screened: columns that enter linearly, numbers tried on a grid, and the way back to the law's parameters.

use crate::course::constants;
use crate::effect::{Effect, substitute};
use crate::place::Site;
use phisindy_expr::{Graph, Id, Names, Scratch, Tape, parse};
use phisindy_phys::System;
use phisindy_phys::unit::{Dimension, Unit};

/// What a number of the grid is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scale {
    /// A displacement.
    Displacement,
    /// A speed.
    Speed,
    /// An angular frequency.
    Frequency,
    /// Nothing known: powers of ten.
    Any,
}

/// A law at a place, ready to be evaluated on data.
pub(crate) struct Recipe {
    pub(crate) graph: Graph,
    /// Symbols of the grid's numbers, in the order of `grid`.
    pub(crate) symbols: Vec<Id>,
    /// The force that each column subtracts.
    pub(crate) columns: Vec<Id>,
    /// The law's internal state and its rate.
    pub(crate) internal: Option<(Id, Id)>,
    /// Displacement and velocity of the place, as expressions of states and inputs.
    pub(crate) displacement: Option<Id>,
    pub(crate) velocity: Id,
    /// What is tried: each number's scale, and whether it may be negative.
    pub(crate) grid: Vec<(Scale, bool)>,
    back: Back,
}

/// Text to a node of the graph, some names replaced.
type Lower<'a> = dyn FnMut(&str, &[(String, String)], &mut Graph) -> Option<Id> + 'a;

/// From coefficients and grid to parameters.
enum Back {
    /// Each parameter is a coefficient (by index) or a number of the grid.
    Direct(Vec<Result<usize, usize>>),
    /// Expressions of c1, c2, ... and the grid.
    Formulas(Tape),
}

impl Recipe {
    /// The recipe of an effect in a system. `None` if the law's text does not suit (its mistakes are told where it is read).
    pub(crate) fn new(effect: &Effect, system: &System) -> Option<Recipe> {
        let Site::Force { displacement, velocity, .. } = &effect.place.site else { return None };
        let law = &effect.entry.law;
        let (mut graph, mut names) = (system.graph.clone(), system.names.clone());
        let fixed = constants(&mut graph, system);
        let mut lower = |text: &str, with: &[(String, String)], graph: &mut Graph| -> Option<Id> {
            let ast = parse(&substitute(text, with)).ok()?;
            let root = graph.lower(&ast, |name| Some(names.intern(name))).ok()?;
            Some(graph.replace(&[root], &fixed)[0])
        };
        // Names that no spec uses.
        let hidden = |name: &str| format!("screen_{name}_");
        let mut with: Vec<(String, String)> = Vec::new();
        for (name, unit) in &law.roles {
            let is_speed = dimension(unit) == Dimension::METRE.div(Dimension::SECOND);
            let place = if is_speed { Some(velocity.clone()) } else { displacement.clone() };
            with.push((name.clone(), place?));
        }
        with.extend(law.given.iter().map(|(name, (value, _))| (name.clone(), format!("{value:?}"))));
        with.extend(law.parameters.iter().map(|(name, _)| (name.clone(), hidden(name))));
        with.extend(law.internal.iter().map(|(name, _)| (name.clone(), hidden(name))));
        let grid_names = law.screen.iter().flat_map(|s| s.grid.iter().map(|(n, _)| n));
        for name in grid_names {
            if !with.iter().any(|(n, _)| n == name) {
                with.push((name.clone(), hidden(name)));
            }
        }
        let place_velocity = lower(velocity, &[], &mut graph)?;
        let place_displacement = match displacement {
            Some(d) => Some(lower(d, &[], &mut graph)?),
            None => None,
        };
        let load = match &effect.load {
            Some(load) => Some(lower(load, &[], &mut graph)?),
            None => None,
        };
        let symbol = |name: &str, lower: &mut Lower<'_>, graph: &mut Graph| lower(&hidden(name), &[], graph);
        let mut recipe = if let Some(screen) = &law.screen {
            let mut columns = Vec::new();
            for text in &screen.columns {
                columns.push(lower(text, &with, &mut graph)?);
            }
            let mut symbols = Vec::new();
            for (name, _) in &screen.grid {
                symbols.push(symbol(name, &mut lower, &mut graph)?);
            }
            let internal = match (&screen.rate, law.internal.first()) {
                (Some(rate), Some((z, _))) => {
                    Some((symbol(z, &mut lower, &mut graph)?, lower(rate, &with, &mut graph)?))
                }
                _ => None,
            };
            let grid =
                screen.grid.iter().map(|(name, unit)| (scale(unit), self::negative(law, name))).collect();
            let back = Back::Formulas(formulas(law, screen)?);
            Recipe {
                graph,
                symbols,
                columns,
                internal,
                displacement: place_displacement,
                velocity: place_velocity,
                grid,
                back,
            }
        } else {
            if !law.internal.is_empty() {
                return None;
            }
            let force = lower(&law.subtracted(effect.mirror)?, &with, &mut graph)?;
            let mut parameters = Vec::new();
            for (name, _) in &law.parameters {
                parameters.push(symbol(name, &mut lower, &mut graph)?);
            }
            let slopes = graph.gradient(force, &parameters);
            // Jointly linear: no slope of one depends on another of them.
            let mut linear: Vec<usize> = Vec::new();
            for k in 0..parameters.len() {
                let free = linear.iter().chain([&k]).all(|&j| !graph.uses(&[slopes[k]], &[parameters[j]]))
                    && linear.iter().all(|&j| !graph.uses(&[slopes[j]], &[parameters[k]]));
                if free {
                    linear.push(k);
                }
            }
            let tried: Vec<usize> = (0..parameters.len()).filter(|k| !linear.contains(k)).collect();
            let grid =
                tried.iter().map(|&k| (scale(&law.parameters[k].1.unit), law.parameters[k].1.within.0 < 0.0));
            let of = |k: usize| match linear.iter().position(|&l| l == k) {
                Some(column) => Ok(column),
                None => Err(tried.iter().position(|&l| l == k).unwrap_or(0)),
            };
            Recipe {
                symbols: tried.iter().map(|&k| parameters[k]).collect(),
                columns: linear.iter().map(|&k| slopes[k]).collect(),
                internal: None,
                displacement: place_displacement,
                velocity: place_velocity,
                grid: grid.collect(),
                back: Back::Direct((0..parameters.len()).map(of).collect()),
                graph,
            }
        };
        if let Some(load) = load {
            recipe.columns = recipe.columns.iter().map(|&c| recipe.graph.mul(load, c)).collect();
        }
        Some(recipe)
    }

    /// The law's parameters from coefficients and grid; `None` where that is nothing finite.
    pub(crate) fn parameters(&self, coefficients: &[f64], grid: &[f64]) -> Option<Vec<f64>> {
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

    /// Coefficients and grid that give these parameters, where each parameter is one of them.
    pub(crate) fn direct(&self, parameters: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
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
fn formulas(law: &phisindy_phys::Law, screen: &phisindy_phys::Screen) -> Option<Tape> {
    let coefficients = (1..=screen.columns.len()).map(|k| format!("c{k}"));
    let of: Vec<String> = coefficients.chain(screen.grid.iter().map(|(n, _)| n.clone())).collect();
    let seed = |(name, _): &(String, _)| screen.seed.iter().find(|(n, _)| n == name).map(|(_, t)| t.as_str());
    compiled(&of, &law.parameters.iter().map(seed).collect::<Option<Vec<_>>>()?)
}

/// Expressions of named numbers.
fn compiled(of: &[String], texts: &[&str]) -> Option<Tape> {
    let (mut graph, mut names) = (Graph::default(), Names::default());
    let mut inputs = Vec::new();
    for name in of {
        let symbol = names.intern(name);
        inputs.push(graph.symbol(symbol));
    }
    let lowered = texts.iter().map(|text| graph.lower(&parse(text).ok()?, |n| names.get(n)).ok());
    let outputs: Vec<Id> = lowered.collect::<Option<_>>()?;
    Tape::compile(&graph, &inputs, &outputs).ok()
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

fn negative(law: &phisindy_phys::Law, name: &str) -> bool {
    law.parameters.iter().any(|(n, p)| n == name && p.within.0 < 0.0)
}
