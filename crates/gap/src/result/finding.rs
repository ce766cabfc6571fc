//! Findings beside the effects: why the search ended, vetoes, other causes, warnings.

use super::placed_law::PlacedLaw;
use crate::model::Score;
use phisindy_signal::Interpolation;

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// Nothing but noise is left.
    White,
    /// The residual is at the repeatability of the motion.
    Repeatability,
    /// What is left is no more than what is not known of the inputs: their noise, or how they go between their samples.
    Inputs,
    /// A few pushes that nobody measured are all that the model lacks.
    Pushes,
    /// The model has the largest number of effects allowed.
    EffectLimit,
    /// No law of the catalogue can act, or is worth its price.
    NothingHelps,
    /// The added effects left most of a large gap.
    WeakSteps,
    /// The user or a limit stopped it.
    Interrupted,
}

/// What the workflow is doing.
#[derive(Clone, Debug, PartialEq)]
pub enum Activity {
    /// Calibrating the initial model.
    Calibrating,
    /// Screening every law at every place.
    Screening(RoundStart),
    /// Comparing models over short segments of the records.
    Comparing {
        /// In this round.
        round: RoundStart,
        /// Models that are compared.
        done: usize,
        /// All of them.
        all: usize,
    },
    /// Fitting the best models in full.
    Fitting {
        /// In this round.
        round: RoundStart,
        /// Models that are fitted.
        done: usize,
        /// All of them.
        all: usize,
        /// The best one so far.
        best: Option<Leader>,
    },
    /// Looking for a formula, where no law of the catalogue explains the data.
    Formulas,
    /// Fitting the best formulas in full.
    FittingFormulas,
    /// Computing error bars.
    ErrorBars,
    /// Trying fixed constants of the spec.
    Constants,
    /// Looking for other causes.
    OtherCauses,
}

/// Where a round of the search begins; it adds one more effect, or a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoundStart {
    /// From 1 on; 0 before the first.
    pub number: usize,
    /// The gap of the model with which it begins.
    pub gap: f64,
}

/// The best one of some models.
#[derive(Clone, Debug, PartialEq)]
pub struct Leader {
    /// Its laws.
    pub laws: Vec<PlacedLaw>,
    /// The gap that it leaves.
    pub gap: f64,
}

/// The evidence that rules out a law.
#[derive(Clone, Debug, PartialEq)]
pub enum Veto {
    /// With this resistance the total damping of the body is negative at some speeds.
    FeedsMotion,
    /// The condition of the law's file is not met, for the reason given there.
    Requirement(String),
    /// A parameter runs to the bound of the law.
    ParameterAtEnd {
        /// As the law calls it.
        name: String,
        /// The bound.
        bound: f64,
        /// Its unit.
        unit: String,
    },
    /// A parameter whose interval is all that the law allows.
    NotSeen(String),
    /// An elastic contact that never slips.
    NeverSlips,
    /// Its force hardly depends on the speed: dry friction, which holds the body at rest as well.
    IsDryFriction,
    /// Friction that would add energy to the motion in places.
    Pushes,
    /// No record lasts half a period of this force; its period (s).
    SlowTone(f64),
    /// Its frequency is one that the motion has by itself, or a whole multiple of it.
    OwnFrequency {
        /// The frequency of the drive or of the free oscillation (rad/s).
        line: f64,
        /// The multiple, 1 for the frequency itself.
        times: u32,
        /// Whether it is that of the free oscillation.
        free: bool,
    },
    /// The record does not determine its numbers: these intervals reach zero.
    Undetermined(Vec<String>),
    /// During stops the mass moves less than the law predicts.
    DoesNotGiveWay {
        /// Number of stops.
        stops: usize,
        /// Measured motion over predicted motion.
        slope: f64,
    },
}

/// A law that evidence rules out.
#[derive(Clone, Debug, PartialEq)]
pub struct Vetoed {
    /// Law and place.
    pub law: PlacedLaw,
    /// Why.
    pub why: Veto,
    /// What the fit leaves with the numbers that evidence speaks against.
    pub(crate) score: Score,
}

