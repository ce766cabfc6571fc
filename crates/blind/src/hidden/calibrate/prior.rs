//! What a world may be: the priors, of which docs/results.md has the table.

use crate::args::Sensors;
use crate::dice::Dice;
use crate::hidden::sensor_noise::SensorNoise;
use crate::hidden::wish::{Kind, LAWS, PAIRS, Purpose, UNSEEN, Wish};
use crate::hidden::{never, outside};

/// Standard deviation of the noise in parts of that of its column.
const NOISE: (f64, f64) = (0.005, 0.08);

/// Laws of sensors and inputs.
fn is_fault(law: &str) -> bool {
    law.starts_with("sensor-") || law.starts_with("input-")
}

/// A world before anything is known of its rig.
pub(super) fn draw(dice: &mut Dice) -> Wish {
    let forces: Vec<&'static str> =
        LAWS.iter().copied().filter(|law| !is_fault(law)).chain(["hanging-body"]).collect();
    let faults: Vec<&'static str> =
        LAWS.iter().copied().filter(|law| is_fault(law)).chain(["sensor-lag"]).collect();
    let strange: Vec<&'static str> =
        never::names().chain(outside::KINDS.iter().chain(outside::WORLD).copied()).collect();
    let kind = match dice.whole(0, 19) {
        0..=3 => Kind::Nothing,
        4..=9 => Kind::Laws(vec![*dice.pick(&forces)]),
        10..=11 => Kind::Laws(dice.pick(PAIRS).to_vec()),
        12..=15 => Kind::Outside(dice.pick::<&str>(&strange)),
        16..=17 => Kind::Laws(vec![*dice.pick(&faults)]),
        18 => Kind::Outside(dice.pick::<&str>(outside::SENSORS)),
        _ => Kind::Constant(dice.pick::<&str>(&["k", "c", "m"])),
    };
    let twice = matches!(&kind, Kind::Laws(laws) if laws.len() == 2 && laws[0] == laws[1]);
    let sensors = match dice.whole(0, 19) {
        0..=7 => Sensors::Mixed,
        8..=14 => Sensors::Displacement,
        _ => Sensors::Acceleration,
    };
    // An accelerometer shows neither a constant force nor a fault of another sensor.
    let seen = match &kind {
        Kind::Laws(laws) => !laws.iter().any(|law| UNSEEN.contains(law)),
        Kind::Outside(kind) => !outside::SENSORS.contains(kind),
        Kind::Nothing | Kind::Constant(_) => true,
    };
    Wish {
        kind,
        noise: dice.log(NOISE.0, NOISE.1),
        two_masses: twice || dice.chance(0.25),
        holds: dice.chance(0.5),
        sensors: if seen { sensors } else { Sensors::Mixed },
        purpose: Purpose::World(SensorNoise::draw(dice)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The classes have the shares that the documents state: within five standard errors of 2000 draws.
    #[test]
    fn every_class_has_its_share() {
        let worlds: Vec<Wish> = (0..2000).map(|k| draw(&mut Dice::new(k, "world"))).collect();
        type Class<'a> = &'a dyn Fn(&Kind) -> bool;
        let share = |of: Class<'_>| worlds.iter().filter(|w| of(&w.kind)).count() as f64 / 2000.0;
        let classes: [(Class<'_>, f64); 5] = [
            (&|k| *k == Kind::Nothing, 0.2),
            (&|k| matches!(k, Kind::Laws(laws) if laws.len() == 1 && !is_fault(laws[0])), 0.3),
            (&|k| matches!(k, Kind::Laws(laws) if laws.len() == 2), 0.1),
            (&|k| matches!(k, Kind::Outside(k) if !outside::SENSORS.contains(k)), 0.2),
            (&|k| matches!(k, Kind::Constant(_)), 0.05),
        ];
        for (k, (of, due)) in classes.into_iter().enumerate() {
            let error = (due * (1.0 - due) / 2000.0).sqrt();
            assert!((share(of) - due).abs() < 5.0 * error, "class {k}: {}", share(of));
        }
        assert!(worlds.iter().all(|w| (NOISE.0..=NOISE.1).contains(&w.noise)));
    }
}
