//! Butterworth filters between an output and its column, as states of the system.
//!
//! A section of second order has `y' = w s`, `s' = w (h - y) - d w s` for what it reads, `h`, with the
//! angular cutoff `w`; one of first order has `y' = w (h - y)`. A low-pass shows `y`, a high-pass
//! `h - y - d s` and `h - y`. Where `h = g + c v'` reads the rate of a state (an accelerometer does), the
//! section keeps `s - w c v` in the place of `s` (of `y`, first order): its rate then holds `g` alone, so
//! friction enters it through the velocity, which does not jump.
//!
//! The poles of order `n` lie on a circle at equal angles: `d = 2 sin(pi (2k - 1)/(2n))`, and one section of
//! first order if `n` is odd (S. Butterworth, On the theory of filter amplifiers, Experimental Wireless 7
//! (1930) 536-541).

use crate::system::equations::System;
use crate::system::filter::{Filter, FilterKind, NotLinear};
use phisindy_expr::{Graph, Id};
use std::collections::HashMap;
use std::f64::consts::PI;

impl System {
    /// Adds the states of a filter behind an output; [`System::connect_filters`] then gives them their rates.
    pub fn add_filter(
        &mut self,
        output: usize,
        kind: FilterKind,
        order: usize,
        cutoff: Id,
        own_parameter: Option<usize>,
    ) {
        let first = self.states.len();
        let (name, unit) = (self.outputs[output].name.clone(), self.outputs[output].unit.clone());
        for k in 0..order {
            // A space keeps the name out of reach of any expression.
            let k = self.add_state(&format!("{name} {} {}", kind.name(), k + 1), &unit);
            self.states[k].hidden = true;
        }
        self.filters.push(Filter { output, kind, order, cutoff, own_parameter, first, settled: vec![] });
    }

    /// Writes the rates of all filters and what their outputs show, from what the outputs read.
    ///
    /// # Errors
    /// The index of the first output whose reading cannot be filtered.
    pub fn connect_filters(&mut self) -> Result<(), (usize, NotLinear)> {
        for output in &mut self.outputs {
            output.node = output.reading;
        }
        for k in 0..self.filters.len() {
            let output = self.filters[k].output;
            let reading = self.outputs[output].node;
            let connected =
                Connection::new(self, &self.filters[k].clone(), reading).ok_or((output, NotLinear))?;
            let first = self.filters[k].first;
            self.known[first..first + connected.rates.len()].copy_from_slice(&connected.rates);
            self.filters[k].settled = connected.settled;
            self.outputs[output].node = connected.shown;
        }
        Ok(())
    }
}

/// A filter behind a reading.
struct Connection {
    rates: Vec<Id>,
    settled: Vec<Id>,
    shown: Id,
}

/// A section of a filter: the angular cutoff, and what stands between its reading and its states.
struct Section {
    omega: Id,
    /// `w c v`, and the reading without rates.
    carried: Id,
    smooth: Id,
}

impl Connection {
    /// `None` if the reading is not linear in rates.
    fn new(system: &mut System, filter: &Filter, reading: Id) -> Option<Connection> {
        let mut all = Connection { rates: vec![], settled: vec![], shown: reading };
        let mut settled = reading;
        let two_pi = system.graph.constant(2.0 * PI);
        let omega = system.graph.mul(two_pi, filter.cutoff);
        let states: Vec<Id> =
            (filter.first..filter.first + filter.order).map(|k| system.states[k].node).collect();
        for (k, own) in states.chunks(2).enumerate() {
            let section = Section::new(system, all.shown, omega)?;
            let graph = &mut system.graph;
            let damping = 2.0 * (PI * (2 * k + 1) as f64 / (2 * filter.order) as f64).sin();
            let y = match *own {
                [first] => section.first_order(graph, first, &mut all),
                [y, second] => section.second_order(graph, (y, second), damping, &mut all),
                _ => unreachable!("chunks of one or two"),
            };
            // At rest y is what the section reads, and s is zero.
            let start = graph.neg(section.carried);
            match own.len() {
                1 => all.settled.push(graph.add(settled, start)),
                _ => all.settled.extend([settled, start]),
            }
            match filter.kind {
                FilterKind::Lowpass => all.shown = y,
                FilterKind::Highpass => {
                    let mut rest = graph.sub(all.shown, y);
                    if let [_, second] = *own {
                        let s = graph.add(second, section.carried);
                        let damping = graph.constant(damping);
                        let damped = graph.mul(damping, s);
                        rest = graph.sub(rest, damped);
                    }
                    all.shown = rest;
                    settled = graph.constant(0.0);
                }
            }
        }
        Some(all)
    }
}

impl Section {
    fn new(system: &mut System, reading: Id, omega: Id) -> Option<Section> {
        let symbols: Vec<Id> = system.rate_symbols.iter().map(|&(_, symbol)| symbol).collect();
        let moving = [system.time].into_iter().chain(system.states.iter().map(|s| s.node));
        let moving: Vec<Id> =
            moving.chain(system.inputs.iter().map(|u| u.node)).chain(symbols.iter().copied()).collect();
        let graph = &mut system.graph;
        let zero = graph.constant(0.0);
        let factors = graph.gradient(reading, &symbols);
        let mut carried = zero;
        for (&(state, _), &factor) in system.rate_symbols.iter().zip(&factors) {
            if graph.uses(&[factor], &moving) {
                return None;
            }
            let share = graph.mul(factor, system.states[state].node);
            carried = graph.add(carried, share);
        }
        let carried = graph.mul(omega, carried);
        let without: HashMap<Id, Id> = symbols.into_iter().map(|symbol| (symbol, zero)).collect();
        let smooth = graph.replace(&[reading], &without)[0];
        Some(Section { omega, carried, smooth })
    }

    /// Adds the rate of the one state; returns `y`.
    fn first_order(&self, graph: &mut Graph, state: Id, all: &mut Connection) -> Id {
        let y = graph.add(state, self.carried);
        let miss = graph.sub(self.smooth, y);
        all.rates.push(graph.mul(self.omega, miss));
        y
    }

    /// Adds the rates of the two states; returns `y`.
    fn second_order(
        &self,
        graph: &mut Graph,
        (y, state): (Id, Id),
        damping: f64,
        all: &mut Connection,
    ) -> Id {
        let s = graph.add(state, self.carried);
        let damping = graph.constant(damping);
        let (miss, damped) = (graph.sub(self.smooth, y), graph.mul(damping, s));
        let push = graph.sub(miss, damped);
        all.rates.extend([graph.mul(self.omega, s), graph.mul(self.omega, push)]);
        y
    }
}
