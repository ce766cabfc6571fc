//! Synthetic records: the truth simulated with located events, sampled, and measured by noisy sensors.

use crate::assembly::Assembly;
use crate::decisions::{
    COARSE_DIVERGED, COARSE_TOLERANCE, FEWEST_SAMPLES, GRID_REFINEMENT, MOST_SINE_SAMPLES, SMALLEST_SIZES,
    TRUTH_TOLERANCE,
};
use crate::excitation::{ExcitationError, Multisine};
use crate::noise::{Noise, Streams, add_noise};
use crate::{Automaton, Drive, Options, SimError, Trajectory, simulate};
use phisindy_expr::{Id, Scratch, Tape};
use phisindy_phys::spec::{InputSpec, NoiseSpec};
use phisindy_phys::{
    Derivation, Note, OwnTimes, Record, RecordPlan, Synthetic, SyntheticInput, System, Value,
};
use phisindy_signal::{Interpolation, Signal, differentiate};
use std::fmt;
use std::sync::Arc;

/// Why a synthetic record could not be made.
#[derive(Clone, Debug, PartialEq)]
pub enum SyntheticError {
    /// The truth cannot be simulated.
    Simulation(SimError),
    /// The excitation is impossible.
    Excitation(ExcitationError),
    /// Something else, in words.
    Other(String),
}

impl fmt::Display for SyntheticError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SyntheticError::Simulation(e) => write!(f, "the truth cannot be simulated: {e}"),
            SyntheticError::Excitation(e) => write!(f, "the excitation cannot be made: {e}"),
            SyntheticError::Other(text) => write!(f, "{text}"),
        }
    }
}

impl std::error::Error for SyntheticError {}

/// Makes a synthetic record. `seed` overrides that of the spec; `file` reads an input from a file.
///
/// Returns the record and the truth without noise at the same times.
///
/// # Errors
/// The truth or its excitation cannot be computed.
///
/// ```
/// use phisindy_phys::{Origin, SourceId, check, spec};
/// use phisindy_sim::synthesize;
/// let text = r#"(states: { "x": "m", "v": "m/s" }, constants: { "k": (1.0, "1/s^2") }, known: { "x": "v", "v": "-k*x" },
///     unknown: { "v": (factor: "-sgn(v)", candidates: ["1", "x"]) }, contacts: ["v"],
///     data: [ Synthetic(truth: { "v": "-0.3*sgn(v)" }, start: { "x": 2.0, "v": 0.0 }, duration: 10.0, step: 0.01, noise: Additive(0.01), seed: 1) ])"#;
/// let (spec, _) = spec::read(text, SourceId(0)).unwrap();
/// let (case, _) = check(&spec, SourceId(0)).unwrap();
/// let Origin::Synthetic(truth) = &case.records[0].origin else { panic!("a measured record") };
/// let (record, clean) = synthesize(&case.records[0], truth, &case.system, None, &|_| Err("no files here".into())).unwrap();
/// // Half a swing takes 2 * 0.3 off the amplitude: from 2 to -1.4, at t = pi.
/// let x = |k: usize| (record.columns[0].as_ref().unwrap()[k], clean.states[2 * k]);
/// assert!((x(314).1 + 1.4).abs() < 1e-4 && (x(314).0 - x(314).1).abs() < 0.1);
/// ```
pub fn synthesize(
    plan: &RecordPlan,
    truth: &Synthetic,
    system: &System,
    seed: Option<u64>,
    file: &dyn Fn(&InputSpec) -> Result<Signal, String>,
) -> Result<(Record, Trajectory), SyntheticError> {
    let streams = Streams(seed.unwrap_or(truth.seed));
    let samples = (truth.duration / truth.step).round().max(2.0) as usize;
    let time: Arc<[f64]> = (0..samples).map(|k| k as f64 * truth.step).collect();
    let excitations = Excitations::new(truth, system, streams, samples)?;
    let constants = record_constants(plan, truth, &excitations)?;
    let (inputs, exact_inputs) = exact_inputs(truth, &excitations, &constants, &time, file)?;
    let start = settled_start(truth, &inputs, &constants)?;
    let run =
        simulate_truth(truth, &start, &inputs, &constants, &time).map_err(SyntheticError::Simulation)?;

    let rows = window_rows(truth, &time)?;
    let sensors = Sensors { plan, truth, system, streams, time: &time, rows: &rows };
    let columns = (0..system.columns()).map(|k| sensors.column(k, &run)).collect::<Result<_, _>>()?;
    let recorded_time: Arc<[f64]> = rows.iter().map(|&k| time[k]).collect();
    let mut recorded = sensors.inputs(exact_inputs, &recorded_time)?;
    let (notes, derivations) = derive_inputs(plan, truth, system, &recorded_time, &mut recorded)?;
    let mut inputs = Vec::new();
    for (k, values) in recorded.into_iter().enumerate() {
        inputs.push(signal(&recorded_time, values, plan.interpolation[k])?);
    }
    let record = Record {
        name: plan.name.clone(),
        role: plan.role,
        time: recorded_time,
        columns,
        own_times: OwnTimes::default(),
        inputs,
        constants,
        sensors: plan.sensors.clone(),
        start: vec![None; system.states.len()],
        continues: None,
        sizes: vec![],
        derivations,
        notes,
    };
    Ok((record, run))
}

