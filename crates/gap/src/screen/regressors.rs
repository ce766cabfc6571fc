//! The regressors of a law at a place: columns with free coefficients, grid parameters, and the map from both
//! to the law's parameters.

use crate::place::{Effect, Site, bindings};
use phisindy_expr::{Graph, Id, Scratch, Tape};
use phisindy_phys::unit::{Dimension, Unit};
use phisindy_phys::{Law, LawGraph, LawScreen, System, jointly_linear};
use std::collections::HashMap;

/// The quantity that scales a grid parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scale {
    /// A displacement.
    Displacement,
    /// A speed.
    Speed,
    /// An angular frequency.
    Frequency,
    /// A number of radians per length.
    WaveNumber,
    /// A number without a unit: its bounds say where it may be.
    Number,
    /// Powers of a length and a time, in a law with memory.
    Power {
        /// The power of the length.
        length: f64,
        /// The power of the time.
        time: f64,
    },
    /// No scale: powers of ten are nonlinear.
    Any,
}

/// A grid parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    /// What scales it.
    pub(super) scale: Scale,
    /// Its bounds.
    pub(super) within: (f64, f64),
}

impl Axis {
    /// Whether there is a choice.
    pub(super) fn is_free(&self) -> bool {
        self.within.0 < self.within.1
    }

    /// The values below and above one, apart by a part of the step of a coarse grid: a factor of four, or an
    /// eighth of the range of a number that may be zero.
    pub(super) fn beside(&self, value: f64, part: f64) -> [f64; 2] {
        let (low, high) = self.within;
        let factor = 4f64.powf(part);
        let [below, above] = match self.is_range() {
            true => [-1.0, 1.0].map(|sign| value + sign * part * (high - low) / 8.0),
            false => [value / factor, value * factor],
        };
        [below.clamp(low, high), above.clamp(low, high)]
    }

    /// Whether two values lie within such a step.
    pub(super) fn adjoin(&self, a: f64, b: f64) -> bool {
        let (low, high) = self.within;
        match self.is_range() {
            true => (a - b).abs() <= (high - low) / 8.0,
            false => a == b || (a / b).ln().abs() <= 4f64.ln(),
        }
    }

    fn is_range(&self) -> bool {
        self.scale == Scale::Number && self.within.0 <= 0.0
    }
}

/// A law at a place, ready to be evaluated on data.
pub(super) struct Regressors {
    pub(super) graph: Graph,
    /// Symbols of the grid parameters, in the order of `grid`.
    pub(super) symbols: Vec<Id>,
    /// The force that each regressor subtracts.
    pub(super) columns: Vec<Id>,
    /// The law's internal states and their rates.
    pub(super) internal: Vec<(Id, Id)>,
    /// Displacement and velocity of the place.
    pub(super) displacement: Option<Id>,
    pub(super) velocity: Id,
    /// The grid parameters.
    pub(super) grid: Vec<Axis>,
    back: Back,
    /// Columns whose coefficient is a parameter that is zero or more.
    positive: Vec<usize>,
}

/// The map from coefficients and grid values to parameters.
enum Back {
    /// Each parameter is a coefficient (`Ok`, its index) or a grid value (`Err`).
    Direct(Vec<Result<usize, usize>>),
    /// Expressions of c1, c2, ... and the grid values.
    Formulas(Tape),
    /// Of a law with memory: each parameter is a coefficient or a grid value, which the coefficient of the
    /// whole force scales with a power of its own.
    Scaled(Vec<Scaled>),
}

/// Where a parameter of a law with memory comes from.
#[derive(Clone, Copy, Debug)]
enum Scaled {
    /// The coefficient with this index.
    Coefficient(usize),
    /// The grid value `at`, times coefficient 0 to a power.
    Grid { at: usize, power: f64 },
}

