//! The fields of specs and laws: the reader takes its names from here, editors their words, and a test holds
//! `docs/reference.md` to it.

use super::Absent::{Is, Needed, Without};
use super::Form::{self, *};
use super::Kind::{
    Constant, Definition, Given, Grid, Impact, Input, Internal, Output, Parameter, Place, Point, Role, Speed,
    State,
};
use super::{Field, Group};

const BOUNDS: Form = Tuple(&[Number, Number]);
const QUANTITY: Form = One(&[Number, Tuple(&[Number, Unit])]);
const CONSTANT: Form = One(&[
    Number,
    Expression,
    Tuple(&[Number, Unit]),
    Group(&MOVABLE),
    Group(&FIND),
    Call("MaxAbs", &[INPUT]),
]);
const CONSTANTS: Form = Map(&Declares(Constant), &CONSTANT);
const STATE: Form = Name(&[State]);
const INPUT: Form = Name(&[Input]);
const MEASURED: Form = Name(&[State, Output, Input]);
const CONSTANT_NAME: Form = Name(&[Constant]);
const PARAMETER_NAME: Form = Name(&[Parameter]);
const SENSOR_VALUE: Form = One(&[Number, Group(&FIND), CONSTANT_NAME]);
const COLUMN: Form = One(&[Header, Tuple(&[Header, Unit])]);
const TIME: Form = One(&[Header, Tuple(&[Header, Unit]), Call("Rate", &[Number])]);
const PER: Form = Tuple(&[Unit, Number]);
/// A number or an expression of numbers.
const TURN: Form = One(&[Number, Expression]);
const MATRIX: Form = One(&[File, Tuple(&[File, Free])]);
const ROLE: Form = One(&[Word("Fit"), Word("Validate")]);
const INTERPOLATION: Form = One(&[Word("Linear"), Word("Hold"), Word("Cubic")]);
const DIFFERENTIATOR: Form = One(&[Word("Spectral"), Word("SavitzkyGolay"), Word("Spline")]);
const DERIVE: Form = One(&[Call("Derivative", &[INPUT]), Call("Derivative", &[INPUT, DIFFERENTIATOR])]);

macro_rules! rows {
    ($($name:ident = $row:expr;)*) => { $(const $name: Field = $row;)* };
}

// Rows that several groups have.
rows! {
    EACH_ROW = Field("each", Truth, "`true`: a value of its own in each record", Is("`false`: one value for all records"));
    PATH_ROW = Field("path", File, "the file, in the data folder", Without("streams"));
    NAME_ROW = Field("name", Prose, "what the record is called", Is("the name of the file"));
    TIME_ROW = Field("time", TIME, "the column of time, `\"t\"` or `(\"t\", \"ms\")`; or `Rate(1000.0)`, rows per second. Times of day (`2024-05-17T10:32:07.125Z`, `17.05.2024 10:32:07,125`, `10:32:07.125`) are seconds from the first row of the file", Without("streams"));
    COLUMNS_ROW = Field("columns", Map(&MEASURED, &COLUMN), "map of states, outputs and inputs to columns, `\"x\"` or `(\"x_mm\", \"mm\")`; leave it out, with `path` and `time`, if `streams` has every column", Without("streams"));
    DERIVE_ROW = Field("derive", Map(&INPUT, &DERIVE), "inputs that are computed: `{ \"du\": Derivative(\"u\") }`, `Derivative(\"u\", Spline)` (or `Spectral`, `SavitzkyGolay`)", Is("none"));
    SENSORS_ROW = Field("sensors", Map(&MEASURED, &Group(&SENSOR)), "map of columns to [sensors](#a-sensor)", Is("perfect ones"));
    ROWS_ROW = Field("rows", Map(&Header, &Number), "only rows where these columns have these values: `{ \"trial\": 0.0 }`", Is("all"));
    START_ROW = Field("start", Map(&STATE, &Number), "start states that are given", Is("fitted"));
    ROLE_ROW = Field("role", ROLE, "`Fit` or `Validate`", Is("`Fit`"));
    RUN_ROW = Field("run", Whole, "which of the runs that follow each other in the file, from 0: a new one begins where time goes back", Is("the file is one run"));
    INTERPOLATE_ROW = Field("interpolate", Map(&INPUT, &INTERPOLATION), "how inputs go between samples: `{ \"u\": Linear }`, `Hold`, `Cubic`", Is("`Cubic`"));
    CONSTANTS_ROW = Field("constants", CONSTANTS, "constants of this record, such as its load", Is("those of the spec"));
    DECIMATE_ROW = Field("decimate", Whole, "the mean of each so many rows in place of them", Is("1"));
    MISSING_ROW = Field("missing", One(&[Word("Omit"), Word("Refuse")]), "`Omit` leaves out the rows in which one of the columns has no value (an empty cell, `NaN`, `n/a`, `-`); `Refuse` takes them for a mistake", Is("`Refuse`"));
    DETREND_ROW = Field("detrend", Map(&MEASURED, &One(&[Word("Mean"), Word("Linear")])), "what is taken off a column: `{ \"x\": Mean }`, `Linear`", Is("nothing"));
    DERIVE_SHORT_ROW = Field("derive", Map(&INPUT, &DERIVE), "inputs that are computed", Is("none"));
    INTERPOLATE_SHORT_ROW = Field("interpolate", Map(&INPUT, &INTERPOLATION), "how inputs go between samples", Is("`Cubic`"));
    CONSTANTS_SHORT_ROW = Field("constants", CONSTANTS, "constants of this record", Is("those of the spec"));
}

