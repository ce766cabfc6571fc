//! The sheet of a sketch: what is drawn, and the room that each piece of it takes.

use super::scheme::{Kind, Known};
use super::symbol::{HALF, Stroke, symbol};
use crate::chart::{at, width_of, word};
use crate::markup::{Element, element};

/// Height of a line of words.
pub(super) const LINE: f64 = 17.0;

/// Length of the widest symbol without its rods.
const CORE: f64 = 52.0;

/// A rectangle: left, top, right, bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Room {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) right: f64,
    pub(crate) bottom: f64,
}

/// What is drawn, and where.
#[derive(Default)]
pub(super) struct Canvas {
    pub(super) drawn: Vec<Element>,
    /// Bodies, symbols and words, each with a name for tests.
    pub(super) rooms: Vec<(String, Room)>,
}

/// The class of a part.
pub(super) fn class(known: Known) -> &'static str {
    match known {
        Known::Stated => "stated",
        Known::Sought => "sought",
        Known::Found => "found",
    }
}

/// A line along which a part lies.
#[derive(Clone, Copy)]
pub(super) enum Along {
    /// From left to right: start, height, length.
    Right(f64, f64, f64),
    /// From top to bottom: middle, start, length.
    Down(f64, f64, f64),
}

impl Canvas {
    fn took(&mut self, name: impl Into<String>, (left, top, right, bottom): (f64, f64, f64, f64)) {
        self.rooms.push((name.into(), Room { left, top, right, bottom }));
    }

    /// The lowest and the rightmost point of all.
    pub(super) fn size(&self) -> (f64, f64) {
        let most = |of: fn(&Room) -> f64| self.rooms.iter().map(|(_, r)| of(r)).fold(0.0, f64::max);
        (most(|r| r.right), most(|r| r.bottom))
    }

    /// Words that begin at a place, at the height of their middle.
    pub(super) fn words(&mut self, text: &str, (x, y): (f64, f64), style: &str) {
        if text.is_empty() {
            return;
        }
        // Bold letters are wider.
        let wide =
            width_of(text) * if style.contains("name") || style.contains("found") { 1.08 } else { 1.0 };
        let left = if style.contains("middle") { x - 0.5 * wide } else { x };
        self.took(text, (left, y - 8.0, left + wide, y + 8.0));
        self.drawn.push(word(style, x, y + 4.5, text));
    }

    /// Lines of words about a middle, the first at the top.
    pub(super) fn lines(&mut self, lines: &[String], (x, top): (f64, f64), style: &str) {
        for (k, line) in lines.iter().enumerate() {
            self.words(line, (x, top + LINE * (k as f64 + 0.5)), style);
        }
    }

    /// Puts what was drawn since then into one group with a key.
    pub(super) fn group(&mut self, since: usize, key: String) {
        let all = self.drawn.split_off(since);
        self.drawn.push(element("g").with("data-part", key).all(all));
    }

    /// A part with its rods.
    pub(super) fn part(&mut self, kind: Kind, known: Known, along: Along) {
        let place = |(a, b): (f64, f64)| match along {
            Along::Right(x, y, _) => (x + a, y + b),
            Along::Down(x, y, _) => (x - b, y + a),
        };
        let (Along::Right(.., long) | Along::Down(.., long)) = along;
        let path = |points: &[(f64, f64)]| {
            let one = |(k, p): (usize, &(f64, f64))| {
                let (x, y) = place(*p);
                format!("{}{} {}", if k == 0 { "M" } else { "L" }, at(x), at(y))
            };
            points.iter().enumerate().map(one).collect::<String>()
        };
        let draw = |stroke: Stroke| match stroke {
            Stroke::Line(points) => element("path").class("piece").with("d", path(&points)),
            Stroke::Hatch(points) => element("path").class("piece thin").with("d", path(&points)),
            Stroke::Area(points) => element("path").class("piece solid").with("d", path(&points) + "Z"),
            Stroke::Circle(middle, radius) => {
                let (x, y) = place(middle);
                element("circle").class("piece solid").with("cx", at(x)).with("cy", at(y)).with("r", radius)
            }
        };
        let all: Vec<Element> = symbol(kind, long).into_iter().map(draw).collect();
        self.drawn.push(element("g").class(format!("{} {}", class(known), name(kind))).all(all));
        // The rods on both sides are lines.
        let core = 0.5 * long.min(CORE);
        let room = match along {
            Along::Right(x, y, long) => (x + 0.5 * long - core, y - HALF, x + 0.5 * long + core, y + HALF),
            Along::Down(x, y, long) => (x - HALF, y, x + HALF, y + long),
        };
        self.took(kind.word(), room);
    }

