//! The motion of a rig with and without hidden effects, from the simulator of the project.

use super::effect::{Action, Effect, Property};
use super::rig::{Line, Rig};
use crate::names::substitute;
use phisindy_phys::Model;
use phisindy_sim::{Automaton, Drive, Options, Trajectory, simulate};

/// Local error, far below any noise.
const TOLERANCE: f64 = 1e-9;
/// A motion with more steps is no realistic case.
const STEPS: usize = 300_000;

/// How a record is measured.
#[derive(Clone, Debug)]
pub(super) struct Experiment {
    /// Start of displacements, then of velocities.
    pub(super) start: Vec<f64>,
    pub(super) lines: Vec<Line>,
    pub(super) times: Vec<f64>,
    /// Whether it is the second record, which may have phases of its own.
    pub(super) second: bool,
}

/// States, sampled.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    pub(super) n: usize,
    /// Displacements, velocities, then states of the effects: one column each.
    pub(super) states: Vec<Vec<f64>>,
    pub(super) rates: Vec<Vec<f64>>,
    /// Whether something sticks.
    pub(super) stuck: Vec<bool>,
    /// For each displacement and velocity, what its sensor reads.
    pub(super) readings: Vec<Vec<f64>>,
}

/// The index of the acceleration of mass 0 among what can be measured; below it are displacements and
/// velocities.
pub(super) const ACCELERATION: usize = 100;

impl Motion {
    /// A displacement, velocity or acceleration of a rig of so many masses.
    pub(super) fn quantity(&self, k: usize, masses: usize) -> &Vec<f64> {
        match k.checked_sub(ACCELERATION) {
            Some(mass) => &self.rates[masses + mass],
            None => &self.states[k],
        }
    }

    /// What its sensor reads.
    pub(super) fn reading(&self, k: usize, masses: usize) -> &Vec<f64> {
        if k < ACCELERATION { &self.readings[k] } else { self.quantity(k, masses) }
    }
}

/// How long before a record the motion must begin: a delayed sensor shows the past.
pub(super) fn earlier(effects: &[Effect]) -> f64 {
    let late = effects.iter().filter_map(|e| match e.action {
        Action::Sensor { property: Property::Delay, value, .. } => Some(value),
        _ => None,
    });
    late.fold(0.0, f64::max) * 1.01
}

/// Simulates an experiment. The motion begins at its start state `before` the first sample.
///
/// # Errors
/// As text: the motion diverges, or an expression is invalid.
pub(super) fn motion(
    rig: &Rig,
    effects: &[Effect],
    experiment: &Experiment,
    before: f64,
) -> Result<Motion, String> {
    let of = equations(rig, effects, experiment);
    let model = model(rig, &of)?;
    let automaton = Automaton::new(&model).map_err(|e| e.message(&model.names))?;
    let drive = Drive { inputs: &[], parameters: &of.constants };
    let start = &of.start;
    let n = start.len();
    let times = &experiment.times;
    let coarse = Options {
        tolerance: 1e-4,
        scale: vec![1e-9; n],
        diverged: 1e24,
        max_steps: STEPS,
        ..Options::default()
    };
    let rough = simulate(&automaton, &drive, -before, start, times, &coarse).map_err(|e| e.to_string())?;
    let largest = |k: usize| rough.states.iter().skip(k).step_by(n).fold(0.0_f64, |m, x| m.max(x.abs()));
    let scale: Vec<f64> = (0..n).map(|k| if largest(k) > 0.0 { largest(k) } else { 1.0 }).collect();
    let fine = Options { tolerance: TOLERANCE, scale, diverged: 1e6, max_steps: STEPS, ..Options::default() };
    let run =
        |times: &[f64]| simulate(&automaton, &drive, -before, start, times, &fine).map_err(|e| e.to_string());
    let now = run(times)?;
    let states = |past: Trajectory| (0..n).map(|k| past.column(k)).collect();
    let past = |late: f64| run(&times.iter().map(|t| t - late).collect::<Vec<_>>()).map(states);
    let exact = (0..2 * rig.count()).map(|k| now.column(k)).collect();
    let readings = read(exact, effects, times, past)?;
    Ok(sampled(now, readings))
}

