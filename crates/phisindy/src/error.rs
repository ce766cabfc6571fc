//! What can go wrong, as data with a `Display`.

use crate::laws::LawError;
use crate::record::RecordError;
use phisindy_gap::GapError;
use phisindy_learn::LearnError;
use phisindy_phys::{Diagnostic, Sources, splice::SetError};
use phisindy_sim::{SimError, SyntheticError};
use std::fmt;

/// Why there is no result.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// The text of the spec, or what was set in it or in a record, is wrong.
    Spec(SpecError),
    /// A field cannot be set: [`crate::Case::with`].
    Set(SetError),
    /// The arrays make no record.
    Record(RecordError),
    /// A law cannot be read.
    Law(LawError),
    /// A synthetic record cannot be made.
    Synthetic {
        /// Name of the record.
        record: String,
        /// Why.
        error: SyntheticError,
    },
    /// [`crate::identify`] came to no result.
    Identify(LearnError),
    /// [`crate::gap`] came to no result.
    Gap(GapError),
    /// The model has an unknown part, which must be identified before it can be simulated.
    Open,
    /// A record cannot be simulated.
    Simulate {
        /// Name of the record.
        record: String,
        /// Why.
        error: SimulationError,
    },
    /// The identified model cannot be written as a spec.
    Completed(String),
}

impl Error {
    /// Whether a state grew without bound: the units of the columns and constants, the signs of stiffness and
    /// damping, or the start values of
    /// movable constants may be wrong.
    pub fn diverged(&self) -> bool {
        match self {
            Error::Identify(error) => error.diverged(),
            Error::Gap(error) => error.diverged(),
            Error::Simulate { error, .. } => error.diverged(),
            _ => false,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Spec(error) => error.fmt(f),
            Error::Set(error) => error.fmt(f),
            Error::Record(error) => error.fmt(f),
            Error::Law(error) => error.fmt(f),
            Error::Synthetic { record, error } => write!(f, "record `{record}`: {error}"),
            Error::Identify(error) => error.fmt(f),
            Error::Gap(error) => error.fmt(f),
            Error::Open => f.write_str(
                "the model has an unknown part: identify it first, then simulate `Identified::case`",
            ),
            Error::Simulate { record, error } => write!(f, "record `{record}`: {error}"),
            Error::Completed(reason) => {
                write!(f, "the identified model cannot be written as a spec: {reason}")
            }
        }
    }
}

impl std::error::Error for Error {}

impl From<SpecError> for Error {
    fn from(error: SpecError) -> Error {
        Error::Spec(error)
    }
}

impl From<SetError> for Error {
    fn from(error: SetError) -> Error {
        Error::Set(error)
    }
}

impl From<RecordError> for Error {
    fn from(error: RecordError) -> Error {
        Error::Record(error)
    }
}

impl From<LawError> for Error {
    fn from(error: LawError) -> Error {
        Error::Law(error)
    }
}

impl From<LearnError> for Error {
    fn from(error: LearnError) -> Error {
        Error::Identify(error)
    }
}

impl From<GapError> for Error {
    fn from(error: GapError) -> Error {
        Error::Gap(error)
    }
}

/// All mistakes of a spec. Its `Display` has a paragraph for each: message, line and column, what to do.
///
/// ```
/// let error = phisindy::Case::read("(\n    states: { \"x\": \"m\" },\n    known: { \"x\": \"w\" },\n)").unwrap_err();
/// assert_eq!(error.mistakes().count(), 1);
/// assert!(error.to_string().starts_with("error: unknown name `w`\n  at spec:3:20"), "{error}");
/// ```
#[derive(Clone, Debug)]
pub struct SpecError {
    diagnostics: Vec<Diagnostic>,
    sources: Sources,
}

impl SpecError {
    pub(crate) fn new(diagnostics: Vec<Diagnostic>, sources: Sources) -> SpecError {
        SpecError { diagnostics, sources }
    }

    /// The texts that the mistakes stand in.
    pub fn sources(&self) -> &Sources {
        &self.sources
    }

    /// The mistakes, without the warnings beside them.
    pub fn mistakes(&self) -> impl Iterator<Item = &Diagnostic> {
        self.diagnostics.iter().filter(|d| d.is_error())
    }
}

impl fmt::Display for SpecError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, mistake) in self.mistakes().enumerate() {
            let between = if k > 0 { "\n" } else { "" };
            write!(f, "{between}{}", mistake.located(&self.sources))?;
        }
        Ok(())
    }
}

impl std::error::Error for SpecError {}

/// Why a model has no free run along a record.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SimulationError {
    /// Nothing tells where a state starts.
    NoStart {
        /// Its name.
        state: String,
    },
    /// The rates of the model cannot be simulated at all: why.
    Model(String),
    /// The run came to no end.
    Run(SimError),
}

impl SimulationError {
    /// Whether a state grew without bound.
    pub fn diverged(&self) -> bool {
        matches!(self, SimulationError::Run(SimError::Diverged { .. }))
    }
}

impl fmt::Display for SimulationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SimulationError::NoStart { state } => {
                write!(f, "no column tells where {state} starts: add `start: {{ \"{state}\": ... }}`")
            }
            SimulationError::Model(reason) => f.write_str(reason),
            SimulationError::Run(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for SimulationError {}
