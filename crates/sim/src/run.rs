//! The simulation: adaptive steps from event to event, and the samples on the way.

use crate::automaton::Automaton;
use crate::dopri::{STAGES, Step};
use crate::events::Search;
use crate::field::Field;
use crate::sensitivity::Sensitivity;
use crate::trajectory::{Drive, Options, SimError, Trajectory};
use phisindy_signal::Interpolation;

/// A step spans no more samples than this, so that a burst of force on something at rest cannot be stepped over.
const SAMPLES_A_STEP: f64 = 32.0;

/// The same for knots of a spline input.
const KNOTS_A_STEP: f64 = 8.0;

/// How well a step must resolve the load of a sticking contact, in units of what it can hold: while nothing moves, nothing else limits the step.
const LOAD_RESOLUTION: f64 = 1e-3;

/// How well a step must resolve the speed of a contact whose friction has a shape near rest, relative to that speed and in units of the tolerance:
/// there speeds far below the tolerance decide how it stops and lets go, and derivatives follow the state with this relative error.
const SHAPE_RESOLUTION: f64 = 300.0;

/// Runs the automaton from `start` at time `t0` and samples it at `times` (not decreasing; a time before `t0`, as a delayed sensor asks for, is
/// extrapolated along the rates at `t0`).
///
/// # Errors
/// See [`SimError`]: the numbers blew up, or the modes fluttered without end.
///
/// # Panics
/// If `start`, `drive` or `options` do not fit the automaton, or a time is not finite.
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
    let mut run = Run::new(automaton, drive, t0, start, times, options);
    run.begin();
    run.sample_before_start();
    while run.next < times.len() {
        run.step()?;
    }
    run.out.evaluations = run.field.evaluations;
    Ok(run.out)
}

/// By how much a step may change the speed of a contact whose friction has a shape near rest, as a ratio, where that shape is felt: the derivatives of the run see the slope of the
/// friction, which is singular at rest, and not the friction, which is not.
const SPEED_RATIO: f64 = 4.0;

/// A shape is felt where friction changes within a step by this part of the acceleration.
const FELT: f64 = 1e-3;

/// `w`, `dw/dt` and `d(dw/dt)/ds` of all switches at a point.
#[derive(Default)]
pub(crate) struct Surfaces {
    pub(crate) w: Vec<f64>,
    pub(crate) rate: Vec<f64>,
    pub(crate) grip: Vec<f64>,
}

impl Surfaces {
    /// Evaluates them, with contacts that stick held at rest.
    pub(crate) fn look(&mut self, field: &mut Field<'_>, t: f64, x: &[f64]) {
        field.held_surfaces(t, x);
        self.w.clear();
        self.w.extend((0..field.switches()).map(|c| field.w(c)));
        self.rate.clear();
        self.rate.extend((0..field.switches()).map(|c| field.w_rate(c)));
        self.grip.clear();
        self.grip.extend((0..field.switches()).map(|c| field.influence(c, c)));
    }
}

pub(crate) struct Run<'a> {
    pub(crate) field: Field<'a>,
    times: &'a [f64],
    options: &'a Options,
    /// The smallest size of each state that matters.
    scale: Vec<f64>,
    pub(crate) t: f64,
    pub(crate) x: Vec<f64>,
    /// Rates at the present point, and after them the loads of the contacts that stick.
    pub(crate) rates: Vec<f64>,
    pub(crate) step: Step,
    /// The surfaces at the present point, and at the end of the step that is tried.
    pub(crate) here: Surfaces,
    pub(crate) there: Surfaces,
    /// Length of the next step to try.
    h: f64,
    /// The longest step.
    longest: f64,
    /// Contacts whose shape near rest was felt in the last step.
    paced: Vec<bool>,
    /// Length of the whole run.
    pub(crate) span: f64,
    /// Times at which an input jumps or turns a corner, in falling order: a step ends there.
    breaks: Vec<f64>,
    pub(crate) sensitivity: Option<Sensitivity>,
    pub(crate) out: Trajectory,
    /// The next sample to write.
    next: usize,
    /// Number of events since a time, to notice a flutter.
    pub(crate) flutter: (usize, f64),
    pub(crate) buffer: Vec<f64>,
}