/// What the sensors read of displacements and velocities, of which `past` gives those of so many seconds ago.
///
/// # Errors
/// Those of `past`.
pub(super) fn read(
    mut readings: Vec<Vec<f64>>,
    effects: &[Effect],
    times: &[f64],
    past: impl Fn(f64) -> Result<Vec<Vec<f64>>, String>,
) -> Result<Vec<Vec<f64>>, String> {
    for effect in effects {
        let Action::Sensor { column, property, value } = effect.action else { continue };
        let late = if property == Property::Delay { Some(past(value)?) } else { None };
        for k in (0..readings.len()).filter(|k| column.is_none_or(|c| c == *k)) {
            let column = &mut readings[k];
            match property {
                Property::Delay => late.iter().for_each(|late| column.clone_from(&late[k])),
                Property::Gain => column.iter_mut().for_each(|y| *y *= value),
                Property::Offset => column.iter_mut().for_each(|y| *y += value),
                Property::Clip => column.iter_mut().for_each(|y| *y = y.clamp(-value, value)),
                Property::Bend => column.iter_mut().for_each(|y| *y += value * *y * *y),
                Property::Lag => follow(column, times, value),
            }
        }
    }
    Ok(readings)
}

/// A column behind a low-pass of first order, straight between its samples.
pub(super) fn follow(column: &mut [f64], times: &[f64], lag: f64) {
    let (mut held, mut before) = (column[0], column[0]);
    for k in 1..column.len() {
        let step = times[k] - times[k - 1];
        let (stays, slope) = ((-step / lag).exp(), (column[k] - before) / step);
        // The response to a straight line is that line a lag later, and what dies out.
        held = column[k] - slope * lag + (held - before + slope * lag) * stays;
        before = column[k];
        column[k] = held;
    }
}

fn sampled(run: Trajectory, readings: Vec<Vec<f64>>) -> Motion {
    let n = run.n;
    let samples = run.states.len() / n;
    let switches = run.modes.len() / samples.max(1);
    let stuck = (0..samples).map(|i| run.modes[i * switches..(i + 1) * switches].contains(&0)).collect();
    let rates = (0..n).map(|k| run.rates.iter().skip(k).step_by(n).copied().collect()).collect();
    Motion { n, states: (0..n).map(|k| run.column(k)).collect(), rates, stuck, readings }
}

/// The drive that acts where the recorded one is off.
fn acting(lines: &[Line], effects: &[Effect]) -> Vec<Line> {
    let mut all = lines.to_vec();
    for effect in effects {
        if let Action::Input { gain, delay } = effect.action {
            for line in &mut all {
                line.amplitude *= gain;
                line.phase -= line.frequency * delay;
            }
        }
    }
    all
}

/// The rig with all hidden effects: names of its states, their rates as text, and their start.
pub(super) struct Equations {
    pub(super) names: Vec<String>,
    /// Over states, constants, `t`, and the drive as `DRIVE` or `u` and `du`.
    pub(super) rates: Vec<String>,
    pub(super) start: Vec<f64>,
    /// What the constants are in truth.
    pub(super) constants: Vec<f64>,
    /// The drive that acts.
    pub(super) lines: Vec<Line>,
}

/// The equations of an experiment.
pub(super) fn equations(rig: &Rig, effects: &[Effect], experiment: &Experiment) -> Equations {
    let mut rates = rig.rates("DRIVE", "u", "du");
    let mut names: Vec<String> = rig.x.iter().chain(&rig.v).cloned().collect();
    let mut own = Vec::new();
    let mut start = experiment.start.clone();
    let mut constants: Vec<f64> = rig.constants.iter().map(|c| c.value).collect();
    for effect in effects {
        match &effect.action {
            Action::Force { place, force, internal } => {
                let force = effect.written(force, experiment.second);
                for &(mass, sign) in &place.parts {
                    let factor = -sign / rig.mass[mass];
                    rates[mass] += &format!(" + ({factor:e})*({force})");
                }
                for (name, rate) in internal {
                    names.push(name.clone());
                    own.push(effect.written(rate, experiment.second));
                    start.push(0.0);
                }
            }
            Action::Factor { mass, factor } => rates[*mass] = format!("({})*({factor})", rates[*mass]),
            Action::Constant { index, value } => constants[*index] = *value,
            Action::Sensor { .. } | Action::Input { .. } => {}
        }
    }
    let mut all: Vec<String> = rig.v.clone();
    all.extend(rates);
    all.extend(own);
    Equations { names, rates: all, start, constants, lines: acting(&experiment.lines, effects) }
}

/// The equations as a model of the simulator.
fn model(rig: &Rig, of: &Equations) -> Result<Model, String> {
    let (value, slope) = Rig::driven(&of.lines);
    let driven = |name: &str| match name {
        "DRIVE" | "u" => Some(value.as_str()),
        "du" => Some(slope.as_str()),
        _ => None,
    };
    let all: Vec<String> = of.rates.iter().map(|text| substitute(text, driven)).collect();
    let texts: Vec<&str> = all.iter().map(String::as_str).collect();
    let names: Vec<&str> = of.names.iter().map(String::as_str).collect();
    let parameters: Vec<&str> = rig.constants.iter().map(|c| c.name.as_str()).collect();
    Model::build(&names, &[], &parameters, &texts)
}
