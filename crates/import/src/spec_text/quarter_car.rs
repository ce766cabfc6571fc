//! A body on a wheel on a road: two masses, and the road as the base.

use super::literals::three_digits;
use crate::draft::Draft;
use crate::roles::Input;
use std::f64::consts::TAU;
use std::fmt::Write;

/// The tyre is stiffer than the suspension, and the wheel lighter than the body, by about so much (D. Hrovat, Survey of
/// advanced suspension developments, Automatica 33, 1997).
const TYRE: f64 = 10.0;
/// Numbers that nothing told may be off by this factor.
const WIDE: f64 = 30.0;

/// The frequency of a body on its suspension where the record tells none (Hz).
const BODY: f64 = 1.2;

/// Whether a draft is of a body on a wheel.
pub(super) fn is_one(draft: &Draft) -> bool {
    draft.roles.wheel.is_some() && matches!(draft.roles.input, Input::Base(_))
}

/// Writes everything before `data`.
pub(super) fn write(draft: &Draft, text: &mut String) {
    let pace = TAU * draft.motion.frequency.unwrap_or(BODY);
    let (spring, damper) = (pace * pace, 0.4 * pace);
    text.push_str("    constants: {\n        \"m1\": (1.0, \"kg\"), // EDIT: the mass of the body; with 1 kg all forces are for each kilogram of it\n");
    for (name, value, unit, what) in [
        ("m2", 1.0 / TYRE, "kg", "the mass of the wheel"),
        ("k1", spring, "N/m", "the suspension"),
        ("c1", damper, "N*s/m", "its damper"),
        ("k2", TYRE * spring, "N/m", "the tyre"),
    ] {
        let [value, low, high] = [value, value / WIDE, value * WIDE].map(three_digits);
        let _ = writeln!(
            text,
            "        \"{name}\": (value: {value:?}, unit: \"{unit}\", within: ({low:?}, {high:?})), // EDIT: {what}, a first guess"
        );
    }
    text.push_str(
        r#"    },
    states: { "x1": "m", "v1": "m/s", "x2": "m", "v2": "m/s" },
    inputs: { "u": "m" },
    known: {
        "x1": "v1",
        "v1": "-(k1*(x1 - x2) + c1*(v1 - v2))/m1", // EDIT: the physics that you are sure of
        "x2": "v2",
        "v2": "(k1*(x1 - x2) + c1*(v1 - v2) - k2*(x2 - u))/m2",
    },
    inertia: { "v1": "m1", "v2": "m2" },
    unknown: {},
    contacts: ["v1-v2"], // friction of the suspension; `phisindy gap` tries every law of the catalogue
"#,
    );
}
