//! The columns of a law at a place: its response to the measured motion, for each combination of grid values.

use super::regression_data::RegressionData;
use crate::evaluate::{carried, evaluated};
use crate::memory::internal_states;

use super::grid::{between, geometric, grids};
use super::regressors::{Axis, Regressors};
use crate::decisions::{GRID_AXIS, GRID_GAPS, GRID_VALUES};
use crate::motion::Motion;
use crate::place::{Effect, Place, Site, entered_nodes};
use crate::whiteness::mean_step;
use phisindy_expr::{Id, Tape};
use phisindy_phys::{SensorPart, System};

/// The columns of an effect for one combination of grid values.
pub(super) struct Trial {
    pub(super) effect: Effect,
    pub(super) grid: Vec<f64>,
    /// Responses as rows, for each column.
    pub(super) columns: Vec<Vec<f64>>,
}

/// A property of the sensors of some columns.
pub(super) fn sensor_trials(effect: &Effect, columns: &[usize], data: &[RegressionData]) -> Vec<Trial> {
    let Some(part) = effect.entry.law.sensor.as_deref().and_then(SensorPart::named) else { return vec![] };
    let column = data.iter().flat_map(|g| g.sensor(columns, part)).collect();
    vec![Trial { effect: effect.clone(), grid: vec![], columns: vec![column] }]
}

/// What acts in the place of inputs: what its change does to the rates and to the outputs. A gain and a delay change a
/// little, any other law as its numbers on a grid say. The number of a delay is that of the record, so that a positive
/// one acts early.
pub(super) fn input_trials(
    effect: &Effect,
    inputs: &[usize],
    system: &System,
    data: &[RegressionData],
) -> Vec<Trial> {
    let law = &effect.entry.law;
    if law.acting().is_some() && law.neutral_input().is_none() {
        return acting_trials(effect, inputs[0], system, data).unwrap_or_default();
    }
    let Some(slopes) = InputSlopes::new(inputs, system) else { return vec![] };
    let m = system.inputs.len();
    let late = effect.is_input_delay();
    // A factor changes the input by itself, an offset by one.
    let all = law.neutral_input().is_some_and(|neutral| neutral == 0.0);
    let mut column = Vec::new();
    for data in data {
        let moved = if late { &data.motion.slopes } else { &data.motion.inputs };
        let moved = |i: usize, j: usize| if all { 1.0 } else { moved[i * m + j] };
        column.extend(slopes.response(data, &slopes.along(data), &moved));
    }
    vec![Trial { effect: effect.clone(), grid: vec![], columns: vec![column] }]
}

/// How rates and outputs change with inputs.
struct InputSlopes<'a> {
    inputs: &'a [usize],
    states: usize,
    tape: Tape,
}

