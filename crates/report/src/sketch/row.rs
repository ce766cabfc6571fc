//! Parts beside each other between the same two sides: one above the other, each below its words.

use super::canvas::{Along, Canvas, LINE, class};
use super::scheme::{End, Known, Part};
use super::symbol::{HALF, LEAST};
use crate::chart::width_of;

/// Between two rows.
const APART: f64 = 8.0;
/// Height of the arrow above a support that moves.
const HEAD: f64 = 24.0;

/// Room for the words and symbols of some parts: the least width, and the height.
pub(super) fn size(parts: &[&Part]) -> (f64, f64) {
    let wide = parts.iter().map(|p| words_wide(p) + 16.0).fold(LEAST, f64::max);
    (
        wide,
        groups(parts).iter().map(|g| group_high(g)).sum::<f64>() - if parts.is_empty() { 0.0 } else { APART },
    )
}

/// Width of the words of a part.
pub(super) fn words_wide(part: &Part) -> f64 {
    let factor = if class(part.known) == "found" { 1.08 } else { 1.0 };
    part.words.iter().map(|w| factor * width_of(w)).fold(0.0, f64::max)
}

fn high(part: &Part) -> f64 {
    LINE * part.words.len() as f64 + 2.0 * HALF + APART
}

/// The parts by their support.
fn groups<'p>(parts: &[&'p Part]) -> Vec<Vec<&'p Part>> {
    let mut sorted = parts.to_vec();
    sorted.sort_by_key(|p| (support(p), p.kind));
    let mut all: Vec<Vec<&Part>> = vec![];
    for part in sorted {
        match all.last_mut().filter(|g| support(g[0]) == support(part)) {
            Some(group) => group.push(part),
            None => all.push(vec![part]),
        }
    }
    all
}

fn support(part: &Part) -> Option<End> {
    (!matches!(part.ends.0, End::Body(_))).then_some(part.ends.0)
}

fn group_high(group: &[&Part]) -> f64 {
    let moves = matches!(group[0].ends.0, End::Base(_));
    group.iter().map(|p| high(p)).sum::<f64>() + if moves { HEAD } else { 0.0 }
}

/// Draws parts from `left` to what `right` says of a height; `wall` is the side of the support, 0 for none.
pub(super) fn draw(
    canvas: &mut Canvas,
    parts: &[&Part],
    bases: &[String],
    (top, wall): (f64, i32),
    (left, right): (&dyn Fn(f64) -> f64, &dyn Fn(f64) -> f64),
) {
    let mut y = top;
    // Between the sides where they are nearest: that of a disc at the height of its middle.
    let level = top + 0.5 * size(parts).1;
    let middle = 0.5 * (left(level) + right(level));
    for group in groups(parts) {
        if let (End::Base(k), true) = (group[0].ends.0, wall != 0) {
            let edge = if wall < 0 { left(y) - 4.0 } else { right(y) + 4.0 };
            canvas.both_ways((edge - 14.0, y + 0.5 * HEAD - 3.0), 28.0);
            let name = &bases[k];
            let x = if wall < 0 { edge + 20.0 } else { edge - 20.0 - width_of(name) };
            canvas.words(name, (x, y + 0.5 * HEAD - 3.0), "label");
            y += HEAD;
        }
        let first = y;
        for part in &group {
            let since = canvas.drawn.len();
            let line = y + LINE * part.words.len() as f64 + HALF;
            let (from, to) = (left(line), right(line));
            let style = format!("label middle {}", class(part.known));
            canvas.lines(&part.words, (middle, y), &style);
            canvas.part(part.kind, part.known, Along::Right(from, line, to - from));
            canvas.group(since, part.key());
            y += high(part);
        }
        let (edge, long) = (if wall < 0 { left(first) } else { right(first) }, y - APART - first);
        match group[0].ends.0 {
            End::Ground if wall != 0 => canvas.ground(wall, (edge, first, long), Known::Stated),
            End::Base(_) if wall != 0 => {
                canvas.plate(true, (if wall < 0 { edge } else { edge + 8.0 }, first, long));
            }
            _ => {}
        }
    }
}
