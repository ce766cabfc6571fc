//! Measured accelerations compared with those that the known part gives for the measured motion, before any
//! fit. A unit that is off by a power of 1000 or two exchanged columns exceed any missing effect by far.
//!
//! Nothing is differentiated twice. With a test function `f` that vanishes with its slope at both ends of a
//! stretch, integration by parts reverses the integral of `f v'` into that of `-f' v` and of `f'' x`. Both
//! sides are such integrals over half a period each (weak form).

use super::words::Suspicion;
use crate::system::equations::System;
use crate::system::record::Record;
use crate::system::sensor::Sensor;
use phisindy_expr::{Binary, Graph, Id, Node, Scratch, Tape, Unary};
use phisindy_signal::{Differentiator, Interpolation, Signal, strongest_line};
use std::f64::consts::{PI, TAU};
use std::ops::{Range, RangeInclusive};

/// When a correction is accepted, in three rows: the misfit before it is at least the first number, the
/// misfit after it at most the second, and the ratio at least the third. Misfits are parts of the
/// acceleration. A model with a huge misfit before may lack friction besides, so that more may remain.
const CORRECTIONS: [(f64, f64, f64); 3] = [(0.25, 0.35, 5.0), (0.7, 0.35, 3.0), (10.0, 0.6, 30.0)];
/// A corrected sign leaves at most this part of the acceleration in each half of a record.
const HALF_MISFIT: f64 = 0.5;
/// The factors of wrong units and signs.
const WRONG_FACTORS: [f64; 7] = [1e3, 1e-3, 1e6, 1e-6, 1e9, 1e-9, -1.0];
/// At most this many samples and parts of a sum are used.
const MAX_SAMPLES: usize = 50_000;
const MAX_PARTS: usize = 100;
/// Least samples of a stretch, and least stretches of a comparison.
const MIN_STRETCH: usize = 12;
const MIN_STRETCHES: usize = 8;

/// Finds two columns of one unit that should be exchanged, or a column or a part of a rate that is off by a
/// power of 1000 or by its sign.
pub(super) fn balance(system: &System, record: &Record, found: &mut Vec<Suspicion>) {
    let rates: Vec<Rate> = system.states.iter().filter_map(|s| Rate::of(system, s.velocity?)).collect();
    // The model is compared where the motion is: an angle may be counted from anywhere.
    let Some(record) = &nearest(system, record, &rates) else { return };
    let now: Vec<Sums> = rates.iter().filter_map(|rate| Sums::new(system, record, rate)).collect();
    let left = worst(&now);
    if !left.is_finite() || left < CORRECTIONS[0].0 {
        return;
    }
    let columns = system.states.len() + system.inputs.len();
    let exchanges = (0..columns).flat_map(|i| (i + 1..columns).map(move |j| Change::Exchange(i, j)));
    let scales = (0..columns).flat_map(|k| WRONG_FACTORS.into_iter().map(move |f| Change::Scale(k, f)));
    // The sign of an input is tested as the sign of a part. A drive scaled down to nothing is plausible only
    // if the misfit is huge.
    let plausible = |c: &Change| match *c {
        Change::Scale(k, f) if k < system.states.len() => f <= 1.0 || left > CORRECTIONS[2].0,
        Change::Scale(_, f) => f >= 1.0 || (f > 0.0 && left > CORRECTIONS[2].0),
        Change::Exchange(..) => true,
    };
    let changes = exchanges.chain(scales.filter(plausible));
    let then = |change: Change| {
        let other = change.applied(system, record)?;
        let sums: Vec<Sums> = rates.iter().filter_map(|rate| Sums::new(system, &other, rate)).collect();
        let steady = !change.reverses() || sums.iter().all(|s| s.holds_in_halves(&|_| 1.0));
        (sums.len() == now.len() && steady).then(|| (worst(&sums), change))
    };
    let best = changes.filter_map(then).min_by(|a, b| a.0.total_cmp(&b.0));
    let best = best.filter(|(after, _)| is_correction(left, *after));
    let off: Vec<(f64, Suspicion)> = now.iter().filter_map(|sums| sums.off(system)).collect();
    // In a linear model a drive that is too large equals a motion that is too small: prefer the part, which
    // is more specific.
    let parts = off.iter().map(|(after, _)| *after).fold(f64::NEG_INFINITY, f64::max);
    match best {
        Some((after, change))
            if off.is_empty() || matches!(change, Change::Exchange(..)) || after < 0.8 * parts =>
        {
            found.push(change.told(system));
        }
        _ => found.extend(off.into_iter().map(|(_, told)| told)),
    }
}