impl<'a> InputSlopes<'a> {
    fn new(inputs: &'a [usize], system: &System) -> Option<InputSlopes<'a>> {
        let nodes: Vec<Id> = inputs.iter().map(|&j| system.inputs[j].node).collect();
        let roots = system.known.iter().copied().chain(system.outputs.iter().map(|o| o.node));
        let roots: Vec<Id> = roots.collect();
        let mut graph = system.graph.clone();
        let slopes: Vec<Id> = roots.iter().flat_map(|&root| graph.gradient(root, &nodes)).collect();
        let tape = Tape::compile(&graph, &system.arguments(), &slopes).ok()?;
        Some(InputSlopes { inputs, states: system.states.len(), tape })
    }

    /// The slopes along a record.
    fn along(&self, data: &RegressionData) -> Vec<Vec<f64>> {
        evaluated(&self.tape, &data.motion, &[], &[])
    }

    /// The response of a record with these slopes to a change of its inputs, by sample and input.
    fn response(
        &self,
        data: &RegressionData,
        slopes: &[Vec<f64>],
        moved: &dyn Fn(usize, usize) -> f64,
    ) -> Vec<f64> {
        let (n, motion) = (self.states, &data.motion);
        let change = |root: usize| -> Vec<f64> {
            let of = |i: usize| {
                let part = |(k, &j): (usize, &usize)| slopes[root * self.inputs.len() + k][i] * moved(i, j);
                self.inputs.iter().enumerate().map(part).sum::<f64>()
            };
            (0..motion.samples()).map(of).collect()
        };
        let mut g = vec![0.0; motion.samples() * n];
        for state in 0..n {
            change(state)
                .into_iter()
                .enumerate()
                .for_each(|(i, v)| g[i * n + state] = if v.is_finite() { v } else { 0.0 });
        }
        data.zero_at_rest(&mut g);
        let mut rows = data.response(&g, &vec![0.0; n]);
        let roots = slopes.len() / self.inputs.len();
        let shown: Vec<Vec<f64>> = (n..roots).map(change).collect();
        data.add_to_outputs(&mut rows, &|output| shown.get(output).map(Vec::as_slice));
        rows
    }
}

/// What acts in the place of one input, over a grid of the law's numbers.
fn acting_trials(
    effect: &Effect,
    input: usize,
    system: &System,
    data: &[RegressionData],
) -> Option<Vec<Trial>> {
    let mut system = system.clone();
    let mut symbols = |count: usize, what: &str| -> Vec<Id> {
        // The space in the name avoids collisions with names of a spec.
        let name = |k: usize| format!("{what} {k}");
        (0..count).map(|k| system.names.intern(&name(k))).map(|symbol| system.graph.symbol(symbol)).collect()
    };
    let of = effect.entry.law.nodes();
    let numbers = symbols(of.parameters.len(), "number");
    let internal = symbols(of.internal.len(), "internal");
    let (acts, mut rates) = effect.acting(input, &mut system, &numbers, &internal).ok()?;
    let change = system.graph.sub(acts, system.inputs[input].node);
    let slopes = rates.iter().zip(&internal).map(|(&rate, &z)| system.graph.gradient(rate, &[z])[0]);
    rates.extend(slopes.collect::<Vec<_>>());
    let arguments: Vec<Id> = system.arguments().into_iter().chain(numbers).chain(internal.clone()).collect();
    let tape = Tape::compile(&system.graph, &arguments, &[change]).ok()?;
    let inner = if rates.is_empty() { None } else { Tape::compile(&system.graph, &arguments, &rates).ok() };
    let inputs = [input];
    let slopes = InputSlopes::new(&inputs, &system)?;
    let along: Vec<Vec<Vec<f64>>> = data.iter().map(|data| slopes.along(data)).collect();
    let mut all = Vec::new();
    for grids in acting_grid(effect, input, data)?.chunks(LANES) {
        let memory = |data: &RegressionData| match &inner {
            Some(tape) => driven_by(tape, internal.len(), &data.motion, grids),
            None => vec![vec![]; grids.len()],
        };
        let memory: Vec<Vec<Vec<Vec<f64>>>> = data.iter().map(memory).collect();
        for (lane, grid) in grids.iter().enumerate() {
            let mut column = Vec::new();
            for ((data, slopes_there), memory) in data.iter().zip(&along).zip(&memory) {
                let series: Vec<&[f64]> = memory[lane].iter().map(Vec::as_slice).collect();
                let moved = evaluated(&tape, &data.motion, grid, &series).swap_remove(0);
                column.extend(slopes.response(data, slopes_there, &|i, _| moved[i]));
            }
            all.push(Trial { effect: effect.clone(), grid: grid.clone(), columns: vec![column] });
        }
    }
    Some(all)
}

/// Numbers of what acts in the place of an input: parts of its largest value, times from a step of the record on.
fn acting_grid(effect: &Effect, input: usize, data: &[RegressionData]) -> Option<Vec<Vec<f64>>> {
    let sizes = data.iter().flat_map(|data| {
        let m = data.motion.inputs.len() / data.motion.samples();
        data.motion.inputs.iter().skip(input).step_by(m).map(|u| u.abs())
    });
    let largest = sizes.fold(0.0, f64::max);
    let time = &data.first()?.motion.time;
    let (step, span) = (mean_step(time), time.last()? - time.first()?);
    let mut all: Vec<Vec<f64>> = vec![vec![]];
    for (_, parameter) in &effect.entry.law.parameters {
        let values: Vec<f64> = match parameter.unit.as_str() {
            "N" => GRID_GAPS.iter().map(|part| part * largest).collect(),
            "s" => geometric(step, 0.1 * span, GRID_AXIS),
            _ => between(parameter.within, GRID_AXIS),
        };
        all = all.iter().flat_map(|g| values.iter().map(|v| [g.as_slice(), &[*v]].concat())).collect();
        all.truncate(GRID_VALUES);
    }
    Some(all)
}

/// A force law at a place, to be tried on the motion of some records.
pub(super) struct ForceTrials<'a> {
    effect: &'a Effect,
    pub(super) regressors: Regressors,
    system: &'a System,
    data: &'a [RegressionData],
    program: Program,
}

