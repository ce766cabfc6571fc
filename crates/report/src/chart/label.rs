//! Labels and coordinates as text.

use crate::markup::{Element, element};

/// A coordinate, rounded to a tenth of a pixel.
pub(crate) fn at(x: f64) -> String {
    let text = format!("{x:.1}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}

/// A label at a position.
pub(crate) fn word(class: &str, x: f64, y: f64, text: &str) -> Element {
    element("text").class(class).with("x", at(x)).with("y", at(y)).text(text)
}

/// Approximate width of a text in the size of labels.
pub(crate) fn width_of(text: &str) -> f64 {
    7.0 * text.chars().count() as f64
}
