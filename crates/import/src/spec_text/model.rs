//! Constants and equations.

use super::literals::three_digits;
use super::notation::Notation;
use crate::draft::Draft;
use crate::roles::Input;
use crate::start_values::Drive;
use std::fmt::Write;

/// Bounds are this factor from a value that a regression told, and its square from one that nothing told:
/// they keep a sign and an order of magnitude, not a guess.
const WIDE: f64 = 100.0;

/// How the other form of a force beside a displacement is written.
const TESTER: &str = r#"    // The data do not tell whether F drives the motion or is what a prescribed motion meets, as in a friction tester. For a tester:
    // states: {}, inputs: { "x": "m", "dx": "m/s" }, outputs: { "F": (unit: "N", reads: "k*x + c*dx") }, known: {},
    // unknown: {}, no inertia and contacts, and in each record derive: { "dx": Derivative("x") }.
"#;

/// Writes `constants`; the load (kg) of the record, if records differ in it, is part of the mass.
pub(super) fn constants(draft: &Draft, notation: &Notation, load: Option<f64>, text: &mut String) {
    let estimate = &draft.estimate;
    text.push_str("    constants: {\n");
    let add = |text: &mut String, name: &str, value: f64, unit: &str, within: (f64, f64), comment: &str| {
        let (low, high) = (three_digits(within.0), three_digits(within.1));
        let value = three_digits(value).clamp(low, high);
        let _ = writeln!(
            text,
            "        \"{name}\": (value: {value:?}, unit: \"{unit}\", within: ({low:?}, {high:?})), // {comment}"
        );
    };
    // The mass that the regression found, or else the one that has about the measured acceleration.
    let told = estimate.input_gain.filter(|b| *b > 0.0).map(|b| 1.0 / b);
    let plausible = || draft.motion.plausible_inertia().unwrap_or(1.0);
    let mass = notation.inertia.map(|_| told.unwrap_or_else(plausible));
    if let (Some((name, unit)), Some(mass)) = (notation.inertia, mass) {
        let (seen, wide) =
            if told.is_some() { ("a first guess", WIDE) } else { ("not seen in the data", WIDE * WIDE) };
        let comment = format!("EDIT: the inertia, {seen}; if you know it: \"{name}\": (1.23, \"{unit}\")");
        match load {
            None => add(text, name, mass, unit, (mass / wide, mass * wide), &comment),
            Some(load) => {
                let bare = if load < mass { mass - load } else { 0.1 * mass };
                add(
                    text,
                    "m0",
                    bare,
                    unit,
                    (0.0, mass * wide),
                    "EDIT: what moves beside the load, a first guess",
                );
                let _ = writeln!(
                    text,
                    "        \"load\": ({load:?}, \"kg\"), \"m\": \"m0 + load\", // each record has its own"
                );
            }
        }
    }
    let per = mass.unwrap_or(1.0);
    if let Some(k) = estimate.stiffness {
        let what = match (draft.motion.is_pendulum, notation.inertia.is_some()) {
            (true, false) => "gravity over length, for a pendulum that hangs at theta = 0",
            (true, true) => "weight times lever, for a pendulum that hangs at theta = 0",
            (false, false) => "stiffness / mass",
            (false, true) => "stiffness",
        };
        let comment = format!("EDIT: {what}, from the data; narrow the bounds if you know better");
        add(text, "k", k * per, notation.spring_unit, (k * per / WIDE, k * per * WIDE), &comment);
    }
    let damping =
        estimate.stiffness.map_or_else(|| 10.0 * estimate.damping.abs().max(0.1), |k| 2.0 * k.sqrt());
    let start = estimate.damping.clamp(0.005 * damping, 0.5 * damping);
    let what = if notation.inertia.is_some() { "viscous damping" } else { "viscous damping / mass" };
    // Ten times critical damping, or as much as was found.
    let most = 10.0 * damping.max(estimate.damping);
    add(text, "c", start * per, notation.damper_unit, (0.0, most * per), &format!("EDIT: {what}"));
    if let Input::Drive(column) = draft.roles.input {
        // Where the regression tells none, the one that the size of drive and acceleration suggest.
        let plausible = || (draft.motion.plausible_inertia().map_or(1.0, f64::recip), WIDE * WIDE);
        let (gain, wide) = estimate.input_gain.filter(|b| *b != 0.0).map_or_else(plausible, |b| (b, 5.0));
        // The gain is for each unit of the column.
        let gain = gain * draft.factor(column);
        let size = wide * gain.abs();
        let comment = "EDIT: acceleration for each unit of the input; either sign";
        add(text, "b", gain, &notation.gain_unit, (-size, size), comment);
    }
    text.push_str("    },\n");
}

