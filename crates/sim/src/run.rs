//! The simulation: adaptive steps, located events, samples.

use crate::automaton::Automaton;
use crate::dopri::Step;
use crate::field::Field;
use crate::sensitivity::Sensitivity;
use phisindy_phys::Signal;
use std::fmt;

/// What drives a run: inputs as functions of time, and numbers for the parameters.
#[derive(Clone, Copy, Debug)]
pub struct Drive<'a> {
    /// One signal for each input of the model.
    pub inputs: &'a [Signal],
    /// One number for each parameter of the model.
    pub parameters: &'a [f64],
}

/// How a run is made.
#[derive(Clone, Debug)]
pub struct Options {
    /// Local error of a step, relative to the size of each state.
    pub tolerance: f64,
    /// The smallest size of each state that matters; empty means 1 for all.
    pub scale: Vec<f64>,
    /// Parameters to differentiate by; `None` for no sensitivities at all.
    pub sensitivities: Option<Vec<usize>>,
    /// Gives up after this many steps.
    pub max_steps: usize,
    /// A state beyond this many times its scale has diverged.
    pub diverged: f64,
}

impl Default for Options {
    fn default() -> Self {
        Options { tolerance: 1e-8, scale: vec![], sensitivities: None, max_steps: 2_000_000, diverged: 1e9 }
    }
}

/// A change of mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// When.
    pub time: f64,
    /// Which switch.
    pub switch: usize,
    /// Mode before: +1, -1, or 0 for sticking.
    pub from: i8,
    /// Mode after.
    pub to: i8,
}

/// A sampled run.
#[derive(Clone, Debug, Default)]
pub struct Trajectory {
    /// Number of states.
    pub n: usize,
    /// Columns of the sensitivities: start states, then the free parameters; 0 if not asked for.
    pub m: usize,
    /// States, row-major samples x n.
    pub states: Vec<f64>,
    /// Rates, row-major samples x n.
    pub rates: Vec<f64>,
    /// d state / d (start, parameter), row-major samples x n x m.
    pub sensitivities: Vec<f64>,
    /// Mode of each switch, row-major samples x switches.
    pub modes: Vec<i8>,
    /// All changes of mode.
    pub events: Vec<Event>,
    /// Steps that were accepted.
    pub steps: usize,
    /// Steps that were tried again with a shorter length.
    pub rejected: usize,
    /// Evaluations of the rates.
    pub evaluations: usize,
}

impl Trajectory {
    /// One state as a column.
    pub fn column(&self, state: usize) -> Vec<f64> {
        self.states.iter().skip(state).step_by(self.n.max(1)).copied().collect()
    }
}

/// Why a run ended early.
#[derive(Clone, Debug, PartialEq)]
pub enum SimError {
    /// A rate is not a number, however short the step.
    NotFinite {
        /// When.
        time: f64,
        /// Which state.
        state: String,
    },
    /// A state grew beyond all bounds.
    Diverged {
        /// When.
        time: f64,
        /// Which state.
        state: String,
    },
    /// More steps than allowed.
    TooManySteps {
        /// How far it came.
        time: f64,
    },
    /// Changes of mode without end at one instant.
    TooManyEvents {
        /// When.
        time: f64,
        /// The switch that flutters.
        switch: String,
    },
}

impl fmt::Display for SimError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SimError::NotFinite { time, state } => write!(f, "the rate of `{state}` is not finite at t = {time:.6}"),
            SimError::Diverged { time, state } => write!(f, "`{state}` grows without bound at t = {time:.6}"),
            SimError::TooManySteps { time } => write!(f, "the step length collapsed at t = {time:.6}"),
            SimError::TooManyEvents { time, switch } => {
                write!(f, "`{switch}` changes sign without end at t = {time:.6}")
            }
        }
    }
}

impl std::error::Error for SimError {}

