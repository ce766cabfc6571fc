//! The motion that a model predicts.

use crate::case::Case;
use crate::error::{Error, SimulationError};
use crate::loaded::Loaded;
use crate::record::Record;
use phisindy_learn::ModelError;
use phisindy_phys::{self as phys, Origin, System};
use phisindy_signal::{Differentiator, standard_deviation};
use phisindy_sim::{SimError, Trajectory};

/// A free run at the times of a record, in SI.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Name of the record.
    pub record: String,
    /// Seconds.
    pub time: Vec<f64>,
    /// Names of the states and outputs, and what would be measured of each: with its sensor where the record
    /// has a column of it, else the state itself.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Whether a model predicts it; false for the truth of a synthetic record.
    pub predicted: bool,
}

impl Motion {
    /// The samples of a state.
    pub fn state(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|(n, _)| n == name).map(|(_, values)| values.as_slice())
    }
}

/// Runs a model without unknown part freely along each record: driven by its inputs, from its `start`, or
/// else from its first sample. The motion
/// of a synthetic record is its truth without noise.
///
/// ```
/// use phisindy::{Case, simulate};
/// let case = Case::read(r#"(states: { "x": "m", "v": "m/s" }, known: { "x": "v", "v": "-x" })"#)?;
/// let t: Vec<f64> = (0..100).map(|k| 0.1 * f64::from(k)).collect();
/// let record = case.record(&[("t", &t)])?.with("start", r#"{ "x": 1.0, "v": 0.0 }"#);
/// let motion = &simulate(&case, &[record])?[0];
/// let x = motion.state("x").unwrap();
/// assert!(x.iter().zip(&t).all(|(x, t)| (x - t.cos()).abs() < 1e-6));
/// # Ok::<(), phisindy::Error>(())
/// ```
///
/// # Errors
/// The model has an unknown part and a record is measured, nothing tells where a state starts, or the motion
/// has no bounds.
pub fn simulate(case: &Case, records: &[Record]) -> Result<Vec<Motion>, Error> {
    Loaded::of(case, records)?.simulate()
}

impl Loaded {
    /// As [`simulate`], along the records that [`Loaded::simulated`] plans.
    ///
    /// # Errors
    /// As [`simulate`].
    pub fn simulate(&self) -> Result<Vec<Motion>, Error> {
        let system = &self.case.system;
        // Along a measured record only a model without unknown part can be run.
        if self.simulated().count() != self.records.len() {
            return Err(Error::Open);
        }
        let one = |((record, truth), plan): ((&phys::Record, &Option<Trajectory>), &phys::RecordPlan)| {
            let columns = match (truth, &plan.origin) {
                (Some(truth), Origin::Synthetic(made)) => {
                    let row = |t: f64| (t / made.step).round() as usize;
                    let column =
                        |k: usize| record.time.iter().map(|&t| truth.states[row(t) * truth.n + k]).collect();
                    (0..truth.n).map(column).collect()
                }
                _ if self.case.is_open() => return Err(Error::Open),
                _ => free_run(system, record)
                    .map_err(|error| Error::Simulate { record: record.name.clone(), error })?,
            };
            let names = (0..system.columns()).map(|k| system.motion_column(k));
            let named = names.zip::<Vec<Vec<f64>>>(columns);
            let columns = named.filter_map(|(name, column)| Some((name?, column))).collect();
            let (record, time) = (record.name.clone(), record.time.to_vec());
            Ok(Motion { record, time, columns, predicted: truth.is_none() })
        };
        self.records.iter().zip(&self.truths).zip(self.simulated()).map(one).collect()
    }
}

/// The free run of a model without unknown part along a measured record, one column for each state (SI).
///
/// It begins at the record's start state; what the spec does not say of it is taken from the first sample.
fn free_run(system: &System, record: &phys::Record) -> Result<Vec<Vec<f64>>, SimulationError> {
    let mut filled = record.clone();
    // A state that cannot be derived is asked for below, unless the spec states where it starts.
    let _ = filled.fill_velocities(system, Differentiator::default());
    for (k, state) in system.states.iter().enumerate() {
        let derived = state.velocity.filter(|&v| record.columns[v].is_none());
        let column = derived.and_then(|v| filled.columns[v].as_mut());
        column.into_iter().flatten().for_each(|v| *v /= record.sensors[k].gain.start);
    }
    let told = phisindy_learn::smoothed(system, record).columns;
    for (column, told) in filled.columns[..system.states.len()].iter_mut().zip(told) {
        if column.is_none() {
            *column = told;
        }
    }
    let start = system.states.iter().enumerate().map(|(k, state)| {
        let sensor = &record.sensors[k];
        let first = filled.columns[k].as_ref().map(|c| {
            if record.columns[k].is_some() { (c[0] - sensor.offset.start) / sensor.gain.start } else { c[0] }
        });
        record.start[k].or(first).ok_or_else(|| SimulationError::NoStart { state: state.name.clone() })
    });
    let start: Vec<f64> = start.collect::<Result<_, _>>()?;
    let size = |k: usize| filled.columns[k].as_ref().map_or(0.0, |column| standard_deviation(column));
    let scale = start.iter().enumerate().map(|(k, x)| size(k).max(x.abs()));
    let mut scale: Vec<f64> = scale.map(|s| if s > 0.0 { s } else { 1.0 }).collect();
    // A state without a column may become far larger than where it starts, and that is no lack of bounds.
    for _ in 0..LARGER {
        let run = phisindy_learn::predicted(system, record, &start, &scale);
        if !run.as_ref().is_err_and(|e| matches!(e, ModelError::Simulation(SimError::Diverged { .. }))) {
            return run.map_err(failed);
        }
        let unknown = |k: &usize| size(*k) == 0.0;
        (0..scale.len()).filter(unknown).for_each(|k| scale[k] *= LARGER_BY);
    }
    phisindy_learn::predicted(system, record, &start, &scale).map_err(failed)
}

fn failed(error: ModelError) -> SimulationError {
    match error {
        ModelError::Unbound(reason) => SimulationError::Model(reason),
        ModelError::Simulation(error) => SimulationError::Run(error),
        other @ (ModelError::Beaten | ModelError::Stopped) => SimulationError::Model(other.to_string()),
    }
}

/// How often, and by how much, a state without a column is allowed to be larger than was thought.
const LARGER: usize = 4;
const LARGER_BY: f64 = 1e3;