/// Writes everything between `constants` and `data`.
pub(super) fn model(draft: &Draft, notation: &Notation, text: &mut String) {
    states(draft, notation, text);
    inputs(draft, notation, text);
    outputs(draft, notation, text);
    known(draft, notation, text);
    inertia(draft, notation, text);
    unknown(draft, notation, text);
}

fn states(draft: &Draft, notation: &Notation, text: &mut String) {
    let edit = match &draft.roles.doubt {
        Some(doubt) => format!(" // EDIT: {doubt}"),
        None if !draft.has_unit() => " // EDIT: the heading gives no unit".to_owned(),
        None => String::new(),
    };
    let Notation { displacement, velocity, displacement_unit, velocity_unit, .. } = notation;
    let _ = writeln!(
        text,
        "    states: {{ \"{displacement}\": \"{displacement_unit}\", \"{velocity}\": \"{velocity_unit}\" }},{edit}"
    );
}

fn inputs(draft: &Draft, notation: &Notation, text: &mut String) {
    let doubt = draft.roles.input_doubt.as_ref().map_or(String::new(), |d| format!(" // EDIT: {d}"));
    let (unit, velocity_unit) = (&notation.input_unit, &notation.velocity_unit);
    let _ = match draft.roles.input {
        Input::None => {
            writeln!(text, "    inputs: {{}}, // EDIT: nothing that acts on it is measured; is it free?")
        }
        Input::Base(_) => {
            writeln!(text, "    inputs: {{ \"u\": \"{unit}\", \"du\": \"{velocity_unit}\" }},{doubt}")
        }
        Input::BaseAcceleration(_) => writeln!(text, "    inputs: {{ \"ab\": \"{unit}\" }},{doubt}"),
        Input::Force(_) | Input::Drive(_) | Input::Reaction(_) => {
            writeln!(text, "    inputs: {{ \"F\": \"{unit}\" }},{doubt}")
        }
    };
}

fn outputs(draft: &Draft, notation: &Notation, text: &mut String) {
    if draft.roles.acceleration.is_some() {
        let (unit, velocity) = (notation.acceleration_unit(), notation.velocity);
        let base = if let Input::BaseAcceleration(_) = draft.roles.input { " + ab" } else { "" };
        let of_base = if base.is_empty() {
            ""
        } else {
            ", which is relative to the base, and the acceleration of the base"
        };
        let _ = writeln!(
            text,
            "    // The sensor reads the rate of {velocity}{of_base}. It does not show a constant force, which shifts the rest as a zero error does, nor a slow drift.\n    \
             outputs: {{ \"a\": (unit: \"{unit}\", reads: \"rate({velocity}){base}\") }},"
        );
    }
}

/// Whether the base moves: springs and dampers then act on the relative motion.
fn is_relative(draft: &Draft) -> bool {
    matches!(draft.roles.input, Input::Base(_))
}