/// The motion that the sensors tell: with their zeros where the search of the fit starts, or in the middle of
/// the motion as far as the bounds of the zeros admit, whichever the model fits better. None if a column is
/// no signal.
fn nearest(system: &System, record: &Record, rates: &[Rate]) -> Option<Record> {
    let starts = corrected(record, |sensor, _| sensor.offset.start)?;
    let middle = corrected(record, |sensor, column| {
        let mean = column.iter().sum::<f64>() / column.len().max(1) as f64;
        sensor.offset.within.map_or(sensor.offset.start, |(low, high)| mean.clamp(low, high))
    })?;
    let misfit = |record: &Record| {
        let sums: Vec<Sums> = rates.iter().filter_map(|rate| Sums::new(system, record, rate)).collect();
        worst(&sums)
    };
    Some(if misfit(&middle) < misfit(&starts) { middle } else { starts })
}

/// The record with its states as their sensors see them, each with the given zero. Inputs were corrected when
/// the record was made.
fn corrected(record: &Record, zero: impl Fn(&Sensor, &[f64]) -> f64) -> Option<Record> {
    let mut out = record.clone();
    for (column, sensor) in out.columns.iter_mut().zip(&record.sensors) {
        let Some(values) = column.take() else { continue };
        let mut sensor = sensor.clone();
        sensor.offset.start = zero(&sensor, &values);
        *column = Some(sensor.corrected(&record.time, values, Interpolation::Linear).ok()?);
    }
    Some(out)
}

/// A possible mistake in the columns of a record; states count first, then inputs.
#[derive(Clone, Copy)]
enum Change {
    Exchange(usize, usize),
    Scale(usize, f64),
}

impl Change {
    fn reverses(&self) -> bool {
        matches!(self, Change::Scale(_, f) if *f < 0.0)
    }

    /// The corrected record; none if the columns differ in unit or are not measured.
    fn applied(self, system: &System, record: &Record) -> Option<Record> {
        match self {
            Change::Exchange(i, j) => {
                let same = system.measured(i).1 == system.measured(j).1;
                let (a, b) = (measured(system, record, i)?, measured(system, record, j)?);
                if same { replaced(system, record, vec![(i, b), (j, a)]) } else { None }
            }
            Change::Scale(k, factor) => {
                let column = measured(system, record, k)?.iter().map(|v| factor * v).collect();
                replaced(system, record, vec![(k, column)])
            }
        }
    }

    fn told(self, system: &System) -> Suspicion {
        let name = |k: usize| system.measured(k).0.to_owned();
        match self {
            Change::Exchange(i, j) => Suspicion::SwappedByModel { first: name(i), second: name(j) },
            Change::Scale(k, factor) => Suspicion::ColumnScaled { column: name(k), factor },
        }
    }
}

/// Whether a correction lowers the misfit enough to be accepted, by [`CORRECTIONS`].
fn is_correction(now: f64, after: f64) -> bool {
    CORRECTIONS.iter().any(|(least, most, fall)| now > *least && after < *most && fall * after < now)
}

/// The largest misfit; minus infinity if there is nothing to compare.
fn worst(all: &[Sums]) -> f64 {
    all.iter().map(|s| s.misfit(&|_| 1.0)).fold(f64::NEG_INFINITY, f64::max)
}

/// The known rate of a velocity as a sum.
struct Rate {
    velocity: usize,
    graph: Graph,
    parts: Vec<Id>,
}

