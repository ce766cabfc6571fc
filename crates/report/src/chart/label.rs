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

/// Width of a text in the size of labels, in the widest of the fonts that the style sheet names (DejaVu
/// Sans). In another font there is room to spare.
pub(crate) fn width_of(text: &str) -> f64 {
    SIZE * text.chars().map(advance).sum::<f64>()
}

/// Size of labels in the style sheet.
const SIZE: f64 = 13.0;

/// Advance of a character, in sizes.
fn advance(c: char) -> f64 {
    match c {
        ' ' | '.' | ',' | ':' | ';' | '\'' | '|' | 'i' | 'j' | 'l' | 'I' | '·' => 0.34,
        'f' | 't' | 'r' | '(' | ')' | '[' | ']' | '/' | '-' => 0.42,
        '⁰' | '¹' | '²' | '³' | '⁴' | '⁵' | '⁶' | '⁷' | '⁸' | '⁹' | '⁻' => 0.53,
        'm' | 'M' | 'w' | 'W' | '%' | '−' | '×' | '+' | '=' | '<' | '>' | '±' | '…' => 1.0,
        'A'..='Z' | '→' => 0.84,
        _ => 0.64,
    }
}

/// The text, or what of it fits a room, and dots: the whole of it stands in the description.
pub(crate) fn shortened(text: &str, room: f64) -> String {
    if width_of(text) <= room {
        return text.to_owned();
    }
    let mut left = room - width_of("…");
    let fits = |c: &char| {
        left -= SIZE * advance(*c);
        left >= 0.0
    };
    text.chars().take_while(fits).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_without_room_ends_with_dots() {
        assert_eq!(shortened("x2, before", 100.0), "x2, before");
        let short = shortened("position_of_the_carriage, before", 100.0);
        assert!(short.ends_with('…') && width_of(&short) <= 100.0 && short.len() > 10, "{short}");
    }
}
