//! What the workflow found.

use crate::effect::Effect;
use crate::fitted::Fitted;
use crate::region::Region;
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

/// A description that was fitted and not chosen.
#[derive(Clone, Debug)]
pub struct Rival {
    /// Law, or laws joined by ` + `.
    pub law: String,
    /// Their places.
    pub at: String,
    /// By how much its criterion is worse.
    pub delta_bic: f64,
}

/// An effect that was added.
#[derive(Clone, Debug)]
pub struct Step {
    /// Which and where.
    pub effect: Effect,
    /// What was added.
    pub expression: String,
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
    /// What evidence speaks against: law, why.
    pub vetoed: Vec<(String, String)>,
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
        Simulated { system: fitted.draft.case.system, records: fitted.cal.records }
    }
}

/// What the workflow found.
#[derive(Clone, Debug)]
pub struct Gap {
    /// How it ended.
    pub status: Status,
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
    /// What is left of that on Validate records if the numbers of the model may move within their errors; the same where that was not asked.
    pub carried: Option<f64>,
    /// A constant that the spec holds and that would explain the data in place of what was found, in words.
    pub instead: Option<String>,
    /// NRMSE of each record and column in the final model, and in the model as it was.
    pub nrmse: Vec<(String, Role, String, f64, f64)>,
    /// Repeatability of the motion: record, column, value.
    pub repeat: Vec<(String, String, Repeat)>,
    /// The residual's score of whiteness before and after.
    pub colour: (f64, f64),
    /// All numbers of the final model.
    pub parameters: Vec<FoundParameter>,
    /// The spec with the effects in it.
    pub completed: String,
    /// The model as it was, running freely along the records.
    pub was: Simulated,
    /// The final model, running freely along the records.
    pub simulated: Simulated,
    /// What a careful reader should know.
    pub warnings: Vec<String>,
    /// Whether it was stopped by the user.
    pub stopped: bool,
}

/// Why there is nothing to say.
#[derive(Clone, Debug, PartialEq)]
pub enum GapError {
    /// The records do not suit: what to do, in words.
    Data(String),
    /// The model cannot be simulated.
    Numerics(String),
}

impl std::fmt::Display for GapError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            GapError::Data(text) | GapError::Numerics(text) => f.write_str(text),
        }
    }
}

impl std::error::Error for GapError {}