impl<'a> ForceTrials<'a> {
    /// `None` where the law does not compile there.
    pub(super) fn new(
        effect: &'a Effect,
        system: &'a System,
        data: &'a [RegressionData],
    ) -> Option<ForceTrials<'a>> {
        let regressors = Regressors::new(effect, system)?;
        let program = Program::new(effect, &regressors, system)?;
        Some(ForceTrials { effect, regressors, system, data, program })
    }

    /// The law over its grid.
    pub(super) fn on_grid(&self) -> Vec<Trial> {
        let ForceTrials { effect, regressors, system, data, program } = self;
        self.at(&grids(regressors, effect, system, data, &program.tape))
    }

    /// The law at these combinations of grid values.
    fn at(&self, grids: &[Vec<f64>]) -> Vec<Trial> {
        let ForceTrials { effect, system, data, program, .. } = self;
        let mut all = Vec::new();
        for grids in grids.chunks(LANES) {
            let mut memory = program.memory(data, grids);
            for (lane, grid) in grids.iter().enumerate() {
                let memory: Vec<Vec<Vec<f64>>> =
                    memory.iter_mut().map(|of| std::mem::take(&mut of[lane])).collect();
                let columns = program.columns(effect, system, data, grid, &memory);
                let small = |columns: &Vec<Vec<f64>>| columns.iter().flatten().all(|x| x.abs() < LARGEST);
                if let Some(columns) = columns.filter(small) {
                    all.push(Trial { effect: (*effect).clone(), grid: grid.clone(), columns });
                }
            }
        }
        all
    }

    /// The law near a combination of grid values: each value in turn is moved down and up by a part of the
    /// distance to its neighbours.
    pub(super) fn around(&self, grid: &[f64], part: f64) -> Vec<Trial> {
        let moved = |(k, axis): (usize, &Axis)| {
            let of = |value: f64| {
                let mut grid = grid.to_vec();
                grid[k] = value;
                grid
            };
            axis.beside(grid[k], part).map(of)
        };
        let free = self.regressors.grid.iter().enumerate().filter(|(_, axis)| axis.is_free());
        let all: Vec<Vec<f64>> = free.flat_map(moved).collect();
        self.at(&all)
    }
}

/// A column with a larger number is that of an internal state that grew without bound. Its square is finite.
const LARGEST: f64 = 1e100;

/// Combinations of grid values whose internal states run side by side: a law with memory is followed step by
/// step, and one instruction serves them all.
const LANES: usize = 16;

/// The rates that a law adds to its bodies, compiled.
struct Program {
    /// The rate that each regressor adds to each body, the rate for unit friction, then velocity and
    /// displacement.
    tape: Tape,
    /// The states whose rates the force changes, each with what it is of the speed of the place.
    acts: Vec<(usize, f64)>,
    /// Rates of the internal states, then the derivative of each by its own state.
    inner: Option<Tape>,
    /// Number of internal states.
    states: usize,
    /// Number of regressors.
    count: usize,
}

impl Program {
    fn new(effect: &Effect, regressors: &Regressors, system: &System) -> Option<Program> {
        let Site::Force { shows, .. } = &effect.place.site else { return None };
        let mut graph = regressors.graph.clone();
        let one = graph.constant(1.0);
        let mut outputs = Vec::new();
        let entered = entered_nodes(system, &mut graph, &effect.place.site);
        for &column in regressors.columns.iter().chain([&one]) {
            outputs.extend(entered.iter().map(|e| graph.mul(column, e.rate)));
            for &(_, sign) in shows {
                outputs.push(if sign < 0.0 { graph.neg(column) } else { column });
            }
        }
        outputs.push(regressors.velocity);
        outputs.push(regressors.displacement.unwrap_or(regressors.velocity));
        let mut all = system.arguments();
        all.extend(&regressors.symbols);
        let internal = &regressors.internal;
        all.extend(internal.iter().map(|(z, _)| *z));
        let slopes: Vec<Id> = internal.iter().map(|&(z, rate)| graph.gradient(rate, &[z])[0]).collect();
        let rates: Vec<Id> = internal.iter().map(|(_, rate)| *rate).chain(slopes).collect();
        let tape = Tape::compile(&graph, &all, &outputs).ok()?;
        let inner = if rates.is_empty() { None } else { Some(Tape::compile(&graph, &all, &rates).ok()?) };
        let acts = entered.iter().map(|e| (e.state, e.part)).collect();
        Some(Program { tape, acts, inner, states: internal.len(), count: regressors.columns.len() })
    }

    /// Internal states along the motion of each record, for up to [`LANES`] combinations of grid values:
    /// samples by record, combination and state.
    fn memory(&self, data: &[RegressionData], grids: &[Vec<f64>]) -> Vec<Vec<Vec<Vec<f64>>>> {
        let of = |data: &RegressionData| match &self.inner {
            Some(tape) => driven_by(tape, self.states, &data.motion, grids),
            None => vec![vec![]; grids.len()],
        };
        data.iter().map(of).collect()
    }

