//! Words in headings, by role.

use crate::headings::{Heading, VELOCITIES};

/// Whether a heading has a word of any role.
pub(crate) fn is_word_of_a_role(heading: &Heading) -> bool {
    let roles = [DISPLACEMENTS, OUTPUTS, BASES, ACCELERATIONS, FORCES, VELOCITIES];
    roles.iter().any(|words| heading.has_word(words))
}

/// Words for a displacement or an angle.
pub(crate) const DISPLACEMENTS: &[&str] = &[
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
    "lage",
    "hub",
    "verschiebung",
    "drehwinkel",
    "enc",
    "geber",
    "drehgeber",
    "resolver",
];
/// Words for an encoder, which counts.
pub(crate) const ENCODERS: &[&str] =
    &["enc", "encoder", "geber", "drehgeber", "inkrementalgeber", "quad", "qei"];
/// Words for a measured output.
pub(super) const OUTPUTS: &[&str] = &["y", "out", "output", "response", "sensor", "measured"];
/// Words for the motion of the base.
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
    "road",
    "foundation",
    "exc",
    "excitation",
    "input",
    "boden",
    "fuss",
    "wall",
    "sockel",
    "fusspunkt",
    "fußpunkt",
    "basis",
    "fundament",
    "tisch",
    "unterlage",
    "podest",
    "anregung",
    "erregung",
];
/// Words for a copy of another column: simulated, filtered, fitted.
pub(crate) const COPIES: &[&str] = &[
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
/// Words for a command.
pub(crate) const COMMANDS: &[&str] =
    &["ref", "reference", "goal", "target", "set", "setpoint", "desired", "cmd", "command", "soll", "demand"];
/// Words for an acceleration.
pub(crate) const ACCELERATIONS: &[&str] = &[
    "a",
    "acc",
    "accel",
    "acceleration",
    "ddx",
    "xddot",
    "beschleunigung",
    "ax",
    "ay",
    "az",
    "accx",
    "accy",
    "accz",
];
/// Words for a displacement that is a length.
pub(crate) const LENGTHS: &[&str] = &[
    "x",
    "y",
    "z",
    "s",
    "disp",
    "displacement",
    "weg",
    "laser",
    "lvdt",
    "mass",
    "deflection",
    "stroke",
    "travel",
    "auslenkung",
    "hub",
    "verschiebung",
];
/// Words for a torque, which acts on an angle.
pub(crate) const TORQUES: &[&str] = &["torque", "moment", "tau", "drehmoment"];
/// Words for an angle.
pub(super) const ANGLES: &[&str] =
    &["theta", "phi", "angle", "alpha", "winkel", "drehwinkel", "thetadot", "omega"];
/// Words for a force or a drive.
pub(crate) const FORCES: &[&str] = &[
    "f",
    "force",
    "kraft",
    "torque",
    "moment",
    "tau",
    "thrust",
    "effort",
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
    "pwm",
    "duty",
    "amps",
    "iq",
    "spannung",
    "strom",
    "drehmoment",
    "antrieb",
    "stellgröße",
    "stellgroesse",
];
