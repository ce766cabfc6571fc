//! The simulation: adaptive steps from event to event, and the samples within them.

use crate::automaton::Automaton;
use crate::decisions::{
    NEWTON_SHORTENING, ON_SURFACE, SHORTEST_STEP, STEP_GROWTH, STEP_REDUCTION, STEP_REMAINDER,
};
use crate::events::Search;
use crate::field::Field;
use crate::observer::Observer;
use crate::state::Run;
use crate::step::Method;
use crate::trajectory::{Drive, Options, SimError, Trajectory};

/// Runs the automaton from `start` at time `t0` and samples it at `times` (not decreasing). A time before
/// `t0`, which a delayed sensor requires, is extrapolated with the rates at `t0`.
///
/// # Errors
/// See [`SimError`]: a state or rate is not finite, a state diverges, or the modes change without end.
///
/// # Panics
/// If `start`, `drive` or `options` have the wrong length, or a time is not finite.
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
    assert!(t0.is_finite() && times.iter().all(|t| t.is_finite()), "finite times");
    finished(Run::new(automaton, drive, t0, start, times, options))
}

/// As [`simulate`], with an observer that sees each sample and may correct the state there: steps end at the
/// samples.
///
/// # Errors
/// As [`simulate`].
///
/// # Panics
/// As [`simulate`].
///
/// ```
/// use phisindy_phys::Model;
/// use phisindy_sim::{Automaton, Drive, Observer, Options, Shown, observe};
/// /// Reads 1 at every sample, and believes half of it.
/// struct Half;
/// impl Observer for Half {
///     fn correct(&mut self, _: usize, _: &Shown<'_>, x: &mut [f64], _: &mut [f64]) -> bool {
///         x[0] += 0.5 * (1.0 - x[0]);
///         true
///     }
/// }
/// let model = Model::build(&["x"], &[], &[], &["0"]).unwrap();
/// let automaton = Automaton::new(&model).unwrap();
/// let drive = Drive { inputs: &[], parameters: &[] };
/// let run = observe(&automaton, &drive, (0.0, &[0.0]), &[1.0, 2.0, 3.0], &Options::default(), &mut Half).unwrap();
/// // A sample shows the state before it is corrected.
/// assert_eq!(run.states, [0.0, 0.5, 0.75]);
/// ```
pub fn observe(
    automaton: &Automaton,
    drive: &Drive<'_>,
    (t0, start): (f64, &[f64]),
    times: &[f64],
    options: &Options,
    observer: &mut dyn Observer,
) -> Result<Trajectory, SimError> {
    let mut run = Run::new(automaton, drive, t0, start, times, options);
    run.observer = Some(observer);
    finished(run)
}

/// The speed of a contact at a state of this `scale`, 0 within rounding, and the nearest state at which it rests.
///
/// ```
/// use phisindy_phys::Model;
/// use phisindy_sim::{Automaton, Drive, at_rest};
/// let model = Model::build(&["x", "v"], &[], &["mu"], &["v", "-x - mu*sgn(v)"]).unwrap();
/// let (automaton, drive) = (Automaton::new(&model).unwrap(), Drive { inputs: &[], parameters: &[0.3] });
/// assert_eq!(at_rest(&automaton, &drive, (0.0, &[0.2, 0.01]), 0, &[1.0, 1.0]), (0.01, vec![0.2, 0.0]));
/// ```
///
/// # Panics
/// The model has no such contact.
pub fn at_rest(
    automaton: &Automaton,
    drive: &Drive<'_>,
    (time, x): (f64, &[f64]),
    contact: usize,
    scale: &[f64],
) -> (f64, Vec<f64>) {
    let mut still: Vec<f64> = x.iter().copied().chain(std::iter::repeat(0.0)).take(automaton.width).collect();
    let mut field = Field::new(automaton, drive, time, Options::default().tolerance);
    field.surfaces(0.0, &still);
    let speed = field.w(contact);
    let size: f64 = scale.iter().enumerate().map(|(j, s)| (field.normal(contact, j) * s).abs()).sum();
    field.project(contact, &mut still);
    still.truncate(x.len());
    (if speed.abs() > ON_SURFACE * size { speed } else { 0.0 }, still)
}

