//! What is told beside the effects: why the search ended, what evidence speaks against, other causes, warnings.

use super::PlacedLaw;

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// Nothing but noise is left.
    White,
    /// What is left is what the motion itself repeats to.
    Repeatability,
    /// As many effects as a model may have.
    EffectLimit,
    /// Nothing in the catalogue can act, or is worth its price.
    NothingHelps,
    /// What was added left most of a large gap.
    WeakSteps,
    /// The user, or a limit, stopped it.
    Interrupted,
}

/// What the workflow is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Activity {
    /// Calibrating the model as it is.
    Calibrating,
    /// Screening every law at every place.
    Screening,
    /// Fitting the best laws in full.
    FittingLaws,
    /// Fitting the best pairs of laws.
    FittingPairs,
    /// Computing error bars.
    ErrorBars,
    /// Trying constants that the spec holds.
    Constants,
    /// Looking for other causes.
    OtherCauses,
}

/// What evidence outside of the fit says against a law.
#[derive(Clone, Debug, PartialEq)]
pub enum Veto {
    /// With this dashpot the damping of the body is negative in total.
    FeedsMotion,
    /// The condition of the law's file is not fulfilled: because, as the file says.
    Requirement(String),
    /// A parameter runs to the end of what the law allows.
    ParameterAtEnd {
        /// As the law calls it.
        name: String,
        /// Where it ends.
        bound: f64,
        /// Its unit.
        unit: String,
    },
    /// An elastic contact that never slips.
    NeverSlips,
    /// Friction that would push in places.
    Pushes,
    /// No record lasts half a period of this force (s).
    SlowTone(f64),
    /// Its frequency is one of the drive's (rad/s).
    DriveFrequency(f64),
    /// In the stops the mass moves less than the law asks for.
    DoesNotGiveWay {
        /// How many stops.
        stops: usize,
        /// Motion over what the law asks for.
        slope: f64,
    },
}

/// A law that evidence speaks against.
#[derive(Clone, Debug, PartialEq)]
pub struct Vetoed {
    /// Which and where.
    pub law: PlacedLaw,
    /// Why.
    pub why: Veto,
}

/// A number with its name and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedValue {
    /// Name of the constant.
    pub name: String,
    /// In `unit`.
    pub value: f64,
    /// Unit; empty for none.
    pub unit: String,
}

/// Something else that would explain the data.
#[derive(Clone, Debug, PartialEq)]
pub enum Alternative {
    /// A constant that the spec holds.
    Constant(AlternativeConstant),
    /// A drive at another frequency.
    Drive(DriveFrequency),
    /// Noise of measured inputs.
    InputNoise(InputNoise),
}

/// A constant that the spec holds and that would do in place of effects.
#[derive(Clone, Debug, PartialEq)]
pub struct AlternativeConstant {
    /// With the value that explains the data.
    pub constant: NamedValue,
    /// What the spec says, in the same unit.
    pub stated: f64,
    /// Effects beside it that were not found without it.
    pub other: Vec<PlacedLaw>,
    /// Effects that are needless then.
    pub needless: Vec<PlacedLaw>,
    /// The numbers of the effects then.
    pub numbers: Vec<NamedValue>,
    /// Its criterion less that of what was found.
    pub delta_bic: f64,
}

/// A drive whose frequency is not what the spec says.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveFrequency {
    /// Its frequency over that of the spec.
    pub ratio: f64,
    /// Effects beside it.
    pub beside: Vec<PlacedLaw>,
    /// Gap of the model as it is, and with this frequency.
    pub gap: (f64, f64),
    /// The numbers of the effects.
    pub numbers: Vec<NamedValue>,
    /// Whether that explains the data; else something is missing beside it.
    pub explains: bool,
}

/// Noise of measured inputs that moves the model and not the rig.
#[derive(Clone, Debug, PartialEq)]
pub struct InputNoise {
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// The gap that so much noise alone leaves.
    pub alone: f64,
    /// The gap that is left.
    pub left: f64,
}

/// A cause that is no force, seen in what is left of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cause {
    /// The residual is a straight line in time above all.
    Drift {
        /// The column.
        of: Named,
        /// Part of the residual's power.
        share: f64,
        /// From end to end (SI).
        swing: f64,
    },
    /// The residual is one tone above all.
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
    /// The model moves far more, or far less, than the column.
    Proportion {
        /// The column.
        of: Named,
        /// The model's size over the column's.
        factor: f64,
    },
    /// Two columns fit each other's model.
    Swapped {
        /// One of them.
        of: Named,
        /// The other column.
        other: String,
    },
}

/// What a careful reader should know.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// `unknown` holds candidates (true) or laws (false), which `gap` leaves out.
    UnknownLeftOut {
        /// Whether they are candidates.
        candidates: bool,
    },
    /// So many corrections of one spring describe any curve.
    Curve {
        /// How many.
        count: usize,
        /// At which place.
        at: String,
    },
    /// So many effects may cover up one that no law describes.
    ManyEffects {
        /// How many.
        count: usize,
        /// Whether a little more than noise is left.
        some_left: bool,
    },
    /// An effect that was not added, for it does not help on data not used.
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
    /// A law that fits, but evidence speaks against it.
    Vetoed(Vetoed),
    /// Something else would explain the data.
    Alternative(Alternative),
    /// The drive is off its frequency, beside what else is missing.
    Drive(DriveFrequency),
    /// A cause that is no force.
    Cause(Cause),
    /// A mistake in a file.
    Data(DataMistake),
    /// What the fit of the final model has to say.
    Fit(phisindy_learn::Warning),
}
