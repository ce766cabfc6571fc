//! States that are no motion: a box for each, what its rate is made of, and arrows of its inputs.

use super::canvas::{Canvas, class};
use super::scheme::{Block, Known};
use crate::chart::width_of;

const HIGH: f64 = 62.0;
const APART: f64 = 18.0;
/// Boxes stand in rows of this width.
const WIDE: f64 = 720.0;
/// Height of a sensor above its box.
const SENSOR: f64 = 22.0;

/// Draws the boxes from a corner on.
pub(super) fn draw(canvas: &mut Canvas, blocks: &[Block], (left, top): (f64, f64)) {
    let sensing = if blocks.iter().any(|b| b.measured) { SENSOR } else { 0.0 };
    let (mut x, mut y) = (left, top + sensing);
    for block in blocks {
        let inputs = block.inputs.join(", ");
        let arrow = if inputs.is_empty() { 0.0 } else { (width_of(&inputs) + 18.0).max(46.0) };
        let of = depends(block);
        let words = [&block.name, &of, &block.words].map(|w| 1.08 * width_of(w));
        let wide = words.into_iter().fold(86.0, f64::max) + 22.0;
        if x > left && x + arrow + wide > WIDE {
            (x, y) = (left, y + HIGH + APART + sensing);
        }
        if arrow > 0.0 {
            canvas.arrow((x, y + 0.5 * HIGH), arrow - 3.0, Known::Stated);
            canvas.words(&inputs, (x + 4.0, y + 0.5 * HIGH - 16.0), "label");
            x += arrow;
        }
        canvas.body(&block.name, false, (x, y, wide, HIGH));
        let middle = x + 0.5 * wide;
        let found = format!("label middle {}", class(block.known));
        let lines = [(block.name.as_str(), "name middle"), (&of, "label middle"), (&block.words, &found)];
        let lines: Vec<_> = lines.into_iter().filter(|(text, _)| !text.is_empty()).collect();
        let first = y + 0.5 * HIGH - 8.5 * (lines.len() as f64 - 1.0);
        for (k, (text, style)) in lines.into_iter().enumerate() {
            canvas.words(text, (middle, first + 17.0 * k as f64), style);
        }
        if block.measured {
            canvas.sensor((x + 14.0, y), Known::Stated);
        }
        x += wide + APART;
    }
}

/// What the rate of a state is made of.
fn depends(block: &Block) -> String {
    match block.of[..] {
        [] => String::new(),
        _ => format!("rate of {}", block.of.join(", ")),
    }
}