/// Runs the automaton from `start` at time `t0` and samples it at `times` (not decreasing; a time before `t0`, as a delayed sensor asks for, is
/// extrapolated along the rates at `t0`).
///
/// # Errors
/// See [`SimError`]: the numbers blew up, or the modes fluttered without end.
///
/// # Panics
/// If `start`, `drive` or `options` do not fit the automaton.
///
/// ```
/// use phisindy_phys::Model;
/// use phisindy_sim::{Automaton, Drive, Options, simulate};
/// // A block thrown along a rough table stops after v0 / mu and stays.
/// let model = Model::build(&["x", "v"], &[], &["mu"], &["v", "-mu*sgn(v)"]).unwrap();
/// let automaton = Automaton::new(&model).unwrap();
/// let drive = Drive { inputs: &[], parameters: &[2.0] };
/// let run = simulate(&automaton, &drive, 0.0, &[0.0, 3.0], &[0.0, 1.0, 5.0], &Options::default()).unwrap();
/// assert!((run.states[4] - 2.25).abs() < 1e-12 && run.states[5] == 0.0);
/// assert!((run.events[0].time - 1.5).abs() < 1e-12);
/// ```
pub fn simulate(
    automaton: &Automaton,
    drive: &Drive<'_>,
    t0: f64,
    start: &[f64],
    times: &[f64],
    options: &Options,
) -> Result<Trajectory, SimError> {
    assert_eq!(start.len(), automaton.states.len(), "one start value for each state");
    assert_eq!(drive.inputs.len(), automaton.inputs, "one signal for each input");
    assert_eq!(drive.parameters.len(), automaton.parameters, "one number for each parameter");
    let mut run = Run::new(automaton, drive, t0, start, times, options);
    run.begin();
    run.sample_before_start();
    while run.next < times.len() {
        run.step()?;
    }
    run.out.evaluations = run.field.evaluations;
    Ok(run.out)
}

struct Run<'a> {
    field: Field<'a>,
    times: &'a [f64],
    options: &'a Options,
    scale: Vec<f64>,
    t: f64,
    x: Vec<f64>,
    /// Rates at the present point.
    rates: Vec<f64>,
    step: Step,
    h: f64,
    sensitivity: Option<Sensitivity>,
    out: Trajectory,
    /// The next sample to write.
    next: usize,
    /// Events since time last moved on.
    stalled: usize,
    buffer: Vec<f64>,
}

impl<'a> Run<'a> {
    fn new(a: &'a Automaton, drive: &'a Drive<'a>, t0: f64, start: &[f64], times: &'a [f64], options: &'a Options) -> Self {
        let n = start.len();
        let sensitivity = options.sensitivities.as_ref().map(|free| Sensitivity::new(n, free));
        let m = sensitivity.as_ref().map_or(0, |s| s.m);
        let scale = if options.scale.is_empty() { vec![1.0; n] } else { options.scale.clone() };
        assert_eq!(scale.len(), n, "one scale for each state");
        let mut out = Trajectory { n, m, ..Default::default() };
        out.states.reserve(times.len() * n);
        out.sensitivities.reserve(times.len() * n * m);
        Run {
            field: Field::new(a, drive, sensitivity.is_some()),
            times,
            options,
            scale,
            t: t0,
            x: start.to_vec(),
            rates: vec![0.0; n],
            step: Step::new(n),
            h: 0.0,
            sensitivity,
            out,
            next: 0,
            stalled: 0,
            buffer: vec![0.0; n * m.max(1)],
        }
    }

    /// Modes at the start: the sign of `w`, or the contact rule where it is zero.
    fn begin(&mut self) {
        self.field.surfaces(self.t, &self.x);
        let mut on = Vec::new();
        for c in 0..self.field.switches() {
            let w = self.field.w(c);
            self.field.speed[c] = w.abs();
            if w == 0.0 {
                on.push(c);
            } else {
                self.field.modes[c] = w.signum();
            }
        }
        if !on.is_empty() {
            self.field.resolve(&on, 0.0, self.t, &self.x);
        }
        self.field.rates(self.t, &self.x, &mut self.rates);
        self.h = self.first_step();
    }

    /// Hairer's guess of a step length (Solving ODEs I, II.4), from the size and the change of the rates.
    fn first_step(&mut self) -> f64 {
        let norm = |v: &[f64], scale: &[f64]| v.iter().zip(scale).map(|(v, s)| (v / s).abs()).fold(0.0, f64::max);
        let span = self.times.last().map_or(0.0, |t| t - self.t).max(f64::MIN_POSITIVE);
        let d1 = norm(&self.rates, &self.scale);
        let h0 = if d1 > 1e-10 { (1e-3 / d1).min(span) } else { 1e-3 * span };
        let moved: Vec<f64> = self.x.iter().zip(&self.rates).map(|(x, f)| x + h0 * f).collect();
        let mut later = vec![0.0; self.x.len()];
        self.field.rates(self.t + h0, &moved, &mut later);
        let change: Vec<f64> = later.iter().zip(&self.rates).map(|(a, b)| (a - b) / h0).collect();
        let d2 = norm(&change, &self.scale);
        let largest = d1.max(d2);
        let h1 = if largest > 1e-15 { (0.01 * self.options.tolerance.powf(0.2) * 10.0 / largest).sqrt() } else { h0 };
        h1.min(100.0 * h0).min(span)
    }

