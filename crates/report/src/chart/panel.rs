//! A panel: one pair of axes with marks.

use super::axis::Axis;
use super::coordinates::{Coordinates, Place};
use super::label::{at, shortened, width_of, word};
use super::mark::Mark;
use super::sheet::{RIGHT, TURNED};
use crate::markup::{Element, element};

/// Height of the plotting area for each label of a tick.
const ROW: f64 = 36.0;

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

    /// Width of the labels at its left, with this height of the plotting area.
    pub(crate) fn labels(&self, height: f64) -> f64 {
        let ticks = self.y.ticks((height / ROW) as usize);
        ticks.iter().map(|(_, label)| width_of(label)).fold(0.0, f64::max)
    }

    /// The panel as elements.
    pub(crate) fn drawn(&self, place: Place) -> Vec<Element> {
        let coordinates = Coordinates { x: &self.x, y: &self.y, place };
        let Place { x: left, y: top, width, height } = place;
        let (right, bottom) = (left + width, top + height);
        let (mut grid, mut ticks, mut words) = (String::new(), String::new(), Vec::new());
        for (value, label) in self.y.ticks((height / ROW) as usize) {
            let y = coordinates.y(value);
            grid += &format!("M{} {}H{}", at(left), at(y), at(right));
            words.push(word("end", left - 8.0, y + 4.5, &label));
        }
        let across = self.x.ticks((width / 84.0) as usize);
        for (value, label) in &across {
            let x = coordinates.x(*value);
            ticks += &format!("M{} {}v5", at(x), at(bottom));
            if self.labelled {
                // The label of a tick at the end of the axis stays in the picture.
                let beyond = x + 0.5 * width_of(label) > right + RIGHT;
                let (class, x) = if beyond { ("end", right + RIGHT) } else { ("middle", x) };
                words.push(word(class, x, bottom + 20.0, label));
            }
        }
        if self.labelled {
            let name = shortened(&self.x.label(), width + 2.0 * RIGHT);
            words.push(word("label middle", left + 0.5 * width, bottom + 39.0, &name));
        }
        if !self.heading.is_empty() {
            words.push(word("heading", left, top - 10.0, &self.heading));
        }
        let label = self.y.label();
        // A label longer than the axis would overlap the next panel, so it stands above the panel; so it does
        // where there is no room beside it.
        let out = (self.labels(height) + TURNED - 14.0).max(56.0);
        if width_of(&label) <= height + 24.0 && left >= out + 4.0 {
            let (x, y) = (at(left - out), at(top + 0.5 * height));
            let turned = word("label middle", 0.0, 0.0, &label);
            words.push(turned.with("transform", format!("translate({x} {y}) rotate(-90)")));
        } else {
            let x = (left - 56.0).max(4.0);
            words.push(word("label", x, top - 10.0, &shortened(&label, right + RIGHT - x)));
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

#[cfg(test)]
mod tests {
    use super::super::sheet::Sheet;
    use super::*;

    /// The texts of elements that are not turned: left and right end.
    fn ends(drawn: &[Element]) -> Vec<(f64, f64, String)> {
        let all: String = drawn.iter().map(ToString::to_string).collect();
        let one = |text: &str| {
            let (head, rest) = text.split_once('>')?;
            let x: f64 = head.split(" x=\"").nth(1)?.split('"').next()?.parse().ok()?;
            let words = rest.split('<').next()?.to_owned();
            let wide = width_of(&words);
            let class = head.split('"').nth(1)?;
            let from = match class {
                c if c.contains("middle") => x - 0.5 * wide,
                c if c.contains("end") => x - wide,
                _ => x,
            };
            (!head.contains("rotate")).then_some((from, from + wide, words))
        };
        all.split("<text ").skip(1).filter_map(one).collect()
    }

    #[test]
    fn no_label_leaves_the_picture_or_meets_the_name_of_its_axis() {
        for sheet in [Sheet::Page, Sheet::Full, Sheet::Half, Sheet::Phone] {
            for (low, high) in [(-0.0125, 0.0125), (0.0, 1.0), (-12_345.0, 60_000.0), (-2e-7, 1e-7)] {
                let x = Axis::between("time", "s", 0.0, 100.0);
                let y = Axis::between("a_column_with_quite_a_long_name_as_loggers_write", "m/s²", low, high);
                let panel = Panel { heading: String::new(), x, y, marks: vec![], labelled: true };
                let (left, width) = sheet.beside(panel.labels(200.0));
                let drawn = panel.drawn(Place { x: left, y: 40.0, width, height: 200.0 });
                for (from, to, words) in ends(&drawn) {
                    assert!(from >= 0.0 && to <= sheet.width(), "{sheet:?}: {words} from {from} to {to}");
                }
                let turned = Panel { y: Axis::between("x", "m", low, high), ..panel };
                let drawn = turned.drawn(Place { x: left, y: 40.0, width, height: 200.0 });
                let text: String = drawn.iter().map(ToString::to_string).collect();
                let Some(base) = text.split("translate(").nth(1).and_then(|t| t.split(' ').next()) else {
                    assert!(sheet.is_phone(), "{sheet:?}: there is room for a turned name");
                    continue;
                };
                // Below the base line of the name are its descenders.
                let base = base.parse::<f64>().expect("a number") + 3.0;
                let ticks = ends(&drawn).into_iter().filter(|(_, to, _)| *to < left);
                let first = ticks.map(|(from, ..)| from).fold(f64::INFINITY, f64::min);
                assert!(base <= first, "{sheet:?}: the name ends at {base}, a tick begins at {first}");
            }
        }
    }
}
