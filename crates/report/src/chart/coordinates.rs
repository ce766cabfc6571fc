//! From values on axes to coordinates in a picture.

use super::axis::Axis;
use super::decimate::decimated;
use super::label::at;
use crate::markup::{Element, element};

/// The plotting area of a panel; labels stand outside of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// Left edge.
    pub(crate) x: f64,
    /// Upper edge.
    pub(crate) y: f64,
    /// Width.
    pub(crate) width: f64,
    /// Height.
    pub(crate) height: f64,
}

/// Maps values on two axes to coordinates.
pub(crate) struct Coordinates<'a> {
    /// The horizontal axis.
    pub(crate) x: &'a Axis,
    /// The vertical axis.
    pub(crate) y: &'a Axis,
    /// The plotting area.
    pub(crate) place: Place,
}

impl Coordinates<'_> {
    pub(crate) fn x(&self, x: f64) -> f64 {
        self.place.x + self.place.width * self.x.place(x)
    }

    pub(crate) fn y(&self, y: f64) -> f64 {
        self.place.y + self.place.height * (1.0 - self.y.place(y))
    }

    /// Clips elements at the edges: a nested `svg` hides what lies outside of it.
    pub(super) fn clipped(&self, content: Vec<Element>) -> Element {
        let Place { x, y, width, height } = self.place;
        let inner = element("svg")
            .with("x", at(x))
            .with("y", at(y))
            .with("width", at(width))
            .with("height", at(height));
        let view = format!("{} {} {} {}", at(x), at(y), at(width), at(height));
        inner.with("viewBox", view).all(content)
    }

    /// A line through points as path data; points that are not finite interrupt it.
    pub(super) fn path(&self, points: &[(f64, f64)]) -> String {
        let columns = self.place.width as usize;
        let mut out = String::new();
        for piece in points.split(|p| !(p.0.is_finite() && p.1.is_finite())) {
            for (k, (x, y)) in decimated(piece, self.x.ends(), columns).into_iter().enumerate() {
                out += &format!("{}{} {}", if k == 0 { "M" } else { "L" }, at(self.x(x)), at(self.y(y)));
            }
        }
        out
    }
}
