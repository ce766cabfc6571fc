//! What stands below a body: contacts on the ground or on a plate, weights, supports of inner bodies.

use super::canvas::{Along, Canvas, LINE, class};
use super::row::words_wide;
use super::scheme::{End, Kind, Known, Part};
use super::symbol::{HALF, LEAST};

/// Least width of a contact.
const PATCH: f64 = 72.0;
/// Between two parts.
const APART: f64 = 14.0;
/// Length of an arm with its weight.
const ARM: f64 = 44.0;

/// Whether a part stands below its body wherever the body is: what rubs on a body that slides, and what hangs on an arm.
pub(super) fn is_below(part: &Part, turns: bool) -> bool {
    part.kind == Kind::Weight || part.kind == Kind::Friction && !turns
}

/// The parts below a body, from left to right.
pub(super) struct Below<'s> {
    parts: Vec<&'s Part>,
    /// Whether the body is a disc.
    turns: bool,
}

impl<'s> Below<'s> {
    pub(super) fn new(mut parts: Vec<&'s Part>, turns: bool) -> Below<'s> {
        parts.sort_by_key(|p| (p.kind != Kind::Friction, p.ends, p.kind));
        Below { parts, turns }
    }

    /// Width of a part with its words.
    fn wide(&self, part: &Part) -> f64 {
        match part.kind {
            Kind::Friction if !self.turns => {
                PATCH.max(words_wide(part)).max(if matches!(part.ends.0, End::Base(_)) { 96.0 } else { 0.0 })
            }
            _ => 2.0 * HALF + words_wide(part) + 8.0,
        }
    }

    fn total(&self) -> f64 {
        let apart = APART * self.parts.len().saturating_sub(1) as f64;
        self.parts.iter().map(|p| self.wide(p)).sum::<f64>() + apart
    }

    /// The least width of the body above: what hangs on rods must meet it; the words of the last may stand out.
    pub(super) fn least(&self) -> f64 {
        match (&self.parts[..], self.parts.last()) {
            ([_, .., _], Some(last)) if last.kind != Kind::Friction => self.total() - words_wide(last) - 8.0,
            ([_, .., _], _) => self.total(),
            _ => 0.0,
        }
    }

    /// How far it reaches to the left and to the right of the middle of a body of this width.
    pub(super) fn reach(&self, wide: f64) -> (f64, f64) {
        let total = self.total();
        let left = match self.parts[..] {
            [one] if one.kind == Kind::Friction && !self.turns => 0.5 * total,
            [_] => HALF,
            _ => 0.5 * wide,
        };
        (left, total - left)
    }

    /// Draws it below a point; returns where it ends.
    pub(super) fn draw(
        &self,
        canvas: &mut Canvas,
        bases: &[String],
        (middle, top, radius): (f64, f64, f64),
    ) -> f64 {
        let (mut left, mut bottom) = (middle - self.reach(2.0 * radius).0, top);
        // The rim of a disc.
        let rim = |x: f64| match self.turns {
            true => top - radius + (radius * radius - (x - middle).powi(2)).max(0.0).sqrt(),
            false => top,
        };
        for part in &self.parts {
            let (wide, since) = (self.wide(part), canvas.drawn.len());
            let end = match part.kind {
                Kind::Friction if !self.turns => contact(canvas, part, bases, (left + 0.5 * wide, top)),
                _ => support(canvas, part, bases, (left + HALF, rim(left + HALF), top)),
            };
            canvas.group(since, part.key());
            left += wide + APART;
            bottom = bottom.max(end);
        }
        bottom
    }
}

/// A contact right below the body.
fn contact(canvas: &mut Canvas, part: &Part, bases: &[String], (middle, top): (f64, f64)) -> f64 {
    let (x, y) = (middle - 0.5 * PATCH, top + 2.0);
    // A number alone does not say of what.
    let named = part.words.len() < 2;
    let words: Vec<String> =
        named.then(|| "friction".to_owned()).into_iter().chain(part.words.iter().cloned()).collect();
    let mut below = y + 12.0;
    match part.ends.0 {
        End::Base(k) => {
            canvas.plate(false, (x, y, PATCH));
            canvas.both_ways((middle - 26.0, y + 18.0), 28.0);
            canvas.words(&bases[k], (middle + 8.0, y + 18.0), "label");
            below += 16.0;
        }
        _ => canvas.ground(0, (x, y, PATCH), part.known),
    }
    let style = format!("label middle {}", class(part.known));
    canvas.lines(&words, (middle, below), &style);
    below + LINE * words.len() as f64
}

/// A part that hangs down, or stands on the ground.
fn support(canvas: &mut Canvas, part: &Part, bases: &[String], (x, from, top): (f64, f64, f64)) -> f64 {
    let long = if part.kind == Kind::Weight { ARM } else { LEAST };
    if from < top {
        canvas.rod((x, from), (x, top), part.known);
    }
    canvas.part(part.kind, part.known, Along::Down(x, top, long));
    let high = LINE * part.words.len() as f64;
    let beside = top + 0.5 * (long - high);
    let style = format!("label {}", class(part.known));
    canvas.lines(&part.words, (x + HALF + 4.0, beside), &style);
    let end = top + long;
    match part.ends.0 {
        _ if part.kind == Kind::Weight => end,
        End::Base(k) => {
            canvas.plate(false, (x - 13.0, end, 26.0));
            canvas.both_ways((x - 13.0, end + 18.0), 26.0);
            canvas.words(&bases[k], (x + 18.0, end + 18.0), "label");
            end + 26.0
        }
        _ => {
            canvas.ground(0, (x - 13.0, end, 26.0), Known::Stated);
            end + 10.0
        }
    }
}