    fn sample_before_start(&mut self) {
        while self.next < self.times.len() && self.times[self.next] <= self.t {
            let back = self.times[self.next] - self.t;
            for (x, f) in self.x.iter().zip(&self.rates) {
                self.out.states.push(x + back * f);
            }
            self.out.rates.extend(&self.rates);
            if let Some(s) = &self.sensitivity {
                self.out.sensitivities.extend(&s.s);
            }
            self.push_modes();
            self.next += 1;
        }
    }

    fn push_modes(&mut self) {
        for c in 0..self.field.switches() {
            let mode = if self.field.stuck[c] { 0 } else { self.field.modes[c] as i8 };
            self.out.modes.push(mode);
        }
    }

    /// One accepted step, up to its end or to the first event in it.
    fn step(&mut self) -> Result<(), SimError> {
        let end = self.times[self.times.len() - 1];
        let tiny = 1e-15 * self.t.abs().max(end.abs()).max(end - self.t);
        self.step.start(self.t, &self.x, &self.rates);
        loop {
            if self.out.steps + self.out.rejected > self.options.max_steps {
                return Err(SimError::TooManySteps { time: self.t });
            }
            let mut h = self.h.min(end - self.t);
            if self.field.stuck.contains(&true) {
                h = h.min(self.sticking_limit());
            }
            if end - self.t - h < 1e-3 * h {
                h = end - self.t;
            }
            self.step.advance(h, |t, x, out| self.field.rates(t, x, out));
            let error = self.step.error(self.options.tolerance, &self.scale);
            if error <= 1.0 {
                let growth = if error > 0.0 { (0.9 * error.powf(-0.2)).clamp(0.2, 5.0) } else { 5.0 };
                match self.first_event(h) {
                    Search::None => {
                        self.h = h * growth;
                        self.accept();
                        return self.check();
                    }
                    Search::At(event, theta) => {
                        self.locate(event, theta, h);
                        self.accept();
                        self.check()?;
                        return self.pass(event);
                    }
                    Search::Shorter => {
                        self.out.rejected += 1;
                        self.h = 0.5 * h;
                    }
                }
            } else {
                self.out.rejected += 1;
                let shrink = if error.is_finite() { (0.9 * error.powf(-0.2)).clamp(0.1, 0.9) } else { 0.1 };
                self.h = h * shrink;
                if let Some(reach) = self.overshoot() {
                    // Friction with a steep shape near zero speed spoils a step across zero: come close first.
                    self.h = self.h.max(0.5 * h.min(reach)).min(0.9 * h);
                }
            }
            if self.h <= tiny {
                let bad = (0..self.x.len()).find(|&i| !self.step.k[1][i].is_finite()).or((0..self.x.len()).find(|&i| !self.rates[i].is_finite()));
                return Err(match bad {
                    Some(i) => SimError::NotFinite { time: self.t, state: self.field.automaton.states[i].clone() },
                    None => SimError::TooManySteps { time: self.t },
                });
            }
        }
    }

    /// While something sticks and nothing moves the error estimate sees nothing: keep the step within what the samples resolve.
    fn sticking_limit(&self) -> f64 {
        let span = self.times[self.times.len() - 1] - self.times[0];
        (16.0 * span / (self.times.len().max(2) - 1) as f64).max(span / 1000.0)
    }

    /// If the failed step ends across a slipping contact's surface: the time to reach it in a straight line.
    fn overshoot(&mut self) -> Option<f64> {
        let c = self.field.switches();
        self.field.surfaces(self.t + self.step.h, self.step.end());
        let crossed: Vec<usize> = (0..c).filter(|&k| !self.field.stuck[k] && self.field.modes[k] * self.field.w(k) < 0.0).collect();
        if crossed.is_empty() {
            return None;
        }
        self.field.surfaces(self.t, &self.x);
        crossed.iter().map(|&k| -self.field.w(k) / self.field.w_rate(k)).filter(|r| *r > 0.0).reduce(f64::min)
    }

    /// The guard of a switch at a point: positive while its mode may last.
    fn guard(&mut self, c: usize, t: f64, x: &[f64]) -> f64 {
        if self.field.stuck[c] {
            self.field.hold(t, x);
            self.field.reserve(c)
        } else {
            self.field.surfaces(t, x);
            self.field.modes[c] * self.field.w(c)
        }
    }

    fn guard_inside(&mut self, c: usize, theta: f64) -> f64 {
        let mut x = std::mem::take(&mut self.buffer);
        let n = self.x.len();
        self.step.dense(theta, &mut x[..n]);
        let g = self.guard(c, self.t + theta * self.step.h, &x[..n]);
        self.buffer = x;
        g
    }