/// The generated inputs of a record and the fine grid on which they are tabulated.
struct Excitations<'a> {
    truth: &'a Synthetic,
    /// For each input its sum of sines; `None` for an input that is not generated.
    generated: Vec<Option<Multisine>>,
    /// [`GRID_REFINEMENT`] points for each sample.
    grid: Arc<[f64]>,
}

impl<'a> Excitations<'a> {
    /// Draws the phases of all generated inputs.
    fn new(
        truth: &'a Synthetic,
        system: &System,
        streams: Streams,
        samples: usize,
    ) -> Result<Self, SyntheticError> {
        let grid = (0..=samples * GRID_REFINEMENT).map(|k| k as f64 * truth.step / GRID_REFINEMENT as f64);
        let grid: Arc<[f64]> = grid.collect();
        let generated: Vec<Option<Multisine>> = truth
            .inputs
            .iter()
            .zip(&system.inputs)
            .map(|(input, name)| multisine(input, streams.seed(&format!("phases of {}", name.name))))
            .collect::<Result<_, _>>()
            .map_err(SyntheticError::Excitation)?;
        if let Some(most) = generated.iter().flatten().map(|m| m.omegas().len()).max()
            && most.saturating_mul(samples) > MOST_SINE_SAMPLES
        {
            return Err(SyntheticError::Other(format!(
                "{most} sines at each of {samples} samples are too much: take fewer sines (a larger step of `omega`, a smaller `count`) or fewer samples"
            )));
        }
        Ok(Excitations { truth, generated, grid })
    }

    /// The exact values of input `k` on the grid, if it is generated or the derivative of a generated input.
    fn exact(&self, k: usize) -> Option<Vec<f64>> {
        let grid = &self.grid;
        match &self.truth.inputs[k] {
            SyntheticInput::Generated(_) => {
                self.generated[k].as_ref().map(|m| m.values_on_grid(grid[0], grid[1] - grid[0], grid.len()))
            }
            SyntheticInput::Derivative(of) => {
                self.generated[*of].as_ref().map(|m| grid.iter().map(|&t| m.slope(t)).collect())
            }
            SyntheticInput::Formula(_) => None,
        }
    }
}

/// The values of the constants of a record, in the order of the plan; a formula may use those before it.
fn record_constants(
    plan: &RecordPlan,
    truth: &Synthetic,
    excitations: &Excitations<'_>,
) -> Result<Vec<f64>, SyntheticError> {
    let max_abs = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| v.abs().max(m));
    let mut constants: Vec<f64> = Vec::new();
    for value in &plan.constants {
        constants.push(match value {
            Value::Number(x) => *x,
            Value::MaxAbs(u) => match (&truth.inputs[*u], excitations.exact(*u)) {
                (_, Some(values)) => max_abs(&values),
                (SyntheticInput::Formula(f), None) => {
                    max_abs(&evaluate(truth, *f, &constants, &excitations.grid)?)
                }
                _ => {
                    return Err(SyntheticError::Other(
                        "MaxAbs needs an input with an excitation of its own".into(),
                    ));
                }
            },
        });
    }
    Ok(constants)
}