impl<'a> Run<'a> {
    fn new(
        automaton: &'a Automaton,
        drive: &'a Drive<'a>,
        t0: f64,
        start: &[f64],
        times: &'a [f64],
        options: &'a Options,
    ) -> Self {
        let (n, c) = (start.len(), automaton.switches.len());
        let sensitivity = options.sensitivities.as_ref().map(|free| Sensitivity::new(n, free));
        let m = sensitivity.as_ref().map_or(0, |s| s.m);
        let scale = if options.scale.is_empty() { vec![1.0; n] } else { options.scale.clone() };
        assert_eq!(scale.len(), n, "one scale for each state");
        let mut out = Trajectory { n, m, ..Default::default() };
        out.states.reserve(times.len() * n);
        out.rates.reserve(times.len() * n);
        out.sensitivities.reserve(times.len() * n * m);
        let span = times.last().map_or(0.0, |end| end - t0).max(f64::MIN_POSITIVE);
        let mut longest = SAMPLES_A_STEP * span / times.len().max(1) as f64;
        for signal in drive.inputs.iter().filter(|s| s.kind() == Interpolation::Cubic) {
            let time = signal.time();
            let knots = (time.len() - 1) as f64;
            if knots > 0.0 {
                longest = longest.min(KNOTS_A_STEP * (time[time.len() - 1] - time[0]) / knots);
            }
        }
        Run {
            field: Field::new(automaton, drive, sensitivity.is_some()),
            times,
            options,
            scale,
            t: t0,
            x: start.to_vec(),
            rates: vec![0.0; n + c],
            step: Step::new(n, c),
            here: Surfaces::default(),
            there: Surfaces::default(),
            h: 0.0,
            longest,
            paced: vec![false; c],
            span,
            breaks: breaks(drive, t0, t0 + span),
            sensitivity,
            out,
            next: 0,
            flutter: (0, t0),
            buffer: vec![0.0; n + c],
        }
    }

    /// Modes at the start: the sign of `w`, or the contact rule where it is zero.
    fn begin(&mut self) {
        self.field.left_of = self.breaks.last().copied();
        self.field.begin(self.t, &self.x, &self.scale);
        self.field.rates(self.t, &self.x, &mut self.rates);
        self.here.look(&mut self.field, self.t, &self.x);
        self.h = self.first_step();
    }

    /// Hairer's guess of a step length (Solving ODEs I, II.4), from the size and the change of the rates.
    fn first_step(&mut self) -> f64 {
        let norm =
            |v: &[f64], scale: &[f64]| v.iter().zip(scale).map(|(v, s)| (v / s).abs()).fold(0.0, f64::max);
        let span = self.longest;
        let d1 = norm(&self.rates, &self.scale);
        let h0 = if d1 > 1e-10 { (1e-3 / d1).min(span) } else { 1e-3 * span };
        let moved: Vec<f64> = self.x.iter().zip(&self.rates).map(|(x, f)| x + h0 * f).collect();
        self.field.rates(self.t + h0, &moved, &mut self.buffer);
        let change: Vec<f64> = self.buffer.iter().zip(&self.rates).map(|(a, b)| (a - b) / h0).collect();
        let d2 = norm(&change, &self.scale);
        let largest = d1.max(d2);
        let h1 = if largest > 1e-15 { (0.1 * self.options.tolerance.powf(0.2) / largest).sqrt() } else { h0 };
        h1.min(100.0 * h0).min(span)
    }

    fn sample_before_start(&mut self) {
        let n = self.x.len();
        while self.next < self.times.len() && self.times[self.next] <= self.t {
            let back = self.times[self.next] - self.t;
            self.out.states.extend(self.x.iter().zip(&self.rates).map(|(x, f)| x + back * f));
            self.out.rates.extend(&self.rates[..n]);
            if let Some(s) = &mut self.sensitivity {
                let slope = s.slope(&mut self.field, self.t, &self.x);
                self.out.sensitivities.extend(s.s.iter().zip(slope).map(|(s, f)| s + back * f));
            }
            self.out.modes.extend((0..self.field.switches()).map(|c| self.field.sign(c)));
            self.next += 1;
        }
    }

