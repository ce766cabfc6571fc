//! Results of the workflow as data. Their sentences are in `words.rs`.

mod error;
mod finding;
mod force_history;
mod missing_force;
mod observed_range;
mod placed_law;
mod region;
pub(crate) mod tried;
pub(crate) mod verdict;
mod words;

pub use crate::model::ModelError;
pub use crate::place::Needs;
pub use error::{DataError, GapError};
pub use finding::{
    Activity, Alternative, AlternativeConstant, Cancelling, Cause, CoarseInput, DataMistake, DriveFrequency,
    InputError, InputNoise, Leader, Named, NamedValue, Push, RoundStart, SensorNonlinearity, SpecMistake,
    StopReason, Veto, Vetoed, Warning,
};
pub use force_history::{ForceHistory, force_history};
pub use missing_force::{Dependence, ForcePoint, MissingForce};
pub use observed_range::ObservedRange;
pub(crate) use observed_range::observed_ranges;
pub use placed_law::PlacedLaw;
pub(crate) use region::regions;
pub use region::{Location, Region};
pub use tried::{NotTried, Tried, WhyNot};

use crate::model::{Fitted, TrialModel};
use crate::place::Effect;
use crate::repeat::Repeat;
use phisindy_learn::{FoundParameter, Horizon, RecordFit};
use phisindy_phys::System;
use phisindy_phys::spec::Role;

/// How the workflow ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The model explains the data as it is.
    NothingMissing,
    /// It does so with the effects that were added.
    Explained,
    /// It does so with a formula that was found in the data, which is in no catalogue.
    Described,
    /// Effects were found that bring the gap down by far, and a force in another form is left beside them.
    Named,
    /// Effects were found that leave only noise, and others do as well: which ones it is, is not determined.
    Undetermined,
    /// Something is missing that no law of the catalogue and no formula explains.
    Unexplained,
}

impl Status {
    /// Name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Status::NothingMissing => "nothing-missing",
            Status::Explained => "explained",
            Status::Described => "described",
            Status::Named => "named",
            Status::Undetermined => "undetermined",
            Status::Unexplained => "unexplained",
        }
    }

    /// Whether the completed model may be used.
    pub fn holds(self) -> bool {
        !matches!(self, Status::Undetermined | Status::Unexplained)
    }
}

/// A parameter of an effect.
#[derive(Clone, Debug)]
pub struct StepParameter {
    /// Name in the law.
    pub name: String,
    /// Name of its constant in the completed spec.
    pub constant: String,
    /// Value in its unit.
    pub value: f64,
    /// 95 % interval.
    pub ci95: (f64, f64),
    /// Unit.
    pub unit: String,
    /// The value and interval in each record, where records have values of their own; empty otherwise.
    /// `value` is then that of the first one.
    pub each: Vec<RecordValue>,
}

/// The value of a parameter in one record.
#[derive(Clone, Debug)]
pub struct RecordValue {
    /// Name of the record.
    pub record: String,
    /// Value in the parameter's unit.
    pub value: f64,
    /// 95 % interval.
    pub ci95: (f64, f64),
}

/// A model that was fitted but not chosen.
#[derive(Clone, Debug)]
pub struct Rival {
    /// Its effects in place of the step and of later steps.
    pub laws: Vec<PlacedLaw>,
    /// How much higher its criterion is, beside the final model where it holds the law in question, else at the time of
    /// the step.
    pub delta_bic: f64,
    /// How much higher its criterion is than that of the final model.
    pub behind: f64,
    /// Whether it moves as the final model does: no record tells the two apart.
    pub same: bool,
    /// The spec with all effects of this model in it, from the numbers of its fit on; `None` where it was not written.
    pub completed: Option<String>,
    /// The model, until it is written.
    pub(crate) model: Option<Box<TrialModel>>,
}

