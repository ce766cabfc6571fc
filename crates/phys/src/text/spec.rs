//! A spec as it is written: every field with its place in the text, nothing checked for meaning yet.
//!
//! [`read`] reports all mistakes of form at once: brackets, unknown, repeated and missing fields, wrong
//! types, numbers out of their range. Whether names exist, expressions parse and units fit is for the next
//! stage to say, with the spans kept here.

mod constant;
mod energy;
pub(crate) mod group;
mod input;
mod leaf;
mod learn;
mod limits;
mod modes;
mod read;
pub(crate) mod reader;
mod record;
mod size;
mod stream;
mod structure;

pub use energy::EnergySpec;
pub use limits::LimitsSpec;
pub use modes::Modes;
pub use read::{read, read_in_memory, read_with_files, read_without_data, read_without_files};
pub use structure::{PointSpec, StructureSpec};

use crate::text::files::Files;
use phisindy_expr::Span;
use phisindy_signal::{Detrend, Differentiator, Interpolation};

/// A value and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Spanned<T> {
    /// What is written there.
    pub value: T,
    /// The content of a text without its quotes; a whole number literal.
    pub span: Span,
}

/// A name, an expression or a unit. Byte `i` of `value` is byte `span.start + i` of the spec.
pub type Text = Spanned<String>;
/// A finite number.
pub type Number = Spanned<f64>;

/// A whole spec.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// What the case is called.
    pub title: Option<Text>,
    /// Names with known or movable values.
    pub constants: Vec<(Text, ConstantSpec)>,
    /// States and their units.
    pub states: Vec<(Text, Text)>,
    /// Inputs and their units.
    pub inputs: Vec<(Text, Text)>,
    /// What sensors read that is neither a state nor an input.
    pub outputs: Vec<(Text, OutputSpec)>,
    /// Names for expressions, each of which may use those before it.
    pub definitions: Vec<(Text, Text)>,
    /// The energies of a mechanism. Its coordinates and speeds are among [`Spec::states`], the rates of its
    /// coordinates in [`Spec::known`].
    pub energy: Option<EnergySpec>,
    /// A structure from matrices. Its points and modes are among [`Spec::states`], the rates of their displacements in
    /// [`Spec::known`].
    pub structure: Option<StructureSpec>,
    /// The known rate of each state.
    pub known: Vec<(Text, Text)>,
    /// What turns a force into the rate of a state; 1 where nothing is given.
    pub inertia: Vec<(Text, Text)>,
    /// The inertia between two states, where it is a matrix: the entries beside its diagonal.
    pub between: Vec<(Text, Text, Text)>,
    /// The unknown part of a state's rate.
    pub unknown: Vec<(Text, UnknownSpec)>,
    /// Velocities that can stick.
    pub contacts: Vec<Text>,
    /// Names of places where a force may act.
    pub places: Vec<(Text, PlaceSpec)>,
    /// What happens where gaps close.
    pub impacts: Vec<(Text, ImpactSpec)>,
    /// What the rig can do and may do, for the design of a next run.
    pub limits: Option<LimitsSpec>,
    /// The records: at least one, but in a spec of [`read_without_data`].
    pub data: Vec<DataSpec>,
    /// How to identify.
    pub learn: LearnSpec,
    /// The numbers of the files that the text names beside its records.
    pub files: Files,
}

impl Spec {
    /// Whether a state is a speed whose rate follows from energies or matrices: what acts along it is then a force.
    pub fn is_moved(&self, state: &str) -> bool {
        let of_energy =
            self.energy.iter().flat_map(|e| &e.coordinates).any(|(_, (speed, _))| speed.value == state);
        of_energy || self.structure.iter().any(|structure| structure.moves(state))
    }

    /// The field with the forces along a speed whose rate follows from energies or matrices.
    pub fn forces_along(&self, state: &str) -> &'static str {
        if self.structure.iter().any(|structure| structure.moves(state)) { "structure" } else { "energy" }
    }
}

/// A place where a force may act.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceSpec {
    /// The speed along which it acts; or with `enters` any signal that it depends on.
    pub of: Text,
    /// By how much it changes the rates of states, where that does not follow from the speed.
    pub enters: Vec<(Text, Text)>,
    /// The input that is to be looked at first, in the place of a force.
    pub replaces: Option<Text>,
}

/// Where something hits something else.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpactSpec {
    /// The gap, which closes at zero.
    pub when: Text,
    /// The part of the closing speed with which it opens again; a text is an expression of constants.
    pub restitution: SensorValue,
}

/// What a sensor reads: an expression of states, inputs, constants, time, and rates of states as `rate(v)`.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputSpec {
    /// As in a state's declaration.
    pub unit: Text,
    /// The expression.
    pub reads: Text,
}

