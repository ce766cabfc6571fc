//! Where model and data disagree, which effect of the catalogue is missing, and what adding it does.
//!
//! ```text
//! spec + records --calibrate--> residual --whiteness--> nothing missing
//!                      ^            |
//!                      |            +--screen--> every law at every place, by linear responses
//!                      |                              |
//!                      +--- best, if Validate says so --- full fits of the best few, evidence, simplification
//! ```
//!
//! The crate reads no files. It takes the text of a spec and its records, adds effects to the graph of the
//! system, and returns the findings as data, with the text of the completed spec. Its sentences are in
//! `result/words.rs`.

mod alternative_constant;
mod changed_constants;
mod constraint;
mod data_mistakes;
mod decisions;
mod drive;
mod drive_frequency;
mod ending;
mod evaluate;
mod evidence;
mod formula;
mod hum;
mod impacts;
mod input_interpolation;
mod memory;
mod model;
mod motion;
mod none_of_these;
mod other_causes;
mod place;
mod plausibility;
mod pushes;
mod repeat;
mod requested_formulas;
mod requested_laws;
mod result;
mod screen;
mod search;
mod sensor_linearity;
mod spec_mistakes;
#[cfg(test)]
mod test_models;
mod whiteness;
mod workflow;

pub use changed_constants::CHANGED;
pub use decisions::decisions;
pub use formula::DISCOVERED;
pub use impacts::IMPACT;
pub use model::{Applied, SpecTextError, TrialModel};
pub use place::{Effect, EffectError, Entry, Place, Quantity, Site, places};
pub use repeat::{Repeat, repeatability};
pub use requested_formulas::{RequestedFormula, WithFormulas, requested_formulas, with_formulas};
pub use requested_laws::{WrittenLaw, WrittenOut, requested_laws, written_out};
pub use result::{
    Activity, Alternative, AlternativeConstant, Cancelling, Cause, CoarseInput, ColumnGap, ColumnRepeat,
    DataError, DataMistake, Dependence, DriveFrequency, ForceHistory, ForcePoint, Gap, GapError, InputError,
    InputNoise, Leader, Location, MissingForce, ModelError, Named, NamedValue, Needs, NotTried,
    ObservedRange, PlacedLaw, Push, RecordValue, Region, Rival, RoundStart, SensorNonlinearity, Simulated,
    SpecMistake, Status, Step, StepParameter, StopReason, Tried, Veto, Vetoed, Warning, WhyNot,
    force_history,
};
pub use workflow::{Standing, gap, standing};