macro_rules! group {
    ($name:ident = $owner:literal, $variant:expr; $($field:expr,)*) => {
        #[doc = concat!("The fields of ", $owner, ".")]
        pub static $name: Group = Group { owner: $owner, variant: $variant, fields: &[$($field),*] };
    };
}

group! { SPEC = "the spec", None;
    Field("title", Prose, "what the case is called", Is("none")),
    Field("constants", CONSTANTS, "map of names to numbers: `0.022`, `(1.0, \"kg\")`, an expression of others `\"sqrt(k/m)\"`, movable `(value: ..., within: ...)`, wholly unknown `Find(...)`, `MaxAbs(\"F\")` the largest magnitude of an input", Is("none")),
    Field("states", Map(&Declares(State), &Unit), "map of states to units", Without("energy")),
    Field("inputs", Map(&Declares(Input), &Unit), "map of inputs to units: what is measured or given and drives the motion", Is("none")),
    Field("outputs", Map(&Declares(Output), &Group(&OUTPUT)), "map of names to [outputs](#an-output): what a sensor reads that is neither a state nor an input, such as an acceleration, a force or a strain", Is("none")),
    Field("let", Map(&Declares(Definition), &Expression), "map of names to expressions, each of which may use those before it: `{ \"slip\": \"r*w - v\" }`; used in all that follows", Is("none")),
    Field("energy", Group(&ENERGY), "[energies of a mechanism](#energy): in the place of the rates of its coordinates and speeds, which are not listed in `states` and `known` then (leave these out where nothing else moves)", Is("the rates are written out")),
    Field("structure", Group(&STRUCTURE), "[matrices of a structure](#structure) from files: its points are states then, with speeds, and are not listed in `states` and `known`", Is("none")),
    Field("known", Map(&STATE, &Expression), "the rate of each state, as far as you know it; `x` counts as the displacement of `v` if its rate is exactly `\"v\"`", Without("energy")),
    Field("inertia", Map(&STATE, &One(&[Expression, Map(&STATE, &Expression)])), "the mass that belongs to a velocity; results are then in newtons. Or the rows of a matrix, `{ \"v\": { \"v\": \"M+m\", \"w\": \"m*l*cos(th)\" }, \"w\": \"m*l^2\" }`: a force along `v` then moves `w` too. If you solved the rates by hand, `gap` reads this from an input that is a force along `v`, where the inertia depends on a state", Is("forces are given per unit of mass")),
    Field("unknown", Map(&STATE, &Group(&UNKNOWN)), "[what might be missing](#an-unknown-part), for each rate that may lack something", Is("nothing is missing")),
    Field("contacts", List(&Expression), "velocities, or differences of velocities, inputs and constants, that can stick", Is("none")),
    Field("places", Map(&Declares(Place), &One(&[Expression, Group(&PLACE)])), "names of places and the speeds along which forces act there, `{ \"rail\": \"r*w - v\" }`, also where the direction turns, `\"r*sin(th)*w\"`. Or a signal and how what depends on it enters the rates, `\"leak\": (of: \"p1 - p2\", enters: { \"p1\": \"-B/V\", \"p2\": \"B/V\" })`; or an input, `\"valve\": (of: \"u\", replaces: \"u\")`. `gap` looks there first", Is("speeds, their differences, contacts")),
    Field("impacts", Map(&Declares(Impact), &Group(&IMPACT)), "map of names to [impacts](#an-impact): where a gap closes, the closing speed is reversed", Is("none")),
    Field("limits", Mixed(&LIMITS, &Name(&[State, Output, Input, Constant]), &BOUNDS), "what the rig can do and may do, for [the next run](guides/next.md): `{ \"F\": (-5.0, 5.0), \"x\": (-0.02, 0.02), duration: 60.0, band: (0.1, 10.0) }`. Inputs may be driven, states and outputs must stay within, constants can be set to either end; longest run in s, frequencies of a drive in Hz", Is("what the records have shown")),
    Field("data", List(&One(&[Group(&CSV), Group(&TABLE), Group(&SYNTHETIC), Group(&ARRAYS)])), "the records, [`Csv(...)`](#csv), [`Table(...)`](#table) or [`Synthetic(...)`](#synthetic)", Needed),
    Field("learn", Group(&LEARN), "[how to identify](#learn)", Is("the program chooses")),
}

