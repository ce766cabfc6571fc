//! What a sampled controller holds: states whose rate is zero, and which jump at known times.
//!
//! `hold(e, T)` is `e` as it was at the last multiple of `T` (of the record's time). With a delay there is a second
//! state: the value that waits for its turn. Steps end at these times. What is sampled sees all held values as they were
//! just before, so a value that is held twice is a period older. Before the first multiple in a run, `e` at its start
//! holds.

use crate::decisions::SAME_TICK;
use crate::state::Run;
use phisindy_expr::{Binary, Id, Node};
use phisindy_phys::Model;
use std::collections::HashMap;

/// Something that is held.
#[derive(Clone, Debug)]
pub(crate) struct Held {
    /// What is sampled.
    pub(crate) of: Id,
    /// Its states: what is in force, and with a delay what waits.
    pub(crate) current: usize,
    pub(crate) waiting: Option<usize>,
    period: f64,
    delay: f64,
}

/// A reset at equal distances of time.
#[derive(Clone, Debug)]
pub(crate) struct Tick {
    /// Which of the automaton's resets.
    pub(crate) reset: usize,
    period: f64,
    /// How long after the multiples of the period.
    delay: f64,
}

impl Tick {
    fn time(&self, count: f64) -> f64 {
        count * self.period + self.delay
    }

    /// The multiple of the period that is the first one after a time.
    fn after(&self, time: f64) -> f64 {
        let count = (time - self.delay) / self.period;
        (count + SAME_TICK.max(4.0 * f64::EPSILON * count.abs())).floor() + 1.0
    }

    /// Whether its multiple `count` has come at a time.
    fn has_come(&self, count: f64, time: f64) -> bool {
        self.after(time) > count
    }
}

impl Held {
    /// Puts states that jump in the place of all that a model holds, behind its own states; inner ones first.
    pub(crate) fn replace(model: &mut Model) -> Vec<Held> {
        let of_impacts = model.impacts.iter().flat_map(|of| {
            [of.gap, of.restitution].into_iter().chain(of.direction.iter().map(|&(_, by)| by))
        });
        let roots: Vec<Id> = model.rates.iter().chain(&model.outputs).copied().chain(of_impacts).collect();
        let (mut all, mut with) = (Vec::new(), HashMap::new());
        for id in model.graph.reachable(&roots) {
            let Node::Binary(Binary::Hold, of, timing) = model.graph.node(id) else { continue };
            let (period, delay) = match model.graph.node(timing) {
                Node::Binary(Binary::Timing, period, delay) => (period, model.graph.value(delay)),
                _ => (timing, Some(0.0)),
            };
            let of = model.graph.replace(&[of], &with)[0];
            // A period that is no number comes from no spec: it is held for ever.
            let period = model.graph.value(period).filter(|period| *period > 0.0).unwrap_or(f64::INFINITY);
            let delay = delay.unwrap_or(0.0);
            let mut state = || {
                let symbol = model.names.intern(&format!("held {}", model.states.len()));
                model.states.push(model.graph.symbol(symbol));
                model.rates.push(model.graph.constant(0.0));
                model.states.len() - 1
            };
            let current = state();
            let waiting = (delay > 0.0).then(state);
            with.insert(id, model.states[current]);
            all.push(Held { of, current, waiting, period, delay });
        }
        if !all.is_empty() {
            model.rates = model.graph.replace(&model.rates, &with);
            model.outputs = model.graph.replace(&model.outputs, &with);
            model.replace_in_impacts(&with);
        }
        all
    }

    /// The resets that it takes: the state that jumps, and where to.
    pub(crate) fn resets(&self, states: &[Id]) -> impl Iterator<Item = (usize, Id)> {
        let sampled = (self.waiting.unwrap_or(self.current), self.of);
        [Some(sampled), self.waiting.map(|waiting| (self.current, states[waiting]))].into_iter().flatten()
    }

    /// When these happen; the first of them is this one of the automaton's.
    pub(crate) fn ticks(&self, first: usize) -> impl Iterator<Item = Tick> {
        let tick = |reset: usize, delay: f64| Tick { reset, period: self.period, delay };
        let later = self.waiting.map(|_| tick(first + 1, self.delay));
        [Some(tick(first, 0.0)), later].into_iter().flatten()
    }
}

impl Run<'_> {
    /// Sets what is held at the start of the run, and when it jumps.
    pub(crate) fn begin_holding(&mut self) {
        let automaton = self.field.automaton;
        self.counts = automaton.ticks.iter().map(|tick| tick.after(self.field.origin)).collect();
        // Inner ones first: what is held may be a part of what is held.
        for tick in &automaton.ticks {
            self.apply(&[tick.reset], &[], 1.0);
        }
        for (scale, x) in self.scale.iter_mut().zip(&self.x).skip(self.own) {
            *scale = if *x != 0.0 && x.is_finite() { x.abs() } else { 1.0 };
        }
    }

    /// The next time at which something that is held jumps, from the start on.
    pub(crate) fn next_tick(&self) -> f64 {
        let ticks = self.field.automaton.ticks.iter().zip(&self.counts);
        ticks.map(|(tick, count)| tick.time(*count) - self.field.origin).fold(f64::INFINITY, f64::min)
    }

    /// Whether something that is held jumps at a time.
    pub(crate) fn ticks_at(&self, t: f64) -> bool {
        let ticks = self.field.automaton.ticks.iter().zip(&self.counts);
        ticks.into_iter().any(|(tick, count)| tick.has_come(*count, self.field.origin + t))
    }

    /// Lets all that is held and due at the present point jump, from the values before.
    pub(crate) fn pass_ticks(&mut self) {
        if !self.ticks_at(self.t) {
            return;
        }
        let (time, ticks) = (self.time(), &self.field.automaton.ticks);
        let due = |&k: &usize| ticks[k].has_come(self.counts[k], time);
        let due: Vec<usize> = (0..ticks.len()).filter(due).collect();
        let resets: Vec<usize> = due.iter().map(|&k| ticks[k].reset).collect();
        self.apply(&resets, &[], 1.0);
        due.into_iter().for_each(|k| self.counts[k] += 1.0);
        self.decide_again();
        self.sample_here();
    }
}