impl Rate {
    /// None if it depends on a parameter that is to be found, or if it has no parts.
    fn of(system: &System, velocity: usize) -> Option<Rate> {
        let mut graph = system.graph.clone();
        let known = system.known[velocity];
        let open = system.parameters.iter().any(|p| !p.known && graph.uses(&[known], &[p.node]));
        let parts = parts(&mut graph, known);
        (!open && !parts.is_empty() && parts.len() <= MAX_PARTS).then_some(Rate { velocity, graph, parts })
    }
}

/// The parts of a sum, with common factors and divisors distributed over them; `k*(x - u)` stays one part.
fn parts(graph: &mut Graph, root: Id) -> Vec<Id> {
    let one = graph.constant(1.0);
    let (mut stack, mut all) = (vec![(root, one)], Vec::new());
    while let Some((id, factor)) = stack.pop() {
        let name = |id: Id| matches!(graph.node(id), Node::Symbol(_));
        let sum = |id: Id| {
            matches!(graph.node(id), Node::Binary(Binary::Add | Binary::Sub, ..) | Node::Unary(Unary::Neg, _))
        };
        match graph.node(id) {
            Node::Binary(op @ (Binary::Add | Binary::Sub), a, b)
                if factor == one || !(name(a) && name(b)) =>
            {
                let other = if op == Binary::Sub { graph.neg(factor) } else { factor };
                stack.extend([(b, other), (a, factor)]);
            }
            Node::Unary(Unary::Neg, a) => {
                let factor = graph.neg(factor);
                stack.push((a, factor));
            }
            Node::Binary(Binary::Div, a, b) => {
                let factor = graph.div(factor, b);
                stack.push((a, factor));
            }
            Node::Binary(Binary::Mul, a, b) if sum(a) || sum(b) => {
                let (open, other) = if sum(a) { (a, b) } else { (b, a) };
                let factor = graph.mul(factor, other);
                stack.push((open, factor));
            }
            _ => all.push(graph.mul(factor, id)),
        }
    }
    all.retain(|&part| graph.value(part).is_none());
    all
}

/// Integrals over stretches of the measured acceleration and of each part of the known one. Their means are
/// removed, since a zero offset of a sensor or a weight would dominate them.
struct Sums<'r> {
    rate: &'r Rate,
    measured: Vec<f64>,
    parts: Vec<Vec<f64>>,
}

impl<'r> Sums<'r> {
    fn new(system: &System, record: &Record, rate: &'r Rate) -> Option<Sums<'r>> {
        let v = rate.velocity;
        let x = system.states.iter().position(|s| s.velocity == Some(v))?;
        let n = record.len().min(MAX_SAMPLES);
        let time = &record.time[..n];
        let (displacement, velocity) = (record.columns[x].as_ref(), record.columns[v].as_ref());
        let column = velocity.or(displacement)?;
        let step = (time[n - 1] - time[0]) / (n - 1) as f64;
        let half = strongest_line(time, &column[..n]).map_or(n / 40, |l| (0.5 / l.frequency / step) as usize);
        let stretch = half.clamp(MIN_STRETCH, (n / MIN_STRETCHES).max(MIN_STRETCH));
        let states = motion(system, record, n, stretch);
        let needed = |k: &usize| rate.graph.uses(&rate.parts, &[system.states[*k].node]);
        if (0..states.len()).filter(needed).any(|k| states[k].is_none()) {
            return None;
        }
        let tape = Tape::compile(&rate.graph, &system.arguments(), &rate.parts).ok()?;
        let mut scratch = Scratch::<1>::new(&tape);
        let numbers: Vec<f64> = system.parameters.iter().map(|p| p.start).collect();
        let mut values = vec![Vec::with_capacity(n); rate.parts.len()];
        for i in 0..n {
            let at = states.iter().map(|s| s.as_ref().map_or(0.0, |s| s[i]));
            scratch.at(record.arguments_at(i, at, &numbers));
            values.iter_mut().enumerate().for_each(|(k, column)| column.push(scratch.output(k)[0]));
        }
        let starts = (0..n.saturating_sub(stretch)).step_by((stretch / 2).max(1));
        let stretches = || starts.clone().map(|from| from..=from + stretch);
        // The mean of a column gives no acceleration, however coarse the grid.
        let rate_of = |column: &[f64], kernel: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
            let centred = |at: RangeInclusive<usize>| {
                integral(&time[at.clone()], &without_mean(column[at].to_vec()), kernel)
            };
            without_mean(stretches().map(centred).collect())
        };
        let measured = match velocity {
            Some(v) => rate_of(v, &|s, length| -PI / length * (TAU * s).sin()),
            None => rate_of(column, &|s, length| 2.0 * (PI / length).powi(2) * (TAU * s).cos()),
        };
        let weight = |s: f64, _: f64| 0.5 * (1.0 - (TAU * s).cos());
        let over = |c: &Vec<f64>| {
            without_mean(stretches().map(|at| integral(&time[at.clone()], &c[at], &weight)).collect())
        };
        let parts: Vec<Vec<f64>> = values.iter().map(over).collect();
        let finite = parts.iter().chain([&measured]).flatten().all(|v| v.is_finite());
        (finite && measured.len() >= MIN_STRETCHES).then_some(Sums { rate, measured, parts })
    }