group! { ENERGY = "`energy`", None;
    Field("coordinates", Map(&Declares(State), &Tuple(&[Declares(Speed), Unit])), "each coordinate with the name of its speed and its unit; both are states", Needed),
    Field("kinetic", Expression, "kinetic energy, quadratic in the speeds; it may depend on coordinates and on `t`", Needed),
    Field("potential", Expression, "potential energy, of the coordinates, `t` and inputs", Is("none")),
    Field("dissipation", Expression, "a function whose derivative by a speed is the force that is lost there: `\"c*v^2/2\"` for a damper, `\"Fc*|v|\"` for dry friction", Is("nothing is lost")),
    Field("forces", Map(&Free, &Expression), "each force with the speed along which it acts: an expression that is linear in speeds, `\"v\"` or `\"r*w - v\"`", Is("none")),
    Field("constraints", List(&Expression), "what closes loops: expressions of coordinates, constants and `t` that are zero, `[\"r*cos(a) + l*cos(b) - x\", \"r*sin(a) + l*sin(b)\"]`", Is("no loops")),
}

group! { STRUCTURE = "`structure`", None;
    Field("mass", MATRIX, "the mass matrix: a file, `\"M.mtx\"` (Matrix Market, text, NumPy, MATLAB), or a file and the name of an array in it, `(\"model.npz\", \"M\")`; SI units", Needed),
    Field("stiffness", MATRIX, "the stiffness matrix", Needed),
    Field("damping", One(&[File, Tuple(&[File, Free]), Number, List(&Number)]), "the damping matrix; or the ratio of all modes, `0.01`; or one for each, `[0.01, 0.02]`, of which the last counts for all others", Is("no damping")),
    Field("coordinates", Free, "what its coordinates are called: with `\"q\"` the point `tip` moves by the state `q_tip` at the speed `q_tip_speed`", Needed),
    Field("points", Map(&Declares(Point), &One(&[Whole, Group(&POINT)])), "map of names to degrees of freedom, counted from 1, or to [points](#a-point)", Needed),
    Field("forces", Map(&Free, &Expression), "each force with the point at which it acts, `{ \"F\": \"tip\" }`, or the speed of points, `\"q_tip_speed - q_joint_speed\"`", Is("none")),
    Field("modes", Whole, "how many modes are kept, from the slowest on", Is("all")),
    Field("band", BOUNDS, "only modes whose frequencies lie between these (Hz) are kept", Is("all")),
}

group! { POINT = "a point", None;
    Field("dof", Whole, "its degree of freedom, counted from 1", Without("row")),
    Field("row", MATRIX, "a file with one number for each degree of freedom: how far the point moves with it", Without("dof")),
    Field("unit", Unit, "the unit of its displacement; the matrices are in SI", Is("`m`")),
}

group! { PLACE = "a place", None;
    Field("of", Expression, "the speed along which a force acts there, or with `enters` any signal that it depends on", Needed),
    Field("enters", Map(&STATE, &Expression), "by how much it changes the rates of states, where that does not follow from the speed", Is("it follows from the speed")),
    Field("replaces", INPUT, "the input that is looked at first, in the place of a force", Is("none")),
}

