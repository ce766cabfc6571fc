//! Names and units of the model.

use crate::draft::Draft;
use crate::headings::Quantity;
use crate::roles::Input;

/// How the model is written down for one kind of motion.
pub(super) struct Notation {
    /// Names of the states.
    pub(super) place: &'static str,
    pub(super) speed: &'static str,
    /// Their units.
    pub(super) place_unit: String,
    pub(super) speed_unit: String,
    /// The inertia, where a force is measured: name and unit.
    pub(super) inertia: Option<(&'static str, &'static str)>,
    /// Units of stiffness, damping, of the input and of what it is multiplied with.
    pub(super) spring_unit: &'static str,
    pub(super) damper_unit: &'static str,
    pub(super) input_unit: String,
    pub(super) gain_unit: String,
}

impl Notation {
    pub(super) fn of(draft: &Draft) -> Notation {
        let heading = |c: usize| &draft.table.columns[c].heading;
        let own = heading(draft.moving());
        let (place, speed) = if draft.roles.angle { ("theta", "w") } else { ("x", "v") };
        let place_unit = match own.quantity {
            Quantity::Electric | Quantity::Other if draft.roles.place.is_some() => {
                own.unit.clone().unwrap_or_default()
            }
            _ if draft.roles.angle => "rad".to_owned(),
            _ => "m".to_owned(),
        };
        let speed_unit = format!("{place_unit}/s");
        let inertia = match (draft.roles.input, draft.roles.angle) {
            (Input::Force(_), false) => Some(("m", "kg")),
            (Input::Force(_), true) => Some(("J", "kg*m^2")),
            _ => None,
        };
        let (spring_unit, damper_unit) = match inertia {
            Some(("m", _)) => ("N/m", "N*s/m"),
            Some(_) => ("N*m", "N*m*s"),
            None => ("1/s^2", "1/s"),
        };
        let (input_unit, gain_unit) = match draft.roles.input {
            Input::None => (String::new(), String::new()),
            Input::Base(_) => (place_unit.clone(), String::new()),
            Input::Force(_) => (if draft.roles.angle { "N*m" } else { "N" }.to_owned(), String::new()),
            Input::Drive(c) => {
                let unit = heading(c).unit.clone().unwrap_or_default();
                let gain = format!("{place_unit}/s^2");
                (
                    unit.clone(),
                    match unit.contains(['*', '/']) {
                        true => format!("{gain}/({unit})"),
                        false if unit.is_empty() => gain,
                        false => format!("{gain}/{unit}"),
                    },
                )
            }
        };
        Notation {
            place,
            speed,
            place_unit,
            speed_unit,
            inertia,
            spring_unit,
            damper_unit,
            input_unit,
            gain_unit,
        }
    }
}