    /// The misfit of the acceleration, relative to the measured one, with each part multiplied by a factor.
    fn misfit(&self, factor: &dyn Fn(usize) -> f64) -> f64 {
        self.misfit_in(0..self.measured.len(), factor)
    }

    /// The same over some of the stretches.
    fn misfit_in(&self, stretches: Range<usize>, factor: &dyn Fn(usize) -> f64) -> f64 {
        let (mut left, mut whole) = (0.0, 0.0);
        for i in stretches {
            let model: f64 = self.parts.iter().enumerate().map(|(k, part)| factor(k) * part[i]).sum();
            left += (self.measured[i] - model).powi(2);
            whole += self.measured[i] * self.measured[i];
        }
        if whole > 0.0 { (left / whole).sqrt() } else { f64::NAN }
    }

    /// Whether the misfit is small in both halves of the record. A drive at a slightly wrong frequency has
    /// the wrong sign for a while.
    fn holds_in_halves(&self, factor: &dyn Fn(usize) -> f64) -> bool {
        let half = self.measured.len() / 2;
        [0..half, half..self.measured.len()].into_iter().all(|of| self.misfit_in(of, factor) < HALF_MISFIT)
    }

    /// A part, or all drives together, that is off by a power of 1000 or by its sign: the misfit after the
    /// correction, and the finding.
    fn off(&self, system: &System) -> Option<(f64, Suspicion)> {
        let Rate { velocity, graph, parts } = self.rate;
        let now = self.misfit(&|_| 1.0);
        let states: Vec<Id> = system.states.iter().map(|s| s.node).collect();
        let drives: Vec<usize> = (0..parts.len()).filter(|&k| !graph.uses(&[parts[k]], &states)).collect();
        let alone = (0..parts.len()).map(|k| vec![k]);
        // A wrong inertia scales all parts.
        let together = [drives, (0..parts.len()).collect()].into_iter().filter(|group| group.len() > 1);
        let groups = alone.chain(together);
        // Scaling a part down to nothing is plausible only if the misfit is huge.
        let factors = WRONG_FACTORS.into_iter().filter(|f| f.abs() >= 1.0 || now > CORRECTIONS[2].0);
        let trials = groups
            .flat_map(|group| factors.clone().map(move |f| (group.clone(), f)))
            .map(|(group, f)| (self.misfit(&|k| if group.contains(&k) { f } else { 1.0 }), group, f));
        let (after, group, f) = trials.min_by(|a, b| a.0.total_cmp(&b.0))?;
        if !is_correction(now, after) {
            return None;
        }
        // Without a numeric factor, which comes from folded constants.
        let bare = |part: Id| match graph.node(part) {
            Node::Binary(Binary::Mul, a, b) if graph.value(a).is_some() => b,
            Node::Binary(Binary::Mul, a, b) if graph.value(b).is_some() => a,
            _ => part,
        };
        if f < 0.0 && !self.holds_in_halves(&|k| if group.contains(&k) { f } else { 1.0 }) {
            return None;
        }
        // A time column in the wrong one of s and ms scales all accelerations by 1e6.
        let clock = parts.len() > 1 && group.len() == parts.len() && (f == 1e6 || f == 1e-6);
        let texts = group.iter().map(|&k| graph.text(bare(parts[k]), &system.names)).collect();
        let velocity = system.states[*velocity].name.clone();
        Some((after, Suspicion::PartScaled { velocity, parts: texts, factor: f, clock }))
    }
}

