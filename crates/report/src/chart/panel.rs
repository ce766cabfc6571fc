//! A panel: one pair of axes with marks.

use super::axis::Axis;
use super::coordinates::{Coordinates, Place};
use super::label::{at, width_of, word};
use super::mark::Mark;
use crate::markup::{Element, element};

/// Axes and marks.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    /// Text above the panel; empty for none.
    pub(crate) heading: String,
    /// The horizontal axis.
    pub(crate) x: Axis,
    /// The vertical axis.
    pub(crate) y: Axis,
    /// Drawn in this order.
    pub(crate) marks: Vec<Mark>,
    /// Whether the x axis has labels; of stacked panels only the last one has.
    pub(crate) labelled: bool,
}

impl Panel {
    /// The panel as a group that tells the script of the page its axes and where they lie.
    pub(crate) fn live(&self, place: Place) -> Element {
        let Place { x, y, width, height } = place;
        let place_words = [x, y, width, height].map(at).join(" ");
        let group = element("g").class("panel").with("data-place", place_words);
        let group = group.with("data-x", self.x.told()).with("data-y", self.y.told());
        group.all(self.drawn(place))
    }

    /// The panel as elements.
    pub(crate) fn drawn(&self, place: Place) -> Vec<Element> {
        let coordinates = Coordinates { x: &self.x, y: &self.y, place };
        let Place { x: left, y: top, width, height } = place;
        let (right, bottom) = (left + width, top + height);
        let (mut grid, mut ticks, mut words) = (String::new(), String::new(), Vec::new());
        for (value, label) in self.y.ticks((height / 36.0) as usize) {
            let y = coordinates.y(value);
            grid += &format!("M{} {}H{}", at(left), at(y), at(right));
            words.push(word("end", left - 8.0, y + 4.5, &label));
        }
        let across = self.x.ticks((width / 84.0) as usize);
        for (value, label) in &across {
            let x = coordinates.x(*value);
            ticks += &format!("M{} {}v5", at(x), at(bottom));
            if self.labelled {
                words.push(word("middle", x, bottom + 20.0, label));
            }
        }
        if self.labelled {
            words.push(word("label middle", left + 0.5 * width, bottom + 39.0, &self.x.label()));
        }
        if !self.heading.is_empty() {
            words.push(word("heading", left, top - 10.0, &self.heading));
        }
        let label = self.y.label();
        // A label longer than the axis would overlap the next panel, so it stands above the panel; so it does
        // where there is no room beside it.
        if width_of(&label) <= height + 24.0 && left >= 60.0 {
            let (x, y) = (at(left - 56.0), at(top + 0.5 * height));
            let turned = word("label middle", 0.0, 0.0, &label);
            words.push(turned.with("transform", format!("translate({x} {y}) rotate(-90)")));
        } else {
            words.push(word("label", (left - 56.0).max(4.0), top - 10.0, &label));
        }
        let path = |class: &str, d: String| element("path").class(class).with("d", d);
        let frame = format!("M{} {}V{}H{}", at(left), at(top), at(bottom), at(right));
        let mut out = vec![path("grid", grid)];
        out.extend(self.marks.iter().flat_map(|m| m.drawn(&coordinates)));
        out.extend([path("frame", frame), path("ticks", ticks)]);
        out.extend(words);
        out
    }
}
