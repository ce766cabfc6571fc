//! What records tell of the force that a model lacks, speed by speed and before any fit: enough, or move slower.
//!
//! `F = m (rate - a)` at smoothed samples, one for each window, so that their errors are independent. The force is
//! linear between nodes at each halving of the largest speed, one row for each direction; it and the free constants
//! of the known part are found together by least squares.

use crate::chart::digits;
use crate::measured_force::LocalCubic;
use crate::table::REACH;
use phisindy_expr::{Id, Scratch, Tape};
use phisindy_phys::{Record, System};
use std::fmt;

/// Convention: a force that is known to this part of its largest value (95 %) is known well enough.
const ENOUGH: f64 = 0.05;
/// Nodes in each direction: each at half the speed of the next.
const HALVINGS: usize = 6;
/// Most samples of a body that are looked at.
const SAMPLES: usize = 3000;
/// Most steps of Gauss and Newton: the rates are nearly linear in their constants.
const STEPS: usize = 8;
/// Part of a constant's force, in squares, that is no function of the speed: with less the curve holds that force.
const APART: f64 = 1e-2;
/// What the records tell of the missing force over one speed.
#[derive(Clone, Debug)]
pub struct Coverage {
    /// The speed, as the spec writes it, and its unit.
    pub speed: (String, String),
    /// Unit of the force; that of the rate where the spec states no inertia.
    pub unit: String,
    /// In the order of the speed.
    pub nodes: Vec<Node>,
    /// The largest force that is known.
    largest: f64,
}

/// The missing force at one speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// In the unit of the spec.
    pub speed: f64,
    /// Positive against a positive speed (SI).
    pub force: f64,
    /// Half of its 95 % interval; infinite where no sample tells it.
    pub half: f64,
}

impl Coverage {
    /// Whether the force is known well enough at all speeds.
    pub fn is_enough(&self) -> bool {
        self.worst().is_some_and(|node| node.half <= ENOUGH * self.largest)
    }

    /// The node that is known worst.
    fn worst(&self) -> Option<&Node> {
        self.nodes.iter().max_by(|a, b| a.half.total_cmp(&b.half))
    }
}

impl fmt::Display for Coverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ((speed, unit), Some(worst)) = (&self.speed, self.worst()) else {
            return f.write_str("Move it.");
        };
        let most = self.nodes.last().map_or(0.0, |n| n.speed);
        let shown = |x: f64| format!("{} {unit}", digits(x, 2));
        let share = format!("{} %", digits(100.0 * worst.half / self.largest, 2));
        if self.is_enough() {
            let least = self.nodes.iter().map(|n| n.speed.abs()).fold(f64::INFINITY, f64::min);
            return write!(
                f,
                "Enough: the missing force is known to {share} from {} to {} of `{speed}`, both ways.",
                shown(least),
                shown(most)
            );
        }
        let way = if worst.speed < 0.0 { "backwards" } else { "forwards" };
        let advice = match worst.speed.abs() {
            v if self.nodes.iter().all(|n| n.speed * worst.speed < 0.0 || n.half.is_infinite()) => {
                format!("Move {way} too, up to {}", shown(v.max(most)))
            }
            v if v <= 0.3 * most => format!("Move slower, {way} at about {}", shown(v)),
            v => format!("Go on, {way} at about {}", shown(v)),
        };
        if worst.half.is_finite() {
            write!(f, "{advice}: there the missing force is known to {share} of its largest value only.")
        } else {
            write!(f, "{advice}: no sample tells the missing force there.")
        }
    }
}

/// What records tell of the missing force at each body whose motion is measured. `None` stands for no body, or
/// for too few samples.
pub fn coverage(system: &System, records: &[Record]) -> Vec<Coverage> {
    let bodies = (0..system.states.len()).filter(|&v| {
        let displacement = system.states.iter().any(|x| x.velocity == Some(v));
        displacement || system.contacts.iter().any(|c| c.node == system.states[v].node)
    });
    bodies.filter_map(|v| Body::of(system, v)?.covered(records)).collect()
}

