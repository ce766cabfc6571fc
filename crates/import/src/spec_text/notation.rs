//! Names and units of the model.

use crate::draft::Draft;
use crate::headings::Quantity;
use crate::roles::Input;

/// Names and units for one kind of motion.
pub(super) struct Notation {
    /// Names of the two states.
    pub(super) displacement: &'static str,
    pub(super) velocity: &'static str,
    /// Their units.
    pub(super) displacement_unit: String,
    pub(super) velocity_unit: String,
    /// Name and unit of the inertia, if a force is measured.
    pub(super) inertia: Option<(&'static str, &'static str)>,
    /// Units of stiffness, damping, the input and its gain.
    pub(super) spring_unit: &'static str,
    pub(super) damper_unit: &'static str,
    pub(super) input_unit: String,
    pub(super) gain_unit: String,
}

impl Notation {
    /// The unit of what an accelerometer reads.
    pub(super) fn acceleration_unit(&self) -> String {
        format!("{}/s^2", self.displacement_unit)
    }

    pub(super) fn of(draft: &Draft) -> Notation {
        let heading = |c: usize| &draft.table.columns[c].heading;
        let own = heading(draft.moving());
        let (displacement, velocity) = if draft.roles.is_angle { ("theta", "w") } else { ("x", "v") };
        let displacement_unit = match own.quantity {
            Quantity::Electric | Quantity::Count | Quantity::Other if draft.roles.displacement.is_some() => {
                own.unit.clone().unwrap_or_default()
            }
            Quantity::Count | Quantity::Other => {
                integral_unit(draft, own.unit.as_deref().unwrap_or_default())
            }
            _ if draft.roles.is_angle => "rad".to_owned(),
            _ => "m".to_owned(),
        };
        let velocity_unit = format!("{displacement_unit}/s");
        let inertia = match (draft.roles.input, draft.roles.is_angle) {
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
            Input::Base(_) => (displacement_unit.clone(), String::new()),
            Input::BaseAcceleration(_) => (format!("{displacement_unit}/s^2"), String::new()),
            Input::Force(_) | Input::Reaction(_) => {
                (if draft.roles.is_angle { "N*m" } else { "N" }.to_owned(), String::new())
            }
            Input::Drive(c) => {
                let unit = heading(c).unit.clone().unwrap_or_default();
                let gain = format!("{displacement_unit}/s^2");
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
            displacement,
            velocity,
            displacement_unit,
            velocity_unit,
            inertia,
            spring_unit,
            damper_unit,
            input_unit,
            gain_unit,
        }
    }
}

/// The unit of a displacement whose velocity or acceleration is read in another unit than those of lengths and
/// angles: `count` for `count/s`.
fn integral_unit(draft: &Draft, unit: &str) -> String {
    let (per, times) = match draft.roles.velocity {
        Some(_) => ("/s", "*s"),
        None => ("/s^2", "*s^2"),
    };
    match unit.strip_suffix(per) {
        Some(own) => own.to_owned(),
        None if unit.contains('/') => format!("({unit}){times}"),
        None => format!("{unit}{times}"),
    }
}
