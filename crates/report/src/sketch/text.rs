//! A sketch in words: a line for each body, and one for each part on it.

use super::scheme::{End, Kind, Known, Part, Scheme};
use crate::terminal::{Ink, Look};

/// How a terminal shows each kind.
const GLYPHS: [(Kind, &str); 8] = [
    (Kind::Spring, "/\\/\\/"),
    (Kind::BentSpring, "/\\↗\\/"),
    (Kind::Damper, "──]──"),
    (Kind::BentDamper, "──]↗─"),
    (Kind::Friction, "▁▟▙▁▁"),
    (Kind::Weight, "────●"),
    (Kind::Force, "─[~]─"),
    (Kind::Link, "o═══o"),
];

/// A line of a sketch: its picture, its words, and how far it is known.
pub(super) struct Line {
    glyph: String,
    pub(super) words: String,
    known: Known,
    /// Whether it is of a body or a state, below which others stand.
    head: bool,
}

/// The sketch as lines of a terminal.
pub(super) fn lines(scheme: &Scheme, look: Look) -> Vec<String> {
    let shown = |line: Line| {
        let words = match line.known {
            Known::Sought => look.ink(Ink::Open, &line.words),
            Known::Found => look.ink(Ink::Model, &line.words),
            Known::Stated if line.head => look.ink(Ink::Strong, &line.words),
            Known::Stated => line.words.clone(),
        };
        if line.head { format!("  {}  {words}", line.glyph) } else { format!("    {}  {words}", line.glyph) }
    };
    all(scheme).into_iter().map(shown).collect()
}

/// The sketch as sentences for readers who do not see it.
pub(super) fn sentences(scheme: &Scheme) -> String {
    let all = all(scheme);
    let mut out = String::new();
    for (k, line) in all.iter().enumerate() {
        let before = match (k, line.head) {
            (0, _) => "",
            (_, true) => ". ",
            _ if all[k - 1].head => ": ",
            _ => "; ",
        };
        out += before;
        out += &line.words;
    }
    if out.is_empty() { out } else { out + "." }
}

fn all(scheme: &Scheme) -> Vec<Line> {
    let mut out = vec![];
    for (k, body) in scheme.bodies.iter().enumerate() {
        let of = if body.inertia.is_empty() { String::new() } else { format!(", {}", body.inertia) };
        let read = match body.sensors.is_empty() {
            true => String::new(),
            false => format!(", sensors of {}", body.sensors.join(", ")),
        };
        let lit = if body.lit.is_empty() { String::new() } else { format!(" ({})", body.lit.join(", ")) };
        let glyph = if body.turns { "( )" } else { "[ ]" }.to_owned();
        let words = format!("{}{of}{read}{lit}", body.name);
        out.push(Line { glyph, words, known: Known::Stated, head: true });
        // A part between two bodies is told at the first of them.
        let own = |e: &&Part| match e.ends {
            (End::Body(a), End::Body(_)) => a == k,
            (_, End::Body(b)) => b == k,
            _ => false,
        };
        out.extend(scheme.elements.iter().filter(own).map(|part| of_part(scheme, part)));
        for push in scheme.pushes.iter().filter(|p| p.body == k) {
            let words = if push.words == "force" {
                "force from outside".to_owned()
            } else {
                format!("force {}", push.words)
            };
            out.push(Line { glyph: "────▶".to_owned(), words, known: push.known, head: false });
        }
    }
    for block in &scheme.blocks {
        let from: Vec<&str> = block.of.iter().chain(&block.inputs).map(String::as_str).collect();
        let from = if from.is_empty() { String::new() } else { format!(", its rate of {}", from.join(", ")) };
        let read = if block.measured { ", measured" } else { "" };
        let found = match block.known {
            Known::Stated => String::new(),
            Known::Sought => ", asked for".to_owned(),
            Known::Found => format!(", {}", block.words),
        };
        let words = format!("{}{from}{read}{found}", block.name);
        out.push(Line { glyph: "[ ]".to_owned(), words, known: block.known, head: true });
    }
    out
}

pub(super) fn of_part(scheme: &Scheme, part: &Part) -> Line {
    let to = match part.ends {
        (End::Ground, _) if matches!(part.kind, Kind::Weight) => String::new(),
        (End::Ground, _) => " to the ground".to_owned(),
        (End::Base(k), _) => format!(" to {}, which moves", scheme.bases[k]),
        (_, End::Body(b)) => format!(" to {}", scheme.bodies[b].name),
        _ => String::new(),
    };
    let number = if part.words.is_empty() { String::new() } else { format!(" {}", part.words.join(", ")) };
    let asked = if part.known == Known::Sought { ", asked for" } else { "" };
    let glyph = GLYPHS.iter().find(|(k, _)| *k == part.kind).map_or("", |(_, glyph)| glyph).to_owned();
    Line { glyph, words: format!("{}{number}{to}{asked}", part.kind.word()), known: part.known, head: false }
}