/// A number with its name and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedValue {
    /// Name of the constant.
    pub name: String,
    /// Value in `unit`.
    pub value: f64,
    /// Unit; empty for none.
    pub unit: String,
}

/// Something else that would explain the data.
#[derive(Clone, Debug, PartialEq)]
pub enum Alternative {
    /// A fixed constant of the spec.
    Constant(AlternativeConstant),
    /// A drive at another frequency.
    Drive(DriveFrequency),
    /// Noise of measured inputs.
    InputNoise(InputNoise),
    /// Pushes that nobody measured: between them the model leaves nothing.
    Pushes(Vec<Push>),
}

/// A force that nobody measured, which acts for a while.
#[derive(Clone, Debug, PartialEq)]
pub struct Push {
    /// Name of the record.
    pub record: String,
    /// The speed on which it acts.
    pub at: String,
    /// When it begins (s).
    pub from: f64,
    /// When it ends (s).
    pub to: f64,
    /// By how much it changes that speed, in `unit`.
    pub changes: f64,
    /// The unit of the speed.
    pub unit: String,
}

/// A fixed constant of the spec that explains the data in place of effects.
#[derive(Clone, Debug, PartialEq)]
pub struct AlternativeConstant {
    /// The constant with the value that explains the data.
    pub constant: NamedValue,
    /// Value in the spec, in the same unit.
    pub stated: f64,
    /// Effects beside it that were not found without it.
    pub other: Vec<PlacedLaw>,
    /// Effects that are needless with it.
    pub needless: Vec<PlacedLaw>,
    /// Parameters of the effects with it.
    pub numbers: Vec<NamedValue>,
    /// Its criterion minus that of the steps.
    pub delta_bic: f64,
}

/// A drive whose frequency differs from the spec.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveFrequency {
    /// Its frequency over that of the spec.
    pub ratio: f64,
    /// Effects beside it.
    pub beside: Vec<PlacedLaw>,
    /// Gap of the initial model, and with this frequency.
    pub gap: (f64, f64),
    /// Parameters of the effects.
    pub numbers: Vec<NamedValue>,
    /// Whether that explains the data; otherwise something else is missing too.
    pub explains: bool,
}

/// Noise of measured inputs that moves the model but not the rig.
#[derive(Clone, Debug, PartialEq)]
pub struct InputNoise {
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// The gap that this noise alone leaves.
    pub alone: f64,
    /// The largest gap for which it accounts.
    pub most: f64,
    /// The gap that is left.
    pub left: f64,
}

/// A cause other than a force, seen in the residual of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cause {
    /// The residual is mostly a straight line in time.
    Drift {
        /// The column.
        of: Named,
        /// Part of the residual's power.
        share: f64,
        /// From end to end (SI).
        swing: f64,
    },
    /// The residual of a column bends with the column.
    Bend {
        /// Name of the column.
        column: String,
        /// Part of the residual's power.
        share: f64,
    },
    /// The residual is mostly one tone.
    Tone {
        /// The column.
        of: Named,
        /// Part of the residual's power.
        share: f64,
        /// Angular frequency (rad/s).
        frequency: f64,
    },
}

/// A column of a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named {
    /// Name of the record.
    pub record: String,
    /// Name of the column.
    pub column: String,
}

/// A mistake in a file that no missing effect explains.
#[derive(Clone, Debug, PartialEq)]
pub enum DataMistake {
    /// The column has the model's shape at another scale.
    Scale {
        /// The column.
        of: Named,
        /// Its size over the model's.
        factor: f64,
    },
    /// The model moves far more or far less than the column.
    Proportion {
        /// The column.
        of: Named,
        /// The model's size over the column's.
        factor: f64,
    },
    /// Each of two columns fits the model of the other.
    Swapped {
        /// One of them.
        of: Named,
        /// The other column.
        other: String,
    },
}

/// Two effects whose forces cancel each other over most of the motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Cancelling {
    /// The effects.
    pub laws: (PlacedLaw, PlacedLaw),
    /// The rms of their sum over that of the smaller one.
    pub left: f64,
}

