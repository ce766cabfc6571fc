//! Marks: the content of a panel.

use super::coordinates::{Coordinates, Place};
use super::label::{at, width_of, word};
use crate::markup::{Element, element};

/// Points; those that are not finite interrupt a line.
pub(crate) type Points = Vec<(f64, f64)>;

/// Dots of a smaller radius are strokes.
const SPECK: f64 = 3.0;

/// A mark; the style sheet defines colour and stroke by `class`.
#[derive(Clone, Debug)]
pub(crate) enum Mark {
    /// A line through points in their order.
    Line { class: &'static str, points: Points },
    /// Dots of a radius.
    Dots { class: &'static str, points: Points, radius: f64 },
    /// The area between two curves: x, lower, upper.
    Band { class: &'static str, points: Vec<(f64, f64, f64)> },
    /// An interval of the x axis over the whole height, with words above it.
    Span { from: f64, to: f64, words: &'static str },
    /// A horizontal line.
    Level { class: &'static str, y: f64 },
    /// A vertical line from zero to each point.
    Stems { class: &'static str, points: Points },
    /// A name that ends at a point, above it.
    Name { x: f64, y: f64, words: String },
    /// Rectangles: left, right, lower, upper.
    Boxes { class: &'static str, boxes: Vec<(f64, f64, f64, f64)> },
}

impl Mark {
    /// The mark as elements.
    pub(crate) fn drawn(&self, coordinates: &Coordinates<'_>) -> Vec<Element> {
        let Place { x: left, y: top, width, height } = coordinates.place;
        let path = |class: &str, d: String| vec![element("path").class(class).with("d", d)];
        match self {
            Mark::Line { class, points } => vec![coordinates.clipped(path(class, coordinates.path(points)))],
            Mark::Dots { class, points, radius } => {
                let finite = points.iter().filter(|p| p.0.is_finite() && p.1.is_finite());
                // A stroke of no length with round ends is a dot that stays round when its panel is zoomed.
                if *radius < SPECK {
                    let dot = |&(x, y): &(f64, f64)| {
                        format!("M{} {}h0", at(coordinates.x(x)), at(coordinates.y(y)))
                    };
                    let speck = element("path")
                        .class(format!("speck {class}"))
                        .with("d", finite.map(dot).collect::<String>());
                    return vec![
                        coordinates
                            .clipped(vec![speck.with("style", format!("stroke-width:{}", at(2.0 * radius)))]),
                    ];
                }
                // One path of small circles takes a tenth of the text that single elements take.
                let r = at(*radius);
                let circle = |&(x, y): &(f64, f64)| {
                    let (x, y) = (at(coordinates.x(x) - radius), at(coordinates.y(y)));
                    format!("M{x} {y}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0z", d = at(2.0 * radius))
                };
                path(&format!("dot {class}"), finite.map(circle).collect())
            }
            Mark::Band { class, points } => {
                let side = |f: fn(&(f64, f64, f64)) -> (f64, f64)| points.iter().map(f).collect::<Points>();
                let (mut low, high) = (side(|p| (p.0, p.1)), side(|p| (p.0, p.2)));
                low.reverse();
                let d = coordinates.path(&high) + &coordinates.path(&low).replacen('M', "L", 1) + "Z";
                vec![coordinates.clipped(path(class, if points.is_empty() { String::new() } else { d }))]
            }
            Mark::Span { from, to, words } => {
                let (a, b) = (coordinates.x(*from).max(left), coordinates.x(*to).min(left + width));
                let area = element("rect").class("unfitted").with("x", at(a)).with("y", at(top));
                let area = area.with("width", at((b - a).max(0.0))).with("height", at(height));
                let edge = element("line").class("edge").with("x1", at(a)).with("x2", at(a));
                let edge = edge.with("y1", at(top)).with("y2", at(top + height));
                // The words stand above the end of the area: the name of the axis may stand at the left.
                let fits = b - width_of(words) >= left;
                let (class, x) = if fits { ("small span end", b - 1.0) } else { ("small span", a + 1.0) };
                vec![coordinates.clipped(vec![area, edge]), word(class, x, top - 6.0, words)]
            }
            Mark::Level { class, y } => {
                let y = at(coordinates.y(*y));
                let line = element("line").class(class).with("x1", at(left)).with("x2", at(left + width));
                vec![line.with("y1", &y).with("y2", &y)]
            }
            Mark::Name { x, y, words } => {
                // A point at the left has its name at its right.
                let end = coordinates.x(*x).max(left + width_of(words));
                vec![word("small end halo", end, coordinates.y(*y) - 5.0, words)]
            }
            Mark::Stems { class, points } => {
                let zero = at(coordinates.y(0.0));
                let stem = |&(x, y): &(f64, f64)| {
                    format!("M{} {zero}V{}", at(coordinates.x(x)), at(coordinates.y(y)))
                };
                path(class, points.iter().map(stem).collect())
            }
            Mark::Boxes { class, boxes } => {
                let one = |&(a, b, low, high): &(f64, f64, f64, f64)| {
                    let (a, b) = (coordinates.x(a), coordinates.x(b));
                    // The shortest rectangle stays visible.
                    let (y, wide) = (coordinates.y(high), (b - a).max(0.7));
                    format!("M{} {}h{}v{}h-{}z", at(a), at(y), at(wide), at(coordinates.y(low) - y), at(wide))
                };
                path(class, boxes.iter().map(one).collect())
            }
        }
    }
}