/// The inputs that drive the truth, and their exact values at the samples.
fn exact_inputs(
    truth: &Synthetic,
    excitations: &Excitations<'_>,
    constants: &[f64],
    time: &Arc<[f64]>,
    file: &dyn Fn(&InputSpec) -> Result<Signal, String>,
) -> Result<(Vec<Signal>, Vec<Vec<f64>>), SyntheticError> {
    let mut signals: Vec<Signal> = Vec::new();
    let mut samples: Vec<Vec<f64>> = Vec::new();
    for (k, input) in truth.inputs.iter().enumerate() {
        let (signal, values) = match (input, excitations.exact(k)) {
            (_, Some(values)) => {
                let coarse = values.iter().step_by(GRID_REFINEMENT).take(time.len()).copied().collect();
                (signal(&excitations.grid, values, Interpolation::Cubic)?, coarse)
            }
            (SyntheticInput::Generated(spec), None) => {
                let signal = file(spec).map_err(SyntheticError::Other)?;
                let values = time.iter().map(|&t| signal.value(t)).collect();
                (signal, values)
            }
            (SyntheticInput::Formula(f), None) => {
                let values = evaluate(truth, *f, constants, time)?;
                (signal(time, values.clone(), Interpolation::Cubic)?, values)
            }
            (SyntheticInput::Derivative(of), None) => {
                let source = &signals[*of];
                let values: Vec<f64> = time.iter().map(|&t| source.slope(t)).collect();
                (signal(time, values.clone(), Interpolation::Cubic)?, values)
            }
        };
        signals.push(signal);
        samples.push(values);
    }
    Ok((signals, samples))
}

/// The samples within the window of the record.
fn window_rows(truth: &Synthetic, time: &[f64]) -> Result<Vec<usize>, SyntheticError> {
    let inside = |t: f64| truth.window.is_none_or(|(a, b)| (a..=b).contains(&t));
    let rows: Vec<usize> = (0..time.len()).filter(|&k| inside(time[k])).collect();
    if rows.len() < FEWEST_SAMPLES {
        return Err(SyntheticError::Other(format!("the window leaves fewer than {FEWEST_SAMPLES} samples")));
    }
    Ok(rows)
}

/// The sensors of a record: states first, then outputs, then inputs.
struct Sensors<'a> {
    plan: &'a RecordPlan,
    truth: &'a Synthetic,
    system: &'a System,
    streams: Streams,
    /// The samples of the whole run.
    time: &'a Arc<[f64]>,
    /// Those within the window.
    rows: &'a [usize],
}

impl Sensors<'_> {
    /// A column as its sensor reads it, within the window. A delayed sensor reads between the samples and
    /// before the window, so it is applied to the whole run.
    fn read(&self, values: Vec<f64>, sensor: usize, kind: Interpolation) -> Result<Vec<f64>, SyntheticError> {
        let values = self.plan.sensors[sensor].reading(self.time, values, kind);
        let values = values.map_err(|e| SyntheticError::Other(e.to_string()))?;
        Ok(self.rows.iter().map(|&k| values[k]).collect())
    }

    fn noisy(&self, mut values: Vec<f64>, name: &str) -> Vec<f64> {
        let mut stream = self.streams.stream(&format!("noise of {name}"));
        add_noise(&mut values, noise_of(&self.truth.noise, name), &mut stream);
        values
    }

    /// The column of a state or output; `None` if it is not measured.
    fn column(&self, k: usize, run: &Trajectory) -> Result<Option<Vec<f64>>, SyntheticError> {
        let read = || self.read(run.column(k), k, Interpolation::Cubic);
        let measured = self.truth.measured_columns[k].then(read).transpose()?;
        Ok(measured.map(|values| self.noisy(values, self.system.measured(k).0)))
    }

    /// The columns of all inputs, with the known properties of their sensors removed again.
    fn inputs(&self, exact: Vec<Vec<f64>>, time: &Arc<[f64]>) -> Result<Vec<Vec<f64>>, SyntheticError> {
        let (n, interpolation) = (self.system.columns(), &self.plan.interpolation);
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (k, values) in exact.into_iter().enumerate() {
            let values = self.read(values, n + k, interpolation[k])?;
            let name = &self.system.inputs[k].name;
            columns.push(if self.truth.measured_inputs[k] { self.noisy(values, name) } else { values });
        }
        for (k, values) in columns.iter_mut().enumerate() {
            *values = self.plan.sensors[n + k]
                .corrected(time, std::mem::take(values), interpolation[k])
                .map_err(|e| SyntheticError::Other(e.to_string()))?;
        }
        Ok(columns)
    }
}

