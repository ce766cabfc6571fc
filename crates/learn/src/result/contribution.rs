//! Contribution of each identified term along the motion: its part of the unknown force, and the energy that
//! it dissipates.

use super::identified::Identified;
use super::term::Contribution;
use crate::decisions::MOSTLY;
use phisindy_expr::{Scratch, Tape};
use phisindy_phys::spec::Role;
use phisindy_phys::unit::{Dimension, Unit};
use phisindy_phys::{Record, System};
use phisindy_signal::strongest_line;
use phisindy_sim::{Automaton, Trajectory};

/// Sums of one term over the Fit records.
#[derive(Clone, Copy, Default)]
struct Sums {
    /// Of the squared force of the term, and of all terms of its state together; number of samples.
    square: f64,
    all: f64,
    samples: f64,
    /// Energy taken out, and the time it took.
    work: f64,
    duration: f64,
    /// Number of cycles; NaN once a record has none.
    cycles: f64,
}

/// Fills in [`crate::FoundTerm::contribution`] from the free runs of the Fit records; it stays empty where
/// one of them could not be run.
pub(crate) fn contributions(system: &System, records: &[Record], found: &mut Identified) {
    let mut sums = vec![Sums::default(); found.terms.len()];
    for (r, record) in records.iter().enumerate().filter(|(_, record)| record.role == Role::Fit) {
        if add(system, r, record, found, &mut sums).is_none() {
            return;
        }
    }
    for (term, s) in found.terms.iter_mut().zip(sums) {
        let moves = is_velocity(system, system.terms[term.term].state) && s.duration > 0.0;
        term.contribution = (s.samples > 0.0).then(|| Contribution {
            rms: (s.square / s.samples).sqrt(),
            share: if s.all > 0.0 { (s.square / s.all).sqrt() } else { 0.0 },
            power: moves.then(|| s.work / s.duration),
            per_cycle: (moves && s.cycles > 0.0).then(|| s.work / s.cycles),
        });
    }
}

/// Adds one record; `None` if its free run failed.
fn add(system: &System, r: usize, record: &Record, found: &Identified, sums: &mut [Sums]) -> Option<()> {
    let run = found.records[r].run.as_ref()?;
    let terms = &found.terms;
    let mut graph = system.graph.clone();
    let one = graph.constant(1.0);
    let values = terms.iter().map(|t| system.terms[t.term].value);
    let inertia = terms.iter().map(|t| system.inertia[system.terms[t.term].state].unwrap_or(one));
    let outputs: Vec<_> = values.chain(inertia).collect();
    let tape = Tape::compile(&graph, &system.arguments(), &outputs).ok()?;
    let mut scratch = Scratch::<1>::new(&tape);
    let sticks = sticks(system, found)?;
    let switches = run.modes.len() / record.len().max(1);
    let parameters = found.parameters_of(system, r);
    let mut before = vec![0.0; terms.len()];
    for i in 0..record.len() {
        let states = run.state_at(i);
        scratch.at(record.arguments_at(i, states.iter().copied(), &parameters));
        let modes = &run.modes[i * switches..(i + 1) * switches];
        let force = |k: usize| {
            // A contact that sticks does no work; its force balances the others.
            let held = sticks[k].iter().any(|&s| modes[s] == 0);
            if held {
                0.0
            } else {
                terms[k].coefficient.value * scratch.output(k)[0] * scratch.output(terms.len() + k)[0]
            }
        };
        let forces: Vec<f64> = (0..terms.len()).map(force).collect();
        for (k, s) in sums.iter_mut().enumerate() {
            let state = system.terms[terms[k].term].state;
            let together = (0..terms.len()).filter(|&j| system.terms[terms[j].term].state == state);
            s.square += forces[k].powi(2);
            s.all += together.map(|j| forces[j]).sum::<f64>().powi(2);
            s.samples += 1.0;
            let power = -forces[k] * states[state];
            if i > 0 {
                s.work += 0.5 * (before[k] + power) * (record.time[i] - record.time[i - 1]);
            }
            before[k] = power;
        }
    }
    let duration = record.time[record.len() - 1] - record.time[0];
    for (k, s) in sums.iter_mut().enumerate() {
        s.duration += duration;
        s.cycles += frequency(system, system.terms[terms[k].term].state, record, run) * duration;
    }
    Some(())
}

/// For each term, the contacts (switches of the automaton) that it is friction of.
fn sticks(system: &System, found: &Identified) -> Option<Vec<Vec<usize>>> {
    let terms: Vec<usize> = found.terms.iter().map(|t| t.term).collect();
    let automaton = Automaton::new(&system.model(&terms)).ok()?;
    let switches = &automaton.switches;
    let held = |term: &usize| {
        let value = system.terms[*term].value;
        (0..switches.len())
            .filter(|&s| switches[s].can_stick && system.graph.uses(&[value], &[switches[s].node]))
            .collect()
    };
    Some(terms.iter().map(held).collect())
}

/// Whether force times this state is power: the rate of a displacement, or what is measured in m/s.
pub(super) fn is_velocity(system: &System, state: usize) -> bool {
    let speed = Dimension::METRE.div(Dimension::SECOND);
    system.states.iter().any(|s| s.velocity == Some(state))
        || Unit::parse(&system.states[state].unit).is_ok_and(|unit| unit.dimension == speed)
}

/// Cycles per second of the motion behind a velocity; NaN if it does not go in cycles.
fn frequency(system: &System, velocity: usize, record: &Record, run: &Trajectory) -> f64 {
    let displacement = system.states.iter().position(|s| s.velocity == Some(velocity));
    let line = strongest_line(&record.time, &run.column(displacement.unwrap_or(velocity)));
    line.filter(|line| line.share > MOSTLY).map_or(f64::NAN, |line| line.frequency)
}
