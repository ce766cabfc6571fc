//! Why nothing could be identified. Texts are in [`super::words`].

use phisindy_sim::SimError;

/// Why a model cannot be simulated.
#[derive(Clone, Debug, PartialEq)]
pub enum ModelError {
    /// A rate uses a symbol that is no state, input, parameter or time; what is said of it.
    Unbound(String),
    /// The simulation failed.
    Simulation(SimError),
    /// Its segments leave more than a rival, and its runs were not asked for.
    Beaten,
    /// The work was to end.
    Stopped,
}

impl ModelError {
    /// Whether a state grew beyond all bounds.
    pub fn diverged(&self) -> bool {
        matches!(self, ModelError::Simulation(SimError::Diverged { .. }))
    }
}

impl From<SimError> for ModelError {
    fn from(error: SimError) -> ModelError {
        ModelError::Simulation(error)
    }
}

/// Why nothing could be identified at all.
#[derive(Clone, Debug, PartialEq)]
pub enum LearnError {
    /// The records do not suit the method.
    Data(DataError),
    /// The numerics failed.
    Numerics(NumericsError),
}

impl LearnError {
    /// Whether a state grew beyond all bounds.
    pub fn diverged(&self) -> bool {
        match self {
            LearnError::Data(_) => false,
            LearnError::Numerics(NumericsError::Model(error)) => error.diverged(),
            LearnError::Numerics(_) => false,
        }
    }
}

impl From<DataError> for LearnError {
    fn from(error: DataError) -> LearnError {
        LearnError::Data(error)
    }
}

impl From<NumericsError> for LearnError {
    fn from(error: NumericsError) -> LearnError {
        LearnError::Numerics(error)
    }
}

/// What is wrong with the records.
#[derive(Clone, Debug, PartialEq)]
pub enum DataError {
    /// No record has the role Fit.
    NothingToFit,
    /// A record has fewer samples than anything can be learned from.
    TooFewSamples {
        /// Name of the record.
        record: String,
        /// How many it has.
        samples: usize,
    },
    /// A measured column does not change.
    ConstantColumn {
        /// Name of the record.
        record: String,
        /// Name of the column's state.
        column: String,
    },
    /// States jump, which method step does not follow.
    Jumps,
    /// The squares of a measured column leave the range of numbers.
    OutOfRange {
        /// Name of the record.
        record: String,
        /// Name of the column's state.
        column: String,
    },
    /// A column holds something that is not a finite number.
    NotANumber {
        /// Name of the record.
        record: String,
        /// Name of the column's state or output.
        column: String,
        /// When, s.
        time: f64,
    },
    /// A sensor is as late as the record is long, or later.
    DelayBeyondRecord {
        /// Name of the record.
        record: String,
        /// Name of the column.
        column: String,
        /// The delay, s.
        delay: f64,
        /// How long the record is, s.
        duration: f64,
    },
    /// A low-pass filter settles so much faster than the samples follow each other that none shows it.
    FilterBetweenSamples {
        /// Name of the record.
        record: String,
        /// Name of the column.
        column: String,
        /// Its cutoff, Hz.
        cutoff: f64,
        /// The sampling rate, Hz.
        rate: f64,
    },
    /// Method step lacks samples of states that cannot be derived from a column.
    MissingStates {
        /// Name of the record.
        record: String,
        /// Names of the states.
        states: Vec<String>,
    },
}

/// Where the numerics failed.
#[derive(Clone, Debug, PartialEq)]
pub enum NumericsError {
    /// The model cannot be simulated from where the fit starts.
    Model(ModelError),
    /// The model can be simulated, but no start leads to a fit.
    Diverged,
    /// The one-step loss is not a number.
    LossNotFinite,
}

/// Why a case has no truth to compare with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TruthError {
    /// No record is synthetic.
    NotSynthetic,
    /// The truth uses a symbol without a value; what is said of it.
    Unbound(String),
    /// The truth of a state's rate is no combination of the dictionary's terms.
    OutsideDictionary {
        /// Name of the state.
        state: String,
    },
}