/// Replaces the derivatives of measured inputs by those of their noisy columns, and these by their smoothed
/// values, as for measured data.
fn derive_inputs(
    plan: &RecordPlan,
    truth: &Synthetic,
    system: &System,
    time: &Arc<[f64]>,
    columns: &mut [Vec<f64>],
) -> Result<(Vec<Note>, Vec<Derivation>), SyntheticError> {
    let (mut notes, mut derivations) = (Vec::new(), Vec::new());
    for (k, of) in plan.derived.iter().enumerate().filter_map(|(k, of)| of.map(|of| (k, of))) {
        if truth.measured_inputs[of] && !truth.measured_inputs[k] {
            let d = differentiate(time, &columns[of], plan.differentiators[k])
                .map_err(|e| SyntheticError::Other(e.to_string()))?;
            let (input, of_name) = (system.inputs[k].name.clone(), system.inputs[of].name.clone());
            notes.push(Note::DerivedInput { input, of: of_name, smoothing: d.smoothing });
            let column = std::mem::replace(&mut columns[of], d.values);
            derivations.push(Derivation { input: k, of, column });
            columns[k] = d.derivative;
        }
    }
    Ok((notes, derivations))
}

/// The start state, in which filters have settled on what they read.
fn settled_start(
    truth: &Synthetic,
    inputs: &[Signal],
    constants: &[f64],
) -> Result<Vec<f64>, SyntheticError> {
    let mut start = truth.start.clone();
    let model = &truth.truth;
    let (values, rates): (Vec<Id>, Vec<Id>) = truth.constraints.iter().copied().unzip();
    if let Some(assembly) = Assembly::new(&model.graph, &model.arguments(), &model.states, (&values, &rates))
    {
        let at = |x: &[f64]| -> Vec<f64> {
            let moving =
                [0.0].into_iter().chain(x.iter().copied()).chain(inputs.iter().map(|u| u.value(0.0)));
            moving.chain(constants.iter().copied()).collect()
        };
        let others: Vec<bool> = truth.given.iter().map(|given| !given).collect();
        if !assembly.assemble(&mut start, &others, &at) {
            return Err(SyntheticError::Other(
                "the start does not satisfy the constraints: name in `start` what is known, and the rest follows; or let \
                 it begin near where it can be"
                    .into(),
            ));
        }
    }
    for &(state, settled) in &truth.settled {
        let tape = Tape::compile(&model.graph, &model.arguments(), &[settled])
            .map_err(|e| SyntheticError::Other(e.message(&model.names)))?;
        let mut scratch = Scratch::<1>::new(&tape);
        let given = start.iter().copied().chain(inputs.iter().map(|u| u.value(0.0)));
        scratch.at([0.0].into_iter().chain(given).chain(constants.iter().copied()));
        start[state] = scratch.output(0)[0];
    }
    Ok(start)
}