impl Regressors {
    /// The regressors of an effect in a system. `None` for an effect on sensors and for a law that uses names
    /// which the system does not have.
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
            None => {
                let force = if effect.mirror { of.mirror? } else { of.force? };
                [force].into_iter().chain(of.rates.iter().copied()).collect()
            }
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
            internal: vec![],
            displacement: displacement.as_ref().map(|d| d.node),
            velocity: velocity.node,
            grid: vec![],
            back: Back::Direct(vec![]),
            positive: vec![],
            graph: system.graph,
        };
        match (&of.screen, &law.screen) {
            (Some(screen), Some(text)) => {
                let rate = screen.rate.and_then(|_| nodes.pop());
                out.internal = here(&of.internal).into_iter().zip(rate).collect();
                nodes.truncate(screen.columns.len());
                out.columns = nodes;
                out.symbols = here(&screen.grid);
                let axis =
                    |(name, unit): &(String, String)| Axis { scale: scale(unit), within: bounds(law, name) };
                out.grid = text.grid.iter().map(axis).collect();
                out.back = Back::Formulas(formulas(of, screen)?);
            }
            _ if law.has_memory() => {
                out.internal = here(&of.internal).into_iter().zip(nodes[1..].iter().copied()).collect();
                out.with_memory(law, nodes[0], &here(&of.parameters));
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
        let axis = |&k: &usize| {
            let p = &law.parameters[k].1;
            Axis { scale: scale(&p.unit), within: p.within }
        };
        self.grid = nonlinear.iter().map(axis).collect();
        self.positive = (0..linear.len()).filter(|&j| law.parameters[linear[j]].1.within.0 == 0.0).collect();
        self.back = Back::Direct((0..parameters.len()).map(of).collect());
    }

    /// For a law with memory and no `screen` entry. Parameters that scale a part of the force and enter no
    /// rate are coefficients. The others are on the grid. What is left of the force has one coefficient, its
    /// scale: a law of mechanics keeps its form when all its forces grow by one factor (Buckingham 1914, doi
    /// 10.1103/PhysRev.4.345), so the first parameter that holds a force is 1 on the grid, in units of the
    /// motion, and the others are relative to it.
    fn with_memory(&mut self, law: &Law, force: Id, parameters: &[Id]) {
        let rates: Vec<Id> = self.internal.iter().map(|(_, rate)| *rate).collect();
        let outside: Vec<usize> =
            (0..parameters.len()).filter(|&k| !self.graph.uses(&rates, &[parameters[k]])).collect();
        let symbols: Vec<Id> = outside.iter().map(|&k| parameters[k]).collect();
        let linear: Vec<usize> =
            jointly_linear(&mut self.graph, force, &symbols).into_iter().map(|j| outside[j]).collect();
        let symbols: Vec<Id> = linear.iter().map(|&k| parameters[k]).collect();
        let zero = self.graph.constant(0.0);
        let none: HashMap<Id, Id> = symbols.iter().map(|&s| (s, zero)).collect();
        let rest = self.graph.replace(&[force], &none)[0];
        let states: Vec<Id> = self.internal.iter().map(|(z, _)| *z).chain([self.velocity]).collect();
        let scaled = self.graph.uses(&[rest], &states);
        let mut columns = self.graph.gradient(force, &symbols);
        if scaled {
            columns.insert(0, rest);
        }
        let own = |k: usize| powers(&law.parameters[k].1.unit);
        let on_grid: Vec<usize> = (0..parameters.len()).filter(|k| !linear.contains(k)).collect();
        let gauge = on_grid.iter().copied().filter(|_| scaled).find(|&k| own(k).0 != 0.0);
        let mut back = Vec::new();
        for (k, &symbol) in parameters.iter().enumerate() {
            if let Some(j) = linear.iter().position(|&l| l == k) {
                let column = j + usize::from(scaled);
                back.push(Scaled::Coefficient(column));
                self.positive.extend((law.parameters[k].1.within.0 == 0.0).then_some(column));
                continue;
            }
            let (force, mut length, mut time) = own(k);
            let of_gauge = gauge.map_or((1.0, 0.0, 0.0), own);
            let power = if gauge.is_some() { force / of_gauge.0 } else { 0.0 };
            (length, time) = (length - power * of_gauge.1, time - power * of_gauge.2);
            back.push(Scaled::Grid { at: self.grid.len(), power });
            self.symbols.push(symbol);
            let within = law.parameters[k].1.within;
            let scale = match (Some(k) == gauge, length == 0.0 && time == 0.0 && power == 0.0) {
                // The unit of force is free: its value on the grid is 1.
                (true, _) => {
                    self.grid.push(Axis { scale: Scale::Number, within: (1.0, 1.0) });
                    continue;
                }
                (_, true) => Scale::Number,
                (..) => Scale::Power { length, time },
            };
            self.grid.push(Axis { scale, within });
        }
        self.columns = columns;
        self.back = Back::Scaled(back);
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
            Back::Scaled(of) => of
                .iter()
                .map(|source| match *source {
                    Scaled::Coefficient(k) => coefficients[k],
                    Scaled::Grid { at, power: 0.0 } => grid[at],
                    Scaled::Grid { at, power } => grid[at] * coefficients[0].powf(power),
                })
                .collect(),
            Back::Formulas(tape) => {
                let mut scratch = Scratch::<1>::new(tape);
                // A law that sticks has one coefficient more: that of its force at rest.
                scratch.at(coefficients[..self.columns.len()].iter().chain(grid).copied());
                (0..self.outputs()).map(|k| scratch.output(k)[0]).collect()
            }
        };
        all.iter().all(|v| v.is_finite()).then_some(all)
    }

    /// The place among these coefficients, of columns `at` (counted from 1), of the most negative one that is
    /// a parameter of zero or more.
    pub(super) fn wrong_sign(&self, at: &[usize], coefficients: &[f64]) -> Option<usize> {
        let wrong = |&k: &usize| self.positive.contains(&(at[k] - 1)) && coefficients[k] < 0.0;
        (0..at.len()).filter(wrong).min_by(|&a, &b| coefficients[a].total_cmp(&coefficients[b]))
    }

    /// Whether these columns (counted from 1) are those of a simpler law, which is tried by itself: one part
    /// alone of a law without memory.
    pub(super) fn is_simpler(&self, at: &[usize]) -> bool {
        let parts = at.iter().filter(|k| **k <= self.columns.len()).count();
        parts < if self.internal.is_empty() { 2 } else { 1 }
    }

    fn outputs(&self) -> usize {
        match &self.back {
            Back::Direct(of) => of.len(),
            Back::Scaled(of) => of.len(),
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
    } else if d == Dimension::NONE.div(Dimension::METRE) {
        Scale::WaveNumber
    } else if d == Dimension::NONE {
        Scale::Number
    } else {
        Scale::Any
    }
}

/// The powers of force, length and time in a unit.
fn powers(unit: &str) -> (f64, f64, f64) {
    let [kg, m, s, ..] = dimension(unit).powers();
    (kg, m - kg, s + 2.0 * kg)
}

/// The bounds of the parameter with this name; unbounded if it is none.
fn bounds(law: &Law, name: &str) -> (f64, f64) {
    let own = law.parameters.iter().find(|(n, _)| n == name);
    own.map_or((0.0, f64::INFINITY), |(_, p)| p.within)
}
