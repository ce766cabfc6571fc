//! A random rig: its physics and its motion.

use crate::dice::{Dice, rounded};
use std::f64::consts::TAU;
use std::fmt::Write;

/// A summand of the force on a mass: its sign and its text.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Summand {
    pub(super) negative: bool,
    pub(super) text: String,
}

/// The known physics of a model: constants by name, and the forces on each mass.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Physics {
    pub(super) constants: Vec<(String, f64)>,
    pub(super) forces: Vec<Vec<Summand>>,
}

impl Physics {
    /// The mass of a body.
    pub(super) fn mass(&self, body: usize) -> f64 {
        let name = format!("m{}", body + 1);
        self.constants.iter().find(|(n, _)| *n == name).map_or(1.0, |(_, x)| *x)
    }
}

/// Friction on a mass: candidates of the dictionary with their true coefficients.
#[derive(Clone, Debug)]
pub(super) struct Friction {
    pub(super) mass: usize,
    pub(super) terms: Vec<(String, f64)>,
}

/// A rig.
#[derive(Clone, Debug)]
pub(super) struct Rig {
    pub(super) physics: Physics,
    pub(super) friction: Vec<Friction>,
    /// The number of cosines of the force that drives it; 0 for a released rig.
    pub(super) lines: usize,
    /// Whether velocities are measured too.
    pub(super) velocities: bool,
    /// Standard deviation of the noise relative to that of each column, or to each sample if `relative`.
    pub(super) noise: f64,
    pub(super) relative: bool,
    /// Whether there is a second record for validation.
    pub(super) validated: bool,
    pub(super) duration: f64,
    pub(super) step: f64,
    /// Scale of the drive and start state of the Fit and the Validate record.
    pub(super) records: [(f64, Vec<f64>); 2],
    pub(super) seed: u64,
}

/// Force of the cubic spring at the largest displacement, relative to the linear spring.
const CUBIC: (f64, f64) = (0.1, 0.5);

impl Rig {
    /// A random rig of one or two masses; `cubic` adds a cubic spring.
    pub(super) fn draw(dice: &mut Dice, cubic: bool) -> Rig {
        let count = if dice.chance(0.4) { 2 } else { 1 };
        let laboratory = dice.chance(0.4);
        let (mass, natural, size) = if laboratory {
            (dice.log(0.5, 8.0), TAU * dice.log(1.5, 15.0), dice.log(3e-4, 5e-3))
        } else {
            (dice.log(0.5, 2.0), dice.log(0.7, 3.0), dice.log(0.3, 2.0))
        };
        let stiff = rounded(mass * natural * natural);
        let mut physics = chain(count, mass, stiff, size, cubic, dice);
        let lines = match dice.whole(0, 9) {
            0..=3 => 1,
            4..=7 => dice.whole(2, 5),
            _ => 0,
        };
        let drive = add_drive(&mut physics, lines, natural, size, stiff, dice);
        // A released mass must swing a few times before friction holds it.
        let force = if lines > 0 { drive } else { 0.4 * size * stiff };
        let friction = frictions(count, force, size * natural, dice);
        let periods = dice.between(8.0, 25.0);
        let samples = dice.whole(900, 2400);
        let step = rounded(TAU / natural * periods / samples as f64);
        let start = |dice: &mut Dice, scale: f64| -> Vec<f64> {
            let reach = size * scale * if lines > 0 { 0.5 } else { 2.0 };
            let place = |dice: &mut Dice| rounded(dice.sign() * dice.between(0.5, 1.0) * reach);
            let x: Vec<f64> = (0..count).map(|_| place(dice)).collect();
            x.into_iter().chain((0..count).map(|_| 0.0)).collect()
        };
        let scale = rounded(dice.between(0.7, 1.3));
        let relative = dice.chance(0.25);
        let records = [(1.0, start(dice, 1.0)), (scale, start(dice, scale))];
        Rig {
            physics,
            friction,
            lines,
            velocities: dice.chance(0.6),
            noise: rounded(dice.log(0.01, 0.05)) * if relative { 2.0 } else { 1.0 },
            relative,
            validated: dice.chance(0.75),
            duration: samples as f64 * step,
            step,
            records,
            // Specs accept integers up to 2^53.
            seed: dice.seed() >> 12,
        }
    }

    /// Number of masses.
    pub(super) fn count(&self) -> usize {
        self.physics.forces.len()
    }

    /// A description for readers.
    pub(super) fn described(&self) -> String {
        let drive = match self.lines {
            0 => "released".to_owned(),
            1 => "one cosine".to_owned(),
            n => format!("{n} cosines"),
        };
        let relative = if self.relative { " relative" } else { "" };
        let validated = if self.validated { "" } else { ", no validation" };
        let mut text =
            format!("{} mass(es), {drive}, noise {}{relative}{validated}", self.count(), self.noise);
        for f in &self.friction {
            let terms: Vec<String> = f.terms.iter().map(|(c, x)| format!("{x}*[{c}]")).collect();
            let _ = write!(text, ", v{}: {}", f.mass + 1, terms.join(" + "));
        }
        text
    }
}

