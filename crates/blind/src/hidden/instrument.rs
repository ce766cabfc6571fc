//! What is wrong with an instrument, or with a number of the spec.

use super::effect::{Action, Effect, Property};
use super::rig::{Constant, Drive, Rig};
use crate::dice::{Dice, rounded};

/// Draws what is wrong with the recorded drive of a rig; `None` for any other law, and where the drive is not
/// recorded.
pub(super) fn draw_input(law: &str, rig: &Rig, dice: &mut Dice) -> Option<Effect> {
    let at = match rig.drive {
        Drive::Force(_) => "F",
        Drive::Base { .. } => "u",
        Drive::Explicit(_) | Drive::Free => return None,
    };
    let (name, value) = match law {
        "input-gain" => ("gain", 1.0 + dice.sign() * dice.log(0.02, 0.3)),
        "input-delay" => ("tau", dice.log(0.01, 0.15) / rig.natural),
        _ => return None,
    };
    let value = rounded(value);
    let (gain, delay) = if name == "gain" { (value, 0.0) } else { (1.0, value) };
    let action = Action::Input { gain, delay };
    Some(Effect {
        law: law.to_owned(),
        at: at.to_owned(),
        parameters: vec![(name, value)],
        second_phase: None,
        action,
    })
}

/// Draws a constant whose name begins with a letter and that is not what the spec says; `None` if the rig has none.
pub(super) fn draw_constant(letter: &str, rig: &Rig, dice: &mut Dice) -> Option<Effect> {
    const NAMES: &[&str] = &["m", "m1", "m2", "k", "k1", "k2", "k3", "c", "c1", "c2", "c3"];
    let fixed = |c: &Constant| c.movable.is_none() && c.name.starts_with(letter);
    let all: Vec<usize> = (0..rig.constants.len()).filter(|&i| fixed(&rig.constants[i])).collect();
    let index = *dice.pick(all.first().map(|_| &all[..])?);
    let constant = &rig.constants[index];
    let value = rounded(constant.value * (1.0 + dice.log(0.03, 0.6)).powf(dice.sign()));
    let name = NAMES.iter().find(|name| **name == constant.name)?;
    Some(Effect {
        law: phisindy_gap::CHANGED.to_owned(),
        at: constant.name.clone(),
        parameters: vec![(name, value)],
        second_phase: None,
        action: Action::Constant { index, value },
    })
}

/// Draws a property of one column or of all. `columns` are their names and sizes; `None` for any other law.
pub(super) fn draw_sensor(
    law: &str,
    columns: &[(String, f64)],
    displacements: usize,
    w0: f64,
    dice: &mut Dice,
) -> Option<Effect> {
    let any = dice.whole(0, columns.len() - 1);
    let (property, name) = match law {
        "sensor-delay" => (Property::Delay, "tau"),
        "sensor-gain" => (Property::Gain, "gain"),
        "sensor-offset" => (Property::Offset, "offset"),
        "clipped-sensor" => (Property::Clip, "top"),
        "bent-sensor" => (Property::Bend, "bend"),
        "sensor-lag" => (Property::Lag, "tau"),
        _ => return None,
    };
    // Of all columns at once only what does not depend on their units.
    let units = matches!(property, Property::Offset | Property::Clip | Property::Bend);
    let common = !units && dice.chance(0.35);
    // Offsets are mostly those of displacements.
    let column = if property == Property::Offset && dice.chance(0.8) { any % displacements } else { any };
    let value = rounded(match property {
        Property::Delay => dice.log(0.003, 0.15) / w0,
        Property::Gain => 1.0 + dice.sign() * dice.log(0.01, 0.3),
        Property::Offset => dice.sign() * dice.log(0.01, 1.5) * columns[column].1,
        Property::Clip => dice.between(0.5, 0.95) * columns[column].1,
        Property::Bend => dice.sign() * dice.log(0.02, 0.3) / columns[column].1,
        Property::Lag => dice.log(0.01, 0.2) / w0,
    });
    let at = if common { "motion".to_owned() } else { columns[column].0.clone() };
    let column = (!common).then_some(column);
    let action = Action::Sensor { column, property, value };
    Some(Effect { law: law.to_owned(), at, parameters: vec![(name, value)], second_phase: None, action })
}
