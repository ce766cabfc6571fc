//! The truth in the form of `truth.json`.

use super::effect::{Action, Effect};
use super::place::places;
use super::rig::{Drive, Rig};
use super::rivals::{Judgement, only_column};
use super::truth::{Hidden, Placed};

/// Laws that do not depend on the displacement.
const SPEED_ONLY: [&str; 5] = ["viscous", "quadratic-drag", "coulomb", "stribeck", "dieterich-ruina"];

/// Other descriptions of the same force.
pub(super) fn alternatives(
    effects: &[Effect],
    judgement: &Judgement,
    rig: &Rig,
    measured: &[(usize, String)],
) -> Vec<Vec<Placed>> {
    let (columns, column) = (measured.len(), measured[0].1.as_str());
    let base = matches!(rig.drive, Drive::Base { .. });
    let placed = |law: &str, at: &str| Placed { law: law.to_owned(), at: at.to_owned() };
    let mut all: Vec<Vec<Placed>> =
        judgement.same.iter().map(|set| set.iter().map(|(law, at)| placed(law, at)).collect()).collect();
    let put = |k: usize, with: Vec<Placed>| {
        let mut set: Vec<Placed> = Vec::new();
        for (i, e) in effects.iter().enumerate() {
            if i == k {
                set.extend(with.clone())
            } else {
                set.push(Placed { law: e.law.clone(), at: e.at.clone() })
            }
        }
        set
    };
    for (k, e) in effects.iter().enumerate() {
        let mut more = Vec::new();
        if e.law == "asymmetric-coulomb" {
            more.push(put(k, vec![placed("coulomb", &e.at), placed("offset", &e.at)]));
        }
        // A force that does not depend on the motion is the same at the moving wall.
        if base && matches!(e.law.as_str(), "offset" | "harmonic-force") && !e.at.contains('-') {
            more.push(put(k, vec![placed(&e.law, &format!("{}-du", e.at))]));
        }
        let others = || effects.iter().enumerate().filter(move |(i, _)| *i != k).map(|(_, other)| other);
        let linear = others().all(|other| SPEED_ONLY.contains(&other.law.as_str()));
        // On linear springs a constant force shifts the motion as an offset of its sensor does. Beside
        // Coulomb friction both together are one law.
        if linear && rig.count() == 1 && e.law == "sensor-offset" && rig.x.contains(&e.at) {
            more.push(put(k, vec![placed("offset", &rig.v[0])]));
            if let Some(other) = others().find(|other| other.law == "coulomb") {
                more.push(vec![placed("asymmetric-coulomb", &other.at)]);
            }
        }
        // For a mass that only hangs on another one, a sensor offset is a constant force between them.
        if linear && rig.count() == 2 && !rig.both_walls() {
            let between = format!("{}-{}", rig.v[0], rig.v[1]);
            if e.law == "sensor-offset" && e.at == rig.x[1] {
                more.push(put(k, vec![placed("offset", &between)]));
            }
            if e.law == "offset" && e.at == between {
                more.push(put(k, vec![placed("sensor-offset", &rig.x[1])]));
            }
        }
        if effects.len() == 1 {
            more.extend(
                of_one_drive(e, rig, (columns, column)).into_iter().map(|placed| put(k, vec![placed])),
            );
        }
        // All columns are one column here.
        if only_column(e, columns) {
            more.push(put(k, vec![placed(&e.law, if e.at == "motion" { column } else { "motion" })]));
        }
        all.extend(more);
    }
    // A spring or a damper with another number is another number of the spec.
    let own: Vec<Placed> = effects.iter().map(|e| placed(&e.law, &e.at)).collect();
    let linear = |law: &Placed| {
        let letter = match law.law.as_str() {
            "stiffness" => "k",
            "viscous" => "c",
            _ => return None,
        };
        constant_at(rig, &law.at, letter).map(|name| placed(phisindy_gap::CHANGED, &name))
    };
    let changed: Vec<Vec<Placed>> = std::iter::once(&own)
        .chain(&all)
        .flat_map(|set| {
            let with = |k: usize| Some([&set[..k], &[linear(&set[k])?], &set[k + 1..]].concat());
            (0..set.len()).filter_map(with).collect::<Vec<_>>()
        })
        .collect();
    all.extend(changed);
    let mut unique: Vec<Vec<Placed>> = Vec::new();
    for mut set in all {
        set.sort();
        if !unique.contains(&set) {
            unique.push(set);
        }
    }
    unique
}

