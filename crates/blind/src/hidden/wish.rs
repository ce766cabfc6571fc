//! The requirements of a set: a shuffled deck of wishes, which every few dozen sets go through once.

use super::outside;
use super::sensor_noise::SensorNoise;
use crate::args::Sensors;
use crate::dice::Dice;

/// What is hidden.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Nothing,
    /// Ids of laws, one or two.
    Laws(Vec<&'static str>),
    /// A kind of effect that no law describes.
    Outside(&'static str),
    /// A constant of the spec whose name begins with this letter is not what the spec says.
    Constant(&'static str),
}

/// What a set is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Purpose {
    /// A blind test: what is hidden can be told from all that is not.
    Blind,
    /// A formula: forced by several cosines, the constants known, and a record that tells the force of the right
    /// formula to this accuracy.
    Formula(f64),
    /// A world as the priors of `calibrate` have it, with this noise: what is hidden can be seen, and no more.
    World(SensorNoise),
}

/// The requirements of a set.
#[derive(Clone, Debug)]
pub(super) struct Wish {
    pub(super) kind: Kind,
    pub(super) noise: f64,
    pub(super) two_masses: bool,
    /// Whether a friction is to hold a mass at rest somewhere.
    pub(super) holds: bool,
    pub(super) sensors: Sensors,
    pub(super) purpose: Purpose,
}

/// Laws that an accelerometer does not show: a constant force, which is also what makes friction asymmetric,
/// and what is wrong with a sensor that is not there.
pub(super) const UNSEEN: &[&str] =
    &["offset", "asymmetric-coulomb", "sensor-delay", "sensor-gain", "sensor-lag", "sensor-offset"];

/// Every law of the catalogue.
pub(super) const LAWS: &[&str] = &[
    "viscous",
    "stiffness",
    "quadratic-drag",
    "coulomb",
    "asymmetric-coulomb",
    "stribeck",
    "dieterich-ruina",
    "position-dependent-friction",
    "presliding",
    "cubic-stiffness",
    "quadratic-stiffness",
    "dead-zone",
    "one-sided-stop",
    "offset",
    "harmonic-force",
    "parametric-stiffness",
    "van-der-pol",
    "sensor-delay",
    "sensor-gain",
    "sensor-offset",
    "drifting-friction",
    "load-dependent-friction",
    "cogging",
    "power-law-damping",
    "cubic-damping",
    "quintic-stiffness",
    "bilinear-stiffness",
    "bouc-wen",
    "lugre",
    "maxwell",
    "maxwell-slip",
    "backlash",
    "input-delay",
    "input-gain",
];

/// Two effects at once.
pub(super) const PAIRS: &[[&str; 2]] = &[
    ["coulomb", "cubic-stiffness"],
    ["coulomb", "viscous"],
    ["viscous", "offset"],
    ["stribeck", "cubic-stiffness"],
    ["dead-zone", "coulomb"],
    ["coulomb", "offset"],
    ["quadratic-drag", "cubic-stiffness"],
    ["viscous", "cubic-stiffness"],
    ["coulomb", "sensor-offset"],
    ["coulomb", "sensor-gain"],
    ["harmonic-force", "viscous"],
    ["one-sided-stop", "coulomb"],
    ["stiffness", "coulomb"],
    ["cubic-stiffness", "offset"],
    ["quadratic-stiffness", "viscous"],
    ["coulomb", "coulomb"],
    ["cubic-stiffness", "sensor-delay"],
    ["harmonic-force", "coulomb"],
];

/// Laws that can hold a mass at rest: once in a deck they do, once they never do.
pub(super) const HOLDING: &[&str] = &[
    "coulomb",
    "asymmetric-coulomb",
    "stribeck",
    "dieterich-ruina",
    "position-dependent-friction",
    "drifting-friction",
    "load-dependent-friction",
];

/// Sets in a deck: all laws, those that can hold a second time, and the others.
const DECK: usize = 67;
const NOTHING: usize = 14;
const TWO: usize = 7;

/// The wish of a set. `only` restricts it to one law, or to `nothing`, `two`, `outside`.
///
/// # Errors
/// There is no such law.
pub(super) fn wish(seed: u64, index: usize, only: Option<&str>, sensors: Sensors) -> Result<Wish, String> {
    let (block, place) = (index / DECK, index % DECK);
    let mut deck: Vec<usize> = (0..DECK).collect();
    let mut shuffle = Dice::new(seed, &format!("deck {block}"));
    for k in (1..DECK).rev() {
        deck.swap(k, shuffle.whole(0, k));
    }
    let mut dice = Dice::new(seed, &format!("wish {index}"));
    let pair = |dice: &mut Dice| Kind::Laws(dice.pick(PAIRS).to_vec());
    let beyond = |dice: &mut Dice| Kind::Outside(dice.pick::<&str>(outside::KINDS));
    let singles = LAWS.len() + HOLDING.len();
    let kind = match (only, deck[place]) {
        (Some("nothing"), _) => Kind::Nothing,
        (Some("two"), _) => pair(&mut dice),
        (Some("outside"), _) => beyond(&mut dice),
        (Some(law), _) => {
            match (LAWS.iter().find(|l| **l == law), outside::KINDS.iter().find(|k| **k == law)) {
                (Some(law), _) => Kind::Laws(vec![law]),
                (None, Some(kind)) => Kind::Outside(kind),
                (None, None) => {
                    return Err(format!(
                        "there is no law `{law}`; there is: nothing, two, outside, {}",
                        LAWS.join(", ")
                    ));
                }
            }
        }
        (None, k) if k < LAWS.len() => Kind::Laws(vec![LAWS[k]]),
        (None, k) if k < singles => Kind::Laws(vec![HOLDING[k - LAWS.len()]]),
        (None, k) if k < singles + NOTHING => Kind::Nothing,
        (None, k) if k < singles + NOTHING + TWO => pair(&mut dice),
        (None, _) => beyond(&mut dice),
    };
    let seen = |law: &&'static str| sensors != Sensors::Acceleration || !UNSEEN.contains(law);
    let kind = match kind {
        // Another law in the place of one that nobody could see.
        Kind::Laws(laws) if !laws.iter().all(&seen) => {
            let others: Vec<&'static str> = LAWS.iter().copied().filter(seen).collect();
            Kind::Laws(vec![*dice.pick(&others)])
        }
        kind => kind,
    };
    let twice = matches!(&kind, Kind::Laws(laws) if laws.len() == 2 && laws[0] == laws[1]);
    let holds = match (&kind, only) {
        (Kind::Laws(laws), None) if laws.len() == 1 && HOLDING.contains(&laws[0]) => {
            deck[place] >= LAWS.len()
        }
        _ => dice.chance(0.5),
    };
    Ok(Wish {
        kind,
        noise: *dice.pick(&[0.01, 0.02, 0.05]),
        two_masses: twice || dice.chance(0.4),
        holds,
        sensors,
        purpose: Purpose::Blind,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deck_holds_every_law_once_and_a_fifth_of_nothing() {
        let kinds: Vec<Kind> =
            (0..DECK).map(|k| wish(5, k, None, Sensors::Mixed).expect("a wish").kind).collect();
        for law in LAWS {
            let times = 1 + usize::from(HOLDING.contains(law));
            assert_eq!(kinds.iter().filter(|k| **k == Kind::Laws(vec![law])).count(), times, "{law}");
        }
        assert!(kinds.iter().filter(|k| **k == Kind::Nothing).count() * 5 >= DECK);
        assert!(wish(0, 0, Some("nonsense"), Sensors::Mixed).is_err());
    }
}