/// The truth at the sample times. A first, coarse run finds the size of each state, which defines the
/// tolerance of the second run.
fn simulate_truth(
    truth: &Synthetic,
    start: &[f64],
    inputs: &[Signal],
    parameters: &[f64],
    time: &[f64],
) -> Result<Trajectory, SimError> {
    let automaton = Automaton::new(&truth.truth)
        .map_err(|e| SimError::NotFinite { time: 0.0, state: e.message(&truth.truth.names) })?;
    let drive = Drive { inputs, parameters };
    let n = start.len();
    let first = |smallest: f64| {
        let options = Options {
            tolerance: COARSE_TOLERANCE,
            scale: vec![smallest; n],
            diverged: COARSE_DIVERGED,
            ..Default::default()
        };
        Ok((simulate(&automaton, &drive, 0.0, start, time, &options)?, smallest))
    };
    let steep = |r: &Result<_, SimError>| {
        matches!(r, Err(SimError::TooManySteps { .. } | SimError::TooManyEvents { .. }))
    };
    let mut tried = first(SMALLEST_SIZES[0]);
    for &smallest in &SMALLEST_SIZES[1..] {
        if steep(&tried) {
            tried = first(smallest);
        }
    }
    let (run, smallest) = tried?;
    let largest =
        |k: usize| run.states.iter().skip(k).step_by(run.n.max(1)).fold(0.0_f64, |m, x| m.max(x.abs()));
    let scale =
        (0..n).map(|k| if largest(k) > COARSE_TOLERANCE * smallest { largest(k) } else { 1.0 }).collect();
    // The coarse run came to its end. Between samples a stiff state may be far larger than at any of them.
    let fine = Options { tolerance: TRUTH_TOLERANCE, scale, diverged: f64::INFINITY, ..Default::default() };
    simulate(&automaton, &drive, 0.0, start, time, &fine)
}

fn multisine(input: &SyntheticInput, seed: u64) -> Result<Option<Multisine>, ExcitationError> {
    match input {
        SyntheticInput::Generated(InputSpec::Jonswap { hs, tp, gamma, omega }) => {
            let (lo, hi, step) = omega;
            Multisine::jonswap(hs.value, tp.value, gamma.value, lo.value, hi.value, step.value, seed)
                .map(Some)
        }
        SyntheticInput::Generated(InputSpec::Multisine { amplitude, band, count }) => {
            let count = count.as_ref().map_or(20, |c| c.value as usize);
            Multisine::band(amplitude.value, band.0.value, band.1.value, count, seed).map(Some)
        }
        _ => Ok(None),
    }
}

/// An expression of time and record constants on a grid.
fn evaluate(
    truth: &Synthetic,
    formula: Id,
    constants: &[f64],
    grid: &[f64],
) -> Result<Vec<f64>, SyntheticError> {
    let model = &truth.truth;
    let mut inputs = vec![model.time];
    inputs.extend(model.parameters.iter().take(constants.len()));
    let tape = Tape::compile(&model.graph, &inputs, &[formula])
        .map_err(|e| SyntheticError::Other(e.message(&model.names)))?;
    let mut scratch = Scratch::<1>::new(&tape);
    for (k, &value) in constants.iter().enumerate() {
        scratch.input(1 + k)[0] = value;
    }
    let values = grid.iter().map(|&t| {
        scratch.input(0)[0] = t;
        scratch.run();
        scratch.output(0)[0]
    });
    Ok(values.collect())
}

fn signal(time: &Arc<[f64]>, values: Vec<f64>, kind: Interpolation) -> Result<Signal, SyntheticError> {
    Signal::new(time.clone(), values, kind)
        .map_err(|e| SyntheticError::Other(format!("an input is no signal: {e}")))
}

fn noise_of(spec: &NoiseSpec, column: &str) -> Noise {
    match spec {
        NoiseSpec::None => Noise::None,
        NoiseSpec::Relative(s) => Noise::Relative(s.value),
        NoiseSpec::Additive(s) => Noise::Additive(s.value),
        NoiseSpec::Sensor(list) => {
            list.iter().find(|(n, _)| n.value == column).map_or(Noise::None, |(_, (sigma, unit))| {
                let factor = unit
                    .as_ref()
                    .and_then(|u| phisindy_phys::unit::Unit::parse(&u.value).ok())
                    .map_or(1.0, |u| u.factor);
                Noise::Sensor(sigma.value * factor)
            })
        }
    }
}