    /// The first guard that fails within the step, and the fraction of the step at which it does.
    fn first_event(&mut self, h: f64) -> Search {
        let mut first: Option<(usize, f64)> = None;
        for c in 0..self.field.switches() {
            let Some(bad) = self.failing_fraction(c, h) else { continue };
            // The guard may start at zero (a contact that has just let go): then look for where it was positive.
            let mut good = 0.0;
            if self.guard_inside(c, 0.0) <= 0.0 {
                let inside = [0.5, 0.25, 0.75, 0.125, 0.03, 0.005].iter().map(|f| f * bad).find(|&f| self.guard_inside(c, f) > 0.0);
                match inside {
                    Some(f) => good = f,
                    // It returns at once: only a shorter step can tell.
                    None if h > 1e-9 * self.scale_of_time() => return Search::Shorter,
                    None => good = bad,
                }
            }
            let theta = if good < bad { illinois(good, bad, |f| self.guard_inside(c, f)) } else { bad };
            if first.is_none_or(|(_, f)| theta < f) {
                first = Some((c, theta));
            }
        }
        first.map_or(Search::None, |(c, theta)| Search::At(c, theta))
    }

    fn scale_of_time(&self) -> f64 {
        (self.times[self.times.len() - 1] - self.times[0]).max(f64::MIN_POSITIVE)
    }

    /// A fraction of the step at which the guard of `c` is negative, if there is one.
    fn failing_fraction(&mut self, c: usize, h: f64) -> Option<f64> {
        if self.field.stuck[c] {
            return [1.0 / 3.0, 2.0 / 3.0, 1.0].into_iter().find(|&f| self.guard_inside(c, f) < 0.0);
        }
        let end = self.step.end().to_vec();
        if self.guard(c, self.t + h, &end) < 0.0 {
            return Some(1.0);
        }
        // It may dip below zero and come back: then its rate changes sign from minus to plus.
        let late = self.field.modes[c] * self.field.w_rate(c);
        self.field.surfaces(self.t, &self.x);
        let early = self.field.modes[c] * self.field.w_rate(c);
        if !(early < 0.0 && late > 0.0) {
            return None;
        }
        let mut slope = |theta: f64| {
            self.guard_inside(c, theta);
            -self.field.modes[c] * self.field.w_rate(c)
        };
        let lowest = illinois(0.0, 1.0, &mut slope);
        (self.guard_inside(c, lowest) < 0.0).then_some(lowest)
    }

    /// Repeats the step so that it ends on the surface: Newton's method on its length, from the root of the dense output.
    fn locate(&mut self, c: usize, theta: f64, h: f64) {
        let delta = 1e-4_f64.min(theta).max(1e-9);
        let slope = (self.guard_inside(c, theta + delta) - self.guard_inside(c, theta - delta)) / (2.0 * delta * h);
        let mut length = theta * h;
        for _ in 0..4 {
            self.step.advance(length, |t, x, out| self.field.rates(t, x, out));
            let end = self.step.end().to_vec();
            let g = self.guard(c, self.t + length, &end);
            let size = if self.field.stuck[c] { 1.0 } else { self.field.speed[c].max(f64::MIN_POSITIVE) };
            let change = -g / slope;
            if g.abs() <= 4e-16 * size || !change.is_finite() || change.abs() > 0.1 * h || length + change <= 0.0 {
                break;
            }
            length += change;
        }
    }

    /// Takes the step: samples within it, sensitivities along it, and the new present point.
    fn accept(&mut self) {
        let n = self.x.len();
        if let Some(s) = &mut self.sensitivity {
            s.advance(&mut self.field, &self.step);
        }
        let (t1, h) = (self.t + self.step.h, self.step.h);
        while self.next < self.times.len() && self.times[self.next] <= t1 {
            let theta = if h > 0.0 { (self.times[self.next] - self.t) / h } else { 1.0 };
            self.step.dense(theta, &mut self.buffer[..n]);
            self.out.states.extend(&self.buffer[..n]);
            // The rates of the dense output, by its difference over a small part of the step; modes do not change inside.
            let x = self.buffer[..n].to_vec();
            self.field.rates(self.times[self.next], &x, &mut self.buffer[..n]);
            self.out.rates.extend(&self.buffer[..n]);
            if let Some(s) = &self.sensitivity {
                s.dense(theta, h, &mut self.buffer[..n * s.m]);
                self.out.sensitivities.extend(&self.buffer[..n * s.m]);
            }
            self.push_modes();
            self.next += 1;
        }
        self.stalled = if h > 1e-12 * self.scale_of_time() { 0 } else { self.stalled };
        self.t = t1;
        self.x.copy_from_slice(self.step.end());
        self.rates.copy_from_slice(&self.step.k[crate::dopri::STAGES - 1]);
        self.out.steps += 1;
        self.field.surfaces(self.t, &self.x);
        for c in 0..self.field.switches() {
            self.field.speed[c] = self.field.speed[c].max(self.field.w(c).abs());
        }
    }

