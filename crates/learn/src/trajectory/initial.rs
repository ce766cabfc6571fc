//! Where the trajectory fit starts: a regression on the smoothed data in integral form.
//!
//! Over a stretch in which no contact sticks or turns, `x(b) - x(a) - int g dt = sum_k xi_k int f_k dt` is
//! linear in the coefficients and needs no derivative of the data. Noise in the integrands makes it slightly
//! biased, which the fit then removes; it cannot fall into a side minimum.

use crate::decisions::{LONGEST_STRETCH, RIDGE, SHORTEST_STRETCH, SLOW_CONTACT};
use crate::linear::{solve_damped, symmetric};
use crate::trajectory::kalman_smoother::{estimated_states, reads_outputs};
use phisindy_expr::{Id, Scratch, Tape, Unary};
use phisindy_phys::{Record, System};
use phisindy_signal::{Differentiator, standard_deviation};
use phisindy_sim::Assembly;
use rayon::prelude::*;

/// The records with the sizes of states that only outputs tell, from what [`smoothed`] makes of them.
pub fn sized(system: &System, records: &[Record], smooth: &[Record]) -> Vec<Record> {
    let size = |column: &Option<Vec<f64>>| column.as_ref().map_or(0.0, |x| standard_deviation(x));
    let of = |(record, smooth): (&Record, &Record)| {
        let told = if reads_outputs(system, record) { system.states.len() } else { 0 };
        Record { sizes: smooth.columns[..told].iter().map(size).collect(), ..record.clone() }
    };
    records.iter().zip(smooth).map(of).collect()
}

/// The record with every column smoothed, and columns for velocities that have none and for states that only
/// outputs tell. States that cannot be derived stay without.
pub fn smoothed(system: &System, record: &Record) -> Record {
    let mut out = differentiated(system, record);
    if let Some(states) = estimated_states(system, record) {
        for (column, state) in out.columns.iter_mut().zip(states).filter(|(column, _)| column.is_none()) {
            *column = Some(state);
        }
    }
    assemble(system, record, &mut out);
    out
}

/// Gives the states of a mechanism with loops that have no column those that its constraints leave, with constants as
/// the spec starts them.
fn assemble(system: &System, record: &Record, out: &mut Record) {
    let (values, rates): (Vec<Id>, Vec<Id>) = system.constraints.iter().map(|c| (c.value, c.rate)).unzip();
    let states: Vec<Id> = system.states.iter().map(|s| s.node).collect();
    let arguments = system.arguments();
    let Some(assembly) = Assembly::new(&system.graph, &arguments, &states, (&values, &rates)) else { return };
    let free: Vec<bool> = out.columns[..states.len()].iter().map(Option::is_none).collect();
    let mut x: Vec<f64> = record.start.iter().map(|start| start.unwrap_or(0.0)).collect();
    let mut all: Vec<Vec<f64>> = vec![Vec::with_capacity(record.len()); states.len()];
    for i in 0..record.len() {
        for (x, column) in x.iter_mut().zip(&out.columns) {
            *x = column.as_ref().map_or(*x, |c| c[i]);
        }
        let time = record.time[i];
        let at = |x: &[f64]| -> Vec<f64> {
            let moving = [time]
                .into_iter()
                .chain(x.iter().copied())
                .chain(record.inputs.iter().map(|u| u.value(time)));
            let numbers = system.parameters.iter().map(|p| p.start).chain(record.constants.iter().copied());
            moving.chain(numbers).collect()
        };
        // Noise may ask for what no linkage can do: it stays where it was.
        assembly.assemble(&mut x, &free, &at);
        all.iter_mut().zip(&x).for_each(|(all, x)| all.push(*x));
    }
    for (column, own) in out.columns.iter_mut().zip(all).filter(|(column, _)| column.is_none()) {
        *column = Some(own);
    }
}

/// The record with every column smoothed, and columns for velocities that have none. Those of states say what the
/// state is and not what its sensor reads, as far as offset and gain are known. States that only outputs tell stay
/// without: fits start them at rest.
pub fn differentiated(system: &System, record: &Record) -> Record {
    let derived = (0..record.columns.len())
        .into_par_iter()
        .map(|k| record.differentiated(k, Differentiator::Spline)?.ok());
    let derived: Vec<_> = derived.collect();
    let mut out = record.clone();
    for (k, d) in derived.into_iter().enumerate().filter_map(|(k, d)| Some((k, d?))) {
        let Some(state) = system.states.get(k) else {
            out.columns[k] = Some(d.values);
            continue;
        };
        let (offset, gain) = record.sensors[k].known_before();
        out.columns[k] = Some(d.values.iter().map(|x| (x - offset) / gain).collect());
        if let Some(v) = state.velocity.filter(|&v| record.columns[v].is_none()) {
            out.columns[v] = Some(d.derivative.iter().map(|x| x / gain).collect());
        }
    }
    out
}

