//! The legend: rows above the panels.

use super::label::{at, width_of, word};
use super::sheet::Sheet;
use crate::markup::{Element, element};

/// The sample in front of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Swatch {
    /// A short line.
    Line,
    /// A filled box.
    Box,
    /// A dot.
    Dot,
}

/// Class of the marks, their sample, and their meaning.
pub(crate) type Entry = (&'static str, Swatch, String);

/// Between two entries.
const APART: f64 = 16.0;
/// Height of a row.
const ROW: f64 = 20.0;

/// The legend at the top of a picture, and where the panels may begin below it. Rows are broken where they
/// would be wider than the sheet.
pub(crate) fn legend(entries: &[Entry], sheet: Sheet) -> (Vec<Element>, f64) {
    let first = if sheet.is_phone() { 6.0 } else { 20.0 };
    let (mut x, mut y) = (first, ROW);
    let mut out = Vec::new();
    for (class, swatch, text) in entries {
        // A dot takes less room than a line.
        let before = if *swatch == Swatch::Dot { 16.0 } else { 32.0 };
        let wide = before + width_of(text);
        if x > first && x + wide > sheet.width() {
            (x, y) = (first, y + ROW);
        }
        let sample = match swatch {
            Swatch::Line => element("path").class(class).with("d", format!("M{} {}h26", at(x), at(y - 4.5))),
            Swatch::Box => element("rect")
                .class(class)
                .with("x", at(x + 3.0))
                .with("y", at(y - 11.0))
                .with("width", 20)
                .with("height", 13),
            Swatch::Dot => element("circle")
                .class(format!("dot {class}"))
                .with("cx", at(x + 6.0))
                .with("cy", at(y - 4.5))
                .with("r", 4),
        };
        // The script of the page makes a switch of each entry.
        let entry = element("g").class("key").with("data-of", class);
        out.push(entry.add(sample).add(word("legend", x + before, y, text)));
        x += wide + APART;
    }
    (out, y + 28.0)
}