/// Two things that a spec or a file may have mixed up, and the gap that is left with them put right.
#[derive(Clone, Debug, PartialEq)]
pub enum SpecMistake {
    /// Two constants have each other's value.
    Constants {
        /// Their names.
        names: (String, String),
        /// The gap that is left.
        gap: f64,
    },
    /// A column is measured against another body.
    Column {
        /// The column, in its first record.
        of: Named,
        /// The state of the other body.
        other: String,
        /// Whether the column is relative where the spec has it absolute; otherwise the other way round.
        relative: bool,
        /// The gap that is left.
        gap: f64,
    },
    /// An input or a column counts in the other direction.
    Sign {
        /// Its name.
        of: String,
        /// The gap that is left.
        gap: f64,
    },
}

impl SpecMistake {
    /// The same finding with this gap.
    pub(crate) fn with_gap(mut self, left: f64) -> SpecMistake {
        match &mut self {
            SpecMistake::Constants { gap, .. }
            | SpecMistake::Column { gap, .. }
            | SpecMistake::Sign { gap, .. } => *gap = left,
        }
        self
    }
}

/// A sensor whose scale would have to bend only a little to do what an effect does.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorNonlinearity {
    /// The effect.
    pub law: PlacedLaw,
    /// The column that bends most.
    pub of: Named,
    /// The rms of the bend over the standard deviation of the column.
    pub bend: f64,
}

/// Inputs with so few samples that it matters how they go between them.
#[derive(Clone, Debug, PartialEq)]
pub struct CoarseInput {
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// How far the model moves when they are drawn in another way, in units of the noise.
    pub open: f64,
    /// How far the smallest effect moves it.
    pub effect: f64,
}

/// A column of a Validate record that leaves no more than the error of the inputs between their samples.
#[derive(Clone, Debug, PartialEq)]
pub struct InputError {
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// The column.
    pub of: Named,
    /// The rms of what is left of it, after allowing for the errors of the parameters, in `unit`.
    pub left: f64,
    /// The rms by which a rule of higher order between the samples moves the model, in `unit`.
    pub open: f64,
    /// Unit of the column; empty for none.
    pub unit: String,
}

/// A warning about the data, the fit or the effects.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// `unknown` holds candidates (true) or laws (false), which `gap` leaves out.
    UnknownLeftOut {
        /// Whether they are candidates.
        candidates: bool,
    },
    /// Several corrections of one spring can describe any curve.
    Curve {
        /// How many.
        count: usize,
        /// At which place.
        at: String,
    },
    /// This number of effects may hide one that no law describes.
    ManyEffects {
        /// How many.
        count: usize,
        /// Whether a little more than noise is left.
        some_left: bool,
    },
    /// An effect that was not added because it does not help on data not used.
    Refused {
        /// The effect.
        law: PlacedLaw,
        /// Gap on Fit records before and after.
        fit: (f64, f64),
        /// Gap on Validate records before and after.
        validate: (f64, f64),
        /// Whether the model follows the motion with it.
        follows: bool,
    },
    /// A law that fits but that evidence rules out.
    Vetoed(Vetoed),
    /// Every fitted record is a periodic motion at this one frequency of the drive (rad/s).
    OneFrequency(f64),
    /// Two things are mixed up.
    Spec(SpecMistake),
    /// A slightly bent scale of a sensor does as well as an effect.
    SensorNonlinearity(SensorNonlinearity),
    /// Two effects cancel each other.
    Cancelling(Cancelling),
    /// The inputs explain the data when they are drawn in another way between their samples.
    Redrawn {
        /// As the spec has them.
        from: Interpolation,
        /// As they explain the data.
        to: Interpolation,
    },
    /// The inputs are sampled too coarsely for the effects that were found.
    CoarseInput(CoarseInput),
    /// What is left of a column is the error of the inputs between their samples.
    InputError(InputError),
    /// Another explanation of the data.
    Alternative(Alternative),
    /// The drive has another frequency, and something else is missing too.
    Drive(DriveFrequency),
    /// A cause other than a force.
    Cause(Cause),
    /// A mistake in a file.
    Data(DataMistake),
    /// A warning of the fit of the final model.
    Fit(phisindy_learn::Warning),
}
