//! A narrow band below a panel with the same x axis; it shows when a condition holds.

use super::axis::Axis;
use super::coordinates::{Coordinates, Place};
use super::label::{at, word};
use super::mark::Mark;
use crate::markup::{Element, element};

/// A band of height 0 to 1 with a name.
pub(crate) struct Strip<'a> {
    /// Label at the left.
    pub(crate) name: &'a str,
    /// The x axis of the panel above.
    pub(crate) x: &'a Axis,
    /// Intervals in which the condition holds.
    pub(crate) marks: Vec<Mark>,
}

impl Strip<'_> {
    /// The strip as elements.
    pub(crate) fn drawn(&self, place: Place) -> Vec<Element> {
        let y = Axis::bare();
        let coordinates = Coordinates { x: self.x, y: &y, place };
        let frame = element("rect").class("grid").with("x", at(place.x)).with("y", at(place.y));
        let mut out = vec![frame.with("width", at(place.width)).with("height", at(place.height))];
        out.extend(self.marks.iter().flat_map(|m| m.drawn(&coordinates)));
        out.push(word("label end", place.x - 8.0, place.y + 0.5 * place.height + 4.5, self.name));
        out
    }
}