group! { IMPACT = "an impact", None;
    Field("when", Expression, "the gap, which is open above zero: an expression of displacements, inputs, constants and `t`", Needed),
    Field("restitution", SENSOR_VALUE, "the part of the closing speed with which it opens again, from 0 to 1: a number, an expression of constants, or `Find(...)`", Needed),
}

group! { LIMITS = "`limits`", None;
    Field("duration", Number, "longest run (s)", Is("what the records have shown")),
    Field("band", BOUNDS, "frequencies of a drive (Hz)", Is("what the records have shown")),
}

group! { OUTPUT = "an output", None;
    Field("unit", Unit, "its unit", Needed),
    Field("reads", Expression, "the expression", Needed),
}

group! { MOVABLE = "a movable constant", None;
    Field("value", Number, "where it starts", Needed),
    Field("unit", Unit, "its unit", Is("whatever fits")),
    Field("within", BOUNDS, "lower and upper bound", Without("sigma")),
    Field("sigma", Number, "standard deviation of your prior belief about it, around `value`; with it `within` may be left out", Is("no prior belief")),
    EACH_ROW,
}

group! { FIND = "`Find`", Some("Find");
    Field("start", Number, "where the search starts", Needed),
    Field("unit", Unit, "its unit", Is("whatever fits")),
    Field("within", BOUNDS, "lower and upper bound", Without("sigma")),
    Field("sigma", Number, "standard deviation of your prior belief about it, around `start`; with it `within` may be left out", Is("no prior belief")),
    EACH_ROW,
}

group! { UNKNOWN = "an unknown part", None;
    Field("factor", Expression, "what every candidate is multiplied by, such as `\"-sgn(v)/m\"`", Is("1")),
    Field("candidates", List(&Expression), "expressions, each with a coefficient to be found", Is("none. Then give `laws` or `search`")),
    Field("within", Map(&Expression, &One(&[Word("Positive"), Word("Negative"), BOUNDS])), "bounds of the coefficients of some candidates: `Positive`, `Negative`, `(0.0, 5.0)`", Is("any value")),
    Field("laws", List(&LawId), "names of laws of the catalogue, `[\"stribeck\"]`, outside of the factor and with a sign of their own: `run` fits their parameters, `gap` tries all laws anyway", Is("none")),
    Field("search", List(&Expression), "in place of candidates: displacement and velocity of the body, or of one body against another (`[\"x\", \"v\"]`, `[\"v\"]`, `[\"x1 - x2\"]`), in which `run` looks for a formula and fits it", Is("none")),
}

group! { CSV = "`Csv`", Some("Csv");
    PATH_ROW,
    NAME_ROW,
    TIME_ROW,
    COLUMNS_ROW,
    Field("streams", Map(&MEASURED, &Group(&CSV_STREAM)), "map of states, outputs and inputs to [streams](#a-stream), columns that have times of their own", Is("none")),
    DERIVE_ROW,
    SENSORS_ROW,
    ROWS_ROW,
    Field("window", BOUNDS, "only rows between these times, in seconds whatever the unit of the column; it cuts what is compared, not what drives: inputs are read before it too, as far as there are, for a sensor may be late", Is("all")),
    START_ROW,
    ROLE_ROW,
    Field("separator", Character, "character between fields", Is("found out")),
    Field("decimal", Character, "decimal mark", Is("found out")),
    Field("header", Truth, "whether there is a heading; one behind a comment sign (`#`, `%`, `//`, `!`, `;`) is read too, as `numpy.savetxt` writes it, with units in a second line or without", Is("found out")),
    Field("skip", Whole, "lines before the heading", Is("0")),
    RUN_ROW,
    INTERPOLATE_ROW,
    CONSTANTS_ROW,
    DECIMATE_ROW,
    MISSING_ROW,
    DETREND_ROW,
}

group! { TABLE = "`Table`", Some("Table");
    PATH_ROW,
    Field("sheet", Prose, "the sheet of a workbook; or the structure, matrix, array or group of a file that holds several. It may be left out where one alone holds numbers", Is("the one that holds numbers")),
    NAME_ROW,
    TIME_ROW,
    COLUMNS_ROW,
    Field("streams", Map(&MEASURED, &Group(&STREAM)), "map of states, outputs and inputs to [streams](#a-stream), columns that have times of their own", Is("none")),
    DERIVE_ROW,
    SENSORS_ROW,
    ROWS_ROW,
    Field("window", BOUNDS, "as in `Csv`", Is("all")),
    START_ROW,
    ROLE_ROW,
    Field("separator", Character, "of text: character between fields", Is("found out")),
    Field("decimal", Character, "of text: decimal mark", Is("found out")),
    Field("header", Truth, "whether there is a heading", Is("found out")),
    Field("skip", Whole, "of a workbook, rows before the heading", Is("0")),
    RUN_ROW,
    INTERPOLATE_ROW,
    CONSTANTS_ROW,
    DECIMATE_ROW,
    MISSING_ROW,
    DETREND_ROW,
}