/// A constant in any of its forms.
#[derive(Clone, Debug, PartialEq)]
pub enum ConstantSpec {
    /// `0.022` or `(1.0, "kg")`.
    Number {
        /// The value in `unit`.
        value: Number,
        /// None: whatever unit fits.
        unit: Option<Text>,
    },
    /// `"sqrt(k/m)"`
    Expression(Text),
    /// `(value: 1191.0, unit: "N/m", within: (1000.0, 1300.0))`
    Movable(Movable),
    /// `Find(start: 0.05, unit: "m/s", within: (0.001, 1.0))`
    Find(Find),
    /// `MaxAbs("F")`: the largest magnitude of an input over its record.
    MaxAbs(Text),
}

impl ConstantSpec {
    /// The unit that is written with it.
    pub fn unit(&self) -> Option<&Text> {
        match self {
            ConstantSpec::Number { unit, .. } => unit.as_ref(),
            ConstantSpec::Movable(m) => m.unit.as_ref(),
            ConstantSpec::Find(f) => f.unit.as_ref(),
            ConstantSpec::Expression(_) | ConstantSpec::MaxAbs(_) => None,
        }
    }
}

/// A constant that is known roughly and may move.
#[derive(Clone, Debug, PartialEq)]
pub struct Movable {
    /// Where it starts; inside `within`.
    pub value: Number,
    /// None: whatever unit fits.
    pub unit: Option<Text>,
    /// Lower and upper bound, in order.
    pub within: (Number, Number),
    /// Standard deviation of a prior around `value`.
    pub sigma: Option<Number>,
    /// One value for each record instead of one for all.
    pub each: bool,
    /// The whole form.
    pub span: Span,
}

/// A number that is to be found.
#[derive(Clone, Debug, PartialEq)]
pub struct Find {
    /// Where the search starts; inside `within`.
    pub start: Number,
    /// None: whatever unit fits.
    pub unit: Option<Text>,
    /// Lower and upper bound, in order.
    pub within: (Number, Number),
    /// Standard deviation of a prior around `start`.
    pub sigma: Option<Number>,
    /// One value for each record instead of one for all.
    pub each: bool,
    /// The whole form.
    pub span: Span,
}

/// What may be missing in one rate; candidates or laws, at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownSpec {
    /// What every candidate is multiplied by; 1 if absent.
    pub factor: Option<Text>,
    /// Expressions, each with a coefficient to be found.
    pub candidates: Vec<Text>,
    /// Bounds of the coefficients of some candidates, in SI, infinite where only the sign is bound.
    pub within: Vec<(Text, (f64, f64))>,
    /// Names of laws of the catalogue.
    pub laws: Vec<Text>,
    /// Displacements and velocities in which a formula is looked for.
    pub search: Vec<Text>,
    /// The whole form.
    pub span: Span,
}

/// Where a record comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum DataSpec {
    /// Measured: a file, or arrays of a program (`Arrays(...)`).
    Csv(Box<CsvSpec>),
    /// A simulation of a given truth.
    Synthetic(Box<SyntheticSpec>),
}

impl DataSpec {
    /// The constants that the record brings.
    pub fn constants(&self) -> &[(Text, ConstantSpec)] {
        match self {
            DataSpec::Csv(csv) => &csv.constants,
            DataSpec::Synthetic(synthetic) => &synthetic.constants,
        }
    }

    /// The record, where a file holds it.
    pub fn of_file(&self) -> Option<&CsvSpec> {
        match self {
            DataSpec::Csv(csv) if !csv.in_memory => Some(csv),
            _ => None,
        }
    }
}

/// What a record is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Role {
    /// To identify from.
    #[default]
    Fit,
    /// To check with.
    Validate,
}

/// A column of a file: `"time_s"` or `("x_mass_m", "m")`.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnSpec {
    /// The column's heading.
    pub header: Text,
    /// The unit of its numbers; None: SI.
    pub unit: Option<Text>,
}

