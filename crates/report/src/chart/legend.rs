//! The legend: one row above the panels.

use super::label::{at, width_of, word};
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

/// The row with its left end at `x` and its base line at `y`.
pub(crate) fn legend(entries: &[Entry], mut x: f64, y: f64) -> Vec<Element> {
    let mut out = Vec::new();
    for (class, swatch, text) in entries {
        out.push(match swatch {
            Swatch::Line => element("path").class(class).with("d", format!("M{} {}h26", at(x), at(y - 4.5))),
            Swatch::Box => element("rect")
                .class(class)
                .with("x", at(x + 3.0))
                .with("y", at(y - 11.0))
                .with("width", 20)
                .with("height", 13),
            Swatch::Dot => element("circle")
                .class(format!("dot {class}"))
                .with("cx", at(x + 13.0))
                .with("cy", at(y - 4.5))
                .with("r", 4),
        });
        out.push(word("legend", x + 32.0, y, text));
        x += 32.0 + width_of(text) + 26.0;
    }
    out
}