/// The regression's normal equations over the whole dictionary; any subset is solved from them.
pub(crate) struct Regression {
    /// Terms that are not finite somewhere on the data.
    pub(crate) singular: Vec<usize>,
    triangle: Vec<f64>,
    right: Vec<f64>,
    /// Bounds of each coefficient.
    within: Vec<(f64, f64)>,
    p: usize,
}

impl Regression {
    /// Gathers the equations from smoothed records, movable constants at `parameters`.
    pub(crate) fn new(system: &System, smooth: &[Record], parameters: &[f64]) -> Regression {
        let terms: Vec<usize> = (0..system.terms.len()).collect();
        let p = terms.len();
        let mut out = Regression {
            singular: vec![],
            triangle: vec![0.0; p * (p + 1) / 2],
            right: vec![0.0; p],
            within: system.terms.iter().map(|t| t.within).collect(),
            p,
        };
        for record in smooth {
            let Some(values) = evaluate(system, &terms, record, parameters) else { continue };
            let bad = |k: &usize| values.terms[*k].iter().any(|v| !v.is_finite());
            out.singular.extend(terms.iter().copied().filter(bad));
            for stretch in stretches(&values.contacts, record.len()) {
                let integral = |column: &[f64]| -> f64 {
                    let slice =
                        |i: usize| 0.5 * (column[i] + column[i + 1]) * (record.time[i + 1] - record.time[i]);
                    (stretch.0..stretch.1).map(slice).sum()
                };
                for state in 0..system.states.len() {
                    let here: Vec<usize> = (0..p).filter(|&k| system.terms[k].state == state).collect();
                    let Some(x) = record.columns[state].as_ref().filter(|_| !here.is_empty()) else {
                        continue;
                    };
                    let left = x[stretch.1] - x[stretch.0] - integral(&values.known[state]);
                    let row: Vec<f64> = here.iter().map(|&k| integral(&values.terms[k])).collect();
                    if !(left.is_finite() && row.iter().all(|v| v.is_finite())) {
                        continue;
                    }
                    for (i, &a) in here.iter().enumerate() {
                        out.right[a] += row[i] * left;
                        for (j, &b) in here.iter().enumerate().skip(i) {
                            out.triangle[a * p - a * (a + 1) / 2 + b] += row[i] * row[j];
                        }
                    }
                }
            }
        }
        out.singular.sort_unstable();
        out.singular.dedup();
        out
    }

    fn at(&self, i: usize, j: usize) -> f64 {
        let (i, j) = (i.min(j), i.max(j));
        self.triangle[i * self.p - i * (i + 1) / 2 + j]
    }

    /// Coefficients of a subset; all zero where the equations cannot be solved. What would leave its bounds
    /// stays at them while the others are solved again.
    pub(crate) fn solve(&self, terms: &[usize]) -> Vec<f64> {
        let mut held: Vec<Option<f64>> = vec![None; terms.len()];
        loop {
            let free: Vec<usize> = (0..terms.len()).filter(|&k| held[k].is_none()).collect();
            let found = self.solve_beside(terms, &free, &held);
            let mut beyond = false;
            for (&k, x) in free.iter().zip(&found) {
                let (low, high) = self.within[terms[k]];
                if *x < low || *x > high {
                    held[k] = Some(x.clamp(low, high));
                    beyond = true;
                }
            }
            if !beyond {
                free.into_iter().zip(found).for_each(|(k, x)| held[k] = Some(x));
                return held.into_iter().map(Option::unwrap_or_default).collect();
            }
        }
    }

    /// Coefficients of the free ones among `terms`, beside those that are held.
    fn solve_beside(&self, terms: &[usize], free: &[usize], held: &[Option<f64>]) -> Vec<f64> {
        let n = free.len();
        let triangle: Vec<f64> = (0..n)
            .flat_map(|i| (i..n).map(move |j| (i, j)))
            .map(|(i, j)| self.at(terms[free[i]], terms[free[j]]))
            .collect();
        let taken = |k: usize| -> f64 {
            held.iter().zip(terms).map(|(h, &t)| h.map_or(0.0, |x| x * self.at(terms[k], t))).sum()
        };
        let right: Vec<f64> = free.iter().map(|&k| self.right[terms[k]] - taken(k)).collect();
        solve_damped(&symmetric(&triangle, n), &right, RIDGE).unwrap_or_else(|| vec![0.0; n])
    }

