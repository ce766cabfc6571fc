//! What the workflow finds, as data. Its words are in `words.rs`.

mod error;
mod finding;
mod force_history;
mod region;
pub(crate) mod verdict;
mod words;

pub use error::{DataError, GapError, ModelError};
pub use finding::{
    Activity, Alternative, AlternativeConstant, Cause, DataMistake, DriveFrequency, InputNoise, Named,
    NamedValue, StopReason, Veto, Vetoed, Warning,
};
pub use force_history::{ForceHistory, force_history};
pub(crate) use region::regions;
pub use region::{Location, Region};

use crate::model::Fitted;
use crate::place::Effect;
use crate::repeat::Repeat;
use phisindy_learn::{FoundParameter, RecordFit};
use phisindy_phys::System;
use phisindy_phys::spec::Role;

/// How the workflow ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The model explains the data as it is.
    NothingMissing,
    /// It does so with the effects that were added.
    Explained,
    /// Something is missing that no law of the catalogue explains.
    Unexplained,
}

impl Status {
    /// As the JSON has it.
    pub fn name(self) -> &'static str {
        match self {
            Status::NothingMissing => "nothing-missing",
            Status::Explained => "explained",
            Status::Unexplained => "unexplained",
        }
    }
}

/// A parameter of an effect.
#[derive(Clone, Debug)]
pub struct StepParameter {
    /// As the law calls it.
    pub name: String,
    /// As the completed spec calls it.
    pub constant: String,
    /// Value in its unit.
    pub value: f64,
    /// 95 % interval.
    pub ci95: (f64, f64),
    /// Unit.
    pub unit: String,
}

/// A law at a place, by name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct PlacedLaw {
    /// The law's id.
    pub law: String,
    /// The place, as [`crate::Place::at`].
    pub at: String,
}

impl PlacedLaw {
    pub(crate) fn of(effect: &Effect) -> PlacedLaw {
        PlacedLaw { law: effect.entry.id.clone(), at: effect.place.at.clone() }
    }
}

/// A description that was fitted and not chosen.
#[derive(Clone, Debug)]
pub struct Rival {
    /// What it has in the place of the step, and after it.
    pub laws: Vec<PlacedLaw>,
    /// By how much its criterion is worse.
    pub delta_bic: f64,
}

/// An effect that was added.
#[derive(Clone, Debug)]
pub struct Step {
    /// Which and where.
    pub effect: Effect,
    /// What was added, in the language of the spec.
    pub expression: String,
    /// The force that it subtracts, as a node of the final system; `None` for what acts on sensors.
    pub force: Option<phisindy_expr::Id>,
    /// Its numbers in the final model.
    pub parameters: Vec<StepParameter>,
    /// Gap on the Fit records before and after.
    pub fit: (f64, f64),
    /// The same on the Validate records.
    pub validate: Option<(f64, f64)>,
    /// By how much the criterion fell.
    pub delta_bic: f64,
    /// What else would nearly do.
    pub rivals: Vec<Rival>,
    /// What evidence speaks against.
    pub vetoed: Vec<Vetoed>,
}

/// A model and what it makes of the records.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// The model; its states are in the order of its runs.
    pub system: System,
    /// In the order of the spec.
    pub records: Vec<RecordFit>,
}

impl Simulated {
    pub(crate) fn of(fitted: Fitted) -> Simulated {
        Simulated { system: fitted.model.system, records: fitted.cal.records }
    }
}

/// NRMSE of a column of a record.
#[derive(Clone, Debug)]
pub struct ColumnGap {
    /// Name of the record.
    pub record: String,
    /// Fitted or only predicted.
    pub role: Role,
    /// Name of the column.
    pub column: String,
    /// In the model as it was.
    pub before: f64,
    /// In the final model.
    pub after: f64,
}

/// How well a column of a record repeats from cycle to cycle.
#[derive(Clone, Debug)]
pub struct ColumnRepeat {
    /// Name of the record.
    pub record: String,
    /// Name of the column.
    pub column: String,
    /// Period and scatter.
    pub repeat: Repeat,
}

/// What the workflow found.
#[derive(Clone, Debug)]
pub struct Gap {
    /// How it ended.
    pub status: Status,
    /// Why the search ended.
    pub stop: StopReason,
    /// Estimated standard deviation of each measured column's noise (SI), over all records.
    pub noise: Vec<(String, f64)>,
    /// Where the model as it was misses.
    pub located: Vec<Region>,
    /// Where the final model misses.
    pub left: Vec<Region>,
    /// The effects that were added, in order.
    pub steps: Vec<Step>,
    /// What helped a little before the search gave up.
    pub partial: Vec<Step>,
    /// The gap of the model as it was, on Fit and Validate records.
    pub before: (f64, Option<f64>),
    /// The gap of the final model.
    pub after: (f64, Option<f64>),
    /// What is left of that on Validate records if the numbers of the model may move within their errors; the same where that was not
    /// computed.
    pub predictive: Option<f64>,
    /// Something else that would explain the data in place of what was found.
    pub alternative: Option<Alternative>,
    /// NRMSE of each record and column.
    pub nrmse: Vec<ColumnGap>,
    /// Repeatability of the motion.
    pub repeat: Vec<ColumnRepeat>,
    /// The residual's whiteness score before and after.
    pub whiteness: (f64, f64),
    /// All numbers of the final model.
    pub parameters: Vec<FoundParameter>,
    /// The spec with the effects in it.
    pub completed: String,
    /// The model as it was, running freely along the records.
    pub initial: Simulated,
    /// The final model, running freely along the records.
    pub simulated: Simulated,
    /// What a careful reader should know.
    pub warnings: Vec<Warning>,
}

impl Gap {
    /// Whether the user stopped it.
    pub fn interrupted(&self) -> bool {
        self.stop == StopReason::Interrupted
    }
}