fn known(draft: &Draft, notation: &Notation, text: &mut String) {
    if draft.drive == Drive::Open && matches!(draft.roles.input, Input::Force(_)) && !draft.roles.is_angle {
        text.push_str(TESTER);
    }
    let Notation { displacement, velocity, .. } = notation;
    let (stretch, slip) = if is_relative(draft) {
        (format!("{displacement} - u"), format!("({velocity} - du)"))
    } else {
        ((*displacement).to_owned(), (*velocity).to_owned())
    };
    let stretch = match (draft.motion.is_pendulum, is_relative(draft)) {
        (true, _) => format!("sin({stretch})"),
        (false, true) => format!("({stretch})"),
        (false, false) => stretch,
    };
    let mut rate = format!("-c*{slip}");
    if draft.estimate.stiffness.is_some() {
        let _ = write!(rate, " - k*{stretch}");
    }
    let rate = match (draft.roles.input, notation.inertia) {
        (Input::Force(_), Some((mass, _))) => format!("(F {})/{mass}", rate.replacen('-', "- ", 1)),
        (Input::Drive(_), _) => format!("{rate} + b*F"),
        (Input::BaseAcceleration(_), _) => format!("{rate} - ab"),
        _ => rate,
    };
    let _ = writeln!(
        text,
        "    known: {{\n        \"{displacement}\": \"{velocity}\",\n        \"{velocity}\": \"{rate}\", // EDIT: the physics that you are sure of"
    );
    if draft.estimate.stiffness.is_none() {
        text.push_str("        // The data show no spring. If there is one, add `- k*x` and a constant k.\n");
    }
    text.push_str("    },\n");
}

fn inertia(draft: &Draft, notation: &Notation, text: &mut String) {
    let velocity = notation.velocity;
    if let Some((mass, _)) = notation.inertia {
        let _ = writeln!(text, "    inertia: {{ \"{velocity}\": \"{mass}\" }},");
        return;
    }
    let (mass, unit, force) = match notation.displacement_unit.as_str() {
        "m" if draft.has_unit() => ("m", "kg", "N"),
        "rad" => ("J", "kg*m^2", "N*m"),
        _ => return,
    };
    // The motion alone does not determine the inertia.
    let _ = writeln!(
        text,
        "    // inertia: {{ \"{velocity}\": \"{mass}\" }}, // EDIT: if you know it, with \"{mass}\": (1.23, \"{unit}\") in constants: then forces are in {force}"
    );
}

fn unknown(draft: &Draft, notation: &Notation, text: &mut String) {
    let Notation { displacement, velocity, .. } = notation;
    let _ = writeln!(
        text,
        "    // What may be missing: dry friction at least. Others: {displacement}^3, {velocity}*|{velocity}|; `phisindy gap` tries every \
         law of the catalogue.\n    // If the friction comes out negative, something else is missing."
    );
    let over = notation.inertia.map_or(String::new(), |(mass, _)| format!("/{mass}"));
    let term = match draft.estimate.stiffness {
        // Only a motion of many frequencies distinguishes a hardening spring from a stiff one.
        Some(_) if draft.is_rich() => {
            format!("(factor: \"-1{over}\", candidates: [\"sgn({velocity})\", \"{displacement}^3\"])")
        }
        Some(_) => format!("(factor: \"-sgn({velocity}){over}\", candidates: [\"1\"])"),
        // Without a spring a constant force cannot be an offset of the sensor.
        None => format!("(factor: \"-1{over}\", candidates: [\"sgn({velocity})\", \"1\"])"),
    };
    let _ = writeln!(text, "    unknown: {{\n        \"{velocity}\": {term}, // EDIT: candidates");
    let rubs = if is_relative(draft) {
        format!(
            "EDIT: it rubs on something at rest; on the base: \"{velocity}-du\" here, and sgn({velocity}-du) above"
        )
    } else if let Input::BaseAcceleration(_) = draft.roles.input {
        "it rubs on the base".to_owned()
    } else {
        "it rubs on something at rest".to_owned()
    };
    let _ = writeln!(text, "    }},\n    contacts: [\"{velocity}\"], // {rubs}");
}