/// An effect that was added.
#[derive(Clone, Debug)]
pub struct Step {
    /// Law, place and parameters.
    pub effect: Effect,
    /// What was added, in the language of the spec.
    pub expression: String,
    /// The subtracted force, a node of the final system; `None` for an effect on sensors.
    pub force: Option<phisindy_expr::Id>,
    /// The same with its numbers in SI, in the language of the spec; `None` for an effect on sensors or
    /// inputs and for a law with memory.
    pub formula: Option<String>,
    /// Where a force without memory is known: the displacements and velocities of the records, of those that
    /// it depends on. Empty for other effects.
    pub observed: Vec<ObservedRange>,
    /// The terms of a discovered force about zero, to third order in its `x` and `v` (SI), where it is smooth
    /// and no polynomial: `12*x - 3.1*x^3`.
    pub expansion: Option<String>,
    /// Its parameters in the final model.
    pub parameters: Vec<StepParameter>,
    /// Gap on the Fit records before and after.
    pub fit: (f64, f64),
    /// The same on the Validate records.
    pub validate: Option<(f64, f64)>,
    /// Decrease of the criterion.
    pub delta_bic: f64,
    /// The probability of the law among it and its rivals: half the difference of the score is the logarithm of a ratio of
    /// evidences (`docs/method.md`, section 10). `None` where these were not compared, as the model leaves more than noise.
    pub probability: Option<f64>,
    /// Models that are nearly as good.
    pub rivals: Vec<Rival>,
    /// Laws that evidence rules out.
    pub vetoed: Vec<Vetoed>,
}

/// A model and its simulation of the records.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// The model; its states are in the order of its runs.
    pub system: System,
    /// Fits of the records, in the order of the spec.
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
    /// Role of the record.
    pub role: Role,
    /// Name of the column.
    pub column: String,
    /// NRMSE of the initial model.
    pub before: f64,
    /// NRMSE of the final model.
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

/// Result of the workflow.
#[derive(Clone, Debug)]
pub struct Gap {
    /// How it ended.
    pub status: Status,
    /// Why the search ended.
    pub stop: StopReason,
    /// Estimated standard deviation of each measured column's noise (SI), over all records.
    pub noise: Vec<(String, f64)>,
    /// Where the initial model misses.
    pub located: Vec<Region>,
    /// Where the final model misses.
    pub left: Vec<Region>,
    /// The probability that a force of the motion without a form is there beside or in place of what was found;
    /// `None` where no force was found, or none was looked for.
    pub none: Option<f64>,
    /// The effects that were added, in order.
    pub steps: Vec<Step>,
    /// Effects that helped a little before the search gave up.
    pub partial: Vec<Step>,
    /// Every law that was tried beside the model as it is, at each place, best first.
    pub tried: Vec<Tried>,
    /// The laws of the catalogue that were not tried, and why.
    pub not_tried: Vec<NotTried>,
    /// The missing force without a formula, where neither a law nor a formula explains the data.
    pub force: Option<MissingForce>,
    /// The gap of the initial model, on Fit and Validate records.
    pub before: (f64, Option<f64>),
    /// The gap of the final model.
    pub after: (f64, Option<f64>),
    /// The gap of the final model on Validate records after allowing for the errors of its parameters; the
    /// plain gap where that was not computed.
    pub predictive: Option<f64>,
    /// Another explanation of the data in place of the steps.
    pub alternative: Option<Alternative>,
    /// NRMSE of each record and column.
    pub nrmse: Vec<ColumnGap>,
    /// Repeatability of the motion.
    pub repeat: Vec<ColumnRepeat>,
    /// The residual's whiteness score before and after.
    pub whiteness: (f64, f64),
    /// All parameters of the final model.
    pub parameters: Vec<FoundParameter>,
    /// The spec with the effects in it.
    pub completed: String,
    /// Free runs of the initial model along the records.
    pub initial: Simulated,
    /// Free runs of the final model along the records.
    pub simulated: Simulated,
    /// How far the final model predicts, beside a linear model.
    pub horizon: Vec<Horizon>,
    /// Warnings about the data, the fit and the effects.
    pub warnings: Vec<Warning>,
}

impl Gap {
    /// Whether the user stopped it.
    pub fn interrupted(&self) -> bool {
        self.stop == StopReason::Interrupted
    }
}