group! { STREAM = "a stream", None;
    Field("column", COLUMN, "the column, `\"x\"` or `(\"x_mm\", \"mm\")`; where its cell is empty there is no sample", Needed),
    Field("path", File, "the file of this stream. Its separator and heading are found out; `rows` and `run` do not apply to it", Is("that of the record")),
    Field("time", TIME, "as in `Csv`", Is("that of the record")),
    Field("per", PER, "as of [a sensor](#a-sensor)", Is("none")),
    Field("unwrap", TURN, "as of a sensor", Is("it does not")),
    Field("quantum", QUANTITY, "as of a sensor", Is("seen from the data")),
    Field("hold", Truth, "`true`: an input keeps its value until the next sample", Is("`false`")),
    Field("sheet", Prose, "in a `Table`: as there", Is("that of the record, in its file")),
}

group! { ARRAYS = "`Arrays`", Some("Arrays");
    Field("name", Prose, "what the record is called", Is("`record`")),
    Field("columns", List(&MEASURED), "list of the states, outputs and inputs that have a column: `[\"x\", \"F\"]`", Needed),
    DERIVE_SHORT_ROW,
    SENSORS_ROW,
    START_ROW,
    ROLE_ROW,
    INTERPOLATE_SHORT_ROW,
    CONSTANTS_SHORT_ROW,
}

group! { SYNTHETIC = "`Synthetic`", Some("Synthetic");
    Field("name", Prose, "what the record is called", Is("`synthetic 0`, ...")),
    Field("truth", Map(&Name(&[State, Output]), &Expression), "what is added to the rate of each state, and to what an output reads", Needed),
    Field("start", Map(&STATE, &Number), "the start state", Needed),
    Field("duration", Number, "seconds", Needed),
    Field("step", Number, "seconds between samples", Needed),
    Field("noise", One(&[Word("None"), Call("Relative", &[Number]), Call("Additive", &[Number]), Call("Sensor", &[Map(&MEASURED, &QUANTITY)])]), "`None`, `Relative(0.1)`, `Additive(0.02)` of each column's standard deviation, `Sensor({ \"x\": (1e-6, \"m\") })`", Is("`None`")),
    Field("seed", Whole, "drives noise and random phases", Is("0")),
    Field("inputs", Map(&INPUT, &One(&[Call("Formula", &[Expression]), Group(&JONSWAP), Group(&MULTISINE), Group(&FILE)])), "map of inputs to `Formula(\"A*cos(W*t)\")`, [`Jonswap(...)`](#jonswap), [`Multisine(...)`](#multisine), [`File(...)`](#file)", Is("needed for each input")),
    DERIVE_SHORT_ROW,
    SENSORS_ROW,
    Field("measure", List(&MEASURED), "what is recorded", Is("all outputs, or all states where there are none")),
    Field("window", BOUNDS, "only samples between these times", Is("all")),
    ROLE_ROW,
    INTERPOLATE_SHORT_ROW,
    CONSTANTS_SHORT_ROW,
}

group! { SENSOR = "a sensor", None;
    Field("offset", SENSOR_VALUE, "zero error", Is("0")),
    Field("gain", SENSOR_VALUE, "scale error", Is("1")),
    Field("delay", SENSOR_VALUE, "lateness", Is("0")),
    Field("clock", SENSOR_VALUE, "drift of the sensor's clock: `50e-6` if it loses 50 us in a second", Is("0")),
    Field("lag", SENSOR_VALUE, "time constant of a filter of first order that is faster than the motion; for any order and speed: `lowpass`", Is("0")),
    Field("quantum", QUANTITY, "the step of the column, in SI or as `(0.1, \"mm\")`: no value is known better than `step/sqrt(12)`", Is("seen from the data")),
    Field("per", PER, "of a column of counts, how many make a unit: `(\"rev\", 4096)`, `(\"mm\", 200)`; the same as the unit `\"rev/4096\"`", Is("none")),
    Field("unwrap", TURN, "after how much the column begins anew, in SI: `\"2*pi\"`. Turns are counted from the first row that is read", Is("it does not")),
    Field("average", QUANTITY, "over how long each sample is the mean, up to its time, as many loggers take it: `(10.0, \"ms\")`", Is("0")),
    Field("lowpass", Group(&FILTER), "Butterworth filter that takes off what is faster than its cutoff, `(order: 2, cutoff: (500.0, \"Hz\"))`", Is("none")),
    Field("highpass", Group(&FILTER), "Butterworth filter that takes off what is slower and what is constant (AC coupling)", Is("none")),
}