/// A measured record: read from a file, or given as arrays by a program.
#[derive(Clone, Debug, PartialEq)]
pub struct CsvSpec {
    /// The file; of arrays, the name of the record.
    pub path: Text,
    /// Whether a program holds the numbers in memory, and there is no file.
    pub in_memory: bool,
    /// Whether the file may be of any format that is known (`Table`); otherwise it is text (`Csv`).
    pub any_format: bool,
    /// The sheet of a workbook, or the variable, structure, group or array of the file.
    pub sheet: Option<Text>,
    /// What the record is called in reports.
    pub name: Option<Text>,
    /// The column of time; its heading is empty where a rate is given.
    pub time: ColumnSpec,
    /// `Rate(1000.0)` in the place of a column of time: rows per second.
    pub rate: Option<Number>,
    /// States and inputs, and the columns that measure them; those of `streams` too.
    pub columns: Vec<(Text, ColumnSpec)>,
    /// Those of the columns that have times of their own.
    pub streams: Vec<StreamSpec>,
    /// Inputs that are computed.
    pub derive: Vec<(Text, DeriveSpec)>,
    /// Imperfections of the sensors.
    pub sensors: Vec<(Text, SensorSpec)>,
    /// Only rows where these columns have these values.
    pub rows: Vec<(Text, Number)>,
    /// Only rows between these times, in order.
    pub window: Option<(Number, Number)>,
    /// Start states that are given.
    pub start: Vec<(Text, Number)>,
    /// What the record is for.
    pub role: Role,
    /// The character between fields; None: found out.
    pub separator: Option<Spanned<char>>,
    /// The decimal mark; None: found out.
    pub decimal: Option<Spanned<char>>,
    /// Whether there is a heading line; None: found out.
    pub header: Option<bool>,
    /// Lines before the heading that are no part of the table.
    pub skip: usize,
    /// Which of the runs that follow each other in the file, from 0: a new one begins wherever time goes
    /// back.
    pub run: Option<Spanned<u64>>,
    /// How inputs go between samples.
    pub interpolate: Vec<(Text, Interpolation)>,
    /// Constants of this record.
    pub constants: Vec<(Text, ConstantSpec)>,
    /// The mean of each n rows in place of them, n at least 1.
    pub decimate: Option<Spanned<u32>>,
    /// Whether rows without a value in one of these columns are left out; otherwise they are a mistake.
    pub omits_missing: bool,
    /// What is taken off these columns before anything else sees them, as the first record of their file and
    /// rows has it.
    pub detrend: Vec<(Text, Detrend)>,
    /// The whole record.
    pub span: Span,
}

/// Where a column with times of its own stands.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamSpec {
    /// The state, output or input.
    pub name: Text,
    /// Its file; None: that of the record.
    pub path: Option<Text>,
    /// As that of a record.
    pub sheet: Option<Text>,
    /// Its column of time; its heading is empty where a rate is given.
    pub time: ColumnSpec,
    /// `Rate(1000.0)` in the place of a column of time.
    pub rate: Option<Number>,
    /// Its column, which is one of those of the record too.
    pub column: ColumnSpec,
    /// The whole stream.
    pub span: Span,
}

/// How an input is computed.
#[derive(Clone, Debug, PartialEq)]
pub enum DeriveSpec {
    /// `Derivative("u")` or `Derivative("u", Spline)`: with respect to time, of that input.
    Derivative(Text, Option<Differentiator>),
}

/// How a sensor differs from the truth.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct SensorSpec {
    /// Added to the column, in its SI unit unless a unit is given.
    pub offset: Option<SensorValue>,
    /// Multiplies the column.
    pub gain: Option<SensorValue>,
    /// How late the column is, in seconds unless a unit is given.
    pub delay: Option<SensorValue>,
    /// By which part of itself a second of the sensor's clock is too short.
    pub clock: Option<SensorValue>,
    /// The time constant with which it follows, in seconds unless a unit is given.
    pub lag: Option<SensorValue>,
    /// The step of the column, and the unit that is written beside it; None: seen from the data.
    pub quantum: Option<(Number, Option<Text>)>,
    /// The unit of a column of counts: `rev/4096`.
    pub per: Option<Text>,
    /// After how much the column begins anew (SI).
    pub unwrap: Option<Number>,
    /// Over how long each sample is the mean, and the unit that is written beside it; None: over no time.
    pub average: Option<(Number, Option<Text>)>,
    /// What takes the high frequencies off the column.
    pub lowpass: Option<FilterSpec>,
    /// What takes the constant part and the low frequencies off the column.
    pub highpass: Option<FilterSpec>,
}

/// A Butterworth filter between a sensor and its column.
#[derive(Clone, Debug, PartialEq)]
pub struct FilterSpec {
    /// Number of its poles, at least 1.
    pub order: Spanned<u32>,
    /// The frequency at which it halves the power, and the unit that is written beside it; none: Hz.
    pub cutoff: (SensorValue, Option<Text>),
    /// The whole form.
    pub span: Span,
}

/// A parameter of a sensor.
#[derive(Clone, Debug, PartialEq)]
pub enum SensorValue {
    /// Known.
    Number(Number),
    /// To be found for each record.
    Find(Find),
    /// A constant of the case: one value for every column and record that names it.
    Constant(Text),
}