/// The integral over a stretch of a column times a kernel, which depends on the position in the stretch (0 to
/// 1) and its length.
fn integral(time: &[f64], column: &[f64], kernel: &dyn Fn(f64, f64) -> f64) -> f64 {
    let length = time[time.len() - 1] - time[0];
    let at = |i: usize| kernel((time[i] - time[0]) / length, length) * column[i];
    (1..time.len()).map(|i| 0.5 * (at(i) + at(i - 1)) * (time[i] - time[i - 1])).sum()
}

fn without_mean(mut values: Vec<f64>) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter_mut().for_each(|v| *v -= mean);
    values
}

/// The first `n` samples of every state that columns determine: a velocity without a column is the slope over
/// a tenth of a stretch, a displacement without one is the integral.
fn motion(system: &System, record: &Record, n: usize, stretch: usize) -> Vec<Option<Vec<f64>>> {
    let time = &record.time;
    let reach = (stretch / 10).max(1);
    let slope = |x: &[f64]| -> Vec<f64> {
        (0..n)
            .map(|i| {
                let (a, b) = (i.saturating_sub(reach), (i + reach).min(n - 1));
                (x[b] - x[a]) / (time[b] - time[a])
            })
            .collect()
    };
    let sum = |v: &[f64]| -> Vec<f64> {
        let mut x = vec![0.0];
        (1..n).for_each(|i| x.push(x[i - 1] + 0.5 * (v[i] + v[i - 1]) * (time[i] - time[i - 1])));
        without_mean(x)
    };
    let mut states: Vec<Option<Vec<f64>>> =
        record.columns[..system.states.len()].iter().map(|c| c.as_ref().map(|c| c[..n].to_vec())).collect();
    for (x, v) in system.states.iter().enumerate().filter_map(|(x, s)| Some((x, s.velocity?))) {
        match (&record.columns[x], &record.columns[v]) {
            (Some(column), None) => states[v] = Some(slope(column)),
            (None, Some(column)) => states[x] = Some(sum(column)),
            _ => {}
        }
    }
    states
}

/// A measured column, states first; none if it has no samples or is derived from another one.
fn measured(system: &System, record: &Record, k: usize) -> Option<Vec<f64>> {
    let Some(input) = k.checked_sub(system.states.len()) else { return record.columns[k].clone() };
    let source = record.derivations.iter().find(|d| d.of == input && d.column.len() == record.len());
    let raw = || source.map_or_else(|| record.input_samples(input).into_owned(), |d| d.column.clone());
    (!record.derivations.iter().any(|d| d.input == input)).then(raw)
}

/// The record with other values in some of its columns, states first. Derived inputs are derived again.
fn replaced(system: &System, record: &Record, columns: Vec<(usize, Vec<f64>)>) -> Option<Record> {
    let mut out = record.clone();
    for (k, values) in columns {
        match k.checked_sub(system.states.len()) {
            None => out.columns[k] = Some(values),
            Some(input) => {
                out.derivations
                    .iter_mut()
                    .filter(|d| d.of == input)
                    .for_each(|d| d.column.clone_from(&values));
                let kind = record.inputs[input].kind();
                out.inputs[input] = Signal::new(record.time.clone(), values, kind).ok()?;
            }
        }
    }
    out.rederived(Differentiator::Spline)
}

#[cfg(test)]
mod tests;
