//! What people call the columns of a file, as parts of a heading.

/// Names of a displacement or an angle.
pub(super) const PLACES: &[&str] = &[
    "x",
    "y",
    "z",
    "q",
    "s",
    "pos",
    "position",
    "disp",
    "displacement",
    "weg",
    "laser",
    "lvdt",
    "encoder",
    "theta",
    "phi",
    "angle",
    "alpha",
    "winkel",
    "mass",
    "deflection",
    "stroke",
    "out",
    "output",
    "response",
    "travel",
    "auslenkung",
];
/// Names of what a sensor reads.
pub(super) const OUTPUTS: &[&str] = &["y", "out", "output", "response", "sensor", "measured"];
/// Names of the motion of what the body hangs on.
pub(super) const BASES: &[&str] = &[
    "u",
    "xb",
    "xg",
    "ub",
    "ug",
    "base",
    "ground",
    "table",
    "shaker",
    "floor",
    "support",
    "foundation",
    "exc",
    "excitation",
    "input",
    "boden",
    "fuss",
    "wall",
    "sockel",
];
/// Words for what is no measurement: another form of a column that is there too.
pub(super) const COPIES: &[&str] = &[
    "true",
    "truth",
    "exact",
    "ideal",
    "model",
    "sim",
    "simulated",
    "pred",
    "predicted",
    "prediction",
    "fit",
    "fitted",
    "est",
    "estimate",
    "estimated",
    "filt",
    "filtered",
    "smooth",
    "smoothed",
];
/// Names of a command.
pub(crate) const ORDERS: &[&str] =
    &["ref", "reference", "goal", "target", "set", "setpoint", "desired", "cmd", "command", "soll", "demand"];
/// Names of an acceleration.
pub(super) const ACCELERATIONS: &[&str] =
    &["a", "acc", "accel", "acceleration", "ddx", "xddot", "beschleunigung"];
/// Names of a force, or of what drives in proportion to one.
pub(super) const FORCES: &[&str] = &[
    "f",
    "force",
    "kraft",
    "torque",
    "moment",
    "tau",
    "thrust",
    "u",
    "in",
    "input",
    "drive",
    "exc",
    "excitation",
    "motor",
    "voltage",
    "current",
    "load",
    "vir",
];
