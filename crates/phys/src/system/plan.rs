//! What a record will be: its columns, constants, sensors; how synthetic data are made. Checked against the
//! system.

use crate::system::constants::Value;
use crate::system::model::Model;
use crate::system::sensor::Sensor;
use crate::text::spec::{CsvSpec, InputSpec, NoiseSpec, Role};
use phisindy_expr::Id;
use phisindy_signal::{Differentiator, Interpolation};

/// What all records have.
#[derive(Clone, Debug)]
pub struct RecordPlan {
    /// Shown to the user.
    pub name: String,
    /// Fitted or only predicted.
    pub role: Role,
    /// One for each of [`crate::System::record_constants`].
    pub constants: Vec<Value>,
    /// One for each state, then each output, then each input.
    pub sensors: Vec<Sensor>,
    /// For each input, the input whose derivative it is.
    pub derived: Vec<Option<usize>>,
    /// For each input, how it is derived if it is.
    pub differentiators: Vec<Differentiator>,
    /// For each input.
    pub interpolation: Vec<Interpolation>,
    /// Start values that the spec states.
    pub start: Vec<Option<f64>>,
    /// Where it comes from.
    pub origin: Origin,
}

/// Where a record comes from.
#[derive(Clone, Debug)]
pub enum Origin {
    /// A file or arrays in memory: read by the program, then [`crate::Record::from_table`].
    Csv(Box<CsvSpec>),
    /// Simulated from a truth.
    Synthetic(Box<Synthetic>),
}

/// How synthetic data are made.
#[derive(Clone, Debug)]
pub struct Synthetic {
    /// The known rates plus the truth; parameters are the record constants. Inputs given by formulas are
    /// replaced by them.
    pub truth: Model,
    /// The truth's extra rate of each state alone.
    pub extra: Vec<Id>,
    /// For each input.
    pub inputs: Vec<SyntheticInput>,
    /// Start state (SI).
    pub start: Vec<f64>,
    /// Which of these the spec gives; of a mechanism with loops the others follow.
    pub given: Vec<bool>,
    /// What is zero in a mechanism with loops, and the rate of that.
    pub constraints: Vec<(Id, Id)>,
    /// States of filters whose start follows from the others, in the order in which they follow.
    pub settled: Vec<(usize, Id)>,
    /// Seconds.
    pub duration: f64,
    /// Seconds between samples.
    pub step: f64,
    /// As in the spec.
    pub noise: NoiseSpec,
    /// As in the spec.
    pub seed: u64,
    /// Which states, then which outputs, are recorded.
    pub measured_columns: Vec<bool>,
    /// Which inputs are recorded with noise (others are known exactly).
    pub measured_inputs: Vec<bool>,
    /// The part of the run that the record shows.
    pub window: Option<(f64, f64)>,
}

/// An input of a synthetic record.
#[derive(Clone, Debug)]
pub enum SyntheticInput {
    /// An expression of time (and record constants).
    Formula(Id),
    /// Multisine, Jonswap, file: made by the simulator.
    Generated(InputSpec),
    /// The derivative of another input.
    Derivative(usize),
}
