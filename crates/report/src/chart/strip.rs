//! A narrow band below a panel with the same x axis; it shows when a condition holds.

use super::axis::Axis;
use super::coordinates::{Coordinates, Place};
use super::label::{at, shortened, word};
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
    /// The strip as a group that tells the script of the page its axes and where they lie.
    pub(crate) fn live(&self, place: Place) -> Element {
        let Place { x, y, width, height } = place;
        let place_words = [x, y, width, height].map(at).join(" ");
        let group = element("g").class("panel").with("data-place", place_words);
        group.with("data-x", self.x.told()).with("data-y", Axis::bare().told()).all(self.drawn(place))
    }

    /// The strip as elements.
    fn drawn(&self, place: Place) -> Vec<Element> {
        let y = Axis::bare();
        let coordinates = Coordinates { x: self.x, y: &y, place };
        let frame = element("rect").class("grid").with("x", at(place.x)).with("y", at(place.y));
        let mut out = vec![frame.with("width", at(place.width)).with("height", at(place.height))];
        let marks = self.marks.iter().flat_map(|m| m.drawn(&coordinates)).collect();
        out.push(coordinates.clipped(marks));
        let name = shortened(self.name, place.x - 10.0);
        out.push(word("label end", place.x - 8.0, place.y + 0.5 * place.height + 4.5, &name));
        out
    }
}
