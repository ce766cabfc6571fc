//! One thing that a model has wrong.

use super::rig::{Physics, Rig};
use crate::dice::{Dice, rounded};

/// What can be wrong.
pub(super) const KINDS: &[&str] =
    &["stiffness", "mass", "no damping", "sign", "drive frequency", "drive phase", "no cubic"];
/// The same so small that it may be lost in the noise: only if asked for.
pub(super) const SMALL: &[&str] = &["stiffness, a little", "damping, a little"];

/// Whether the truth of this kind has a spring that is not straight.
pub(super) fn needs_cubic(kind: &str) -> bool {
    kind == "no cubic"
}

/// The physics with one thing wrong, and what that is. `None` where the rig has nothing of the kind.
pub(super) fn with_mistake(rig: &Rig, kind: &str, dice: &mut Dice) -> Option<(Physics, String)> {
    let mut wrong = rig.physics.clone();
    let number = |wrong: &mut Physics, name: &str, change: &dyn Fn(f64) -> f64| {
        let (_, value) = wrong.constants.iter_mut().find(|(n, _)| n == name)?;
        let before = *value;
        *value = rounded(change(before));
        Some(format!("{name} = {value} in place of {before}"))
    };
    let one = dice.whole(1, rig.count());
    let line = dice.whole(1, rig.lines.max(1));
    let sign = dice.sign();
    let said = match kind {
        "stiffness" => number(&mut wrong, &format!("k{one}"), &|k| k * (1.0 + 0.1 * sign))?,
        "stiffness, a little" => {
            let part = dice.log(0.002, 0.04);
            number(&mut wrong, &format!("k{one}"), &|k| k * (1.0 + part * sign))?
        }
        "damping, a little" => {
            let part = dice.log(0.05, 0.6);
            number(&mut wrong, &format!("c{one}"), &|c| c * (1.0 + part * sign))?
        }
        "mass" => number(&mut wrong, &format!("m{one}"), &|m| m * (1.0 + 0.2 * sign))?,
        "no damping" => {
            wrong.forces.iter_mut().for_each(|f| f.retain(|s| !s.text.starts_with('c')));
            "no damping".to_owned()
        }
        "sign" => {
            let mass = one - 1;
            let which = dice.whole(0, wrong.forces[mass].len() - 1);
            let summand = &mut wrong.forces[mass][which];
            summand.negative = !summand.negative;
            format!("the sign of {} on mass {one}", summand.text)
        }
        "drive frequency" => {
            let part = dice.between(0.01, 0.05);
            number(&mut wrong, &format!("W{line}"), &|w| w * (1.0 + sign * part))?
        }
        "drive phase" => {
            let by = dice.between(0.2, 0.6);
            number(&mut wrong, &format!("p{line}"), &|p| p + sign * by)?
        }
        "no cubic" => {
            wrong.forces.iter_mut().for_each(|f| f.retain(|s| !s.text.starts_with('q')));
            "no cubic spring".to_owned()
        }
        _ => return None,
    };
    // What stands nowhere any more need not be known.
    let used = |name: &str| {
        name.starts_with('m')
            || wrong
                .forces
                .iter()
                .flatten()
                .any(|s| s.text.split(|c: char| !c.is_alphanumeric()).any(|word| word == name))
    };
    let constants = wrong.constants.iter().filter(|(name, _)| used(name)).cloned().collect();
    Some((Physics { constants, ..wrong }, said))
}
