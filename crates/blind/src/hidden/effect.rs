//! A hidden effect: an addition to the known part.

use super::place::Place;
use crate::dice::Dice;
use crate::names::substitute;

/// What an effect acts on.
#[derive(Clone, Debug)]
pub(super) enum Action {
    /// A force at a place, subtracted as in its law, with internal states (name and rate) for some laws.
    Force { place: Place, force: String, internal: Vec<(String, String)> },
    /// What acts is the recorded drive times a gain, a delay later.
    Input { gain: f64, delay: f64 },
    /// A property of a column, or of all of them.
    Sensor { column: Option<usize>, property: Property, value: f64 },
    /// The rate of a velocity is multiplied by a text.
    Factor { mass: usize, factor: String },
    /// A constant of the rig is not what the spec says.
    Constant { index: usize, value: f64 },
}

/// A property of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Property {
    Delay,
    Gain,
    Offset,
    /// It reads no more than this to either side.
    Clip,
    /// So much of the square is added.
    Bend,
    /// It follows with this time constant.
    Lag,
}

/// A hidden effect.
#[derive(Clone, Debug)]
pub(super) struct Effect {
    /// The id of its law, or a name for an effect that no law describes.
    pub(super) law: String,
    /// Its place as `gap` writes it.
    pub(super) at: String,
    /// Its law's parameters.
    pub(super) parameters: Vec<(&'static str, f64)>,
    /// The phase of the second record, if records have their own.
    pub(super) second_phase: Option<f64>,
    pub(super) action: Action,
}

impl Effect {
    /// A parameter of its law.
    pub(super) fn parameter(&self, name: &str) -> Option<f64> {
        self.parameters.iter().find(|(n, _)| *n == name).map(|(_, x)| *x)
    }

    /// Whether it acts on the motion, not on what is read of it.
    pub(super) fn is_force(&self) -> bool {
        matches!(self.action, Action::Force { .. } | Action::Factor { .. })
    }

    /// The number of its unknown parameters.
    pub(super) fn freedom(&self) -> usize {
        self.parameters.len()
    }

    /// Whether it is a friction that can hold a mass.
    pub(super) fn is_friction(&self) -> bool {
        self.law != "power-law-damping"
            && matches!(&self.action, Action::Force { force, .. } if force.contains("sgn("))
    }

    /// Text with the displacement and velocity of the place, and numbers in place of parameters.
    pub(super) fn written(&self, text: &str, second: bool) -> String {
        let own = |name: &str| if name == "phase" && second { self.second_phase } else { None };
        let numbers: Vec<(&str, String)> = self
            .parameters
            .iter()
            .map(|(name, value)| (*name, format!("({:e})", own(name).unwrap_or(*value))))
            .collect();
        substitute(text, |name| {
            let number = numbers.iter().find(|(n, _)| *n == name).map(|(_, number)| number.as_str());
            number.or_else(|| self.place_name(name))
        })
    }

    /// Text with the displacement and velocity of the place and the names of parameters.
    pub(super) fn at_its_place(&self, text: &str) -> String {
        substitute(text, |name| self.place_name(name))
    }

    /// The text for the displacement `X` and the velocity `Y` of a force.
    fn place_name(&self, name: &str) -> Option<&str> {
        let Action::Force { place, .. } = &self.action else { return None };
        match name {
            "X" => Some(&place.x),
            "Y" => Some(&place.v),
            _ => None,
        }
    }
}

/// Largest displacement and velocity at a place, and the force that drives the rig.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales {
    pub(super) x: f64,
    pub(super) v: f64,
    pub(super) force: f64,
    /// The duration of the first record.
    pub(super) time: f64,
}

