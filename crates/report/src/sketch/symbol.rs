//! The symbol of each kind of part, along a line of some length: what lies along is counted from its start, what lies
//! across from the line.

use super::scheme::Kind;

/// Half of the height of the highest symbol.
pub(super) const HALF: f64 = 14.0;
/// Length of the longest symbol, with a piece of rod at each end.
pub(super) const LEAST: f64 = 74.0;

/// A point: along, across.
type At = (f64, f64);

/// A piece of a symbol.
pub(super) enum Stroke {
    Line(Vec<At>),
    /// A closed area.
    Area(Vec<At>),
    /// A circle: its middle and its radius.
    Circle(At, f64),
    /// A thin line.
    Hatch(Vec<At>),
}
use Stroke::{Area, Circle, Hatch, Line};

/// Draws a symbol in the middle of a line of this length, with the rods on both sides.
type Draw = fn(f64) -> Vec<Stroke>;

/// One row for each kind.
const SYMBOLS: [(Kind, Draw); 8] = [
    (Kind::Spring, spring),
    (Kind::BentSpring, |long| bent(spring(long), long)),
    (Kind::Damper, damper),
    (Kind::BentDamper, |long| bent(damper(long), long)),
    (Kind::Friction, friction),
    (Kind::Weight, weight),
    (Kind::Force, force),
    (Kind::Link, link),
];

/// The strokes of a part.
pub(super) fn symbol(kind: Kind, long: f64) -> Vec<Stroke> {
    SYMBOLS.iter().find(|(k, _)| *k == kind).map_or(vec![], |(_, draw)| draw(long))
}

/// Seven half waves.
fn spring(long: f64) -> Vec<Stroke> {
    const TOOTH: f64 = 7.0;
    let from = 0.5 * long - 3.5 * TOOTH;
    let mut line = vec![(0.0, 0.0), (from, 0.0)];
    line.extend((0..7).map(|k| (from + TOOTH * (f64::from(k) + 0.5), if k % 2 == 0 { -8.0 } else { 8.0 })));
    line.extend([(from + 7.0 * TOOTH, 0.0), (long, 0.0)]);
    vec![Line(line)]
}

/// A piston in a pot.
fn damper(long: f64) -> Vec<Stroke> {
    let middle = 0.5 * long;
    let pot = vec![(middle - 14.0, -9.0), (middle + 14.0, -9.0), (middle + 14.0, 9.0), (middle - 14.0, 9.0)];
    vec![
        Line(vec![(0.0, 0.0), (middle + 2.0, 0.0)]),
        Line(vec![(middle + 2.0, -6.0), (middle + 2.0, 6.0)]),
        Line(pot),
        Line(vec![(middle + 14.0, 0.0), (long, 0.0)]),
    ]
}

/// An arrow through a symbol: it is no constant.
fn bent(mut strokes: Vec<Stroke>, long: f64) -> Vec<Stroke> {
    let middle = 0.5 * long;
    let tip = (middle + 20.0, -13.0);
    strokes.push(Line(vec![(middle - 20.0, 13.0), tip]));
    strokes.push(Area(vec![tip, (tip.0 - 9.4, tip.1 + 2.0), (tip.0 - 5.6, tip.1 + 7.8)]));
    strokes
}

/// Two plates, one on the other.
fn friction(long: f64) -> Vec<Stroke> {
    let middle = 0.5 * long;
    let mut all = vec![
        Line(vec![(0.0, 0.0), (middle - 22.0, 0.0), (middle - 22.0, 5.0), (middle + 16.0, 5.0)]),
        Line(vec![(long, 0.0), (middle + 22.0, 0.0), (middle + 22.0, -5.0), (middle - 16.0, -5.0)]),
    ];
    let tooth = |k: i32| {
        let x = middle - 14.0 + 6.0 * f64::from(k);
        Hatch(vec![(x, 5.0), (x + 5.0, -5.0)])
    };
    all.extend((0..5).map(tooth));
    all
}

/// A bob on an arm.
fn weight(long: f64) -> Vec<Stroke> {
    vec![Line(vec![(0.0, 0.0), (long - 9.0, 0.0)]), Circle((long - 9.0, 0.0), 9.0)]
}

/// A box with a curve in it: any force.
fn force(long: f64) -> Vec<Stroke> {
    let middle = 0.5 * long;
    let curve = [(-10.0, 6.0), (-5.0, 5.0), (-2.0, 1.5), (2.0, -1.5), (5.0, -5.0), (10.0, -6.0)];
    vec![
        Line(vec![(0.0, 0.0), (middle - 16.0, 0.0)]),
        Area(vec![
            (middle - 16.0, -11.0),
            (middle + 16.0, -11.0),
            (middle + 16.0, 11.0),
            (middle - 16.0, 11.0),
        ]),
        Hatch(curve.map(|(x, y)| (middle + x, y)).to_vec()),
        Line(vec![(middle + 16.0, 0.0), (long, 0.0)]),
    ]
}

/// A bar between two pins.
fn link(long: f64) -> Vec<Stroke> {
    vec![
        Line(vec![(8.0, -4.0), (long - 8.0, -4.0)]),
        Line(vec![(8.0, 4.0), (long - 8.0, 4.0)]),
        Circle((7.0, 0.0), 5.0),
        Circle((long - 7.0, 0.0), 5.0),
    ]
}