fn minus(text: &str) -> Summand {
    Summand { negative: true, text: text.to_owned() }
}

fn plus(text: &str) -> Summand {
    Summand { negative: false, text: text.to_owned() }
}

/// Masses in a chain on springs and dampers, without a drive; `cubic` adds a cubic spring on the first mass.
fn chain(count: usize, mass: f64, stiff: f64, size: f64, cubic: bool, dice: &mut Dice) -> Physics {
    let damping = dice.log(0.01, 0.07);
    let mut constants = Vec::new();
    let mut forces: Vec<Vec<Summand>> = vec![vec![]; count];
    for i in 0..count {
        let other = |dice: &mut Dice| if i == 0 { 1.0 } else { dice.between(0.6, 1.5) };
        let spring = rounded(stiff * other(dice));
        constants.push((format!("m{}", i + 1), rounded(mass * other(dice))));
        constants.push((format!("k{}", i + 1), spring));
        constants.push((format!("c{}", i + 1), rounded(2.0 * damping * (spring * mass).sqrt())));
    }
    forces[0].extend([minus("k1*x1"), minus("c1*v1")]);
    if count == 2 {
        forces[0].extend([minus("k2*(x1-x2)"), minus("c2*(v1-v2)")]);
        forces[1].extend([plus("k2*(x1-x2)"), plus("c2*(v1-v2)")]);
    }
    if cubic {
        let share = dice.between(CUBIC.0, CUBIC.1);
        constants.push(("q".to_owned(), rounded(share * stiff / (size * size))));
        forces[0].push(minus("q*x1^3"));
    }
    Physics { constants, forces }
}

/// Adds a force of `lines` cosines on one mass, scaled by `G`. Returns the root of the sum of squared
/// amplitudes.
fn add_drive(
    physics: &mut Physics,
    lines: usize,
    natural: f64,
    size: f64,
    stiff: f64,
    dice: &mut Dice,
) -> f64 {
    let mut drive = 0.0;
    let mut sum = Vec::new();
    for k in 1..=lines {
        let ratio = dice.between(0.3, if lines > 1 { 1.8 } else { 1.3 });
        // Away from the resonance the same motion takes a larger force.
        let wanted = size * dice.between(0.6, 1.4) / (lines as f64).sqrt();
        let amplitude = rounded(wanted * stiff * (1.0 - ratio * ratio).abs().max(0.15));
        drive += amplitude * amplitude;
        physics.constants.push((format!("A{k}"), amplitude));
        physics.constants.push((format!("W{k}"), rounded(natural * ratio)));
        physics.constants.push((format!("p{k}"), rounded(dice.between(-3.0, 3.0))));
        sum.push(format!("A{k}*cos(W{k}*t+p{k})"));
    }
    let on = dice.whole(0, physics.forces.len() - 1);
    if lines > 0 {
        physics.forces[on].push(plus(&format!("G*({})", sum.join(" + "))));
    }
    drive.sqrt()
}

/// Coulomb friction, with viscous friction, or decreasing with speed. Some dictionaries contain false
/// candidates.
fn frictions(count: usize, force: f64, speed: f64, dice: &mut Dice) -> Vec<Friction> {
    let both = count == 2 && dice.chance(0.3);
    let one = dice.whole(0, count - 1);
    let masses: Vec<usize> = if both { vec![0, 1] } else { vec![one] };
    let friction = |mass: usize, dice: &mut Dice| {
        let (x, v) = (format!("x{}", mass + 1), format!("v{}", mass + 1));
        let level = dice.log(0.05, 0.6) * force;
        let level = rounded(if both { 0.6 * level } else { level });
        let mut terms = vec![("1".to_owned(), level)];
        match dice.whole(0, 2) {
            0 => {}
            1 => terms.push((format!("|{v}|"), rounded(dice.between(0.2, 1.0) * level / speed))),
            _ => {
                let scale = rounded(dice.between(0.1, 0.4) * speed);
                terms.push((format!("exp(-|{v}|/({scale:e}))"), rounded(dice.between(0.3, 1.0) * level)));
            }
        }
        let more =
            [x.clone(), format!("|{v}|"), v.clone(), format!("{x}^2"), format!("{x}*{v}"), format!("{v}^2")];
        // Half of the dictionaries contain only the true candidates.
        let wanted = *dice.pick(&[0, 0, 2, more.len()]);
        for other in more.into_iter().take(wanted) {
            if !terms.iter().any(|(c, _)| *c == other) {
                terms.push((other, 0.0));
            }
        }
        Friction { mass, terms }
    };
    masses.into_iter().map(|mass| friction(mass, dice)).collect()
}