group! { FILTER = "a filter", None;
    Field("order", Whole, "number of its poles", Needed),
    Field("cutoff", One(&[Number, Tuple(&[Number, Unit]), Group(&FIND), CONSTANT_NAME]), "the frequency at which it halves the power, in Hz", Needed),
}

group! { JONSWAP = "`Jonswap`", Some("Jonswap");
    Field("hs", Number, "significant height", Needed),
    Field("tp", Number, "peak period in seconds", Needed),
    Field("gamma", Number, "peak enhancement", Is("3.3")),
    Field("omega", Tuple(&[Number, Number, Number]), "first and last frequency and their distance in rad/s", Is("`(0.1, 50.0, 0.1)`")),
}

group! { MULTISINE = "`Multisine`", Some("Multisine");
    Field("amplitude", Number, "root mean square of the sum", Needed),
    Field("band", BOUNDS, "lowest and highest frequency in Hz", Needed),
    Field("count", Whole, "how many cosines", Is("20")),
}

group! { FILE = "`File`", Some("File");
    Field("path", File, "the file, in the data folder", Needed),
    Field("time", COLUMN, "the column of time", Needed),
    Field("column", COLUMN, "the column of the input", Needed),
}

group! { LEARN = "`learn`", None;
    Field("optimiser", One(&[Word("RAdam"), Word("Sgd"), Word("GaussNewton")]), "of method step: `RAdam`, `Sgd`, `GaussNewton`", Is("`RAdam`")),
    Field("epochs", List(&Whole), "of method step, for each of its three stages", Is("`[1000, 1000, 1000]`")),
    Field("rates", List(&Number), "learning rates of method step, for each stage", Is("`[0.1, 0.01, 0.001]`")),
    Field("cutoff", Number, "of method step: smaller coefficients are dropped after each stage", Is("0.05")),
    Field("tolerance", Number, "of method step: the speed below which a contact counts as stuck", Is("0.001")),
    Field("crossings", One(&[Word("Keep"), Word("Skip")]), "of method step: `Keep` or `Skip` steps across which a contact's velocity changes sign", Is("`Keep`")),
    Field("selection", One(&[Word("Auto"), Word("All"), Call("Cutoff", &[Number])]), "of method trajectory: `Auto`, `All`, `Cutoff(0.05)`", Is("`Auto`")),
    Field("horizon", Whole, "of method step: samples that each prediction runs over", Is("1")),
    Field("segments", One(&[Word("Auto"), Whole, Call("Count", &[Whole])]), "of method trajectory: into how many segments a record is cut, `Auto` or a number", Is("`Auto`")),
    Field("differentiator", DIFFERENTIATOR, "how the velocities of method step are made: `Spectral`, `SavitzkyGolay`, `Spline`", Is("`SavitzkyGolay`")),
    Field("method", One(&[Word("Step"), Word("Trajectory")]), "`Step` or `Trajectory`", Is("`Trajectory`")),
}

