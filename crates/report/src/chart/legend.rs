//! What the lines of a picture mean, in one row above it.

use super::label::{at, width_of, word};
use crate::markup::{Element, element};

/// How an entry is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Swatch {
    /// A piece of a line.
    Line,
    /// A filled box.
    Box,
    /// A dot.
    Dot,
}

/// A class of marks, how it looks, and what it means.
pub(crate) type Entry = (&'static str, Swatch, String);

/// Draws the row with its left end at `x`, its base line at `y`, entries after one another.
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