/// A body, and what is asked of its expressions.
struct Body<'a> {
    system: &'a System,
    /// Its velocity.
    state: usize,
    /// The speed over which the force is drawn, and its name.
    speed: String,
    /// Speed, rate, inertia; then the derivatives of rate and inertia by each free constant.
    tape: Tape,
}

/// A sample: speed, missing force, its derivatives by the free constants.
struct Sample {
    speed: f64,
    force: f64,
    by: Vec<f64>,
}

/// States of a record at samples that are independent, with the rate of one of them.
struct Motion {
    samples: Vec<usize>,
    states: Vec<Vec<f64>>,
    rates: Vec<f64>,
    /// Standard deviation of the smoothed velocity.
    error: f64,
}

impl<'a> Body<'a> {
    fn of(system: &'a System, state: usize) -> Option<Body<'a>> {
        let own = system.states[state].node;
        // It rubs at the contact that its speed has a part in.
        let contact = system.contacts.iter().find(|c| system.graph.uses(&[c.node], &[own]));
        let (node, speed) = contact.map_or((own, &system.states[state].name), |c| (c.node, &c.text));
        let mut graph = system.graph.clone();
        let (rate, inertia) = (system.known[state], system.inertia[state]);
        let inertia = inertia.unwrap_or_else(|| graph.constant(1.0));
        let constants: Vec<Id> = system.parameters.iter().map(|p| p.node).collect();
        let slopes = [rate, inertia].map(|of| graph.gradient(of, &constants));
        let nodes: Vec<Id> = [node, rate, inertia].into_iter().chain(slopes.concat()).collect();
        let tape = Tape::compile(&graph, &system.arguments(), &nodes).ok()?;
        Some(Body { system, state, speed: speed.clone(), tape })
    }

    fn covered(&self, records: &[Record]) -> Option<Coverage> {
        let motions: Vec<(&Record, Motion)> =
            records.iter().filter_map(|r| Some((r, self.motion(r)?))).collect();
        let error = motions.iter().map(|(_, m)| m.error).fold(0.0, f64::max);
        let mut values: Vec<f64> = self.system.parameters.iter().map(|p| p.start).collect();
        let mut fitted = None;
        for _ in 0..STEPS {
            let samples: Vec<Sample> =
                motions.iter().flat_map(|(r, m)| self.samples(r, m, &values)).collect();
            let most = samples.iter().map(|s| s.speed.abs()).fold(0.0, f64::max);
            let nodes: Vec<f64> =
                (0..HALVINGS).map(|k| most / f64::from(1 << k)).take_while(|v| *v > 4.0 * error).collect();
            if nodes.is_empty() {
                return None;
            }
            let fit = Fit::of(&samples, &nodes, &values)?;
            let moved = self.moved(&mut values, &fit.constants);
            fitted = Some((fit, nodes));
            if !moved {
                break;
            }
        }
        let (fit, nodes) = fitted?;
        Some(self.told(&fit, &nodes))
    }

    /// Moves the constants within their bounds; whether by more than a part in a million.
    fn moved(&self, values: &mut [f64], by: &[f64]) -> bool {
        let mut moved = false;
        for ((value, p), by) in values.iter_mut().zip(&self.system.parameters).zip(by) {
            let new = (*value + by).clamp(p.within.0, p.within.1);
            moved |= (new - *value).abs() > 1e-6 * value.abs();
            *value = new;
        }
        moved
    }

    fn told(&self, fit: &Fit, nodes: &[f64]) -> Coverage {
        let (system, v) = (self.system, self.state);
        let state = &system.states[v];
        let rotates = state.unit.starts_with("rad") || state.unit.starts_with("deg");
        let unit = match system.inertia[v] {
            Some(_) if rotates => "N*m".to_owned(),
            Some(_) => "N".to_owned(),
            None => format!("{}/s", state.unit),
        };
        let size = |k: usize| 1.0 / if system.inertia[v].is_some() { 1.0 } else { system.factor(k) };
        let mut all: Vec<Node> = Vec::new();
        for (k, speed) in nodes.iter().flat_map(|v| [*v, -*v]).enumerate() {
            let (force, half) = fit.nodes[k];
            all.push(Node { speed: speed / system.factor(v), force: force * size(v), half: half * size(v) });
        }
        all.sort_by(|a, b| a.speed.total_cmp(&b.speed));
        let known = all.iter().filter(|n| n.half.is_finite());
        let largest = known.map(|n| n.force.abs()).fold(f64::MIN_POSITIVE, f64::max);
        Coverage { speed: (self.speed.clone(), state.unit.clone()), unit, nodes: all, largest }
    }

    /// The motion of a record, smoothed; `None` where this body is not measured.
    fn motion(&self, record: &Record) -> Option<Motion> {
        let states = &self.system.states;
        let measured = |s: usize| record.columns[s].as_deref().filter(|_| record.own_times.all(s));
        let place = states.iter().position(|x| x.velocity == Some(self.state));
        let (column, twice) = match (measured(self.state), place) {
            (Some(_), _) => (self.state, false),
            (None, Some(x)) => (x, true),
            (None, None) => return None,
        };
        let rate = |own: &LocalCubic<'_>, i: usize| own.at(i).map(|d| if twice { d[2] } else { d[1] });
        let values = measured(column)?;
        let noise = record.noise_level(column);
        let (time, longest) = (&record.time, LocalCubic::new(&record.time, values, f64::INFINITY, twice)?);
        let every = (record.len() / SAMPLES).max(1);
        let typical = (0..record.len()).step_by(every).filter_map(|i| rate(&longest, i));
        let typical = typical.map(f64::abs).fold(0.0, f64::max);
        let smooth: Vec<Option<LocalCubic<'_>>> = (0..states.len())
            .map(|s| match s {
                s if s == column => LocalCubic::new(time, values, noise / typical, twice),
                s => LocalCubic::new(time, measured(s)?, record.noise_level(s) / record.deviation(s), false),
            })
            .collect();
        let own = smooth[column].as_ref()?;
        let step = (2.0 * own.half_width() / record.step(column)).round().max(1.0) as usize;
        let at = |s: usize, i: usize| -> f64 {
            let of = |s: usize, k: usize| smooth[s].as_ref().and_then(|cubic| Some(cubic.at(i)?[k]));
            let slope = || states.iter().position(|x| x.velocity == Some(s)).and_then(|x| of(x, 1));
            of(s, 0).or_else(slope).unwrap_or(f64::NAN)
        };
        let error = noise * own.error(usize::from(twice));
        let mut motion = Motion { samples: vec![], states: vec![], rates: vec![], error };
        let half = step / 2;
        for i in (half..record.len().saturating_sub(half)).step_by(step.max(record.len() / SAMPLES)) {
            let speed = at(self.state, i);
            // A window over a reversal mixes both signs of a friction, and one at rest tells none.
            let same = [i - half, i + half].into_iter().all(|k| at(self.state, k) * speed >= 0.0);
            let (Some(rate), true) = (rate(own, i), same && speed.abs() > 3.0 * motion.error) else {
                continue;
            };
            motion.samples.push(i);
            motion.states.push((0..states.len()).map(|s| at(s, i)).collect());
            motion.rates.push(rate);
        }
        Some(motion)
    }

    /// Speed and force of the samples, with these values of the constants.
    fn samples(&self, record: &Record, motion: &Motion, values: &[f64]) -> Vec<Sample> {
        let mut scratch = Scratch::<1>::new(&self.tape);
        let mut all = Vec::new();
        for (k, &a) in motion.rates.iter().enumerate() {
            scratch.at(record.arguments_at(motion.samples[k], motion.states[k].iter().copied(), values));
            let told = |k: usize| scratch.output(k)[0];
            let (speed, left, inertia) = (told(0), told(1) - a, told(2));
            let by = |p: usize| inertia * told(3 + p) + left * told(3 + values.len() + p);
            let by: Vec<f64> = (0..values.len()).map(by).collect();
            let force = inertia * left;
            if [speed, force].into_iter().chain(by.iter().copied()).all(f64::is_finite) {
                all.push(Sample { speed, force, by });
            }
        }
        all
    }
}

/// The force at the nodes, forwards and backwards in turn, with half of its 95 % interval, and how far each free
/// constant moves.
struct Fit {
    nodes: Vec<(f64, f64)>,
    constants: Vec<f64>,
}

impl Fit {
    fn of(samples: &[Sample], nodes: &[f64], values: &[f64]) -> Option<Fit> {
        let own = 2 * nodes.len();
        let column = |j: usize| -> Vec<f64> {
            if let Some(p) = j.checked_sub(own) {
                return samples.iter().map(|s| -s.by[p]).collect();
            }
            samples
                .iter()
                .map(|s| if (s.speed < 0.0) == (j % 2 == 1) { hat(nodes, j / 2, s.speed.abs()) } else { 0.0 })
                .collect()
        };
        let seen: Vec<f64> = (0..own)
            .map(|j| column(j).iter().filter(|w| **w <= 1.0).map(|w| w.max(0.0).powi(2)).sum())
            .collect();
        let mut left: Vec<f64> = samples.iter().map(|s| s.force).collect();
        // Gram and Schmidt: what its predecessors tell of a column is taken out, and one of which nothing is left is
        // left out.
        let mut basis: Vec<Vec<f64>> = vec![];
        let mut kept: Vec<(usize, Vec<f64>)> = vec![];
        for j in 0..own + values.len() {
            let mut rest = column(j);
            let whole = dot(&rest, &rest);
            let mut parts = Vec::new();
            for q in &basis {
                let part = dot(q, &rest);
                rest.iter_mut().zip(q).for_each(|(r, q)| *r -= part * q);
                parts.push(part);
            }
            let length = dot(&rest, &rest).sqrt();
            if length * length > APART * whole {
                rest.iter_mut().for_each(|r| *r /= length);
                parts.push(length);
                basis.push(rest);
                kept.push((j, parts));
            } else if let Some(p) = j.checked_sub(own) {
                // A constant whose force is one over the speed: the force that is told holds all of it.
                left.iter_mut().zip(samples).for_each(|(f, s)| *f -= s.by[p] * values[p]);
            }
        }
        let freedom = samples.len().checked_sub(kept.len()).filter(|n| *n > 0)?;
        let size: Vec<f64> = basis.iter().map(|q| dot(q, &left)).collect();
        for (q, size) in basis.iter().zip(&size) {
            left.iter_mut().zip(q).for_each(|(l, q)| *l -= size * q);
        }
        let deviation = (dot(&left, &left) / freedom as f64).sqrt();
        // The triangle is solved backwards, for the estimates and for each unit of error.
        let solved = |mut right: Vec<f64>| {
            for k in (0..kept.len()).rev() {
                right[k] /= kept[k].1[k];
                for i in 0..k {
                    right[i] -= kept[k].1[i] * right[k];
                }
            }
            right
        };
        let mut squares = vec![0.0; kept.len()];
        for k in 0..kept.len() {
            let mut unit = vec![0.0; kept.len()];
            unit[k] = deviation;
            squares.iter_mut().zip(solved(unit)).for_each(|(sum, e)| *sum += e * e);
        }
        let mut fit = Fit { nodes: vec![(0.0, f64::INFINITY); own], constants: vec![0.0; values.len()] };
        for (((j, _), value), square) in kept.iter().zip(solved(size)).zip(squares) {
            match j.checked_sub(own) {
                Some(p) => fit.constants[p] = value,
                // Without a sample about it a node only leads the line to the next one.
                None if seen[*j] < 0.25 => {}
                None => fit.nodes[*j] = (value, REACH * square.sqrt()),
            }
        }
        Some(fit)
    }
}

/// The hat of node `k` at a speed: 1 there, 0 at its neighbours; below the last node the line through the last two
/// goes on.
fn hat(nodes: &[f64], k: usize, speed: f64) -> f64 {
    let right = nodes.iter().rposition(|v| *v > speed).map_or(0, |at| at.min(nodes.len().saturating_sub(2)));
    let (Some(&upper), Some(&lower)) = (nodes.get(right), nodes.get(right + 1)) else { return 1.0 };
    let part = ((speed - lower) / (upper - lower)).min(1.0);
    if k == right {
        part
    } else if k == right + 1 {
        1.0 - part
    } else {
        0.0
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests;
