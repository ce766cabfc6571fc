//! Sketches of all specs: what is in them, and where.

use super::canvas::{Canvas, Room};
use super::mechanisms::{MECHANISMS, SPECS};
use super::scheme::Scheme;
use super::*;
use phisindy_phys::{SourceId, check, spec};

fn read(text: &str) -> Scheme {
    let (spec, _) = spec::read_without_data(text, SourceId(0)).expect("well formed");
    let (case, _) = check(&spec, SourceId(0)).expect("a good case");
    of_case(&spec, &case)
}

/// The specs of the repository by their names.
fn specs() -> Vec<(String, Scheme)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../specs");
    let mut all = vec![];
    for entry in std::fs::read_dir(folder).expect("the specs") {
        let path = entry.expect("a file").path();
        if path.extension().is_some_and(|e| e == "ron") {
            let text = std::fs::read_to_string(&path).expect("a text");
            let name = path.file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
            all.push((name, read(&text)));
        }
    }
    all.sort_by(|a, b| a.0.cmp(&b.0));
    assert!(all.len() > 30, "{}", all.len());
    all
}

/// What must stand apart: words from all, bodies and symbols from each other. A body holds its own words whole.
fn overlaps(canvas: &Canvas, words: &dyn Fn(&str) -> bool) -> Vec<String> {
    let meets = |a: &Room, b: &Room| {
        a.left < b.right - 0.5 && b.left < a.right - 0.5 && a.top < b.bottom - 0.5 && b.top < a.bottom - 0.5
    };
    let holds =
        |a: &Room, b: &Room| a.left <= b.left && a.right >= b.right && a.top <= b.top && a.bottom >= b.bottom;
    let mut out = vec![];
    for (k, (a, room)) in canvas.rooms.iter().enumerate() {
        for (b, other) in &canvas.rooms[k + 1..] {
            let body = a.starts_with("body ") && words(b) && holds(room, other);
            // A stem is a line: it may cross the rod of a part, never words.
            let lines = (a == "stem" || b == "stem") && !words(a) && !words(b);
            if meets(room, other) && !body && !lines {
                out.push(format!("{a} {room:?} meets {b} {other:?}"));
            }
        }
    }
    out
}

const PIECES: [&str; 8] = ["ground", "base", "arrow", "both ways", "sensor", "stem", "body ", "joint"];

fn is_words(name: &str) -> bool {
    let kinds = ["spring", "nonlinear spring", "damper", "nonlinear damper", "weight on an arm"];
    // A contact without words is called friction, and so is its symbol between two bodies: both stand apart.
    !PIECES.iter().any(|p| name.starts_with(p)) && !kinds.contains(&name) && name != "force"
}

fn judge(name: &str, scheme: &Scheme) {
    let canvas = layout::drawn(scheme);
    let (wide, high) = layout::size(&canvas);
    let all = overlaps(&canvas, &is_words);
    assert!(all.is_empty(), "{name}: {all:#?}");
    for (what, room) in &canvas.rooms {
        let inside = room.left >= 0.0 && room.top >= 0.0 && room.right <= wide && room.bottom <= high;
        assert!(inside, "{name}: {what} {room:?} is outside of {wide} by {high}");
    }
    if let Some((chart, _)) = chart(scheme) {
        let text = chart.file();
        assert!(!text.contains("NaN") && !text.contains("inf"), "{name}");
        if let Ok(folder) = std::env::var("SKETCHES") {
            std::fs::write(format!("{folder}/{name}.svg"), text).expect("a picture");
        }
    }
}

#[test]
fn nothing_overlaps_in_the_sketch_of_any_spec() {
    for (name, scheme) in specs() {
        judge(&name, &scheme);
    }
}

#[test]
fn nothing_overlaps_in_the_sketch_of_a_mechanism() {
    for (name, text, _) in MECHANISMS {
        judge(name, &read(&format!("({text}, data: [])")));
    }
}

#[test]
fn the_longest_names_of_laws_find_room_wherever_they_act() {
    let mechanisms = MECHANISMS.iter().map(|(name, text, _)| (*name, read(&format!("({text}, data: [])"))));
    let all: Vec<(String, Scheme)> = mechanisms.map(|(name, scheme)| (name.to_owned(), scheme)).collect();
    for (name, mut scheme) in all.into_iter().chain(specs()) {
        let words =
            || ["Dieterich-Ruina friction (steady state)", "A = 0.298 ± 0.008 N"].map(str::to_owned).to_vec();
        for part in &mut scheme.elements {
            (part.known, part.words) = (Known::Found, words());
        }
        for push in &mut scheme.pushes {
            (push.known, push.words) = (Known::Found, words().join(", "));
        }
        for body in scheme.bodies.iter_mut().filter(|b| !b.sensors.is_empty()) {
            body.lit = ["Sensor offset", "offset = 1.23 ± 0.04 mm"].map(str::to_owned).to_vec();
        }
        for block in &mut scheme.blocks {
            (block.known, block.words) = (Known::Found, words().join(", "));
        }
        judge(&format!("{name}, lit"), &scheme);
    }
}

#[test]
fn a_sketch_has_the_parts_of_its_mechanism() {
    let mut wrong = vec![];
    for (name, text, expected) in MECHANISMS {
        let said = text::sentences(&read(&format!("({text}, data: [])")));
        if said != expected {
            wrong.push(format!("{name}: {said}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_sketch_has_the_parts_of_its_spec() {
    let mut wrong = vec![];
    for (name, scheme) in specs() {
        let said = text::sentences(&scheme);
        let expected = SPECS.iter().find(|(n, _)| *n == name).map_or("", |(_, said)| said);
        if said != expected {
            wrong.push(format!("{name}: {said}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