/// Runs to the last sample.
fn finished(mut run: Run<'_>) -> Result<Trajectory, SimError> {
    run.begin();
    run.sample_here();
    while run.next < run.times.len() {
        run.step()?;
    }
    run.out.evaluations = run.field.evaluations;
    run.out.factorisations = run.step.factorisations();
    Ok(run.out)
}

impl Run<'_> {
    /// Sets the modes, the rates and the first step length at the start.
    fn begin(&mut self) {
        self.field.left_of = self.breakpoints.last().copied();
        self.begin_holding();
        self.field.begin(self.t, &self.x, &self.scale);
        self.field.rates(self.t, &self.x, &mut self.rates);
        self.begin_at_rest();
        self.begin_gaps();
        self.here.evaluate(&mut self.field, self.t, &self.x);
        self.h = self.first_step();
    }

    /// Writes the samples up to the present point, along the present rates.
    pub(crate) fn sample_here(&mut self) {
        let n = self.own;
        while self.next < self.times.len() && self.times[self.next] <= self.t {
            let back = self.times[self.next] - self.t;
            self.out.states.extend(self.x[..n].iter().zip(&self.rates).map(|(x, f)| x + back * f));
            self.out.rates.extend(&self.rates[..n]);
            if let Some(s) = &mut self.sensitivity {
                s.sample_along(&mut self.field, self.t, &self.x, back, &mut self.sampled);
                self.out.sensitivities.extend(&self.sampled[..n * s.m]);
            }
            let (x, rates) = (self.x.clone(), self.rates[..self.x.len()].to_vec());
            self.sample_outputs(self.t, &x, &rates, back);
            self.out.modes.extend((0..self.field.frictions()).map(|c| self.field.sign(c)));
            self.next += 1;
            self.let_correct();
        }
    }

    /// Makes one accepted step: up to its planned end, the next breakpoint of an input, or the first event
    /// in it.
    fn step(&mut self) -> Result<(), SimError> {
        let end = self.times[self.times.len() - 1];
        let end = if self.observer.is_some() { self.times[self.next] } else { end };
        let target = self.breakpoints.last().map_or(end, |b| (b - self.field.origin).min(end));
        let target = target.min(self.next_tick());
        let tiny = SHORTEST_STEP * self.t.abs().max(end.abs()).max(self.span);
        self.step.start(self.t, &self.x, &self.rates);
        self.measure();
        loop {
            if self.options.stop.aborts() {
                return Err(SimError::Stopped { time: self.time() });
            }
            if self.out.steps + self.out.rejected > self.options.max_steps {
                return Err(SimError::TooManySteps { time: self.time() });
            }
            let mut h = self.h.min(self.longest);
            h = h.min(self.speed_limit());
            if target - self.t - h < STEP_REMAINDER * h {
                h = target - self.t;
            }
            if self.attempt(h)? {
                self.let_correct();
                return Ok(());
            }
            self.out.rejected += 1;
            if self.h <= tiny {
                return Err(self.collapsed());
            }
        }
    }

    /// Tries a step of length `h`; returns whether it, or the part of it up to an event, was accepted.
    /// Otherwise the length of the next trial is set.
    fn attempt(&mut self, h: f64) -> Result<bool, SimError> {
        if !self.step.advance(h, &self.allowed, &mut self.field) {
            self.h = NEWTON_SHORTENING * h;
            return Ok(false);
        }
        self.there.evaluate(&mut self.field, self.t + h, self.step.end());
        let error = self.error();
        if error > 1.0 {
            self.refuse(h, error);
            return Ok(false);
        }
        if let Some(shorter) = self.shape_limit() {
            self.h = shorter;
            return Ok(false);
        }
        match self.first_event() {
            Search::None => {
                let growth = if error > 0.0 { self.rescale(error, STEP_GROWTH) } else { STEP_GROWTH[1] };
                // A step that a breakpoint shortens is no reason to shorten the next one.
                self.h = (h * growth).max(if h < self.h { self.h } else { 0.0 });
                self.accept();
                self.pass_breakpoint();
                self.pass_ticks();
                self.check().map(|()| true)
            }
            Search::At(event, theta) => {
                if theta > 0.0 {
                    if !self.locate(event, theta) {
                        self.h = NEWTON_SHORTENING * h;
                        return Ok(false);
                    }
                    self.accept();
                    self.check()?;
                }
                let known = self.out.events.len();
                self.pass(event)?;
                self.pass_breakpoint();
                self.pass_ticks();
                // At a kink alone the rates go on as they came.
                let kinks = self.field.switches()..self.field.gap(0);
                let alone = kinks.contains(&event) && self.out.events.len() == known;
                self.h = if alone { h } else { self.first_step() };
                Ok(true)
            }
            Search::Shorter => {
                self.h = 0.5 * h;
                Ok(false)
            }
        }
    }

    /// Shortens a step with too large an error.
    fn refuse(&mut self, h: f64, error: f64) {
        let shrink = if error.is_finite() { self.rescale(error, STEP_REDUCTION) } else { STEP_REDUCTION[0] };
        self.h = h * shrink;
        if let Some(reach) = self.time_to_surface() {
            // Friction with a steep shape near zero speed spoils a step across zero: stop short of it first.
            self.h = self.h.max(0.5 * h.min(reach)).min(0.9 * h);
        }
    }

    fn collapsed(&self) -> SimError {
        let n = self.x.len();
        let bad = |k: &[f64]| (0..n).find(|&i| !k[i].is_finite());
        match bad(&self.rates).or_else(|| self.step.k.iter().find_map(|k| bad(k))) {
            Some(i) => {
                let states = &self.field.automaton.states;
                let state = states.get(i).map_or_else(|| "hold".to_owned(), String::clone);
                SimError::NotFinite { time: self.time(), state }
            }
            None => SimError::TooManySteps { time: self.time() },
        }
    }

    /// Accepts the step: samples within it, sensitivities, and the new present point.
    fn accept(&mut self) {
        if let Some(s) = &mut self.sensitivity {
            s.advance(&mut self.field, &mut self.step);
        }
        let (t1, h) = (self.t + self.step.h, self.step.h);
        let from = self.next;
        // What jumps at the end of the step shows there what it has become.
        let jumps = self.ticks_at(t1);
        let within = |time: f64| time < t1 || (time == t1 && !jumps);
        while self.next < self.times.len() && within(self.times[self.next]) {
            if let Some(s) = self.sensitivity.as_mut().filter(|_| self.next == from) {
                s.interpolate(&self.step);
            }
            self.sample((self.times[self.next] - self.t) / h);
        }
        self.t = t1;
        self.x.copy_from_slice(self.step.end());
        self.rates.copy_from_slice(self.step.end_rates());
        self.out.steps += 1;
        self.out.implicit += usize::from(self.step.method() == Method::Implicit);
        self.step.accept();
        self.choose_method();
        std::mem::swap(&mut self.here, &mut self.there);
        self.field.note_speeds(&self.here.w);
        self.field.keep_at_rest(self.t, &mut self.x);
    }

    /// Writes the next sample, at the fraction `theta` of the step just made.
    fn sample(&mut self, theta: f64) {
        let (n, own) = (self.x.len(), self.own);
        let mut x = std::mem::take(&mut self.buffer);
        let mut rates = std::mem::take(&mut self.slopes);
        x.truncate(n);
        let dense = self.step.dense();
        dense.value(theta, &mut x);
        dense.slope(theta, &mut rates);
        self.field.keep_at_rest(self.times[self.next], &mut x);
        self.out.states.extend(&x[..own]);
        self.out.rates.extend(&rates[..own]);
        if let Some(s) = &self.sensitivity {
            s.sample(theta, &mut self.sampled);
            self.out.sensitivities.extend(&self.sampled[..own * s.m]);
        }
        if self.field.automaton.outputs > 0 {
            self.sample_outputs(self.times[self.next], &x, &rates, 0.0);
        }
        self.out.modes.extend((0..self.field.frictions()).map(|c| self.field.sign(c)));
        self.next += 1;
        x.resize(n + self.field.switches(), 0.0);
        (self.buffer, self.slopes) = (x, rates);
    }

    fn check(&self) -> Result<(), SimError> {
        let reach = if self.options.reach.is_empty() { &self.scale } else { &self.options.reach };
        let fits = |i: usize| self.x[i].abs() <= self.options.diverged * reach[i];
        match (0..self.own).find(|&i| !fits(i)) {
            Some(i) => {
                Err(SimError::Diverged { time: self.time(), state: self.field.automaton.states[i].clone() })
            }
            None => Ok(()),
        }
    }

    /// Continues after a breakpoint of an input, if the present point is one.
    fn pass_breakpoint(&mut self) {
        let (origin, t) = (self.field.origin, self.t);
        let ahead = self.breakpoints.partition_point(|&b| b - origin > t);
        let passed = self.breakpoints.split_off(ahead);
        let Some(&last) = passed.first() else { return };
        self.field.right_of = last;
        self.pass_moving_steps(&passed);
        self.field.left_of = self.breakpoints.last().copied();
        self.decide_again();
    }

    /// A step of a held input is an event whose time hangs on parameters alone: the derivatives jump by what the rates
    /// jump there (saltation). Of several steps at one instant each has parameters of its own, so one is passed after
    /// the other; what modes there are with so many of them is decided from those before, as for all together.
    fn pass_moving_steps(&mut self, passed: &[f64]) {
        if self.options.moving.is_empty() {
            return;
        }
        let (options, drive) = (self.options, self.field.drive);
        let (n, modes, stuck) = (self.x.len(), self.field.modes.clone(), self.field.stuck.clone());
        for (input, signal) in drive.inputs.iter().enumerate() {
            let Some(s) = self.sensitivity.as_ref() else { return };
            let own = options.moving.iter().filter(|moving| moving.input == input);
            let mut moves = vec![0.0; s.m];
            own.for_each(|moving| {
                let place = s.free.iter().position(|&k| k == moving.parameter);
                place.into_iter().for_each(|k| moves[s.column_of_free(k)] += moving.by.value(self.time()));
            });
            let steps = |&at: &f64| signal.value(at.next_down()) != signal.value(at);
            if !passed.iter().any(steps) {
                continue;
            }
            let (old, shown) = (self.rates.clone(), self.shown());
            self.field.stepped[input] = true;
            self.field.modes.copy_from_slice(&modes);
            self.field.stuck.copy_from_slice(&stuck);
            self.field.reconsider(self.t, &self.x);
            self.field.rates(self.t, &self.x, &mut self.rates);
            if let Some(s) = &mut self.sensitivity {
                s.jump(&moves, &old[..n], &self.rates[..n]);
            }
            self.note_jump(&shown, moves);
        }
        self.field.stepped.fill(false);
        (self.field.modes, self.field.stuck) = (modes, stuck);
    }

    /// Goes on from a point to which the input or the state has jumped.
    pub(crate) fn decide_again(&mut self) {
        let before = self.field.signs();
        self.decide_modes(&before);
        self.strike_closing();
    }

    fn decide_modes(&mut self, before: &[i8]) {
        self.field.reconsider(self.t, &self.x);
        self.record(before);
        self.field.rates(self.t, &self.x, &mut self.rates);
        self.here.evaluate(&mut self.field, self.t, &self.x);
        if let Some(s) = &mut self.sensitivity {
            s.restart();
        }
    }
}