    fn check(&self) -> Result<(), SimError> {
        match (0..self.x.len()).find(|&i| !(self.x[i].abs() <= self.options.diverged * self.scale[i])) {
            Some(i) => Err(SimError::Diverged { time: self.t, state: self.field.automaton.states[i].clone() }),
            None => Ok(()),
        }
    }

    /// Passes the event at the present point: new modes, jump of the sensitivities, and whatever else is due at the same instant.
    fn pass(&mut self, first: usize) -> Result<(), SimError> {
        let mut due = Some(first);
        let mut done = Vec::new();
        while let Some(c) = due {
            self.stalled += 1;
            if self.stalled > 200 {
                let switch = self.field.automaton.switches[c].text.clone();
                return Err(SimError::TooManyEvents { time: self.t, switch });
            }
            self.change(c);
            done.push(c);
            due = (0..self.field.switches()).find(|&k| !done.contains(&k) && self.is_due(k));
        }
        let restart = self.first_step();
        self.h = self.h.min(restart).max(1e-3 * restart);
        Ok(())
    }

    /// Whether a slipping switch stands on its surface, about to cross it.
    fn is_due(&mut self, c: usize) -> bool {
        self.field.surfaces(self.t, &self.x);
        let (s, w, rate) = (self.field.modes[c], self.field.w(c), self.field.w_rate(c));
        !self.field.stuck[c] && s * w <= 1e-13 * self.field.speed[c] && s * rate < 0.0
    }

    fn change(&mut self, c: usize) {
        let n = self.x.len();
        let modes = |f: &Field<'_>| -> Vec<i8> {
            (0..f.switches()).map(|k| if f.stuck[k] { 0 } else { f.modes[k] as i8 }).collect()
        };
        let before = modes(&self.field);
        self.field.surfaces(self.t, &self.x);
        if self.field.stuck[c] {
            self.field.hold(self.t, &self.x);
            self.field.release(c, self.t, &self.x);
            self.field.rates(self.t, &self.x, &mut self.rates);
            if let Some(s) = &mut self.sensitivity {
                s.restart();
            }
        } else {
            let (w, w_rate, came) = (self.field.w(c), self.field.w_rate(c), self.field.modes[c]);
            let normal: Vec<f64> = (0..n).map(|j| self.field.normal(c, j)).collect();
            let by_parameter = self.sensitivity.as_ref().map(|s| s.by_parameter(&mut self.field, c, self.t, &self.x));
            // Onto the surface exactly, along its normal: the step came within rounding.
            let length: f64 = normal.iter().map(|g| g * g).sum();
            if length > 0.0 {
                self.x.iter_mut().zip(&normal).for_each(|(x, g)| *x -= g * w / length);
            }
            let old = self.rates.clone();
            self.field.resolve(&[c], came, self.t, &self.x);
            self.field.rates(self.t, &self.x, &mut self.rates);
            if let (Some(s), Some(by_parameter)) = (&mut self.sensitivity, by_parameter) {
                s.jump(&normal, &by_parameter, w_rate, &old, &self.rates);
            }
        }
        for (switch, (from, to)) in before.into_iter().zip(modes(&self.field)).enumerate().filter(|(_, (a, b))| a != b) {
            self.out.events.push(Event { time: self.t, switch, from, to });
        }
    }
}

enum Search {
    None,
    At(usize, f64),
    Shorter,
}

/// The root of `g` between `good` (positive) and `bad` (negative): the Illinois variant of false position.
fn illinois(mut good: f64, mut bad: f64, mut g: impl FnMut(f64) -> f64) -> f64 {
    let (mut high, mut low) = (g(good), g(bad));
    let mut side = 0;
    for _ in 0..80 {
        let mut middle = (good * low - bad * high) / (low - high);
        if !(middle > good.min(bad) && middle < good.max(bad)) {
            middle = 0.5 * (good + bad);
        }
        let value = g(middle);
        if value == 0.0 || (bad - good).abs() <= 1e-14 {
            return middle;
        }
        if value > 0.0 {
            (good, high) = (middle, value);
            if side == 1 {
                low *= 0.5;
            }
            side = 1;
        } else {
            (bad, low) = (middle, value);
            if side == -1 {
                high *= 0.5;
            }
            side = -1;
        }
    }
    bad
}