    /// One accepted step: up to its end, the next corner of an input, or the first event in it.
    fn step(&mut self) -> Result<(), SimError> {
        let end = self.times[self.times.len() - 1];
        let target = self.breaks.last().map_or(end, |b| b.min(end));
        let tiny = 1e-15 * self.t.abs().max(end.abs()).max(self.span);
        self.step.start(self.t, &self.x, &self.rates);
        loop {
            if self.out.steps + self.out.rejected > self.options.max_steps {
                return Err(SimError::TooManySteps { time: self.t });
            }
            let mut h = self.h.min(self.longest);
            h = h.min(self.paced());
            if target - self.t - h < 1e-3 * h {
                h = target - self.t;
            }
            self.step.advance(h, |t, x, out| self.field.rates(t, x, out));
            self.there.look(&mut self.field, self.t + h, self.step.end());
            let error = self.error();
            if let Some(shorter) = (error <= 1.0).then(|| self.too_far()).flatten() {
                self.h = shorter;
            } else if error <= 1.0 {
                match self.first_event() {
                    Search::None => {
                        let growth = if error > 0.0 { (0.9 * error.powf(-0.2)).clamp(0.2, 5.0) } else { 5.0 };
                        // A step cut short by a corner says nothing against the longer one that was planned.
                        self.h = (h * growth).max(if h < self.h { self.h } else { 0.0 });
                        self.accept();
                        self.turn_corner();
                        return self.check();
                    }
                    Search::At(event, theta) => {
                        if theta > 0.0 {
                            self.locate(event, theta);
                            self.accept();
                            self.check()?;
                        }
                        self.pass(event)?;
                        self.turn_corner();
                        self.h = self.first_step();
                        return Ok(());
                    }
                    Search::Shorter => self.h = 0.5 * h,
                }
            } else {
                let shrink = if error.is_finite() { (0.9 * error.powf(-0.2)).clamp(0.1, 0.9) } else { 0.1 };
                self.h = h * shrink;
                if let Some(reach) = self.overshoot() {
                    // Friction with a steep shape near zero speed spoils a step across zero: come close first.
                    self.h = self.h.max(0.5 * h.min(reach)).min(0.9 * h);
                }
            }
            self.out.rejected += 1;
            if self.h <= tiny {
                return Err(self.collapsed());
            }
        }
    }

    /// If the step just tried passes over the shape of some friction near rest: the length of a step that does not.
    fn too_far(&mut self) -> Option<f64> {
        let h = self.step.h;
        let mut shorter: Option<f64> = None;
        for c in (0..self.field.switches()).filter(|&c| self.field.automaton.switches[c].shaped) {
            if self.field.stuck[c] {
                continue;
            }
            let (mode, least) = (self.field.modes[c], self.field.least_speed(c));
            let (start, end) = (mode * self.here.w[c], mode * self.there.w[c]);
            let (from, to) = (start.max(least), end.max(least));
            let change = (self.here.grip[c] - self.there.grip[c]).abs();
            let felt = change > FELT * self.here.rate[c].abs().min(self.there.rate[c].abs());
            self.paced[c] = felt;
            let ratio = if to < from { from / to } else { to / from };
            if !felt || ratio <= 1.2 * SPEED_RATIO {
                continue;
            }
            let reach = if to < from { from / SPEED_RATIO - start } else { SPEED_RATIO * from - start };
            let length = (h * reach / (end - start)).clamp(0.03 * h, 0.9 * h);
            shorter = Some(shorter.map_or(length, |s| s.min(length)));
        }
        shorter
    }

    /// The longest step that keeps the speeds of contacts whose shape was felt in the last one within the ratio.
    fn paced(&self) -> f64 {
        (0..self.field.switches())
            .filter(|&c| self.paced[c] && !self.field.stuck[c])
            .map(|c| {
                let (mode, least) = (self.field.modes[c], self.field.least_speed(c));
                let (speed, rate) = (mode * self.here.w[c], mode * self.here.rate[c]);
                let from = speed.max(least);
                if rate < 0.0 {
                    // Below the smallest speed that counts nothing changes: the surface may be reached.
                    if speed <= SPEED_RATIO * least {
                        f64::INFINITY
                    } else {
                        (from / SPEED_RATIO - speed) / rate
                    }
                } else if rate > 0.0 {
                    (SPEED_RATIO * from - speed) / rate
                } else {
                    // It has just let go, exactly at its limit.
                    f64::INFINITY
                }
            })
            .fold(f64::INFINITY, f64::min)
    }

    fn collapsed(&self) -> SimError {
        let n = self.x.len();
        let bad = |k: &[f64]| (0..n).find(|&i| !k[i].is_finite());
        match bad(&self.rates).or_else(|| self.step.k.iter().find_map(|k| bad(k))) {
            Some(i) => SimError::NotFinite { time: self.t, state: self.field.automaton.states[i].clone() },
            None => SimError::TooManySteps { time: self.t },
        }
    }

