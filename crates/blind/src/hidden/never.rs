//! Static laws that are in no catalogue, for the blind test of formulas: many shapes, most of which the
//! grammar was not developed on.

use super::effect::{Action, Effect, Scales};
use super::place::Place;
use crate::dice::{Dice, rounded};

/// How a number of a law is drawn.
#[derive(Clone, Copy, Debug)]
enum Draw {
    /// A coefficient: a part of the driving force at the largest displacement and speed to these powers.
    Force { x: f64, v: f64 },
    /// A part of the largest displacement.
    Length,
    /// A part of the largest speed.
    Speed,
    /// So many across the largest displacement.
    PerLength,
    /// A number without a unit, of either sign.
    Ratio,
}

/// A law: its force over the displacement `X` and the velocity `Y`, and its numbers.
struct Row {
    name: &'static str,
    force: &'static str,
    numbers: &'static [(&'static str, Draw, f64, f64)],
}

const fn force(x: f64, v: f64) -> Draw {
    Draw::Force { x, v }
}

use Draw::{Length, PerLength, Ratio, Speed};

#[rustfmt::skip]
const ROWS: &[Row] = &[
    Row { name: "bell-damper", force: "A*Y*exp(-(X/s)^2)", numbers: &[("A", force(0.0, 1.0), 0.2, 0.8), ("s", Length, 0.35, 0.8)] },
    Row { name: "abs-displacement-damper", force: "A*abs(X)*Y", numbers: &[("A", force(1.0, 1.0), 0.3, 1.2)] },
    Row { name: "root-of-displacement-damper", force: "A*Y*abs(X)^0.5", numbers: &[("A", force(0.5, 1.0), 0.2, 0.8)] },
    Row { name: "square-displacement-damper", force: "A*X^2*Y", numbers: &[("A", force(2.0, 1.0), 0.4, 1.5)] },
    Row { name: "saturating-cubic-damper", force: "A*Y^3/(1 + (Y/s)^2)", numbers: &[("A", force(0.0, 3.0), 0.8, 3.0), ("s", Speed, 0.3, 0.7)] },
    Row { name: "falling-damper", force: "A*Y/(1 + (Y/s)^2)", numbers: &[("A", force(0.0, 1.0), 0.4, 1.2), ("s", Speed, 0.3, 0.8)] },
    Row { name: "tanh-damper", force: "A*tanh(Y/s)", numbers: &[("A", force(0.0, 0.0), 0.1, 0.4), ("s", Speed, 0.12, 0.4)] },
    Row { name: "atan-damper", force: "A*atan(Y/s)", numbers: &[("A", force(0.0, 0.0), 0.08, 0.3), ("s", Speed, 0.12, 0.4)] },
    Row { name: "logarithmic-damper", force: "A*ln(1 + abs(Y)/s)*sgn(Y)", numbers: &[("A", force(0.0, 0.0), 0.1, 0.3), ("s", Speed, 0.1, 0.4)] },
    Row { name: "square-displacement-friction", force: "A*sgn(Y)*(1 + (X/s)^2)", numbers: &[("A", force(0.0, 0.0), 0.05, 0.3), ("s", Length, 0.5, 1.0)] },
    Row { name: "exponential-friction", force: "A*sgn(Y)*exp(-abs(Y)/s) + B*Y", numbers: &[("A", force(0.0, 0.0), 0.1, 0.4), ("s", Speed, 0.15, 0.5), ("B", force(0.0, 1.0), 0.1, 0.3)] },
    Row { name: "rational-friction", force: "A*sgn(Y)/(1 + abs(Y)/s)", numbers: &[("A", force(0.0, 0.0), 0.15, 0.6), ("s", Speed, 0.15, 0.5)] },
    Row { name: "abs-spring", force: "A*X*abs(X)", numbers: &[("A", force(2.0, 0.0), 0.2, 1.0)] },
    Row { name: "stiff-power-spring", force: "A*X*abs(X)^1.5", numbers: &[("A", force(2.5, 0.0), 0.2, 1.0)] },
    Row { name: "hertzian-spring", force: "A*X*abs(X)^0.5", numbers: &[("A", force(1.5, 0.0), 0.2, 1.0)] },
    Row { name: "saturating-rational-spring", force: "A*X/(1 + abs(X)/s)", numbers: &[("A", force(1.0, 0.0), 0.2, 0.8), ("s", Length, 0.2, 0.6)] },
    Row { name: "tanh-spring", force: "A*tanh(X/s)", numbers: &[("A", force(0.0, 0.0), 0.1, 0.5), ("s", Length, 0.15, 0.4)] },
    Row { name: "exponential-spring", force: "A*(exp(r*X) - 1)", numbers: &[("A", force(0.0, 0.0), 0.06, 0.2), ("r", PerLength, 0.8, 2.0)] },
    Row { name: "sinus-spring", force: "A*sin(q*X)", numbers: &[("A", force(0.0, 0.0), 0.1, 0.5), ("q", PerLength, 2.0, 6.0)] },
    Row { name: "quartic-spring", force: "A*X^4", numbers: &[("A", force(4.0, 0.0), 0.2, 1.0)] },
    Row { name: "displacement-drag", force: "A*X*Y^2", numbers: &[("A", force(1.0, 2.0), 0.3, 1.2)] },
    Row { name: "cosine-damper", force: "A*Y*(1 + B*cos(q*X))", numbers: &[("A", force(0.0, 1.0), 0.1, 0.4), ("B", Ratio, 0.4, 0.8), ("q", PerLength, 1.5, 4.0)] },
    Row { name: "power-damper-and-spring", force: "A*abs(Y)^1.5*sgn(Y) + B*X^5", numbers: &[("A", force(0.0, 1.5), 0.15, 0.6), ("B", force(5.0, 0.0), 0.3, 1.2)] },
    Row { name: "cubic-drag-and-sine", force: "A*Y^3 + B*sin(q*X)", numbers: &[("A", force(0.0, 3.0), 0.3, 1.2), ("B", force(0.0, 0.0), 0.1, 0.4), ("q", PerLength, 2.0, 5.0)] },
];

/// Their names.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    ROWS.iter().map(|row| row.name)
}

/// Draws one of them; `None` if there is none of this name.
pub(super) fn draw(name: &str, place: &Place, s: Scales, dice: &mut Dice) -> Option<Effect> {
    let row = ROWS.iter().find(|row| row.name == name)?;
    let number = |(name, how, low, high): &(&'static str, Draw, f64, f64)| {
        let part = dice.log(*low, *high);
        let value = match how {
            Draw::Force { x, v } => part * s.force / (s.x.powf(*x) * s.v.powf(*v)),
            Draw::Length => part * s.x,
            Draw::Speed => part * s.v,
            Draw::PerLength => part / s.x,
            Draw::Ratio => part * dice.sign(),
        };
        (*name, rounded(value))
    };
    let parameters = row.numbers.iter().map(number).collect();
    let action = Action::Force { place: place.clone(), force: row.force.to_owned(), internal: vec![] };
    Some(Effect { law: name.to_owned(), at: place.at.clone(), parameters, second_phase: None, action })
}