/// A record that is simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct SyntheticSpec {
    /// What the record is called in reports.
    pub name: Option<Text>,
    /// What is added to each state's rate.
    pub truth: Vec<(Text, Text)>,
    /// The start state.
    pub start: Vec<(Text, Number)>,
    /// Seconds, positive.
    pub duration: Number,
    /// Seconds between samples, positive.
    pub step: Number,
    /// The sensors' noise.
    pub noise: NoiseSpec,
    /// Drives noise and random phases.
    pub seed: Option<u64>,
    /// What drives the system.
    pub inputs: Vec<(Text, InputSpec)>,
    /// Inputs that are computed.
    pub derive: Vec<(Text, DeriveSpec)>,
    /// Imperfections of the sensors.
    pub sensors: Vec<(Text, SensorSpec)>,
    /// What is recorded; None: all states, or all outputs where there are some.
    pub measure: Option<Vec<Text>>,
    /// Only samples between these times, in order.
    pub window: Option<(Number, Number)>,
    /// What the record is for.
    pub role: Role,
    /// How inputs go between samples.
    pub interpolate: Vec<(Text, Interpolation)>,
    /// Constants of this record.
    pub constants: Vec<(Text, ConstantSpec)>,
    /// The whole record.
    pub span: Span,
}

/// Noise that is added to simulated columns; no number is negative.
#[derive(Clone, Debug, PartialEq)]
pub enum NoiseSpec {
    /// Exact columns.
    None,
    /// Each sample times (1 + s n), n standard normal.
    Relative(Number),
    /// A fraction of each column's standard deviation.
    Additive(Number),
    /// A standard deviation for each column, with its unit; columns that are not listed are exact.
    Sensor(Vec<(Text, (Number, Option<Text>))>),
}

/// An input of a simulated record.
#[derive(Clone, Debug, PartialEq)]
pub enum InputSpec {
    /// Sum of cosines with the JONSWAP spectrum.
    Jonswap {
        /// Significant height.
        hs: Number,
        /// Peak period in seconds.
        tp: Number,
        /// Peak enhancement; 3.3 if not written.
        gamma: Number,
        /// First and last frequency and their distance, in rad/s; 0.1, 50, 0.1 if not written.
        omega: (Number, Number, Number),
    },
    /// An expression of time and constants.
    Formula(Text),
    /// Sum of cosines of equal amplitude and random phase.
    Multisine {
        /// Root mean square of the sum.
        amplitude: Number,
        /// Lowest and highest frequency in Hz.
        band: (Number, Number),
        /// How many cosines; None: the program chooses.
        count: Option<Spanned<u32>>,
    },
    /// A measured column.
    File {
        /// The file.
        path: Text,
        /// The column of time.
        time: ColumnSpec,
        /// The column of the input.
        column: ColumnSpec,
    },
}

/// How to identify; what is not given is chosen by the program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LearnSpec {
    /// Minimiser of method step.
    pub optimiser: Option<Optimiser>,
    /// Epochs of each stage.
    pub epochs: Option<Vec<u32>>,
    /// Learning rate of each stage.
    pub rates: Option<Vec<f64>>,
    /// Coefficients below are dropped.
    pub cutoff: Option<Number>,
    /// Speed below which method step takes a contact as stuck.
    pub tolerance: Option<Number>,
    /// Whether method step uses steps across which a contact's velocity changes sign.
    pub crossings: Option<Crossings>,
    /// How method trajectory chooses terms.
    pub selection: Option<SelectionSpec>,
    /// Samples of a segment of method trajectory.
    pub horizon: Option<u32>,
    /// Into how many segments method trajectory cuts a record.
    pub segments: Option<SegmentsSpec>,
    /// How the velocities that method step needs are made from displacements.
    pub differentiator: Option<Differentiator>,
    /// Which method.
    pub method: Option<Method>,
}

/// Minimiser of the one-step loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Optimiser {
    /// Rectified Adam.
    RAdam,
    /// Plain gradient descent.
    Sgd,
    /// Least squares.
    GaussNewton,
}

/// What method step does with steps across which a contact's velocity changes sign: a Runge-Kutta step is
/// wrong there by the jump of the friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crossings {
    /// Uses them, as the paper does.
    Keep,
    /// Leaves them out.
    Skip,
}

/// How terms are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SelectionSpec {
    /// By an information criterion.
    Auto,
    /// Every candidate stays.
    All,
    /// Coefficients below this are dropped.
    Cutoff(f64),
}

/// Into how many segments a record is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SegmentsSpec {
    /// As many as the motion needs.
    Auto,
    /// That many, at least 1.
    Count(u32),
}

/// How to identify.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// The paper's one-step loss.
    Step,
    /// Fit of the simulated trajectory.
    Trajectory,
}

impl Method {
    /// Name in results and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Method::Step => "step",
            Method::Trajectory => "trajectory",
        }
    }

    /// The method of this name.
    pub fn named(name: &str) -> Option<Method> {
        [Method::Step, Method::Trajectory].into_iter().find(|method| method.name() == name)
    }
}
