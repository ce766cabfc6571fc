//! Words and coordinates in a picture.

use crate::markup::{Element, element};

/// A coordinate, to a tenth of a pixel.
pub(crate) fn at(x: f64) -> String {
    let text = format!("{x:.1}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// A word in a picture.
pub(crate) fn word(class: &str, x: f64, y: f64, text: &str) -> Element {
    element("text").class(class).with("x", at(x)).with("y", at(y)).text(text)
}

/// About how wide a word is at the size of labels.
pub(crate) fn width_of(text: &str) -> f64 {
    7.0 * text.chars().count() as f64
}
