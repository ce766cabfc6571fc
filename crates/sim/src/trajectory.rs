//! Input and output of a run: drive, options, events, samples, errors.

use crate::decisions::{DEFAULT_DIVERGED, DEFAULT_MAX_STEPS, DEFAULT_TOLERANCE};
use crate::stop::Stop;
use phisindy_signal::Signal;
use std::fmt;

/// The drive of a run: inputs as functions of time, and values of the parameters.
#[derive(Clone, Copy, Debug)]
pub struct Drive<'a> {
    /// One signal for each input of the model.
    pub inputs: &'a [Signal],
    /// One number for each parameter of the model.
    pub parameters: &'a [f64],
}

/// The steps of a held input, if their times hang on a parameter: that of a clock or of a delay.
#[derive(Clone, Debug)]
pub struct MovingSteps {
    /// Which input.
    pub input: usize,
    /// Which parameter.
    pub parameter: usize,
    /// By how much a step at a time moves for each unit of the parameter.
    pub by: Signal,
}

/// Options of a run.
#[derive(Clone, Debug)]
pub struct Options {
    /// Local error of a step, relative to the size of each state.
    pub tolerance: f64,
    /// The smallest size of each state that matters; empty means 1 for all. It also sets the speed scale of
    /// the contact rule.
    pub scale: Vec<f64>,
    /// How far each state may be expected to go; empty means [`Options::scale`]. A body at rest has a small
    /// scale, and a model may move it all the same.
    pub reach: Vec<f64>,
    /// Indices of the parameters to differentiate by; `None` for no sensitivities.
    pub sensitivities: Option<Vec<usize>>,
    /// Columns of the sensitivities behind those: numbers that no rate knows, but an [`crate::Observer`] does.
    pub spare: usize,
    /// What parameters do to the steps of held inputs, beside what the rates know of them.
    pub moving: Vec<MovingSteps>,
    /// The run fails after this many steps.
    pub max_steps: usize,
    /// A state beyond this many times its reach has diverged.
    pub diverged: f64,
    /// Ends the run without a result.
    pub stop: Stop,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            tolerance: DEFAULT_TOLERANCE,
            scale: vec![],
            reach: vec![],
            sensitivities: None,
            spare: 0,
            moving: vec![],
            max_steps: DEFAULT_MAX_STEPS,
            diverged: DEFAULT_DIVERGED,
            stop: Stop::default(),
        }
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

/// A jump of states or outputs at an event.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Jump {
    /// When.
    pub time: f64,
    /// By how much each state jumps, then each output.
    pub by: Vec<f64>,
    /// d time / d (start, parameter); empty without sensitivities.
    pub moves: Vec<f64>,
}

/// An impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// When.
    pub time: f64,
    /// Which of the model's impacts.
    pub impact: usize,
    /// The speed at which the gap closed.
    pub speed: f64,
    /// Whether the gap stays closed.
    pub rests: bool,
}

/// A sampled run.
#[derive(Clone, Debug, Default)]
pub struct Trajectory {
    /// Number of columns: the states, then the outputs.
    pub n: usize,
    /// Number of outputs among them.
    pub outputs: usize,
    /// Number of columns of the sensitivities: start states, then the free parameters; 0 without
    /// sensitivities.
    pub m: usize,
    /// States and outputs, row-major samples x n.
    pub states: Vec<f64>,
    /// Their rates of change, row-major samples x n; those of the states from the interpolant of the steps.
    pub rates: Vec<f64>,
    /// d column / d (start, parameter), row-major samples x n x m.
    pub sensitivities: Vec<f64>,
    /// Mode of each switch, row-major samples x switches.
    pub modes: Vec<i8>,
    /// All changes of mode.
    pub events: Vec<Event>,
    /// The events at which a state or an output jumps.
    pub jumps: Vec<Jump>,
    /// All impacts.
    pub hits: Vec<Hit>,
    /// Steps that were accepted.
    pub steps: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Evaluations of the rates.
    pub evaluations: usize,
    /// Accepted steps that are implicit, because the rates are stiff.
    pub implicit: usize,
    /// Matrices decomposed for them.
    pub factorisations: usize,
}

impl Trajectory {
    /// One state or output as a column.
    pub fn column(&self, index: usize) -> Vec<f64> {
        self.states.iter().skip(index).step_by(self.n.max(1)).copied().collect()
    }

    /// Whether a contact or a gap changes within a time of an instant.
    pub fn changes_near(&self, time: f64, within: f64) -> bool {
        let events = self.events.iter().map(|event| event.time);
        events.chain(self.hits.iter().map(|hit| hit.time)).any(|t| (t - time).abs() < within)
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.states.len() / self.n.max(1)
    }

    /// The states at a sample.
    pub fn state_at(&self, sample: usize) -> &[f64] {
        &self.states[sample * self.n..][..self.n - self.outputs]
    }
}

/// The words of [`SimError::Diverged`] about a state; a caller may add advice.
pub const DIVERGED: &str = "grows without bound";

/// Why a run ended early.
#[derive(Clone, Debug, PartialEq)]
pub enum SimError {
    /// A rate is not finite, however short the step.
    NotFinite {
        /// When.
        time: f64,
        /// Which state.
        state: String,
    },
    /// A state exceeds [`Options::diverged`].
    Diverged {
        /// When.
        time: f64,
        /// Which state.
        state: String,
    },
    /// More steps than permitted, or steps too short to advance time.
    TooManySteps {
        /// The time reached.
        time: f64,
    },
    /// The modes change without end at one instant.
    TooManyEvents {
        /// When.
        time: f64,
        /// The switch that chatters.
        switch: String,
    },
    /// [`Options::stop`] asked for it.
    Stopped {
        /// The time reached.
        time: f64,
    },
    /// What a sensor reads is not a finite number.
    NoReading {
        /// The time of the sample.
        time: f64,
        /// Name of the output.
        output: String,
    },
}

impl fmt::Display for SimError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SimError::NotFinite { time, state } => {
                write!(f, "the rate of `{state}` is not finite at t = {time:.6}")
            }
            SimError::Diverged { time, state } => write!(f, "`{state}` {DIVERGED} at t = {time:.6}"),
            SimError::TooManySteps { time } => write!(f, "the step length collapsed at t = {time:.6}"),
            SimError::TooManyEvents { time, switch } => {
                write!(f, "`{switch}` changes sign without end at t = {time:.6}")
            }
            SimError::NoReading { time, output } => {
                write!(
                    f,
                    "the output `{output}` is not a number at t = {time:.6}: a root, power or logarithm of something negative, or a division by zero?"
                )
            }
            SimError::Stopped { time } => write!(f, "it was stopped at t = {time:.6}"),
        }
    }
}

impl std::error::Error for SimError {}