    /// A body: a block, or a disc of this height.
    pub(super) fn body(&mut self, name: &str, turns: bool, (left, top, wide, high): (f64, f64, f64, f64)) {
        let shape = match turns {
            false => element("rect")
                .with("x", at(left))
                .with("y", at(top))
                .with("width", at(wide))
                .with("height", at(high))
                .with("rx", 4),
            true => element("circle")
                .with("cx", at(left + 0.5 * wide))
                .with("cy", at(top + 0.5 * high))
                .with("r", at(0.5 * high)),
        };
        let mut all = vec![shape.class("piece body")];
        if turns {
            // A mark on the rim shows that it turns.
            let (x, y, r) = (left + 0.5 * wide, top + 0.5 * high, 0.5 * high - 6.0);
            let [(a, b), (c, d)] = [0.66, 0.84].map(|turn: f64| {
                let angle = std::f64::consts::TAU * turn;
                (x + r * angle.cos(), y + r * angle.sin())
            });
            let arc = format!("M{} {}A{r} {r} 0 0 1 {} {}", at(a), at(b), at(c), at(d), r = at(r));
            let head = format!("M{} {}l-9.5 -1.5l5.5 -7z", at(c + 3.0), at(d + 3.5));
            all.push(element("path").class("piece thin").with("d", arc));
            all.push(element("path").class("tip").with("d", head));
        }
        self.drawn.push(element("g").class("stated moving").all(all));
        self.took(format!("body {name}"), (left, top, left + wide, top + high));
    }

    /// Ground with its hatching: a wall at the left (`-1`) or right (`1`) of a line, or a floor below it (`0`).
    pub(super) fn ground(&mut self, side: i32, (x, y, long): (f64, f64, f64), known: Known) {
        let edge = match side {
            0 => format!("M{} {}h{}", at(x), at(y), at(long)),
            _ => format!("M{} {}v{}", at(x), at(y), at(long)),
        };
        let mut hatching = String::new();
        let mut along = 0.0;
        while along < long - 2.0 {
            hatching += &match side {
                0 => format!("M{} {}l-7 8", at(x + along + 6.0), at(y)),
                side => format!("M{} {}l{} 7", at(x), at(y + along), 8 * side),
            };
            along += 8.0;
        }
        let edge = element("path").class("piece").with("d", edge);
        let hatching = element("path").class("piece thin").with("d", hatching);
        self.drawn.push(element("g").class(format!("{} ground", class(known))).add(edge).add(hatching));
        let room = match side {
            0 => (x, y, x + long, y + 9.0),
            1 => (x, y, x + 9.0, y + long),
            _ => (x - 9.0, y, x, y + long),
        };
        self.took("ground", room);
    }

    /// A support that moves: a plate on a line, upright or not.
    pub(super) fn plate(&mut self, upright: bool, (x, y, long): (f64, f64, f64)) {
        let (wide, high) = if upright { (8.0, long) } else { (long, 8.0) };
        let left = if upright { x - 8.0 } else { x };
        let plate = element("rect")
            .class("piece body")
            .with("x", at(left))
            .with("y", at(y))
            .with("width", at(wide))
            .with("height", at(high))
            .with("rx", 2);
        self.drawn.push(element("g").class("stated base").add(plate));
        self.took("base", (left, y, left + wide, y + high));
    }

    /// An arrow of a force, from left to right.
    pub(super) fn arrow(&mut self, (x, y): (f64, f64), long: f64, known: Known) {
        let line =
            element("path").class("piece bold").with("d", format!("M{} {}h{}", at(x), at(y), at(long - 8.0)));
        let head =
            element("path").class("tip").with("d", format!("M{} {}l-12 -5.5v11z", at(x + long), at(y)));
        self.drawn.push(element("g").class(format!("{} push", class(known))).add(line).add(head));
        self.took("arrow", (x, y - 6.0, x + long, y + 6.0));
    }

    /// An arrow with two heads: what moves both ways.
    pub(super) fn both_ways(&mut self, (x, y): (f64, f64), long: f64) {
        let line = format!("M{} {}h{}", at(x + 5.0), at(y), at(long - 10.0));
        let heads = format!("M{} {}l8 -4v8zM{} {}l-8 -4v8z", at(x), at(y), at(x + long), at(y));
        let line = element("path").class("piece").with("d", line);
        let heads = element("path").class("tip").with("d", heads);
        self.drawn.push(element("g").class("stated").add(line).add(heads));
        self.took("both ways", (x, y - 5.0, x + long, y + 5.0));
    }

    /// A sensor on a stem that stands at a point.
    pub(super) fn sensor(&mut self, (x, y): (f64, f64), known: Known) {
        let stem = element("path").class("piece thin").with("d", format!("M{} {}v-6", at(x), at(y)));
        let dial =
            element("circle").class("piece dial").with("cx", at(x)).with("cy", at(y - 12.0)).with("r", 6);
        let needle =
            element("path").class("piece thin").with("d", format!("M{} {}l3 -4", at(x), at(y - 11.0)));
        self.drawn
            .push(element("g").class(format!("{} sensor", class(known))).add(stem).add(dial).add(needle));
        self.took("sensor", (x - 6.0, y - 18.0, x + 6.0, y));
    }

    /// A rod from one point to another.
    pub(super) fn rod(&mut self, (x, y): (f64, f64), (to, down): (f64, f64), known: Known) {
        let line = format!("M{} {}L{} {}", at(x), at(y), at(to), at(down));
        let rod = element("path").class("piece").with("d", line);
        self.drawn.push(element("g").class(class(known)).add(rod));
    }

    /// A line from a body to what stands above it.
    pub(super) fn stem(&mut self, (x, from): (f64, f64), to: f64, known: Known) {
        let stem = element("path").class("piece").with("d", format!("M{} {}V{}", at(x), at(from), at(to)));
        self.drawn.push(element("g").class(class(known)).add(stem));
        self.took("stem", (x - 1.0, to.min(from), x + 1.0, to.max(from)));
    }
}

fn name(kind: Kind) -> String {
    kind.word().replace(' ', "-")
}