    /// What a subset explains: the fall of the sum of squares.
    fn explained(&self, terms: &[usize]) -> f64 {
        let x = self.solve(terms);
        let rise =
            |i: usize| (0..terms.len()).map(|j| x[i] * x[j] * self.at(terms[i], terms[j])).sum::<f64>();
        (0..terms.len()).map(|i| 2.0 * x[i] * self.right[terms[i]] - rise(i)).sum()
    }

    /// The `rank`-th best single term of each equation (the last one where there are fewer).
    pub(crate) fn single(&self, system: &System, rank: usize) -> Vec<usize> {
        let mut chosen: Vec<usize> = Vec::new();
        for state in 0..system.states.len() {
            let mut here: Vec<usize> = (0..self.p).filter(|&k| system.terms[k].state == state).collect();
            here.sort_by(|&a, &b| self.explained(&[b]).total_cmp(&self.explained(&[a])));
            chosen.extend(here.get(rank).or(here.last()));
        }
        chosen.sort_unstable();
        chosen
    }

    /// The best subset with at most `most` terms in each equation, greedily.
    pub(crate) fn best(&self, system: &System, most: usize) -> Vec<usize> {
        let mut chosen: Vec<usize> = Vec::new();
        for state in 0..system.states.len() {
            let here: Vec<usize> = (0..self.p).filter(|&k| system.terms[k].state == state).collect();
            let mut own: Vec<usize> = Vec::new();
            for _ in 0..most.min(here.len()) {
                let with = |k: usize| own.iter().copied().chain([k]).collect::<Vec<_>>();
                let outside = here.iter().copied().filter(|k| !own.contains(k));
                let Some(next) =
                    outside.max_by(|&a, &b| self.explained(&with(a)).total_cmp(&self.explained(&with(b))))
                else {
                    break;
                };
                own.push(next);
            }
            chosen.extend(own);
        }
        chosen.sort_unstable();
        chosen
    }
}

struct Values {
    known: Vec<Vec<f64>>,
    terms: Vec<Vec<f64>>,
    /// Everything whose sign stands in a rate, and the rates of gaps.
    contacts: Vec<Vec<f64>>,
}

/// Known rates, terms and velocities of contacts at every sample.
fn evaluate(system: &System, terms: &[usize], record: &Record, parameters: &[f64]) -> Option<Values> {
    let inputs = system.arguments();
    let mut outputs = system.known.clone();
    outputs.extend(terms.iter().map(|&k| system.terms[k].value));
    let signs: Vec<Id> = system
        .graph
        .reachable(&outputs)
        .into_iter()
        .filter_map(|id| match system.graph.node(id) {
            phisindy_expr::Node::Unary(Unary::Sgn | Unary::Step, w) => Some(w),
            _ => None,
        })
        .collect();
    outputs.extend(&signs);
    // A gap that closes opens again: its rate turns as that of a contact does.
    let mut graph = system.graph.clone();
    outputs.extend(system.gap_rates(&mut graph));
    let tape = Tape::compile(&graph, &inputs, &outputs).ok()?;
    let mut scratch = Scratch::<1>::new(&tape);
    let mut columns = vec![Vec::with_capacity(record.len()); outputs.len()];
    for i in 0..record.len() {
        let states = record.columns[..system.states.len()].iter().map(|c| c.as_ref().map_or(0.0, |c| c[i]));
        scratch.at(record.arguments_at(i, states, parameters));
        columns.iter_mut().enumerate().for_each(|(k, c)| c.push(scratch.output(k)[0]));
    }
    let contacts = columns.split_off(system.known.len() + terms.len());
    let terms = columns.split_off(system.known.len());
    Some(Values { known: columns, terms, contacts })
}

/// Stretches in which every contact keeps its direction and moves at more than a small part of its usual
/// speed.
fn stretches(contacts: &[Vec<f64>], samples: usize) -> Vec<(usize, usize)> {
    let slow: Vec<f64> = contacts
        .iter()
        .map(|w| SLOW_CONTACT * (w.iter().map(|v| v * v).sum::<f64>() / samples as f64).sqrt())
        .collect();
    let moving = |i: usize| contacts.iter().zip(&slow).all(|(w, s)| w[i].abs() > *s);
    let same = |i: usize, j: usize| contacts.iter().all(|w| w[i] * w[j] > 0.0);
    let mut out = Vec::new();
    let mut start = 0;
    for i in 0..samples {
        let breaks = !moving(i) || !same(start, i);
        if breaks || i - start == LONGEST_STRETCH {
            let end = if breaks { i.saturating_sub(1) } else { i };
            if end >= start + SHORTEST_STRETCH {
                out.push((start, end));
            }
            start = i;
        }
    }
    out
}

#[cfg(test)]
mod tests;
