//! Effects that no law of the catalogue describes.

use super::effect::{Action, Effect, Scales};
use super::place::Place;
use super::rig::Rig;
use crate::dice::{Dice, rounded};

/// Their names.
pub(super) const KINDS: &[&str] = &[
    "saturating-spring",
    "septic-stiffness",
    "corrugated-friction",
    "time-varying-mass",
    "smooth-bouc-wen",
    "exponential-wall",
    "fading-friction",
    "chirp-force",
];

/// Those that only worlds have: another law of the decks would change the sets of every seed.
pub(super) const WORLD: &[&str] = &[
    "odd-exponential-damper",
    "position-speed-force",
    "leaky-hysteresis",
    "several-tones",
    "pulse-force",
    "nonlinear-hanging-body",
];

/// Faults of sensors.
pub(super) const SENSORS: &[&str] = &["clipped-sensor", "bent-sensor"];

/// Draws one of them.
pub(super) fn draw(
    kind: &str,
    place: &Place,
    s: Scales,
    rig: &Rig,
    duration: f64,
    dice: &mut Dice,
    holds: bool,
) -> Option<Effect> {
    let a = dice.log(0.03, 0.6) * s.force;
    let friction = if holds { dice.log(0.2, 0.7) } else { dice.log(0.03, 0.5) } * s.force;
    let (w0, phase) = (rig.natural, dice.between(-3.0, 3.0));
    let mut internal = vec![];
    let (parameters, force): (Vec<(&'static str, f64)>, &str) = match kind {
        "saturating-spring" => (vec![("A", a), ("s", dice.between(0.3, 0.7) * s.x)], "A*tanh((X/s)^5)"),
        "septic-stiffness" => (vec![("A", dice.log(0.1, 3.0) * s.force), ("s", s.x)], "A*(X/s)^7"),
        "corrugated-friction" => (
            vec![
                ("A", friction),
                ("B", friction * dice.between(0.4, 0.9)),
                ("q", dice.between(5.0, 14.0) / s.x),
            ],
            "(A + B*sin(q*X))*sgn(Y)",
        ),
        "smooth-bouc-wen" => {
            let d = dice.between(0.15, 0.5) * s.x;
            internal = vec![("z".to_owned(), "Y - (b*abs(Y)*z*abs(z) + g*Y*z^2)".to_owned())];
            let b = dice.between(0.6, 0.9) / (d * d);
            (vec![("A", dice.log(0.1, 0.6) * s.force / d), ("b", b), ("g", dice.sign() * 0.4 * b)], "A*z")
        }
        "exponential-wall" => {
            (vec![("A", a), ("s", dice.between(0.12, 0.3) * s.x)], "A*(exp(X/s)*exp(-2.5)-exp(-2.5))")
        }
        "fading-friction" => {
            (vec![("A", friction), ("T", duration * dice.between(0.15, 0.5))], "A*exp(-t/T)*sgn(Y)")
        }
        "chirp-force" => (
            vec![
                ("A", a),
                ("w", w0 * dice.between(0.3, 0.8)),
                ("r", w0 * dice.between(0.3, 1.0) / duration),
                ("b", phase),
            ],
            "(-A*cos(w*t + r*t^2 + b))",
        ),
        "odd-exponential-damper" => (
            vec![("A", dice.log(0.3, 3.0) * s.force / s.v.powi(3)), ("s", dice.between(0.2, 0.6) * s.v)],
            "A*Y^3*exp(-abs(Y)/s)",
        ),
        "position-speed-force" => (
            vec![
                ("A", dice.sign() * dice.log(0.1, 0.8) * s.force / (s.x * s.v)),
                ("B", dice.log(0.1, 0.8) * s.force / (s.x.powi(3) * s.v.powi(2))),
            ],
            "A*X*Y + B*X^3*Y^2",
        ),
        "leaky-hysteresis" => {
            let d = dice.between(0.15, 0.6) * s.x;
            internal = vec![("z".to_owned(), "Y - abs(Y)*z/d - z/T".to_owned())];
            (vec![("A", dice.log(0.1, 0.6) * s.force / d), ("d", d), ("T", dice.log(0.5, 4.0) / w0)], "A*z")
        }
        "several-tones" => (
            vec![
                ("A", a),
                ("a", w0 * dice.between(0.2, 0.6)),
                ("B", a * dice.between(0.4, 1.0)),
                ("b", w0 * dice.between(0.7, 1.3)),
                ("C", a * dice.between(0.4, 1.0)),
                ("c", w0 * dice.between(1.4, 2.2)),
                ("f", phase),
            ],
            "(-(A*cos(a*t + f) + B*cos(b*t + 2*f) + C*cos(c*t - f)))",
        ),
        "pulse-force" => (
            vec![
                ("A", dice.sign() * dice.log(0.1, 1.5) * s.force),
                ("T", duration * dice.between(0.15, 0.5)),
                ("s", dice.log(0.3, 3.0) / w0),
            ],
            "(-A*exp(-((t-T)/s)^2))",
        ),
        "nonlinear-hanging-body" => {
            let (m, w) = (rig.mass[place.parts[0].0] * dice.log(0.05, 0.4), w0 * dice.log(0.5, 2.0));
            let hung = "k*hs + q*hs^3 + c*(Y - hw)";
            internal = vec![("hs".to_owned(), "Y - hw".to_owned()), ("hw".to_owned(), format!("({hung})/m"))];
            let k = m * w * w;
            (
                vec![
                    ("k", k),
                    ("q", k * dice.log(0.3, 5.0) / (s.x * s.x)),
                    ("m", m),
                    ("c", 2.0 * dice.log(0.02, 0.2) * m * w),
                ],
                "(k*hs + q*hs^3 + c*(Y - hw))",
            )
        }
        "time-varying-mass" => {
            let mass = place.parts[0].0;
            let (e, w) = (rounded(dice.log(0.03, 0.5)), rounded(w0 * dice.between(0.1, 0.7)));
            let factor = if dice.chance(0.5) {
                format!("1/(1+({e:e})*sin(({w:e})*t))")
            } else {
                format!("1/(1+({:e})*t/({duration:e}))", 2.0 * e)
            };
            let action = Action::Factor { mass, factor };
            let at = rig.v[mass].clone();
            return Some(Effect {
                law: kind.to_owned(),
                at,
                parameters: vec![("e", e), ("w", w)],
                second_phase: None,
                action,
            });
        }
        _ => return None,
    };
    let parameters = parameters.into_iter().map(|(n, x)| (n, rounded(x))).collect();
    let action = Action::Force { place: place.clone(), force: force.to_owned(), internal };
    Some(Effect { law: kind.to_owned(), at: place.at.clone(), parameters, second_phase: None, action })
}
