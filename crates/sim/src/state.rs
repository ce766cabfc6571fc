//! The state of a run between two steps, and its start.

use crate::automaton::Automaton;
use crate::decisions::{KNOTS_PER_STEP, SAMPLES_PER_STEP};
use crate::field::Field;
use crate::observer::Observer;
use crate::sensitivity::Sensitivity;
use crate::step::Step;
use crate::stiffness::Watch;
use crate::trajectory::{Drive, Event, Options, Trajectory};
use phisindy_signal::Interpolation;

/// `w` and `dw/dt` of all switches and kinks at a point, and `d(dw/dt)/ds` of the switches.
#[derive(Default)]
pub(crate) struct Surfaces {
    pub(crate) w: Vec<f64>,
    pub(crate) rate: Vec<f64>,
    pub(crate) influence: Vec<f64>,
}

impl Surfaces {
    /// Evaluates the surfaces, with the sticking contacts at rest.
    pub(crate) fn evaluate(&mut self, field: &mut Field<'_>, t: f64, x: &[f64]) {
        field.stuck_surfaces(t, x);
        self.w.clear();
        self.w.extend((0..field.all_surfaces()).map(|c| field.w(c)));
        self.rate.clear();
        self.rate.extend((0..field.all_surfaces()).map(|c| field.w_rate(c)));
        self.influence.clear();
        self.influence.extend((0..field.switches()).map(|c| field.influence(c, c)));
    }
}

pub(crate) struct Run<'a> {
    pub(crate) field: Field<'a>,
    /// When samples are taken, from the start on: all of a run counts from there, for a double holds the time since 1970
    /// to a quarter of a microsecond only. The rates alone see the time of the record.
    pub(crate) times: Vec<f64>,
    pub(crate) options: &'a Options,
    /// The smallest size of each state that matters.
    pub(crate) scale: Vec<f64>,
    /// Since the start.
    pub(crate) t: f64,
    pub(crate) x: Vec<f64>,
    /// How many of the states are the model's: those that hold something follow them.
    pub(crate) own: usize,
    /// Of what is held, the next multiple of each period.
    pub(crate) counts: Vec<f64>,
    /// Memory: the derivatives of all states at a sample.
    pub(crate) sampled: Vec<f64>,
    /// Memory: the rates at a sample.
    pub(crate) slopes: Vec<f64>,
    /// Rates at the present point, followed by the loads of the sticking contacts.
    pub(crate) rates: Vec<f64>,
    pub(crate) step: Step,
    /// What the last steps say about the method of the next one.
    pub(crate) watch: Watch,
    /// The size of each state, and the permitted error of the step.
    pub(crate) size: Vec<f64>,
    pub(crate) allowed: Vec<f64>,
    /// The surfaces at the present point, and at the end of the trial step.
    pub(crate) here: Surfaces,
    pub(crate) there: Surfaces,
    /// Length of the next trial step.
    pub(crate) h: f64,
    /// The longest step.
    pub(crate) longest: f64,
    /// Contacts whose friction had a significant shape near rest in the last step.
    pub(crate) speed_limited: Vec<bool>,
    /// Length of the whole run.
    pub(crate) span: f64,
    /// Times of the record at which an input or its slope jumps, in descending order: a step ends there.
    pub(crate) breakpoints: Vec<f64>,
    pub(crate) sensitivity: Option<Sensitivity>,
    pub(crate) out: Trajectory,
    /// The next sample to write.
    pub(crate) next: usize,
    /// Number of events since a time, to detect chattering.
    pub(crate) chatter: (usize, f64),
    /// When each kink changed its mode last.
    pub(crate) turned: Vec<f64>,
    pub(crate) buffer: Vec<f64>,
    /// What follows a record, and the samples that it has seen.
    pub(crate) observer: Option<&'a mut dyn Observer>,
    pub(crate) observed: usize,
    /// Derivatives of the outputs of the last sample by the states, row-major.
    pub(crate) by_state: Vec<f64>,
}