/// The constant of a spring (`k`) or damper (`c`) that acts at a place and is not found by the model itself.
fn constant_at(rig: &Rig, at: &str, letter: &str) -> Option<String> {
    let place = places(rig).into_iter().find(|p| p.at == at && p.spring.is_some())?;
    let number = if place.parts.len() == 2 { 1 } else { 2 * place.parts[0].0 };
    let name = rig.named(letter, number);
    rig.constants.iter().any(|c| c.name == name && c.movable.is_none()).then_some(name)
}

/// Laws of an input, and of a sensor that shows the same.
const OF_INPUT_AND_SENSOR: [(&str, &str); 3] =
    [("input-delay", "sensor-delay"), ("input-gain", "sensor-gain"), ("input-lag", "sensor-lag")];

/// A delay, a lag or a gain of the one recorded drive and of the one column are the same: what acts late shows late,
/// and on linear springs a scale of the drive is one of the motion.
fn of_one_drive(e: &Effect, rig: &Rig, (columns, column): (usize, &str)) -> Vec<Placed> {
    let input = match rig.drive {
        Drive::Base { .. } => "u",
        Drive::Force(_) => "F",
        _ => return vec![],
    };
    let placed = |law: &str, at: &str| Placed { law: law.to_owned(), at: at.to_owned() };
    let mut all = Vec::new();
    for (of_input, of_sensor) in OF_INPUT_AND_SENSOR {
        if e.law == of_input {
            all.push(placed(of_sensor, "motion"));
            if columns == 1 {
                all.push(placed(of_sensor, column));
            }
        }
        if e.law == of_sensor && (e.at == "motion" || columns == 1) {
            all.push(placed(of_input, input));
        }
    }
    all
}

/// An effect with its values.
pub(super) fn hidden(effect: &Effect) -> Hidden {
    let expression = match &effect.action {
        Action::Force { force, internal, .. } => {
            let own = |text: &str| effect.at_its_place(text);
            let with = |(name, rate): &(String, String)| format!(" with d{name}/dt = {}", own(rate));
            own(force) + &internal.iter().map(with).collect::<String>()
        }
        Action::Sensor { property, .. } => format!("{property:?}").to_lowercase(),
        Action::Input { gain, delay } => format!("the drive times {gain}, {delay} s later"),
        Action::Factor { factor, .. } => format!("rate times {factor}"),
        Action::Constant { value, .. } => format!("it is {value}"),
    };
    let mut parameters: std::collections::BTreeMap<String, f64> =
        effect.parameters.iter().map(|(n, x)| ((*n).to_owned(), *x)).collect();
    if let Some(second) = effect.second_phase
        && effect.parameter("phase") != Some(second)
    {
        // The records have different phases.
        parameters.remove("phase");
    }
    Hidden { law: effect.law.clone(), at: effect.at.clone(), parameters, expression }
}

/// A description of the rig for readers.
pub(super) fn described(rig: &Rig, records: usize) -> String {
    let drive = match rig.drive {
        Drive::Explicit(on) => format!("{} cosines on mass {} in `known`", rig.lines.len(), on + 1),
        Drive::Force(on) => format!("measured force of {} cosines on mass {}", rig.lines.len(), on + 1),
        Drive::Base { derived } => {
            format!(
                "wall moved by {} cosines, du {}",
                rig.lines.len(),
                if derived { "derived" } else { "measured" }
            )
        }
        Drive::Free => "released".to_owned(),
    };
    let how = if records == 1 { "one run in two windows" } else { "two runs" };
    format!("{} scale, {} masses, {drive}; {how}", rig.scale, rig.count())
}