/// Parameters of a law and the text of its force.
type Force = (Vec<(&'static str, f64)>, &'static str);

/// The internal states of the laws that have some, with their rates.
const INTERNAL: &[(&str, &[(&str, &str)])] = &[
    ("presliding", &[("z", "Y - kt*abs(Y)*z/Fc")]),
    ("bouc-wen", &[("z", "A*Y - beta*abs(Y)*z - gamma*Y*abs(z)")]),
    ("lugre", &[("z", "Y - s0*abs(Y)*z/(Fc + (Fs-Fc)*exp(-(Y/vs)^2))")]),
    ("maxwell", &[("z", "km*(Y - z/cm)")]),
    ("hanging-body", &[("hs", "Y - hw"), ("hw", "(k*hs + c*(Y - hw))/m")]),
    (
        "maxwell-slip",
        &[
            ("z1", "Y*(1 - (pos(z1*sgn(Y))*kt/(Fc*(1 - spread)))^20)"),
            ("z2", "Y*(1 - (pos(z2*sgn(Y))*kt/(Fc*(1 - spread/3)))^20)"),
            ("z3", "Y*(1 - (pos(z3*sgn(Y))*kt/(Fc*(1 + spread/3)))^20)"),
            ("z4", "Y*(1 - (pos(z4*sgn(Y))*kt/(Fc*(1 + spread)))^20)"),
        ],
    ),
    ("backlash", &[("z", "Y*(1 - (pos(z*sgn(Y))/gap)^20)")]),
];

/// Draws the effect of a law at a place; `None` if the law does not fit there.
pub(super) fn draw(
    law: &str,
    place: &Place,
    s: Scales,
    rig: &super::rig::Rig,
    dice: &mut Dice,
    holds: bool,
) -> Option<Effect> {
    let (parameters, force) = match law {
        "viscous" | "stiffness" => draw_linear(law, s, rig, dice),
        "cubic-stiffness"
        | "quadratic-stiffness"
        | "quintic-stiffness"
        | "bilinear-stiffness"
        | "cogging"
        | "dead-zone"
        | "one-sided-stop" => draw_spring(law, place, s, rig, dice),
        "bouc-wen" | "lugre" | "maxwell" | "maxwell-slip" | "backlash" | "hanging-body" => {
            draw_memory(law, place, s, rig, dice)
        }
        "offset" | "harmonic-force" | "parametric-stiffness" | "van-der-pol" => {
            draw_excitation(law, s, rig, dice)
        }
        _ => draw_friction(law, s, dice, holds),
    }?;
    let parameters: Vec<_> = parameters.into_iter().map(|(n, x)| (n, crate::dice::rounded(x))).collect();
    let own = INTERNAL.iter().find(|(id, _)| *id == law).map_or(&[][..], |(_, own)| own);
    let internal = own.iter().map(|(z, rate)| ((*z).to_owned(), (*rate).to_owned())).collect();
    // The phase of cogging is that of a position.
    let phase = parameters.iter().find(|(n, _)| *n == "phase" && law != "cogging");
    let second_phase =
        phase.map(
            |(_, phase)| {
                if dice.chance(0.5) { crate::dice::rounded(dice.between(-3.0, 3.0)) } else { *phase }
            },
        );
    // The load is the spring of the place.
    let force = match force.contains("LOAD") {
        true => force.replace("LOAD", &format!("{:e}*X", place.spring?)),
        false => force.to_owned(),
    };
    let action = Action::Force { place: place.clone(), force, internal };
    Some(Effect { law: law.to_owned(), at: place.at.clone(), parameters, second_phase, action })
}

/// A change of a damper or a spring.
fn draw_linear(law: &str, s: Scales, rig: &super::rig::Rig, dice: &mut Dice) -> Option<Force> {
    Some(match law {
        "viscous" => {
            let dc = dice.log(0.01, 1.0) * s.force / s.v;
            let negative = dice.chance(0.2);
            // The damping of a mass must stay positive.
            let least = rig.damper.iter().copied().fold(f64::INFINITY, f64::min);
            (vec![("dc", if negative { -(0.7 * least).min(dc) } else { dc })], "dc*Y")
        }
        "stiffness" => {
            let dk = dice.log(0.01, 1.0) * s.force / s.x;
            let least = 0.4 * rig.spring.iter().copied().fold(f64::INFINITY, f64::min);
            (vec![("dk", if dice.chance(0.4) { -dk.min(least) } else { dk })], "dk*X")
        }
        _ => return None,
    })
}

/// A friction or a drag.
fn draw_friction(law: &str, s: Scales, dice: &mut Dice, holds: bool) -> Option<Force> {
    let level = |dice: &mut Dice| if holds { dice.log(0.15, 0.8) } else { dice.log(0.02, 0.5) } * s.force;
    Some(match law {
        "quadratic-drag" => (vec![("d", dice.log(0.02, 1.5) * s.force / (s.v * s.v))], "d*Y*abs(Y)"),
        "cubic-damping" => (vec![("d3", dice.log(0.02, 1.5) * s.force / s.v.powi(3))], "d3*Y^3"),
        "power-law-damping" => {
            let p = match dice.whole(0, 2) {
                0 => dice.between(0.3, 0.7),
                1 => dice.between(1.3, 1.7),
                _ => dice.between(2.3, 2.7),
            };
            (vec![("b", dice.log(0.05, 1.0) * s.force / s.v.powf(p)), ("p", p)], "b*abs(Y)^p*sgn(Y)")
        }
        "coulomb" => (vec![("Fc", level(dice))], "Fc*sgn(Y)"),
        "load-dependent-friction" => {
            (vec![("F0", level(dice)), ("mu", dice.between(0.1, 0.6))], "(F0 + mu*abs(LOAD))*sgn(Y)")
        }
        "drifting-friction" => {
            let change = if dice.chance(0.5) { dice.between(0.5, 2.0) } else { -dice.between(0.3, 0.6) };
            (vec![("Fc", level(dice)), ("r", change / s.time)], "Fc*(1 + r*t)*sgn(Y)")
        }
        "asymmetric-coulomb" => {
            let (small, ratio) = (level(dice), dice.between(1.3, 3.0));
            let (p, m) = if dice.chance(0.5) { (small, ratio * small) } else { (ratio * small, small) };
            (vec![("Fp", p), ("Fm", m)], "(0.5*(Fp+Fm)*sgn(Y) + 0.5*(Fp-Fm))")
        }
        "stribeck" => {
            let fc = level(dice);
            let fs = fc * dice.between(1.3, 3.0);
            (
                vec![("Fc", fc), ("Fs", fs), ("vs", dice.log(0.05, 0.6) * s.v)],
                "(Fc + (Fs-Fc)*exp(-(Y/vs)^2))*sgn(Y)",
            )
        }
        "dieterich-ruina" => {
            let f = level(dice);
            let b = f * dice.between(0.12, 0.45);
            (
                vec![("F", f), ("a", b * dice.between(0.5, 0.95)), ("b", b)],
                "(F + a*ln((abs(Y)+1e-6)/0.003) + b*ln(0.022+0.003/(abs(Y)+1e-6)))*sgn(Y)",
            )
        }
        "position-dependent-friction" => {
            let f = level(dice);
            let (one, two) = (dice.sign() * dice.between(0.2, 0.6) * f, dice.between(-0.3, 0.8) * f);
            (vec![("F0", f), ("F1", one / s.x), ("F2", two / (s.x * s.x))], "(F0 + F1*X + F2*X^2)*sgn(Y)")
        }
        "presliding" => {
            let fc = dice.log(0.04, 0.6) * s.force;
            (vec![("Fc", fc), ("kt", fc / (dice.log(0.03, 0.4) * s.x))], "kt*z")
        }
        _ => return None,
    })
}

/// A nonlinear spring or a stop.
fn draw_spring(law: &str, place: &Place, s: Scales, rig: &super::rig::Rig, dice: &mut Dice) -> Option<Force> {
    Some(match law {
        "cubic-stiffness" => {
            let k3 = dice.log(0.01, 2.0) * s.force / s.x.powi(3);
            (vec![("k3", if dice.chance(0.25) { -0.15 * k3 } else { k3 })], "k3*X^3")
        }
        "quadratic-stiffness" => {
            (vec![("k2", dice.sign() * dice.log(0.01, 0.5) * s.force / (s.x * s.x))], "k2*X^2")
        }
        "quintic-stiffness" => (vec![("k5", dice.log(0.02, 2.0) * s.force / s.x.powi(5))], "k5*X^5"),
        "bilinear-stiffness" => {
            let force = if dice.chance(0.5) { "kb*pos(X)" } else { "(-kb*pos(-X))" };
            (vec![("kb", dice.log(0.03, 0.6) * rig.spring[0])], force)
        }
        "cogging" => {
            let (size, n) = (dice.log(0.03, 0.5) * s.force, dice.between(4.0, 14.0) / s.x);
            (vec![("A", size), ("n", n), ("phase", dice.between(-3.0, 3.0))], "A*sin(n*X + phase)")
        }
        "dead-zone" => {
            (vec![("ks", place.spring?), ("gap", dice.log(0.02, 0.5) * s.x)], "ks*(dead(X,gap) - X)")
        }
        "one-sided-stop" => {
            let stiff = dice.log(0.5, 20.0) * rig.spring[0];
            let at = dice.between(0.35, 0.97) * s.x;
            let force = if dice.chance(0.5) { "ks*pos(X-gap)" } else { "(-ks*pos(-X-gap))" };
            (vec![("ks", stiff), ("gap", at)], force)
        }
        _ => return None,
    })
}

/// A force with memory.
fn draw_memory(law: &str, place: &Place, s: Scales, rig: &super::rig::Rig, dice: &mut Dice) -> Option<Force> {
    let level = dice.log(0.08, 0.6) * s.force;
    Some(match law {
        "bouc-wen" => {
            let (d, part) = (dice.log(0.08, 0.5) * s.x, dice.sign() * dice.between(0.3, 0.7));
            let beta = 1.0 / (d * (1.0 + part));
            (vec![("A", level / d), ("beta", beta), ("gamma", part * beta)], "z")
        }
        "lugre" => {
            let s0 = level / (dice.log(0.01, 0.1) * s.x);
            let mass = rig.mass[place.parts[0].0];
            let parameters = vec![
                ("Fc", level),
                ("Fs", level * dice.between(1.3, 2.5)),
                ("vs", dice.log(0.05, 0.3) * s.v),
                ("s0", s0),
                ("s1", dice.between(0.2, 1.0) * (s0 * mass).sqrt()),
                ("s2", dice.log(0.02, 0.2) * s.force / s.v),
            ];
            (parameters, "(s0*z + s1*(Y - s0*abs(Y)*z/(Fc + (Fs-Fc)*exp(-(Y/vs)^2))) + s2*Y)")
        }
        "maxwell" => {
            let km = dice.log(0.05, 0.8) * s.force / s.x;
            (vec![("km", km), ("cm", km * dice.log(0.3, 3.0) / rig.natural)], "z")
        }
        "maxwell-slip" => {
            let kt = level / (dice.log(0.1, 0.4) * s.x);
            (
                vec![("Fc", level), ("kt", kt), ("spread", dice.between(0.4, 0.9))],
                "0.25*kt*(z1 + z2 + z3 + z4)",
            )
        }
        "hanging-body" => {
            let m = rig.mass[place.parts[0].0] * dice.log(0.03, 0.4);
            let w = rig.natural * dice.log(0.4, 2.5);
            let damping = dice.log(0.01, 0.2);
            (vec![("k", m * w * w), ("m", m), ("c", 2.0 * damping * m * w)], "(k*hs + c*(Y - hw))")
        }
        "backlash" => {
            let ks = dice.log(0.1, 1.0) * s.force / s.x;
            (vec![("ks", ks), ("gap", dice.between(0.08, 0.4) * s.x)], "ks*(X - z)")
        }
        _ => return None,
    })
}

/// A force that excites the motion.
fn draw_excitation(law: &str, s: Scales, rig: &super::rig::Rig, dice: &mut Dice) -> Option<Force> {
    let w0 = rig.natural;
    Some(match law {
        "offset" => (vec![("f0", dice.sign() * dice.log(0.02, 0.8) * s.force)], "(-f0)"),
        "harmonic-force" => {
            let w = w0 * dice.log(0.3, 2.5);
            (
                vec![("A", dice.log(0.02, 0.8) * s.force), ("w", w), ("phase", dice.between(-3.0, 3.0))],
                "(-A*cos(w*t+phase))",
            )
        }
        "parametric-stiffness" => {
            let (e, w) = (dice.log(0.02, 0.6) * s.force / s.x, w0 * dice.log(0.2, 3.0));
            let e = e.min(0.5 * rig.spring[0]);
            (vec![("e", e), ("w", w), ("phase", dice.between(-3.0, 3.0))], "e*cos(w*t+phase)*X")
        }
        "van-der-pol" => {
            let mu = dice.log(0.02, 1.0) * s.force / s.v;
            (vec![("mu", mu), ("a", dice.log(0.5, 10.0) / (s.x * s.x))], "(-mu*(1-a*X^2)*Y)")
        }
        _ => return None,
    })
}