impl<'a> Run<'a> {
    pub(crate) fn new(
        automaton: &'a Automaton,
        drive: &'a Drive<'a>,
        t0: f64,
        start: &[f64],
        times: &[f64],
        options: &'a Options,
    ) -> Self {
        let (own, n, c) = (start.len(), automaton.width, automaton.switches.len() + automaton.twins.len());
        let mut scale = if options.scale.is_empty() { vec![1.0; own] } else { options.scale.clone() };
        assert_eq!(scale.len(), own, "one scale for each state");
        scale.resize(n, 1.0);
        let derivatives = |free: &Vec<usize>| {
            Sensitivity::new((&scale, own), options.tolerance, automaton.parameters, free, options.spare)
        };
        let sensitivity = options.sensitivities.as_ref().map(derivatives);
        let m = sensitivity.as_ref().map_or(0, |s| s.m);
        let outputs = automaton.outputs;
        let width = own + outputs;
        let mut out = Trajectory { n: width, outputs, m, ..Default::default() };
        out.states.reserve(times.len() * width);
        out.rates.reserve(times.len() * width);
        out.sensitivities.reserve(times.len() * width * m);
        let span = times.last().map_or(0.0, |end| end - t0).max(f64::MIN_POSITIVE);
        let mut longest = SAMPLES_PER_STEP * span / times.len().max(1) as f64;
        for signal in drive.inputs.iter().filter(|s| s.kind() == Interpolation::Cubic) {
            let time = signal.time();
            let knots = (time.len() - 1) as f64;
            if knots > 0.0 {
                longest = longest.min(KNOTS_PER_STEP * (time[time.len() - 1] - time[0]) / knots);
            }
        }
        Run {
            field: Field::new(automaton, drive, t0, options.tolerance),
            times: times.iter().map(|t| t - t0).collect(),
            options,
            scale,
            t: 0.0,
            x: start.iter().copied().chain(std::iter::repeat(0.0)).take(n).collect(),
            own,
            counts: vec![],
            sampled: vec![],
            slopes: vec![0.0; n],
            rates: vec![0.0; n + c],
            step: Step::new(n, c),
            watch: Watch::default(),
            size: vec![0.0; n],
            allowed: vec![0.0; n],
            here: Surfaces::default(),
            there: Surfaces::default(),
            h: 0.0,
            longest,
            speed_limited: vec![false; c],
            span,
            breakpoints: breakpoints(drive, t0, t0 + span),
            sensitivity,
            out,
            next: 0,
            chatter: (0, 0.0),
            turned: vec![f64::NEG_INFINITY; automaton.kinks],
            buffer: vec![0.0; n + c],
            observer: None,
            observed: 0,
            by_state: vec![],
        }
    }

    /// The time of the record.
    pub(crate) fn time(&self) -> f64 {
        self.field.origin + self.t
    }

    /// Records the modes that have changed.
    pub(crate) fn record(&mut self, before: &[i8]) {
        let after = self.field.signs();
        for (switch, (&from, &to)) in before.iter().zip(&after).enumerate().filter(|(_, (a, b))| a != b) {
            self.out.events.push(Event { time: self.time(), switch, from, to });
        }
    }
}

/// Times within the run at which an input or its slope jumps, in descending order.
fn breakpoints(drive: &Drive<'_>, from: f64, to: f64) -> Vec<f64> {
    let mut all = Vec::new();
    for signal in drive.inputs {
        let feature: fn((f64, f64)) -> f64 = match signal.kind() {
            Interpolation::Hold => |(value, _)| value,
            Interpolation::Linear => |(_, slope)| slope,
            Interpolation::Cubic => continue,
        };
        let mut hint = 0;
        all.extend(signal.knots().filter(|&t| {
            let mut at = |t| feature(signal.value_and_slope(t, &mut hint));
            t > from && t < to && at(t.next_down()) != at(t)
        }));
    }
    all.sort_by(|a: &f64, b| b.total_cmp(a));
    all.dedup();
    all
}
