//! What a number of a result is of: a term of the dictionary, a constant, or a property of a sensor. Names
//! stand beside the indices, so that a result can be printed without the system.

use phisindy_phys::{SensorPart, System};

/// A term of the dictionary.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TermId {
    /// Index into [`System::terms`].
    pub index: usize,
    /// The candidate as the spec writes it.
    pub candidate: String,
    /// Name of the state in whose rate it stands.
    pub state: String,
}

impl TermId {
    /// The term at an index.
    ///
    /// # Panics
    /// The system has no such term.
    pub fn new(system: &System, index: usize) -> TermId {
        let term = &system.terms[index];
        TermId { index, candidate: term.candidate.clone(), state: system.states[term.state].name.clone() }
    }
}

/// What a parameter is of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParameterOf {
    /// A constant of the model.
    Constant {
        /// Index into [`System::parameters`].
        index: usize,
        /// As in the spec.
        name: String,
    },
    /// A property of the sensor of a column.
    Sensor {
        /// Index of the state or, beyond the states, of the input that the sensor measures.
        column: usize,
        /// Name of that state or input.
        name: String,
        /// Which property.
        part: SensorPart,
    },
}

/// The record that a parameter belongs to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordId {
    /// Index among the records that were given.
    pub index: usize,
    /// As in the spec.
    pub name: String,
    /// Whether it is the only one that was fitted: labels of sensors leave its name out.
    pub only: bool,
}

/// Which parameter: what it is of and, where each record has its own, of which record. `Display` gives the
/// label `k`, `k [run 1]`, `x.offset` or `x.offset [run 1]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterId {
    /// What it is of.
    pub of: ParameterOf,
    /// The record it belongs to; `None` for what all records share.
    pub owner: Option<RecordId>,
}

impl ParameterId {
    /// Index into [`System::parameters`]; `None` for a property of a sensor.
    pub fn constant(&self) -> Option<usize> {
        match self.of {
            ParameterOf::Constant { index, .. } => Some(index),
            ParameterOf::Sensor { .. } => None,
        }
    }

    /// The column (state or, beyond the states, input) and the property of its sensor; `None` for a constant.
    pub fn sensor(&self) -> Option<(usize, SensorPart)> {
        match self.of {
            ParameterOf::Constant { .. } => None,
            ParameterOf::Sensor { column, part, .. } => Some((column, part)),
        }
    }

    /// Index of the record it belongs to; `None` for what all records share.
    pub fn record(&self) -> Option<usize> {
        self.owner.as_ref().map(|owner| owner.index)
    }

    /// Whether a record has this value: its own, or one that all share.
    pub fn holds_in(&self, record: usize) -> bool {
        self.record().is_none_or(|owner| owner == record)
    }

    /// The name of the record, where the label shows it.
    pub fn shown_record(&self) -> Option<&str> {
        let shown = |owner: &&RecordId| !(owner.only && self.sensor().is_some());
        self.owner.as_ref().filter(shown).map(|owner| owner.name.as_str())
    }
}

/// A number of a result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The coefficient of a term.
    Coefficient(TermId),
    /// A parameter that moved.
    Parameter(ParameterId),
}