group! { LAW = "a law", None;
    Field("name", Prose, "what it is called", Needed),
    Field("about", Prose, "one sentence", Is("")),
    Field("reference", Prose, "where it comes from", Is("")),
    Field("roles", Map(&Declares(Role), &Unit), "what it knows of its place, with units: a displacement in `\"m\"`, a velocity in `\"m/s\"`, a load in `\"N\"` (a spring or an input of the known part, which `gap` finds)", Is("")),
    Field("parameters", Map(&Declares(Parameter), &Group(&PARAMETER)), "map of numbers to be found to [what they may be](#a-parameter-of-a-law)", Is("")),
    Field("given", Map(&Declares(Given), &Tuple(&[Number, Unit])), "map of numbers that are held: `{ \"V\": (1.0, \"m/s\") }`", Is("")),
    Field("internal", Map(&Declares(Internal), &Group(&INTERNAL)), "map of states of its own to [their rates](#an-internal-state)", Is("")),
    Field("force", Expression, "what is subtracted, in newtons; names that the law does not declare are those of the model; `t` counts from the first sample of all records", Is("")),
    Field("push", Expression, "in place of `force`: what is added", Is("")),
    Field("sensor", One(&[Quoted("offset"), Quoted("gain"), Quoted("delay"), Quoted("lag")]), "in place of `force`: `\"offset\"`, `\"gain\"`, `\"delay\"` or `\"lag\"` of a column, or of all; the one parameter is its value", Is("")),
    Field("input", One(&[Expression, Quoted("gain"), Quoted("delay")]), "in place of `force`: what acts where the model has the recorded input `u`, as an expression of `u`, parameters and internal states: `\"dead(u, d)\"`, `\"gain*u\"`; an input is measured in `\"N\"` here, whatever its unit. Or `\"delay\"`: the input of a while ago", Is("")),
    Field("mirror", Expression, "the mirror image of `force`, which is tried too", Is("")),
    Field("simpler", List(&LawId), "laws that it contains, simplest first; they are tried in its place", Is("")),
    Field("same_as", List(&LawId), "two laws that together are the same force; this one is named in their place", Is("")),
    Field("family", Prose, "two laws of one family never act at one place", Is("")),
    Field("needs", Group(&NEED), "what its parameters must fulfil: `(positive: \"Fs - Fc\", because: \"its friction would grow with the speed\")`", Is("")),
    Field("screen", Group(&SCREEN), "[a hint on how to find it](#screen); most laws need none", Is("")),
    Field("sketch", Group(&SKETCH), "how its picture is drawn: `(over: \"v\", with: { \"d\": 1.0 })`, over `x`, `v` or `t`", Is("")),
    Field("indistinguishable", Group(&INDISTINGUISHABLE), "`(cause: \"...\", check: \"...\")`: another cause that no record can tell from it, and what to check", Is("")),
    Field("told_apart_by", Map(&LawId, &Prose), "map of other laws to the measurement that tells them from this one", Is("")),
}

group! { PARAMETER = "a parameter of a law", None;
    Field("unit", Unit, "its unit where positions are in metres and forces in newtons", Needed),
    Field("within", BOUNDS, "lower and upper bound", Needed),
    Field("each", Truth, "`true`: a value of its own in each record", Is("`false`")),
    Field("whole", Truth, "`true` if the bounds are the whole range, such as one turn of an angle. A value at a bound is then no sign of a wrong law", Is("`false`")),
}

group! { INTERNAL = "an internal state", None;
    Field("unit", Unit, "its unit", Needed),
    Field("rate", Expression, "its rate of change", Needed),
    Field("start", Number, "where it starts", Needed),
    Field("inertia", Expression, "only for the speed of a body that the law adds: the mass of that body, an expression of the parameters. Other laws may then act between this body and the place", Is("")),
}

group! { NEED = "`needs`", None;
    Field("positive", Expression, "an expression of the parameters that is not negative", Needed),
    Field("because", Prose, "why, in words", Needed),
}

group! { SCREEN = "`screen`", None;
    Field("columns", List(&Expression), "expressions that are added to the force, each with a coefficient `c1`, `c2`, ...", Needed),
    Field("rate", Expression, "the rate of the internal state in terms of the grid", Is("")),
    Field("grid", Map(&Declares(Grid), &Unit), "map of numbers that are tried on a grid to their units", Is("")),
    Field("seed", Map(&PARAMETER_NAME, &Expression), "map of every parameter to its start: an expression of the coefficients and the grid", Needed),
}

group! { SKETCH = "`sketch`", None;
    Field("over", One(&[Quoted("x"), Quoted("v"), Quoted("t")]), "what it is drawn over: a displacement, a velocity, or time", Needed),
    Field("with", Map(&PARAMETER_NAME, &Number), "example values of the parameters", Needed),
}

group! { INDISTINGUISHABLE = "`indistinguishable`", None;
    Field("cause", Prose, "the other cause, in words", Needed),
    Field("check", Prose, "what to check on the rig, in words", Needed),
}

/// A stream of a `Csv`: a text has no sheets.
pub static CSV_STREAM: Group =
    Group { owner: "a stream", variant: None, fields: STREAM.fields.split_at(STREAM.fields.len() - 1).0 };