    /// The largest scaled error of the step just tried: at most 1 is good.
    fn error(&mut self) -> f64 {
        let n = self.x.len();
        self.step.errors(&mut self.buffer);
        let (states, loads) = self.buffer.split_at(n);
        let tolerance = self.options.tolerance;
        let mut worst = 0.0_f64;
        let mut weigh = |error: f64, size: f64| {
            let scaled = error.abs() / size;
            worst = if scaled.is_nan() { f64::INFINITY } else { worst.max(scaled) };
        };
        for (i, &e) in states.iter().enumerate() {
            weigh(e, tolerance * self.scale[i].max(self.x[i].abs()).max(self.step.end()[i].abs()));
        }
        for (c, &load) in loads.iter().enumerate().take(self.field.switches()) {
            if self.field.stuck[c] {
                weigh(load, LOAD_RESOLUTION);
            } else if self.field.automaton.switches[c].shaped {
                let e: f64 = states.iter().enumerate().map(|(j, e)| self.field.normal(c, j) * e).sum();
                let speed = self.here.w[c].abs().max(self.there.w[c].abs()).max(self.field.least_speed(c));
                weigh(e, SHAPE_RESOLUTION * tolerance * speed);
            }
        }
        worst
    }

    /// If the failed step ends across a slipping contact's surface: the time to reach it in a straight line.
    fn overshoot(&self) -> Option<f64> {
        let crossed = |&c: &usize| !self.field.stuck[c] && self.field.modes[c] * self.there.w[c] < 0.0;
        let reach = |c: usize| -self.here.w[c] / self.here.rate[c];
        (0..self.field.switches()).filter(crossed).map(reach).filter(|r| *r > 0.0).reduce(f64::min)
    }

    /// Takes the step: samples within it, sensitivities along it, and the new present point.
    fn accept(&mut self) {
        if let Some(s) = &mut self.sensitivity {
            s.advance(&mut self.field, &self.step);
        }
        let (t1, h) = (self.t + self.step.h, self.step.h);
        let from = self.next;
        while self.next < self.times.len() && self.times[self.next] <= t1 {
            if let Some(s) = self.sensitivity.as_mut().filter(|_| self.next == from) {
                s.interpolate(h);
            }
            self.sample((self.times[self.next] - self.t) / h);
        }
        self.t = t1;
        self.x.copy_from_slice(self.step.end());
        self.rates.copy_from_slice(&self.step.k[STAGES - 1]);
        self.out.steps += 1;
        std::mem::swap(&mut self.here, &mut self.there);
        self.field.note_speeds(&self.here.w);
        self.field.keep_at_rest(self.t, &mut self.x);
    }

    /// Writes the next sample, at a fraction of the step just made.
    fn sample(&mut self, theta: f64) {
        let n = self.x.len();
        let at = self.out.states.len();
        self.out.states.resize(at + n, 0.0);
        self.out.rates.resize(at + n, 0.0);
        let dense = self.step.dense();
        dense.value(theta, &mut self.out.states[at..]);
        dense.slope(theta, &mut self.out.rates[at..]);
        self.field.keep_at_rest(self.times[self.next], &mut self.out.states[at..]);
        if let Some(s) = &self.sensitivity {
            self.out.sensitivities.extend(s.dense.values(theta));
        }
        self.out.modes.extend((0..self.field.switches()).map(|c| self.field.sign(c)));
        self.next += 1;
    }

    fn check(&self) -> Result<(), SimError> {
        let fits = |i: usize| self.x[i].abs() <= self.options.diverged * self.scale[i];
        match (0..self.x.len()).find(|&i| !fits(i)) {
            Some(i) => {
                Err(SimError::Diverged { time: self.t, state: self.field.automaton.states[i].clone() })
            }
            None => Ok(()),
        }
    }

    /// Goes on behind a jump or a corner of an input, if the present point is one.
    fn turn_corner(&mut self) {
        if self.breaks.last().is_none_or(|&b| b > self.t) {
            return;
        }
        while self.breaks.last().is_some_and(|&b| b <= self.t) {
            self.breaks.pop();
        }
        self.field.left_of = self.breaks.last().copied();
        let before = self.field.signs();
        self.field.reconsider(self.t, &self.x);
        self.record(&before);
        self.field.rates(self.t, &self.x, &mut self.rates);
        self.here.look(&mut self.field, self.t, &self.x);
        if let Some(s) = &mut self.sensitivity {
            s.restart();
        }
    }
}

/// Where an input jumps or turns a corner within the run, in falling order.
fn breaks(drive: &Drive<'_>, from: f64, to: f64) -> Vec<f64> {
    let mut all = Vec::new();
    for signal in drive.inputs {
        let feature: fn((f64, f64)) -> f64 = match signal.kind() {
            Interpolation::Hold => |(value, _)| value,
            Interpolation::Linear => |(_, slope)| slope,
            Interpolation::Cubic => continue,
        };
        let mut hint = 0;
        all.extend(signal.time().iter().filter(|&&t| {
            let mut at = |t| feature(signal.value_and_slope(t, &mut hint));
            t > from && t < to && at(t.next_down()) != at(t)
        }));
    }
    all.sort_by(|a: &f64, b| b.total_cmp(a));
    all.dedup();
    all
}