    /// The columns for one combination of grid values: the response to each regressor, and to the holding
    /// force at rest. `memory` holds the internal states along each record. `None` where a force is a number at no
    /// sample; where it is none now and then, it counts as zero.
    fn columns(
        &self,
        effect: &Effect,
        system: &System,
        data: &[RegressionData],
        grid: &[f64],
        memory: &[Vec<Vec<f64>>],
    ) -> Option<Vec<Vec<f64>>> {
        let Site::Force { shows, .. } = &effect.place.site else { return None };
        let acts = &self.acts;
        let (n, width) = (system.states.len(), acts.len() + shows.len());
        let sticks = effect.entry.law.sticks();
        let mut columns: Vec<Vec<f64>> = vec![vec![]; self.count];
        let mut holding: Vec<f64> = vec![];
        let mut rested = false;
        for (data, memory) in data.iter().zip(memory) {
            let samples = data.motion.samples();
            let series: Vec<&[f64]> = memory.iter().map(Vec::as_slice).collect();
            let values = evaluated(&self.tape, &data.motion, grid, &series);
            let still = data.still.iter().find(|s| s.at == effect.place.at);
            let rests = |i: usize| sticks && still.is_some_and(|s| s.rests[i]);
            for (c, column) in columns.iter_mut().enumerate() {
                if (0..width).any(|j| values[c * width + j].iter().all(|f| !f.is_finite())) {
                    return None;
                }
                let mut g = vec![0.0; samples * n];
                for (j, &(state, _)) in acts.iter().enumerate() {
                    let force = &values[c * width + j];
                    (0..samples)
                        .filter(|&i| !rests(i))
                        .for_each(|i| g[i * n + state] = if force[i].is_finite() { force[i] } else { 0.0 });
                }
                data.zero_at_rest(&mut g);
                let mut rows = data.response(&g, &vec![0.0; n]);
                let shown = |output: usize| {
                    let j = shows.iter().position(|(o, _)| *o == output)?;
                    Some(values[c * width + acts.len() + j].as_slice())
                };
                data.add_to_outputs(&mut rows, &shown);
                column.extend(rows);
            }
            if sticks {
                let at_rest: Vec<usize> = (0..samples).filter(|&i| rests(i)).collect();
                rested |= !at_rest.is_empty();
                let unit = &values[self.count * width..];
                let g = holding_rates(&at_rest, unit, acts, system, &effect.place, data);
                holding.extend(data.response(&g, &vec![0.0; n]));
            }
        }
        if rested {
            columns.push(holding);
        }
        Some(columns)
    }
}

/// The rates that hold a body at these samples: at rest, friction balances the other forces. `unit` is the
/// rate that unit friction gives each body.
pub(super) fn holding_rates(
    at_rest: &[usize],
    unit: &[Vec<f64>],
    acts: &[(usize, f64)],
    system: &System,
    place: &Place,
    data: &RegressionData,
) -> Vec<f64> {
    let n = system.states.len();
    let mut g = vec![0.0; data.motion.samples() * n];
    let carried = carried(system, &data.motion, place).filter(|_| !at_rest.is_empty());
    for &i in at_rest {
        let (mut toward, mut give) = (0.0, 0.0);
        for (j, &(state, part)) in acts.iter().enumerate() {
            toward += part * data.rates[i * n + state];
            give += part * unit[j][i];
        }
        toward -= carried.as_ref().map_or(0.0, |acceleration| acceleration[i]);
        for (j, &(state, _)) in acts.iter().enumerate() {
            g[i * n + state] = -toward / give * unit[j][i];
        }
    }
    g
}

/// Internal states along a motion, for up to [`LANES`] combinations of grid values: by combination and state.
fn driven_by(tape: &Tape, count: usize, motion: &Motion, grids: &[Vec<f64>]) -> Vec<Vec<Vec<f64>>> {
    let samples = motion.samples();
    let (n, m) = (motion.states.len() / samples, motion.inputs.len() / samples);
    let after = 1 + n + m;
    let (numbers, width) = (motion.numbers.len(), grids.first().map_or(0, Vec::len));
    // The last lanes may have nothing of their own to do.
    let of = |lane: usize, k: usize| grids[lane.min(grids.len() - 1)][k];
    internal_states::<LANES>(tape, (after + numbers + width, count), &motion.time, &mut |i, scratch| {
        *scratch.input(0) = [motion.time[i]; LANES];
        // At the midpoint of the step.
        let middle = |v: &[f64], w: usize, k: usize| [0.5 * (v[i * w + k] + v[(i + 1) * w + k]); LANES];
        (0..n).for_each(|k| *scratch.input(1 + k) = middle(&motion.states, n, k));
        (0..m).for_each(|k| *scratch.input(1 + n + k) = middle(&motion.inputs, m, k));
        // Inputs keep their values.
        if i == 0 {
            (0..numbers).for_each(|k| *scratch.input(after + k) = [motion.numbers[k]; LANES]);
            for k in 0..width {
                *scratch.input(after + numbers + k) = std::array::from_fn(|lane| of(lane, k));
            }
        }
    })
}
